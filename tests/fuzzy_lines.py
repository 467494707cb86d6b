"""Lines and symbols for tests of fuzzy search."""

from fractions import Fraction

import numpy as np
from hypothesis import strategies as st

from lanindex.model.columns import roster_of
from lanindex.search.fuzzy import FuzzyLine, Net, followed, nets_of
from lanindex.search.language import parse
from lanindex.search.match.batch import Batch
from lanindex.search.plan import plan


def net_of(text: str) -> Net:
    """Return a line of one part as a net."""
    (program,) = plan(parse(text))
    (net,) = nets_of(program)
    return net


def batch_of(columns, captures) -> Batch:
    """Return all symbols of columns."""
    roster = roster_of(captures)
    return Batch(roster, {columns.part: columns}, np.arange(len(roster)), Fraction(1, 10))


def keys_of(line: FuzzyLine, batch: Batch, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the key of the best match that ends with each symbol, and what each one costs."""
    code = batch.rows(line.net.part).of_rows(line._kinds.code)
    symbols = line._symbols(batch, np.arange(len(code)), code)
    arrived, _ = followed(line.net, symbols, most)
    return (arrived + symbols.exit).min(axis=0), symbols.costs


_WORDS = ("low", "right mid", "place high", "any", "left", "mid/high", "not low", "(low or high)")
_WAY = ["right low", "right mid", "right high", "place high"]


@st.composite
def counted_lines(draw) -> str:
    """Return steps of one part with counts, some of them in brackets."""
    steps = draw(st.lists(st.sampled_from(_WORDS), min_size=1, max_size=4) | st.just(_WAY))
    counts = [draw(st.sampled_from(("", "", "?", " x2", " x1+", " x1..2"))) for _ in steps]
    items = [f"{step}{count}" for step, count in zip(steps, counts, strict=True)]
    arrows = [draw(st.sampled_from((" -> ", " ... "))) for _ in steps[1:]]
    line = "".join(map("".join, zip(items, [*arrows, ""], strict=True)))
    return f"(r_arm any -> {line}) x1+" if draw(st.booleans()) else f"r_arm any -> {line}"
