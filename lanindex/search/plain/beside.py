"""What stands beside a line: the other lines of a group, once its own line has come to an end.

The lines that must be there are sought one after the other; then those that must not be there are
looked for. "One movement, stay or rest cannot serve two lines", and "a match of L that uses a
symbol of the hit does not count, for ``without`` as for ``never``": of the hit as a whole, so what
disturbs a bracket may still be forgiven later on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from lanindex.search.automaton import Companion, Group
from lanindex.search.plain.candidates import Match, Recording
from lanindex.search.plain.clauses import Clauses
from lanindex.search.plain.paths import Memory, Open, Path, distinct, longest
from lanindex.search.plain.relations import FORBIDDEN, NO_FRAMES, Stretch, stands
from lanindex.search.plain.track import Claim, forgiving
from lanindex.search.plain.wanted import Sides

MOST_WAYS = 1_000_000
"""How many ways to stand beside one end of a line are tried, before it is given up."""


class Hull(NamedTuple):
    """A line with what has been found beside it: their hull, what they remember, the paths."""

    low: int
    high: int
    memory: Memory
    fit: float = 1.0
    paths: tuple[Path, ...] = ()

    def joined(self, path: Path, relation: str) -> Hull:
        """Return it with another path; what comes before, after or around adds no frames."""
        low, high = (self.low, self.high) if relation in NO_FRAMES else (path.low, path.high)
        other = path.memory
        return Hull(
            min(self.low, low),
            max(self.high, high),
            self.memory.using(other.used, other.seen, other.owed),
            min(self.fit, path.fit),
            (*self.paths, path),
        )


def smallest(ways: Iterable[Hull], alike: bool) -> list[Hull]:
    """Return the ways that no other one is better than: no larger, no less clear.

    Only ways that remember the same are compared, and of these, where it is asked for, those alike
    in their frames.
    """
    kept: dict[object, list[Hull]] = {}
    for way in sorted(ways, key=lambda way: (way.high, -way.low, -way.fit)):
        frames = (way.low, way.high) if alike else ()
        _, *rest = way.memory  # the groups are the same in all of them
        others = kept.setdefault((*rest, *frames), [])
        if not any(it.low >= way.low and it.fit >= way.fit for it in others):
            others.append(way)
    return [way for others in kept.values() for way in others]


class Company:
    """Finds what stands beside the lines of one query in one capture.

    Parameters
    ----------
    recording : Recording
        The capture.
    paths : callable
        Line → all its paths, from wherever it can begin.
    slack : int
        Frames by which edges may differ that should agree.
    clauses : Clauses
        What is asked of each way, besides.
    wholes : frozenset of Group
        Those that close last.
    """

    def __init__(
        self,
        recording: Recording,
        paths: Callable[[Sides], list[Path]],
        slack: int,
        clauses: Clauses,
        wholes: frozenset[Group],
    ) -> None:
        self._recording, self._paths, self._slack = recording, paths, slack
        self._clauses, self._wholes = clauses, wholes
        self._matches: dict[Sides, list[Path]] = {}

    def close(
        self, group: Group, match: Match, memory: Memory
    ) -> Iterator[tuple[Memory, tuple[Path, ...]]]:
        """Yield the ways in which a group can close at the last match of its own line."""
        *outer, line = memory.groups
        lasted = match.end - line.start
        if group.length and (line.alone or not self._recording.meets(lasted, group.length)):
            return
        for hull in self._hulls(group, match, line, memory):
            groups = tuple(it.beside(hull.low, hull.high, match.end) for it in outer)
            yield hull.memory._replace(groups=groups), hull.paths

    def _hulls(self, group: Group, match: Match, line: Open, memory: Memory) -> list[Hull]:
        """Return what a group can hold once its line has come to an end."""
        stretch = Stretch(line.start, match.until if line.alone else match.end, line.alone)
        hulls = [Hull(line.low, max(line.beyond, match.end), memory)]
        for companion in group.companions:
            if companion.relation not in FORBIDDEN:
                ways = self._with(companion, stretch, hulls, group in self._wholes)
                hulls = smallest(ways, self._clauses.of_match)
        for companion in group.companions:
            if companion.relation in FORBIDDEN:
                hulls = [
                    hull._replace(memory=hull.memory.using(frozenset(), (), owed))
                    for hull in hulls
                    for owed in [self._disturbing(companion, stretch, hull)]
                    if frozenset() not in owed
                ]
        return hulls

    def _with(
        self, companion: Companion, stretch: Stretch, hulls: list[Hull], whole: bool
    ) -> Iterator[Hull]:
        """Yield each of some ways with each path that can stand beside it."""
        if len(hulls) * len(self._paths(companion.programs)) > MOST_WAYS:
            raise self._recording.too_many(MOST_WAYS)
        for hull in hulls:
            self._recording.tick()
            for path in self._partners(companion, stretch, hull, whole):
                yield hull.joined(path, companion.relation)

    def _partners(
        self, companion: Companion, stretch: Stretch, hull: Hull, whole: bool
    ) -> list[Path]:
        """Return the paths that stand beside a line as a companion must.

        Of one that ends in a repeat it is the longest that can stand there and fits the conditions,
        as far as they can be told yet.
        """
        used, seen = hull.memory.used, hull.memory.seen if whole else ()
        paths = [
            path
            for path in self._paths(companion.programs)
            if stands(companion, stretch, path, self._recording, self._slack)
            and not path.memory.used & used
            and self._clauses.may_hold((*seen, *path.memory.seen))
        ]
        runs_on = any(program.open_ended for program in companion.programs)
        return distinct(longest(paths)) if runs_on else paths

    def _disturbing(
        self, companion: Companion, line: Stretch, hull: Hull
    ) -> frozenset[frozenset[Claim]]:
        """Return what the matches of a line that must not happen use, where it is nothing of ours.

        A line that is still no more than a starting position lasts as long as its part stays there.
        """
        stretch = Stretch(hull.low, max(hull.high, line.until), line.alone)
        forgiven = forgiving(hull.memory.used)
        self._recording.tick()
        return frozenset(
            path.memory.used
            for path in self._alone(companion.programs)
            if not path.memory.used & forgiven
            and stands(companion, stretch, path, self._recording, self._slack)
        )

    def _alone(self, line: Sides) -> list[Path]:
        """Return the matches of a line by itself, one of those in the same place."""
        if line not in self._matches:
            places = {
                (path.start, path.until, path.alone, path.memory.used): path
                for path in self._paths(line)
                if not path.memory.owed
            }
            self._matches[line] = list(places.values())
        return self._matches[line]
