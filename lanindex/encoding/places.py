"""Stage 0: where joints are, over the stretches in which they are known, at the rate of the method.

Frames are made of those of the source a few at a time.

Source: ``encoding/METHOD.md``, stage 0.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import Block, blocks, slopes, smooth, window
from lanindex.encoding.joints import COLUMNS, KEPT, NAMES, Body, Frames, chunk, few, grouped
from lanindex.model import Span

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

    def values(self, points: Floats, frames: range, fast: bool = False) -> Floats:
        """Return the values (N, ...) of frames from the points of ``sources(frames)``, (S, ...)."""
        index, weights = _weights(self, frames)
        if not len(index):
            return points
        if fast:
            from lanindex.encoding import curves_fast

            rows = np.ascontiguousarray(points.T)
            flat = curves_fast.resampled(rows.reshape(-1, len(points)), index, weights)
            between: Floats = flat.reshape(*rows.shape[:-1], len(index))
            return between.T
        slope = slopes(points.T)
        values: Floats = (
            points.T.take(index, axis=-1) * weights[0]
            + points.T.take(index + 1, axis=-1) * weights[1]
            + slope.take(index, axis=-1) * weights[2]
            + slope.take(index + 1, axis=-1) * weights[3]
        )
        return values.T


@lru_cache(4)  # heading, limbs and joints ask for the same
def _weights(work: Resampling, frames: range) -> tuple[NDArray[np.int64], Floats]:
    """Return the points before frames, (N,), and weights (4, N): two points, two slopes."""
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
    """Return points (T, ...), from source frame `start` on, at the rate `target`."""
    work = Resampling(start, len(points), rate / target)
    frames = work.frames
    if work.step == 1:
        return start, points
    values = np.empty((*points.shape[:0:-1], len(frames)))
    for part in blocks(len(frames)):
        some = frames[part.inner]
        values[..., part.inner] = work.values(points[work.sources(some)], some).T
    return frames.start, values.T


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Joints over frames in which all are known; nothing is worked out before it is needed."""

    body: Body  # The capture
    known: Span  # The frames of the source
    names: tuple[str, ...]  # The joints, and what of ``joints.AXES`` is with them
    work: Resampling  # How its frames are made of those of the source
    frames: range  # Numbers of the resampled frames

    def blocks(
        self, neighbours: int = 0, names: Sequence[str] = ()
    ) -> Iterator[tuple[Block, dict[str, Floats]]]:
        """Yield where the joints are, resampled and smoothed, block by block."""
        wanted = tuple(names) or self.names
        size = 0 if self.body.short else few(len(wanted))
        for block in blocks(len(self.frames), neighbours, size):
            yield block, self._places(wanted, block.outer)

    def take(self, names: Sequence[str], frames: NDArray[np.int64]) -> dict[str, Floats]:
        """Return where joints are in some frames, counted from the first: by joint (n, 3)."""
        found = {name: np.empty((len(frames), 3)) for name in names}
        order = np.argsort(frames)
        for block in blocks(len(self.frames), size=few(len(names))):
            start, stop = frames[order].searchsorted((block.inner.start, block.inner.stop))
            if start < stop:
                some = order[start:stop]
                for name, places in self._places(names, block.inner).items():
                    found[name][some] = places[frames[some] - block.inner.start]
        return found

    def _places(self, names: Sequence[str], frames: slice) -> dict[str, Floats]:
        """Return where joints are in some frames: by joint (n, 3)."""
        if not self.body.short:
            return dict(zip(names, self._calm(names, frames), strict=True))
        kept = self._kept()
        return {name: kept[COLUMNS[name], frames] for name in names}

    def _kept(self) -> Floats:
        """Return where all joints are, (K, N, 3), worked out once."""
        kept, key = self.body.calm, (self.known.start, self.known.stop)
        if key not in kept:
            if sum(one.shape[1] for one in kept.values()) * len(NAMES) > KEPT:
                kept.clear()
            kept[key] = self._calm(NAMES, slice(0, len(self.frames)))
        return kept[key]

    def _calm(self, names: Sequence[str], frames: slice) -> Floats:
        """Return where joints are in some frames, counted from the first, (K, n, 3)."""
        profile = self.body.profile
        width = window(profile.smoothing, profile.rate)
        first = max(frames.start - width // 2, 0)
        some = self.frames[first : frames.stop + width // 2]
        fast = self.body.fast
        rough = self.work.values(self.sources(names, some), some, fast).T
        calm = smooth(rough, width, fast).transpose(1, 2, 0)
        return calm[:, frames.start - first : frames.stop - first]

    def sources(self, names: Sequence[str], frames: range) -> Floats:
        """Return where joints are in the frames of the source that some are made of, (S, K, 3)."""
        near, begin, body = self.work.sources(frames), self.known.start, self.body
        some = slice(begin + near.start, begin + near.stop)
        if body.short or len(self.known) > chunk(len(body.names)):
            return body.at(names, some)
        # other joints are asked for next in the frames around so short a stretch
        return body.at(body.names, some)[:, list(map(body.names.index, names))]


def stretches(whole: Body, needed: Sequence[str], wished: Sequence[str] = ()) -> Iterator[Stretch]:
    """Yield the stretches in which joints are known."""
    found = whole.together(needed)
    there = [(name, _within(found, whole.known[name])) for name in wished]
    for number, (start, stop) in enumerate(found.tolist()):
        names = (*needed, *(name for name, known in there if known[number]))
        yield from _stretch(whole, start, stop, names)


def together(
    whole: Body, needed: Mapping[str, Sequence[str]]
) -> Iterator[tuple[Stretch, Sequence[str]]]:
    """Yield the stretches in which parts are known, with a few of these parts at a time."""
    found: dict[tuple[int, int], list[str]] = {}
    for part, names in needed.items():
        for start, stop in whole.together(names).tolist():
            found.setdefault((start, stop), []).append(part)
    for (start, stop), parts in sorted(found.items()):
        frames = Resampling(start, stop - start, whole.step).frames
        for some in grouped(parts, len(frames)):
            joints = dict.fromkeys(name for part in some for name in needed[part])
            yield from ((it, some) for it in _stretch(whole, start, stop, tuple(joints)))


def _stretch(whole: Body, start: int, stop: int, names: tuple[str, ...]) -> Iterator[Stretch]:
    """Yield a stretch, if any frame lies within."""
    work = Resampling(start, stop - start, whole.step)
    if frames := work.frames:
        yield Stretch(whole, Span(start, stop), names, work, frames)


def _within(found: Frames, known: Frames) -> NDArray[np.bool_]:
    """Tell of each stretch (R, 2) whether one of those that are known holds all of it."""
    if found is known:
        return np.ones(len(found), bool)
    last = known[:, 0].searchsorted(found[:, 0], "right")
    return np.append(0, known[:, 1])[last] >= found[:, 1]
