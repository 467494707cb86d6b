"""LDD, Labanotation Delete Data: which symbols between others are only passed on the way.

Source: ``encoding/METHOD.md``, "LDD"; Matsumoto and Hachimura (2001), 4.6 and figure 14.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lanindex.alphabet import DIRECTION_CODES, LEVEL_CODES
from lanindex.errors import NotationError, shown
from lanindex.notation.text import read_text, words_of


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


def parse(text: str, name: str = "LDD") -> tuple[Rule, ...]:
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


def read(path: Path) -> tuple[Rule, ...]:
    """Read an LDD file; see `parse`."""
    return parse(read_text(path), str(path))
