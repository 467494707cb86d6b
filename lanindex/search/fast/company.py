"""A leading line with those beside it, where none of them wants what another one takes.

The first line leads: each other line is compared with it. The lines that must be there make the
hull of the hit; then those that must not be there are looked for. Each is looked for only in the
captures that are still in question.
"""

from __future__ import annotations

from collections.abc import Callable
from math import floor

import numpy as np

from lanindex.search.automaton import Companion, Program
from lanindex.search.fast import beside
from lanindex.search.fast.abreast import standing
from lanindex.search.fast.beside import FORBIDDEN, NO_FRAMES, Margins, Others, Stretches, gathered
from lanindex.search.fast.block import Block
from lanindex.search.fast.ragged import FAR, Mask, Whole, best_of_each

Ways = Callable[[Program, Whole], tuple[Whole, Stretches]]
"""Gives all ways of a line in some captures: at which row they begin, and their frames."""

Hull = tuple[Whole, Whole, Whole]
"""Of which line, growing, and low and high."""


class Company:
    """A program in some captures.

    Parameters
    ----------
    block : Block
        Where.
    program : Program
        The leading line.
    ways : callable
        Gives the ways of lines.
    captures : ndarray
        In which captures.
    """

    def __init__(self, block: Block, program: Program, ways: Ways, captures: Whole) -> None:
        self._block, self._program, self._ways, self._captures = block, program, ways, captures

    def leading(self) -> Hull:
        """Return the best way from each beginning: its row, low and high."""
        rows, lines = self._ways(self._program, self._captures)
        hulls = np.arange(len(lines)), lines.low, lines.high
        companions = self._program.whole.companions
        others = {}
        for companion in (it for it in companions if it.relation not in FORBIDDEN):
            others[companion] = self._others(companion, lines.capture[hulls[0]])
            held = self._holds(companion, lines, others[companion])
            hulls = _some(hulls, held[hulls[0]])
        for companion, beside_it in others.items():
            if companion.relation not in NO_FRAMES:
                hulls = self._joined(companion, lines, hulls, beside_it)
        for companion in (it for it in companions if it.relation in FORBIDDEN):
            line, low, high = hulls
            capture, high = lines.capture[line], np.maximum(high, lines.until[line])
            here = Stretches(capture, low, high, low, high, lines.alone[line])
            forbidden = self._others(companion, capture)
            hulls = _some(hulls, ~self._holds(companion, here, forbidden))
        line, low, high = hulls
        best = best_of_each((rows[line],), (high, -low))
        return rows[line[best]], low[best], high[best]

    def _others(self, companion: Companion, captures: Whole) -> Others:
        """Return the lines beside, in some captures; of what must not happen the outermost."""
        there = np.zeros(len(self._block), bool)
        there[captures] = True
        places = np.flatnonzero(there)
        none = np.zeros(0, np.int64)
        tables = [Stretches(none, none, none, none, none, none > 0)]
        for program in standing(self._program, companion):
            tables.append(beside.different(self._ways(program, places)[1]))
        found = gathered(tables)
        return Others(
            found.at(beside.outermost(found)) if companion.relation in FORBIDDEN else found
        )

    def _holds(self, companion: Companion, lines: Stretches, others: Others) -> Mask:
        return beside.holds(companion.relation, lines, others, self._margins(companion))

    def _joined(self, companion: Companion, lines: Stretches, hulls: Hull, others: Others) -> Hull:
        """Return ways together with the best of the others."""
        line, low, high = hulls
        compared = np.unique(line)
        found = beside.hulls(
            companion.relation, lines.at(compared), others, self._margins(companion)
        )
        way, place = beside.matched(line, compared[found[0]])
        low, high = np.minimum(low[way], found[1][place]), np.maximum(high[way], found[2][place])
        return beside.smallest(line[way], low, high)

    def _margins(self, companion: Companion) -> Margins:
        none = np.broadcast_to(np.int64(0), len(self._block))
        least, most, slack = none, np.broadcast_to(np.int64(-1), len(self._block)), none
        if companion.within:
            least, most = self._block.bounds(companion.within)
        elif companion.relation in ("after", "before"):
            most = np.broadcast_to(np.int64(FAR >> 1), len(self._block))
        if companion.relation in ("starting with", "ending with", "exactly with"):
            clocks, own = self._block.clocks()
            told = [floor(self._block.tolerance * clock.rate) for clock in clocks]
            slack = np.array(told, np.int64)[own]
        return Margins(least, most, slack)


def _some(hulls: Hull, fits: Mask) -> Hull:
    line, low, high = hulls
    return line[fits], low[fits], high[fits]
