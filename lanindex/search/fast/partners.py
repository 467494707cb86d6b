"""What stands beside a line, or must not, with all that the lines have to remember."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np

from lanindex.search.automaton import Companion, Group, Program
from lanindex.search.fast import beside, taken
from lanindex.search.fast.beside import FORBIDDEN, NO_FRAMES, Margins, Stretches
from lanindex.search.fast.ends import Found
from lanindex.search.fast.memory import Nodes, distinct
from lanindex.search.fast.ragged import FAR, Mask, Numbers, TooMuch, Whole, starts_of
from lanindex.search.fast.recall import Recall
from lanindex.search.fast.setting import Hulls, Setting
from lanindex.search.fast.taken import Taken, filled, sets_together

MOST_MARKS = 1 << 27
"""How many pairs of a line and a node beside it may be noted."""


@dataclass(slots=True, eq=False)
class Others:
    """The ways of a line that stands beside another.

    Attributes
    ----------
    lines : Stretches
        Their frames.
    taken, owed, seen
        What they remember, as in `Memory`.
    node, walk : ndarray
        (N,) int64: where they end, and in which of `walks`.
    walks : list of Nodes
        One a program.
    """

    lines: Stretches
    taken: Taken
    owed: Whole
    seen: Whole
    node: Whole
    walk: Whole
    walks: list[Nodes]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.node)

    def at(self, chosen: Numbers) -> Others:
        """Return some of them."""
        memory = self.taken.at(chosen), self.owed[:, chosen], self.seen[:, chosen]
        own = self.node[chosen], self.walk[chosen]
        return Others(self.lines.at(chosen), *memory, *own, self.walks)

    def keys(self) -> list[Whole]:
        """Return what they look like from outside."""
        lines = self.lines
        frames = [lines.capture, lines.start, lines.until, lines.low, lines.high]
        rest = [*self.taken.first, *self.taken.last, *self.owed, *self.seen]
        return [*frames, lines.alone.astype(np.int64), *rest]


class Partners:
    """Finds what stands beside lines.

    Parameters
    ----------
    setting : Setting
        Where, and what is asked.
    """

    def __init__(self, setting: Setting) -> None:
        self._setting, self._block = setting, setting.block
        clocks, own = self._block.clocks()
        slack = [floor(self._block.tolerance * clock.rate) for clock in clocks]
        self._slack = np.array(slack, np.int64)[own]
        self._found: dict[tuple[Program, ...], Others] = {}
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
        for companion in group.companions:
            if companion.relation not in FORBIDDEN:
                self._setting.tick()
                hulls = self._with(companion, lines, hulls, whole=whole)
        for companion in group.companions:
            if companion.relation in FORBIDDEN:
                self._setting.tick()
                hulls = self._without(companion, lines, hulls)
        return hulls

    def unpaid(self, owed: Whole, had: Taken) -> Whole:
        """Return what is still owed of what ways have to take, (M, N)."""
        if not owed.size:
            return owed[:0]
        left = owed.copy()
        for column in left:
            some = np.flatnonzero(column < FAR)
            paid = ~self._matches.at(column[some]).apart(had.at(some))
            column[some[paid]] = FAR
        left = np.sort(left, axis=0)
        return left[: int((left < FAR).any(axis=1).sum())]

    def others(self, companion: Companion) -> Others:
        """Return all ways of the line of a companion."""
        programs = companion.programs
        if programs not in self._found:
            runs_on = any(program.open_ended for program in programs)
            tables = []
            walks = []
            for number, program in enumerate(programs):
                recall = Recall(self._setting, program, tracked=runs_on)
                walks.append(recall.nodes)
                tables.append(self._from_outside(program, recall.found(), number))
            found = _gathered(tables, walks)
            if not runs_on:
                found = found.at(distinct(found.keys(), len(found))[0])
            self._found[programs] = found
        return self._found[programs]

    def _from_outside(self, program: Program, found: Found, number: int) -> Others:
        """Return ways of a line as others see them."""
        lines = Stretches(
            *(found.capture, found.start, found.until, found.low, found.high, found.alone)
        )
        memory, asked = found.memory, self._setting.asked
        owed = self.unpaid(memory.owed, memory.taken)
        had = memory.taken if program in self._setting.outside else taken.nothing(len(memory))
        seen = memory.columns[len(memory.columns) - len(asked.columns) :]
        own = found.node, np.full(len(memory), number)
        others = Others(lines, had, owed, seen, *own, [])
        conditions = [it for it in asked.conditions if it not in asked.of_all]
        return others.at(self._setting.met_where_known(conditions, found.capture, seen))

    def _margins(self, companion: Companion) -> Margins:
        none = np.zeros(len(self._block), np.int64)
        if companion.within:
            least, most = self._block.bounds(companion.within)
            return Margins(least, most, self._slack)
        if companion.relation in ("after", "before"):
            return Margins(none, none + (FAR >> 1), self._slack)
        return Margins(none, none - 1, self._slack)

    def _with(self, companion: Companion, lines: Stretches, hulls: Hulls, *, whole: bool) -> Hulls:
        """Return the ways to which a line comes that must be there."""
        others = self.others(companion)
        wanted = np.zeros(len(lines), bool)
        wanted[hulls.line] = True
        pieces = [hulls.at(np.zeros(0, np.int64))]
        for alone in (False, True):
            own = np.flatnonzero(wanted & (lines.alone == alone))
            if len(own) and not (alone and companion.relation in ("after", "before")):
                some = others if alone else others.at(np.flatnonzero(~others.lines.alone))
                pieces.append(self._joined(companion, (lines, own), hulls, some, whole=whole))
        return self._reduced(_all_hulls(pieces))

    def _joined(
        self,
        companion: Companion,
        which: tuple[Stretches, Whole],
        hulls: Hulls,
        others: Others,
        *,
        whole: bool,
    ) -> Hulls:
        """Return the ways of some lines with each of the others that can stand beside them."""
        (lines, own), relation = which, companion.relation
        margins = self._margins(companion)
        keys = [lines.capture[own], lines.start[own], lines.until[own]]
        once, alike = distinct(keys, len(own))  # ways differ, where they stand hardly does
        here = lines.at(own[once])
        stands = np.full(len(lines), -1)
        stands[own] = alike
        runs_on = any(program.open_ended for program in companion.programs)
        simple = not (runs_on or others.taken or others.owed.size or len(others.seen))
        if simple and not self._setting.asked.of_frames:
            return self._with_best(relation, (here, stands), hulls, others, margins)
        line, other = _pairs(relation, here, others.lines, margins)
        way, place = beside.matched(stands[hulls.line], line)
        other = other[place]
        fits = hulls.taken.at(way).apart(others.taken.at(other))
        way, other = way[fits], other[fits]
        seen = np.maximum(hulls.seen[:, way], others.seen[:, other])
        if whole or not runs_on:
            asked = self._setting.asked
            conditions = [it for it in asked.conditions if it not in asked.of_all]
            capture = lines.capture[hulls.line[way]]
            kept = self._setting.met_where_known(conditions, capture, seen)
            way, other, seen = way[kept], other[kept], seen[:, kept]
        if runs_on:
            kept = np.flatnonzero(~_goes_on(others, way, other))
            way, other, seen = way[kept], other[kept], seen[:, kept]
        low, high = hulls.low[way], hulls.high[way]
        if relation not in NO_FRAMES:
            low = np.minimum(low, others.lines.low[other])
            high = np.maximum(high, others.lines.high[other])
        had = hulls.taken.at(way).with_those(others.taken.at(other))
        owed = sets_together(hulls.owed[:, way], others.owed[:, other])
        return Hulls(hulls.line[way], low, high, had, owed, seen)

    def _with_best(
        self,
        relation: str,
        which: tuple[Stretches, Whole],
        hulls: Hulls,
        others: Others,
        margins: Margins,
    ) -> Hulls:
        """Return the ways of some lines with the best of others that remember nothing."""
        here, stands = which
        place = stands[hulls.line]
        if relation in NO_FRAMES:
            held = np.append(
                beside.holds(relation, here, beside.Others(others.lines), margins), False
            )
            return hulls.at(np.flatnonzero(held[place]))
        line, low, high = beside.hulls(relation, here, beside.Others(others.lines), margins)
        way, place = beside.matched(place, line)
        found = hulls.at(way)
        found.low = np.minimum(found.low, low[place])
        found.high = np.maximum(found.high, high[place])
        return found

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

    def _without(self, companion: Companion, lines: Stretches, hulls: Hulls) -> Hulls:
        """Return the ways in which nothing happens that must not, with what they owe for that."""
        others, base = self._forbidden(companion)
        capture, alone = lines.capture[hulls.line], lines.alone[hulls.line]
        low, high = hulls.low, hulls.high
        here = Stretches(capture, low, high, low, high, alone)
        margins, free = self._margins(companion), others.taken.none
        disturbed = np.zeros(len(here), bool)
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
            hull, other = _pairs(companion.relation, here.at(own), others.lines.at(owed), margins)
            hull, other = own[hull], owed[other]
            apart = hulls.taken.at(hull).apart(others.taken.at(other))
            owing.append(np.stack((hull[apart], other[apart] + base)))
        pairs = np.concatenate(owing, axis=1)
        hulls.owed = sets_together(hulls.owed, _by_line(pairs, len(here)))
        return hulls.at(np.flatnonzero(~disturbed))

    def _forbidden(self, companion: Companion) -> tuple[Others, int]:
        """Return the matches of a line that must not happen, and where their numbers begin."""
        programs = companion.programs
        if programs not in self._alone:
            others = self.others(companion)
            others = others.at(np.flatnonzero((others.owed >= FAR).all(axis=0)))
            lines = others.lines
            keys = [lines.capture, lines.start, lines.until, lines.alone.astype(np.int64)]
            keys += [*others.taken.first, *others.taken.last]
            others = others.at(distinct(keys, len(others))[0])
            self._alone[programs] = others, len(self._matches)
            self._matches = taken.beside_each_other([self._matches, others.taken])
        return self._alone[programs]


def _pairs(
    relation: str, lines: Stretches, others: Stretches, margins: Margins
) -> tuple[Whole, Whole]:
    """Return all pairs of a line and another one that stands beside it, by place."""
    ordered = beside.Others(others)
    line, place = beside.pairs(relation, lines, ordered, margins)
    return line, ordered.order[place]


def _goes_on(others: Others, way: Whole, other: Whole) -> Mask:
    """Tell which of the others beside each way go on in another one beside the same."""
    found = np.zeros(len(way), bool)
    for number, nodes in enumerate(others.walks):
        own = np.flatnonzero(others.walk[other] == number)
        found[own] = nodes.behind(way[own], others.node[other[own]], MOST_MARKS)
    return found


def _by_line(pairs: Whole, lines: int) -> Whole:
    """Return what each line is paired with as columns, filled up with `FAR`."""
    pairs = pairs[:, np.lexsort(pairs[::-1])]
    counts = np.bincount(pairs[0], minlength=lines)
    most = int(counts.max(initial=0))
    if most * lines > MOST_MARKS:
        raise TooMuch
    found = np.full((most, lines), FAR)
    begin = np.cumsum(counts) - counts
    found[np.arange(pairs.shape[1]) - begin[pairs[0]], pairs[0]] = pairs[1]
    return found


def _gathered(tables: list[Others], walks: list[Nodes]) -> Others:
    return Others(
        beside.gathered([it.lines for it in tables]),
        taken.beside_each_other([it.taken for it in tables]),
        filled([it.owed for it in tables]),
        np.concatenate([it.seen for it in tables], axis=1),
        np.concatenate([it.node for it in tables]),
        np.concatenate([it.walk for it in tables]),
        walks,
    )


def _all_hulls(tables: list[Hulls]) -> Hulls:
    """Return the ways of several tables, in order of their lines."""
    line, low, high = (
        np.concatenate([getattr(it, name) for it in tables]) for name in ("line", "low", "high")
    )
    had = taken.beside_each_other([it.taken for it in tables])
    owed = filled([it.owed for it in tables])
    seen = np.concatenate([it.seen for it in tables], axis=1)
    hulls = Hulls(line, low, high, had, owed, seen)
    return hulls.at(np.argsort(hulls.line, kind="stable"))
