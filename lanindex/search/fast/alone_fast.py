"""Lines of one part, compiled (extra ``fast``): the program run backwards, row by row.

The same as `lines` does with whole columns, which is the truth: equal values. Each row is looked
at once for each step that it fits; no arrow leads out of a stretch, so that what is remembered is
of one stretch alone.
"""

from __future__ import annotations

import numba
import numpy as np

from lanindex.model.columns import PASSING, STARTING, THOUSANDTHS
from lanindex.search.fast.arrows import NONE
from lanindex.search.fast.lines import COST_BITS
from lanindex.search.language.words import WORD_KINDS

_COST = (1 << COST_BITS) - 1
_ONE = np.uint64(1)
_MOVES, _STAYS, _RESTS = range(3)
_CHANGES = WORD_KINDS["change"].codes
_SINKING, _NEITHER, _RISING = (_CHANGES[it] for it in ("sinking", "neither", "rising"))


@numba.njit(inline="always")
def _fitting(cell, row, begin, accepts, changes):
    """Return which states a row fits: a bit each."""
    fits = accepts[cell[row]]
    if len(changes) == 0 or fits == 0:
        return fits
    level = cell[row] >> 4 & 3
    change = _NEITHER if level else -1
    if level and not cell[row] & PASSING:
        before = row - 1
        while before >= begin and cell[before] & PASSING:
            before -= 1
        if before >= begin:
            other = cell[before] >> 4 & 3
            if other and other != level:
                change = _RISING if other < level else _SINKING
    return fits & changes[change + 1]


@numba.njit
def _stretch_end(gaps, low, high, begin, frames):
    """Return in which frame the stretch ends that begins in another."""
    end = frames
    for gap in range(low, high):
        if gaps[gap, 1] < gaps[gap, 2] and gaps[gap, 1] <= begin:
            end = gaps[gap, 2] if begin <= gaps[gap, 2] else frames
    return end


@numba.njit(cache=True, nogil=True)
def backwards(first, last, rows, stretches, frames, gaps, states, edges, limits, clocks):
    """Return where a line may begin in the captures from one up to another: rows, frames, values.

    Parameters
    ----------
    first, last : int
        Which captures.
    rows : tuple of ndarray
        bounds, cell, margin, start and stop of the part.
    stretches : ndarray
        Room for the rows of the longest capture: (rows + 1, states) int64, twice, and
        (rows + 2,) int64, three times.
    frames, gaps : ndarray
        Of the captures, as in `Roster` and `Columns`.
    states : tuple of ndarray
        accepts (256,) and changes (4,) or (0,): which states fit, a bit each; their order, rests
        first; manners; which may begin or end at a passing row; begin at all; end; and the
        number of their limit, -1: none.
    edges : tuple of ndarray
        The first of each state; targets; fewest and most rows skipped, -1: no limit; whether they
        may be skipped at all; the number of their limit.
    limits : ndarray
        (limits, clocks, 2) int64: the fewest and the most frames.
    clocks : ndarray
        (C,) of each capture.
    """
    bounds, cell, margin, start, stop = rows
    values, smallest, rank, place, until = stretches
    accepts, changes, order, manners, through, begins, ends, lasting = states
    leading, targets, fewest, most, later, timed = edges
    many = len(manners)
    kept, held, open_to = (
        np.zeros(many, np.int64),
        np.zeros(many, np.int64),
        np.zeros(many, np.bool_),
    )
    # room for all that may be found: what is not written to is never there
    room = np.int64(begins.sum()) * (bounds[last] - bounds[first])
    found, low, value = (
        np.empty(room, np.int64),
        np.empty(room, np.int64),
        np.empty(room, np.int64),
    )
    count = 0
    entering = leaving = np.uint64(0)
    for state in range(many):
        entering |= np.uint64(begins[state]) << np.uint64(state)
        leaving |= np.uint64(ends[state]) << np.uint64(state)
    low_gap = np.searchsorted(gaps[:, 0], last)
    # from the last row to the first, so that what is found stands in order when it is turned around
    for capture in range(last - 1, first - 1, -1):
        gap = low_gap
        while low_gap > 0 and gaps[low_gap - 1, 0] == capture:
            low_gap -= 1
        clock, begin = clocks[capture], bounds[capture + 1]
        while begin > bounds[capture]:
            behind, fitted = begin, np.uint64(0)
            begin -= 1
            while begin > bounds[capture] and cell[begin] < STARTING:
                fitted |= accepts[cell[begin]]
                begin -= 1
            fitted |= accepts[cell[begin]]
            if not fitted & entering or not fitted & leaving:
                continue
            size, shown = behind - begin, 0
            for it in range(size):
                rank[it] = shown
                if not cell[begin + it] & PASSING:
                    place[shown] = it
                    shown += 1
            rank[size] = shown
            end = _stretch_end(gaps, low_gap, gap, start[begin], np.int64(frames[capture]))
            for state in range(many):
                smallest[size, state] = NONE
                open_to[state] = False
            for it in range(size - 1, -1, -1):
                row = begin + it
                passing, starting = cell[row] & PASSING != 0, cell[row] & STARTING != 0
                fits = _fitting(cell, row, begin, accepts, changes)
                cost = np.int64(THOUSANDTHS) - np.int64(margin[row])
                if not passing:
                    until[it] = end
                    end = np.int64(start[row])
                for number in range(many):
                    state = order[number]
                    values[it, state] = NONE
                    smallest[it, state] = smallest[it + 1, state]
                    manner, own_cost, final = manners[state], cost, it
                    if not fits >> np.uint64(state) & _ONE:
                        if not passing:
                            open_to[state] = False
                        continue
                    enters, leaves = np.int64(start[row]), np.int64(stop[row])
                    if manner == _STAYS:
                        if not open_to[state]:
                            open_to[state], held[state], kept[state] = True, it, 0
                        kept[state] = max(kept[state], cost)
                        before = row - 1
                        while before >= begin and cell[before] & PASSING:
                            before -= 1
                        if before >= begin:
                            others = _fitting(cell, before, begin, accepts, changes)
                            if others >> np.uint64(state) & _ONE:
                                continue
                        own_cost, final = kept[state], held[state]
                        enters = enters if starting else leaves - 1
                        leaves = until[final]
                    elif manner == _RESTS:
                        enters, leaves = leaves, until[it]
                    if manner != _MOVES and enters >= leaves:
                        continue
                    stands = starting and manner == _MOVES
                    if lasting[state] >= 0:
                        least = limits[lasting[state], clock, 0]
                        longest = limits[lasting[state], clock, 1]
                        if stands or leaves - enters < least or leaves - enters > longest:
                            continue
                    best = np.int64(NONE)
                    for edge in range(leading[state], leading[state + 1]):
                        target = targets[edge]
                        rests = np.int64(manners[target] == _RESTS)
                        own_rest = np.int64(rests and manner == _MOVES and not passing)
                        base = rank[final + 1] - rests
                        there = final + 1 - own_rest
                        soonest = base + fewest[edge]
                        if soonest > shown:
                            continue
                        if soonest > 0:
                            there = max(there, place[soonest - 1] + 1)
                        if timed[edge] < 0 and most[edge] < 0:
                            best = min(best, smallest[there, target])
                            continue
                        least = limits[max(timed[edge], 0), clock, 0]
                        longest = limits[max(timed[edge], 0), clock, 1]
                        while there < size:
                            if most[edge] >= 0 and rank[there] > base + most[edge]:
                                break
                            other = begin + there
                            if timed[edge] >= 0:
                                if not cell[other] & PASSING and start[other] - leaves > longest:
                                    break
                                comes = np.int64(start[other])
                                if manners[target] == _RESTS:
                                    comes = np.int64(stop[other])
                                elif manners[target] == _STAYS and not cell[other] & STARTING:
                                    comes = np.int64(stop[other]) - 1
                                between = max(comes - leaves, 0)
                                if passing and manner == _MOVES and not later[edge]:
                                    between = 0
                                if between < least or between > longest:
                                    there += 1
                                    continue
                            best = min(best, values[there, target])
                            there += 1
                    if best < NONE:
                        best = (best & ~_COST) | max(best & _COST, own_cost)
                    elif ends[state] and not stands and (through[state] or not passing):
                        best = (leaves << COST_BITS) | own_cost
                    else:
                        continue
                    values[it, state] = best
                    smallest[it, state] = min(smallest[it, state], best)
                    if begins[state] and (through[state] or not passing):
                        found[count], low[count], value[count] = row, enters, best
                        count += 1
    return found[:count][::-1], low[:count][::-1], value[:count][::-1]
