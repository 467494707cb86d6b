"""Which way alignments go: the plain one, or the compiled one (extra ``fast``)."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from typing import Any

WORTH = 20_000_000
"""Cells of alignments at once from which on numba's import (half a second) is risked."""

_FAST = "lanindex.search.example.align_fast"


def chosen(cells: int) -> Callable[..., Any] | None:
    """Return the compiled way for much work, or once it has been loaded; None: the plain one.

    Parameters
    ----------
    cells : int
        Pairs of rows that are to be compared.
    """
    return compiled() if cells >= WORTH or _FAST in sys.modules else None


@cache
def compiled() -> Callable[..., Any] | None:
    """Load the compiled way; without numba, or a folder for its cache, there is none."""
    try:
        from lanindex.search.example import align_fast
    except (ImportError, RuntimeError):
        return None
    found: Callable[..., Any] = align_fast.differences
    return found
