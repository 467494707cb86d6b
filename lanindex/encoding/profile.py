"""A profile: the numbers that the method runs on, as a folder of text files.

``profile.toml`` holds the parameters; an LPD and an LDD file a part, a group of parts or ``all``
hold the directions and the rules. Users copy a folder and edit it.

Source: ``encoding/METHOD.md``, "Profiles".
"""

import hashlib
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import GROUPS, PARTS
from lanindex.encoding.direction import CELLS
from lanindex.errors import NotationError, quoted, shown
from lanindex.model import Meter
from lanindex.notation.lpd_ldd import Ranges, Rule, parse_ldd, parse_lpd
from lanindex.notation.text import read_text, read_toml

BUILT_IN = Path(__file__).parent / "profiles"


@dataclass(frozen=True, slots=True)
class Measure:
    """A length or a speed: millimetres (a second), or parts of the limb's length."""

    value: float  # The number
    relative: bool  # Whether it counts in the limb's length

    def of(self, length: float) -> float:
        """Return millimetres (a second) for a limb of `length` mm."""
        return self.value * length if self.relative else self.value


class Rules:
    """The rules of a part, ready to be looked up."""

    def __init__(self, rules: Sequence[Rule]) -> None:
        self._rules = rules

    @cached_property
    def table(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Borders (27 · 27 + 1,) of the rules that begin with two cells; all rules (R, 4).

        A rule is its number of cells, its third cell or 0, the deleted cells as bits, and its line.
        """
        rows: list[list[tuple[int, ...]]] = [[] for _ in range(CELLS * CELLS)]
        for rule in self._rules:
            one, two, *third = (direction * 3 + level for direction, level in rule.cells)
            gone = sum(deleted << place for place, deleted in enumerate(rule.deleted))
            rows[one * CELLS + two].append((2 + len(third), sum(third), gone, rule.line))
        borders = np.cumsum([0, *map(len, rows)], dtype=np.int64)
        return borders, np.array(list(chain(*rows)), np.int64).reshape(-1, 4)


@dataclass(frozen=True, slots=True)
class Profile:
    """Everything that the encoding may vary by."""

    name: str  # As the folder says
    # sha256 of the method's number and the folder's files: equal digests encode equally
    digest: str
    rate: Fraction  # Frames a second that captures are resampled to
    smoothing: float  # Seconds of the moving average
    # Speeds: v0, how far a rim must stand above a minimum, what counts as no speed
    candidate_speed: Measure
    prominence: Measure
    still: Measure
    distance: Measure  # d_t
    path_check: float  # In d_t; 0: not checked
    achieved_within: float  # Degrees
    onset: float  # Part of the peak speed; 0: off
    meter: Meter  # Tempo, rhythm and grid
    ranges: Mapping[str, Ranges]  # By part
    rules: Mapping[str, Rules]  # By part


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError("text in quotes")
    return value


def _number(value: Any, low: float, high: float, kind: type[float] = float) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | kind) or not low <= value <= high:
        whole = "whole " if kind is int else ""
        raise ValueError(f"a {whole}number from {low:g} to {high:g}")
    return value


def _positive(value: Any) -> Fraction:
    return Fraction(str(_number(value, 0.1, 1000)))


def _quantity(value: Any, units: str, wanted: str) -> tuple[float, str]:
    """Return a number and its unit."""
    pattern = rf"(\d+(?:\.\d+)?)\s*({units})"
    match = re.fullmatch(pattern, value) if isinstance(value, str) else None
    if match is None:
        raise ValueError(wanted)
    if float(match[1]) > 1e6:
        raise ValueError("a number of at most 1000000")
    return float(match[1]), match[2]


def _seconds(value: Any) -> float:
    number, unit = _quantity(value, "ms|s", '"83 ms" or "0.083 s"')
    return number / (1000 if unit == "ms" else 1)


def _measure(value: Any, units: str, wanted: str) -> Measure:
    number, unit = _quantity(value, units, wanted)
    return Measure(number, unit.startswith("L"))


_speed = partial(_measure, units="mm/s|L/s", wanted='"600 mm/s" or "1.09 L/s"')
_length = partial(_measure, units="mm|L", wanted='"50 mm" or "0.09 L"')


def _rhythm(value: Any) -> tuple[int, int]:
    match = re.fullmatch(r"([1-9]\d?)/([1-9]\d?)", value) if isinstance(value, str) else None
    if match is None:
        raise ValueError('"4/4"')
    return int(match[1]), int(match[2])


_FIELDS: dict[str, Callable[[Any], Any]] = {
    "name": _text,
    "rate": _positive,
    "smoothing": _seconds,
    "candidate_speed": _speed,
    "prominence": _speed,
    "still": _speed,
    "distance": _length,
    "path_check": lambda value: float(_number(value, 0, 100)),
    "achieved_within": lambda value: float(_number(value, 0, 180)),
    "onset": lambda value: float(_number(value, 0, 0.25)),
    "speed": _positive,
    "rhythm": _rhythm,
    "division": lambda value: _number(value, 1, 4096, int),
}


def _parameters(path: Path) -> dict[str, Any]:
    table = read_toml(path)
    for key in [*table, *_FIELDS]:
        if key not in _FIELDS:
            wanted = "one of " + ", ".join(_FIELDS)
            raise NotationError(f'"{shown(key)}"', place=str(path), wanted=wanted)
        if key not in table:
            raise NotationError(f"no {key}", place=str(path), wanted="a line for it")
    values = {}
    for key, value in table.items():
        try:
            values[key] = _FIELDS[key](value)
        except ValueError as error:
            found = f"{key} = {quoted(value)}"
            raise NotationError(found, place=str(path), wanted=str(error)) from error
    return values


def _of_part(folder: Path, part: str, suffix: str) -> Path:
    for stem in (part, PARTS[part].group, "all"):
        path = folder / (stem + suffix)
        if path.is_file():
            return path
    raise NotationError(
        f"no {suffix[1:].upper()} file for {part}",
        place=str(folder),
        wanted=f"{part}{suffix}, {PARTS[part].group}{suffix} or all{suffix}",
    )


def _check_names(folder: Path) -> None:
    """Refuse a file that no part would ever read: a slip in its name."""
    for path in sorted(folder.iterdir()):
        if path.suffix in (".lpd", ".ldd") and path.stem not in {*PARTS, *GROUPS, "all"}:
            raise NotationError(
                f'no part is called "{shown(path.stem)}"',
                place=str(path),
                wanted=f"a part ({', '.join(PARTS)}), a group ({', '.join(GROUPS)}) or all",
            )


def _folder(name: str | Path) -> Path:
    for folder in (BUILT_IN / name, Path(name)):
        if os.path.isfile(folder / "profile.toml"):
            return folder
    known = ", ".join(sorted(path.name for path in BUILT_IN.iterdir() if path.is_dir()))
    raise NotationError(
        f'no profile "{shown(str(name))}"', wanted=f"{known}, or a folder with a profile.toml"
    )


def load(name: str | Path = "default") -> Profile:
    """Read a profile.

    Parameters
    ----------
    name : str or Path
        ``default``, ``paper``, or a folder.

    Returns
    -------
    Profile

    Raises
    ------
    NotationError
        With the file, and the line where there is one.

    Examples
    --------
    >>> import lanindex
    >>> profile = lanindex.load_profile("paper")
    >>> float(profile.rate), profile.distance, profile.ranges["r_arm"].place
    (60.0, Measure(value=50.0, relative=False), 250.0)
    """
    folder = _folder(name)
    _check_names(folder)
    values = _parameters(folder / "profile.toml")
    beats, beat = values.pop("rhythm")
    meter = Meter(values.pop("speed"), beats, beat, values.pop("division"))
    paths = {
        part: (_of_part(folder, part, ".lpd"), _of_part(folder, part, ".ldd")) for part in PARTS
    }
    used = {path for pair in paths.values() for path in pair} | {folder / "profile.toml"}
    ranges = {it: parse_lpd(read_text(it), str(it)) for it in used if it.suffix == ".lpd"}
    rules = {it: Rules(parse_ldd(read_text(it), str(it))) for it in used if it.suffix == ".ldd"}
    return Profile(
        **values,
        digest=_digest(used),
        meter=meter,
        ranges={part: ranges[pair[0]] for part, pair in paths.items()},
        rules={part: rules[pair[1]] for part, pair in paths.items()},
    )


METHOD = b"10"
"""Which method encodes: another one makes other symbols with the same numbers."""


def _digest(paths: set[Path]) -> str:
    digest = hashlib.sha256(METHOD)
    for path in sorted(paths, key=lambda path: path.name):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()
