"""Files into the library: found, read, written down and stored, one transaction a file."""

from __future__ import annotations

import hashlib
import os
import signal
import threading
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex import capture
from lanindex.errors import CaptureError, LanindexError, UsageError
from lanindex.library.store import Encoding, Library

if TYPE_CHECKING:
    from concurrent.futures import Future

    from lanindex.encode.profile import Profile
    from lanindex.model import Score

SUFFIXES = {**capture.SUFFIXES, ".lnd": "lnd"}
"""Endings that a folder is searched for, with the format each stands for."""


@dataclass(frozen=True, slots=True)
class Reading:
    """What a reader is told in place of what it would have found.

    Attributes
    ----------
    unit, up, compose : str or None
        As for `lanindex.read`.
    rate : Fraction or None
        Frames a second.
    """

    unit: str | None = None
    up: str | None = None
    rate: Fraction | None = None
    compose: str | None = None

    def told(self) -> dict[str, str]:
        """Return what was told, as text."""
        values = {"unit": self.unit, "up": self.up, "rate": self.rate, "compose": self.compose}
        return {name: str(value) for name, value in values.items() if value is not None}


@dataclass(frozen=True, slots=True)
class Task:
    """One file to ingest.

    Attributes
    ----------
    path : str
        As given, or as found in a folder.
    profile : Profile
        How to write it down.
    reading : Reading
        How to read it.
    known : tuple or None
        sha256 and encoding of what the library holds from there.
    only_look : bool
        Whether only to see if it has changed.
    """

    path: str
    profile: Profile
    reading: Reading = Reading()
    known: tuple[str, Encoding] | None = None
    only_look: bool = False


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a file.

    Attributes
    ----------
    path : str
        As in the task.
    status : str
        ``added``, ``unchanged`` or ``failed``.
    frames, symbols : int
        How many there are.
    warnings : tuple of str
        What was doubtful.
    error : str or None
        What went wrong.
    seconds : float
        How long the capture lasts.
    """

    path: str
    status: str
    frames: int = 0
    symbols: int = 0
    warnings: tuple[str, ...] = ()
    error: str | None = None
    seconds: float = 0.0
    score: Score | None = field(default=None, repr=False)
    format: str = ""
    sha256: str = ""
    encoding: Encoding = field(default_factory=Encoding)


def discover(paths: Iterable[str | os.PathLike[str]]) -> Iterator[str]:
    """Yield the files to ingest: those named, and in folders all of a known ending, sorted.

    Parameters
    ----------
    paths : iterable of path-like
        Files and folders.

    Yields
    ------
    str
        A path, once.
    """
    seen: set[str] = set()
    for named in paths:
        path = os.fspath(named)
        for found in _walk(path) if os.path.isdir(path) else [path]:
            place = os.path.abspath(found)
            if place not in seen:
                seen.add(place)
                yield found


def _walk(folder: str) -> Iterator[str]:
    closed: list[OSError] = []
    for place, folders, names in os.walk(folder, onerror=closed.append):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(names):
            if Path(name).suffix.lower() in SUFFIXES and not name.startswith("."):
                yield os.path.join(place, name)
    for error in closed:  # reported like a file that cannot be read
        yield str(error.filename)


def prepare(task: Task) -> Outcome:
    """Read a file and write it down, without storing it; never raises a `LanindexError`.

    Parameters
    ----------
    task : Task
        Which file, and how.

    Returns
    -------
    Outcome
        With the score, if it is new or changed.
    """
    try:
        return _prepare(task)
    except LanindexError as error:
        return Outcome(task.path, "failed", error=str(error))


def _prepare(task: Task) -> Outcome:
    data = capture.load(task.path)
    sha256 = hashlib.sha256(data).hexdigest()
    notated = Path(task.path).suffix.lower() == ".lnd"
    encoding = Encoding()
    if not notated:
        encoding = Encoding(task.profile.name, task.profile.digest, task.reading.told())
    if task.known == (sha256, encoding):
        return Outcome(task.path, "unchanged", sha256=sha256, encoding=encoding)
    if task.only_look:
        return Outcome(task.path, "added")
    score, form, warnings = (_notated if notated else _written_down)(task, data)
    return Outcome(
        task.path,
        "added",
        score.frames,
        sum(len(track) for track in score.tracks.values()),
        warnings,
        seconds=float(score.frames / score.rate),
        score=score,
        format=form,
        sha256=sha256,
        encoding=encoding,
    )


def _notated(task: Task, data: bytes) -> tuple[Score, str, tuple[str, ...]]:
    from lanindex.notation import lnd

    return lnd.read(data, place=task.path), "lnd", ()


def _written_down(task: Task, data: bytes) -> tuple[Score, str, tuple[str, ...]]:
    from lanindex.encode import encode

    told = task.reading
    motion = capture.read(
        task.path,
        unit=told.unit,
        up=told.up,
        rate=told.rate,
        compose=told.compose,
        data=data,
    )
    score, warnings = encode(motion, task.profile), motion.warnings
    if score.meter.division != task.profile.meter.division:
        warnings += (f"the grid was refined to {score.meter.division} ticks a unit",)
    return score, motion.source.format, warnings


def ingest(
    library: Library | None,
    paths: Iterable[str],
    profile: Profile,
    *,
    reading: Reading | None = None,
    labels: Mapping[str, tuple[str, Mapping[str, str]]] | None = None,
    jobs: int = 1,
    force: bool = False,
    dry_run: bool = False,
) -> Iterator[Outcome]:
    """Read files into a library.

    Parameters
    ----------
    library : Library or None
        None, with `dry_run`: there is none yet.
    paths : iterable of str
        Files, as from `discover`.
    profile : Profile
        How to write captures down.
    reading : Reading, optional
        How to read them.
    labels : Mapping, optional
        By absolute path: the label and other columns of a capture.
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
    known = library.known() if library and not force else {}
    told = reading or Reading()
    tasks = (Task(path, profile, told, known.get(os.path.abspath(path))) for path in paths)
    for outcome in prepared(tasks, jobs):
        yield replace(outcome if dry_run else _store(library, outcome, labels or {}), score=None)


def prepared(tasks: Iterable[Task], jobs: int) -> Iterator[Outcome]:
    """Prepare tasks, in their order, in one process or several.

    Parameters
    ----------
    tasks : iterable of Task
        What to read.
    jobs : int
        Processes.

    Yields
    ------
    Outcome
        One a task.

    Raises
    ------
    UsageError
        Where `jobs` is less than one.
    CaptureError
        Where a process died.
    """
    if jobs < 1:
        raise UsageError(f"{jobs} processes", place="--jobs", wanted="one at least")
    yield from map(prepare, tasks) if jobs == 1 else _in_processes(tasks, jobs)


def _store(
    library: Library | None,
    outcome: Outcome,
    labels: Mapping[str, tuple[str, Mapping[str, str]]],
) -> Outcome:
    label, metadata = labels.get(os.path.abspath(outcome.path), (None, None))
    if library is not None and outcome.score is not None:
        try:
            library.add(
                outcome.path,
                outcome.score,
                format=outcome.format,
                sha256=outcome.sha256,
                encoding=outcome.encoding,
                label=label,
                metadata=metadata,
            )
        except UsageError as error:
            return Outcome(outcome.path, "failed", error=str(error))
    elif library is not None and outcome.status == "unchanged" and label is not None:
        library.label(outcome.path, label, metadata)
    return outcome


def _in_processes(tasks: Iterable[Task], jobs: int) -> Iterator[Outcome]:
    """Prepare tasks in several processes, in their order, with a few ahead.

    What is unchanged is told here: processes start with the first file that is not.
    """
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    pool = ProcessPoolExecutor(jobs, get_context("spawn"), initializer=_settle)

    def begun(task: Task) -> Future[Outcome]:
        with _interrupts_later():  # a process that starts now inherits that
            return pool.submit(prepare, task)

    waiting: deque[tuple[Task, Future[Outcome] | Outcome]] = deque()
    try:
        for task in tasks:
            waiting.append((task, _unchanged(task) or begun(task)))
            if len(waiting) >= 4 * jobs:
                yield _done(*waiting.popleft())
        while waiting:
            yield _done(*waiting.popleft())
    finally:
        pool.shutdown(cancel_futures=True)


def _unchanged(task: Task) -> Outcome | None:
    if task.known is None:
        return None
    outcome = prepare(replace(task, only_look=True))
    return None if outcome.status == "added" else outcome


def _done(task: Task, result: Future[Outcome] | Outcome) -> Outcome:
    from concurrent.futures.process import BrokenProcessPool

    if isinstance(result, Outcome):
        return result
    try:
        return result.result()
    except BrokenProcessPool as error:
        raise CaptureError(
            "the process that read it died (out of memory?)",
            place=task.path,
            remedy="Try again with --jobs 1.",
        ) from error


@contextmanager
def _interrupts_later() -> Iterator[None]:
    """Hold Ctrl-C back until the end of the block."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _settle(*_: Any) -> None:
    """Leave Ctrl-C to the parent, which ends the pool in good order, and end when it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_follow_parent, daemon=True).start()


def _follow_parent() -> None:
    from multiprocessing import parent_process
    from multiprocessing.connection import wait

    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
