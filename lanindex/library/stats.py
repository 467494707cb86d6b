"""What a library holds, counted."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.library import read, segments
from lanindex.library.dialect import MOST, Link
from lanindex.library.segments import Segment, Spine
from lanindex.library.totals import TOTALLED, Counting, Totals
from lanindex.model.columns import roster_of


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
    """Count what a library holds that is a file of `size` bytes, and perhaps files of segments."""
    totals = Totals()
    for one in _pieces(connection, spine):
        totals.add(one)
    seconds = _seconds(totals.frames)
    known = {part: _seconds(frames) for part, frames in sorted(totals.seen.items())}
    return Stats(
        captures=totals.labels.total(),
        frames=totals.frames.total(),
        symbols=totals.symbols.total(),
        seconds=float(seconds),
        size=size + sum(one.bytes for one in spine.segments),
        parts=dict(sorted(totals.symbols.items())),
        coverage={part: round(float(it / seconds), 4) for part, it in known.items() if seconds},
        labels=dict(sorted(totals.labels.items())),
        profiles=dict(sorted(totals.profiles.items())),
        formats=dict(sorted(totals.formats.items())),
    )


def _seconds(frames: Mapping[str, int]) -> Fraction:
    """Return how long frames last, by their rate."""
    return sum((number / Fraction(rate) for rate, number in frames.items()), Fraction())


def _pieces(connection: Link, spine: Spine) -> Iterator[Totals]:
    """Yield the counts of all captures of a library, those of segments first."""
    numbers = [
        segments.read_column(connection, one, "", "number").astype(np.int64)
        for one in spine.segments
    ]
    segments.checked_order(connection, spine, numbers)
    for segment, number in zip(spine.segments, numbers, strict=True):
        alive = segments.alive(spine, segment, number)
        totals = segments.read_totals(connection, segment)
        if totals is None or len(alive) < segment.captures:
            totals = _of_columns(connection, segment, alive)
        yield totals
    segments.check_pending(read.read_numbers(connection, spine.pending), spine.pending)
    for first in range(0, len(spine.pending), MOST):
        chosen = read.read_captures(connection, spine.pending[first : first + MOST])
        tracks = read.read_track_rows(connection, chosen)
        roster = roster_of([one.capture for one in chosen])
        counting = Counting(roster, segments.texts_of(TOTALLED, chosen, tracks))
        for part, columns in segments.tracks_by_part(tracks).items():
            counting.add(part, *columns)
        yield counting.finished()


def _of_columns(connection: Link, segment: Segment, alive: NDArray[np.int64]) -> Totals:
    """Return the counts of those captures of a segment that are alive, by their places."""
    texts = segments.read_texts(connection, segment, TOTALLED)
    counting = Counting(segments.read_roster(connection, segment), texts, alive)
    for part in segment.parts:
        seen = segments.read_column(connection, segment, part, "gaps")
        counting.add(part, segments.read_counts(connection, segment, part), seen)
    return counting.finished()
