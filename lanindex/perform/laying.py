"""Where trunk, head and arms of the standard body point while it rests on something else than feet.

Source: ``encode/BODY.md``, "Other supports", read backwards.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lanindex.model import Score
from lanindex.perform.figure import Body
from lanindex.perform.resting import LIES, Pose, Resting, Tells, slerp, way

Floats = NDArray[np.float64]

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

    Parameters
    ----------
    score : Score
        What is to be carried out: what begins meanwhile is done as it is told.
    resting : Resting
        When something else than feet carries.
    times : ndarray
        (T,) seconds.
    hips : ndarray
        (T,) how high they are, mm.
    bones : dict of str to ndarray
        (T, 3) where they point as told.
    body : Body
        Who carries it out.
    """
    rests, doubts = resting.rests, dict[str, None]()
    tells = Tells(score)
    leans = [tells(rest, "torso", "torso_incline") for rest in rests]
    aims = [
        None if it.pose.trunk is None or lean else way(it.pose.trunk)
        for it, lean in zip(rests, leans, strict=True)
    ]
    found = {"torso": resting.blended(bones["torso"], aims, slerp)}
    neck = hips + _along(body, "Neck") * found["torso"][:, 1]
    for rest, lean in zip(rests, leans, strict=True):
        if (
            lean
            and rest.what == "trunk"
            and neck[rest.middle(times)] > hips[rest.middle(times)] * 2
        ):
            doubts[f"torso goes as told at {rest.start:g} s and does not lie"] = None
    if bones["head"] is bones["torso"]:
        found["head"] = found["torso"]
    up = hips + _along(body, "RightShoulder") * found["torso"][:, 1]
    for side in "rl":
        names = [f"{side}_{it}" for it in ARM]
        own = [bones[it] for it in names]
        arms = list[tuple[Floats | None, ...]]()
        for rest in rests:
            middle, pose = rest.middle(times), rest.pose
            told = tells(rest, f"{side}_arm", *names)
            sinks = up[middle] + _lowest(own, middle, body) < 0
            moves = sinks or (pose.arms is None and not told)
            arms.append(_arm(pose, float(up[middle]), body) if moves else (None,) * len(ARM))
            if told and pose.arms is None:
                doubts[f"{side}_arm goes as told at {rest.start:g} s and does not prop"] = None
            elif pose.arms is None and up[middle] > sum(_sizes(body)[:2]) * (1 + LIES):
                doubts[f"{side}_hand does not reach the floor at {rest.start:g} s"] = None
            elif told and sinks:
                doubts[f"{side}_arm would go through the floor at {rest.start:g} s"] = None
        for name, base, those in zip(names, own, zip(*arms, strict=True), strict=True):
            found[name] = resting.blended(base, those, slerp)
    return found, tuple(doubts)


def _arm(pose: Pose, shoulder: float, body: Body) -> tuple[Floats, Floats, Floats]:
    """Return where the bones of an arm point that rests, or props the body."""
    if pose.arms is not None:
        return (way(pose.arms),) * 3
    sizes = _sizes(body)
    cosine = min((shoulder - LIES * sum(sizes[:2])) / sum(sizes[:2]), 1.0)
    reach = way(float(np.degrees(np.arccos(cosine))))
    return reach, reach, way(90.0)


def _lowest(own: Sequence[Floats], frame: int, body: Body) -> float:
    """Return how far below its shoulder an arm ends, mm."""
    return sum(size * min(float(it[frame, 1]), 0.0)
               for it, size in zip(own, _sizes(body), strict=True))  # fmt: skip


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
