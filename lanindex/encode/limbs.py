"""Stages 0 and 1: limbs of the body, resampled, turned to face forward, part by part.

Source: ``encode/METHOD.md``, stages 0 and 1; Matsumoto and Hachimura (2001), 2 and 4.2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import PARTS
from lanindex.encode.arithmetic import blocks, runs
from lanindex.encode.joints import Body, Joints
from lanindex.encode.resample import Resampling
from lanindex.model import Span

Floats = NDArray[np.float64]
Curves = Callable[[Floats, NDArray[np.int64], Resampling, range, Floats, int], Floats]

TOGETHER = 1 << 20
"""Frames times parts that are worked out together: some 120 MB."""


@dataclass(frozen=True, slots=True, eq=False)
class Limbs:
    """Parts of the body over one stretch in which all of them are known.

    Attributes
    ----------
    parts : tuple of str
        (P) names.
    known : Span
        The stretch, in frames of the source.
    rate : Fraction
        Frames a second of the source.
    begin : int
        Number of the first resampled frame.
    curve : ndarray
        (P, N, 3) float64, mm: child minus parent, forward +x, up +y, right +z, smoothed.
    lengths : ndarray
        (P,) float64, mm.
    """

    parts: tuple[str, ...]
    known: Span
    rate: Fraction
    begin: int
    curve: Floats
    lengths: Floats


def smooth(curve: Floats, window: int) -> Floats:
    """Return the centred moving average; at the ends of the frames that exist.

    Parameters
    ----------
    curve : ndarray
        (..., N) float64.
    window : int
        Frames, odd.

    Returns
    -------
    ndarray
        (..., N) float64.
    """
    half = min(window // 2, curve.shape[-1] - 1)
    if half < 1:
        return curve
    total: Floats = curve.copy()
    count = np.ones(curve.shape[-1])
    for shift in range(1, half + 1):
        total[..., shift:] += curve[..., :-shift]
        total[..., :-shift] += curve[..., shift:]
        count[shift:] += 1
        count[:-shift] += 1
    total /= count
    return total


def window(seconds: float, rate: Fraction) -> int:
    """Return the odd number of frames nearest to `seconds`.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from lanindex.encode.limbs import window
    >>> window(0.083, Fraction(60)), window(0.15, Fraction(60))
    (5, 9)
    """
    return 2 * int(seconds * float(rate) / 2) + 1


def limbs(
    body: Body,
    turn: Floats,
    parts: Iterable[str] = PARTS,
    make: Curves | None = None,
) -> Iterator[Limbs]:
    """Yield the curves of parts, as far as the capture knows them, stretch by stretch.

    Parameters
    ----------
    body : Body
        The capture.
    turn : ndarray
        (N,) float64, radians, as from `lanindex.encode.heading.heading`.
    parts : iterable of str
        Which; by default all.
    make : Curves, optional
        What makes curves of places; by default `curves`.

    Yields
    ------
    Limbs
        Parts that are known over the same stretch stand together; of a long capture only a few
        parts are worked out at a time.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.encode.heading import heading
    >>> from lanindex.encode.joints import Body
    >>> from lanindex.encode.limbs import limbs
    >>> body = Body(lanindex.read("corpus/compass.bvh"), lanindex.load_profile())
    >>> (found,) = limbs(body, heading(body.motion, body.profile.rate))
    >>> found.known, found.curve.shape, found.parts[:2]
    (Span(start=0, stop=840), (18, 1679, 3), ('r_arm', 'l_arm'))
    >>> [round(float(number)) for number in found.curve[0, 0]]  # the right arm hangs
    [0, -570, 0]
    """
    names = list(parts)
    few = max(TOGETHER // max(len(body.motion), len(turn), 1), 1)
    for start in range(0, len(names), few):
        found = _known(body, turn, names[start : start + few], make or curves)
        while found:
            yield found.pop(0)


def _known(body: Body, turn: Floats, parts: Sequence[str], make: Curves) -> list[Limbs]:
    joints = body.joints({joint for name in parts for joint in PARTS[name].chain})
    size = dict(zip(parts, body.lengths(parts).tolist(), strict=True))
    unknown = dict(zip(joints.names, joints.unknown.T, strict=True))
    ever = dict(zip(joints.names, np.logical_or.reduce(joints.unknown).tolist(), strict=True))
    stretches: dict[tuple[int, int], list[str]] = {}
    for name in parts:
        if size[name] > 0:
            one, other = PARTS[name].parent, PARTS[name].child
            gaps = ever[one] or ever[other]
            known = runs(~(unknown[one] | unknown[other])) if gaps else [(0, len(joints))]
            for stretch in known:
                stretches.setdefault(stretch, []).append(name)
    found = []
    for stretch, names in sorted(stretches.items()):
        span, sizes = Span(*stretch), np.array([size[name] for name in names])
        begin, curve = _curve(body, joints, turn, span, names, make)
        if curve.shape[1]:
            found.append(Limbs(tuple(names), span, body.motion.rate, begin, curve, sizes))
    return found


def _curve(
    body: Body, joints: Joints, turn: Floats, known: Span, names: Sequence[str], make: Curves
) -> tuple[int, Floats]:
    """Return the first frame of a stretch and its curves, (P, N, 3), block by block."""
    profile = body.profile
    pairs = [(PARTS[name].parent, PARTS[name].child) for name in names]
    ends = np.array([list(map(joints.names.index, pair)) for pair in pairs]).T
    points = joints.places[known.start : known.stop]
    work = Resampling(known.start, len(known), body.motion.rate / profile.rate)
    frames, width = work.frames, window(profile.smoothing, profile.rate)
    curve = np.empty((3, len(names), len(frames)))
    for part in blocks(len(frames), width // 2):
        some = frames[part.outer]
        near, angle = points[work.sources(some)], turn[some.start : some.stop]
        found = make(near, ends, work, some, angle, width)
        curve[..., part.inner] = found[..., part.within]
    return frames.start, curve.transpose(1, 2, 0)


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

    Parameters
    ----------
    near : ndarray
        (S, K, 3) float64, the places that the frames are made of.
    ends : ndarray
        (2, P): of each part which joint is the parent, and which the child.
    work : Resampling
        How frames are made of places.
    frames : range
        Which.
    angle : ndarray
        (N,) float64, radians: the heading.
    width : int
        Frames of the moving average.

    Returns
    -------
    ndarray
        (3, P, N) float64.
    """
    parents, children = ends
    forward, up, right = work.values(near[:, children] - near[:, parents], frames).T
    sine, cosine = np.sin(angle), np.cos(angle)
    turned = np.stack((forward * cosine - right * sine, up, forward * sine + right * cosine))
    return smooth(turned, width)
