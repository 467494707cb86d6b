"""What a hit says of its labels, of its clip and of itself, and whether a condition holds.

Times are exact: frames become seconds as fractions. What is missing (a label on a step that was
left out, a column that a capture does not have, a direction that a symbol lacks) makes every
condition on it false.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from lanindex.alphabet import DIRECTION_CODES, DIRECTIONS, LEVELS, MIRRORED, mirrored_part
from lanindex.model import Capture, Hit, Span, Symbol
from lanindex.search.language.clauses import (
    CLIP,
    MATCH,
    Comparison,
    Condition,
    Mirrors,
    Number,
    Reference,
    Sum,
    Term,
    Text,
    Value,
)
from lanindex.search.language.times import Clock

Found = Fraction | str
"""A number, seconds, or words."""

_CLIP: dict[str, Callable[[Capture], Found]] = {
    "path": lambda capture: capture.path,
    "format": lambda capture: capture.format,
    "label": lambda capture: capture.label,
    "sha256": lambda capture: capture.sha256,
    "fps": lambda capture: capture.rate,
    "frames": lambda capture: Fraction(capture.frames),
    "tempo": lambda capture: capture.meter.speed,
}
"""What every capture has; all else is a column of its own metadata."""


@dataclass(frozen=True, slots=True)
class _Named:
    """What a name stands for: its frames, and the last of its symbols."""

    span: Span
    last: Symbol


_FRAMES: dict[str, Callable[[Span], int]] = {
    "start": lambda span: span.start,
    "end": lambda span: span.stop,
    "length": len,
}

_LAST: dict[str, Callable[[Symbol], Found | None]] = {
    "part": lambda symbol: symbol.part,
    "direction": lambda symbol: symbol.direction,
    "level": lambda symbol: symbol.level,
    "swings": lambda symbol: Fraction(symbol.swings),
    "margin": lambda symbol: Fraction(round(symbol.margin * 1000), 1000),
}
"""What is told by the last of several symbols; margins are kept in thousandths."""


def value_of(reference: Reference, hit: Hit) -> Found | None:
    """Return what a field of a label, of ``match`` or of ``clip`` is in a hit.

    Parameters
    ----------
    reference : Reference
        ``a.start``, ``match.length``, ``clip.label``.
    hit : Hit
        With its labels. ``match`` is all of it: its frames, and the last symbol of its first line.

    Returns
    -------
    Fraction or str or None
        Seconds, a number or words; None where it is missing.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.search.conditions import value_of
    >>> from lanindex.search.language.clauses import Reference
    >>> with lanindex.open_library("dance.db") as library:
    ...     hit = library.search("torso forward high -> hold 1s+")[0]
    >>> value_of(Reference("match", "length"), hit), value_of(Reference("clip", "label"), hit)
    (Fraction(4, 1), 'greeting')
    """
    if reference.name == CLIP:
        return _of_clip(reference.field, hit.capture)
    named = _named(reference.name, hit)
    if named is None:
        return None
    if reference.field in _FRAMES:
        return Fraction(_FRAMES[reference.field](named.span)) / hit.capture.rate
    return _LAST[reference.field](named.last)


def order_of(reference: Reference, hit: Hit) -> tuple[int, Fraction, str]:
    """Return by what hits are sorted: numbers and levels by size, texts by letter, none last."""
    value = value_of(reference, hit)
    if value is None:
        return 2, Fraction(0), ""
    if reference.field == "level" and reference.name != CLIP:
        return 0, Fraction(LEVELS.index(str(value))), ""
    return (1, Fraction(0), value) if isinstance(value, str) else (0, value, "")


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
    """Tell whether a condition is true of a hit.

    Parameters
    ----------
    condition : Comparison or Mirrors
        Of a ``where``.
    hit : Hit
        With its labels.
    """
    if isinstance(condition, Mirrors):
        return _mirrors(hit.labels.get(condition.first), hit.labels.get(condition.second))
    return _compares(condition, hit)


def _of_clip(field: str, capture: Capture) -> Found | None:
    found = _CLIP[field](capture) if field in _CLIP else capture.metadata.get(field)
    return None if found == "" else found


def _named(name: str, hit: Hit) -> _Named | None:
    if name == MATCH:
        return _Named(hit.span, hit.lines[0][-1])
    symbols = hit.labels.get(name)
    if not symbols:
        return None
    span = Span(min(it.start for it in symbols), max(it.stop for it in symbols))
    return _Named(span, symbols[-1])


# Comparisons.

_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": operator.eq,
    "!=": operator.ne,
}


def _compares(condition: Comparison, hit: Hit) -> bool:
    left, right = _sum(condition.left, hit), _sum(condition.right, hit)
    if isinstance(left, Fraction) != isinstance(right, Fraction):
        left, right = _number(left), _number(right)
    if left is None or right is None:
        return False
    if left in LEVELS and right in LEVELS:  # by height, not by letter
        left, right = (Fraction(LEVELS.index(str(side))) for side in (left, right))
    return _COMPARE[condition.compare](left, right)


def _sum(said: Sum, hit: Hit) -> Found | None:
    values = [_term(term, hit) for _, term in said.terms]
    if len(values) == 1:
        return values[0]
    total = Fraction(0)
    for (sign, _), value in zip(said.terms, map(_number, values), strict=True):
        if value is None:
            return None
        total += sign * value
    return total


def _term(term: Term, hit: Hit) -> Found | None:
    match term:
        case Reference():
            return value_of(term, hit)
        case Number():
            return term.value
        case Text():
            return term.text
        case Value():
            return term.value
    rate = hit.capture.rate
    return term.frames(Clock(rate, hit.capture.meter.speed / 60)) / rate


def _number(value: Found | None) -> Fraction | None:
    """Return a number, also where it is written in a column of text."""
    try:
        return None if value is None else Fraction(value)
    except (ValueError, ZeroDivisionError):
        return None


def _mirrors(first: tuple[Symbol, ...] | None, second: tuple[Symbol, ...] | None) -> bool:
    """Tell whether symbols are the mirror image of others, one by one."""
    if not first or not second or len(first) != len(second):
        return False
    return all(
        _in_the_mirror(it) == (other.part, other.direction, other.level)
        for it, other in zip(first, second, strict=True)
    )


def _in_the_mirror(symbol: Symbol) -> tuple[str, str | None, str | None]:
    direction = symbol.direction
    if direction is not None:
        direction = DIRECTIONS[MIRRORED[DIRECTION_CODES[direction]]]
    return mirrored_part(symbol.part), direction, symbol.level
