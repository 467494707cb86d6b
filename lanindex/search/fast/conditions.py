"""Which conditions of a ``where`` hold of many ways at once, exactly."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor
from typing import Any, Protocol

import numpy as np

from lanindex.alphabet import DIRECTION_CODES, KINDS, LEVEL_CODES, MEASURES, kind_of
from lanindex.model import Capture, Span
from lanindex.model.bends import degree_of
from lanindex.model.columns import CELL, THOUSANDTHS
from lanindex.model.symbol import FIELDS
from lanindex.search.conditions import names_in, number_of
from lanindex.search.fast.asked import MET, TIMES, Asked
from lanindex.search.fast.block import Block
from lanindex.search.fast.ragged import FAR, Mask, Numbers, Whole
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
)
from lanindex.search.language.times import Clock, Time
from lanindex.search.language.words import AMOUNTS, WORD_KINDS

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

_CODES = {
    "direction": DIRECTION_CODES,
    "level": LEVEL_CODES,
    **{kind: WORD_KINDS[kind].codes for kind in AMOUNTS if kind not in ("degrees", "bend")},
}
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
        """Tell of which ways a condition is true of which that was not told before."""
        if isinstance(condition, Mirrors):
            first = told.seen[self._asked.columns[condition.first, "mirrored"]]
            second = told.seen[self._asked.columns[condition.second, "shown"]]
            mirrored: Mask = (first == second) & (first >= 0)
            return mirrored
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
        there: Mask = np.all([it.there for it in columns], axis=0)
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
        columns = self._asked.columns
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
        for code, name in enumerate(self._asked.parts()):
            here = (part == code) & (row >= 0)
            if here.any():
                values[here] = self._of_rows(name, field.field)[row[here]]
        kind = "direction" if field.field == "else" else field.field
        kind = kind if kind in _CODES else "thousandths"
        return _Column(kind, values, values >= 0)

    def _of_rows(self, part: str, field: str) -> Whole:
        """Return a field of each row of a part."""
        if (part, field) not in self._values:
            rows = self._block.rows(part)
            cell = rows.cell.astype(np.int64)
            if field == "swings":
                told = THOUSANDTHS * self._source.swings(part)
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


def _at_threshold(compare: str, total: Whole, constant: Fraction) -> Mask:
    """Compare whole numbers with a broken one, exactly."""
    if compare in _ROUND:
        threshold = max(-FAR, min(FAR, _ROUND[compare](constant)))
        return _COMPARE[compare](total, threshold)
    same: Mask = (total == constant.numerator) & (constant.denominator == 1)
    return ~same if compare == "!=" else same
