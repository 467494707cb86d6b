"""Stages 2 to 4, compiled (extra ``fast``): from curves to moves, and the runs that they pass.

The same as `segment`, `direction` and `achieve` do with numpy, which are the truth: equal numbers.
"""

from __future__ import annotations

from math import atan2, degrees, inf, sqrt

import numba
import numpy as np

from lanindex.alphabet import PLACE
from lanindex.encoding.nth_fast import middle
from lanindex.encoding.segment import LONG_HOLD

UNSEEN, UNCLEAR = -2, -1
"""What stands for a cell that nobody asked for, and for one at whose border a point lies."""

_CLEAR = 1e-9  # of a radius, or of a degree: nearer to a border the plain way decides


@numba.njit
def _size(x, y, z):
    return sqrt(x * x + z * z + y * y)


@numba.njit
def _apart(x, y, z, one, other):
    return _size(x[one] - x[other], y[one] - y[other], z[one] - z[other])


@numba.njit
def _speeds(x, y, z, rate, speed):
    last = len(speed) - 1
    for frame in range(1, last):
        speed[frame] = _size(
            (x[frame + 1] - x[frame - 1]) / 2.0 * rate,
            (y[frame + 1] - y[frame - 1]) / 2.0 * rate,
            (z[frame + 1] - z[frame - 1]) / 2.0 * rate,
        )
    for frame, first in ((0, 0), (last, last - 1)):
        speed[frame] = 0.0 if last < 1 else _size(
            (x[first + 1] - x[first]) * rate,
            (y[first + 1] - y[first]) * rate,
            (z[first + 1] - z[first]) * rate,
        )  # fmt: skip


@numba.njit
def _minima(speed, slow, prominence, still, depths, rims, firsts, lasts):
    """Write the minima that are deep enough, and where each begins and ends; return how many."""
    many, frame, before, rim = 0, 0, inf, 0.0
    while frame < len(speed):
        level, first = max(speed[frame], still), frame
        behind = inf
        while frame < len(speed):
            behind = max(speed[frame], still)
            if behind != level:
                break
            behind = inf
            frame += 1
        rim = max(rim, level)
        if level <= slow and before > level and behind > level:
            while many and depths[many - 1] > level and rim - depths[many - 1] < prominence:
                many -= 1
                rim = max(rim, rims[many])
            if not (many and level > depths[many - 1] and rim - level < prominence):
                depths[many], rims[many], firsts[many], lasts[many] = level, rim, first, frame - 1
                many += 1
                rim = level
        before = level
    return many


@numba.njit
def _holds(x, y, z, firsts, lasts, many, distance, limit, holds):
    """Write the holds: frames that stay together; return how many."""
    within = min(distance, limit)
    last = len(x) - 1
    holds[0, 0] = holds[0, 1] = 0
    count = 1
    for number in range(2 * many + 1):
        if number == 2 * many:
            stop = last
        else:
            stop = firsts[number // 2] if number % 2 == 0 else lasts[number // 2]
        first, before = holds[count - 1]
        if stop == before:
            continue
        near = _apart(x, y, z, stop, first) <= within
        if near and limit < inf:
            for frame in range(before, stop):
                if _apart(x, y, z, frame, first) > limit:
                    near = False
                    break
        if not near:
            holds[count, 0] = stop
            count += 1
        holds[count - 1, 1] = stop
    return count


@numba.njit
def _quiet(speed, hold, still):
    """Return the speed that a move is told from the noise of a hold by."""
    first, last = hold
    if last - first + 1 < LONG_HOLD:
        return still
    return max(still, middle(speed[first : last + 1].copy()))


@numba.njit
def _begin(speed, hold, first, last, step, fast, slow):
    start = first
    while speed[start] < fast and start != last:
        start += step
    while start != hold:
        if speed[start] <= slow:
            return start
        start -= step
    return hold


@numba.njit
def _moves(speed, holds, count, onset, still, moves):
    """Write the moves between holds: first and last frame, and when each is seen to be."""
    calm = _quiet(speed, holds[0], still) if onset else still
    for number in range(count - 1):
        first, last = holds[number, 1], holds[number + 1, 0]
        begin, end = first, last
        if onset:
            peak = speed[first]
            for frame in range(first, last + 1):
                peak = max(peak, speed[frame])
            quiet, calm = calm, _quiet(speed, holds[number + 1], still)
            slow = onset * peak
            begin = _begin(speed, holds[number, 0], first, last, 1, peak / 4, max(slow, quiet))
            end = _begin(speed, holds[number + 1, 1], last, first, -1, peak / 4, max(slow, calm))
            end = max(begin, end)
        moves[number, 0], moves[number, 1] = first, last
        moves[number, 2], moves[number, 3] = begin, end


@numba.njit
def _turned(x, z, starts, order):
    """Return the sector of a point, by its azimuth."""
    azimuth = degrees(atan2(x, z))
    if azimuth < 0:
        azimuth += 360.0
    sector = order[-1]
    for one in order:
        off = abs(azimuth - starts[one])
        if off < _CLEAR or off > 360 - _CLEAR:
            return UNCLEAR
        if starts[one] <= azimuth:
            sector = one
    return sector


@numba.njit
def _find(x, y, z, first, last, numbers, sides, order, cells):
    """Find out cells from a frame to another; return how many are unclear."""
    radius, mid_cosine, mid_sine, high_cosine, high_sine = numbers[6:]
    place, sector, unclear = radius * radius, UNSEEN, 0
    a = b = c = d = 0.0
    for frame in range(first, last + 1):
        if cells[frame] != UNSEEN:
            continue
        forward, up, right = x[frame], y[frame], z[frame]
        square = forward * forward + right * right
        away = sqrt(square)
        mid = away * mid_cosine + up * mid_sine
        high = away * high_cosine + up * high_sine
        near, off = _CLEAR * (away + abs(up)), square - place
        code = (1 if mid > 0 else 0) + (1 if high > 0 else 0)
        if not (abs(mid) > near and abs(high) > near and abs(off) > _CLEAR * place):
            code = UNCLEAR
        elif off < 0:
            code += PLACE * 3
        else:
            near = _CLEAR * away
            if not (a * forward - b * right > near and d * right - c * forward > near):
                sector = _turned(forward, right, sides[:, 4], order)
                a, b, c, d = sides[sector, :4]
            code = sector * 3 + code if sector >= 0 else UNCLEAR
        cells[frame] = code
        unclear += code == UNCLEAR
    return unclear


@numba.njit
def _nearest(x, y, z, start, stop, length, middle):
    """Return the frame of a run that comes nearest to the middle of its cell, and how near."""
    found, least = start, inf
    forward, up, right = middle[0], middle[1], middle[2]
    for frame in range(start, stop):
        scale = length if length else max(_size(x[frame], y[frame], z[frame]), 1e-9)
        apart = _size(x[frame] / scale - forward, y[frame] / scale - up, z[frame] / scale - right)
        if apart < least:
            found, least = frame, apart
    return found, least


@numba.njit
def _longer(table, many):
    more = np.empty((2 * len(table), table.shape[1]), table.dtype)
    more[:many] = table[:many]
    return more


@numba.njit(cache=True, nogil=True)
def moved(curves, rate, onset, numbers, sides, orders, cells):
    """Return the moves of parts, and find out the cells that they pass.

    `curves` (3, P, N) float64, mm; `numbers` (P, 11): the highest speed of a candidate, its
    prominence, the speed that is still, d_t, how far a part may stray in a hold, its length, the
    radius of place, cosine and sine of the elevations at which mid and high begin; `sides` (P, 8,
    5): cosine and sine of the azimuths where a direction begins and ends, and where it begins in
    degrees; no cosine and sine where it takes half of the circle or more; `orders` (P, 8): the
    directions in order of azimuth; `cells` (P, N) int8, `UNSEEN`: of the frames that are asked for
    they are written; `moves` (M, 5) int64: the fields of `Segment`, and room for how many runs it
    passes; `counts` (P) moves of each part.
    """
    parts, frames = cells.shape
    speed, depths, rims = np.empty(frames), np.empty(frames), np.empty(frames)
    firsts, lasts = np.empty(frames, np.int64), np.empty(frames, np.int64)
    holds = np.empty((frames + 1, 2), np.int64)
    counts = np.empty(parts, np.int64)
    moves = np.empty((64 * parts, 5), np.int64)
    done = unclear = 0
    for part in range(parts):
        x, y, z = curves[0, part], curves[1, part], curves[2, part]
        slow, prominence, still, distance, limit = numbers[part, :5]
        order, own = orders[part], cells[part]
        _speeds(x, y, z, rate, speed)
        count = _minima(speed, slow, prominence, still, depths, rims, firsts, lasts)
        count = _holds(x, y, z, firsts, lasts, count, distance, limit, holds)
        counts[part] = count - 1
        while len(moves) < done + count:
            moves = _longer(moves, done)
        _moves(speed, holds, count, onset, still, moves[done:, :4])
        unclear += _find(x, y, z, 0, 0, numbers[part], sides[part], order, own)
        for number in range(done, done + count - 1):
            first, last = moves[number, 0], moves[number, 1]
            unclear += _find(x, y, z, first, last, numbers[part], sides[part], order, own)
        done += count - 1
    return moves[:done], counts, unclear


@numba.njit(cache=True, nogil=True)
def passed(curves, moves, counts, lengths, middles, cells):
    """Return the runs that moves pass, and write how many each does.

    `lengths` (P,) float64, mm; `middles` (P, 27, 3): the middle of each cell; `runs` (R, 4) int64:
    the cell, its frames, and the one that is nearest to the middle; `apart` (R, 1) float64, how far
    from it.
    """
    runs = np.empty((128 * len(counts), 4), np.int64)
    nearest = np.empty((128 * len(counts), 1))
    done = many = 0
    for part in range(len(counts)):
        x, y, z, own = curves[0, part], curves[1, part], curves[2, part], cells[part]
        for number in range(done, done + counts[part]):
            first, last = moves[number, 0], moves[number, 1]
            while len(runs) < many + last - first + 1:
                runs, nearest = _longer(runs, many), _longer(nearest, many)
            begin, start = many, first
            while start <= last:
                code, stop = own[start], start + 1
                while stop <= last and own[stop] == code:
                    stop += 1
                some = last if stop > last else start
                scale = lengths[part] if code // 3 == PLACE else 0.0
                near, off = _nearest(x, y, z, some, stop, scale, middles[part, code])
                runs[many, 0], runs[many, 1], runs[many, 2], runs[many, 3] = code, start, stop, near
                nearest[many, 0] = off
                many, start = many + 1, stop
            moves[number, 4] = many - begin
        done += counts[part]
    return runs[:many], nearest[:many]
