"""Whether the conditions of a ``where`` hold of a hit.

Times are exact. What is missing (a label on a step that was left out, a column that a capture does
not have, a direction that a symbol lacks) makes every condition on it false.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import (
    DIRECTION_CODES,
    DIRECTIONS,
    KINDS,
    LEVELS,
    MIRRORED,
    kind_of,
    mirrored_part,
)
from lanindex.model import Hit, Symbol
from lanindex.search.fields import Value, value_of
from lanindex.search.language.clauses import Condition, Mirrors, Reference, Sum, Term, Text
from lanindex.search.language.times import Clock, Time

_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
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


def names_in(conditions: Iterable[Condition]) -> frozenset[str]:
    """Return the names that conditions speak of: labels, ``clip`` and ``match``."""
    names: set[str] = set()
    for condition in conditions:
        if isinstance(condition, Mirrors):
            names |= {condition.first, condition.second}
        else:
            terms = [*condition.left.terms, *condition.right.terms]
            names |= {term.name for _, term in terms if isinstance(term, Reference)}
    return frozenset(names)


def holds(condition: Condition, hit: Hit) -> bool:
    """Tell whether a condition is true of a hit with its labels.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.search.conditions import holds
    >>> from lanindex.search.language import parse
    >>> (condition,) = parse("torso any where match.length >= 4s").where
    >>> with lanindex.open_library("dance.db") as library:
    ...     [holds(condition, hit) for hit in library.search("torso forward high -> hold 1s+")]
    [True]
    """
    if isinstance(condition, Mirrors):
        one, other = (hit.labels.get(name, ()) for name in (condition.first, condition.second))
        return 0 < len(one) == len(other) and all(map(_mirrors, one, other))
    left, right = _sum(condition.left, hit), _sum(condition.right, hit)
    if left is None or right is None:
        return False
    if isinstance(left, Fraction) != isinstance(right, Fraction):
        left, right = number_of(left), number_of(right)
        if left is None or right is None:  # a word is no number
            return condition.compare == "!="
    if left in LEVELS and right in LEVELS:  # by height, not by letter
        left, right = (Fraction(LEVELS.index(str(side))) for side in (left, right))
    return _COMPARE[condition.compare](left, right)


def _sum(said: Sum, hit: Hit) -> Value:
    values = [_term(term, hit) for _, term in said.terms]
    if len(values) == 1:
        return values[0]
    total = Fraction(0)
    for (sign, _), value in zip(said.terms, map(number_of, values), strict=True):
        if value is None:
            return None
        total += sign * value
    return total


def _term(term: Term, hit: Hit) -> Value:
    match term:
        case Reference():
            return value_of(term, hit)
        case Time():
            rate = hit.capture.rate
            return term.frames(Clock(rate, hit.capture.meter.speed / 60)) / rate
    return term.text if isinstance(term, Text) else term.value


def number_of(value: Value) -> Fraction | None:
    """Return a number, also where it is written as text."""
    try:
        return None if value is None else Fraction(value)
    except (ValueError, ZeroDivisionError):
        return None


def _mirrors(one: Symbol, other: Symbol) -> bool:
    """Tell whether a symbol is the mirror image of another."""
    direction = one.direction and DIRECTIONS[MIRRORED[DIRECTION_CODES[one.direction]]]
    amounts = [about(it.part, -1 if it.amount is None else it.amount) for it in (one, other)]
    image = mirrored_part(one.part), direction, one.level, amounts[0]
    return image == (other.part, other.direction, other.level, amounts[1])


def about(part: str, amount: Amount) -> Amount:
    """Return amounts as closely as mirror images agree in them: of a turn to the nearest eighth.

    How far a limb is bent that points somewhere does not count.
    """
    kind = KINDS[kind_of(part)]
    if "amount" not in kind.fields:
        return amount * 0
    return amount if kind.amounts else (amount + _EIGHTH // 2) // _EIGHTH
