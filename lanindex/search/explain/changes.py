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

LEFT_OUT = 2.5  # the cost of leaving a condition out
OTHER_NUMBER = 1.05  # the cost of the nearest number instead
Limit = Length | Repeat  # of a time, of the movements skipped, or of the repeats
_Put = Callable[[Any], Any]  # takes a node, returns the whole query with it in another's place


@dataclass(frozen=True, slots=True)
class Change:
    """A query with one change."""

    query: Query
    cost: float  # from 1 for a slip of the pen
    condition: str = ""  # the one left out, as written; empty: something is replaced
    step: str = ""  # the step with the word that is left out
    limit: Limit | None = None  # the one left out
    number: str = ""  # the text about the nearest number
    limited: Callable[[Limit], Query] | None = None  # returns the query with another limit there

    def nearest(self, finds: Callable[[Query], bool]) -> tuple[Change, str] | None:
        """Return the query with the nearest limit that finds something, and the number there."""
        limit, limited = self.limit, self.limited
        if limit is None or limited is None:
            return None
        near = nearest_limit(limit, lambda it: finds(limited(it)))
        return (Change(limited(near[0]), OTHER_NUMBER), near[1]) if near else None


def changes(query: Query) -> list[Change]:
    """Return the changes of a query, the cheapest first, then in the query's order.

    A change drops a ``without`` or ``never`` line, but never alters one.
    """
    found: list[Change] = []
    for node, put in nodes_of(query):
        step = str(node) if isinstance(node, Step) else ""
        found += (Change(put(other), cost) for cost, other in _alike(node))
        found += (Change(put(rest), LEFT_OUT, said, step) for said, rest in _shorter(node))
        for name, form, number in _LIMITS.get(type(node), ()):
            limit = getattr(node, name)
            if isinstance(limit, Repeat):
                excludes = limit.least > 1
            else:  # "with" without its limit is stricter
                excludes = limit and getattr(node, "relation", "after") in ("after", "before")
            if excludes:
                limited = partial(_put, node, put, name, 0)
                rest = limited(ONCE if name == "repeat" else None)
                condition = form.format(str(limit).strip())
                found.append(Change(rest, LEFT_OUT, condition, "", limit, number, limited))
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


# Conditions left out.

_LIMITS: dict[type, tuple[tuple[str, str, str], ...]] = {
    Beside: (("within", "[{}]", "the nearest lies {} away"),),
    Arrow: (
        ("length", "[{}]", "the nearest comes after {}"),
        ("skips", "[{}]", "the nearest skips {}"),
    ),
    Item: (("length", "{}", "the nearest takes {}"), ("repeat", "{}", "{} in a row are the most")),
}
"""By node: the fields with a limit, how it is written, and the text about the nearest number."""


def _shorter(node: Any) -> Iterator[tuple[str, Any]]:
    """Yield each condition of a node except limits, as written, and the node without it."""
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
            if node.arrows:
                first, second, *others = node.items
                if not node.start and isinstance(second.unit, Step):
                    second = replace(second, unit=replace(second.unit, named=True))
                    rest = replace(node, items=(second, *others), arrows=node.arrows[1:])
                    yield f"{first} {node.arrows[0]}", rest
                rest = replace(node, items=node.items[:-1], arrows=node.arrows[:-1])
                yield f"{node.arrows[-1]} {node.items[-1]}", rest
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


def beginnings(lines: Lines) -> Iterator[Lines]:
    """Yield the first step, then one step more each time, then the end, then one line more."""
    line = lines.first
    for count in range(1, len(line.items) + 1):
        yield Lines(Line(line.items[:count], line.arrows[: count - 1], line.start))
    if line.end:
        yield Lines(line)
    for count in range(len(lines.others)):
        yield Lines(line, lines.others[: count + 1])


# Conditions replaced.

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
"""By direction or level, its neighbours."""

_TO_NEIGHBOUR = {"direction": 1.6, "level": 1.8}  # the cost by kind of word

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
"""By limb, its parts, or the limbs that it is a part of."""

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
"""By relation, what replaces it, with the cost."""

_MANNERS = {"move": ((1.1, "via"), (1.4, "at")), "at": ((1.3, "move"),), "hold": ((1.3, "at"),)}
"""By manner, others that take the same words, with the cost."""


def _alike(node: Any) -> Iterator[tuple[float, Any]]:
    """Yield what a node can become, with the cost."""
    match node:
        case Query():  # all arrows, all steps, a part everywhere, or all sides changed
            nodes = [inner for inner, _ in nodes_of(node)]
            for cost, change in ((1.1, _later), (1.2, _via)):
                if sum(change(it) != it for it in nodes) > 1:
                    yield cost, changed_nodes(node, change)
            vocabulary = Vocabulary()
            for mover in dict.fromkeys(it for it in nodes if isinstance(it, Mover)):
                others = [(1.5, "either", mover.members)] if mover.form == "both" else []
                for limb in _RELATIVES.get(mover.members[0][2:], ()):
                    others.append((2.0, mover.form, tuple(it[:2] + limb for it in mover.members)))
                for cost, form, members in others:
                    if other := vocabulary.of(form, members):
                        yield cost, changed_nodes(node, partial(_exchanged, mover, other))
            mirror_image = mirrored(node.pattern)
            if mirror_image != node.pattern and not node.where:
                yield 1.9, replace(node, pattern=mirror_image)
        case Arrow(later=False):
            yield 1.0, _later(node)
        case Beside(within=None):
            for cost, fields_changed in _RELATIONS.get(node.relation, ()):
                yield cost, replace(node, **fields_changed)
        case Step():
            if _says_where(node):
                yield from ((cost, replace(node, manner=it)) for cost, it in _MANNERS[node.manner])
            sides = dict.fromkeys(("right", "left"), "side")
            own = tuple(
                replace(
                    it, values=tuple(dict.fromkeys(sides.get(value, value) for value in it.values))
                )
                for it in node.words
            )
            if node.mover.form == "both" and own != node.words:
                yield 1.2, replace(node, words=own)
        case Word(kind, (value,), False) if kind in _TO_NEIGHBOUR:
            for neighbour in _NEIGHBOURS.get(value, ()):
                yield _TO_NEIGHBOUR[kind], replace(node, values=(neighbour,))


def _says_where(step: Step) -> bool:
    """Return whether the words of a step fit a movement, a stay and a rest alike."""
    says = any(word.values != (ANY,) for word in step.words)
    return says and step.manner in _MANNERS and all(it.kind not in MOVING for it in step.words)


def _later(node: Any) -> Any:
    return replace(node, later=True) if isinstance(node, Arrow) else node


def _via(node: Any) -> Any:
    moves = isinstance(node, Step) and node.manner == "move" and _says_where(node)
    return replace(node, manner="via") if moves else node


def _exchanged(old: Mover, new: Mover, node: Any) -> Any:
    return new if node == old else node


# The nearest number.

_HUNDREDTH = Fraction(1, 100)
_FINEST = {"s": _HUNDREDTH, "ms": Fraction(10), "f": Fraction(1), "b": _HUNDREDTH, "": Fraction(1)}
"""By unit, the steps in which the nearest length is searched."""

_STEPS = Clock(Fraction(100), Fraction(1))  # a frame of this clock is such a step, in any unit
_DOUBLINGS = 24  # of a limit, before the search for a longer one stops
_FARTHEST = 6  # from a number of skipped movements, up to which other numbers are tried


def nearest_limit(limit: Limit, found: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
    """Return the nearest limit with which `found` is true, and its number; None: there is none."""
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

    above = below = None
    if most is not None and met(least, None):
        fails = most
        for doubling in range(_DOUBLINGS):
            fits = max(2 * most, 1) << doubling
            if met(least, fits):
                above = bisect_left(range(fits), True, fails + 1, key=lambda it: met(least, it))
                break
            fails = fits
    if least > smallest and met(smallest, most):
        below = bisect_left(range(least), True, smallest, key=lambda it: not met(it, most)) - 1
    if above is not None and (below is None or above - (most or 0) <= least - below):
        nearest, steps = _between(limit, least, above), above
    elif below is not None:
        nearest, steps = _between(limit, below, most), below
    else:
        return None
    if isinstance(limit, Repeat) or not limit.time.unit:
        return nearest, str(steps)
    unit = limit.time.unit
    return nearest, f"{float(steps * _FINEST[unit]):g} {UNITS[unit]}"


def _between(limit: Limit, least: int, most: int | None) -> Limit:
    """Return a limit of the same unit from `least` to `most` steps, None: without end."""
    if isinstance(limit, Repeat):
        return Repeat(least, None)
    unit = limit.time.unit
    begin = Time(least * _FINEST[unit], unit)
    if most is None:
        return Length("+" if unit else ">=", begin)
    end = Time(most * _FINEST[unit], unit)
    return Length("..", begin, end) if least and unit else Length("<=", end)
