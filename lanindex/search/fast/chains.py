"""Lines of one part, each step a movement: answered from the rows of their rarest step.

Most of what people ask is such a chain, and most of it is rare; so nothing is worked out for all
rows but which of them are the rarest step. From those few the arrows lead on and back.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np

from lanindex.model.columns import PASSING, STARTING, THOUSANDTHS, Columns
from lanindex.search.automaton import Program, State
from lanindex.search.fast.answers import Answers
from lanindex.search.fast.arrows import NONE
from lanindex.search.fast.events import cells_of
from lanindex.search.fast.lines import cost_of, end_of, value_of, with_cost
from lanindex.search.fast.ragged import Mask, Numbers, Whole, smallest_in
from lanindex.search.language.query import Arrow
from lanindex.search.language.words import WORD_KINDS

MOST_CHAINS = 16
"""Ways through a program that are gone one by one."""

MOST_STEPS = 64
"""Steps of a program that is taken apart into chains."""

PARTS_KEPT = 4
"""Parts of which more than the columns is kept for the next search."""

FEW_KINDS = 8
"""Kinds of cells that are looked for one by one; more are looked up in a table."""


@dataclass(frozen=True, slots=True)
class Chain:
    """One way through a program.

    Attributes
    ----------
    states : tuple of State
        Its steps.
    arrows : tuple of Arrow
        Between them, one fewer.
    """

    states: tuple[State, ...]
    arrows: tuple[Arrow, ...]


def chains_of(program: Program) -> list[Chain] | None:
    """Return all ways through a program, None if it is no bundle of chains."""
    states = program.states
    if program.open_ended or program.brackets or program.whole.companions:
        return None
    if len(states) > MOST_STEPS:
        return None
    plain = all(
        state.manner in ("move", "via")
        and state.members == states[0].members
        and not (state.length or state.near)
        for state in states
    )
    through = any(states[it.state].manner == "via" for it in program.entries)
    if not plain or len(states[0].members) > 1 or (through and len(states) > 1):
        return None
    chains: list[Chain] = []
    for entry in program.entries:
        if entry.from_start or not _follow(program, [entry.state], [], chains):
            return None
    return chains


def _follow(program: Program, way: list[int], arrows: list[Arrow], chains: list[Chain]) -> bool:
    """Add all chains that go on from a way; tell whether there are few, and nothing else."""
    leaving = program.exits[way[-1]]
    if leaving:
        chains.append(Chain(tuple(program.states[it] for it in way), tuple(arrows)))
    if len(chains) > MOST_CHAINS or any(it.to_end for it in leaving):
        return False
    for edge in program.edges[way[-1]]:
        state = edge.entry.state
        if state in way or edge.entry.from_start or edge.arrow.length:
            return False
        if not _follow(program, [*way, state], [*arrows, edge.arrow], chains):
            return False
    return True


class Part:
    """One part's rows in all captures, and what chains need to know of them.

    Parameters
    ----------
    columns : Columns
        Of the part.
    """

    def __init__(self, columns: Columns) -> None:
        self.columns, self.cell = columns, columns.cell
        self.counts = np.bincount(columns.cell, minlength=256)

    def __len__(self) -> int:
        """Return how many rows there are."""
        return len(self.cell)

    @cached_property
    def begins(self) -> Mask:
        """Which rows begin a stretch, (S + 1,); the one behind the last does."""
        begins = np.zeros(len(self) + 1, bool)
        np.greater_equal(self.cell, STARTING, out=begins[:-1])
        begins[self.columns.bounds] = True
        return begins

    @cached_property
    def behind(self) -> Numbers:
        """The row behind the last one of each row's stretch, (S,) int32."""
        beginnings = np.flatnonzero(self.begins).astype(np.int32)
        return np.repeat(beginnings[1:], np.diff(beginnings))

    @cached_property
    def shown(self) -> Numbers:
        """The rows that the score shows, int32."""
        return np.flatnonzero(self.cell & PASSING == 0).astype(np.int32)

    def where(self, table: Mask) -> Whole:
        """Return the rows whose cell stands in a table of 256."""
        kinds = np.flatnonzero(table & (self.counts > 0)).astype(np.uint8)
        if len(kinds) > FEW_KINDS:
            return np.flatnonzero(table[self.cell])
        found = np.zeros(len(self), bool)
        for kind in kinds:
            found |= self.cell == kind
        return np.flatnonzero(found)

    def after(self, rows: Whole, passing: bool) -> tuple[Whole, Whole]:
        """Return where ``->`` leads from some rows, passing ones too if they are wanted.

        Returns
        -------
        ndarray, ndarray
            Places in `rows`, and rows.
        """
        there = rows + 1
        going = ~self.begins[there]
        places, found = np.flatnonzero(going), []
        there = there[going]
        while len(there):
            passed = self.cell[there] & PASSING > 0
            kept = slice(None) if passing else ~passed
            found.append((places[kept], there[kept]))
            going = passed & ~self.begins[there + 1]
            places, there = places[going], there[going] + 1
        return _joined(found)

    def before(self, rows: Whole, passing: bool) -> tuple[Whole, Whole]:
        """Return from where ``->`` leads to some rows: places in `rows`, and rows."""
        going = ~self.begins[rows]
        places, found = np.flatnonzero(going), []
        there = rows[going] - 1
        while len(there):
            passed = self.cell[there] & PASSING > 0
            kept = slice(None) if passing else ~passed
            found.append((places[kept], there[kept]))
            going = passed & ~self.begins[there]
            places, there = places[going], there[going] - 1
        return _joined(found)

    def cost(self, rows: Whole) -> Whole:
        """Return what is missing to a margin of 1, in thousandths."""
        return THOUSANDTHS - self.columns.margin[rows].astype(np.int64)

    def change(self, rows: Whole) -> Numbers:
        """Return how the level of rows compares with that before: codes."""
        codes = WORD_KINDS["change"].codes
        level = (self.cell[rows] >> 4 & 3).astype(np.int64) - 1
        change = np.where(level >= 0, codes["neither"], -1)
        shown = np.flatnonzero((self.cell[rows] & PASSING == 0) & (level >= 0))
        places, earlier = self.before(rows[shown], passing=False)
        before = (self.cell[earlier] >> 4 & 3).astype(np.int64) - 1
        own = level[shown[places]]
        said = np.where(before < own, codes["rising"], codes["sinking"])
        told = (before >= 0) & (before != own)
        change[shown[places[told]]] = said[told]
        return change


@lru_cache(maxsize=PARTS_KEPT)
def part_of(columns: Columns) -> Part:
    """Return a part's rows; those of the last few columns are kept."""
    return Part(columns)


def _joined(found: list[tuple[Whole, Whole]]) -> tuple[Whole, Whole]:
    if not found:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    return np.concatenate([it for it, _ in found]), np.concatenate([it for _, it in found])


class Links:
    """The steps of a chain, as rows of its part."""

    def __init__(self, part: Part, chain: Chain) -> None:
        self.part, self.chain = part, chain
        last = len(chain.states) - 1
        self.passing = [
            state.manner == "via" or (state.names_passing and 0 < number < last)
            for number, state in enumerate(chain.states)
        ]
        self.tables = [self._table(state, number) for number, state in enumerate(chain.states)]
        self.many = [int(part.counts[table].sum()) for table in self.tables]

    def _table(self, state: State, number: int) -> Mask:
        cells, table = np.arange(256), cells_of(state, 0)
        if not self.passing[number]:
            table &= cells & PASSING == 0
        if number or len(self.chain.states) == 1:
            table &= cells & STARTING == 0
        return table

    def rows(self, number: int) -> Whole:
        """Return all rows that a step fits."""
        rows = self.part.where(self.tables[number])
        return rows[self._changed(number, rows)]

    def fits(self, number: int, rows: Whole) -> Mask:
        """Return which of some rows a step fits."""
        fits: Mask = self.tables[number][self.part.cell[rows]]
        fits[fits] = self._changed(number, rows[fits])
        return fits

    def _changed(self, number: int, rows: Whole) -> Mask:
        wanted = self.chain.states[number].fits[0].get("change")
        if wanted is None:
            return np.ones(len(rows), bool)
        changed: Mask = np.isin(self.part.change(rows), sorted(wanted))
        return changed

    def linked(self, first: int, last: int) -> list[Whole]:
        """Return the rows that the steps from one to another match, over ``->``: step by step."""
        rarest = first + int(np.argmin(self.many[first : last + 1]))
        rows = [self.rows(rarest)]
        for number in range(rarest + 1, last + 1):
            places, there = self.part.after(rows[-1], self.passing[number])
            fits = self.fits(number, there)
            rows = [*(it[places[fits]] for it in rows), there[fits]]
        for number in range(rarest - 1, first - 1, -1):
            places, there = self.part.before(rows[0], self.passing[number])
            fits = self.fits(number, there)
            rows = [there[fits], *(it[places[fits]] for it in rows)]
        return rows


def table(columns: Columns, chains: list[Chain], program: int, place: int) -> Answers:
    """Return the answers of a program in all captures, rows counted over all of them.

    Parameters
    ----------
    columns : Columns
        Of its part.
    chains : list of Chain
        All its ways.
    program, place : int
        Which program it is, and where its part stands in the list of `Finder`.
    """
    found = [answers(part_of(columns), chain) for chain in chains]
    rows, values = _best(*(np.concatenate(one) for one in zip(*found, strict=True)))
    capture = np.searchsorted(columns.bounds, rows, side="right") - 1
    many = len(rows)
    firsts = np.stack((rows, np.full(many, -1)), axis=1)
    low = columns.start[rows].astype(np.int64)
    ends = end_of(values), cost_of(values)
    return Answers(capture, low, *ends, np.full(many, program), np.full(many, place), firsts)


def answers(part: Part, chain: Chain) -> tuple[Whole, Whole]:
    """Return where a chain begins, and how it ends best.

    Parameters
    ----------
    part : Part
        Of its states.
    chain : Chain
        Which.

    Returns
    -------
    ndarray, ndarray
        Rows, growing, and values as from `lines.value_of`.
    """
    links = Links(part, chain)
    cuts = [0, *(it + 1 for it, arrow in enumerate(chain.arrows) if arrow.later), len(chain.states)]
    begins = values = np.empty(0, np.int64)
    for first, behind in reversed(list(pairwise(cuts))):
        rows = links.linked(first, behind - 1)
        if behind == len(chain.states):
            own = value_of(part.columns.stop[rows[-1]].astype(np.int64), part.cost(rows[-1]))
        else:
            low, high = _reached(part, rows[-1], chain.arrows[behind - 1])
            low, high = np.searchsorted(begins, low), np.searchsorted(begins, high)
            own = smallest_in(values, low, high, NONE)
            some = np.flatnonzero(own < NONE)
            own, rows = own[some], [it[some] for it in rows]
            own = with_cost(own, part.cost(rows[-1]))
        for step in rows[:-1]:
            own = with_cost(own, part.cost(step))
        begins, values = _best(rows[0], own)
    return begins, values


def _best(rows: Whole, values: Whole) -> tuple[Whole, Whole]:
    """Return rows once, in order, each with its smallest value."""
    if not (np.diff(rows) > 0).all():
        order = np.argsort(rows, kind="stable")
        rows, values = rows[order], values[order]
        firsts = np.flatnonzero(np.diff(rows, prepend=-1))
        values = np.minimum.reduceat(values, firsts) if len(rows) else values
        rows = rows[firsts]
    return rows, values


def _reached(part: Part, rows: Whole, arrow: Arrow) -> tuple[Whole, Whole]:
    """Return to which rows ``...`` leads from some: from one up to, not including, another."""
    low = rows + 1
    high: Whole = part.behind[rows].astype(np.int64)
    if not arrow.skips:
        return low, high
    least, most = arrow.skips.bounds
    shown, many = part.shown, len(part.shown)
    behind = np.searchsorted(shown, rows.astype(np.int32), side="right")
    if least:
        skipped = shown[np.minimum(behind + least, many) - 1].astype(np.int64)
        low = np.where(behind + least <= many, skipped + 1, high)
    if most is not None:
        last = shown[np.minimum(behind + most, many - 1)].astype(np.int64)
        high = np.where(behind + most < many, np.minimum(high, last + 1), high)
    return np.minimum(low, high), high
