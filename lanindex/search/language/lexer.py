"""Pattern text → tokens, the cursor over them, and the errors about tokens in a wrong place."""

import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from lanindex.alphabet import DIRECTIONS, SIXTHS
from lanindex.data import shipped
from lanindex.errors import PatternError, shown
from lanindex.search.language.times import Length, Time
from lanindex.search.language.words import DEGREES, LANGUAGE, UNITS, VALUES, Mover, Vocabulary

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

COUNT = re.compile(r"x(\d+)")  # a word that counts: x3
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


_FEW = 6
"""Parts that are named where a word is none."""

_NO_STEPS = ("start", "let", "count", "sort", "first", "by", "mirrors", "clip", "match", "and")
"""Words that never begin a step."""


@cache
def remedies(table: str) -> dict[str, str]:
    """Return a table of ``remedies.toml`` by each word or mark of its keys."""
    rows = shipped("search/language/remedies.toml")[table].items()
    return {word: remedy for words, remedy in rows for word in words.split()}


def broken(rule: str, **said: object) -> str:
    """Return the sentence about a rule of the grammar that is broken."""
    sentence: str = shipped("search/language/remedies.toml")["rules"][rule]
    return sentence.format(**said)


def unknown_word(vocabulary: Vocabulary, word: str, part_expected: bool) -> str:
    """Return the sentence about a word that is not in the vocabulary."""
    from lanindex.search.dictionary import absent

    if part_expected and (lacking := absent(word)):  # no other word misspelt
        return f'I don\'t know "{word}". Did you mean:  {lacking.instead}'
    if guess := _guess(vocabulary, word.lower(), part_expected):
        return f'I don\'t know "{word}". Did you mean "{guess}"?'
    if not part_expected:
        directions = ", ".join(DIRECTIONS[:4])
        known = f"A movement has a direction ({directions} …) and a level (high, mid, low)."
        return f'I don\'t know "{word}". {known}'
    parts = " ".join(vocabulary.parts[:_FEW]) or "none"
    parts += " …" * (len(vocabulary.parts) > _FEW)
    return f'There is no part "{word}". The parts are: {parts}'


def _guess(vocabulary: Vocabulary, word: str, part_expected: bool) -> str:
    from rapidfuzz import process
    from rapidfuzz.distance import OSA

    from lanindex.search.dictionary import load

    named = {name: f"@{name}" for name in load()} if part_expected else {}
    if word in named:
        return named[word]
    side = next((it for it in ("right_", "left_", "r_", "l_") if word.startswith(it)), "")
    similar = remedies("meant")
    meant = (side and f"{side[0]}_") + similar.get(word.removeprefix(side), "")
    if word in similar or meant in vocabulary.movers:
        return meant
    known = [*VALUES, *vocabulary.movers, *LANGUAGE, *named]
    jumbled = [it for it in known if sorted(it) == sorted(word)]
    begun = [it for it in known if it[0] == word[0]]  # people seldom mistype a beginning
    found = process.extractOne(word, begun, scorer=OSA.normalized_similarity, score_cutoff=0.7)
    guess = jumbled[0] if jumbled else found[0] if found else ""
    return named.get(guess, guess)


def is_unknown(cursor: Cursor) -> bool:
    """Return whether the next token is a word that the language does not know."""
    word = cursor.token.text
    known = word in VALUES or word in LANGUAGE or word in UNITS or COUNT.fullmatch(word)
    return cursor.stands("word") and not (known or cursor.vocabulary.mover(word))


def unknown(cursor: Cursor, part_expected: bool = False) -> PatternError:
    """Return the error of a word that is not in the vocabulary."""
    if cursor.stands("string"):
        return cursor.error("Take the quotation marks away.")
    word = cursor.excerpt(cursor.token)
    known = remedies("unknown").get(word.lower())
    return cursor.error(known or unknown_word(cursor.vocabulary, word, part_expected))


def no_step(cursor: Cursor, after: str) -> PatternError:
    """Return the error where a step should begin behind `after`, and none does."""
    token = cursor.token
    remedy = remedies("stray").get(token.text, "")
    arrow = after in ("->", "start")
    if is_unknown(cursor):
        return unknown(cursor, part_expected=True)
    if token.kind in ("arrow", "dots"):
        if arrow:
            return cursor.fault("two arrows")
        return cursor.fault("arrow first")
    if token.kind in ("unknown", "string"):
        return cursor.error(remedy) if remedy else unknown(cursor)
    if token.text in _NO_STEPS:
        return cursor.error(remedy)
    if after:
        return cursor.fault("arrow last" if arrow else "nothing after", cursor.before, after=after)
    if token.kind == "end":
        return cursor.fault("bracket last", cursor.before)
    return cursor.fault("nothing before", text=cursor.excerpt(token))


def stray(cursor: Cursor) -> PatternError:
    """Return the error of what follows a line that is complete."""
    token = cursor.token
    if cursor.at_label:
        return cursor.fault("label behind a step", token, cursor.ahead(1))
    remedy = remedies("stray").get(token.text)
    if is_unknown(cursor) or (token.kind in ("unknown", "string") and not remedy):
        return unknown(cursor)
    if token.kind == "word" and cursor.vocabulary.mover(token.text):
        return cursor.fault("another part")
    if cursor.before.text == "end":
        return cursor.fault("behind end")
    if remedy:
        return cursor.error(remedy)
    if token.text in VALUES:
        return cursor.fault("word too late", word=token.text)
    return cursor.fault("nothing said", text=cursor.excerpt(token))
