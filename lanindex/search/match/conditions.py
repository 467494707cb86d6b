"""Conditions and rhythm, evaluated for many matches at once.

Of each label matches note as much as conditions need: where it begins and ends, its last symbol,
or the sequence of its symbols.
"""

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import count
from math import ceil, floor, lcm
from typing import NamedTuple

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
from lanindex.model import Capture
from lanindex.model.columns import CELL, THOUSANDTHS, cell_of, has_amount
from lanindex.model.derived import degree_of
from lanindex.model.symbol import FIELDS
from lanindex.search.hits import COMPARE, Value, about, constant, names_in, number_of
from lanindex.search.language.clauses import (
    CLIP,
    MATCH,
    Comparison,
    Condition,
    Mirrors,
    Reference,
    Term,
)
from lanindex.search.language.query import Query, nodes_in
from lanindex.search.language.times import Clock
from lanindex.search.language.words import AMOUNTS, WORD_KINDS
from lanindex.search.match.arrays import FAR, BoolArray, IntArray, Table, once
from lanindex.search.match.batch import Batch
from lanindex.search.plan import State

MET = FAR  # noted of a label instead, once all its conditions are met: matches may be alike then

TIMES = {"start": ("start",), "end": ("end",), "length": ("start", "end")}
_LAST = ("part", "row")
"""What is noted of a label, by the field that a condition needs; for any other the last symbol."""


class Clauses:
    """The conditions and the rhythm of a query, and what matches have to note for them."""

    def __init__(self, query: Query) -> None:
        names = {it: names_in([it]) - {CLIP} for it in query.where}
        # conditions on the capture alone, and the others with their labels
        self.of_capture = tuple(
            it for it in query.where if isinstance(it, Comparison) and not names[it]
        )
        self.conditions = tuple(dict.fromkeys(it for it in query.where if names[it]))
        self.labels = {it: names[it] - {MATCH} for it in self.conditions}
        # conditions on all that matched, and whether any needs its frames
        self.of_all = frozenset(it for it in self.conditions if MATCH in names[it])
        fields = set(nodes_in(self.conditions, Reference))
        frames = {it for it in fields if it.name == MATCH and it.field in TIMES}
        self.of_frames = bool(frames)
        # those that the last symbol of the first line decides
        self.of_last = tuple(
            it
            for it in self.conditions
            if isinstance(it, Comparison)
            and names[it] == {MATCH}
            and not frames & set(nodes_in((it,), Reference))
        )
        noted = {
            (it.name, what)
            for it in fields
            if it.name not in (CLIP, MATCH)
            for what in TIMES.get(it.field, _LAST)
        }
        for it in self.conditions:
            if isinstance(it, Mirrors):
                noted |= {(it.first, "mirrored"), (it.second, "shown")}
        # label and what is noted of it → its column
        self.columns = {it: place for place, it in enumerate(sorted(noted))}
        parts = query.parts | {mirrored_part(part) for part in query.parts}
        self.codes = {part: code for code, part in enumerate(sorted(parts))}
        # numbered at once, since hits may be looked at in several threads
        self._sequences = defaultdict[tuple[int, int], int](count().__next__)
        several = lcm(*(share.denominator for share in query.rhythm))
        self.rhythm = [int(share * several) for share in query.rhythm]

    def __bool__(self) -> bool:
        """Return whether matches have to remember anything."""
        return bool(self.conditions or self.rhythm)

    @property
    def width(self) -> int:
        """How many notes each match has."""
        return len(self.columns)

    def place(self, label: str) -> int:
        """Return the first column of a label."""
        return min(place for (name, _), place in self.columns.items() if name == label)

    def noted(self, batch: Batch, state: State, events: IntArray, notes: IntArray) -> IntArray:
        """Return the notes of labels (S, N) once some events (N,) have matched a state."""
        wanted = [it for it in self.columns if it[0] in state.labels]
        if not wanted:
            return notes
        found, own = notes.copy(), batch.events(state).at(events)
        for label, what in wanted:
            column = found[self.columns[label, what]]
            if what == "start":
                column[:] = np.where(column < 0, own.start, np.minimum(column, own.start))
            elif what == "end":
                column[:] = np.maximum(column, own.end)
            elif what == "part":
                column[:] = self.codes[state.members[-1]]
            elif what == "row":
                column[:] = own.last[-1]
            else:
                for part, first, last in zip(state.members, own.first, own.last, strict=True):
                    self._follow(batch, part, first, last, column, what == "mirrored")
        return found

    def _follow(
        self,
        batch: Batch,
        part: str,
        first: IntArray,
        last: IntArray,
        column: IntArray,
        mirrored: bool,
    ) -> None:
        """Add symbols, or their mirror images, to the sequences (N,) that a label had before."""
        rows = batch.rows(part)
        named = self.codes[mirrored_part(part) if mirrored else part] << 8
        cells = MIRRORED_CELLS if mirrored else np.arange(CELL + 1)
        for behind in range(int((last - first).max(initial=-1)) + 1):
            row = first + behind
            here = np.flatnonzero(row <= last)
            here = here[~rows.passing[row[here]] | (first == last)[here]]
            codes = named | cells[rows.cell[row[here]] & CELL]
            if has_amount(part):
                codes |= about(part, rows.amount[row[here]].astype(np.int64)) << 20
            pairs, place = np.unique((column[here] + 1) << 32 | codes, return_inverse=True)
            longer = [self._sequences[it >> 32, it & 0xFFFFFFFF] for it in pairs.tolist()]
            column[here] = np.array(longer, np.int64)[place]

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
        """Tell which steps last in the proportion of the rhythm, (R, N) → (N,)."""
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


_ROUND: dict[str, Callable[[Fraction], int]] = {"<": ceil, "<=": floor, ">": floor, ">=": ceil}
"""To which whole number others are compared in the same way as to a broken one."""

_CODES = {
    "direction": DIRECTION_CODES,
    "level": LEVEL_CODES,
    **{kind: WORD_KINDS[kind].codes for kind in AMOUNTS if kind not in ("degrees", "bend")},
}

Captures = Callable[[Sequence[int]], list[Capture]]
"""Gives captures by their places in a batch."""


@dataclass(slots=True, eq=False)
class Facts(Table):
    """What conditions need of matches."""

    capture: IntArray  # (N,)
    notes: IntArray  # (S, N) notes of labels, as `Clauses.columns` says; -1: nothing
    low: IntArray  # (N,) frames of the hit
    high: IntArray
    part: IntArray  # (N,) the last symbol of the first line
    row: IntArray


class _Column(NamedTuple):
    """A field of matches: whole numbers of a kind, and where they are known, (N,) each."""

    kind: str
    values: IntArray
    known: BoolArray


class Evaluator:
    """Evaluates the conditions of a query in one batch."""

    def __init__(self, clauses: Clauses, batch: Batch, captures: Captures) -> None:
        self._clauses, self._batch, self._captures = clauses, batch, captures
        self._values: dict[tuple[str, str], IntArray] = {}

    def holds(self, condition: Condition, facts: Facts) -> BoolArray:
        """Tell for which matches a condition is true, (N,) bool."""
        met = np.zeros(len(facts.capture), bool)
        for label in self._clauses.labels[condition]:
            met |= facts.notes[self._clauses.place(label)] == MET
        some = np.flatnonzero(~met)
        met[some] = self._true_of(condition, facts.at(some))
        return met

    def _true_of(self, condition: Condition, facts: Facts) -> BoolArray:
        """Tell for which matches a condition is true, evaluating it for all of them."""
        columns, found = self._clauses.columns, np.zeros(len(facts.capture), bool)
        if isinstance(condition, Mirrors):
            first = facts.notes[columns[condition.first, "mirrored"]]
            second = facts.notes[columns[condition.second, "shown"]]
            found |= (first == second) & (first >= 0)
            return found
        clocks, own = self._batch.clocks()
        of_clip = CLIP in names_in([condition])
        groups = facts.capture if of_clip else own[facts.capture]
        numbers = once(groups).tolist()
        captures = self._captures(numbers) if of_clip else [None] * len(numbers)
        for number, capture in zip(numbers, captures, strict=True):
            here = np.flatnonzero(groups == number)
            clock = clocks[own[number] if of_clip else number]
            found[here] = self._compare(condition, facts.at(here), clock, capture)
        return found

    def _compare(
        self, condition: Comparison, facts: Facts, clock: Clock, capture: Capture | None
    ) -> BoolArray:
        """Compare the two sides of a condition in captures that have one clock."""

        def value_of(term: Term) -> _Column | Value:
            if isinstance(term, Reference) and term.name != CLIP:
                return self._column(term, facts)
            return constant(term, clock, capture)

        sides = [
            [(sign, value_of(term)) for sign, term in side.terms]
            for side in (condition.left, condition.right)
        ]
        terms = [it for side in sides for _, it in side]
        columns = [it for it in terms if isinstance(it, _Column)]
        there: BoolArray = np.all([it.known for it in columns], axis=0)
        nowhere = np.zeros(len(there), bool)
        if None in terms:
            return nowhere
        (kind,) = {it.kind for it in columns}  # the language compares like with like alone
        if kind not in ("frames", "thousandths"):
            codes = self._clauses.codes if kind == "part" else _CODES[kind]
            left, right = (
                it.values if isinstance(it, _Column) else codes.get(str(it), -1) for it in terms
            )
            there &= COMPARE[condition.compare](left, right)
            return there
        scale = clock.rate if kind == "frames" else Fraction(THOUSANDTHS)
        total, rest = np.zeros(len(there), np.int64), Fraction(0)
        for side, signed in zip((1, -1), sides, strict=True):
            for sign, value in signed:
                if isinstance(value, _Column):
                    total += side * sign * value.values
                    continue
                number = number_of(value)
                if number is None:  # a word is no number; in a sum nothing can be made of it
                    return there if len(signed) == 1 and condition.compare == "!=" else nowhere
                rest -= side * sign * number * scale
        return there & _at_threshold(condition.compare, total, rest)

    def _column(self, field: Reference, facts: Facts) -> _Column:
        """Return a field of a label, or of all that matched."""
        if field.name == MATCH:
            noted = {"start": facts.low, "end": facts.high, "part": facts.part, "row": facts.row}
        else:
            columns = self._clauses.columns
            noted = {
                it: facts.notes[at] for (name, it), at in columns.items() if name == field.name
            }
        if field.field in TIMES:
            times = [noted[it] for it in TIMES[field.field]]
            values = times[1] - times[0] if len(times) > 1 else times[0]
            return _Column("frames", values, np.all([it >= 0 for it in times], axis=0))
        part, row = noted["part"], noted["row"]
        if field.field == "part":
            return _Column("part", part, row >= 0)
        values = np.full(len(row), -1)
        for name, code in self._clauses.codes.items():
            here = (part == code) & (row >= 0)
            if here.any():
                values[here] = self._of_rows(name, field.field)[row[here]]
        kind = "direction" if field.field == "else" else field.field
        kind = kind if kind in _CODES else "thousandths"
        return _Column(kind, values, values >= 0)

    def _of_rows(self, part: str, field: str) -> IntArray:
        """Return a field of each row of a part, (rows,) codes or thousandths; -1: not known."""
        if (part, field) not in self._values:
            rows = self._batch.rows(part)
            cell = rows.cell.astype(np.int64)
            if field == "swings":
                values = THOUSANDTHS * rows.measure(field).astype(np.int64)
            elif field in MEASURES:
                values = rows.measure(field).astype(np.int64) - 1
                values[values >= 0] *= THOUSANDTHS // FIELDS[field].scale
            elif field in AMOUNTS:
                values = rows.amount.astype(np.int64)
                none = (values < 0) | (field not in KINDS[kind_of(part)].words)
                if field == "bend":
                    values = degree_of(values)
                values *= 1 if field in _CODES else THOUSANDTHS
                values[none] = -1
            else:
                values = {
                    "direction": (cell & 15) - 1,
                    "level": ((cell & CELL) >> 4) - 1,
                    "else": (rows.runner.astype(np.int64) & 15) - 1,
                    "margin": THOUSANDTHS - rows.cost.astype(np.int64),
                }[field]
            self._values[part, field] = values
        return self._values[part, field]


def _at_threshold(compare: str, total: IntArray, constant: Fraction) -> BoolArray:
    """Compare whole numbers with a broken one, exactly."""
    found: BoolArray = (total == constant.numerator) & (constant.denominator == 1)
    if compare == "!=":
        found = ~found
    elif compare in _ROUND:
        found = COMPARE[compare](total, max(-FAR, min(FAR, _ROUND[compare](constant))))
    return found
