"""What a library holds, counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.library import columns, read, segments
from lanindex.library.connect import MOST, Link
from lanindex.library.segments import Spine
from lanindex.library.selection import Texts
from lanindex.model.columns import Roster, roster_of


@dataclass(frozen=True, slots=True)
class Stats:
    """Counts of a library."""

    captures: int
    frames: int
    symbols: int
    seconds: float
    size: int
    parts: Mapping[str, int]
    coverage: Mapping[str, float]
    labels: Mapping[str, int]
    profiles: Mapping[str, int]
    formats: Mapping[str, int]


def count(connection: Link, spine: Spine, size: int) -> Stats:
    """Count what a library holds that is a file of `size` bytes."""
    tally = _Tally()
    rosters, _ = columns.read_rosters(connection, spine)
    columns.check_pending(read.read_numbers(connection, spine.pending), spine.pending)
    for segment, roster in zip(spine.segments, rosters, strict=True):
        alive = np.zeros(len(roster), np.bool_)
        alive[columns.alive(spine, segment, roster)] = True
        tracks = {
            part: (
                segments.read_counts(connection, segment, part),
                segments.read_column(connection, segment, part, "gaps"),
            )
            for part in segment.parts
        }
        tally.add(roster, alive, segments.read_texts(connection, segment, _TEXTS), tracks)
    for first in range(0, len(spine.pending), MOST):
        chosen = read.read_captures(connection, spine.pending[first : first + MOST])
        wanted = read.read_wanted(connection, chosen)
        roster = roster_of([one.capture for one in chosen])
        texts = {name: columns.texts_of(name, chosen, wanted) for name in _TEXTS}
        tally.add(roster, np.ones(len(roster), np.bool_), texts, columns.tracks_by_part(wanted))
    return tally.stats(size)


_TEXTS = ("label", "profile", "format", "still")

_Rate = tuple[int, int]
"""Frames a second, as a fraction."""


@dataclass(slots=True)
class _Tally:
    """Counts so far; frames by rate, as sums of seconds would be rounded."""

    frames: Counter[_Rate] = field(default_factory=Counter)
    known: dict[str, Counter[_Rate]] = field(default_factory=dict)
    parts: Counter[str] = field(default_factory=Counter)
    labels: Counter[str] = field(default_factory=Counter)
    profiles: Counter[str] = field(default_factory=Counter)
    formats: Counter[str] = field(default_factory=Counter)

    def add(
        self,
        roster: Roster,
        alive: NDArray[np.bool_],
        texts: Texts,
        tracks: Mapping[str, tuple[NDArray[Any], NDArray[Any]]],
    ) -> None:
        """Count those captures of a roster that are `alive`, (C,).

        `tracks` are by part the symbols of each capture, (C,), and `Columns.seen`, (G, 3).
        """
        rates, codes = np.unique(roster.rate, axis=0, return_inverse=True)
        codes, ratios = codes.reshape(-1), [(one, two) for one, two in rates.tolist()]

        def by_rate(places: NDArray[Any], frames: NDArray[Any]) -> Counter[_Rate]:
            sums = np.bincount(codes[places], frames, len(ratios)).astype(np.int64).tolist()
            return Counter(dict(zip(ratios, sums, strict=True)))

        self.frames += by_rate(alive, roster.frames[alive])
        self.labels.update(compress(texts["label"], alive))
        self.profiles.update(compress(texts["profile"], alive))
        self.formats.update(compress(texts["format"], alive))
        for part, (counts, seen) in tracks.items():
            whole = alive & (counts > 0)
            whole[seen[:, 0]] = False
            seen = seen[alive[seen[:, 0]]].astype(np.int64)
            if len(seen) or whole.any():
                known = by_rate(whole, roster.frames[whole])
                known.update(by_rate(seen[:, 0], seen[:, 2] - seen[:, 1]))
                self._add_track(part, int(counts[alive].sum()), known)
        still = zip(map(tuple, texts["still"]), codes.tolist(), roster.frames.tolist(), strict=True)
        frames: Counter[tuple[tuple[str, ...], int]] = Counter()
        for parts, code, many in compress(still, alive):
            frames[parts, code] += many
        for (parts, code), many in frames.items():
            for part in parts:
                self._add_track(part, 0, {ratios[code]: many})

    def _add_track(self, part: str, symbols: int, known: Mapping[_Rate, int]) -> None:
        self.parts[part] += symbols
        self.known.setdefault(part, Counter()).update(known)

    def stats(self, size: int) -> Stats:
        """Return the counts, with seconds in place of frames."""
        seconds, known = _seconds(self.frames), sorted(self.known.items())
        return Stats(
            captures=self.labels.total(),
            frames=self.frames.total(),
            symbols=self.parts.total(),
            seconds=float(seconds),
            size=size,
            parts=_sorted_counts(self.parts),
            coverage={it: round(float(_seconds(own) / seconds), 4) for it, own in known if seconds},
            labels=_sorted_counts(self.labels),
            profiles=_sorted_counts(self.profiles),
            formats=_sorted_counts(self.formats),
        )


def _seconds(frames: Mapping[_Rate, int]) -> Fraction:
    return sum((many / Fraction(*rate) for rate, many in frames.items()), Fraction())


def _sorted_counts(counts: Counter[str]) -> dict[str, int]:
    return dict(sorted(counts.items()))
