"""Given beats: when each comes, and how a score counts by them.

Source: ``encoding/BODY.md``, "Tempo".
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import ceil
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import shown
from lanindex.model import Meter, Score, Span, Track
from lanindex.notation.text import read_text, refuse, words_of

AUTO = "auto"  # in place of a file of beats: find them in the movement
FOUND = "// tempo: "  # how the comment begins of a score whose tempo was found in its movement
SPREAD = 0.05  # largest deviation from the mean interval, as its share, of even beats
NEAREST = 0.05  # seconds from one beat to the next, at least

_LINE = re.compile(r"// beats from (\S+):((?: \S+)+)")


@dataclass(frozen=True, slots=True)
class Beats:
    """When the beats of a score come."""

    first: Fraction  # Beats of the score before the first of `times`
    # Seconds, rising, two at least. Before them and behind them beats come as the two nearest
    times: tuple[float, ...]
    bar: int | None = None  # Beats in a unit, where they were told

    @property
    def speed(self) -> Fraction:
        """Beats a minute, in the mean, to a hundredth."""
        mean = (self.times[-1] - self.times[0]) / (len(self.times) - 1)
        return Fraction(round(6000 / mean), 100)

    @property
    def spread(self) -> tuple[float, float]:
        """The shortest and the longest time from one beat to the next, seconds."""
        apart = np.diff(self.times)
        return float(apart.min()), float(apart.max())

    @property
    def even(self) -> bool:
        """Whether all come nearly as fast as in the mean."""
        mean, (least, most) = 60 / float(self.speed), self.spread
        return mean * (1 - SPREAD) <= least and most <= mean * (1 + SPREAD)

    def numbers(self, seconds: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the number of beats passed at times in seconds, (N,)."""
        times = np.array(self.times)
        at = np.clip(times.searchsorted(seconds, side="right") - 1, 0, len(times) - 2)
        share = (seconds - times[at]) / (times[at + 1] - times[at])
        found: NDArray[np.float64] = float(self.first) + at + share
        return found

    def seconds(self, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the times in seconds, (N,), at which so many beats have passed."""
        times, numbers = np.array(self.times), numbers - float(self.first)
        at = np.clip(np.floor(numbers).astype(np.int64), 0, len(times) - 2)
        found: NDArray[np.float64] = times[at] + (numbers - at) * (times[at + 1] - times[at])
        return found

    def since(self, seconds: float, gone: Fraction) -> Beats:
        """Return the beats of an excerpt that begins at a time, `gone` beats into the score."""
        times = tuple(round(time - seconds, 6) for time in self.times)
        return Beats(self.first - gone, times, self.bar)

    def line(self) -> str:
        """Return the comment of LND that holds them."""
        times = (f"{time:.6f}".rstrip("0").rstrip(".") for time in self.times)
        return f"// beats from {self.first}: {' '.join(times)}"

    @classmethod
    def of(cls, lines: Iterable[str]) -> Beats | None:
        """Return the beats from the first comment that holds them, or None."""
        for line in lines:
            found = _LINE.fullmatch(line)
            if found:
                try:
                    first, times = Fraction(found[1]), tuple(map(float, found[2].split()))
                except (ValueError, ZeroDivisionError):
                    continue
                if len(times) > 1 and all(NEAREST <= b - a < 1e6 for a, b in pairwise(times)):
                    return cls(first, times)
        return None


def describe_tempo(meter: Meter, lines: Iterable[str]) -> str:
    """Describe the tempo of a score."""
    lines = list(lines)
    found = next((line.removeprefix(FOUND) for line in lines if line.startswith(FOUND)), "")
    beats = Beats.of(lines)
    many = f" (the mean of {len(beats.times)} beats)" if beats else ""
    return found or f"{float(meter.speed):g} beats a minute{many}"


def ticks_at(
    frames: NDArray[np.int64],
    meter: Meter,
    rate: Fraction,
    beats: Beats | None = None,
    *,
    up: bool = False,
) -> NDArray[np.int64]:
    """Return the ticks nearest to frames of the source, (N,), halves (or with `up` all) upwards."""
    if beats is not None:
        gone = beats.numbers(frames / float(rate)) * (meter.division / meter.beats)
        return (np.ceil(gone) if up else np.floor(gone + 0.5)).astype(np.int64)
    scale = meter.tick_rate / rate
    rest = 2 * scale.denominator - 1 if up else scale.denominator
    return (frames * 2 * scale.numerator + rest) // (2 * scale.denominator)


def in_time(score: Score) -> Score:
    """Return a score whose frames are ticks at the times of its beats, if a comment holds them."""
    beats = Beats.of(score.other)
    if beats is None:
        return score
    mine = beats.since(float(beats.seconds(np.zeros(1))[0]), Fraction(0))
    meter = score.meter
    rate = meter.tick_rate * ceil(60 / float(mine.speed) / mine.spread[0])

    def at(ticks: NDArray[np.int32]) -> NDArray[np.int64]:
        seconds = mine.seconds(ticks.astype(np.float64) * meter.beats / meter.division)
        return np.floor(seconds * float(rate) + 0.5).astype(np.int64)

    tracks = {}
    for part, track in score.tracks.items():
        rows = track.symbols.copy()
        rows["start"], rows["stop"] = at(rows["start"]), at(rows["stop"])
        edges = at(np.array([(one.start, one.stop) for one in track.known]))
        tracks[part] = Track(part, rows, tuple(Span(*pair) for pair in edges.tolist()))
    other = tuple(mine.line() if Beats.of([line]) else line for line in score.other)
    frames = int(at(np.array([score.frames]))[0])
    return Score(rate, frames, meter, tracks, score.heading, other, score.warnings)


def parse(text: str, beats: int = 4, name: str = "beats") -> Beats:
    r"""Read the text of a file of beats."""
    times: list[float] = []
    counts: list[int] = []
    for line, words in words_of(text):
        place = f"{name}:{line}"
        wanted = "a time in seconds, and perhaps which beat of its bar it is"
        try:
            time, *count = float(words[0]), *map(int, words[1:])
        except ValueError:
            refuse(place, f'"{shown(" ".join(words))}"', wanted)
        mixed = bool(times) and bool(count) != bool(counts)
        if len(count) > 1 or not 0 <= time < 1e6 or mixed:
            refuse(place, f'"{shown(" ".join(words))}"', wanted)
        if times and time < times[-1] + NEAREST:
            found, least = f"a beat at {words[0]} s", times[-1] + NEAREST
            refuse(place, found, f"one at {least:g} s or later")
        times.append(round(time, 6))
        counts += count
    if len(times) < 2:
        refuse(name, f"{len(times)} beats", "two at least")
    bar = max(counts) if counts else beats
    for one, two in pairwise(counts):
        if one < 1 or two != one % bar + 1:
            refuse(name, f"beat {two} behind beat {one}", f"bars of {bar} beats, counted from 1")
    first = counts[0] - 1 if counts else 0
    lead = -Beats(Fraction(0), tuple(times)).numbers(np.zeros(1))[0]
    first += bar * max(ceil((lead - first) / bar), 0)
    return Beats(Fraction(first), tuple(times), bar if counts else None)


def read(path: Path, beats: int = 4) -> Beats:
    """Read a file of beats; see `parse`."""
    return parse(read_text(path), beats, str(path))
