"""Files into the library: found, read, written down and stored, one transaction a file."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lanindex import formats
from lanindex.errors import UsageError
from lanindex.formats.not_read import unread
from lanindex.library.store import Store
from lanindex.model import Reading
from lanindex.pipeline.labels import key_of
from lanindex.pipeline.moved import Moved
from lanindex.pipeline.pool import prepared
from lanindex.pipeline.prepare import Outcome, Task

if TYPE_CHECKING:
    from lanindex.encode.profile import Profile

SUFFIXES = {suffix: form.name for form in formats.FORMATS for suffix in form.suffixes} | {
    ".lnd": "lnd"
}
"""Endings that a folder is searched for, with the format each stands for."""

GATHER = 4096
"""Files after which an ingest puts what it has stored into columns; and after the last one."""


def discover(
    paths: Iterable[str | os.PathLike[str]], others: list[str] | None = None
) -> Iterator[str]:
    """Yield the files to ingest: those named, and in folders all of a known ending, sorted.

    Parameters
    ----------
    paths : iterable of path-like
        Files and folders.
    others : list of str, optional
        To which is added what is passed over in folders: files, and links to other folders. What
        is hidden is left aside.

    Yields
    ------
    str
        A path, once.

    Examples
    --------
    >>> from lanindex.pipeline.ingest import discover
    >>> list(discover(["corpus"]))[:3]
    ['corpus/compass.bvh', 'corpus/compass.lnd', 'corpus/conductor_four.bvh']
    """
    seen: set[str] = set()
    for named in paths:
        path = os.fspath(named)
        for found in _walk(path, others) if os.path.isdir(path) else [path]:
            place = os.path.abspath(found)
            if place not in seen:
                seen.add(place)
                yield found


def _walk(folder: str, others: list[str] | None) -> Iterator[str]:
    closed: list[OSError] = []
    for place, folders, names in os.walk(folder, onerror=closed.append):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        if others is not None:  # they could lead in a circle
            linked = (os.path.join(place, name) for name in folders)
            others.extend(path for path in linked if os.path.islink(path))
        for name in sorted(name for name in names if not name.startswith(".")):
            if Path(name).suffix.lower() in SUFFIXES:
                yield os.path.join(place, name)
            elif others is not None:
                others.append(os.path.join(place, name))
    for error in closed:  # reported like a file that cannot be read
        yield str(error.filename)


def left_out(others: Iterable[str]) -> str:
    """Say what was passed over: captures of formats that are not read yet, by ending, and the rest.

    Parameters
    ----------
    others : iterable of str
        As from `discover`; each file counts once.

    Returns
    -------
    str
        ``24 .c3d, 7 .amc (formats that are not read yet); 3 other files``; empty if there are none.
    """
    paths = set(map(os.path.abspath, others))
    kinds = Counter("/" if os.path.isdir(path) else unread(path) for path in paths)
    rest, linked = kinds.pop("", 0), kinds.pop("/", 0)
    by_number = sorted(kinds.items(), key=lambda kind: (-kind[1], kind[0]))
    known = ", ".join(f"{number} {kind}" for kind, number in by_number)
    said = [f"{known} (formats that are not read yet)"] if known else []
    for number, noun in ((rest, "other file"), (linked, "linked folder")):
        said += [f"{number} {noun}" + "s" * (number > 1)] if number else []
    return "; ".join(said)


def ingest(
    library: Store | None,
    paths: Iterable[str],
    profile: Profile,
    *,
    reading: Reading | None = None,
    labels: Mapping[str, tuple[str | None, Mapping[str, str]]] | None = None,
    jobs: int = 1,
    force: bool = False,
    dry_run: bool = False,
) -> Iterator[Outcome]:
    """Read files into a library.

    Parameters
    ----------
    library : Store or None
        None, with `dry_run`: there is none yet.
    paths : iterable of str
        Files, as from `discover`.
    profile : Profile
        How to write captures down.
    reading : Reading, optional
        How to read them.
    labels : Mapping, optional
        As from `lanindex.pipeline.labels.read_labels`; what they do not tell stays.
    jobs : int
        Processes.
    force : bool
        Read unchanged files again, too.
    dry_run : bool
        Store nothing, only say what would be.

    Yields
    ------
    Outcome
        One a file, in their order, as soon as it is stored.

    Raises
    ------
    LibraryError
        Where the library cannot be written; what was stored before stays.
    """
    held = library.known() if library else {}
    moved, told = Moved(held), reading or Reading()
    tasks = (moved.told(Task(path, profile, told), force=force) for path in paths)
    for number, outcome in enumerate(prepared(tasks, jobs)):
        place = os.path.abspath(outcome.path)
        before = moved.found.get(place, "")
        outcome = replace(outcome, held=place in held or bool(before), moved=before)
        done = outcome if dry_run else _store(library, outcome, labels or {})
        yield replace(done, score=None)
        if library and not dry_run and (number + 1) % GATHER == 0:
            library.gather()
    if library and not dry_run:
        library.gather()


def _store(
    library: Store | None,
    outcome: Outcome,
    labels: Mapping[str, tuple[str | None, Mapping[str, str]]],
) -> Outcome:
    if library is None or outcome.status == "failed":
        return outcome
    place = os.path.abspath(outcome.path)
    if outcome.moved:
        library.move(outcome.moved, outcome.path)
    label, metadata = labels.get(key_of(place), (None, {}))
    if metadata and outcome.held:
        metadata = {**library.capture(place).metadata, **metadata}
    if outcome.score is None:
        told = label is not None or bool(metadata)
        return replace(outcome, labelled=told and library.label(place, label, metadata or None))
    try:
        library.add(
            outcome.path,
            outcome.score,
            format=outcome.format,
            sha256=outcome.sha256,
            encoding=outcome.encoding,
            label=label,
            metadata=metadata or None,
            warnings=outcome.warnings,
        )
    except UsageError as error:
        return Outcome(outcome.path, "failed", error=str(error), held=outcome.held)
    return outcome
