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


@numba.njit(inline="always")
def _comes(manner, row, cell, start, stop):
    """Return in which frame a movement, stay or rest begins at a row."""
    if manner == _RESTS:
        return np.int64(stop[row])
    if manner == _STAYS and not cell[row] & STARTING:
        return np.int64(stop[row]) - 1
    return np.int64(start[row])


@numba.njit(inline="always")
def _stayed(state, row, begin, cell, accepts, changes):
    """Tell whether the row that is shown before another fits, too."""
    before = row - 1
    while before >= begin and cell[before] & PASSING:
        before -= 1
    if before < begin:
        return False
    return _fitting(cell, before, begin, accepts, changes) >> np.uint64(state) & _ONE != 0


@numba.njit(inline="always")
def _laid_out(begin, behind, cell, rank, place):
    """Write how many rows are shown before each, and where they are; return how many."""
    shown = 0
    for it in range(behind - begin):
        rank[it] = shown
        if not cell[begin + it] & PASSING:
            place[shown] = it
            shown += 1
    rank[behind - begin] = shown
    return shown


@numba.njit(inline="always")
def _within(edge, there, final, begin, size, leaves, at_once, clock, rows, room, states, edges):
    """Return the smallest value that an arrow with limits leads to, from a place on."""
    _, cell, _, start, stop = rows
    values, _, rank, _, _ = room
    _, targets, _, most, _, timed, limits = edges
    manner, best = states[3][targets[edge]], np.int64(NONE)
    base = rank[final + 1] - (manner == _RESTS)
    least, longest = limits[max(timed[edge], 0), clock, 0], limits[max(timed[edge], 0), clock, 1]
    for it in range(there, size):
        if most[edge] >= 0 and rank[it] > base + most[edge]:
            break
        row = begin + it
        if timed[edge] >= 0:
            if not cell[row] & PASSING and start[row] - leaves > longest:
                break
            between = max(_comes(manner, row, cell, start, stop) - leaves, 0)
            if at_once:
                between = 0
            if between < least or between > longest:
                continue
        best = min(best, values[it, targets[edge]])
    return best


@numba.njit(inline="always")
def _beyond(state, passing, final, begin, size, leaves, clock, rows, room, states, edges):
    """Return the smallest value that the arrows of a state lead to."""
    _, smallest, rank, place, _ = room
    leading, targets, fewest, most, later, timed, _ = edges
    moves, best = states[3][state] == _MOVES, np.int64(NONE)
    for edge in range(leading[state], leading[state + 1]):
        rests = states[3][targets[edge]] == _RESTS
        there = final + 1
        if rests and moves and not passing:
            there = final
        soonest = rank[final + 1] - np.int64(rests) + fewest[edge]
        if soonest > rank[size]:
            continue
        if soonest > 0:
            there = max(there, place[soonest - 1] + 1)
        if timed[edge] < 0 and most[edge] < 0:
            best = min(best, smallest[there, targets[edge]])
            continue
        at_once = passing and moves and not later[edge]
        found = _within(
            edge, there, final, begin, size, leaves, at_once, clock, rows, room, states, edges
        )
        best = min(best, found)
    return best


@numba.njit(inline="always")
def _event(state, it, begin, clock, rows, until, states, stays, limits):
    """Return what begins at a row that fits: last row (-1: nothing), first frame, end, cost."""
    _, cell, margin, start, stop = rows
    kept, held, goes_on = stays
    row, manner, limit = begin + it, states[3][state], states[7][state]
    enters, leaves = _comes(manner, row, cell, start, stop), np.int64(stop[row])
    final, cost, fits = it, np.int64(THOUSANDTHS) - np.int64(margin[row]), True
    if manner == _STAYS:
        if not goes_on[state]:
            goes_on[state], held[state], kept[state] = 1, it, 0
        kept[state] = max(kept[state], cost)
        cost, final = kept[state], held[state]
        fits = not _stayed(state, row, begin, cell, states[0], states[1])
    if manner != _MOVES:
        leaves = until[final]
        fits &= enters < leaves
    if limit >= 0:
        fits &= manner != _MOVES or not cell[row] & STARTING
        fits &= limits[limit, clock, 0] <= leaves - enters <= limits[limit, clock, 1]
    return final if fits else -1, enters, leaves, cost


@numba.njit
def _stretch(begin, size, end, clock, rows, room, states, edges, stays, found, low, value, count):
    """Add where a line may begin in a stretch, from its last row to its first; return how many."""
    _, cell, _, start, _ = rows
    values, smallest, _, _, until = room
    accepts, changes, order, manners, through, begins, ends, _ = states
    goes_on = stays[2]
    smallest[size, : len(order)] = NONE
    goes_on[:] = 0
    for it in range(size - 1, -1, -1):
        row = begin + it
        passing, fits = cell[row] & PASSING != 0, _fitting(cell, row, begin, accepts, changes)
        if not passing:
            until[it], end = end, np.int64(start[row])
        for state in order:
            values[it, state], smallest[it, state] = NONE, smallest[it + 1, state]
            if not fits >> np.uint64(state) & _ONE:
                goes_on[state] &= passing
                continue
            final, enters, leaves, cost = _event(
                state, it, begin, clock, rows, until, states, stays, edges[6]
            )
            if final < 0:
                continue
            best = _beyond(
                state, passing, final, begin, size, leaves, clock, rows, room, states, edges
            )
            seen = through[state] or not passing
            stands = manners[state] == _MOVES and cell[row] & STARTING != 0
            if best < NONE:
                best = (best & ~_COST) | max(best & _COST, cost)
            elif ends[state] and not stands and seen:
                best = (leaves << COST_BITS) | cost
            else:
                continue
            values[it, state], smallest[it, state] = best, min(smallest[it, state], best)
            if begins[state] and seen:
                found[count], low[count], value[count] = row, enters, best
                count += 1
    return count


@numba.njit(cache=True, nogil=True)
def backwards(first, last, rows, room, frames, gaps, states, edges, clocks):
    """Return where a line may begin in the captures from one up to another: rows, frames, values.

    Parameters
    ----------
    first, last : int
        Which captures.
    rows : tuple of ndarray
        bounds, cell, margin, start and stop of the part.
    room : tuple of ndarray
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
        may be skipped at all; the number of their limit; and of limits (limits, clocks, 2) the
        fewest and the most frames.
    clocks : ndarray
        (C,) of each capture.
    """
    bounds, cell, _, start, _ = rows
    accepts, begins, ends, many = states[0], states[5], states[6], len(states[3])
    stays = np.zeros(many, np.int64), np.zeros(many, np.int64), np.zeros(many, np.int64)
    # room for all that may be found: what is not written to is never there
    most = np.int64(begins.sum()) * (bounds[last] - bounds[first])
    found, low, value = np.empty(most, np.int64), np.empty(most, np.int64), np.empty(most, np.int64)
    count, entering, leaving = 0, np.uint64(0), np.uint64(0)
    for state in range(many):
        entering |= np.uint64(begins[state]) << np.uint64(state)
        leaving |= np.uint64(ends[state]) << np.uint64(state)
    low_gap = np.searchsorted(gaps[:, 0], last)
    # from the last row to the first, so that what is found stands in order when it is turned around
    for capture in range(last - 1, first - 1, -1):
        gap = low_gap
        while low_gap > 0 and gaps[low_gap - 1, 0] == capture:
            low_gap -= 1
        begin = bounds[capture + 1]
        while begin > bounds[capture]:
            behind, fitted, begun = begin, np.uint64(0), False
            while not begun:
                begin -= 1
                fitted |= accepts[cell[begin]]
                begun = begin == bounds[capture] or cell[begin] >= STARTING
            if not fitted & entering or not fitted & leaving:
                continue
            _laid_out(begin, behind, cell, room[2], room[3])
            end = _stretch_end(gaps, low_gap, gap, start[begin], np.int64(frames[capture]))
            own = begin, behind - begin, end, clocks[capture]
            count = _stretch(*own, rows, room, states, edges, stays, found, low, value, count)
    return found[:count][::-1], low[:count][::-1], value[:count][::-1]
