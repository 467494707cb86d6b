"""Pattern text → Query: the grammar, read from left to right.

The constructs that this version does not understand yet, which LANGUAGE.md lists, are recognised
where they stand, and said to be so.
"""

from __future__ import annotations

from collections.abc import Collection

from lanindex.errors import PatternError
from lanindex.search.language.cursor import Cursor
from lanindex.search.language.lexer import Token
from lanindex.search.language.measures import arrow_at, length_at, repeat_at
from lanindex.search.language.mistakes import not_yet, not_yet_bounded, stray
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
    steps_taken,
)
from lanindex.search.language.steps import step_at
from lanindex.search.language.words import TWO_WORD_RELATIONS, Mover, Vocabulary

_LONGEST = 10_000
_DEEPEST = 40
_MOST_STEPS = 1000


def parse(text: str, parts: Collection[str] | None = None, known: Collection[str] = ()) -> Query:
    """Read a pattern.

    Parameters
    ----------
    text : str
        In the pattern language.
    parts : collection of str, optional
        The parts that the library holds; by default those of the alphabet and the supports.
    known : collection of str
        Parts that may be named though the library lacks them.

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
    if len(text) > _LONGEST:
        raise PatternError(
            f"A pattern of {len(text)} characters; {_LONGEST} is the most.",
            text=f"{text[:60]}…",
            start=60,
            stop=61,
        )
    return _Parser(Cursor(text, Vocabulary(parts, known))).query()


class _Parser:
    """One method a rule of the grammar; each reads its tokens and returns its node."""

    def __init__(self, cursor: Cursor) -> None:
        self.cursor = cursor
        self.depth = 0
        self.mirror = False

    def query(self) -> Query:
        cursor = self.cursor
        if cursor.stands("end"):
            raise cursor.error("Nothing to look for. Name a part first: r_arm right mid")
        pattern = self.pattern(frozenset())
        either_side = False
        while begin := cursor.take("word", "either"):
            if not cursor.take("word", "side"):
                raise cursor.error('"either side": the pattern or its mirror image.', begin)
            either_side = True
        if either_side and not cursor.stands("end"):
            raise not_yet(cursor) or cursor.error('"either side" ends the pattern.')
        if not cursor.stands("end"):
            raise stray(cursor)
        return Query(pattern, either_side)

    def pattern(self, carried: frozenset[Mover]) -> Choice:
        alternatives = [self.lines(carried, "")]
        while self.cursor.take("word", "or"):
            alternatives.append(self.lines(carried, "or"))
        return Choice(tuple(alternatives))

    def lines(self, carried: frozenset[Mover], after: str) -> Lines:
        first = self.line(carried, after)
        others = []
        while relation := self.relation():
            others.append(Beside(relation, self.line(frozenset(), relation)))
        return Lines(first, tuple(others))

    def relation(self) -> str | None:
        word = self.cursor.take("word", "with", "during", "without", *TWO_WORD_RELATIONS)
        if word is None:
            return None
        if late := not_yet_bounded(self.cursor):
            raise late
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
        begin = cursor.token
        unit = self.unit(carried, after)
        length = length_at(cursor)
        if length and (token := cursor.token) and length_at(cursor):
            raise cursor.error("Two lengths. From 1s to 2s is 1s..2s", token, cursor.before)
        item = Item(unit, length, repeat_at(cursor))
        if item.repeat != ONCE:
            self.refuse_more(begin)
        if (steps := steps_taken(item)) > _MOST_STEPS:
            raise cursor.error(
                f"This asks for {steps} movements in a row; {_MOST_STEPS} is the most. "
                "x3+ leaves the number open.",
                begin,
                cursor.before,
            )
        return item

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

    def unit(self, carried: frozenset[Mover], after: str) -> Step | Bracket:
        cursor = self.cursor
        if late := not_yet(cursor):
            raise late
        if word := cursor.take("word", "mirror"):
            if not cursor.stands("mark", "("):
                raise cursor.error("Brackets follow: mirror(r_arm right)", word)
            self.mirror = not self.mirror
            bracket = self.bracket(carried)
            self.mirror = not self.mirror
            return bracket
        if cursor.stands("mark", "("):
            return self.bracket(carried)
        return step_at(cursor, carried, after, self.mirror)

    def bracket(self, carried: frozenset[Mover]) -> Bracket:
        cursor = self.cursor
        opening = cursor.advance()
        self.depth += 1
        if self.depth > _DEEPEST:
            raise cursor.error(f"More than {_DEEPEST} brackets inside each other.", opening)
        if cursor.stands("mark", ")"):
            raise cursor.error("Nothing between these brackets.", opening, cursor.token)
        pattern = self.pattern(carried)
        if cursor.stands("end"):
            raise cursor.error('This bracket is never closed: a ")" is missing.', opening)
        if not cursor.take("mark", ")"):
            raise stray(cursor)
        self.depth -= 1
        return Bracket(pattern)
