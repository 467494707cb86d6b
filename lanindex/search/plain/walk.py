"""Walk a program through a capture: all the ways in which a line and those beside it match.

A walk goes from match to match. Two ways that stand at the same match and remember the same are
one node, so their number stays small whatever the pattern repeats.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from heapq import heappop, heappush
from math import floor, inf

from lanindex.search.automaton import Edge, Exit, Program, State
from lanindex.search.plain.beside import Company
from lanindex.search.plain.candidates import First, Match, Recording
from lanindex.search.plain.clauses import Clauses
from lanindex.search.plain.paths import Memory, Node, Open, Path, Seen, distinct, longest, seen_in
from lanindex.search.plain.track import Claim
from lanindex.search.plain.wanted import Sides, Wanted

MOST_NODES = 200_000
"""How many nodes a walk from one first match may have, before it is given up."""


class Walker:
    """Walks the programs of one query through one capture.

    Parameters
    ----------
    recording : Recording
        The capture.
    programs : sequence of Program
        Of the leading lines.
    tolerance : Fraction
        Seconds by which edges may differ that should agree.
    clauses : Clauses
        What is asked of each way, besides.
    """

    def __init__(
        self,
        recording: Recording,
        programs: Sequence[Program],
        tolerance: Fraction,
        clauses: Clauses,
    ) -> None:
        self._recording, self._programs, self._clauses = recording, programs, clauses
        self._timed = frozenset(programs) if clauses.timed else frozenset()
        self._wanted = Wanted(recording, programs)
        self._paths: dict[Sides, list[Path]] = {}
        slack = floor(tolerance * recording.capture.rate)
        wholes = frozenset(program.whole for program in programs)
        self._company = Company(recording, self.paths, slack, clauses, wholes)

    def leading(self, program: Program, first: First | None = None) -> Iterator[Path]:
        """Yield the best path of a leading line from each of its first matches, or from one.

        "The earliest end is taken, then the latest start, then the greatest fit"; but "a repeat or
        ``?`` that ends a line runs on as long as it can".
        """
        for root in self._roots(program):
            if first is not None and root.match.first != first:
                continue
            whole: list[Path] = []
            soonest: float = inf
            for end, ending in self._from(program, root):
                if end > soonest:  # no path ends before the last match of its own line
                    break
                good = [path for path in ending if self._is_whole(path)]
                whole += good
                if not program.open_ended:
                    soonest = min([soonest, *(path.high for path in good)])
            yield from sorted(longest(whole), key=lambda path: path.rank)[:1]

    def _is_whole(self, path: Path) -> bool:
        """Tell whether a path is all that is asked for.

        A starting position alone is no movement; nothing happens that must not.
        """
        return not path.alone and not path.memory.owed and self._clauses.met_by(path)

    def paths(self, line: Sides) -> list[Path]:
        """Return all paths of a line that stands beside another, from wherever it can begin.

        Of what they have used they remember what others may want.
        """
        if line not in self._paths:
            found = [
                path
                for program in line
                for root in self._roots(program)
                for _, ending in self._from(program, root)
                for path in ending
            ]
            outside = self._wanted.outside(line)
            for path in found:
                used = frozenset(it for it in path.memory.used if it[1:] in outside)
                path.memory = path.memory._replace(used=used)
            runs_on = any(program.open_ended for program in line)
            self._paths[line] = found if runs_on else distinct(found)
        return self._paths[line]

    def _roots(self, program: Program) -> Iterator[Node]:
        for entry in program.entries:
            state = program.states[entry.state]
            for match in self._recording.anywhere(state):
                if all(self._recording.begins(match, arrow) for arrow in entry.from_start):
                    opened = Open(match.start, match.start, 0, match.starting)
                    groups = (opened,) * (1 + len(entry.opens))
                    memory = Memory(groups, self._claims(match), seen=self._seen(state, match))
                    yield Node(state, match, self._timing(program, match, memory))

    def _claims(self, match: Match) -> frozenset[Claim]:
        return frozenset(it for it in match.claims if it[1:] in self._wanted.twice)

    def _seen(self, state: State, match: Match) -> tuple[Seen, ...]:
        spoken = [label for label in state.labels if label in self._clauses.labels]
        return tuple(seen for label in spoken for seen in seen_in(match, label))

    def _timing(self, program: Program, match: Match, memory: Memory) -> Memory:
        """Return a memory with how long a match has lasted, if a rhythm is asked for."""
        if program not in self._timed:
            return memory
        return memory._replace(beats=(*memory.beats, match.end - match.start))

    def _from(self, program: Program, root: Node) -> Iterator[tuple[int, list[Path]]]:
        """Yield, in order of time, where nodes end that one first match leads to, and what does.

        So all nodes from which one may come are settled before it.
        """
        seen: dict[tuple[State, Match, Memory], Node] = {}
        todo = [(root.match.end, 0, 0, root)]
        while todo:
            end, *_, node = heappop(todo)
            self._recording.tick()
            node.settle()
            exits = program.exits[node.state.number]
            yield end, [path for leaving in exits for path in self._finish(root, node, leaving)]
            for edge in program.edges[node.state.number]:
                for new in self._cross(program, node, edge):
                    known = seen.setdefault((new.state, new.match, new.memory), new)
                    if known is new:
                        row = new.match.events[0].last
                        heappush(todo, (new.match.end, row, len(seen), new))
                    else:
                        known.came += new.came
            if len(seen) > MOST_NODES:
                raise self._recording.too_many(MOST_NODES)

    def _finish(self, root: Node, node: Node, leaving: Exit) -> Iterator[Path]:
        """Yield the paths that end at a node."""
        if not node.match.may_border:
            return
        for memory, beside in self._leave(node, leaving):
            (line,) = memory.groups
            until = node.match.until if line.alone else node.match.end
            yield Path(root.match, node, memory, until, max(line.beyond, node.match.end), beside)

    def _cross(self, program: Program, node: Node, edge: Edge) -> Iterator[Node]:
        """Yield the nodes to which an edge leads."""
        state, entry = program.states[edge.entry.state], edge.entry
        ways = self._leave(node, edge.exit)
        if not ways:
            return
        for match in self._recording.following(state, node.match, edge.arrow, edge.same):
            if not all(self._recording.begins(match, arrow) for arrow in entry.from_start):
                continue
            claims, seen = self._claims(match), self._seen(state, match)
            opened = (Open(match.start, match.start, 0, False),) * len(entry.opens)
            for memory, beside in ways:
                if not claims & memory.used:
                    moved = tuple(it.moved(match.start, match.end) for it in memory.groups)
                    new = memory._replace(groups=moved + opened).using(claims, seen)
                    new = self._timing(program, match, new)
                    if self._clauses.may_go_on(new.beats):
                        yield Node(state, match, new, [(node, beside)])

    def _leave(self, node: Node, leaving: Exit) -> list[tuple[Memory, tuple[Path, ...]]]:
        """Return the ways in which the groups that end at a node can close."""
        if not all(self._recording.ends(node.match, arrow) for arrow in leaving.to_end):
            return []
        ways: list[tuple[Memory, tuple[Path, ...]]] = [(node.memory, ())]
        for group in leaving.closes:
            ways = [
                (closed, (*beside, *more))
                for memory, beside in ways
                for closed, more in self._company.close(group, node.match, memory)
            ]
        return ways
