"""Stage 0: from the frames of the source to those of the method, a stretch at a time.

Source: ``encoding/METHOD.md``, stage 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import blocks, smooth

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Resampling:
    """A cubic Hermite, slopes by central differences, one-sided at the ends."""

    start: int  # Number of the first frame of the source
    count: int  # How many there are
    step: Fraction  # Frames of the source from one frame of the result to the next

    @property
    def frames(self) -> range:
        """Frame k of the result lies at frame k · step of the source, none after the last."""
        over, under = self.step.as_integer_ratio()
        last = self.start + self.count - 1
        return range(-(-self.start * under // over), last * under // over + 1)

    def sources(self, frames: range) -> slice:
        """Return which points, counted from the first, some frames (one at least) are made of."""
        over, under = self.step.as_integer_ratio()
        first, last = (frame * over // under - self.start for frame in (frames[0], frames[-1]))
        if self.step == 1 or self.count < 2:
            return slice(first, last + 1)
        return slice(max(min(first, self.count - 2) - 1, 0), min(last + 3, self.count))

    def weights(self, frames: range) -> tuple[NDArray[np.int64], Floats]:
        """Return what values are made of, beside that they are the points where there is nothing.

        `index` (N,) int64: which of the points of ``sources(frames)`` is the one before each frame;
        `weights` (4, N) float64: of this point and the next, and of their slopes.
        """
        return _weights(self, frames)

    def values(self, points: Floats, frames: range) -> Floats:
        """Return the values of some frames.

        `points` (S, ...) float64, the points of ``sources(frames)``; returned (N, ...) float64.
        """
        index, weights = self.weights(frames)
        if not len(index):
            return points
        slope = np.gradient(points, axis=0).T
        values: Floats = (
            points.T.take(index, axis=-1) * weights[0]
            + points.T.take(index + 1, axis=-1) * weights[1]
            + slope.take(index, axis=-1) * weights[2]
            + slope.take(index + 1, axis=-1) * weights[3]
        )
        return values.T


@lru_cache(4)  # heading, limbs and joints ask for the same
def _weights(work: Resampling, frames: range) -> tuple[NDArray[np.int64], Floats]:
    if work.step == 1 or work.count < 2:
        return np.empty(0, np.int64), np.empty((4, 0))
    numbers = np.arange(frames.start, frames.stop) * work.step.numerator
    whole, rest = np.divmod(numbers, work.step.denominator)
    index = np.minimum(whole - work.start, work.count - 2)
    share = rest / work.step.denominator + (whole - work.start - index)
    square, cube = share**2, share**3
    bend = 3 * square - 2 * cube
    weights = np.array((1 - bend, bend, cube - 2 * square + share, cube - square))
    return index - work.sources(frames).start, weights


def resample(points: Floats, start: int, rate: Fraction, target: Fraction) -> tuple[int, Floats]:
    """Resample all points.

    `points` (T, ...) float64, values at source frames `start` and on; `values` (N, ...) float64; no
    frame lies after the last of the source.
    """
    work = Resampling(start, len(points), rate / target)
    frames = work.frames
    if work.step == 1:
        return start, points
    values = np.empty((*points.shape[:0:-1], len(frames)))
    for part in blocks(len(frames)):
        some = frames[part.inner]
        values[..., part.inner] = work.values(points[work.sources(some)], some).T
    return frames.start, values.T


def calm(points: Floats, work: Resampling, frames: range, width: int) -> Floats:
    """Return joints (S, K, 3) resampled and smoothed, (K, N, 3); the rest is as for `curves`."""
    return smooth(work.values(points, frames).T, width).transpose(1, 2, 0)


def curves(
    near: Floats,
    ends: NDArray[np.int64],
    work: Resampling,
    frames: range,
    angle: Floats,
    width: int,
) -> Floats:
    """Return curves of some frames.

    `near` (S, K, 3) float64, the places that the frames are made of; `ends` (2, P): of each part
    which joint is the parent, and which the child; `angle` (N,) float64, radians: the heading;
    returned (3, P, N) float64.
    """
    parents, children = ends
    forward, up, right = work.values(near[:, children] - near[:, parents], frames).T
    sine, cosine = np.sin(angle), np.cos(angle)
    turned = np.stack((forward * cosine - right * sine, up, forward * sine + right * cosine))
    return smooth(turned, width)


Curves = Callable[[Floats, NDArray[np.int64], Resampling, range, Floats, int], Floats]
