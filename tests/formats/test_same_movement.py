"""One movement in two formats gives the same positions, times and symbols."""

from dataclasses import replace
from difflib import SequenceMatcher

import numpy as np
import pytest

import lanindex
from lanindex.model import Motion, Score

PAIRS = (  # BVH, what was derived of it, and from which of its frames on
    ("bvh/cmu_cgspeed/01_01.bvh", "npz/derived_cmu_01_01_joints22.npz", 1),
    ("bvh/cmu_cgspeed/cmu_12_01_walk.bvh", "npz/derived_cmu_12_01_walk_joints22.npy", 1),
    ("bvh/cmu_cgspeed/cmu_12_01_walk.bvh", "csv/derived_cmu_12_01_walk_joints.csv", 1),
    ("bvh/rokoko/jesse_dance.bvh", "npz/derived_rokoko_dance_joints22.npy", 0),
)


def thinned(motion: Motion, like: Motion, first: int) -> Motion:
    """Return a motion at the times of one with fewer frames."""
    frames = np.round(np.arange(len(like)) * float(motion.rate / like.rate)).astype(int) + first
    places = motion.positions[frames[frames < len(motion)]]
    return replace(motion, positions=places, rate=like.rate, first=0, rotations=None, axes={})


def alike(one: Score, other: Score) -> float:
    """Return which share of the symbols of shared parts is equal, part by part."""
    rows = [
        {part: [] for part in {symbol.part for symbol in score.symbols()}} for score in (one, other)
    ]
    for score, parts in zip((one, other), rows, strict=True):
        for symbol in score.symbols():
            parts[symbol.part].append((symbol.direction, symbol.level, symbol.passing))
    shared = rows[0].keys() & rows[1].keys()
    pairs = [(rows[0][part], rows[1][part]) for part in shared]
    equal = sum(
        block.size
        for a, b in pairs
        for block in SequenceMatcher(None, a, b, autojunk=False).get_matching_blocks()
    )
    return equal / sum(max(len(a), len(b)) for a, b in pairs)


@pytest.mark.parametrize(("bvh", "derived", "first"), PAIRS, ids=lambda name: str(name))
def test_joints_and_symbols(captures, bvh, derived, first):
    whole, found = lanindex.read(captures / bvh), lanindex.read(captures / derived)
    same = thinned(whole, found, first)
    plays = [motion.skeleton.played() for motion in (same, found)]
    joints = [name for name in plays[0] if name in plays[1]]
    assert len(joints) == 18
    one, other = (
        motion.positions[:, [motion.skeleton.names.index(play[name]) for name in joints]]
        for motion, play in zip((same, found), plays, strict=True)
    )
    hip = joints.index("RHip")  # the derived files stand elsewhere
    one, other = one - one[:, [hip]], other[: len(one)] - other[: len(one), [hip]]
    assert np.linalg.norm(one - other, axis=2).max() < 1.0
    score = lanindex.encode(found)
    assert alike(lanindex.encode(same), score) > 0.995
    assert alike(lanindex.encode(whole), score) >= 0.95  # fewer frames, other borders
