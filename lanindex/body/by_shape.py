"""The body by its shape alone: for skeletons whose joints are called J1, J2, J3.

Two limbs are a pair if they leave the trunk at one joint and have equal bones. The pair with the
longest two bones in a row is the legs, the next one the arms; the trunk between goes on to neck
and head. Feet point forward (else knees do), and that tells left from right, unless the names of
the limbs do.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import nlargest
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from lanindex.body.by_name import keys
from lanindex.body.rig import Rig, near_hips

_ALIKE = 0.3  # how much the bones of two sides may differ
_THINNEST = 0.1  # of a limb's longest bone: shorter ones are no thigh or forearm
_BRANCHES = 12  # looked at where more leave one joint
_LONGEST = 60  # joints of a branch looked at
_EQUAL = 0.86  # of the longest two bones in a row
_CLEAR = 0.2  # mean cosine: how far forward feet or knees must show
_ARM = ("Shoulder", "Elbow", "Wrist", "Hand")


@dataclass(frozen=True, slots=True)
class _Limb:
    """The two longest bones in a row of a branch."""

    top: int  # The first joint of the branch
    joints: tuple[int, int, int]  # Where the two bones begin, meet and end: hip, knee, ankle
    bones: tuple[float, float]  # Their lengths


Poses = NDArray[np.float64]
_Pair = tuple[_Limb, _Limb]


def by_shape(rig: Rig) -> tuple[dict[str, int], tuple[str, ...]]:
    """Find the body by bones and poses."""
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
        if len(children) < 2:
            continue
        longest = nlargest(_BRANCHES, children, key=rig.extent.__getitem__)
        limbs = [limb for child in longest if (limb := _limb(rig, child)) is not None]
        for one, other in combinations(limbs, 2):
            if all(
                abs(a - b) <= _ALIKE * max(a, b)
                for a, b in zip(one.bones, other.bones, strict=True)
            ):
                found.append((one, other))
    return found


def _limb(rig: Rig, top: int) -> _Limb | None:
    """Return the two longest bones in a row, where a branch has two; of equals the outer ones."""
    chain = _chain(rig, top)
    lengths = [rig.bones[joint] for joint in chain]
    sums = [one + two for one, two in pairwise(lengths[1:])]
    if not sums:
        return None
    best = max(k for k, length in enumerate(sums, 1) if length >= _EQUAL * max(sums))
    if min(lengths[best : best + 2]) < _THINNEST * max(lengths):
        return None
    first, middle, last = chain[best - 1 : best + 2]
    return _Limb(top, (first, middle, last), (lengths[best], lengths[best + 1]))


def _chain(rig: Rig, top: int) -> list[int]:
    """Return the joints of the longest branch, those in one place with the one before left out."""
    chain = [top]
    while rig.below[chain[-1]] and len(chain) < _LONGEST:
        joint = chain[-1]
        while rig.below[joint]:
            joint = max(rig.below[joint], key=rig.extent.__getitem__)
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
        inner = limb.joints[-2] if names[-1] == "Toe" else None
        tip = rig.tip(limb.joints[-1], inner=inner)
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
    if chest not in rig.above(body.get("Pelvis", -1)):
        body["Chest"] = chest
    limbs = {limb.top for limb in (*legs, *arms)}
    towards = set(rig.above(pelvis))
    free = [child for child in rig.below[chest] if child not in limbs and child not in towards]
    if not free:
        return
    neck = _chain(rig, max(free, key=rig.extent.__getitem__))
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
    if {"RShoulder", "LShoulder"} <= body.keys():
        hips, arms = _across(poses, body, "Hip"), _across(poses, body, "Shoulder")
        if (hips * arms).sum() < 0:
            body = {_other(j) if j[1:] in _ARM else j: index for j, index in body.items()}
    forward = _named(rig, body) or _forward(poses, body, up)
    if forward < 0:
        body = {_other(joint): index for joint, index in body.items()}
    doubt = "which side is left could not be told for certain"
    return body, () if abs(forward) > _CLEAR else (doubt,)


def _named(rig: Rig, body: dict[str, int]) -> int:
    """Return 1 where names tell the same sides, -1: the other ones, 0: they do not tell them."""
    sides = [side for side, _ in keys(rig.names)]
    told = [sides[index] == joint[0] for joint, index in body.items()
            if _other(joint) != joint and sides[index]]  # fmt: skip
    return 0 if len(told) < 4 else 1 if all(told) else 0 if any(told) else -1


def _other(joint: str) -> str:
    paired = joint[0] in "RL" and joint[1:2].isupper()
    return {"R": "L", "L": "R"}[joint[0]] + joint[1:] if paired else joint


def _across(poses: Poses, body: dict[str, int], joint: str) -> Poses:
    return poses[:, body["R" + joint]] - poses[:, body["L" + joint]]


def _forward(poses: Poses, body: dict[str, int], up: Poses) -> float:
    """Return how far forward (1) or backward (-1) feet point; without feet, knees and hands."""
    forward = np.cross(up, _across(poses, body, "Hip"))
    at = {joint: poses[:, index] for joint, index in body.items()}
    if {"RToe", "LToe"} <= body.keys():
        points = [at[s + "Toe"] - at[s + "Ankle"] for s in "RL"]
    else:
        points = [2 * at[s + "Knee"] - at[s + "Hip"] - at[s + "Ankle"] for s in "RL"]
        points += [at[s + "Wrist"] - at[s + "Shoulder"] for s in "RL" if s + "Wrist" in body]
    total = np.sum(points, axis=0)
    total -= np.outer(total @ up, up) / (up @ up)
    sizes = np.linalg.norm(forward, axis=1) * np.linalg.norm(total, axis=1)
    return float((forward * total).sum() / max(sizes.sum(), 1e-12))
