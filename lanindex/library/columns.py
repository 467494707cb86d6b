"""The columns of a library: put together from its segments, and kept while it is held open.

What a search asks for is read inside one transaction, part by part, once: as long as the change
stamp stays, it is given again. Captures that no segment holds yet are taken from their rows.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.library import derive, segments, state
from lanindex.library.link import Link
from lanindex.library.segments import Distrust, Segment, Spine
from lanindex.model.columns import (
    EXTRA,
    Columns,
    Roster,
    columns_of,
    enrolled,
    extras_of,
    has_amount,
)


@dataclass(slots=True)
class AllColumns:
    """All captures of a library, and how their columns are put together."""

    segments: list[Segment]
    extra: derive.Derived
    order: NDArray[np.int64] | None
    roster: Roster

    @property
    def parts(self) -> list[str]:
        """The parts that any capture has, or had."""
        found = [part for one in self.segments for part in one.parts]
        return list(dict.fromkeys([*found, *self.extra[1]]))

    def columns(self, connection: Link, part: str, more: Collection[str] = ()) -> Columns:
        """Load the columns of a part."""
        found = stored(connection, self.segments, self.extra, part, more)
        return found if self.order is None else found.taken(self.order)


def read_all_columns(
    connection: Link, spine: Spine, parts: Sequence[str] | None = None
) -> AllColumns:
    """Return the captures of a library."""
    rosters, order = read_rosters(connection, spine)
    extra = derive.derived(connection, spine.pending, parts)
    check_pending(extra[0].number.tolist(), spine.pending)
    whole = enrolled([*rosters, extra[0]])
    return AllColumns(spine.segments, extra, order, whole if order is None else whole.taken(order))


def read_rosters(connection: Link, spine: Spine) -> tuple[list[Roster], NDArray[np.int64] | None]:
    """Return the captures of each segment, and the order as in `AllColumns`."""
    rosters = [read_roster(connection, one) for one in spine.segments]
    number = np.concatenate([*(one.number for one in rosters), np.array(spine.pending, np.int64)])
    order = order_of(spine, number)
    number = number if order is None else number[order]
    stored = state.read_state(connection)
    if (len(number), int(number.sum())) != (stored.captures, stored.numbers) or (
        np.diff(number) <= 0
    ).any():
        raise Distrust("damaged: they are not those of the captures that there are")
    return rosters, order


def check_pending(there: Sequence[int], pending: Sequence[int]) -> None:
    """Refuse to wait for other captures than those that are there."""
    if list(there) != list(pending):
        raise Distrust("damaged: they wait for captures that there are not")


def read_roster(connection: Link, segment: Segment) -> Roster:
    """Return the captures of a segment, dead ones too."""
    found = [segments.read_column(connection, segment, "", name) for name in segments.CAPTURES]
    if {len(one) for one in found} != {segment.captures}:
        raise Distrust(f"damaged: the captures of segment {segment.id}")
    return Roster(
        *(one.astype(type) for one, type in zip(found, segments.CAPTURES.values(), strict=True))
    )


def alive(
    connection: Link, spine: Spine, segment: Segment
) -> tuple[NDArray[np.int64], Roster, dict[str, Columns]]:
    """Return the places of the captures of a segment that count, and all that it holds."""
    roster, nothing = read_roster(connection, segment), (enrolled([]), dict[str, Columns]())
    order = order_of(Spine([segment], spine.dead, []), roster.number)
    held = {part: stored(connection, [segment], nothing, part, EXTRA) for part in segment.parts}
    return np.arange(len(roster)) if order is None else order, roster, held


def order_of(spine: Spine, numbers: NDArray[np.int64]) -> NDArray[np.int64] | None:
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


def stored(
    connection: Link,
    held: Sequence[Segment],
    extra: derive.Derived,
    part: str,
    more: Collection[str] = (),
) -> Columns:
    """Return the columns of a part in all captures of segments, dead ones too, then in `extra`.

    `more` tells what of `lanindex.model.columns.EXTRA` is wanted, too.
    """
    added = extra[1].get(part, columns_of(part, [], []))

    def column(name: str, last: NDArray[Any]) -> NDArray[Any]:
        return _joined(
            [*(segments.read_column(connection, one, part, name) for one in held), last],
            segments.TYPES[name],
        )

    counts = [read_counts(connection, one, part) for one in held]
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
        amount=column("amount", _own(added, "amount")) if has_amount(part) else None,
        **{name: column(name, _own(added, name)) for name in extras_of(part) if name in more},
    )
    if {len(getattr(found, name)) for name in found.rows} != {found.bounds[-1]}:
        raise Distrust(f"damaged: the columns of {part} are not of one length")
    return found


def _own(added: Columns, name: str) -> NDArray[Any]:
    found: NDArray[Any] | None = getattr(added, name)
    return np.empty(0, segments.TYPES[name]) if found is None else found


def read_counts(connection: Link, segment: Segment, part: str) -> NDArray[np.int64]:
    """Return how many symbols of a part each capture of a segment has, dead ones too."""
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


def chosen(
    roster: Roster, columns: dict[str, Columns], numbers: Sequence[int]
) -> tuple[Roster, dict[str, Columns]]:
    """Return the roster and the columns of those captures that have some of these numbers."""
    order = np.flatnonzero(np.isin(roster.number, np.array(sorted(set(numbers)), np.int64)))
    return roster.taken(order), {part: one.taken(order) for part, one in columns.items()}
