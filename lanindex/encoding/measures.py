"""How fast, how far and how straight each symbol is gone.

Source: ``encoding/BODY.md``, "Measures".
"""

from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import blocks, sizes
from lanindex.encoding.limbs import Limbs
from lanindex.encoding.profile import Profile
from lanindex.model.symbol import FIELDS

Floats = NDArray[np.float64]
IntArray = NDArray[np.int64]
Rows = NDArray[Any]

WAY = 0.05
"""Seconds from one point of a way to the next."""

FEW = 1 << 13
"""Rows that are measured together."""

_TINY = 1e-9
"""Millimetres: who is no farther away points nowhere."""


def measure(
    rows: Rows, counts: Sequence[int], limbs: Limbs, profile: Profile, fast: bool = False
) -> None:
    """Fill in the measures of rows (S,) in resampled frames; a starting position has none."""
    limb, frames = np.arange(len(counts)).repeat(counts), limbs.curve.shape[1]
    first = np.maximum(rows["start"].astype(np.int64) - limbs.begin - 1, 0)
    last = np.minimum(
        np.maximum(rows["stop"].astype(np.int64) - limbs.begin - 1, first), frames - 1
    )
    moved = np.append(False, limb[1:] == limb[:-1])
    for some in _few(counts):
        chosen = limb[some], first[some], last[some]
        values = _measured(limbs, *chosen, float(profile.rate), fast)
        for name, measured in zip(("speed", "size", "straightness"), values, strict=True):
            how = FIELDS[name]
            stored = np.rint(np.minimum(measured * how.scale, how.most)) / how.scale
            rows[name][some][moved[some]] = stored[moved[some]]


def _few(counts: Sequence[int]) -> Iterator[slice]:
    """Yield the rows of parts, all at a time if they are few, else a few of a part at a time."""
    if sum(counts) <= FEW:
        yield slice(0, sum(counts))
        return
    for behind, count in zip(accumulate(counts), counts, strict=True):
        for part in blocks(count, size=FEW):
            yield slice(behind - count + part.inner.start, behind - count + part.inner.stop)


def _measured(
    limbs: Limbs, limb: IntArray, first: IntArray, last: IntArray, rate: float, fast: bool
) -> tuple[Floats, Floats, Floats]:
    """Return how fast, how far and how straight some rows are gone, (S,) each."""
    look = _looked
    if fast:
        from lanindex.encoding.written_fast import looked as look
    pace = max(round(WAY * rate), 1)
    peaks, begins, turned, gone = look(
        limbs.curve.transpose(2, 0, 1), limb, first, last, limbs.lengths, pace
    )
    turned = 2 * np.arcsin(np.minimum(turned / 2, 1))
    steps = np.hypot(turned, gone)
    whole, degrees = steps[begins], np.degrees(turned[begins])
    steps[begins] = 0
    way = np.add.reduceat(steps, begins)
    straight = np.divide(whole, way, out=np.ones(len(whole)), where=way > 0)
    return peaks * rate / limbs.lengths[limb], degrees, np.minimum(straight, 1.0)


def _looked(
    curves: Floats, limb: IntArray, first: IntArray, last: IntArray, lengths: Floats, pace: int
) -> tuple[Floats, IntArray, Floats, Floats]:
    """Return the highest speeds (S,) of rows, mm a frame, and how their parts move between points.

    `curves` (3, P, N) mm; `limb, first, last` (S,) the part and the frames of each row; `lengths`
    (P,) mm. Points lie `pace` frames apart, the last perhaps nearer; `begins` (S,) the first point
    of each row. `turned, gone` (M,): by how much direction and distance, in lengths, differ from
    the point before; of a first point, from the last one of its row.
    """
    counts = -((first - last) // pace) + 1
    begins = np.cumsum(counts) - counts
    row = np.arange(len(first)).repeat(counts)
    frames = first[row] + pace * (np.arange(len(row)) - begins[row])
    points = curves[:, limb[row], np.minimum(frames, last[row])]
    away = sizes(points.T)
    points /= np.maximum(away, _TINY)
    away /= lengths[limb[row]]
    before = np.arange(-1, len(row) - 1)
    after = before + 1
    before[begins], after[begins] = begins, begins + counts - 1
    turned = sizes((points[:, after] - points[:, before]).T)
    return _peaks(curves, limb, first, last), begins, turned, away[after] - away[before]


def _peaks(curves: Floats, limb: IntArray, first: IntArray, last: IntArray) -> Floats:
    """Return the highest speed of each row: (S,) mm a frame, by central differences."""
    begin, own = max(int(first.min()) - 1, 0), int(limb.min())
    some = curves[:, own : int(limb.max()) + 1, begin : int(last.max()) + 2]
    _, parts, frames = some.shape
    squares = np.zeros((parts, frames + 1))  # one more, for a row to end before
    if frames > 1:
        for place in some:
            squares[:, 1:-2] += np.square(place[:, 2:] - place[:, :-2])
            squares[:, 0] += 4 * (place[:, 1] - place[:, 0]) ** 2
            squares[:, -2] += 4 * (place[:, -1] - place[:, -2]) ** 2
    pairs = np.stack((first, last + 1), axis=1) - begin + ((limb - own) * (frames + 1))[:, None]
    peaks: Floats = np.sqrt(np.maximum.reduceat(squares.ravel(), pairs.ravel())[::2]) / 2
    return peaks
