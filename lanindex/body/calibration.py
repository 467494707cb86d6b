"""What a file does not state and the body tells: unit, vertical axis, calibration pose."""

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.errors import UsageError

UNITS: Mapping[str, float] = {
    "mm": 1.0,
    "cm": 10.0,
    "m": 1000.0,
    "inch": 25.4,
    "inch/0.45": 25.4 / 0.45,
}
"""Millimetres in one unit; the last is the CMU captures'."""

_OTHER_NAMES = {"in": "inch", "inches": "inch", "cmu": "inch/0.45", "metre": "m", "meter": "m"}

AXES: Mapping[str, tuple[tuple[int, int], ...]] = {
    "y": ((0, 1), (1, 1), (2, 1)),
    "z": ((0, 1), (2, 1), (1, -1)),
    "x": ((1, -1), (0, 1), (2, 1)),
    "-y": ((0, 1), (1, -1), (2, -1)),
    "-z": ((0, 1), (2, -1), (1, 1)),
    "-x": ((1, 1), (0, -1), (2, 1)),
}
"""By vertical axis: the file's axis and sign for each of x, y, z; all are turns, no mirrors."""

_LENGTHS = (  # mm, of a person of 1.70 m
    (("Hip", "Knee", "Ankle"), 820.0),
    (("Shoulder", "Elbow", "Wrist"), 510.0),
)
_CHAINS = np.array(
    [[[JOINT_CODES[side + joint] for joint in limb] for side in "RL"] for limb, _ in _LENGTHS]
)
_TOPS, _BOTTOMS = (
    tuple([JOINT_CODES[joint] for joint in group.split()] for group in groups)
    for groups in (
        ("Neck", "RShoulder LShoulder", "Head", "Chest", "RHip LHip"),
        ("RAnkle LAnkle", "RKnee LKnee", "RHip LHip"),
    )
)
_CORNERS = (_BOTTOMS[2], _TOPS[1], _BOTTOMS[0], [JOINT_CODES[side + "Wrist"] for side in "RL"])
_FACING = tuple(
    tuple([JOINT_CODES[joint] for joint in group.split()] for group in groups)
    for groups in (("RHip", "LHip"), ("RToe LToe", "RAnkle LAnkle"))
)
_MOSTLY = 0.9  # of the poses
_ACROSS = 0.6  # cosine, 53 degrees; a person on the floor has arms and legs so in .44 of the poses
_HUMAN = (0.4, 1.2), (0.35, 1.5)  # arms, trunk, in legs; of real captures .52 to 1.07, .41 to .85
_SIZES = (0.7, 1.4)
_BONES = np.array([["thigh", "shank"], ["upper arm", "forearm"]])  # of `_CHAINS`
_UNEVEN = 1.5  # how many times as long a bone may be on one side as on the other
_UPRIGHT = 0.7
_CALIBRATION_SPEED = 25_000.0  # mm/s

BEGINNING = 40
"""Frames, the first ones, that are looked at for a calibration pose."""

_FALLING, _FALL = 2_000.0, Fraction(1, 10)  # mm/s, and seconds at most


def unit_named(unit: str) -> str:
    """Return a unit that the user names, as a key of `UNITS`."""
    name = _OTHER_NAMES.get(unit.lower(), unit.lower())
    if name not in UNITS:
        raise UsageError(f"unit {unit!r}", wanted=f"one of {', '.join(UNITS)}")
    return name


def up_axis_named(up: str) -> str:
    """Return a vertical axis that the user names, as a key of `AXES`."""
    if up.lower() not in AXES:
        raise UsageError(f"up axis {up!r}", wanted=f"one of {', '.join(AXES)}")
    return up.lower()


def unit_of(
    lengths: Mapping[str, float], unit: str | None, declared: str | None = None
) -> tuple[str, float, tuple[str, ...]]:
    """Return the unit."""
    if unit is not None:
        name = unit_named(unit)
        return name, UNITS[name], ()
    declared_unit = _OTHER_NAMES.get((declared or "").lower(), (declared or "").lower())
    known = [
        (limb, length, typical)
        for limb, typical in _LENGTHS
        if (length := lengths.get(" ".join(limb), 0.0)) > 0
    ]
    if not known and declared_unit not in UNITS:
        return "cm (assumed)", UNITS["cm"], ("no length tells the unit: cm assumed",)
    if not known:
        return declared_unit, UNITS[declared_unit], ()
    limb, length, typical = known[0]
    part = "leg" if limb[0] == "Hip" else "arm"
    sizes = {unit: size * length for unit, size in UNITS.items()}
    usual = [unit for unit, size in sizes.items() if _SIZES[0] <= size / typical <= _SIZES[1]]
    name = min(UNITS, key=lambda unit: abs(sizes[unit] - typical))
    if declared_unit in usual or (declared_unit in UNITS and name not in usual):
        return declared_unit, UNITS[declared_unit], ()
    if declared_unit in UNITS:
        found = f"says {declared_unit}, in which its {part} is {sizes[declared_unit]:.0f} mm"
        return f"{name} (detected)", UNITS[name], (f"{found}: {name} believed",)
    if name in usual:
        return f"{name} (detected)", UNITS[name], ()
    warning = f"in no known unit the body has a usual size: in {name} its {part} is"
    doubt = f"{warning} {sizes[name]:.0f} mm. If that is wrong, give --unit"
    return f"{name} (guessed)", UNITS[name], (doubt,)


def body_lengths(body: NDArray[np.float64]) -> dict[str, float]:
    """Return the lengths of leg and arm in poses (S, 20, 3), those of the longer side."""
    middle = _usual(_bones(body).sum(axis=-1)).tolist()
    return {
        " ".join(limb): max(known)
        for (limb, _), sides in zip(_LENGTHS, middle, strict=True)
        if (known := [length for length in sides if not math.isnan(length)])
    }


def _bones(body: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how long the bones of `_CHAINS` are, (S, limb, side, bone)."""
    chains = body[:, _CHAINS]
    bones = chains[..., 1:, :] - chains[..., :-1, :]
    lengths: NDArray[np.float64] = np.sqrt((bones * bones).sum(axis=-1))
    return lengths


def _usual(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the middle of lengths; NaN comes last."""
    middle: NDArray[np.float64] = np.sort(lengths, axis=0)[len(lengths) // 2]
    return middle


def uneven_doubt(body: NDArray[np.float64], scale: float) -> tuple[str, ...]:
    """Return a warning where a bone in poses (S, 20, 3) is far longer on one side."""
    sides = _usual(_bones(body)) * scale
    right, left = sides[:, 0], sides[:, 1]
    uneven = np.maximum(right, left) > _UNEVEN * np.minimum(right, left)
    found = [
        f"right {bone} {one:.0f} mm, left {other:.0f}"
        for bone, one, other in zip(_BONES[uneven], right[uneven], left[uneven], strict=True)
    ]
    told = f"{'; '.join(found)}: a joint or marker may be misnamed, or was badly seen"
    return (told,) if found else ()


def up_of(
    body: NDArray[np.float64], up: str | None, declared: str | None, four_legs: bool
) -> tuple[str, tuple[str, ...]]:
    """Return the vertical axis of poses (S, 20, 3): the body points from the ankles to the neck.

    The straightest poses tell it: who sprints leans far forward at first, and later stands tall.
    """
    if up is not None:
        return up_axis_named(up), ()
    spine = _middle(body, _TOPS[-1:] if four_legs else _TOPS) - _middle(body, _BOTTOMS)
    lengths = np.sqrt((spine * spine).sum(axis=1))
    spine = spine[np.argsort(-lengths)[: max(np.count_nonzero(lengths > 0) // 4, 1)]]
    length = math.sqrt(float((spine * spine).sum()) / len(spine))
    mean = (spine.sum(axis=0) / len(spine)).tolist()
    axis = max((1, 2, 0), key=lambda k: abs(mean[k]))
    upright = abs(mean[axis]) >= _UPRIGHT * length
    seen = ("-" if mean[axis] < 0 else "") + "xyz"[axis]
    if declared is not None and declared in AXES:
        if seen == declared or not upright:
            return declared, ()
        return seen, (
            f"says that {declared} is up, but the body stands along {seen}: that believed",
        )
    if axis == 0 or not upright or math.isnan(length):
        doubt = "the body is not upright: y taken as up. If that is wrong, give --up"
        return "y", () if math.isnan(length) else (doubt,)
    return seen, ()


def _middle(body: NDArray[np.float64], choices: tuple[list[int], ...]) -> NDArray[np.float64]:
    """Return the first of these joints that is known in any pose, (S, 3); the middle of a pair."""
    for choice in choices:
        place: NDArray[np.float64] = body[:, choice].sum(axis=1) / len(choice)
        if choice is choices[-1] or not np.isnan(place[:, 0]).all():
            break
    return place


def on_four_legs(body: NDArray[np.float64]) -> bool:
    """Return whether arms and legs stand side by side, across the trunk, in most poses."""
    hips, shoulders, ankles, wrists = (_middle(body, (pair,)) for pair in _CORNERS)
    lines = np.stack((shoulders - hips, ankles - hips, wrists - shoulders))
    lines /= np.maximum(np.sqrt((lines * lines).sum(axis=2, keepdims=True)), 1e-9)
    leg, arm, both = (np.einsum("sk,sk->s", *lines[pair]) for pair in ([0, 1], [0, 2], [1, 2]))
    stands = (abs(leg) < _ACROSS) & (abs(arm) < _ACROSS) & (both > _ACROSS)
    return bool(np.count_nonzero(stands) >= _MOSTLY * len(body))


def shape_doubts(
    body: NDArray[np.float64], lengths: Mapping[str, float], four_legs: bool
) -> tuple[str, ...]:
    """Return warnings where poses (S, 20, 3), `lengths` in them, are hardly those of a human."""
    hips, shoulders = (_middle(body, (pair,)) for pair in _CORNERS[:2])
    trunk = float(_usual(np.sqrt(((shoulders - hips) ** 2).sum(axis=1))))
    leg, arm = (lengths.get(" ".join(limb), math.nan) for limb, _ in _LENGTHS)
    found = [
        f"its {part} {verb} {size / leg:.1f} times as long as its legs"
        for part, verb, size, (least, most) in zip(
            ("arms", "trunk"), ("are", "is"), (arm, trunk), _HUMAN, strict=True
        )
        if size < least * leg or size > most * leg
    ]
    if four_legs:
        found.append("arms and legs stand across the trunk throughout, as if it had four legs")
    return (f"perhaps no human: {'; '.join(found)}",) if found else ()


def facing_doubt(body: NDArray[np.float64], up: str) -> tuple[str, ...]:
    """Return a warning where feet in poses (S, 20, 3) point backwards, as if mirrored."""
    vertical = "xyz".index(up[-1])
    one, other = (vertical + 1) % 3, (vertical + 2) % 3
    across, feet = (body[:, toes] - body[:, heels] for toes, heels in _FACING)
    feet = feet.sum(axis=1)
    forward = across[:, 0, one] * feet[:, other] - across[:, 0, other] * feet[:, one]
    backwards = np.count_nonzero(forward > 0 if up[0] == "-" else forward < 0)
    if backwards < _MOSTLY * len(body):
        return ()
    return ("the feet point backwards: left and right may be exchanged",)


def first_frame(wrists: Sequence[Sequence[Sequence[float]]], rate: Fraction) -> int:
    """Return the first frame of movement, behind a calibration pose; `wrists` (N, W, 3) mm.

    No arm is so fast as the jump from such a pose. Some converters smear it over the next frames:
    the wrists slow down, but are faster than 2 m/s, for a tenth of a second at most.
    """
    few = wrists[: 2 + int(_FALL * rate)]
    steps = [max(map(math.dist, *pair), default=0.0) for pair in pairwise(few)]
    if not (steps and steps[0] * float(rate) > _CALIBRATION_SPEED):
        return 0
    most = len(steps)
    slow = _FALLING / float(rate)
    for frame in range(1, most):
        if not slow < steps[frame] < steps[frame - 1]:
            return frame
    return most
