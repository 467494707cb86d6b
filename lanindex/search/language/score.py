"""Scores as patterns: pasted LND, a line of it a step, several a score to find; and files."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from lanindex import model
from lanindex.alphabet import KINDS, LINES, kind_of
from lanindex.errors import NotationError, PatternError
from lanindex.notation import NOTATIONS, notation_of, read
from lanindex.notation.text import read_text
from lanindex.search.language.lexer import Cursor, Token
from lanindex.search.language.query import (
    NEXT,
    Arrow,
    Beside,
    Bracket,
    Choice,
    Item,
    Line,
    Lines,
    Step,
    Word,
)
from lanindex.search.language.suggestions import is_unknown, unknown
from lanindex.search.language.times import Length, Time
from lanindex.search.language.words import ANY, DEGREES, RELATIVE, THINGS, Mover, values_for

_SUFFIXES = "|".join(("lq", *map(re.escape, NOTATIONS)))
_FILE = re.compile(rf"@(?P<path>.*\.(?:{_SUFFIXES})|\S*[/\\].*)", re.IGNORECASE | re.DOTALL)

_HEADINGS = ("speed", "rhythm", "unit_total", "unit_per_line", "unit")
"""What may stand behind ``#``."""


class Saved(str):
    """A pattern's text that knows the file it comes from, so that an error can name it."""

    path: Path

    def __new__(cls, text: str, path: Path) -> Saved:
        """Make one of a text."""
        made = super().__new__(cls, text)
        made.path = path
        return made

    def place(self, start: int) -> str:
        """Return file and line of a character."""
        return f"{self.path}:{self.count(chr(10), 0, start) + 1}"


def pattern_in(text: str, folder: Path | None = None) -> str:
    r"""Return a pattern, read from a file where its text names one.

    Parameters
    ----------
    text : str
        A pattern, or ``@`` and the path of a file that ends in ``.lq`` or as a score, or has a
        slash. Scores in other notations are read as LND.
    folder : Path, optional
        What the path starts from; by default the working folder.

    Returns
    -------
    str
        The text itself, or a `Saved`.

    Raises
    ------
    NotationError
        Where the file cannot be read, or is not text.

    Examples
    --------
    >>> from pathlib import Path
    >>> from lanindex.search.language.score import pattern_in
    >>> _ = Path("up.lq").write_text("// to overhead\nr_arm low -> place high")
    >>> print(pattern_in("@up.lq"))
    // to overhead
    r_arm low -> place high
    """
    named = _FILE.fullmatch(text.strip())
    if named is None:
        return text
    path = Path(named["path"]) if folder is None else folder / named["path"]
    form = notation_of(str(path))
    if form is not None and form.name != "lnd":
        from lanindex.notation import lnd

        return Saved(lnd.write(read(str(path))), path)
    return Saved(read_text(path).replace("\r\n", "\n").replace("\r", "\n"), path)


def is_lnd(cursor: Cursor) -> bool:
    """Tell whether a line of LND begins here: a word like jump alone is none."""
    if cursor.stands("word", "direction") or cursor.stands("mark", "#"):
        return True
    kind, part = LINES.get(cursor.token.text), cursor.ahead(1)
    return bool(kind and part.kind == "word" and KINDS[kind_of(part.text)] == kind)


def score_at(cursor: Cursor, strict: bool) -> tuple[Step | Bracket, Length | None]:
    """Read one or more lines of LND, which begin here.

    Of a single line it is a step, and how long that lasts if the timing counts (`strict`).
    """
    score = _Score(cursor, strict)
    (first, *more) = score.lines
    if first.mover and first.symbol and not more:
        step = Step(first.mover, True, "move", first.symbol.words)
        return step, score.length(first.symbol)
    return Bracket(Choice((score.side_by_side(),))), None


@dataclass(frozen=True, slots=True)
class _Symbol:
    """A symbol of a score: its words, and its times in beats."""

    words: tuple[Word, ...]
    start: Fraction
    stop: Fraction

    @property
    def length(self) -> Fraction:
        """Beats that it lasts; a starting position has none."""
        return self.stop - self.start


@dataclass(frozen=True, slots=True)
class _Pasted:
    """One line, and where it stands: a heading, or who moves, and how."""

    text: str
    first: Token
    last: Token
    heading: str = ""
    mover: Mover | None = None
    symbol: _Symbol | None = None


def _heading_at(cursor: Cursor) -> _Pasted:
    begin = cursor.advance()
    word = cursor.take("word")
    said = word.text if word else ""
    numbered = said[:4] == "unit" and said[4:].isdecimal()
    if not (said in _HEADINGS or numbered):
        known = " ".join(f"#{heading}" for heading in _HEADINGS)
        raise cursor.error(f"No such heading. LND has: {known}", begin, word or begin)
    cursor.take("mark", "=")
    if not numbered and not cursor.take("number"):
        raise cursor.error_since(begin, "A number follows this heading.")
    if cursor.take("mark", "/") and not cursor.take("number"):
        raise cursor.error_since(begin, "A rhythm is like 4/4.")
    text = " ".join(cursor.text[begin.start : cursor.before.stop].split())
    return _Pasted(text, begin, cursor.before, "unit" if numbered else said)


def _symbol_at(cursor: Cursor) -> _Pasted:
    begin = cursor.advance()
    part = cursor.mover()
    if part is None:
        raise unknown(cursor, True) if is_unknown(cursor) else _short(cursor, begin)
    if part.form != "one":
        right, left = part.members
        raise cursor.error(f"LND names one part: {right} or {left}", cursor.before)
    words = tuple(_word_at(cursor, begin, kind) for kind in LINES[begin.text].names)
    times = [_number_at(cursor, begin) for _ in range(2)]
    start, stop = map(Fraction, times)
    if stop < start:
        raise cursor.error_since(begin, f"An end at {times[1]} lies before the start.")
    told = [word.values[0].removesuffix(DEGREES).replace(" ", "") for word in words]
    text = " ".join([begin.text, part.name, *told, *times])
    return _Pasted(text, begin, cursor.before, "", part, _Symbol(words, start, stop))


def _short(cursor: Cursor, begin: Token) -> PatternError:
    names = LINES[begin.text].names
    count = {1: "four", 2: "five"}[len(names)]
    known = f"A line of LND has {count} words behind {begin.text}: part"
    return cursor.error_since(begin, f"{known} {' '.join(names)} start end")


def _word_at(cursor: Cursor, begin: Token, kind: str) -> Word:
    if kind == "degrees":
        return Word(kind, (_number_at(cursor, begin) + DEGREES,))
    if is_unknown(cursor) and cursor.token.text not in THINGS.get(kind, ()):
        raise unknown(cursor)
    found = values_for((kind,)).get(cursor.token.text) if cursor.stands("word") else None
    if found is None or found[0] != kind or found[1] in (*RELATIVE, ANY):
        raise _short(cursor, begin)
    cursor.advance()
    return Word(kind, (found[1],))


def _number_at(cursor: Cursor, begin: Token) -> str:
    number = cursor.take("number")
    if number is None:
        raise _short(cursor, begin)
    if len(number.text) > 40:
        raise cursor.error("No more than 40 digits, please.", number)
    return number.text


def _words(symbol: model.Symbol) -> tuple[Word, ...]:
    names = KINDS[kind_of(symbol.part)].names
    said = zip(names, symbol.words.split(), strict=True)
    return tuple(Word(name, (word,)) for name, word in said)


def _stays(symbols: list[_Symbol]) -> bool:
    """Tell whether a track is a starting position alone."""
    return len(symbols) == 1 and not symbols[0].length


class _Score:
    """Lines of LND, read from where a cursor stands; the timing of them counts, or not.

    A score that tells its speed is timed in seconds, any other in beats of the capture.
    """

    def __init__(self, cursor: Cursor, strict: bool) -> None:
        self.cursor, self.strict = cursor, strict
        self.lines: list[_Pasted] = []
        while is_lnd(cursor):
            heading = cursor.stands("mark", "#")
            self.lines.append(_heading_at(cursor) if heading else _symbol_at(cursor))
        said = [it.text.replace("=", " ").split()[-1] for it in self.lines if it.heading == "speed"]
        self.speed = Fraction(said[0]) if said else Fraction(0)  # beats a minute

    def error(self, sentence: str) -> PatternError:
        return self.cursor.error(sentence, self.lines[0].first, self.lines[-1].last)

    def length(self, symbol: _Symbol) -> Length | None:
        """Return what a symbol may last."""
        return Length("~", self.time(symbol.length)) if self.strict and symbol.length else None

    def arrow(self, before: _Symbol, after: _Symbol) -> Arrow:
        """Return the arrow from one movement to the next, over the rest between."""
        if not (self.strict and before.length):
            return NEXT
        rest = after.start - before.stop
        form, beats = ("~", rest) if rest else ("<=", before.length / 5)
        return Arrow(length=Length(form, self.time(beats)))

    def time(self, beats: Fraction) -> Time:
        number, unit = (beats * 60 / self.speed, "s") if self.speed else (beats, "b")
        return Time(max(Fraction(round(number * 1000), 1000), Fraction(1, 1000)), unit)

    def side_by_side(self) -> Lines:
        """Return a line for each part: those that move first, in order of appearance."""
        movers = list(dict.fromkeys(line.mover for line in self.lines if line.mover))
        if not movers:
            raise self.error("A score without symbols: there is nothing to find.")
        in_units = any(line.heading == "unit" for line in self.lines)
        tracks = self.tracks_in_units() if in_units else self.tracks_as_written()
        movers.sort(key=lambda mover: _stays(tracks[mover.name]))
        lines = [self.line(mover, tracks[mover.name]) for mover in movers]
        return Lines(lines[0], tuple(Beside("with", line) for line in lines[1:]))

    def tracks_as_written(self) -> dict[str, list[_Symbol]]:
        tracks: dict[str, list[_Symbol]] = {}
        for line in self.lines:
            if line.mover and line.symbol:
                tracks.setdefault(line.mover.name, []).append(line.symbol)
        return tracks

    def tracks_in_units(self) -> dict[str, list[_Symbol]]:
        """Return the symbols by part, sorted by time, halves across bar lines joined."""
        from lanindex.notation import lnd

        try:
            score = lnd.read("\n".join(["", *(line.text for line in self.lines)]), place="LND")
        except NotationError as error:
            number = error.place.rpartition(":")[2]
            found = f"{error.found}{f', wanted {error.wanted}' if error.wanted else ''}."
            if not number.isdecimal():
                raise self.error(found) from error
            line = self.lines[int(number) - 2]
            raise self.cursor.error(found, line.first, line.last) from error
        beat = Fraction(score.meter.beats, score.meter.division)
        return {
            part: [
                _Symbol(_words(symbol), symbol.tick * beat, (symbol.tick + symbol.ticks) * beat)
                for symbol in score.symbols(part)
            ]
            for part in score.tracks
        }

    def line(self, mover: Mover, symbols: list[_Symbol]) -> Line:
        """Return what one part does; of one that only has a starting position, that it is there."""
        for before, after in pairwise(symbols):
            if not after.length:
                raise self.error(
                    f"{mover} has a symbol without length in the middle: it was not seen before "
                    "that, and no pattern goes over a time in which a part is unknown."
                )
            if self.strict and after.start < before.stop:
                raise self.error(
                    f"{mover} goes back in time: lines like #unit1 between would tell the time."
                )
        if _stays(symbols):
            return Line((Item(Step(mover, True, "at", symbols[0].words)),))
        items = tuple(
            Item(Step(mover, not number, "move", symbol.words), self.length(symbol))
            for number, symbol in enumerate(symbols)
        )
        return Line(items, tuple(self.arrow(*pair) for pair in pairwise(symbols)))
