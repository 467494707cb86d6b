"""The steps of a chain of movements of one part: as planes, and as rows where one passes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lanindex.model.columns import PASSING
from lanindex.search.automaton import State
from lanindex.search.fast.events import cells_of
from lanindex.search.fast.planes import MOVES, Part, Plane, ahead, holds, places
from lanindex.search.fast.ragged import Mask, Whole
from lanindex.search.language.query import Arrow
from lanindex.search.language.words import WORD_KINDS


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


class Links:
    """The steps of a chain, as planes and as rows of its part."""

    def __init__(self, part: Part, chain: Chain) -> None:
        self.part, self.chain = part, chain
        last = len(chain.states) - 1
        self.passing = [
            state.manner == "via" or (state.names_passing and 0 < number < last)
            for number, state in enumerate(chain.states)
        ]
        self._passed: dict[int, Whole] = {}
        self._planes: dict[int, Plane] = {}

    def plane(self, number: int) -> Plane:
        """Return the plane of the shown rows that a step fits.

        No starting position follows another symbol; a step alone is none.
        """
        if number not in self._planes:
            plane = self.part.shown_as(self.chain.states[number].fits[0])
            if len(self.chain.states) == 1:
                plane = plane & self.part.store[self.part.place(*MOVES)]
            self._planes[number] = plane
        return self._planes[number]

    def groups(self, number: int) -> list[list[int]]:
        """Return of which planes of the store a step wants one each."""
        groups = [
            [self.part.place(kind, code) for code in sorted(codes)]
            for kind, codes in self.chain.states[number].fits[0].items()
        ]
        if len(self.chain.states) == 1:
            groups.append([self.part.place(*MOVES)])
        return groups

    def passed(self, number: int) -> Whole:
        """Return the passing rows that a step fits."""
        if number not in self._passed:
            rows = self.part.passed if self.passing[number] else np.empty(0, np.int64)
            self._passed[number] = rows[self._passing(number, rows)] if len(rows) else rows
        return self._passed[number]

    def _passing(self, number: int, rows: Whole) -> Mask:
        """Tell which passing rows a step fits: none of them rises or sinks."""
        state, cells = self.chain.states[number], self.part.cell[rows]
        fits: Mask = cells_of(state, 0)[cells]
        wanted = state.fits[0].get("change")
        if wanted is not None:
            fits &= (cells >> 4 & 3 > 0) & (WORD_KINDS["change"].codes["neither"] in wanted)
        return fits

    def _fits(self, number: int, rows: Whole) -> Mask:
        """Tell which of some rows a step fits."""
        passed = self.part.cell[rows] & PASSING > 0
        fits = np.empty(len(rows), bool)
        fits[passed] = self._passing(number, rows[passed])
        fits[~passed] = holds(self.plane(number), self.part.ranks(rows[~passed]))
        return fits

    def apart(self, first: int, offsets: tuple[int, ...]) -> Plane:
        """Return where steps from one on match shown rows so far from it, if nothing passes."""
        plane = self.plane(first) & self.part.together(offsets[-1])
        for number, offset in enumerate(offsets[1:], first + 1):
            plane &= ahead(self.plane(number), offset)
        return plane

    def linked(self, first: int, last: int) -> list[Whole]:
        """Return the rows that the steps from one to another match, over ``->``: step by step."""
        ranks = places(self.apart(first, tuple(range(last - first + 1))))
        shown = [
            self.part.rows(ranks + step if step else ranks) for step in range(last - first + 1)
        ]
        through = self.through(first, last)
        if not len(through[0]):
            return shown
        return [np.concatenate(both) for both in zip(shown, through, strict=True)]

    def through(self, first: int, last: int) -> list[Whole]:
        """Return those of these rows that lead through a passing one."""
        none = [np.empty(0, np.int64)] * (last - first + 1)
        found = [none]
        for number in range(first, last + 1):
            if len(self.passed(number)):
                found.append(self._first_passing(first, number, last))
        return [np.concatenate(step) for step in zip(*found, strict=True)]

    def _first_passing(self, first: int, number: int, last: int) -> list[Whole]:
        """Return those of these rows of which the step with a number is the first to pass."""
        part, rows, steps = self.part, self.passed(number), number - first
        ranks = part.ranks(rows) - steps
        if steps:
            rows, ranks = rows[ranks >= 0], ranks[ranks >= 0]
            kept = holds(self.apart(first, tuple(range(steps))), ranks)
            rows, ranks = rows[kept], ranks[kept]
            kept = part.behind(part.rows(ranks)) == part.behind(rows)
            rows, ranks = rows[kept], ranks[kept]
        found = [*(part.rows(ranks + step) for step in range(steps)), rows]
        for after in range(number + 1, last + 1):
            sources, there = part.after(found[-1], self.passing[after])
            fits = self._fits(after, there)
            found = [*(it[sources[fits]] for it in found), there[fits]]
        return found
