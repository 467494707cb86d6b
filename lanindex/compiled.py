"""Whether loops over a capture run as plain numpy or compiled by numba (extra ``fast``).

Both ways give the same bytes. Compiled loops are several times as fast, but importing numba and
loading its cache takes a third of a second, and compiling, which is done once after an
install, takes seconds. So the work of the process decides, here and for the whole package.
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from multiprocessing.synchronize import Lock

LOAD = 20_000_000
"""Bytes of captures from which on loops in the cache of numba are worth loading."""

FRAME = 500
"""Bytes of a file for each frame of a capture, about, where only the frames are known."""


class Loops(NamedTuple):
    """Loops that are used together."""

    modules: tuple[str, ...]  # What has to be imported
    # The kernel of the last module that a capture calls last: once it is in the cache of numba, so
    # are the others
    last: str
    worth: int  # Bytes of captures from which on compiling them costs less than it saves


LOOPS = {
    "numbers": Loops(
        ("lanindex.formats.decimals_fast", "lanindex.body.kinematics_fast"),
        "_positions",
        100_000_000,
    ),
    "encode": Loops(
        tuple(f"lanindex.encoding.{name}_fast" for name in ("curves", "touch", "written")),
        "looked",
        500_000_000,
    ),
}
"""What is compiled together, and what that is worth."""


_done, _again = Counter[str](), Counter[str]()
_expected = 0
_turn: Lock | None = None
_chosen = set[str]()


def expect(size: int) -> None:
    """Say how many bytes of captures this process is going to read in all, as far as is known."""
    global _expected
    _expected = max(_expected, size)


def take_turns(turn: Lock) -> None:
    """Let only one of the processes that share a lock compile."""
    global _turn
    _turn = turn


def without_scipy() -> None:
    """Let numba, in a process of the command, not import scipy for products: a fifth of a second.

    No loop multiplies matrices; scripts, whose own loops may, do not call this.
    """
    sys.modules["scipy.linalg.cython_blas"] = None  # type: ignore[assignment]


def chosen(name: str, size: int) -> bool:
    """Return whether to use compiled loops from now on."""
    _done[name] += size
    if name not in _chosen:
        work = max(_done[name], _expected)
        if work < LOAD or not (_found(name) or (work >= LOOPS[name].worth and _may_compile())):
            return False
        _chosen.add(name)
    return imported(name)


@cache
def imported(name: str) -> bool:
    """Import loops; tell whether numba, and a folder for what it compiles, are there."""
    try:
        for module in LOOPS[name].modules:
            import_module(module)
    except (ImportError, RuntimeError):
        return False
    return True


def cached(name: str) -> bool:
    """Return whether loops are in the cache of numba, without importing it.

    The cache of an older module looks the same: it is compiled anew when it is called. A change
    of a constant or a function that a module imports from another one is not noticed.
    """
    module, kernel = LOOPS[name].modules[-1], LOOPS[name].last
    source = Path(__file__).parents[1].joinpath(*module.split(".")).with_suffix(".py")
    python = "".join(map(str, sys.version_info[:2]))
    index = f"{source.stem}.{kernel}-*.py{python}*.nbi"
    folder = os.environ.get("NUMBA_CACHE_DIR")
    of_user = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "numba"
    folders = [Path(folder)] if folder else [source.parent / "__pycache__", of_user]
    return any(any((*one.glob(index), *one.glob(f"*/{index}"))) for one in folders)


def _found(name: str) -> bool:
    """Look for loops in the cache, not for each capture: a look takes a millisecond."""
    if _done[name] < _again[name]:
        return False
    _again[name] = _done[name] + LOAD // 10
    return cached(name)


def _may_compile() -> bool:
    global _turn
    if _turn is not None and _turn.acquire(False):
        _turn = None
    return _turn is None
