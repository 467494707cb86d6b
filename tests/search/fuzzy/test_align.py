"""What a line costs in a track: against every way of choosing symbols for its steps."""

from itertools import combinations

import made_patterns
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lanindex.errors import UsageError
from lanindex.model.columns import PASSING, STARTING, columns_of
from lanindex.search.automaton import plan
from lanindex.search.fuzzy.align import NOTHING, align, cost_of, first_of
from lanindex.search.fuzzy.costs import MOST, UNIT, angles, middles, substitutions
from lanindex.search.fuzzy.net import MISSING, SKIPPED, Net, net_of
from lanindex.search.fuzzy.trace import trace
from lanindex.search.language import parse


def net(text: str) -> Net:
    (program,) = plan(parse(text))
    return net_of(program)


def by_trying_everything(net: Net, costs: list, cells: list[int], most: int) -> list:
    """Return for each row the least cost of a match that ends there, and its latest beginning."""
    later = {before: free for before, _, free in net.edges}
    best: list = [None] * len(cells)
    for count in range(1, len(net.states) + 1):
        for steps in combinations(range(len(net.states)), count):
            for rows in combinations(range(len(cells)), count):
                if any(cells[row] & STARTING for row in range(rows[0] + 1, rows[-1] + 1)):
                    continue
                cost = MISSING * (len(net.states) - count)
                cost += sum(int(costs[a][b]) for a, b in zip(steps, rows, strict=True))
                for one in range(count - 1):
                    between = range(rows[one] + 1, rows[one + 1])
                    if not any(later[step] for step in range(steps[one], steps[one + 1])):
                        cost += SKIPPED * sum(not cells[row] & PASSING for row in between)
                way = (cost, -rows[0])
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
    line = net(text)
    costs = [substitutions(state, 0, columns) for state in line.states]
    keys = align(line, columns, costs, most)
    for begin, end in zip(columns.bounds[:-1].tolist(), columns.bounds[1:].tolist(), strict=True):
        rows = slice(begin, end)
        expected = by_trying_everything(
            line, [own[rows] for own in costs], columns.cell[rows].tolist(), most
        )
        found = [
            None if key == NOTHING else (int(cost_of(key)), begin - int(first_of(key)))
            for key in keys[rows]
        ]
        assert found == expected


@settings(max_examples=100, deadline=None)
@given(made_patterns.bare_lines(), made_patterns.recordings())
def test_the_way_that_is_told_costs_what_was_said(text, recording):
    capture, tracks = recording
    columns = columns_of("r_arm", [capture], [tracks["r_arm"]])
    line = net(text)
    costs = [substitutions(state, 0, columns) for state in line.states]
    shown = columns.cell & PASSING == 0
    for last, key in enumerate(align(line, columns, costs, 3 * UNIT).tolist()):
        if key == NOTHING:
            continue
        first = int(first_of(np.int64(key)))
        rows = slice(first, last + 1)
        told = trace(line, [own[rows].tolist() for own in costs], shown[rows].tolist())
        assert (told[0][0], told[-1][0]) == (0, last - first)
        cost = sum(int(costs[step][first + row]) for row, step in told)
        assert cost + MISSING * (len(line.states) - len(told)) <= cost_of(np.int64(key))


def test_a_match_is_never_cheaper_than_what_fits_exactly_and_never_dearer_than_it_may():
    text = "r_arm right mid -> place high"
    (program,) = plan(parse(text))
    assert net_of(program).entry == (0, MISSING)
    assert net_of(program).exit == (MISSING, 0)


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
    (program,) = plan(parse(f"r_arm {asked}"))
    assert substitutions(program.states[0], 0, columns)[0] == pytest.approx(cost, abs=1)


def test_a_symbol_at_the_border_to_what_is_asked_costs_nothing():
    (program,) = plan(parse("r_arm right mid"))
    costs = [
        substitutions(
            program.states[0],
            0,
            made_patterns.one_symbol("r_arm", "r_forward", "mid", margin, ("right", "mid")),
        )[0]
        for margin in (0.0, 0.5, 1.0)
    ]
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
        "arms high",
        "r_arm low ->[<1s] high",
        "r_arm low ...[2] high",
        "start -> r_arm high",
        "r_arm high -> end",
    ],
)
def test_what_has_no_edits_is_refused_by_name(text):
    (program,) = plan(parse(text))
    with pytest.raises(UsageError, match="cannot count edits") as caught:
        net_of(program)
    assert "--fuzzy" in str(caught.value)


def test_a_line_of_many_steps_is_refused():
    (program,) = plan(parse("r_arm low x1000"))
    with pytest.raises(UsageError, match="1000 steps in a row, wanted 40 at most"):
        net_of(program)
