"""What a walk through a capture leaves behind: memories, nodes and whole paths."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from lanindex.search.automaton import State
from lanindex.search.plain.candidates import Match
from lanindex.search.plain.track import Claim, forgiving


class Open(NamedTuple):
    """A group that has begun, or the whole line.

    Attributes
    ----------
    start : int
        Where its own line began.
    low : int
        Where its hull begins, that of all that matched since.
    beyond : int
        Where its hull ends, if one beside it goes on for longer than its own line; else 0.
    alone : bool
        Whether its line is still no more than a starting position.
    """

    start: int
    low: int
    beyond: int
    alone: bool

    def moved(self, start: int, end: int) -> Open:
        """Return it with one more match of its own line inside."""
        beyond = self.beyond if self.beyond > end else 0
        return Open(self.start, min(self.low, start), beyond, False)

    def beside(self, low: int, high: int, end: int) -> Open:
        """Return it with a hull inside, where its own line has come to an end."""
        beyond = max(self.beyond, high if high > end else 0)
        return Open(self.start, min(self.low, low), beyond, self.alone)


class Seen(NamedTuple):
    """A symbol under a label, with the frames of the step that it matched."""

    label: str
    part: str
    row: int
    start: int
    end: int


class Memory(NamedTuple):
    """What a walk remembers of its past, and all that its future depends on.

    Attributes
    ----------
    groups : tuple of Open
        The whole line, and the groups it is in, the innermost last.
    used : frozenset of Claim
        What it has used of that which another line might want.
    owed : frozenset of frozenset of Claim
        Of each match of a line that must not happen what it uses: none of them counts that uses
        what the hit uses, so one of each has still to be used.
    seen : tuple of Seen
        What has matched under the labels that conditions speak of.
    beats : tuple of int
        How many frames each of the steps has lasted whose rhythm is asked for.
    """

    groups: tuple[Open, ...]
    used: frozenset[Claim]
    owed: frozenset[frozenset[Claim]] = frozenset()
    seen: tuple[Seen, ...] = ()
    beats: tuple[int, ...] = ()

    def using(
        self,
        claims: frozenset[Claim],
        seen: tuple[Seen, ...],
        owed: frozenset[frozenset[Claim]] = frozenset(),
    ) -> Memory:
        """Return it with more that is used, seen and owed."""
        used, owed = self.used | claims, self.owed | owed
        if owed:
            forgiven = forgiving(used)
            owed = frozenset(it for it in owed if not it & forgiven)
        return Memory(self.groups, used, owed, self.seen + seen, self.beats)


@dataclass(slots=True, eq=False)
class Node:
    """A walk at a match.

    Attributes
    ----------
    state : State
        Of the program.
    match : Match
        What matches it.
    memory : Memory
        What it remembers.
    came : list of tuple of Node and tuple of Path
        From where it may have come, each with what matched beside the groups that closed on the
        way; none: it is the first.
    fit : float
        Of the clearest way to it.
    steps : int
        How many nodes that way has, itself included.
    """

    state: State
    match: Match
    memory: Memory
    came: list[tuple[Node, tuple[Path, ...]]] = field(default_factory=list)
    fit: float = 1.0
    steps: int = 1

    def settle(self) -> None:
        """Put the clearest way first, of those the one of most steps; all before it are settled."""
        self.came.sort(key=lambda way: (_fit_of_way(way), way[0].steps), reverse=True)
        self.fit = min([self.match.fit, *map(_fit_of_way, self.came[:1])])
        self.steps = 1 + sum(node.steps for node, _ in self.came[:1])

    def told(self) -> list[Node]:
        """Return the nodes of the clearest way to it, in order."""
        nodes = [self]
        while nodes[-1].came:
            nodes.append(nodes[-1].came[0][0])
        return nodes[::-1]

    def labelled(self) -> Iterator[Seen]:
        """Yield what its match has under each label of its state."""
        for label in self.state.labels:
            yield from seen_in(self.match, label)


def _fit_of_way(way: tuple[Node, tuple[Path, ...]]) -> float:
    node, beside = way
    return min([node.fit, *(path.fit for path in beside)])


def seen_in(match: Match, label: str) -> Iterator[Seen]:
    """Yield the symbols of a match; one stayed at or rested in lasts as long as that."""
    for event in match.events:
        whole = match if match.manner in ("at", "hold") else event
        for row in event.rows:
            yield Seen(label, event.timeline.part, row, whole.start, whole.end)


@dataclass(slots=True, eq=False)
class Path:
    """A whole line that matches.

    Attributes
    ----------
    first : Match
        Where it begins.
    node : Node
        Where it ends.
    memory : Memory
        What it remembers there, all groups closed.
    until, high : int
        Its end for comparing lines, and that of the hull of the line and all beside it.
    beside : tuple of Path
        What matched beside the groups that closed last.
    fit : float
        The smallest margin of all that matched, on the clearest way.
    """

    first: Match
    node: Node
    memory: Memory
    until: int
    high: int
    beside: tuple[Path, ...]
    fit: float = field(init=False)

    def __post_init__(self) -> None:
        """Work out the fit, once and for all."""
        self.fit = _fit_of_way((self.node, self.beside))

    @property
    def start(self) -> int:
        """Its first frame, for comparing lines."""
        return self.memory.groups[0].start

    @property
    def low(self) -> int:
        """The first frame of the hull of the line and all beside it."""
        return self.memory.groups[0].low

    @property
    def alone(self) -> bool:
        """Whether it is no more than a starting position."""
        return self.memory.groups[0].alone

    @property
    def rank(self) -> tuple[int, int, float, int]:
        """What decides: the earliest end, then the latest start, then the greatest fit.

        Of ways that tie in all this the one of most steps is told.
        """
        return self.high, -self.low, -self.fit, -self.node.steps

    def lines(self) -> list[list[tuple[str, int]]]:
        """Return part and row of all that matched: this line's first, then each one beside."""
        nodes = self.node.told()
        own = [
            (event.timeline.part, row)
            for node in nodes
            for event in node.match.events
            for row in event.rows
        ]
        beside = [line for path in self._beside(nodes) for line in path.lines()]
        return [list(dict.fromkeys(own)), *beside]

    def labelled(self) -> list[Seen]:
        """Return what has matched under a label, of this line and of each one beside."""
        nodes = self.node.told()
        own = [seen for node in nodes for seen in node.labelled()]
        return own + [seen for path in self._beside(nodes) for seen in path.labelled()]

    def _beside(self, nodes: list[Node]) -> list[Path]:
        inner = [path for node in nodes for _, beside in node.came[:1] for path in beside]
        return [*inner, *self.beside]


def longest(paths: list[Path]) -> list[Path]:
    """Return the paths that do not go on in another one of them."""
    behind: set[Node] = set()
    todo = [node for path in paths for node, _ in path.node.came]
    while todo:
        node = todo.pop()
        if node not in behind:
            behind.add(node)
            todo += [before for before, _ in node.came]
    return [path for path in paths if path.node not in behind]


def distinct(paths: Iterable[Path]) -> list[Path]:
    """Return one of those paths that look alike from outside, the clearest."""
    kept: dict[tuple[Memory, int, int], Path] = {}
    for path in paths:
        key = (path.memory, path.until, path.high)
        if key not in kept or path.fit > kept[key].fit:
            kept[key] = path
    return list(kept.values())
