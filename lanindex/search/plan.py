"""The plan of a query: each line as a program of states and edges; nothing here knows a capture.

The states and edges are Glushkov's automaton. A line of ``arm`` becomes two programs, one a side.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

from lanindex.search.language import query as tree
from lanindex.search.language.times import Length
from lanindex.search.language.words import ANY, STILL

NEGATIONS = ("without", "never")
"""Relations to lines that must not happen."""

SIDES = ("r_", "l_")


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """A step of a line, where a match may stand."""

    number: int  # its index in the program
    members: tuple[str, ...]  # the part that moves, or the two that move together
    manner: str  # move, via, at or hold
    # by member: the codes that fit, by kind of words; no entry where any code does
    fits: tuple[dict[str, frozenset[int]], ...]
    # whether it may match a passing symbol: via anywhere in a line, a movement that says enough
    # between the first and the last
    names_passing: bool
    length: Length | None  # how long it may last
    labels: tuple[str, ...] = ()  # its own, and those of the brackets around it
    near: int = 0  # how far across its border a symbol may lie, in thousandths of a margin


@dataclass(frozen=True, slots=True, eq=False)
class Companion:
    """A line beside the leading one."""

    relation: str  # as in `Beside`
    programs: tuple[Program, ...]  # one a side
    within: Length | None = None  # how many frames may lie between


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """What must hold of a stretch of a line once it is complete: of a bracket, or of all of it."""

    length: Length | None = None
    companions: tuple[Companion, ...] = ()


@dataclass(frozen=True, slots=True)
class Entry:
    """A way into a state: the groups that open, and the arrows from the clip's start."""

    state: int
    opens: tuple[Group, ...] = ()
    from_start: tuple[tree.Arrow, ...] = ()


@dataclass(frozen=True, slots=True)
class Exit:
    """A way out of a state: the groups that close, inner ones first, and arrows to the end."""

    state: int
    closes: tuple[Group, ...] = ()
    to_end: tuple[tree.Arrow, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """From one state to the next; `same`: of the same parts."""

    exit: Exit
    arrow: tree.Arrow
    entry: Entry
    same: bool


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """One line, of one side, ready to be matched."""

    states: tuple[State, ...]  # its steps, repeats written out
    entries: tuple[Entry, ...]  # where it may begin
    edges: tuple[tuple[Edge, ...], ...]  # by state: where it may go on
    exits: tuple[tuple[Exit, ...], ...]  # by state: how it may end there
    outermost: Group  # what must hold of all of it
    brackets: tuple[Group, ...]  # those that may open in it
    open_ended: bool  # it can go on where it could end: it then runs on as long as it can

    @property
    def companions(self) -> tuple[Companion, ...]:
        """The lines beside all of it, then those beside its brackets."""
        return tuple(it for group in (self.outermost, *self.brackets) for it in group.companions)


def plan(query: tree.Query) -> tuple[Program, ...]:
    """Return the programs of the leading lines; any one of them answers the query."""
    planner = _Planner(query.near)
    return tuple(
        program
        for pattern in query.patterns
        for lines in pattern.alternatives
        for program in planner.programs(lines)
    )


def counts(pattern: tree.Choice) -> bool:
    """Return whether a pattern counts anywhere, with ``x`` or ``?``."""
    return any(repeat != tree.ONCE for repeat in tree.nodes_in(pattern, tree.Repeat))


def followers(program: Program) -> list[list[int]]:
    """Return by state the states that an edge leads to."""
    return [sorted({edge.entry.state for edge in edges}) for edges in program.edges]


def reached(following: list[list[int]], state: int) -> set[int]:
    """Return the states that may come after one, sooner or later; see `followers`."""
    found: set[int] = set()
    todo = list(following[state])
    while todo:
        other = todo.pop()
        if other not in found:
            found.add(other)
            todo += following[other]
    return found


def components(program: Program) -> list[list[int]]:
    """Return the states that lead to each other, together; what leads to others goes first."""
    following = followers(program)
    together: dict[frozenset[int], list[int]] = {}  # by the states ahead, themselves included
    for state in range(len(following)):
        together.setdefault(frozenset((state, *reached(following, state))), []).append(state)
    return [together[ahead] for ahead in sorted(together, key=len, reverse=True)]


def open_groups(program: Program) -> list[tuple[Group, ...]]:
    """Return the brackets that are open at each state, the inner ones last."""
    found: dict[int, tuple[Group, ...]] = {}
    todo = [(entry.state, entry.opens) for entry in program.entries]
    while todo:
        state, groups = todo.pop()
        if state not in found:
            found[state] = groups
            for edge in program.edges[state]:
                left = groups[: len(groups) - len(edge.exit.closes)]
                todo.append((edge.entry.state, (*left, *edge.entry.opens)))
    return [found.get(state, ()) for state in range(len(program.states))]


def _unwrapped(lines: tree.Lines) -> tree.Lines:
    """Return the lines inside brackets around all of a line: what is beside them is beside it."""
    unit = lines.first.items[0].unit
    if isinstance(unit, tree.Bracket) and lines == tree.Lines(tree.Line((tree.Item(unit),))):
        inner, *others = unit.pattern.alternatives
        if not others:
            return _unwrapped(inner)
    return lines


class _Planner:
    """Plans each line once; lines behind `without` and `never` without a border tolerance."""

    def __init__(self, near: int = 0) -> None:
        self.near = near
        self._planned: dict[tree.Line, tuple[Program, ...]] = {}
        self._exact = _Planner() if near else self

    def programs(self, lines: tree.Lines) -> tuple[Program, ...]:
        """Return the program of the first line; one for each side if a part is of either."""
        lines = _unwrapped(lines)
        group = Group(None, self.companions(lines))
        programs = tuple(_Builder(self, side).program(lines.first, group) for side in SIDES)
        right, left = ([state.members for state in it.states] for it in programs)
        return programs[:1] if right == left else programs

    def companions(self, lines: tree.Lines) -> tuple[Companion, ...]:
        found = []
        for it in lines.others:
            planner = self._exact if it.relation in NEGATIONS else self
            if it.line not in planner._planned:
                planner._planned[it.line] = planner.programs(tree.Lines(it.line))
            found.append(Companion(it.relation, planner._planned[it.line], it.within))
        return tuple(found)


@dataclass(frozen=True, slots=True)
class _Piece:
    """A piece of a program: its entries and exits, and whether it may be left out."""

    entries: list[Entry] = field(default_factory=list)
    exits: list[Exit] = field(default_factory=list)
    optional: bool = False

    def inside(self, group: Group) -> _Piece:
        """Return the piece as a group of its own."""
        return _Piece(
            [Entry(it.state, (group, *it.opens), it.from_start) for it in self.entries],
            [Exit(it.state, (*it.closes, group), it.to_end) for it in self.exits],
        )


def _up_to_required(pieces: Iterable[_Piece]) -> Iterator[_Piece]:
    """Yield pieces up to the first one that may not be left out."""
    for piece in pieces:
        yield piece
        if not piece.optional:
            break


@dataclass(slots=True)
class _Builder:
    """Builds the program of one line, for one side."""

    planner: _Planner
    side: str
    groups: list[Group] = field(default_factory=list)
    states: list[State] = field(default_factory=list)
    edges: list[list[Edge]] = field(default_factory=list)  # by the state that they leave
    labels: tuple[str, ...] = ()

    def program(self, line: tree.Line, group: Group) -> Program:
        piece = self.line(line)
        if group.companions:
            piece = piece.inside(group)
        exits: list[list[Exit]] = [[] for _ in self.states]
        for leaving in piece.exits:
            exits[leaving.state].append(leaving)
        return Program(
            tuple(self.states),
            tuple(piece.entries),
            tuple(map(tuple, self.edges)),
            tuple(map(tuple, exits)),
            group,
            tuple(self.groups),
            any(ends and goes_on for ends, goes_on in zip(exits, self.edges, strict=True)),
        )

    def line(self, line: tree.Line) -> _Piece:
        pieces = [self.item(item) for item in line.items]
        for last, piece in enumerate(pieces):
            for before in _up_to_required(reversed(pieces[:last])):
                self.join(before, line.arrows[last - 1], piece)
        entries = []
        for piece, arrow in zip(_up_to_required(pieces), (line.start, *line.arrows), strict=False):
            # a step that is left out takes the arrow before it along
            start = (arrow,) if line.start and arrow else ()
            entries += [Entry(it.state, it.opens, (*it.from_start, *start)) for it in piece.entries]
        end = (line.end,) if line.end else ()
        exits = [it for piece in _up_to_required(reversed(pieces)) for it in piece.exits]
        return _Piece(entries, [Exit(it.state, it.closes, (*it.to_end, *end)) for it in exits])

    def join(self, before: _Piece, arrow: tree.Arrow, after: _Piece) -> None:
        for leaving in before.exits:
            members = self.states[leaving.state].members
            for entry in after.entries:
                same = members == self.states[entry.state].members
                self.edges[leaving.state].append(Edge(leaving, arrow, entry, same))

    def item(self, item: tree.Item) -> _Piece:
        repeat, around = item.repeat, self.labels
        self.labels = (*around, item.label) if item.label else around
        copies = [self.unit(item) for _ in range(repeat.copies)]
        self.labels = around
        for before, after in pairwise(copies):
            self.join(before, tree.NEXT, after)
        if repeat.most is None:
            self.join(copies[-1], tree.NEXT, copies[-1])
        ends = copies[max(repeat.least, 1) - 1 :]
        return _Piece(
            copies[0].entries, [it for copy in ends for it in copy.exits], not repeat.least
        )

    def unit(self, item: tree.Item) -> _Piece:
        if isinstance(item.unit, tree.Step):
            return self.step(item.unit, item.length)
        piece = _Piece()
        for lines in item.unit.pattern.alternatives:
            inner = self.line(lines.first)
            if item.length or lines.others:
                group = Group(item.length, self.planner.companions(lines))
                self.groups.append(group)
                inner = inner.inside(group)
            piece.entries.extend(inner.entries)
            piece.exits.extend(inner.exits)
        return piece

    def step(self, step: tree.Step, length: Length | None) -> _Piece:
        number, members, manner = len(self.states), step.mover.members, step.manner
        if step.mover.form == "either":
            members = tuple(member for member in members if member.startswith(self.side))
        positive = any(not word.negated and word.values != (ANY,) for word in step.words)
        changing = any(word.kind == "change" for word in step.words)
        names_passing = manner == "via" or (manner == "move" and positive and not changing)
        wanted, near = tuple(fits(step, member) for member in members), self.planner.near
        if manner == STILL:
            manner, wanted = "hold", tuple(it | {STILL: frozenset({0})} for it in wanted)
        self.states.append(
            State(number, members, manner, wanted, names_passing, length, self.labels, near)
        )
        self.edges.append([])
        return _Piece([Entry(number)], [Exit(number)])


def fits(step: tree.Step, part: str) -> dict[str, frozenset[int]]:
    """Return the codes that fit a step, said of one part, by the kinds of its words."""
    kinds = dict.fromkeys(word.kind for word in step.words if ANY not in word.values)
    return {kind: tree.meaning(step.words, kind, part) for kind in kinds}
