"""Pattern text → tokens, and the cursor over them."""

import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction

from lanindex.alphabet import SIXTHS
from lanindex.errors import PatternError, shown
from lanindex.search.language.remedies import broken
from lanindex.search.language.times import Length, Time
from lanindex.search.language.words import DEGREES, UNITS, Mover, Vocabulary

_KINDS = {
    "comment": r"//[^\n]*",
    "dots": r"\.\.\.|…",
    "range": r"\.\.",
    "number": r"\d+(?:\.\d+)?|\.\d+",
    "word": r"[^\W\d]\w*",
    "arrow": r"->|→",
    "compare": r"<=|>=|<|>|≤|≥",
    "string": r'"[^"\n]*"?',
    "mark": r"!=|[()\[\]/?:;@|+\-=.,#]",
    "space": r"\s+",
    "unknown": r".",  # so that the first error in a text is told, not the first odd character
}
_TOKEN = re.compile("|".join(f"(?P<{kind}>{form})" for kind, form in _KINDS.items()), re.DOTALL)
_ALIASES = {"≤": "<=", "≥": ">=", "→": "->", "then": "->", "…": "..."}

_LONGEST_NUMBER = 9
_QUOTED = re.compile(r'"([^"]*)"')


@dataclass(frozen=True, slots=True)
class Token:
    """A word, number or mark of a pattern."""

    kind: str  # a key of `_KINDS`, or "end"
    text: str  # in lower case and one spelling: "->" for "→"
    start: int  # its characters in the pattern
    stop: int


def tokens(text: str) -> list[Token]:
    """Split a pattern into tokens without comments and white space; the last is of kind ``end``."""
    found = []
    for match in _TOKEN.finditer(text):
        kind, word = str(match.lastgroup), match.group().lower()
        word = _ALIASES.get(word, word)
        if kind not in ("comment", "space"):
            kind = "arrow" if word == "->" else kind
            found.append(Token(kind, word, match.start(), match.end()))
    end = found[-1].stop if found else 0
    return [*found, Token("end", "", end, end)]


class Cursor:
    """The tokens of a pattern, read from left to right, and the numbers and lengths they make."""

    def __init__(self, text: str, vocabulary: Vocabulary) -> None:
        self.text, self.vocabulary = text, vocabulary
        self.tokens: Sequence[Token] = tokens(text)
        self.index = 0  # of the next token
        self.labels: dict[str, tuple[Token, Token]] = {}  # by name, with the colon behind it

    @property
    def token(self) -> Token:
        """The next token, not yet read."""
        return self.tokens[self.index]

    @property
    def before(self) -> Token:
        """The last token that was read; at the beginning the next one."""
        return self.tokens[max(self.index - 1, 0)]

    @property
    def at_label(self) -> bool:
        """Whether a word with a colon stands here."""
        return self.token.kind == "word" and self.ahead(1).text == ":"

    @property
    def at_length(self) -> bool:
        """Whether a number or a comparison stands here."""
        return self.token.kind in ("number", "compare")

    @property
    def at_angle(self) -> bool:
        """Whether an angle stands here."""
        return self.number_and_unit()[1] == DEGREES

    def ahead(self, steps: int) -> Token:
        """Return the token so many places behind the next one."""
        return self.tokens[min(self.index + steps, len(self.tokens) - 1)]

    def advance(self) -> Token:
        """Read a token; the end can be read again and again."""
        token = self.token
        self.index = min(self.index + 1, len(self.tokens) - 1)
        return token

    def stands(self, kind: str, *texts: str) -> bool:
        """Return whether the next token is of a kind, and one of these if any are given."""
        return self.token.kind == kind and (not texts or self.token.text in texts)

    def take(self, kind: str, *texts: str) -> Token | None:
        """Read the next token if it is of a kind, and one of these if any are given."""
        return self.advance() if self.stands(kind, *texts) else None

    def excerpt(self, first: Token, last: Token | None = None) -> str:
        """Return the text from one token to another, on one line, cut where it is long."""
        return shown(" ".join(self.text[first.start : (last or first).stop].split()))

    def error(
        self, sentence: str, first: Token | None = None, last: Token | None = None
    ) -> PatternError:
        """Return an error about the next token, or about the text from `first` to `last`."""
        first = first or self.token
        sentence = _QUOTED.sub(lambda quoted: f'"{shown(quoted[1])}"', sentence)
        return PatternError(sentence, text=self.text, start=first.start, stop=(last or first).stop)

    def fault(
        self, rule: str, first: Token | None = None, last: Token | None = None, **said: object
    ) -> PatternError:
        """Return the error of a broken rule, about the same; `said` goes into its sentence."""
        return self.error(broken(rule, **said), first, last)

    def mover(self) -> Mover | None:
        """Read who moves, if a name of up to three words stands here: ``r_arm``, ``right arm``."""
        for count in (3, 2, 1):
            some = [self.ahead(number) for number in range(count)]
            mover = self.vocabulary.mover(*(token.text for token in some))
            if mover and all(token.kind == "word" for token in some):
                self.index += count
                return mover
        return None

    def checked(self, number: Token, digits: str = "") -> str:
        """Return the digits of a number; refuse too many."""
        digits = digits or number.text
        if len(digits) > _LONGEST_NUMBER:
            raise self.fault("too many digits", number, most=_LONGEST_NUMBER)
        return digits

    def number(self) -> Fraction:
        """Read a number."""
        return Fraction(self.checked(self.advance()))

    def number_and_unit(self) -> tuple[str, str]:
        """Return the number that stands here or behind a comparison, and its unit, unread."""
        number, unit = (self.ahead(self.stands("compare") + ahead) for ahead in (0, 1))
        return (number.text, unit.text) if number.kind == "number" else ("", "")

    def time(self, units: Collection[str] = UNITS) -> Time:
        """Read a time: ``0.3s``, ``300ms``, ``9f``, ``2b``; or a number with another unit."""
        number = self.take("number")
        if number is None:
            raise self.fault("no time", self.before)
        digits = self.checked(number)
        if not self.stands("word", *units):
            often = {"1": "once", "2": "twice"}.get(digits, f"{digits} times")
            rule = "time or count" if digits.isdecimal() else "time without unit"
            raise self.fault(rule, number, number=digits, often=often)
        return Time(Fraction(digits), self.advance().text)

    def length(self, units: Collection[str] = UNITS) -> Length | None:
        """Read a length, if one stands here: ``<0.3s``, ``1s..2s``, ``2s+``, ``1s``."""
        return self._range(lambda: self.time(units)) if self.at_length else None

    def _range(self, value: Callable[[], Time]) -> Length:
        """Read a range; `value` reads one end of it."""
        begin = self.token
        if compare := self.take("compare"):
            return Length(compare.text, value())
        first = value()
        if self.take("mark", "+"):
            return Length("+", first)
        if not self.take("range"):
            return Length("~", first)
        last = value()
        if last.unit == first.unit and last.number < first.number:
            raise self.fault("more to less", begin, self.before, right=f"{last}..{first}")
        return Length("..", first, last)

    def sixths(self) -> str:
        """Read a degree of bending, if one stands here: ``3``, ``3+``, ``2..4``, ``<3``."""
        number, unit = self.number_and_unit()
        if not number or unit in (*UNITS, DEGREES):
            return ""
        return str(self._range(self._sixth))

    def _sixth(self) -> Time:
        token = self.advance()
        is_whole = token.kind == "number" and token.text.isdecimal()
        if is_whole and len(token.text) <= _LONGEST_NUMBER and int(token.text) <= SIXTHS:
            return Time(Fraction(token.text), "")
        raise self.fault("no such bend", token, most=SIXTHS)
