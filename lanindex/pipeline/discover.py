"""Which captures there are: in folders, in archives, several people in one file."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

from lanindex import formats
from lanindex.errors import LanindexError
from lanindex.formats import archives
from lanindex.formats.sniff import COMPANIONS, unread
from lanindex.formats.sniff import WITHOUT_PLACES as ANGLES
from lanindex.library.selection import printable
from lanindex.notation import NOTATIONS

SUFFIXES = {suffix: form.name for form in formats.FORMATS for suffix in form.suffixes} | {
    form.suffix: form.name for form in NOTATIONS.values() if form.ingested
}
"""Endings that a folder is searched for, with the format each stands for."""

_UNSURE = {suffix for form in formats.FORMATS if not form.certain for suffix in form.suffixes}


def discover(
    paths: Iterable[str | os.PathLike[str]],
    others: list[str] | None = None,
    *,
    apart: bool = True,
) -> Iterator[str]:
    """Yield the captures to ingest: those named, and all that folders and archives hold, sorted."""
    seen: set[str] = set()
    for named in paths:
        path = os.fspath(named)
        for found in _walk(path, others) if os.path.isdir(path) else [path]:
            place = os.path.abspath(found)
            if place not in seen:
                seen.add(place)
                yield from map(printable, _captures_in(found, others, apart))


def _walk(folder: str, others: list[str] | None) -> Iterator[str]:
    closed: list[OSError] = []
    for place, folders, names in os.walk(folder, onerror=closed.append):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        if others is not None:  # they could lead in a circle
            linked = (os.path.join(place, name) for name in folders)
            others.extend(path for path in linked if os.path.islink(path))
        for name in sorted(name for name in names if not name.startswith(".")):
            yield from _if_read(os.path.join(place, name), others)
    for error in closed:  # reported like a file that cannot be read
        yield str(error.filename)


def _if_read(path: str, others: list[str] | None) -> Iterator[str]:
    """Yield a path if what it leads to is an archive, a capture or a score."""
    suffix = Path(path).suffix.lower()
    packed = archives.is_archive(path) and not archives.split(path)[0]
    unsure = suffix in _UNSURE and not formats.is_capture(path)
    if packed or (suffix in SUFFIXES and not unsure):
        yield path
    elif others is not None and suffix not in COMPANIONS:
        others.append(path)


def _captures_in(path: str, others: list[str] | None, apart: bool) -> Iterator[str]:
    """Yield the captures in a file: of an archive its members, else its people."""
    try:
        if archives.is_archive(path) and os.path.isfile(path):
            names = archives.members(path)
            inside = (path + archives.MARK + name for name in names if not _hidden(name))
            for member in (one for name in inside for one in _if_read(name, others)):
                yield from formats.captures_in(member) if apart else (member,)
        else:
            yield from formats.captures_in(path) if apart else (path,)
    except LanindexError:  # reported when it is read
        yield path


def _hidden(name: str) -> bool:
    return any(part.startswith((".", "__MACOSX")) for part in name.split("/"))


def left_out(others: Iterable[str]) -> str:
    """Say how many files were passed over: by ending for formats that are not read yet."""
    paths = set(map(os.path.abspath, others))
    kinds = Counter("/" if os.path.isdir(path) else unread(path) for path in paths)
    rest, linked = kinds.pop("", 0), kinds.pop("/", 0)
    by_number = sorted(kinds.items(), key=lambda kind: (-kind[1], kind[0]))
    counts = []
    for angles, why in ((False, "formats that are not read yet"), (True, "angles without places")):
        some = [f"{number} {kind}" for kind, number in by_number if (kind in ANGLES) is angles]
        counts += [f"{', '.join(some)} ({why})"] if some else []
    for number, noun in ((rest, "other file"), (linked, "linked folder")):
        counts += [f"{number} {noun}" + "s" * (number > 1)] if number else []
    return "; ".join(counts)
