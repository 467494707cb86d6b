"""Borders and rules of an encoding: LPD, Labanotation Parameter Data, and LDD, Delete Data.

LPD tells which angles each direction and level spans, LDD which symbols between others are only
passed on the way. Source: ``encoding/METHOD.md``, "LPD" and "LDD"; Matsumoto and Hachimura (2001),
4.5.2, 4.6, figures 13 and 14.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from lanindex.alphabet import DIRECTION_CODES, DIRECTIONS, LEVEL_CODES, PLACE
from lanindex.errors import NotationError, shown
from lanindex.notation.text import read_text, words_of


@dataclass(frozen=True, slots=True)
class Ranges:
    """The cells that space is divided into around a joint."""

    place: float  # Horizontal radius of ``place``: millimetres, or parts of the limb's length
    relative: bool  # Whether `place` is in parts of the limb's length
    starts: tuple[float, ...]  # (8) azimuth in degrees at which each direction begins, by code
    mid: float  # Elevation in degrees from straight down at which each level begins
    high: float

    def radius(self, length: float) -> float:
        """Return the radius of ``place`` in mm for a limb of `length` mm."""
        return self.place * length if self.relative else self.place

    def centre(self, direction: int) -> float:
        """Return the middle azimuth of a direction's sector, in degrees."""
        begin = self.starts[direction]
        end = min((start - begin) % 360 or 360 for start in self.starts)
        return (begin + end / 2) % 360


def _number(word: str, place: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or value < 0:
        raise NotationError(f'"{shown(word)}"', place=place, wanted="a number of 0 or more")
    return value


_COUNTS = {"place": (1, 2), "mid": (2,), "high": (1,), "low": (1,)}


def parse_lpd(text: str, name: str = "LPD") -> Ranges:
    """Read the text of an LPD file."""
    found: dict[str, list[float]] = {}
    relative = False
    for number, (word, *values) in words_of(text):
        place, word = f"{name}:{number}", word.lower()
        if word not in DIRECTION_CODES and word not in LEVEL_CODES:
            raise NotationError(f'"{shown(word)}"', place=place, wanted="a direction or a level")
        if word in found:
            raise NotationError(f'"{word}" stands twice', place=place, wanted="one line of it")
        if word == "place" and len(values) == 2 and values[1] == "L":
            relative = True
            values = values[:1]
        counts = _COUNTS.get(word, (1,))
        if len(values) != counts[0]:
            raise NotationError(
                f"{len(values)} values after {word}", place=place, wanted=str(counts[0])
            )
        found[word] = [_number(value, place) for value in values]
    missing = [word for word in (*DIRECTIONS, *LEVEL_CODES) if word not in found]
    if missing:
        raise NotationError("no line for " + ", ".join(missing), place=name, wanted="all of them")
    mid, high = found["mid"][0], found["high"][0]
    if not 0 < mid < high < 180 or found["mid"][1] != 360 - high or found["low"][0] != 360 - mid:
        raise NotationError(
            f"low {found['low'][0]:g}, mid {mid:g} {found['mid'][1]:g}, high {high:g}",
            place=name,
            wanted="mid m 360-h, high h, low 360-m with 0 < m < h < 180",
        )
    starts = tuple(found[word][0] % 360 for word in DIRECTIONS[:PLACE])
    _check_order(starts, name)
    return Ranges(found["place"][0], relative, starts, mid, high)


def _check_order(starts: tuple[float, ...], name: str) -> None:
    turns = [(b - a) % 360 for a, b in zip(starts, (*starts[1:], starts[0]), strict=True)]
    if min(turns) <= 0 or abs(sum(turns) - 360) > 1e-9:
        raise NotationError(
            "the directions do not follow each other round the circle",
            place=name,
            wanted="rising starts from right over forward, left and back",
        )


def read_lpd(path: Path) -> Ranges:
    """Read an LPD file; see `parse`."""
    return parse_lpd(read_text(path), str(path))


@dataclass(frozen=True, slots=True)
class Rule:
    """A row of symbols of which some are deleted."""

    line: int  # Where the rule begins in its file
    cells: tuple[tuple[int, int], ...]  # Codes of direction and level, in order of time
    deleted: tuple[bool, ...]  # Which of them go


def _row(words: list[str], place: str) -> tuple[tuple[int, int], bool]:
    wanted = '"L direction level" or "D direction level"'
    lower = [word.lower() for word in words]
    if len(lower) != 3 or lower[0] not in ("l", "d"):
        raise NotationError(f'"{shown(" ".join(words))}"', place=place, wanted=wanted)
    action, direction, level = lower
    if direction not in DIRECTION_CODES:
        raise NotationError(f'"{shown(direction)}"', place=place, wanted="a direction")
    if level not in LEVEL_CODES:
        raise NotationError(f'"{shown(level)}"', place=place, wanted="high, mid or low")
    return (DIRECTION_CODES[direction], LEVEL_CODES[level]), action == "d"


def _rule(line: int, rows: list[tuple[tuple[int, int], bool]], name: str) -> Rule:
    place = f"{name}:{line}"
    if len(rows) not in (2, 3):
        raise NotationError(f"a rule of {len(rows)} rows", place=place, wanted="two or three")
    deleted = tuple(gone for _, gone in rows)
    if not any(deleted):
        raise NotationError(
            "a rule that deletes nothing, it would never end", place=place, wanted="a row with D"
        )
    return Rule(line, tuple(cell for cell, _ in rows), deleted)


def parse_ldd(text: str, name: str = "LDD") -> tuple[Rule, ...]:
    """Read the text of an LDD file."""
    rules: list[Rule] = []
    rows: list[tuple[tuple[int, int], bool]] = []
    begun = 0
    for number, words in words_of(text):
        place = f"{name}:{number}"
        mark = words[0].lower().rstrip("#") if words[0].startswith("#") else ""
        if mark == "#rule_start" and not begun:
            begun, rows = number, []
        elif mark == "#rule_end" and begun:
            rules.append(_rule(begun, rows, name))
            begun = 0
        elif begun and not mark:
            rows.append(_row(words, place))
        else:
            wanted = "a row of the rule or #rule_end#" if begun else "#rule_start#"
            raise NotationError(f'"{shown(" ".join(words))}"', place=place, wanted=wanted)
    if begun:
        raise NotationError("a rule without an end", place=f"{name}:{begun}", wanted="#rule_end#")
    return tuple(rules)


def read_ldd(path: Path) -> tuple[Rule, ...]:
    """Read an LDD file; see `parse`."""
    return parse_ldd(read_text(path), str(path))
