"""A library searched: its columns for the engine, its rows for the hits that are shown."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import nullcontext
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import FACING, TRACKS, mirrored_part
from lanindex.errors import LanindexError, LibraryError, OutOfMemoryError
from lanindex.library.store import Store
from lanindex.model import Hit
from lanindex.pipeline.how import How
from lanindex.search.fields import extras_in, measures_in
from lanindex.search.language.query import Query
from lanindex.search.match.finder import NARROWER, Recording, Watch

if TYPE_CHECKING:
    from lanindex.model.columns import Columns, Roster
    from lanindex.search.match.finder import Recordings


MOST_NAMED = 5
"""Captures that are named, of those that are too rich for a pattern."""


def search(
    library: Store,
    query: Query,
    numbers: Sequence[int] | None,
    how: How,
    watch: Watch | None = None,
    best: int | None = None,
    memory: int | None = None,
) -> tuple[Sequence[Hit], list[LanindexError]]:
    """Find a pattern in a library."""
    measures = measures_in(query)
    roster, columns = library.columns(query.parts, numbers, more=extras_in(query))
    if len(roster) and (absent := _absent(columns)):
        library.tell(
            f"no capture that was searched has symbols of {', '.join(absent)}{_why(absent)}"
        )
    if count := _unmeasured(columns, measures) if measures else 0:
        library.tell(
            f"{count} of {len(roster)} captures tell no {' or '.join(sorted(measures))}: they came "
            "as scores, or from an earlier version, and want to be ingested anew"
        )
    recordings = _recordings(library, roster, columns)
    try:
        refused: list[LanindexError] = []
        found = how.find(query, roster, columns, recordings, watch, best, memory, refused)
        for line in named(refused):
            library.tell(line)
        return found, refused
    except MemoryError:
        place = library.place
    raise OutOfMemoryError("the search ran out of memory", place=place, remedy=NARROWER)


def named(refused: Sequence[LanindexError]) -> Iterator[str]:
    """Yield a line for each capture that is too rich for a pattern; of many, for the first ones."""
    yield from map(str, refused[:MOST_NAMED])
    if more := refused[MOST_NAMED:]:
        yield f"{len(more)} more captures are too rich for this pattern"


def _absent(columns: Mapping[str, Columns]) -> list[str]:
    """Return the parts without symbols in any capture; of a pair, only if both sides have none."""
    blank = {part for part, one in columns.items() if not len(one)}
    moving = columns.keys() - blank
    return [part for part in TRACKS if part in blank and mirrored_part(part) not in moving]


def _why(absent: Sequence[str]) -> str:
    """Return where a user learns why palms are absent: few captures tell where they face."""
    palms = any(part in FACING for part in absent)
    return ": few captures tell where palms face (lanindex inspect FILE)" if palms else ""


def _unmeasured(columns: Mapping[str, Columns], measures: Collection[str]) -> int:
    """Return of how many captures no movement of some parts was measured, though there are some."""
    from lanindex.model.columns import STARTING

    moving: NDArray[np.int64] = np.zeros(1, np.int64)
    known = moving
    for one in columns.values():
        held = [getattr(one, name) for name in measures if getattr(one, name) is not None]
        if held:
            moving = moving + _sums(one.cell < STARTING, one.bounds)
            known = known + _sums(np.logical_and.reduce([it > 0 for it in held]), one.bounds)
    return int(((moving > 0) & (known == 0)).sum())


def _sums(rows: NDArray[np.bool_], bounds: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return how many rows of each capture are so."""
    before = np.append(0, np.cumsum(rows))
    counts: NDArray[np.int64] = before[bounds[1:]] - before[bounds[:-1]]
    return counts


def _recordings(library: Store, roster: Roster, columns: Mapping[str, Columns]) -> Recordings:
    """Return what fetches captures with some of their tracks, by their places in a roster.

    They are held against the columns, for a hit is told by its rows, and these may be others by
    now: the library has changed, or it is damaged.
    """

    def recordings(places: Sequence[int], parts: Collection[str]) -> Sequence[Recording]:
        wanted = roster.number[list(places)].tolist()
        with (
            nullcontext(library)
            if library.is_open
            else type(library).open(library.place, readonly=True) as opened
        ):
            found: list[Recording]
            if parts:
                found = list(opened.tracks(wanted, parts, listed=False))
            else:
                found = [(capture, {}) for capture in opened.some(wanted)]
            if _same(roster, columns, places, parts, found):
                return found
            held = {one.id: (one, tracks) for one, tracks in opened.tracks(wanted, parts)}
        pairs = zip(places, wanted, strict=True)
        same = [
            one in held and _same(roster, columns, [place], parts, [held[one]])
            for place, one in pairs
        ]
        raise LibraryError(
            f"{same.count(False)} captures with hits are gone, or others now",
            place=library.place,
            remedy="Search again: the library has changed since.",
        )

    return recordings


def _same(
    roster: Roster,
    columns: Mapping[str, Columns],
    places: Sequence[int],
    parts: Collection[str],
    found: Sequence[Recording],
) -> bool:
    """Return whether captures are as the columns have them, and so are some of their tracks."""
    from lanindex.model.columns import columns_of, roster_of

    own, captures = np.array(places, np.int64), [capture for capture, _ in found]
    return roster_of(captures).same_as(roster.taken(own)) and all(
        columns_of(part, captures, [tracks.get(part) for _, tracks in found]).same_as(
            columns[part].taken(own)
        )
        for part in parts
        if part in columns
    )
