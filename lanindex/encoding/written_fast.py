"""Parts of the body written down by compiled stages (extra ``fast``), all of a stretch together.

What rounds otherwise in a compiled loop than in numpy (angles, margins) is left to numpy, so that
the rows are those of `track`, bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding import moves_fast, rows_fast
from lanindex.encoding.arithmetic import parted
from lanindex.encoding.direction import Space, angles, borders, course, margins, numbers, space
from lanindex.encoding.limbs import Limbs
from lanindex.encoding.measures import measure
from lanindex.encoding.profile import Profile
from lanindex.encoding.rules import Rules
from lanindex.encoding.track import Written
from lanindex.model.symbol import blank
from lanindex.notation.lpd import Ranges

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def written(limbs: Limbs, profile: Profile) -> list[Written]:
    """Write down parts that are known over one stretch, as `track.written` does."""
    lengths = limbs.lengths.tolist()
    around = list(map(space, (profile.ranges[part] for part in limbs.parts), lengths))
    curves = np.ascontiguousarray(limbs.curve.transpose(2, 0, 1))
    moves, runs, apart, counts, cells = _passed(curves, around, profile)
    limb = np.arange(len(around))
    owner = limb.repeat(counts).repeat(moves[:, 4])
    points = curves[:, owner, runs[:, 3]].T
    angle = angles(points, runs[:, 0], apart)
    which, openings, rules = _ruled(tuple(profile.rules[part] for part in limbs.parts))
    step = limbs.rate / profile.rate
    table, shares = rows_fast.rows(
        curves,
        moves,
        counts,
        runs,
        apart,
        angle,
        cells[:, 0].astype(np.int64),
        profile.achieved_within,
        np.array([profile.distance.of(length) for length in lengths]),
        borders(tuple(one.ranges for one in around)).references * limbs.lengths[:, None, None],
        profile.onset > 0,
        which,
        openings,
        rules,
        (limbs.known.start, limbs.known.stop, limbs.begin, step.numerator, step.denominator),
    )
    rows = _rows(table, curves, around, limb.repeat(shares))
    measure(rows, shares, limbs, profile, rows_fast.looked)
    rows["start"], rows["stop"] = table.T[1:3]
    each = parted(rows, shares.tolist())
    return [Written(part, limbs.known, own) for part, own in zip(limbs.parts, each, strict=True)]


@lru_cache(8)
def _ruled(each: tuple[Rules, ...]) -> tuple[Ints, Ints, Ints]:
    """Return which rules are a part's, and all of them: see `rows_fast.rows`."""
    different = list(dict.fromkeys(each))
    begins = np.cumsum([0, *(len(one.table[1]) for one in different)])
    openings = [one.table[0] + begin for one, begin in zip(different, begins, strict=False)]
    rules = np.concatenate([one.table[1] for one in different])
    return np.array([different.index(one) for one in each]), np.array(openings), rules


def _rows(table: Ints, curves: Floats, around: Sequence[Space], owner: Ints) -> NDArray[Any]:
    """Return (S,) of `model.SYMBOL` with their margins, start and stop in resampled frames."""
    cell, _, _, achieved, rule, passing, swings, start, stop = table.T
    clear, other = margins(curves[:, owner, achieved].T, cell, around, owner)
    rows = blank(len(table))
    rows["direction"], rows["level"] = np.divmod(cell, 3)
    rows["start"], rows["stop"], rows["passing"] = start, stop, passing
    rows["rule"], rows["swings"], rows["margin"] = rule, swings, np.round(clear, 3)
    rows["runner_direction"], rows["runner_level"] = np.divmod(other, 3)
    return rows


def _passed(
    curves: Floats, around: list[Space], profile: Profile
) -> tuple[Ints, Ints, Floats, Ints, NDArray[np.int8]]:
    """Return moves, runs, how far they are from the middle, moves of each part, and cells."""
    cells = np.full(curves.shape[1:], moves_fast.UNSEEN, np.int8)
    division, measures = numbers(around)
    turned, levels, orders = _turned(tuple(one.ranges for one in around))
    length, radius, *_ = measures
    distance = profile.distance.of(length)
    limit = profile.path_check * distance
    speeds = (profile.candidate_speed, profile.prominence, profile.still)
    table = np.empty((len(around), 7 + levels.shape[1]))
    table[:, 7:] = levels
    values = *(one.of(length) for one in speeds), distance, limit, length, radius
    for column, value in enumerate(values):
        table[:, column] = value
    table[table[:, 4] == 0, 4] = inf
    told = table, turned, orders, cells
    moves, counts, unclear = moves_fast.moved(curves, float(profile.rate), profile.onset, *told)
    if unclear:
        for part, one in enumerate(around):
            some = np.flatnonzero(cells[part] == moves_fast.UNCLEAR)
            (seen,) = course(curves[:, part, some].T[None], [one])
            cells[part, some] = seen.cells
    middles = division.references
    runs, apart = moves_fast.passed(curves, moves, counts, length, middles, cells)
    return moves, runs, apart[:, 0], counts, cells


@cache
def _turned(each: tuple[Ranges, ...]) -> tuple[Floats, Floats, Ints]:
    """Return sides, cosine and sine of the levels, and orders: see `moves_fast.moved`."""
    levels = np.radians([(one.mid, one.high) for one in each])
    turned = np.stack((np.cos(levels), np.sin(levels)), axis=2).reshape(len(each), 4)
    orders = np.array([np.argsort(one.starts) for one in each])
    return np.array([_sides(one) for one in each]), turned, orders


def _sides(ranges: Ranges) -> Floats:
    starts = np.array(ranges.starts)
    order = np.argsort(starts)
    stops = np.empty(8)
    stops[order] = np.roll(starts[order], -1)
    narrow = (stops - starts) % 360 < 180
    begin, end = np.radians(starts), np.radians(stops)
    turned = np.array((np.cos(begin), np.sin(begin), np.cos(end), np.sin(end))) * narrow
    return np.vstack((turned, starts)).T
