"""Columns of the rows: what the segments are made of, each row held against its checksum."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from lanindex.library import codes, read
from lanindex.library.link import Link
from lanindex.model.columns import (
    CELL,
    PASSING,
    STARTING,
    Columns,
    Roster,
    enrolled,
    gaps_of,
    has_amount,
    joined,
    measures_of,
    roster_of,
)
from lanindex.model.symbol import FIELDS

BATCH = 256
"""Captures read at a time."""

_RUNNER = FIELDS["runner_direction"].shift
_MARGIN, _FULL = FIELDS["margin"].shift, (1 << FIELDS["margin"].bits) - 1
_PASSING = FIELDS["passing"].shift
_SWINGS, _MOST_SWINGS = FIELDS["swings"].shift, (1 << FIELDS["swings"].bits) - 1
_AMOUNT, _MOST_AMOUNT = FIELDS["amount"].shift, (1 << FIELDS["amount"].bits) - 1
_READ = ("sign", "start", "length", "notes")
"""Of the columns of ``symbol_code``."""

Derived = tuple[Roster, dict[str, Columns]]
"""Captures, and the columns of the parts that any of them has."""


def derived(
    connection: Link, numbers: Sequence[int], parts: Sequence[str] | None = None
) -> Derived:
    """Return the columns of captures, in the order of their numbers."""
    return together(list(batches(connection, numbers, parts)))


def batches(
    connection: Link, numbers: Sequence[int], parts: Sequence[str] | None = None
) -> Iterator[Derived]:
    """Yield what `derived` returns, some captures at a time."""
    for first in range(0, len(numbers), BATCH):
        yield _batch(connection, numbers[first : first + BATCH], parts)


def together(pieces: Sequence[Derived]) -> Derived:
    """Return captures and columns, one after the other; the pieces lose their columns."""
    if len(pieces) == 1:
        return pieces[0]
    rosters = [roster for roster, _ in pieces]
    names = dict.fromkeys(part for _, columns in pieces for part in columns)
    whole = {
        part: joined(part, [columns.pop(part, None) for _, columns in pieces], rosters)
        for part in names
    }
    return enrolled(rosters), whole


def _batch(connection: Link, numbers: Sequence[int], parts: Sequence[str] | None) -> Derived:
    chosen = read.read_captures(connection, numbers)
    wanted = read.read_wanted(connection, chosen, parts)
    return of_rows(wanted, read.read_fields(connection, wanted, every=parts is None))


def of_rows(wanted: read.Tracks, symbols: NDArray[np.int64]) -> Derived:
    """Return the columns of captures whose rows have been read."""
    codes_of = {part: code for code, part in enumerate(dict.fromkeys(wanted.part))}
    few = np.min_scalar_type(len(codes_of))  # numpy sorts small numbers by counting
    whose = np.array([codes_of[part] for part in wanted.part], few)
    counts = np.array(wanted.symbols, np.int64)
    gaps, rows_whose = _gaps(wanted), np.repeat(whose, counts)
    order = np.argsort(rows_whose, kind="stable")
    by_part = {name: symbols[:, codes.COLUMNS.index(name)][order] for name in _READ}
    ends = np.cumsum(np.bincount(rows_whose, minlength=len(codes_of))).tolist()
    columns = {}
    for (part, code), first, last in zip(codes_of.items(), [0, *ends], ends, strict=False):
        own = whose == code
        bounds = np.zeros(len(wanted.chosen) + 1, np.int64)
        bounds[wanted.place[own] + 1] = counts[own]
        held = np.array(gaps.get(part, []), np.int32).reshape(-1, 3)
        rows = {name: column[first:last] for name, column in by_part.items()}
        columns[part] = _columns(part, np.cumsum(bounds), held, **rows)
    return roster_of([one.capture for one in wanted.chosen]), columns


def _gaps(wanted: read.Tracks) -> dict[str, list[tuple[int, int, int]]]:
    """Return by part the stretches in which it was seen, of the captures where not always."""
    gaps: dict[str, list[tuple[int, int, int]]] = {}
    for track, known in enumerate(wanted.known):
        if known is not None:
            place, part = int(wanted.place[track]), wanted.part[track]
            capture = wanted.chosen[place].capture
            spans = gaps_of(read.known_of(capture, part, known), capture.frames)
            gaps.setdefault(part, []).extend((place, *span) for span in spans)
    return gaps


def _columns(
    part: str,
    bounds: NDArray[np.int64],
    gaps: NDArray[np.int32],
    sign: NDArray[np.int64],
    start: NDArray[np.int64],
    length: NDArray[np.int64],
    notes: NDArray[np.int64],
) -> Columns:
    """Return columns of the rows of a part: (S,) each of the fields in `_READ`."""
    cell = sign & CELL  # as it stands there: direction, then level
    cell |= np.where(sign >> _PASSING & 1, PASSING, 0)
    cell |= np.where(length == 0, STARTING, 0)
    return Columns(
        part,
        bounds,
        cell.astype(np.uint8),
        (sign >> _RUNNER & CELL).astype(np.uint8),
        (sign >> _MARGIN & _FULL).astype(np.uint16),
        start.astype(np.int32),
        (start + length).astype(np.int32),
        gaps,
        (notes >> _SWINGS & _MOST_SWINGS).astype(np.int32),
        ((notes >> _AMOUNT & _MOST_AMOUNT) - 1).astype(np.int16) if has_amount(part) else None,
        **{name: _measured(name, sign) for name in measures_of(part)},
    )


def _measured(name: str, sign: NDArray[np.int64]) -> NDArray[np.uint16]:
    return (sign >> FIELDS[name].shift & (1 << FIELDS[name].bits) - 1).astype(np.uint16)
