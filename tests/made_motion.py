"""Motions made up for tests: bones that swing between poses, hold still, tremble and vanish."""

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.model import Motion, Skeleton, Source

Floats = NDArray[np.float64]

RATES = tuple(
    Fraction(rate) for rate in (24, 25, 30, "30000/1001", 50, 60, 100, "120000/1001", 120, 240)
)

BONES = {
    "Chest": ("Pelvis", 300.0),
    "Neck": ("Chest", 220.0),
    "Head": ("Neck", 150.0),
    **{
        side + child: (parent if parent in ("Neck", "Pelvis") else side + parent, length)
        for side in "RL"
        for child, parent, length in (
            ("Shoulder", "Neck", 180.0),
            ("Elbow", "Shoulder", 290.0),
            ("Wrist", "Elbow", 260.0),
            ("Hand", "Wrist", 90.0),
            ("Hip", "Pelvis", 100.0),
            ("Knee", "Hip", 420.0),
            ("Ankle", "Knee", 410.0),
            ("Toe", "Ankle", 130.0),
        )
    },
}
"""Child: parent and length in mm."""


def motion_of(body: Floats, rate: Fraction, first: int = 0) -> Motion:
    """Return a motion whose joints are those of the body model: (T, 20, 3), mm, NaN unknown."""
    seen = ~np.isnan(body).all(axis=(0, 2))
    index = np.where(seen, np.arange(len(JOINTS)), -1).astype(np.int16)
    skeleton = Skeleton(JOINTS, np.full(20, -1, np.int16), np.zeros((20, 3), np.float32), index)
    source = Source("made", "made", "mm", 1.0, "y")
    return Motion(skeleton, rate, body.astype(np.float32), source, first)


def swung(seed: int, frames: int, rate: Fraction, tremble: float) -> Floats:
    """Return (T, 20, 3) float32-exact positions, mm: every bone swings from pose to pose.

    Bones go to directions drawn at random, in 0.1 to 1 s, wait up to 1 s there (some not at
    all), and tremble by noise of a standard deviation of `tremble` mm.
    """
    random = np.random.default_rng(seed)
    seconds = np.arange(frames) / float(rate)
    body = np.zeros((frames, 20, 3))
    body[:, 0] = (0.0, 900.0, 0.0)
    for joint, (parent, length) in BONES.items():
        point = _directions(random, seconds, lively=not joint.endswith("Hip"))
        if joint.endswith("Hip"):
            point[:, 2] += 2.0 if joint[0] == "R" else -2.0
        size = np.linalg.norm(point, axis=1, keepdims=True)
        bone = length * point / np.maximum(size, 1e-6)
        body[:, JOINT_CODES[joint]] = body[:, JOINT_CODES[parent]] + bone
    body += random.normal(0.0, 1.0, body.shape) * tremble
    return body.astype(np.float32).astype(np.float64)


def _directions(random: np.random.Generator, seconds: Floats, *, lively: bool) -> Floats:
    """Return (T, 3) vectors that move smoothly between random ones, with holds between."""
    here = random.normal(0.0, 1.0 if lively else 0.3, 3)
    path = np.tile(here, (len(seconds), 1))
    time = random.uniform(0.0, 0.5)
    while len(seconds) and time < seconds[-1]:
        there = here + random.normal(
            0.0, random.choice([0.1, 0.7, 1.5]) * (1 if lively else 0.2), 3
        )
        share = np.clip((seconds - time) / random.uniform(0.1, 1.0), 0.0, 1.0)[:, None]
        path += (there - here) * share**3 * (10 - 15 * share + 6 * share**2)
        here = there
        time += random.uniform(0.1, 1.0) + random.choice([0.0, random.uniform(0.0, 1.0)])
    return path


def with_gaps(body: Floats, gaps: list[tuple[int, int, int]]) -> Floats:
    """Return the body with joints unknown: (joint, first frame, frames) each."""
    holed = body.copy()
    for joint, start, frames in gaps:
        holed[start : start + frames, joint] = np.nan
    return holed


def body_of(motion: Motion) -> Floats:
    """Return a motion's joints as (T, 20, 3) float64, mm, NaN where there is none."""
    index = motion.skeleton.body
    body = np.asarray(motion.positions[:, index], np.float64)
    body[:, index < 0] = np.nan
    return body
