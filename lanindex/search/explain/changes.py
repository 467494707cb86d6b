"""What a query becomes by one change: without a condition, or with something like it instead."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple

from lanindex.alphabet import LEVELS
from lanindex.search.explain.nearest import Limit, nearest_limit
from lanindex.search.language.query import (
    ONCE,
    Arrow,
    Beside,
    Choice,
    Item,
    Line,
    Lines,
    Query,
    Repeat,
    Step,
    Word,
    everywhere,
    mirrored,
)
from lanindex.search.language.times import Length, Time, decimal
from lanindex.search.language.words import ANY, MOVING, Mover, Vocabulary
from lanindex.search.plan import NEGATIONS


def query_of(lines: Line | Lines) -> Query:
    """Return a query for a line, or for lines side by side."""
    return Query(Choice((Lines(lines) if isinstance(lines, Line) else lines,)))


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

    def nearest(self, finds: Callable[[Query], bool]) -> tuple[Query, str] | None:
        """Return the query with the nearest limit that finds something, and the number there."""
        limit, asking = self.limit, self.asking
        if limit is None or asking is None:
            return None
        near = nearest_limit(limit, lambda it: finds(asking(it)))
        return (asking(near[0]), near[1]) if near else None


_LIMITS: dict[type, tuple[tuple[str, str, str], ...]] = {
    Beside: (("within", "[{}]", "the nearest lies {} away"),),
    Arrow: (
        ("length", "[{}]", "the nearest comes after {}"),
        ("skips", "[{}]", "the nearest skips {}"),
    ),
    Item: (("length", "{}", "the nearest takes {}"), ("repeat", "{}", "{} in a row are the most")),
}
"""By node, the fields that hold a limit, how it is written, and how to tell the nearest number."""


def conditions(query: Query) -> Iterator[Condition]:
    """Yield the conditions of a query, in the order in which they are written.

    What stands behind ``without`` is left out as a whole only.
    """
    for node, put in places(query):
        step = str(node) if isinstance(node, Step) else ""
        for said, rest in _shorter(node):
            yield Condition(said, put(rest), step)
        for name, form, told in _LIMITS.get(type(node), ()):
            limit = getattr(node, name)
            if limit and _may_change(node, limit):
                asking = partial(_put, node, put, name, 0)
                rest = asking(ONCE if name == "repeat" else None)
                said = form.format(str(limit).strip())
                yield Condition(said, rest, "", limit, told, asking)


def _may_change(node: Any, limit: Limit) -> bool:
    """Tell whether a query may have another limit: not where few repeats or none are asked for."""
    if isinstance(limit, Repeat):
        return limit.least > 1
    return not isinstance(node, Beside) or node.relation in ("after", "before")


def _shorter(node: Any) -> Iterator[tuple[str, Any]]:
    """Yield each condition of a node but limits, as written, and the node without it."""
    match node:
        case Query():
            if node.rhythm:
                yield f"rhythm {':'.join(map(decimal, node.rhythm))}", replace(node, rhythm=())
            for index, clause in enumerate(node.where):
                yield f"{'and' if index else 'where'} {clause}", _without(node, "where", index)
        case Lines():
            for index, beside in enumerate(node.others):
                yield str(beside), _without(node, "others", index)
        case Line():
            if node.start:
                yield f"start {node.start}", replace(node, start=None)
            yield from _without_ends(node)
            if node.end:
                yield f"{node.end} end", replace(node, end=None)
        case Step():
            for index, word in enumerate(node.words):
                last_of_a_stay = node.manner == "at" and len(node.words) == 1
                if word.values != (ANY,) and not last_of_a_stay:
                    yield str(word), _written(_without(node, "words", index))


def _without(node: Any, name: str, index: int) -> Any:
    several = getattr(node, name)
    return replace(node, **{name: several[:index] + several[index + 1 :]})


def _without_ends(line: Line) -> Iterator[tuple[str, Line]]:
    """Yield a line without its first step, then without its last."""
    if len(line.items) == 1:
        return
    first, second, *_ = line.items
    if not line.start and isinstance(second.unit, Step):
        second = replace(second, unit=replace(second.unit, named=True))
        rest = replace(line, items=(second, *line.items[2:]), arrows=line.arrows[1:])
        yield f"{first} {line.arrows[0]}", rest
    rest = replace(line, items=line.items[:-1], arrows=line.arrows[:-1])
    yield f"{line.arrows[-1]} {line.items[-1]}", rest


def _written(step: Step) -> Step:
    """Return a step that can be written: one that would be no word at all says ``any``."""
    if step.words or step.named or step.manner == "hold":
        return step
    return replace(step, words=(Word("direction", (ANY,)),))


def beginnings(lines: Lines) -> Iterator[Lines]:
    """Yield ever longer beginnings: each with one step more, then the end, then a line more."""
    line = lines.first
    for count in range(1, len(line.items) + 1):
        yield Lines(Line(line.items[:count], line.arrows[: count - 1], line.start))
    if line.end:
        yield Lines(line)
    for count in range(len(lines.others)):
        yield Lines(line, lines.others[: count + 1])


# With something like it.

_RING = ("right", "r_forward", "forward", "l_forward", "left", "l_back", "back", "r_back")
_NEIGHBOURS: dict[str, tuple[str, ...]] = {
    **{name: (_RING[k - 1], _RING[(k + 1) % 8]) for k, name in enumerate(_RING)},
    # in a limb's own terms no word stands for straight ahead or straight behind
    "side": ("side_back", "side_forward"),
    "across": ("across_forward", "across_back"),
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

_TOGETHER = ("exactly with", "starting with", "ending with", "during", "overlapping")
_CLOSE_BY = Length("<", Time(Fraction(1), "s"))

Change = Callable[[Any], Iterator[Any]]
"""Takes a node of a query, yields what it can become."""


def _all(kind: type, change: Change) -> Change:
    """Return what changes all nodes of a kind at once, where there are several to change."""

    def changed(query: Query) -> Iterator[Query]:
        several = [it for it in places(query) if type(it.node) is kind and any(change(it.node))]
        if len(several) > 1:
            yield everywhere(query, lambda it: next(change(it), it) if type(it) is kind else it)

    return changed


def _later(arrow: Arrow) -> Iterator[Arrow]:
    if not arrow.later:
        yield replace(arrow, later=True)


def _manner(before: str, after: str) -> Change:
    def change(step: Step) -> Iterator[Step]:
        says = any(word.values != (ANY,) for word in step.words)
        if step.manner == before and says and all(word.kind not in MOVING for word in step.words):
            yield replace(step, manner=after)

    return change


def _relation(relations: tuple[str, ...], *others: dict[str, Any]) -> Change:
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
        for word in step.words
    )
    if step.mover.form == "both" and words != step.words:
        yield replace(step, words=words)


def _neighbours(kind: str) -> Change:
    def change(word: Word) -> Iterator[Word]:
        if word.kind == kind and len(word.values) == 1 and not word.negated:
            for value in _NEIGHBOURS.get(word.values[0], ()):
                yield replace(word, values=(value,))

    return change


def _exchanged(others: Change) -> Change:
    """Return what lets another one move, by its form and members, also where it is carried over."""

    def changed(query: Query) -> Iterator[Query]:
        movers = Vocabulary()
        for old in dict.fromkeys(it.node for it in places(query) if isinstance(it.node, Mover)):
            for new in filter(None, (movers.of(*other) for other in others(old))):
                yield everywhere(query, partial(_if_equal, old, new))

    return changed


def _if_equal(old: Mover, new: Mover, node: Any) -> Any:
    return new if node == old else node


def _either(mover: Mover) -> Iterator[tuple[str, tuple[str, ...]]]:
    if mover.form == "both":
        yield "either", mover.members


def _relatives(mover: Mover) -> Iterator[tuple[str, tuple[str, ...]]]:
    for limb in _FAMILY.get(mover.members[0][2:], ()):
        yield mover.form, tuple(part[:2] + limb for part in mover.members)


def _other_side(query: Query) -> Iterator[Query]:
    other = mirrored(query.pattern)
    if other != query.pattern and not query.where:
        yield replace(query, pattern=other)


_EDITS: tuple[tuple[float, type, Change], ...] = (
    (1.0, Arrow, _later),
    (1.1, Query, _all(Arrow, _later)),
    (1.1, Step, _manner("move", "via")),
    (1.2, Query, _all(Step, _manner("move", "via"))),
    (1.2, Beside, _relation(_TOGETHER, {"relation": "with"})),
    (1.2, Step, _own_side),
    (1.3, Step, _manner("at", "move")),
    (1.3, Step, _manner("hold", "at")),
    (1.4, Step, _manner("move", "at")),
    (1.4, Beside, _relation(("with",), {"within": _CLOSE_BY})),
    (1.5, Query, _exchanged(_either)),
    (1.6, Word, _neighbours("direction")),
    (1.8, Word, _neighbours("level")),
    (1.9, Query, _other_side),
    (2.0, Query, _exchanged(_relatives)),
    (2.2, Beside, _relation(("with",), {"relation": "after"}, {"relation": "before"})),
)
"""Changes of a kind of nodes, with their costs: from 1, a slip of the pen, to another movement."""


def edited(query: Query) -> Iterator[tuple[float, Query]]:
    """Yield what a query becomes by one edit, with what that costs, the cheapest first."""
    for cost, kind, change in _EDITS:
        for node, put in places(query):
            if type(node) is kind:
                yield from ((cost, put(other)) for other in change(node))
