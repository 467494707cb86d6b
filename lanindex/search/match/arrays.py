"""Ranges of many lengths at once: spread out, counted, and the smallest value in each.

The engine hardly ever loops: from each of a million events an arrow leads to a range of others,
and what is asked of all the ranges is asked in a few operations on arrays.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.search.match import budget

IntArray = NDArray[np.int64]
"""IntArray numbers: rows, frames, places in a table."""

BoolArray = NDArray[np.bool_]

AnyArray = NDArray[Any]

FAR = 1 << 40
"""More than any frame or row; times a number of captures it still fits 64 bits."""

MOST_AT_ONCE = 1 << 18
"""Pairs that are looked at before a search is told that it goes on."""

PAIR = 128
"""Bytes of a pair that is spread out, with all that is made of it."""


def spread(low: IntArray, high: IntArray) -> tuple[IntArray, IntArray]:
    """Return all pairs of a range's number and a place in it, for ranges ``[low, high)``.

    Raises
    ------
    TooMuch
        Where there are more than the budget allows.
    """
    counts = np.maximum(high - low, 0)
    total = int(counts.sum())
    if total > budget.rows(PAIR):
        raise budget.TooMuch
    ranges = np.repeat(np.arange(len(low)), counts)
    begins = np.cumsum(counts) - counts
    return ranges, np.arange(total) - np.repeat(begins - low, counts)


def in_pieces(counts: IntArray) -> Iterator[IntArray]:
    """Yield places, so many at once that their counts are together about `MOST_AT_ONCE`."""
    pieces = np.cumsum(counts) // min(MOST_AT_ONCE, budget.rows(4 * PAIR))
    yield from np.split(np.arange(len(counts)), np.flatnonzero(starts_of(pieces))[1:])


def starts_of(numbers: AnyArray) -> BoolArray:
    """Return which elements differ from the one before; the first does."""
    starts = np.ones(len(numbers), bool)
    starts[1:] = numbers[1:] != numbers[:-1]
    return starts


def once(numbers: IntArray) -> IntArray:
    """Return the different numbers, growing; what numpy has for this imports much."""
    numbers = np.sort(numbers)
    return numbers[starts_of(numbers)]


def smallest_from_here(values: IntArray, groups: IntArray) -> IntArray:
    """Return for each place the smallest value from there to the end of its group.

    Parameters
    ----------
    values : ndarray
        (N,) int64, 0 or more, below 2**43.
    groups : ndarray
        (N,) int64, from 0, growing, fewer than 2**19.
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

    Parameters
    ----------
    keys : tuple of ndarray
        (N,) each: what rows have in common; the first counts most in the order of the answer.
    ranks : tuple of ndarray
        (N,) each: smaller is better; the first counts most. Of equal rows the first one wins.
    """
    order = in_order((*keys, *ranks))
    new = np.zeros(len(order), bool)
    for key in keys:
        new |= starts_of(key[order])
    return order[new]


def in_order(columns: tuple[AnyArray, ...]) -> IntArray:
    """Return the places of rows in order of some columns; the first counts most, ties stay.

    Parameters
    ----------
    columns : tuple of ndarray
        (N,) whole numbers each.
    """
    if not len(columns[0]):
        return np.empty(0, np.int64)
    packed, room = np.zeros(len(columns[0]), np.int64), 63
    for column in columns:
        least, most = int(column.min()), int(column.max())
        room -= (most - least).bit_length()
        if room < 0:
            return np.lexsort(columns[::-1])
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
