"""Which joint plays which: naming schemes, and shape where names say nothing."""

import random

import numpy as np
import pytest
from bodies import SIMPLE, hierarchy, named, person, played, still
from hypothesis import given, settings
from hypothesis import strategies as st

from lanindex import formats
from lanindex.alphabet import JOINTS
from lanindex.body.names import keys
from lanindex.errors import BodyError

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


@pytest.mark.parametrize("scheme", SCHEMES)
def test_naming_schemes(scheme):
    names = named(SCHEMES[scheme])
    motion = formats.read("x.bvh", data=person(names=names, ends=False))
    assert motion.skeleton.played() == played(names)
    assert motion.warnings == ()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_naming_schemes_with_end_sites(scheme):
    names = named(SCHEMES[scheme])
    found = formats.read("x.bvh", data=person(names=names)).skeleton.played()
    assert {joint: found[joint] for joint in played(names)} == played(names)


def test_a_hand_is_the_middle_fingers_first_joint():
    text = hierarchy(named(SCHEMES["Mixamo"]))
    thumb = "JOINT mixamorig:LeftHandThumb1 { OFFSET 9 0 9 CHANNELS 0 }\n"
    text = text.replace(
        "JOINT mixamorig:LeftHandMiddle1", thumb + "JOINT mixamorig:LeftHandMiddle1"
    )
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert found["LHand"] == "mixamorig:LeftHandMiddle1"


def test_tips_are_end_sites_where_there_is_nothing_else():
    names = {role: name for role, name in SIMPLE.items() if role[1:] not in ("Hand", "Toe")}
    names.pop("Head")
    tips = ["LWrist", "LAnkle"]
    text = hierarchy(names)
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert not {"LHand", "RHand", "LToe", "RToe", "Head"} & found.keys()
    for tip in (*tips, "RWrist", "RAnkle", "Neck"):
        text = text.replace(
            text[text.index(f"JOINT {tip}\n") :],
            text[text.index(f"JOINT {tip}\n") :].replace(
                "End Site\n{\nOFFSET 0.000000 0.000000 0.000000", "End Site\n{\nOFFSET 1 2 3", 1
            ),
        )
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert found["LHand"] == "LWrist End"
    assert found["RToe"] == "RAnkle End"
    assert found["Head"] == "Neck End"


def test_a_head_without_a_neck_is_the_neck_and_its_tip_the_head():
    names = {role: name for role, name in SIMPLE.items() if role != "Neck"}
    found = formats.read("x.bvh", data=person(names=names)).skeleton.played()
    assert (found["Neck"], found["Head"]) == ("Head", "Head End")


def test_a_head_in_one_place_with_the_neck_gives_its_tip():
    text = hierarchy().replace(
        "OFFSET 0.000000 10.000000 1.000000", "OFFSET 0.000000 0.000000 0.000000"
    )
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert (found["Neck"], found["Head"]) == ("Head", "Head End")


def test_a_ground_joint_above_the_hips_is_not_the_pelvis():
    names = SIMPLE | {"Pelvis": "Hips"}
    for above in ("joint_Root", "root", "Reference"):
        text = hierarchy(names, above=above)
        motion = formats.read("x.bvh", data=still(text, root=(0, 0, 0, 0, 0, 0)).encode())
        assert motion.skeleton.played()["Pelvis"] == "Hips"
        assert motion.skeleton.names[0] == above


@pytest.mark.parametrize("facing", [0.0, 90.0, 200.0])
@pytest.mark.parametrize("up", ["y", "z"])
def test_shape_alone(facing, up):
    rows = list(SIMPLE)
    names = {role: f"J{rows.index(role) + 1}" for role in rows}
    axes = {"y": ((0, 1), (1, 1), (2, 1)), "z": ((0, 1), (2, -1), (1, 1))}[up]
    turn = (facing, 0, 0) if up == "z" else (0, 0, facing)
    text = still(hierarchy(names, axes=axes), root=(0, 92, 0, *turn))
    motion = formats.read("x.bvh", data=text.encode())
    assert motion.skeleton.played() == played(names)
    assert motion.source.up == up
    assert any("by shape" in warning for warning in motion.warnings)


@settings(deadline=None, max_examples=30)
@given(st.randoms(use_true_random=False))
def test_shape_does_not_depend_on_the_order_of_sides(numbers: random.Random):
    swap = numbers.random() < 0.5
    roles = [f"J{k}" for k in numbers.sample(range(1000), len(SIMPLE))]
    names = dict(zip(SIMPLE, roles, strict=True))
    text = hierarchy(names)
    if swap:  # the right side first: mirror the text's offsets and the names
        mirrored = {
            role: names[("RL"["LR".index(role[0])] + role[1:]) if role[1:2].isupper() else role]
            for role in names
        }
        text = hierarchy(mirrored, axes=((0, -1), (1, 1), (2, 1)))
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert found == played(names)


def test_arms_missing_from_the_names_are_found_by_shape():
    odd = {role: f"X{k}" for k, role in enumerate(SIMPLE) if role[1:] in ("Shoulder", "Elbow")}
    names = SIMPLE | odd
    motion = formats.read("x.bvh", data=person(names=names))
    assert motion.skeleton.played() == played(names)
    (warning,) = motion.warnings
    assert warning == ("recognised by shape, not by name: RShoulder, RElbow, LShoulder, LElbow")


def test_legs_alone_are_enough():
    legs = ("Pelvis", "Hip", "Knee", "Ankle", "Toe")
    names = {role: name for role, name in SIMPLE.items() if role.lstrip("LR") in legs}
    found = formats.read("x.bvh", data=person(names=names)).skeleton.played()
    assert set(found) == set(played(names))


def test_arms_and_hips_are_enough():
    names = {r: n for r, n in SIMPLE.items() if r[1:] not in ("Knee", "Ankle", "Toe")}
    found = formats.read("x.bvh", data=person(names=names)).skeleton.played()
    assert {"RHip", "LWrist"} <= found.keys()


def test_what_is_no_human_is_refused_by_name():
    lamp = {"Pelvis": "Base", "Chest": "Stem", "Head": "Bulb"}
    with pytest.raises(BodyError) as caught:
        formats.read("lamp.bvh", data=person(names=lamp))
    text = str(caught.value)
    assert text.startswith("lamp.bvh: no human skeleton: among 4 joints there is no RShoulder")
    assert "LAnkle" in text


def test_a_near_miss_is_guessed():
    wrong = ("LHip", "RHip", "LWrist", "RWrist")
    names = {
        role: name.replace("Hip", "Hipp_").replace("Wrist", "Wriist")
        for role, name in SIMPLE.items()
        if role in wrong or role[1:] not in ("Collar",)
    }
    data = person(names=names).replace(b" -42.000000 ", b" -4.000000 ")
    data = data.replace(b" -40.000000 ", b" -90.000000 ")
    with pytest.raises(BodyError, match="is 'R"):
        formats.read("x.bvh", data=data)


def test_a_crowd_of_joints_is_refused_quickly():
    crowd = "".join(f"JOINT j{k} {{ OFFSET 0 1 0 CHANNELS 0 }}\n" for k in range(10_000))
    text = hierarchy({"Pelvis": "Hips"}).replace("End Site", crowd + "End Site")
    with pytest.raises(BodyError, match="among 10002 joints"):
        formats.read("crowd.bvh", data=still(text).encode())
    deep = "".join(f"JOINT j{k} {{ OFFSET 0 1 0 CHANNELS 0 " for k in range(5000)) + "}" * 5000
    text = hierarchy({"Pelvis": "Hips"}).replace("End Site", deep + "End Site")
    with pytest.raises(BodyError, match="among 5002 joints"):
        formats.read("deep.bvh", data=still(text).encode())


def test_a_person_in_a_crowd_of_joints_is_found():
    crowd = "".join(f"JOINT j{k} {{ OFFSET 0 1 0 CHANNELS 0 }}\n" for k in range(10_000))
    text = hierarchy().replace("JOINT Chest", crowd + "JOINT Chest")
    motion = formats.read("crowd.bvh", data=still(text).encode())
    assert motion.skeleton.played() == played(SIMPLE)


def test_keys():
    names = ("mixamorig:LeftHandMiddle1", "lhumerus", "Bip01 R Thigh", "TORSO#", "hand.R", "RUpLeg")
    assert keys(names) == (
        ("L", "handmiddle1"),
        ("L", "humerus"),
        ("R", "1thigh"),
        ("", "torso"),
        ("R", "hand"),
        ("R", "upleg"),
    )


def test_the_joints_of_a_body_are_in_the_alphabets_order():
    motion = formats.read("x.bvh", data=person())
    assert motion.skeleton.body.dtype == np.int16
    assert [motion.skeleton.names[k] for k in motion.skeleton.body] == list(JOINTS)
