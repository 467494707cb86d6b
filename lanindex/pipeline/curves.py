"""How a limb of a capture went and how it was written down, a window at a time.

The whole of a limb is followed once and kept (`lanindex.pipeline.kept`); windows are read from
there. They are the curves of the figures of Matsumoto and Hachimura (2001), section 4.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.draw.staff import last_second
from lanindex.encoding.arithmetic import sizes
from lanindex.encoding.direction import polar
from lanindex.encoding.profile import Profile, load, made_of
from lanindex.encoding.written import OUTCOMES, Trace, write_limbs
from lanindex.errors import UsageError, shown
from lanindex.library.store import Store
from lanindex.model import Capture
from lanindex.notation.lpd_ldd import Ranges
from lanindex.pipeline import anew
from lanindex.pipeline.kept import CACHE, Cache, Made
from lanindex.pipeline.motion import SOURCES
from lanindex.pipeline.profiles import Shelf
from lanindex.records import of_name

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Thresholds:
    """What a profile comes to for one limb, in mm and mm/s."""

    v0: float  # mm/s: minima of speed at or below it are candidates
    prominence: float  # mm/s that the rim of a minimum stands above it
    still: float  # mm/s: what is slower is one plateau
    d_t: float  # mm: candidates as near to the first one of a hold belong to it
    stray: float  # mm that the limb may stray from there between them; 0: not looked at
    place: float  # mm from the vertical within which the direction is place


@dataclass(frozen=True, eq=False)
class Curves:
    """How one limb goes in a window of time, as `lanindex.Library.curves` returns it.

    Frames are resampled ones, ``profile.rate`` a second, counted from the capture's beginning;
    where the limb is unknown there are none.

    Attributes
    ----------
    capture : Capture
        The capture.
    part : str
        The limb.
    profile : Profile
        The numbers of the method.
    length : float
        Length of the limb, mm.
    thresholds : Thresholds
        ``v0``, ``prominence``, ``still`` (mm/s); ``d_t``, ``stray``, ``place`` (mm).
    frames : (N,) int64
        Frames of the window.
    speed : (N,) float64
        Speed of the limb's end, mm/s.
    distance : (N,) float64
        How far it is from the first candidate of the latest hold, mm: what d_t is held against.
    azimuth, elevation : (N,) float64
        Degrees: seen from above, 0 right, 90 forward; and from straight down.
    cells : (N,) int64
        direction · 3 + level.
    candidates : (C,) int64
        Frames at which it may have stopped.
    holds : (H, 2) int64
        First and last frame of each hold that the window shows a piece of.
    moves : (M, 4) int64
        First and last frame of each segment, and those at which it is seen to begin and end.
    runs : (R, 6) int64
        Cell, first frame, frame behind the last, frame at which it is achieved, what became of
        it (an index of `lanindex.encoding.written.OUTCOMES`), line of the rule that deleted it.
    """

    capture: Capture
    part: str
    profile: Profile
    length: float
    frames: Ints
    speed: Floats
    distance: Floats
    azimuth: Floats
    elevation: Floats
    cells: Ints
    candidates: Ints
    holds: Ints
    moves: Ints
    runs: Ints

    def __repr__(self) -> str:
        return f"<Curves of {self.part}: {len(self.frames)} frames, {len(self.moves)} moves>"

    @property
    def ranges(self) -> Ranges:
        """The borders of the cells."""
        return self.profile.ranges[self.part]

    @cached_property
    def times(self) -> Floats:
        """Seconds of the frames, (N,)."""
        return self.frames / float(self.profile.rate)

    @cached_property
    def thresholds(self) -> Thresholds:
        """What the numbers of the profile come to for this limb."""
        names = ("candidate_speed", "prominence", "still", "distance")
        v0, prominence, still, d_t = (getattr(self.profile, it).of(self.length) for it in names)
        stray, place = self.profile.path_check * d_t, self.ranges.radius(self.length)
        return Thresholds(v0, prominence, still, d_t, stray, place)

    def record(self) -> dict[str, Any]:
        """Return the window as JSON: times in seconds, the rest in the units of the fields."""
        rate = float(self.profile.rate)

        def times(frames: Ints) -> Any:
            return np.round(frames / rate, 6).tolist()

        cells, spans, codes, rules = self.runs[:, 0], self.runs[:, 1:4], *self.runs[:, 4:].T
        rows = zip(cells.tolist(), times(spans), codes.tolist(), rules.tolist(), strict=True)
        starts = zip(DIRECTIONS, self.ranges.starts, strict=False)  # place has none
        return {
            **of_name(self.capture),
            "part": self.part,
            "profile": self.profile.name,
            "rate": rate,
            "length": round(self.length, 1),
            "thresholds": {key: round(it, 1) for key, it in asdict(self.thresholds).items()},
            "azimuth_from": dict(starts),
            "elevation_from": {"low": 0, "mid": self.ranges.mid, "high": self.ranges.high},
            "times": times(self.frames),
            **{name: np.round(getattr(self, name), 1).tolist() for name in _ALONG[:-1]},
            "cells": [_cell(it) for it in self.cells.tolist()],
            "candidates": times(self.candidates),
            "holds": times(self.holds),
            "moves": times(self.moves),
            "runs": [
                {
                    "cell": _cell(cell),
                    "start": start,
                    "end": end,
                    "achieved": achieved,
                    "outcome": OUTCOMES[code],
                    "rule": rule,
                }
                for cell, (start, end, achieved), code, rule in rows
            ],
        }


def _cell(code: int) -> str:
    return f"{DIRECTIONS[code // 3]} {LEVELS[code % 3]}"


def curves(
    store: Store,
    which: int | str,
    part: str,
    start: float = 0.0,
    stop: float | None = None,
    profile: Profile | str | Path | None = None,
    cache: Cache = CACHE,
) -> Curves:
    """Return how a limb goes in a window: see `lanindex.Library.curves`."""
    capture = store.capture(which)
    anew.check_moves(capture)
    stop = last_second(float(capture.frames / capture.rate), start, stop)
    if profile is None:
        profile = _own(store, capture)
    elif not isinstance(profile, Profile):
        profile = load(profile)
    job = {"store": store, "capture": capture, "part": part, "profile": profile, "cache": cache}
    key = "curves", *SOURCES.of(store, capture).key, part, profile.digest
    kept = cache.get(key, _traced, job, aside=False)
    frames = kept.window("frames")
    first, behind = (ceil(it * float(profile.rate) - 1e-6) for it in (start, stop))
    low, high = frames.searchsorted((first, behind)).tolist()
    along = {name: kept.window(name, low, high) for name in _ALONG}
    candidates = kept.window("candidates")
    chosen = candidates[slice(*candidates.searchsorted((first, behind)).tolist())]
    holds, moves, runs = (kept.window(name) for name in ("holds", "moves", "runs"))
    return Curves(
        capture,
        part,
        profile,
        kept.about["length"],
        frames[low:high],
        **along,
        candidates=chosen,
        holds=holds[(holds[:, 0] < behind) & (holds[:, 1] >= first)],
        moves=moves[(moves[:, 0] < behind) & (moves[:, 1] >= first)],
        runs=runs[(runs[:, 1] < behind) & (runs[:, 2] > first)],
    )


def _own(store: Store, capture: Capture) -> Profile:
    """Return the profile that a capture was written down with, if it is as it was."""
    encoding, shelf = store.encoding(capture.id), Shelf(store.session.target)
    if encoding.profile in shelf.names():
        found = made_of(shelf.files(encoding.profile), encoding.profile)
        if found.digest == encoding.digest:
            return found
    raise UsageError(
        f'its profile "{shown(encoding.profile)}" is not here, or is another one now',
        place=capture.path,
        remedy='Name one (profile="default", or a folder), or ingest it again.',
    )


_ALONG = ("speed", "distance", "azimuth", "elevation", "cells")


def _traced(store: Store, capture: Capture, part: str, profile: Profile, cache: Cache) -> Made:
    """Return the whole of a limb as it is kept."""
    groups = anew.known_curves(store, capture, part, profile, cache)
    traces = [one for group in groups for one in write_limbs(group, profile)]
    found = [_rows(one) for one in traces]
    joined = {name: np.concatenate([one[name] for one in found]) for name in found[0]}
    return {"length": traces[0].space.length}, joined


def _rows(it: Trace) -> dict[str, NDArray[Any]]:
    """Return the arrays of one stretch, with frames counted from the capture's beginning."""
    firsts = np.array([hold.first for hold in it.holds])
    origins = it.curve[firsts.repeat(np.diff(firsts, append=len(it.curve)))]
    _, azimuth, elevation = polar(it.curve)
    codes = {name: code for code, name in enumerate(OUTCOMES)}
    runs = [
        (run.cell, run.start, run.stop, run.achieved, codes[run.outcome], run.rule)
        for move in it.runs
        for run in move
    ]
    begin = it.begin
    return {
        "frames": np.arange(len(it.curve)) + begin,
        "speed": it.speed,
        "distance": sizes(it.curve - origins),
        "azimuth": azimuth,
        "elevation": elevation,
        "cells": it.course.cells.astype(np.int64),
        "candidates": it.candidates + begin,
        "holds": np.array(it.holds, np.int64).reshape(-1, 2) + begin,
        "moves": np.array(it.segments, np.int64).reshape(-1, 4) + begin,
        "runs": np.array(runs, np.int64).reshape(-1, 6) + np.array([0, *[begin] * 3, 0, 0]),
    }
