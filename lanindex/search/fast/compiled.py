"""Which way the loops of a search go: the plain one, or the compiled one (extra ``fast``)."""

from __future__ import annotations

import sys
from functools import cache
from types import ModuleType

WORTH = 4_000_000
"""Symbols of a search from which on numba's import (half a second) is risked."""

_FAST = "lanindex.search.fast.joins_fast"


def chosen(symbols: int) -> ModuleType | None:
    """Return the compiled loops for much work, or once they have been loaded; None: the plain ones.

    Parameters
    ----------
    symbols : int
        How many the search looks at.
    """
    return compiled() if symbols >= WORTH or _FAST in sys.modules else None


@cache
def compiled() -> ModuleType | None:
    """Load the compiled loops; without numba, or a folder for its cache, there are none."""
    try:
        from lanindex.search.fast import joins_fast
    except (ImportError, RuntimeError):
        return None
    return joins_fast
