"""Stage 6: frames of the source, ticks of the score, and the tempo that counts them.

Beats a minute come from the profile, from told beats, or from the movement itself: its steps, or
its limbs.

Source: ``encoding/METHOD.md``, stage 6, ``encoding/BODY.md``, "Tempo"; Matsumoto and Hachimura
(2001), 4.7.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import slopes, smooth, window
from lanindex.encoding.joints import Body
from lanindex.encoding.places import Stretch, stretches
from lanindex.encoding.profile import Profile
from lanindex.errors import UsageError
from lanindex.model import Meter, Motion, Span
from lanindex.model.derived import SUPPORTS
from lanindex.model.symbol import joined
from lanindex.notation.beats import AUTO, FOUND, Beats, read, ticks_at

Rows = NDArray[Any]
IntArray = NDArray[np.int64]

FINEST = 1 << 16
"""Ticks in a unit beyond which the grid is not refined."""

TOGETHER = 1 << 16
"""Rows whose ticks are worked out together: some 10 MB."""


def to_source(
    rows: Rows, counts: Sequence[int], known: Sequence[Span], rate: Fraction, target: Fraction
) -> None:
    """Replace resampled frames by source frames in rows (S,), track by track, in place.

    Every row but a track's first then has a frame at least, none overlap, and a passing row lies
    inside the row after it. A stretch with fewer frames than symbols makes its first symbols
    passing.
    """
    owner, ends = np.arange(len(counts)).repeat(counts), np.cumsum(counts)
    first = ends - counts
    low, high = np.array([(one.start, one.stop) for one in known], np.int64).T
    step = rate / target
    frames = np.array((rows["start"], rows["stop"]), np.int64)
    borders = -(-frames * step.numerator // step.denominator)
    borders = np.minimum(np.maximum(borders, low[owner]), high[owner])
    borders[:, first] = low
    passing, later = rows["passing"], np.ones(len(rows), np.bool_)
    later[first] = False
    shown = np.flatnonzero(later & ~passing)
    many = np.bincount(owner[shown], minlength=len(counts))
    surplus = np.maximum(many - (high - low), 0)
    over = _places(many) < surplus[owner[shown]]
    passing[shown[over]] = True
    shown, many = shown[~over], many - surplus
    begin, end = low[owner[shown]], high[owner[shown]]
    starts, stops = _apart(borders[:, shown] - begin, many) + begin
    stops = np.minimum(stops, end - (many[owner[shown]] - 1 - _places(many)))
    borders[:, shown] = np.minimum(starts, stops - 1), stops
    if len(gone := np.flatnonzero(later & passing)):
        around = np.zeros(len(rows), np.bool_)
        around[shown] = around[ends - 1] = True
        outer = np.flatnonzero(around)
        outer = outer[outer.searchsorted(gone)]
        low, high = borders[:, outer]  # so that each has a frame within
        starts = np.minimum(np.maximum(borders[0, gone], low), high - 1)
        stops = np.minimum(np.maximum(borders[1, gone], starts + 1), high)
        borders[:, gone] = starts, stops
    rows["start"], rows["stop"] = borders


def _apart(spans: IntArray, counts: IntArray) -> IntArray:
    """Give every span (2, S) a length of one or more, behind those before it on its track."""
    place = _places(counts)
    least = np.maximum(np.maximum(spans[1], spans[0] + 1) - place, 1)
    over = np.arange(len(counts)).repeat(counts) * least.max(initial=0)  # no track reaches the next
    free = np.maximum.accumulate(least + over) - over + place
    before = np.where(place, np.roll(free, 1), 0)
    return np.array((np.maximum(spans[0], before), free))


def _places(counts: IntArray) -> IntArray:
    """Return how many come before each on its own track: (S,)."""
    begins = np.cumsum(counts) - counts
    places: IntArray = np.arange(counts.sum()) - begins.repeat(counts)
    return places


def quantise(
    tracks: Iterable[Rows], frames: int, rate: Fraction, meter: Meter, beats: Beats | None = None
) -> Meter:
    """Round the borders of symbols to the score's grid: fill ``tick`` and ``ticks``."""
    few = list(_few(tracks))
    last = np.array([frames])
    while True:
        end = int(ticks_at(last, meter, rate, beats, up=True)[0])
        behind = max((_tick(some, meter, rate, beats) for some in few), default=0)
        if meter.division >= FINEST or behind <= end:
            return meter
        meter = replace(meter, division=meter.division * 2)


def _few(tracks: Iterable[Rows]) -> Iterator[list[Rows]]:
    """Yield the tracks of a score, as many at a time as have rows enough to be worth it."""
    some = list[Rows]()
    for rows in tracks:
        some.append(rows)
        if sum(map(len, some)) > TOGETHER:
            yield some
            some = []
    if some:
        yield some


def _tick(tracks: Sequence[Rows], meter: Meter, rate: Fraction, beats: Beats | None) -> int:
    """Write the ticks of some tracks; return the last one of all."""
    table = joined(tracks)
    starts, stops = table["start"], table["stop"]
    owner = np.arange(len(tracks)).repeat(list(map(len, tracks)))
    shown = np.flatnonzero((starts != stops) & ~table["passing"])
    ticks = ticks_at(np.array((starts, stops), np.int64), meter, rate, beats)
    ticks[:, shown] = _apart(ticks[:, shown], np.bincount(owner[shown], minlength=len(tracks)))
    last = int(ticks[1, shown].max(initial=0))
    ticks[1] -= ticks[0]
    ticks[0, (starts == 0) & (stops == 0)] = 0  # unit 1 may begin before the capture does
    first = 0
    for rows in tracks:
        rows["tick"], rows["ticks"] = ticks[:, first : first + len(rows)]
        first += len(rows)
    return last


Floats = NDArray[np.float64]

SHORTEST, LONGEST = 0.25, 1.5
"""Seconds from one beat to the next."""

FEWEST = 8
"""Steps that tell a tempo."""

AHEAD = 4
"""Steps, or beats, after a moment that it is compared with."""

REGULAR = 0.7
"""Mean cosine from which steps are regular."""

MOVED = 0.45
"""Mean correlation from which limbs are."""

LIKE = 0.1
"""Less regular by so much, the slower beat of steps is taken."""

HALF = 0.7
"""Part of the best correlation that the fastest beat of limbs needs."""

ENDS = ("RWrist", "LWrist", "RAnkle", "LAnkle")

_PERIODS = np.geomspace(SHORTEST, LONGEST, 360)


class Tempo(NamedTuple):
    """What was found."""

    speed: Fraction  # Beats a minute, to a tenth
    confidence: float  # From 0, nothing recurs, to 1, all recurs evenly
    source: str  # What tells it

    @property
    def clear(self) -> bool:
        """Whether it is one."""
        return self.confidence >= (REGULAR if self.source == "steps" else MOVED)

    def __str__(self) -> str:
        """Return it as reports and headers say it."""
        basis = f"confidence {self.confidence:.2f}, from {self.source}"
        return f"{float(self.speed):g} beats a minute ({basis})"


class Count(NamedTuple):
    """How the time of a score is counted."""

    meter: Meter  # Tempo, rhythm and grid
    header: tuple[str, ...] = ()  # Comments of the score that tell more
    doubts: tuple[str, ...] = ()  # What a person should know


def count(
    asked: str | Path | None, motion: Motion, profile: Profile, rows: Mapping[str, Rows]
) -> Count:
    """Give all symbols their ticks, and say how they are counted."""
    beats = None
    if asked is None:
        found = Count(profile.meter)
    elif asked == AUTO:
        found = _looked_for(motion, profile, rows)
    else:
        beats = read(Path(asked), profile.meter.beats)
        found = _told(beats, motion, profile.meter, str(asked))
    meter = quantise(rows.values(), len(motion), motion.rate, found.meter, beats)
    return found._replace(meter=meter)


def _looked_for(motion: Motion, profile: Profile, rows: Mapping[str, Rows]) -> Count:
    found, usual = estimated(motion, profile, rows), profile.meter
    if found is not None and found.clear:
        return Count(replace(usual, speed=found.speed), header=(f"{FOUND}{found}",))
    why = f"at most {found}" if found else "it is too short, or nothing moves"
    counted = f"beats are counted at {float(usual.speed):g} a minute"
    return Count(usual, doubts=(f"no tempo was found, {why}: {counted}",))


def _told(beats: Beats, motion: Motion, meter: Meter, place: str) -> Count:
    if beats.times[0] >= motion.seconds:
        found = f"beats from {beats.times[0]:g} s on"
        raise UsageError(found, place=place, wanted=f"some of the {motion.seconds:g} s captured")
    meter = replace(meter, speed=beats.speed, beats=beats.bar or meter.beats)
    least, most = beats.spread
    uneven = (
        f"beats come {least:.3g} to {most:.3g} s apart: times in beats are asked for "
        f"at their mean, {float(beats.speed):g} a minute"
    )
    return Count(meter, (beats.line(),), () if beats.even else (uneven,))


def estimated(motion: Motion, profile: Profile, rows: Mapping[str, Rows]) -> Tempo | None:
    """Look for the beat of a movement: in its steps, else in the speed of its limbs."""
    feet = [rows[foot] for foot in SUPPORTS if foot in rows]
    stops = [table["stop"][table["stop"] > table["start"]] for table in feet]
    times = np.unique(np.concatenate(stops)) / float(motion.rate) if stops else np.zeros(0)
    stepped = _steps(times)
    if stepped is not None and stepped.clear:
        return stepped
    moved = _limbs(activity(motion, profile), float(profile.rate))
    if moved is None or moved.clear:
        return moved or stepped
    return max((stepped or moved, moved), key=lambda it: it.confidence)


def _steps(times: Floats) -> Tempo | None:
    """Return the beat that most times lie on, the slowest of those as regular; (N,) seconds."""
    if len(times) < FEWEST:
        return None
    apart = np.concatenate([times[k:] - times[:-k] for k in range(1, AHEAD + 1)])
    regular = np.array([np.cos(2 * np.pi / period * apart).mean() for period in _PERIODS])
    peaks = _peaks(regular)
    if not len(peaks):
        return None
    best = peaks[regular[peaks] >= regular[peaks].max() - LIKE][-1]
    beats = np.rint(apart / _PERIODS[best])
    near = (beats > 0) & (np.abs(apart / _PERIODS[best] - beats) < 0.25)
    period = (apart * beats)[near].sum() / (beats**2)[near].sum()
    return Tempo(_speed(period), float(regular[best]), "steps")


def _limbs(moved: Floats, rate: float) -> Tempo | None:
    """Return the beat that speed recurs with, the fastest of those nearly as clear; (N,) of it."""
    longest = min(int(AHEAD * LONGEST * rate), len(moved) // 2)
    energy = np.append(0.0, np.cumsum(moved**2))
    if longest < 2 or energy[-1] <= 0:
        return None
    alike = np.empty(longest + 1)
    for lag in range(longest + 1):
        rest = len(moved) - lag
        sizes = energy[rest] * (energy[-1] - energy[lag])
        alike[lag] = np.dot(moved[:rest], moved[lag:]) / max(np.sqrt(sizes), 1e-9)
    periods = _PERIODS[_PERIODS * rate * 2 <= longest] * rate
    lags = periods * np.arange(1, AHEAD + 1)[:, None]
    seen = lags <= longest
    values = np.interp(lags, np.arange(longest + 1), alike)
    regular = (values * seen).sum(axis=0) / np.maximum(seen.sum(axis=0), 1)
    peaks = _peaks(regular)
    if not (regular[peaks] > 0).any():
        return None
    best = peaks[regular[peaks] >= HALF * regular[peaks].max()][0]
    return Tempo(_speed(_refined(alike, periods[best]) / rate), float(regular[best]), "limbs")


def _refined(alike: Floats, period: float) -> float:
    """Return a period by the top of the last of its multiples that has one; frames."""
    for beats in range(2, AHEAD + 1):
        first, last = int(beats * period * 0.96), int(np.ceil(beats * period * 1.04))
        if last + 1 >= len(alike):
            break
        top = first + int(alike[first : last + 1].argmax())
        before, here, after = alike[top - 1 : top + 2]
        if here > 0 and here >= max(before, after) and before + after < 2 * here:
            period = (top + (before - after) / (before + after - 2 * here) / 2) / beats
    return period


def _peaks(values: Floats) -> NDArray[np.int64]:
    """Return where values are higher than beside them; not at the ends."""
    inner = values[1:-1]
    return np.flatnonzero((inner >= values[:-2]) & (inner > values[2:])) + 1


def _speed(period: float) -> Fraction:
    return Fraction(round(600 / period), 10)


def activity(motion: Motion, profile: Profile) -> Floats:
    """Return how much faster hands and feet move than in the seconds around, (N,) mm/s."""
    frames = int((len(motion) - 1) * profile.rate / motion.rate) + 1
    total, body = np.zeros(frames), Body(motion, profile)
    wide = window(LONGEST, profile.rate)
    for end in ENDS:
        for stretch in stretches(body, ("RHip", "LHip", end)):
            speed = _fast(stretch, end) * float(profile.rate)
            calm = smooth(speed, wide)
            total[stretch.frames.start : stretch.frames.stop] += speed - calm
    return total


def _fast(stretch: Stretch, end: str) -> Floats:
    """Return how far one end of a limb goes in a frame, seen from the hips: (N,) mm."""
    speed = np.zeros(len(stretch.frames))
    for block, places in stretch.blocks(1):
        away = places[end] - (places["RHip"] + places["LHip"]) / 2
        speed[block.inner] = np.linalg.norm(slopes(away.T).T, axis=1)[block.within]
    return speed
