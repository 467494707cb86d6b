"""What a query becomes by one change: without a condition, or with something like it instead."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple

from lanindex.alphabet import LEVELS
from lanindex.search.automaton import NEGATIONS
from lanindex.search.language.query import (
    ONCE,
    Arrow,
    Beside,
    Item,
    Line,
    Lines,
    Query,
    Repeat,
    Skips,
    Step,
    Word,
    mirrored,
)
from lanindex.search.language.times import Length, Time, decimal
from lanindex.search.language.words import ANY, MOVING, Mover, Vocabulary

Limit = Length | Skips | Repeat
"""A condition on a number."""


class Place(NamedTuple):
    """A node of a query, and what returns the whole query with another node in its place."""

    node: Any
    put: Callable[[Any], Query]


def places(node: Any, put: Callable[[Any], Any] = lambda other: other) -> Iterator[Place]:
    """Yield the places of a query from the root down, in the order in which it is written.

    What stands behind ``without`` and ``never`` is no place: see `NEGATIONS`.
    """
    yield Place(node, put)
    if isinstance(node, Beside) and node.relation in NEGATIONS:
        return
    for field in fields(node):
        value = getattr(node, field.name)
        for index, inner in enumerate(value if isinstance(value, tuple) else (value,)):
            if is_dataclass(inner):
                yield from places(inner, partial(_put, node, put, field.name, index))


def _put(node: Any, put: Callable[[Any], Any], name: str, index: int, other: Any) -> Any:
    value = getattr(node, name)
    if isinstance(value, tuple):
        other = (*value[:index], other, *value[index + 1 :])
    return put(replace(node, **{name: other}))


def everywhere(node: Any, changed: Callable[[Any], Any]) -> Any:
    """Return a query with every node replaced by what a function makes of it, leaves first."""

    def inside(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(map(inside, value))
        return everywhere(value, changed) if is_dataclass(value) else value

    return changed(
        replace(node, **{it.name: inside(getattr(node, it.name)) for it in fields(node)})
    )


# Without a condition.


@dataclass(frozen=True, slots=True)
class Condition:
    """One condition of a query."""

    said: str  # as it is written there
    rest: Query  # the query without it
    step: str = ""  # of a word, the step that says it
    limit: Limit | None = None  # where it bounds a number
    told: str = ""  # how to tell the nearest number
    asking: Callable[[Limit], Query] | None = None  # the query with another limit instead


def conditions(query: Query) -> Iterator[Condition]:
    """Yield the conditions of a query, in the order in which they are written.

    What stands behind ``without`` is left out as a whole only.
    """
    for place in places(query):
        yield from _conditions_of(*place)


def _conditions_of(node: Any, put: Callable[[Any], Query]) -> Iterator[Condition]:
    match node:
        case Query():
            if node.rhythm:
                said = f"rhythm {':'.join(map(decimal, node.rhythm))}"
                yield Condition(said, replace(node, rhythm=()))
            for index, clause in enumerate(node.where):
                rest = replace(node, where=_without(node.where, index))
                yield Condition(f"{'and' if index else 'where'} {clause}", rest)
        case Lines():
            for index, beside in enumerate(node.others):
                rest = put(replace(node, others=_without(node.others, index)))
                yield Condition(str(beside), rest)
        case Beside(relation="after" | "before"):
            yield from _limit(node, put, "within", "the nearest lies {} away", form="[{}]")
        case Line():
            yield from _conditions_of_line(node, put)
        case Arrow():
            yield from _limit(node, put, "length", "the nearest comes after {}", form="[{}]")
            yield from _limit(node, put, "skips", "the nearest skips {}", form="[{}]")
        case Item():
            yield from _limit(node, put, "length", "the nearest takes {}")
            if node.repeat.least > 1:
                yield from _limit(node, put, "repeat", "{} in a row are the most", ONCE)
        case Step():
            for index, word in enumerate(node.words):
                last_of_a_stay = node.manner == "at" and len(node.words) == 1
                if word.values != (ANY,) and not last_of_a_stay:
                    step = _written(replace(node, words=_without(node.words, index)))
                    yield Condition(str(word), put(step), str(node))


def _without(several: tuple[Any, ...], index: int) -> tuple[Any, ...]:
    return several[:index] + several[index + 1 :]


def _limit(
    node: Any,
    put: Callable[[Any], Query],
    name: str,
    told: str,
    empty: Any = None,
    form: str = "{}",
) -> Iterator[Condition]:
    """Yield the limit that stands in a field of a node."""

    def asking(other: Any) -> Query:
        return put(replace(node, **{name: other}))

    limit = getattr(node, name)
    if limit != empty:
        yield Condition(form.format(str(limit).strip()), asking(empty), "", limit, told, asking)


def _conditions_of_line(line: Line, put: Callable[[Any], Query]) -> Iterator[Condition]:
    if line.start:
        yield Condition(f"start {line.start}", put(replace(line, start=None)))
    if len(line.items) > 1:
        second = line.items[1]
        if not line.start and isinstance(second.unit, Step):
            second = replace(second, unit=replace(second.unit, named=True))
            rest = replace(line, items=(second, *line.items[2:]), arrows=line.arrows[1:])
            yield Condition(f"{line.items[0]} {line.arrows[0]}", put(rest))
        rest = replace(line, items=line.items[:-1], arrows=line.arrows[:-1])
        yield Condition(f"{line.arrows[-1]} {line.items[-1]}", put(rest))
    if line.end:
        yield Condition(f"{line.end} end", put(replace(line, end=None)))


def _written(step: Step) -> Step:
    """Return a step that can be written: one that would be no word at all says ``any``."""
    if step.words or step.named or step.manner == "hold":
        return step
    return replace(step, words=(Word("direction", (ANY,)),))


# With something like it.

_RING = ("right", "r_forward", "forward", "l_forward", "left", "l_back", "back", "r_back")
_OWN_RING = ("side", "side_forward", "across_forward", "across", "across_back", "side_back")
_NEIGHBOURS: dict[str, tuple[str, ...]] = {
    **{name: (_RING[k - 1], _RING[(k + 1) % 8]) for k, name in enumerate(_RING)},
    **{name: (_OWN_RING[k - 1], _OWN_RING[(k + 1) % 6]) for k, name in enumerate(_OWN_RING)},
    # in their own terms no word stands for straight ahead or straight behind
    "side_forward": ("side", "forward"),
    "across_forward": ("forward", "across"),
    "side_back": ("side", "back"),
    "across_back": ("back", "across"),
    **{level: LEVELS[max(k - 1, 0) : k] + LEVELS[k + 1 : k + 2] for k, level in enumerate(LEVELS)},
}
"""By direction or level, those next to it."""

_FAMILY = {
    "arm": ("forearm", "upper_arm", "hand"),
    "forearm": ("arm", "hand"),
    "upper_arm": ("arm",),
    "hand": ("arm", "forearm"),
    "palm": ("hand", "forearm"),
    "leg": ("thigh", "shank", "foot"),
    "thigh": ("leg",),
    "shank": ("leg",),
    "foot": ("leg", "shank"),
    "support": ("leg", "foot"),
}
"""By limb, those that it consists of, or that it belongs to."""

_TOGETHER = ("exactly with", "starting with", "ending with", "during")
_CLOSE_BY = Length("<", Time(Fraction(1), "s"))

Change = Callable[[Query], Iterator[Query]]
"""Takes a query, yields what it can become."""


def _one(kind: type, change: Callable[[Any], Iterator[Any]]) -> Change:
    """Return what changes one node of a kind at a time."""

    def changed(query: Query) -> Iterator[Query]:
        for node, put in places(query):
            if type(node) is kind:
                yield from map(put, change(node))

    return changed


def _all(kind: type, change: Callable[[Any], Iterator[Any]]) -> Change:
    """Return what changes all nodes of a kind at once, where there are several to change."""

    def changed(query: Query) -> Iterator[Query]:
        several = [it for it in places(query) if type(it.node) is kind and any(change(it.node))]
        if len(several) > 1:
            yield everywhere(query, lambda it: next(change(it), it) if type(it) is kind else it)

    return changed


def _later(arrow: Arrow) -> Iterator[Arrow]:
    if not arrow.later:
        yield replace(arrow, later=True)


def _manner(before: str, after: str) -> Callable[[Step], Iterator[Step]]:
    def change(step: Step) -> Iterator[Step]:
        says = any(word.values != (ANY,) for word in step.words)
        if step.manner == before and says and all(word.kind not in MOVING for word in step.words):
            yield replace(step, manner=after)

    return change


def _relation(relations: tuple[str, ...], *others: dict[str, Any]) -> Callable[..., Iterator[Any]]:
    """Return what lets a line lie otherwise beside the first, where no limit is set to that."""

    def change(beside: Beside) -> Iterator[Beside]:
        if beside.relation in relations and not beside.within:
            yield from (replace(beside, **other) for other in others)

    return change


def _own_side(step: Step) -> Iterator[Step]:
    """Yield a pair's step to the right or left as one that each takes to its own side."""
    own = {"right": "side", "left": "side"}
    words = tuple(
        replace(word, values=tuple(dict.fromkeys(own.get(it, it) for it in word.values)))
        if word.kind == "direction"
        else word
        for word in step.words
    )
    if step.mover.form == "both" and words != step.words:
        yield replace(step, words=words)


def _neighbours(kind: str) -> Callable[[Word], Iterator[Word]]:
    def change(word: Word) -> Iterator[Word]:
        if word.kind == kind and len(word.values) == 1 and not word.negated:
            for value in _NEIGHBOURS.get(word.values[0], ()):
                yield replace(word, values=(value,))

    return change


def _exchanged(names: Callable[[Mover, str], list[str]]) -> Change:
    """Return what lets another one move, also where the part is carried over.

    `names` takes a mover, and its limb without the side.
    """

    def changed(query: Query) -> Iterator[Query]:
        movers = Vocabulary().movers
        for old in dict.fromkeys(it.node for it in places(query) if isinstance(it.node, Mover)):
            limb = old.members[0].removeprefix("r_").removeprefix("l_")
            for new in (movers[name] for name in names(old, limb) if name in movers):
                yield everywhere(query, partial(_if_equal, old, new))

    return changed


def _if_equal(old: Mover, new: Mover, node: Any) -> Any:
    return new if node == old else node


def _either(mover: Mover, limb: str) -> list[str]:
    return [limb] if mover.form == "both" else []


def _relatives(mover: Mover, limb: str) -> list[str]:
    """Return what other limbs of the same side, or sides, are called."""
    others = _FAMILY.get(limb, ())
    if mover.form == "one":
        return [f"{mover.name[:2]}{other}" for other in others]
    if mover.form == "either":
        return list(others)
    return ["feet" if other == "foot" else f"{other}s" for other in others]


def _other_side(query: Query) -> Iterator[Query]:
    other = mirrored(query.pattern)
    if other != query.pattern and not query.where:
        yield replace(query, pattern=other)


_EDITS: tuple[tuple[float, Change], ...] = (
    (1.0, _one(Arrow, _later)),
    (1.1, _all(Arrow, _later)),
    (1.1, _one(Step, _manner("move", "via"))),
    (1.2, _all(Step, _manner("move", "via"))),
    (1.2, _one(Beside, _relation(_TOGETHER, {"relation": "with"}))),
    (1.2, _one(Step, _own_side)),
    (1.3, _one(Step, _manner("at", "move"))),
    (1.3, _one(Step, _manner("hold", "at"))),
    (1.4, _one(Step, _manner("move", "at"))),
    (1.4, _one(Beside, _relation(("with",), {"within": _CLOSE_BY}))),
    (1.5, _exchanged(_either)),
    (1.6, _one(Word, _neighbours("direction"))),
    (1.8, _one(Word, _neighbours("level"))),
    (1.9, _other_side),
    (2.0, _exchanged(_relatives)),
    (2.2, _one(Beside, _relation(("with",), {"relation": "after"}, {"relation": "before"}))),
)
"""Changes, each with its cost: from 1, a slip of the pen, to quite another movement."""


def edited(query: Query) -> Iterator[tuple[float, Query]]:
    """Yield what a query becomes by one edit, with what that costs, the cheapest first."""
    return ((cost, other) for cost, change in _EDITS for other in change(query))
