"""Which captures a person means: by glob, by path, by the end of a path, by a missing file."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from fnmatch import fnmatchcase
from numbers import Integral
from operator import attrgetter
from typing import TypeGuard
from unicodedata import normalize

from lanindex.errors import LibraryError, UsageError
from lanindex.model import Capture

Where = Mapping[str, str] | Iterable[tuple[str, str]]
"""Globs by what of a capture they are compared with."""

_COLUMNS: dict[str, Callable[[Capture], str]] = {
    "label": attrgetter("label"),
    "format": attrgetter("format"),
    "dataset": lambda capture: capture.metadata.get("dataset", ""),
}
"""What every capture can be asked for by name, beside its path."""

_MOST_NUMBER = (1 << 63) - 1
"""What SQLite counts to."""


def is_number(which: object) -> TypeGuard[int]:
    """Return whether this can be the number of a capture: whole, from 1, and no truth value."""
    whole = isinstance(which, Integral) and not isinstance(which, bool)
    return whole and 0 < int(which) <= _MOST_NUMBER  # type: ignore[call-overload]


def _fits(text: str, glob: str) -> bool:
    # The same letters may be composed or not: macOS names files in one way, people type in both.
    return fnmatchcase(normalize("NFC", text), normalize("NFC", glob))


def matching(captures: Iterable[Capture], glob: str) -> list[Capture]:
    """Return the captures whose path fits a glob.

    Parameters
    ----------
    captures : iterable of Capture
        To choose from.
    glob : str
        Compared with the path as ingested, the absolute path and, if it has no slash, the name
        of the file; ``*`` crosses folders.
    """
    return [
        capture
        for capture in captures
        if any(_fits(path, glob) for path in (capture.path, capture.location))
        or ("/" not in glob and _fits(os.path.basename(capture.location), glob))
    ]


def chosen_by(captures: Sequence[Capture], where: Where) -> list[Capture]:
    """Return the captures that fit all of some globs.

    Parameters
    ----------
    captures : sequence of Capture
        To choose from.
    where : Mapping of str to str, or iterable of (str, str)
        Globs by column: ``path`` as `matching` compares it, ``label``, ``format``, ``dataset`` or
        any other column that the user gave; one that a capture lacks is the empty text.

    Raises
    ------
    UsageError
        If no capture has such a column.
    """
    chosen = list(captures)
    for key, glob in where.items() if isinstance(where, Mapping) else where:
        if key == "path":
            chosen = matching(chosen, glob)
            continue
        asked = _COLUMNS.get(key) or _column(captures, key)
        chosen = [capture for capture in chosen if _fits(asked(capture), glob)]
    return chosen


def _column(captures: Sequence[Capture], key: str) -> Callable[[Capture], str]:
    columns = sorted({column for capture in captures for column in capture.metadata})
    if captures and key not in columns:
        raise UsageError(
            f'no capture has a column "{key}"',
            wanted=f"one of {', '.join(dict.fromkeys(('path', *_COLUMNS, *columns)))}",
        )
    return lambda capture: capture.metadata.get(key, "")


def missing(captures: Iterable[Capture]) -> list[Capture]:
    """Return the captures whose file is no longer there."""
    return [capture for capture in captures if gone(capture.location)]


def gone(path: str) -> bool:
    """Return whether a file is surely no longer there."""
    try:
        os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return True
    except OSError:  # it may be there, behind a door that is closed to us
        return False
    return False


def find_capture(captures: Sequence[Capture], named: str, place: str) -> Capture:
    """Return the one capture that a name means.

    The first of these that any capture fits: its path, its absolute path, the last parts of its
    path, its number.

    Parameters
    ----------
    captures : sequence of Capture
        Of the library.
    named : str
        What the user wrote.
    place : str
        The library, as a message names it.

    Raises
    ------
    LibraryError
        If no capture is meant, or several are.
    """
    absolute, tail = os.path.abspath(named), os.sep + named
    tests = (
        lambda capture: capture.path == named,
        lambda capture: capture.location == absolute,
        lambda capture: capture.location.endswith(tail),
        lambda capture: str(capture.id) == named,
    )
    for test in tests:
        found = [capture for capture in captures if test(capture)]
        if len(found) == 1:
            return found[0]
        if found:
            raise LibraryError(
                f"{len(found)} captures are called {named}",
                place=place,
                remedy=f"Name one: {_listed([capture.location for capture in found])}",
            )
    raise LibraryError(f"there is no capture {named}", place=place, remedy=_guess(captures, named))


def _listed(names: Sequence[str], most: int = 3) -> str:
    return ", ".join(names[:most]) + (" …" if len(names) > most else "")


def _guess(captures: Sequence[Capture], named: str) -> str:
    from rapidfuzz import process

    names = {os.path.basename(capture.location): capture.path for capture in captures}
    near = process.extract(os.path.basename(named), list(names), limit=3, score_cutoff=60)
    if near:
        return f"Did you mean {_listed([names[name] for name, _, _ in near])}?"
    return "All are shown by: lanindex list"
