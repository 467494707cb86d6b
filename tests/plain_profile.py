"""A profile's folder, read line by line: the slow twin's own reading."""

import tomllib
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from lanindex.alphabet import DIRECTIONS, LEVELS, PARTS


@dataclass
class Cells:
    """What an LPD says: how wide place is, and where sectors and levels begin."""

    place: str
    sectors: dict[str, float]
    levels: list[tuple[float, str]]


@dataclass
class Rule:
    line: int
    rows: list[tuple[str, str, str]]


@dataclass
class Profile:
    """The numbers of profile.toml; amounts stay text until a limb's length is known."""

    rate: Fraction
    smoothing: float
    candidate_speed: str
    prominence: str
    still: str
    distance: str
    path_check: float
    achieved_within: float
    onset: float
    cells: dict[str, Cells]
    rules: dict[str, list[Rule]]


def amount(text: str, length: float) -> float:
    """Return millimetres (a second): "0.09 L" of a limb of that length, "50 mm", "250"."""
    number, _, unit = text.partition(" ")
    return float(number) * (length if unit.startswith("L") else 1.0)


def seconds(text: str) -> float:
    number, unit = text.split()
    return float(number) * {"ms": 0.001, "s": 1.0}[unit]


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    lines = path.read_text(encoding="utf-8").splitlines()
    found = []
    for number, line in enumerate(lines, 1):
        words = line.split()
        if words and not words[0].startswith("//"):
            found.append((number, words))
    return found


def read_cells(path: Path) -> Cells:
    cells = Cells("", {}, [])
    for _, (name, *values) in _rows(path):
        if name == "place":
            cells.place = " ".join(values)
        elif name in DIRECTIONS:
            cells.sectors[name] = float(values[0])
        elif name in LEVELS:
            cells.levels.extend((float(value), name) for value in values)
    cells.levels.sort()
    return cells


def read_rules(path: Path) -> list[Rule]:
    rules: list[Rule] = []
    for number, words in _rows(path):
        if words[0].startswith("#rule_start"):
            rules.append(Rule(number, []))
        elif words[0] in ("L", "D"):
            rules[-1].rows.append((words[0], words[1], words[2]))
    return rules


def _file(folder: Path, part: str, suffix: str) -> Path:
    for name in (part, PARTS[part].group, "all"):
        path = folder / f"{name}.{suffix}"
        if path.exists():
            return path
    raise FileNotFoundError(folder / f"all.{suffix}")


def read_profile(folder: Path) -> Profile:
    values = tomllib.loads((folder / "profile.toml").read_text(encoding="utf-8"))
    return Profile(
        Fraction(values["rate"]),
        seconds(values["smoothing"]),
        values["candidate_speed"],
        values["prominence"],
        values["still"],
        values["distance"],
        float(values["path_check"]),
        float(values["achieved_within"]),
        float(values["onset"]),
        {part: read_cells(_file(folder, part, "lpd")) for part in PARTS},
        {part: read_rules(_file(folder, part, "ldd")) for part in PARTS},
    )
