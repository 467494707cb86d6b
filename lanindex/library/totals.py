"""Counts of captures that can be added up: those of each segment are stored with it."""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.library.selection import Texts
from lanindex.model.columns import Roster

TOTALLED = ("label", "profile", "format", "still")
"""The texts of captures that are counted."""


class Totals:
    """Counts of captures; frames are counted by their rate, since seconds would be rounded."""

    def __init__(self) -> None:
        self.frames = Counter[str]()  # By rate
        self.labels, self.profiles, self.formats = (Counter[str]() for _ in range(3))
        self.symbols = Counter[str]()  # By part
        self.seen = defaultdict[str, Counter[str]](Counter)  # Frames by part and rate

    def add(self, other: Totals) -> None:
        """Add the counts of other captures."""
        for name in ("frames", "labels", "profiles", "formats", "symbols"):
            getattr(self, name).update(getattr(other, name))
        for part, frames in other.seen.items():
            self.seen[part].update(frames)

    def packed(self) -> bytes:
        """Return them as JSON."""
        return json.dumps(vars(self), ensure_ascii=False).encode("utf-8", "surrogatepass")

    @classmethod
    def unpacked(cls, content: bytes) -> Totals:
        """Return them from JSON."""
        totals, held = cls(), json.loads(content)
        for part, frames in held.pop("seen").items():
            totals.seen[part].update(frames)
        for name, counts in held.items():
            getattr(totals, name).update(counts)
        return totals


class Counting:
    """Count the captures of a roster, or some, by their places; then their parts one by one."""

    def __init__(
        self, roster: Roster, texts: Texts, places: NDArray[np.int64] | None = None
    ) -> None:
        alive = np.full(len(roster), places is None)
        alive[places if places is not None else []] = True
        self._roster, self._alive = roster, alive
        rates, codes = np.unique(roster.rate, axis=0, return_inverse=True)
        self._codes, self._rates = codes.reshape(-1), [f"{a}/{b}" for a, b in rates.tolist()]
        self._still = defaultdict[str, list[int]](list)
        for place, names in enumerate(texts["still"]):
            for part in names:
                self._still[part].append(place)
        self.totals = Totals()
        self.totals.frames.update(self._by_rate(alive, roster.frames[alive]))
        self.totals.labels.update(compress(texts["label"], alive))
        self.totals.profiles.update(compress(texts["profile"], alive))
        self.totals.formats.update(compress(texts["format"], alive))

    def add(self, part: str, counts: NDArray[Any], seen: NDArray[Any]) -> None:
        """Count a part of which each capture has so many symbols, (C,); `seen` as of `Columns`."""
        whole = counts > 0
        whole[seen[:, 0]] = False
        whole[self._still.pop(part, [])] = True
        whole &= self._alive
        seen = seen[self._alive[seen[:, 0]]].astype(np.int64)
        if len(seen) or whole.any():
            self.totals.symbols[part] += int(counts[self._alive].sum())
            known = self.totals.seen[part]
            known.update(self._by_rate(whole, self._roster.frames[whole]))
            known.update(self._by_rate(seen[:, 0], seen[:, 2] - seen[:, 1]))

    def finished(self) -> Totals:
        """Return the counts, with those of parts that no capture has a symbol of."""
        nothing = np.zeros(len(self._roster), np.int64), np.zeros((0, 3), np.int64)
        for part in list(self._still):
            self.add(part, *nothing)
        return self.totals

    def _by_rate(self, captures: NDArray[Any], frames: NDArray[Any]) -> dict[str, int]:
        """Return how many of (N,) frames, of captures by place or mask, there are of each rate."""
        sums = np.bincount(self._codes[captures], frames, len(self._rates)).tolist()
        return {rate: int(sum) for rate, sum in zip(self._rates, sums, strict=True) if sum}
