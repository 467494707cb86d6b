"""The standard body, and how its limbs, palms, chest and head go where a score tells them to.

Source: ``encoding/BODY.md``, "Touch", "Palms", "Twists" and "Inclines", read backwards. Directions
are vectors of the body frame: forward +x, up +y, right +z.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, JOINTS, LOW, MID, PLACE, TOUCHED, amounts_of
from lanindex.body.axes import facing, planes
from lanindex.model import SYMBOL, Score, Skeleton
from lanindex.model.derived import DEGREE, degree_of

Floats = NDArray[np.float64]
Cell = tuple[int, int]

FORWARD = np.array([1.0, 0.0, 0.0])
UP = np.array([0.0, 1.0, 0.0])
FOLDED: Cell = (PLACE, MID)


@dataclass(frozen=True, slots=True, eq=False)
class Limb:
    """An arm or a leg of two equal bones, and how it folds."""

    bones: tuple[str, str]  # Upper and lower, without their side
    # (3,) forward, up, out: directions of the folded limb's end and of its middle joint
    toward: Floats
    bend: Floats
    near: float  # How far the folded limb's end lies, of the limb's length


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """The standard body: its skeleton, which bone moves each joint, how long bones are (mm)."""

    skeleton: Skeleton  # (J) joints at rest: facing +z, y up, left +x
    bones: tuple[str, ...]  # (J) the bone that turns each joint's offset, or the empty string
    limbs: dict[str, Limb]  # By group: ``arm``, ``leg``
    sole: float  # Height of the lowest joint at rest
    arm: tuple[float, float, float]  # Upper arm, forearm, and hand to the tips of the fingers
    shoulders: float  # Height above the hips
    leg: float  # From the hip to the ankle
    # (3,) in the body frame at rest: the toe's joint from the ankle, and the hips from the root
    toe: Floats
    hips: dict[str, Floats]

    @property
    def ankle(self) -> float:
        """Height of an ankle above the floor."""
        return self.sole - float(self.toe[1])


@cache
def standard(palms: frozenset[str] = frozenset()) -> Body:
    """Return the standard body."""
    table = tomllib.loads(files("lanindex.perform").joinpath("figure.toml").read_text("utf-8"))
    joints = [it for it in table["joints"] if it["bone"][1:] != "_palm" or it["bone"] in palms]
    names = [joint["name"] for joint in joints]
    plays = [joint["plays"] for joint in joints]
    parents = [names.index(it["parent"]) if it["parent"] else -1 for it in joints]
    offsets = np.array([joint["offset"] for joint in joints], np.float64)
    skeleton = Skeleton(
        tuple(names),
        np.array(parents, np.int16),
        offsets.astype(np.float32),
        np.array([plays.index(joint) for joint in JOINTS], np.int16),
    )
    limbs = {
        name: Limb(
            tuple(limb["bones"]), np.array(limb["toward"]), np.array(limb["bend"]), limb["near"]
        )
        for name, limb in table["limbs"].items()
    }

    def length(*bones: str) -> float:
        own = [it for it, joint in zip(offsets, joints, strict=True) if joint["bone"] in bones]
        return float(sum(np.linalg.norm(it) for it in own))

    def seen(joint: str) -> Floats:
        x, y, z = offsets[plays.index(joint)]
        return np.array([z, y, -x])

    shoulders, joint = 0.0, plays.index("RShoulder")
    while joint > 0:
        shoulders, joint = shoulders + float(offsets[joint][1]), parents[joint]
    return Body(
        skeleton,
        tuple(joint["bone"] for joint in joints),
        limbs,
        table["sole"],
        (length("r_upper_arm"), length("r_forearm"), length("r_hand")),
        shoulders,
        length("r_thigh", "r_shank"),
        seen("RToe"),
        {side: seen(f"{side.upper()}Hip") for side in "rl"},
    )


def direction_vector(cell: Cell) -> Floats:
    """Return the unit vector, (3,), of a cell other than `FOLDED`."""
    code, level = cell
    if code == PLACE:
        return -UP if level == LOW else UP
    azimuth, elevation = np.radians(45.0 * code), np.radians(45.0 * (level + 1))
    flat = np.sin(elevation)
    return np.array([flat * np.sin(azimuth), -np.cos(elevation), flat * np.cos(azimuth)])


def minimum_jerk(share: Floats) -> Floats:
    """Return the share of the way done, (T,), after a share of the time, (T,)."""
    return share**3 * (10 - 15 * share + 6 * share**2)


def dot(one: Floats, other: Floats) -> Floats:
    """Return products of vectors, (..., 3), as (..., 1)."""
    product: Floats = np.sum(one * other, axis=-1, keepdims=True)
    return product


def unit(vectors: Floats) -> Floats:
    """Return vectors, (..., 3), at length 1."""
    found: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
    return found


def great_circle(start: Floats, stop: Floats, share: Floats, side: Floats) -> Floats:
    """Return directions, (T, 3), at shares, (T,), of the shorter great circle between two, (3,)."""
    along = float(start @ stop)
    across = stop - along * start
    angle = np.arctan2(np.linalg.norm(across), along)
    if np.linalg.norm(across) < 1e-9:  # half-way round: in front, from front to back past `side`
        across = FORWARD - (FORWARD @ start) * start
        if np.linalg.norm(across) < 1e-9:
            across = side
    turn = share[:, None] * angle
    points: Floats = np.cos(turn) * start + np.sin(turn) * (across / np.linalg.norm(across))
    return points


def shown(score: Score, part: str) -> NDArray[Any]:
    """Return the rows of a part that the score shows, (S,) of `SYMBOL`."""
    rows = score.tracks[part].symbols if part in score.tracks else np.zeros(0, SYMBOL)
    found: NDArray[Any] = rows[~rows["passing"]]
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """A stretch of frames in which a part goes from one cell to another, or stays."""

    frames: slice
    start: Cell
    stop: Cell
    share: Floats  # (T,) of the way done in each frame


def reaches(rows: NDArray[Any], times: Floats, rate: Fraction, rest: Cell) -> Iterator[Reach]:
    """Yield the reaches and rests of rows that are `shown`, at times (T,) in seconds."""
    now, done = rest, 0
    for row in rows:
        cell = int(row["direction"]), int(row["level"])
        start, stop = float(row["start"] / rate), float(row["stop"] / rate)
        begin, end = np.searchsorted(times, [start - 1e-9, stop - 1e-9])
        yield Reach(slice(done, begin), now, now, np.zeros(begin - done))
        share = (
            minimum_jerk((times[begin:end] - start) / (stop - start)) if end > begin else times[:0]
        )
        yield Reach(slice(begin, end), now, cell, share)
        now, done = cell, int(end)
    yield Reach(slice(done, len(times)), now, now, np.zeros(len(times) - done))


def reach_when_bent(rows: NDArray[Any], times: Floats, rate: Fraction) -> Floats:
    """Return the reach, (T,), 1 straight and 0 folded, of a limb by the rows of its bends."""
    angle, now = np.zeros(len(times)), 0.0
    for row in rows:
        start, stop = float(row["start"] / rate), float(row["stop"] / rate)
        begin = int(np.searchsorted(times, start - 1e-9))
        then = np.radians(DEGREE * degree_of(int(row["amount"])))
        share = np.clip((times[begin:] - start) / max(stop - start, 1e-9), stop <= start, 1)
        angle[begin:] = now + (then - now) * minimum_jerk(share)
        now = then
    reach: Floats = np.cos(angle / 2)
    return reach


NEARLY = 0.92  # cosine of 23 degrees: a palm farther off than that is reported

_SLIGHT = 1e-6


def face_palms(
    joints: Floats,
    wanted: Mapping[str, tuple[Floats, NDArray[np.int64]]],
    body: Body,
) -> list[str]:
    """Place knuckles, in (T, J, 3) mm, as palms shall face, (T, 3) by part; return what fails."""
    warnings = []
    for part, (out, arrived) in wanted.items():
        names = part[0].upper() + "Wrist", part[0].upper() + "Hand"
        wrist, tip = (int(body.skeleton.body[JOINT_CODES[name]]) for name in names)
        along = unit(joints[:, tip] - joints[:, wrist])
        palm = out - dot(out, along) * along
        size = np.linalg.norm(palm, axis=1)
        if (size[arrived] < NEARLY).any():
            warnings.append(f"{part} cannot face along the hand: it comes as near as it can")
        none = size < _SLIGHT
        palm[none] = np.cross(along[none], np.eye(3)[np.abs(along[none]).argmin(axis=1)])
        thumb = np.cross(along, unit(palm)) * (1 if part[0] == "r" else -1)
        for joint in (number for number, bone in enumerate(body.bones) if bone == part):
            far, _, aside = body.skeleton.offsets[joint].tolist()
            above = joints[:, body.skeleton.parents[joint]]
            joints[:, joint] = above + abs(far) * along + aside * thumb
    return warnings


def palm_axes(joints: Floats, body: Body) -> dict[str, NDArray[np.float32]]:
    """Return the axes of the hands of a body with knuckles, as in `Motion.axes`."""
    found = {}
    for hand, (first, last, _) in planes(body.skeleton.names).items():
        wrist = joints[:, body.skeleton.body[JOINT_CODES[hand[0] + "Wrist"]]]
        across, along = joints[:, first] - joints[:, last], joints[:, first] - wrist
        found[hand] = facing(hand, across, along).astype(np.float32)
    return found


TURNED = ("torso_twist", "head_turn", "torso_incline", "head_incline")
"""The tracks that are carried out here."""


def angles(score: Score, part: str, times: Floats) -> NDArray[np.complex128]:
    """Return the twist or lean of a part, (T,) degrees: real to the right, imaginary forward."""
    found, now = np.zeros(len(times), np.complex128), 0j
    for row in shown(score, part):
        start, stop = (float(Fraction(int(row[end])) / score.rate) for end in ("start", "stop"))
        some = slice(int(np.searchsorted(times, start)), None)
        code, degrees, there = int(row["direction"]), int(row["amount"]), 0j
        if 0 <= code < PLACE and degrees >= 0:
            there = complex(degrees * np.exp(1j * np.radians(45 * code)))
        share = np.clip((times[some] - start) / max(stop - start, 1e-9), 0, 1)
        found[some] = now + (there - now) * minimum_jerk(share)
        now = there
    return found


def lean_direction(lean: NDArray[np.complex128]) -> Floats:
    """Return the unit vectors, (T, 3), of a lean in degrees, (T,) as from `angles`."""
    size = np.abs(lean)
    way = lean / np.maximum(size, _SLIGHT)
    flat = np.sin(np.radians(size))
    return np.stack((flat * way.imag, np.cos(np.radians(size)), flat * way.real), axis=1)


def chest_axes(trunk: Floats, twist: Floats) -> tuple[Floats, Floats]:
    """Return the chest's front and right, (T, 3), from the trunk, (T, 3), and its twist, (T,)."""
    right = np.array([0.0, 0.0, 1.0])
    across = right - trunk[:, 2:] * trunk
    size = np.linalg.norm(across, axis=1, keepdims=True)
    aside = size < _SLIGHT  # as the torso lay down on its side, its right went down
    across = np.where(aside, -np.sign(trunk[:, 2:]) * [0.0, 1.0, 0.0], across / (size + aside))
    front = np.cross(trunk, across)
    cosine, sine = np.cos(np.radians(twist))[:, None], np.sin(np.radians(twist))[:, None]
    return cosine * front + sine * across, cosine * across - sine * front


def head_right(up: Floats, trunk: Floats, across: Floats) -> Floats:
    """Return a head's right, (T, 3), by its top and the chest's up and right, turned as it."""
    along = dot(up, trunk)
    along = np.where(np.abs(along) < _SLIGHT, _SLIGHT, along)
    return unit(across - dot(up, across) / along * trunk)


# The tracks that are carried out here, and whose hands they are of
TOUCHES = {"hands_touch": "RL", "r_hand_touch": "R", "l_hand_touch": "L"}
# Seconds that a hand is on its way, that it still comes nearer when touch begins, and that it has
# been on its way back when touch ends
COMES, NEARS, LEAVES = 0.5, 0.06, 0.12
PALM = 0.15  # lengths of an arm from the wrist to the middle of the palm
FARTHEST = 0.97  # part of its length, to the palm, that an arm reaches
_BEND = np.array([-0.3, -0.8, 0.6])  # forward, up, out: where an elbow goes
_PLACES: dict[str, tuple[tuple[str, str], float, tuple[float, float, float]]] = {
    "hand": (("Neck", "Pelvis"), 0.35, (0.45, 0.0, 0.06)),
    "head": (("Neck", "Head"), 0.0, (0.12, 0.33, 0.14)),
    "trunk": (("Neck", "Pelvis"), 0.55, (0.18, 0.0, 0.06)),
    "arm": (("other Shoulder", "other Elbow"), 0.75, (0.06, 0.0, -0.07)),
    "thigh": (("own Hip", "own Knee"), 0.6, (0.15, 0.0, 0.0)),
    "knee": (("own Knee", "own Knee"), 0.0, (0.12, 0.0, 0.0)),
    "shank": (("own Knee", "own Ankle"), 0.5, (0.11, 0.0, 0.0)),
    "foot": (("own Ankle", "own Toe"), 0.5, (0.0, 0.1, 0.0)),
}
"""By what is touched: two joints, how far from the first to the second, and from there forward, up
and out to the hand's side in lengths of an arm, where the palm comes to."""


def bring_hands(joints: Floats, score: Score, times: Floats, body: Body) -> list[str]:
    """Bring hands to what they touch, (T, J, 3) mm in place; return what is out of reach."""
    numbers = {name: int(body.skeleton.body[code]) for name, code in JOINT_CODES.items()}
    places = {name: joints[:, number].copy() for name, number in numbers.items()}
    arm, left_out = sum(body.arm[:2]), dict[str, None]()
    for side, thing, share in _touches(score, times):
        some = np.flatnonzero(share > 0)
        if not len(some):
            continue
        done, seen = share[some], {name: it[some] for name, it in places.items()}
        shoulder, elbow, wrist, hand = (
            seen[side + it] for it in ("Shoulder", "Elbow", "Wrist", "Hand")
        )
        up = unit(seen["Neck"] - seen["Pelvis"])
        right = seen["RHip"] - seen["LHip"]
        right = unit(right - dot(right, up) * up)
        out = right * (1 if side == "R" else -1)
        axes = np.stack([np.cross(up, right), up, out], axis=1)  # of the trunk, (T, 3, 3)
        ends, along, way = _PLACES[thing]
        other = {"R": "L", "L": "R"}[side]
        first, last = (it.replace("other ", other).replace("own ", side) for it in ends)
        target = seen[first] + along * (seen[last] - seen[first])
        target = target + arm * np.einsum("i,tij->tj", np.array(way), axes)
        near = np.linalg.norm(target - shoulder, axis=1) <= FARTHEST * (arm + PALM * arm)
        if not near[done > 0.99].all():
            hand_name = f"{side.lower()}_hand"
            left_out[f"{hand_name} does not reach the {thing}: it stays where its arm points"] = (
                None
            )
            continue
        palm = wrist + PALM * arm * unit(hand - wrist)
        palm += (target - palm) * done[:, None]
        elbow, wrist = _folded_arm(shoulder, palm, axes, elbow, done, body)
        joints[some, numbers[side + "Elbow"]] = elbow
        joints[some, numbers[side + "Wrist"]] = wrist
        before, far = numbers[side + "Wrist"], 0.0
        for number, parent in enumerate(body.skeleton.parents):
            if parent == before:  # those beyond the wrist are in line
                far += float(np.linalg.norm(body.skeleton.offsets[number]))
                joints[some, number] = wrist + far * unit(palm - wrist)
                before = number
        for name in (side + it for it in ("Elbow", "Wrist", "Hand")):
            places[name][some] = joints[some, numbers[name]]
    return list(left_out)


def _touches(score: Score, times: Floats) -> Iterator[tuple[str, str, Floats]]:
    """Yield whose palm comes to what, and how much it is there, (T,); hands to hands last."""
    for part, sides in reversed(TOUCHES.items()):
        if part not in score.tracks:
            continue
        rows = score.tracks[part].symbols
        starts, stops = (rows[it].astype(float) / float(score.rate) for it in ("start", "stop"))
        rests = np.maximum(starts[1:] - stops[:-1], 0.2) / 2
        before = np.minimum(np.concatenate([[COMES], rests]), COMES)
        after = np.minimum(np.concatenate([rests, [COMES]]), COMES)
        when = np.stack([starts, stops, before[: len(rows)], after[len(after) - len(rows) :]], 1)
        for row, (start, stop, coming, going) in zip(rows, when.tolist(), strict=True):
            thing = TOUCHED[row["amount"]] if 0 <= row["amount"] < len(TOUCHED) else ""
            if row["passing"] or thing not in amounts_of(part):
                continue
            begin, end = start + NEARS - coming, stop - LEAVES + going
            comes = np.clip((times - begin) / coming, 0, 1)
            goes = np.clip((end - times) / going, 0, 1)
            share = minimum_jerk(np.minimum(comes, goes))
            yield from ((side, thing, share) for side in sides)


def _folded_arm(
    shoulder: Floats, palm: Floats, axes: Floats, elbow: Floats, share: Floats, body: Body
) -> tuple[Floats, Floats]:
    """Return elbow and wrist of an arm whose palm lies there, the hand in line with the forearm."""
    upper, forearm, _ = body.arm
    lower = forearm + PALM * (upper + forearm)
    direction = palm - shoulder
    far = np.clip(np.linalg.norm(direction, axis=1, keepdims=True), 1e-9, upper + lower)
    direction = unit(direction)
    bend = np.einsum("i,tij->tj", _BEND, axes) * share[:, None]
    bend += (elbow - shoulder) / upper * (1 - share[:, None])
    bend = unit(bend - dot(bend, direction) * direction)
    along = (upper**2 - lower**2 + far**2) / (2 * far)
    out = np.sqrt(np.maximum(upper**2 - along**2, 0))
    found = shoulder + along * direction + out * bend
    return found, found + forearm * unit(palm - found)
