"""Read pasted LND: a line of it as a step, several as a score to find."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

from lanindex.alphabet import KINDS, LINES, kind_of
from lanindex.errors import NotationError, PatternError
from lanindex.search.language.cursor import Cursor
from lanindex.search.language.lexer import Token
from lanindex.search.language.mistakes import is_strange, stranger
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
from lanindex.search.language.things import OWN, values
from lanindex.search.language.times import Length, Time
from lanindex.search.language.words import ANY, DEGREES, RELATIVE, Mover

if TYPE_CHECKING:
    from lanindex import model

HEADINGS = ("speed", "rhythm", "unit_total", "unit_per_line", "unit")
"""What may stand behind ``#``."""

_COUNTED = {1: "four", 2: "five"}
"""How many words such a line has behind that, by how many fields it tells."""


@dataclass(frozen=True, slots=True)
class Symbol:
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
    """One line, and where it stands; of a symbol also who moves, and how."""

    text: str
    first: Token
    last: Token
    heading: str = ""
    mover: Mover | None = None
    symbol: Symbol | None = None


def is_lnd(cursor: Cursor) -> bool:
    """Tell whether a line of LND begins here: a word like jump alone is none."""
    if cursor.stands("word", "direction") or cursor.stands("mark", "#"):
        return True
    kind, part = LINES.get(cursor.token.text), cursor.ahead(1)
    return bool(kind and part.kind == "word" and KINDS[kind_of(part.text)] == kind)


def score_at(cursor: Cursor, strict: bool) -> tuple[Step | Bracket, Length | None]:
    """Read one or more lines of LND, which begin here.

    Parameters
    ----------
    cursor : Cursor
        Stands where they begin.
    strict : bool
        Whether the timing counts.

    Returns
    -------
    Step or Bracket, Length or None
        A line, or a score; of a line also how long it lasts, if that counts.

    Raises
    ------
    PatternError
        A line cannot be read, or they make no score.
    """
    lines = [_line_at(cursor)]
    while is_lnd(cursor):
        lines.append(_line_at(cursor))
    pace = _Pace(strict, _speed(lines))
    (first, *more) = lines
    if first.mover and first.symbol and not more:
        step = Step(first.mover, True, "move", first.symbol.words)
        return step, pace.length(first.symbol.length)
    return Bracket(Choice((_lines(cursor, lines, pace),))), None


def _line_at(cursor: Cursor) -> _Pasted:
    return _heading_at(cursor) if cursor.stands("mark", "#") else _symbol_at(cursor)


def _heading_at(cursor: Cursor) -> _Pasted:
    begin = cursor.advance()
    word = cursor.take("word")
    said = word.text if word else ""
    numbered = said[:4] == "unit" and said[4:].isdecimal()
    if not (said in HEADINGS or numbered):
        known = " ".join(f"#{heading}" for heading in HEADINGS)
        raise cursor.error(f"No such heading. LND has: {known}", begin, word or begin)
    cursor.take("mark", "=")
    if not numbered and not cursor.take("number"):
        raise cursor.error("A number follows this heading.", begin, cursor.before)
    if cursor.take("mark", "/") and not cursor.take("number"):
        raise cursor.error("A rhythm is like 4/4.", begin, cursor.before)
    text = " ".join(cursor.text[begin.start : cursor.before.stop].split())
    return _Pasted(text, begin, cursor.before, "unit" if numbered else said)


def _symbol_at(cursor: Cursor) -> _Pasted:
    begin = cursor.advance()
    kind = LINES[begin.text]
    part = cursor.mover_at()
    if part is None:
        raise stranger(cursor, True) if is_strange(cursor) else _short(cursor, begin)
    if part.form != "one":
        right, left = part.members
        raise cursor.error(f"LND names one part: {right} or {left}", cursor.before)
    words = tuple(_word_at(cursor, begin, name) for name in kind.names)
    times = [_number_at(cursor, begin) for _ in range(2)]
    start, stop = map(Fraction, times)
    if stop < start:
        raise cursor.error(f"An end at {times[1]} lies before the start.", begin, cursor.before)
    told = [word.values[0].removesuffix(DEGREES).replace(" ", "") for word in words]
    said = " ".join([begin.text, part.name, *told, *times])
    return _Pasted(said, begin, cursor.before, "", part, Symbol(words, start, stop))


def _short(cursor: Cursor, begin: Token) -> PatternError:
    names = LINES[begin.text].names
    count, told = _COUNTED[len(names)], " ".join(names)
    sentence = f"A line of LND has {count} words behind {begin.text}: part {told} start end"
    return cursor.error(sentence, begin, cursor.before)


def _word_at(cursor: Cursor, begin: Token, kind: str) -> Word:
    if kind == "degrees":
        return Word(kind, (_number_at(cursor, begin) + DEGREES,))
    if is_strange(cursor) and cursor.token.text not in OWN.get(kind, ()):
        raise stranger(cursor)
    found = values((kind,)).get(cursor.token.text) if cursor.stands("word") else None
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


def _speed(lines: list[_Pasted]) -> Fraction:
    """Return the beats a minute that a score tells, or 0."""
    said = [line.text.replace("=", " ").split()[-1] for line in lines if line.heading == "speed"]
    return Fraction(said[0]) if said else Fraction(0)


@dataclass(frozen=True, slots=True)
class _Pace:
    """How beats of a score become lengths of a pattern, where timing counts.

    A score that tells its speed is timed in seconds, any other in beats of the capture.
    """

    strict: bool
    speed: Fraction

    def length(self, beats: Fraction) -> Length | None:
        """Return what a symbol may last."""
        return Length("~", self._time(beats)) if self.strict and beats else None

    def arrow(self, before: Symbol, after: Symbol) -> Arrow:
        """Return the arrow from one movement to the next, over the rest between."""
        if not (self.strict and before.length):
            return NEXT
        rest = after.start - before.stop
        form, beats = ("~", rest) if rest else ("<=", before.length / 5)
        return Arrow(length=Length(form, self._time(beats)))

    def _time(self, beats: Fraction) -> Time:
        if not self.speed:
            return Time(_rounded(beats), "b")
        return Time(_rounded(beats * 60 / self.speed), "s")


def _rounded(number: Fraction) -> Fraction:
    return max(Fraction(round(number * 1000), 1000), Fraction(1, 1000))


def _lines(cursor: Cursor, pasted: list[_Pasted], pace: _Pace) -> Lines:
    """Return the score as lines side by side; those that move first, in order of appearance."""
    first, last = pasted[0].first, pasted[-1].last
    movers = dict.fromkeys(line.mover for line in pasted if line.mover)
    if not movers:
        raise cursor.error("A score without symbols: there is nothing to find.", first, last)
    in_units = any(line.heading == "unit" for line in pasted)
    tracks = _counted(cursor, pasted) if in_units else _as_written(pasted)
    lines = [_line(cursor, mover, tracks[mover.name], pace, first, last) for mover in movers]
    lines.sort(key=lambda line: line.items[0].unit.manner == "at")  # type: ignore[union-attr]
    return Lines(lines[0], tuple(Beside("with", line) for line in lines[1:]))


def _as_written(pasted: list[_Pasted]) -> dict[str, list[Symbol]]:
    tracks: dict[str, list[Symbol]] = {}
    for line in pasted:
        if line.mover and line.symbol:
            tracks.setdefault(line.mover.name, []).append(line.symbol)
    return tracks


def _counted(cursor: Cursor, pasted: list[_Pasted]) -> dict[str, list[Symbol]]:
    """Return the symbols by part, in units: sorted by time, halves across bar lines joined."""
    from lanindex.notation.lnd import read

    try:
        score = read("\n".join(["", *(line.text for line in pasted)]), place="LND")
    except NotationError as error:
        number = error.place.rpartition(":")[2]
        line = pasted[int(number) - 2] if number.isdecimal() else pasted[0]
        until = line if number.isdecimal() else pasted[-1]
        wanted = f", wanted {error.wanted}" if error.wanted else ""
        raise cursor.error(f"{error.found}{wanted}.", line.first, until.last) from error
    beat = Fraction(score.meter.beats, score.meter.division)
    return {
        part: [
            Symbol(_words(symbol), symbol.tick * beat, (symbol.tick + symbol.ticks) * beat)
            for symbol in score.symbols(part)
        ]
        for part in score.tracks
    }


def _words(symbol: model.Symbol) -> tuple[Word, ...]:
    """Return what a symbol says, in words."""
    said = zip(KINDS[kind_of(symbol.part)].names, symbol.words.split(), strict=True)
    return tuple(Word(name, (word,)) for name, word in said)


def _line(
    cursor: Cursor, mover: Mover, symbols: list[Symbol], pace: _Pace, first: Token, last: Token
) -> Line:
    """Return what one part does; of one that only has a starting position, that it is there."""
    for before, after in pairwise(symbols):
        if not after.length:
            raise cursor.error(
                f"{mover} has a symbol without length in the middle: it was not seen before that, "
                "and no pattern goes over a time in which a part is unknown.",
                first,
                last,
            )
        if pace.strict and after.start < before.stop:
            raise cursor.error(
                f"{mover} goes back in time: lines like #unit1 between would tell the time.",
                first,
                last,
            )
    if len(symbols) == 1 and not symbols[0].length:
        return Line((Item(Step(mover, True, "at", symbols[0].words)),))
    items = tuple(
        Item(Step(mover, not number, "move", symbol.words), pace.length(symbol.length))
        for number, symbol in enumerate(symbols)
    )
    return Line(items, tuple(pace.arrow(*pair) for pair in pairwise(symbols)))
