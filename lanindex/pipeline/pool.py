"""Files prepared by several processes, as many as memory has room for."""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from heapq import nlargest
from itertools import accumulate, chain
from typing import TYPE_CHECKING

from lanindex import compiled
from lanindex.errors import CaptureError, UsageError
from lanindex.formats.file import on_disk
from lanindex.memory import available
from lanindex.pipeline.prepare import Outcome, Task, prepare

if TYPE_CHECKING:
    from concurrent.futures import Future
    from multiprocessing.connection import Connection
    from multiprocessing.synchronize import Lock


Outcomes = tuple[Outcome, ...]


def prepared(tasks: Iterable[Task], jobs: int) -> Iterator[Outcome]:
    """Prepare tasks, in their order, in one process or several."""
    if jobs < 1:
        raise UsageError(f"{jobs} processes", place="--jobs", wanted="one at least")
    waiting = list(tasks)
    sizes = [size_of(task.path) for task in waiting]
    jobs = affordable(sizes, jobs)
    # what the library holds is most likely unchanged
    new = sum(size for task, size in zip(waiting, sizes, strict=True) if not task.held)
    shared = (replace(task, total=new // jobs) for task in waiting)
    alone = jobs == 1
    yield from chain.from_iterable(map(prepare, shared)) if alone else _in_processes(shared, jobs)


def _in_processes(tasks: Iterable[Task], jobs: int) -> Iterator[Outcome]:
    """Prepare tasks in several processes, in their order, with a few ahead.

    What is unchanged is told here: processes start with the first file that is not.
    """
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    context = get_context("spawn")
    reader, needed = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(
        jobs, context, initializer=_settle, initargs=(reader, context.Lock())
    )

    def begun(task: Task) -> Future[Outcomes]:
        with _interrupts_later():  # a process that starts now inherits that
            return pool.submit(prepare, task)

    waiting: deque[tuple[Task, Future[Outcomes] | Outcomes]] = deque()
    try:
        for task in tasks:
            waiting.append((task, _unchanged(task) or begun(task)))
            if len(waiting) >= 4 * jobs:
                yield from _done(waiting[0][1])
                waiting.popleft()
        while waiting:
            yield from _done(waiting[0][1])
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


def _unchanged(task: Task) -> Outcomes:
    return prepare(replace(task, only_look=True)) if task.held else ()


def _done(result: Future[Outcomes] | Outcomes) -> Outcomes:
    return result if isinstance(result, tuple) else result.result()


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


def _settle(needed: Connection, turn: Lock) -> None:
    """Leave Ctrl-C to the parent, and end when it does, or when it needs nothing any more."""
    compiled.take_turns(turn)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_follow_parent, args=(needed,), daemon=True).start()


def _follow_parent(needed: Connection) -> None:
    from multiprocessing import parent_process
    from multiprocessing.connection import wait

    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel, needed])
        os._exit(1)


BASE = 300 << 20
"""Bytes that a process takes which reads a small file."""

SHARE = 2.2
"""Bytes more for each byte of the file (tests/benchmarks/memory.py)."""


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
        return os.stat(on_disk(path)).st_size
    except (OSError, ValueError):
        return 0
