"""The fast encoding against its slow twin (tests/plain.py), field by field."""

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import plain
import plain_segment
import pytest
from effort import examples, seeds, thinned
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from motions import RATES, body_of, motion_of, swung, with_gaps

from lanindex.alphabet import ALWAYS, JOINTS
from lanindex.encoding import encode, trace
from lanindex.encoding.profile import BUILT_IN
from lanindex.encoding.written import candidates
from lanindex.errors import EncodeError
from lanindex.formats import read
from lanindex.model import Motion, Symbol

ODD_NUMBERS = """name = "odd"
rate = 50
smoothing = "150 ms"
candidate_speed = "2 L/s"
prominence = "30 mm/s"
still = "0.05 L/s"
distance = "70 mm"
path_check = 1.5
achieved_within = 35
onset = 0.1
speed = 90
rhythm = "3/4"
division = 24
"""
ODD_CELLS = """place 120
right 330
r_forward 30
forward 60
l_forward 120
left 150
l_back 200
back 250
r_back 290
high 100
mid 70 260
low 290
"""
LEVELS = ("low", "mid", "high")
ODD_RULES = "".join(
    f"#rule_start\n{rows}#rule_end\n"
    for rows in (
        *(f"L {d} mid\nD {d} high\n" for d in ("right", "left", "forward", "back")),
        *(f"D {d} low\nL place low\n" for d in ("r_forward", "l_back", "right", "left")),
        *(f"L place mid\nD place {level}\nD place mid\n" for level in ("low", "high")),
        *(f"L {d} low\nD {d} mid\nL {d} low\n" for d in ("right", "l_forward", "back")),
        *(f"L right {a}\nD r_forward {a}\nL right {a}\n" for a in LEVELS),
    )
)
QUICK = settings(examples(15), derandomize=True, phases=(Phase.explicit, Phase.generate))
RARE_RATES = (*RATES, Fraction(10), Fraction(12))
PROFILES = ("default", "paper", "odd")


@dataclass(frozen=True)
class Recipe:
    """What a made-up motion is made of; short enough to be printed when a test fails."""

    seed: int
    rate: Fraction
    frames: int
    tremble: float
    gaps: list[tuple[int, int, int]]
    absent: list[int]
    first: int

    def motion(self) -> Motion:
        body = swung(self.seed, self.frames, self.rate, self.tremble)
        body = with_gaps(body, self.gaps)
        body[:, self.absent] = np.nan
        return motion_of(body, self.rate, min(self.first, self.frames - 1))


joints = st.integers(0, len(JOINTS) - 1)
frames = st.integers(0, 200)
recipes = st.builds(
    Recipe,
    seed=st.integers(0, 2**32),
    rate=st.sampled_from(RARE_RATES),
    # not two: a straight line, in which rounding alone tells one speed from the next
    frames=st.one_of(st.just(1), st.integers(3, 5), st.integers(6, 200)),
    tremble=st.sampled_from([0.0, 0.1, 1.0, 5.0]),
    gaps=st.one_of(
        st.just([]), st.lists(st.tuples(joints, frames, st.integers(1, 60)), max_size=6)
    ),
    absent=st.one_of(st.just([]), st.lists(joints, max_size=2)),
    first=st.integers(0, 1),
)


@pytest.fixture(scope="session")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the folders of the built-in profiles and of an odd one."""
    odd = tmp_path_factory.mktemp("profile")
    (odd / "profile.toml").write_text(ODD_NUMBERS)
    (odd / "all.lpd").write_text(ODD_CELLS)
    (odd / "all.ldd").write_text(ODD_RULES)
    return {"default": BUILT_IN / "default", "paper": BUILT_IN / "paper", "odd": odd}


def as_plain(symbol: Symbol, rule: int) -> dict[str, Any]:
    return {
        "direction": symbol.direction,
        "level": symbol.level,
        "start": symbol.span.start,
        "stop": symbol.span.stop,
        "passing": symbol.passing,
        "rule": rule,
        "swings": symbol.swings,
        "margin": pytest.approx(symbol.margin, abs=5.1e-4),  # told in thousandths,
        "runner": symbol.runner_up,
    }


def assert_twins(motion: Motion, folder: Path) -> None:
    slow = plain.encode_plain(body_of(motion), motion.rate, folder, motion.first)
    try:
        every = encode(motion, folder).tracks
    except EncodeError:
        every = {}
    tracks = {part: track for part, track in every.items() if part in ALWAYS}
    assert set(tracks) == set(slow)
    for part, track in tracks.items():
        rules = track.symbols["rule"].tolist()
        fast = [as_plain(*pair) for pair in zip(track.listed(), rules, strict=True)]
        assert slow[part] == fast, f"{part} of {motion}"


@pytest.mark.parametrize("profile", PROFILES)
@QUICK
@given(recipe=recipes)
def test_made_motions_read_alike(folders: dict[str, Path], profile: str, recipe: Recipe) -> None:
    assert_twins(recipe.motion(), folders[profile])


@pytest.mark.parametrize(("rate", "longer"), thinned(product(RARE_RATES, [0, 1]), 3))
def test_gaps_of_a_fifth_of_a_second_read_alike(
    folders: dict[str, Path], rate: Fraction, longer: int
) -> None:
    gap = math.floor(rate / 5) + longer
    body = with_gaps(swung(7, 2 * gap + 20, rate, 0.0), [(JOINTS.index("RWrist"), 9, gap)])
    motion = motion_of(body, rate)
    assert len(encode(motion).tracks["r_arm"].known) == 1 + longer
    assert_twins(motion, folders["default"])


@pytest.mark.parametrize("seed", seeds(30))
def test_more_symbols_than_frames_read_alike(folders: dict[str, Path], seed: int) -> None:
    rate = Fraction(3 + seed % 3)
    assert_twins(motion_of(swung(seed, 4 + seed % 5, rate, 50.0), rate), folders["paper"])


@pytest.mark.slow
@pytest.mark.parametrize("profile", PROFILES)
@examples(100)
@given(recipe=recipes)
def test_many_made_motions_read_alike(
    folders: dict[str, Path], profile: str, recipe: Recipe
) -> None:
    assert_twins(recipe.motion(), folders[profile])


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize(
    "name",
    [
        "bandai2/run/dataset-2_run_elderly_011.bvh",
        "bandai2/raise-up-right-hand/dataset-2_raise-up-right-hand_elderly_006.bvh",
        "xia_style/angry_13_000.bvh",
        "pybvh/standard_skeleton.bvh",
    ],
)
def test_real_captures_read_alike(
    captures: Path, folders: dict[str, Path], profile: str, name: str
) -> None:
    assert_twins(read(captures / "bvh" / name), folders[profile])


@pytest.mark.slow
@pytest.mark.parametrize("profile", PROFILES)
def test_all_real_captures_read_alike(
    captures: Path, folders: dict[str, Path], profile: str
) -> None:
    files = sorted(captures.glob("bvh/**/*.bvh"))
    assert files
    for file in files:
        assert_twins(read(file), folders[profile])


@pytest.mark.parametrize("profile", PROFILES)
@QUICK
@given(recipe=recipes, part=st.sampled_from(sorted(ALWAYS)))
def test_every_stage_is_alike(
    folders: dict[str, Path], profile: str, recipe: Recipe, part: str
) -> None:
    motion = recipe.motion()
    stages = plain.stages_plain(
        body_of(motion), motion.rate, folders[profile], motion.first, [part]
    )
    if part not in stages:
        return
    found = trace(motion, part, folders[profile])
    assert len(found) == len(stages[part])
    for fast, slow in zip(found, stages[part], strict=True):
        assert (fast.begin, fast.known.start, fast.known.stop) == (slow.offset, *slow.source)
        np.testing.assert_allclose(fast.curve, slow.curve, atol=1e-6)
        np.testing.assert_allclose(fast.speed, slow.speed, atol=1e-5)
        assert fast.candidates.tolist() == slow.candidates
        assert [(hold.first, hold.last) for hold in fast.holds] == slow.holds
        assert [(s.first, s.last, s.begin, s.end) for s in fast.segments] == [
            (s.start, s.stop, s.begins, s.ends) for s in slow.segments
        ]
        runs = [[(run.start, run.stop - 1) for run in move] for move in fast.runs]
        assert runs == [[(run.first, run.last) for run in move] for move in slow.runs]


@given(
    speed=arrays(np.float64, st.integers(1, 30), elements=st.integers(0, 6)),
    slow=st.integers(2, 6),
    prominence=st.integers(0, 4),
    still=st.integers(0, 2),
)
def test_candidates_agree_on_ties_and_plateaus(
    speed: np.ndarray, slow: int, prominence: int, still: int
) -> None:
    fast = candidates(speed, slow, prominence, still).tolist()
    assert fast == plain_segment.candidates(speed.tolist(), slow, prominence, still)
