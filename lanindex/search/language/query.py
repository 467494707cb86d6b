"""What a pattern says, as a tree: what the parser builds, and the matcher and the explainer read.

Every node prints as a pattern that parses to the same node. A step always knows who moves, also
where the part was carried over an arrow; `Step.named` tells whether it was written there. Mirror
images are taken while parsing, so that nobody below has to think of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

from lanindex.search.language.bending import written
from lanindex.search.language.clauses import Condition, Stage
from lanindex.search.language.times import Length, decimal
from lanindex.search.language.words import ABSENT, WORD_KINDS, Mover, mirrored_value, values_of


@dataclass(frozen=True, slots=True)
class Skips:
    """A condition on the number of movements between: ``[<=2]``."""

    form: str
    count: int

    def __str__(self) -> str:
        """Return it as written, without the brackets."""
        return f"{self.form}{self.count}"

    @property
    def bounds(self) -> tuple[int, int | None]:
        """The fewest and the most, None: no limit."""
        below = {"": self.count, "<": self.count - 1, "<=": self.count}
        above = {"": self.count, ">": self.count + 1, ">=": self.count}
        return above.get(self.form, 0), below.get(self.form)


@dataclass(frozen=True, slots=True)
class Arrow:
    """From one step to the next: ``->`` or ``...``, with a limit on what lies between.

    Attributes
    ----------
    later : bool
        Whether movements may be skipped: ``...``.
    length : Length or None
        A condition on the time between.
    skips : Skips or None
        A condition on the number of movements skipped.
    """

    later: bool = False
    length: Length | None = None
    skips: Skips | None = None

    def __str__(self) -> str:
        """Return it as written, without spaces around."""
        limit = self.length or self.skips
        return ("..." if self.later else "->") + (f"[{limit}]" if limit else "")

    @property
    def bounds(self) -> tuple[int, int | None]:
        """The fewest and the most movements skipped, None: no limit."""
        if not self.later:
            return 0, 0
        return self.skips.bounds if self.skips else (0, None)


NEXT = Arrow()


@dataclass(frozen=True, slots=True)
class Word:
    """A word of a step, with its ``/`` alternatives.

    Attributes
    ----------
    kind : str
        One of ``words.WORD_KINDS``: ``direction``, ``level``, ``change``.
    values : tuple of str
        In their own spelling.
    negated : bool
        Whether ``not`` stands before.
    """

    kind: str
    values: tuple[str, ...]
    negated: bool = False

    def __str__(self) -> str:
        """Return it as written."""
        return ("not " if self.negated else "") + "/".join(self.values)

    def mirrored(self) -> Word:
        """Return the mirror image."""
        return replace(self, values=tuple(mirrored_value(self.kind, it) for it in self.values))


def meaning(words: tuple[Word, ...], kind: str, part: str) -> frozenset[str]:
    """Return what the words of one kind leave of that kind, said of one part.

    Parameters
    ----------
    words : tuple of Word
        Of a step.
    kind : str
        Of ``words.WORD_KINDS``; to ``change`` belongs ``neither``, to ``pace`` ``usual``.
    part : str
        ``l_arm``; tells what ``side`` is.

    Returns
    -------
    frozenset of str
        With ``words.ABSENT`` only where they say nothing: also ``not`` needs something to deny.
    """
    left = frozenset((*WORD_KINDS[kind].codes, ABSENT))
    for word in words:
        if word.kind == kind:
            said = frozenset().union(*(values_of(kind, value, part) for value in word.values))
            left = left - said - {ABSENT} if word.negated else left & said
    return left


@dataclass(frozen=True, slots=True)
class Step:
    """One movement, passage (``via``), stay (``at``) or rest (``hold``) of one part or pair.

    Attributes
    ----------
    mover : Mover
        Who moves, also where it was carried over an arrow.
    named : bool
        Whether the part is written here.
    manner : str
        ``move``, ``via``, ``at`` or ``hold``.
    words : tuple of Word
        Direction, level and change.
    """

    mover: Mover
    named: bool
    manner: str = "move"
    words: tuple[Word, ...] = ()

    def __str__(self) -> str:
        """Return it as written."""
        told = next((word.values[0] for word in self.words if word.kind == "bend"), "")
        said = [written(self.mover.name, self.manner, told)] if self.named else []
        said += [] if self.manner == "move" else [self.manner]
        return " ".join([*said, *map(str, self.words)])


@dataclass(frozen=True, slots=True)
class Bracket:
    """A pattern in brackets: a step made of steps."""

    pattern: Choice

    def __str__(self) -> str:
        """Return it as written."""
        return f"({self.pattern})"


@dataclass(frozen=True, slots=True)
class Repeat:
    """How often in a row: at least, at most (None: no limit)."""

    least: int = 1
    most: int | None = 1

    def __str__(self) -> str:
        """Return it as written; once is not written."""
        if (self.least, self.most) == (1, 1):
            return ""
        if (self.least, self.most) == (0, 1):
            return "?"
        if self.most is None:
            return f" x{self.least}+"
        return f" x{self.least}" if self.least == self.most else f" x{self.least}..{self.most}"

    @property
    def copies(self) -> int:
        """How many copies of the step a matcher needs."""
        return max(self.least, 1) if self.most is None else self.most


ONCE = Repeat()


@dataclass(frozen=True, slots=True)
class Item:
    """A step of a line with its length, its count, and the label by which it is spoken of."""

    unit: Step | Bracket
    length: Length | None = None
    repeat: Repeat = ONCE
    label: str = ""

    def __str__(self) -> str:
        """Return it as written."""
        return (
            (f"{self.label}: " if self.label else "")
            + str(self.unit)
            + (f" {self.length}" if self.length else "")
            + str(self.repeat)
        )

    @property
    def optional(self) -> bool:
        """Whether it may be left out."""
        return self.repeat.least == 0


@dataclass(frozen=True, slots=True)
class Line:
    """Steps joined by arrows.

    Attributes
    ----------
    items : tuple of Item
        The steps, one or more.
    arrows : tuple of Arrow
        Between them, one fewer.
    start, end : Arrow or None
        From the clip's start, to its end.
    """

    items: tuple[Item, ...]
    arrows: tuple[Arrow, ...] = ()
    start: Arrow | None = None
    end: Arrow | None = None

    def __str__(self) -> str:
        """Return it as written."""
        said = [f"start {self.start}"] if self.start else []
        said.append(str(self.items[0]))
        for arrow, item in zip(self.arrows, self.items[1:], strict=True):
            said += [str(arrow), str(item)]
        return " ".join([*said, *([f"{self.end} end"] if self.end else [])])


@dataclass(frozen=True, slots=True)
class Beside:
    """A line beside the first, and how they must lie.

    Attributes
    ----------
    relation : str
        ``with``, ``during``, ``starting with``, ``ending with``, ``exactly with``, ``after``,
        ``before``, ``without`` or ``never``.
    line : Line
        The other line.
    within : Length or None
        A condition on the frames that lie between the two: of ``with[1s]`` and ``without[1s]`` less
        than that, of ``after`` and ``before`` any length, as on an arrow.
    """

    relation: str
    line: Line
    within: Length | None = None

    def __str__(self) -> str:
        """Return it as written."""
        limit = str(self.within or "")
        if self.within and self.relation in ("with", "without"):
            limit = limit.removeprefix("<")  # less than that is all it can mean
        return f"{self.relation}{f'[{limit}]' if limit else ''} {self.line}"


@dataclass(frozen=True, slots=True)
class Lines:
    """Lines side by side; the first one leads."""

    first: Line
    others: tuple[Beside, ...] = ()

    def __str__(self) -> str:
        """Return it as written."""
        return " ".join(map(str, (self.first, *self.others)))


@dataclass(frozen=True, slots=True)
class Choice:
    """Lines joined by ``or``: any one of them will do."""

    alternatives: tuple[Lines, ...]

    def __str__(self) -> str:
        """Return it as written."""
        return " or ".join(map(str, self.alternatives))


@dataclass(frozen=True, slots=True)
class Query:
    """A whole pattern with its clauses, and what becomes of its hits.

    Attributes
    ----------
    pattern : Choice
        What to find.
    either_side : bool
        Whether its mirror image will do as well.
    rhythm : tuple of Fraction
        In which proportion the steps of the first line last; empty: in any.
    where : tuple of Condition
        What must be true of each hit.
    stages : tuple of Stage
        The pipe that the hits go through, in order.
    near : int
        How far across its border a symbol may lie, in thousandths of a margin; no text says so.
    """

    pattern: Choice
    either_side: bool = False
    rhythm: tuple[Fraction, ...] = ()
    where: tuple[Condition, ...] = ()
    stages: tuple[Stage, ...] = ()
    near: int = 0

    def __str__(self) -> str:
        """Return the query as a pattern text."""
        said = [str(self.pattern)]
        said += ["either side"] if self.either_side else []
        said += [f"rhythm {':'.join(map(decimal, self.rhythm))}"] if self.rhythm else []
        said += [f"where {' and '.join(map(str, self.where))}"] if self.where else []
        return " | ".join([" ".join(said), *map(str, self.stages)])

    @property
    def patterns(self) -> tuple[Choice, ...]:
        """The pattern, and its mirror image if that will do as well."""
        return (self.pattern, mirrored(self.pattern)) if self.either_side else (self.pattern,)

    @property
    def parts(self) -> frozenset[str]:
        """The parts whose tracks are needed to answer it."""
        steps = [step for pattern in self.patterns for step in steps_of(pattern)]
        return frozenset(part for step in steps for part in step.mover.members)


def items_of(pattern: Choice) -> Iterator[Item]:
    """Yield every item of a pattern that is a step, brackets opened."""
    for lines in pattern.alternatives:
        for line in (lines.first, *(beside.line for beside in lines.others)):
            for item in line.items:
                if isinstance(item.unit, Bracket):
                    yield from items_of(item.unit.pattern)
                else:
                    yield item


def steps_of(pattern: Choice) -> Iterator[Step]:
    """Yield every step of a pattern, as written."""
    return (item.unit for item in items_of(pattern) if isinstance(item.unit, Step))


def steps_taken(item: Item) -> int:
    """Return how many steps a matcher needs for an item, repeats written out."""
    if isinstance(item.unit, Step):
        return item.repeat.copies
    alternatives = item.unit.pattern.alternatives
    lines = [line for it in alternatives for line in (it.first, *(it.line for it in it.others))]
    return item.repeat.copies * sum(steps_taken(inner) for line in lines for inner in line.items)


def last_movers(pattern: Choice) -> frozenset[Mover]:
    """Return who moves last in the leading line of each alternative."""
    found: set[Mover] = set()
    for lines in pattern.alternatives:
        unit = lines.first.items[-1].unit
        found |= {unit.mover} if isinstance(unit, Step) else last_movers(unit.pattern)
    return frozenset(found)


def mirrored(pattern: Choice) -> Choice:
    """Return the mirror image of a pattern: of its parts and of its directions."""
    return Choice(
        tuple(
            Lines(
                _mirrored_line(lines.first),
                tuple(replace(it, line=_mirrored_line(it.line)) for it in lines.others),
            )
            for lines in pattern.alternatives
        )
    )


def _mirrored_line(line: Line) -> Line:
    return replace(line, items=tuple(replace(it, unit=mirrored_unit(it.unit)) for it in line.items))


def mirrored_unit(unit: Step | Bracket) -> Step | Bracket:
    """Return the mirror image of a step or bracket."""
    if isinstance(unit, Bracket):
        return Bracket(mirrored(unit.pattern))
    words = tuple(word.mirrored() for word in unit.words)
    return replace(unit, mover=unit.mover.mirrored(), words=words)
