"""Borders and rules of an encoding: LPD, Labanotation Parameter Data, and LDD, Delete Data.

LPD tells which angles each direction and level spans, LDD which symbols between others are only
passed on the way. Source: ``encoding/METHOD.md``, "LPD" and "LDD"; Matsumoto and Hachimura (2001),
4.5.2, 4.6, figures 13 and 14.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from lanindex.alphabet import DIRECTION_CODES, DIRECTIONS, LEVEL_CODES, LEVELS, PLACE
from lanindex.errors import shown
from lanindex.notation.text import refuse, words_of


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
        refuse(place, f'"{shown(word)}"', "a number of 0 or more")
    return value


def parse_lpd(text: str, name: str = "LPD") -> Ranges:
    """Read the text of an LPD file."""
    numbers: dict[str, list[float]] = {}
    relative = False
    for line, (word, *values) in words_of(text):
        place, word = f"{name}:{line}", word.lower()
        if word not in DIRECTION_CODES and word not in LEVEL_CODES:
            refuse(place, f'"{shown(word)}"', "a direction or a level")
        if word in numbers:
            refuse(place, f'"{word}" stands twice', "one line of it")
        if word == "place" and len(values) == 2 and values[1] == "L":
            relative = True
            values = values[:1]
        count = 2 if word == "mid" else 1
        if len(values) != count:
            refuse(place, f"{len(values)} values after {word}", str(count))
        numbers[word] = [_number(value, place) for value in values]
    missing = [word for word in (*DIRECTIONS, *LEVEL_CODES) if word not in numbers]
    if missing:
        refuse(name, "no line for " + ", ".join(missing), "all of them")
    (low,), (mid, mid_end), (high,) = (numbers[level] for level in LEVELS)
    if not 0 < mid < high < 180 or mid_end != 360 - high or low != 360 - mid:
        found = f"low {low:g}, mid {mid:g} {mid_end:g}, high {high:g}"
        refuse(name, found, "mid m 360-h, high h, low 360-m with 0 < m < h < 180")
    starts = tuple(numbers[word][0] % 360 for word in DIRECTIONS[:PLACE])
    turns = [(b - a) % 360 for a, b in zip(starts, (*starts[1:], starts[0]), strict=True)]
    if min(turns) <= 0 or abs(sum(turns) - 360) > 1e-9:
        found = "the directions do not follow each other round the circle"
        refuse(name, found, "rising starts from right over forward, left and back")
    return Ranges(numbers["place"][0], relative, starts, mid, high)


def write_lpd(ranges: Ranges) -> str:
    """Return the text of an LPD file."""
    lines = [f"place\t{_written(ranges.place)}{' L' * ranges.relative}"]
    lines += [
        f"{name}\t{_written(start)}"
        for name, start in zip(DIRECTIONS[:PLACE], ranges.starts, strict=True)
    ]
    mid, high = ranges.mid, ranges.high
    lines += [f"high\t{_written(high)}", f"mid\t{_written(mid)}\t{_written(360 - high)}"]
    return "\n".join([*lines, f"low\t{_written(360 - mid)}", ""])


def _written(number: float) -> str:
    return f"{number:.9f}".rstrip("0").rstrip(".")


@dataclass(frozen=True, slots=True)
class Rule:
    """A row of symbols of which some are deleted."""

    line: int  # Where the rule begins in its file
    cells: tuple[tuple[int, int], ...]  # Codes of direction and level, in order of time
    deleted: tuple[bool, ...]  # Which of them go


def parse_ldd(text: str, name: str = "LDD") -> tuple[Rule, ...]:
    """Read the text of an LDD file."""
    rules: list[Rule] = []
    cells: list[tuple[int, int]] = []
    deleted: list[bool] = []
    begin = 0
    for number, words in words_of(text):
        place, line = f"{name}:{number}", shown(" ".join(words))
        mark = words[0].lower().rstrip("#") if words[0].startswith("#") else ""
        if mark == "#rule_start" and not begin:
            begin, cells, deleted = number, [], []
        elif mark == "#rule_end" and begin:
            place = f"{name}:{begin}"
            if len(cells) not in (2, 3):
                refuse(place, f"a rule of {len(cells)} rows", "two or three")
            if not any(deleted):
                refuse(place, "a rule that deletes nothing, it would never end", "a row with D")
            rules.append(Rule(begin, tuple(cells), tuple(deleted)))
            begin = 0
        elif begin and not mark:
            action, *cell = (word.lower() for word in words)
            if len(cell) != 2 or action not in ("l", "d"):
                refuse(place, f'"{line}"', '"L direction level" or "D direction level"')
            direction, level = cell
            if direction not in DIRECTION_CODES:
                refuse(place, f'"{shown(direction)}"', "a direction")
            if level not in LEVEL_CODES:
                refuse(place, f'"{shown(level)}"', "high, mid or low")
            cells.append((DIRECTION_CODES[direction], LEVEL_CODES[level]))
            deleted.append(action == "d")
        else:
            wanted = "a row of the rule or #rule_end#" if begin else "#rule_start#"
            refuse(place, f'"{line}"', wanted)
    if begin:
        refuse(f"{name}:{begin}", "a rule without an end", "#rule_end#")
    return tuple(rules)


def write_ldd(rules: Iterable[Rule]) -> str:
    """Return the text of an LDD file."""
    lines = list[str]()
    for rule in rules:
        rows = zip(rule.cells, rule.deleted, strict=True)
        lines += ["#rule_start#"]
        lines += [f"{'LD'[gone]} {DIRECTIONS[it[0]]} {LEVELS[it[1]]}" for it, gone in rows]
        lines += ["#rule_end#"]
    return "\n".join([*lines, ""])
