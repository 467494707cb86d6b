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
from lanindex.notation import content_of
from lanindex.notation.lpd_ldd import Ranges, Rule, parse_ldd, parse_lpd
from lanindex.notation.text import decoded, parse_toml

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
        self.all = rules

    @cached_property
    def table(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Borders (27 · 27 + 1,) of the rules that begin with two cells; all rules (R, 4).

        A rule is its number of cells, its third cell or 0, the deleted cells as bits, and its line.
        """
        rows: list[list[tuple[int, ...]]] = [[] for _ in range(CELLS * CELLS)]
        for rule in self.all:
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


@dataclass(frozen=True, slots=True)
class Parameter:
    """What a line of ``profile.toml`` may say: a number, or a number and a unit in quotes."""

    units: tuple[str, ...] = ()  # One of which it must have; none: a bare number
    examples: str = ""  # Of a number with a unit
    low: float = 0
    high: float = 1e6
    whole: bool = False

    @property
    def wanted(self) -> str:
        """What is wanted, in words."""
        whole = "whole " if self.whole else ""
        return self.examples or f"a {whole}number from {self.low:g} to {self.high:g}"

    def read(self, value: Any) -> tuple[Any, str]:
        """Return a number and its unit; a `ValueError` says what is wanted instead."""
        if not self.units:
            kinds = int if self.whole else int | float
            if isinstance(value, bool) or not isinstance(value, kinds):
                raise ValueError(self.wanted)
            if not self.low <= value <= self.high:
                raise ValueError(self.wanted)
            return value, ""
        pattern = rf"(\d+(?:\.\d+)?)\s*({'|'.join(self.units)})"
        match = re.fullmatch(pattern, value) if isinstance(value, str) else None
        if match is None:
            raise ValueError(self.wanted)
        if float(match[1]) > self.high:
            raise ValueError(f"a number of at most {self.high:.0f}")
        return float(match[1]), match[2]


_SPEED = Parameter(("mm/s", "L/s"), '"600 mm/s" or "1.09 L/s"')
PARAMETERS = {
    "rate": Parameter(low=0.1, high=1000),
    "smoothing": Parameter(("ms", "s"), '"83 ms" or "0.083 s"'),
    "candidate_speed": _SPEED,
    "prominence": _SPEED,
    "still": _SPEED,
    "distance": Parameter(("mm", "L"), '"50 mm" or "0.09 L"'),
    "path_check": Parameter(high=100),
    "achieved_within": Parameter(high=180),
    "onset": Parameter(high=0.25),
    "speed": Parameter(low=0.1, high=1000),
    "division": Parameter(low=1, high=4096, whole=True),
}
"""The numbers of ``profile.toml``; what each is says its comment in that of ``default``."""


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError("text in quotes")
    return value


def _rhythm(value: Any) -> tuple[int, int]:
    match = re.fullmatch(r"([1-9]\d?)/([1-9]\d?)", value) if isinstance(value, str) else None
    if match is None:
        raise ValueError('"4/4"')
    return int(match[1]), int(match[2])


def _number(key: str, value: Any) -> Any:
    """Return what a parameter is in a `Profile`."""
    number, unit = PARAMETERS[key].read(value)
    if key in ("rate", "speed"):
        return Fraction(str(number))
    if key == "smoothing":
        return number / (1000 if unit == "ms" else 1)
    if unit:
        return Measure(number, unit.startswith("L"))
    return number if PARAMETERS[key].whole else float(number)


_FIELDS: dict[str, Callable[[Any], Any]] = {
    "name": _text,
    **{key: partial(_number, key) for key in PARAMETERS},
    "rhythm": _rhythm,
}


def _parameters(text: str, place: str) -> dict[str, Any]:
    table = parse_toml(text, place)
    for key in [*table, *_FIELDS]:
        if key not in _FIELDS:
            wanted = "one of " + ", ".join(_FIELDS)
            raise NotationError(f'"{shown(key)}"', place=place, wanted=wanted)
        if key not in table:
            raise NotationError(f"no {key}", place=place, wanted="a line for it")
    values = {}
    for key, value in table.items():
        try:
            values[key] = _FIELDS[key](value)
        except ValueError as error:
            found = f"{key} = {quoted(value)}"
            raise NotationError(found, place=place, wanted=str(error)) from error
    return values


Files = Mapping[str, bytes]
"""The files of a profile, by name."""


def file_of(files: Files, part: str, suffix: str, place: str = "") -> str:
    """Return the name of the file that a part takes its directions or its rules from."""
    for stem in (part, PARTS[part].group, "all"):
        if stem + suffix in files:
            return stem + suffix
    raise NotationError(
        f"no {suffix[1:].upper()} file for {part}",
        place=place,
        wanted=f"{part}{suffix}, {PARTS[part].group}{suffix} or all{suffix}",
    )


def _check_names(files: Files, place: str) -> None:
    """Refuse a file that no part would ever read: a slip in its name."""
    for name in sorted(files):
        stem, _, suffix = name.rpartition(".")
        if suffix in ("lpd", "ldd") and stem not in {*PARTS, *GROUPS, "all"}:
            raise NotationError(
                f'no part is called "{shown(stem)}"',
                place=os.path.join(place, name),
                wanted=f"a part ({', '.join(PARTS)}), a group ({', '.join(GROUPS)}) or all",
            )


def _folder(name: str | Path) -> Path:
    for folder in (BUILT_IN / name, Path(name)):
        if os.path.isfile(folder / PROFILE):
            return folder
    known = ", ".join(built_in())
    raise NotationError(
        f'no profile "{shown(str(name))}"', wanted=f"{known}, or a folder with a profile.toml"
    )


PROFILE = "profile.toml"


def built_in() -> list[str]:
    """Return the names of the profiles that come with the program."""
    return sorted(path.name for path in BUILT_IN.iterdir() if path.is_dir())


def files_of(name: str | Path) -> dict[str, bytes]:
    """Return the files of a profile, by name: ``default``, ``paper``, or a folder."""
    folder = _folder(name)
    return {
        path.name: content_of(str(path))
        for path in sorted(folder.iterdir())
        if path.name == PROFILE or (path.suffix in (".lpd", ".ldd"))
    }


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
    return made_of(files_of(name), str(_folder(name)))


def made_of(files: Files, place: str = "") -> Profile:
    """Return the profile that some files are; `place` is where errors say that they are."""
    _check_names(files, place)

    def text(name: str) -> tuple[str, str]:
        path = os.path.join(place, name)
        return decoded(files[name], path, "a text file"), path

    values = _parameters(*text(PROFILE))
    beats, beat = values.pop("rhythm")
    meter = Meter(values.pop("speed"), beats, beat, values.pop("division"))
    names = {
        part: [file_of(files, part, suffix, place) for suffix in (".lpd", ".ldd")] for part in PARTS
    }
    used = {PROFILE, *chain.from_iterable(names.values())}
    ranges = {it: parse_lpd(*text(it)) for it in used if it.endswith(".lpd")}
    rules = {it: Rules(parse_ldd(*text(it))) for it in used if it.endswith(".ldd")}
    return Profile(
        **values,
        digest=_digest({name: files[name] for name in used}),
        meter=meter,
        ranges={part: ranges[pair[0]] for part, pair in names.items()},
        rules={part: rules[pair[1]] for part, pair in names.items()},
    )


METHOD = b"10"
"""Which method encodes: another one makes other symbols with the same numbers."""


def _digest(files: Files) -> str:
    digest = hashlib.sha256(METHOD)
    for name in sorted(files):
        digest.update(name.encode() + b"\0" + files[name] + b"\0")
    return digest.hexdigest()
