"""Why a query finds nothing: what each of its conditions keeps out, and what is found instead.

A change of a query leaves out one condition, or puts something like it in its place.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields, is_dataclass, replace
from fractions import Fraction
from functools import partial
from math import inf
from time import monotonic, process_time
from typing import Any

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.data import shipped
from lanindex.errors import counted
from lanindex.search.language import query as tree
from lanindex.search.language.times import Clock, Length, Time, decimal
from lanindex.search.language.words import ANY, MOVING, RELATIVE, RESTS, UNITS, Mover, Vocabulary
from lanindex.search.plan import NEGATIONS

_SIMILAR = shipped("search/explain/similar.toml")

SECONDS = 2.0  # how long the changes of a query may be tried
MOST = 5  # patterns that are offered
_CLOCK_FACTOR = 4  # how many times as long it may take by the clock on a busy machine
# Shares of the time: limits are left out until the first, similar patterns are tried until the
# second; the rest is for the other conditions
_FOR_LIMITS, _FOR_EDITS = 0.4, 0.7
_COMBINED = 60  # changes, and changes of each changed query, that are tried if no single one helps

HitCounts = tuple[int, int]  # how many hits, and in how many captures
Count = Callable[[tree.Query], HitCounts | None]  # None: there was no time to count the hits
Read = Callable[[str], tree.Query | None]  # None: the pattern is not understood


@dataclass(frozen=True)
class Budget:
    """Seconds of work, counted from now; a busy machine may take longer by the clock."""

    seconds: float
    _worked: float = field(default_factory=process_time)
    _begun: float = field(default_factory=monotonic)

    def late(self, share: float = 1) -> bool:
        """Return whether a share of the time is over."""
        allowed = share * self.seconds
        worked, passed = process_time() - self._worked, monotonic() - self._begun
        return worked >= allowed or passed >= _CLOCK_FACTOR * allowed


@dataclass(frozen=True, slots=True)
class LeftOut:
    """What a query finds without one of its conditions."""

    condition: str  # as written; empty: the choice of captures
    hits: int
    captures: int
    nearest: str = ""  # how near it came to be met, where that is a number
    step: str = ""  # which step says it, where several do
    pattern: str = ""  # that is left; empty: the same, in all captures

    def __str__(self) -> str:
        near = f", {self.nearest}" if self.nearest else ""
        of = f' of "{self.step}"' if self.step else ""
        where = f'without "{self.condition}"{of}' if self.condition else "in all captures"
        return f"{where}: {counted(self.hits, 'hit')}{near}"


@dataclass(frozen=True, slots=True)
class Suggestion:
    """A pattern that finds something, and how much."""

    pattern: str
    hits: int
    captures: int

    @property
    def counts(self) -> str:
        """How much it finds, in words."""
        return f"{counted(self.hits, 'hit')} in {counted(self.captures, 'capture')}"


@dataclass(frozen=True, slots=True)
class Advice:
    """What to do about a pattern that finds nothing.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     advice = library.suggest("arms low -> high")
    >>> print(advice.instead[0].pattern)
    arms low ... high
    >>> advice.brief
    'nearest: arms low ... high (18 hits in 7 captures)'
    >>> advice.record()["instead"][0]
    {'pattern': 'arms low ... high', 'hits': 18, 'captures': 7}
    """

    pattern: str
    never: tuple[str, ...] = ()  # its steps that match nothing at any time
    left_out: tuple[LeftOut, ...] = ()  # without which it finds something, in the pattern's order
    instead: tuple[Suggestion, ...] = ()  # that find something, the nearest first
    untried: int = 0  # changes for which there was no time
    remark: str = ""  # what to say before all this

    def __str__(self) -> str:
        lines = [self.remark] if self.remark else []
        lines += [f'"{step}" is nowhere to be found' for step in self.never]
        lines += map(str, self.left_out)
        if self.instead:
            width = max(len(it.pattern) for it in self.instead)
            lines.append("The nearest patterns that find something:")
            lines += [f"  {it.pattern.ljust(width)}  {it.counts}" for it in self.instead]
        elif not self.left_out and not self.remark:
            tried = " that could be tried" if self.untried else ""
            lines.append(f"Nor does anything near it{tried} find something.")
        if self.untried:
            lines.append(f"{counted(self.untried, 'change')} could not be tried in time.")
        return "\n".join(lines)

    def record(self) -> dict[str, Any]:
        """Return it for JSON: these keys, and those of `LeftOut` and `Suggestion`."""
        left_out = [
            {**asdict(it), "pattern": it.pattern or self.pattern, "said": str(it)}
            for it in self.left_out
        ]
        return {**asdict(self), "never": list(self.never), "left_out": left_out} | {
            "instead": list(map(asdict, self.instead))
        }

    @property
    def brief(self) -> str:
        """The same in one line."""
        if self.instead:
            return f"nearest: {self.instead[0].pattern} ({self.instead[0].counts})"
        return self.remark or next(map(str, self.left_out), "nothing near it finds something")


def advise(query: tree.Query, count: Count, read: Read, *, budget: Budget) -> Advice:
    """Return why a query finds nothing, and what would be found.

    Each pattern in the advice parses to exactly the query that was counted.
    """
    return _Adviser(query, count, read, budget, counted={query: (0, 0)}).advice()


@dataclass(slots=True)
class _Adviser:
    """Tries the changes of a query, for as long as there is time."""

    query: tree.Query
    count: Count
    read: Read
    budget: Budget
    counted: dict[tree.Query, HitCounts]
    untried: int = 0
    left_out: dict[Change, LeftOut] = field(default_factory=dict)
    instead: list[tuple[Change, Suggestion]] = field(default_factory=list)

    def advice(self) -> Advice:
        """Try the likeliest changes first: limits, similar patterns, then other conditions."""
        all_changes = changes(self.query)
        conditions = [it for it in all_changes if it.condition]
        counts = Counter(it.condition for it in conditions)
        conditions = [it if counts[it.condition] > 1 else replace(it, step="") for it in conditions]
        self.attempt([it for it in conditions if it.limited], _FOR_LIMITS)
        self.attempt([it for it in all_changes if not it.condition], _FOR_EDITS)
        never = tuple(self.never())
        self.attempt([it for it in conditions if not it.limited])
        if all(it.condition for it, _ in self.instead) and not self.untried:
            both = [
                Change(second.query, first.cost + second.cost)
                for first in all_changes[:_COMBINED]
                for second in changes(first.query)[:_COMBINED]
            ]
            self.attempt(sorted(both, key=lambda it: it.cost))
            self.untried = 0
        best = sorted(self.instead, key=lambda it: (it[0].cost, -it[1].hits))[:MOST]
        left_out = tuple(self.left_out[it] for it in conditions if it in self.left_out)
        return Advice(str(self.query), never, left_out, tuple(it for _, it in best), self.untried)

    def attempt(self, several: Iterable[Change], share: float = 1) -> None:
        """Count what changes find; once enough find something, skip those that cost more."""
        dearest = inf
        for change in several:
            if change.cost > dearest:
                return
            if self.budget.late(share):
                self.untried += 1
                continue
            hits, captures = self.keep(change)
            if hits and change.condition:
                near = self.nearest(*change.limited) if change.limited else ""
                found = LeftOut(change.condition, hits, captures, near, change.step)
                self.left_out[change] = replace(found, pattern=str(change.query))
            if sum(not it.condition for it, _ in self.instead) >= MOST:
                dearest = change.cost

    def keep(self, change: Change) -> HitCounts:
        """Return how much a change finds, and offer it if that is anything."""
        query = change.query
        if query not in self.counted:
            counts = self.count(query) if self.read(str(query)) == query else (0, 0)
            self.untried += counts is None
            self.counted[query] = counts or (0, 0)
            if counts and counts[0]:
                self.instead.append((change, Suggestion(str(query), *counts)))
        return self.counted[query]

    def never(self) -> Iterator[str]:
        """Yield the steps that match nothing even alone.

        The first step of a line may be a starting position.
        """
        alone: dict[str, tree.Query] = {}
        nodes = [node for node, _ in nodes_of(self.query)]
        firsts = [it.items[0] for it in nodes if isinstance(it, tree.Line) and not it.start]
        for item in nodes:
            if isinstance(item, tree.Item) and isinstance(item.unit, tree.Step):
                begins = item.unit.words and item in firsts and tree.may_begin(item)
                manner = "at" if begins else item.unit.manner
                step = replace(item.unit, named=True, manner=manner)
                alone[str(replace(item.unit, named=True))] = tree.query_of(
                    tree.Line((tree.Item(step),))
                )
        for text, query in alone.items() if len(alone) > 1 else ():
            if self.read(str(query)) == query and self.count(query) == (0, 0):
                yield text

    def nearest(self, limit: Limit, limited: Callable[[Limit], tree.Query], text: str) -> str:
        """Return how near a limit came to be met, and offer the query with that limit."""

        def finds(other: Limit) -> bool:
            counts = self.count(limited(other))
            if counts is None:
                raise TimeoutError
            return bool(counts[0])

        with suppress(TimeoutError):
            if near := nearest_limit(limit, finds):
                other, number = near
                self.keep(Change(limited(other), OTHER_NUMBER))
                return text.format(number)
        return ""


# Changes.

LEFT_OUT = 2.5  # the cost of leaving a condition out
OTHER_NUMBER = 1.05  # the cost of the nearest number instead
Limit = Length | tree.Repeat  # of a time, of the movements skipped, or of the repeats
_Put = Callable[[Any], Any]  # takes a node, returns the whole query with it in another's place


@dataclass(frozen=True, slots=True)
class Change:
    """A query with one change."""

    query: tree.Query
    cost: float  # from 1 for a slip of the pen
    condition: str = ""  # the one left out, as written; empty: something is replaced
    step: str = ""  # the step with the word that is left out
    # the limit left out, what returns the query with another one, the text about the nearest
    limited: tuple[Limit, Callable[[Limit], tree.Query], str] | None = None


def changes(query: tree.Query) -> list[Change]:
    """Return the changes of a query, the cheapest first, then in the query's order.

    A change drops a ``without`` or ``never`` line, but never alters one.
    """
    variants: list[Change] = []
    for node, put in nodes_of(query):
        step = str(node) if isinstance(node, tree.Step) else ""
        variants += [
            Change(put(it), cost, condition, step) for cost, condition, it in _variants(node)
        ]
        for name, form, text in _SIMILAR["limits"].get(type(node).__name__, ()):
            limit = getattr(node, name)
            if isinstance(limit, tree.Repeat):
                excludes = limit.least > 1
            else:  # "with" without its limit is stricter
                excludes = limit and getattr(node, "relation", "after") in ("after", "before")
            if excludes:
                limited = partial(_put, node, put, name, 0)
                rest = limited(tree.ONCE if name == "repeat" else None)
                condition = form.format(str(limit).strip())
                variants.append(Change(rest, LEFT_OUT, condition, "", (limit, limited, text)))
    return sorted(variants, key=lambda it: it.cost)


def nodes_of(node: Any, put: _Put = lambda other: other) -> Iterator[tuple[Any, _Put]]:
    """Yield each node of a query, the root first, and a function that replaces it."""
    yield node, put
    if isinstance(node, tree.Beside) and node.relation in NEGATIONS:
        return
    for name in (it.name for it in fields(node)):
        value = getattr(node, name)
        for index, inner in enumerate(value if isinstance(value, tuple) else (value,)):
            if is_dataclass(inner):
                yield from nodes_of(inner, partial(_put, node, put, name, index))


def _put(node: Any, put: _Put, name: str, index: int, other: Any) -> Any:
    value = getattr(node, name)
    if isinstance(value, tuple):
        other = (*value[:index], other, *value[index + 1 :])
    return put(replace(node, **{name: other}))


_OF_A_LIMB = {direction: name for name, direction in RELATIVE.items()}
_RINGS = tuple(_OF_A_LIMB.get(it, it) for it in DIRECTIONS[:8]), DIRECTIONS[:8]
_NEIGHBOURS: dict[str, tuple[str, ...]] = {
    **{name: (ring[k - 1], ring[(k + 1) % 8]) for ring in _RINGS for k, name in enumerate(ring)},
    **{level: LEVELS[max(k - 1, 0) : k] + LEVELS[k + 1 : k + 2] for k, level in enumerate(LEVELS)},
}
"""By direction or level, its neighbours; those of forward and back are the absolute ones."""

_OWN_SIDE = dict.fromkeys(("right", "left"), "side")


def _variants(node: Any) -> Iterator[tuple[float, str, Any]]:
    """Yield what a node can become: the cost, the condition left out if it is one, and the node.

    Limits are left out by `changes`.
    """
    match node:
        case tree.Query():  # all arrows, all steps, a part everywhere, or all sides changed
            nodes = [inner for inner, _ in nodes_of(node)]
            for cost, change in ((1.1, _later), (1.2, _via)):
                if sum(change(it) != it for it in nodes) > 1:
                    yield cost, "", tree.changed_nodes(node, change)
            vocabulary = Vocabulary()
            for mover in dict.fromkeys(it for it in nodes if isinstance(it, Mover)):
                others = [(1.5, "either", mover.members)] if mover.form == "both" else []
                for limb in _SIMILAR["limbs"].get(mover.members[0][2:], ()):
                    others.append((2.0, mover.form, tuple(it[:2] + limb for it in mover.members)))
                for cost, form, members in others:
                    if other := vocabulary.of(form, members):
                        yield cost, "", tree.changed_nodes(node, partial(_exchanged, mover, other))
            mirror_image = tree.mirrored(node.pattern)
            if mirror_image != node.pattern and not node.where:
                yield 1.9, "", replace(node, pattern=mirror_image)
            if node.rhythm:
                rhythm = f"rhythm {':'.join(map(decimal, node.rhythm))}"
                yield LEFT_OUT, rhythm, replace(node, rhythm=())
            for index, clause in enumerate(node.where):
                joined = "and" if index else "where"
                yield LEFT_OUT, f"{joined} {clause}", _without(node, "where", index)
        case tree.Lines():
            for index, beside in enumerate(node.others):
                yield LEFT_OUT, str(beside), _without(node, "others", index)
        case tree.Beside(within=None):
            for relation, cost in _SIMILAR["relations"].get(node.relation, {}).items():
                yield cost, "", replace(node, relation=relation)
            if node.relation == "with":
                yield 1.4, "", replace(node, within=Length("<", Time(Fraction(1), "s")))
        case tree.Line():
            if node.start:
                yield LEFT_OUT, f"start {node.start}", replace(node, start=None)
            if node.arrows:
                first, second, *later = node.items
                if not node.start and isinstance(second.unit, tree.Step):
                    second = replace(second, unit=replace(second.unit, named=True))
                    rest = replace(node, items=(second, *later), arrows=node.arrows[1:])
                    yield LEFT_OUT, f"{first} {node.arrows[0]}", rest
                rest = replace(node, items=node.items[:-1], arrows=node.arrows[:-1])
                yield LEFT_OUT, f"{node.arrows[-1]} {node.items[-1]}", rest
            if node.end:
                yield LEFT_OUT, f"{node.end} end", replace(node, end=None)
        case tree.Arrow(later=False):
            yield 1.0, "", _later(node)
        case tree.Step():
            manners = _SIMILAR["manners"].get(node.manner, {}) if _says_where(node) else {}
            for manner, cost in manners.items():
                yield cost, "", replace(node, manner=manner)
            own_side = tuple(
                replace(it, values=tuple(dict.fromkeys(_OWN_SIDE.get(v, v) for v in it.values)))
                for it in node.words
            )
            if node.mover.form == "both" and own_side != node.words:
                yield 1.2, "", replace(node, words=own_side)
            for index, word in enumerate(node.words):
                only_place = node.manner == "at" and len(node.words) == 1
                if word.values != (ANY,) and not only_place:
                    rest = _without(node, "words", index)
                    if not (rest.words or rest.named or rest.manner in RESTS):
                        rest = replace(rest, words=(tree.Word("direction", (ANY,)),))
                    yield LEFT_OUT, str(word), rest
        case tree.Word(kind, (value,), False) if kind in _SIMILAR["neighbours"]:
            for neighbour in _NEIGHBOURS.get(value, ()):
                yield _SIMILAR["neighbours"][kind], "", replace(node, values=(neighbour,))


def _without(node: Any, name: str, index: int) -> Any:
    several = getattr(node, name)
    return replace(node, **{name: several[:index] + several[index + 1 :]})


def _says_where(step: tree.Step) -> bool:
    """Return whether the words of a step fit a movement, a stay and a rest alike."""
    says = any(word.values != (ANY,) for word in step.words) or step.manner == "still"
    return says and step.manner != "via" and all(it.kind not in MOVING for it in step.words)


def _later(node: Any) -> Any:
    return replace(node, later=True) if isinstance(node, tree.Arrow) else node


def _via(node: Any) -> Any:
    moves = isinstance(node, tree.Step) and node.manner == "move" and _says_where(node)
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


def nearest_limit(limit: Limit, has_hits: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
    """Return the nearest limit that `has_hits`, and its number; None: there is none."""
    smallest = 0
    match limit:
        case Length("", Time(count)):  # just so many are skipped: no range, so look around
            around = (count + sign * away for away in range(1, _FARTHEST) for sign in (-1, 1))
            others = (Length("", Time(it, "")) for it in around if it >= 0)
            exact = next(filter(has_hits, others), None)
            return None if exact is None else (exact, str(exact))
        case tree.Repeat():
            least, most, smallest = limit.least, None, 1
        case Length(_, Time(unit=unit), last):
            if last and last.unit != unit:
                return None  # from seconds to beats: there is no one number between
            least, most = limit.bounds(_STEPS)

    def met(least: int, most: int | None) -> bool:
        return has_hits(_between(limit, least, most))

    near: list[tuple[int, int, Limit]] = []  # how far off, the number of steps, the limit
    if most is not None and met(least, None):
        doubled = (max(2 * most, 1) << doubling for doubling in range(_DOUBLINGS))
        if fits := next((it for it in doubled if met(least, it)), 0):
            above = bisect_left(range(fits), True, fits // 2 + 1, key=lambda it: met(least, it))
            near.append((above - most, above, _between(limit, least, above)))
    if least > smallest and met(smallest, most):
        below = bisect_left(range(least), True, smallest, key=lambda it: not met(it, most)) - 1
        near.append((least - below, below, _between(limit, below, most)))
    if not near:
        return None
    _, steps, nearest = min(near, key=lambda it: it[0])
    unit = "" if isinstance(limit, tree.Repeat) else limit.time.unit
    return nearest, f"{float(steps * _FINEST[unit]):g} {UNITS[unit]}" if unit else str(steps)


def _between(limit: Limit, least: int, most: int | None) -> Limit:
    """Return a limit of the same unit from `least` to `most` steps, None: without end."""
    if isinstance(limit, tree.Repeat):
        return tree.Repeat(least, None)
    unit = limit.time.unit
    begin = Time(least * _FINEST[unit], unit)
    if most is None:
        return Length("+" if unit else ">=", begin)
    end = Time(most * _FINEST[unit], unit)
    return Length("..", begin, end) if least and unit else Length("<=", end)
