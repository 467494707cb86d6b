"""What stands behind a pattern in plain English: rhythm, conditions, and the pipe."""

from __future__ import annotations

from collections.abc import Iterator

from lanindex.search.language.clauses import (
    CLIP,
    MATCH,
    Condition,
    Count,
    First,
    Mirrors,
    Reference,
    Sort,
    Stage,
    Sum,
)
from lanindex.search.language.query import Query
from lanindex.search.language.times import Time, decimal

_UNITS = {"s": "s", "ms": "ms", "f": "frames", "b": "beats"}
_COMPARED = {
    "=": "is",
    "!=": "is not",
    "<": "is less than",
    "<=": "is at most",
    ">": "is more than",
    ">=": "is at least",
}
_FIELDS = {
    **{"swings": "number of swings", "degrees": "angle"},
    "else": "direction across the nearest border",
    **{"feet": "kind of jump", "bend": "degree of bending"},
}
_FIELDS |= {"speed": "highest speed (in its lengths a second)", "size": "size (in degrees)"}
_FIELDS |= {"touched": "thing touched"}
_OWNERS = {CLIP: "the clip's", MATCH: "the hit's"}


def endings(query: Query) -> Iterator[str]:
    """Yield a sentence for each of what stands behind the pattern."""
    if query.either_side:
        yield "Or the mirror image of all this."
    if query.rhythm:
        proportion = " : ".join(map(decimal, query.rhythm))
        yield f"Its steps last in proportion {proportion}, give or take a quarter."
    if query.where:
        yield f"And so that {' and '.join(map(_condition, query.where))}."
    yield from map(_stage, query.stages)


def time(length: Time) -> str:
    """Return a length of time as a person writes it."""
    number, unit = decimal(length.number), _UNITS[length.unit]
    return f"{number} {unit[:-1] if number == '1' and len(unit) > 2 else unit}"


def _condition(condition: Condition) -> str:
    if isinstance(condition, Mirrors):
        return f"{condition.first} is the mirror image of {condition.second}"
    left, right = _sum(condition.left), _sum(condition.right)
    return f"{left} {_COMPARED[condition.compare]} {right}"


def _sum(terms: Sum) -> str:
    said = "".join(f" {'plus' if sign > 0 else 'less'} {_term(term)}" for sign, term in terms.terms)
    return said.removeprefix(" plus ").strip()


def _term(term: object) -> str:
    if isinstance(term, Reference):
        return _reference(term)
    return time(term) if isinstance(term, Time) else str(term)


def _reference(reference: Reference) -> str:
    field = _FIELDS.get(reference.field, reference.field)
    owner = _OWNERS.get(reference.name, f"{reference.name}'s")
    return f"{owner} {field}"


def _stage(stage: Stage) -> str:
    match stage:
        case Count(Reference() as by):
            return f"Then count the hits by {_reference(by)}."
        case Sort(by):
            return f"Then sort them by {_reference(by)}, the smallest first."
        case First(count):
            return f"Then keep the first{f' {count}' if count > 1 else ''}."
    return "Then count the hits."
