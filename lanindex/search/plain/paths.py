"""What a walk through a capture leaves behind: nodes, paths, and how paths lie to each other."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from lanindex.search.plain.candidates import Match
from lanindex.search.plain.track import Claim


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
        if not self.alone and self.low <= start and (not self.beyond or self.beyond > end):
            return self
        beyond = self.beyond if self.beyond > end else 0
        return Open(self.start, min(self.low, start), beyond, False)

    def beside(self, low: int, high: int, end: int) -> Open:
        """Return it with a hull inside, where its own line has come to an end."""
        beyond = max(self.beyond, high if high > end else 0)
        return Open(self.start, min(self.low, low), beyond, self.alone)


class Memory(NamedTuple):
    """What a walk remembers of its past, and all that its future depends on.

    Attributes
    ----------
    groups : tuple of Open
        The whole line, and the groups it is in, the innermost last.
    used : frozenset of Claim
        What it has used of that which another line might want.
    """

    groups: tuple[Open, ...]
    used: frozenset[Claim]


@dataclass(slots=True, eq=False)
class Node:
    """A walk at a match.

    Attributes
    ----------
    state : int
        Of the program.
    match : Match
        What matches it.
    memory : Memory
        What it remembers.
    before : list of Node
        Where it may have come from; the first is the way that is told.
    beside : tuple of Path
        What matched beside the groups that closed on that way.
    """

    state: int
    match: Match
    memory: Memory
    before: list[Node] = field(default_factory=list)
    beside: tuple[Path, ...] = ()


@dataclass(slots=True, eq=False)
class Path:
    """A whole line that matches.

    Attributes
    ----------
    first, node : Match, Node
        Where it begins and where it ends.
    start, until : int
        Its frames for comparing lines.
    low, high : int
        The hull of the line and all beside it.
    alone : bool
        Whether it is no more than a starting position.
    used : frozenset of Claim
        What it has used of that which another line might want.
    beside : tuple of Path
        What matched beside the groups that closed last.
    """

    first: Match
    node: Node
    start: int
    until: int
    low: int
    high: int
    alone: bool
    used: frozenset[Claim]
    beside: tuple[Path, ...]

    def lines(self) -> list[list[tuple[str, int]]]:
        """Return part and row of all that matched: this line's first, then each one beside."""
        nodes = [self.node]
        while nodes[-1].before:
            nodes.append(nodes[-1].before[0])
        nodes.reverse()
        own = [
            (event.timeline.part, row)
            for node in nodes
            for event in node.match.events
            for row in event.rows
        ]
        beside = [path for node in nodes for path in node.beside] + list(self.beside)
        return [list(dict.fromkeys(own)), *(line for path in beside for line in path.lines())]


class Hull(NamedTuple):
    """A line with what has been found beside it: their hull, what they use, the paths."""

    low: int
    high: int
    used: frozenset[Claim]
    paths: tuple[Path, ...] = ()

    def joined(self, path: Path, relation: str) -> Hull:
        """Return it with another path; what it lies inside adds no frames."""
        low, high = (path.low, path.high) if relation != "during" else (self.low, self.high)
        return Hull(
            min(self.low, low), max(self.high, high), self.used | path.used, (*self.paths, path)
        )


RELATIONS: dict[str, Callable[[int, int, Path, int], bool]] = {
    "with": lambda start, until, path, slack: start < path.until and path.start < until,
    "during": lambda start, until, path, slack: path.start <= start and until <= path.until,
    "starting with": lambda start, until, path, slack: abs(path.start - start) <= slack,
    "ending with": lambda start, until, path, slack: abs(path.until - until) <= slack,
    "exactly with": lambda start, until, path, slack: (
        abs(path.start - start) <= slack and abs(path.until - until) <= slack
    ),
}
"""How the leading line's start and end must lie to another line; slack in frames."""


def smallest(ways: Iterable[Hull]) -> list[Hull]:
    """Return the ways whose hull holds no other one's, among those that use the same."""
    kept: list[Hull] = []
    best: dict[frozenset[Claim], int] = {}
    for way in sorted(ways, key=lambda way: (way.high, -way.low)):
        if way.low > best.get(way.used, -1):
            best[way.used] = way.low
            kept.append(way)
    return kept


def longest(paths: list[Path]) -> list[Path]:
    """Return the paths that do not go on in another one of them."""
    behind: set[Node] = set()
    todo = [node for path in paths for node in path.node.before]
    while todo:
        node = todo.pop()
        if node not in behind:
            behind.add(node)
            todo += node.before
    return [path for path in paths if path.node not in behind]
