"""BVH texts for tests: a person in a T-pose, 1.7 m, facing +z, y up, with any joint names."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from lanindex.alphabet import JOINTS

TREE = (
    ("Pelvis", None, (0, 92, 0)),
    ("Chest", "Pelvis", (0, 25, 0)),
    ("Neck", "Chest", (0, 24, 0)),
    ("Head", "Neck", (0, 10, 1)),
    *(
        row
        for side, out in (("L", 1), ("R", -1))
        for row in (
            (side + "Collar", "Chest", (3 * out, 20, 0)),
            (side + "Shoulder", side + "Collar", (15 * out, 0, 0)),
            (side + "Elbow", side + "Shoulder", (28 * out, 0, 0)),
            (side + "Wrist", side + "Elbow", (25 * out, 0, 0)),
            (side + "Hand", side + "Wrist", (9 * out, 0, 0)),
            (side + "Hip", "Pelvis", (9 * out, -4, 0)),
            (side + "Knee", side + "Hip", (0, -42, 0)),
            (side + "Ankle", side + "Knee", (0, -40, 0)),
            (side + "Toe", side + "Ankle", (0, -6, 13)),
        )
    ),
)
"""Role, the role it hangs from, offset in cm."""

TIPS = {"Head": (0, 18, 0), "LHand": (8, 0, 0), "RHand": (-8, 0, 0)}
TIPS |= {"LToe": (0, 0, 6), "RToe": (0, 0, 6)}
"""End Sites, in cm; others have no length."""

SIMPLE = {role: role for role, _, _ in TREE}


def hierarchy(
    names: Mapping[str, str] = SIMPLE,
    *,
    scale: float = 1.0,
    axes: Sequence[tuple[int, int]] = ((0, 1), (1, 1), (2, 1)),
    channels: str = "Zrotation Xrotation Yrotation",
    ends: bool = True,
    above: str = "",
) -> str:
    """Return a HIERARCHY.

    Parameters
    ----------
    names
        What each role is called; roles that are not named are left out.
    scale
        Units in a centimetre.
    axes
        Which coordinate (and its sign) of the T-pose each coordinate of the file is.
    channels
        Rotations of each joint; the root has positions before them.
    ends
        Whether there are End Sites.
    above
        Name of a joint on the ground above the pelvis.
    """
    lines = ["HIERARCHY"]
    hanging = dict.fromkeys([role for role, _, _ in TREE])
    offsets = {role: list(offset) for role, _, offset in TREE}
    for role, parent, _ in TREE:
        while parent is not None and parent not in names:
            offsets[role] = [a + b for a, b in zip(offsets[role], offsets[parent], strict=True)]
            parent = {r: p for r, p, _ in TREE}[parent]
        hanging[role] = parent

    def numbers(offset: Sequence[float]) -> str:
        return " ".join(f"{offset[axis] * sign * scale:.6f}" for axis, sign in axes)

    def write(role: str, kind: str) -> None:
        positions = "" if kind == "JOINT" else "Xposition Yposition Zposition "
        count = len((positions + channels).split())
        lines.extend((f"{kind} {names[role]}", "{", f"OFFSET {numbers(offsets[role])}"))
        lines.append(f"CHANNELS {count} {positions}{channels}")
        below = [child for child in hanging if hanging[child] == role and child in names]
        for child in below:
            write(child, "JOINT")
        if not below and ends:
            tip = TIPS.get(role, (0, 0, 0))
            lines.extend(("End Site", "{", f"OFFSET {numbers(tip)}", "}"))
        lines.append("}")

    roots = [role for role in hanging if role in names and hanging[role] is None]
    if above:
        lines.extend((f"ROOT {above}", "{", "OFFSET 0 0 0"))
        lines.append(f"CHANNELS 6 Xposition Yposition Zposition {channels}")
    for root in roots:
        write(root, "JOINT" if above else "ROOT")
    if above:
        lines.append("}")
    return "\n".join(lines) + "\n"


def motion(frames: Sequence[Sequence[float]], time: str = "0.0333333") -> str:
    """Return a MOTION with these frames."""
    rows = "".join(" ".join(f"{number:g}" for number in frame) + "\n" for frame in frames)
    return f"MOTION\nFrames: {len(frames)}\nFrame Time: {time}\n{rows}"


def still(text: str, frames: int = 3, root: Sequence[float] = (0, 92, 0)) -> str:
    """Return a HIERARCHY with a MOTION that stands still."""
    width = sum(map(int, re.findall(r"CHANNELS (\d+)", text)))
    frame = [*root, *[0.0] * (width - len(root))]
    return text + motion([frame] * frames)


def person(frames: int = 3, **options: Any) -> bytes:
    """Return the whole file of a person that stands still."""
    return still(hierarchy(**options), frames).encode()


SIDES = {
    "L": {"Left": "Left", "left": "left", "LEFT": "LEFT", "L": "L", "l": "l", "Le": "左"},
    "R": {"Left": "Right", "left": "right", "LEFT": "RIGHT", "L": "R", "l": "r", "Le": "右"},
}


def named(scheme: str) -> dict[str, str]:
    """Return the names of a scheme: words for Pelvis Chest Neck Head, then for each side.

    A scheme is ``Pelvis Chest Neck Head | Collar Shoulder Elbow Wrist Hand | Hip Knee Ankle Toe``
    with ``-`` for what it lacks, ``_`` for a blank, and ``{Left}``, ``{l}`` ... for the side.
    """
    middle, arm, leg = (part.split() for part in scheme.split("|"))
    names = dict(zip(("Pelvis", "Chest", "Neck", "Head"), middle, strict=True))
    roles = ("Collar", "Shoulder", "Elbow", "Wrist", "Hand", "Hip", "Knee", "Ankle", "Toe")
    for side, words in SIDES.items():
        for role, name in zip(roles, arm + leg, strict=True):
            names[side + role] = name.format_map(words)
    return {role: name.replace("~", " ") for role, name in names.items() if name != "-"}


def played(names: Mapping[str, str]) -> dict[str, str]:
    """Return what a reader has to find: the body's joints among the roles."""
    return {joint: names[joint] for joint in JOINTS if joint in names}


SCHEMES = {
    "MotionBuilder, LAFAN1": "Hips Spine2 Neck Head"
    "| {Left}Shoulder {Left}Arm {Left}ForeArm {Left}Hand -"
    "| {Left}UpLeg {Left}Leg {Left}Foot {Left}Toe",
    "cgspeed": "Hips Spine1 Neck Head"
    "| {Left}Shoulder {Left}Arm {Left}ForeArm {Left}Hand {L}Fingers"
    "| {Left}UpLeg {Left}Leg {Left}Foot {Left}ToeBase",
    "cgspeed, renamed": "Hips Chest2 Neck Head"
    "| {Left}Collar {Left}Shoulder {Left}Elbow {Left}Wrist {l}hand"
    "| {Left}Hip {Left}Knee {Left}Ankle {Left}Toe",
    "DAZ": "hip chest neck head"
    "| {l}Collar {l}Shldr {l}ForeArm {l}Hand {l}Mid1 | {l}Thigh {l}Shin {l}Foot -",
    "CMU bones": "root thorax lowerneck head"
    "| {l}clavicle {l}humerus {l}radius {l}wrist {l}fingers"
    "| {l}femur {l}tibia {l}foot {l}toes",
    "BioVision": "Hips Chest2 Neck Head"
    "| {Left}Collar {Left}Shoulder {Left}Elbow {Left}Wrist -"
    "| {Left}Hip {Left}Knee {Left}Ankle -",
    "Xsens": "Hips Chest4 Neck Head"
    "| {Left}Collar {Left}Shoulder {Left}Elbow {Left}Wrist -"
    "| {Left}Hip {Left}Knee {Left}Ankle {Left}Toe",
    "Rokoko, Perception Neuron": "Hips Spine2 Neck Head"
    "| {Left}Shoulder {Left}Arm {Left}ForeArm {Left}Hand {Left}HandMiddle1"
    "| {Left}UpLeg {Left}Leg {Left}Foot {Left}ToeBase",
    "Mixamo": "mixamorig:Hips mixamorig:Spine2 mixamorig:Neck mixamorig:Head"
    "| mixamorig:{Left}Shoulder mixamorig:{Left}Arm mixamorig:{Left}ForeArm"
    " mixamorig:{Left}Hand mixamorig:{Left}HandMiddle1"
    "| mixamorig:{Left}UpLeg mixamorig:{Left}Leg mixamorig:{Left}Foot mixamorig:{Left}ToeBase",
    "Mixamo from Blender": "mixamorig1_Hips mixamorig1_Spine2 mixamorig1_Neck mixamorig1_Head"
    "| mixamorig1_{Left}Shoulder mixamorig1_{Left}Arm mixamorig1_{Left}ForeArm"
    " mixamorig1_{Left}Hand -"
    "| mixamorig1_{Left}UpLeg mixamorig1_{Left}Leg mixamorig1_{Left}Foot mixamorig1_{Left}ToeBase",
    "Bandai": "Hips Chest Neck Head"
    "| Shoulder_{L} UpperArm_{L} LowerArm_{L} Hand_{L} -"
    "| UpperLeg_{L} LowerLeg_{L} Foot_{L} Toes_{L}",
    "OpenNI": "- TORSO NECK HEAD"
    "| - {LEFT}_SHOULDER {LEFT}_ELBOW {LEFT}_HAND - | {LEFT}_HIP {LEFT}_KNEE {LEFT}_FOOT -",
    "Kinect": "SpineBase SpineMid Neck Head"
    "| - Shoulder{Left} Elbow{Left} Wrist{Left} Hand{Left}"
    "| Hip{Left} Knee{Left} Ankle{Left} Foot{Left}",
    "HumanML3D, SMPL": "pelvis spine3 neck head"
    "| {left}_collar {left}_shoulder {left}_elbow {left}_wrist {left}_middle1"
    "| {left}_hip {left}_knee {left}_ankle {left}_foot",
    "SMPL in capitals": "Pelvis Spine3 Neck Head"
    "| {L}_Collar {L}_Shoulder {L}_Elbow {L}_Wrist {L}_Hand | {L}_Hip {L}_Knee {L}_Ankle {L}_Foot",
    "Unreal": "pelvis spine_03 neck_01 head"
    "| clavicle_{l} upperarm_{l} lowerarm_{l} hand_{l} middle_01_{l}"
    "| thigh_{l} calf_{l} foot_{l} ball_{l}",
    "Blender": "hips chest neck head"
    "| shoulder.{L} upper_arm.{L} forearm.{L} hand.{L} f_middle.01.{L}"
    "| thigh.{L} shin.{L} foot.{L} toe.{L}",
    "Biped": "Bip01~Pelvis Bip01~Spine1 Bip01~Neck Bip01~Head"
    "| Bip01~{L}~Clavicle Bip01~{L}~UpperArm Bip01~{L}~Forearm Bip01~{L}~Hand Bip01~{L}~Finger2"
    "| Bip01~{L}~Thigh Bip01~{L}~Calf Bip01~{L}~Foot Bip01~{L}~Toe0",
    "Biped with underscores": "Bip001_Pelvis Bip001_Spine1 Bip001_Neck Bip001_Head"
    "| Bip001_{L}_Clavicle Bip001_{L}_UpperArm Bip001_{L}_Forearm Bip001_{L}_Hand -"
    "| Bip001_{L}_Thigh Bip001_{L}_Calf Bip001_{L}_Foot Bip001_{L}_Toe0",
    "VRM": "hips chest neck head"
    "| {left}Shoulder {left}UpperArm {left}LowerArm {left}Hand {left}MiddleProximal"
    "| {left}UpperLeg {left}LowerLeg {left}Foot {left}Toes",
    "VRoid": "J_Bip_C_Hips J_Bip_C_Chest J_Bip_C_Neck J_Bip_C_Head"
    "| J_Bip_{L}_Shoulder J_Bip_{L}_UpperArm J_Bip_{L}_LowerArm J_Bip_{L}_Hand J_Bip_{L}_Middle1"
    "| J_Bip_{L}_UpperLeg J_Bip_{L}_LowerLeg J_Bip_{L}_Foot J_Bip_{L}_ToeBase",
    "MakeHuman": "root spine01 neck01 head"
    "| clavicle.{L} upperarm01.{L} lowerarm01.{L} wrist.{L} finger3-1.{L}"
    "| upperleg01.{L} lowerleg01.{L} foot.{L} toe1-1.{L}",
    "Motive": "Hip Chest Neck Head"
    "| {L}Shoulder {L}UArm {L}FArm {L}Hand - | {L}Thigh {L}Shin {L}Foot {L}Toe",
    "DeepMotion": "hips_JNT spine2_JNT neck_JNT head_JNT"
    "| {l}_shoulder_JNT {l}_arm_JNT {l}_forearm_JNT {l}_hand_JNT {l}_handMiddle1_JNT"
    "| {l}_upleg_JNT {l}_leg_JNT {l}_foot_JNT {l}_toebase_JNT",
    "Reallusion": "CC_Base_Hip CC_Base_Spine02 CC_Base_NeckTwist01 CC_Base_Head"
    "| CC_Base_{L}_Clavicle CC_Base_{L}_Upperarm CC_Base_{L}_Forearm CC_Base_{L}_Hand"
    " CC_Base_{L}_Mid1"
    "| CC_Base_{L}_Thigh CC_Base_{L}_Calf CC_Base_{L}_Foot CC_Base_{L}_ToeBase",
    "MikuMikuDance": "下半身 上半身2 首 頭"
    "| {Le}肩 {Le}腕 {Le}ひじ {Le}手首 -"
    "| {Le}足 {Le}ひざ {Le}足首 {Le}つま先",
    "all lower case": "hips chest neck head"
    "| {left}collar {left}arm {left}forearm {left}hand -"
    "| {left}upleg {left}leg {left}foot {left}toe",
    "side behind": "Hips Chest Neck Head"
    "| Collar{Left} Arm{Left} ForeArm{Left} Hand{Left} -"
    "| UpLeg{Left} Leg{Left} Foot{Left} Toe{Left}",
}
"""How programs call the joints, for `named`."""
