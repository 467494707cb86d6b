"""Patterns in files, and pasted LND: a line of it is a step, several are a score to find."""

import re
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from lanindex.alphabet import KINDS, LINES, kind_of
from lanindex.errors import NotationError, PatternError
from lanindex.notation import NOTATIONS, notation_of, read
from lanindex.notation.text import read_text
from lanindex.search.language import query as tree
from lanindex.search.language.lexer import Cursor, Token
from lanindex.search.language.remedies import is_unknown, unknown
from lanindex.search.language.times import Length, Time
from lanindex.search.language.words import ANY, DEGREES, RELATIVE, THINGS, Mover, values_for

_SUFFIXES = "|".join(("lq", *map(re.escape, NOTATIONS)))
_FILE = re.compile(rf"@(?P<path>.*\.(?:{_SUFFIXES})|\S*[/\\].*)", re.IGNORECASE | re.DOTALL)

_HEADINGS = ("speed", "rhythm", "unit_total", "unit_per_line", "unit")  # what may stand behind #


class FilePattern(str):
    """A pattern's text with the path of its file, which errors name."""

    path: Path

    def place(self, start: int) -> str:
        """Return file and line of a character."""
        return f"{self.path}:{self.count(chr(10), 0, start) + 1}"


def pattern_in(text: str, folder: Path | None = None) -> str:
    """Return the text itself, or the pattern in the file or score that it names: ``@raise.lq``."""
    named = _FILE.fullmatch(text.strip())
    if named is None:
        return text
    path = Path(named["path"]) if folder is None else folder / named["path"]
    form = notation_of(str(path))
    if form is None or form.name == "lnd":
        pattern = FilePattern(read_text(path).replace("\r\n", "\n").replace("\r", "\n"))
    else:
        from lanindex.notation import lnd

        pattern = FilePattern(lnd.write(read(str(path))))
    pattern.path = path
    return pattern


def is_lnd(cursor: Cursor) -> bool:
    """Return whether a line of LND begins here; a word like jump alone is none."""
    if cursor.stands("word", "direction") or cursor.token.text == "#":
        return True
    cursor.expect("notation", *LINES)
    kind, part = LINES.get(cursor.token.text), cursor.ahead(1)
    if kind:
        meant = [it for it in cursor.vocabulary.parts if KINDS[kind_of(it)] == kind]
        cursor.expect("part", *meant, ahead=1)
    return bool(kind and part.kind == "word" and KINDS[kind_of(part.text)] == kind)


def score_at(cursor: Cursor, strict: bool) -> tuple[tree.Step | tree.Bracket, Length | None]:
    """Read lines of LND; one alone is a step, with its length if the timing counts (`strict`)."""
    score = _Score(cursor, strict)
    if len(score.lines) == 1 and score.tracks:
        ((mover, (symbol,)),) = score.tracks.items()
        return tree.Step(mover, True, "move", symbol.words), score.length(symbol)
    return tree.Bracket(tree.Choice((score.side_by_side(),))), None


@dataclass(frozen=True, slots=True)
class _Symbol:
    """A symbol of a score: its words, and its times in beats."""

    words: tuple[tree.Word, ...]
    start: Fraction
    stop: Fraction

    @property
    def length(self) -> Fraction:
        """Its beats; a starting position has none."""
        return self.stop - self.start


def _stays(symbols: list[_Symbol]) -> bool:
    """Return whether a track is a starting position alone."""
    return len(symbols) == 1 and not symbols[0].length


class _Score:
    """Lines of LND; timed in seconds if they have a speed, else in beats of the capture."""

    def __init__(self, cursor: Cursor, strict: bool) -> None:
        self.cursor, self.strict = cursor, strict
        self.lines: list[tuple[str, Token, Token]] = []  # the text of each, from where to where
        self.tracks: dict[Mover, list[_Symbol]] = {}  # as written
        self.speed: Fraction | None = None  # beats a minute
        self.in_units = False
        while is_lnd(cursor):
            begin = cursor.advance()
            text = self.heading(begin) if begin.text == "#" else self.symbol(begin)
            self.lines.append((text, begin, cursor.before))

    def heading(self, begin: Token) -> str:
        cursor = self.cursor
        word = cursor.take("word")
        name = word.text if word else ""
        numbered = name[:4] == "unit" and name[4:].isdecimal()
        if not (name in _HEADINGS or numbered):
            known = " ".join(f"#{heading}" for heading in _HEADINGS)
            raise cursor.fault("no such heading", begin, word or begin, known=known)
        cursor.take("mark", "=")
        if not numbered and not cursor.take("number"):
            raise cursor.fault("no number in heading", begin, cursor.before)
        if cursor.take("mark", "/") and not cursor.take("number"):
            raise cursor.fault("no rhythm in heading", begin, cursor.before)
        self.in_units |= numbered or name == "unit"
        text = " ".join(cursor.text[begin.start : cursor.before.stop].split())
        if name == "speed" and self.speed is None:
            try:
                self.speed = Fraction(text.replace("=", " ").split()[-1])
            except (ValueError, ZeroDivisionError) as error:  # thousands of digits, or 1/0
                raise cursor.fault("no speed", begin, cursor.before) from error
        return text

    def symbol(self, begin: Token) -> str:
        cursor = self.cursor
        cursor.expect_parts("one")
        part = cursor.mover()
        if part is None:
            raise unknown(cursor, True) if is_unknown(cursor) else self.incomplete(begin)
        if part.form != "one":
            raise cursor.fault("two parts in LND", cursor.before, parts=part.members)
        words = tuple(self.word(begin, kind) for kind in LINES[begin.text].names)
        times = [self.number(begin) for _ in range(2)]
        start, stop = map(Fraction, times)
        if stop < start:
            raise cursor.fault("end before start", begin, cursor.before, end=times[1])
        self.tracks.setdefault(part, []).append(_Symbol(words, start, stop))
        spelled = [word.values[0].removesuffix(DEGREES).replace(" ", "") for word in words]
        return " ".join([begin.text, part.name, *spelled, *times])

    def incomplete(self, begin: Token) -> PatternError:
        cursor, names = self.cursor, LINES[begin.text].names
        said = {"count": {1: "four", 2: "five"}[len(names)], "names": " ".join(names)}
        return cursor.fault("no line of LND", begin, cursor.before, line=begin.text, **said)

    def word(self, begin: Token, kind: str) -> tree.Word:
        cursor = self.cursor
        if kind == "degrees":
            return tree.Word(kind, (self.number(begin) + DEGREES,))
        known = values_for((kind,))
        meant = [
            it
            for it, (other, value) in known.items()
            if other == kind and value not in (*RELATIVE, ANY)
        ]
        cursor.expect("notation", *meant)
        if is_unknown(cursor) and cursor.token.text not in THINGS.get(kind, ()):
            raise unknown(cursor)
        found = known.get(cursor.token.text) if cursor.stands("word") else None
        if found is None or found[0] != kind or found[1] in (*RELATIVE, ANY):
            raise self.incomplete(begin)
        cursor.advance()
        return tree.Word(kind, (found[1],))

    def number(self, begin: Token) -> str:
        self.cursor.expect("number", "1")
        number = self.cursor.take("number")
        if number is None:
            raise self.incomplete(begin)
        if len(number.text) > 40:
            raise self.cursor.fault("too many digits", number, most=40)
        return number.text

    def fault(self, rule: str, **said: object) -> PatternError:
        """Return the error of a broken rule, about all lines."""
        return self.cursor.fault(rule, self.lines[0][1], self.lines[-1][2], **said)

    def length(self, symbol: _Symbol) -> Length | None:
        return Length("~", self.time(symbol.length)) if self.strict and symbol.length else None

    def arrow(self, before: _Symbol, after: _Symbol) -> tree.Arrow:
        if not (self.strict and before.length):
            return tree.NEXT
        rest = after.start - before.stop
        form, beats = ("~", rest) if rest else ("<=", before.length / 5)
        return tree.Arrow(length=Length(form, self.time(beats)))

    def time(self, beats: Fraction) -> Time:
        number, unit = (beats * 60 / self.speed, "s") if self.speed else (beats, "b")
        return Time(max(Fraction(round(number * 1000), 1000), Fraction(1, 1000)), unit)

    def side_by_side(self) -> tree.Lines:
        """Return a line for each part: those that move first, in order of appearance."""
        if not self.tracks:
            raise self.fault("no symbols")
        tracks = self.tracks_in_units() if self.in_units else self.tracks
        movers = sorted(tracks, key=lambda mover: _stays(tracks[mover]))
        first, *others = [self.line(mover, tracks[mover]) for mover in movers]
        return tree.Lines(first, tuple(tree.Beside("with", line) for line in others))

    def tracks_in_units(self) -> dict[Mover, list[_Symbol]]:
        """Return the symbols sorted by time, with halves across bar lines joined."""
        from lanindex.notation import lnd

        try:
            score = lnd.read("\n".join(["", *(text for text, _, _ in self.lines)]), place="LND")
        except NotationError as error:
            number = error.place.rpartition(":")[2]
            found = f"{error.found}{f', wanted {error.wanted}' if error.wanted else ''}."
            lines = self.lines[int(number) - 2 :][:1] if number.isdecimal() else self.lines
            raise self.cursor.error(found, lines[0][1], lines[-1][2]) from error
        beat = Fraction(score.meter.beats, score.meter.division)
        tracks: dict[Mover, list[_Symbol]] = {mover: [] for mover in self.tracks}
        for mover, symbols in tracks.items():
            names = KINDS[kind_of(mover.name)].names
            for symbol in score.symbols(mover.name):
                pairs = zip(names, symbol.words.split(), strict=True)
                words = tuple(tree.Word(name, (word,)) for name, word in pairs)
                stop = symbol.tick + symbol.ticks
                symbols.append(_Symbol(words, symbol.tick * beat, stop * beat))
        return tracks

    def line(self, mover: Mover, symbols: list[_Symbol]) -> tree.Line:
        """Return the movements of one part, or that it stays in its starting position."""
        for before, after in pairwise(symbols):
            if not after.length:
                raise self.fault("unknown in the middle", mover=mover)
            if self.strict and after.start < before.stop:
                raise self.fault("back in time", mover=mover)
        if _stays(symbols):
            return tree.Line((tree.Item(tree.Step(mover, True, "at", symbols[0].words)),))
        items = tuple(
            tree.Item(tree.Step(mover, not number, "move", symbol.words), self.length(symbol))
            for number, symbol in enumerate(symbols)
        )
        return tree.Line(items, tuple(self.arrow(*pair) for pair in pairwise(symbols)))
