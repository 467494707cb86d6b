"""The body by its shape alone: for skeletons whose joints are called J1, J2, J3.

Two limbs are a pair if they leave the trunk at one joint and have equal bones. The pair with the
longest two bones in a row is the legs, the next one the arms; the trunk between goes on to neck
and head. Feet point forward (else knees do), and that tells left from right.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from lanindex.capture.skeleton import Rig, near_hips

_ALIKE = 0.12  # how much the bones of two sides may differ
_THINNEST = 0.1  # of a limb's longest bone: shorter ones are no thigh or forearm
_CLEAR = 0.1  # mean cosine: how far forward feet or knees must show


@dataclass(frozen=True, slots=True)
class _Limb:
    """The two longest bones in a row of a branch.

    Attributes
    ----------
    top : int
        The first joint of the branch.
    joints : tuple of int
        Where the two bones begin, meet and end: hip, knee, ankle.
    bones : tuple of float
        Their lengths.
    """

    top: int
    joints: tuple[int, int, int]
    bones: tuple[float, float]


_Pair = tuple[_Limb, _Limb]


def by_shape(rig: Rig) -> tuple[dict[str, int], tuple[str, ...]]:
    """Find the body by bones and poses.

    Parameters
    ----------
    rig : Rig
        The skeleton.

    Returns
    -------
    tuple of dict and tuple of str
        Joint of the body → joint of the rig, as far as they were found; and doubts.
    """
    pairs = sorted(_pairs(rig), key=lambda pair: -sum(pair[0].bones + pair[1].bones))
    if not pairs:
        return {}, ()
    legs = pairs[0]
    inside = _inside(rig, legs)
    arms = next((pair for pair in pairs[1:] if not inside & {pair[0].top, pair[1].top}), None)
    body: dict[str, int] = {}
    _limbs(rig, legs, ("Hip", "Knee", "Ankle", "Toe"), body)
    if arms is not None:
        _limbs(rig, arms, ("Shoulder", "Elbow", "Wrist", "Hand"), body)
    _trunk(rig, legs, arms, body)
    return _sided(rig, body)


def _pairs(rig: Rig) -> list[_Pair]:
    """Return all pairs of branches with equal bones."""
    found = []
    for children in rig.below:
        limbs = [limb for child in children if (limb := _limb(rig, child)) is not None]
        for one, other in combinations(limbs, 2):
            if all(
                abs(a - b) <= _ALIKE * max(a, b)
                for a, b in zip(one.bones, other.bones, strict=True)
            ):
                found.append((one, other))
    return found


def _limb(rig: Rig, top: int) -> _Limb | None:
    """Return the two longest bones in a row, where a branch has two."""
    chain = _chain(rig, top)
    lengths = [rig.bones[joint] for joint in chain]
    best = max(range(1, len(chain) - 1), key=lambda k: lengths[k] + lengths[k + 1], default=None)
    if best is None or min(lengths[best : best + 2]) < _THINNEST * max(lengths):
        return None
    first, middle, last = chain[best - 1 : best + 2]
    return _Limb(top, (first, middle, last), (lengths[best], lengths[best + 1]))


def _chain(rig: Rig, top: int) -> list[int]:
    """Return the joints of the longest branch, those in one place with the one before left out."""
    chain = [top]
    while rig.below[chain[-1]]:
        joint = chain[-1]
        while rig.below[joint]:
            joint = max(rig.below[joint], key=rig.reach.__getitem__)
            if rig.bones[joint] > rig.nothing:
                break
        if rig.bones[joint] <= rig.nothing:
            break
        chain.append(joint)
    return chain


def _inside(rig: Rig, pair: _Pair) -> set[int]:
    """Return all joints of two branches."""
    inside = {pair[0].top, pair[1].top}
    for joint, parent in enumerate(rig.parents):
        if parent in inside:
            inside.add(joint)
    return inside


def _limbs(rig: Rig, pair: _Pair, names: tuple[str, str, str, str], body: dict[str, int]) -> None:
    for side, limb in zip("RL", pair, strict=True):
        body |= {side + name: joint for name, joint in zip(names, limb.joints, strict=False)}
        tip = rig.longest_branch(limb.joints[-1])
        if tip is not None:
            body[side + names[-1]] = tip


def _trunk(rig: Rig, legs: _Pair, arms: _Pair | None, body: dict[str, int]) -> None:
    """Find pelvis, chest, neck and head."""
    pelvis = rig.parents[legs[0].top]
    if near_hips(rig, pelvis, body):
        body["Pelvis"] = pelvis
    if arms is None:
        return
    chest = rig.parents[arms[0].top]
    if chest not in rig.above(pelvis):
        body["Chest"] = chest
    limbs = {limb.top for limb in (*legs, *arms)}
    towards = set(rig.above(pelvis))
    free = [child for child in rig.below[chest] if child not in limbs and child not in towards]
    if not free:
        return
    neck = _chain(rig, max(free, key=rig.reach.__getitem__))
    if rig.bones[neck[0]] <= rig.nothing and len(neck) > 1:
        neck = neck[1:]
    head = next((k for k, joint in enumerate(neck) if len(rig.below[joint]) > 1), None)
    if head is None:  # the last but one: behind it comes the tip of the head
        head = max(len(neck) - 2, 0)
    body["Neck"] = neck[0]
    body["Head"] = neck[head] if head > 0 else neck[-1]
    if len(neck) == 1:
        del body["Neck"]


def _sided(rig: Rig, body: dict[str, int]) -> tuple[dict[str, int], tuple[str, ...]]:
    """Exchange right and left where the body faces the other way."""
    poses = rig.poses
    ankles = (poses[:, body["RAnkle"]] + poses[:, body["LAnkle"]]) / 2
    top = body.get("Neck", body.get("Chest", body.get("Pelvis", body["RHip"])))
    up = (poses[:, top] - ankles).mean(axis=0)
    legs = _forward(poses, body, up, "Hip", "Toe" if {"RToe", "LToe"} <= body.keys() else "Knee")
    doubts = () if abs(legs) > _CLEAR else ("which side is left could not be told for certain",)
    if legs < 0:
        body = {_other(joint): index for joint, index in body.items()}
    if {"RShoulder", "LShoulder"} <= body.keys():
        across = poses[:, body["RHip"]] - poses[:, body["LHip"]]
        arms = poses[:, body["RShoulder"]] - poses[:, body["LShoulder"]]
        if (across * arms).sum() < 0:
            body = {_other(j) if j[1:] in _ARM else j: index for j, index in body.items()}
    return body, doubts


_ARM = ("Shoulder", "Elbow", "Wrist", "Hand")


def _other(joint: str) -> str:
    paired = joint[0] in "RL" and joint[1:2].isupper()
    return {"R": "L", "L": "R"}[joint[0]] + joint[1:] if paired else joint


def _forward(
    poses: NDArray[np.float64], body: dict[str, int], up: NDArray[np.float64], base: str, tip: str
) -> float:
    """Return the mean cosine between where the hips say forward is, and where a limb points."""
    across = poses[:, body["R" + base]] - poses[:, body["L" + base]]
    forward = np.cross(up, across)
    if tip == "Toe":
        points = sum(poses[:, body[s + "Toe"]] - poses[:, body[s + "Ankle"]] for s in "RL")
    else:
        points = sum(
            2 * poses[:, body[s + "Knee"]] - poses[:, body[s + "Hip"]] - poses[:, body[s + "Ankle"]]
            for s in "RL"
        )
    points = np.asarray(points) - np.outer(np.asarray(points) @ up, up) / (up @ up)
    sizes = np.linalg.norm(forward, axis=1) * np.linalg.norm(points, axis=1)
    cosines = (forward * points).sum(axis=1) / np.where(sizes > 0, sizes, 1.0)
    return float(cosines.mean())
