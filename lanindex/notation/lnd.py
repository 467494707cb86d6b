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

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from math import ceil, lcm
from os import PathLike, fspath
from typing import Any

import numpy as np
from numpy.typing import NDArray

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

UNITS_PER_LINE = "#unit_per_line 4"  # default line for how many units stand in a row on paper
UNIT = re.compile(r"#unit(\d+)")  # the line before the kept lines of a unit

PART = re.compile(r"[a-z_]+")
_HEADING = re.compile(r"#\s*(speed|rhythm|unit_total|unit)(?![a-z_])\s*=?\s*(.*)", re.IGNORECASE)
_ONE_LINE = re.compile(r"[^\r\n]+")
_COUNT = re.compile(r"\d{1,9}")
_RHYTHM = re.compile(r"([1-9]\d?)\s*/\s*([1-9]\d?)")
# Keywords of the whole body; lines with them for a limb are kept, not read
_WHOLE_BODY = ("support", "jump", "travel", "rotation")
_AS_WELL = {("direction", "support")}  # keywords that also begin symbols of another kind

_LAST_TICK = int(np.iinfo(np.int32).max)
_SLOWEST, _FASTEST = Fraction(1, 10), Fraction(1000)
_HOURS = 24  # longest duration of a score: one that is longer holds a slip of the pen

_RANKS = {part: rank for rank, part in enumerate(TRACKS)}


def rank(part: str) -> tuple[int, str]:
    """Return the sort key of a part: the alphabet's order, unknown ones last."""
    return _RANKS.get(part, len(_RANKS)), part


@lru_cache(maxsize=256)
def fields_of(part: str) -> dict[str, dict[str, int]]:
    """Return the fields of a part's symbols in order, with the codes of their words, if any."""
    kind = KINDS[kind_of(part)]
    codes = {
        "direction": {word: DIRECTION_CODES[word] for word in kind.directions},
        "level": LEVEL_CODES,
        "amount": {word: kind.amounts.index(word) for word in amounts_of(part)},
    }
    return {name: codes[field] for name, field in zip(kind.names, kind.fields, strict=True)}


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
        start, stop = self.start, self.stop
        return (
            _in_units(before, start.numerator, start.denominator, beats),
            _in_units(before, stop.numerator, stop.denominator, beats),
        )


@lru_cache(maxsize=1 << 14)
def _in_units(before: int, numerator: int, denominator: int, beats: int) -> Fraction:
    # (before + time) / beats, which is slow with fractions
    return Fraction(before * denominator + numerator, beats * denominator)


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
            self._take_heading(heading[1].lower(), heading[2].strip())
        elif not words:
            pass
        elif words[0] not in LINES:
            self._refuse_misspelt(words[0])
            return self._keep(line)
        elif words[0] in _WHOLE_BODY and words[1:2] and words[1] in PARTS:
            return self._keep(line)
        else:
            self.written.append(self._symbol(*words))
        if mark:
            self._keep(mark + comment)
        self.understood |= bool(words)

    def _refuse_misspelt(self, word: str) -> None:
        """Refuse a misspelt keyword: its line would be kept, its symbol lost in silence."""
        from rapidfuzz.distance import OSA

        for keyword in (*LINES, "#speed", "#rhythm"):
            if OSA.distance(word.partition("=")[0], keyword) <= len(keyword) // 4:
                raise self.fault(f'"{shown(word)}"', f'"{keyword}"')

    def _keep(self, line: str) -> None:
        if line.split() == UNITS_PER_LINE.split():
            return
        if self.unit != self.kept_in:
            self.other.append(f"#unit{self.unit}")
            self.kept_in = self.unit
        self.other.append(line)

    def _take_heading(self, name: str, word: str) -> None:
        if name == "unit":
            self.unit = self._count(word, "unit")
        elif name == "unit_total":
            self.total = max(self.total, self._count(word, "total"))
        elif name == "speed":
            speed = self._number(word, "speed")
            if not _SLOWEST <= speed <= _FASTEST:
                wanted = f"{float(_SLOWEST)} to {_FASTEST} beats a minute"
                raise self.fault(f"a speed of {shown(word)}", wanted)
            if self.speed not in (None, speed):
                raise self.fault("a second speed", "one for the whole score")
            self.speed = speed
        else:
            match = _RHYTHM.fullmatch(word)
            if not match:
                raise self.fault(f'the rhythm "{shown(word)}"', "beats/note like 4/4")
            rhythm = int(match[1]), int(match[2])
            if self.rhythm not in (None, rhythm):
                raise self.fault("a second rhythm", "one for the whole score")
            self.rhythm = rhythm

    def _count(self, word: str, what: str) -> int:
        if not _COUNT.fullmatch(word):
            raise self.fault(f'the {what} "{shown(word)}"', "a whole number")
        return int(word)

    def _number(self, word: str, what: str) -> Fraction:
        if not DECIMAL.fullmatch(word):
            raise self.fault(f'the {what} "{shown(word)}"', "a number like 1.5")
        return fraction(word)

    def _symbol(self, keyword: str, *words: str) -> SymbolLine:
        kind = LINES[keyword]
        if len(words) != len(kind.names) + 3:
            count = {1: "four", 2: "five"}[len(kind.names)]
            wanted = f"{count}: part {' '.join(kind.names)} start end"
            raise self.fault(f"{len(words)} words behind {keyword}", wanted)
        part, *values, start, stop = words
        if self.unit is None:
            raise self.fault("a symbol before any unit", "a line like #unit1 above it")
        if not PART.fullmatch(part):
            raise self.fault(f'the part "{shown(part)}"', "a name like r_arm")
        own = KINDS[kind_of(part)]
        if own != kind and (keyword, own.name) not in _AS_WELL:
            wanted = f'"{own.keyword}"' if own.keyword else "the supports that it is made of"
            raise self.fault(f'"{keyword}" of {shown(part)}', wanted)
        cell = []
        for word, (name, codes) in zip(values, fields_of(part).items(), strict=True):
            if codes and word not in codes:
                near = guess(word, codes)
                remedy = f'Did you mean "{near}"?' if near else ""
                raise self.fault(f'the {name} "{shown(word)}"', " ".join(codes), remedy)
            cell.append(codes[word] if codes else self._count(word, "degrees"))
            if not codes and cell[-1] > MOST_AMOUNT:
                raise self.fault(f"a turn by {cell[-1]} degrees", f"at most {MOST_AMOUNT}")
        times = self._number(start, "start"), self._number(stop, "end")
        if times[1] < times[0]:
            wanted = f"at {shown(start)} or later, where it starts"
            raise self.fault(f"an end at {shown(stop)}", wanted)
        return SymbolLine(part, tuple(cell), self.unit, *times, self.line)

    def score(self) -> Score:
        """Return the score, once all lines are taken."""
        if not self.understood:
            raise self.fault("no line of LND", "lines like #unit1", line=0)
        beats, beat = self.rhythm or (4, 4)
        speed = self.speed or Fraction(60)
        symbols = [(*written.units(beats), written) for written in self.written]
        ends = [(Fraction(self.total), 0), *((stop, written.line) for _, stop, written in symbols)]
        units, line = max(ends, key=lambda it: it[0])
        hours = units * beats / speed / 60
        if hours > _HOURS:
            found = f"{ceil(units)} units of {beats} beats at {float(speed):g} beats a minute"
            wanted = f"at most {_HOURS} hours"
            raise self.fault(f"{found}, {float(hours):.3g} hours", wanted, line=line)
        division, last = Meter().division, max(self.total, 1)  # the coarsest grid of all times
        for start, stop, written in symbols:
            division = lcm(division, start.denominator, stop.denominator)
            last = max(last, ceil(stop))
            if last * division > _LAST_TICK:  # at once: a grid of many such times has no end
                found = f"{last} units in ticks of 1/{division} unit"
                wanted = f"at most {_LAST_TICK} ticks"
                raise self.fault(found, wanted, "Round the times to a few decimals.", written.line)
        meter, frames = Meter(speed, beats, beat, division), last * division
        parts: dict[str, list[tuple[int, int, SymbolLine]]] = defaultdict(list)
        for start, stop, written in symbols:
            tick, end = (it.numerator * (division // it.denominator) for it in (start, stop))
            parts[written.part].append((tick, end, written))
        tracks = {part: self._track(part, own, frames) for part, own in parts.items()}
        tracks = with_derived(tracks)
        tracks = {part: tracks[part] for part in sorted(tracks, key=rank)}
        return Score(meter.tick_rate, frames, meter, tracks, other=tuple(self.other))

    def _track(self, part: str, symbols: list[tuple[int, int, SymbolLine]], frames: int) -> Track:
        """Return the track of symbols (first tick, last tick, line), of which none share time."""
        symbols.sort(key=lambda it: (it[0], it[1], it[2].line))
        joined: list[tuple[int, int, SymbolLine]] = []
        for start, stop, symbol in symbols:
            tick, end, before = joined[-1] if joined else (-1, -1, symbol)
            if start < end or stop == tick:
                found = f"{part} has a symbol here and on line {before.line}"
                raise self.fault(found, "one at a time", line=symbol.line)
            if tick < end == start < stop and symbol.start == 0 and symbol.cell == before.cell:
                joined.pop()  # two halves across a bar line
                start = tick
            joined.append((start, stop, symbol))
        rows = blank(len(joined))
        starts, stops, lines = zip(*joined, strict=True)
        rows["start"], rows["tick"], rows["stop"], rows["margin"] = starts, starts, stops, 1
        rows["ticks"] = rows["stop"] - rows["tick"]
        for at, name in enumerate(KINDS[kind_of(part)].fields):
            rows[name] = [it.cell[at] for it in lines]
        return track_of(part, rows, frames)


def track_of(part: str, rows: NDArray[Any], frames: int) -> Track:
    """Return a track of rows, (S,) of `SYMBOL`; those without length begin its known spans."""
    seen = rows["start"][rows["start"] == rows["stop"]].tolist()
    edges = [*(seen if seen[:1] == [rows["start"][0]] else [0, *seen]), frames]
    return Track(part, rows, tuple(Span(*pair) for pair in pairwise(edges)))


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
    if isinstance(source, PathLike) or (isinstance(source, str) and _ONE_LINE.fullmatch(source)):
        place = place or fspath(source)
        source = content_of(fspath(source))
    page = LndReader(place or "LND")
    text = source if isinstance(source, str) else decoded(source, page.place, "LND")
    for line in re.split(r"\r\n|\r|\n", text.removeprefix("\ufeff")):
        page.take(line.strip())
    return in_time(page.score())


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
    header: list[str] = []
    kept: dict[int, list[str]] = defaultdict(list)
    lines = header
    for line in score.other:
        if heading := UNIT.fullmatch(line):
            lines = kept[int(heading[1])]
        else:
            lines.append(line)
    units: dict[int, list[tuple[int, int, str]]] = defaultdict(list)
    end, beats = np.array([score.frames]), Beats.of(score.other)
    last = int(ticks_at(end, score.meter, score.rate, beats, up=True)[0])
    written = [part for part in score.tracks if KINDS[score.tracks[part].kind].keyword]
    for column, part in enumerate(sorted(written, key=rank)):
        for unit, tick, stop, line in _lines(score.tracks[part], score.meter):
            units[unit].append((tick, column, line))
            last = max(last, stop)
    units_per_line = [line for line in header if line.startswith("#unit_per_line")]
    text = [
        *(line for line in header if line not in units_per_line),
        f"#speed={number(score.meter.speed)}",
        f"#rhythm {score.meter.beats}/{score.meter.beat}",
        *(units_per_line or [UNITS_PER_LINE]),
        f"#unit_total {max(1, -(-last // score.meter.division))}",
    ]
    for unit in sorted(units.keys() | kept.keys()):
        text += [f"#unit{unit}", *kept.get(unit, ())]
        text += [line for _, _, line in sorted(units.get(unit, ()), key=lambda entry: entry[:2])]
    return "\n".join(text) + "\n"


def _lines(track: Track, meter: Meter) -> Iterator[tuple[int, int, int, str]]:
    """Yield unit, first tick, last tick and line of each symbol that the score shows."""
    kind, beat = KINDS[track.kind], Fraction(meter.beats, meter.division)
    rows, free = track.symbols[~track.symbols["passing"]], 0
    cells = zip(*(rows[name].tolist() for name in kind.fields), strict=True)
    shown: list[tuple[int, int, tuple[int, ...]]] = []
    for tick, ticks, cell in zip(rows["tick"].tolist(), rows["ticks"].tolist(), cells, strict=True):
        # behind a short gap a starting position may round to before the end of the last symbol,
        # or two of them to one tick: the first is moved, of the others the last one stands
        tick = max(tick, free)
        free = tick + ticks
        if shown and tick == free and shown[-1][:2] == (tick, tick):
            shown.pop()
        shown.append((tick, free, cell))
    names = {"direction": DIRECTIONS, "level": LEVELS, "amount": kind.amounts}
    before = None
    for tick, stop, cell in shown:
        unit = tick // meter.division + 1 if stop else 0
        if tick % meter.division == 0 and stop > tick and before == (tick, cell):
            unit -= 1
        begin = max(unit - 1, 0) * meter.division
        words = [
            names[field][code] if names[field] else str(code)
            for field, code in zip(kind.fields, cell, strict=True)
        ]
        times = number((tick - begin) * beat), number((stop - begin) * beat)
        yield unit, tick, stop, " ".join((kind.keyword, track.part, *words, *times))
        before = (stop, cell) if stop > tick else None
