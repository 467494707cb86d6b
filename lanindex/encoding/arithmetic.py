"""What several stages work out alike."""

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import accumulate, pairwise
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BLOCK = 1 << 13
"""Frames that a stage works on at a time, so that what lies between start and result is small."""


class Block(NamedTuple):
    """Some frames of many."""

    inner: slice  # Those frames
    outer: slice  # They, and as many neighbours as they depend on, as far as there are any
    within: slice  # Where `inner` lies in `outer`


def blocks(count: int, neighbours: int = 0, size: int = 0) -> Iterator[Block]:
    """Yield `count` frames block by block, with the neighbours that each depends on."""
    size = size or BLOCK
    for start in range(0, count, size):
        stop = min(start + size, count)
        first = max(start - neighbours, 0)
        outer = slice(first, min(stop + neighbours, count))
        yield Block(slice(start, stop), outer, slice(start - first, stop - first))


def sizes(vectors: Floats) -> Floats:
    """Return the sizes (...) of vectors (..., 3): forward, up, right.

    The horizontal part is summed first: quarter turns and mirroring then change no bit.
    """
    size: Floats = np.sqrt(vectors[..., 0] ** 2 + vectors[..., 2] ** 2 + vectors[..., 1] ** 2)
    return size


def dot(one: Floats, other: Floats) -> Floats:
    """Return the scalar products of (3, N) vectors, (N,)."""
    product: Floats = one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
    return product


def cross(one: Floats, other: Floats) -> Floats:
    """Return the vector products of (3, ...) vectors: numpy's take ten times as long."""
    product = np.empty(one.shape)
    for axis in range(3):
        second, third = (axis + 1) % 3, (axis + 2) % 3
        product[axis] = one[second] * other[third] - one[third] * other[second]
    return product


def dist(one: Sequence[float] | Floats, other: Sequence[float] | Floats) -> float:
    """Return how far two points (3,) are apart, summed as `sizes` does."""
    x, y, z = one[0] - other[0], one[1] - other[1], one[2] - other[2]
    return sqrt(x * x + z * z + y * y)


def slopes(curves: NDArray[Any]) -> NDArray[Any]:
    """Return central differences of (..., N) numbers, one-sided at the ends; 0 of a single one.

    They are those of numpy's gradient, in a third of its time where curves are short.
    """
    found = np.zeros_like(curves)
    if curves.shape[-1] > 1:
        found[..., 1:-1] = (curves[..., 2:] - curves[..., :-2]) / 2
        found[..., 0] = curves[..., 1] - curves[..., 0]
        found[..., -1] = curves[..., -1] - curves[..., -2]
    return found


def bend(upper: Floats, lower: Floats) -> Floats:
    """Return the angles (...) from upper to lower bones (3, ...), degrees; 0: straight."""
    along = upper[0] * lower[0] + upper[2] * lower[2] + upper[1] * lower[1]
    x, y, z = cross(upper, lower)
    angle: Floats = np.degrees(np.arctan2(np.sqrt(x**2 + z**2 + y**2), along))
    return angle


def unwrapped(angles: Floats) -> Floats:
    """Return radians (N,) in one go, past half a circle on: as numpy's unwrap does, in blocks."""
    steps = [slice(part.inner.start, part.inner.stop + 1) for part in blocks(len(angles) - 1)]
    if all((np.abs(np.diff(angles[some])) < np.pi).all() for some in steps):
        return angles
    found, gone = angles.copy(), 0.0
    for some in steps:
        step = np.diff(angles[some])
        turn = np.mod(step + np.pi, 2 * np.pi) - np.pi
        turn[(turn == -np.pi) & (step > 0)] = np.pi
        turn -= step
        turn[np.abs(step) < np.pi] = 0
        turn[0] += gone
        turned = turn.cumsum()
        found[some][1:] += turned
        gone = float(turned[-1])
    return found


def smooth(curve: Floats, window: int, fast: bool = False) -> Floats:
    """Return the centred moving average of curves (..., N); shorter at the ends."""
    half = min(window // 2, curve.shape[-1] - 1)
    if half < 1:
        return curve
    if fast:
        from lanindex.encoding import curves_fast

        rows = np.ascontiguousarray(curve).reshape(-1, curve.shape[-1])
        calm: Floats = curves_fast.smoothed(rows, half).reshape(curve.shape)
        return calm
    total: Floats = curve.copy()
    for shift in range(1, half + 1):
        total[..., shift:] += curve[..., :-shift]
        total[..., :-shift] += curve[..., shift:]
    frames, last = np.arange(curve.shape[-1]), curve.shape[-1] - 1
    total /= np.minimum(frames + half, last) - np.maximum(frames - half, 0) + 1
    return total


def window(seconds: float, rate: Fraction) -> int:
    """Return the odd number of frames nearest to `seconds`."""
    return 2 * int(seconds * float(rate) / 2) + 1


def median(values: NDArray[Any]) -> float:
    """Return the median of (N,) numbers, none NaN, in a tenth of the time of numpy's."""
    lower, upper = (len(values) - 1) // 2, len(values) // 2
    found = np.partition(values, (lower, upper))
    return float((found[lower] + found[upper]) / 2)


def parted(rows: NDArray[Any], counts: Iterable[int]) -> list[NDArray[Any]]:
    """Return rows in parts of so many each: numpy's split takes ten times as long."""
    return [rows[start:stop] for start, stop in pairwise(accumulate(counts, initial=0))]


def runs(mask: NDArray[Any]) -> list[tuple[int, int]]:
    """Return start and stop of each stretch of True, of (N,) truths."""
    if not len(mask):
        return []
    edges = [0, *((mask[1:] != mask[:-1]).nonzero()[0] + 1).tolist(), len(mask)]
    first = 0 if mask[0] else 1
    return list(zip(edges[first::2], edges[first + 1 :: 2], strict=False))


def held(begins: NDArray[np.bool_], stays: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a state with hysteresis: on from a frame where it begins, as long as it stays."""
    state = np.empty(len(begins), bool)
    before = np.zeros(1, bool)
    for part in blocks(len(begins)):
        stay = stays[part.inner]
        on = begins[part.inner] & stay
        last = np.where(on | ~stay, np.arange(1, len(on) + 1), 0)
        state[part.inner] = np.concatenate((before, on))[np.maximum.accumulate(last)]
        before = state[part.inner][-1:]
    return state
