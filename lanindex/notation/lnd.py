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
from collections.abc import Iterator
from fractions import Fraction
from os import PathLike, fspath

import numpy as np

from lanindex.alphabet import DIRECTIONS, KINDS, LEVELS, Kind
from lanindex.model import Meter, Score, Track
from lanindex.notation import content_of
from lanindex.notation.beats import Beats, in_time, ticks_at
from lanindex.notation.exact import number
from lanindex.notation.excerpt import excerpt
from lanindex.notation.page import UNIT, UNITS_PER_LINE, Page, rank
from lanindex.notation.text import decoded

Cell = tuple[int, ...]
"""The fields of a symbol, as its kind has them."""

__all__ = ["excerpt", "read", "write"]


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
    page = Page(place or "LND")
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
    >>> from lanindex.notation.lnd import excerpt
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
    """Sort the lines that were not understood: the header's, and each unit's."""
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
