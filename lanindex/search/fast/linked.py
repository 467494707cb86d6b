"""Lines of linked movements, alone and beside one another: in many captures at once.

Where each line is a row of movements of one part, joined by ``->``, nothing need be known of the
rows but their cells. The leading line is looked for first, the others only in its captures.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction

import numpy as np

from lanindex.model.columns import PASSING, STARTING, THOUSANDTHS, Columns, Roster
from lanindex.search import compiled
from lanindex.search.automaton import Group, Program
from lanindex.search.fast.answers import Answers, best, firsts, joined, own_rows
from lanindex.search.fast.beside import Stretches
from lanindex.search.fast.block import Block, slabs
from lanindex.search.fast.chains import answers as line_answers
from lanindex.search.fast.chains import chains_of
from lanindex.search.fast.claims import Contested, all_lines, contested
from lanindex.search.fast.company import Company
from lanindex.search.fast.events import cells_of
from lanindex.search.fast.links import Chain, Links
from lanindex.search.fast.narrow import Narrowing
from lanindex.search.fast.planes import Part, part_of
from lanindex.search.fast.ragged import Mask, Whole, best_of_each
from lanindex.search.fast.walk import Ends, NotCovered

MOST_ROWS = 1 << 18
"""How many rows of a part are gone through at once."""

Ways = dict[Program, list[Chain]]
"""By program all its chains."""


def covered(programs: tuple[Program, ...]) -> Ways | None:
    """Return the chains of programs and of all lines beside them, None if they are more."""
    found: Ways = {}
    for program in programs:
        try:
            if contested(program).states:
                return None
        except NotCovered:
            return None
        for line in all_lines(program):
            chains = chains_of(replace(line, whole=Group()))
            if chains is None or not all(map(_linked, chains)):
                return None
            found[line] = chains
    return found


def _linked(chain: Chain) -> bool:
    """Tell whether a chain's steps follow each other, and ask for a place alone."""
    changing = any("change" in state.fits[0] for state in chain.states)
    return not changing and not any(arrow.later for arrow in chain.arrows)


class Linked:
    """Searches for programs all of whose lines are linked movements.

    Parameters
    ----------
    roster : Roster
        All captures.
    columns : Mapping of str to Columns
        By part; a part that is not there never moves.
    programs : tuple of Program
        Any one of them answers.
    tolerance : Fraction
        Seconds by which edges may differ that should agree.
    """

    def __init__(
        self,
        roster: Roster,
        columns: Mapping[str, Columns],
        programs: tuple[Program, ...],
        tolerance: Fraction,
    ) -> None:
        self._columns, self._programs = columns, programs
        self._block = Block(roster, columns, np.arange(len(roster)), tolerance)

    def answers(self, chains: Ways, parts: list[tuple[str, ...]]) -> Iterator[tuple[int, Answers]]:
        """Yield answers, with how many captures are done before them.

        Parameters
        ----------
        chains : dict
            As from `covered`.
        parts : list of tuple of str
            Of `Finder`.
        """
        for captures in slabs(self._columns.values(), self._possible(chains), MOST_ROWS):
            found = []
            for number, program in enumerate(self._programs):
                part = program.states[0].members[0]
                if part not in self._columns:
                    continue
                company = _Linked(self._block, self._columns, chains, captures)
                rows, low, high = company.best(program)
                place, _ = firsts(program.states[0], parts)
                capture = np.searchsorted(self._columns[part].bounds, rows, side="right") - 1
                every = np.stack((rows, np.full(len(rows), -1)), axis=1)
                margin = np.minimum(self._columns[part].margin[rows], THOUSANDTHS).astype(np.int64)
                cost, one = ~(THOUSANDTHS - margin), np.ones(len(rows), np.int64)
                found.append(Answers(capture, low, high, cost, number * one, place * one, every))
            answers = best(joined(found))
            yield (
                int(captures[0]),
                own_rows(answers, parts, lambda part: self._columns[part].bounds),
            )

    def _possible(self, chains: Ways) -> Whole:
        """Return the captures in which a leading line matches, and others may if those are many."""
        there = np.zeros(len(self._block), bool)
        for program in self._programs:
            columns = self._columns.get(program.states[0].members[0])
            if columns is not None:
                part = part_of(columns)
                there[part.captures(line_answers(part, chains[program])[0])] = True
        if 2 * there.sum() > len(there):
            there &= Narrowing(self._columns, self._block).possible(self._programs)
        return np.flatnonzero(there)


class _Linked(Company):
    """Programs in some captures, whose chains are known; the rows are those of all captures."""

    def __init__(
        self, block: Block, columns: Mapping[str, Columns], chains: Ways, captures: Whole
    ) -> None:
        super().__init__(block, Contested({}, set()))
        self._columns, self._chains, self._captures = columns, chains, captures

    def best(self, program: Program) -> tuple[Whole, Whole, Whole]:
        """Return where a program begins, and low and high of the best way from there."""
        fast = compiled.chosen("chains", 0)
        movement = self._one_movement(program) if fast else None
        if fast is None or movement is None:
            return self.leading(program)[1:]
        part, fits = movement
        columns = self._columns[program.states[0].members[0]]
        found = [np.empty((3, 0), np.int64)]
        for chain in self._chains[program]:
            capture, first, last = rows_of(columns, chain, self._captures)
            start, stop = columns.start[first], columns.stop[last]
            ways = capture, first, start, stop
            found.append(fast.sharing(*ways, part.cell, part.bounds, part.start, part.stop, fits))
        rows, low, high = np.concatenate(found, axis=1)
        chosen = best_of_each((rows,), (high, -low))
        return rows[chosen], low[chosen], high[chosen]

    def _one_movement(self, program: Program) -> tuple[Columns, Mask] | None:
        """Return what stands beside a program and which cells it fits, if a movement is all."""
        group = program.whole
        if group.length or [it.relation for it in group.companions] != ["with"]:
            return None
        (beside,) = group.companions
        lines = [self._chains[it] for it in beside.programs]
        if beside.within or any(it.whole.companions or it.whole.length for it in beside.programs):
            return None
        chains = [chain for line in lines for chain in line]
        parts = {state.members[0] for chain in chains for state in chain.states}
        if len(parts) > 1 or any(len(chain.states) > 1 for chain in chains):
            return None
        (part,) = parts
        fits = np.any([_tables(chain)[0] for chain in chains], axis=0)
        return (self._columns[part], fits) if part in self._columns else None

    def _found(
        self, program: Program, begun: list[Mask] | None = None, within: Whole | None = None
    ) -> tuple[Ends, Stretches]:
        """Return the ways of a line, all; what is looked for later, only in their captures."""
        part = program.states[0].members[0]
        if part not in self._columns:
            return _ends(np.empty((3, 0), np.int64), None)
        columns = self._columns[part]
        pieces = [rows_of(columns, chain, self._captures) for chain in self._chains[program]]
        return _ends(np.concatenate(pieces, axis=1), columns)

    def _look_only_in(self, program: Program, captures: Whole) -> None:
        """Look for the lines beside a program in some captures alone."""
        there = np.zeros(len(self._block), bool)
        there[captures] = True
        self._captures = np.flatnonzero(there)


def _ends(found: Whole, columns: Columns | None) -> tuple[Ends, Stretches]:
    """Return as ways of a line what begins and ends at some rows of some captures."""
    capture, first, last = found
    nothing = np.zeros(len(first), np.int64)
    ends = Ends(nothing, first, nothing, last, np.empty((len(first), 0), np.int64))
    start = columns.start[first].astype(np.int64) if columns else nothing
    stop = columns.stop[last].astype(np.int64) if columns else nothing
    return ends, Stretches(capture, start, stop, start, stop, nothing > 0)


def rows_of(columns: Columns, chain: Chain, captures: Whole) -> Whole:
    """Return capture, first and last row of all ways of a chain in some captures, (3, N) int64.

    Parameters
    ----------
    columns : Columns
        Of its part.
    chain : Chain
        Of linked movements.
    captures : ndarray
        (M,) int64, growing.
    """
    if not len(captures):
        return np.empty((3, 0), np.int64)
    fast = compiled.chosen("joins", len(columns))
    begin, behind = int(captures[0]), int(captures[-1]) + 1
    if fast:
        found: Whole = fast.linked(columns.cell, columns.bounds, captures, _tables(chain))
        return found
    own = columns.between(begin, behind)
    links = Links(Part(own), chain)
    rows = links.linked(0, len(chain.states) - 1)
    capture = np.searchsorted(own.bounds, rows[0], side="right") - 1 + begin
    wanted = np.zeros(behind, bool)
    wanted[captures] = True
    first = int(columns.bounds[begin])
    return np.stack((capture, rows[0] + first, rows[-1] + first))[:, wanted[capture]]


def _tables(chain: Chain) -> Mask:
    """Return which cells each step of a chain fits, (steps, 256) bool."""
    cells, last = np.arange(256), len(chain.states) - 1
    tables = np.stack([cells_of(state, 0) for state in chain.states])
    for number, state in enumerate(chain.states):
        if not (state.manner == "via" or (state.names_passing and 0 < number < last)):
            tables[number] &= cells & PASSING == 0
        if number or not last:
            tables[number] &= cells & STARTING == 0
    return tables
