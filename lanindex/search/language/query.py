"""The syntax tree of a pattern; each node prints as a pattern that parses to the same node."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeVar

from lanindex.alphabet import DIRECTION_CODES, DIRECTIONS, KINDS, MIRRORED, kind_of
from lanindex.model.columns import GRADES
from lanindex.search.language.clauses import Condition, Stage
from lanindex.search.language.times import COUNTED, Length, decimal
from lanindex.search.language.words import ABSENT, BEND_MOVES, RESTS, WORD_KINDS, Mover, codes_of

Node = TypeVar("Node")


@dataclass(frozen=True, slots=True)
class Arrow:
    """From one step to the next: ``->``, or ``...`` (`later`), which may skip movements."""

    later: bool = False
    length: Length | None = None  # of the time between
    skips: Length | None = None  # of the number of movements between

    def __str__(self) -> str:
        limit = self.length or self.skips
        return ("..." if self.later else "->") + (f"[{limit}]" if limit else "")

    @property
    def bounds(self) -> tuple[int, int | None]:
        """The fewest and the most movements skipped, None: no limit."""
        if not self.later:
            return 0, 0
        return self.skips.bounds(COUNTED) if self.skips else (0, None)


NEXT = Arrow()


@dataclass(frozen=True, slots=True)
class Word:
    """A word of a step, with its ``/`` alternatives, in their own spelling."""

    kind: str  # a key of `words.WORD_KINDS`
    values: tuple[str, ...]
    negated: bool = False

    def __str__(self) -> str:
        return ("not " if self.negated else "") + "/".join(self.values)

    def mirrored(self) -> Word:
        """Return the mirror image; only directions of the body have one."""
        images = {it: DIRECTIONS[MIRRORED[code]] for it, code in DIRECTION_CODES.items()}
        return replace(self, values=tuple(images.get(it, it) for it in self.values))


@lru_cache(64)
def meaning(words: tuple[Word, ...], kind: str, part: str) -> frozenset[int]:
    """Return the codes of one kind that words allow, `ABSENT` only if none is of that kind."""
    left = WORD_KINDS[kind].all
    for word in words:
        if word.kind == kind:
            said = frozenset().union(*(codes_of(kind, value, part) for value in word.values))
            left = left - said - {ABSENT} if word.negated else left & said
    return left


@dataclass(frozen=True, slots=True)
class Step:
    """One movement, passage (``via``), stay (``at``) or rest (``hold``) of one part or pair."""

    mover: Mover  # also where it was carried over an arrow
    named: bool  # whether the part is written here
    manner: str = "move"  # or via, at, hold, still
    words: tuple[Word, ...] = ()

    @property
    def name(self) -> str:
        """Who moves, as a step with these words names it: the limb of an elbow that bends."""
        bend = next((word.values[0] for word in self.words if word.kind == "bend"), "")
        limb = bend and (self.manner in ("at", *RESTS) or bend.split()[0] in BEND_MOVES)
        return self.mover.name.replace("_bend", "", 1) if limb else self.mover.name

    def __str__(self) -> str:
        words = [self.name] if self.named else []
        words += [] if self.manner == "move" else [self.manner]
        return " ".join([*words, *map(str, self.words)])


@dataclass(frozen=True, slots=True)
class Bracket:
    """A pattern in brackets, which is a step."""

    pattern: Choice

    def __str__(self) -> str:
        return f"({self.pattern})"


@dataclass(frozen=True, slots=True)
class Repeat:
    """How often in a row: at least, at most (None: no limit)."""

    least: int = 1
    most: int | None = 1

    def __str__(self) -> str:
        if (self.least, self.most) in ((1, 1), (0, 1)):
            return "" if self.least else "?"
        if self.most is None:
            return f" x{self.least}+"
        return f" x{self.least}" if self.least == self.most else f" x{self.least}..{self.most}"

    @property
    def copies(self) -> int:
        """How many copies of the step a program needs."""
        return max(self.least, 1) if self.most is None else self.most


ONCE = Repeat()


@dataclass(frozen=True, slots=True)
class Item:
    """A step of a line, with its length, count and label."""

    unit: Step | Bracket
    length: Length | None = None
    repeat: Repeat = ONCE
    label: str = ""

    def __str__(self) -> str:
        label = f"{self.label}: " if self.label else ""
        return f"{label}{self.unit}{f' {self.length}' if self.length else ''}{self.repeat}"


@dataclass(frozen=True, slots=True)
class Line:
    """Steps, and the arrows between them; from the start of the clip, to its end."""

    items: tuple[Item, ...]
    arrows: tuple[Arrow, ...] = ()
    start: Arrow | None = None
    end: Arrow | None = None

    def __str__(self) -> str:
        parts = [f"start {self.start}"] if self.start else []
        parts.append(str(self.items[0]))
        for arrow, item in zip(self.arrows, self.items[1:], strict=True):
            parts += [str(arrow), str(item)]
        return " ".join([*parts, *([f"{self.end} end"] if self.end else [])])


@dataclass(frozen=True, slots=True)
class Beside:
    """A line beside the first, and how they must lie."""

    relation: str  # such as with, ending with, never
    line: Line
    within: Length | None = None  # of the time between; after with and without only <

    def __str__(self) -> str:
        limit = f"[{self.within}]" if self.within else ""
        if self.relation in ("with", "without"):
            limit = limit.replace("<", "")
        return f"{self.relation}{limit} {self.line}"


@dataclass(frozen=True, slots=True)
class Lines:
    """Lines side by side, compared with the first one."""

    first: Line
    others: tuple[Beside, ...] = ()

    def __str__(self) -> str:
        return " ".join(map(str, (self.first, *self.others)))


@dataclass(frozen=True, slots=True)
class Choice:
    """Alternatives joined by ``or``."""

    alternatives: tuple[Lines, ...]

    def __str__(self) -> str:
        return " or ".join(map(str, self.alternatives))


@dataclass(frozen=True, slots=True)
class Query:
    """A whole pattern with its clauses and stages."""

    pattern: Choice
    either_side: bool = False  # whether the mirror image will do as well
    rhythm: tuple[Fraction, ...] = ()  # the proportion of the first line's steps; empty: any
    where: tuple[Condition, ...] = ()
    stages: tuple[Stage, ...] = ()
    near: int = 0  # how far across its border a symbol may lie, in thousandths of a margin

    def __str__(self) -> str:
        parts = [str(self.pattern)]
        parts += ["either side"] if self.either_side else []
        parts += [f"rhythm {':'.join(map(decimal, self.rhythm))}"] if self.rhythm else []
        parts += [f"where {' and '.join(map(str, self.where))}"] if self.where else []
        return " | ".join([" ".join(parts), *map(str, self.stages)])

    @property
    def patterns(self) -> tuple[Choice, ...]:
        """The pattern, and its mirror image for ``either side``."""
        return (self.pattern, mirrored(self.pattern)) if self.either_side else (self.pattern,)

    @property
    def parts(self) -> frozenset[str]:
        """The parts whose tracks are needed to answer it."""
        return frozenset(it for mover in nodes_in(self.patterns, Mover) for it in mover.members)


def query_of(lines: Line | Lines) -> Query:
    """Return a query for a line, or for lines side by side."""
    return Query(Choice((Lines(lines) if isinstance(lines, Line) else lines,)))


def nodes_in(tree: object, kind: type[Node]) -> Iterator[Node]:
    """Yield the nodes of one kind in a syntax tree or a tuple of trees, as they are written."""
    todo = [tree]
    while todo:
        node = todo.pop()
        if isinstance(node, kind):
            yield node
        if isinstance(node, tuple):
            todo += reversed(node)
        else:
            names = getattr(node, "__dataclass_fields__", ())
            todo += [getattr(node, name) for name in reversed(names)]


def steps_taken(item: Item) -> int:
    """Return how many steps a program needs for an item, repeats written out."""
    if isinstance(item.unit, Step):
        return item.repeat.copies
    every = item.unit.pattern.alternatives
    lines = (line for it in every for line in (it.first, *(other.line for other in it.others)))
    return item.repeat.copies * sum(steps_taken(it) for line in lines for it in line.items)


def steps_in(line: Line) -> tuple[int, float]:
    """Return the fewest and the most steps that a line has, repeats written out."""
    least, most = 0, 0.0
    for item in line.items:
        few, many = 1, 1.0
        if isinstance(item.unit, Bracket):
            counts = [steps_in(lines.first) for lines in item.unit.pattern.alternatives]
            few, many = min(it[0] for it in counts), max(it[1] for it in counts)
        repeat = item.repeat
        least += repeat.least * few
        most += float("inf") if repeat.most is None else repeat.most * many
    return least, most


def may_begin(item: Item) -> bool:
    """Return whether a starting position fits a line's first step, without length and speed."""
    step = item.unit
    if not isinstance(step, Step) or not KINDS[kind_of(step.mover.members[0])].lasts:
        return False
    moves = any(
        word.kind in GRADES or (word.kind == "change" and not word.negated) for word in step.words
    )
    return not moves and (step.manner, item.length, item.repeat) == ("move", None, ONCE)


def last_movers(unit: Step | Bracket) -> frozenset[Mover]:
    """Return who moves last in a step, or in the leading line of each alternative."""
    if isinstance(unit, Step):
        return frozenset({unit.mover})
    units = (lines.first.items[-1].unit for lines in unit.pattern.alternatives)
    return frozenset(mover for it in units for mover in last_movers(it))


def changed_nodes(node: Any, changed: Callable[[Any], Any]) -> Any:
    """Return a tree with every node replaced by a function's result, leaves first."""
    if isinstance(node, tuple):
        return tuple(changed_nodes(it, changed) for it in node)
    names = getattr(node, "__dataclass_fields__", None)
    if names is None:
        return node
    own = {name: changed_nodes(getattr(node, name), changed) for name in names}
    return changed(replace(node, **own))


Pattern = TypeVar("Pattern", Choice, Step | Bracket)


def mirrored(pattern: Pattern) -> Pattern:
    """Return the mirror image of a pattern, a step or a bracket: of its parts and directions."""
    image: Pattern = changed_nodes(
        pattern, lambda it: it.mirrored() if isinstance(it, Mover | Word) else it
    )
    return image
