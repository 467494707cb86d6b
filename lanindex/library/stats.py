"""What a library holds, counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.library import columns, read, segments
from lanindex.library.connect import MOST, Link
from lanindex.library.segments import Segment, Spine
from lanindex.model.columns import Roster


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
        tally.add_segment(connection, spine, segment, roster)
    tally.add_rows(connection, spine.pending)
    return tally.stats(size)


_Rate = tuple[int, int]
"""Frames a second, as a fraction."""


@dataclass(slots=True)
class _Tally:
    """What has been counted; frames by rate, for seconds that are added up would be rounded."""

    frames: Counter[_Rate] = field(default_factory=Counter)
    known: dict[str, Counter[_Rate]] = field(default_factory=dict)
    parts: Counter[str] = field(default_factory=Counter)
    labels: Counter[str] = field(default_factory=Counter)
    profiles: Counter[str] = field(default_factory=Counter)
    formats: Counter[str] = field(default_factory=Counter)

    def add_rows(self, connection: Link, numbers: Sequence[int]) -> None:
        """Count captures by their rows and those of their tracks."""
        for first in range(0, len(numbers), MOST):
            chosen = read.read_captures(connection, numbers[first : first + MOST])
            for one in chosen:
                self.frames[one.capture.rate.as_integer_ratio()] += one.capture.frames
            self.labels.update(one.capture.label for one in chosen)
            self.profiles.update(one.encoding.profile for one in chosen)
            self.formats.update(one.capture.format for one in chosen)
            own = read.read_wanted(connection, chosen)
            for capture, part, known, symbols in zip(
                own.owners, own.part, own.known, own.symbols, strict=True
            ):
                frames = sum(map(len, read.known_of(capture, part, known)))
                self._add_track(part, symbols, {capture.rate.as_integer_ratio(): frames})

    def _add_track(self, part: str, symbols: int, known: Mapping[_Rate, int]) -> None:
        self.parts[part] += symbols
        self.known.setdefault(part, Counter()).update(known)

    def add_segment(self, connection: Link, spine: Spine, segment: Segment, roster: Roster) -> None:
        """Count those captures of a segment that count."""
        alive = np.zeros(len(roster), np.bool_)
        alive[columns.alive(spine, segment, roster)] = True
        rates, codes = np.unique(roster.rate, axis=0, return_inverse=True)
        codes, ratios = codes.reshape(-1), [(one, two) for one, two in rates.tolist()]

        def by_rate(places: NDArray[Any], frames: NDArray[Any]) -> Counter[_Rate]:
            sums = np.bincount(codes[places], frames, len(ratios)).astype(np.int64).tolist()
            return Counter(dict(zip(ratios, sums, strict=True)))

        self.frames += by_rate(alive, roster.frames[alive])
        names = {"label": self.labels, "profile": self.profiles, "format": self.formats}
        texts = segments.read_texts(connection, segment, (*names, "still"))
        for name, counter in names.items():
            counter.update(compress(texts[name], alive))
        for part in segment.parts:
            counts = segments.read_counts(connection, segment, part)
            gaps = segments.read_column(connection, segment, part, "gaps").astype(np.int64)
            whole = alive & (counts > 0)
            whole[gaps[:, 0]] = False
            gaps = gaps[alive[gaps[:, 0]]]
            if len(gaps) or whole.any():
                known = by_rate(whole, roster.frames[whole])
                known.update(by_rate(gaps[:, 0], gaps[:, 2] - gaps[:, 1]))
                self._add_track(part, int(counts[alive].sum()), known)
        still = zip(map(tuple, texts["still"]), codes.tolist(), roster.frames.tolist(), strict=True)
        frames: Counter[tuple[tuple[str, ...], int]] = Counter()
        for parts, code, many in compress(still, alive):
            frames[parts, code] += many
        for (parts, code), many in frames.items():
            for part in parts:
                self._add_track(part, 0, {ratios[code]: many})

    def stats(self, size: int) -> Stats:
        """Return the counts, with seconds in place of frames."""
        seconds, known = _seconds(self.frames), sorted(self.known.items())
        return Stats(
            captures=self.labels.total(),
            frames=self.frames.total(),
            symbols=self.parts.total(),
            seconds=float(seconds),
            size=size,
            parts=_sorted(self.parts),
            coverage={it: round(float(_seconds(own) / seconds), 4) for it, own in known if seconds},
            labels=_sorted(self.labels),
            profiles=_sorted(self.profiles),
            formats=_sorted(self.formats),
        )


def _seconds(frames: Mapping[_Rate, int]) -> Fraction:
    return sum((many / Fraction(*rate) for rate, many in frames.items()), Fraction())


def _sorted(counts: Counter[str]) -> dict[str, int]:
    return dict(sorted(counts.items()))
