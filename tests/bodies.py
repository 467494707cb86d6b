"""BVH texts for tests: a person in a T-pose, 1.7 m, facing +z, y up, with joints called at will."""

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
