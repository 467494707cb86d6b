"""Where joints are, over the stretches in which they are known, a few frames at a time.

Source: ``encode/METHOD.md``, stage 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lanindex.encode.arithmetic import BLOCK, Block, blocks, runs
from lanindex.encode.joints import COLUMNS, KEPT, NAMES, Body
from lanindex.encode.limbs import window
from lanindex.encode.resample import Resampling
from lanindex.model import Span

Floats = NDArray[np.float64]

FEW = 4
"""Joints of which a whole block of frames is worked out at a time."""


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Joints over frames in which all of them are known; nothing is worked out before it is asked.

    Attributes
    ----------
    body : Body
        The capture.
    known : Span
        The frames of the source.
    names : tuple of str
        The joints, and what of ``joints.AXES`` is with them.
    work : Resampling
        How its frames are made of those of the source.
    frames : range
        Numbers of the resampled frames.
    """

    body: Body
    known: Span
    names: tuple[str, ...]
    work: Resampling
    frames: range

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
        kept = self._kept() if self.body.short else None
        size = BLOCK if self.body.short else _size(len(self.names))
        columns = [COLUMNS[name] for name in self.names]
        for block in blocks(len(self.frames), neighbours, size):
            if kept is None:
                calm = list(self._calm(self.names, block.outer))
            else:
                calm = [kept[column, block.outer] for column in columns]
            yield block, dict(zip(self.names, calm, strict=True))

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
        near = self.work.sources(some)
        begin = self.known.start
        points = at(self.body, names, slice(begin + near.start, begin + near.stop))
        calm = self.body.stages.calm(points, self.work, some, width)
        return calm[:, frames.start - first : frames.stop - first]


def _size(joints: int) -> int:
    """Return how many frames of some joints are worked out at a time: fewer of more."""
    return max(BLOCK * FEW // max(joints, FEW), 1)


def at(whole: Body, names: Sequence[str], frames: slice) -> Floats:
    """Return where joints are in some frames of the source, gaps filled: (n, K, 3) float64, mm."""
    joints, first = (whole.joints(names), 0) if whole.short else whole.some(names, frames)
    part = slice(frames.start - first, frames.stop - first)
    if joints.names == tuple(names):
        return joints.places[part]
    return joints.places[part, [joints.names.index(name) for name in names]]


def stretches(whole: Body, needed: Sequence[str], wished: Sequence[str] = ()) -> Iterator[Stretch]:
    """Yield the stretches in which joints are known.

    Parameters
    ----------
    whole : Body
        The capture.
    needed : sequence of str
        Joints without which there is no stretch.
    wished : sequence of str
        Joints that are there if they are known over the whole of it.
    """
    names = (*needed, *wished)
    if _always(whole, names):
        yield from _stretch(whole, 0, len(whole.motion), names)
        return
    seen = _seen(whole, names)
    for start, stop in runs(np.logical_and.reduce(seen[: len(needed)])):
        there = zip(names, np.all(seen[:, start:stop], axis=1).tolist(), strict=True)
        yield from _stretch(whole, start, stop, tuple(name for name, known in there if known))


def together(
    whole: Body, needed: Mapping[str, Sequence[str]]
) -> Iterator[tuple[Stretch, list[str]]]:
    """Yield the stretches in which parts are known, and these: those of one stretch at a time.

    Parameters
    ----------
    whole : Body
        The capture.
    needed : Mapping of str to sequence of str
        By part: the joints without which it is not known.
    """
    found: dict[tuple[int, int], list[str]] = {}
    for part, names in needed.items():
        always = _always(whole, names)
        seen = (
            [(0, len(whole.motion))] if always else runs(np.logical_and.reduce(_seen(whole, names)))
        )
        for one in seen:
            found.setdefault(one, []).append(part)
    for (start, stop), parts in sorted(found.items()):
        joints = dict.fromkeys(name for part in parts for name in needed[part])
        yield from ((it, parts) for it in _stretch(whole, start, stop, tuple(joints)))


def _always(whole: Body, names: Sequence[str]) -> bool:
    return whole.short and whole.always.issuperset(names)


def _stretch(whole: Body, start: int, stop: int, names: tuple[str, ...]) -> Iterator[Stretch]:
    """Yield a stretch, if any frame lies within."""
    work = Resampling(start, stop - start, whole.step)
    if frames := work.frames:
        yield Stretch(whole, Span(start, stop), names, work, frames)


def _seen(whole: Body, names: Sequence[str]) -> NDArray[np.bool_]:
    """Return in which frames joints are known, (K, T)."""
    if whole.short:
        joints = whole.joints(names)
        return ~joints.unknown.T[[joints.names.index(name) for name in names]]
    seen = np.empty((len(names), len(whole.motion)), bool)
    for part in blocks(len(whole.motion), size=_size(len(names))):
        seen[:, part.inner] = ~np.isnan(at(whole, names, part.inner).sum(axis=2)).T
    return seen


def ever(whole: Body, name: str) -> bool:
    """Tell whether a joint is known in any frame."""
    return _always(whole, (name,)) or bool(_seen(whole, (name,)).any())
