"""Lines and symbols as the alignment takes them, for tests."""

import numpy as np
from hypothesis import strategies as st

from lanindex.model.columns import PASSING, STARTING
from lanindex.search.automaton import plan
from lanindex.search.fuzzy.align import Rows, blurs
from lanindex.search.fuzzy.costs import kinds_of, substitutions
from lanindex.search.fuzzy.net import Net, nets_of
from lanindex.search.language import parse


def net_of(text: str) -> Net:
    """Return a line of one part as a net."""
    (program,) = plan(parse(text))
    (net,) = nets_of(program)
    return net


def tables_of(net: Net, columns) -> np.ndarray:
    """Return what all kinds of symbols cost as each of the steps."""
    return np.array([kinds_of(columns).table(state) for state in net.states])


def costs_of(net: Net, columns) -> np.ndarray:
    """Return what all symbols cost as each of the steps."""
    every = np.arange(len(columns))
    tables = tables_of(net, columns)
    return np.array(
        [
            substitutions(state, table, columns, every)
            for state, table in zip(net.states, tables, strict=True)
        ]
    ).reshape(len(net.states), len(columns))


def rows_of(net: Net, columns) -> Rows:
    """Return all symbols of columns; nothing is asked of a clip's start and end."""
    new = columns.cell & STARTING != 0
    new[columns.bounds[:-1][np.diff(columns.bounds) > 0]] = True
    nothing = np.zeros((2, 1), np.int32)
    shown, blur = columns.cell & PASSING == 0, blurs(columns.margin)
    skipped = np.zeros(len(columns), np.int64)
    return Rows(new, shown, skipped, costs_of(net, columns), blur, nothing, nothing)


_WORDS = ("low", "right mid", "place high", "any", "left", "mid/high", "not low", "(low or high)")


@st.composite
def counted_lines(draw) -> str:
    """Return steps of one part with counts, some of them in brackets."""
    steps = draw(st.lists(st.sampled_from(_WORDS), min_size=1, max_size=4))
    counts = [draw(st.sampled_from(("", "", "?", " x2", " x1+", " x1..2"))) for _ in steps]
    items = [f"{step}{count}" for step, count in zip(steps, counts, strict=True)]
    arrows = [draw(st.sampled_from((" -> ", " ... "))) for _ in steps[1:]]
    line = "".join(map("".join, zip(items, [*arrows, ""], strict=True)))
    return f"(r_arm any -> {line}) x1+" if draw(st.booleans()) else f"r_arm any -> {line}"
