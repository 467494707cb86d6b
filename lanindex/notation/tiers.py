"""What annotation programs share: symbols as words with times in milliseconds.

Source: ``NOTATIONS.md``, "Tiers".
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import BENDS, BENT, HOW_BENT, KINDS, MOST_AMOUNT, TRACKS, kind_of
from lanindex.errors import ExportError, shown
from lanindex.model import Score, Track
from lanindex.notation.lnd import PART, LndReader, SymbolLine, fields_of, rank
from lanindex.notation.text import refuse

SECOND = 1000  # units of time in a second

_DEGREES = re.compile(r"(\d{1,9})deg")


@dataclass(frozen=True, slots=True)
class TierEntry:
    """A symbol as an entry of a tier."""

    words: str  # The symbol without its part
    start: int  # Milliseconds; a starting position has no length
    stop: int


def entries_of(score: Score) -> dict[str, list[TierEntry]]:
    """Return the entries of each part of a score: starting positions and movements."""
    tiers: dict[str, list[TierEntry]] = {}
    for part in sorted(score.tracks, key=rank):
        track = score.tracks[part]
        if not (KINDS[track.kind].keyword and len(track)):
            continue
        if not PART.fullmatch(part):
            wanted = "small letters and _, as in r_arm"
            raise ExportError(f'the part "{shown(part)}"', wanted=wanted)
        entries = tiers[part] = list[TierEntry]()
        for symbol in track.listed():
            if symbol.passing:
                continue
            start, stop = (milliseconds(it, score.rate) for it in (symbol.start, symbol.stop))
            again = bool(entries) and entries[-1].start == start == stop
            if again or (start == stop and symbol.start < symbol.stop):
                place = f"{part} at {start / SECOND:g} s"
                raise ExportError("a symbol of less than 1 ms", place=place, wanted="1 ms at least")
            entries.append(TierEntry(symbol.words, start, stop))
    return tiers


def milliseconds(frame: int, rate: Fraction) -> int:
    """Return the time of a frame in milliseconds, halves rounded up."""
    return (2 * frame * SECOND * rate.denominator + rate.numerator) // (2 * rate.numerator)


def is_part(name: str) -> bool:
    """Return whether a tier of that name is read: a track of the alphabet that is not derived."""
    return name in TRACKS and bool(KINDS[kind_of(name)].keyword)


def duration(score: Score) -> int:
    """Return the milliseconds of a score."""
    return milliseconds(score.frames, score.rate)


def score_of(
    tiers: Mapping[str, Iterable[TierEntry]],
    place: str,
    warnings: Iterable[str] = (),
    length: int = 0,
) -> Score:
    """Return the score of tiers."""
    page, bends = LndReader(place), dict[str, NDArray[np.int64]]()
    page.understood, page.total = True, -(-length // (4 * SECOND))
    for part, entries in tiers.items():
        if not PART.fullmatch(part):
            refuse(place, f'the part "{shown(part)}"', "one like r_arm")
        ordered, degrees, before = sorted(entries, key=lambda it: (it.start, it.stop)), [], None
        for it in ordered:
            where = f"{place}: {part} at {it.start / SECOND:g} s"
            if before and (it.start < before.stop or it.stop == before.start):
                found = f"begins before what begins at {before.start / SECOND:g} s is over"
                refuse(where, found, "one at a time")
            cell, degree = _read(part, it.words, where)
            times = Fraction(it.start, SECOND), Fraction(it.stop, SECOND)
            page.written.append(SymbolLine(part, cell, 1, *times, 0))
            degrees.append(degree)
            before = it
        bends[part] = np.array(degrees)
    score = page.score()
    tracks = dict(score.tracks)
    for part, track in score.tracks.items():
        if part in BENDS and (bends[part] >= 0).any():
            rows, bend = track.symbols.copy(), bends[part]  # without words at most slightly bent
            rows["amount"] = np.where(bend >= 0, bend, np.minimum(rows["amount"], BENT - 1))
            tracks[part] = Track(part, rows, track.known)
    return replace(score, tracks=tracks, warnings=tuple(warnings))


def _read(part: str, words: str, place: str) -> tuple[tuple[int, ...], int]:
    """Return the fields of a symbol and the degree of bend, -1 if none is written."""
    cell, rest = [], words.lower().split()
    fields = fields_of(part)
    for codes in fields.values():
        word = rest.pop(0) if rest else ("" if codes else "0deg")
        degrees = _DEGREES.fullmatch(word)
        if codes and word not in codes:
            refuse(place, f'"{shown(words)}"', " ".join(codes))
        if not codes and (degrees is None or int(degrees[1]) > MOST_AMOUNT):
            wanted = f"degrees at its end, like 90deg, at most {MOST_AMOUNT}"
            refuse(place, f'"{shown(words)}"', wanted)
        cell.append(int(degrees[1]) if degrees else codes[word])
    bend = " ".join(rest)
    if bend and (kind_of(part) != "gesture" or bend not in HOW_BENT):
        refuse(place, f'"{shown(words)}"', f"no more than {' and '.join(fields)}")
    return tuple(cell), HOW_BENT.index(bend) if bend else -1
