"""Read the columns and texts of captures: from segments, or from rows where they are in none."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.library import read, segments
from lanindex.library.connect import MOST, Link
from lanindex.library.segments import TEXTS, Distrust, Segment, Spine
from lanindex.library.selection import Texts
from lanindex.model.columns import (
    EXTRA,
    Columns,
    Roster,
    columns_of_rows,
    enrolled,
    joined_columns,
    roster_of,
    seen_of,
)

BATCH = 256
"""Captures read at a time."""


class Piece(NamedTuple):
    """Some captures of a library."""

    roster: Roster
    columns: dict[str, Columns]  # Of the parts that any of them has
    texts: Texts  # Empty where only some parts were read

    def at(self, places: NDArray[np.int64]) -> Piece:
        """Return some of the captures, by their places in the roster: (D,) int64."""
        columns = {part: one.at(places) for part, one in self.columns.items()}
        return Piece(self.roster.at(places), columns, joined_texts([self.texts], places))

    def same_as(self, other: Piece) -> bool:
        """Return whether captures, columns and texts are equal."""
        own, others = (
            {part: one for part, one in piece.columns.items() if not one.blank}
            for piece in (self, other)
        )
        return (
            self.roster.same_as(other.roster)
            and self.texts == other.texts
            and own.keys() == others.keys()
            and all(one.same_as(others[part]) for part, one in own.items())
        )


def batches(
    connection: Link, numbers: Sequence[int], parts: Sequence[str] | None = None
) -> Iterator[Piece]:
    """Yield captures from their rows, some at a time, by number: with all parts, or some."""
    for first in range(0, len(numbers), BATCH):
        chosen = read.read_captures(connection, numbers[first : first + BATCH])
        tracks = read.read_track_rows(connection, chosen, parts)
        symbols = read.read_symbols(connection, tracks)
        yield of_rows(tracks, symbols, TEXTS if parts is None else ())


def together(pieces: Sequence[Piece]) -> Piece:
    """Join captures; the columns leave the pieces, which saves memory."""
    if len(pieces) == 1:
        return pieces[0]
    sizes = [len(one.roster) for one in pieces]
    columns = {
        part: joined_columns(part, [one.columns.pop(part, None) for one in pieces], sizes)
        for part in dict.fromkeys(part for one in pieces for part in one.columns)
    }
    roster = enrolled([one.roster for one in pieces])
    return Piece(roster, columns, joined_texts([one.texts for one in pieces]))


def of_rows(tracks: read.TrackRows, symbols: NDArray[Any], texts: Iterable[str] = TEXTS) -> Piece:
    """Return captures of which the rows of tracks and their symbols, (S,), have been read."""
    by_part, columns, first = tracks_by_part(tracks), dict[str, Columns](), 0
    codes = {part: code for code, part in enumerate(by_part)}
    few = np.min_scalar_type(len(codes))  # numpy sorts small numbers by counting
    whose = np.array([codes[part] for part in tracks.part], few)
    order = np.argsort(np.repeat(whose, np.array(tracks.symbols, np.int64)), kind="stable")
    symbols = symbols.take(order)  # by an index, numpy copies field by field
    for part, (counts, seen) in by_part.items():
        last = first + int(counts.sum())
        columns[part] = columns_of_rows(part, counts, symbols[first:last], seen)
        first = last
    roster = roster_of([one.capture for one in tracks.chosen])
    return Piece(roster, columns, texts_of(texts, tracks.chosen, tracks))


def tracks_by_part(
    tracks: read.TrackRows,
) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int32]]]:
    """Return by part how many symbols each capture has, (C,), and `Columns.seen`, (G, 3)."""
    counts = {part: np.zeros(len(tracks.chosen), np.int64) for part in dict.fromkeys(tracks.part)}
    seen: dict[str, list[tuple[int, int, int]]] = {part: [] for part in counts}
    columns = (tracks.place.tolist(), tracks.part, tracks.symbols, tracks.known)
    for place, part, symbols, known in zip(*columns, strict=True):
        counts[part][place] = symbols
        if known is not None:
            capture = tracks.chosen[place].capture
            spans = seen_of(read.known_of(capture, part, known), capture.frames)
            seen[part] += [(place, *span) for span in spans]
    return {
        part: (counts[part], np.array(own, np.int32).reshape(-1, 3)) for part, own in seen.items()
    }


def read_all_columns(
    connection: Link, spine: Spine, wanted: Mapping[str, Collection[str]]
) -> tuple[Roster, dict[str, Columns]]:
    """Return all captures of a library, and the columns of the wanted parts.

    `wanted` names by part which of `lanindex.model.columns.EXTRA` are wanted, too.
    """
    rosters, order = read_rosters(connection, spine)
    added = together(list(batches(connection, spine.pending, list(wanted))))
    check_pending(added.roster.number.tolist(), spine.pending)
    roster = enrolled([*rosters, added.roster])
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
    added: Piece | None = None,
) -> Columns:
    """Return the columns of a part in captures of segments, then in those that are `added`.

    `order` selects and sorts the captures; None: all, dead ones too, as they come.
    """
    pieces, sizes = list[Columns | None](), [one.captures for one in stored_segments]
    for one in stored_segments:
        there = (part, "counts") in one.entries
        pieces.append(segments.read_columns(connection, one, part, more) if there else None)
    if added is not None:
        last = added.columns.get(part)
        spare: dict[str, Any] = {name: None for name in EXTRA if name not in more}
        pieces.append(None if last is None else replace(last, **spare))
        sizes.append(len(added.roster))
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
    pieces = [
        {"id": roster.number.tolist(), **segments.read_texts(connection, one, names)}
        for one, roster in zip(spine.segments, rosters, strict=True)
    ]
    for first in range(0, len(spine.pending), MOST):
        numbers = spine.pending[first : first + MOST]
        chosen = read.read_captures(connection, numbers)
        check_pending([one.capture.id for one in chosen], numbers)
        pieces.append({"id": numbers, **texts_of(names, chosen)})
    texts = joined_texts([{name: () for name in ("id", *names)}, *pieces], order)
    return texts.pop("id"), texts


def joined_texts(
    pieces: Sequence[Texts], order: NDArray[np.int64] | None = None
) -> dict[str, list[Any]]:
    """Join the texts of pieces that have the same; `order` selects and sorts the captures."""
    names = pieces[0] if pieces else ()
    texts = {name: [value for piece in pieces for value in piece[name]] for name in names}
    if order is None:
        return texts
    places = order.tolist()
    return {name: [values[place] for place in places] for name, values in texts.items()}


def texts_of(
    names: Iterable[str], chosen: Sequence[read.Stored], tracks: read.TrackRows | None = None
) -> dict[str, list[Any]]:
    """Return texts of captures by name of the column; ``still`` needs all tracks of theirs."""
    texts: dict[str, list[Any]] = {}
    for name in names:
        if name == "profile":
            texts[name] = [one.encoding.profile for one in chosen]
        elif name == "still" and tracks is not None:
            texts[name] = [[] for _ in chosen]
            columns = (tracks.place.tolist(), tracks.part, tracks.symbols, tracks.known)
            for place, part, symbols, known in zip(*columns, strict=True):
                if symbols == 0 and known is None:
                    texts[name][place].append(part)
        else:
            texts[name] = [getattr(one.capture, name) for one in chosen]
    return texts
