"""Stages 2 to 6, compiled (extra ``fast``): all parts of a stretch from curves to rows.

The rows are equal to those that `written`, `direction` and `measures` make with numpy. Angles and
margins would round differently in a compiled loop, so numpy computes them here, too.
"""

from functools import cache
from math import atan2, degrees, inf, sqrt

import numba
import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from lanindex.alphabet import PLACE
from lanindex.encoding.arithmetic import dist, parted
from lanindex.encoding.curves_fast import middle, size
from lanindex.encoding.direction import Space, angles, course
from lanindex.encoding.limbs import Limbs
from lanindex.encoding.measures import _TINY
from lanindex.encoding.profile import Profile
from lanindex.encoding.written import (
    LONG_HOLD,
    ROW,
    Written,
    _gain,
    _put,
    _way,
    achieve,
    apply_rules,
    finished,
    onset_frame,
    settings,
    spaces,
    symbol_begin,
    write_rows,
)
from lanindex.notation.lpd_ldd import Ranges

UNSEEN, UNCLEAR = -2, -1
"""Codes of a cell that was not computed, and of one whose border is too near to tell."""

_CLEAR = 1e-9  # of a radius, or of a degree: nearer to a border numpy decides


@numba.njit
def _between(x, y, z, one, other):
    return size(x[one] - x[other], y[one] - y[other], z[one] - z[other])


@numba.njit
def _speeds(x, y, z, rate, speed):
    last = len(speed) - 1
    for frame in range(1, last):
        speed[frame] = size(
            (x[frame + 1] - x[frame - 1]) / 2.0 * rate,
            (y[frame + 1] - y[frame - 1]) / 2.0 * rate,
            (z[frame + 1] - z[frame - 1]) / 2.0 * rate,
        )
    for frame, first in ((0, 0), (last, last - 1)):
        speed[frame] = 0.0 if last < 1 else size(
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
        near = _between(x, y, z, stop, first) <= within
        if near and limit < inf:
            for frame in range(before, stop):
                if _between(x, y, z, frame, first) > limit:
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


register_jitable(onset_frame)  # compiled with the loop below that calls it


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
            fast, slow = peak / 4, onset * peak
            begin = onset_frame(speed, holds[number, 0], first, last, 1, fast, max(slow, quiet))
            end = onset_frame(speed, holds[number + 1, 1], last, first, -1, fast, max(slow, calm))
            end = max(begin, end)
        moves[number, 0], moves[number, 1] = first, last
        moves[number, 2], moves[number, 3] = begin, end


@numba.njit
def _sector(x, z, starts, order):
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
    radius, mid_cosine, mid_sine, high_cosine, high_sine = numbers[5:]
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
                sector = _sector(forward, right, sides[:, 4], order)
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
        scale = length if length else max(size(x[frame], y[frame], z[frame]), 1e-9)
        apart = size(x[frame] / scale - forward, y[frame] / scale - up, z[frame] / scale - right)
        if apart < least:
            found, least = frame, apart
    return found, least


@numba.njit(cache=True, nogil=True)
def moved(curve, rate, onset, numbers, sides, order, cells):
    """Return the moves (M, 5) of a part, and how many cells are unclear; write `cells`.

    `curve` (3, N) mm; `numbers` (10,): candidate speed, prominence, still, d_t, how far a part may
    stray in a hold, radius of place, cosine and sine of the elevations at which mid and high begin;
    `sides` (8, 5): cosine and sine of the azimuths at which a direction begins and ends, 0 if it
    takes half of the circle or more, and the begin in degrees; `order` (8,): directions by azimuth;
    `cells` (N,) `UNSEEN`. A move is a `Segment` and room for the number of its runs.
    """
    x, y, z = curve
    slow, prominence, still, distance, limit = numbers[:5]
    frames = len(cells)
    speed, depths, rims = np.empty(frames), np.empty(frames), np.empty(frames)
    firsts, lasts = np.empty(frames, np.int64), np.empty(frames, np.int64)
    holds = np.empty((frames + 1, 2), np.int64)
    _speeds(x, y, z, rate, speed)
    count = _minima(speed, slow, prominence, still, depths, rims, firsts, lasts)
    count = _holds(x, y, z, firsts, lasts, count, distance, limit, holds)
    moves = np.empty((count - 1, 5), np.int64)
    _moves(speed, holds, count, onset, still, moves)
    unclear = _find(x, y, z, 0, 0, numbers, sides, order, cells)
    for move in moves:
        unclear += _find(x, y, z, move[0], move[1], numbers, sides, order, cells)
    return moves, unclear


@numba.njit(cache=True, nogil=True)
def passed(curve, moves, length, middles, cells):
    """Return the runs (R, 4) of moves and their distances (R,) from the middles of cells.

    A run is its cell, its frames, and the frame nearest to the middle; `middles` (27, 3) of the
    cells. The last column of `moves` becomes the number of runs.
    """
    x, y, z = curve
    most = len(cells) + len(moves)
    runs, apart, many = np.empty((most, 4), np.int64), np.empty(most), 0
    for move in moves:
        begin, start, last = many, move[0], move[1]
        while start <= last:
            code, stop = cells[start], start + 1
            while stop <= last and cells[stop] == code:
                stop += 1
            some = last if stop > last else start
            scale = length if code // 3 == PLACE else 0.0
            near, apart[many] = _nearest(x, y, z, some, stop, scale, middles[code])
            runs[many, 0], runs[many, 1], runs[many, 2], runs[many, 3] = code, start, stop, near
            many, start = many + 1, stop
        move[4] = many - begin
    return runs[:many].copy(), apart[:many].copy()


for _function in (dist, _way, _gain, achieve, apply_rules, symbol_begin, _put):
    register_jitable(_function)  # compiled with the loop that calls them
written_rows = numba.njit(cache=True, nogil=True)(write_rows)


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
    """Return what rows go along their curves: see `lanindex.encoding.measures._looked`."""
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


Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def written(limbs: Limbs, profile: Profile) -> list[Written]:
    """Write down parts that are known over one stretch, as `written.written` does."""
    around = spaces(limbs, profile)
    curves = np.ascontiguousarray(limbs.curve.transpose(2, 0, 1))
    each = [_passed(curves[:, part], one, profile) for part, one in enumerate(around)]
    counts = [len(runs) for *_, runs, _ in each]
    runs, apart = (np.concatenate(those) for those in list(zip(*each, strict=True))[2:])
    limb = np.arange(len(around)).repeat(counts)
    angle = parted(angles(curves[:, limb, runs[:, 3]].T, runs[:, 0], apart), counts)
    tables = [
        written_rows(
            curves[:, part],
            cell,
            moves,
            own[:, 0],
            own[:, 3],
            off,
            angle[part],
            *np.zeros((2, counts[part]), np.int64),
            *settings(limbs.parts[part], around[part], profile),
        )
        for part, (cell, moves, own, off) in enumerate(each)
    ]
    table = np.concatenate(tables).view(ROW)[:, 0]
    return finished(table, list(map(len, tables)), limbs, around, profile, True)


def _passed(curve: Floats, around: Space, profile: Profile) -> tuple[int, Ints, Ints, Floats]:
    """Return the cell of the first frame, moves, runs, and how far these are from the middle."""
    cells = np.full(curve.shape[1], UNSEEN, np.int8)
    length = around.length
    distance = profile.distance.of(length)
    speeds = (profile.candidate_speed, profile.prominence, profile.still)
    levels, sides, order = _borders(around.ranges)
    numbers = *(one.of(length) for one in speeds), distance, profile.path_check * distance or inf
    table = np.array((*numbers, around.ranges.radius(length), *levels))
    moves, unclear = moved(curve, float(profile.rate), profile.onset, table, sides, order, cells)
    if unclear:
        some = np.flatnonzero(cells == UNCLEAR)
        (seen,) = course(curve[:, some].T[None], [around])
        cells[some] = seen.cells
    return int(cells[0]), moves, *passed(curve, moves, length, around.references, cells)


@cache
def _borders(ranges: Ranges) -> tuple[tuple[float, ...], Floats, Ints]:
    """Return cosine and sine of the levels; sides; and order: see `moved`."""
    starts = np.array(ranges.starts)
    order = np.argsort(starts)
    stops = np.empty(8)
    stops[order] = np.roll(starts[order], -1)
    narrow = (stops - starts) % 360 < 180
    begin, end = np.radians(starts), np.radians(stops)
    turned = np.array((np.cos(begin), np.sin(begin), np.cos(end), np.sin(end))) * narrow
    levels = np.radians((ranges.mid, ranges.high))
    borders = np.stack((np.cos(levels), np.sin(levels)), axis=1)
    return tuple(borders.ravel().tolist()), np.vstack((turned, starts)).T, order
