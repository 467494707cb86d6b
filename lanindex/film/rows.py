"""The rows of a score that a stretch of it needs, found without looking at all of them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from lanindex.model import Score, Track


class Rows:
    """What is drawn of each track, in order."""

    def __init__(self, score: Score) -> None:
        self.score, self._held = score, {}
        for part, track in score.tracks.items():
            rows = track.symbols[~track.symbols["passing"]]
            ends = np.maximum.accumulate(rows["stop"])  # when it and all before it are over
            self._held[part] = rows, np.ascontiguousarray(rows["start"]), ends

    def around(self, start: float, stop: float, parts: Collection[str] | None = None) -> Score:
        """Return the score with the rows of a stretch alone, seconds: one more on either side."""
        tracks, rate = {}, float(self.score.rate)
        for part, (rows, begins, ends) in self._held.items():
            if parts is None or part in parts:
                first = int(np.searchsorted(ends, start * rate, "right"))
                last = int(np.searchsorted(begins, stop * rate, "left"))
                some = rows[max(first - 1, 0) : max(last, first) + 1]
                tracks[part] = Track(part, some, self.score.tracks[part].known)
        return replace(self.score, tracks=tracks)
