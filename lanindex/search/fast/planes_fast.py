"""Chains of one part, compiled (extra ``fast``): words of planes, then the symbols that match.

The same as `chains` does with numpy, which is the truth: equal arrays.
"""

from __future__ import annotations

import numba
import numpy as np

from lanindex.model.columns import PASSING, THOUSANDTHS
from lanindex.search.fast.lines import COST_BITS

_CHUNK = 512  # words at once, so that what is worked out of them stays close to the processor
_FIRST = 64 * _CHUNK
_ONE, _TWO, _NIL = np.uint64(1), np.uint64(2), np.uint64(0)
# every other bit, pair of bits, four of them, and the first of each eight
_PAIRS, _FOURS = np.uint64(0x5555555555555555), np.uint64(0x3333333333333333)
_EIGHTS, _EACH = np.uint64(0x0F0F0F0F0F0F0F0F), np.uint64(0x0101010101010101)
# each six bits in a row of this number are others, so that they tell how far it was moved
_SPREAD = np.uint64(0x03F79D71B4CB0A89)
_LOWEST = np.zeros(64, np.uint64)
_LOWEST[(_SPREAD << np.arange(64, dtype=np.uint64)) >> np.uint64(58)] = np.arange(64)


@numba.njit
def _keep(found, words):
    """Leave of the places found those that words hold."""
    for place in range(len(found)):
        found[place] &= words[place]


@numba.njit
def _add(found, words):
    """Add the places that words hold."""
    for place in range(len(found)):
        found[place] |= words[place]


@numba.njit
def _keep_moved(found, words, more, bits):
    """Leave of the places found those that words hold some bits later."""
    rest = np.uint64(64) - bits
    for place in range(len(found)):
        found[place] &= (words[place] >> bits) | (more[place] << rest)


@numba.njit
def _moved(words, steps, found):
    """Leave of the places found those that words hold some steps later."""
    over, bits, count = steps // 64, np.uint64(steps % 64), len(found)
    if bits == _NIL:
        _keep(found, words[over : over + count])
    else:
        more = words[over + 1 : over + 1 + count]
        _keep_moved(found, words[over : over + count], more, bits)


@numba.njit
def _said(store, steps, groups, codes, first, count, said, spare):
    """Write which places each step fits: one code at least of each group of them."""
    for step in range(len(steps) - 1):
        own = said[step, :count]
        own[:] = ~_NIL
        for group in range(steps[step], steps[step + 1]):
            begin, end = groups[group], groups[group + 1]
            if end - begin == 1:
                _keep(own, store[codes[begin], first : first + count])
                continue
            some = spare[:count]
            some[:] = _NIL
            for code in range(begin, end):
                _add(some, store[codes[code], first : first + count])
            _keep(own, some)


@numba.njit
def _matched(said, on, offsets, places, kept, held, every):
    """Write where each way matches, and where any does."""
    kept[:] = ~_NIL
    every[:] = _NIL
    span = 0
    for way in range(len(offsets)):
        while span < offsets[way, -1]:
            _moved(on, span, kept)
            span += 1
        own = held[way]
        own[:] = kept
        for step in range(offsets.shape[1]):
            _moved(said[places[way, step]], offsets[way, step], own)
        _add(every, own)


@numba.njit(inline="always")
def _lowest(word):
    """Return which bit of a word, not 0, is the lowest that is set."""
    return _LOWEST[((word & (~word + _ONE)) * _SPREAD) >> np.uint64(58)]


@numba.njit(inline="always")
def _first_ones(held, place, bit, lasts):
    """Return which ways end first, of those that begin at a place: a bit each."""
    ways, span = _NIL, np.int64(-1)
    for way in range(len(lasts)):
        if span >= 0 and lasts[way] > span:
            break
        if held[way, place] >> bit & _ONE:
            ways |= _ONE << np.uint64(way)
            span = lasts[way]
    return ways


@numba.njit
def _longer(numbers, many):
    more = np.empty(2 * len(numbers), numbers.dtype)
    more[:many] = numbers[:many]
    return more


@numba.njit
def listed(plane, first, some, found):
    """Write which places a plane holds, counted from a first one; return how many there are."""
    words = many = 0
    for place in range(len(plane)):  # which words hold any is found out without a branch
        some[words] = place
        words += plane[place] != _NIL
    for place in some[:words]:
        word = plane[place]
        while word != _NIL:
            found[many] = first + place * 64 + np.int64(_lowest(word))
            word &= word - _ONE
            many += 1
    return many


@numba.njit
def _told(held, lasts, first, ranks, which):
    """Write for each rank which ways that begin there end first."""
    if len(lasts) == 1:
        which[: len(ranks)] = _ONE
        return
    for number in range(len(ranks)):
        place = ranks[number] - first
        which[number] = _first_ones(held, place >> 6, np.uint64(place & 63), lasts)


@numba.njit(inline="always")
def _value(rank, way, offsets, shown, margin, stop):
    """Return how a way ends that begins at a rank."""
    least, row = np.int64(THOUSANDTHS), np.int64(0)
    for step in range(offsets.shape[1]):
        row = rank + offsets[way, step]
        if len(shown):
            row = np.int64(shown[row])
        least = min(least, np.int64(margin[row]))
    return (np.int64(stop[row]) << COST_BITS) | (THOUSANDTHS - least)


@numba.njit
def _valued(ranks, which, offsets, shown, margin, stop):
    """Return how ways end best that begin at ranks, each of the ways that a bit tells."""
    values = np.empty(len(ranks), np.int64)
    for place in range(len(ranks)):
        ways = which[place]
        best = _value(ranks[place], np.int64(_lowest(ways)), offsets, shown, margin, stop)
        ways &= ways - _ONE
        while ways != _NIL:
            way = np.int64(_lowest(ways))
            best = min(best, _value(ranks[place], way, offsets, shown, margin, stop))
            ways &= ways - _ONE
        values[place] = best
    return values


@numba.njit(cache=True, nogil=True)
def together(store, goes_on, steps, groups, codes, offsets, places, shown, margin, stop):
    """Return the ranks where ways begin, and the value of each.

    Parameters
    ----------
    store : ndarray
        (planes, words) uint64.
    goes_on : int
        The plane of the ranks whose stretch goes on.
    steps, groups, codes : ndarray
        Which groups are of a step, which codes of a group, and which plane is that of a code.
    offsets, places : ndarray
        (ways, steps), 64 ways at most: how far each step lies from the first, and which step it
        is; in order of the last, which is told again where a way has fewer steps.
    shown : ndarray
        The row of each rank; empty: the same.
    margin, stop : ndarray
        Of the rows.
    """
    words = store.shape[1]
    lasts = offsets[:, -1].copy()
    more = lasts[-1] // 64 + 2
    said = np.zeros((len(steps) - 1, _CHUNK + more), np.uint64)
    on, spare = np.zeros(_CHUNK + more, np.uint64), np.empty(_CHUNK + more, np.uint64)
    held = np.zeros((len(lasts), _CHUNK), np.uint64)
    kept, every = np.empty(_CHUNK, np.uint64), np.empty(_CHUNK, np.uint64)
    some = np.empty(_CHUNK + 1, np.int64)
    ranks, which, many = np.empty(_FIRST, np.int64), np.empty(_FIRST, np.uint64), 0
    for first in range(0, words, _CHUNK):
        count = min(_CHUNK, words - first)
        reach = min(count + more, words - first)
        _said(store, steps, groups, codes, first, reach, said, spare)
        said[:, reach:] = _NIL
        on[:reach] = store[goes_on, first : first + reach]
        on[reach:] = _NIL
        _matched(said, on, offsets, places, kept[:count], held[:, :count], every[:count])
        if len(ranks) < many + 64 * count:
            ranks, which = _longer(ranks, many), _longer(which, many)
        found = listed(every[:count], first * 64, some, ranks[many:])
        _told(held, lasts, first * 64, ranks[many : many + found], which[many:])
        many += found
    ranks = ranks[:many]
    return ranks, _valued(ranks, which, offsets, shown, margin, stop)


@numba.njit(inline="always")
def _many(word):
    """Return how many bits of a word are set."""
    word -= word >> _ONE & _PAIRS
    word = (word & _FOURS) + (word >> np.uint64(2) & _FOURS)
    word = word + (word >> np.uint64(4)) & _EIGHTS
    return np.int64(word * _EACH >> np.uint64(56))


@numba.njit(cache=True, nogil=True)
def told(rows, values, near, entered, captures, start):
    """Return of rows and values: capture, first frame, end, cost, and the rows once more.

    Parameters
    ----------
    rows, values : ndarray
        (N,).
    near : ndarray
        By words of 64 rows: which of the captures that have any the first of them is in.
    entered : ndarray
        The plane of the rows that are the first of a capture.
    captures : ndarray
        Which captures have rows; empty: all.
    start : ndarray
        Of all rows.
    """
    many = len(rows)
    where, low = np.empty(many, np.int64), np.empty(many, np.int64)
    high, cost = np.empty(many, np.int64), np.empty(many, np.int64)
    symbols = np.full((many, 2), -1)
    for place in range(many):
        low[place] = start[rows[place]]
    for place in range(many):
        word, bit = rows[place] >> 6, np.uint64(rows[place] & 63)
        behind = entered[word] & ((_TWO << bit) - _TWO)
        where[place] = near[word] + _many(behind)
    if len(captures):
        for place in range(many):
            where[place] = captures[where[place]]
    for place in range(many):
        high[place] = values[place] >> COST_BITS
        cost[place] = values[place] & ((1 << COST_BITS) - 1)
        symbols[place, 0] = rows[place]
    return where, low, high, cost, symbols


@numba.njit(cache=True, nogil=True)
def sharing(capture, first, begin, until, cell, bounds, start, stop, fits):
    """Return the best hull of each line and a movement of another part that shares a frame with it.

    Parameters
    ----------
    capture, first, begin, until : ndarray
        (N,) the lines in order: where, their first rows, and their frames.
    cell, bounds, start, stop : ndarray
        Of the other part.
    fits : ndarray
        (256,) bool: which cells are wanted.

    Returns
    -------
    ndarray
        (3, M) int64: the first row of each line that has one, low, and high: of the hulls that end
        first the one that begins last.
    """
    found, many = np.empty((3, len(first)), np.int64), 0
    there, row = np.int64(-1), np.int64(0)
    for line in range(len(first)):
        if capture[line] != there or begin[line] < begin[line - 1]:
            there = capture[line]
            row = bounds[there]
        behind = bounds[there + 1]
        while row < behind and stop[row] <= begin[line]:  # nor does it reach what begins later
            row += 1
        low, high = np.int64(-1), np.int64(1) << 62
        for other in range(row, behind):
            if start[other] >= until[line]:
                if cell[other] & PASSING:  # the movement that it leads to began before it
                    continue
                break
            if fits[cell[other]] and stop[other] > begin[line]:
                end = max(np.int64(stop[other]), np.int64(until[line]))
                own = min(np.int64(start[other]), np.int64(begin[line]))
                if end < high or (end == high and own > low):
                    low, high = own, end
        if low >= 0:
            found[0, many], found[1, many], found[2, many] = first[line], low, high
            many += 1
    return found[:, :many].copy()
