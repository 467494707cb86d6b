"""What the conditions of a ``where`` compare, and whether a capture meets one on it alone.

Times are exact. What is missing (a label on a step that was left out, a column that a capture does
not have, a direction that a symbol lacks) makes every condition on it false.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Collection
from fractions import Fraction
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import KINDS, LEVELS, kind_of
from lanindex.model import Capture, Span
from lanindex.search.fields import Value, value_of_span
from lanindex.search.language.clauses import (
    Comparison,
    Condition,
    Mirrors,
    Reference,
    Sum,
    Term,
    references_in,
)
from lanindex.search.language.times import Clock, Time

COMPARE: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": operator.eq,
    "!=": operator.ne,
}

_EIGHTH = 45
"""Degrees of an eighth of a turn."""

Amount = TypeVar("Amount", int, NDArray[np.int64])


def names_in(conditions: Collection[Condition]) -> frozenset[str]:
    """Return the names that conditions speak of: labels, ``clip`` and ``match``."""
    mirrored = [it for it in conditions if isinstance(it, Mirrors)]
    labels = {name for it in mirrored for name in (it.first, it.second)}
    return frozenset(labels | {it.name for it in references_in(conditions)})


def meets(capture: Capture, condition: Comparison) -> bool:
    """Tell whether a capture is as a condition on it alone demands.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.search.conditions import meets
    >>> from lanindex.search.language import parse
    >>> (condition,) = parse("torso any where clip.seconds < 3600").where
    >>> with lanindex.open_library("dance.db") as library:
    ...     meets(library.capture("compass.bvh"), condition)
    True
    """
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


def _sum(said: Sum, capture: Capture) -> Value:
    clock = Clock(capture.rate, capture.meter.speed / 60)
    values = [constant(term, clock, capture) for _, term in said.terms]
    if len(values) == 1:
        return values[0]
    total = Fraction(0)
    for (sign, _), value in zip(said.terms, map(number_of, values), strict=True):
        if value is None:
            return None
        total += sign * value
    return total


def constant(term: Term, clock: Clock, capture: Capture | None) -> Value:
    """Return what a term is that speaks of no label: a field of the capture, a time, a word."""
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
    """Return amounts as closely as mirror images agree in them: of a turn to the nearest eighth.

    How far a limb is bent that points somewhere does not count.
    """
    kind = KINDS[kind_of(part)]
    if "amount" not in kind.fields:
        return amount * 0
    return amount if kind.amounts else (amount + _EIGHTH // 2) // _EIGHTH
