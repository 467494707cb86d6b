"""The conditions of a query, each with the query that is left without it.

A table: one function a kind of node. What stands behind ``without`` is left out as a whole only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from lanindex.search.explain.tree import Place, places
from lanindex.search.language.query import (
    ONCE,
    Arrow,
    Beside,
    Bracket,
    Item,
    Line,
    Lines,
    Query,
    Repeat,
    Skips,
    Step,
    Word,
)
from lanindex.search.language.times import Length, decimal
from lanindex.search.language.words import ANY

Limit = Length | Skips | Repeat
"""What can be measured: how far off is what there is?"""


@dataclass(frozen=True, slots=True)
class Condition:
    """One condition of a query.

    Attributes
    ----------
    said : str
        As it is written there.
    rest : Query
        The query without it.
    step : str
        The step that says it, of a word.
    limit : Length, Skips, Repeat or None
        What it bounds, where that is a number.
    told : str
        How to tell the number that is nearest.
    asking : callable or None
        Takes another limit, returns the query with that one instead.
    """

    said: str
    rest: Query
    step: str = ""
    limit: Limit | None = None
    told: str = ""
    asking: Callable[[Limit], Query] | None = None


def conditions(query: Query) -> Iterator[Condition]:
    """Yield the conditions of a query, in the order in which they are written."""
    for place in places(query):
        yield from _CONDITIONS.get(type(place.node), _none)(place)


def _none(place: Place) -> Iterator[Condition]:
    return iter(())


def _limit(
    place: Place, name: str, told: str, empty: Any = None, form: str = "{}"
) -> Iterator[Condition]:
    """Yield the limit that stands in a field of a node."""
    node, put = place.node, place.put
    limit = getattr(node, name)
    if limit == empty:
        return
    rest = put(replace(node, **{name: empty}))
    said = form.format(str(limit).strip())
    yield Condition(said, rest, "", limit, told, lambda it: put(replace(node, **{name: it})))


def _of_item(place: Place) -> Iterator[Condition]:
    yield from _limit(place, "length", "the nearest takes {}")
    if place.node.repeat.least > 1:
        yield from _limit(place, "repeat", "{} in a row are the most", ONCE)


def _of_arrow(place: Place) -> Iterator[Condition]:
    yield from _limit(place, "length", "the nearest comes after {}", form="[{}]")
    yield from _limit(place, "skips", "the nearest skips {}", form="[{}]")


def _of_beside(place: Place) -> Iterator[Condition]:
    if place.node.relation in ("after", "before"):
        yield from _limit(place, "within", "the nearest lies {} away", form="[{}]")


def _of_step(place: Place) -> Iterator[Condition]:
    step: Step = place.node
    for index, word in enumerate(step.words):
        last_of_a_stay = step.manner == "at" and len(step.words) == 1
        if word.values != (ANY,) and not last_of_a_stay:
            words = step.words[:index] + step.words[index + 1 :]
            rest = place.put(said_at_all(replace(step, words=words)))
            yield Condition(str(word), rest, str(step))


def said_at_all(step: Step) -> Step:
    """Return a step that can be written: one that would be no word at all says ``any``."""
    if step.words or step.named or step.manner == "hold":
        return step
    return replace(step, words=(Word("direction", (ANY,)),))


def _of_line(place: Place) -> Iterator[Condition]:
    line: Line = place.node
    if line.start:
        yield Condition(f"start {line.start}", place.put(replace(line, start=None)))
    if len(line.items) > 1:
        if not line.start and (second := _named(line.items[1])):
            items = (second, *line.items[2:])
            rest = replace(line, items=items, arrows=line.arrows[1:])
            yield Condition(f"{line.items[0]} {line.arrows[0]}", place.put(rest))
        rest = replace(line, items=line.items[:-1], arrows=line.arrows[:-1])
        yield Condition(f"{line.arrows[-1]} {line.items[-1]}", place.put(rest))
    if line.end:
        yield Condition(f"{line.end} end", place.put(replace(line, end=None)))


def _named(item: Item) -> Item | None:
    """Return an item that says who moves, None where that is not easily said."""
    if isinstance(item.unit, Bracket):
        return None
    return replace(item, unit=replace(item.unit, named=True))


def _of_lines(place: Place) -> Iterator[Condition]:
    lines: Lines = place.node
    for index, beside in enumerate(lines.others):
        others = lines.others[:index] + lines.others[index + 1 :]
        yield Condition(str(beside), place.put(replace(lines, others=others)))


def _of_query(place: Place) -> Iterator[Condition]:
    query: Query = place.node
    if query.rhythm:
        proportion = ":".join(map(decimal, query.rhythm))
        yield Condition(f"rhythm {proportion}", replace(query, rhythm=()))
    for index, condition in enumerate(query.where):
        rest = replace(query, where=query.where[:index] + query.where[index + 1 :])
        yield Condition(f"{'and' if index else 'where'} {condition}", rest)


_CONDITIONS: dict[type, Callable[[Place], Iterator[Condition]]] = {
    Query: _of_query,
    Lines: _of_lines,
    Beside: _of_beside,
    Line: _of_line,
    Arrow: _of_arrow,
    Item: _of_item,
    Step: _of_step,
}
"""By kind of node, what yields the conditions that it makes."""
