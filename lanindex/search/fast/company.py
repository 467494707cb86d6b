"""A program with all that stands beside its line: from each beginning, what can be at best.

The first line leads: each other line is compared with it. The lines that must be there make the
hull of the hit; then those that must not be there are looked for. Which ways there are is worked
out for the frames alone.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from math import floor

import numpy as np

from lanindex.search.automaton import Companion, Group, Program
from lanindex.search.fast import beside
from lanindex.search.fast.arrows import NONE
from lanindex.search.fast.beside import FORBIDDEN, NO_FRAMES, Margins, Others, Stretches, gathered
from lanindex.search.fast.block import Block
from lanindex.search.fast.claims import (
    Contested,
    all_lines,
    check_running_on,
    could_want,
    manner_of,
)
from lanindex.search.fast.lines import Backwards, end_of
from lanindex.search.fast.ragged import FAR, Mask, Whole, best_of_each, in_order, starts_of
from lanindex.search.fast.walk import Ends, NotCovered, Walk, outer_groups
from lanindex.search.fast.ways import Used, Ways, apart, reduced, united


class Company:
    """Programs of a query in a block.

    Parameters
    ----------
    block : Block
        Where.
    taken : Contested
        What the lines have to remember of what they took.
    """

    def __init__(self, block: Block, taken: Contested) -> None:
        self._block, self._contested = block, taken
        self._lines: dict[tuple[Program, bool], Stretches] = {}
        self._others: dict[Companion, tuple[Others, Others]] = {}
        self._places: Whole = np.arange(len(block))
        self._inner: Company | None = None

    def leading(
        self, program: Program, begun: list[Mask] | None = None, within: Whole | None = None
    ) -> tuple[Whole, Whole, Whole, Whole]:
        """Return the best way of a program from each beginning; `begun`, `within` as in `Walk`.

        Returns
        -------
        tuple of ndarray
            By which entry and at which event it begins, its low and high.
        """
        if program.open_ended:
            check_running_on(program)
        ends, lines = self._found(program, begun, within)
        chosen = np.flatnonzero(~lines.alone)
        ends, lines = ends.at(chosen), lines.at(chosen)
        self._look_only_in(program, lines.capture)
        close = self._running_on if program.open_ended else self._ending_first
        ways = close(program, ends, lines)
        entry, root = ends.entry[ways.line], ends.root[ways.line]
        best = best_of_each((entry, root), (ways.high, -ways.low))
        return entry[best], root[best], ways.low[best], ways.high[best]

    def _ending_first(self, program: Program, ends: Ends, lines: Stretches) -> Ways:
        """Return ways of lines, with the best of each beginning among them.

        The lines that end first are tried first: what ends later than the best way is not tried.
        """
        fits = np.ones(len(lines), bool)
        for companion in _needed(program):
            fits &= self._accompanied([companion], lines)
            self._look_only_in(program, lines.capture[fits])
        chosen = np.flatnonzero(fits)
        ways = self._tried(program, ends.at(chosen), lines.at(chosen), lines.until[chosen])
        ways.line = chosen[ways.line]
        return ways

    def _tried(self, program: Program, ends: Ends, lines: Stretches, ranks: Whole) -> Ways:
        """Return ways of the lines that rank first, until none is left that could be better.

        Of each beginning some are tried, then twice as many, as long as one ranks no worse than the
        `high` of the best way found.
        """
        order = in_order((ends.entry, ends.root, ranks))
        new = starts_of(ends.root[order]) | starts_of(ends.entry[order])
        root = np.cumsum(new) - 1
        place = np.arange(len(order)) - np.flatnonzero(new)[root] if len(order) else order
        best = np.full(int(new.sum()), FAR)
        found: list[Ways] = []
        done, many = 0, 1
        while True:
            left = (place >= done) & (ranks[order] <= best[root])
            order, root, place = order[left], root[left], place[left]
            if not len(order):
                return united(found) if found else Ways(order, order, order)
            now = place < done + many
            chosen = order[now]
            ways = self._closed(program, lines.at(chosen))
            np.minimum.at(best, root[now][ways.line], ways.high)
            ways.line = chosen[ways.line]
            found.append(ways)
            done, many = done + many, 2 * many

    def _running_on(self, program: Program, ends: Ends, lines: Stretches) -> Ways:
        """Return ways of lines that run on as long as they can."""
        relations = {it.relation for group in outer_groups(program) for it in group.companions}
        if not relations & {"during", "before", "without"}:
            last = self._last_of_all(program, ends)
            ways = self._closed(program, lines.at(last))
            ways.line = last[ways.line]
            return ways
        ways = self._closed(program, lines)
        later = self._next_end(program, ends)[ways.line]
        on = np.flatnonzero(later < NONE)
        longer = lines.at(ways.line[on])
        longer.until = longer.high = later[on]
        ended = np.ones(len(ways.line), bool)
        ended[on[self._closed(program, longer).line]] = False
        return ways.at(ended)

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

    def lines(self, program: Program, *, forbidden: bool) -> Stretches:
        """Return all ways of a line beside another, as far as they matter.

        Of one that runs on the longest; of one that must not happen those that no other holds.
        """
        if self._inner:
            found = self._inner.lines(program, forbidden=forbidden)
            return replace(found, capture=self._places[found.capture])
        longest = program.open_ended and not forbidden
        key = (program, forbidden)
        if key not in self._lines:
            ends, lines = self._found(program)
            if longest:
                if outer_groups(program):
                    raise NotCovered
                lines = lines.at(self._last_of_all(program, ends))
            alone = forbidden and program not in self._contested.outside
            if alone:  # the furthest of each beginning will do; any rank is more than any frame
                chosen = np.flatnonzero(self._accompanied(_needed(program), lines))
                ends, lines = ends.at(chosen), lines.at(chosen)
                lines = _as(self._tried(program, ends, lines, FAR - lines.until), lines)
            elif outer_groups(program):
                lines = _as(self._closed(program, lines), lines)
            if program not in self._contested.outside:
                lines.used = ()
            if alone:
                lines = lines.at(beside.outermost(lines))
            self._lines[key] = beside.different(lines)
        return self._lines[key]

    def _found(
        self, program: Program, begun: list[Mask] | None = None, within: Whole | None = None
    ) -> tuple[Ends, Stretches]:
        """Return the ways of a line, and their frames."""
        used = self._contested.states.get(program, ())
        ends = Walk(self._block, program, used, begun, within).ends()
        return ends, self._stretches(program, ends)

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
        return Stretches(capture, start, until, start, high, alone, self._taken(program, ends))

    def _taken(self, program: Program, ends: Ends) -> tuple[Used, ...]:
        """Return what lines took at the states where others could want it."""
        found = []
        for number, column in zip(
            self._contested.states.get(program, ()), ends.used.T, strict=True
        ):
            state = program.states[number]
            events = self._block.events(state)
            some = column >= 0
            for member, part in enumerate(state.members):
                first, last = np.zeros(len(column), np.int64), np.full(len(column), -1)
                first[some] = events.first[member][column[some]]
                last[some] = events.last[member][column[some]]
                found.append(Used((manner_of(state), part), first, last))
        return tuple(found)

    def _closed(self, program: Program, lines: Stretches) -> Ways:
        """Return the ways in which a program's outer groups can close."""
        ways = Ways(np.arange(len(lines)), lines.low, lines.high)
        for around, group in enumerate(reversed(outer_groups(program))):
            if group.length:
                lasts = self._block.meets(lines.capture, lines.high - lines.start, group.length)
                ways = ways.at((lasts & ~lines.alone)[ways.line])
            order = _in_order(group)
            beyond = [it for out in outer_groups(program)[: -1 - around] for it in out.companions]
            for place, companion in enumerate(order):
                if companion.relation in FORBIDDEN:
                    ways = ways.at(~self._disturbed(companion, lines, ways))
                else:
                    ways = self._joined(companion, lines, ways)
                    self._forget(program, ways, [*order[place + 1 :], *beyond])
                    ways = reduced(ways)
        return ways

    def _forget(self, program: Program, ways: Ways, later: list[Companion]) -> None:
        """Let go of what other lines took, if none that comes later could want it."""
        if not ways.used:
            return
        coming = [inner for companion in later for inner in companion.programs]
        done = [
            inner
            for around in outer_groups(program)
            for companion in around.companions
            if companion not in later
            for inner in companion.programs
        ]
        others = [line for inner in coming for line in all_lines(inner)]
        if program not in self._contested.outside and not could_want(done, others):
            ways.used = ()

    def _margins(self, companion: Companion) -> Margins:
        none = np.broadcast_to(np.int64(0), len(self._block))
        least, most = none, np.broadcast_to(np.int64(-1), len(self._block))
        if companion.within:
            least, most = self._block.bounds(companion.within)
        elif companion.relation in _IN_TURN:
            most = np.broadcast_to(np.int64(FAR >> 1), len(self._block))
        return Margins(least, most, self._slack if companion.relation in _TOGETHER else none)

    @cached_property
    def _slack(self) -> Whole:
        """By how many frames edges may differ, by capture."""
        clocks, own = self._block.clocks()
        slack = [floor(self._block.tolerance * clock.rate) for clock in clocks]
        return np.array(slack, np.int64)[own]

    def _partners(self, companion: Companion) -> tuple[Others, Others]:
        """Return the other lines that those stand beside that are not alone, and those that are."""
        if companion not in self._others:
            forbidden = companion.relation in FORBIDDEN
            tables = [self.lines(program, forbidden=forbidden) for program in companion.programs]
            others = gathered(tables)
            every = Others(others)
            moving = Others(others.at(~others.alone)) if others.alone.any() else every
            self._others[companion] = moving, every
        return self._others[companion]

    def _look_only_in(self, program: Program, captures: Whole) -> None:
        """Look for the lines beside a program in some captures alone, if these are few enough."""
        there = np.zeros(len(self._block), bool)
        there[captures] = True
        if 2 * there.sum() < len(self._places) and not self._contested.states:
            self._places = np.flatnonzero(there)
            self._inner = Company(self._block.taken(self._places), self._contested)

    def _accompanied(self, companions: list[Companion], lines: Stretches) -> Mask:
        """Tell which lines have all that must stand beside them, whatever it takes."""
        found = np.ones(len(lines), bool)
        compared = replace(lines, low=lines.start, high=lines.until)
        for companion in companions if len(lines) else []:
            moving, every = self._partners(companion)
            margins = self._margins(companion)
            for alone, others in ((False, moving), (True, every)):
                own = np.flatnonzero(found & (lines.alone == alone))
                if len(own):
                    held = beside.holds(companion.relation, compared.at(own), others, margins)
                    found[own] = held & ~(alone and companion.relation in _IN_TURN)
        return found

    def _joined(self, companion: Companion, lines: Stretches, ways: Ways) -> Ways:
        """Return the ways to which another line comes that must be there."""
        relation = companion.relation
        open_ended = any(program.open_ended for program in companion.programs)
        if open_ended and relation in ("after", "ending with", "exactly with"):
            raise NotCovered
        wanted = np.zeros(len(lines), bool)
        wanted[ways.line] = True
        found = []
        for alone, others in zip((False, True), self._partners(companion), strict=True):
            own = np.flatnonzero(wanted & (lines.alone == alone))
            if len(own) and not (alone and relation in _IN_TURN):
                join = self._with_each if others.lines.used else self._with_best
                found.append(join(companion, lines, own, others, ways))
        return united(found) if found else ways.at(np.zeros(0, np.int64))

    def _with_best(
        self, companion: Companion, lines: Stretches, own: Whole, others: Others, ways: Ways
    ) -> Ways:
        """Return ways together with the best of the others; none wants what they took."""
        relation, margins = companion.relation, self._margins(companion)
        if relation in NO_FRAMES:
            held = own[beside.holds(relation, lines.at(own), others, margins)]
            return ways.at(np.isin(ways.line, held))
        line, low, high = beside.hulls(relation, lines.at(own), others, margins)
        way, place = beside.matched(ways.line, own[line])
        low, high = np.minimum(ways.low[way], low[place]), np.maximum(ways.high[way], high[place])
        return reduced(Ways(ways.line[way], low, high, tuple(it.at(way) for it in ways.used)))

    def _with_each(
        self, companion: Companion, lines: Stretches, own: Whole, others: Others, ways: Ways
    ) -> Ways:
        """Return ways together with each of the others that took nothing of theirs."""
        relation = companion.relation
        line, other = beside.pairs(relation, lines.at(own), others, self._margins(companion))
        way, place = beside.matched(ways.line, own[line])
        line, other = own[line][place], other[place]
        used = tuple(it.at(line) for it in lines.used) + tuple(it.at(way) for it in ways.used)
        more = tuple(it.at(other) for it in others.lines.used)
        if used:
            fits = apart(used, more)
            way, line, other = way[fits], line[fits], other[fits]
        low, high = ways.low[way], ways.high[way]
        if relation not in NO_FRAMES:
            low = np.minimum(low, others.lines.low[other])
            high = np.maximum(high, others.lines.high[other])
        used = tuple(it.at(way) for it in ways.used) + tuple(
            it.at(other) for it in others.lines.used
        )
        return Ways(line, low, high, used)

    def _disturbed(self, companion: Companion, lines: Stretches, ways: Ways) -> Mask:
        """Tell in which ways something happens that must not."""
        high = np.maximum(ways.high, lines.until[ways.line])
        hulls = Stretches(
            *(lines.capture[ways.line], ways.low, high, ways.low, high),
            lines.alone[ways.line],
            tuple(it.at(ways.line) for it in lines.used) + ways.used,
        )
        disturbed: Mask = np.zeros(len(hulls), bool)
        margins = self._margins(companion)
        for alone, others in zip((False, True), self._partners(companion), strict=True):
            own = np.flatnonzero(hulls.alone == alone)
            own = own[beside.holds(companion.relation, hulls.at(own), others, margins)]
            if hulls.used and others.lines.used:
                here = hulls.at(own)
                hull, other = beside.pairs(companion.relation, here, others, margins)
                one = tuple(it.at(hull) for it in here.used)
                another = tuple(it.at(other) for it in others.lines.used)
                own = own[np.unique(hull[apart(one, another)])]
            disturbed[own] = True
        return disturbed


def _needed(program: Program) -> list[Companion]:
    """Return what must stand beside a program."""
    every = [it for group in outer_groups(program) for it in group.companions]
    return [it for it in every if it.relation not in FORBIDDEN]


def _as(ways: Ways, lines: Stretches) -> Stretches:
    """Return ways as lines of their own."""
    lines = lines.at(ways.line)
    lines.low, lines.high, lines.used = ways.low, ways.high, lines.used + ways.used
    return lines


_TOGETHER = ("starting with", "ending with", "exactly with")
"""Relations of lines whose edges agree."""

_IN_TURN = ("after", "before")
"""Relations that a line which is no more than a starting position has to none."""


def _in_order(group: Group) -> list[Companion]:
    """Return the lines beside: what only chooses first, what must not happen last."""
    ranks = {**dict.fromkeys(NO_FRAMES, 0), **dict.fromkeys(FORBIDDEN, 2)}
    return sorted(group.companions, key=lambda it: ranks.get(it.relation, 1))
