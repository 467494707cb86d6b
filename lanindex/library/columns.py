"""Read the columns and texts of captures: from segments, or from rows where they are in none."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.library import read, segments
from lanindex.library.connect import MOST, Link
from lanindex.library.rows import COLUMNS
from lanindex.library.segments import TEXTS, Distrust, Segment, Spine
from lanindex.library.selection import Texts
from lanindex.model.columns import (
    CELL,
    EXTRA,
    PASSING,
    STARTING,
    Columns,
    Roster,
    enrolled,
    has_amount,
    joined_columns,
    measures_of,
    roster_of,
    seen_of,
)
from lanindex.model.symbol import FIELDS

BATCH = 256
"""Captures read at a time."""

_READ = ("sign", "start", "length", "notes")
"""The columns of ``symbol_code`` that `_columns` needs."""

Derived = tuple[Roster, dict[str, Columns]]
"""Captures, and the columns of the parts that any of them has."""


def batches(
    connection: Link, numbers: Sequence[int], parts: Sequence[str] | None = None
) -> Iterator[Derived]:
    """Yield the columns of captures from their rows, some captures at a time, by number."""
    for first in range(0, len(numbers), BATCH):
        chosen = read.read_captures(connection, numbers[first : first + BATCH])
        wanted = read.read_wanted(connection, chosen, parts)
        yield of_rows(wanted, read.read_fields(connection, wanted, every=parts is None))


def together(pieces: Sequence[Derived]) -> Derived:
    """Join captures and columns; the columns leave the pieces, which saves memory."""
    if len(pieces) == 1:
        return pieces[0]
    sizes = [len(roster) for roster, _ in pieces]
    names = dict.fromkeys(part for _, columns in pieces for part in columns)
    whole = {
        part: joined_columns(part, [columns.pop(part, None) for _, columns in pieces], sizes)
        for part in names
    }
    return enrolled([roster for roster, _ in pieces]), whole


def of_rows(wanted: read.Tracks, symbols: NDArray[np.int64]) -> Derived:
    """Return the columns of captures whose rows have been read."""
    tracks, columns, first = tracks_by_part(wanted), dict[str, Columns](), 0
    codes = {part: code for code, part in enumerate(tracks)}
    few = np.min_scalar_type(len(codes))  # numpy sorts small numbers by counting
    whose = np.array([codes[part] for part in wanted.part], few)
    order = np.argsort(np.repeat(whose, np.array(wanted.symbols, np.int64)), kind="stable")
    fields = {name: symbols[:, COLUMNS.index(name)][order] for name in _READ}
    for part, (counts, seen) in tracks.items():
        bounds = np.concatenate([[0], np.cumsum(counts)])
        last = first + bounds[-1].item()
        rows = {name: column[first:last] for name, column in fields.items()}
        columns[part] = _columns(part, bounds, seen, **rows)
        first = last
    return roster_of([one.capture for one in wanted.chosen]), columns


def tracks_by_part(
    wanted: read.Tracks,
) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int32]]]:
    """Return by part how many symbols each capture has, (C,), and `Columns.seen`, (G, 3)."""
    counts = {part: np.zeros(len(wanted.chosen), np.int64) for part in dict.fromkeys(wanted.part)}
    seen: dict[str, list[tuple[int, int, int]]] = {part: [] for part in counts}
    tracks = zip(wanted.place.tolist(), wanted.part, wanted.symbols, wanted.known, strict=True)
    for place, part, symbols, known in tracks:
        counts[part][place] = symbols
        if known is not None:
            capture = wanted.chosen[place].capture
            spans = seen_of(read.known_of(capture, part, known), capture.frames)
            seen[part] += [(place, *span) for span in spans]
    return {
        part: (counts[part], np.array(own, np.int32).reshape(-1, 3)) for part, own in seen.items()
    }


def _columns(
    part: str,
    bounds: NDArray[np.int64],
    seen: NDArray[np.int32],
    sign: NDArray[np.int64],
    start: NDArray[np.int64],
    length: NDArray[np.int64],
    notes: NDArray[np.int64],
) -> Columns:
    """Return columns of the rows of a part: (S,) each of the fields in `_READ`."""

    def bits(column: NDArray[np.int64], name: str) -> NDArray[np.int64]:
        return column >> FIELDS[name].shift & (1 << FIELDS[name].bits) - 1

    cell = sign & CELL  # The same bits in both: direction, then level
    cell |= np.where(bits(sign, "passing"), PASSING, 0)
    cell |= np.where(length == 0, STARTING, 0)
    return Columns(
        part,
        bounds,
        cell.astype(np.uint8),
        (sign >> FIELDS["runner_direction"].shift & CELL).astype(np.uint8),
        bits(sign, "margin").astype(np.uint16),
        start.astype(np.int32),
        (start + length).astype(np.int32),
        seen,
        bits(notes, "swings").astype(np.int32),
        (bits(notes, "amount") - 1).astype(np.int16) if has_amount(part) else None,
        **{name: bits(sign, name).astype(np.uint16) for name in measures_of(part)},
    )


def read_all_columns(
    connection: Link, spine: Spine, wanted: Mapping[str, Collection[str]]
) -> Derived:
    """Return all captures of a library, and the columns of the wanted parts.

    `wanted` names by part which of `lanindex.model.columns.EXTRA` are wanted, too.
    """
    rosters, order = read_rosters(connection, spine)
    added = together(list(batches(connection, spine.pending, list(wanted))))
    check_pending(added[0].number.tolist(), spine.pending)
    roster = enrolled([*rosters, added[0]])
    columns = {
        part: stored_columns(connection, spine.segments, part, order, more, added)
        for part, more in wanted.items()
    }
    return roster if order is None else roster.at(order), columns


def stored_columns(
    connection: Link,
    stored_segments: Sequence[Segment],
    part: str,
    order: NDArray[np.int64] | None,
    more: Collection[str] = EXTRA,
    added: Derived | None = None,
) -> Columns:
    """Return the columns of a part in captures of segments, then in those that are `added`.

    `order` selects and sorts the captures; None: all, dead ones too, as they come.
    """
    pieces, sizes = list[Columns | None](), [one.captures for one in stored_segments]
    for one in stored_segments:
        there = (part, "counts") in one.entries
        pieces.append(segments.read_columns(connection, one, part, more) if there else None)
    if added is not None:
        last = added[1].get(part)
        spare: dict[str, Any] = {name: None for name in EXTRA if name not in more}
        pieces.append(None if last is None else replace(last, **spare))
        sizes.append(len(added[0]))
    columns = joined_columns(part, pieces, sizes)
    return columns if order is None else columns.at(order)


def read_rosters(connection: Link, spine: Spine) -> tuple[list[Roster], NDArray[np.int64] | None]:
    """Return the captures of each segment, and the order of all as `order_of` returns it."""
    rosters = [segments.read_roster(connection, one) for one in spine.segments]
    number = np.concatenate([*(one.number for one in rosters), np.array(spine.pending, np.int64)])
    order = order_of(spine, number)
    number = number if order is None else number[order]
    stored = read.read_state(connection)
    if (len(number), int(number.sum())) != (stored.captures, stored.numbers) or (
        np.diff(number) <= 0
    ).any():
        raise Distrust("damaged: they are not those of the captures that there are")
    return rosters, order


def order_of(spine: Spine, numbers: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """Return the places of the captures that are alive, by number; None: all, as they come."""
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


def alive(spine: Spine, segment: Segment, roster: Roster) -> NDArray[np.int64]:
    """Return the places of the captures of a segment that are alive, by number."""
    order = order_of(Spine([segment], spine.dead, []), roster.number)
    return np.arange(len(roster)) if order is None else order


def check_pending(there: Sequence[int], pending: Sequence[int]) -> None:
    """Refuse a list of pending captures that differs from those that exist."""
    if list(there) != list(pending):
        raise Distrust("damaged: they wait for captures that there are not")


def read_all_texts(
    connection: Link, spine: Spine, names: Sequence[str]
) -> tuple[list[int], dict[str, list[Any]]]:
    """Return the numbers of all captures, in order, and their texts by name of the column."""
    rosters, order = read_rosters(connection, spine)
    pieces = [segments.read_texts(connection, one, names) for one in spine.segments]
    pieces.append(texts_of_rows(connection, spine.pending, names))
    numbers = [*(one.number.tolist() for one in rosters), spine.pending]
    numbered = [{"id": own, **texts} for own, texts in zip(numbers, pieces, strict=True)]
    texts = joined_texts(numbered, ["id", *names], order)
    return texts.pop("id"), texts


def joined_texts(
    pieces: Sequence[Texts], names: Iterable[str], order: NDArray[np.int64] | None
) -> dict[str, list[Any]]:
    """Join the texts of all pieces; `order` selects and sorts the captures."""
    texts = {name: [value for piece in pieces for value in piece[name]] for name in names}
    if order is None:
        return texts
    places = order.tolist()
    return {name: [values[place] for place in places] for name, values in texts.items()}


def texts_of_rows(
    connection: Link, numbers: Sequence[int], names: Iterable[str] = TEXTS
) -> dict[str, list[Any]]:
    """Return the texts of captures from their rows."""
    texts: dict[str, list[Any]] = {name: [] for name in names}
    for first in range(0, len(numbers), MOST):
        some = numbers[first : first + MOST]
        chosen = read.read_captures(connection, some)
        check_pending([one.capture.id for one in chosen], some)
        wanted = read.read_wanted(connection, chosen) if "still" in texts else None
        for name, values in texts.items():
            values += texts_of(name, chosen, wanted)
    return texts


def texts_of(name: str, chosen: Sequence[read.Stored], wanted: read.Tracks | None) -> list[Any]:
    """Return one column of texts of captures; "still" needs their tracks."""
    if name == "profile":
        return [one.encoding.profile for one in chosen]
    if name != "still" or wanted is None:
        return [getattr(one.capture, name) for one in chosen]
    still: list[list[str]] = [[] for _ in chosen]
    for track in np.flatnonzero(np.array(wanted.symbols) == 0).tolist():
        if wanted.known[track] is None:
            still[wanted.place[track]].append(wanted.part[track])
    return still
