"""Which captures a person means: by glob, by path, by the end of a path, by a missing file."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from fnmatch import translate
from numbers import Integral
from typing import Any, TypeGuard
from unicodedata import normalize

from lanindex.errors import AbsentError, LibraryError, UsageError
from lanindex.model import Capture

Where = Mapping[str, str] | Iterable[tuple[str, str]]
"""Globs by what of a capture they are compared with."""

_NEEDED = {"path": ("path", "location"), "label": ("label",), "format": ("format",)}
"""By column the lists of what captures are called in which it stands; else ``metadata``."""

Texts = Mapping[str, Sequence[Any]]
"""What captures are called: by name of the column, a value for each."""

_COLUMNS = ("label", "format", "dataset")
"""What every capture can be asked for by name, beside its path."""

_MOST_NUMBER = (1 << 63) - 1
"""What SQLite counts to."""


def is_number(which: object) -> TypeGuard[int]:
    """Return whether this can be the number of a capture: whole, from 1, and no truth value."""
    whole = isinstance(which, Integral) and not isinstance(which, bool)
    return whole and 0 < int(which) <= _MOST_NUMBER  # type: ignore[call-overload]


def globs(within: str | None, where: Where | None) -> list[tuple[str, str]]:
    """Return what is asked of captures as globs by column."""
    pairs = list(where.items() if isinstance(where, Mapping) else where or ())
    return pairs if within is None else [*pairs, ("path", within)]


def _fitting(glob: str) -> Callable[[str], bool]:
    """Return what tells whether a text fits a glob."""
    # The same letters may be composed or not: macOS names files in one way, people type in both.
    fits = re.compile(translate(normalize("NFC", glob))).match
    return lambda text: fits(text if text.isascii() else normalize("NFC", text)) is not None


def fitting(
    called: Texts, places: Sequence[int], where: Iterable[tuple[str, str]]
) -> Sequence[int]:
    """Return those of some captures that fit all of some globs."""
    for key, glob in where:
        if key == "path":
            places = _paths(called, places, glob)
            continue
        fits, texts = _fitting(glob), _texts(called, key)
        known = {text: fits(text) for text in {texts[place] for place in places}}
        places = [place for place in places if known[texts[place]]]
    return places


def needed(where: Iterable[tuple[str, str]]) -> list[str]:
    """Return which lists of what captures are called `fitting` looks at."""
    names = [_NEEDED.get(key, ("metadata",)) for key, _ in where]
    return list(dict.fromkeys(name for some in names for name in some))


def _paths(called: Texts, places: Sequence[int], glob: str) -> list[int]:
    """Return those captures of which a path fits: as ingested, absolute, or the file's name."""
    fits, paths, locations = _fitting(glob), called["path"], called["location"]
    if glob.startswith("*"):  # what fits the end of a path fits all of it
        rest = [place for place in places if not locations[place].endswith(paths[place])]
        known = {place for place in rest if fits(paths[place])}
        return [place for place in places if fits(locations[place]) or place in known]
    named = "/" not in glob
    return [
        place
        for place in places
        if fits(paths[place])
        or fits(locations[place])
        or (named and fits(os.path.basename(locations[place])))
    ]


def _texts(called: Texts, key: str) -> Sequence[str]:
    if key in ("label", "format"):
        return called[key]
    metadata: Sequence[Mapping[str, str]] = called["metadata"]
    columns = {column for one in metadata for column in one}
    if metadata and key not in columns and key not in _COLUMNS:
        raise UsageError(
            f'no capture has a column "{key}"',
            wanted=f"one of {', '.join(dict.fromkeys(('path', *_COLUMNS, *sorted(columns))))}",
        )
    return [one.get(key, "") for one in metadata]


def missing(captures: Iterable[Capture]) -> list[Capture]:
    """Return the captures whose file is no longer there."""
    return [capture for capture in captures if gone(capture.location)]


def gone(path: str) -> bool:
    """Return whether a file is surely no longer there."""
    from lanindex.formats.file import on_disk

    try:
        os.stat(on_disk(path))
    except (FileNotFoundError, NotADirectoryError):
        return True
    except OSError:  # it may be there, behind a door that is closed to us
        return False
    return False


def several(named: str, locations: Sequence[str], place: str) -> LibraryError:
    """Return the error that says that a name means several captures."""
    return LibraryError(
        f"{len(locations)} captures are called {named}",
        place=place,
        remedy=f"Name one: {_listed(locations)}",
    )


def absent(named: str, called: Texts, place: str) -> AbsentError:
    """Return the error that says that a name means no capture, and which ones have one like it."""
    return AbsentError(f"there is no capture {named}", place=place, remedy=_guess(called, named))


def _listed(names: Sequence[str], most: int = 3) -> str:
    return ", ".join(names[:most]) + (" …" if len(names) > most else "")


def _guess(called: Texts, named: str) -> str:
    from rapidfuzz import process

    pairs = zip(called["location"], called["path"], strict=True)
    names = {os.path.basename(location): path for location, path in pairs}
    near = process.extract(os.path.basename(named), list(names), limit=3, score_cutoff=60)
    if near:
        return f"Did you mean {_listed([names[name] for name, _, _ in near])}?"
    return "All are shown by: lanindex list"
