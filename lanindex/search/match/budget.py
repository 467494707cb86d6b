"""How much memory a search may take: tables that would be larger are made in pieces, or refused.

What is free changes while a search runs, so the budget is fixed when it begins.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

LEAST = 64 << 20  # bytes that a search gets in any case
_UNKNOWN = 1 << 30  # bytes where the system does not say what is free
_memory: ContextVar[int] = ContextVar("memory", default=_UNKNOWN)


class TooMuch(Exception):
    """A table would be larger than the budget: to be tried with fewer captures."""


@contextmanager
def limited_to(memory: int | None) -> Iterator[None]:
    """Fix the budget of a search in bytes; None is a quarter of what is free."""
    token = _memory.set(max(LEAST, _free() // 4 if memory is None else memory))
    try:
        yield
    finally:
        _memory.reset(token)


def rows(size: int) -> int:
    """Return how many rows a table may have that take so many bytes each, with all made of them."""
    return _memory.get() // size


def _free() -> int:
    """Return the bytes of memory that are free."""
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            free = next(line for line in lines if line.startswith("MemAvailable"))
        return int(free.split()[1]) << 10
    except (OSError, StopIteration):
        pass
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return 4 * _UNKNOWN
