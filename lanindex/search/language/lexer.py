"""Pattern text → tokens, and the cursor over them."""

import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

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

Node = TypeVar("Node")

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


def ends_in_comment(text: str) -> bool:
    """Return whether what follows a text on the same line is a comment."""
    kinds = [str(match.lastgroup) for match in _TOKEN.finditer(text)]
    return kinds[-1:] == ["comment"]


@dataclass(frozen=True, slots=True)
class Place:
    """Where a node of the syntax tree was read, and what it is in the text."""

    node: object
    start: int
    stop: int
    written: str = ""  # mirror, named or score, where the node is made from other words
    inner: object = None  # the node as it is written, of a mirror image


_FORMS = {
    **{"arrow": ("->",), "dots": ("...",), "range": ("..",)},
    **{"compare": ("<", "<=", ">", ">=")},
}
"""The texts of tokens that are asked for by their kind alone."""


class Cursor:
    """The tokens of a pattern, read from left to right, and the numbers and lengths they make."""

    def __init__(self, text: str, vocabulary: Vocabulary) -> None:
        self.text, self.vocabulary = text, vocabulary
        self.tokens: Sequence[Token] = tokens(text)
        self.index = 0  # of the next token
        self.labels: dict[str, tuple[Token, Token]] = {}  # by name, with the colon behind it
        self.typed = self.tokens  # those of the text itself, not of a pattern that it names
        self.wanted: dict[str, str] | None = None  # if asked: what may stand at the end; its kind
        self.places: dict[int, Place] | None = None  # if asked: of the nodes, by identity

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
        self.expect(kind, *(texts or _FORMS.get(kind, ())))
        return self.token.kind == kind and (not texts or self.token.text in texts)

    def ends(self, ahead: int) -> bool:
        """Return whether the end that is asked about stands here, or so many tokens ahead."""
        at_end = self.index + ahead == len(self.tokens) - 1
        return self.wanted is not None and at_end and self.tokens is self.typed

    def expect(self, kind: str, *texts: str, ahead: int = 0) -> None:
        """Note that these texts may stand at the end that is asked about, if it is there."""
        if self.wanted is not None and self.ends(ahead):
            for text in texts:
                self.wanted.setdefault(text, kind)

    def expect_number(self, example: str, *units: str) -> None:
        """Note that a number may stand here or behind a comparison, with one of these units."""
        compared = self.token.kind == "compare"
        self.expect("number", example, ahead=compared)
        self.expect("compare", *_FORMS["compare"])
        if self.ahead(compared).kind == "number":
            self.expect("unit", *units, ahead=compared + 1)

    def expect_parts(self, form: str = "") -> None:
        """Note that a name of who moves may stand or go on here; of a form, if one is given."""
        for count in filter(self.ends, range(3)):
            begun = "".join(f"{self.ahead(number).text}_" for number in range(count))
            self.expect("part", *self.vocabulary.names(begun, form), ahead=count)

    def placed(self, node: Node, begin: Token, written: str = "", inner: object = None) -> Node:
        """Return a node that was read, and note where it was."""
        if self.places is not None:
            self.places[id(node)] = Place(node, begin.start, self.before.stop, written, inner)
        return node

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
        compared = self.token.kind == "compare"
        number, unit = (self.ahead(compared + ahead) for ahead in (0, 1))
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
        self.expect_number(f"1{next(iter(units))}", *units)
        if not self.at_length:
            return None
        begin = self.token
        return self.placed(self._range(lambda: self.time(units)), begin)

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
        self.expect("number", f"{first.number.__ceil__() + 1}{first.unit}")
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
