"""Walk a program through a capture: all the ways in which a line and those beside it match.

A walk goes from match to match. Two ways that stand at the same match, with the same brackets
open and the same hull, are one node, so their number stays small whatever the pattern repeats.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from heapq import heappop, heappush
from math import floor, inf

from lanindex.errors import LanindexError
from lanindex.search.automaton import Companion, Edge, Exit, Group, Program
from lanindex.search.plain.candidates import Board, Match
from lanindex.search.plain.paths import RELATIONS, Hull, Node, Open, Run, State, longest, smallest
from lanindex.search.plain.track import Origin, Token

MOST_NODES = 200_000
"""How many nodes a walk from one first match may have, before it is given up."""


class Walk:
    """What the nodes of one walk have in common.

    Parameters
    ----------
    program : Program
        Which is walked.
    fading : dict of Token to float, optional
        Until when a line beside may want what the walk has used; without it nothing fades.
    """

    def __init__(self, program: Program, fading: dict[Token, float] | None) -> None:
        self.program = program
        self._fading = fading
        self._inner = 2 if program.whole.companions else 1
        self._crossed: set[tuple[Edge, int, State]] | None = None if program.open_ended else set()

    def fresh(
        self, edge: Edge, origins: tuple[Origin, ...], ways: list[tuple[State, tuple[Run, ...]]]
    ) -> list[tuple[State, tuple[Run, ...]]]:
        """Return the ways over an edge that lead to what was not reached before.

        All that is later than a node is also later than an earlier one, and those go first.
        """
        if not edge.open or len(origins) > 1 or self._crossed is None:
            return ways
        keys = [(edge, origins[0].stretch, state) for state, _ in ways]
        fresh = [way for way, key in zip(ways, keys, strict=True) if key not in self._crossed]
        self._crossed.update(keys)
        return fresh

    def kept(
        self, used: frozenset[Token], match: Match, groups: tuple[Open, ...]
    ) -> frozenset[Token]:
        """Return of what was used what a line beside may still want."""
        fading = self._fading
        if fading is None or not used or match.passing:
            return used
        since = min([match.start, *(it.start for it in groups[self._inner :])])
        return frozenset([token for token in used if fading.get(token, -inf) > since])


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
        self._closed: dict[tuple[Group, Match, Open, frozenset[Token]], list[Hull]] = {}

    # Which movements more than one line may want.

    @cached_property
    def _wanted(self) -> frozenset[Token]:
        wanted: set[Token] = set()
        for program in self._programs:
            if any(group.companions for group in (program.whole, *program.brackets)):
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
        for group in (program.whole, *program.brackets):
            for companion in group.companions:
                for inner in companion.programs:
                    self._tally(inner, lines if group is program.whole else 2, tally)

    def _fading(self, program: Program) -> dict[Token, float]:
        """Return until which frame a line beside a leading one may still want a movement.

        What has faded need not be remembered: so a long wave of brackets stays one walk.
        """
        until: dict[Token, float] = {}
        for group in (program.whole, *program.brackets) if self._wanted else ():
            for companion in group.companions:
                for inner in companion.programs:
                    for run in self.runs(inner):
                        end = inf if group is program.whole else run.until + self._slack
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
                    opened = Open(match.start, match.start, 0, match.starting)
                    groups = (opened,) * (1 + len(entry.opens))
                    yield Node(entry.place, match, State(groups, self._tokens(match)))

    def _tokens(self, match: Match) -> frozenset[Token]:
        return match.tokens & self._wanted if self._wanted else self._wanted

    def _from(self, program: Program, root: Node, fading: dict[Token, float] | None) -> list[Run]:
        """Return the runs from one first match; earlier nodes go first."""
        walk = Walk(program, fading)
        seen: dict[tuple[int, Match, State], Node] = {}
        todo, runs = [(0, 0, 0, root)], list[Run]()
        while todo:
            node = heappop(todo)[-1]
            for leaving in program.exits[node.place]:
                runs += self._finish(root, node, leaving)
            for edge in program.edges[node.place]:
                for new in self._cross(walk, node, edge):
                    known = seen.setdefault((new.place, new.match, new.state), new)
                    if known is new:
                        row = new.match.events[0].last
                        heappush(todo, (new.match.end, row, len(seen), new))
                    else:
                        known.before.append(node)
            if len(seen) > MOST_NODES:
                raise LanindexError(
                    f"the pattern fits in more than {MOST_NODES} ways",
                    place=self._board.capture.path,
                    remedy='Put fewer "..." into repeats, or name the part after "without"',
                )
        return runs

    def _finish(self, root: Node, node: Node, leaving: Exit) -> Iterator[Run]:
        """Yield the runs that end at a node."""
        if node.match.passing:
            return
        end = node.match.end
        for state, beside in self._leave(node, leaving):
            (line,) = state.groups
            until = node.match.until if line.alone else end
            yield Run(
                *(root.match, node, line.start, until, line.low, max(line.beyond, end)),
                *(line.alone, state.used, beside),
            )

    def _cross(self, walk: Walk, node: Node, edge: Edge) -> Iterator[Node]:
        """Yield the nodes to which an edge leads."""
        place, entry = walk.program.places[edge.entry.place], edge.entry
        origins = self._board.origins(place, node.match, edge.same)
        ways = walk.fresh(edge, origins, self._leave(node, edge.exit)) if origins else []
        if not origins or not ways:
            return
        for match in self._board.following(place, origins, node.match, edge.arrow):
            if not all(self._board.begins(match, arrow) for arrow in entry.from_start):
                continue
            tokens = self._tokens(match)
            opened = (Open(match.start, match.start, 0, False),) * len(entry.opens)
            for (groups, used), beside in ways:
                if tokens & used:
                    continue
                moved = tuple([it.moved(match.start, match.end) for it in groups])
                kept = walk.kept(used | tokens, match, moved) if self._wanted else used
                yield Node(place.number, match, State(moved + opened, kept), [node], beside)

    # What stands beside.

    def _leave(self, node: Node, leaving: Exit) -> list[tuple[State, tuple[Run, ...]]]:
        """Return the ways in which the groups that end at a node can close."""
        if leaving.to_end and not all(
            self._board.ends(node.match, arrow) for arrow in leaving.to_end
        ):
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
        key = (group, match, line, state.used)
        if key not in self._closed:
            self._closed[key] = self._hulls(group, match, line, state.used)
        for hull in self._closed[key]:
            groups = tuple([it.beside(hull.low, hull.high, match.end) for it in outer])
            yield State(groups, hull.used), hull.runs

    def _hulls(self, group: Group, match: Match, line: Open, used: frozenset[Token]) -> list[Hull]:
        """Return what a group can hold once its line has come to an end."""
        if group.length and line.alone:
            return []
        if not self._board.meets(match.end - line.start, group.length):
            return []
        until = match.until if line.alone else match.end
        hulls = [Hull(line.low, max(line.beyond, match.end), used)]
        for companion in group.companions:
            if companion.relation != "without":
                hulls = smallest(
                    hull.joined(run, companion.relation)
                    for hull in hulls
                    for run in self._partners(companion, line, until, hull.used)
                )
        without = [it for it in group.companions if it.relation == "without"]
        return [
            hull
            for hull in hulls
            if not any(self._disturbs(companion, line.alone, hull) for companion in without)
        ]

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

    def _disturbs(self, companion: Companion, alone: bool, hull: Hull) -> bool:
        """Tell whether a line happens that must not."""
        return any(
            run.start < hull.high
            and hull.low < run.until
            and (alone or not run.alone)
            and not run.used & hull.used
            for program in companion.programs
            for run in self.runs(program)
        )
