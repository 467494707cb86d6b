"""Stages 0 and 1: joints of the body, resampled, turned to face forward, part by part.

Source: ``encode/METHOD.md``, stages 0 and 1; Matsumoto and Hachimura (2001), 2 and 4.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, PARTS
from lanindex.encode.arithmetic import median
from lanindex.encode.profile import Profile
from lanindex.model import Motion, Span

Floats = NDArray[np.float64]

GAP = Fraction(1, 5)
"""Seconds: shorter gaps are filled."""

SHORTEST_AXIS = 1.0
"""Millimetres: a hip axis shorter than this on the ground tells no heading."""


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


def body(motion: Motion) -> Floats:
    """Return the 20 joints of the body model, with a calibration pose replaced and gaps filled.

    Parameters
    ----------
    motion : Motion
        Any skeleton.

    Returns
    -------
    ndarray
        (T, 20, 3) float64, mm, y up; NaN where a joint is unknown, or nowhere.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.alphabet import JOINT_CODES
    >>> from lanindex.encode.limbs import body
    >>> joints = body(lanindex.read("corpus/compass.bvh"))
    >>> joints.shape, joints[0, JOINT_CODES["RWrist"]].round()
    ((840, 20, 3), array([-185.,  805.,    0.]))
    """
    index = motion.skeleton.body
    # a coordinate's frames lie side by side in memory, here and in all that is made of it
    joints = np.asarray(motion.positions[:, index], dtype=np.float64, order="F")
    joints[:, index < 0] = np.nan
    joints[np.isinf(joints)] = np.nan
    if index[JOINT_CODES["Pelvis"]] < 0:
        hips = [JOINT_CODES["LHip"], JOINT_CODES["RHip"]]
        joints[:, JOINT_CODES["Pelvis"]] = joints[:, hips].mean(axis=1)
    if 0 < motion.first < len(joints):
        joints[: motion.first] = joints[motion.first]
    for joint in np.flatnonzero(_unknown(joints).any(axis=0)):
        _fill(joints[:, joint], math.floor(GAP * motion.rate))
    return joints


def _fill(points: Floats, longest: int) -> None:
    """Fill gaps of at most `longest` frames of (T, 3) points in place, by straight lines."""
    unknown = _unknown(points)
    for start, stop in _runs(unknown):
        if start > 0 and stop < len(points) and stop - start <= longest:
            share = np.arange(1, stop - start + 1)[:, None] / (stop - start + 1)
            points[start:stop] = points[start - 1] * (1 - share) + points[stop] * share


def _unknown(points: Floats) -> NDArray[np.bool_]:
    """Return which points (..., 2 or 3) lack a coordinate."""
    mask: NDArray[np.bool_] = np.isnan(points.sum(axis=-1))
    return mask


def _runs(mask: NDArray[Any]) -> list[tuple[int, int]]:
    """Return start and stop of each stretch of True."""
    edges = (np.flatnonzero(mask[1:] != mask[:-1]) + 1).tolist()
    return [(a, b) for a, b in pairwise([0, *edges, len(mask)]) if a < b and mask[a]]


def resample(points: Floats, start: int, rate: Fraction, target: Fraction) -> tuple[int, Floats]:
    """Resample by a cubic Hermite, slopes by central differences, one-sided at the ends.

    Parameters
    ----------
    points : ndarray
        (T, ...) float64, values at source frames `start` and on.
    start : int
        Number of the first of these frames.
    rate, target : Fraction
        Frames a second before and after.

    Returns
    -------
    begin : int
        Number of the first frame of the result; frame k lies at source frame k · rate / target.
    values : ndarray
        (N, ...) float64; no frame lies after the last of the source.

    Examples
    --------
    >>> from fractions import Fraction
    >>> import numpy as np
    >>> from lanindex.encode.limbs import resample
    >>> resample(np.array([0.0, 1.0, 4.0]), 0, Fraction(30), Fraction(60))
    (0, array([0.   , 0.375, 1.   , 2.375, 4.   ]))
    """
    if rate == target:
        return start, points
    step = rate / target
    begin = math.ceil(start / step)
    if len(points) < 2:
        return begin, points[: int(begin * step == start)]
    frames = np.arange(begin, math.floor((start + len(points) - 1) / step) + 1)
    whole, rest = np.divmod(frames * step.numerator, step.denominator)
    index = np.minimum(whole - start, len(points) - 2)
    share = rest / step.denominator + (whole - start - index)
    slope = np.gradient(points, axis=0).T
    here, there = points.T.take(index, axis=-1), points.T.take(index + 1, axis=-1)
    square, cube = share**2, share**3
    bend = 3 * square - 2 * cube
    values: Floats = (
        here * (1 - bend)
        + there * bend
        + slope.take(index, axis=-1) * (cube - 2 * square + share)
        + slope.take(index + 1, axis=-1) * (cube - square)
    )
    return begin, values.T


def heading(joints: Floats, rate: Fraction, target: Fraction) -> Floats:
    """Return the turn that brings the hip axis to +z, frame by frame.

    Parameters
    ----------
    joints : ndarray
        (T, 20, 3) float64, mm.
    rate, target : Fraction
        Frames a second of `joints` and of the result.

    Returns
    -------
    ndarray
        (N,) float64, radians about the vertical; where the axis tells nothing the last turn is
        kept. A body without hips is turned by its shoulders.

    Examples
    --------
    >>> from fractions import Fraction
    >>> import lanindex
    >>> from lanindex.encode.limbs import body, heading
    >>> joints = body(lanindex.read("corpus/compass.bvh"))
    >>> turn = heading(joints, Fraction(30), Fraction(60))  # faces +z; forward shall be +x
    >>> turn.shape, round(float(turn[0]), 3)
    ((1679,), -1.571)
    """
    for pair in (("LHip", "RHip"), ("LShoulder", "RShoulder")):
        left, right = (joints[:, JOINT_CODES[name]] for name in pair)
        axis = (right - left)[:, [0, 2]]
        if not _unknown(axis).all():
            break
    count = math.floor((len(axis) - 1) * target / rate) + 1
    across = np.full((count, 2), np.nan)
    for start, stop in _runs(~_unknown(axis)):
        begin, values = resample(axis[start:stop], start, rate, target)
        across[begin : begin + len(values)] = values
    turn: Floats = np.arctan2(across[:, 0], across[:, 1])
    clear = np.hypot(across[:, 0], across[:, 1]) >= SHORTEST_AXIS
    if clear.all():
        return turn
    if not clear.any():
        return np.zeros(count)
    last = np.maximum.accumulate(np.where(clear, np.arange(count), -1))
    last[last < 0] = np.argmax(clear)
    held: Floats = turn[last]
    return held


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

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.encode.limbs import smooth
    >>> curve = np.zeros((1, 4, 3))
    >>> curve[0, :, 1] = 0, 30, 0, 30
    >>> smooth(curve, 3)[0, :, 1]
    array([15., 10., 20., 15.])
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


def lengths(joints: Floats, parts: Iterable[str]) -> Floats:
    """Return the length of each part: median over time of the sum of its bones.

    Parameters
    ----------
    joints : ndarray
        (T, 20, 3) float64, mm.
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
    missing = np.count_nonzero(_unknown(joints), axis=0)
    result = []
    for name in parts:
        chain = [JOINT_CODES[joint] for joint in PARTS[name].chain]
        inner = [code for code in chain[1:-1] if missing[code] < len(joints)]
        chain = [chain[0], *inner, chain[-1]]
        bones = sum(np.linalg.norm(joints[:, b] - joints[:, a], axis=1) for a, b in pairwise(chain))
        known = bones[~np.isnan(bones)]
        result.append(median(known) if len(known) else math.nan)
    return np.array(result)


def limbs(joints: Floats, turn: Floats, rate: Fraction, profile: Profile) -> list[Limbs]:
    """Return the curves of all parts that the capture knows, stretch by stretch.

    Parameters
    ----------
    joints : ndarray
        (T, 20, 3) float64, mm, as from `body`.
    turn : ndarray
        (N,) float64, radians, as from `heading`.
    rate : Fraction
        Frames a second of `joints`.
    profile : Profile
        Rate and smoothing.

    Returns
    -------
    list of Limbs
        Parts that are known over the same stretch stand together.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.encode.limbs import body, heading, limbs
    >>> motion, profile = lanindex.read("corpus/compass.bvh"), lanindex.load_profile()
    >>> joints = body(motion)
    >>> turn = heading(joints, motion.rate, profile.rate)
    >>> (found,) = limbs(joints, turn, motion.rate, profile)
    >>> found.known, found.curve.shape, found.parts[:2]
    (Span(start=0, stop=840), (18, 1679, 3), ('r_arm', 'l_arm'))
    >>> [round(float(number)) for number in found.curve[0, 0]]  # the right arm hangs
    [0, -570, 0]
    """
    unknown = _unknown(joints)
    stretches: dict[tuple[int, int], list[str]] = {}
    for name, part in PARTS.items():
        seen = ~(unknown[:, JOINT_CODES[part.parent]] | unknown[:, JOINT_CODES[part.child]])
        for stretch in _runs(seen):
            stretches.setdefault(stretch, []).append(name)
    found = (
        _stretch(joints, turn, rate, profile, Span(*stretch), names)
        for stretch, names in sorted(stretches.items())
    )
    return [limb for limb in found if limb is not None]


def _stretch(
    joints: Floats,
    turn: Floats,
    rate: Fraction,
    profile: Profile,
    known: Span,
    names: Sequence[str],
) -> Limbs | None:
    size = lengths(joints, names)
    kept = [index for index, length in enumerate(size) if length > 0]
    parts = tuple(names[index] for index in kept)
    ends = np.array(
        [[JOINT_CODES[PARTS[name].parent], JOINT_CODES[PARTS[name].child]] for name in parts]
    )
    if not len(ends):
        return None
    points = joints[known.start : known.stop]
    begin, curve = resample(
        points[:, ends[:, 1]] - points[:, ends[:, 0]], known.start, rate, profile.rate
    )
    if not len(curve):
        return None
    angle = turn[begin : begin + len(curve)]
    sine, cosine = np.sin(angle), np.cos(angle)
    forward, up, right = curve.T
    turned = np.stack((forward * cosine - right * sine, up, forward * sine + right * cosine))
    return Limbs(
        parts,
        known,
        rate,
        begin,
        smooth(turned.transpose(1, 2, 0), window(profile.smoothing, profile.rate)),
        size[kept],
    )
