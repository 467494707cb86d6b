"""The animations of a glTF file: keys at times, and what is between them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError
from lanindex.formats.gltf.document import Document, Value, numbers, shape
from lanindex.formats.rates import nearest_rate
from lanindex.formats.turning import between, unit

PATHS = {"translation": 3, "rotation": 4, "scale": 3}
KINDS = ("LINEAR", "STEP", "CUBICSPLINE")

ON_GRID = 0.1
"""Of a frame: keys as near as this to a frame are on it."""

SLOW, USUAL = 15, 30
"""Keys that are rarer than so many a second are looked at, between them, so often at least."""

MOST_BETWEEN = 10_000
"""Frames that a key may stand for."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """How one thing changes."""

    node: int  # whose; -1: of no node
    path: str  # ``translation``, ``rotation``, ``scale``; another: nothing that moves joints
    kind: str  # ``LINEAR``, ``STEP`` or ``CUBICSPLINE``
    times: Floats  # (K,) seconds, not falling
    # (K, W); of a spline (K, 3, W): the tangent before, the value, the tangent behind. Turns are
    # (x, y, z, w).
    values: NDArray[Any]
    keys: Floats  # (K,) the times in frames

    def at(self, frames: NDArray[np.int64], *, exactly: bool = False) -> Floats:
        """Return the values (T, W) in some frames; turns are (w, x, y, z), of length 1.

        Where turns are wanted exactly they are of the length that their keys have.
        """
        keys = self.keys
        last = len(keys) - 1
        before = np.clip(np.searchsorted(keys, frames, side="right") - 1, 0, last)
        found = self._key(before)
        if self.kind != "STEP" and last:
            after = np.minimum(before + 1, last)
            wide = keys[after] - keys[before]
            part = np.clip((frames - keys[before]) / np.where(wide > 0, wide, 1), 0, 1)
            on = np.flatnonzero(part)
            if len(on):
                found[on] = self._between(before[on], after[on], part[on])
        return unit(found) if self.path == "rotation" and not exactly else found

    def _key(self, index: NDArray[np.int64], which: int = 1) -> Floats:
        """Return values (T, W) of keys, or of a spline's a tangent: 0 before it, 2 behind."""
        rows = self.values[index, which] if self.kind == "CUBICSPLINE" else self.values[index]
        rows = rows.astype(np.float64)
        return rows[:, [3, 0, 1, 2]] if self.path == "rotation" else rows

    def _between(self, before: NDArray[np.int64], after: NDArray[np.int64], u: Floats) -> Floats:
        """Return values between keys; on cubic Hermite splines as appendix C of glTF 2.0 says."""
        start, stop = self._key(before), self._key(after)
        if self.kind == "LINEAR" and self.path == "rotation":
            return between(unit(start), unit(stop), u)
        u = u[:, None]
        if self.kind == "LINEAR":
            return np.asarray(start + u * (stop - start))
        seconds = (self.times[after] - self.times[before])[:, None]
        square, cube = u * u, u * u * u
        found = (2 * cube - 3 * square + 1) * start + (3 * square - 2 * cube) * stop
        found += seconds * (cube - 2 * square + u) * self._key(before, 2)
        found += seconds * (cube - square) * self._key(after, 0)
        return np.asarray(found)


@dataclass(frozen=True, slots=True)
class Clock:
    """When frames are."""

    rate: Fraction  # frames a second
    pace: float  # the same as the keys have it, not rounded
    start: float  # seconds at frame 0
    count: int  # how many frames there are
    tied: float  # of a frame: keys as near as this to one are on it
    doubts: tuple[str, ...] = ()  # what was odd

    def frames(self, times: Floats) -> Floats:
        """Return when times are, in frames."""
        frames = (times - self.start) * self.pace
        nearest = np.rint(frames)
        return np.where(np.abs(frames - nearest) <= self.tied, nearest, frames)


def takes(document: Document) -> list[tuple[str, Value]]:
    """Return the animations by their names, those without one by their numbers from 1 on."""
    found = []
    for number, take in enumerate(document.root.get("animations"), 1):
        found.append((take.get("name", "").text() or str(number), take))
    return found


def moved(document: Document, take: Value) -> set[int]:
    """Return the nodes that an animation moves, its numbers not looked at."""
    nodes = document.root.get("nodes")
    found = set()
    for channel in take.get("channels"):
        target = channel.get("target")
        if str(target.get("path").value) in PATHS and "node" in target:
            found.add(target.get("node").one_of(nodes))
    return found


def tracks(document: Document, take: Value, wanted: Iterable[int] | None = None) -> list[Track]:
    """Return the tracks of an animation."""
    nodes, chosen = document.root.get("nodes"), None if wanted is None else set(wanted)
    samplers = take.get("samplers")
    known = dict[int, NDArray[Any]]()
    found = []
    for channel in take.get("channels"):
        target = channel.get("target")
        path = str(target.get("path").value)
        node = target.get("node").one_of(nodes) if "node" in target else -1
        if chosen is not None and (path not in PATHS or node not in chosen):
            continue
        sampler = samplers[channel.get("sampler").one_of(samplers)]
        found.append(_track(document, sampler, node, path, known))
    return found


def _track(
    document: Document, sampler: Value, node: int, path: str, known: dict[int, NDArray[Any]]
) -> Track:
    kind = sampler.get("interpolation", "LINEAR").word(KINDS)
    spline = kind == "CUBICSPLINE"
    start, stop = sampler.get("input"), sampler.get("output")
    keys, (count, width) = shape(document, start), shape(document, stop)
    elements = keys[0] * (3 if spline else 1)
    fits = (
        (count == elements and width == PATHS[path])
        if path in PATHS
        else not count * width % elements
    )
    if keys[1] != 1 or not fits:
        raise CaptureError(
            f"{sampler.where} has {keys[0]} keys of {keys[1]} and {count} values of {width}",
            place=document.file.name,
            wanted=f"times and as many values as a {kind} {path} has",
        )
    if start.whole() not in known:
        times = numbers(document, start)[:, 0].astype(np.float64)
        if (np.diff(times) < 0).any():
            raise CaptureError(
                f"the times of {sampler.where} go back at key {int(np.diff(times).argmin()) + 1}",
                place=document.file.name,
                wanted="times that rise",
            )
        known[start.whole()] = times
    if stop.whole() not in known:
        known[stop.whole()] = numbers(document, stop)
    values = known[stop.whole()]
    values = values.reshape(keys[0], 3, -1) if spline else values.reshape(keys[0], -1)
    times = known[start.whole()]
    return Track(node, path, kind, times, values, times)


def clock(times: Sequence[Floats], path: str) -> Clock:
    """Return the frames of an animation.

    They are at the times of its keys: so many a second as the track of most keys has, and where
    keys are left out on a way that is even, between them. Keys that are rare, as where an
    animator sets them, or at uneven times are read between too.
    """
    densest = max(times, key=len)
    first = min(float(one[0]) for one in times)
    last = max(float(one[-1]) for one in times)
    steps = np.diff(densest)
    steps = steps[steps > 0]
    if not len(steps):
        return Clock(Fraction(USUAL), float(USUAL), first, 1, 0.0)
    step = float(np.sort(steps)[(len(steps) - 1) // 2])
    usual = steps[np.abs(steps - step) < step / 2]
    whole = np.maximum(np.rint(steps / float(usual.mean())), 1)
    pace = float(whole.sum() / steps.sum())
    even = bool(np.abs(np.cumsum(steps) * pace - np.cumsum(whole)).max() <= ON_GRID)
    if not even:
        pace = 1 / step
    doubts: tuple[str, ...] = ()
    often = ceil(USUAL / pace) if pace < SLOW else 1
    keys = f"keys are {1 / pace:.3g} s apart"
    pace *= often
    if not first + 1e5 > last or (last - first) * pace > MOST_BETWEEN * len(densest):
        raise CaptureError(
            f"{len(densest)} keys from {first:g} to {last:g} s, {step:g} s apart",
            place=path,
            wanted=f"keys that stand for {MOST_BETWEEN} frames at most, in a day",
        )
    rate = nearest_rate(Fraction(pace).limit_denominator(10**6))
    tied = ON_GRID if even else 1e-3
    pace = pace if even else float(rate)
    start = float(densest[0])
    start -= np.floor((start - first) * pace + tied) / pace
    found = Clock(rate, pace, start, 1, tied)
    frames = int(np.floor(found.frames(np.array([last]))[0] + tied)) + 1
    if often > 1:
        doubts = (f"{keys}: it is read at {float(rate):g} frames a second",)
    if not even or any(_off(found, one) for one in times):
        doubts = (f"keys are at uneven times: it is read at {float(rate):g} frames a second",)
    return Clock(rate, pace, start, frames, tied, doubts)


def timed(found: Sequence[Track], clock: Clock) -> list[Track]:
    """Return tracks that know their keys in frames."""
    known = {id(track.times): clock.frames(track.times) for track in found}
    return [replace(track, keys=known[id(track.times)]) for track in found]


def _off(clock: Clock, times: Floats) -> bool:
    frames = clock.frames(times)
    return bool((frames != np.rint(frames)).any())
