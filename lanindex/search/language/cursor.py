"""Where the parser stands in a pattern, and how it says that something is wrong there."""

from __future__ import annotations

import re
from collections.abc import Sequence

from lanindex.errors import PatternError, shown
from lanindex.search.language.lexer import Token, tokens
from lanindex.search.language.words import Mover, Vocabulary

_QUOTED = re.compile(r'"([^"]*)"')


class Cursor:
    """A pattern's tokens, read from left to right.

    Parameters
    ----------
    text : str
        The whole pattern.
    vocabulary : Vocabulary
        The words it may use.
    read : sequence of Token, optional
        What to read of it, the last of kind ``end``; by default all.
    """

    def __init__(
        self, text: str, vocabulary: Vocabulary, read: Sequence[Token] | None = None
    ) -> None:
        self.text, self.vocabulary = text, vocabulary
        self._tokens = tokens(text) if read is None else read
        self._index = 0

    @property
    def tokens(self) -> Sequence[Token]:
        """All tokens, the last of kind ``end``."""
        return self._tokens

    @property
    def index(self) -> int:
        """How many tokens were read."""
        return self._index

    def cut(self, begin: int) -> Cursor:
        """Return a cursor of what was read since `index` was that; it ends where this stands."""
        stop = self.before.stop
        read = self._tokens[begin : self._index]
        return Cursor(self.text, self.vocabulary, [*read, Token("end", "", stop, stop)])

    @property
    def token(self) -> Token:
        """The next token, not yet read."""
        return self._tokens[self._index]

    @property
    def before(self) -> Token:
        """The last token that was read; at the beginning the next one."""
        return self._tokens[max(self._index - 1, 0)]

    def ahead(self, steps: int) -> Token:
        """Return the token that many places behind the next one."""
        return self._tokens[min(self._index + steps, len(self._tokens) - 1)]

    def advance(self) -> Token:
        """Read a token; the end can be read again and again."""
        token = self.token
        self._index = min(self._index + 1, len(self._tokens) - 1)
        return token

    def stands(self, kind: str, *texts: str) -> bool:
        """Tell whether the next token is of a kind, and one of these if any are given."""
        return self.token.kind == kind and (not texts or self.token.text in texts)

    def take(self, kind: str, *texts: str) -> Token | None:
        """Read the next token if it is of a kind, and one of these if any are given."""
        return self.advance() if self.stands(kind, *texts) else None

    def mover_at(self) -> Mover | None:
        """Read who moves, if it is said here, in up to three words: ``r_arm``, ``right arm``."""
        for count in (3, 2, 1):
            some = [self.ahead(number) for number in range(count)]
            if any(token.kind != "word" for token in some):
                continue
            words = [token.text for token in some]
            apart = self.vocabulary.spelt_apart(*words) if count > 1 else None
            if mover := apart or (None if count > 1 else self.vocabulary.mover(words[0])):
                for _ in some:
                    self.advance()
                return mover
        return None

    def said(self, first: Token, last: Token | None = None) -> str:
        """Return the text from one token to another, on one line, and cut where it is long."""
        return shown(" ".join(self.text[first.start : (last or first).stop].split()))

    def error(
        self, sentence: str, first: Token | None = None, last: Token | None = None
    ) -> PatternError:
        """Return an error about the next token, or about those from `first` to `last`."""
        first = first or self.token
        sentence = _QUOTED.sub(lambda quoted: f'"{shown(quoted[1])}"', sentence)
        return PatternError(sentence, text=self.text, start=first.start, stop=(last or first).stop)
