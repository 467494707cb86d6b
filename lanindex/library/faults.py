"""What a database says when it fails, put into words that a person can act on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lanindex.errors import LibraryBusyError, LibraryError
from lanindex.library.link import faults

_AGAIN = "What was stored before is whole; run again"

_FAULTS: dict[str, tuple[type[LibraryError], str, str]] = {
    "SQLITE_BUSY": (
        LibraryBusyError,
        "another process holds the library",
        "Wait until it has ended (or end it), then run again.",
    ),
    "SQLITE_READONLY": (
        LibraryError,
        "the library or its folder may not be written",
        "Give yourself the right to write both, or name another library with --db.",
    ),
    "SQLITE_READONLY_ROLLBACK": (
        LibraryError,
        "a write was broken off here and cannot be undone without the right to write",
        "Open the library once with the right to write it and its folder.",
    ),
    "SQLITE_FULL": (LibraryError, "the disk is full", f"{_AGAIN} when there is room."),
    "SQLITE_IOERR": (
        LibraryError,
        "the disk cannot be read or written",
        f"{_AGAIN} when the disk is well (is it full, or gone?).",
    ),
    "SQLITE_NOTADB": (
        LibraryError,
        "this is not a library",
        "Name a library, or a new file, with --db.",
    ),
    "SQLITE_CORRUPT": (
        LibraryError,
        "the library is damaged",
        "Ingest the captures into a new library: all in it comes from them.",
    ),
    "SQLITE_CANTOPEN": (
        LibraryError,
        "the library cannot be opened",
        "Check that its folder exists and that you may read and write both.",
    ),
}
"""By SQLite's name of the result, the longer one first looked for."""

_UNKNOWN = "Ask it for what is wrong with: lanindex db check"


def _named(error: BaseException) -> str:
    if isinstance(error, UnicodeDecodeError):  # not even what SQLite says of it can be read
        return "SQLITE_CORRUPT"
    return getattr(error, "sqlite_errorname", None) or ""


def library_error(error: Exception, place: str) -> LibraryError:
    """Return the LibraryError that says what a database's error means."""
    origin = getattr(error, "orig", None) or error
    name = _named(origin)
    fault = _FAULTS.get(name) or _FAULTS.get("_".join(name.split("_")[:2]))
    if fault is None:
        return LibraryError(f"the database says: {origin}", place=place, remedy=_UNKNOWN)
    kind, found, remedy = fault
    return kind(found, place=place, remedy=remedy)


@contextmanager
def translated(place: str) -> Iterator[None]:
    """Raise every error of the database inside as a LibraryError."""
    try:
        yield
    except faults() as error:
        raise library_error(error, place) from error
