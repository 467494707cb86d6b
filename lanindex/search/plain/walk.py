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
from lanindex.search.plain.candidates import Match, Recording
from lanindex.search.plain.paths import RELATIONS, Hull, Memory, Node, Open, Path, longest, smallest
from lanindex.search.plain.track import Claim, Origin

MOST_NODES = 200_000
"""How many nodes a walk from one first match may have, before it is given up."""


class Walk:
    """What the nodes of one walk have in common.

    Parameters
    ----------
    program : Program
        Which is walked.
    fading : dict of Claim to float, optional
        Until when a line beside may want what the walk has used; without it nothing fades.
    """

    def __init__(self, program: Program, fading: dict[Claim, float] | None) -> None:
        self.program = program
        self._fading = fading
        self._inner = 2 if program.whole.companions else 1
        self._crossed: set[tuple[Edge, int, Memory]] | None = None if program.open_ended else set()

    def fresh(
        self, edge: Edge, origins: tuple[Origin, ...], ways: list[tuple[Memory, tuple[Path, ...]]]
    ) -> list[tuple[Memory, tuple[Path, ...]]]:
        """Return the ways over an edge that lead to what was not reached before.

        All that is later than a node is also later than an earlier one, and those go first.
        """
        if not edge.open or len(origins) > 1 or self._crossed is None:
            return ways
        keys = [(edge, origins[0].stretch, memory) for memory, _ in ways]
        fresh = [way for way, key in zip(ways, keys, strict=True) if key not in self._crossed]
        self._crossed.update(keys)
        return fresh

    def kept(
        self, used: frozenset[Claim], match: Match, groups: tuple[Open, ...]
    ) -> frozenset[Claim]:
        """Return of what was used what a line beside may still want."""
        fading = self._fading
        if fading is None or not used or match.passing:
            return used
        since = min([match.start, *(it.start for it in groups[self._inner :])])
        return frozenset([claim for claim in used if fading.get(claim, -inf) > since])


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
    """

    def __init__(
        self, recording: Recording, programs: Sequence[Program], tolerance: Fraction
    ) -> None:
        self._recording, self._programs = recording, programs
        self._slack = floor(tolerance * recording.capture.rate)
        self._paths: dict[Program, list[Path]] = {}
        self._closed: dict[tuple[Group, Match, Open, frozenset[Claim]], list[Hull]] = {}

    # Which movements more than one line may want.

    @cached_property
    def _wanted(self) -> frozenset[Claim]:
        wanted: set[Claim] = set()
        for program in self._programs:
            if any(group.companions for group in (program.whole, *program.brackets)):
                tally: Counter[Claim] = Counter()
                self._tally(program, 1, tally)
                wanted |= {claim for claim, lines in tally.items() if lines > 1}
        return frozenset(wanted)

    def _tally(self, program: Program, lines: int, tally: Counter[Claim]) -> None:
        """Count how many lines may want a movement; a line in a bracket may come again."""
        for claim in {
            claim
            for state in program.states
            for events in self._recording.events(state)
            for event in events
            for claim in event.claims
        }:
            tally[claim] += lines
        for group in (program.whole, *program.brackets):
            for companion in group.companions:
                for inner in companion.programs:
                    self._tally(inner, lines if group is program.whole else 2, tally)

    def _fading(self, program: Program) -> dict[Claim, float]:
        """Return until which frame a line beside a leading one may still want a movement.

        What has faded need not be remembered: so a long wave of brackets stays one walk.
        """
        until: dict[Claim, float] = {}
        for group in (program.whole, *program.brackets) if self._wanted else ():
            for companion in group.companions:
                for inner in companion.programs:
                    for path in self.paths(inner):
                        end = inf if group is program.whole else path.until + self._slack
                        until.update({it: max(end, until.get(it, 0)) for it in path.used})
        return until

    # Walking.

    def paths(self, program: Program) -> list[Path]:
        """Return all paths of a line that stands beside another, from wherever it can begin."""
        if program not in self._paths:
            self._paths[program] = [
                path
                for root in self._roots(program)
                for _, ending in self._from(program, root, fading=None)
                for path in ending
            ]
        return self._paths[program]

    def leading(self, program: Program) -> Iterator[Path]:
        """Yield the best path of a leading line from each of its first matches.

        The best one ends first, and of these begins last; a line that may end in a repeat runs
        on as long as the whole pattern lets it.
        """
        fading = None
        for root in self._roots(program):
            fading = self._fading(program) if fading is None else fading
            best = self._best(program, self._from(program, root, fading))
            if best:
                yield best

    def _best(self, program: Program, ends: Iterator[tuple[int, list[Path]]]) -> Path | None:
        """Return the path of all that begin alike that ends first, and of these begins last.

        No path ends before the last match of its own line, and the walk finds those in order of
        time: so it may stop behind the first end, where a line does not run on.
        """
        paths: list[Path] = []
        first: float = inf
        for end, ending in ends:
            if end > first:
                break
            paths += [path for path in ending if not path.alone]
            if not program.open_ended:
                first = min([first, *(path.high for path in ending if not path.alone)])
        return min(longest(paths), key=lambda path: (path.high, -path.low), default=None)

    def _roots(self, program: Program) -> Iterator[Node]:
        for entry in program.entries:
            for match in self._recording.anywhere(program.states[entry.state]):
                if all(self._recording.begins(match, arrow) for arrow in entry.from_start):
                    opened = Open(match.start, match.start, 0, match.starting)
                    groups = (opened,) * (1 + len(entry.opens))
                    yield Node(entry.state, match, Memory(groups, self._claims(match)))

    def _claims(self, match: Match) -> frozenset[Claim]:
        return match.claims & self._wanted if self._wanted else self._wanted

    def _from(
        self, program: Program, root: Node, fading: dict[Claim, float] | None
    ) -> Iterator[tuple[int, list[Path]]]:
        """Yield what ends at each node that one first match leads to; earlier nodes go first."""
        walk = Walk(program, fading)
        seen: dict[tuple[int, Match, Memory], Node] = {}
        todo = [(root.match.end, 0, 0, root)]
        while todo:
            end, *_, node = heappop(todo)
            yield (
                end,
                [
                    path
                    for way in program.exits[node.state]
                    for path in self._finish(root, node, way)
                ],
            )
            for edge in program.edges[node.state]:
                for new in self._cross(walk, node, edge):
                    known = seen.setdefault((new.state, new.match, new.memory), new)
                    if known is new:
                        row = new.match.events[0].last
                        heappush(todo, (new.match.end, row, len(seen), new))
                    else:
                        known.before.append(node)
            if len(seen) > MOST_NODES:
                raise LanindexError(
                    f"the pattern fits in more than {MOST_NODES} ways",
                    place=self._recording.capture.path,
                    remedy='Put fewer "..." into repeats, or name the part after "without"',
                )

    def _finish(self, root: Node, node: Node, leaving: Exit) -> Iterator[Path]:
        """Yield the paths that end at a node."""
        if node.match.passing:
            return
        end = node.match.end
        for memory, beside in self._leave(node, leaving):
            (line,) = memory.groups
            until = node.match.until if line.alone else end
            yield Path(
                *(root.match, node, line.start, until, line.low, max(line.beyond, end)),
                *(line.alone, memory.used, beside),
            )

    def _cross(self, walk: Walk, node: Node, edge: Edge) -> Iterator[Node]:
        """Yield the nodes to which an edge leads."""
        state, entry = walk.program.states[edge.entry.state], edge.entry
        origins = self._recording.origins(state, node.match, edge.same)
        ways = walk.fresh(edge, origins, self._leave(node, edge.exit)) if origins else []
        if not origins or not ways:
            return
        for match in self._recording.following(state, origins, node.match, edge.arrow):
            if not all(self._recording.begins(match, arrow) for arrow in entry.from_start):
                continue
            claims = self._claims(match)
            opened = (Open(match.start, match.start, 0, False),) * len(entry.opens)
            for (groups, used), beside in ways:
                if claims & used:
                    continue
                moved = tuple([it.moved(match.start, match.end) for it in groups])
                kept = walk.kept(used | claims, match, moved) if self._wanted else used
                yield Node(state.number, match, Memory(moved + opened, kept), [node], beside)

    # What stands beside.

    def _leave(self, node: Node, leaving: Exit) -> list[tuple[Memory, tuple[Path, ...]]]:
        """Return the ways in which the groups that end at a node can close."""
        if leaving.to_end and not all(
            self._recording.ends(node.match, arrow) for arrow in leaving.to_end
        ):
            return []
        ways: list[tuple[Memory, tuple[Path, ...]]] = [(node.memory, ())]
        for group in leaving.closes:
            ways = [
                (closed, (*beside, *more))
                for memory, beside in ways
                for closed, more in self._close(group, node.match, memory)
            ]
        return ways

    def _close(
        self, group: Group, match: Match, memory: Memory
    ) -> Iterator[tuple[Memory, tuple[Path, ...]]]:
        *outer, line = memory.groups
        key = (group, match, line, memory.used)
        if key not in self._closed:
            self._closed[key] = self._hulls(group, match, line, memory.used)
        for hull in self._closed[key]:
            groups = tuple([it.beside(hull.low, hull.high, match.end) for it in outer])
            yield Memory(groups, hull.used), hull.paths

    def _hulls(self, group: Group, match: Match, line: Open, used: frozenset[Claim]) -> list[Hull]:
        """Return what a group can hold once its line has come to an end."""
        if group.length and line.alone:
            return []
        if not self._recording.meets(match.end - line.start, group.length):
            return []
        until = match.until if line.alone else match.end
        hulls = [Hull(line.low, max(line.beyond, match.end), used)]
        for companion in group.companions:
            if companion.relation != "without":
                hulls = smallest(
                    hull.joined(path, companion.relation)
                    for hull in hulls
                    for path in self._partners(companion, line, until, hull.used)
                )
        without = [it for it in group.companions if it.relation == "without"]
        return [
            hull
            for hull in hulls
            if not any(self._disturbs(companion, line.alone, hull) for companion in without)
        ]

    def _partners(
        self, companion: Companion, line: Open, until: int, used: frozenset[Claim]
    ) -> list[Path]:
        """Return the paths that stand beside a line as a companion must."""
        agrees = RELATIONS[companion.relation]
        found = []
        for program in companion.programs:
            paths = [
                path
                for path in self.paths(program)
                if agrees(line.start, until, path, self._slack)
                and (line.alone or not path.alone)
                and not path.used & used
            ]
            found += longest(paths) if program.open_ended else paths
        return found

    def _disturbs(self, companion: Companion, alone: bool, hull: Hull) -> bool:
        """Tell whether a line happens that must not."""
        return any(
            path.start < hull.high
            and hull.low < path.until
            and (alone or not path.alone)
            and not path.used & hull.used
            for program in companion.programs
            for path in self.paths(program)
        )
