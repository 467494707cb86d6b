"""Writing, joining and verifying segments, each step in a transaction of its own.

An interrupted step leaves the library as it was before it; no step changes what the rows say.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from lanindex.library import capture_texts, derive, segments
from lanindex.library.columns import check_pending, order_of, read_roster, read_rosters, stored
from lanindex.library.link import Link
from lanindex.library.segments import Distrust, Segment, Spine
from lanindex.model.columns import EXTRA, Columns, enrolled

CHUNK = 1 << 20
"""About the symbols of the largest segment that is made of rows at once."""

LARGEST = 1 << 27
"""Symbols of the largest segment that is made by joining: SQLite keeps a billion bytes in one place
and no more, and readers wait while segments are joined."""

Step = Callable[[Link], bool]
"""Work in a transaction of its own; returns whether there may be more of it."""


def is_compacted(connection: Link) -> bool:
    """Return whether there is nothing to write for `cover` and `join`."""
    try:
        spine = segments.read_spine(connection)
    except Distrust:
        return False
    return not spine.pending and _first_to_join(spine) >= len(spine.segments)


def verify(connection: Link) -> None:
    """Load all segments."""
    spine = segments.read_spine(connection)
    read_rosters(connection, spine)
    nothing = derive.derived(connection, [])
    for segment in spine.segments:
        capture_texts.read_texts(connection, segment)
        for part in segment.parts:
            stored(connection, [segment], nothing, part, EXTRA)


def purge(connection: Link) -> bool:
    """Delete all segments if one of them is not what was stored, and return whether so."""
    try:
        verify(connection)
    except Distrust:
        segments.begin_anew(connection)
        return True
    return False


def cover(connection: Link, waiting: Callable[[int], None] = lambda count: None) -> bool:
    """Write a segment of captures that are in none, and return whether more are left."""
    spine = segments.read_spine(connection)
    pending = spine.pending
    pieces: list[derive.Derived] = []
    symbols = covered = 0
    waiting(len(pending))
    for piece in derive.batches(connection, pending):
        pieces.append(piece)
        covered += len(piece[0])
        symbols += sum(map(len, piece[1].values()))
        waiting(len(pending) - covered)
        if symbols >= CHUNK:
            break
    if not covered:
        return False
    roster, columns = derive.together(pieces)
    check_pending(roster.number.tolist(), pending[:covered])
    texts = capture_texts.spelled(capture_texts.of_rows(connection, pending[:covered]))
    segments.put(connection, roster, texts, columns.values())
    segments.mark_covered(connection, pending[:covered])
    return covered < len(pending)


def join(connection: Link) -> bool:
    """Make one segment of the newest ones that are worth it, and return whether there were any.

    A segment is joined with all newer ones once these hold as many symbols, so that each symbol is
    written again only when what it lies in has doubled; and all are, once a quarter of the
    captures in them is dead.
    """
    spine = segments.read_spine(connection)
    first = _first_to_join(spine)
    old = spine.segments[first:]
    if not old:
        return False
    ages = {one.id for one in old}
    dead = {number: last for number, last in spine.dead.items() if last >= min(ages)}
    rosters = enrolled([read_roster(connection, one) for one in old])
    order = order_of(Spine(old, dead, []), rosters.number)
    roster = rosters if order is None else rosters.taken(order)
    parts = list(dict.fromkeys(part for one in old for part in one.parts))
    pieces = [capture_texts.read_texts(connection, one) for one in old]
    texts = capture_texts.spelled(capture_texts.together(pieces, capture_texts.NAMES, order))
    segments.put(connection, roster, texts, _moved(connection, old, parts, order))
    segments.drop(connection, old)
    return True


def _moved(
    connection: Link,
    old: list[Segment],
    parts: Sequence[str],
    order: NDArray[np.int64] | None,
) -> Iterator[Columns]:
    """Yield the columns of segments part by part, each gone from there: its room is used again."""
    nothing = derive.derived(connection, [])
    for part in parts:
        found = stored(connection, old, nothing, part, EXTRA)
        segments.drop_part(connection, old, part)
        yield found if order is None else found.taken(order)


def _first_to_join(spine: Spine) -> int:
    """Return from which segment on all are to be joined."""
    sizes = [one.symbols + one.captures for one in spine.segments]
    lost = 4 * len(spine.dead) > sum(one.captures for one in spine.segments)
    for first in range(len(sizes)):
        rest = sum(sizes[first + 1 :])
        worth = (lost and first == 0) or (rest > 0 and sizes[first] <= rest)
        if worth and sizes[first] + rest <= LARGEST:
            return first
    return len(sizes)
