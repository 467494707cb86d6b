"""What a library holds, counted."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.library import read, segments
from lanindex.library.dialect import MOST, Link
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


_TEXTS = ("label", "profile", "format", "still")

_Piece = tuple[
    Roster, NDArray[np.bool_], Texts, Mapping[str, tuple[NDArray[np.int64], NDArray[Any]]]
]
"""Some captures; which of them are alive, (C,); texts of `_TEXTS`; by part how many symbols each
has, (C,), and `Columns.seen`, (G, 3)."""


def count(connection: Link, spine: Spine, size: int) -> Stats:
    """Count what a library holds that is a file of `size` bytes, and perhaps files of segments."""
    frames, seconds, known = 0, Fraction(), defaultdict[str, Fraction](Fraction)
    parts, labels, profiles, formats = (Counter[str]() for _ in range(4))
    for roster, alive, texts, by_part in _pieces(connection, spine):
        rates, codes = np.unique(roster.rate, axis=0, return_inverse=True)
        codes, periods = codes.reshape(-1), [1 / Fraction(*rate) for rate in rates.tolist()]
        frames += int(roster.frames[alive].sum())
        seconds += _seconds(codes[alive], roster.frames[alive], periods)
        labels.update(compress(texts["label"], alive))
        profiles.update(compress(texts["profile"], alive))
        formats.update(compress(texts["format"], alive))
        still: dict[str, list[int]] = {}
        for place, names in enumerate(texts["still"]):
            for part in names:
                still.setdefault(part, []).append(place)
        nothing = np.zeros(len(roster), np.int64), np.zeros((0, 3), np.int64)
        for part in dict.fromkeys((*by_part, *still)):
            counts, seen = by_part.get(part, nothing)
            whole = counts > 0
            whole[seen[:, 0]] = False
            whole[still.get(part, [])] = True
            whole &= alive
            seen = seen[alive[seen[:, 0]]].astype(np.int64)
            if len(seen) or whole.any():
                parts[part] += int(counts[alive].sum())
                known[part] += _seconds(codes[whole], roster.frames[whole], periods)
                known[part] += _seconds(codes[seen[:, 0]], seen[:, 2] - seen[:, 1], periods)
    coverage = {part: round(float(known[part] / seconds), 4) for part in sorted(known) if seconds}
    return Stats(
        captures=labels.total(),
        frames=frames,
        symbols=parts.total(),
        seconds=float(seconds),
        size=size + sum(one.bytes for one in spine.segments),
        parts=dict(sorted(parts.items())),
        coverage=coverage,
        labels=dict(sorted(labels.items())),
        profiles=dict(sorted(profiles.items())),
        formats=dict(sorted(formats.items())),
    )


def _seconds(codes: NDArray[Any], frames: NDArray[Any], periods: list[Fraction]) -> Fraction:
    """Return how long (N,) counts of frames last; `codes`, (N,), index the seconds of a frame.

    Frames of one rate are added up first: sums of seconds would be rounded, or take long.
    """
    sums = np.bincount(codes, frames, len(periods)).tolist()
    return sum((int(n) * period for n, period in zip(sums, periods, strict=True)), Fraction())


def _pieces(connection: Link, spine: Spine) -> Iterator[_Piece]:
    """Yield all captures of a library, those of segments first."""
    rosters, _ = segments.read_rosters(connection, spine)
    segments.check_pending(read.read_numbers(connection, spine.pending), spine.pending)
    for segment, roster in zip(spine.segments, rosters, strict=True):
        alive = np.zeros(len(roster), np.bool_)
        alive[segments.alive(spine, segment, roster)] = True
        by_part = {
            part: (
                segments.read_counts(connection, segment, part),
                segments.read_column(connection, segment, part, "gaps"),
            )
            for part in segment.parts
        }
        yield roster, alive, segments.read_texts(connection, segment, _TEXTS), by_part
    for first in range(0, len(spine.pending), MOST):
        chosen = read.read_captures(connection, spine.pending[first : first + MOST])
        tracks = read.read_track_rows(connection, chosen)
        roster = roster_of([one.capture for one in chosen])
        texts = segments.texts_of(_TEXTS, chosen, tracks)
        yield roster, np.ones(len(roster), np.bool_), texts, segments.tracks_by_part(tracks)
