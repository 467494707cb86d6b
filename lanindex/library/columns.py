"""The columns of a library: put together from its segments, and kept while it is held open.

What a search asks for is read inside one transaction, part by part, once: as long as the change
stamp stays, it is given again. Captures that no segment holds yet are taken from their rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection

from lanindex.library import derive, segments, state
from lanindex.library.segments import Distrust, Segment, Spine
from lanindex.model.columns import Columns, Roster, columns_of, enrolled

CHUNK = 1 << 20
"""About the symbols of the largest segment that is made of rows at once."""


@dataclass(slots=True)
class Whole:
    """All captures of a library, and how their columns are put together.

    Attributes
    ----------
    segments : list of Segment
        Where they are.
    extra : Roster, dict of str to Columns
        Those that are in none.
    order : ndarray or None
        (C,) int64: which of the captures in the segments and `extra` count, in order of number;
        None: all, as they stand there.
    roster : Roster
        In that order.
    """

    segments: list[Segment]
    extra: derive.Derived
    order: NDArray[np.int64] | None
    roster: Roster

    @property
    def parts(self) -> list[str]:
        """The parts that any capture has, or had."""
        found = [part for one in self.segments for part in one.parts]
        return list(dict.fromkeys([*found, *self.extra[1]]))

    def columns(self, connection: Connection, part: str) -> Columns:
        """Load the columns of a part.

        Raises
        ------
        Distrust
            If they are not what was stored.
        """
        found = _stored(connection, self.segments, self.extra, part)
        return found if self.order is None else found.taken(self.order)


def read_whole(connection: Connection, spine: Spine, parts: Sequence[str] | None = None) -> Whole:
    """Return the captures of a library.

    Parameters
    ----------
    connection : Connection
        In a transaction.
    spine : Spine
        What there is of segments.
    parts : sequence of str, optional
        Which ones of the captures that are in no segment will be wanted; else all.

    Raises
    ------
    Distrust
        If the segments do not hold just the captures that there are.
    LibraryError
        If a capture that is in no segment is not what was stored.
    """
    extra = derive.derived(connection, spine.pending, parts)
    _check_pending(extra[0], spine.pending)
    whole = enrolled([*(_roster(connection, one) for one in spine.segments), extra[0]])
    order = _order(spine, whole.number)
    roster = whole if order is None else whole.taken(order)
    stored, numbers = state.read_state(connection), roster.number
    if (len(numbers), int(numbers.sum())) != (stored.captures, stored.numbers) or (
        np.diff(numbers) <= 0
    ).any():
        raise Distrust("damaged: they are not those of the captures that there are")
    return Whole(spine.segments, extra, order, roster)


def _check_pending(roster: Roster, pending: Sequence[int]) -> None:
    if roster.number.tolist() != list(pending):
        raise Distrust("damaged: they wait for captures that there are not")


def _roster(connection: Connection, segment: Segment) -> Roster:
    found = [segments.read_column(connection, segment, "", name) for name in segments.CAPTURES]
    if {len(one) for one in found} != {segment.captures}:
        raise Distrust(f"damaged: the captures of segment {segment.id}")
    return Roster(
        *(
            one.astype(segments.TYPES[name])
            for one, name in zip(found, segments.CAPTURES, strict=True)
        )
    )


def _order(spine: Spine, numbers: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """Return which captures count, in order of number; None: all, and they are."""
    ages = np.repeat(
        [one.id for one in spine.segments] + [1 << 62],
        [one.captures for one in spine.segments] + [len(spine.pending)],
    )
    alive = np.ones(len(numbers), np.bool_)
    if spine.dead:
        dead = np.array(sorted(spine.dead.items()), np.int64)
        places = np.searchsorted(dead[:, 0], numbers).clip(max=len(dead) - 1)
        alive = (dead[places, 0] != numbers) | (dead[places, 1] < ages)
    if alive.all() and (np.diff(numbers) > 0).all():
        return None
    order = np.flatnonzero(alive)
    return order[np.argsort(numbers[order], kind="stable")]


def _stored(
    connection: Connection, held: Sequence[Segment], extra: derive.Derived, part: str
) -> Columns:
    """Return the columns of a part in all captures of segments, and in `extra`."""
    added = extra[1].get(part, columns_of(part, [], []))

    def column(name: str, last: NDArray[Any]) -> NDArray[Any]:
        return _joined(
            [*(segments.read_column(connection, one, part, name) for one in held), last],
            segments.TYPES[name],
        )

    counts = [_counts(connection, one, part) for one in held]
    counts.append(np.diff(added.bounds) if part in extra[1] else np.zeros(len(extra[0]), np.int64))
    start = column("start", added.start)
    stop = column("length", added.stop - added.start)
    stop = stop + start
    firsts = np.cumsum([0, *(one.captures for one in held)])
    gaps = [
        segments.read_column(connection, one, part, "gaps") + np.array([first, 0, 0], np.int64)
        for one, first in zip(held, firsts[:-1], strict=True)
    ]
    gaps.append(added.gaps + np.array([firsts[-1], 0, 0]))
    found = Columns(
        part,
        np.concatenate([[0], *counts]).cumsum(dtype=np.int64),
        column("cell", added.cell),
        column("runner", added.runner),
        column("margin", added.margin),
        start,
        stop,
        np.concatenate(gaps).astype(np.int32),
    )
    if {len(found.cell), len(found.runner), len(found.margin), len(start)} != {found.bounds[-1]}:
        raise Distrust(f"damaged: the columns of {part} are not of one length")
    return found


def _counts(connection: Connection, segment: Segment, part: str) -> NDArray[np.int64]:
    found = segments.read_column(connection, segment, part, "counts").astype(np.int64)
    if (part, "counts") not in segment.entries:
        return np.zeros(segment.captures, np.int64)
    if len(found) != segment.captures:
        raise Distrust(f"damaged: counts of {part} in segment {segment.id}")
    return found


def _joined(pieces: list[NDArray[Any]], type: Any) -> NDArray[Any]:
    """Return arrays one after the other; one alone is not copied."""
    filled = [one for one in pieces if len(one)]
    if len(filled) == 1:
        return filled[0].astype(type, copy=False)
    whole, first = np.empty(sum(map(len, filled)), type), 0
    for one in filled:
        whole[first : first + len(one)] = one
        first += len(one)
    return whole


class Held:
    """What has been loaded of a library's columns, as long as it stays as it was."""

    def __init__(self) -> None:
        self._stamp: int | None = None
        self._roster = enrolled([])
        self._columns: dict[str, Columns] = {}

    def has(self, connection: Connection, parts: Sequence[str]) -> bool:
        """Return whether the library is as it was, and these parts are loaded."""
        same = state.read_state(connection).stamp == self._stamp
        return same and all(part in self._columns for part in parts)

    def find(
        self, connection: Connection, parts: Sequence[str], *, trusted: bool = True
    ) -> tuple[Roster, dict[str, Columns]]:
        """Return all captures and the columns of some parts.

        Parameters
        ----------
        connection : Connection
            In a transaction.
        parts : sequence of str
            Whose.
        trusted : bool
            Read the segments; else the rows.

        Raises
        ------
        Distrust
            If the segments cannot be trusted.
        LibraryError
            If a capture is not what was stored.
        """
        stamp = state.read_state(connection).stamp
        if stamp != self._stamp:
            self._columns = {}
            self._stamp = None
        missing = [part for part in parts if part not in self._columns]
        if missing or self._stamp is None:
            if trusted:
                spine = segments.read_spine(connection)
            else:
                spine = Spine([], {}, state.capture_numbers(connection))
            whole = read_whole(connection, spine, missing)
            for part in missing:
                self._columns[part] = whole.columns(connection, part)
            self._roster, self._stamp = whole.roster, stamp
        return self._roster, {part: self._columns[part] for part in parts}


def chosen(
    roster: Roster, columns: dict[str, Columns], numbers: Sequence[int]
) -> tuple[Roster, dict[str, Columns]]:
    """Return the roster and the columns of those captures that have some of these numbers."""
    order = np.flatnonzero(np.isin(roster.number, np.array(sorted(set(numbers)), np.int64)))
    return roster.taken(order), {part: one.taken(order) for part, one in columns.items()}


Step = Callable[[Connection], bool]
"""Work in a transaction of its own; returns whether there may be more of it."""


def is_gathered(connection: Connection) -> bool:
    """Return whether there is nothing to write for `cover` and `join`."""
    try:
        spine = segments.read_spine(connection)
    except Distrust:
        return False
    return not spine.pending and _first_to_join(spine) >= len(spine.segments)


def cover(connection: Connection) -> bool:
    """Write a segment of captures that are in none, and return whether more are left.

    Raises
    ------
    Distrust
        If the segments cannot be trusted.
    LibraryError
        If one of those captures is not what was stored.
    """
    pending = segments.read_spine(connection).pending
    pieces: list[derive.Derived] = []
    symbols = covered = 0
    for piece in derive.batches(connection, pending):
        pieces.append(piece)
        covered += len(piece[0])
        symbols += sum(map(len, piece[1].values()))
        if symbols >= CHUNK:
            break
    if not covered:
        return False
    roster, columns = derive.together(pieces)
    _check_pending(roster, pending[:covered])
    segments.put(connection, roster, columns.values())
    segments.mark_covered(connection, pending[:covered])
    return covered < len(pending)


def join(connection: Connection) -> bool:
    """Make one segment of the newest ones that are worth it, and return whether there were any.

    A segment is joined with all newer ones once these hold as many symbols, so that each symbol is
    written again only when what it lies in has doubled; and all are, once a quarter of the
    captures in them is dead.

    Raises
    ------
    Distrust
        If the segments cannot be trusted.
    """
    spine = segments.read_spine(connection)
    first = _first_to_join(spine)
    old = spine.segments[first:]
    if not old:
        return False
    ages = {one.id for one in old}
    dead = {number: last for number, last in spine.dead.items() if last >= min(ages)}
    rosters = enrolled([_roster(connection, one) for one in old])
    order = _order(Spine(old, dead, []), rosters.number)
    roster = rosters if order is None else rosters.taken(order)
    parts = list(dict.fromkeys(part for one in old for part in one.parts))
    segments.put(connection, roster, _moved(connection, old, parts, order))
    segments.drop(connection, old)
    return True


def _moved(
    connection: Connection,
    old: list[Segment],
    parts: Sequence[str],
    order: NDArray[np.int64] | None,
) -> Iterator[Columns]:
    """Yield the columns of segments part by part, each gone from there: its room is used again."""
    nothing = derive.derived(connection, [])
    for part in parts:
        found = _stored(connection, old, nothing, part)
        segments.drop_part(connection, old, part)
        if len(found := found if order is None else found.taken(order)) or len(found.gaps):
            yield found


def _first_to_join(spine: Spine) -> int:
    """Return from which segment on all are to be joined."""
    sizes = [one.symbols + one.captures for one in spine.segments]
    if 4 * len(spine.dead) > sum(one.captures for one in spine.segments):
        return 0
    for first in range(len(sizes) - 1):
        if sum(sizes[first + 1 :]) >= sizes[first]:
            return first
    return len(sizes)
