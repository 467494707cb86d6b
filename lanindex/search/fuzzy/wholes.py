"""All lines of a pattern together in one capture: what goes with what, at the least cost."""

from __future__ import annotations

from fractions import Fraction
from math import floor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.search.automaton import Program
from lanindex.search.fuzzy.allowance import Allowance
from lanindex.search.fuzzy.beside import OUTSIDE, RELATIONS, Found, Limits
from lanindex.search.fuzzy.lines import Line
from lanindex.search.fuzzy.net import Net, net_of
from lanindex.search.language.query import Choice, Lines, Query
from lanindex.search.language.times import Clock, Length

_NONE = 1 << 20
"""A cost that no match may have."""

_FRAMES = 1 << 32
"""More frames than a capture has."""


class Beside(NamedTuple):
    """A line that must lie beside the leading one: how, one net a side, how far at most."""

    relation: str
    nets: tuple[Net, ...]
    within: Length | None


class Apart(NamedTuple):
    """A line that must not happen: how near, and what is looked for."""

    relation: str
    query: Query
    within: Length | None


class Plan(NamedTuple):
    """What a leading line asks for.

    Attributes
    ----------
    net : Net
        The leading line.
    beside : tuple of Beside
        Those that must lie beside it.
    apart : tuple of Apart
        Those that must not; no edits are allowed to them.
    steps : int
        Of all lines but those.
    most : int
        What a match may cost, in parts of an edit.
    """

    net: Net
    beside: tuple[Beside, ...]
    apart: tuple[Apart, ...]
    steps: int
    most: int

    @classmethod
    def of(cls, program: Program, lines: Lines, allowance: Allowance) -> Plan:
        """Return the plan of a program of some lines.

        Raises
        ------
        UsageError
            Where it says what has no edits.
        """
        beside = tuple(
            Beside(it.relation, tuple(map(net_of, it.programs)), it.within)
            for it in program.whole.companions
            if it.relation in RELATIONS
        )
        apart = tuple(
            Apart(it.relation, Query(Choice((Lines(it.line),))), it.within)
            for it in lines.others
            if it.relation not in RELATIONS
        )
        net = net_of(program)
        steps = len(net.states) + sum(max(len(it.states) for it in one.nets) for one in beside)
        return cls(net, beside, apart, steps, allowance.of(steps))


class Whole(NamedTuple):
    """A match of all lines: its frames, its cost, and of each line the first and last row."""

    low: int
    high: int
    cost: int
    lines: tuple[tuple[Line, int, int], ...]

    @property
    def begins(self) -> tuple[str, int]:
        """The part and the row with which the leading line begins."""
        line, first, _ = self.lines[0]
        return line.net.part, first

    @property
    def rank(self) -> tuple[int, int, int]:
        """What is smaller for the better of two: cheaper, over sooner, begun later."""
        return self.cost, self.high, -self.low

    def uses(self, part: str, row: int) -> bool:
        """Return whether a row lies within one of the lines."""
        return any(line.net.part == part and a <= row <= b for line, a, b in self.lines)


def limits_of(clock: Clock, within: Length | None, tolerance: Fraction) -> Limits:
    """Return in frames of a capture what a relation allows."""
    least, most = within.bounds(clock) if within else (0, None)
    return Limits(floor(tolerance * clock.rate), least, most)


class Partners:
    """For each match of a leading line the cheapest match of another one that goes with it.

    Parameters
    ----------
    relation : str
        How they must lie.
    lead : Line
        The leading line.
    found : Found
        (N,) its matches.
    """

    def __init__(self, relation: str, lead: Line, found: Found) -> None:
        self.relation, self._lead, self._found = relation, lead, found
        self.cost: NDArray[np.int64] = np.full(len(found.cost), _NONE)
        self._chosen: list[tuple[Line, Found, int] | None] = [None] * len(found.cost)

    def consider(self, line: Line, others: Found, limits: Limits) -> None:
        """Take the matches of a line, one side of it, where they are cheaper."""
        if line.net.part == self._lead.net.part and self.relation == "with" and not limits.most:
            return  # no two movements of one part share a frame
        if not len(others.cost):
            return
        fits = RELATIONS[self.relation](self._found, others, limits)
        fits &= self._found.alone[:, None] | ~others.alone[None]
        rank = np.where(fits, (others.cost * _FRAMES + others.until)[None], _NONE * _FRAMES)
        best = rank.argmin(axis=1)
        cost = np.where(fits[np.arange(len(best)), best], others.cost[best], _NONE)
        for index in np.flatnonzero(cost < self.cost).tolist():
            self._chosen[index] = (line, others, int(best[index]))
        self.cost = np.minimum(self.cost, cost)

    def joined(self, whole: Whole, index: int) -> Whole:
        """Return a match with the one that goes with it."""
        chosen = self._chosen[index]
        assert chosen is not None
        line, others, which = chosen
        low, high = whole.low, whole.high
        if self.relation not in OUTSIDE:
            low = min(low, int(others.start[which]))
            high = max(high, int(others.until[which]))
        rows = (line, int(others.first[which]), int(others.last[which]))
        return Whole(low, high, whole.cost, (*whole.lines, rows))
