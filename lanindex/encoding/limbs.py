"""Stages 0 and 1: limbs of the body, resampled, turned to face forward, part by part.

Source: ``encoding/METHOD.md``, stages 0 and 1; Matsumoto and Hachimura (2001), 2 and 4.2.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import PARTS
from lanindex.encoding.arithmetic import blocks, window
from lanindex.encoding.joints import Body, known_parts
from lanindex.encoding.places import Stretch, together
from lanindex.encoding.resample import Curves, curves
from lanindex.model import Span

Floats = NDArray[np.float64]


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


def limbs(
    body: Body,
    turn: Floats,
    parts: Iterable[str] | None = None,
    make: Curves | None = None,
) -> Iterator[Limbs]:
    """Yield the curves of parts, as far as the capture knows them, stretch by stretch.

    `turn` (N,) float64, radians, as from `lanindex.encoding.heading.heading`.
    """
    names = known_parts(body.motion) if parts is None else list(parts)
    sizes = dict(zip(names, body.lengths(names).tolist(), strict=True))
    ends = {name: (PARTS[name].parent, PARTS[name].child) for name in names if sizes[name] > 0}
    for stretch, some in together(body, ends):
        curve = _curve(stretch, turn, [ends[name] for name in some], make or curves)
        own = np.array([sizes[name] for name in some])
        yield Limbs(tuple(some), stretch.known, body.motion.rate, stretch.frames.start, curve, own)
        del curve


def _curve(
    stretch: Stretch, turn: Floats, pairs: Sequence[tuple[str, str]], make: Curves
) -> Floats:
    """Return curves between joints, (P, N, 3), worked out block by block."""
    body, frames = stretch.body, stretch.frames
    names = body.names if body.short else stretch.names
    ends = np.array([list(map(names.index, pair)) for pair in pairs]).T
    width = window(body.profile.smoothing, body.profile.rate)
    curve = np.empty((3, len(pairs), len(frames)))
    for part in blocks(len(frames), width // 2):
        some = frames[part.outer]
        near, angle = stretch.sources(names, some), turn[some.start : some.stop]
        found = make(near, ends, stretch.work, some, angle, width)
        curve[..., part.inner] = found[..., part.within]
    return curve.transpose(1, 2, 0)
