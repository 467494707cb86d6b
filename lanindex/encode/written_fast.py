"""Parts of the body written down by compiled stages (extra ``fast``), all of a stretch together.

What rounds otherwise in a compiled loop than in numpy (angles, margins) is left to numpy, so that
the rows are those of `track`, bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import cos, inf, radians, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.encode import moves_fast, rows_fast
from lanindex.encode.direction import Space, angles, course, margins, space
from lanindex.encode.limbs import Limbs
from lanindex.encode.measures import measure
from lanindex.encode.profile import Profile
from lanindex.encode.rules import Rules
from lanindex.encode.track import Written
from lanindex.model.symbol import blank
from lanindex.notation.lpd import Ranges

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def written(limbs: Limbs, profile: Profile) -> list[Written]:
    """Write down parts that are known over one stretch, as `lanindex.encode.track.written` does.

    Parameters
    ----------
    limbs : Limbs
        Their curves.
    profile : Profile
        The numbers.
    """
    around = [
        space(profile.ranges[part], length)
        for part, length in zip(limbs.parts, limbs.lengths.tolist(), strict=True)
    ]
    curves = np.ascontiguousarray(limbs.curve.transpose(2, 0, 1))
    moves, runs, apart, counts, cells = _passed(curves, around, profile)
    limb = np.arange(len(around))
    owner = limb.repeat(counts).repeat(moves[:, 4])
    points = curves[:, owner, runs[:, 3]].T
    angle = angles(points, runs[:, 0], apart)
    which, openings, rules = _ruled([profile.rules[part] for part in limbs.parts])
    step = limbs.rate / profile.rate
    table, shares = rows_fast.rows(
        curves,
        moves,
        counts,
        runs,
        apart,
        angle,
        cells[:, 0].astype(np.int64),
        np.array([(profile.achieved_within, profile.distance.of(one.length)) for one in around]),
        np.array([one.references * one.length for one in around]),
        profile.onset > 0,
        which,
        openings,
        rules,
        (limbs.known.start, limbs.known.stop, limbs.begin, step.numerator, step.denominator),
    )
    rows = _rows(table, curves, around, limb.repeat(shares))
    measure(rows, shares, limbs, profile, rows_fast.looked)
    rows["start"], rows["stop"] = table.T[1:3]
    each = np.split(rows, np.cumsum(shares)[:-1])
    return [Written(part, limbs.known, own) for part, own in zip(limbs.parts, each, strict=True)]


def _ruled(each: Sequence[Rules]) -> tuple[Ints, Ints, Ints]:
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
    told = (
        curves,
        float(profile.rate),
        profile.onset,
        np.array([_numbers(one, profile) for one in around]),
        np.array([_sides(one.ranges) for one in around]),
        np.array([np.argsort(one.ranges.starts) for one in around]),
        np.array([one.references for one in around]),
        cells,
    )
    *found, unclear = moves_fast.passed(*told)
    if unclear:
        for part, one in enumerate(around):
            some = np.flatnonzero(cells[part] == moves_fast.UNCLEAR)
            (seen,) = course(curves[:, part, some].T[None], [one])
            cells[part, some] = seen.cells
        *found, _ = moves_fast.passed(*told)
    moves, runs, apart, counts = found
    return moves, runs, apart[:, 0], counts, cells


def _numbers(around: Space, profile: Profile) -> tuple[float, ...]:
    length, ranges = around.length, around.ranges
    distance = profile.distance.of(length)
    measures = (profile.candidate_speed, profile.prominence, profile.still)
    levels = (radians(ranges.mid), radians(ranges.high))
    return (
        *(one.of(length) for one in measures),
        distance,
        profile.path_check * distance or inf,
        length,
        ranges.radius(length),
        *(turn(level) for level in levels for turn in (cos, sin)),
    )


@cache
def _sides(ranges: Ranges) -> Floats:
    starts = np.array(ranges.starts)
    order = np.argsort(starts)
    stops = np.empty(8)
    stops[order] = np.roll(starts[order], -1)
    narrow = (stops - starts) % 360 < 180
    begin, end = np.radians(starts), np.radians(stops)
    turned = np.array((np.cos(begin), np.sin(begin), np.cos(end), np.sin(end))) * narrow
    return np.vstack((turned, starts)).T
