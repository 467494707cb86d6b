"""Which captures a person means: by glob, by path, by the end of a path, by a missing file."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from lanindex.errors import LibraryError
from lanindex.model import Capture


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
        if any(fnmatchcase(path, glob) for path in (capture.path, capture.location))
        or ("/" not in glob and fnmatchcase(os.path.basename(capture.location), glob))
    ]


def missing(captures: Iterable[Capture]) -> list[Capture]:
    """Return the captures whose file is no longer there."""
    return [capture for capture in captures if _gone(capture.location)]


def _gone(path: str) -> bool:
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
