"""LND, the text form of Labanotation: read and write.

A file counts time in beats inside numbered units::

    #speed=80
    #rhythm 4/4
    #unit_total 2
    #unit0
    direction r_arm place low 0 0
    #unit1
    direction r_arm right high 1.5 2.5

Unit 0 holds starting positions. Later on, a symbol without length says that the part is seen
anew: the capture had a gap before it.

Source: ``encoding/METHOD.md``, "LND"; Matsumoto and Hachimura (2001), 3.2.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from math import ceil, lcm
from os import PathLike, fspath

import numpy as np

from lanindex.alphabet import (
    DIRECTION_CODES,
    DIRECTIONS,
    KINDS,
    LEVEL_CODES,
    LEVELS,
    LINES,
    MOST_AMOUNT,
    PARTS,
    TRACKS,
    Kind,
    amounts_of,
    kind_of,
)
from lanindex.errors import NotationError, guess, shown
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.derived import with_derived
from lanindex.model.symbol import blank
from lanindex.notation import content_of
from lanindex.notation.beats import Beats, in_time, ticks_at
from lanindex.notation.text import DECIMAL, decoded, fraction, number

UNITS_PER_LINE = "#unit_per_line 4"
"""Default line for how many units stand in a row on paper."""

_HEADING = re.compile(r"#\s*(speed|rhythm|unit_total|unit)(?![a-z_])\s*=?\s*(.*)", re.IGNORECASE)
UNIT = re.compile(r"#unit(\d+)")
"""The line before the kept lines of a unit."""

_COUNT = re.compile(r"\d{1,9}")
_RHYTHM = re.compile(r"([1-9]\d?)\s*/\s*([1-9]\d?)")
PART = re.compile(r"[a-z_]+")


def _codes(kind: Kind) -> dict[str, dict[str, int]]:
    """Return the fields of a symbol's line in order, with their words; degrees have none."""
    codes = {
        "direction": {name: DIRECTION_CODES[name] for name in kind.directions},
        "level": LEVEL_CODES,
    }
    amounts = {name: code for code, name in enumerate(kind.amounts)}
    return {name: codes.get(name, amounts) for name in kind.names}


_FIELDS = {keyword: _codes(kind) for keyword, kind in LINES.items()}
_COUNTED = {1: "four", 2: "five"}
"""Number of words behind a keyword, by its number of fields."""

_KEYWORDS = (*LINES, "#speed", "#rhythm")
_LAST_TICK = int(np.iinfo(np.int32).max)
_SLOWEST, _FASTEST = Fraction(1, 10), Fraction(1000)
_HOURS = 24
"""How long a score may last: one that is longer holds a slip of the pen."""

_Ends = tuple[Fraction, Fraction]
_RANKS = {part: rank for rank, part in enumerate(TRACKS)}


_AS_WELL = {("direction", "support")}
"""Keywords that also begin symbols of another kind."""

_RESERVED = ("support", "jump", "travel", "rotation")
"""Keywords of the whole body; lines with them for a limb are kept, not read."""


def rank(part: str) -> tuple[int, str]:
    """Return the sort key of a part: the alphabet's order, unknown ones last."""
    return _RANKS.get(part, len(_RANKS)), part


@dataclass(frozen=True, slots=True)
class SymbolLine:
    """The line of a symbol: its fields, and its times in beats from the beginning of its unit."""

    part: str
    cell: tuple[int, ...]
    unit: int
    start: Fraction
    stop: Fraction
    line: int

    def units(self, beats: int) -> tuple[Fraction, Fraction]:
        """Return start and stop in units from the beginning of unit 1."""
        if self.unit == 0:
            return Fraction(0), Fraction(0)
        before = (self.unit - 1) * beats
        return _over(self.start, before, beats), _over(self.stop, before, beats)


def _over(time: Fraction, before: int, beats: int) -> Fraction:
    """Return ``(before + time) / beats``, which is slow with fractions, of which there are many."""
    size = time.denominator
    return Fraction(before * size + time.numerator, beats * size)


@dataclass(slots=True)
class _Placed:
    """A symbol in ticks."""

    cell: tuple[int, ...]
    tick: int
    stop: int
    written: SymbolLine

    @property
    def opens_unit(self) -> bool:
        """Whether it can be the second half of a symbol across a bar line."""
        return self.written.start == 0 and self.stop > self.tick


class LndReader:
    """A reader of LND: `take` each line, then call `score`."""

    def __init__(self, place: str) -> None:
        self.place = place
        self.line = 0
        self.speed: Fraction | None = None
        self.rhythm: tuple[int, int] | None = None
        self.total = 0
        self.unit: int | None = None
        self.kept_in: int | None = None
        self.understood = False
        self.written: list[SymbolLine] = []
        self.other: list[str] = []

    def fault(
        self, found: str, wanted: str = "", remedy: str = "", line: int | None = None
    ) -> NotationError:
        """Return an error at a line: by default the current one, 0 for the whole file."""
        line = self.line if line is None else line
        place = f"{self.place}:{line}" if line else self.place
        return NotationError(found, place=place, wanted=wanted, remedy=remedy)

    def take(self, line: str) -> None:
        """Read one line."""
        self.line += 1
        content, mark, comment = line.partition("//")
        heading, words = _HEADING.fullmatch(content.strip()), content.lower().split()
        if heading:
            _HEADINGS[heading[1].lower()](self, heading[2].strip())
        elif words and words[0] in LINES and not self._reserved(*words):
            self.written.append(self._symbol(*words))
        elif words:
            if words[0] not in LINES:
                self._guard(words[0])
            self._keep(line)
            return
        if mark:
            self._keep(mark + comment)
        self.understood |= bool(words)

    def _reserved(self, keyword: str, part: str = "", *_: str) -> bool:
        """Return whether a line has a keyword of the whole body for a limb."""
        return keyword in _RESERVED and part in PARTS

    def _guard(self, word: str) -> None:
        """Refuse a misspelt keyword: its line would be kept, its symbol lost in silence."""
        from rapidfuzz.distance import OSA

        for meant in _KEYWORDS:
            if OSA.distance(word.partition("=")[0], meant) <= len(meant) // 4:
                raise self.fault(f'"{shown(word)}"', f'"{meant}"')

    def _keep(self, line: str) -> None:
        if line.split() == UNITS_PER_LINE.split():
            return
        if self.unit != self.kept_in:
            self.other.append(f"#unit{self.unit}")
            self.kept_in = self.unit
        self.other.append(line)

    def _speed(self, word: str) -> None:
        speed = self._number(word, "speed")
        if not _SLOWEST <= speed <= _FASTEST:
            wanted = f"{float(_SLOWEST)} to {_FASTEST} beats a minute"
            raise self.fault(f"a speed of {shown(word)}", wanted)
        if self.speed not in (None, speed):
            raise self.fault("a second speed", "one for the whole score")
        self.speed = speed

    def _rhythm(self, word: str) -> None:
        match = _RHYTHM.fullmatch(word)
        if not match:
            raise self.fault(f'the rhythm "{shown(word)}"', "beats/note like 4/4")
        rhythm = int(match[1]), int(match[2])
        if self.rhythm not in (None, rhythm):
            raise self.fault("a second rhythm", "one for the whole score")
        self.rhythm = rhythm

    def _total(self, word: str) -> None:
        self.total = max(self.total, self._count(word, "total"))

    def _unit(self, word: str) -> None:
        self.unit = self._count(word, "unit")

    def _count(self, word: str, what: str) -> int:
        if not _COUNT.fullmatch(word):
            raise self.fault(f'the {what} "{shown(word)}"', "a whole number")
        return int(word)

    def _number(self, word: str, what: str) -> Fraction:
        if not DECIMAL.fullmatch(word):
            raise self.fault(f'the {what} "{shown(word)}"', "a number like 1.5")
        return fraction(word)

    def _symbol(self, keyword: str, *words: str) -> SymbolLine:
        """Read what stands behind ``direction``, or another word that begins a symbol."""
        kind, fields = LINES[keyword], _FIELDS[keyword]
        if len(words) != len(fields) + 3:
            found = f"{len(words)} words behind {keyword}"
            wanted = f"{_COUNTED[len(fields)]}: part {' '.join(fields)} start end"
            raise self.fault(found, wanted)
        part, *said, start, stop = words
        if self.unit is None:
            raise self.fault("a symbol before any unit", "a line like #unit1 above it")
        if not PART.fullmatch(part):
            raise self.fault(f'the part "{shown(part)}"', "a name like r_arm")
        own = KINDS[kind_of(part)]
        if own != kind and (keyword, own.name) not in _AS_WELL:
            wanted = f'"{own.keyword}"' if own.keyword else "the supports that it is made of"
            raise self.fault(f'"{keyword}" of {shown(part)}', wanted)
        cell = tuple(
            self._code(word, name, codes) if codes else self._degrees(word)
            for word, (name, codes) in zip(said, fields.items(), strict=True)
        )
        name = kind.amounts[cell[-1]] if kind.amounts else ""
        if name and name not in amounts_of(part):
            raise self.fault(f'the {kind.names[-1]} "{name}"', " ".join(amounts_of(part)))
        times = self._number(start, "start"), self._number(stop, "end")
        if times[1] < times[0]:
            wanted = f"at {shown(start)} or later, where it starts"
            raise self.fault(f"an end at {shown(stop)}", wanted)
        return SymbolLine(part, cell, self.unit, *times, self.line)

    def _degrees(self, word: str) -> int:
        degrees, most = self._count(word, "degrees"), MOST_AMOUNT
        if degrees > most:
            raise self.fault(f"a turn by {degrees} degrees", f"at most {most}")
        return degrees

    def _code(self, word: str, what: str, codes: dict[str, int]) -> int:
        if word in codes:
            return codes[word]
        near = guess(word, codes)
        remedy = f'Did you mean "{near}"?' if near else ""
        raise self.fault(f'the {what} "{shown(word)}"', " ".join(codes), remedy)

    def score(self) -> Score:
        """Return the score, once all lines are taken."""
        if not self.understood:
            raise self.fault("no line of LND", "lines like #unit1", line=0)
        beats, beat = self.rhythm or (4, 4)
        speed = self.speed or Fraction(60)
        times = [written.units(beats) for written in self.written]
        self._check_length(times, beats, speed)
        meter = Meter(speed, beats, beat, self._division(times))
        parts: dict[str, list[_Placed]] = defaultdict(list)
        for written, ends in zip(self.written, times, strict=True):
            start, stop = (it.numerator * (meter.division // it.denominator) for it in ends)
            parts[written.part].append(_Placed(written.cell, start, stop, written))
        for symbols in parts.values():
            symbols.sort(key=lambda symbol: (symbol.tick, symbol.stop, symbol.written.line))
            self._check(symbols)
        last = max((symbol.stop for symbols in parts.values() for symbol in symbols), default=0)
        frames = max(self.total, -(-last // meter.division), 1) * meter.division
        tracks = {part: _track(part, _joined(parts[part]), frames) for part in parts}
        tracks = with_derived(tracks)
        tracks = {part: tracks[part] for part in sorted(tracks, key=rank)}
        return Score(meter.tick_rate, frames, meter, tracks, other=tuple(self.other))

    def _check_length(self, times: list[_Ends], beats: int, speed: Fraction) -> None:
        """Refuse a score that would last for longer than a day."""
        ends = zip(times, self.written, strict=True)
        last = max(ends, key=lambda it: it[0][1], default=None)
        units, line = (last[0][1], last[1].line) if last else (Fraction(0), 0)
        if units <= self.total:
            units, line = Fraction(self.total), 0
        hours = units * beats / speed / 60
        if hours > _HOURS:
            found = f"{ceil(units)} units of {beats} beats at {float(speed):g} beats a minute"
            wanted = f"at most {_HOURS} hours"
            raise self.fault(f"{found}, {float(hours):.3g} hours", wanted, line=line)

    def _division(self, times: list[_Ends]) -> int:
        """Return the coarsest grid that holds all times."""
        division, units = Meter().division, max(self.total, 1)
        for written, (start, stop) in zip(self.written, times, strict=True):
            division = lcm(division, start.denominator, stop.denominator)
            units = max(units, ceil(stop))
            if units * division > _LAST_TICK:  # at once: a grid of many such times has no end
                found = f"{units} units in ticks of 1/{division} unit"
                wanted = f"at most {_LAST_TICK} ticks"
                raise self.fault(found, wanted, "Round the times to a few decimals.", written.line)
        return division

    def _check(self, symbols: list[_Placed]) -> None:
        """Refuse symbols that share time; two of them may only touch."""
        for one, two in pairwise(symbols):
            if two.tick < one.stop or two.stop == one.tick:
                found = f"{two.written.part} has a symbol here and on line {one.written.line}"
                raise self.fault(found, "one at a time", line=two.written.line)


def _joined(symbols: Iterable[_Placed]) -> list[_Placed]:
    """Join the halves of symbols across bar lines."""
    joined: list[_Placed] = []
    for symbol in symbols:
        last = joined[-1] if joined else None
        if (
            last is not None
            and symbol.opens_unit
            and (last.cell, last.stop) == (symbol.cell, symbol.tick)
            and last.tick < last.stop
        ):
            joined[-1] = replace(last, stop=symbol.stop)
        else:
            joined.append(symbol)
    return joined


def _track(part: str, symbols: list[_Placed], frames: int) -> Track:
    rows = blank(len(symbols))
    cells = zip(*(symbol.cell for symbol in symbols), strict=True)
    for name, codes in zip(KINDS[kind_of(part)].fields, cells, strict=True):
        rows[name] = codes
    rows["start"] = rows["tick"] = [symbol.tick for symbol in symbols]
    rows["stop"] = [symbol.stop for symbol in symbols]
    rows["ticks"], rows["margin"] = rows["stop"] - rows["tick"], 1
    seen = [symbol.tick for symbol in symbols if symbol.tick == symbol.stop]
    edges = [*(seen if seen[:1] == [symbols[0].tick] else [0, *seen]), frames]
    known = tuple(Span(*pair) for pair in pairwise(edges))
    return Track(part, rows, known)


_HEADINGS: dict[str, Callable[[LndReader, str], None]] = {
    "speed": LndReader._speed,
    "rhythm": LndReader._rhythm,
    "unit_total": LndReader._total,
    "unit": LndReader._unit,
}


Cell = tuple[int, ...]
"""The fields of a symbol, as its kind has them."""


def read(source: str | bytes | PathLike[str], *, place: str = "") -> Score:
    """Read a score from LND.

    Symbols of equal direction and level are joined where the second begins its unit and
    touches the first: a movement across a bar line, written as two. A tick is the largest
    1/N of a unit, N a multiple of 32, on which all times of the file lie; ``meter.division``
    tells N, and ticks are the score's frames. Lines that are not understood, and comments,
    are kept in ``other``, those of unit 3 behind a line ``#unit3``. A comment that tells the beats
    gives ticks their times; frames are finer then.

    Parameters
    ----------
    source : path-like, str or bytes
        A file, or its content: bytes, or text of more than one line.
    place : str, optional
        What errors call the text; the path unless told.

    Returns
    -------
    Score
        Its frames are ticks, its rate is ticks a second, its margins are 1.

    Raises
    ------
    NotationError
        The file or a line cannot be read, or two symbols of a part overlap.

    Examples
    --------
    >>> import lanindex
    >>> score = lanindex.read_lnd('''
    ... #rhythm 4/4
    ... #unit0
    ... direction r_arm place low 0 0
    ... #unit1
    ... direction r_arm right high 1.5 2.5
    ... ''')
    >>> for symbol in score.symbols():  # in ticks, 32 a unit
    ...     print(symbol)
    r_arm place low [0, 0)
    r_arm right high [12, 20)
    """
    if isinstance(source, PathLike) or (isinstance(source, str) and _names_a_file(source)):
        place = place or fspath(source)
        source = content_of(fspath(source))
    page = LndReader(place or "LND")
    text = source if isinstance(source, str) else decoded(source, page.place, "LND")
    for line in re.split(r"\r\n|\r|\n", text.removeprefix("\ufeff")):
        page.take(line.strip())
    return in_time(page.score())


def _names_a_file(source: str) -> bool:
    return bool(source) and "\n" not in source and "\r" not in source


def write(score: Score) -> str:
    """Write what a score shows as LND, in quantised time.

    Passing symbols, margins and source frames are not in LND. A symbol across a bar line
    stands in the unit it starts in. One that repeats the symbol it touches at a bar line stands
    at the end of the unit before, so that reading does not join the two. Lines that were not
    understood stand first in their units.

    Parameters
    ----------
    score : Score
        Only ``tick`` and ``ticks`` of its symbols count, not their frames.

    Returns
    -------
    str
        Text that `read` reads; lines end with a line feed.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.model import Span
    >>> from lanindex.notation.excerpt import excerpt
    >>> score = lanindex.read_lnd("corpus/compass.lnd")
    >>> print(lanindex.write_lnd(excerpt(score, Span(0, 16))))
    // The compass of the right arm: all 27 directions, one a beat.
    #speed=60
    #rhythm 4/4
    #unit_per_line 4
    #unit_total 1
    #unit0
    direction r_arm place low 0 0
    #unit1
    direction r_arm forward low 0 0.75
    direction r_arm r_forward low 1 1.75
    """
    header, kept = _kept(score.other)
    units: dict[int, list[tuple[int, int, str]]] = defaultdict(list)
    end, beats = np.array([score.frames]), Beats.of(score.other)
    last = int(ticks_at(end, score.meter, score.rate, beats, up=True)[0])
    written = [part for part in score.tracks if KINDS[score.tracks[part].kind].keyword]
    for column, part in enumerate(sorted(written, key=rank)):
        for unit, tick, stop, line in _lines(score.tracks[part], score.meter):
            units[unit].append((tick, column, line))
            last = max(last, stop)
    wishes = [line for line in header if line.startswith("#unit_per_line")]
    text = [
        *(line for line in header if line not in wishes),
        f"#speed={number(score.meter.speed)}",
        f"#rhythm {score.meter.beats}/{score.meter.beat}",
        *(wishes or [UNITS_PER_LINE]),
        f"#unit_total {max(1, -(-last // score.meter.division))}",
    ]
    for unit in sorted(units.keys() | kept.keys()):
        text += [f"#unit{unit}", *kept.get(unit, ())]
        text += [line for _, _, line in sorted(units.get(unit, ()), key=lambda entry: entry[:2])]
    return "\n".join(text) + "\n"


def _lines(track: Track, meter: Meter) -> Iterator[tuple[int, int, int, str]]:
    """Yield unit, first tick, last tick and line of each symbol that the score shows."""
    beat = Fraction(meter.beats, meter.division)
    head = f"{KINDS[track.kind].keyword} {track.part}"
    names, before = _names(KINDS[track.kind]), None
    for tick, stop, cell in _shown(track):
        unit = tick // meter.division + 1 if stop else 0
        if tick % meter.division == 0 and stop > tick and before == (tick, cell):
            unit -= 1
        begin = max(unit - 1, 0) * meter.division
        words = zip(names, cell, strict=True)
        said = " ".join(own[code] if own else str(code) for own, code in words)
        times = f"{number((tick - begin) * beat)} {number((stop - begin) * beat)}"
        yield unit, tick, stop, f"{head} {said} {times}"
        before = (stop, cell) if stop > tick else None


def _names(kind: Kind) -> list[tuple[str, ...]]:
    """Return the words for each field of a kind; of degrees, which are numbers, none."""
    names = {"direction": DIRECTIONS, "level": LEVELS, "amount": kind.amounts}
    return [names[name] for name in kind.fields]


def _shown(track: Track) -> list[tuple[int, int, Cell]]:
    """Return first tick, last tick and fields of each symbol that the score shows.

    After a short gap a part's new starting position may round to before the end of what it did
    last, or two of them to one tick: the first is moved, of the others the last one stands.
    """
    shown: list[tuple[int, int, Cell]] = []
    rows, free = track.symbols[~track.symbols["passing"]], 0
    cells = zip(*(rows[name].tolist() for name in KINDS[track.kind].fields), strict=True)
    times = zip(rows["tick"].tolist(), rows["ticks"].tolist(), cells, strict=True)
    for tick, ticks, cell in times:
        tick = max(tick, free)
        free = tick + ticks
        if shown and tick == free and shown[-1][:2] == (tick, tick):
            shown.pop()
        shown.append((tick, free, cell))
    return shown


def _kept(other: tuple[str, ...]) -> tuple[list[str], dict[int, list[str]]]:
    """Return kept lines of the header and of each unit."""
    header: list[str] = []
    units: dict[int, list[str]] = defaultdict(list)
    here = header
    for line in other:
        heading = UNIT.fullmatch(line)
        if heading:
            here = units[int(heading[1])]
        else:
            here.append(line)
    return header, units
