"""The single changes of a query: one condition left out, or something like it instead."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any

from lanindex.alphabet import DIRECTIONS, LEVELS
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
    changed_nodes,
    mirrored,
)
from lanindex.search.language.times import Clock, Length, Time, decimal
from lanindex.search.language.words import ANY, MOVING, RELATIVE, UNITS, Mover, Vocabulary
from lanindex.search.plan import NEGATIONS

LEFT_OUT, OTHER_NUMBER = 2.5, 1.05
"""What it costs to leave a condition out, and to ask for the nearest number instead."""

Limit = Length | Repeat
"""A condition on a number: of a length, of movements skipped, or of repeats."""

_Put = Callable[[Any], Any]
"""Takes a node, returns the whole query with that node in the place of another."""


@dataclass(frozen=True, slots=True)
class Change:
    """A query with one change."""

    query: Query
    cost: float  # from 1, a slip of the pen, to another movement
    condition: str = ""  # what is left out, as written; empty: the query asks for something else
    step: str = ""  # of a word that is left out, the step that says it
    limit: Limit | None = None  # what is left out, where it bounds a number
    number: str = ""  # how to say which number is nearest
    limited: Callable[[Limit], Query] | None = None  # the query with another limit there

    def nearest(self, finds: Callable[[Query], bool]) -> tuple[Change, str] | None:
        """Return the query with the nearest limit that finds something, and the number there."""
        limit, limited = self.limit, self.limited
        if limit is None or limited is None:
            return None
        near = nearest_limit(limit, lambda it: finds(limited(it)))
        return (Change(limited(near[0]), OTHER_NUMBER), near[1]) if near else None


def changes(query: Query) -> list[Change]:
    """Return the changes of a query, the cheapest first; equal ones as they stand in the query.

    Lines behind ``without`` and ``never`` are left out, but not changed.
    """
    found: list[Change] = []
    for node, put in nodes_of(query):
        step = str(node) if isinstance(node, Step) else ""
        found += (Change(put(other), cost) for cost, other in _alike(node))
        found += (Change(put(rest), LEFT_OUT, said, step) for said, rest in _shorter(node))
        for name, form, number in _LIMITS.get(type(node), ()):
            limit = getattr(node, name)
            if limit and _excludes(node, limit):
                limited = partial(_put, node, put, name, 0)
                rest = limited(ONCE if name == "repeat" else None)
                said = form.format(str(limit).strip())
                found.append(Change(rest, LEFT_OUT, said, "", limit, number, limited))
    return sorted(found, key=lambda it: it.cost)


def query_of(lines: Line | Lines) -> Query:
    """Return a query for a line, or for lines side by side."""
    return Query(Choice((Lines(lines) if isinstance(lines, Line) else lines,)))


def nodes_of(node: Any, put: _Put = lambda other: other) -> Iterator[tuple[Any, _Put]]:
    """Yield each node of a query, the root first, and a function that replaces it."""
    yield node, put
    if isinstance(node, Beside) and node.relation in NEGATIONS:
        return
    for field in fields(node):
        value = getattr(node, field.name)
        for index, inner in enumerate(value if isinstance(value, tuple) else (value,)):
            if is_dataclass(inner):
                yield from nodes_of(inner, partial(_put, node, put, field.name, index))


def _put(node: Any, put: _Put, name: str, index: int, other: Any) -> Any:
    value = getattr(node, name)
    if isinstance(value, tuple):
        other = (*value[:index], other, *value[index + 1 :])
    return put(replace(node, **{name: other}))


# One condition left out.

_LIMITS: dict[type, tuple[tuple[str, str, str], ...]] = {
    Beside: (("within", "[{}]", "the nearest lies {} away"),),
    Arrow: (
        ("length", "[{}]", "the nearest comes after {}"),
        ("skips", "[{}]", "the nearest skips {}"),
    ),
    Item: (("length", "{}", "the nearest takes {}"), ("repeat", "{}", "{} in a row are the most")),
}
"""By node, the fields that hold a limit, how it is written, and how to say the nearest number."""


def _excludes(node: Any, limit: Limit) -> bool:
    """Return whether a query can find more without a limit: ``with`` has a stricter one instead."""
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
                only_place = node.manner == "at" and len(node.words) == 1
                if word.values != (ANY,) and not only_place:
                    rest = _without(node, "words", index)
                    if not (rest.words or rest.named or rest.manner == "hold"):
                        rest = replace(rest, words=(Word("direction", (ANY,)),))
                    yield str(word), rest


def _without(node: Any, name: str, index: int) -> Any:
    several = getattr(node, name)
    return replace(node, **{name: several[:index] + several[index + 1 :]})


def _without_ends(line: Line) -> Iterator[tuple[str, Line]]:
    """Yield a line without its first step, then without its last."""
    if not line.arrows:
        return
    first, second, *others = line.items
    if not line.start and isinstance(second.unit, Step):
        second = replace(second, unit=replace(second.unit, named=True))
        rest = replace(line, items=(second, *others), arrows=line.arrows[1:])
        yield f"{first} {line.arrows[0]}", rest
    rest = replace(line, items=line.items[:-1], arrows=line.arrows[:-1])
    yield f"{line.arrows[-1]} {line.items[-1]}", rest


def beginnings(lines: Lines) -> Iterator[Lines]:
    """Yield ever longer beginnings: each with one step more, then the end, then a line more."""
    line = lines.first
    for count in range(1, len(line.items) + 1):
        yield Lines(Line(line.items[:count], line.arrows[: count - 1], line.start))
    if line.end:
        yield Lines(line)
    for count in range(len(lines.others)):
        yield Lines(line, lines.others[: count + 1])


# Something like it.

_RING = DIRECTIONS[:8]
_AROUND = {name: (_RING[k - 1], _RING[(k + 1) % 8]) for k, name in enumerate(_RING)}
_OF_A_LIMB = {direction: name for name, direction in RELATIVE.items()}
_NEIGHBOURS: dict[str, tuple[str, ...]] = {
    **_AROUND,
    **{
        name: tuple(_OF_A_LIMB.get(it, it) for it in _AROUND[direction])
        for name, direction in RELATIVE.items()
    },
    **{level: LEVELS[max(k - 1, 0) : k] + LEVELS[k + 1 : k + 2] for k, level in enumerate(LEVELS)},
}
"""By direction or level, those next to it."""

_TO_NEIGHBOUR = {"direction": 1.6, "level": 1.8}
"""By kind of words, what a neighbour costs."""

_RELATIVES = {
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

_RELATIONS: dict[str, tuple[tuple[float, dict[str, Any]], ...]] = {
    **dict.fromkeys(
        ("exactly with", "starting with", "ending with", "during", "overlapping"),
        ((1.2, {"relation": "with"}),),
    ),
    "with": (
        (1.4, {"within": Length("<", Time(Fraction(1), "s"))}),
        (2.2, {"relation": "after"}),
        (2.2, {"relation": "before"}),
    ),
}
"""By relation, how else the line may lie, with the cost."""

_MANNERS = {"move": ((1.1, "via"), (1.4, "at")), "at": ((1.3, "move"),), "hold": ((1.3, "at"),)}
"""By manner, others that ask for the same words, with the cost."""


def _alike(node: Any) -> Iterator[tuple[float, Any]]:
    """Yield what a node can become, with the cost."""
    match node:
        case Query():
            yield from _all_at_once(node)
        case Arrow(later=False):
            yield 1.0, _later(node)
        case Beside(within=None):
            for cost, other in _RELATIONS.get(node.relation, ()):
                yield cost, replace(node, **other)
        case Step():
            if _says_where(node):
                yield from ((cost, replace(node, manner=it)) for cost, it in _MANNERS[node.manner])
            if node.mover.form == "both" and (own := _to_own_sides(node)) != node:
                yield 1.2, own
        case Word(kind, (value,), False) if kind in _TO_NEIGHBOUR:
            for neighbour in _NEIGHBOURS.get(value, ()):
                yield _TO_NEIGHBOUR[kind], replace(node, values=(neighbour,))


def _says_where(step: Step) -> bool:
    """Return whether the words of a step can be said of a movement, a stay and a rest alike."""
    says = any(word.values != (ANY,) for word in step.words)
    return says and step.manner in _MANNERS and all(it.kind not in MOVING for it in step.words)


def _to_own_sides(step: Step) -> Step:
    words = []
    for word in step.words:
        values = ("side" if it in ("right", "left") else it for it in word.values)
        words.append(replace(word, values=tuple(dict.fromkeys(values))))
    return replace(step, words=tuple(words))


def _all_at_once(query: Query) -> Iterator[tuple[float, Query]]:
    """Yield a query with all arrows, all steps, a part everywhere, or all sides changed."""
    nodes = [node for node, _ in nodes_of(query)]
    for cost, change in ((1.1, _later), (1.2, _via)):
        if sum(change(it) != it for it in nodes) > 1:
            yield cost, changed_nodes(query, change)
    vocabulary = Vocabulary()
    for mover in dict.fromkeys(it for it in nodes if isinstance(it, Mover)):
        others = [(1.5, "either", mover.members)] if mover.form == "both" else []
        for limb in _RELATIVES.get(mover.members[0][2:], ()):
            others.append((2.0, mover.form, tuple(part[:2] + limb for part in mover.members)))
        for cost, form, members in others:
            if other := vocabulary.of(form, members):
                yield cost, changed_nodes(query, partial(_exchanged, mover, other))
    mirror_image = mirrored(query.pattern)
    if mirror_image != query.pattern and not query.where:
        yield 1.9, replace(query, pattern=mirror_image)


def _later(node: Any) -> Any:
    return replace(node, later=True) if isinstance(node, Arrow) else node


def _via(node: Any) -> Any:
    moves = isinstance(node, Step) and node.manner == "move" and _says_where(node)
    return replace(node, manner="via") if moves else node


def _exchanged(old: Mover, new: Mover, node: Any) -> Any:
    return new if node == old else node


# The nearest number.

_FINEST = {
    **{"s": Fraction(1, 100), "ms": Fraction(10), "f": Fraction(1), "b": Fraction(1, 100)},
    "": Fraction(1),
}
"""By unit, the steps in which a length is looked for."""

_STEPS = Clock(Fraction(100), Fraction(1))
"""By this clock a frame is such a step, in any unit."""

_DOUBLINGS = 24
"""How often a limit is doubled before what lies beyond is given up."""

_FARTHEST = 6
"""How far from a number of skipped movements the next one is looked for."""


def nearest_limit(limit: Limit, found: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
    """Return the limit nearest to one that finds nothing, and the number it allows; None: none.

    `found` tells whether another limit in its place finds something.
    """
    smallest = 0
    match limit:
        case Length("", Time(count)):  # just so many are skipped: no range, so look around
            around = (count + sign * away for away in range(1, _FARTHEST) for sign in (-1, 1))
            others = (Length("", Time(it, "")) for it in around if it >= 0)
            exact = next(filter(found, others), None)
            return None if exact is None else (exact, str(exact))
        case Repeat():
            least, most, smallest = limit.least, None, 1
        case Length(_, Time(unit=unit), last):
            if last and last.unit != unit:
                return None  # from seconds to beats: there is no one number between
            least, most = limit.bounds(_STEPS)

    def met(least: int, most: int | None) -> bool:
        return found(_between(limit, least, most))

    above = None if most is None else _above(least, most, met)
    below = None
    if least > smallest and met(smallest, most):
        below = bisect_left(range(least), True, smallest, key=lambda it: not met(it, most)) - 1
    if above is not None and (below is None or above - (most or 0) <= least - below):
        return _between(limit, least, above), _number(limit, above)
    return None if below is None else (_between(limit, below, most), _number(limit, below))


def _above(least: int, most: int, met: Callable[[int, int | None], bool]) -> int | None:
    """Return the least number above a range up to which something is found."""
    if not met(least, None):
        return None
    fails = most
    for doubling in range(_DOUBLINGS):
        fits = max(2 * most, 1) << doubling
        if met(least, fits):
            return bisect_left(range(fits), True, fails + 1, key=lambda it: met(least, it))
        fails = fits
    return None


def _between(limit: Limit, least: int, most: int | None) -> Limit:
    """Return a limit like another, from one number of steps to another, None: without end."""
    if isinstance(limit, Repeat):
        return Repeat(least, None)
    unit = limit.time.unit
    begin = Time(least * _FINEST[unit], unit)
    if most is None:
        return Length("+" if unit else ">=", begin)
    end = Time(most * _FINEST[unit], unit)
    return Length("..", begin, end) if least and unit else Length("<=", end)


def _number(limit: Limit, steps: int) -> str:
    if isinstance(limit, Repeat) or not limit.time.unit:
        return str(steps)
    return f"{float(steps * _FINEST[limit.time.unit]):g} {UNITS[limit.time.unit]}"
