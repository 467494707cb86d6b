"""The standard body and its directions: symbols of a track to directions over time.

Directions are unit vectors of the body frame: forward +x, up +y, right +z.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINTS, LOW, MID, PLACE
from lanindex.data import shipped
from lanindex.model import Skeleton
from lanindex.model.derived import DEGREE, degree_of

Floats = NDArray[np.float64]
Cell = tuple[int, int]
# Frames in which a part goes from a cell to another, or stays, and the share done, (T,)
Reach = tuple[slice, Cell, Cell, Floats]

FORWARD, UP, RIGHT = np.eye(3)
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
    table = shipped("perform/figure.toml")
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
        name: Limb(tuple(it["bones"]), np.array(it["toward"]), np.array(it["bend"]), it["near"])
        for name, it in table["limbs"].items()
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


def share_done(times: Floats, start: float, stop: float) -> Floats:
    """Return the share done, (T,), with minimum jerk, of what fills a stretch, or has no length."""
    share = (times - start) / max(stop - start, 1e-9)
    return minimum_jerk(np.where(times < stop, np.maximum(share, 0), 1))


def dot(one: Floats, other: Floats) -> Floats:
    """Return products of vectors, (..., 3), as (..., 1)."""
    product: Floats = np.sum(one * other, axis=-1, keepdims=True)
    return product


def unit(vectors: Floats) -> Floats:
    """Return vectors, (..., 3), at length 1."""
    found: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
    return found


def great_circle(start: Floats, stop: Floats, share: Floats, side: Floats = RIGHT) -> Floats:
    """Return directions, (T, 3), on the shorter great circle between two, (3,) or (T, 3).

    Half-way round they pass the front, or `side` from front to back; `share` (T,) is what is done.
    """
    along = dot(start, stop)
    across = stop - along * start
    size = np.linalg.norm(across, axis=-1, keepdims=True)
    front = FORWARD - dot(start, FORWARD) * start
    front = np.where(np.linalg.norm(front, axis=-1, keepdims=True) < 1e-9, side, front)
    across = unit(np.where(size < 1e-9, front, across))
    turn = share[:, None] * np.arctan2(size, along)
    points: Floats = np.cos(turn) * start + np.sin(turn) * across
    return points


def turned(vectors: Floats, left: Floats) -> Floats:
    """Turn vectors, (T, ..., 3), to the left about the vertical by angles, (T, ...), radians.

    The front is +x of the body frame or +z of the stage: the formula is the same.
    """
    sine, cosine = np.sin(left), np.cos(left)
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack((x * cosine + z * sine, y, z * cosine - x * sine), axis=-1)


def reaches(rows: NDArray[Any], times: Floats, rate: Fraction, rest: Cell) -> Iterator[Reach]:
    """Yield the reaches and rests of rows as of `rows_of`, at times (T,) in seconds."""
    now, done = rest, 0
    for row in rows:
        cell = int(row["direction"]), int(row["level"])
        start, stop = float(row["start"] / rate), float(row["stop"] / rate)
        begin, end = np.searchsorted(times, [start - 1e-9, stop - 1e-9])
        yield (slice(done, begin), now, now, np.zeros(begin - done))
        share = (times[begin:end] - start) / (stop - start)
        yield (slice(begin, end), now, cell, minimum_jerk(share))
        now, done = cell, int(end)
    yield (slice(done, len(times)), now, now, np.zeros(len(times) - done))


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
