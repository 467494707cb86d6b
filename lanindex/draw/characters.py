"""The characters of a staff in plain text, and the names above its columns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import zip_longest

from lanindex.alphabet import BENT, Kind
from lanindex.draw.staff import name_of
from lanindex.model.bends import STRETCHES, degree_of

_SHORTER = {
    **{"support": "supp", "forearm": "fore arm", "upper": "uppr", "thigh": "thgh"},
    **{"shank": "shnk", "torso": "tors", "incline": "incl", "twist": "twst", "touch": "tch"},
    **{"hands": "hnds", "travel": "way", "stance": "stnd", "other": "othr"},
}
"""Words of parts that are wider than a column."""


@dataclass(frozen=True, slots=True)
class Signs:
    """The characters of a staff."""

    directions: tuple[str, ...]  # By a direction's code; what turns has others
    turns: tuple[str, ...]
    levels: tuple[str, ...]  # By a level's code, and last where there is none
    bars: tuple[str, ...]
    bends: tuple[str, str]  # To bend, to stretch
    cell: int  # How many there are in a column, behind one for the mark
    # Before what is marked; the staff's lines, upright, across, and where it begins and ends; rows
    # that say nothing new; a foot that stands
    mark: str
    line: str
    rule: str
    double: str
    fold: str
    hold: str

    @property
    def legend(self) -> str:
        """What the signs mean, in a line."""
        (right, _, forward, *_, place), (low, mid, high, _) = self.directions, self.levels
        return (
            f"time runs down; {forward} forward, {right} right, {place} place, {high} high,"
            f" {mid} mid, {low} low; a number: how far bent, or degrees; {self.mark} matched,"
            f" {self.hold} stands, ? not known"
        )

    def of(self, kind: Kind, direction: int, level: int, amount: int) -> str:
        """Return the sign of a symbol, from its codes; what is less than 0 stands for nothing."""
        where = self.turns if kind.name in ("turn", "twist") else self.directions
        said = where[direction] if direction >= 0 else ""
        said += self.levels[level] if level >= 0 else ""
        return (said + self._amount(kind, amount) if amount >= 0 else said)[: self.cell]

    def _amount(self, kind: Kind, amount: int) -> str:
        """Return an amount in as many characters as there is room for."""
        if kind.name == "bend":
            return f"{self.bends[amount >= STRETCHES]}{degree_of(amount)}"
        if kind.name == "gesture":
            return str(amount) if amount >= BENT else ""
        if kind.amounts:
            return kind.amount(amount)
        return str(amount or "") if amount < 1000 else f"{amount // 360}x"


UNICODE = Signs(
    ("→", "↗", "↑", "↖", "←", "↙", "↓", "↘", "□"),
    ("↻", "", "", "", "↺", "", "", "", "□"),
    ("▼", "·", "▲", ""),
    ("██", "▒▒", "░░", "▐▌"),
    ("\u00d7", "И"),
    4,
    *("»", "│", "─", "═", "⋮", "○"),
)
ASCII = Signs(
    ("r", "rf", "f", "lf", "l", "lb", "b", "rb", "o"),
    ("r", "", "", "", "l", "", "", "", "o"),
    ("L", "m", "H", ""),
    ("##", "++", "::", "||"),
    ("x", "N"),
    5,
    *(">", "|", "-", "=", ":", "()"),
)
"""What can be shown anywhere."""


def names_of(parts: Iterable[str]) -> Iterator[list[str]]:
    """Yield what stands above the columns of some tracks, word by word."""
    words = []
    for part in parts:
        side = part[0].upper() if part[:2] in ("r_", "l_") else ""
        own = " ".join(_SHORTER.get(word, word) for word in name_of(part).split())
        words.append([side, *own.split()])
    yield from (list(row) for row in zip_longest(*words, fillvalue=""))
