"""Where trunk, head and arms of the standard body point while it rests on something else than feet.

Source: ``encode/BODY.md``, "Other supports", read backwards.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lanindex.model import Score
from lanindex.perform.figure import Body
from lanindex.perform.resting import LIES, Resting, Tells, above, slerp, way

Floats = NDArray[np.float64]

LEVEL = 0.7
"""The sine of half a right angle: what is lower lies; the cosine of two that differ by more."""

FLESH = 10.0
"""Millimetres above the floor: lower goes no joint of an arm."""

ARM = ("upper_arm", "forearm", "hand")


def laid(
    score: Score,
    resting: Resting,
    times: Floats,
    hips: Floats,
    bones: dict[str, Floats],
    body: Body,
) -> tuple[dict[str, Floats], tuple[str, ...]]:
    """Return where trunk, head and arms point of a body that rests, and what cannot be.

    `times`: (T,) seconds; `hips`: (T,) how high they are, mm; `bones`: (T, 3) where they point as
    told.
    """
    rests, doubts = resting.rests, dict[str, None]()
    tells, middles = Tells(score), [rest.middle(times) for rest in rests]
    aims = list[Floats | None]()
    for rest, middle in zip(rests, middles, strict=True):
        pose, lean = rest.pose, bones["torso"][middle]
        told = tells(rest, "torso", "torso_incline")
        suits = abs(lean[1]) < LEVEL or (pose.props and lean[0] > LEVEL)
        aims.append(None if pose.trunk is None or told or suits else way(pose.trunk))
        if pose.trunk is not None and told and not suits:
            doubts[f"torso goes as told at {rest.start:g} s: {rest.what} may not carry"] = None
    found = {"torso": resting.blended(bones["torso"], aims, slerp)}
    if bones["head"] is bones["torso"]:
        found["head"] = found["torso"]
    up, sizes = hips + _along(body, "RightShoulder") * found["torso"][:, 1], _sizes(body)
    for side in "rl":
        names = [f"{side}_{it}" for it in ARM]
        touches = (f"{side}_hand_touch", "hands_touch")
        told_of = [
            tells(it, f"{side}_arm", *names, *(touches if it.pose.props else ())) for it in rests
        ]
        reaches = list[list[Floats | None]]()
        for rest, middle, told in zip(rests, middles, told_of, strict=True):
            props = rest.pose.props and not told
            reaches.append([*_reach(float(up[middle]), sizes)] if props else [None] * len(ARM))
            if rest.pose.props and (told or up[middle] > (1 + 2 * LIES) * sum(sizes[:2])):
                doubts[f"{side}_hand does not prop at {rest.start:g} s: it goes as told"] = None
        high, lies = up, resting.done > 0
        for number, (name, size) in enumerate(zip(names, sizes, strict=True)):
            ways = resting.blended(bones[name], [it[number] for it in reaches], slerp)
            ways[lies] = above(ways[lies], (high[lies] - FLESH) / size)
            found[name], high = ways, high + size * ways[:, 1]
        for rest, middle, told in zip(rests, middles, told_of, strict=True):
            if told and any(
                float(found[it][middle] @ bones[it][middle]) < LEVEL for it in names[:2]
            ):
                doubts[f"{side}_arm would go through the floor at {rest.start:g} s"] = None
    return found, tuple(doubts)


def _reach(shoulder: float, sizes: Sequence[float]) -> tuple[Floats, Floats, Floats]:
    """Return where the bones of an arm point whose hand is on the floor."""
    arm = sum(sizes[:2])
    way_down = way(float(np.degrees(np.arccos(min(max(shoulder / arm - LIES, 0), 1)))))
    return way_down, way_down, way(90.0)


def _sizes(body: Body) -> tuple[float, float, float]:
    """Return how long upper arm, forearm and hand are, mm."""
    found = dict.fromkeys(ARM, 0.0)
    for name, offset in zip(body.bones, body.skeleton.offsets, strict=True):
        if name.startswith("r_") and name[2:] in found:
            found[name[2:]] += float(np.linalg.norm(offset))
    return found["upper_arm"], found["forearm"], found["hand"]


def _along(body: Body, name: str) -> float:
    """Return how far along the trunk a joint lies, mm."""
    found, joint = 0.0, body.skeleton.names.index(name)
    while joint > 0:
        found += float(body.skeleton.offsets[joint][1])
        joint = int(body.skeleton.parents[joint])
    return found
