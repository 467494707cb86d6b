"""The example of search/README.md is what the matcher does."""

import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from query_cases import recordings_of

import lanindex.search
from lanindex.search.explain.english import planned
from lanindex.search.language import parse
from lanindex.search.match.backward import NONE, Backwards, end_of, ending_values
from lanindex.search.match.batch import Batch
from lanindex.search.match.finder import columns_in, find_in
from lanindex.search.match.follow import Transitions
from lanindex.search.plan import plan

PAGE = Path(lanindex.search.__file__).with_name("README.md").read_text(encoding="utf-8")
TRACKS = (
    "fps 10 frames 60; r_arm: place low 0 0, right mid 5 12, place low 20 25, place high 30 36, "
    "right low 40 50; l_arm: place low 0 0, left mid 6 14, place low 22 26, left mid 28 34, "
    "place high 41 49"
)


@pytest.fixture(scope="module")
def recordings():
    return [(it.capture, it.tracks) for it in recordings_of(TRACKS)]


def numbers(begun: str, word: str) -> list[int]:
    """Return the numbers behind a word in the line of the page that begins so."""
    (line,) = (it for it in PAGE.splitlines() if it.strip().startswith(begun))
    return [int(it) for it in re.search(rf"{word} ([\d ]+)", line)[1].split()]


def test_the_arrays_of_the_example(recordings):
    query = parse("r_arm low -> high with l_arm mid")
    assert f"    {query}\n" in PAGE
    assert "".join(f"    {line}\n" for line in planned(query).splitlines()) in PAGE
    (program,) = plan(query)
    batch = Batch(*columns_in(recordings, query.parts), np.arange(1), Fraction(1, 10))
    (beside,) = program.outermost.companions[0].programs
    for begun, state in zip(
        ("state 0: row", "state 1: row", "beside:  row"),
        (*program.states, beside.states[0]),
        strict=True,
    ):
        events = batch.events(state)
        assert numbers(begun, "row") == events.first[0].tolist()
        assert numbers(begun, "start") == events.start.tolist()
        assert numbers(begun, "end") == events.end.tolist()
    before = batch.events(program.states[0])
    transitions = Transitions(batch, program, program.edges[0][0], before)
    table = PAGE[PAGE.index("event of state 0 ") :]
    assert re.search(r"low +([\d ]+)\n", table)[1].split() == list(map(str, transitions.low))
    assert re.search(r"high +([\d ]+)\n", table)[1].split() == list(map(str, transitions.high))
    every = [np.ones(len(batch.events(it)), bool) for it in program.states]
    values = Backwards(batch, program, ending_values(batch, program), every).values
    assert [end_of(it[it < NONE]).tolist() for it in values] == [[36], [36]]
    assert np.flatnonzero(values[0] < NONE).tolist() == [1]
    (hit,) = find_in(recordings, query)
    assert numbers("capture 0", "low") == [hit.span.start]
    assert numbers("capture 0", "high") == [hit.span.stop]
    told = [[(it.part, it.ordinal) for it in line] for line in hit.lines]
    assert told == [[("r_arm", 2), ("r_arm", 3)], [("l_arm", 3)]]


@pytest.mark.parametrize("path", sorted(set(re.findall(r"`([a-z_/]+\.py)`", PAGE))))
def test_the_modules_that_it_names_are_there(path):
    folder = Path(lanindex.search.__file__).parent
    places = (folder, folder / "match", folder.parent, folder.parents[1])
    assert any((it / path).is_file() for it in places)
