"""Every place of a query's tree, each with a way to put something else there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from lanindex.search.language.query import Beside, Query

FORBIDDING = ("without", "never")
"""Relations of what must not happen: to loosen what stands there would tighten the pattern."""


@dataclass(frozen=True, slots=True)
class Place:
    """A node of a query, and the query with another node in its place.

    Attributes
    ----------
    node : object
        A node of ``language.query``.
    put : callable
        Takes the other node, returns the whole query.
    """

    node: Any
    put: Callable[[Any], Query]


def places(query: Query) -> Iterator[Place]:
    """Yield the places of a query from the root down, in the order in which it is written.

    What stands behind ``without`` and ``never`` is no place: see `FORBIDDING`.
    """
    return _places(query, lambda other: other)


def _places(node: Any, put: Callable[[Any], Query]) -> Iterator[Place]:
    yield Place(node, put)
    if isinstance(node, Beside) and node.relation in FORBIDDING:
        return
    for field in fields(node):
        value = getattr(node, field.name)
        if is_dataclass(value):
            yield from _places(value, _setter(node, field.name, put))
        elif isinstance(value, tuple):
            for index, inner in enumerate(value):
                if is_dataclass(inner):
                    yield from _places(inner, _setter(node, field.name, put, index))


def everywhere(query: Query, changed: Callable[[Any], Any]) -> Query:
    """Return a query with every node replaced by what a function makes of it, leaves first."""
    return _changed(query, changed)  # type: ignore[no-any-return]


def _changed(node: Any, changed: Callable[[Any], Any]) -> Any:
    new: dict[str, Any] = {}
    for field in fields(node):
        value = getattr(node, field.name)
        if is_dataclass(value):
            new[field.name] = _changed(value, changed)
        elif isinstance(value, tuple):
            new[field.name] = tuple(
                _changed(inner, changed) if is_dataclass(inner) else inner for inner in value
            )
    return changed(replace(node, **new) if new else node)


def _setter(
    node: Any, name: str, put: Callable[[Any], Query], index: int | None = None
) -> Callable[[Any], Query]:
    def setter(other: Any) -> Query:
        if index is not None:
            value = getattr(node, name)
            other = (*value[:index], other, *value[index + 1 :])
        return put(replace(node, **{name: other}))

    return setter
