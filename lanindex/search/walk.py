"""Walk a program through a capture: all the ways in which a line and those beside it match.

A walk goes from match to match. Two ways that stand at the same match, with the same brackets
open and the same hull, are one node, so their number stays small whatever the pattern repeats.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from math import floor, inf

from lanindex.errors import LanindexError
from lanindex.search.plan import Companion, Edge, Exit, Group, Program
from lanindex.search.reach import Board, Match
from lanindex.search.runs import RELATIONS, Hull, Node, Open, Run, State, longest, smallest
from lanindex.search.timeline import Token

_MOST_NODES = 200_000


class Walker:
    """Walks the programs of one query through one capture.

    Parameters
    ----------
    board : Board
        The capture.
    programs : sequence of Program
        Of the leading lines.
    tolerance : Fraction
        Seconds by which edges may differ that should agree.
    """

    def __init__(self, board: Board, programs: Sequence[Program], tolerance: Fraction) -> None:
        self._board, self._programs = board, programs
        self._slack = floor(tolerance * board.capture.rate)
        self._runs: dict[Program, list[Run]] = {}
        self._nodes = 0

    # Which movements more than one line may want.

    @cached_property
    def _wanted(self) -> frozenset[Token]:
        wanted: set[Token] = set()
        for program in self._programs:
            if any(group.companions for group in program.groups):
                tally: Counter[Token] = Counter()
                self._tally(program, 1, tally)
                wanted |= {token for token, lines in tally.items() if lines > 1}
        return frozenset(wanted)

    def _tally(self, program: Program, lines: int, tally: Counter[Token]) -> None:
        """Count how many lines may want a movement; a line in a bracket may come again."""
        for token in {
            token
            for place in program.places
            for events in self._board.events(place)
            for event in events
            for token in event.tokens
        }:
            tally[token] += lines
        for depth, group in enumerate(program.groups):
            for companion in group.companions:
                for inner in companion.programs:
                    self._tally(inner, 2 if depth else lines, tally)

    def _fading(self, program: Program) -> dict[Token, float]:
        """Return until which frame a line beside a leading one may still want a movement.

        What has faded need not be remembered: so a long wave of brackets stays one walk.
        """
        until: dict[Token, float] = {}
        for depth, group in enumerate(program.groups if self._wanted else ()):
            for companion in group.companions:
                for inner in companion.programs:
                    for run in self.runs(inner):
                        end = run.until + self._slack if depth else inf
                        until.update({it: max(end, until.get(it, 0)) for it in run.used})
        return until

    # Walking.

    def runs(self, program: Program) -> list[Run]:
        """Return all runs of a line that stands beside another, from wherever it can begin."""
        if program not in self._runs:
            self._runs[program] = [
                run
                for root in self._roots(program)
                for run in self._from(program, root, fading=None)
            ]
        return self._runs[program]

    def leading(self, program: Program) -> Iterator[Run]:
        """Yield the best run of a leading line from each of its first matches.

        The best one ends first, and of these begins last; a line that may end in a repeat runs
        on as long as the whole pattern lets it.
        """
        fading = None
        for root in self._roots(program):
            fading = self._fading(program) if fading is None else fading
            runs = [run for run in self._from(program, root, fading) if not run.alone]
            if runs:
                yield min(longest(runs), key=lambda run: (run.high, -run.low))

    def _roots(self, program: Program) -> Iterator[Node]:
        for entry in program.entries:
            for match in self._board.anywhere(program.places[entry.place]):
                if all(self._board.begins(match, arrow) for arrow in entry.from_start):
                    opened = Open(match.start, match.start, match.end, match.starting)
                    groups = (opened,) * (1 + len(entry.opens))
                    yield Node(entry.place, match, State(groups, match.tokens & self._wanted))

    def _from(self, program: Program, root: Node, fading: dict[Token, float] | None) -> list[Run]:
        """Return the runs from one first match."""
        seen: dict[tuple[int, Match, State], Node] = {}
        todo, runs = [root], list[Run]()
        while todo:
            node = todo.pop()
            for leaving in program.exits[node.place]:
                runs += self._finish(root, node, leaving)
            for edge in program.edges[node.place]:
                for new in self._cross(program, node, edge, fading):
                    known = seen.setdefault((new.place, new.match, new.state), new)
                    if known is not new:
                        known.before.append(node)
                        continue
                    todo.append(new)
                    self._nodes += 1
            if self._nodes > _MOST_NODES:
                raise LanindexError(
                    f"the pattern fits in more than {_MOST_NODES} ways",
                    place=self._board.capture.path,
                    remedy='Put fewer "..." into repeats, or name the part after "without"',
                )
        return runs

    def _finish(self, root: Node, node: Node, leaving: Exit) -> Iterator[Run]:
        """Yield the runs that end at a node."""
        if node.match.passing:
            return
        for state, beside in self._leave(node, leaving):
            (line,) = state.groups
            until = node.match.until if line.alone else node.match.end
            yield Run(
                *(root.match, node, line.start, until, line.low, line.high, line.alone),
                *(state.used, beside),
            )

    def _cross(
        self, program: Program, node: Node, edge: Edge, fading: dict[Token, float] | None
    ) -> Iterator[Node]:
        """Yield the nodes to which an edge leads."""
        place, entry = program.places[edge.entry.place], edge.entry
        ways = self._leave(node, edge.exit)
        for match in self._board.following(place, node.match, edge.arrow) if ways else ():
            if not all(self._board.begins(match, arrow) for arrow in entry.from_start):
                continue
            tokens = match.tokens & self._wanted
            opened = (Open(match.start, match.start, match.end, False),) * len(entry.opens)
            for state, beside in ways:
                if tokens & state.used:
                    continue
                groups = tuple(it.widened(match.start, match.end) for it in state.groups) + opened
                used = state.used | tokens
                if fading is not None and used and not match.passing:
                    since = min([match.start, *(it.start for it in groups[2:])])
                    used = frozenset(it for it in used if fading.get(it, -inf) > since)
                yield Node(place.number, match, State(groups, used), [node], beside)

    # What stands beside.

    def _leave(self, node: Node, leaving: Exit) -> list[tuple[State, tuple[Run, ...]]]:
        """Return the ways in which the groups that end at a node can close."""
        if not all(self._board.ends(node.match, arrow) for arrow in leaving.to_end):
            return []
        ways: list[tuple[State, tuple[Run, ...]]] = [(node.state, ())]
        for group in leaving.closes:
            ways = [
                (closed, (*beside, *more))
                for state, beside in ways
                for closed, more in self._close(group, node.match, state)
            ]
        return ways

    def _close(
        self, group: Group, match: Match, state: State
    ) -> Iterator[tuple[State, tuple[Run, ...]]]:
        *outer, line = state.groups
        if group.length and line.alone:
            return
        if not self._board.meets(match.end - line.start, group.length):
            return
        until = match.until if line.alone else match.end
        ways = [Hull(line.low, line.high, state.used)]
        for companion in group.companions:
            if companion.relation != "without":
                ways = smallest(
                    way.joined(run, companion.relation)
                    for way in ways
                    for run in self._partners(companion, line, until, way.used)
                )
        for way in ways:
            if not any(
                self._disturbs(companion, line.alone, way)
                for companion in group.companions
                if companion.relation == "without"
            ):
                groups = tuple(it.widened(way.low, way.high, it.alone) for it in outer)
                yield State(groups, way.used), way.runs

    def _partners(
        self, companion: Companion, line: Open, until: int, used: frozenset[Token]
    ) -> list[Run]:
        """Return the runs that stand beside a line as a companion must."""
        agrees = RELATIONS[companion.relation]
        found = []
        for program in companion.programs:
            runs = [
                run
                for run in self.runs(program)
                if agrees(line.start, until, run, self._slack)
                and (line.alone or not run.alone)
                and not run.used & used
            ]
            found += longest(runs) if program.open_ended else runs
        return found

    def _disturbs(self, companion: Companion, alone: bool, way: Hull) -> bool:
        """Tell whether a line happens that must not."""
        return any(
            run.start < way.high
            and way.low < run.until
            and (alone or not run.alone)
            and not run.used & way.used
            for program in companion.programs
            for run in self.runs(program)
        )
