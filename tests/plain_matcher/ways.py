"""Ways through lines: from match to match, with the lines that joined on the way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from lanindex.search.plan import State
from plain_matcher.candidates import Match
from plain_matcher.relations import NO_FRAMES, Stretch
from plain_matcher.track import Claim, forgiving


class Open(NamedTuple):
    """A bracket that is open, or the whole line.

    Attributes
    ----------
    start : int
        Where its own line began.
    low, high : int
        Its hull, that of all that matched since.
    alone : bool
        Whether its line is still no more than a starting position.
    """

    start: int
    low: int
    high: int
    alone: bool

    def around(self, low: int, high: int) -> Open:
        """Return it with more inside."""
        return self._replace(low=min(self.low, low), high=max(self.high, high))


class Past(NamedTuple):
    """What a way has come to.

    Attributes
    ----------
    opened : tuple of Open
        The whole line, and the brackets it is in, the innermost last.
    used : frozenset of Claim
        What its own line has used, and those that joined.
    owed : frozenset of frozenset of Claim
        What each match of a line that must not happen uses: none of them counts that uses what the
        hit uses, so one of each has still to be used.
    joined : tuple of Way
        The lines that have joined since its last match.
    """

    opened: tuple[Open, ...]
    used: frozenset[Claim]
    owed: frozenset[frozenset[Claim]] = frozenset()
    joined: tuple[Way, ...] = ()

    def with_line(self, way: Way, relation: str) -> Past:
        """Return it with a line that joins; what comes before, after or around adds no frames."""
        *outer, own = self.opened
        own = own if relation in NO_FRAMES else own.around(way.low, way.high)
        used, owed = self.used | way.past.used, self.owed | way.past.owed
        return Past((*outer, own), used, owed, (*self.joined, way))

    def with_match(self, match: Match, opening: int) -> Past:
        """Return it with the next match, at which some brackets open."""
        opened = [it.around(match.start, match.end)._replace(alone=False) for it in self.opened]
        opened += [Open(match.start, match.start, match.end, False)] * opening
        return Past(tuple(opened), self.used | match.claims, self.owed)


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A way at a match.

    Attributes
    ----------
    before : Node or None
        Where it was before; None: it begins here.
    joined : tuple of Way
        The lines that joined on the way from there.
    state : State
        Of the program.
    match : Match
        What matches it.
    past : Past
        What it has come to.
    """

    before: Node | None
    joined: tuple[Way, ...]
    state: State
    match: Match
    past: Past

    def all(self) -> list[Node]:
        """Return all nodes of its way so far, in order."""
        return [*(self.before.all() if self.before else []), self]


class Seen(NamedTuple):
    """A symbol under a label, with the frames of the step that it matched."""

    label: str
    part: str
    row: int
    start: int
    end: int


@dataclass(eq=False)
class Way:
    """A whole line that matches: where it ends, and what it has come to, all brackets closed."""

    node: Node
    past: Past

    @cached_property
    def nodes(self) -> list[Node]:
        """Its nodes in order."""
        return self.node.all()

    @cached_property
    def joined(self) -> list[Way]:
        """The lines beside it."""
        return [
            it for joined in (*(n.joined for n in self.nodes), self.past.joined) for it in joined
        ]

    @property
    def low(self) -> int:
        """The first frame of the hull of the line and all beside it."""
        return self.past.opened[0].low

    @property
    def high(self) -> int:
        """The end of that hull."""
        return self.past.opened[0].high

    @property
    def alone(self) -> bool:
        """Whether it is no more than a starting position."""
        return self.past.opened[0].alone

    @property
    def stretch(self) -> Stretch:
        """The line itself, for comparing it with others."""
        match = self.node.match
        until = match.until if self.alone else match.end
        return Stretch(self.past.opened[0].start, until, self.alone)

    @cached_property
    def fit(self) -> float:
        """The smallest margin of all that matched."""
        return min([*(it.match.fit for it in self.nodes), *(it.fit for it in self.joined)])

    @property
    def rank(self) -> tuple[int, int, float]:
        """What decides: the earliest end, then the latest start, then the greatest fit."""
        return self.high, -self.low, -self.fit

    @property
    def paid(self) -> bool:
        """Whether all that happens and must not uses what it uses, or what led there."""
        forgiven = forgiving(self.past.used)
        return all(it & forgiven for it in self.past.owed)

    def lines(self) -> Iterator[tuple[tuple[str, int], ...]]:
        """Yield part and row of all that matched: this line's first, then each one beside."""
        events = (event for node in self.nodes for event in node.match.events)
        yield tuple(dict.fromkeys((it.timeline.part, row) for it in events for row in it.rows))
        for way in self.joined:
            yield from way.lines()

    def labelled(self) -> Iterator[Seen]:
        """Yield what has matched under a label; what is stayed at lasts as long as the stay."""
        for node in self.nodes:
            match = node.match
            for event in match.events:
                whole = match if match.manner in ("at", "hold") else event
                for label in node.state.labels:
                    for row in event.rows:
                        yield Seen(label, event.timeline.part, row, whole.start, whole.end)
        for way in self.joined:
            yield from way.labelled()


def longest(ways: Iterable[Way]) -> list[Way]:
    """Return the ways that do not go on in another one of them."""
    ways = list(ways)
    behind = {node for way in ways for node in way.nodes[:-1]}
    return [way for way in ways if way.node not in behind]
