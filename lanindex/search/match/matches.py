"""Partial matches as a table: all that their future depends on, and what they have claimed.

Of each the claims are ranges of numbers, in order and apart from each other, so that equal sets
are equal columns: a part that repeats without end claims one range. Columns that are shorter than
others are filled up with `FAR`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lanindex.search.match import budget
from lanindex.search.match.arrays import (
    FAR,
    AnyArray,
    BoolArray,
    IntArray,
    in_order,
    once,
    spread,
    starts_of,
)


@dataclass(slots=True, eq=False)
class Claims:
    """Sets of claims, one a line.

    Attributes
    ----------
    first, last : ndarray
        (K, N) int64: ranges, both ends included.
    """

    first: IntArray
    last: IntArray

    def __len__(self) -> int:
        """Return of how many lines."""
        return int(self.first.shape[1])

    def __bool__(self) -> bool:
        """Return whether any line may have taken anything."""
        return bool(self.first.size)

    def at(self, chosen: AnyArray) -> Claims:
        """Return those of some lines."""
        return Claims(self.first[:, chosen], self.last[:, chosen])

    @property
    def none(self) -> BoolArray:
        """Which lines have taken nothing, (N,) bool."""
        return self.first[0] >= FAR if self else np.ones(len(self), bool)

    def apart(self, other: Claims) -> BoolArray:
        """Tell which lines have nothing in common with the line of the same place in another."""
        found = np.ones(len(self), bool)
        for first, last in zip(self.first, self.last, strict=True):
            for begin, end in zip(other.first, other.last, strict=True):
                found &= (last < begin) | (end < first) | (begin >= FAR) | (first >= FAR)
        return found

    def with_those(self, other: Claims) -> Claims:
        """Return what each line and the one of the same place in another have taken together."""
        if not other or not self:
            return self if self else other
        first = np.concatenate((self.first, other.first))
        last = np.concatenate((self.last, other.last))
        order = np.argsort(first, axis=0, kind="stable")
        first = np.take_along_axis(first, order, axis=0)
        return _joined(first, np.take_along_axis(last, order, axis=0))


def in_sets(first: IntArray, last: IntArray) -> Claims:
    """Return ranges, in any order and some of them empty, as sets."""
    gone = first > last
    first, last = np.where(gone, FAR, first), np.where(gone, FAR, last)
    order = np.argsort(first, axis=0, kind="stable")
    many = int((first < FAR).sum(axis=0).max(initial=0))
    first = np.take_along_axis(first, order, axis=0)[:many]
    return Claims(first, np.take_along_axis(last, order, axis=0)[:many])


def _joined(first: IntArray, last: IntArray) -> Claims:
    """Return ranges in order, those that follow each other as one."""
    lines = np.arange(first.shape[1])
    begin, end = np.full_like(first, FAR), np.full_like(last, FAR)
    begin[0], end[0] = first[0], last[0]
    place = np.zeros(len(lines), np.int64)
    for next_first, next_last in zip(first[1:], last[1:], strict=True):
        on = next_first <= end[place, lines] + 1
        some = next_first < FAR
        place += some & ~on
        begin[place, lines] = np.where(some & ~on, next_first, begin[place, lines])
        latest = np.maximum(end[place, lines], next_last)
        end[place, lines] = np.where(some, np.where(on, latest, next_last), end[place, lines])
    most = int((begin < FAR).any(axis=1).sum())
    return Claims(begin[:most], end[:most])


def nothing(lines: int) -> Claims:
    """Return what lines have taken that have taken nothing."""
    none = np.empty((0, lines), np.int64)
    return Claims(none, none)


def one_each(first: IntArray, last: IntArray) -> Claims:
    """Return what lines have taken that have taken one range each."""
    return Claims(first[np.newaxis], last[np.newaxis])


def beside_each_other(tables: list[Claims]) -> Claims:
    """Return what the lines of several tables have taken, one table after the other."""
    first, last = (filled([getattr(it, name) for it in tables]) for name in ("first", "last"))
    return Claims(first, last)


def filled(tables: list[IntArray]) -> IntArray:
    """Return columns of different lengths as one table, filled up with `FAR`."""
    most = max(len(it) for it in tables)
    found = np.full((most, sum(it.shape[1] for it in tables)), FAR)
    begin = 0
    for it in tables if most else ():
        found[: len(it), begin : begin + it.shape[1]] = it
        begin += it.shape[1]
    return found


def sets_together(one: IntArray, other: IntArray) -> IntArray:
    """Return the numbers that stand in the columns of either table, (M, N), each once, in order."""
    if not len(one) or not len(other):
        return one if len(one) else other
    both = np.sort(np.concatenate((one, other)), axis=0)
    both[1:][both[1:] == both[:-1]] = FAR
    both = np.sort(both, axis=0)
    return both[: int((both < FAR).any(axis=1).sum())]


ROOT, EVENT, GROUPS = range(3)
"""What the first columns are: where a way began, at which event it stands, and then, of the whole
line and of each bracket that is open, the inner ones last, three each:"""

START, LOW, BEYOND = range(3)
"""Where it began; where the hull of all that matched since begins; and where that ends, if what is
beside goes on for longer than the line, else 0."""


@dataclass(slots=True, eq=False)
class Matches:
    """Ways, each with what it remembers.

    Attributes
    ----------
    columns : ndarray
        (W, N) int64: `ROOT`, `EVENT`, three a group, the frames of each step, if they are asked
        for, and what is noted of labels.
    claims : Claims
        What they have taken that another line could want.
    unmet : ndarray
        (M, N) int64: matches of lines that must not happen, from which they still have to take
        something; filled up with `FAR`.
    parent : ndarray
        (N,) int64: the node that they come from, -1: they begin there.
    link : ndarray
        (N,) int64: what joined since that node, a number in `Joins`; -1: nothing.
    """

    columns: IntArray
    claims: Claims
    unmet: IntArray
    parent: IntArray
    link: IntArray

    def __len__(self) -> int:
        """Return how many there are."""
        return int(self.columns.shape[1])

    def at(self, chosen: AnyArray) -> Matches:
        """Return some of them."""
        return Matches(
            *(self.columns[:, chosen], self.claims.at(chosen), self.unmet[:, chosen]),
            *(self.parent[chosen], self.link[chosen]),
        )

    def alike(self) -> tuple[Matches, IntArray]:
        """Return one of those that remember the same, and for each which of those it is."""
        root, event = self.columns[ROOT], self.columns[EVENT]
        if (np.diff(root) + (np.diff(event) > 0) * (np.diff(root) == 0) > 0).all():
            return self, np.arange(len(self))
        chosen, which = distinct([*self.columns, *self.rest()], len(self))
        return self.at(chosen), which

    def rest(self) -> list[IntArray]:
        """Return what they remember besides the columns."""
        return [*self.claims.first, *self.claims.last, *self.unmet]


def distinct(keys: list[IntArray], many: int) -> tuple[IntArray, IntArray]:
    """Return the places of different columns, and for each column which of those it is."""
    keys = telling(keys)
    if not keys:
        return np.arange(min(many, 1)), np.zeros(many, np.int64)
    order = in_order(tuple(keys))
    new = np.zeros(many, bool)
    for key in keys:
        new |= starts_of(key[order])
    which = np.empty(many, np.int64)
    which[order] = np.cumsum(new) - 1
    return order[new], which


def telling(keys: list[IntArray]) -> list[IntArray]:
    """Return the columns, of some rows, that tell rows apart, with small numbers for `FAR`."""
    found: list[IntArray] = []
    for key in keys:
        if (key != key[:1]).any() and not any(np.array_equal(key, it) for it in found):
            found.append(key)
    return [np.where(it < FAR, it, 1 + (it * (it < FAR)).max()) for it in found]


def beginning(columns: IntArray) -> Matches:
    """Return ways that have just begun."""
    many = columns.shape[1]
    none = np.empty((0, many), np.int64)
    return Matches(columns, nothing(many), none, np.full(many, -1), np.full(many, -1))


def carry_out(columns: IntArray, own: int, end: IntArray) -> None:
    """Add the hull of a group that closes to those around it."""
    low, beyond = columns[own + LOW], columns[own + BEYOND]
    for outer in range(GROUPS, own, 3):
        lows, beyonds = columns[outer + LOW], columns[outer + BEYOND]
        np.minimum(lows, low, out=lows)
        np.maximum(beyonds, np.where(beyond > end, beyond, 0), out=beyonds)
    columns[own : own + 3] = -1


def together(tables: list[Matches]) -> Matches:
    """Return the ways of several tables as one."""
    if len(tables) == 1:
        return tables[0]
    return Matches(
        np.concatenate([it.columns for it in tables], axis=1),
        beside_each_other([it.claims for it in tables]),
        filled([it.unmet for it in tables]),
        np.concatenate([it.parent for it in tables]),
        np.concatenate([it.link for it in tables]),
    )


class Nodes:
    """Which node of a walk comes from which, to tell what goes on in what."""

    def __init__(self) -> None:
        self.many = 0
        self._before: list[IntArray] = []
        self._after: list[IntArray] = []
        self._edges: tuple[IntArray, IntArray] | None = None

    def add(self, many: int, parent: IntArray, which: IntArray) -> IntArray:
        """Add nodes with those that they come from, and return their numbers."""
        own = np.arange(self.many, self.many + many)
        self.many, self._edges = self.many + many, None
        fits = parent >= 0
        self._before.append(parent[fits])
        self._after.append(own[which[fits]])
        return own

    def leading_to(self, nodes: IntArray) -> BoolArray:
        """Return which nodes are some of these, or go on in one of them, (nodes,) bool."""
        found = np.zeros(self.many, bool)
        before, bounds = self._backwards()
        todo = nodes
        while len(todo):
            found[todo] = True
            _, place = spread(bounds[todo], bounds[todo + 1])
            todo = before[place]
            todo = once(todo[~found[todo]])
        return found

    def _backwards(self) -> tuple[IntArray, IntArray]:
        """Return the nodes that each one comes from, one after the other, and their bounds."""
        if self._edges is None:
            before = np.concatenate(self._before or [np.empty(0, np.int64)])
            after = np.concatenate(self._after or [np.empty(0, np.int64)])
            order = np.argsort(after, kind="stable")
            bounds = np.searchsorted(after[order], np.arange(self.many + 1))
            self._edges = before[order], bounds
        return self._edges

    def behind(self, line: IntArray, node: IntArray) -> BoolArray:
        """Tell, of nodes of some lines, which go on in another one of the same line, (N,) bool.

        Parameters
        ----------
        line, node : ndarray
            (N,) int64; node -1: none.

        Raises
        ------
        TooMuch
            Where there are more pairs of a line and a node than the budget allows.
        """
        before, bounds = self._backwards()
        lines, own = np.unique(line, return_inverse=True)
        if len(lines) * self.many > budget.rows(8):
            raise budget.TooMuch
        behind = np.zeros(len(lines) * self.many, bool)
        todo = own * self.many + node
        while len(todo):
            base, last = todo - todo % max(self.many, 1), todo % max(self.many, 1)
            one, place = spread(bounds[last], bounds[last + 1])
            todo = base[one] + before[place]
            todo = once(todo[~behind[todo]])
            behind[todo] = True
        found: BoolArray = behind[own * self.many + node]
        return found
