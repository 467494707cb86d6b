"""How much memory a file takes, how much is free, and so how many can be read at once."""

from __future__ import annotations

import os
from collections.abc import Iterable
from heapq import nlargest
from itertools import accumulate

from lanindex.formats.file import on_disk
from lanindex.memory import available

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
