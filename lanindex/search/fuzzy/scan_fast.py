"""The alignment of a line with a part, compiled (extra ``fast``): symbol by symbol, as they stand.

`lanindex.search.fuzzy.align` is the truth; the two give equal keys.
"""

from __future__ import annotations

import numba
import numpy as np

from lanindex.search.fuzzy.align import BLUR, COST, FIRST, LATEST, NOTHING
from lanindex.search.fuzzy.net import MISSING, SKIPPED

_ONE, _NIL = np.uint64(1), np.uint64(0)
# each six bits in a row of this number are others, so that they tell how far it was moved
_SPREAD = np.uint64(0x03F79D71B4CB0A89)
_LOWEST = np.zeros(64, np.uint64)
_LOWEST[(_SPREAD << np.arange(64, dtype=np.uint64)) >> np.uint64(58)] = np.arange(64)
_MISSING, _SKIPPED = np.int64(MISSING) << COST, np.int64(SKIPPED) << COST


@numba.njit(cache=True, nogil=True)
def _reached(seed, step, behind, code, begins, passing, steps, reach, spare):
    """Return the last row, up or down, that a match can cover with another; what there may match.

    Going down it is not before `behind`. What may match are steps, a bit each.
    """
    there, met = seed, steps[code[seed]]
    while there > behind or step > 0:
        if begins[there + max(step, 0)]:
            break
        kind = code[there + step]
        if reach >= 0 and not passing[kind]:
            reach -= 1
            spare -= steps[kind] == 0
            if reach < 0 or spare < 0:
                break
        there += step
        met |= steps[kind]
    return there, met


@numba.njit(cache=True, nogil=True)
def _arrive(row, kind, blur, tables, entry, waits, most, waiting, arrived):
    """Write the best match that stands at each step with a row."""
    for state in range(len(tables)):
        key = (entry[state] << COST) + (np.int64(LATEST - row) << FIRST)
        key = min(key, waiting[waits[0, state]], waiting[waits[1, state]])
        cost = np.int64(tables[state, kind])
        key += cost << COST
        if cost == 0 and key & BLUR < blur:
            key = key & ~BLUR | blur
        arrived[state] = key if key >> COST <= most else NOTHING


@numba.njit(cache=True, nogil=True)
def _ended(leave, arrived):
    """Return the best match that ends with a row."""
    best = np.int64(NOTHING)
    for state in range(len(arrived)):
        if arrived[state] < NOTHING:
            best = min(best, arrived[state] + (leave[state] << COST))
    return best


@numba.njit(cache=True, nogil=True)
def _wait(shown, tight, comes, missing, most, waiting, arrived):
    """Let what waits pass over a row, what has arrived wait, and then let steps be missing.

    Returns
    -------
    bool
        Whether anything waits.
    """
    alive = False
    for door in range(len(tight)):
        if shown and tight[door] and waiting[door] < NOTHING:
            waiting[door] += _SKIPPED
    for pair in range(len(comes)):
        key = arrived[comes[pair, 1]]
        if key < waiting[comes[pair, 0]]:
            waiting[comes[pair, 0]] = key
    for way in range(len(missing)):
        near, far, steps = missing[way]
        waiting[far] = min(waiting[far], waiting[near] + steps * _MISSING)
    for door in range(len(tight)):
        if waiting[door] >> COST > most:
            waiting[door] = NOTHING
        alive |= waiting[door] < NOTHING
    return alive


@numba.njit(cache=True, nogil=True)
def _with_room(keys, last, many):
    """Return columns with room for one more."""
    if many < len(keys):
        return keys, last
    return np.append(keys, np.empty(many, np.int64)), np.append(last, np.empty(many, np.int64))


@numba.njit(cache=True, nogil=True)
def scanned(seeds, first, row, whole, rows, part, tables, ends, net, numbers):
    """Return the matches around some rows, or in the `whole` stretches that begin with them.

    Parameters
    ----------
    seeds : ndarray
        (N,) int64 rows, growing.
    first, row : int
        Which of the seeds is the next, and the first row that has not been looked at.
    whole : bool
        Whether the seeds are beginnings.
    rows : int
        How many rows are looked at, about.
    part : tuple of ndarray
        The code of each row, where stretches begin, the margins, and of each kind whether it is
        passing and which steps it may match, a bit each.
    tables : ndarray
        (K, kinds) int16: by step what each kind costs.
    ends : ndarray
        (2, K) int64: what is missing before and after each step.
    net : tuple of ndarray
        The doors before each step, (2, K); whether what lies between costs anything, by door; by
        which steps one comes to a door; from which door to which one comes by missing steps.
    numbers : tuple of int
        The reach (-1: any), what may be passed over, what a match may cost, a margin of 1, and
        the steps that a match cannot do without.

    Returns
    -------
    ndarray, ndarray, int, int
        (M,) int64 keys and last rows; where to go on.
    """
    code, begins, margin, passing, steps = part
    reach, spare, most, clear, needed = numbers
    waits, tight, comes, missing = net
    keys, last, many = np.empty(256, np.int64), np.empty(256, np.int64), 0
    waiting, arrived = np.empty(len(tight) + 1, np.int64), np.empty(len(tables), np.int64)
    while first < len(seeds) and rows > 0:
        seed = seeds[first]
        first += 1
        if seed < row:
            continue
        if not whole:
            low, met = _reached(seed, -1, row, code, begins, passing, steps, reach, spare)
            high, more = _reached(seed, 1, row, code, begins, passing, steps, reach, spare)
            if needed & ~(met | more):
                row = row if reach >= 0 else high + 1
                continue
            row = low
        else:
            row = seed
        alive = True
        waiting[:] = NOTHING
        while alive or whole or row <= seed:
            kind = code[row]
            blur = max(clear - np.int64(margin[row]), 0)
            if steps[kind]:
                _arrive(row, kind, blur, tables, ends[0], waits, most, waiting, arrived)
                best = _ended(ends[1], arrived)
                if best >> COST <= most:
                    keys, last = _with_room(keys, last, many)
                    keys[many], last[many] = best, row
                    many += 1
            else:
                arrived[:] = NOTHING
            alive = _wait(not passing[kind], tight, comes, missing, most, waiting, arrived)
            row, rows = row + 1, rows - 1
            if begins[row]:
                break
    return keys[:many], last[:many], first, row


@numba.njit
def _noted(plane, kinds, by_kind, ends, counts):
    """Note in a plane the rows of some kinds."""
    for kind in range(len(kinds)):
        if kinds[kind]:
            for row in by_kind[ends[kind] - counts[kind] : ends[kind]]:
                plane[(row >> 6) + 1] |= _ONE << np.uint64(row & 63)


@numba.njit(inline="always")
def _away(plane, word, steps):
    """Return a word of a plane as it is so many rows later, two at most before or behind."""
    if steps > 0:
        bits = np.uint64(steps)
        return plane[word] >> bits | plane[word + 1] << np.uint64(64) - bits
    bits = np.uint64(-steps)
    return plane[word] << bits | plane[word - 1] >> np.uint64(64) - bits


@numba.njit(cache=True, nogil=True)
def between(own, near, far, narrow, by_kind, ends, counts, passed):
    """Return the rows of some kinds between rows of others, growing; passing ones may be left out.

    Parameters
    ----------
    own : ndarray
        (K,) bool: the kinds.
    near, far : ndarray
        (2, K) bool: those next to these, before and behind, and those beyond.
    narrow : ndarray
        (2, 2) bool: whether the rows next to these are to be looked at, and those beyond; each
        before and behind.
    by_kind, ends, counts : ndarray
        The rows by kind, and by kind where they end there, and how many they are.
    passed : ndarray
        The plane of the passing rows, and a word of 0 before it and one behind.
    """
    plane, there = np.zeros((2, len(passed)), np.uint64)
    _noted(plane, own, by_kind, ends, counts)
    for side, way in ((0, -1), (1, 1)):
        if narrow[0, side]:
            there[:] = 0
            _noted(there, near[side], by_kind, ends, counts)
            for word in range(1, len(plane) - 1):
                beyond = _away(there, word, 2 * way) | _away(passed, word, 2 * way)
                kept = _away(there, word, way) | (_away(passed, word, way) & beyond)
                plane[word] &= kept
        if narrow[1, side]:
            there[:] = passed
            _noted(there, far[side], by_kind, ends, counts)
            for word in range(1, len(plane) - 1):
                plane[word] &= _away(there, word, 2 * way) | _away(passed, word, way)
    found = np.empty(counts[own].sum(), np.int64)
    return found[: _listed(plane[1:-1], 0, np.empty(len(plane), np.int64), found)]


@numba.njit(inline="always")
def _lowest(word):
    """Return which bit of a word, not 0, is the lowest that is set."""
    return _LOWEST[((word & (~word + _ONE)) * _SPREAD) >> np.uint64(58)]


@numba.njit(cache=True, nogil=True)
def _listed(plane, first, some, found):
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
