"""Partial matches as a table: all that their future depends on, and the symbols they have claimed.

The claims of each are ranges of numbers, in order and apart from each other, so that equal sets
are equal columns: a part that repeats without end claims one range. Columns that are shorter than
others are filled up with `FAR`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lanindex.search.limits import check_budget, tick
from lanindex.search.match.arrays import FAR, BoolArray, IntArray, Table, grouped, once, spread


@dataclass(slots=True, eq=False)
class Claims(Table):
    """Sets of claims, one for each of N partial matches."""

    first: IntArray  # (K, N) ranges, both ends included
    last: IntArray  # (K, N)

    def __len__(self) -> int:
        return int(self.first.shape[1])

    def __bool__(self) -> bool:
        """Return whether any set may have claims."""
        return bool(self.first.size)

    @property
    def none(self) -> BoolArray:
        """Which sets are empty, (N,) bool."""
        return self.first[0] >= FAR if self else np.ones(len(self), bool)

    def disjoint(self, other: Claims) -> BoolArray:
        """Tell which sets share nothing with the other one in the same place, (N,) bool."""
        found = np.ones(len(self), bool)
        for first, last in zip(self.first, self.last, strict=True):
            for begin, end in zip(other.first, other.last, strict=True):
                found &= (last < begin) | (end < first) | (begin >= FAR) | (first >= FAR)
        return found

    def united_with(self, other: Claims) -> Claims:
        """Return the union of each set with the other one in the same place."""
        if not other or not self:
            return self if self else other
        first = np.concatenate((self.first, other.first))
        last = np.concatenate((self.last, other.last))
        order = np.argsort(first, axis=0, kind="stable")
        first = np.take_along_axis(first, order, axis=0)
        return _merged(first, np.take_along_axis(last, order, axis=0))


def in_sets(first: IntArray, last: IntArray) -> Claims:
    """Return ranges, in any order and some of them empty, as sets."""
    gone = first > last
    first, last = np.where(gone, FAR, first), np.where(gone, FAR, last)
    order = np.argsort(first, axis=0, kind="stable")
    many = int((first < FAR).sum(axis=0).max(initial=0))
    first = np.take_along_axis(first, order, axis=0)[:many]
    return Claims(first, np.take_along_axis(last, order, axis=0)[:many])


def _merged(first: IntArray, last: IntArray) -> Claims:
    """Return ranges in order as sets, those that follow each other as one."""
    begin, end, place = first.copy(), last.copy(), np.zeros(first.shape[1], np.int64)
    begin[1:] = end[1:] = FAR
    for next_first, next_last in zip(first[1:], last[1:], strict=True):
        some = np.flatnonzero(next_first < FAR)
        at = place[some]
        latest = end[at, some]
        apart = next_first[some] > latest + 1
        new = some[apart]
        place[new] += 1
        begin[place[new], new] = next_first[new]
        end[place[some], some] = np.maximum(next_last[some], np.where(apart, 0, latest))
    most = int((begin < FAR).any(axis=1).sum())
    return Claims(begin[:most], end[:most])


def no_claims(many: int) -> Claims:
    """Return empty sets."""
    none = np.empty((0, many), np.int64)
    return Claims(none, none)


def single_claims(first: IntArray, last: IntArray) -> Claims:
    """Return sets of one range each, (N,) both."""
    return Claims(first[np.newaxis], last[np.newaxis])


def united_columns(one: IntArray, other: IntArray) -> IntArray:
    """Return the union of two tables' columns, (M, N) numbers in order."""
    if not len(one) or not len(other):
        return one if len(one) else other
    both = np.sort(np.concatenate((one, other)), axis=0)
    both[1:][both[1:] == both[:-1]] = FAR
    both = np.sort(both, axis=0)
    return both[: int((both < FAR).any(axis=1).sum())]


FRAME_BITS = 31
LATEST = (1 << FRAME_BITS) - 1  # no frame is later
NEVER = LATEST << FRAME_BITS  # more than any rank of a hull


def hull_rank(low: IntArray, high: IntArray) -> IntArray:
    """Return numbers, (N,), by which hulls are ranked: the first to end, then the last to begin."""
    rank: IntArray = high << FRAME_BITS | LATEST - np.minimum(low, LATEST)
    return rank


ROOT, EVENT, GROUPS = range(3)
"""The first columns: where a match began, at which event it stands, and then three a group, of the
whole line and of each bracket that is open, the inner ones last:"""

START, LOW, BEYOND = range(3)
"""Where the group began; where the hull of all that matched since begins; and where that ends, if
what is beside goes on for longer than the line, else 0."""


@dataclass(slots=True, eq=False)
class Matches(Table):
    """Partial matches, each with what it remembers."""

    columns: IntArray  # (W, N) as above, the frames of each step in a rhythm, and notes of labels
    claims: Claims  # the symbols that another line could want
    unmet: IntArray  # (M, N) matches of negations, with which a symbol still has to be shared
    parent: IntArray  # (N,) the node that they come from, -1: they begin there
    link: IntArray  # (N,) what joined since that node, a number in `Joins`; -1: nothing

    def __len__(self) -> int:
        return int(self.columns.shape[1])

    def deduplicated(self) -> tuple[Matches, IntArray]:
        """Return the matches without duplicates, and for each which of them stands for it."""
        root, event = self.columns[ROOT], self.columns[EVENT]
        if (np.diff(root) + (np.diff(event) > 0) * (np.diff(root) == 0) > 0).all():
            return self, np.arange(len(self))
        chosen, which = distinct([*self.columns, *self.rest()], len(self))
        return self.at(chosen), which

    def rest(self) -> list[IntArray]:
        """Return claims and unmet matches as key columns, (N,) each."""
        return [*self.claims.first, *self.claims.last, *self.unmet]


def distinct(keys: list[IntArray], many: int) -> tuple[IntArray, IntArray]:
    """Return the places of different rows of (many,) keys, and which of those each row is."""
    keys = distinguishing(keys)
    if not keys:
        return np.arange(min(many, 1)), np.zeros(many, np.int64)
    return grouped(tuple(keys))


def distinguishing(keys: list[IntArray]) -> list[IntArray]:
    """Return the keys that differ between rows, each once, with small numbers for `FAR`."""
    found: list[IntArray] = []
    for key in keys:
        tick()
        if (key != key[:1]).any() and not any(np.array_equal(key, it) for it in found):
            found.append(key)
    return [np.where(it < FAR, it, 1 + (it * (it < FAR)).max()) for it in found]


def beginning(columns: IntArray) -> Matches:
    """Return partial matches that have just begun."""
    many = columns.shape[1]
    none = np.empty((0, many), np.int64)
    return Matches(columns, no_claims(many), none, np.full(many, -1), np.full(many, -1))


def close_group(columns: IntArray, offset: int, end: IntArray) -> None:
    """Add the hull of a group that closes to those around it."""
    low, beyond = columns[offset + LOW], columns[offset + BEYOND]
    for outer in range(GROUPS, offset, 3):
        lows, beyonds = columns[outer + LOW], columns[outer + BEYOND]
        np.minimum(lows, low, out=lows)
        np.maximum(beyonds, np.where(beyond > end, beyond, 0), out=beyonds)
    columns[offset : offset + 3] = -1


class Nodes:
    """The graph of a walk: a node for each partial match, linked to those that lead to it."""

    def __init__(self) -> None:
        self.many = 0
        self._pairs = [np.empty((2, 0), np.int64)]
        self._lows: list[IntArray] = []  # of the pairs after the first ones, where they are noted
        self._edges: tuple[IntArray, IntArray] | None = None

    def begin(self, many: int) -> IntArray:
        """Add nodes that come from no other one, and return their numbers."""
        self.many, self._edges = self.many + many, None
        return np.arange(self.many - many, self.many)

    def add(
        self, many: int, parent: IntArray, numbers: IntArray, low: IntArray | None = None
    ) -> IntArray:
        """Add nodes with those that they come from, and return their numbers.

        `low` is where the hull of what matched between the two begins.
        """
        nodes, fits = self.begin(many), parent >= 0
        self._pairs.append(np.stack((parent[fits], nodes[numbers[fits]])))
        if low is not None:
            self._lows.append(low[fits])
        return nodes

    def best_hulls(
        self, node: IntArray, low: IntArray, high: IntArray
    ) -> tuple[IntArray, IntArray]:
        """Return low and high of the best end that each node leads to, (nodes,); high -1: none.

        The best one ends first, and of those it begins last. `low` and `high` (N,) are those of
        ends at some nodes.
        """
        best = np.full(self.many, NEVER)
        np.minimum.at(best, node, hull_rank(low, high))
        for (before, after), low in zip(self._pairs[:0:-1], self._lows[::-1], strict=True):
            early = LATEST - np.minimum(low, LATEST)
            np.minimum.at(
                best, before, best[after] & ~LATEST | np.maximum(best[after] & LATEST, early)
            )
        return LATEST - (best & LATEST), np.where(best < NEVER, best >> FRAME_BITS, -1)

    def leading_to(self, nodes: IntArray) -> BoolArray:
        """Return which nodes are some of these, or go on in one of them, (nodes,) bool."""
        found = self._before(np.zeros(len(nodes), np.int64), nodes)
        found[nodes] = True
        return found

    def behind(self, line: IntArray, node: IntArray) -> BoolArray:
        """Tell, of nodes of some lines, which go on in another one of the same line, (N,) bool.

        Node -1 is none. `OverBudget` where lines times nodes are more than the budget allows.
        """
        found, some = np.zeros(len(node), bool), np.flatnonzero(node >= 0)
        own = grouped((line[some],))[1]
        found[some] = self._before(own, node[some])[own * self.many + node[some]]
        return found

    def _before(self, line: IntArray, node: IntArray) -> BoolArray:
        """Tell by line which nodes go on in one of its own (N,), as (lines * nodes,) bool."""
        if self._edges is None:
            before, after = np.concatenate(self._pairs, axis=1)
            order = np.argsort(after, kind="stable")
            self._edges = before[order], np.searchsorted(after[order], np.arange(self.many + 1))
        before, bounds = self._edges
        lines = int(line.max(initial=0)) + 1
        check_budget(lines * self.many, 8)
        found, todo = np.zeros(lines * self.many, bool), line * self.many + node
        while len(todo):
            base, last = todo - todo % max(self.many, 1), todo % max(self.many, 1)
            one, place = spread(bounds[last], bounds[last + 1])
            todo = base[one] + before[place]
            todo = once(todo[~found[todo]])
            found[todo] = True
        return found
