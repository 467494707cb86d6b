"""A capture encoded part by part and in small blocks gives the same score, bit for bit."""

import subprocess
import sys
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from effort import thinned
from motions import motion_of, swung, with_gaps

from lanindex.alphabet import JOINTS
from lanindex.encoding import arithmetic, encode, joints, limbs, places
from lanindex.encoding.limbs import heading
from lanindex.encoding.profile import load
from lanindex.model import Score

GAPS = [(JOINTS.index("RWrist"), 9, 40), (JOINTS.index("LKnee"), 50, 3), (0, 30, 20)]


def facts(score: Score) -> list[object]:
    tracks = score.tracks.items()
    rows = [(part, track.known, track.symbols.tobytes()) for part, track in tracks]
    return [rows, score.heading.tobytes(), score.meter]


KEPT = [(0, 0), (2000, 0), (1 << 20, 50), (1 << 20, 1 << 20)]


@pytest.mark.parametrize(
    ("rate", "profile", "block", "keeps"),
    thinned(product([24, 60, 120], ["default", "paper"], [5, 64], KEPT), 5),
)
def test_blocks_leave_no_trace(
    monkeypatch: pytest.MonkeyPatch, rate: int, profile: str, block: int, keeps: tuple[int, int]
) -> None:
    motion = motion_of(with_gaps(swung(3, 100, Fraction(rate), 5.0), GAPS), Fraction(rate))
    whole = facts(encode(motion, profile))
    monkeypatch.setattr(arithmetic, "BLOCK", block)
    monkeypatch.setattr(joints, "TOGETHER", 3 * len(motion))
    monkeypatch.setattr("lanindex.encoding.whole.TOGETHER", block)
    monkeypatch.setattr("lanindex.encoding.timing.TOGETHER", block)
    monkeypatch.setattr("lanindex.encoding.measures.FEW", block)
    monkeypatch.setattr(joints, "KEPT", keeps[0])
    monkeypatch.setattr(places, "KEPT", keeps[1])
    assert facts(encode(motion, profile)) == whole


FEW, MANY = 300_000, 900_000
"""Frames: what is held at a time, whatever the length, hides what is held for each of fewer."""


@pytest.mark.slow
@pytest.mark.parametrize(("way", "most"), [("plain", 300), ("fast", 370)])
def test_memory_of_a_long_capture_grows_by_little_a_frame(way: str, most: int) -> None:
    if way == "fast":
        pytest.importorskip("numba")
        measured(way, 1000)  # compiles, which takes more memory than the short one
    # 240 bytes a frame are those of the body itself
    assert measured(way, MANY) - measured(way, FEW) <= most * (MANY - FEW)


def measured(way: str, frames: int) -> int:
    """Return the bytes that a process holds at most which makes a long capture and encodes it."""
    words = [sys.executable, "-c", LONG, way, str(frames)]
    done = subprocess.run(words, capture_output=True, text=True, check=True, cwd=TESTS)
    return int(done.stdout)


LONG = """
import resource, sys
from fractions import Fraction
import numpy as np
from motions import motion_of, swung
from lanindex import compiled
from lanindex.encoding import encode
from lanindex.model import Motion
way, frames = sys.argv[1], int(sys.argv[2])
compiled.chosen = lambda name, size: way == "fast"
some = motion_of(swung(3, 3000, Fraction(60), 5.0), Fraction(60))
encode(some)
positions = np.empty((frames, *some.positions.shape[1:]), np.float32)
for start in range(0, frames, len(some)):
    positions[start : start + len(some)] = some.positions[: frames - start]
encode(Motion(some.skeleton, some.rate, positions, some.source))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)
"""
TESTS = Path(__file__).parents[1]


def test_a_few_parts_at_a_time_are_all_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    motion, profile = motion_of(swung(5, 60, Fraction(60), 0.0), Fraction(60)), load("default")
    body = joints.Body(motion, profile)
    turn = heading(motion, profile.rate)
    (together,) = limbs.limbs(body, turn)
    monkeypatch.setattr(joints, "TOGETHER", 1)
    alone = list(limbs.limbs(body, turn))
    assert [one.parts for one in alone] == [(part,) for part in together.parts]
    assert all(
        np.array_equal(one.curve[0], curve)
        for one, curve in zip(alone, together.curve, strict=True)
    )
