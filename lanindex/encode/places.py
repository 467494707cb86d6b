"""Where joints are, over the stretches in which they are known, a few frames at a time.

Source: ``encode/METHOD.md``, stage 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lanindex.body.facing import TURNING
from lanindex.body.made import GAP
from lanindex.encode import compiled
from lanindex.encode.arithmetic import BLOCK, Block, blocks, runs
from lanindex.encode.limbs import body, window
from lanindex.encode.profile import Profile
from lanindex.encode.resample import Resampling
from lanindex.model import Motion, Span

Floats = NDArray[np.float64]

FEW = 4
"""Joints of which a whole block of frames is worked out at a time."""


AXES = {
    f"{joint} {way}": (joint, number)
    for joint in TURNING
    for number, way in enumerate(("right", "up"))
}
"""What points to a joint's own right, and up, beside the joints themselves: ``Head up``."""


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Joints over frames in which all of them are known; nothing is worked out before it is asked.

    Attributes
    ----------
    motion : Motion
        The capture.
    profile : Profile
        Rate and smoothing.
    known : Span
        The frames of the source.
    names : tuple of str
        The joints, and what of `AXES` is with them.
    """

    motion: Motion
    profile: Profile
    known: Span
    names: tuple[str, ...]

    @property
    def frames(self) -> range:
        """Numbers of the resampled frames."""
        return self._work.frames

    @property
    def _work(self) -> Resampling:
        return Resampling(self.known.start, len(self.known), self.motion.rate / self.profile.rate)

    def blocks(self, neighbours: int = 0) -> Iterator[tuple[Block, dict[str, Floats]]]:
        """Yield where the joints are, resampled and smoothed, block by block.

        Parameters
        ----------
        neighbours : int
            Frames on both sides of a block that are wanted, too.

        Yields
        ------
        tuple of Block and dict of str to ndarray
            Frames counted from the stretch's first; by joint (outer, 3) float64, mm, y up.
        """
        work, width = self._work, window(self.profile.smoothing, self.profile.rate)
        size = _size(len(self.names))
        for wide, block in zip(
            blocks(len(work.frames), neighbours + width // 2, size),
            blocks(len(work.frames), neighbours, size),
            strict=True,
        ):
            some = work.frames[wide.outer]
            near = work.sources(some)
            first = self.known.start + near.start
            points = at(self.motion, self.names, slice(first, self.known.start + near.stop))
            calm = compiled.chosen(0).calm(points, work, some, width)
            first = block.outer.start - wide.outer.start
            calm = calm[:, first : first + block.outer.stop - block.outer.start]
            yield block, dict(zip(self.names, calm, strict=True))


def _size(joints: int) -> int:
    """Return how many frames of some joints are worked out at a time: fewer of more."""
    return max(BLOCK * FEW // max(joints, FEW), 1)


def at(motion: Motion, names: Sequence[str], frames: slice) -> Floats:
    """Return where joints are in some frames of the source, gaps filled: (n, K, 3) float64, mm.

    Of `AXES` it is the way in which one points.
    """
    reach = math.floor(GAP * motion.rate) + 1  # a gap that is filled ends within
    first, last = max(frames.start - reach, 0), max(frames.stop + reach, motion.first + 1)
    some = replace(
        motion,
        positions=motion.positions[first:last],
        first=max(motion.first - first, 0),
        rotations=None,
        axes={joint: axes[first:last] for joint, axes in motion.axes.items()},
    )
    joints = body(some, names)
    points = np.empty((len(joints), len(names), 3), order="F")
    for column, name in enumerate(names):
        points[:, column] = _axis(some, *AXES[name]) if name in AXES else joints[name]
    return points[frames.start - first : frames.stop - first]


def _axis(motion: Motion, joint: str, number: int) -> Floats:
    """Return the way in which a joint's axis points, (T, 3); NaN where nothing tells."""
    if joint not in motion.axes:
        return np.full((len(motion), 3), np.nan)
    axis = motion.axes[joint][:, number].astype(np.float64)
    if 0 < motion.first < len(axis):
        axis[: motion.first] = axis[motion.first]
    return axis


def stretches(
    motion: Motion, profile: Profile, needed: Sequence[str], wished: Sequence[str] = ()
) -> Iterator[Stretch]:
    """Yield the stretches in which joints are known.

    Parameters
    ----------
    motion : Motion
        The capture.
    profile : Profile
        Rate and smoothing.
    needed : sequence of str
        Joints without which there is no stretch.
    wished : sequence of str
        Joints that are there if they are known over the whole of it.
    """
    names = (*needed, *wished)
    seen = np.empty((len(names), len(motion)), bool)
    for part in blocks(len(motion), size=_size(len(names))):
        seen[:, part.inner] = ~np.isnan(at(motion, names, part.inner).sum(axis=2)).T
    for start, stop in runs(np.logical_and.reduce(seen[: len(needed)])):
        there = zip(names, seen[:, start:stop], strict=True)
        known = tuple(name for name, known in there if known.all())
        found = Stretch(motion, profile, Span(start, stop), known)
        if found.frames:
            yield found
