"""The fast engine on recordings in memory, answered as the plain matcher answers."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from lanindex.model import Capture, Track
from lanindex.model.columns import columns_of, roster_of
from lanindex.search.fast import Finder, Found, Watch
from lanindex.search.language import Query

Recordings = Sequence[tuple[Capture, Mapping[str, Track]]]


def find_fast(
    query: Query,
    recordings: Recordings,
    *,
    tolerance: Fraction = Fraction(1, 10),
    overlaps: str = "none",
    watch: Watch | None = None,
) -> Found:
    """Return what the engine finds."""
    captures = [capture for capture, _ in recordings]
    parts = {part for _, tracks in recordings for part in tracks if part in query.parts}
    columns = {
        part: columns_of(part, captures, [tracks.get(part) for _, tracks in recordings])
        for part in parts
    }
    finder = Finder(
        query,
        roster_of(captures),
        columns,
        lambda places, _: [recordings[place] for place in places],
        tolerance,
    )
    return finder.find(overlaps, watch)


def numbered(recordings: Recordings) -> Recordings:
    """Return recordings with numbers of their own, as in a library."""
    return [
        (replace(capture, id=number), tracks)
        for number, (capture, tracks) in enumerate(recordings, 1)
    ]


def told(hits) -> list[tuple]:
    """Return what two matchers must agree in: capture, frames and fit."""
    return [(hit.capture.id, hit.span.start, hit.span.stop, round(hit.fit, 3)) for hit in hits]
