"""Lines of linked steps, alone and simultaneous, in long captures."""

from dataclasses import replace
from random import Random

import pytest
from fast_search import find_fast, numbered, told
from plain_matcher import ties
from random_library import random_library

from lanindex.search.language import parse

CHAINS = (
    "r_arm low -> high",
    "r_arm mid -> high -> low",
    "r_arm via high",
    "r_arm low -> via high",
    "r_arm low -> rising? -> not high",
    "r_arm sinking -> sinking",
    "r_arm not rising -> high",
    "r_arm any -> any? -> mid? -> any",
    "r_arm low ...[<=3] high",
    "r_arm low ...[>1] high -> mid",
    "r_arm low ...[<=2] mid ...[<=1] high",
    "r_arm low ...[<40] high",
    "r_arm low ...[1] via high",
    "r_arm mid ...[1] mid -> low",
    "r_arm low ... mid -> high ... low",
    "r_arm low ... via mid ... high",
    "r_arm mid x60",
)

BESIDE = (
    "r_arm low with l_arm high",
    "r_arm low -> high with l_arm any",
    "r_arm any -> any with l_arm via high",
    "r_arm low -> mid? -> any with arm low",
    "r_arm mid -> any -> high with l_arm high/low",
    "l_arm any? -> low with r_arm not high",
)
"""Lines beside which one movement stands."""


@pytest.fixture(scope="module")
def recordings():
    """Captures with gaps and passing symbols; some lack the part."""
    random = Random(5)
    found = [it for _ in range(60) for it in random_library(random)]
    return numbered(found)


@pytest.mark.parametrize("text", [*CHAINS, *BESIDE])
def test_linked_movements_are_found_as_the_plain_matcher_finds_them(text, recordings):
    query = parse(text)
    found = told(find_fast(query, recordings, overlaps="all"))
    assert found == told(hits[0] for hits in ties(query, recordings, overlaps="all"))
    assert bool(found) == (text != "r_arm mid x60")


def test_an_arrow_that_skips_fewer_than_none_leads_nowhere(recordings):
    assert not len(find_fast(parse("r_arm any ...[<0] any"), recordings))


@pytest.mark.parametrize("text", ["r_arm low <1s", "r_arm low -> high"])
def test_a_part_without_rows_has_no_hits(text, recordings):
    without = [
        (capture, {"l_arm": tracks["l_arm"]}) for capture, tracks in recordings if "l_arm" in tracks
    ]
    for _, tracks in without:
        tracks["r_arm"] = replace(
            tracks["l_arm"], part="r_arm", symbols=tracks["l_arm"].symbols[:0]
        )
    assert not len(find_fast(parse(text), without))
