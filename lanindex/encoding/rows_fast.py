"""Stages 4 to 6, compiled (extra ``fast``): from runs to the rows of a table.

The same as `achieve`, `rules`, `rows` and `timing` do one by one, which are the truth: equal rows.
"""

from __future__ import annotations

from math import sqrt

import numba
import numpy as np

from lanindex.encoding.measures import _TINY

_SYMBOL, _DROPPED, _PASSING, _REJOINED = range(4)
_CELL, _START, _STOP, _ACHIEVED, _RULE, _IS_PASSING, _SWINGS, _FIRST, _BEHIND = range(9)


@numba.njit
def _apart(curve, frame, x, y, z):
    x, y, z = curve[0, frame] - x, curve[1, frame] - y, curve[2, frame] - z
    return sqrt(x * x + z * z + y * y)


@numba.njit
def _moved(curve, move):
    last = move[1]
    return _apart(curve, move[0], curve[0, last], curve[1, last], curve[2, last])


@numba.njit
def _gain(curve, move, middle):
    before = _apart(curve, move[0], middle[0], middle[1], middle[2])
    return before - _apart(curve, move[1], middle[0], middle[1], middle[2])


@numba.njit
def _achieved(runs, apart, angle, in_force, within, outcome, alive):
    """Write what becomes of the runs of a move; return how many are symbols, and list them."""
    last, many = len(runs) - 1, 0
    for run in range(last + 1):
        outcome[run] = _SYMBOL
        if angle[run] > within and run < last:
            outcome[run] = _DROPPED
            continue
        before = alive[many - 1]
        if many and runs[before, 0] == runs[run, 0]:
            if apart[before] <= apart[run] and run < last:
                runs[run, 3], apart[run] = runs[before, 3], apart[before]
            outcome[before] = _DROPPED
            many -= 1
        alive[many] = run
        many += 1
    if many and runs[alive[0], 0] == in_force:
        outcome[alive[0]] = _DROPPED
        alive[: many - 1] = alive[1:many].copy()
        many -= 1
    return many


@numba.njit
def _ruled(runs, in_force, alive, many, openings, rules, outcome, deleted):
    """Write which symbols the rules delete, and which are joined with an equal neighbour."""
    start = 0
    while start < many:
        before = in_force if start == 0 else runs[alive[start - 1], 0]
        opening = before * 27 + runs[alive[start], 0]
        found = -1
        for rule in range(openings[opening], openings[opening + 1]):
            length, third, gone, _ = rules[rule]
            if start + length > many + 1 or (start == 0 and gone & 1):
                continue
            if start + length == many + 1 and gone >> (length - 1) & 1:
                continue
            if length == 2 or runs[alive[start + 1], 0] == third:
                found = rule
                break
        if found < 0:
            start += 1
            continue
        length, _, gone, line = rules[found]
        kept = start - 1 if start else 0
        for place in range(0 if start else 1, length):
            run = alive[start + place - 1]
            if gone >> place & 1:
                outcome[run], deleted[run] = _PASSING, line
            else:
                alive[kept] = run
                kept += 1
        rest = many - (start + length - 1)
        for place in range(rest):
            alive[kept + place] = alive[start + length - 1 + place]
        many = kept + rest
        start = max(start - 2, 0)
    for place in range(many - 1):
        if runs[alive[place], 0] == runs[alive[place + 1], 0]:
            outcome[alive[place]] = _REJOINED


@numba.njit
def _spread(rows, known, stop):
    """Give every symbol a frame, of its neighbours; those for which there is none are passing."""
    shown = 0
    for row in rows[1:]:
        shown += row[_IS_PASSING] == 0
    surplus, free = shown - (stop - known), known
    for row in rows[1:]:
        if row[_IS_PASSING]:
            continue
        if surplus > 0:
            surplus -= 1
            row[_IS_PASSING] = 1
            continue
        row[_START] = max(row[_START], free)
        row[_STOP] = free = max(row[_STOP], row[_START] + 1)
    limit = stop
    for number in range(len(rows) - 1, 0, -1):
        row = rows[number]
        if row[_IS_PASSING]:
            continue
        if row[_STOP] <= limit:
            break
        row[_STOP] = limit
        row[_START] = limit = min(row[_START], limit - 1)
    outer = rows[-1]
    for number in range(len(rows) - 1, 0, -1):
        row = rows[number]
        if not row[_IS_PASSING]:
            outer = row
            continue
        low, high = outer[_START], outer[_STOP]
        row[_START] = min(max(row[_START], low), high - 1)
        row[_STOP] = min(max(row[_STOP], row[_START] + 1), high)


@numba.njit
def _begin(curve, moves, move, idle, middle):
    """Return where the first symbol of a move begins: perhaps with moves before that had none."""
    begin = move[2]
    for number in idle[::-1]:
        before = moves[number]
        if before[3] + 1 < begin or _gain(curve, before, middle) < _moved(curve, before) / 2:
            break
        begin = before[2]
    return begin


@numba.njit
def _put(runs, outcome, deleted, start, end, rows, many, now):
    """Write the rows of a move; return how many there are, and which is in force."""
    cut = start
    for run in range(len(runs)):
        if outcome[run] == _DROPPED:
            continue
        stop = min(max(runs[run, 3] + 1, cut), end)
        if outcome[run] != _REJOINED:
            passing = outcome[run] == _PASSING
            if not passing and run == len(runs) - 1:
                stop = end
            rows[many] = 0
            rows[many, _CELL], rows[many, _ACHIEVED] = runs[run, 0], runs[run, 3]
            rows[many, _START], rows[many, _STOP] = cut if passing else start, stop
            rows[many, _RULE], rows[many, _IS_PASSING] = deleted[run] if passing else 0, passing
            if not passing:
                now, start = many, stop
            many += 1
        cut = stop
    return many, now


@numba.njit
def _written(curve, moves, runs, apart, angle, scales, middles, lengthen, ruled, rows, scratch):
    """Write the rows of a part, in frames from the stretch's first; return how many."""
    within, distance = scales
    openings, rules = ruled
    alive, outcome, deleted, idle = scratch
    many, now, waiting, begun = 1, 0, 0, 0
    for number in range(len(moves)):
        move = moves[number]
        behind = begun + move[4]
        some, near, off = runs[begun:behind], apart[begun:behind], angle[begun:behind]
        begun = behind
        force = rows[now, _CELL]
        symbols = _achieved(some, near, off, force, within, outcome, alive)
        if symbols == 0:
            rows[now, _SWINGS] += _moved(curve, move) >= distance
            touches = rows[now, _STOP] > 0 and move[2] <= rows[now, _STOP]
            if lengthen and touches and _gain(curve, move, middles[force]) > 0:
                rows[now, _STOP] = max(rows[now, _STOP], move[3] + 1)
            else:
                idle[waiting] = number
                waiting += 1
            continue
        first = alive[0]
        _ruled(some, force, alive, symbols, openings, rules, outcome, deleted)
        earlier = idle[: waiting if lengthen else 0]
        begin = _begin(curve, moves, move, earlier, middles[some[first, 0]])
        waiting, start = 0, max(begin, rows[now, _STOP])
        end = max(move[3] + 1, start)
        many, now = _put(some, outcome, deleted, start, end, rows, many, now)
    return many


@numba.njit(cache=True, nogil=True)
def rows(
    curves, moves, counts, runs, apart, angle, firsts, within, distances, middles, lengthen, which,
    openings, rules, frames,
):  # fmt: skip
    """Return the rows of parts, and how many each has.

    `curves` (3, P, N) float64, mm; `angle` (R,) float64, degrees from the middle of a run's cell;
    `firsts` (P,) the cells of the first frame; `distances` (P,) d_t, mm; `middles` (P, 27, 3) mm;
    `which` (P,) which rules are a part's; `table` (S, 9) int64: the cell, first frame and behind
    the last in the source, the resampled frame where it is achieved, the rule, whether it is
    passing, swings, and first frame and behind the last of those that are resampled; `shares` (P,)
    rows of each part.
    """
    known, until, begin, numerator, denominator = frames
    parts, longest = len(counts), 1
    for move in moves:
        longest = max(longest, move[4])
    scratch = (
        np.empty(longest, np.int64), np.empty(longest, np.int64), np.empty(longest, np.int64),
        np.empty(len(moves), np.int64),
    )  # fmt: skip
    table = np.empty((len(runs) + parts, _BEHIND + 1), np.int64)
    shares = np.empty(parts, np.int64)
    done = first = run = 0
    for part in range(parts):
        own = moves[first : first + counts[part]]
        behind = run + own[:, 4].sum()
        some = table[done:]
        some[0] = 0
        some[0, _CELL] = firsts[part]
        ruled = openings[which[part]], rules
        many = _written(
            curves[:, part], own, runs[run:behind], apart[run:behind], angle[run:behind],
            (within, distances[part]), middles[part], lengthen, ruled, some, scratch,
        )  # fmt: skip
        some = some[:many]
        for row in some:
            for end, seen in ((_START, _FIRST), (_STOP, _BEHIND)):
                row[seen] = row[end] + begin
                frame = -(-row[seen] * numerator // denominator)
                row[end] = min(max(frame, known), until)
        some[0, _START] = some[0, _STOP] = known
        _spread(some, known, until)
        shares[part] = many
        done, first, run = done + many, first + counts[part], behind
    return table[:done], shares


@numba.njit
def _speed(curve, frame):
    """Return the square of twice the way in a frame, one-sided at the ends."""
    last = curve.shape[1] - 1
    before, after = max(frame - 1, 0), min(frame + 1, last)
    square = 0.0
    for axis in range(3):
        way = curve[axis, after] - curve[axis, before]
        square += way * way
    return square if after - before == 2 else 4 * square


@numba.njit(cache=True, nogil=True)
def looked(curves, limb, first, last, lengths, pace):
    """Return what rows go along their curves: see `lanindex.encoding.measures.looked`."""
    count, many = len(first), 0
    peaks, begins = np.empty(count), np.empty(count, np.int64)
    for row in range(count):
        begins[row] = many
        many += -((first[row] - last[row]) // pace) + 1
    turned, gone = np.empty(many), np.empty(many)
    for row in range(count):
        curve, length = curves[:, limb[row]], lengths[limb[row]]
        peak = 0.0
        for frame in range(first[row], last[row] + 1):
            peak = max(peak, _speed(curve, frame))
        peaks[row] = sqrt(peak) / 2
        until = begins[row + 1] if row + 1 < count else many
        x = y = z = away = 0.0
        for place in range(begins[row], until):
            frame = min(first[row] + pace * (place - begins[row]), last[row])
            a, b, c = curve[0, frame], curve[1, frame], curve[2, frame]
            size = sqrt(a * a + c * c + b * b)
            least = max(size, _TINY)
            a, b, c, size = a / least, b / least, c / least, size / length
            d, e, f = a - x, b - y, c - z
            turned[place], gone[place] = sqrt(d * d + f * f + e * e), size - away
            if place == begins[row]:
                begun = (a, b, c, size)
            x, y, z, away = a, b, c, size
        x, y, z = x - begun[0], y - begun[1], z - begun[2]
        turned[begins[row]], gone[begins[row]] = sqrt(x * x + z * z + y * y), away - begun[3]
    return peaks, begins, turned, gone
