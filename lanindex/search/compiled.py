"""Which way the loops of a search go: the plain one, or the compiled one (extra ``fast``).

To import numba costs two fifths of a second, and to make ready what it has compiled a tenth for
each module: a single small search goes the plain way, and so does a process that does little.
"""

from __future__ import annotations

import sys
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import NamedTuple

CHEAPER = 4
"""By how much less the next loops are to be had once numba has been imported for others."""


class Loops(NamedTuple):
    """Loops that have been compiled: in which module, and from how much work on it is worth it."""

    module: str
    worth: int


LOOPS = {
    "fuzzy": Loops("lanindex.search.fuzzy.scan_fast", 20_000_000),
}
"""Work is counted in rows that are gone through, in steps of them, or in pairs of them."""

_gone = dict.fromkeys(LOOPS, 0)


def chosen(name: str, work: int) -> ModuleType | None:
    """Return compiled loops once they are there, or much has been done without; None: plain ones.

    Parameters
    ----------
    name : str
        Which, of `LOOPS`.
    work : int
        How much is to be done now; what the process did before counts too.
    """
    _gone[name] += work
    module, worth = LOOPS[name]
    there = any(it.module in sys.modules for it in LOOPS.values())
    enough = _gone[name] >= (worth // CHEAPER if there else worth)
    return loaded(name) if enough or module in sys.modules else None


@cache
def loaded(name: str) -> ModuleType | None:
    """Load compiled loops; without numba, or a folder for its cache, there are none."""
    try:
        return import_module(LOOPS[name].module)
    except (ImportError, RuntimeError):
        return None
