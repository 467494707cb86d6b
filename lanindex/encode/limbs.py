"""Stages 0 and 1: joints of the body, resampled, turned to face forward, part by part.

Source: ``encode/METHOD.md``, stages 0 and 1; Matsumoto and Hachimura (2001), 2 and 4.2.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, reduce
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, JOINTS, PARTS
from lanindex.body.made import GAP, MADE, weighted
from lanindex.encode.arithmetic import blocks, median, runs
from lanindex.encode.profile import Profile
from lanindex.encode.resample import Resampling
from lanindex.model import Motion, Span

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


@dataclass(frozen=True, slots=True, eq=False)
class Joints:
    """Joints of the body over a whole capture.

    Attributes
    ----------
    names : tuple of str
        (K) of ``alphabet.JOINTS``.
    places : ndarray
        (T, K, 3) float64, mm, y up; NaN where a joint is unknown, or nowhere.
    unknown : ndarray
        (T, K) bool, where they are.
    """

    names: tuple[str, ...]
    places: Floats
    unknown: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.places)

    def __getitem__(self, name: str) -> Floats:
        """Return the places of one joint, (T, 3)."""
        return self.places[:, self.names.index(name)]


def body(motion: Motion, names: Iterable[str] = JOINTS) -> Joints:
    """Return joints of the body model, with a calibration pose replaced and gaps filled.

    Parameters
    ----------
    motion : Motion
        Any skeleton.
    names : iterable of str
        Which joints; all 20 of a long capture are many.

    Returns
    -------
    Joints
        In the order of ``alphabet.JOINTS``.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.encode.limbs import body
    >>> joints = body(lanindex.read("corpus/compass.bvh"), ["RShoulder", "RWrist"])
    >>> joints.names, joints["RWrist"][0].round()
    (('RShoulder', 'RWrist'), array([-185.,  805.,    0.]))
    """
    wanted = set(names)
    ordered = tuple(name for name in JOINTS if name in wanted)
    places = _seen(motion, ordered)
    for column, name in enumerate(ordered):
        if name in MADE and motion.skeleton.body[JOINT_CODES[name]] < 0:
            shares = MADE[name].items()
            places[:, column] = weighted(
                (_seen(motion, (of,))[:, 0], share) for of, share in shares
            )
    if 0 < motion.first < len(places):
        places[: motion.first] = places[motion.first]
    unknown = unknown_of(places)
    for column in np.flatnonzero(unknown.any(axis=0)).tolist():
        _fill(places[:, column], unknown[:, column], math.floor(GAP * motion.rate))
    return Joints(ordered, places, unknown)


def _seen(motion: Motion, names: Sequence[str]) -> Floats:
    """Return joints as the file has them, (T, K, 3)."""
    index = motion.skeleton.body[[JOINT_CODES[name] for name in names]]
    # a coordinate's frames lie side by side in memory, here and in all that is made of it
    places = np.empty((len(motion), len(names), 3), order="F")
    for part in blocks(len(motion)):
        some = motion.positions[part.inner].take(index, axis=1)
        some[np.isinf(some)] = np.nan
        places[part.inner] = some
    places[:, index < 0] = np.nan
    return places


def _fill(points: Floats, unknown: NDArray[np.bool_], longest: int) -> None:
    """Fill gaps of at most `longest` frames of (T, 3) points in place, by straight lines."""
    for start, stop in runs(unknown):
        if start > 0 and stop < len(points) and stop - start <= longest:
            share = np.arange(1, stop - start + 1)[:, None] / (stop - start + 1)
            points[start:stop] = points[start - 1] * (1 - share) + points[stop] * share
            unknown[start:stop] = False


def unknown_of(points: Floats) -> NDArray[np.bool_]:
    """Return which points (..., 2 or 3) lack a coordinate."""
    mask: NDArray[np.bool_] = np.isnan(points.sum(axis=-1))
    return mask


def smooth(curve: Floats, window: int) -> Floats:
    """Return the centred moving average; at the ends of the frames that exist.

    Parameters
    ----------
    curve : ndarray
        (P, N, 3) float64.
    window : int
        Frames, odd.

    Returns
    -------
    ndarray
        (P, N, 3) float64.
    """
    half = min(window // 2, curve.shape[1] - 1)
    if half < 1:
        return curve
    total: Floats = curve.copy(order="K")
    count = np.ones(curve.shape[1])
    for shift in range(1, half + 1):
        total[:, shift:] += curve[:, :-shift]
        total[:, :-shift] += curve[:, shift:]
        count[shift:] += 1
        count[:-shift] += 1
    total /= count[:, None]
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


def lengths(joints: Joints, parts: Iterable[str]) -> Floats:
    """Return the length of each part: median over time of the sum of its bones.

    Parameters
    ----------
    joints : Joints
        Those of the parts' chains among them.
    parts : iterable of str
        (P) names.

    Returns
    -------
    ndarray
        (P,) float64, mm; NaN where a part was never seen.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.encode.limbs import body, lengths
    >>> joints = body(lanindex.read("corpus/compass.bvh"))
    >>> lengths(joints, ["r_arm", "r_leg"]).round()
    array([570., 820.])
    """
    seen = np.flatnonzero(~joints.unknown.all(axis=0)).tolist()
    nowhere = set(joints.names) - {joints.names[column] for column in seen}
    bone = cache(lambda *pair: _bone(*(joints[joint] for joint in pair)))
    result = []
    for name in parts:
        chain = PARTS[name].chain
        inner = [joint for joint in chain[1:-1] if joint not in nowhere]
        pairs = list(pairwise((chain[0], *inner, chain[-1])))
        size = reduce(np.add, (bone(*pair) for pair in pairs))
        known = size[~np.isnan(size)]
        result.append(median(known) if len(known) else math.nan)
    return np.array(result)


def _bone(one: Floats, other: Floats) -> Floats:
    """Return how far two joints are from each other, (T,)."""
    size = np.empty(len(one))
    for part in blocks(len(one)):
        x, y, z = (other[part.inner] - one[part.inner]).T
        size[part.inner] = np.sqrt(x * x + y * y + z * z)
    return size


def unmeasured(motion: Motion, parts: Sequence[str]) -> list[str]:
    """Return the parts whose ends are seen together, but whose length is not to be told.

    The joint between is there, yet never in a frame with both of its neighbours.

    Parameters
    ----------
    motion : Motion
        The capture.
    parts : sequence of str
        Those that have no track.
    """
    found = []
    for name in parts:
        chain = PARTS[name].chain
        joints = body(motion, chain)
        seen = ~(unknown_of(joints[chain[0]]) | unknown_of(joints[chain[-1]]))
        if seen.any() and math.isnan(lengths(joints, (name,))[0]):
            found.append(name)
    return found


def limbs(
    motion: Motion,
    turn: Floats,
    profile: Profile,
    parts: Iterable[str] = PARTS,
    make: Curves | None = None,
) -> Iterator[Limbs]:
    """Yield the curves of parts, as far as the capture knows them, stretch by stretch.

    Parameters
    ----------
    motion : Motion
        The capture.
    turn : ndarray
        (N,) float64, radians, as from `lanindex.encode.heading.heading`.
    profile : Profile
        Rate and smoothing.
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
    >>> from lanindex.encode.limbs import limbs
    >>> motion, profile = lanindex.read("corpus/compass.bvh"), lanindex.load_profile()
    >>> (found,) = limbs(motion, heading(motion, profile.rate), profile)
    >>> found.known, found.curve.shape, found.parts[:2]
    (Span(start=0, stop=840), (18, 1679, 3), ('r_arm', 'l_arm'))
    >>> [round(float(number)) for number in found.curve[0, 0]]  # the right arm hangs
    [0, -570, 0]
    """
    names = list(parts)
    few = max(TOGETHER // max(len(motion), len(turn), 1), 1)
    for start in range(0, len(names), few):
        found = _known(motion, turn, profile, names[start : start + few], make or curves)
        while found:
            yield found.pop(0)


def _known(
    motion: Motion, turn: Floats, profile: Profile, parts: Sequence[str], make: Curves
) -> list[Limbs]:
    joints = body(motion, {joint for name in parts for joint in PARTS[name].chain})
    size = dict(zip(parts, lengths(joints, parts).tolist(), strict=True))
    unknown = dict(zip(joints.names, joints.unknown.T, strict=True))
    stretches: dict[tuple[int, int], list[str]] = {}
    for name in parts:
        if size[name] > 0:
            for stretch in runs(~(unknown[PARTS[name].parent] | unknown[PARTS[name].child])):
                stretches.setdefault(stretch, []).append(name)
    found = []
    for stretch, names in sorted(stretches.items()):
        known, sizes = Span(*stretch), np.array([size[name] for name in names])
        begin, curve = _curve(joints, turn, motion.rate, profile, known, names, make)
        if curve.shape[1]:
            found.append(Limbs(tuple(names), known, motion.rate, begin, curve, sizes))
    return found


def _curve(
    joints: Joints,
    turn: Floats,
    rate: Fraction,
    profile: Profile,
    known: Span,
    names: Sequence[str],
    make: Curves,
) -> tuple[int, Floats]:
    """Return the first frame of a stretch and its curves, (P, N, 3), block by block."""
    pairs = [(PARTS[name].parent, PARTS[name].child) for name in names]
    ends = np.array([list(map(joints.names.index, pair)) for pair in pairs]).T
    points = joints.places[known.start : known.stop]
    work = Resampling(known.start, len(known), rate / profile.rate)
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
    return smooth(work.values(points, frames).transpose(1, 0, 2), width)


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
    return smooth(turned.transpose(1, 2, 0), width).transpose(2, 0, 1)
