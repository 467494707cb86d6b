"""Files prepared by several processes, which end with the one that started them."""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from lanindex.errors import CaptureError, UsageError
from lanindex.pipeline.prepare import Outcome, Task, prepare

if TYPE_CHECKING:
    from concurrent.futures import Future


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
