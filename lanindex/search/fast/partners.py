"""What stands beside a line, or must not, with all that the lines have to remember."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from lanindex.search.automaton import Companion, Group, Program
from lanindex.search.fast import beside, budget, taken
from lanindex.search.fast.abreast import standing
from lanindex.search.fast.beside import FORBIDDEN, NO_FRAMES, Margins, Stretches, smallest
from lanindex.search.fast.forgiven import by_line, paired, unforgiven
from lanindex.search.fast.memory import distinct
from lanindex.search.fast.others import Others, gathered
from lanindex.search.fast.ragged import FAR, PAIR, Whole, starts_of
from lanindex.search.fast.recall import Recall
from lanindex.search.fast.setting import Hulls, Setting
from lanindex.search.fast.tails import LONGER_BESIDE, enough_beside
from lanindex.search.fast.taken import Taken, filled, sets_together

_BOTH = ("start", "until")
_COMPARED = {
    **dict.fromkeys(("starting with", "after"), ("start",)),
    **dict.fromkeys(("ending with", "before"), ("until",)),
}
"""What of a line is compared with others."""


MOST_AT_ONCE = 1 << 18
"""Pairs of lines that are joined before the search is told that it goes on."""


class Standing(NamedTuple):
    """Where lines stand: one each of those that are compared alike.

    Attributes
    ----------
    here : Stretches
        Those.
    place : ndarray
        (N,) int64: by way, which of them; -1: none.
    margins : Margins
        How near others must lie.
    """

    here: Stretches
    place: Whole
    margins: Margins

    def at(self, some: Whole) -> Standing:
        """Return where some ways stand."""
        if len(some) == len(self.place):
            return self
        used, place = np.unique(self.place[some], return_inverse=True)
        missing = int(len(used) > 0 and used[0] < 0)
        return Standing(self.here.at(used[missing:]), place - missing, self.margins)


class Partners:
    """Finds what stands beside lines.

    Parameters
    ----------
    setting : Setting
        Where, and what is asked.
    program : Program
        The leading line.
    """

    def __init__(self, setting: Setting, program: Program) -> None:
        beside_it = program.whole.companions
        self._standing = {companion: standing(program, companion) for companion in beside_it}
        self._setting, self._block = setting, setting.block
        self._found: dict[tuple[Program, str | None], Others] = {}
        self._last: dict[Program, Others] = {}
        self._alone: dict[tuple[Program, ...], tuple[Others, int]] = {}
        self._matches = taken.nothing(0)

    def close(self, group: Group, lines: Stretches, hulls: Hulls, *, whole: bool) -> Hulls:
        """Return the ways in which a group can close.

        Parameters
        ----------
        group : Group
            Any.
        lines : Stretches
            Of its own line, as far as it has come.
        hulls : Hulls
            One for each of those.
        whole : bool
            Whether it is all of a leading line.
        """
        needed = [it for it in group.companions if it.relation not in FORBIDDEN]
        for companion in needed if len(needed) > 1 else ():
            if len(hulls.line):
                hulls = self._accompanied(companion, lines, hulls)
        for companion in needed:
            if len(hulls.line):
                self._setting.tick()
                hulls = self._with(companion, lines, hulls, whole=whole)
        for companion in group.companions:
            if companion.relation in FORBIDDEN and self._programs(companion) and len(hulls.line):
                self._setting.tick()
                hulls = self._without(companion, lines, hulls, whole=whole)
        return hulls

    def unpaid(self, owed: Whole, had: Taken) -> Whole:
        """Return what is still owed of what ways have to take, (M, N)."""
        if not owed.size:
            return owed[:0]
        left, (column, way) = owed.copy(), np.nonzero(owed < FAR)
        forgiven = self._setting.forgiving(had).at(way)
        paid = ~self._matches.at(owed[column, way]).apart(forgiven)
        left[column[paid], way[paid]] = FAR
        left = np.sort(left, axis=0)
        return left[: int((left < FAR).any(axis=1).sum())]

    def others(self, program: Program, companion: Companion) -> Others:
        """Return the ways of a line that stands beside another, as far as they matter."""
        end = enough_beside(program, companion)
        if (program, end) not in self._found:
            found = self._from_outside(program, self._walk(program, end))
            if not program.open_ended:
                found = found.at(distinct(found.keys(), len(found))[0])
            self._found[program, end] = found
        return self._found[program, end]

    def _walk(self, program: Program, enough: str | None) -> Recall:
        return Recall(self._setting, program, tracked=program.open_ended, enough=enough)

    def _programs(self, companion: Companion) -> tuple[Program, ...]:
        """Return the lines, one a side, that can be what is asked for beside another."""
        return self._standing.get(companion, companion.programs)

    def _beside(self, program: Program, companion: Companion) -> Others:
        """Return the ways of a line that may stand beside another.

        Of one that runs on as long as it can the longest will do, if those that are shorter stand
        only where it does, too.
        """
        others = self.others(program, companion)
        if others.nodes and others.free and companion.relation in LONGER_BESIDE:
            if program not in self._last:
                self._last[program] = others.last()
            return self._last[program]
        return others

    def _from_outside(self, program: Program, recall: Recall) -> Others:
        """Return ways of a line as others see them."""
        found = recall.found()
        lines = Stretches(
            *(found.capture, found.start, found.until, found.low, found.high, found.alone)
        )
        memory, asked = found.memory, self._setting.asked
        owed = self.unpaid(memory.owed, memory.taken)
        had = memory.taken if program in self._setting.outside else taken.nothing(len(memory))
        seen = memory.columns[len(memory.columns) - len(asked.columns) :]
        nodes = recall.nodes if program.open_ended else None
        ends = self._setting.joins.ended(recall, len(memory))
        others = Others(lines, had, owed, seen, found.node, ends, nodes)
        conditions = [it for it in asked.conditions if it not in asked.of_all]
        return others.at(self._setting.met_where_known(conditions, found.capture, seen))

    def _margins(self, companion: Companion) -> Margins:
        none = np.zeros(len(self._block), np.int64)
        if companion.within:
            least, most = self._block.bounds(companion.within)
            return Margins(least, most, self._setting.slack)
        if companion.relation in ("after", "before"):
            return Margins(none, none + (FAR >> 1), self._setting.slack)
        return Margins(none, none - 1, self._setting.slack)

    def _with(self, companion: Companion, lines: Stretches, hulls: Hulls, *, whole: bool) -> Hulls:
        """Return the ways to which a line comes that must be there."""
        relation = companion.relation
        wanted = np.zeros(len(lines), bool)
        wanted[hulls.line] = True
        pieces = [hulls.at(np.zeros(0, np.int64))]
        for alone in (False, True):
            own = np.flatnonzero(wanted & (lines.alone == alone))
            if not len(own) or (alone and relation in ("after", "before")):
                continue
            # ways differ, where they stand hardly does
            compared = _COMPARED.get(relation, _BOTH)
            keys = [getattr(lines, it)[own] for it in ("capture", *compared)]
            once, alike = distinct(keys, len(own))
            stands = np.full(len(lines), -1)
            stands[own] = alike
            here = lines.at(own[once])  # those that stand alike have hulls of their own
            here.high = np.zeros(len(here), np.int64)
            here.low = here.start if "start" in compared else here.high + FAR - 1
            line = Standing(here, stands[hulls.line], self._margins(companion))
            for program in self._programs(companion):
                others = self._beside(program, companion)
                if not alone:
                    others = others.at(np.flatnonzero(~others.lines.alone))
                join = self._with_free if others.free else self._with_each
                for some in _pieces(relation, line, others):
                    joined = join(relation, line.at(some), hulls.at(some), others, whole=whole)
                    answered = self._setting.tried(lines.capture[joined.line])
                    if answered is not None:
                        joined = joined.at(np.flatnonzero(answered))
                    pieces.append(joined if len(some) == len(line.place) else self._reduced(joined))
                    self._setting.tick()
        return self._reduced(_all_hulls(pieces))

    def _accompanied(self, companion: Companion, lines: Stretches, hulls: Hulls) -> Hulls:
        """Return the ways that have a line beside them at all, whatever it takes."""
        found = np.zeros(len(lines), bool)
        for program in self._programs(companion):
            others = self._beside(program, companion).lines
            for alone in (False, True):
                own = np.flatnonzero(lines.alone == alone)
                some = others if alone else others.at(~others.alone)
                margins = self._margins(companion)
                found[own] |= beside.holds(
                    companion.relation, lines.at(own), beside.Others(some), margins
                )
        return hulls.at(np.flatnonzero(found[hulls.line]))

    def _with_each(
        self, relation: str, line: Standing, hulls: Hulls, others: Others, *, whole: bool
    ) -> Hulls:
        """Return ways with each of the others that can stand beside them."""
        place, other = paired(relation, line.here, others.lines, line.margins)
        way, place = beside.matched(line.place, place)
        other = other[place]
        fits = hulls.taken.at(way).apart(others.taken.at(other))
        way, other = way[fits], other[fits]
        seen = np.maximum(hulls.seen[:, way], others.seen[:, other])
        if whole or not others.nodes:
            asked = self._setting.asked
            conditions = [it for it in asked.conditions if it not in asked.of_all]
            capture = others.lines.capture[other]
            kept = self._setting.met_where_known(conditions, capture, seen)
            way, other, seen = way[kept], other[kept], seen[:, kept]
        if others.nodes:
            kept = np.flatnonzero(~others.nodes.behind(way, others.node[other]))
            way, other, seen = way[kept], other[kept], seen[:, kept]
        low, high = hulls.low[way], hulls.high[way]
        if relation not in NO_FRAMES:
            low = np.minimum(low, others.lines.low[other])
            high = np.maximum(high, others.lines.high[other])
        had = hulls.taken.at(way).with_those(others.taken.at(other))
        owed = sets_together(hulls.owed[:, way], others.owed[:, other])
        link = self._setting.joins.add(hulls.link[way], others.end[other])
        return Hulls(hulls.line[way], low, high, had, owed, seen, link)

    def _with_free(
        self, relation: str, line: Standing, hulls: Hulls, others: Others, *, whole: bool
    ) -> Hulls:
        """Return ways with others that remember nothing: once for each place where lines stand."""
        of_frames = self._setting.asked.of_frames
        if not others.nodes and relation in NO_FRAMES:
            held = beside.holds(relation, line.here, beside.Others(others.lines), line.margins)
            return hulls.at(np.flatnonzero(np.append(held, False)[line.place]))
        if not others.nodes and not of_frames:
            place, low, high = beside.hulls(
                relation, line.here, beside.Others(others.lines), line.margins
            )
        else:
            place, other = paired(relation, line.here, others.lines, line.margins)
            if others.nodes:
                kept = ~others.nodes.behind(place, others.node[other])
                place, other = place[kept], other[kept]
            if relation in NO_FRAMES:
                return hulls.at(np.flatnonzero(np.isin(line.place, place)))
            low, high = others.lines.low[other], others.lines.high[other]
            if not of_frames:
                place, low, high = smallest(place, low, high)
        way, which = beside.matched(line.place, place)
        joined = hulls.at(way)
        joined.low = np.minimum(joined.low, low[which])
        joined.high = np.maximum(joined.high, high[which])
        return joined

    def _reduced(self, hulls: Hulls) -> Hulls:
        """Return ways without those that others are better than: no larger, and alike else."""
        keys = [hulls.line, *hulls.taken.first, *hulls.taken.last, *hulls.owed, *hulls.seen]
        if self._setting.asked.of_frames:
            chosen, _ = distinct([*keys, hulls.low, hulls.high], len(hulls.line))
            return hulls.at(np.sort(chosen))
        _, which = distinct(keys, len(hulls.line))
        order = np.lexsort((-hulls.low, hulls.high, which))
        reach = (which * FAR + hulls.low)[order]
        kept = starts_of(which[order])
        kept[1:] |= reach[1:] > np.maximum.accumulate(reach)[:-1]
        return hulls.at(np.sort(order[kept]))

    def _without(
        self, companion: Companion, lines: Stretches, hulls: Hulls, *, whole: bool
    ) -> Hulls:
        """Return the ways in which nothing happens that must not, with what they owe for that.

        All of a leading line owes nothing: no more is used that could still forgive a match.
        """
        others, base = self._forbidden(companion)
        capture, alone = lines.capture[hulls.line], lines.alone[hulls.line]
        low, high = hulls.low, np.maximum(hulls.high, lines.until[hulls.line])
        here = Stretches(capture, low, high, low, high, alone)
        margins, free = self._margins(companion), others.taken.none
        disturbed = np.zeros(len(here), bool)
        forgiven = self._setting.forgiving(hulls.taken)
        owing: list[Whole] = []
        for still in (False, True):
            own = np.flatnonzero(alone == still)
            fits = np.ones(len(others), bool) if still else ~others.lines.alone
            some = others.lines.at(np.flatnonzero(fits & free))
            if companion.relation == "never":
                disturbed[own] |= np.isin(capture[own], some.capture)
            else:
                disturbed[own] |= beside.holds(
                    "without", here.at(own), beside.Others(some), margins
                )
            owed = np.flatnonzero(fits & ~free)
            matches = others.lines.at(owed)
            if whole and not still:
                told = here.at(own), forgiven.at(own), matches, others.taken.at(owed), margins
                disturbed[own] |= unforgiven(companion.relation, *told)
                continue
            hull, other = paired(companion.relation, here.at(own), matches, margins)
            hull, other = own[hull], owed[other]
            apart = forgiven.at(hull).apart(others.taken.at(other))
            if whole:
                disturbed[hull[apart]] = True
            else:
                owing.append(np.stack((hull[apart], other[apart] + base)))
        if owing:
            pairs = np.concatenate(owing, axis=1)
            hulls.owed = sets_together(hulls.owed, by_line(pairs, len(here)))
        return hulls.at(np.flatnonzero(~disturbed))

    def _forbidden(self, companion: Companion) -> tuple[Others, int]:
        """Return the matches of a line that must not happen, and where their numbers begin."""
        programs = self._programs(companion)
        if programs not in self._alone:
            others = gathered([self.others(program, companion) for program in programs])
            others = others.at(np.flatnonzero((others.owed >= FAR).all(axis=0)))
            lines = others.lines
            keys = [lines.capture, lines.start, lines.until, lines.alone.astype(np.int64)]
            keys += [*others.taken.first, *others.taken.last]
            others = others.at(distinct(keys, len(others))[0])
            self._alone[programs] = others, len(self._matches)
            self._matches = taken.beside_each_other([self._matches, others.taken])
        return self._alone[programs]


def _pieces(relation: str, line: Standing, others: Others) -> Iterator[Whole]:
    """Yield ways, so many at once that the pairs of them and others keep within the budget."""
    most, every = min(budget.rows(4 * PAIR), MOST_AT_ONCE), np.arange(len(line.place))
    few = len(every) * len(others) <= most
    if few or (relation == "with" and others.free and others.lines.plain):  # few pairs are made
        yield every
        return
    many = beside.many(relation, line.here, beside.Others(others.lines), line.margins)
    pairs = np.cumsum(np.append(many, 0)[line.place])
    yield from np.split(every, np.flatnonzero(starts_of(pairs // most))[1:])


def _all_hulls(tables: list[Hulls]) -> Hulls:
    """Return the ways of several tables, in order of their lines."""
    line, low, high = (
        np.concatenate([getattr(it, name) for it in tables]) for name in ("line", "low", "high")
    )
    had = taken.beside_each_other([it.taken for it in tables])
    owed = filled([it.owed for it in tables])
    seen = np.concatenate([it.seen for it in tables], axis=1)
    link = np.concatenate([it.link for it in tables])
    hulls = Hulls(line, low, high, had, owed, seen, link)
    return hulls.at(np.argsort(hulls.line, kind="stable"))
