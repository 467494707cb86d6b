"""Chains of one part, told from planes of all its rows: as the engine tells them otherwise."""

import gc
import sys
import weakref
from dataclasses import replace
from random import Random

import numpy as np
import pytest
from fast_search import find_fast, numbered
from random_library import random_library

from lanindex.model.columns import columns_of
from lanindex.search.automaton import plan
from lanindex.search.fast import alone, chains, find, planes
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
    "r_arm low ... mid -> high ... low",
    "r_arm low ... via mid ... high",
    "r_arm mid x60",
)


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
def compiled(monkeypatch):
    """The compiled loops from the first row on."""
    monkeypatch.setattr(planes, "WORTH", 0)
    assert planes.compiled(0)


@pytest.mark.parametrize("text", CHAINS)
def test_compiled_chains_are_told_as_plain_ones_are(text, recordings, compiled, monkeypatch):
    told = found(text, recordings)
    monkeypatch.setattr(planes, "compiled", lambda rows: None)
    monkeypatch.setattr(chains, "compiled", lambda rows: None)
    assert told == found(text, recordings)


LINES = (
    "r_arm at low",
    "r_arm low -> at high 2f+",
    "r_arm low <4f -> hold",
    "r_arm hold low -> any ... any",
    "r_arm at low -> not low -> hold -> low",
    "r_arm low ...[<1s] high",
    "r_arm low ->[>2f] high",
    "r_arm any ...[>2] via high ...[<3f] mid",
    "r_arm low ...[1s] at not high",
    "r_arm rising x2+",
    "r_arm rising <6f -> low x1..3",
    "r_arm low ... (high -> low) x2+",
    "r_arm low -> hold? -> high x0+ ... at mid <1s",
    "arm low <0.5s either side",
    "r_arm via high 3f",
)


@pytest.mark.parametrize("text", LINES)
def test_compiled_lines_are_told_as_plain_ones_are(text, recordings, compiled, monkeypatch):
    assert all(alone.alone_of(it, {}) for it in plan(parse(text)))
    told = found(text, recordings)
    assert told
    monkeypatch.setattr(find, "alone_of", lambda program, columns: None)
    assert told == found(text, recordings)


@pytest.mark.parametrize("text", ["r_arm low <1s", "r_arm low -> high"])
def test_a_part_without_rows_has_no_hits(text, recordings, compiled):
    without = [
        (capture, {"l_arm": tracks["l_arm"]}) for capture, tracks in recordings if "l_arm" in tracks
    ]
    for _, tracks in without:
        tracks["r_arm"] = replace(
            tracks["l_arm"], part="r_arm", symbols=tracks["l_arm"].symbols[:0]
        )
    assert found(text, without) == []


@pytest.mark.parametrize(
    "text",
    [
        "start -> r_arm at low",
        "r_arm low x1+ -> end",
        "r_arm low <1s -> l_arm low",
        "arms low <1s",
        "(r_arm low -> high) <1s",
        "r_arm via low -> high <1s",
        "r_arm low with l_arm low",
    ],
)
def test_what_is_no_plain_line_of_one_part_is_not_walked_row_by_row(text, compiled):
    assert not any(alone.alone_of(it, {}) for it in plan(parse(text)))


def test_small_searches_do_not_load_what_is_compiled(monkeypatch):
    monkeypatch.setattr(planes, "_gone", 0)
    monkeypatch.delitem(sys.modules, planes._FAST, raising=False)
    assert planes.compiled(planes.WORTH - 1) is None
    assert planes.compiled(1) is not None


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
