"""A program with all that stands beside its line: from each beginning, what can be at best.

The first line leads: each other line is compared with it. The lines that must be there make the
hull of the hit; then those that must not be there are looked for. Which ways there are is worked
out for the frames alone: the plain matcher tells the symbols of those hits that are shown.
"""

from __future__ import annotations

from math import floor

import numpy as np

from lanindex.search.automaton import Companion, Group, Program
from lanindex.search.fast import beside
from lanindex.search.fast.arrows import NONE
from lanindex.search.fast.beside import FORBIDDEN, NO_FRAMES, Margins, Stretches
from lanindex.search.fast.block import Block
from lanindex.search.fast.lines import Backwards, end_of
from lanindex.search.fast.ragged import FAR, Mask, Whole, best_of_each
from lanindex.search.fast.walk import Ends, NotCovered, Walk, outer_groups

Ways = tuple[Whole, Whole, Whole]
"""Ways in which something can be: of which line, low, high."""


class Company:
    """Programs of a query in a block.

    Parameters
    ----------
    block : Block
        Where.
    """

    def __init__(self, block: Block) -> None:
        self._block = block
        rates = block.clocks()
        slack = np.array([floor(block.tolerance * clock.rate) for clock in rates[0]], np.int64)
        self._slack = slack[rates[1]]
        self._lines: dict[tuple[Program, bool], Stretches] = {}

    def leading(self, program: Program) -> tuple[Whole, Whole, Whole, Whole]:
        """Return the best way of a program from each beginning.

        Returns
        -------
        tuple of ndarray
            By which entry and at which event it begins, its low and high.
        """
        ends = Walk(self._block, program).ends()
        lines = self._stretches(program, ends)
        chosen = np.flatnonzero(~lines.alone)
        ends, lines = _ends_at(ends, chosen), lines.at(chosen)
        if program.open_ended:
            line, low, high = self._running_on(program, ends, lines)
        else:
            line, low, high = self._closed(program, lines)
        entry, root = ends.entry[line], ends.root[line]
        best = best_of_each((entry, root), (high, -low))
        return entry[best], root[best], low[best], high[best]

    def _running_on(self, program: Program, ends: Ends, lines: Stretches) -> Ways:
        """Return ways of lines that run on as long as they can."""
        groups = outer_groups(program)
        relations = {it.relation for group in groups for it in group.companions}
        bounded = any(
            group.length is not None
            or any(it.relation == "before" and it.within for it in group.companions)
            for group in groups
        )
        if bounded or relations & {"ending with", "exactly with"}:
            raise NotCovered
        if not relations & {"during", "before", "without"}:
            last = self._last_of_all(program, ends)
            line, low, high = self._closed(program, lines.at(last))
            return last[line], low, high
        if relations & {"with", "starting with"}:
            raise NotCovered
        line, low, high = self._closed(program, lines)
        later = self._next_end(program, ends)[line]
        on = np.flatnonzero(later < NONE)
        longer = lines.at(line[on])
        longer.until = longer.high = later[on]
        still = self._closed(program, longer)[0]
        ended = np.ones(len(line), bool)
        ended[on[still]] = False
        return line[ended], low[ended], high[ended]

    def _last_of_all(self, program: Program, ends: Ends) -> Whole:
        """Return the places of lines that cannot go on."""
        return np.flatnonzero(self._next_end(program, ends) >= NONE)

    def _next_end(self, program: Program, ends: Ends) -> Whole:
        """Return where each line ends next if it goes on, `NONE` if it cannot."""
        backwards = Backwards(self._block, program, runs_on=False)
        found = np.full(len(ends.state), NONE)
        for state, beyond in enumerate(backwards.beyond):
            own = ends.state == state
            value = beyond[ends.event[own]]
            found[own] = np.where(value < NONE, end_of(value), NONE)
        return found

    def lines(self, program: Program, *, longest: bool) -> Stretches:
        """Return all ways of a line beside another; or the longest of one that runs on."""
        longest = longest and program.open_ended
        key = (program, longest)
        if key not in self._lines:
            ends = Walk(self._block, program).ends()
            lines = self._stretches(program, ends)
            if longest:
                if outer_groups(program):
                    raise NotCovered
                lines = lines.at(self._last_of_all(program, ends))
            line, low, high = self._closed(program, lines)
            lines = lines.at(line)
            lines.low, lines.high = low, high
            keys = tuple(getattr(lines, name) for name in ("capture", "start", "until", "alone"))
            self._lines[key] = lines.at(best_of_each((*keys, low, high), ()))
        return self._lines[key]

    def _stretches(self, program: Program, ends: Ends) -> Stretches:
        """Return the frames of lines."""
        columns = np.empty((3, len(ends.root)), np.int64)
        for number, entry in enumerate(program.entries):
            own = ends.entry == number
            events = self._block.events(program.states[entry.state])
            columns[0, own] = events.capture[ends.root[own]]
            columns[1, own] = events.start[ends.root[own]]
        high, alone = np.empty(len(ends.root), np.int64), np.zeros(len(ends.root), bool)
        for state in range(len(program.states)):
            own = ends.state == state
            events = self._block.events(program.states[state])
            alone[own] = events.starting[ends.event[own]]
            high[own] = events.end[ends.event[own]]
            until = np.where(events.starting, events.until, events.end)
            columns[2, own] = until[ends.event[own]]
        capture, start, until = columns
        return Stretches(capture, start, until, start, high, alone)

    def _closed(self, program: Program, lines: Stretches) -> Ways:
        """Return the ways in which a program's outer groups can close."""
        ways: Ways = (np.arange(len(lines)), lines.low, lines.high)
        for group in reversed(outer_groups(program)):
            ways = self._group(group, lines, ways)
        return ways

    def _group(self, group: Group, lines: Stretches, ways: Ways) -> Ways:
        if group.length:
            lasts = self._block.meets(lines.capture, lines.high - lines.start, group.length)
            ways = _chosen(ways, (lasts & ~lines.alone)[ways[0]])
        for companion in sorted(group.companions, key=lambda it: it.relation not in NO_FRAMES):
            if companion.relation not in FORBIDDEN:
                ways = self._joined(companion, lines, ways)
        for companion in group.companions:
            if companion.relation in FORBIDDEN:
                ways = _chosen(ways, ~self._disturbed(companion, lines, ways))
        return ways

    def _margins(self, companion: Companion) -> Margins:
        none = np.zeros(len(self._block), np.int64)
        if companion.within:
            least, most = self._block.bounds(companion.within)
            return Margins(least, most, self._slack)
        if companion.relation in ("after", "before"):
            return Margins(none, none + (FAR >> 1), self._slack)
        return Margins(none, none - 1, self._slack)

    def _partners(self, companion: Companion, *, longest: bool) -> list[tuple[bool, Stretches]]:
        """Return the other lines that those stand beside that are alone, and those that are not."""
        tables = [self.lines(program, longest=longest) for program in companion.programs]
        others = Stretches(
            *(
                np.concatenate([getattr(it, name) for it in tables])
                for name in ("capture", "start", "until", "low", "high", "alone")
            )
        )
        moving = others.at(~others.alone)
        return [(False, moving), (True, others)]

    def _joined(self, companion: Companion, lines: Stretches, ways: Ways) -> Ways:
        relation, margins = companion.relation, self._margins(companion)
        open_ended = any(program.open_ended for program in companion.programs)
        if open_ended and relation in ("after", "ending with", "exactly with"):
            raise NotCovered
        wanted = np.zeros(len(lines), bool)
        wanted[ways[0]] = True
        found: list[Ways] = []
        for alone, others in self._partners(companion, longest=True):
            own = np.flatnonzero(wanted & (lines.alone == alone))
            if not len(own) or (alone and relation in ("after", "before")):
                continue
            if relation in NO_FRAMES:
                held = own[beside.holds(relation, lines.at(own), others, margins)]
                fits = np.zeros(len(lines), bool)
                fits[held] = True
                found.append(_chosen(ways, fits[ways[0]]))
            else:
                line, low, high = beside.hulls(relation, lines.at(own), others, margins)
                found.append(beside.both(ways, (own[line], low, high)))
        return (
            beside.smallest(*(np.concatenate(it) for it in zip(*found, strict=True)))
            if found
            else _chosen(ways, np.zeros(len(ways[0]), bool))
        )

    def _disturbed(self, companion: Companion, lines: Stretches, ways: Ways) -> Mask:
        """Tell in which ways something happens that must not."""
        line, low, high = ways
        hulls = Stretches(lines.capture[line], low, high, low, high, lines.alone[line])
        disturbed: Mask = np.zeros(len(line), bool)
        margins = self._margins(companion)
        for alone, others in self._partners(companion, longest=False):
            own = np.flatnonzero(hulls.alone == alone)
            if companion.relation == "never":
                disturbed[own] = np.isin(hulls.capture[own], others.capture)
            else:
                disturbed[own] = beside.shares(hulls.at(own), others, margins)
        return disturbed


def _chosen(ways: Ways, fits: Mask) -> Ways:
    return ways[0][fits], ways[1][fits], ways[2][fits]


def _ends_at(ends: Ends, chosen: Whole) -> Ends:
    return Ends(ends.entry[chosen], ends.root[chosen], ends.state[chosen], ends.event[chosen])
