"""Symbols as columns: the rows of one part in many captures, field by field.

A search over a whole library reads a few long arrays instead of millions of objects. The rows of
all captures follow each other; `Columns.bounds` tells where each capture's begin.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import BENDS, KINDS, MEASURES, PARTS, kind_of
from lanindex.data import shipped
from lanindex.model.capture import Capture
from lanindex.model.score import Track
from lanindex.model.symbol import FIELDS, Span, frozen, joined

GRADES = {"pace": "speed", "extent": "size"}
"""By kind of words, the measure that they grade."""

BELOW, USUAL, ABOVE = range(3)
"""Grades: of slow and small, of what has no word, of fast and large."""

LIMITS: dict[str, dict[str, tuple[float, float]]] = shipped("model/limits.toml")
"""By group of parts: less than the first is slow or small, more than the second fast or large."""


def stored(name: str, values: NDArray[Any]) -> NDArray[np.int64]:
    """Return a measure as columns store it, (S,): in its smallest unit plus 1; 0 is unknown."""
    whole: NDArray[np.int64] = np.rint(values.astype(np.float64) * FIELDS[name].scale)
    return whole.astype(np.int64) + 1


def graded(part: str, kind: str, values: NDArray[Any]) -> NDArray[np.int8]:
    """Return the grade of each symbol, -1 where unknown, from measures as `stored`, (S,)."""
    name, known = GRADES[kind], values > 0
    group = PARTS[part].group if part in PARTS else part
    between = LIMITS.get(group, {}).get(name)
    if between is None:  # of an unknown part
        return np.full(len(values), -1, np.int8)
    low, high = (round(it * FIELDS[name].scale) + 1 for it in between)
    grades = np.where(values < low, BELOW, np.where(values > high, ABOVE, USUAL))
    return np.where(known, grades, -1).astype(np.int8)


PASSING, STARTING = 1 << 6, 1 << 7
"""Flags of a cell: on the way only, and a starting position."""

CELL = PASSING - 1
"""The bits of a cell without its flags."""

THOUSANDTHS = 1000
"""A margin of 1."""

_ROWS = ("cell", "runner", "margin", "start", "stop")
"""Fields of `Columns` with a value for each symbol."""

EXTRA = ("swings", *MEASURES)
"""Fields that are read only on demand."""


def has_amount(part: str) -> bool:
    """Return whether the symbols of a part have an amount."""
    return part in BENDS or "amount" in KINDS[kind_of(part)].fields


def extras_of(part: str) -> tuple[str, ...]:
    """Return the fields of `EXTRA` that a part has."""
    return ("swings", *KINDS[kind_of(part)].measures)


def parted(capture: NDArray[Any], start: NDArray[Any], seen: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which rows, (S,), begin a known stretch where no starting position says so.

    `capture` and `start` are those of the rows; `seen` is `Columns.seen`, (G, 3).
    """
    stretches = seen[:, 0].astype(np.int64) << 32 | seen[:, 1]
    own = np.searchsorted(stretches, capture.astype(np.int64) << 32 | start, side="right")
    apart: NDArray[np.bool_] = np.diff(own, prepend=own[:1]) != 0
    return apart


def cell_of(direction: Any, level: Any) -> Any:
    """Return the cell, or cells, of a direction and a level, -1 where there is none of them."""
    return (direction + 1) | (level + 1) << 4


def codes_of(cells: NDArray[np.uint8]) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
    """Return the directions and the levels of cells, flags or not; -1 where there is none."""
    directions = (cells & CELL).astype(np.int8)
    return (directions & 15) - 1, (directions >> 4) - 1


ROSTER = {"number": np.int64, "frames": np.int32, "rate": np.int64, "speed": np.int64}
"""The arrays of `Roster`, by name their type."""


@dataclass(frozen=True, slots=True, eq=False)
class Roster:
    """The captures that columns are of, in the order of their numbers."""

    number: NDArray[np.int64]  # (C,) int64, as in the library
    frames: NDArray[np.int32]  # (C,) int32
    rate: NDArray[np.int64]  # (C, 2) int64: frames a second, as a fraction
    speed: NDArray[np.int64]  # (C, 2) int64: beats a minute, as a fraction
    # A cache of searches, freed with the captures
    kept: dict[str, Any] = field(default_factory=dict, init=False, repr=False)

    def __len__(self) -> int:
        return len(self.number)

    def __post_init__(self) -> None:
        for name in ROSTER:
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def same_as(self, other: Roster) -> bool:
        """Return whether another roster is equal."""
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in ROSTER)

    def at(self, places: NDArray[np.int64]) -> Roster:
        """Return the roster of some of the captures, by their places in this one: (D,) int64."""
        return Roster(*(getattr(self, name)[places] for name in ROSTER))


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Columns:
    """The symbols of one part, in all captures of a roster."""

    part: str
    # (C + 1,): the rows of capture c are ``bounds[c]`` to ``bounds[c + 1]``, half-open
    bounds: NDArray[np.int64]
    # (S,) uint8: as from `cell_of`, with the flags `PASSING` and `STARTING`
    cell: NDArray[np.uint8]
    runner: NDArray[np.uint8]  # (S,) uint8: the cell across the nearest border; 0: none known
    margin: NDArray[np.uint16]  # (S,) uint16, thousandths
    start: NDArray[np.int32]  # (S,) int32: frames of the source, half-open
    stop: NDArray[np.int32]
    # (G, 3) int32, sorted: place of the capture in the roster, and a range of frames in which the
    # part was seen. A capture without a range was seen from its first frame to its last; a part
    # that was never seen has an empty range
    seen: NDArray[np.int32]
    # (S,) int32, moves out and back within the cell; None where nobody has asked for them
    swings: NDArray[np.int32] | None = None
    # (S,) int16, as of a symbol; None where its kind of symbol has none
    amount: NDArray[np.int16] | None = None
    # (S,) uint16, as from `lanindex.model.columns.stored`: 0 where it is not known; None where its
    # kind of symbol has none, or nobody has asked
    speed: NDArray[np.uint16] | None = None
    size: NDArray[np.uint16] | None = None
    straightness: NDArray[np.uint16] | None = None
    # A cache of searches, freed with the columns
    kept: dict[str, Any] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("bounds", *self.rows, "seen"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def rows(self) -> tuple[str, ...]:
        """The names of fields with a value for each symbol."""
        return (*_ROWS, *(name for name in ("amount", *EXTRA) if getattr(self, name) is not None))

    def __len__(self) -> int:
        return len(self.cell)

    @property
    def blank(self) -> bool:
        """Whether no capture has the part: no symbols and no ranges in `seen`."""
        return not len(self) and not len(self.seen)

    def same_as(self, other: Columns) -> bool:
        """Return whether other columns are equal in the fields that both have."""
        names = ("bounds", *(name for name in self.rows if name in other.rows), "seen")
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in names)

    def at(self, places: NDArray[np.int64]) -> Columns:
        """Return the columns of some of the captures, by their places in the roster: (D,) int64."""
        bounds, rows = ranges(self.bounds[:-1][places], self.bounds[1:][places])
        edges = (np.searchsorted(self.seen[:, 0], places + end) for end in (0, 1))
        seen_bounds, seen_rows = ranges(*edges)
        seen = self.seen[seen_rows]
        seen[:, 0] = np.repeat(np.arange(len(places)), np.diff(seen_bounds))
        columns = {name: getattr(self, name)[rows] for name in self.rows}
        return Columns(self.part, bounds, **columns, seen=seen)

    def prints(self, extras: Collection[str]) -> NDArray[np.uint64]:
        """Return a number for each capture, (C,), that any other rows or ranges would change.

        Of the fields of `EXTRA`, only `extras` count.
        """
        names = [name for name in self.rows if name not in EXTRA or name in extras]
        fields = [getattr(self, name) for name in names]
        seen = np.searchsorted(self.seen[:, 0], np.arange(len(self.bounds)))
        found: NDArray[np.uint64] = _mixed(self.bounds, fields)
        return found ^ _mixed(seen, [self.seen[:, 1], self.seen[:, 2]]) * _FACTOR


_FACTOR = np.uint64(0x9E3779B97F4A7C15)


def _mixed(bounds: NDArray[np.int64], fields: Sequence[NDArray[Any]]) -> NDArray[np.uint64]:
    """Return a number for each stretch of rows, (D,); `bounds` (D + 1,) as of `Columns`."""
    places = np.arange(1, bounds[-1] + 1) - np.repeat(bounds[:-1], np.diff(bounds))
    mixed = places.astype(np.uint64) * _FACTOR
    for values in fields:
        mixed = (mixed ^ mixed >> np.uint64(29) ^ values.astype(np.int64).view(np.uint64)) * _FACTOR
    sums = np.append(np.uint64(0), np.cumsum(mixed ^ mixed >> np.uint64(32), dtype=np.uint64))
    return sums[bounds[1:]] - sums[bounds[:-1]]


def enrolled(rosters: Sequence[Roster]) -> Roster:
    """Return the captures of several rosters as one."""
    every = (roster_of([]), *rosters)
    return Roster(*(np.concatenate([getattr(one, name) for one in every]) for name in ROSTER))


def joined_columns(part: str, pieces: Sequence[Columns | None], sizes: Sequence[int]) -> Columns:
    """Return the columns of a part in several lists of captures, one after the other.

    `sizes` are the numbers of captures of each; None stands for captures without the part.
    """
    held, empty = [one for one in pieces if one is not None], columns_of(part, [], [])
    names = [name for name in empty.rows if all(name in one.rows for one in held)]
    filled = [one for one in held if len(one)] or [empty]
    rows = {name: [getattr(one, name) for one in filled] for name in names}
    counts = [
        np.zeros(size, np.int64) if one is None else np.diff(one.bounds)
        for one, size in zip(pieces, sizes, strict=True)
    ]
    seen = [
        one.seen + np.array([first, 0, 0], np.int32)
        for one, first in zip(pieces, np.cumsum([0, *sizes])[:-1], strict=True)
        if one is not None
    ]
    return Columns(
        part,
        np.concatenate([[0], *counts]).cumsum(dtype=np.int64),
        # One alone is not copied: it may be most of the memory.
        **{name: np.concatenate(own) if len(own) > 1 else own[0] for name, own in rows.items()},
        seen=np.concatenate([empty.seen, *seen]),
    )


def ranges(
    firsts: NDArray[np.int64], lasts: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the bounds, (D + 1,), and the rows, (S,), of stretches laid end to end.

    `firsts` and `lasts` (D,) are the half-open stretches; the bounds are as `Columns.bounds`.
    """
    bounds = np.concatenate([[0], np.cumsum(lasts - firsts)]).astype(np.int64)
    rows = np.arange(bounds[-1]) + np.repeat(firsts - bounds[:-1], lasts - firsts)
    return bounds, rows


def roster_of(captures: Sequence[Capture]) -> Roster:
    """Return the roster of some captures."""
    rates = [_ratio(one.rate) for one in captures]
    speeds = [_ratio(one.meter.speed) for one in captures]
    return Roster(
        np.array([one.id for one in captures], np.int64),
        np.array([one.frames for one in captures], np.int32),
        np.array(rates, np.int64).reshape(-1, 2),
        np.array(speeds, np.int64).reshape(-1, 2),
    )


def _ratio(value: Fraction) -> tuple[int, int]:
    """Return numerator and denominator, rounded to 62 bits."""
    numerator, denominator = value.as_integer_ratio()
    spare = max(numerator.bit_length(), denominator.bit_length()) - 62
    if spare <= 0:
        return numerator, denominator
    return max(1, numerator >> spare), max(1, denominator >> spare)


def columns_of(part: str, captures: Sequence[Capture], tracks: Sequence[Track | None]) -> Columns:
    """Return the columns of a part."""
    symbols = joined(track.symbols for track in tracks if track)
    seen = [
        (number, *span)
        for number, (capture, track) in enumerate(zip(captures, tracks, strict=True))
        if track is not None  # one without symbols may be seen, too
        for span in seen_of(track.known, capture.frames)
    ]
    counts = [len(track) if track else 0 for track in tracks]
    return columns_of_rows(part, counts, symbols, np.array(seen, np.int32).reshape(-1, 3))


def columns_of_rows(
    part: str, counts: Sequence[int] | NDArray[Any], symbols: NDArray[Any], seen: NDArray[np.int32]
) -> Columns:
    """Return columns of (S,) rows of `SYMBOL`; `counts`, (C,), tells how many a capture has."""
    measures = KINDS[kind_of(part)].measures
    cell = cell_of(symbols["direction"], symbols["level"]).astype(np.uint8)
    cell |= np.where(symbols["passing"], np.uint8(PASSING), np.uint8(0))
    cell |= np.where(symbols["start"] == symbols["stop"], np.uint8(STARTING), np.uint8(0))
    return Columns(
        part,
        np.concatenate([[0], counts]).cumsum(dtype=np.int64),
        cell,
        cell_of(symbols["runner_direction"], symbols["runner_level"]).astype(np.uint8),
        np.rint(symbols["margin"].astype(np.float64) * THOUSANDTHS).astype(np.uint16),
        symbols["start"].copy(),
        symbols["stop"].copy(),
        seen,
        symbols["swings"].astype(np.int32),
        symbols["amount"].copy() if has_amount(part) else None,
        **{name: stored(name, symbols[name]).astype(np.uint16) for name in measures},
    )


def seen_of(known: Sequence[Span], frames: int) -> list[tuple[int, int]]:
    """Return the ranges of `Columns.seen` for a track: none where the part was seen all the time.

    A part that was never seen has one range, from frame 0 to frame 0.
    """
    spans = [(span.start, span.stop) for span in known]
    return [] if spans == [(0, frames)] else spans or [(0, 0)]
