"""Chains of one part, told from planes of all its rows: as the engine tells them otherwise."""

import gc
import weakref
from dataclasses import replace
from random import Random

import numpy as np
import pytest
from both_ways import fast, plain
from fast_search import find_fast, numbered
from random_library import random_library

from lanindex.model.columns import columns_of
from lanindex.search import compiled
from lanindex.search.automaton import plan
from lanindex.search.fast import chains, find, planes
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
    """Captures whose rows fill many words, with gaps and passing symbols; some lack the part."""
    random = Random(5)
    found = [it for _ in range(60) for it in random_library(random)]
    return numbered(found)


def found(text: str, recordings) -> list[tuple]:
    """Return the answers as rows of a table: all that the engine itself tells."""
    hits = find_fast(parse(text), recordings, overlaps="all")
    told = hits._answers.at(hits._chosen)
    columns = (told.capture, told.low, told.high, told.cost, *told.rows.T)
    return list(zip(*(column.tolist() for column in columns), strict=True))


@pytest.mark.parametrize("text", CHAINS)
def test_chains_are_told_as_other_lines_are(text, recordings, monkeypatch):
    assert all(chains.chains_of(program) is not None for program in plan(parse(text)))
    told = found(text, recordings)
    monkeypatch.setattr(find, "chains_of", lambda program: None)
    monkeypatch.setattr(find, "covered", lambda programs: None)
    assert told == found(text, recordings)


def test_an_arrow_that_skips_fewer_than_none_leads_nowhere(recordings):
    assert found("r_arm any ...[<0] any", recordings) == []


def test_the_chains_that_are_tried_do_match(recordings):
    matched = [text for text in CHAINS if found(text, recordings)]
    assert set(CHAINS) - set(matched) == {"r_arm mid x60"}


@pytest.mark.parametrize("count", [0, 1, 63, 64, 65, 500])
def test_a_plane_tells_what_its_mask_does(count):
    mask = np.random.default_rng(count).random(count) < 0.3
    plane = planes.packed(mask)
    where = np.arange(count)
    assert planes.places(plane).tolist() == np.flatnonzero(mask).tolist()
    assert planes.holds(plane, where).tolist() == mask.tolist()
    assert planes.Counted(plane).before(where).tolist() == [int(mask[:it].sum()) for it in where]
    for steps in (0, 1, 63, 64, 130, 700):
        later = np.flatnonzero(mask[steps:])
        assert planes.places(planes.ahead(plane, steps)).tolist() == later.tolist()


@pytest.fixture
def loops(monkeypatch):
    """The compiled loops from the first row on."""
    monkeypatch.setattr(compiled, "chosen", fast)
    assert compiled.loaded("chains")


@pytest.mark.parametrize("text", CHAINS)
def test_compiled_chains_are_told_as_plain_ones_are(text, recordings, loops, monkeypatch):
    told = found(text, recordings)
    monkeypatch.setattr(compiled, "chosen", plain)
    assert told == found(text, recordings)


@pytest.mark.parametrize("text", BESIDE)
def test_a_movement_beside_a_line_is_told_as_other_lines_are(text, recordings, monkeypatch):
    told = []
    for way in (plain, fast):
        monkeypatch.setattr(compiled, "chosen", way)
        told.append(found(text, recordings))
    assert told[0] == told[1] != []


@pytest.mark.parametrize("text", ["r_arm low <1s", "r_arm low -> high"])
def test_a_part_without_rows_has_no_hits(text, recordings, loops):
    without = [
        (capture, {"l_arm": tracks["l_arm"]}) for capture, tracks in recordings if "l_arm" in tracks
    ]
    for _, tracks in without:
        tracks["r_arm"] = replace(
            tracks["l_arm"], part="r_arm", symbols=tracks["l_arm"].symbols[:0]
        )
    assert found(text, without) == []


def test_what_is_known_of_columns_goes_with_them(recordings):
    captures = [capture for capture, _ in recordings]
    columns = columns_of("r_arm", captures, [tracks.get("r_arm") for _, tracks in recordings])
    part = planes.part_of(columns)
    assert planes.part_of(columns) is part
    part = weakref.ref(part)
    gc.disable()
    try:
        del columns
        assert part() is None
    finally:
        gc.enable()
