"""Walk a program through a capture: all the ways in which a line and those beside it match.

"One movement, stay or rest serves one line only"; and "what must not happen does not count where
the hit itself uses it": of the hit as a whole, so what disturbs a bracket may still be forgiven
later on.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import floor

from lanindex.errors import LanindexError
from lanindex.search.plan import Companion, Edge, Exit, Group, Program
from plain_matcher.candidates import Recording
from plain_matcher.clauses import Clauses
from plain_matcher.relations import FORBIDDEN, Stretch, stands
from plain_matcher.track import Claim
from plain_matcher.ways import Node, Open, Past, Way, longest

MOST_WAYS = 100_000
"""How many steps are taken in one capture, and lines joined, before it is given up."""


class Walker:
    """Walks the programs of one query through one capture.

    Parameters
    ----------
    recording : Recording
        The capture.
    tolerance : Fraction
        Seconds by which edges may differ that should agree.
    clauses : Clauses
        What is asked of each way, besides.
    """

    def __init__(self, recording: Recording, tolerance: Fraction, clauses: Clauses) -> None:
        self._recording, self._clauses = recording, clauses
        self._slack = floor(tolerance * recording.capture.rate)
        self._beside: dict[tuple[Program, ...], list[Way]] = {}
        self._tried = 0

    def leading(self, program: Program) -> Iterator[list[Way]]:
        """Yield, for each first match of a leading line, the ways that are all that is asked for.

        A starting position alone is no movement; nothing happens that must not. "A line that may
        end in an open count runs on for as long as the whole pattern allows".
        """
        for root in self._roots(program):
            ways = (way for way in self._from(program, root) if not way.alone and way.paid)
            yield longest(way for way in ways if self._clauses.met_by(way))

    def ways(self, line: tuple[Program, ...]) -> list[Way]:
        """Return all ways of a line that stands beside another, a program a side."""
        if line not in self._beside:
            self._beside[line] = [
                way
                for program in line
                for root in self._roots(program)
                for way in self._from(program, root)
            ]
        return self._beside[line]

    def _roots(self, program: Program) -> Iterator[Node]:
        for entry in program.entries:
            state = program.states[entry.state]
            for match in self._recording.anywhere(state):
                if all(self._recording.begins(match, arrow) for arrow in entry.from_start):
                    opened = Open(match.start, match.start, match.end, match.starting)
                    past = Past((opened,) * (1 + len(entry.opens)), match.claims)
                    yield Node(None, (), state, match, past)

    def _from(self, program: Program, node: Node) -> Iterator[Way]:
        """Yield all ways that go on from a node, those that end there first."""
        self._count()
        for leaving in program.exits[node.state.number] if node.match.may_border else ():
            for past in self._left(program, node, leaving):
                yield Way(node, past)
        for edge in program.edges[node.state.number]:
            for after in self._over(program, node, edge):
                yield from self._from(program, after)

    def _over(self, program: Program, node: Node, edge: Edge) -> Iterator[Node]:
        """Yield the nodes to which an edge leads."""
        state, entry = program.states[edge.entry.state], edge.entry
        for past in self._left(program, node, edge.exit):
            for match in self._recording.following(state, node.match, edge.arrow, edge.same):
                begins = all(self._recording.begins(match, arrow) for arrow in entry.from_start)
                if begins and not match.claims & past.used:
                    new = past.with_match(match, len(entry.opens))
                    yield Node(node, past.joined, state, match, new)

    def _left(self, program: Program, node: Node, leaving: Exit) -> list[Past]:
        """Return the ways in which the brackets that end at a node can close, inner ones first."""
        if not all(self._recording.ends(node.match, arrow) for arrow in leaving.to_end):
            return []
        pasts = [node.past]
        for group in leaving.closes:
            whole = group is program.outermost
            pasts = [it for past in pasts for it in self._closed(group, node, past, whole)]
        return pasts

    def _closed(self, group: Group, node: Node, past: Past, whole: bool) -> Iterator[Past]:
        """Yield the ways in which a bracket can close: with each choice of lines beside it."""
        match, own = node.match, past.opened[-1]
        frames = match.end - own.start
        if group.length and (own.alone or not self._recording.meets(frames, group.length)):
            return
        line = Stretch(own.start, match.until if own.alone else match.end, own.alone)
        pasts = [past]
        for companion in group.companions:
            if companion.relation not in FORBIDDEN:
                pasts = [
                    one.with_line(way, companion.relation)
                    for one in pasts
                    for way in self._partners(companion, line, Way(node, one), whole)
                ]
        for one in pasts:
            *outer, own = one.opened
            hull = Stretch(own.low, max(own.high, line.until), own.alone)
            owed = one.owed.union(*(self._disturbing(it, hull) for it in group.companions))
            opened = tuple(it.around(own.low, own.high) for it in outer)
            yield one._replace(opened=opened, owed=owed)

    def _partners(self, companion: Companion, line: Stretch, so_far: Way, whole: bool) -> list[Way]:
        """Return the lines that stand beside a line as a companion must.

        One that may end in an open count "runs on for as long as it can stand there and meets the
        conditions on its labels".
        """
        said = list(so_far.labelled()) if whole else []
        ways = []
        for way in self.ways(companion.programs):
            self._count()
            if (
                stands(companion, line, way.stretch, self._recording, self._slack)
                and not way.past.used & so_far.past.used
                and self._clauses.may_hold([*said, *way.labelled()])
            ):
                ways.append(way)
        return longest(ways)

    def _disturbing(self, companion: Companion, hull: Stretch) -> Iterator[frozenset[Claim]]:
        """Yield what the matches of a line use that must not happen beside a hull."""
        if companion.relation in FORBIDDEN:
            for way in self.ways(companion.programs):
                self._count()
                if way.paid and stands(companion, hull, way.stretch, self._recording, self._slack):
                    yield way.past.used

    def _count(self) -> None:
        self._tried += 1
        if self._tried > MOST_WAYS:
            raise LanindexError(
                f"the pattern fits in more than {MOST_WAYS} ways",
                place=self._recording.capture.path,
                remedy="Search with the engine: this is for comparing it on small captures.",
            )
