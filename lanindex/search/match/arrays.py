"""Tables of columns, and ranges of many lengths at once.

The engine hardly ever loops: a million ranges are worked on in a few operations on arrays.
"""

from collections.abc import Iterator, Sequence
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from lanindex.search import limits
from lanindex.search.limits import check_budget, tick

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
AnyArray = NDArray[Any]

FAR = 1 << 40  # more than any frame or row; times a number of captures it still fits 64 bits
MOST_AT_ONCE = 1 << 18  # pairs made at once
PAIR = 128  # bytes of a pair that is spread out, with all that is made of it


class Table:
    """Columns of equal length: the fields of a dataclass with slots.

    A field is an array whose last axis are the rows, a tuple of such arrays, or another table.
    """

    __slots__: tuple[str, ...] = ()

    def at(self, rows: AnyArray) -> Self:
        """Return some rows, by their places or as a mask."""
        if rows.dtype == bool:
            rows = np.flatnonzero(rows)
        return type(self)(*(_at(getattr(self, name), rows) for name in self.__slots__))


AnyTable = TypeVar("AnyTable", bound=Table)


def _at(column: Any, rows: AnyArray) -> Any:
    tick()
    if isinstance(column, np.ndarray):
        return column.take(rows, axis=-1)  # faster than an index where there are two axes
    if isinstance(column, tuple):
        return tuple(it[rows] for it in column)
    return column.at(rows)


def together(tables: Sequence[AnyTable]) -> AnyTable:
    """Return the rows of several tables as one, one after the other."""
    first, *others = tables
    names = first.__slots__ if others else ()
    columns = ([getattr(it, name) for it in tables] for name in names)
    return type(first)(*map(_together, columns)) if others else first


def _together(columns: Sequence[Any]) -> Any:
    tick()
    if isinstance(columns[0], Table):
        return together(columns)
    return np.concatenate(columns) if columns[0].ndim == 1 else filled(columns)


def filled(tables: Sequence[IntArray]) -> IntArray:
    """Return tables of different heights side by side, filled up with `FAR`: (M, N)."""
    most = max(map(len, tables))
    if all(len(it) == most for it in tables):
        return np.concatenate(tables, axis=1)
    found = np.full((most, sum(it.shape[1] for it in tables)), FAR)
    begin = 0
    for it in tables:
        found[: len(it), begin : begin + it.shape[1]] = it
        begin += it.shape[1]
    return found


def spread(low: IntArray, high: IntArray) -> tuple[IntArray, IntArray]:
    """Return all pairs of a range's number and a place in it, for ranges ``[low, high)``.

    Raises `OverBudget` where there are more than the budget allows.
    """
    counts = np.maximum(high - low, 0)
    total = int(counts.sum())
    check_budget(total, PAIR)
    ranges = np.repeat(np.arange(len(low)), counts)
    begins = np.cumsum(counts) - counts
    return ranges, np.arange(total) - np.repeat(begins - low, counts)


def in_pieces(counts: IntArray) -> Iterator[IntArray]:
    """Yield places, so many at once that their counts are together about `MOST_AT_ONCE`."""
    most = min(MOST_AT_ONCE, limits.most_rows(4 * PAIR))
    if counts.sum() < most:
        yield np.arange(len(counts))
        return
    pieces = np.cumsum(counts) // most
    for piece in np.split(np.arange(len(counts)), np.flatnonzero(starts_of(pieces))[1:]):
        tick()
        yield piece


def starts_of(*columns: AnyArray) -> BoolArray:
    """Return which rows differ from the one before in any of some columns; the first does."""
    starts = np.zeros(len(columns[0]), bool)
    starts[:1] = True
    for column in columns:
        starts[1:] |= column[1:] != column[:-1]
    return starts


def once(numbers: IntArray) -> IntArray:
    """Return the different numbers, growing; what numpy has for this imports much."""
    numbers = np.sort(numbers)
    return numbers[starts_of(numbers)]


def smallest_from_here(values: IntArray, groups: IntArray) -> IntArray:
    """Return for each place the smallest value from there to the end of its group.

    Values are from 0 to 2**43; groups grow from 0 and are fewer than 2**19.
    """
    # Going backwards each group lies below the one behind it, so that the minimum begins anew.
    lifted = values + (groups << 43)
    smallest: IntArray = np.minimum.accumulate(lifted[::-1])[::-1] - (groups << 43)
    return smallest


def smallest_in(values: IntArray, low: IntArray, high: IntArray, nothing: int) -> IntArray:
    """Return the smallest value in each range ``[low, high)``, `nothing` where it is empty."""
    smallest = np.full(len(low), nothing, np.int64)
    widths = high - low
    some = np.flatnonzero(widths > 0)
    if not len(some):
        return smallest
    doublings = np.frexp(widths[some].astype(np.float64))[1] - 1
    table = values
    for doubling in range(int(doublings.max()) + 1):
        tick()
        here = some[doublings == doubling]
        if len(here):
            last = high[here] - (1 << doubling)
            smallest[here] = np.minimum(table[low[here]], table[last])
        step = 1 << doubling
        longer = table.copy()
        longer[: len(table) - step] = np.minimum(table[: len(table) - step], table[step:])
        table = longer
    return smallest


def best_of_each(keys: tuple[AnyArray, ...], ranks: tuple[AnyArray, ...]) -> IntArray:
    """Return the places of the rows that rank first among those with the same keys.

    They come in order of the keys, the first of which counts most; so does the first rank. The
    smallest rank is best; of equal rows the first one is.
    """
    order = in_order((*keys, *ranks))
    return order[starts_of(*(key[order] for key in keys))]


def grouped(columns: tuple[AnyArray, ...]) -> tuple[IntArray, IntArray]:
    """Return the places of different rows, in order, and for each row which of those it is."""
    order = in_order(columns)
    new = starts_of(*(_at(column, order) for column in columns))
    which = np.empty(len(order), np.int64)
    which[order] = np.cumsum(new) - 1
    return order[new], which


def _by_each(columns: tuple[AnyArray, ...]) -> IntArray:
    """Return what `in_order` does, column by column: `np.lexsort` says nothing meanwhile."""
    order = np.arange(len(columns[0]))
    for column in reversed(columns):
        order = order[np.argsort(_at(column, order), kind="stable")]
    return order


def in_order(columns: tuple[AnyArray, ...]) -> IntArray:
    """Return the places of rows in order of some columns of whole numbers, (N,) each.

    The first column counts most; of equal rows the first one comes first.
    """
    if not len(columns[0]):
        return np.empty(0, np.int64)
    packed, room = np.zeros(len(columns[0]), np.int64), 63
    for column in columns:
        tick()
        least, most = int(column.min()), int(column.max())
        room -= (most - least).bit_length()
        if room < 0:
            return _by_each(columns)
        packed <<= (most - least).bit_length()
        packed += column - least
    if (packed[1:] >= packed[:-1]).all():
        return np.arange(len(packed))
    room -= len(packed).bit_length()
    if room < 0:
        return np.argsort(packed, kind="stable")
    packed <<= len(packed).bit_length()  # numbers that differ are sorted faster than places
    packed += np.arange(len(packed))
    packed.sort()
    return packed & (1 << len(packed).bit_length()) - 1
