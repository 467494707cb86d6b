"""The legs of the standard body: where their bones point whose feet stand somewhere.

Source: ``encode/BODY.md``, read backwards. Places over the ground are forward and right of where
the body began.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.perform.figure import Body
from lanindex.perform.reach import UP
from lanindex.perform.resting import LIES, Rest, above

Floats = NDArray[np.float64]

LIFTED = 0.05
"""Lengths of a leg above the floor: a foot so high goes wherever the knee takes it."""

HEIGHTS = 70
"""Hundredths of a leg in which the height is looked for at which a body rests."""

SITS = 0.12
"""Lengths of a leg above the floor: so high are hips that sit."""

TOES = 64.0
"""Millimetres from the toe's joint to its tip."""

SIDES = "rl"


@dataclass(frozen=True, slots=True)
class Size:
    """How long a leg is, where the toe is seen from the ankle, how high that stands; mm."""

    leg: float
    toe: Floats
    ankle: float

    @classmethod
    def of(cls, body: Body) -> Size:
        """Return the sizes of a body."""
        toe = bone(body, "RToe")
        bones = (bone(body, f"R{joint}") for joint in ("Knee", "Ankle"))
        return cls(sum(float(np.linalg.norm(it)) for it in bones), toe, body.sole - float(toe[1]))


@dataclass(frozen=True, slots=True, eq=False)
class Stand:
    """Where feet are, frame by frame; all but `over` in lengths of a leg."""

    # (T, 2) mm, by side: where the ankle is over the ground while the heel is down
    over: dict[str, Floats]
    raised: dict[str, Floats]  # (T,) how high
    heels: dict[str, Floats]  # (T,) how high the heel is raised
    knees: dict[str, Floats]  # (T, 3) unit vectors of the body frame: where the knee goes
    high: Floats  # (T,) how high the body flies

    def at(self, frame: int, count: int) -> Stand:
        """Return one frame so many times."""
        some = np.full(count, frame)
        over, raised, heels, knees = (
            {side: it[some] for side, it in one.items()}
            for one in (self.over, self.raised, self.heels, self.knees)
        )
        return Stand(over, raised, heels, knees, self.high[some])


def leg_to(
    side: str, hips: Floats, front: Floats, stand: Stand, reach: Floats, body: Body
) -> dict[str, Floats]:
    """Return where the bones of a leg point whose foot is there, (T, 3)."""
    size, joint, ahead = Size.of(body), hip(body, side), toward(front + np.pi / 2)
    foot_size, raised = float(np.linalg.norm(size.toe)), stand.raised[side]
    back = size.leg * stand.heels[side] - size.toe[1]
    back = np.sqrt(foot_size**2 - np.minimum(back, 0.99 * foot_size) ** 2)
    tip = stand.over[side] + size.toe[0] * ahead  # the toe stays where the heel cannot
    heel = tip - back[:, None] * ahead
    height = size.ankle + size.leg * (raised + stand.heels[side])
    target = np.stack((heel[:, 0], height, heel[:, 1]), axis=1)
    way = (turned(target - hips, -front) - joint) / size.leg
    far, free = np.linalg.norm(way, axis=1), np.clip((raised - stand.high) / LIFTED, 0, 1)
    way *= (1 - free * np.maximum(1 - reach / np.maximum(far, 1e-9), 0))[:, None]
    thigh, shank = _bent(way, stand.knees[side])
    point = np.stack((tip[:, 0], body.sole + size.leg * raised, tip[:, 1]), axis=1)
    foot = turned(point - hips, -front) - joint - size.leg / 2 * (thigh + shank)
    foot /= np.linalg.norm(foot, axis=1, keepdims=True)
    toes = above(foot, (body.sole + size.leg * raised) / TOES)
    return {
        f"{side}_thigh": thigh,
        f"{side}_shank": shank,
        f"{side}_foot": foot,
        f"{side}_toes": toes,
    }


def lying_height(
    rest: Rest, times: Floats, hips: Floats, front: Floats, stand: Stand, body: Body
) -> float:
    """Return how high the hips of a body are that rests: the lower knee lies on the floor."""
    leg = Size.of(body).leg
    if rest.pose.up is not None:
        return leg * rest.pose.up
    frame = min(int(np.searchsorted(times, min(rest.stop, rest.rise[0]))), len(times) - 1)
    heights = leg * np.arange(HEIGHTS) / 100
    there = np.tile(hips[frame], (HEIGHTS, 1))
    there[:, 1] = heights
    some, ahead = stand.at(frame, HEIGHTS), np.full(HEIGHTS, front[frame])
    knees = [
        heights
        + leg / 2 * leg_to(side, there, ahead, some, np.ones(HEIGHTS), body)[f"{side}_thigh"][:, 1]
        for side in SIDES
    ]
    sunk = np.flatnonzero(np.minimum(*knees) < LIES * leg)
    if not len(sunk):  # knees that stand up carry nothing
        return leg * SITS
    return float(heights[min(sunk[-1] + 1, HEIGHTS - 1)])


def _bent(way: Floats, knees: Floats) -> tuple[Floats, Floats]:
    """Return where thigh and shank point for an ankle to lie there, (T, 3) lengths of the leg."""
    reach = np.linalg.norm(way, axis=1, keepdims=True)
    along = way / np.maximum(reach, 1e-9)
    reach = np.minimum(reach, 1.0)
    aside = knees - np.sum(along * knees, axis=1, keepdims=True) * along
    size = np.linalg.norm(aside, axis=1, keepdims=True)
    aside = np.where(size > 1e-6, aside / np.maximum(size, 1e-6), UP)
    bow = np.sqrt(np.maximum(1 - reach**2, 0)) * aside
    return reach * along + bow, reach * along - bow


def bone(body: Body, joint: str) -> Floats:
    """Return the offset of a joint of the body model, in the body frame at rest, mm."""
    x, y, z = body.skeleton.offsets[body.skeleton.body[JOINT_CODES[joint]]].astype(float)
    return np.array([z, y, -x])


def hip(body: Body, side: str) -> Floats:
    """Return where a hip is seen from the root, in the body frame at rest, mm."""
    return bone(body, f"{side.upper()}Hip")


def toward(azimuth: Any) -> Floats:
    """Return directions over the ground, (..., 2): forward, right; 0 is right, 90 forward."""
    return np.stack((np.sin(azimuth), np.cos(azimuth)), axis=-1)


def turned(vectors: Floats, left: Floats) -> Floats:
    """Turn vectors, (T, 3), to the left about the vertical by (T,) radians."""
    sine, cosine = np.sin(left), np.cos(left)
    forward, right = vectors[:, 0], vectors[:, 2]
    turned = (forward * cosine + right * sine, vectors[:, 1], right * cosine - forward * sine)
    return np.stack(turned, axis=1)
