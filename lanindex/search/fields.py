"""Fields of hits and captures, which ``where`` compares and a pipe sorts and counts by."""

from __future__ import annotations

import operator
from collections.abc import Callable, Collection
from fractions import Fraction
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import KINDS, LEVEL_CODES, LEVELS, MEASURES, kind_of
from lanindex.model import Capture, Hit, Span, Symbol
from lanindex.model.columns import GRADES
from lanindex.model.derived import degree_of
from lanindex.search.language.clauses import (
    CLIP,
    MATCH,
    Comparison,
    Condition,
    Mirrors,
    Reference,
    Sum,
    Term,
    references_in,
)
from lanindex.search.language.query import Query, steps_of
from lanindex.search.language.times import Clock, Time
from lanindex.search.language.words import AMOUNTS

Value = str | Fraction | None  # times in seconds; no condition holds of a missing value

COMPARE: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": operator.eq,
    "!=": operator.ne,
}

_CLIP: dict[str, Callable[[Capture], str | Fraction]] = {
    **{name: attrgetter(name) for name in ("path", "label", "format", "sha256")},
    "fps": lambda capture: capture.rate,
    "frames": lambda capture: Fraction(capture.frames),
    "seconds": lambda capture: capture.frames / capture.rate,
    "tempo": lambda capture: capture.meter.speed,
}

CLIP_FIELDS = tuple(_CLIP)
"""Fields of every capture; its other columns have the names that the user gave."""

_TIMES = ("start", "end", "length")
_EIGHTH = 45  # degrees of an eighth of a turn

Amount = TypeVar("Amount", int, NDArray[np.int64])


def names_in(conditions: Collection[Condition]) -> frozenset[str]:
    """Return the names that conditions speak of: labels, ``clip`` and ``match``."""
    mirrored = ((it.first, it.second) for it in conditions if isinstance(it, Mirrors))
    return frozenset().union(*mirrored, (it.name for it in references_in(conditions)))


def measures_in(query: Query) -> frozenset[str]:
    """Return the measures of symbols that the words and conditions of a query need."""
    kinds = {word.kind for step in steps_of(query.pattern) for word in step.words}
    fields = {it.field for it in references_in(query.where) if it.name != CLIP}
    return frozenset(fields.intersection(MEASURES)).union(
        name for kind, name in GRADES.items() if kind in kinds
    )


def extras_in(query: Query) -> frozenset[str]:
    """Return the columns that a search reads besides those that every search does."""
    fields = {it.field for it in references_in(query.where)}
    return measures_in(query) | fields.intersection(("swings",))


def value_of(reference: Reference, hit: Hit) -> Value:
    """Return a field of a hit, None where it is missing; times are seconds from its start."""
    if is_of_span(reference):
        return value_of_span(reference, hit.capture, hit.span)
    symbols = hit.lines[0] if reference.name == MATCH else hit.labels.get(reference.name, ())
    if not symbols:
        return None
    if reference.field not in _TIMES:
        return _of_symbol(symbols[-1], reference.field)
    span = Span(min(it.start for it in symbols), max(it.stop for it in symbols))
    return value_of_span(Reference(MATCH, reference.field), hit.capture, span)


def is_of_span(reference: Reference) -> bool:
    """Return whether capture and frames of a hit are all that a field needs."""
    return reference.name == CLIP or (reference.name == MATCH and reference.field in _TIMES)


def value_of_span(reference: Reference, capture: Capture, span: Span) -> Value:
    """Return a field that needs only capture and frames of a hit, see `is_of_span`."""
    field = reference.field
    if reference.name != CLIP:
        frames = {"start": span.start, "end": span.stop, "length": span.stop - span.start}
        return frames[field] / capture.rate
    if field in _CLIP:
        value = _CLIP[field](capture)
        return None if value == "" else value
    # people write the name of a column of theirs in small letters or capitals
    return next((it for name, it in capture.metadata.items() if name.lower() == field), "") or None


def _of_symbol(symbol: Symbol, field: str) -> Value:
    if field in AMOUNTS:
        kind = KINDS[kind_of(symbol.part)]
        if field not in kind.words or symbol.amount is None:
            return None
        if field == "bend":
            return Fraction(degree_of(symbol.amount))
        return kind.amount(symbol.amount) if kind.amounts else Fraction(symbol.amount)
    value = symbol.runner_direction if field == "else" else getattr(symbol, field)
    return Fraction(round(value * 1000), 1000) if isinstance(value, float | int) else value


def order(reference: Reference, value: Value) -> tuple[bool, bool, str | Fraction | int]:
    """Return a key that sorts values of a field: numbers, then texts by letter, then None."""
    if not isinstance(value, str):
        return value is None, False, value or 0
    if reference.name != CLIP and reference.field == "level":
        return False, False, LEVEL_CODES[value]
    digits = value.strip().removeprefix("-").replace(".", "", 1)
    if digits.isascii() and digits.isdecimal() and len(digits) < 100:
        return False, False, Fraction(value.strip())
    return False, True, value


def meets(capture: Capture, condition: Comparison) -> bool:
    """Return whether a capture meets a condition on it alone."""
    left, right = (_sum(side, capture) for side in (condition.left, condition.right))
    if left is None or right is None:
        return False
    if isinstance(left, Fraction) != isinstance(right, Fraction):
        left, right = number_of(left), number_of(right)
        if left is None or right is None:  # a word is no number
            return condition.compare == "!="
    if left in LEVELS and right in LEVELS:  # by height, not by letter
        left, right = (Fraction(LEVELS.index(str(side))) for side in (left, right))
    return bool(COMPARE[condition.compare](left, right))


def _sum(side: Sum, capture: Capture) -> Value:
    clock = Clock(capture.rate, capture.meter.speed / 60)
    values = [constant(term, clock, capture) for _, term in side.terms]
    if len(values) == 1:
        return values[0]
    total = Fraction(0)
    for (sign, _), value in zip(side.terms, map(number_of, values), strict=True):
        if value is None:
            return None
        total += sign * value
    return total


def constant(term: Term, clock: Clock, capture: Capture | None) -> Value:
    """Return the value of a term without a label: a field of the capture, a time, a word."""
    match term:
        case Reference():
            assert capture
            return value_of_span(term, capture, Span(0, 0))
        case Time():
            return term.frames(clock) / clock.rate
    return term.value


def number_of(value: Value) -> Fraction | None:
    """Return a number, also where it is written as text."""
    try:
        return None if value is None else Fraction(value)
    except (ValueError, ZeroDivisionError):
        return None


def about(part: str, amount: Amount) -> Amount:
    """Return amounts as mirror images compare them: turns in eighths, bends of a gesture as 0."""
    kind = KINDS[kind_of(part)]
    if "amount" not in kind.fields:
        return amount * 0
    return amount if kind.amounts else (amount + _EIGHTH // 2) // _EIGHTH
