"""Names that a pattern gives: labels of its steps, and patterns that ``let`` or a dictionary name.

A named pattern is read anew wherever it is used, since a part may carry into it. That is bounded:
by how deep names may speak of names, and by how much there is to read in the end.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from lanindex.errors import PatternError, shown
from lanindex.search.language.cursor import Cursor
from lanindex.search.language.lexer import Token
from lanindex.search.language.mistakes import COUNT
from lanindex.search.language.steps import NO_PART
from lanindex.search.language.words import Mover

ANYONE = Mover("any part", "one", ("r_any",))
"""Who moves in a pattern that is being named, where only its use will tell."""

_MOST_WORDS = 10_000


def name_at(cursor: Cursor) -> Token:
    """Read a name.

    Raises
    ------
    PatternError
        The next token is none, or means something already.
    """
    token = cursor.token
    if token.kind != "word":
        raise cursor.error("A name goes here, such as a or reach_up.", cursor.before)
    said = cursor.said(token)
    if COUNT.fullmatch(token.text):
        raise cursor.error(f'"{said}" is a count: choose another name.')
    if means := cursor.vocabulary.taken(token.text):
        raise cursor.error(f'"{said}" is {means}: choose another name.')
    return cursor.advance()


def label_at(cursor: Cursor) -> Token | None:
    """Read a label with its colon, if one stands here: ``a:``."""
    if not (cursor.token.kind == "word" and cursor.ahead(1).text == ":"):
        return None
    label = name_at(cursor)
    cursor.advance()
    if cursor.token.kind == "word" and cursor.ahead(1).text == ":":
        raise cursor.error("One label is enough.", cursor.token, cursor.ahead(1))
    return label


class Names:
    """The patterns that have a name.

    Parameters
    ----------
    given : Mapping of str to str
        Names in small letters, and the pattern of each.
    """

    def __init__(self, given: Mapping[str, str]) -> None:
        self._given = given
        self._let: dict[str, Cursor] = {}
        self._inside: list[str] = []
        self._read = 0

    def let(self, cursor: Cursor, name: str, begin: int) -> None:
        """Keep what was read since `begin` under a name."""
        self._let[name] = cursor.cut(begin)

    @property
    def used(self) -> bool:
        """Whether any was written out."""
        return self._read > 0

    def known(self, name: str) -> bool:
        """Tell whether a let has given this name."""
        return name in self._let

    @contextmanager
    def giving(self, name: str) -> Iterator[None]:
        """Read a pattern that gets a name, in which that name means nothing yet."""
        self._inside.append(name)
        yield
        self._inside.pop()

    @contextmanager
    def opened(self, cursor: Cursor, at: Token) -> Iterator[Cursor]:
        """Read a name behind ``@``, and give what it stands for.

        Raises
        ------
        PatternError
            Nothing has this name, it speaks of itself, or there is too much to read.
        """
        token = cursor.token
        if token.kind != "word":
            raise cursor.error("The name of a pattern follows: @reach_up", at)
        name = cursor.advance().text
        if name in self._inside:
            raise cursor.error(f'"@{name}" speaks of itself.', at, token)
        found = self._found(cursor, name)
        if found is None and cursor.stands("mark", ".") and cursor.ahead(1).text in ("lq", "lnd"):
            file = cursor.ahead(1)
            raise cursor.error("A pattern in a file stands alone: search @raise.lq", at, file)
        if found is None:
            raise cursor.error(self._stranger(name), at, token)
        self._read += len(found.tokens)
        if self._read > _MOST_WORDS:
            raise cursor.error(
                f"With all names written out this has more than {_MOST_WORDS} words.", at, token
            )
        with self.giving(name):
            yield found

    def _found(self, cursor: Cursor, name: str) -> Cursor | None:
        if let := self._let.get(name):
            return Cursor(let.text, let.vocabulary, let.tokens)
        text = self._given.get(name)
        return None if text is None else Cursor(text, cursor.vocabulary)

    def _stranger(self, name: str) -> str:
        from rapidfuzz import process

        known = [*self._let, *self._given]
        guess = process.extractOne(name, known, score_cutoff=60)
        remedy = f"A let before gives one its name: let {shown(name, 20)} = mid -> high;"
        if guess:
            remedy = f'Did you mean "@{guess[0]}"?'
        return f'There is no pattern "@{name}". {remedy}'


def within(cursor: Cursor, at: Token, error: PatternError) -> PatternError:
    """Return the error of a named pattern, as one about its use, which was just read."""
    name = cursor.said(at, cursor.before)
    found = f"{name}: {error.found}"
    if error.found == NO_PART:
        found = f"{name} begins without a part. Let one carry into it: r_arm low -> {name}"
    return cursor.error(found, at, cursor.before)
