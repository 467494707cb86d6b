"""The fast engine on recordings in memory, answered as the plain matcher answers."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from lanindex.model import Capture, Track
from lanindex.search.language import Query
from lanindex.search.match import ExactHits, find_in

Recordings = Sequence[tuple[Capture, Mapping[str, Track]]]


def find_fast(query: Query, recordings: Recordings, **options: Any) -> ExactHits:
    """Return what the engine finds."""
    return find_in(recordings, query, **options)


def numbered(recordings: Recordings) -> Recordings:
    """Return recordings with numbers of their own, as in a library."""
    return [
        (replace(capture, id=number), tracks)
        for number, (capture, tracks) in enumerate(recordings, 1)
    ]


def told(hits) -> list[tuple]:
    """Return what two matchers must agree in: capture, frames and fit."""
    return [(hit.capture.id, hit.span.start, hit.span.stop, round(hit.fit, 3)) for hit in hits]
