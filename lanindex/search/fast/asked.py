"""What the clauses behind a pattern ask of many ways at once: rhythm and conditions.

What a label has matched is noted as far as a condition speaks of it: where it begins and ends, what
its last symbol is, or of which symbols it is, one after the other.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor, lcm
from typing import Any, Protocol

import numpy as np

from lanindex.alphabet import DIRECTION_CODES, LEVEL_CODES, MIRRORED, mirrored_part
from lanindex.model import Capture, Span
from lanindex.model.columns import CELL, THOUSANDTHS, cell_of
from lanindex.search.automaton import State
from lanindex.search.conditions import names_in, number_of
from lanindex.search.fast.block import Block
from lanindex.search.fast.ragged import FAR, Mask, Numbers, Whole
from lanindex.search.fast.walk import NotCovered
from lanindex.search.fields import Value, value_of_span
from lanindex.search.language.clauses import (
    CLIP,
    MATCH,
    Comparison,
    Condition,
    Mirrors,
    Reference,
    Term,
    references_in,
)
from lanindex.search.language.query import Query
from lanindex.search.language.times import Clock, Time

MET = FAR
"""What is noted of a label instead, once all that is asked of it is met: ways may be alike then."""

_TIMES = {"start": ("start",), "end": ("end",), "length": ("start", "end")}
_LAST = ("part", "row")
"""What is noted of a label, by the field that is asked for; of any other one the last symbol."""

_COMPARE: dict[str, Callable[[Numbers, Any], Mask]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_ROUND: dict[str, Callable[[Fraction], int]] = {"<": ceil, "<=": floor, ">": floor, ">=": ceil}
"""To which whole number others are compared in the same way as to a broken one."""

_CODES = {"direction": DIRECTION_CODES, "level": LEVEL_CODES}
_NO_FRAMES = Span(0, 0)


class Source(Protocol):
    """What columns do not tell."""

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in a block."""

    def swings(self, part: str) -> Whole:
        """Return how often each row of a part swings, (S,)."""


@dataclass(slots=True, eq=False)
class Told:
    """What is known of ways: of their labels and, at their ends, of all of them.

    Attributes
    ----------
    capture : ndarray
        (N,) int64.
    seen : ndarray
        (S, N) int64: what is noted of labels, as `Asked.columns` says; -1: nothing.
    low, high, part, row : ndarray
        (N,) int64: the frames of the hit, and the last symbol of its first line.
    """

    capture: Whole
    seen: Whole
    low: Whole
    high: Whole
    part: Whole
    row: Whole

    def at(self, chosen: Numbers) -> Told:
        """Return what is known of some of them."""
        own = (it[chosen] for it in (self.low, self.high, self.part, self.row))
        return Told(self.capture[chosen], self.seen[:, chosen], *own)


@dataclass(slots=True, eq=False)
class _Column:
    """A field of each of some ways: whole numbers of a kind, and where they are missing."""

    kind: str
    values: Whole
    there: Mask


class Asked:
    """The clauses of a query.

    Parameters
    ----------
    query : Query
        With its rhythm and conditions.

    Attributes
    ----------
    of_capture : tuple of Condition
        Those that a capture meets or does not, whatever matches.
    conditions : tuple of Condition
        The others.
    labels : dict of Condition to frozenset of str
        Of which each of those speaks.
    of_all : frozenset of Condition
        Those that speak of all that matched.
    of_frames : bool
        Whether they speak of the frames of all that matched.
    columns : dict of tuple of str to int
        By label and what is noted of it: where.
    """

    def __init__(self, query: Query) -> None:
        names = {it: names_in([it]) - {CLIP} for it in query.where}
        self.of_capture = tuple(it for it in query.where if not names[it])
        self.conditions = tuple(dict.fromkeys(it for it in query.where if names[it]))
        self.labels = {it: names[it] - {MATCH} for it in self.conditions}
        self.of_all = frozenset(it for it in self.conditions if MATCH in names[it])
        asked = set(references_in(self.conditions))
        self.of_frames = any(it.name == MATCH and it.field in _TIMES for it in asked)
        noted = [
            (it.name, what)
            for it in asked
            if it.name not in (CLIP, MATCH)
            for what in _TIMES.get(it.field, _LAST)
        ]
        for it in self.conditions:
            if isinstance(it, Mirrors):
                noted += [(it.first, "mirrored"), (it.second, "shown")]
        self.columns = {it: place for place, it in enumerate(sorted(set(noted)))}
        parts = query.parts | {mirrored_part(part) for part in query.parts}
        self._parts = {part: code for code, part in enumerate(sorted(parts))}
        self._sequences: dict[tuple[int, int], int] = {}
        several = lcm(*(share.denominator for share in query.rhythm))
        self.rhythm = [int(share * several) for share in query.rhythm]

    def __bool__(self) -> bool:
        """Return whether ways have to remember anything."""
        return bool(self.conditions or self.rhythm)

    def place(self, label: str) -> int:
        """Return where something is noted of a label."""
        return min(place for (name, _), place in self.columns.items() if name == label)

    def code(self, part: str) -> int:
        """Return the number of a part."""
        return self._parts[part]

    def parts(self) -> list[str]:
        """Return the parts by their numbers."""
        return list(self._parts)

    def noted(self, block: Block, state: State, events: Whole, seen: Whole) -> Whole:
        """Return what is known of labels once some events have matched a state."""
        wanted = [it for it in self.columns if it[0] in state.labels]
        if not wanted:
            return seen
        found, own = seen.copy(), block.events(state).at(events)
        for label, what in wanted:
            column = found[self.columns[label, what]]
            if what == "start":
                column[:] = np.where(column < 0, own.start, np.minimum(column, own.start))
            elif what == "end":
                column[:] = np.maximum(column, own.end)
            elif what == "part":
                column[:] = self._parts[state.members[-1]]
            elif what == "row":
                column[:] = own.last[-1]
            else:
                ends = zip(state.members, own.first, own.last, strict=True)
                for part, first, last in ends:
                    self._follow(block, part, (first, last), column, what == "mirrored")
        return found

    def _follow(
        self, block: Block, part: str, ends: tuple[Whole, Whole], column: Whole, mirrored: bool
    ) -> None:
        """Add symbols, or their mirror images, to those that a label had before."""
        first, last = ends
        rows = block.rows(part)
        named = self._parts[mirrored_part(part) if mirrored else part] << 8
        cells = _MIRRORED_CELLS if mirrored else np.arange(CELL + 1)
        for behind in range(int((last - first).max(initial=-1)) + 1):
            row = first + behind
            here = np.flatnonzero(row <= last)
            here = here[~rows.passing[row[here]] | (first == last)[here]]
            codes = named | cells[rows.cell[row[here]] & CELL]
            pairs, place = np.unique((column[here] + 1) << 20 | codes, return_inverse=True)
            told = [
                self._sequences.setdefault((it >> 20, it & 0xFFFFF), len(self._sequences))
                for it in pairs.tolist()
            ]
            column[here] = np.array(told, np.int64)[place]

    def may_be_in_rhythm(self, beats: Whole) -> Mask:
        """Tell where no two steps' lengths are too far from their shares, (R, N) → (N,)."""
        fits = np.ones(beats.shape[1], bool)
        shares = np.array(self.rhythm, object if max(self.rhythm) >> 28 else np.int64)
        for place, beat in enumerate(beats):
            for other, before in enumerate(beats[:place]):
                one, two = beat * shares[other], before * shares[place]
                near = (3 * one <= 5 * two) & (3 * two <= 5 * one)
                fits &= near.astype(bool) | (beat < 0)
        return fits

    def in_rhythm(self, beats: Whole) -> Mask:
        """Tell which steps last in the proportion that is asked for, (R, N) → (N,)."""
        whole = sum(self.rhythm)
        beats = beats.astype(object) if whole >> 28 else beats
        total = beats.sum(axis=0)
        fits: Mask = (beats >= 0).all(axis=0)
        for share, beat in zip(self.rhythm, beats, strict=True):
            fits &= (4 * abs(beat * whole - share * total) <= share * total).astype(bool)
        return fits


_MIRRORED_CELLS = np.array(
    [
        cell_of(MIRRORED[direction] if 0 <= direction < len(MIRRORED) else direction, level)
        for level, direction in ((it // 16 - 1, it % 16 - 1) for it in range(CELL + 1))
    ]
)


class Clauses:
    """The clauses of a query, asked in one block.

    Parameters
    ----------
    asked : Asked
        What they are.
    block : Block
        Where.
    source : Source
        What columns do not tell.
    """

    def __init__(self, asked: Asked, block: Block, source: Source) -> None:
        self._asked, self._block, self._source = asked, block, source
        self._values: dict[tuple[str, str], Whole] = {}

    def holds(self, condition: Condition, told: Told) -> Mask:
        """Tell of which ways a condition is true, (N,) bool."""
        met = np.zeros(len(told.capture), bool)
        for label in self._asked.labels[condition]:
            met |= told.seen[self._asked.place(label)] == MET
        some = np.flatnonzero(~met)
        met[some] = self._true_of(condition, told.at(some))
        return met

    def _true_of(self, condition: Condition, told: Told) -> Mask:
        if isinstance(condition, Mirrors):
            first = told.seen[self._asked.columns[condition.first, "mirrored"]]
            mirrored: Mask = first == told.seen[self._asked.columns[condition.second, "shown"]]
            return mirrored & (first >= 0)
        found = np.zeros(len(told.capture), bool)
        clocks, own = self._block.clocks()
        if CLIP not in names_in([condition]):
            for number, clock in enumerate(clocks):
                here = np.flatnonzero(own[told.capture] == number)
                if len(here):
                    found[here] = self._compared(condition, told.at(here), clock, None)
            return found
        places, which = np.unique(told.capture, return_inverse=True)
        captures = self._source.captures(places.tolist())
        for number, (place, capture) in enumerate(zip(places.tolist(), captures, strict=True)):
            here = np.flatnonzero(which == number)
            found[here] = self._compared(condition, told.at(here), clocks[own[place]], capture)
        return found

    def _compared(
        self, condition: Comparison, told: Told, clock: Clock, capture: Capture | None
    ) -> Mask:
        """Compare the two sides of a condition in captures that have one clock."""
        sides = [
            [(sign, self._term(term, told, clock, capture)) for sign, term in side.terms]
            for side in (condition.left, condition.right)
        ]
        columns = [it for side in sides for _, it in side if isinstance(it, _Column)]
        there = np.all([it.there for it in columns], axis=0)
        kinds = {it.kind for it in columns}
        if len(kinds) > 1:
            raise NotCovered
        (kind,) = kinds
        if kind not in ("frames", "thousandths"):
            return there & self._same(condition.compare, sides, kind)
        scale = clock.rate if kind == "frames" else Fraction(THOUSANDTHS)
        total, constant = np.zeros(len(there), np.int64), Fraction(0)
        for side, terms in zip((1, -1), sides, strict=True):
            for sign, value in terms:
                if isinstance(value, _Column):
                    total += side * sign * value.values
                    continue
                number = number_of(value)
                if number is None:  # a word is no number; in a sum nothing can be made of it
                    other = value is not None and len(terms) == 1 and condition.compare == "!="
                    return there & other
                constant -= side * sign * number * scale
        return there & _at_threshold(condition.compare, total, constant)

    def _same(
        self, compare: str, sides: list[list[tuple[int, _Column | Value]]], kind: str
    ) -> Mask:
        """Compare words, all of one kind."""
        told: list[Whole | int] = []
        for ((_, value),) in sides:
            if isinstance(value, _Column):
                told.append(value.values)
            elif value is None:
                return np.zeros(1, bool)
            else:
                codes = _CODES.get(kind) or {it: self._asked.code(it) for it in self._asked.parts()}
                told.append(codes.get(str(value), -1))
        unknown = any(isinstance(it, int) and it < 0 for it in told)
        if compare not in ("=", "!=") and (kind != "level" or unknown):
            raise NotCovered
        return np.atleast_1d(_COMPARE[compare](np.asarray(told[0]), told[1]))

    def _term(
        self, term: Term, told: Told, clock: Clock, capture: Capture | None
    ) -> _Column | Value:
        match term:
            case Reference(name=name) if name == CLIP:
                assert capture
                return value_of_span(term, capture, _NO_FRAMES)
            case Reference():
                return self._column(term, told)
            case Time():
                return term.frames(clock) / clock.rate
        return term.text if hasattr(term, "text") else term.value

    def _column(self, field: Reference, told: Told) -> _Column:
        """Return a field of a label, or of all that matched."""
        whole = field.name == MATCH
        columns = self._asked.columns
        if field.field in _TIMES:
            start, end = (
                own if whole else told.seen[columns.get((field.name, what), 0)]
                for own, what in ((told.low, "start"), (told.high, "end"))
            )
            values = {"start": start, "end": end, "length": end - start}[field.field]
            wanted = (start, end) if field.field == "length" else (values,)
            return _Column("frames", values, np.all([it >= 0 for it in wanted], axis=0))
        part = told.part if whole else told.seen[columns[field.name, "part"]]
        row = told.row if whole else told.seen[columns[field.name, "row"]]
        if field.field == "part":
            return _Column("part", part, row >= 0)
        values = np.full(len(row), -1)
        for code, name in enumerate(self._asked.parts()):
            here = (part == code) & (row >= 0)
            if here.any():
                values[here] = self._of_rows(name, field.field)[row[here]]
        kind = field.field if field.field in _CODES else "thousandths"
        return _Column(kind, values, values >= 0)

    def _of_rows(self, part: str, field: str) -> Whole:
        """Return a field of each row of a part."""
        if (part, field) not in self._values:
            rows = self._block.rows(part)
            cell = rows.cell.astype(np.int64)
            self._values[part, field] = {
                "direction": lambda: (cell & 15) - 1,
                "level": lambda: ((cell & CELL) >> 4) - 1,
                "margin": lambda: THOUSANDTHS - rows.cost,
                "swings": lambda: THOUSANDTHS * self._source.swings(part),
            }[field]()
        return self._values[part, field]


def _at_threshold(compare: str, total: Whole, constant: Fraction) -> Mask:
    """Compare whole numbers with a broken one, exactly."""
    if compare in _ROUND:
        threshold = max(-FAR, min(FAR, _ROUND[compare](constant)))
        return _COMPARE[compare](total, threshold)
    same = total == constant.numerator if constant.denominator == 1 else np.zeros(len(total), bool)
    return ~same if compare == "!=" else same
