"""Profiles as records: what their numbers are, changed ones, and those that lie beside a library.

A changed profile is the files of another with some lines of its ``profile.toml`` replaced, and
with an LPD or LDD file of its own for each part that differs: what was not touched stays as it is.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from lanindex.alphabet import DIRECTION_CODES, DIRECTIONS, LEVEL_CODES, LEVELS, PARTS, PLACE
from lanindex.encoding.profile import (
    PARAMETERS,
    PROFILE,
    Files,
    Profile,
    built_in,
    file_of,
    files_of,
    made_of,
)
from lanindex.errors import UsageError, quoted, shown
from lanindex.library.dialect import Target
from lanindex.notation.lpd_ldd import Ranges, Rule, write_ldd, write_lpd
from lanindex.notation.text import decoded
from lanindex.pipeline.files import safe_stem

MOST_RULES = 400
"""Rules of a part, at most."""

_LINE = r"(?m)^({key}\s*=\s*)(\"[^\"\n]*\"|[^\s#]+)"


@dataclass(frozen=True, slots=True)
class Changes:
    """What differs from a profile: lines of ``profile.toml``, borders and rules of parts."""

    parameters: Mapping[str, Any]
    spaces: Mapping[str, Ranges]
    rules: Mapping[str, tuple[Rule, ...]]

    @classmethod
    def read(cls, said: Any) -> Changes:
        """Return what a record says: ``parameters``, ``spaces`` and ``rules``, as of `record`."""
        groups = {"parameters": _same, "spaces": _ranges, "rules": _rules}
        tables = {name: _table(said, name) for name in groups}
        for name in ("spaces", "rules"):
            for part in tables[name]:
                if part not in PARTS:
                    raise UsageError(f'no part "{shown(part)}"', place=name, wanted="a part")
        return cls(**{
            name: {key: read(value, f"{name} of {key}") for key, value in tables[name].items()}
            for name, read in groups.items()
        })  # fmt: skip

    def __bool__(self) -> bool:
        return bool(self.parameters or self.spaces or self.rules)


def _same(value: Any, place: str) -> Any:
    return value


def _table(said: Any, name: str) -> dict[str, Any]:
    table = said.get(name, {}) if isinstance(said, dict) else None
    if not isinstance(table, dict):
        raise UsageError(quoted(said), place=name, wanted="an object")
    return table


def _number(value: Any, place: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 1e6:
        raise UsageError(quoted(value), place=place, wanted="a number from 0 to 1000000")
    return float(value)


def _ranges(said: Any, place: str) -> Ranges:
    starts = said.get("starts") if isinstance(said, dict) else None
    if not isinstance(starts, list) or len(starts) != PLACE:
        raise UsageError(quoted(said), place=place, wanted=f"{PLACE} starts, place, mid and high")
    place_within, mid, high = (_number(said.get(it), place) for it in ("place", "mid", "high"))
    begins = tuple(_number(it, place) for it in starts)
    return Ranges(place_within, said.get("relative") is True, begins, mid, high)


def _rules(said: Any, place: str) -> tuple[Rule, ...]:
    if not isinstance(said, list) or len(said) > MOST_RULES:
        raise UsageError(quoted(said), place=place, wanted=f"a list of {MOST_RULES} rules at most")
    return tuple(_rule(it, place) for it in said)


def _rule(said: Any, place: str) -> Rule:
    try:
        pairs = [(DIRECTION_CODES[a], LEVEL_CODES[b]) for a, b in map(str.split, said["cells"])]
        gone = {int(it) for it in said["deleted"]}
    except (KeyError, TypeError, ValueError) as error:
        wanted = 'cells such as "place low", and which of them are deleted'
        raise UsageError(quoted(said), place=place, wanted=wanted) from error
    return Rule(0, tuple(pairs), tuple(it in gone for it in range(len(pairs))))


def changed(files: Files, changes: Changes) -> dict[str, bytes]:
    """Return the files of a profile with changes; equal ones where nothing differs."""
    table = decoded(files[PROFILE], PROFILE, "a text file")
    for key, value in changes.parameters.items():
        if key not in (*PARAMETERS, "rhythm", "name"):
            raise UsageError(f'"{shown(key)}"', place=PROFILE, wanted="a parameter of profiles")
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise UsageError(f"{key} = {quoted(value)}", place=PROFILE, wanted="a number or a text")
        text = json.dumps(value).replace("\\", r"\\")  # of a template, which takes them in pairs
        table = re.sub(_LINE.format(key=key), rf"\g<1>{text}", table)
    texts = {PROFILE: table}
    texts |= {f"{part}.lpd": write_lpd(it) for part, it in changes.spaces.items()}
    texts |= {f"{part}.ldd": write_ldd(it) for part, it in changes.rules.items()}
    return {**files, **{name: text.encode() for name, text in texts.items()}}


@cache
def meanings() -> dict[str, str]:
    """Return what each parameter is: the comments of the default ``profile.toml``."""
    text = files_of("default")[PROFILE].decode()
    found = dict(re.findall(r"(?m)^(\w+) = [^#\n]*#\s*(.+)$", text))
    return {**found, "rhythm": "beats in a unit (a bar) / the note of a beat"}


def record(files: Files) -> dict[str, Any]:
    """Return a profile as JSON: its parameters with units, meanings and limits, and its parts."""
    profile, names = made_of(files), {part: file_of(files, part, ".ldd") for part in PARTS}
    values, says = _values(profile), meanings()
    return {
        "name": profile.name,
        "digest": profile.digest,
        "parameters": [
            {
                "name": key,
                "value": values[key],
                "units": list(it.units),
                "low": it.low,
                "high": it.high,
                "whole": it.whole,
                "says": says[key],
            }
            for key, it in PARAMETERS.items()
        ],
        "rhythm": f"{profile.meter.beats}/{profile.meter.beat}",
        "spaces": {part: _space(it) for part, it in profile.ranges.items()},
        "rules": {part: names[part] for part in PARTS},
        "files": {
            name: [_of_rule(it) for it in profile.rules[part].all] for part, name in names.items()
        },
    }


def _values(profile: Profile) -> dict[str, Any]:
    """Return parameters as ``profile.toml`` writes them."""
    values = dict[str, Any]()
    for key, it in PARAMETERS.items():
        own = getattr(profile.meter if key in ("speed", "division") else profile, key)
        if key == "smoothing":
            values[key] = f"{own * 1000:g} ms"
        elif it.units:
            values[key] = f"{own.value:g} {it.units[own.relative]}"
        else:
            values[key] = own if it.whole else float(own)
    return values


def _space(ranges: Ranges) -> dict[str, Any]:
    return {
        "place": ranges.place,
        "relative": ranges.relative,
        "starts": list(ranges.starts),
        "mid": ranges.mid,
        "high": ranges.high,
    }


def _of_rule(rule: Rule) -> dict[str, Any]:
    cells = [f"{DIRECTIONS[it]} {LEVELS[level]}" for it, level in rule.cells]
    return {"cells": cells, "deleted": [at for at, gone in enumerate(rule.deleted) if gone]}


class Shelf:
    """The profiles beside a library, a folder each; and those that are built in."""

    def __init__(self, library: Target) -> None:
        self.folder = library.beside("profiles")

    def names(self) -> list[str]:
        """Return the names of all profiles, those that are built in first."""
        own = [path.parent.name for path in sorted(self.folder.glob(f"*/{PROFILE}"))]
        return built_in() + [it for it in own if it not in built_in() and not it.startswith(".")]

    def place(self, name: str) -> str:
        """Return what ``--profile`` takes: a name, or the folder of one beside the library."""
        if name not in self.names():
            known = ", ".join(self.names())
            raise UsageError(f'no profile "{shown(name)}"', wanted=f"one of {known}")
        return name if name in built_in() else str(self.folder / name)

    def files(self, name: str) -> dict[str, bytes]:
        """Return the files of a profile."""
        return files_of(self.place(name))

    def save(self, name: str, files: Files, *, replace_it: bool = False) -> str:
        """Write a profile, whole or not at all, and return the name that it got."""
        name = name.strip()
        safe = safe_stem(f"{name}.") if name.strip(". ") else ""
        if not safe or safe in built_in():
            wanted = f"a name other than {' and '.join(built_in())}"
            raise UsageError(f'the name "{shown(name)}"', place="profile", wanted=wanted)
        target = self.folder / safe
        if os.path.lexists(target) and not replace_it:
            remedy = "Give it another name, or replace it."
            raise UsageError(f'there is a profile "{safe}"', place="profile", remedy=remedy)
        named = Changes({"name": safe}, {}, {})
        files = changed(files, named)
        made_of(files, safe)  # raises what is wrong with it
        self.folder.mkdir(parents=True, exist_ok=True)
        draft = self.folder / f".{secrets.token_hex(8)}"
        draft.mkdir()
        try:
            for file, content in files.items():
                (draft / file).write_bytes(content)
            _put(draft, target)
        finally:
            shutil.rmtree(draft, ignore_errors=True)
        return safe


def _put(draft: Path, target: Path) -> None:
    """Give a folder its name; what is there goes."""
    if not target.is_symlink() and target.is_dir():
        before = draft.with_name(f"{draft.name}-before")
        target.rename(before)
        draft.rename(target)
        shutil.rmtree(before, ignore_errors=True)
    else:
        draft.rename(target)
