"""The compiled stages against the plain ones: the same rows, byte by byte."""

import itertools
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from effort import seeds, slow
from motions import RATES, motion_of, swung, with_gaps

from lanindex import compiled, formats
from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.encoding import arithmetic, encode
from lanindex.encoding.profile import BUILT_IN, Profile, load
from lanindex.errors import LanindexError
from lanindex.model import Motion

pytest.importorskip("numba")
pytestmark = pytest.mark.slow  # in a fresh tree they compile for most of a minute

GAPS = [(JOINTS.index("RWrist"), 9, 40), (JOINTS.index("LKnee"), 50, 3), (0, 30, 20)]
DIRECTIONS = ["right", "r_forward", "forward", "l_forward", "left", "l_back", "back", "r_back"]
ON_AXES = "high 90\nmid 45 270\nlow 315\nplace 0.5 L\n"
WIDE = "high 120\nmid 60 240\nlow 300\nplace 0\n"


def facts(motion: Motion, profile: Profile) -> object:
    try:
        score = encode(motion, profile)
    except LanindexError as error:
        return str(error)
    tracks = score.tracks.items()
    rows = [(part, track.known, track.symbols.tobytes()) for part, track in tracks]
    return [rows, score.heading.tobytes(), score.meter, score.warnings]


def assert_equal(motion: Motion, profile: Profile, monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for fast in (False, True):
        monkeypatch.setattr(compiled, "chosen", lambda name, size, fast=fast: fast)
        found.append(facts(motion, profile))
    assert found[0] == found[1]


@pytest.fixture(scope="module")
def odd(tmp_path_factory: pytest.TempPathFactory) -> list[Profile]:
    """Return profiles with borders on the axes, and with a direction of more than half a circle."""
    profiles = []
    for name, levels, step in (("axes", ON_AXES, 45), ("wide", WIDE, 10)):
        folder = tmp_path_factory.mktemp(name)
        starts = "".join(f"{word} {step * at}\n" for at, word in enumerate(DIRECTIONS))
        (folder / "all.lpd").write_text(levels + starts)
        (folder / "all.ldd").write_text((BUILT_IN / "default" / "all.ldd").read_text())
        told = (BUILT_IN / "default" / "profile.toml").read_text()
        (folder / "profile.toml").write_text(told.replace('"83 ms"', '"0 ms"'))
        profiles.append(load(folder))
    return profiles


def on_borders() -> Motion:
    """Return a motion whose limbs point along axes and diagonals, to the last bit."""
    ways = np.array(list(itertools.product((-1, 0, 1), repeat=3)), float)
    body = np.zeros((len(ways) * 12, 20, 3))
    body[:, JOINT_CODES["RHip"], 0], body[:, JOINT_CODES["LHip"], 0] = -100, 100
    for shift, name in enumerate(("RWrist", "LWrist", "Head", "RAnkle", "LAnkle")):
        body[:, JOINT_CODES[name]] = 256 * np.roll(ways, 5 * shift, axis=0).repeat(12, axis=0)
    return motion_of(body, Fraction(60))


@pytest.mark.parametrize("profile", ["default", "paper"])
@pytest.mark.parametrize("seed", seeds(20))
def test_made_motions(monkeypatch: pytest.MonkeyPatch, seed: int, profile: str) -> None:
    rate = RATES[seed % len(RATES)]
    body = swung(seed, (1, 3, 90, 400)[seed % 4], rate, (0.0, 0.5, 5.0)[seed % 3])
    body = with_gaps(body, GAPS) if seed % 2 else body
    assert_equal(motion_of(body, rate), load(profile), monkeypatch)


def test_what_lies_on_a_border(monkeypatch: pytest.MonkeyPatch, odd: list[Profile]) -> None:
    for profile in (*odd, load("default")):
        assert_equal(on_borders(), profile, monkeypatch)
        made = motion_of(swung(4, 300, Fraction(60), 0.2), Fraction(60))
        assert_equal(made, profile, monkeypatch)


def test_blocks_leave_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arithmetic, "BLOCK", 7)
    motion = motion_of(swung(3, 100, Fraction(24), 5.0), Fraction(24))
    assert_equal(motion, load("default"), monkeypatch)


@pytest.mark.parametrize("profile", ["default", "paper"])
def test_real_captures(captures: Path, monkeypatch: pytest.MonkeyPatch, profile: str) -> None:
    families: dict[Path, list[Path]] = {}
    for path in sorted(captures.rglob("*")):
        if path.suffix.lower() in (".bvh", ".c3d", ".trc", ".amc"):
            families.setdefault(path.parent, []).append(path)
    read = 0
    for path in itertools.chain(*(family[:: 1 if slow() else 12] for family in families.values())):
        try:
            motion = formats.read(path)
        except LanindexError:
            continue
        assert_equal(motion, load(profile), monkeypatch)
        read += 1
    assert read > (300 if slow() else 35)
