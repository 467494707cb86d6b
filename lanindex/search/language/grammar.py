"""Pattern text → Query: the grammar, read from left to right."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from lanindex.errors import PatternError
from lanindex.search.language.cursor import Cursor
from lanindex.search.language.endings import Endings
from lanindex.search.language.lexer import Token
from lanindex.search.language.measures import arrow_at, length_at, repeat_at, within_at
from lanindex.search.language.mistakes import stray
from lanindex.search.language.names import ANYONE, Names, label_at, name_at, within
from lanindex.search.language.natural import offer_reading
from lanindex.search.language.query import (
    ONCE,
    Arrow,
    Beside,
    Bracket,
    Choice,
    Item,
    Line,
    Lines,
    Query,
    Step,
    last_movers,
    mirrored_unit,
    steps_taken,
)
from lanindex.search.language.saved import Saved
from lanindex.search.language.score import is_lnd, score_at
from lanindex.search.language.steps import step_at
from lanindex.search.language.times import Length
from lanindex.search.language.words import (
    ONE_WORD_RELATIONS,
    TWO_WORD_RELATIONS,
    Mover,
    Vocabulary,
)

_LONGEST = 10_000
_DEEPEST = 40
_MOST_STEPS = 1000


def parse(
    text: str,
    parts: Collection[str] | None = None,
    *,
    names: Mapping[str, str] | None = None,
    strict: bool = False,
) -> Query:
    """Read a pattern.

    Parameters
    ----------
    text : str
        In the pattern language; one from `saved.pattern_in` names its file in errors.
    parts : collection of str, optional
        The parts that the library has; a pattern may name those of the alphabet, too.
    names : Mapping of str to str, optional
        Names in small letters that the pattern may use besides those that it gives itself, and
        the pattern that each stands for: ``@raise``.
    strict : bool
        Whether the timing of pasted LND counts.

    Returns
    -------
    Query
        The pattern as a tree; ``str()`` of it is a pattern again.

    Raises
    ------
    PatternError
        The pattern cannot be understood; says where and why.

    Examples
    --------
    >>> from lanindex.errors import PatternError
    >>> from lanindex.search.language import parse
    >>> sorted(parse("r_arm right mid -> high with head").parts)
    ['head', 'r_arm']
    >>> try:
    ...     parse("r_arm rihgt")
    ... except PatternError as error:
    ...     print(error)
    r_arm rihgt
          ^^^^^
    I don't know "rihgt". Did you mean "right"?
    """
    vocabulary = Vocabulary(parts)

    def read(text: str) -> Query:
        return _Parser(Cursor(text, vocabulary), Names(names or {}), strict).query()

    try:
        if len(text) > _LONGEST:
            raise PatternError(
                f"A pattern of {len(text)} characters; {_LONGEST} is the most.",
                text=f"{text[:60]}…",
                start=60,
                stop=61,
            )
        return read(str(text))
    except PatternError as error:
        offer_reading(error, read, vocabulary.parts)
        if isinstance(text, Saved):
            error.place = text.place(error.start)
        raise


class _Parser:
    """One method a rule of the grammar; each reads its tokens and returns its node."""

    def __init__(self, cursor: Cursor, names: Names, strict: bool) -> None:
        self.cursor, self.names, self.strict = cursor, names, strict
        self.labels: dict[str, tuple[Token, Token]] = {}
        self.depth = 0
        self.mirror = False
        self.timed = False

    def query(self) -> Query:
        cursor = self.cursor
        begin = cursor.token
        while let := cursor.take("word", "let"):
            self.let(let)
        if cursor.stands("end"):
            raise cursor.error("Nothing to look for. Name a part first: r_arm right mid")
        pattern = self.pattern(frozenset())
        if self.strict and not self.timed:
            raise cursor.error(
                "Only the timing of pasted LND can be strict, and there is none here.",
                begin,
                cursor.before,
            )
        if self.timed:
            pattern = _opened(pattern)
        query = Endings(cursor, pattern, self.labels).query()
        if self.names.used and (length := len(str(query))) > _LONGEST:
            raise cursor.error(
                f"With all names written out it has {length} characters; {_LONGEST} is the most.",
                begin,
                cursor.before,
            )
        return query

    def let(self, let: Token) -> None:
        """Read ``let NAME = pattern ;``: checked now, read again with each use."""
        cursor = self.cursor
        name = name_at(cursor)
        if self.names.known(name.text):
            raise cursor.error(f'"{name.text}" has a pattern already: choose another name.', name)
        if not cursor.take("mark", "="):
            raise cursor.error(f"An = follows: let {name.text} = mid -> high;", let, name)
        begin = cursor.index
        with self.names.giving(name.text):
            self.pattern(frozenset((ANYONE,)), "=")
        if cursor.stands("end"):
            raise cursor.error(
                'A ";" ends it, and the pattern follows: let up = mid -> high; r_arm low -> @up',
                let,
                cursor.before,
            )
        if not cursor.stands("mark", ";"):
            raise stray(cursor)
        self.names.let(cursor, name.text, begin)
        cursor.advance()
        self.labels.clear()

    def pattern(self, carried: frozenset[Mover], after: str = "") -> Choice:
        alternatives = [self.lines(carried, after)]
        while self.cursor.take("word", "or"):
            alternatives.append(self.lines(carried, "or"))
        return Choice(tuple(alternatives))

    def lines(self, carried: frozenset[Mover], after: str) -> Lines:
        first = self.line(carried, after)
        others = []
        while relation := self.relation():
            within = within_at(self.cursor, relation)
            labelled = len(self.labels)
            line = self.line(frozenset(), relation)
            if relation in ("without", "never"):
                self.refuse_labels(labelled, f'"{relation}": it speaks of what does not happen.')
            others.append(Beside(relation, line, within))
        return Lines(first, tuple(others))

    def refuse_labels(self, before: int, where: str) -> None:
        """Refuse labels where they could not tell which symbols they mean."""
        for name, place in list(self.labels.items())[before:]:
            raise self.cursor.error(f'The label "{name}" stands inside {where}', *place)

    def relation(self) -> str | None:
        word = self.cursor.take("word", *ONE_WORD_RELATIONS, *TWO_WORD_RELATIONS)
        if word is None:
            return None
        if word.text not in TWO_WORD_RELATIONS:
            return word.text
        if not self.cursor.take("word", "with"):
            raise self.cursor.error(f'"with" follows: r_arm high {word.text} with l_arm high', word)
        return f"{word.text} with"

    def line(self, carried: frozenset[Mover], after: str) -> Line:
        cursor = self.cursor
        begin = cursor.token
        start = self.start()
        items = [self.item(carried, "start" if start else after)]
        arrows: list[Arrow] = []
        end = None
        while arrow := arrow_at(cursor):
            if cursor.take("word", "end"):
                end = arrow
                break
            arrows.append(arrow)
            unit = items[-1].unit
            last = frozenset((unit.mover,)) if isinstance(unit, Step) else last_movers(unit.pattern)
            items.append(self.item(last, "->"))
        if all(item.optional for item in items):
            raise cursor.error(
                "All of this line may be left out, so there is nothing to find: "
                'take a "?" or an "x0" away.',
                begin,
                cursor.before,
            )
        return Line(tuple(items), tuple(arrows), start, end)

    def start(self) -> Arrow | None:
        begin = self.cursor.take("word", "start")
        if begin is None:
            return None
        arrow = arrow_at(self.cursor)
        if arrow is None:
            raise self.cursor.error('An arrow follows "start": start -> r_arm high', begin)
        return arrow

    def item(self, carried: frozenset[Mover], after: str) -> Item:
        cursor = self.cursor
        begin, labelled = cursor.token, len(self.labels)
        label = self.label()
        first = cursor.token
        unit, timed = self.unit(carried, after)
        length = length_at(cursor)
        if length and (token := cursor.token) and length_at(cursor):
            raise cursor.error("Two lengths. From 1s to 2s is 1s..2s", token, cursor.before)
        item = Item(unit, length or timed, repeat_at(cursor), label)
        if item.repeat != ONCE:
            self.refuse_more(first)
            self.refuse_labels(labelled + bool(label), "a repeat: put it before all of it.")
        if (steps := steps_taken(item)) > _MOST_STEPS:
            raise cursor.error(
                f"This asks for {steps} movements in a row; {_MOST_STEPS} is the most. "
                "x3+ leaves the number open.",
                begin,
                cursor.before,
            )
        return item

    def label(self) -> str:
        begin = self.cursor.token
        label = label_at(self.cursor)
        if label is None:
            return ""
        if label.text in self.labels:
            raise self.cursor.error(
                f'The label "{label.text}" stands once.', begin, self.cursor.before
            )
        self.labels[label.text] = (begin, self.cursor.before)
        return label.text

    def refuse_more(self, begin: Token) -> None:
        """Refuse a length or another count after a count: it could be meant in two ways."""
        cursor = self.cursor
        counted, token = cursor.said(begin, cursor.before), cursor.token
        if length_at(cursor):
            raise cursor.error(
                "A length after a count: to time all of it, bracket it: "
                f"({counted}) {cursor.said(token, cursor.before)}; to time each, length first.",
                token,
                cursor.before,
            )
        if repeat_at(cursor) != ONCE:
            raise cursor.error(
                "A count after a count: to repeat all of it, bracket it: "
                f"({counted}) {cursor.said(token, cursor.before)}",
                token,
                cursor.before,
            )

    def unit(self, carried: frozenset[Mover], after: str) -> tuple[Step | Bracket, Length | None]:
        """Read a step, with the length that a line of LND tells."""
        cursor = self.cursor
        if word := cursor.take("word", "mirror"):
            if not cursor.stands("mark", "("):
                raise cursor.error("Brackets follow: mirror(r_arm right)", word)
            self.mirror = not self.mirror
            bracket = self.bracket(carried)
            self.mirror = not self.mirror
            return bracket, None
        if cursor.stands("mark", "("):
            return self.bracket(carried), None
        if cursor.stands("mark", "@"):
            return self.named(carried), None
        if is_lnd(cursor):
            self.timed = True
            unit, timed = score_at(cursor, self.strict)
            return mirrored_unit(unit) if self.mirror else unit, timed
        return step_at(cursor, carried, after, self.mirror), None

    def bracket(self, carried: frozenset[Mover]) -> Bracket:
        cursor = self.cursor
        opening = cursor.advance()
        self.deepen(opening)
        if cursor.stands("mark", ")"):
            raise cursor.error("Nothing between these brackets.", opening, cursor.token)
        pattern = self.pattern(carried)
        if cursor.stands("end"):
            raise cursor.error('This bracket is never closed: a ")" is missing.', opening)
        if not cursor.take("mark", ")"):
            raise stray(cursor)
        self.depth -= 1
        return Bracket(pattern)

    def deepen(self, opening: Token) -> None:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise self.cursor.error(f"More than {_DEEPEST} brackets inside each other.", opening)

    def named(self, carried: frozenset[Mover]) -> Bracket:
        """Read ``@NAME``: its pattern, in brackets."""
        cursor, begin = self.cursor, self.cursor.advance()
        self.deepen(begin)
        labelled = len(self.labels)
        with self.names.opened(cursor, begin) as inner:
            self.cursor = inner
            try:
                pattern = self.pattern(carried)
                if not inner.stands("end"):
                    raise stray(inner)
            except PatternError as error:
                raise within(cursor, begin, error) from error
            self.cursor = cursor
        for name in list(self.labels)[labelled:]:
            self.labels[name] = (begin, cursor.before)
        self.depth -= 1
        return Bracket(pattern)


def _opened(pattern: Choice) -> Choice:
    """Return what stands in brackets, if that is all: a score is lines side by side."""
    match pattern:
        case Choice((Lines(Line((Item(Bracket(inner), None, repeat, ""),), (), None, None), ()),)):
            return inner if repeat == ONCE else pattern
    return pattern
