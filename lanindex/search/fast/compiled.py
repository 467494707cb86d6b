"""Which way the loops of a search go: the plain one, or the compiled one (extra ``fast``)."""

from __future__ import annotations

import sys
from functools import cache
from types import ModuleType

WORTH = 4_000_000
"""Symbols that a process has looked at from which on numba's import (half a second) is risked."""

_FAST = "lanindex.search.fast.joins_fast"

_gone = 0


def chosen(symbols: int) -> ModuleType | None:
    """Return the compiled loops once they have been loaded, or much has been done without them.

    Parameters
    ----------
    symbols : int
        How many are to be looked at.
    """
    global _gone
    _gone += symbols
    return compiled() if _gone >= WORTH or _FAST in sys.modules else None


@cache
def compiled() -> ModuleType | None:
    """Load the compiled loops; without numba, or a folder for its cache, there are none."""
    try:
        from lanindex.search.fast import joins_fast
    except (ImportError, RuntimeError):
        return None
    return joins_fast
