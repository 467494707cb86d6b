"""What a score counts by: bars and beats, or seconds where nobody told a tempo."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np
from numpy.typing import NDArray

from lanindex.model import Score

FIVE = 5
"""Seconds in what stands for a bar where seconds are counted."""


@dataclass(frozen=True, slots=True)
class Clock:
    """How time becomes a count."""

    score: Score  # Whose
    seconds: bool  # Whether seconds are counted, and not beats

    @property
    def bar(self) -> int:
        """Counts in a bar."""
        return FIVE if self.seconds else self.score.meter.beats

    def symbols(self, rows: NDArray[np.void]) -> tuple[list[float], list[float]]:
        """Return at which count some rows begin and end."""
        if self.seconds:
            rate = float(self.score.rate)
            return (rows["start"] / rate).tolist(), (rows["stop"] / rate).tolist()
        beats = self.score.meter.beats / self.score.meter.division
        return (rows["tick"] * beats).tolist(), ((rows["tick"] + rows["ticks"]) * beats).tolist()

    def at(self, seconds: float) -> float:
        """Return the count at a time; where beats are uneven, from the symbols around it."""
        if self.seconds:
            return seconds
        score, meter = self.score, self.score.meter
        rows = [track.symbols for track in score.tracks.values()]
        frames = np.concatenate([[0], *(it[name] for it in rows for name in ("start", "stop"))])
        ticks = np.concatenate(
            [[0], *(part for it in rows for part in (it["tick"], it["tick"] + it["ticks"]))]
        )
        frames, first = np.unique(frames, return_index=True)
        ticks, frame = np.maximum.accumulate(ticks[first]), seconds * float(score.rate)
        rate = float(meter.tick_rate / score.rate)
        past = max(frame - float(frames[-1]), 0.0) * rate
        return float((np.interp(frame, frames, ticks) + past) * meter.beats / meter.division)

    def number(self, count: float) -> str:
        """Return what stands beside a bar that begins at a count: its number, or the second."""
        bar = floor(count / self.bar + 1e-9)
        return str(bar * FIVE) if self.seconds else str(bar + 1)
