"""What lines have taken, as sets: of movements, stays and rests, and of what still has to be taken.

Of each line the claims are ranges of numbers, in order and apart from each other, so that equal
sets are equal columns: a part that repeats without end takes one range. Columns that are shorter
than others are filled up with `FAR`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lanindex.search.fast.ragged import FAR, Mask, Numbers, Whole


@dataclass(slots=True, eq=False)
class Taken:
    """Sets of claims, one a line.

    Attributes
    ----------
    first, last : ndarray
        (K, N) int64: ranges, both ends included.
    """

    first: Whole
    last: Whole

    def __len__(self) -> int:
        """Return of how many lines."""
        return int(self.first.shape[1])

    def __bool__(self) -> bool:
        """Return whether any line may have taken anything."""
        return bool(self.first.size)

    def at(self, chosen: Numbers) -> Taken:
        """Return those of some lines."""
        return Taken(self.first[:, chosen], self.last[:, chosen])

    @property
    def none(self) -> Mask:
        """Which lines have taken nothing, (N,) bool."""
        return self.first[0] >= FAR if self else np.ones(len(self), bool)

    def apart(self, other: Taken) -> Mask:
        """Tell which lines have nothing in common with the line of the same place in another."""
        found = np.ones(len(self), bool)
        for first, last in zip(self.first, self.last, strict=True):
            for begin, end in zip(other.first, other.last, strict=True):
                found &= (last < begin) | (end < first) | (begin >= FAR) | (first >= FAR)
        return found

    def with_those(self, other: Taken) -> Taken:
        """Return what each line and the one of the same place in another have taken together."""
        if not other or not self:
            return self if self else other
        first = np.concatenate((self.first, other.first))
        last = np.concatenate((self.last, other.last))
        order = np.argsort(first, axis=0, kind="stable")
        first = np.take_along_axis(first, order, axis=0)
        return _joined(first, np.take_along_axis(last, order, axis=0))


def in_sets(first: Whole, last: Whole) -> Taken:
    """Return ranges, in any order and some of them empty, as sets."""
    gone = first > last
    first, last = np.where(gone, FAR, first), np.where(gone, FAR, last)
    order = np.argsort(first, axis=0, kind="stable")
    many = int((first < FAR).sum(axis=0).max(initial=0))
    first = np.take_along_axis(first, order, axis=0)[:many]
    return Taken(first, np.take_along_axis(last, order, axis=0)[:many])


def _joined(first: Whole, last: Whole) -> Taken:
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
    return Taken(begin[:most], end[:most])


def nothing(lines: int) -> Taken:
    """Return what lines have taken that have taken nothing."""
    none = np.empty((0, lines), np.int64)
    return Taken(none, none)


def one_each(first: Whole, last: Whole) -> Taken:
    """Return what lines have taken that have taken one range each."""
    return Taken(first[np.newaxis], last[np.newaxis])


def beside_each_other(tables: list[Taken]) -> Taken:
    """Return what the lines of several tables have taken, one table after the other."""
    first, last = (filled([getattr(it, name) for it in tables]) for name in ("first", "last"))
    return Taken(first, last)


def filled(tables: list[Whole]) -> Whole:
    """Return columns of different lengths as one table, filled up with `FAR`."""
    most = max(len(it) for it in tables)
    found = np.full((most, sum(it.shape[1] for it in tables)), FAR)
    begin = 0
    for it in tables if most else ():
        found[: len(it), begin : begin + it.shape[1]] = it
        begin += it.shape[1]
    return found


def sets_together(one: Whole, other: Whole) -> Whole:
    """Return the numbers that stand in the columns of either table, (M, N), each once, in order."""
    if not len(one) or not len(other):
        return one if len(one) else other
    both = np.sort(np.concatenate((one, other)), axis=0)
    both[1:][both[1:] == both[:-1]] = FAR
    both = np.sort(both, axis=0)
    return both[: int((both < FAR).any(axis=1).sum())]
