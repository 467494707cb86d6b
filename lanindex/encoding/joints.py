"""Stage 0: the joints of the body as a capture has them, read once for all that is made of them.

Source: ``encoding/METHOD.md``, stage 0.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lanindex import compiled
from lanindex.alphabet import JOINT_CODES, JOINTS, PALMS, PARTS
from lanindex.body.mapping import LONGEST_GAP
from lanindex.encoding import arithmetic
from lanindex.encoding.arithmetic import blocks, parted, runs
from lanindex.encoding.profile import Profile
from lanindex.model import Motion

Floats = NDArray[np.float64]
Frames = NDArray[np.int64]

FEW = 4
"""Joints of which a whole block of frames is worked out at a time."""

KEPT = 1 << 20
"""Frames times joints of a capture that is short: all that is worked out of it is kept, 50 MB."""

TOGETHER = 1 << 20
"""Frames times parts that are worked out together: some 120 MB."""

AXES = {"Head right": ("Head", 0), "Head up": ("Head", 1)}
"""What points to a joint's own right, and up, beside the joints themselves: ``Head up``."""

NAMES = (*JOINTS, *AXES)
OUT = 100.0
"""Millimetres in front of a palm that its point lies."""

COLUMNS = {name: column for column, name in enumerate(NAMES)}


@dataclass(frozen=True, slots=True, eq=False)
class Joints:
    """Joints of the body over a whole capture."""

    names: tuple[str, ...]  # (K) of ``alphabet.JOINTS``, and of `AXES`
    # (T, K, 3) float64, mm, y up; NaN where a joint is unknown, or nowhere. Of `AXES` unit vectors
    places: Floats
    unknown: NDArray[np.bool_]  # (T, K) bool, where they are

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, name: str) -> Floats:
        """Return the places of one joint, (T, 3)."""
        return self.places[:, self.names.index(name)]


class Body:
    """The joints of one capture, for all tracks: of a short capture they are worked out once."""

    def __init__(self, motion: Motion, profile: Profile) -> None:
        """Read nothing yet."""
        self.motion, self.profile = motion, profile
        self.names = (*NAMES, *(palm for palm, hand in PALMS.items() if hand in motion.axes))
        self.step = motion.rate / profile.rate
        frames = len(motion) / min(self.step, Fraction(1))
        self.short = frames * len(NAMES) <= KEPT
        self.calm: dict[tuple[int, int], Floats] = {}
        self._lengths: dict[str, float] = {}
        self._some: dict[tuple[str, ...], tuple[int, int, int, Joints]] = {}

    @cached_property
    def fast(self) -> bool:
        """Whether loops over its frames run compiled: see `lanindex.compiled.chosen`."""
        frames = math.floor((len(self.motion) - 1) / self.step) + 1
        return compiled.chosen("encode", frames * compiled.FRAME)

    @cached_property
    def _all(self) -> Joints:
        return body(self.motion, self.names)

    def at(self, names: Sequence[str], frames: slice) -> Floats:
        """Return joints in some source frames, (n, K, 3) mm, gaps filled; NaN where unknown."""
        wanted = tuple(names)
        joints, first = (self._all, 0) if self.short else self._read(wanted, frames)
        part = slice(frames.start - first, frames.stop - first)
        if joints.names[: len(wanted)] == wanted:
            return joints.places[part, : len(wanted)]
        return joints.places[part, [joints.names.index(name) for name in wanted]]

    def _read(self, names: tuple[str, ...], frames: slice) -> tuple[Joints, int]:
        """Return joints in some frames and more, for stretches to come; and the first frame."""
        begin, end, first, joints = self._some.get(names, (1, 0, 0, None))
        if joints is None or not begin <= frames.start <= frames.stop <= end:
            motion, begin = self.motion, frames.start
            end = max(frames.stop, min(begin + chunk(len(names)), len(motion)))
            reach = math.floor(LONGEST_GAP * motion.rate) + 1  # a gap that is filled ends within
            first, last = max(begin - reach, 0), max(end + reach, motion.first + 1)
            part = replace(
                motion,
                positions=motion.positions[first:last],
                first=max(motion.first - first, 0),
                rotations=None,
                axes={joint: axes[first:last] for joint, axes in motion.axes.items()},
            )
            joints = body(part, names)
            self._some = dict(list(self._some.items())[-1:])  # feet and rests take turns
            self._some[names] = begin, end, first, joints
        return joints, first

    @cached_property
    def known(self) -> dict[str, Frames]:
        """The stretches in which each joint is known: (R, 2), first frame and behind the last.

        Where they are equal, they are one array.
        """
        edges, count = list[tuple[Frames, Frames]](), len(self.motion)
        before = np.zeros((1, len(self.names)), bool)
        for part in blocks(count, size=count if self.short else few(len(self.names))):
            unknown = (
                self._all.unknown if self.short else unknown_of(self.at(self.names, part.inner))
            )
            seen = ~unknown
            frame, joint = np.nonzero(seen != np.concatenate((before, seen[:-1])))
            edges.append((frame + part.inner.start, joint))
            before = seen[-1:]
        edges.append((np.full(np.count_nonzero(before), count), np.flatnonzero(before)))
        frames, joints = map(np.concatenate, zip(*edges, strict=True))
        ends = frames[np.argsort(joints, kind="stable")].reshape(-1, 2)
        each = parted(ends, (np.bincount(joints, minlength=len(self.names)) // 2).tolist())
        one = {known.tobytes(): known for known in each}
        return {name: one[it.tobytes()] for name, it in zip(self.names, each, strict=True)}

    def together(self, names: Sequence[str]) -> Frames:
        """Return the stretches in which all of some joints are known: (R, 2), as of `known`."""
        if len({id(self.known[name]) for name in names}) == 1:
            return self.known[names[0]]
        starts, stops = np.sort(np.concatenate([self.known[name] for name in names]), axis=0).T
        begun = starts.searchsorted(starts, "right") - stops.searchsorted(starts, "right")
        found = np.unique(starts[begun == len(names)])
        return np.stack((found, stops[stops.searchsorted(found, "right")]), axis=1)

    def lengths(self, parts: Sequence[str]) -> Floats:
        """Return the lengths (P,) of parts, mm: medians over time; NaN where never seen."""
        count = len(self.motion)
        asked = dict.fromkeys((*parts, *known_parts(self.motion))) if self.short else parts
        for new in grouped([part for part in asked if part not in self._lengths], count):
            gone = frozenset(name for name, known in self.known.items() if not len(known))
            names, ends, chains = _chains(tuple(new), gone)
            sums = np.empty((len(new), count))
            for part in blocks(count, size=few(len(names))):
                sums[:, part.inner] = _sums(self.at(names, part.inner), ends, chains)
            self._lengths |= zip(new, _medians(sums).tolist(), strict=True)
        return np.array([self._lengths[part] for part in parts])

    def length(self, parts: Sequence[str]) -> float | None:
        """Return the mean length of parts, mm; None where none was ever seen whole."""
        known = [size for size in self.lengths(parts).tolist() if size > 0]
        return sum(known) / len(known) if known else None


def few(joints: int) -> int:
    """Return how many frames of some joints are worked out at a time: fewer of more."""
    return max(arithmetic.BLOCK * FEW // max(joints, FEW), 1)


def chunk(joints: int) -> int:
    """Return how many frames of some joints of a long capture are read at a time."""
    return KEPT // (8 * joints)


def grouped(parts: Sequence[str], frames: int) -> Iterator[Sequence[str]]:
    """Yield parts, as many at a time as are worked out together over so many frames."""
    most = max(TOGETHER // max(frames, 1), 1)
    for start in range(0, len(parts), most):
        yield parts[start : start + most]


def body(motion: Motion, names: Iterable[str] = JOINTS) -> Joints:
    """Return joints of the body model, with a calibration pose replaced and gaps filled."""
    wanted = set(names)
    ordered = tuple(name for name in (*NAMES, *PALMS) if name in wanted)
    places = _seen(motion, ordered)
    for column, name in enumerate(ordered):
        if name in AXES:
            places[:, column] = _axis(motion, *AXES[name])
        elif name in PALMS:
            wrist = _seen(motion, (name[0] + "Wrist",))[:, 0]
            places[:, column] = wrist + OUT * _axis(motion, PALMS[name], 0)
        elif name == "Pelvis" and motion.skeleton.body[JOINT_CODES[name]] < 0:
            places[:, column] = _seen(motion, ("LHip", "RHip")).sum(axis=1) / 2
    if 0 < motion.first < len(places):
        places[: motion.first] = places[motion.first]
    unknown = unknown_of(places)
    for column in np.flatnonzero(unknown.any(axis=0)).tolist():
        if ordered[column] not in AXES:
            _fill(places[:, column], unknown[:, column], math.floor(LONGEST_GAP * motion.rate))
    return Joints(ordered, places, unknown)


def known_parts(motion: Motion) -> list[str]:
    """Return the parts that a motion may have: palms only where it says how hands are turned."""
    return [
        name
        for name, part in PARTS.items()
        if part.child not in PALMS or PALMS[part.child] in motion.axes
    ]


def _seen(motion: Motion, names: Sequence[str]) -> Floats:
    """Return joints as the file has them, (T, K, 3); NaN where it has none."""
    codes = [JOINT_CODES.get(name, -1) for name in names]
    index = np.where(np.array(codes) < 0, -1, motion.skeleton.body[codes])
    # a coordinate's frames lie side by side in memory, here and in all that is made of it
    places = np.empty((len(motion), len(names), 3), order="F")
    for part in blocks(len(motion)):
        some = motion.positions[part.inner].take(index, axis=1)
        some[np.isinf(some)] = np.nan
        places[part.inner] = some
    places[:, index < 0] = np.nan
    return places


def _axis(motion: Motion, joint: str, number: int) -> NDArray[np.float32] | float:
    """Return the way in which a joint's axis points, (T, 3); NaN where nothing tells."""
    return motion.axes[joint][:, number] if joint in motion.axes else math.nan


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


@cache
def _chains(
    parts: tuple[str, ...], gone: frozenset[str]
) -> tuple[tuple[str, ...], NDArray[np.int64], NDArray[np.int64]]:
    """Return joints (K), columns of bones' ends, (2, B), each part's bones, (L, P); B: no more."""
    chains = [
        list(pairwise((first, *(joint for joint in inner if joint not in gone), last)))
        for first, *inner, last in (PARTS[name].chain for name in parts)
    ]
    pairs = list(dict.fromkeys(pair for chain in chains for pair in chain))
    names = tuple(dict.fromkeys(joint for pair in pairs for joint in pair))
    ends = np.array([list(map(names.index, pair)) for pair in pairs]).T
    longest = max(map(len, chains))
    bones = [[*map(pairs.index, one), *[len(pairs)] * (longest - len(one))] for one in chains]
    return names, ends, np.array(bones).T


def _sums(places: Floats, ends: NDArray[np.int64], chains: NDArray[np.int64]) -> Floats:
    """Return how long parts are, (P, n), of places (n, K, 3)."""
    some = places.T
    x, y, z = some.take(ends[1], axis=1) - some.take(ends[0], axis=1)
    bones = np.zeros((ends.shape[1] + 1, len(places)))  # the last one is no bone
    bones[:-1] = np.sqrt(x * x + y * y + z * z)
    sums: Floats = bones[chains[0]]
    for bone in chains[1:]:
        sums += bones[bone]
    return sums


def _medians(sums: Floats) -> Floats:
    """Return the medians of numbers (P, T), which are put in another order: (P,)."""
    counts = sums.shape[1] - np.array([np.count_nonzero(np.isnan(row)) for row in sums])
    middle = np.maximum(np.stack((counts - 1, counts)) // 2, 0).T
    sums.partition(sorted({*middle.ravel().tolist()}), axis=1)  # what is not known comes last
    found: Floats = np.take_along_axis(sums, middle, axis=1).sum(axis=1) / 2
    return found


def unmeasured(body: Body, parts: Sequence[str]) -> list[str]:
    """Return the parts whose ends are known together, but never with the joint between."""
    found = []
    for name, length in zip(parts, body.lengths(parts).tolist(), strict=True):
        if not math.isnan(length):
            continue
        if len(body.together((PARTS[name].chain[0], PARTS[name].chain[-1]))):
            found.append(name)
    return found
