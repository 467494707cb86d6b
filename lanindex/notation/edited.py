"""A score as an editor holds it: numbers and words as JSON, times in ticks.

It says what LND says, and is read by the reader of LND, so that both refuse the same::

    {"speed": "60", "beats": 4, "beat": 4, "division": 96, "units": 2, "other": [],
     "symbols": [["r_arm", 0, 0, "place", "low"], ["r_arm", 24, 48, "right", "high"]]}

A symbol is its part, the ticks at which it starts and ends, and the words of its fields. There are
``division`` ticks in a unit; the grids of the editor lie on them. Those of a part stand in the
order of time: the number of each is its ordinal in the track that they become.
"""

import re
from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from math import lcm
from typing import Any

from lanindex.alphabet import DIRECTIONS, KINDS, LEVELS, kind_of
from lanindex.errors import NotationError, shown
from lanindex.model import Score
from lanindex.notation import lnd
from lanindex.notation.beats import in_time
from lanindex.notation.text import number

GRAIN = 24
"""Ticks of a beat, at least: eighths and sixths of it lie on them."""

_KEYS = {"speed": str, "beats": int, "beat": int, "division": int, "units": int}
_LISTS = ("other", "symbols")
_WORD = re.compile(r"\w{1,20}", re.ASCII)


def of_score(score: Score) -> dict[str, Any]:
    """Return what a score shows, on the grid of its LND.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.notation import edited
    >>> data = edited.of_score(lanindex.read_lnd("corpus/compass.lnd"))
    >>> data["speed"], data["division"], data["symbols"][:2]
    ('60', 96, [['r_arm', 0, 0, 'place', 'low'], ['r_arm', 0, 18, 'forward', 'low']])
    """
    score = lnd.read(lnd.write(score), place="LND")
    meter = score.meter
    division = lcm(meter.division, GRAIN * meter.beats)
    times = division // meter.division
    last, symbols = 0, list[list[Any]]()
    for part, track in score.tracks.items():
        kind = KINDS[track.kind]
        if not kind.keyword:
            continue
        words: dict[str, Any] = {
            "direction": DIRECTIONS,
            "level": LEVELS,
            "amount": kind.amounts or _Numbers(),
        }
        columns = [[words[it][code] for code in track.symbols[it].tolist()] for it in kind.fields]
        starts = (track.symbols["tick"] * times).tolist()
        stops = ((track.symbols["tick"] + track.symbols["ticks"]) * times).tolist()
        rows = zip(starts, stops, *columns, strict=True)
        symbols += [[part, *row] for row in rows]
        last = max([last, *stops])
    total = next(it for it in lnd.write(score).splitlines() if it.startswith("#unit_total"))
    return {
        "speed": number(meter.speed),
        "beats": meter.beats,
        "beat": meter.beat,
        "division": division,
        "units": int(total.split()[1]),
        "other": list(score.other),
        "symbols": symbols,
    }


class _Numbers:
    """The words of amounts that are numbers."""

    def __getitem__(self, number: int) -> str:
        return str(number)


def score_of(data: Mapping[str, Any]) -> Score:
    """Return the score that an editor holds.

    Raises
    ------
    NotationError
        LND cannot say it; ``place`` has the number of the symbol, from 1, as a line.
    """
    reader = lnd.LndReader("symbol")
    for name, kind in _KEYS.items():
        value = data.get(name)
        if not isinstance(value, kind) or isinstance(value, bool):
            raise NotationError(f"{value!r:.40}", place=name, wanted=f"a {kind.__name__}")
    for name in _LISTS:
        if not isinstance(data.get(name), list):
            raise NotationError(f"{data.get(name)!r:.40}", place=name, wanted="a list")
    division, beats = data["division"], data["beats"]
    if division < 1:
        raise NotationError(str(division), place="division", wanted="1 or more")
    for line in (
        f"#speed={data['speed']}",
        f"#rhythm {beats}/{data['beat']}",
        f"#unit_total {data['units']}",
        "#unit1",
    ):
        reader.take(line)
    for at, symbol in enumerate(data["symbols"]):
        try:
            written = _read(beats, division, *symbol)
        except (NotationError, TypeError, ValueError):  # said again, with its number
            reader.line = at
            _take(reader, Fraction(beats, division), symbol)
        else:
            reader.written.append(lnd.SymbolLine(*written, at + 1))
            reader.understood = True
    reader.other = [line for line in data["other"] if isinstance(line, str) and "\n" not in line]
    return in_time(reader.score())


@lru_cache(maxsize=1 << 14, typed=True)
def _read(
    beats: int, division: int, *symbol: Any
) -> tuple[str, tuple[int, ...], int, Fraction, Fraction]:
    """Return the line of a symbol but for its number: an editor sends many that did not change."""
    reader = lnd.LndReader("symbol")
    reader.unit = 1
    _take(reader, Fraction(beats, division), symbol)
    (line,) = reader.written
    return line.part, line.cell, line.unit, line.start, line.stop


def _take(reader: lnd.LndReader, ticks: Fraction, symbol: Any) -> None:
    part, start, stop, *words = _checked(symbol, reader)
    times = (number(it * ticks) for it in (start, stop))
    reader.take(" ".join([KINDS[kind_of(part)].keyword, part, *words, *times]))


def _checked(symbol: Any, reader: lnd.LndReader) -> list[Any]:
    """Return a symbol whose values have their types; what they say is checked as a line of LND."""
    match symbol:
        case [str(part), int(start), int(stop), *words] if 0 <= start <= stop and all(
            isinstance(it, str) and _WORD.fullmatch(it) for it in words
        ):
            pass
        case _:
            wanted = "its part, two ticks, and its words"
            raise reader.fault(f"{symbol!r:.60}", wanted, line=reader.line + 1)
    if not KINDS[kind_of(part)].keyword or not lnd.PART.fullmatch(part):
        wanted = "a part whose symbols stand in LND"
        raise reader.fault(f'"{shown(part)}"', wanted, line=reader.line + 1)
    return [part, start, stop, *words]
