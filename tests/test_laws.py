"""The laws of encoding/METHOD.md on a few real captures; tests/benchmarks/laws.py takes all."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path

import motions
import pytest
from effort import examples, thinned
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from motions import RATES, motion_of, swung

from lanindex.encoding import encode
from lanindex.encoding.profile import Profile, load
from lanindex.formats import read
from lanindex.model import Motion, Score

FEW = (
    "bandai1/dataset-1_punch_normal_001.bvh",
    "bandai2/wave-both-hands/dataset-2_wave-both-hands_feminine_*.bvh",
    "bandai2/walk-turn-left/dataset-2_walk-turn-left_active_*.bvh",
    "mae_openni/swipe/*.bvh",
    "rokoko/*.bvh",
    "cmu_retargeted/*.bvh",
    "xsens/*.bvh",
)
FAST = ("cmu_daz/*.bvh", "cmu_cgspeed/cmu_12_01_walk.bvh", "xia_style/*.bvh", "sfu_moda/*.bvh")
SLOW = ("bandai2/*/*_normal_*.bvh", "bandai1/*.bvh")
PROFILES = ("default", "paper")
CHANGES: dict[str, Callable[[Motion], Motion]] = {
    "turned": lambda motion: motions.turned(motion, 37),
    "turned back": lambda motion: motions.turned(motion, 180),
    "moved": lambda motion: motions.moved(motion, (512, -64, 256)),
}
IMAGES: dict[str, tuple[Callable[[Motion], Motion], Callable[[Score], dict]]] = {
    **{name: (change, motions.rows) for name, change in CHANGES.items()},
    "mirrored": (motions.mirrored, motions.mirrored_rows),
}


def read_all(captures: Path, names: tuple[str, ...]) -> list[Motion]:
    found = [read(path) for name in names for path in sorted(captures.glob("bvh/" + name))]
    assert len(found) >= len(names), "captures are missing"
    return found


@pytest.fixture(scope="module")
def few(captures: Path) -> list[Motion]:
    return read_all(captures, FEW)


@pytest.fixture(scope="module")
def fast(captures: Path) -> list[Motion]:
    found = read_all(captures, FAST)
    assert all(110 < motion.rate < 130 for motion in found)
    return found


@pytest.fixture(scope="module")
def slow(captures: Path) -> list[Motion]:
    found = read_all(captures, SLOW)
    assert all(29 < motion.rate < 31 for motion in found)
    return found


def differing(
    found: list[Motion],
    profile: Profile,
    change: Callable[[Motion], Motion],
    image: Callable[[Score], dict],
) -> list[str]:
    return [
        f"{part} of {motion.source.path}"
        for motion in found
        for part in motions.changed_tracks(
            image(encode(motion, profile)), motions.rows(encode(change(motion), profile))
        )
    ]


@pytest.mark.parametrize(("law", "profile"), thinned(product(IMAGES, PROFILES), 3))
def test_place_heading_and_side_change_nothing(few: list[Motion], law: str, profile: str) -> None:
    assert differing(few, load(profile), *IMAGES[law]) == []


@pytest.mark.parametrize("factor", [0.5, 1.7])
def test_size_changes_nothing(few: list[Motion], factor: float) -> None:
    profile = load("default")
    change = partial(motions.scaled, factor=factor)
    assert differing(few, profile, change, motions.rows) == []


def test_size_matters_in_millimetres(few: list[Motion]) -> None:
    change = partial(motions.scaled, factor=0.5)
    assert differing(few, load("paper"), change, motions.rows)


@pytest.mark.parametrize("law", IMAGES)
@settings(examples(15), derandomize=True, phases=(Phase.explicit, Phase.generate))
@given(
    seed=st.integers(0, 2**32),
    rate=st.sampled_from(RATES),
    frames=st.integers(1, 300),
    profile=st.sampled_from(PROFILES),
)
def test_laws_hold_for_made_motions(law: str, seed: int, rate, frames: int, profile: str) -> None:
    motion = motion_of(swung(seed, frames, rate, 0.5), rate)
    change, image = IMAGES[law]
    before, after = image(encode(motion, profile)), motions.rows(encode(change(motion), profile))
    assert motions.changed_tracks(before, after) == []


def agreement(
    found: list[Motion], profile: Profile, change: Callable[[Motion], Motion]
) -> tuple[float, float]:
    """Return the share of limb tracks that agree, and the edits a symbol of them all."""
    counts = []
    for motion in found:
        before, after = encode(motion, profile), encode(change(motion), profile)
        counts += [motions.edits(before, after, part) for part in motions.LIMBS]
    agree = sum(wrong == 0 for wrong, _ in counts) / len(counts)
    return agree, sum(wrong for wrong, _ in counts) / sum(size for _, size in counts)


@pytest.mark.parametrize("step", [2, 4])
def test_fewer_frames_a_second_change_little(fast: list[Motion], step: int) -> None:
    agree, wrong = agreement(fast, load("default"), lambda motion: motions.thinned(motion, step))
    assert agree >= 0.85
    assert wrong <= 0.015


@pytest.mark.slow
def test_noise_of_1_mm_changes_little(slow: list[Motion]) -> None:
    _, wrong = agreement(slow, load("default"), lambda motion: motions.noisy(motion, 1.0))
    assert 0 < wrong <= 0.035


@pytest.mark.slow
def test_noise_of_2_mm_changes_little_when_smoothed(slow: list[Motion]) -> None:
    calm = replace(load("default"), smoothing=0.150)
    _, wrong = agreement(slow, calm, lambda motion: motions.noisy(motion, 2.0))
    assert 0 < wrong <= 0.04
