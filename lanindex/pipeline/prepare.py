"""Files read and written down, not yet stored, by as many processes as memory has room for.

A file is opened once, however many people are in it, and only opened if all of them are held.
"""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from heapq import nlargest
from itertools import accumulate
from typing import TYPE_CHECKING, TypeVar

from lanindex import compiled, formats, locations
from lanindex.errors import CaptureError, LanindexError, OutOfMemoryError, UsageError, counted
from lanindex.formats.file import SUBJECT, on_disk, together
from lanindex.library.connect import no_tick
from lanindex.library.rows import Encoding
from lanindex.memory import available
from lanindex.model.motion import Reading
from lanindex.notation import notation_of, read
from lanindex.notation.beats import AUTO, describe_tempo

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.synchronize import Lock

    from lanindex.encoding.profile import Profile
    from lanindex.model import Score
    from lanindex.pipeline.spread import Spread, Tick

_FILES = ("skeleton", "body", "columns", "tempo")
"""What of a `Reading` is a file, unless it is a word."""

MANY = 16
"""Files that are worth the start of several processes."""

BASE = 300 << 20
"""Bytes that a process takes which reads a small file."""

SHARE = 2.2
"""Bytes more for each byte of the file (tests/benchmarks/memory.py)."""

BATCH, FILE = 32 << 20, 64 << 10
"""Bytes of files, or of clips, of which a process of a cluster does one after the other; what each
counts for more than its bytes."""

Item = TypeVar("Item")

_THEMSELVES = "Workers read files themselves: under the same paths."

_in_a_folder = threading.Lock()

StoredFile = Mapping[str, tuple[str, Encoding]]
"""What a library holds of a file: sha256 and encoding by person, of all of it by the empty text."""


@dataclass(frozen=True, slots=True)
class Task:
    """One file to ingest."""

    path: str
    profile: Profile
    reading: Reading = field(default_factory=Reading)
    stored: StoredFile = field(default_factory=dict)
    only_look: bool = False
    total: int = 0


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a file."""

    path: str
    status: str
    frames: int = 0
    symbols: int = 0
    warnings: tuple[str, ...] = ()
    error: str | None = None
    seconds: float = 0.0
    division: int = 0
    was_stored: bool = False
    labelled: bool = False
    moved: str = ""
    beside: tuple[str, ...] = ()
    tempo: str = ""
    score: Score | None = field(default=None, repr=False)
    format: str = ""
    sha256: str = ""
    encoding: Encoding = field(default_factory=Encoding)


Outcomes = tuple[Outcome, ...]


def prepare(task: Task) -> Outcomes:
    """Read a file and write down who is in it, unstored; never raises a `LanindexError`."""
    compiled.expect(task.total)
    try:
        if unchanged := _unchanged(task):
            return unchanged
        file = formats.opened(task.path)
        sha256, beside = file.sha256(), companions(task, file)
        encoding = encoding_of(task, beside)
        same = {name: one.people for name, (digest, one) in task.stored.items()
                if (digest, one) == (sha256, encoding)}  # fmt: skip
        names: Collection[str] = ()
        complete = _is_complete(same)
        if complete:
            names = same
        elif task.only_look:
            return ()
        elif not notation_of(task.path):
            names = formats.names_in(file, task.reading)
        outcomes = []
        for name in names or ("",):
            person = file
            if name:
                person = replace(file, name=file.name + SUBJECT + name, subject=name)
            facts = Outcome(
                person.name,
                "unchanged",
                sha256=sha256,
                encoding=replace(encoding, people=len(names), version=file.version),
                beside=tuple(one.name for one in beside),
            )
            is_new = not complete and same.get(name) != len(names)
            outcomes.append(_encoded(task, person, facts) if is_new else facts)
    except LanindexError as problem:
        return (Outcome(task.path, "failed", error=str(problem)),)
    except MemoryError:
        remedy = "Ingest it by itself (--jobs 1), or cut it into shorter files."
        error = OutOfMemoryError("not enough memory to read it", place=task.path, remedy=remedy)
        return (Outcome(task.path, "failed", error=str(error)),)
    return tuple(outcomes)


def _is_complete(people: Mapping[str, int]) -> bool:
    """Return whether nobody is missing of a file: by name how many were in it."""
    return "" in people or (len(people) > 1 and set(people.values()) == {len(people)})


def _unchanged(task: Task) -> Outcomes:
    """Return what became of a file that is as it was by what its store says of it; else nothing.

    What lies beside a file may change without it, so there must have been nothing.
    """
    if not locations.is_url(task.path):
        return ()
    place, name, encoding = on_disk(task.path), locations.plain(task.path), encoding_of(task, ())
    same = {who: one for who, one in task.stored.items() if one[1] == encoding}
    if not _is_complete({who: one.people for who, (_, one) in same.items()}):
        return ()
    version, *others = {one.version for _, one in same.values()}
    if others or not version or not _has_version(place, version):
        return ()
    return tuple(
        Outcome(name + SUBJECT * bool(who) + who, "unchanged", sha256=digest, encoding=one)
        for who, (digest, one) in same.items()
    )


def _has_version(place: str, version: str) -> bool:
    """Return whether a file has a version; asked anew where a list tells it otherwise."""
    with suppress(FileNotFoundError, CaptureError):  # said where it is opened
        if locations.version(place) != version:
            locations.forget(place)
        return locations.version(place) == version
    return False


def companions(task: Task, file: formats.File) -> tuple[formats.File, ...]:
    """Return the other files that are read with one."""
    return () if notation_of(task.path) else formats.companions(file, task.reading)


def encoding_of(task: Task, beside: Iterable[formats.File]) -> Encoding:
    """Return how a file is going to be written down, with what lies beside it."""
    if notation_of(task.path):
        return Encoding()
    given = task.reading.given()
    named = (name for name in _FILES if given.get(name, AUTO) != AUTO)
    given |= {name: locations.located(given[name]) for name in named}
    return Encoding(task.profile.name, task.profile.digest, given, together(beside))


def as_ingested(file: formats.File, sha256: str, encoding: Encoding) -> bool:
    """Return whether a file is as it was, and what it was read with, as far as that was noted."""
    if not (file.version and file.version == encoding.version) and file.sha256() != sha256:
        return False
    reading = Reading(**encoding.options)
    return not encoding.beside or encoding.beside == together(formats.companions(file, reading))


def _encoded(task: Task, file: formats.File, facts: Outcome) -> Outcome:
    """Return the outcome of a file, or of one person in it, that is read and written down."""
    try:
        if form := notation_of(task.path):
            score, format_name = read(task.path, file.content[:]), form.name
            warnings = score.warnings
        else:
            from lanindex.encoding import encode

            motion = formats.read_file(file, task.reading, formats.Wanted(body_only=True))
            score = encode(motion, task.profile, tempo=task.reading.tempo)
            format_name, warnings = motion.source.format, (*motion.warnings, *score.warnings)
    except LanindexError as error:
        return Outcome(file.name, "failed", error=str(error), beside=facts.beside)
    return replace(
        facts,
        status="added",
        frames=score.frames,
        symbols=sum(len(track) for track in score.tracks.values()),
        warnings=warnings,
        seconds=float(score.frames / score.rate),
        division=score.meter.division,
        tempo=describe_tempo(score.meter, score.other) if task.reading.tempo else "",
        score=score,
        format=format_name,
    )


def processes(files: int, requested: int | None) -> int:
    """Return how many processes are worth their start for so many files, or those requested."""
    return requested or (os.cpu_count() or 1 if files >= MANY else 1)


def prepared(tasks: Iterable[Task], jobs: int, spread: Spread | None = None) -> Iterator[Outcome]:
    """Prepare tasks, in their order, in one process or several, or spread over a cluster."""
    for outcomes in prepared_together(tasks, jobs, spread):
        yield from outcomes


def prepared_together(
    tasks: Iterable[Task], jobs: int, spread: Spread | None = None
) -> Iterator[Sequence[Outcome]]:
    """Yield the same, file by file, or batch by batch as a cluster returns them."""
    if jobs < 1:
        raise UsageError(f"{jobs} processes", place="--jobs", wanted="one at least")
    waiting = list(tasks)
    sizes = [size_of(task.path) for task in waiting]
    if spread is not None:
        here = os.getcwd()
        batches = ((here, some) for some in in_batches(waiting, sizes, spread.tasks))
        yield from spread.results(prepare_batch, batches, no_tick)
        return
    jobs = affordable(sizes, jobs)
    # what the library holds is most likely unchanged
    new = sum(size for task, size in zip(waiting, sizes, strict=True) if not task.stored)
    shared = (replace(task, total=new // jobs) for task in waiting)
    if jobs == 1:
        yield from map(prepare, shared)
    else:
        yield from _in_processes(shared, jobs)


def in_batches(items: Iterable[Item], sizes: Iterable[int], count: int) -> Iterator[list[Item]]:
    """Yield items that follow each other, in at least so many batches of about as many bytes."""
    weighed = [(item, size + FILE) for item, size in zip(items, sizes, strict=True)]
    most = min(BATCH, sum(size for _, size in weighed) // (2 * count))
    batch, taken = list[Item](), 0
    for item, size in weighed:
        if batch and taken + size > most:
            yield batch
            batch, taken = [], 0
        batch.append(item)
        taken += size
    if batch:
        yield batch


def prepare_batch(batch: tuple[str, Iterable[Task]], tick: Tick) -> list[Outcome]:
    """Prepare tasks in a process of a cluster, as if it ran in the folder that is given.

    A process has one such folder: its threads take turns.
    """
    folder, tasks = batch
    outcomes, unseen = list[Outcome](), list[CaptureError]()
    with _in_a_folder:
        before = os.getcwd()
        try:
            os.chdir(folder)
        except OSError as error:
            found = f"a worker cannot go to this folder ({error.strerror})"
            raise LanindexError(found, place=folder, remedy=_THEMSELVES) from error
        try:
            for task in tasks:
                tick()
                if lost := _unseen(task.path):
                    unseen.append(lost)
                    outcomes.append(Outcome(task.path, "failed", error=str(lost)))
                else:
                    outcomes += prepare(task)
        finally:
            os.chdir(before)
    if len(unseen) == len(outcomes) > 1:  # so it would be with all others
        unseen[0].found += f", nor {counted(len(unseen) - 1, 'other file')}"
        raise unseen[0]
    return outcomes


def _unseen(path: str) -> CaptureError | None:
    """Return the error of a file that whoever gives the tasks sees, and this process does not."""
    found, place = "a worker does not see this file", on_disk(path)
    if locations.is_gone(place):
        return CaptureError(found, place=path, remedy=_THEMSELVES)
    try:
        locations.mark(place)
    except CaptureError as error:  # its store does not let this process read
        return CaptureError(f"{found} ({error.found})", place=path, remedy=error.remedy)
    except OSError:  # told when it is read
        pass
    return None


def _in_processes(tasks: Iterable[Task], jobs: int) -> Iterator[Outcomes]:
    """Prepare tasks in several processes, in their order, with a few ahead.

    What is unchanged is told here: processes start with the first file that is not.
    """
    from concurrent.futures import Future, ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    context = get_context("spawn")
    reader, needed = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(
        jobs, context, initializer=_prepare_process, initargs=(reader, context.Lock())
    )

    def begun(task: Task) -> Future[Outcomes]:
        if task.stored and (unchanged := prepare(replace(task, only_look=True))):
            done = Future[Outcomes]()
            done.set_result(unchanged)
            return done
        with interrupts_later():  # a process that starts now inherits that
            return pool.submit(prepare, task)

    waiting: deque[tuple[Task, Future[Outcomes]]] = deque()
    try:
        for task in tasks:
            waiting.append((task, begun(task)))
            if len(waiting) >= 4 * jobs:
                yield waiting[0][1].result()
                waiting.popleft()
        while waiting:
            yield waiting[0][1].result()
            waiting.popleft()
    except BrokenProcessPool as error:
        raise CaptureError(
            "a process that read this or a later file could not start, or died (out of memory?)",
            place=next((task.path for task, _ in waiting), ""),
            remedy="Try again with one process; in a script, begin it under "
            'if __name__ == "__main__".',
        ) from error
    except BaseException:
        needed.close()  # whoever breaks off does not wait for what is half done
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        for end in (needed, reader):
            end.close()


@contextmanager
def interrupts_later() -> Iterator[None]:
    """Hold Ctrl-C back until the end of the block."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _prepare_process(needed: Connection, turn: Lock) -> None:
    """Leave Ctrl-C to the parent, and end when it does, or when it needs nothing any more."""
    compiled.take_turns(turn)
    compiled.without_scipy()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_follow_parent, args=(needed,), daemon=True).start()


def _follow_parent(needed: Connection) -> None:
    from multiprocessing import parent_process
    from multiprocessing.connection import wait

    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel, needed])
        os._exit(1)


def needed(size: int) -> int:
    """Return the bytes that a process takes at most which reads a file of some bytes."""
    return BASE + round(SHARE * size)


def affordable(sizes: Iterable[int], jobs: int) -> int:
    """Return how many processes have room for the largest files at once: one at least."""
    free = available()
    if jobs == 1 or free is None:
        return jobs
    largest = nlargest(jobs, sizes)
    largest += [0] * (jobs - len(largest))
    taken = accumulate(map(needed, largest))
    return max(sum(together <= free for together in taken), 1)


def size_of(path: str) -> int:
    """Return the bytes of a file, 0 where nothing is there."""
    try:
        return locations.size(on_disk(path))
    except (OSError, ValueError, CaptureError):
        return 0
