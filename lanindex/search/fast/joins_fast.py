"""The loops of a search over many rows, compiled (extra ``fast``).

Each does what a function without it does, which is its test and its explanation.
"""

from __future__ import annotations

import numba
import numpy as np

from lanindex.model.columns import PASSING, STARTING
from lanindex.search.fast.ragged import FAR

_ONE, _NONE = np.uint64(1), np.uint64(0)
_FAR = np.int64(FAR)


@numba.njit(cache=True, nogil=True)
def in_order(
    cell, start, stop, bounds, captures, accepts, first, last, following, timed, limits, found
):
    """Note in which captures an order occurs, as `order.plainly` tells."""
    for place in range(len(captures)):
        capture = captures[place]
        pending, later, ever, closing, seen = _NONE, _NONE, _NONE, _NONE, 0
        for row in range(bounds[capture], bounds[capture + 1]):
            here = cell[row]
            shown = 0 if here & PASSING else 1
            if here & STARTING:
                pending, later = _NONE, _NONE
            accepted = accepts[here]
            opening = first[1, shown] if seen <= 1 else _NONE
            if accepted:
                lasts = np.int64(stop[row]) - start[row]
                for number in range(len(timed)):
                    least, most = limits[number, 0, capture], limits[number, 1, capture]
                    if lasts < least or lasts > most:
                        accepted &= ~timed[number]
            active = accepted & (first[0, shown] | opening | pending | later | ever)
            if shown:
                pending, closing = _NONE, _NONE
            seen += shown
            todo, number = active, 0
            while todo:
                if todo & _ONE << np.uint64(number):
                    todo &= ~(_ONE << np.uint64(number))
                    pending |= following[0, number]
                    later |= following[1, number]
                    ever |= following[3, number]
                    more = accepted & (following[2, number] | following[3, number]) & ~active
                    active |= more
                    todo |= more
                number = (number + 1) & 63
            closing |= active & last[1, shown]
            if active & last[0, shown]:
                found[place] = True
                break
        if closing:
            found[place] = True


@numba.njit
def _left(row, passing, start, stretch, stretch_end):
    """Return until when a shown row is the last, as `Rows.until` tells."""
    after, here = row + 1, stretch[row]
    while after < len(start) and passing[after] and stretch[after] == here:
        after += 1
    follows = after < len(start) and stretch[after] == here
    return start[after] if follows else stretch_end[here]


@numba.njit(cache=True, nogil=True)
def stays(fits, cost, start, stop, passing, starting, stretch, stretch_end):
    """Return first and last row, start, end and cost of stays, as `events.staying` tells."""
    found, many = np.empty((5, np.count_nonzero(fits)), np.int64), 0
    first, last, most = -1, -1, 0
    for row in range(len(fits) + 1):
        if row < len(fits) and passing[row]:
            continue
        fitting = row < len(fits) and fits[row]
        if first >= 0 and not (fitting and stretch[row] == stretch[last]):
            begun = start[first] if starting[first] else stop[first] - 1
            end = _left(last, passing, start, stretch, stretch_end)
            if begun < end:
                found[0, many], found[1, many], found[2, many] = first, last, begun
                found[3, many], found[4, many] = end, most
                many += 1
            first = -1
        if fitting:
            most = cost[row] if first < 0 else max(most, cost[row])
            first, last = row if first < 0 else first, row
    return found[:, :many].copy()


@numba.njit
def _longer(table):
    """Return a table with twice the room."""
    longer = np.empty((table.shape[0], 2 * table.shape[1]), table.dtype)
    longer[:, : table.shape[1]] = table
    return longer


@numba.njit
def _added(table, many, one, two, three):
    """Return a table of three columns with one more row, and how many rows it has."""
    if many == table.shape[1]:
        table = _longer(table)
    table[0, many], table[1, many], table[2, many] = one, two, three
    return table, many + 1


@numba.njit
def _first_from(values, low, high, least):
    """Return the first place in a range of growing values that holds at least so much."""
    while low < high:
        middle = (low + high) >> 1
        if values[middle] >= least:
            high = middle
        else:
            low = middle + 1
    return low


@numba.njit
def _near_from(values, near, least):
    """Return the same of all values; it is looked for near a place, in growing steps."""
    step = 1
    if near < len(values) and values[near] < least:
        while near + step < len(values) and values[near + step] < least:
            near, step = near + step, 2 * step
        return _first_from(values, near + 1, min(near + step, len(values)), least)
    while near - step >= 0 and values[near - step] >= least:
        near, step = near - step, 2 * step
    return _first_from(values, max(near - step + 1, 0), near, least)


@numba.njit(cache=True, nogil=True)
def sharing_hulls(base, low, high, begin_last, end_first, keys, heads, start, until, latest):
    """Return the hulls of lines and what they share frames with, as `beside.hulls` tells.

    First come the others that begin within the line: of them the one that ends first. Then, from
    the line's start back, those that begin the later, the more they reach beyond it.
    """
    found, many, first = np.empty((3, len(base) + 16), np.int64), 0, 0
    for line in range(len(base)):
        first = _near_from(keys, first, base[line] + low[line])
        best, head, last = _FAR, first, base[line] + begin_last[line]
        while head < len(keys) and keys[head] <= last and best > high[line]:
            place = _first_from(until, heads[head], heads[head + 1], end_first[line])
            if place < heads[head + 1]:
                best = min(best, max(until[place], high[line]))
            head += 1
        if best < _FAR:
            found, many = _added(found, many, line, low[line], best)
        head, least = first - 1, base[line] + end_first[line]
        while best > high[line] and head >= 0 and latest[heads[head + 1] - 1] >= least:
            place = _first_from(until, heads[head], heads[head + 1], end_first[line])
            if place < heads[head + 1] and max(until[place], high[line]) < best:
                best = max(until[place], high[line])
                found, many = _added(found, many, line, start[place], best)
            head -= 1
    return found[0, :many].copy(), found[1, :many].copy(), found[2, :many].copy()


@numba.njit(cache=True, nogil=True)
def linked(cell, bounds, captures, tables):
    """Return capture, first and last row of all ways of a chain, as `linked.rows_of` tells."""
    found, many, last = np.empty((3, 1024), np.int64), 0, len(tables) - 1
    there = np.empty(len(tables), np.int64)
    for capture in captures:
        behind = bounds[capture + 1]
        for first in range(bounds[capture], behind):
            if not tables[0, cell[first]]:
                continue
            if not last:
                found, many = _added(found, many, capture, first, first)
                continue
            depth, there[1] = 1, first + 1
            while depth:
                row = there[depth]
                if row >= behind or cell[row] & STARTING:
                    depth -= 1
                    continue
                there[depth] = row + 1 if cell[row] & PASSING else behind
                if tables[depth, cell[row]]:
                    if depth == last:
                        found, many = _added(found, many, capture, first, row)
                    else:
                        depth += 1
                        there[depth] = row + 1
    return found[:, :many].copy()


@numba.njit(cache=True, nogil=True)
def from_left(capture, low, high, kept):
    """Note which hits begin when the one before is over, as `overlaps.from_left` tells."""
    last, end = np.int64(-1), np.int64(0)
    for hit in range(len(capture)):
        if capture[hit] != last or low[hit] >= end:
            kept[hit] = True
            last, end = capture[hit], high[hit]
