"""What a line costs in a track: against every way of choosing symbols for its steps."""

from itertools import combinations

import made_patterns
import numpy as np
import pytest
from fuzzy_lines import costs_of, counted_lines, net_of, rows_of, tables_of
from hypothesis import given, settings
from hypothesis import strategies as st

from lanindex.errors import UsageError
from lanindex.model.columns import PASSING, STARTING, columns_of, roster_of
from lanindex.search.automaton import plan
from lanindex.search.fuzzy.align import NOTHING, Stretch, align, blur_of, cost_of, first_of, trace
from lanindex.search.fuzzy.costs import MOST, UNIT, angles, kinds_of, middles
from lanindex.search.fuzzy.lines import Line
from lanindex.search.fuzzy.net import FREE, MISSING, SKIPPED, Net, nets_of
from lanindex.search.fuzzy.windows import wanted
from lanindex.search.language import parse


def ask() -> None:
    """Go on."""


def by_trying_everything(net: Net, costs: list, cells: list, blur: list, most: int) -> list:
    """Return for each row the least cost of a match that ends there, where it begins, its blur."""
    later = {before: free for before, _, free in net.edges}
    best: list = [None] * len(cells)
    for count in range(1, len(net.states) + 1):
        for steps in combinations(range(len(net.states)), count):
            for rows in combinations(range(len(cells)), count):
                if any(cells[row] & STARTING for row in range(rows[0] + 1, rows[-1] + 1)):
                    continue
                pairs = list(zip(steps, rows, strict=True))
                cost = MISSING * (len(net.states) - count)
                cost += sum(int(costs[a][b]) for a, b in pairs)
                for one in range(count - 1):
                    between = range(rows[one] + 1, rows[one + 1])
                    if not any(later[step] for step in range(steps[one], steps[one + 1])):
                        cost += SKIPPED * sum(not cells[row] & PASSING for row in between)
                unclear = max([0, *(blur[b] for a, b in pairs if costs[a][b] == 0)])
                way = (cost, -rows[0], unclear)
                if cost <= most and (best[rows[-1]] is None or way < best[rows[-1]]):
                    best[rows[-1]] = way
    return best


@settings(max_examples=150, deadline=None)
@given(
    made_patterns.bare_lines(),
    st.lists(made_patterns.recordings(), min_size=1, max_size=3),
    st.integers(0, 200),
)
def test_it_is_the_cheapest_of_all_ways(text, recordings, most):
    captures, held = zip(*recordings, strict=True)
    columns = columns_of("r_arm", captures, [tracks["r_arm"] for tracks in held])
    line = net_of(text)
    rows = rows_of(line, columns)
    keys = align(line, rows, most, ask)
    for begin, end in zip(columns.bounds[:-1].tolist(), columns.bounds[1:].tolist(), strict=True):
        own = slice(begin, end)
        cells, blur = columns.cell[own].tolist(), rows.blur[own].tolist()
        expected = by_trying_everything(line, rows.costs[:, own].tolist(), cells, blur, most)
        found = [
            None
            if key == NOTHING
            else (int(cost_of(key)), begin - int(first_of(key)), int(blur_of(key)))
            for key in keys[own]
        ]
        assert found == expected


@settings(max_examples=300, deadline=None)
@given(
    counted_lines(),
    st.lists(made_patterns.recordings(), min_size=1, max_size=3),
    st.integers(0, 300),
)
def test_windows_around_what_a_match_must_have_leave_out_no_match(text, recordings, most):
    captures, held = zip(*recordings, strict=True)
    columns = columns_of("r_arm", captures, [tracks["r_arm"] for tracks in held])
    net, kinds = net_of(text), kinds_of(columns)
    line = Line(net, columns, roster_of(captures), most)
    expected = align(net, rows_of(net, columns), line.most, ask)
    ends = np.flatnonzero(expected != NOTHING)
    expected = expected[ends]
    seeds = kinds.where(wanted(net, list(tables_of(net, columns)), kinds.counts, line.most))
    for rows, whole in (
        (kinds.stretches[:-1], True),
        (np.arange(len(columns)), False),
        (seeds, False),
    ):
        keys, first, last = line.moves(rows, whole, ask)
        assert last.tolist() == ends.tolist()
        assert first.tolist() == first_of(expected).tolist()
        assert cost_of(keys).tolist() == cost_of(expected).tolist()
        assert blur_of(keys).tolist() == blur_of(expected).tolist()


@settings(max_examples=100, deadline=None)
@given(counted_lines(), made_patterns.recordings())
def test_the_way_that_is_told_is_the_one_that_was_found(text, recording):
    capture, tracks = recording
    columns = columns_of("r_arm", [capture], [tracks["r_arm"]])
    line = net_of(text)
    rows = rows_of(line, columns)
    for last, key in enumerate(align(line, rows, 3 * UNIT, ask).tolist()):
        if key == NOTHING:
            continue
        first = int(first_of(np.int64(key)))
        own = slice(first, last + 1)
        ends = list(line.entry[FREE]), list(line.exit[FREE])
        stretch = Stretch(rows.costs[:, own], rows.blur[own], rows.shown[own], *ends)
        told = trace(line, stretch, int(cost_of(np.int64(key))))
        assert (told[0][0], told[-1][0]) == (0, last - first)
        fitting = [row for row, step in told if rows.costs[step][first + row] == 0]
        assert max([0, *rows.blur[own][fitting].tolist()]) == blur_of(np.int64(key))


def test_what_is_missing_before_and_behind_a_step():
    line = net_of("r_arm right mid -> place high")
    assert line.entry[FREE] == (0, MISSING)
    assert line.exit[FREE] == (MISSING, 0)


@pytest.mark.parametrize("steps", [10, 40])
def test_steps_that_may_be_left_out_are_passed_over_once(steps):
    line = net_of("r_arm low" + " -> high?" * (steps - 2) + " -> low")
    assert len(line.edges) == steps * (steps - 1) // 2
    assert len(line.doors) == steps - 1  # one waits for a step, wherever one comes from
    assert len(line.missing(20 * UNIT)) == (steps - 1) * (steps - 2) // 2


def test_missing_steps_are_gone_around_a_circle_once():
    line = net_of("(r_arm low -> mid -> high) x1+")
    assert sorted(line.missing(9 * UNIT)) == [
        *((0, 1, 1), (0, 2, 2), (1, 0, 2), (1, 2, 1), (2, 0, 1), (2, 1, 2)),
    ]


@pytest.mark.parametrize(
    ("asked", "symbol", "cost"),
    [
        ("right mid", ("right", "mid"), 0),
        ("right mid", ("r_forward", "mid"), UNIT / 2),
        ("right mid", ("right", "high"), UNIT / 2),
        ("right mid", ("forward", "mid"), UNIT * 3 / 2),
        ("right mid", ("left", "mid"), MOST),
        ("right", ("right", "low"), 0),
        ("right/forward", ("r_forward", "mid"), UNIT / 2),
        ("place high", ("place", "low"), MOST),
        ("any", ("left", "low"), 0),
        ("place mid", ("right", "mid"), (60 - 22.5) / 45 * UNIT),
    ],
)
def test_a_neighbour_costs_less(asked, symbol, cost):
    columns = made_patterns.one_symbol("r_arm", *symbol)
    assert costs_of(net_of(f"r_arm {asked}"), columns)[0, 0] == pytest.approx(cost, abs=1)


def test_a_symbol_at_the_border_to_what_is_asked_costs_nothing():
    line = net_of("r_arm right mid")
    symbols = [
        made_patterns.one_symbol("r_arm", "r_forward", "mid", margin, ("right", "mid"))
        for margin in (0.0, 0.5, 1.0)
    ]
    costs = [costs_of(line, one)[0, 0] for one in symbols]
    assert costs[0] == 0 < costs[1] < costs[2]


def test_the_middles_are_as_far_apart_as_a_body_sees_them():
    found = angles(middles(), middles())
    assert found.shape == (27, 27)
    assert np.allclose(found, found.T)
    assert np.allclose(np.diag(found), 0)


@pytest.mark.parametrize(
    "text",
    [
        "r_arm low -> (high with l_arm high)",
        "(r_arm low -> high) <2s",
        "r_arm right -> hold",
        "r_arm at high 2s+",
        "r_arm low -> l_arm high",
        "r_arm low ->[<1s] high",
        "r_arm low ...[2] high",
        "start ->[<1s] r_arm high",
        "arms at high",
        "r_arm high overlapping l_arm high",
    ],
)
def test_what_has_no_edits_is_refused_by_name(text):
    (program,) = plan(parse(text))
    with pytest.raises(UsageError, match="cannot count edits") as caught:
        nets_of(program)
    assert "--fuzzy" in str(caught.value)


def test_a_line_of_many_steps_is_refused():
    (program,) = plan(parse("r_arm low x1000"))
    with pytest.raises(UsageError, match="1000 steps in a row, wanted 40 at most"):
        nets_of(program)
