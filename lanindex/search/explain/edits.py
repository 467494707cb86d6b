"""What is nearly the same as a query: a table of small changes, each with how far it leads."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from lanindex.alphabet import LEVELS
from lanindex.search.explain.tree import everywhere, places
from lanindex.search.language.query import Arrow, Beside, Query, Step, Word, mirrored
from lanindex.search.language.times import Length, Time
from lanindex.search.language.words import ANY, MOVING, Mover, Vocabulary

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

_LOOSER = {"exactly with": "with", "starting with": "with", "ending with": "with", "during": "with"}
"""By relation, the one that asks for less."""


@dataclass(frozen=True, slots=True)
class Edit:
    """A kind of change.

    Attributes
    ----------
    cost : float
        How far it leads from what was asked: 1 is a slip of the pen.
    changed : callable
        Takes a query, yields what it can become.
    """

    cost: float
    changed: Callable[[Query], Iterator[Query]]


def _one(kind: type, change: Callable[[Any], Iterator[Any]]) -> Callable[[Query], Iterator[Query]]:
    """Return what changes one node of a kind at a time."""

    def changed(query: Query) -> Iterator[Query]:
        for place in places(query):
            if type(place.node) is kind:
                yield from (place.put(other) for other in change(place.node))

    return changed


def _all(kind: type, change: Callable[[Any], Iterator[Any]]) -> Callable[[Query], Iterator[Query]]:
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


def _looser(beside: Beside) -> Iterator[Beside]:
    if beside.relation in _LOOSER:
        yield replace(beside, relation=_LOOSER[beside.relation])


def _close_by(beside: Beside) -> Iterator[Beside]:
    if beside.relation == "with" and not beside.within:
        yield replace(beside, within=Length("<", Time(Fraction(1), "s")))


def _one_after_the_other(beside: Beside) -> Iterator[Beside]:
    if beside.relation == "with" and not beside.within:
        yield from (replace(beside, relation=relation) for relation in ("after", "before"))


def _own_side(step: Step) -> Iterator[Step]:
    words = tuple(
        replace(word, values=tuple(dict.fromkeys(map(_to_side, word.values))))
        if word.kind == "direction"
        else word
        for word in step.words
    )
    if step.mover.form == "both" and words != step.words:
        yield replace(step, words=words)


def _to_side(value: str) -> str:
    return "side" if value in ("right", "left") else value


def _neighbours(kind: str) -> Callable[[Word], Iterator[Word]]:
    def change(word: Word) -> Iterator[Word]:
        if word.kind == kind and len(word.values) == 1 and not word.negated:
            for value in _NEIGHBOURS.get(word.values[0], ()):
                yield replace(word, values=(value,))

    return change


def _movers(query: Query) -> dict[Mover, None]:
    return dict.fromkeys(it.node for it in places(query) if isinstance(it.node, Mover))


def _exchanged(query: Query, old: Mover, new: Mover) -> Query:
    """Return a query in which another one moves, also where the part is carried over."""
    return everywhere(query, lambda it: new if it == old else it)


def _either(query: Query) -> Iterator[Query]:
    movers = Vocabulary().movers
    for mover in _movers(query):
        if mover.form == "both" and (other := movers.get(_group(mover))):
            yield _exchanged(query, mover, other)


def _relatives(query: Query) -> Iterator[Query]:
    movers = Vocabulary().movers
    for mover in _movers(query):
        for group in _FAMILY.get(_group(mover), ()):
            yield _exchanged(query, mover, movers[_said(mover, group)])


def _group(mover: Mover) -> str:
    """Return the limb without its side."""
    return mover.members[0].removeprefix("r_").removeprefix("l_")


def _said(mover: Mover, group: str) -> str:
    """Return how another limb of the same side, or sides, is called."""
    if mover.form == "one":
        return f"{mover.name[:2]}{group}"
    if mover.form == "either":
        return group
    return "feet" if group == "foot" else f"{group}s"


def _other_side(query: Query) -> Iterator[Query]:
    other = mirrored(query.pattern)
    if other != query.pattern and not query.where:
        yield replace(query, pattern=other)


EDITS = (
    Edit(1.0, _one(Arrow, _later)),
    Edit(1.1, _all(Arrow, _later)),
    Edit(1.1, _one(Step, _manner("move", "via"))),
    Edit(1.2, _all(Step, _manner("move", "via"))),
    Edit(1.2, _one(Beside, _looser)),
    Edit(1.2, _one(Step, _own_side)),
    Edit(1.3, _one(Step, _manner("at", "move"))),
    Edit(1.3, _one(Step, _manner("hold", "at"))),
    Edit(1.4, _one(Step, _manner("move", "at"))),
    Edit(1.4, _one(Beside, _close_by)),
    Edit(1.5, _either),
    Edit(1.6, _one(Word, _neighbours("direction"))),
    Edit(1.8, _one(Word, _neighbours("level"))),
    Edit(1.9, _other_side),
    Edit(2.0, _relatives),
    Edit(2.2, _one(Beside, _one_after_the_other)),
)
"""From what is hardly a change to what is quite another movement of the same kind."""


def edited(query: Query) -> Iterator[tuple[float, Query]]:
    """Yield what a query becomes by one change, the smallest changes first."""
    for edit in EDITS:
        for other in edit.changed(query):
            yield edit.cost, other
