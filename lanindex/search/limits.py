"""When a search gives up: the memory, the time and the partial matches that it may take.

What is free changes while a search runs, so its budget is fixed when it begins. Tables that would
be larger are made in pieces, or their capture is refused. Whoever waits for the search is told with
each column that is made, and may break it off there.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from time import monotonic

from lanindex.errors import LanindexError
from lanindex.memory import available

MOST_TRIED = 1 << 21
"""Partial matches and joins that are tried in one capture before it is refused."""

LEAST = 64 << 20  # bytes that a search gets in any case
UNKNOWN = 1 << 30  # bytes that it gets where the system does not say what is free

Progress = Callable[[str, int, int], None]
"""Called with a noun, how many are done, and of how many."""

_Running = tuple[int, Callable[[], None] | None]
_running: ContextVar[_Running] = ContextVar("running", default=(UNKNOWN, None))


class OverBudget(Exception):
    """A table would be larger than the budget: to be tried with fewer captures."""


@contextmanager
def running(memory: int | None, tick: Callable[[], None] | None) -> Iterator[None]:
    """Begin a search: its budget in bytes, None a quarter of what is free, and its tick.

    Without a tick, whoever waits already is told.
    """
    if memory is None:
        free = available()
        memory = UNKNOWN if free is None else free // 4
    token = _running.set((max(LEAST, memory), tick or _running.get()[1]))
    try:
        yield
    finally:
        _running.reset(token)


def tick() -> None:
    """Tell whoever waits that the search goes on; this raises where it may not."""
    if call := _running.get()[1]:
        call()


def most_rows(size: int) -> int:
    """Return how many rows a table may have that take so many bytes each, with all made of them."""
    return _running.get()[0] // size


def check_budget(rows: int, size: int) -> None:
    """Raise `OverBudget` where a table of rows that take so many bytes each would be too large."""
    if rows > most_rows(size):
        raise OverBudget


@contextmanager
def deadline(
    progress: Progress, seconds: float | None, job: str = "search", remedy: str = ""
) -> Iterator[Progress]:
    """Yield a progress that is passed on, and raises once the job has taken too long.

    What is passed on never falls; it ends at its total, when others are counted and with the job.
    """
    begun, last = monotonic(), ("", 0, 0)

    def watch(noun: str, done: int, total: int) -> None:
        nonlocal last
        if (noun, total) == (last[0], last[2]):
            done = max(done, last[1])
        else:
            end()
        last = noun, done, total
        progress(*last)
        if seconds is not None and monotonic() - begun > seconds:
            raise LanindexError(
                f"the {job} took longer than {seconds:g} s, "
                f"and was through with {done:,} of {total:,} {noun}",
                remedy=remedy,
            )

    def end() -> None:
        noun, done, total = last
        if done < total:
            progress(noun, total, total)

    yield watch
    end()
