"""Lines with a limit on their whole length."""

from random import Random

import numpy as np
import pytest
from fast_search import find_fast, numbered, told
from plain_matcher import find
from random_library import random_library

from lanindex.model.columns import columns_of, roster_of
from lanindex.search.language import parse
from lanindex.search.match import batch

LIMITED = (
    "(r_arm low ... high -> low) <4s",
    "((r_arm low -> any) <=0.8s) <3s",
    "(r_arm low ... high or r_arm mid ... low) <1s",
    "(arms any ... any) <=0.6s",
    "(r_arm any -> l_arm any) <6f",
    "start -> (r_arm any ... any) <0.5s",
    "(r_arm via any -> any) <0.5s",
    "(r_arm low ... high) >1s",
    "(r_arm low ... high) 1s",
    "(r_arm low x1+) <2s",
    "(r_arm low -> high) <1s ... low",
    "(r_arm low -> high) <1s x2",
    "(r_arm low with l_arm high) <2s",
    "(r_arm low -> high) <2s with l_arm any",
    "((r_arm low -> high) <1s or r_arm mid) <2s",
    "r_arm low <2s",
)


@pytest.fixture(scope="module")
def recordings():
    random = Random(11)
    return numbered([it for _ in range(30) for it in random_library(random)])


@pytest.mark.parametrize("text", LIMITED)
@pytest.mark.parametrize("overlaps", ["all", "none"])
def test_a_line_of_limited_length_is_found_as_plainly(text, overlaps, recordings):
    wanted = told(find(parse(text), recordings, overlaps=overlaps))
    assert told(find_fast(parse(text), recordings, overlaps=overlaps)) == wanted != []


def test_blocks_of_a_small_library_are_smaller(recordings, monkeypatch):
    captures = [capture for capture, _ in recordings]
    columns = columns_of("r_arm", captures, [tracks.get("r_arm") for _, tracks in recordings])
    places = np.arange(len(roster_of(captures)))

    def largest(most: int) -> int:
        split = batch.split([columns], places, most)
        assert np.concatenate(split).tolist() == places.tolist()
        return max(columns.bounds[it[-1] + 1] - columns.bounds[it[0]] for it in split)

    longest = np.diff(columns.bounds).max()
    monkeypatch.setattr(batch, "FEWEST_ROWS", 10)
    monkeypatch.setattr(batch, "LARGE", len(columns))
    assert 40 < largest(80) < 80 + longest
    monkeypatch.setattr(batch, "LARGE", 4 * len(columns))
    assert largest(80) < 20 + longest
    assert largest(8) < 8 + longest  # never more than is asked for
