"""Every motif has exactly the hits of a search for it."""

from fractions import Fraction
from itertools import pairwise, product

import numpy as np
from effort import examples
from hypothesis import given
from hypothesis import strategies as st
from plain_matcher import find

from lanindex.model import Capture, Span, Track
from lanindex.model.columns import columns_of
from lanindex.model.symbol import blank
from lanindex.search.example.motifs import LONGEST, line_of, motifs, ranked
from lanindex.search.language import parse


@st.composite
def tracks(draw: st.DrawFn) -> Track:
    """Draw one arm between few cells, so that much recurs: some passing, some behind gaps."""
    kinds = draw(st.lists(st.sampled_from("mmmmmpg"), min_size=3, max_size=16))
    rows, time, begins = [], 0, [0]

    def row(kind: str, stop: int) -> None:
        one = blank(())
        cell = draw(st.sampled_from([(8, 0), (8, 2), (0, 1)]))
        one["direction"], one["level"] = cell
        one["start"], one["stop"], one["passing"] = time, stop, kind == "p"
        one["margin"] = 1
        rows.append(one)

    row("m", 0)
    passed = 0  # where what is passed on the way to the next movement ends
    for kind in [*kinds, "m"]:
        if kind == "g" and not passed:
            time += 5
            begins.append(time)
            row("m", time)
            continue
        stop = max(time, passed) + draw(st.integers(1, 9))
        row("p" if kind == "p" else "m", stop)
        time, passed = (time, stop) if kind == "p" else (stop, 0)
    edges = [*begins, time + 1]
    known = tuple(Span(low, high) for low, high in pairwise(edges))
    return Track("r_arm", np.array(rows), known)


def captures(many: list[Track]):
    for number, track in enumerate(many, 1):
        frames = track.known[-1].stop
        yield Capture(number, f"{number}.bvh", "bvh", "", "", Fraction(30), frames), track


def searched(pattern: str, many: list[Track]) -> list[tuple[int, int, int]]:
    recordings = [(capture, {"r_arm": track}) for capture, track in captures(many)]
    hits = find(parse(pattern, ["r_arm"]), recordings, tolerance=Fraction(0), overlaps="none")
    return [(hit.capture.id, hit.start, hit.stop) for hit in hits]


def mined(many: list[Track], least: int = 2, **how):
    owners = [capture for capture, _ in captures(many)]
    columns = columns_of("r_arm", owners, many)
    line = line_of(columns, np.array([capture.id for capture in owners]))
    return motifs("r_arm", line, least=least, shortest=how.pop("shortest", 2), **how)


@examples(60)
@given(st.lists(tracks(), min_size=1, max_size=4))
def test_a_search_for_a_motif_finds_just_its_places(many) -> None:
    for motif in mined(many).found:
        places = [tuple(place) for place in motif.places.tolist()]
        assert searched(motif.pattern, many) == places
        assert (motif.hits, motif.captures) == (len(places), len({one for one, *_ in places}))


@examples(15)
@given(st.lists(tracks(), min_size=1, max_size=3))
def test_none_is_missing_and_none_is_told_beside_a_longer_one(many) -> None:
    hits = {
        cells: len(searched(written(cells), many))
        for steps in (2, 3, 4)
        for cells in product((24, 26, 1), repeat=steps)
    }
    within = {
        shorter
        for cells, count in hits.items()
        for shorter in (cells[1:], cells[:-1])
        if count >= 2 and hits.get(shorter) == count
    }
    wanted = {
        cells: count
        for cells, count in hits.items()
        if count >= 2 and len(cells) < 4 and cells not in within
    }
    assert {motif.cells: motif.hits for motif in mined(many, longest=3).found} == wanted


def written(cells: tuple[int, ...]) -> str:
    names = {24: "place low", 26: "place high", 1: "right mid"}
    return "r_arm " + " -> ".join(names[cell] for cell in cells)


def test_of_what_occurs_as_often_only_the_longest_is_told() -> None:
    many = [repeated("abcd", 3)]
    found = {motif.pattern: motif.hits for motif in mined(many, least=3, shortest=3).found}
    assert "r_arm place high -> right mid -> left mid" not in found
    whole = "r_arm place low -> place high -> right mid -> left mid"
    assert found[whole] == 3


def repeated(word: str, times: int) -> Track:
    cells = {"a": (8, 0), "b": (8, 2), "c": (0, 1), "d": (4, 1)}
    rows = blank(len(word) * times)
    rows["direction"], rows["level"] = zip(*(cells[one] for one in word * times), strict=True)
    rows["stop"] = 10 * np.arange(len(rows))
    rows["start"] = np.maximum(rows["stop"] - 10, 0)
    return Track("r_arm", rows, (Span(0, 10 * len(rows)),))


def test_what_was_not_grown_is_told() -> None:
    many = [repeated("abc", 20) for _ in range(3)]
    assert mined(many).cut == 0
    bounded = mined(many, most=100)
    assert bounded.cut == 2
    assert bounded.found == []
    assert max(len(motif.cells) for motif in mined(many).found) == LONGEST


def test_what_tells_most_of_what_is_left_comes_next() -> None:
    many = [repeated("abab" * 4, 1), repeated("cd" * 3, 1)]
    every = mined(many).found
    found = ranked(every)
    assert set(found[0].cells) == {24, 26}
    assert set(found[1].cells) == {1, 13}
    assert sorted(motif.cells for motif in found) == sorted(motif.cells for motif in every)
