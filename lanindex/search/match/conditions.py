"""What the clauses behind a pattern ask of many matches at once: rhythm and conditions.

What a label has matched is noted as far as a condition speaks of it: where it begins and ends, what
its last symbol is, or of which symbols it is, one after the other.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor, lcm
from typing import Any

import numpy as np

from lanindex.alphabet import (
    DIRECTION_CODES,
    KINDS,
    LEVEL_CODES,
    MEASURES,
    MIRRORED,
    kind_of,
    mirrored_part,
)
from lanindex.model import Capture, Span
from lanindex.model.bends import degree_of
from lanindex.model.columns import CELL, THOUSANDTHS, cell_of, has_amount
from lanindex.model.symbol import FIELDS
from lanindex.search.automaton import State
from lanindex.search.conditions import about, names_in, number_of
from lanindex.search.fields import Value, value_of_span
from lanindex.search.language.clauses import (
    CLIP,
    MATCH,
    Comparison,
    Condition,
    Mirrors,
    Reference,
    Term,
    Text,
    references_in,
)
from lanindex.search.language.query import Query
from lanindex.search.language.times import Clock, Time
from lanindex.search.language.words import AMOUNTS, WORD_KINDS
from lanindex.search.match.arrays import FAR, AnyArray, BoolArray, IntArray
from lanindex.search.match.batch import Batch

MET = FAR
"""What is noted of a label instead, once all that is asked of it is met: ways may be alike then."""

TIMES = {"start": ("start",), "end": ("end",), "length": ("start", "end")}
_LAST = ("part", "row")
"""What is noted of a label, by the field that is asked for; of any other one the last symbol."""


class Clauses:
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
        self.of_frames = any(it.name == MATCH and it.field in TIMES for it in asked)
        noted = [
            (it.name, what)
            for it in asked
            if it.name not in (CLIP, MATCH)
            for what in TIMES.get(it.field, _LAST)
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

    def noted(self, batch: Batch, state: State, events: IntArray, seen: IntArray) -> IntArray:
        """Return what is known of labels once some events have matched a state."""
        wanted = [it for it in self.columns if it[0] in state.labels]
        if not wanted:
            return seen
        found, own = seen.copy(), batch.events(state).at(events)
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
                    self._follow(batch, part, (first, last), column, what == "mirrored")
        return found

    def _follow(
        self,
        batch: Batch,
        part: str,
        ends: tuple[IntArray, IntArray],
        column: IntArray,
        mirrored: bool,
    ) -> None:
        """Add symbols, or their mirror images, to those that a label had before."""
        first, last = ends
        rows = batch.rows(part)
        named = self._parts[mirrored_part(part) if mirrored else part] << 8
        cells = MIRRORED_CELLS if mirrored else np.arange(CELL + 1)
        for behind in range(int((last - first).max(initial=-1)) + 1):
            row = first + behind
            here = np.flatnonzero(row <= last)
            here = here[~rows.passing[row[here]] | (first == last)[here]]
            codes = named | cells[rows.cell[row[here]] & CELL]
            if has_amount(part):
                codes |= about(part, rows.amount[row[here]].astype(np.int64)) << 20
            pairs, place = np.unique((column[here] + 1) << 32 | codes, return_inverse=True)
            told = [
                self._sequences.setdefault((it >> 32, it & 0xFFFFFFFF), len(self._sequences))
                for it in pairs.tolist()
            ]
            column[here] = np.array(told, np.int64)[place]

    def may_be_in_rhythm(self, beats: IntArray) -> BoolArray:
        """Tell where no two steps' lengths are too far from their shares, (R, N) → (N,)."""
        fits = np.ones(beats.shape[1], bool)
        shares = np.array(self.rhythm, object if max(self.rhythm) >> 28 else np.int64)
        for place, beat in enumerate(beats):
            for other, before in enumerate(beats[:place]):
                one, two = beat * shares[other], before * shares[place]
                near = (3 * one <= 5 * two) & (3 * two <= 5 * one)
                fits &= near.astype(bool, copy=False) | (beat < 0)
        return fits

    def in_rhythm(self, beats: IntArray) -> BoolArray:
        """Tell which steps last in the proportion that is asked for, (R, N) → (N,)."""
        whole = sum(self.rhythm)
        beats = beats.astype(object) if whole >> 28 else beats
        total = beats.sum(axis=0)
        fits: BoolArray = np.min(beats, axis=0) >= 0
        for share, beat in zip(self.rhythm, beats, strict=True):
            off = 4 * abs(beat * whole - share * total)
            fits &= np.asarray(off <= share * total, bool)
        return fits


MIRRORED_CELLS = np.array(
    [
        cell_of(MIRRORED[direction] if 0 <= direction < len(MIRRORED) else direction, level)
        for level, direction in ((it // 16 - 1, it % 16 - 1) for it in range(CELL + 1))
    ]
)


_COMPARE: dict[str, Callable[[AnyArray, Any], BoolArray]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_ROUND: dict[str, Callable[[Fraction], int]] = {"<": ceil, "<=": floor, ">": floor, ">=": ceil}
"""To which whole number others are compared in the same way as to a broken one."""

_CODES = {
    "direction": DIRECTION_CODES,
    "level": LEVEL_CODES,
    **{kind: WORD_KINDS[kind].codes for kind in AMOUNTS if kind not in ("degrees", "bend")},
}
_NO_FRAMES = Span(0, 0)


Captures = Callable[[Sequence[int]], list[Capture]]
"""Gives captures by their places in a batch."""


@dataclass(slots=True, eq=False)
class Told:
    """What is known of ways: of their labels and, at their ends, of all of them.

    Attributes
    ----------
    capture : ndarray
        (N,) int64.
    seen : ndarray
        (S, N) int64: what is noted of labels, as `Clauses.columns` says; -1: nothing.
    low, high, part, row : ndarray
        (N,) int64: the frames of the hit, and the last symbol of its first line.
    """

    capture: IntArray
    seen: IntArray
    low: IntArray
    high: IntArray
    part: IntArray
    row: IntArray

    def at(self, chosen: AnyArray) -> Told:
        """Return what is known of some of them."""
        own = (it[chosen] for it in (self.low, self.high, self.part, self.row))
        return Told(self.capture[chosen], self.seen[:, chosen], *own)


@dataclass(slots=True, eq=False)
class _Column:
    """A field of each of some ways: whole numbers of a kind, and where they are missing."""

    kind: str
    values: IntArray
    there: BoolArray


class Evaluator:
    """The clauses of a query, asked in one batch.

    Parameters
    ----------
    clauses : Clauses
        What they are.
    batch : Batch
        Where.
    captures : callable
        Gives captures by their places in the batch.
    """

    def __init__(self, clauses: Clauses, batch: Batch, captures: Captures) -> None:
        self._clauses, self._batch, self._captures = clauses, batch, captures
        self._values: dict[tuple[str, str], IntArray] = {}

    def holds(self, condition: Condition, told: Told) -> BoolArray:
        """Tell of which ways a condition is true, (N,) bool."""
        met = np.zeros(len(told.capture), bool)
        for label in self._clauses.labels[condition]:
            met |= told.seen[self._clauses.place(label)] == MET
        some = np.flatnonzero(~met)
        met[some] = self._true_of(condition, told.at(some))
        return met

    def _true_of(self, condition: Condition, told: Told) -> BoolArray:
        """Tell of which ways a condition is true of which that was not told before."""
        if isinstance(condition, Mirrors):
            first = told.seen[self._clauses.columns[condition.first, "mirrored"]]
            second = told.seen[self._clauses.columns[condition.second, "shown"]]
            mirrored: BoolArray = (first == second) & (first >= 0)
            return mirrored
        found = np.zeros(len(told.capture), bool)
        clocks, own = self._batch.clocks()
        if CLIP not in names_in([condition]):
            for number, clock in enumerate(clocks):
                here = np.flatnonzero(own[told.capture] == number)
                if len(here):
                    found[here] = self._compared(condition, told.at(here), clock, None)
            return found
        places, which = np.unique(told.capture, return_inverse=True)
        captures = self._captures(places.tolist())
        for number, (place, capture) in enumerate(zip(places.tolist(), captures, strict=True)):
            here = np.flatnonzero(which == number)
            found[here] = self._compared(condition, told.at(here), clocks[own[place]], capture)
        return found

    def _compared(
        self, condition: Comparison, told: Told, clock: Clock, capture: Capture | None
    ) -> BoolArray:
        """Compare the two sides of a condition in captures that have one clock."""
        sides = [
            [(sign, self._term(term, told, clock, capture)) for sign, term in side.terms]
            for side in (condition.left, condition.right)
        ]
        columns = [it for side in sides for _, it in side if isinstance(it, _Column)]
        there: BoolArray = np.all([it.there for it in columns], axis=0)
        (kind,) = {it.kind for it in columns}  # the language compares like with like alone
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
                    return there if other else ~there & there
                constant -= side * sign * number * scale
        return there & _at_threshold(condition.compare, total, constant)

    def _same(
        self, compare: str, sides: list[list[tuple[int, _Column | Value]]], kind: str
    ) -> BoolArray:
        """Compare words, all of one kind."""
        told: list[IntArray | int] = []
        for ((_, value),) in sides:
            if isinstance(value, _Column):
                told.append(value.values)
            elif value is None:
                return np.zeros(1, bool)
            else:
                codes = _CODES.get(kind) or {
                    it: self._clauses.code(it) for it in self._clauses.parts()
                }
                told.append(codes.get(str(value), -1))
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
            case Text():
                return term.text
        return term.value

    def _column(self, field: Reference, told: Told) -> _Column:
        """Return a field of a label, or of all that matched."""
        whole = field.name == MATCH
        columns = self._clauses.columns
        if field.field in TIMES:
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
        for code, name in enumerate(self._clauses.parts()):
            here = (part == code) & (row >= 0)
            if here.any():
                values[here] = self._of_rows(name, field.field)[row[here]]
        kind = "direction" if field.field == "else" else field.field
        kind = kind if kind in _CODES else "thousandths"
        return _Column(kind, values, values >= 0)

    def _of_rows(self, part: str, field: str) -> IntArray:
        """Return a field of each row of a part."""
        if (part, field) not in self._values:
            rows = self._batch.rows(part)
            cell = rows.cell.astype(np.int64)
            if field == "swings":
                told = THOUSANDTHS * rows.measure(field).astype(np.int64)
            elif field in MEASURES:
                told = rows.measure(field).astype(np.int64) - 1
                told[told >= 0] *= THOUSANDTHS // FIELDS[field].scale
            elif field in AMOUNTS:
                told = rows.amount.astype(np.int64)
                none = told < 0
                if field == "bend":
                    told = degree_of(told)
                told *= 1 if field in _CODES else THOUSANDTHS
                told[none | (field not in KINDS[kind_of(part)].words)] = -1
            else:
                told = {
                    "direction": (cell & 15) - 1,
                    "level": ((cell & CELL) >> 4) - 1,
                    "else": (rows.runner.astype(np.int64) & 15) - 1,
                    "margin": THOUSANDTHS - rows.cost.astype(np.int64),
                }[field]
            self._values[part, field] = told
        return self._values[part, field]


def _at_threshold(compare: str, total: IntArray, constant: Fraction) -> BoolArray:
    """Compare whole numbers with a broken one, exactly."""
    if compare in _ROUND:
        threshold = max(-FAR, min(FAR, _ROUND[compare](constant)))
        return _COMPARE[compare](total, threshold)
    same: BoolArray = (total == constant.numerator) & (constant.denominator == 1)
    return ~same if compare == "!=" else same
