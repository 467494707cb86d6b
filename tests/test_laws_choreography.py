"""METHOD's law: a performed choreography is encoded as the same symbols.

Neighbouring symbols are less than 60 degrees apart: a longer reach passes through other cells.
"""

from dataclasses import replace

import numpy as np
import pytest
from choreography import CELLS, FRAMES, choreography, shown, spoken
from effort import examples
from hypothesis import given
from hypothesis import strategies as st

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.encoding import encode
from lanindex.encoding.profile import Profile, load
from lanindex.model import Score
from lanindex.notation import lnd
from lanindex.perform import perform

LIMBS = ("r_arm", "l_arm", "r_leg", "l_leg")
PARTS = ("r_upper_arm", "r_forearm", "l_hand", "l_thigh", "l_shank", "r_foot", "head", "torso")


def profile(smoothing: float | None) -> Profile:
    loaded = load("default")
    return replace(loaded, smoothing=smoothing) if smoothing else loaded


def again(score: Score, noise: float = 0.0, smoothing: float | None = None) -> Score:
    return encode(perform(score, rate=FRAMES, noise=noise), profile(smoothing))


@pytest.mark.parametrize(("noise", "smoothing"), [(0, None), (2, None), (2, 0.15)])
@given(seed=st.integers(0, 2**32 - 1))
@examples(12)
def test_limbs_come_back_symbol_for_symbol(
    noise: float, smoothing: float | None, seed: int
) -> None:
    score = choreography(seed, LIMBS)
    heard = again(score, noise, smoothing)
    for part in LIMBS:
        assert spoken(heard, part) == spoken(score, part)


@given(seed=st.integers(0, 2**32 - 1))
@examples(12)
def test_every_part_comes_back_symbol_for_symbol(seed: int) -> None:
    score = choreography(seed, PARTS)
    heard = again(score)
    for part in PARTS:
        assert spoken(heard, part) == spoken(score, part)


@pytest.mark.parametrize(("noise", "smoothing", "frames"), [(0, None, 3), (2, 0.15, 8)])
def test_starts_and_ends_come_back(noise: float, smoothing: float | None, frames: int) -> None:
    """At p95 of 12 scores, 384 symbols."""
    late: dict[str, list[np.ndarray]] = {"start": [], "stop": []}
    for seed in range(12):
        score = choreography(seed, LIMBS)
        heard = again(score, noise, smoothing)
        for part in LIMBS:
            for edge, errors in late.items():
                wanted, found = (shown(one, part)[1:][edge] for one in (score, heard))
                errors.append(np.abs(found.astype(int) - wanted))
    for errors in late.values():
        assert np.percentile(np.concatenate(errors), 95) <= frames


@pytest.mark.parametrize("part", ["r_arm", "l_leg"])
@pytest.mark.parametrize("cell", CELLS)
def test_a_folded_limb_comes_back(part: str, cell: tuple[int, int]) -> None:
    name = f"{DIRECTIONS[cell[0]]} {LEVELS[cell[1]]}"
    score = lnd.read(
        f"#unit0\ndirection {part} {name} 0 0\n"
        f"#unit1\ndirection {part} place mid 0.5 1.5\ndirection {part} {name} 2.5 3.5\n"
    )
    assert spoken(again(score), part) == [name, "place mid", name]
