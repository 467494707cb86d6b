"""Stages 0 and 1: where the body faces, and its limbs turned to face forward, part by part.

Source: ``encoding/METHOD.md``, stages 0 and 1; Matsumoto and Hachimura (2001), 2 and 4.2.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import PARTS
from lanindex.encoding.arithmetic import blocks, runs, smooth, window
from lanindex.encoding.joints import Body, known_parts
from lanindex.encoding.places import Resampling, Stretch, together
from lanindex.encoding.profile import load
from lanindex.model import Motion, Span

Floats = NDArray[np.float64]

AXES = (("LHip", "RHip"), ("LShoulder", "RShoulder"))
"""What tells where the body faces, the first that is there."""

CACHED = 1 << 13
"""Frames times limbs turned at a time: what comes between stays in the processor's cache."""

SHORTEST_AXIS = 1.0
"""Millimetres: a hip axis shorter than this on the ground tells no heading."""


def heading(
    motion: Motion,
    target: Fraction,
    body: Body | None = None,
    axes: Sequence[tuple[str, str]] = AXES,
) -> Floats:
    """Return the rotation (N,) about the vertical that brings the first axis seen to +z, radians.

    Where the axis tells nothing, the last rotation is kept.
    """
    whole = body or Body(motion, load("default"))
    pair = next((one for one in axes if len(whole.together(one))), axes[0])
    count = math.floor((len(motion) - 1) * target / motion.rate) + 1
    turn, clear = np.zeros(count), np.zeros(count, bool)
    for start, stop in whole.together(pair).tolist():
        work = Resampling(start, stop - start, motion.rate / target)
        for part in blocks(len(work.frames)):
            some = work.frames[part.inner]
            near = work.sources(some)
            axis = _axis(whole, pair, slice(start + near.start, start + near.stop))
            east, south = work.values(axis, some, whole.fast).T
            turn[some.start : some.stop] = np.arctan2(east, south)
            clear[some.start : some.stop] = np.hypot(east, south) >= SHORTEST_AXIS
    for start, stop in runs(~clear):
        if stop - start < count:
            turn[start:stop] = turn[start - 1 if start else stop]
        else:
            turn[:] = 0
    return turn


def _axis(body: Body, pair: tuple[str, str], frames: slice) -> Floats:
    """Return the way from left to right over the ground in some frames, (n, 2)."""
    left, right = body.at(pair, frames).transpose(1, 0, 2)
    axis: Floats = (right - left)[:, ::2]
    return axis


@dataclass(frozen=True, slots=True, eq=False)
class Limbs:
    """Parts of the body over one stretch in which all of them are known."""

    parts: tuple[str, ...]  # (P) names
    known: Span  # The stretch, in frames of the source
    rate: Fraction  # Frames a second of the source
    begin: int  # Number of the first resampled frame
    # (P, N, 3) float64, mm: child minus parent, forward +x, up +y, right +z, smoothed
    curve: Floats
    lengths: Floats  # (P,) float64, mm


def limbs(body: Body, turn: Floats, parts: Iterable[str] | None = None) -> Iterator[Limbs]:
    """Yield the curves of parts, stretch by stretch; `turn` (N,) radians, as from `heading`."""
    names = known_parts(body.motion) if parts is None else list(parts)
    sizes = dict(zip(names, body.lengths(names).tolist(), strict=True))
    ends = {name: (PARTS[name].parent, PARTS[name].child) for name in names if sizes[name] > 0}
    for stretch, some in together(body, ends):
        curve = _curve(stretch, turn, [ends[name] for name in some])
        own = np.array([sizes[name] for name in some])
        yield Limbs(tuple(some), stretch.known, body.motion.rate, stretch.frames.start, curve, own)
        del curve


def _curve(stretch: Stretch, turn: Floats, pairs: Sequence[tuple[str, str]]) -> Floats:
    """Return curves between joints, (P, N, 3), worked out block by block."""
    body, frames = stretch.body, stretch.frames
    names = body.names if body.short else stretch.names
    ends = np.array([tuple(map(names.index, pair)) for pair in pairs])
    numbers = np.arange(len(ends))
    width = window(body.profile.smoothing, body.profile.rate)
    curve = np.empty((3, len(pairs), len(frames)))
    for part in blocks(len(frames), width // 2):
        some = frames[part.outer]
        places, angle = stretch.sources(names, some), turn[some.start : some.stop]
        sine, cosine = np.sin(angle), np.cos(angle)
        for group in np.array_split(numbers, -(-len(places) * len(ends) // CACHED)):
            parent, child = ends[group].T
            way = stretch.work.values(places[:, child] - places[:, parent], some, body.fast)
            forward, up, right = way.T
            turned = forward * cosine - right * sine, up, forward * sine + right * cosine
            calm = smooth(np.array(turned), width, body.fast)
            curve[:, group, part.inner] = calm[..., part.within]
    return curve.transpose(1, 2, 0)
