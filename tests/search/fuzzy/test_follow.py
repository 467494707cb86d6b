"""The cost of a line in a track, against every choice of symbols for its steps."""

from itertools import combinations, pairwise

import generated_patterns
import numpy as np
import pytest
from effort import examples
from fuzzy_lines import batch_of, counted_lines, keys_of, net_of
from hypothesis import assume, given
from hypothesis import strategies as st

from lanindex.errors import UsageError
from lanindex.model.columns import PASSING, STARTING, columns_of
from lanindex.search.fuzzy import (
    BETWEEN,
    BLUR,
    COST,
    FIRST,
    FREE,
    LATEST,
    MISSING,
    MOST,
    MOST_STEPS,
    SKIPPED,
    UNIT,
    FuzzyLine,
    Net,
    angles,
    nets_of,
    on_the_way,
)
from lanindex.search.language import parse
from lanindex.search.plan import plan
from lanindex.search.sphere import CELLS, MIDDLES


def told(key: int, most: int) -> tuple[int, int, int] | None:
    """Return cost, first row and blur of a match; None: there is none."""
    if key >> COST > most:
        return None
    return key >> COST, LATEST - (key >> FIRST & LATEST), key & BLUR


def cost_of(net: Net, costs: list, cells: list, way: list[tuple[int, int]]) -> int:
    """Return what a match costs of which some steps, by number, stand at some rows."""
    later, joined = net.edges[0, 1].any(axis=1), net.edges[0].any(axis=0)
    between = on_the_way(net.states, joined)
    cost = MISSING * (len(net.states) - len(way)) + sum(int(costs[a][b]) for a, b in way)
    for (step, row), (next_step, next_row) in pairwise(way):
        if not later[step:next_step].any():
            cost += SKIPPED * sum(not cells[it] & PASSING for it in range(row + 1, next_row))
        if next_step > step + 1 and between[next_step - 2, next_step - 1, next_step]:
            cost += BETWEEN - MISSING
    return cost


def by_trying_everything(net: Net, costs: list, cells: list, blur: list, most: int) -> list:
    """Return for each row the least cost of a match that ends there, where it begins, its blur."""
    best: list = [None] * len(cells)
    for count in range(1, len(net.states) + 1):
        for steps in combinations(range(len(net.states)), count):
            for rows in combinations(range(len(cells)), count):
                if any(cells[row] & STARTING for row in range(rows[0] + 1, rows[-1] + 1)):
                    continue
                pairs = list(zip(steps, rows, strict=True))
                cost = cost_of(net, costs, cells, pairs)
                unclear = max([0, *(blur[b] for a, b in pairs if costs[a][b] == 0)])
                way = (cost, -rows[0], unclear)
                if cost <= most and (best[rows[-1]] is None or way < best[rows[-1]]):
                    best[rows[-1]] = way
    return best


@examples(150)
@given(
    generated_patterns.bare_lines(),
    st.lists(generated_patterns.recordings(), min_size=1, max_size=3),
    st.integers(0, 200),
)
def test_it_is_the_cheapest_of_all_ways(text, recordings, most):
    captures, held = zip(*recordings, strict=True)
    columns = columns_of("r_arm", captures, [tracks["r_arm"] for tracks in held])
    net, batch = net_of(text), batch_of(columns, captures)
    line = FuzzyLine(net, columns, most)
    keys, costs = keys_of(line, batch, line._most)
    unclear = batch.rows("r_arm").cost
    for capture, (begin, end) in enumerate(pairwise(columns.bounds.tolist())):
        own = slice(begin, end)
        cells, blur = columns.cell[own].tolist(), unclear[own].tolist()
        expected = by_trying_everything(net, costs[:, own].tolist(), cells, blur, most)
        found = [told(key, most) for key in keys[own].tolist()]
        found = [it and (it[0], begin - it[1], it[2]) for it in found]
        assert found == expected
        for last, (cost, first, _) in ((last, it) for last, it in enumerate(found) if it):
            told_rows = line.rows(batch, capture, -first, last)
            way = [(step, row) for row, step in told_rows]
            assert cost_of(net, costs[:, own].tolist(), cells, way) == cost


@examples(150)
@given(
    counted_lines(),
    st.lists(generated_patterns.recordings(), min_size=1, max_size=3),
    st.integers(0, 300),
)
def test_an_open_count_goes_on_as_often_as_there_are_symbols(text, recordings, most):
    captures, held = zip(*recordings, strict=True)
    columns = columns_of("r_arm", captures, [tracks["r_arm"] for tracks in held])
    net, batch = net_of(text), batch_of(columns, captures)
    (program,) = plan(parse(text.replace("x1+", f"x1..{max(np.diff(columns.bounds))}")))
    assume(len(program.states) <= MOST_STEPS)
    (written_out,) = nets_of(program)
    found, expected = (
        [told(key, most) for key in keys_of(FuzzyLine(it, columns, most), batch, most)[0].tolist()]
        for it in (net, written_out)
    )
    assert found == expected


@examples(300)
@given(
    counted_lines(),
    st.lists(generated_patterns.recordings(), min_size=1, max_size=3),
    st.integers(0, 300),
)
def test_symbols_and_captures_that_are_left_out_have_no_match(text, recordings, most):
    captures, held = zip(*recordings, strict=True)
    columns = columns_of("r_arm", captures, [tracks["r_arm"] for tracks in held])
    batch, rows = batch_of(columns, captures), columns.bounds
    line = FuzzyLine(net_of(text), columns, most)
    most = min(most, (MOST + MISSING) * len(line.net.states))
    expected: dict[int, tuple] = {}
    for last, key in enumerate(keys_of(line, batch, most)[0].tolist()):
        if found := told(key, most):
            cost, first, blur = found
            alone = first == last and columns.start[last] == columns.stop[last]
            match = (cost, int(columns.stop[last]), last, blur, alone)
            expected[first] = min(match, expected.get(first, match))
    found = line.matches(batch)
    assert line.possible()[found.capture].all()
    first, last = (rows[found.capture] + found.line_rows[:, 0, it] for it in (1, 2))
    columns_found = first, found.cost, found.high, last, found.blur
    assert list(zip(*(it.tolist() for it in columns_found), strict=True)) == [
        (first, *match) for first, (*match, alone) in sorted(expected.items()) if not alone
    ]


@examples(100)
@given(counted_lines(), generated_patterns.recordings())
def test_the_way_that_is_told_is_the_one_that_was_found(text, recording):
    capture, tracks = recording
    columns = columns_of("r_arm", [capture], [tracks["r_arm"]])
    net, batch = net_of(text), batch_of(columns, [capture])
    line = FuzzyLine(net, columns, 3 * UNIT)
    keys, costs = keys_of(line, batch, 3 * UNIT)
    unclear = batch.rows("r_arm").cost
    for last, key in enumerate(keys.tolist()):
        if found := told(key, 3 * UNIT):
            _, first, blur = found
            way = line.rows(batch, 0, first, last)
            assert (way[0][0], way[-1][0]) == (first, last)
            fitting = [row for row, step in way if costs[step][row] == 0]
            assert max([0, *unclear[fitting].tolist()]) == blur


def test_what_is_missing_before_and_behind_a_step():
    net = net_of("r_arm right mid -> place high")
    assert net.entry[FREE].tolist() == [0, MISSING]
    assert net.exit[FREE].tolist() == [MISSING, 0]


@pytest.mark.parametrize("steps", [10, 40])
def test_steps_that_may_be_left_out_are_passed_over_once(steps):
    net = net_of("r_arm low" + " -> high?" * (steps - 2) + " -> low")
    assert net.edges[0].sum() == steps * (steps - 1) // 2
    assert net.entry[FREE].tolist() == [0, *[MISSING] * (steps - 1)]


@pytest.mark.parametrize(
    ("text", "least"),
    [
        ("right mid -> right high -> place high", BETWEEN),
        ("right mid -> r_forward mid ... forward mid", BETWEEN),
        ("r_forward mid -> forward mid -> r_forward mid", MISSING),  # to and fro
        ("right mid -> right mid -> right high", MISSING),
        ("right mid -> high -> place high", MISSING),
        ("right mid -> place high -> left mid", BETWEEN),
        ("right mid -> right low -> place high", MISSING),
    ],
)
def test_a_step_on_the_way_is_left_out_for_less(text, least):
    assert net_of(f"r_arm {text}").least.tolist() == [MISSING, least, MISSING]


def cost(text, columns):
    line, batch = (
        FuzzyLine(net_of(text), columns, MOST),
        batch_of(columns, [generated_patterns.CAPTURE]),
    )
    return keys_of(line, batch, MOST)[1][0, 0]


@pytest.mark.parametrize(
    ("asked", "symbol", "expected"),
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
def test_a_neighbour_costs_less(asked, symbol, expected):
    columns = generated_patterns.one_symbol("r_arm", *symbol)
    assert cost(f"r_arm {asked}", columns) == pytest.approx(expected, abs=1)


def test_a_symbol_at_the_border_to_what_is_asked_costs_nothing():
    symbols = [
        generated_patterns.one_symbol("r_arm", "r_forward", "mid", margin, ("right", "mid"))
        for margin in (0.0, 0.5, 1.0)
    ]
    costs = [cost("r_arm right mid", one) for one in symbols]
    assert costs[0] == 0 < costs[1] < costs[2]


def test_the_middles_are_as_far_apart_as_a_body_sees_them():
    found = angles(MIDDLES[CELLS], MIDDLES[CELLS])
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
