"""The engine beside others that are known to be fast: ``python tests/benchmarks/peers.py``.

One part of 4.6 million symbols: an exact chain of three steps, classes with an optional step, a gap
of three symbols at most. hyperscan, where it is installed, is given the cells as a text, a byte a
symbol, with a byte between captures, and asked for the same: capture and last frame of each match.
It tells all ends, we the first end of each beginning, so ours are to be among its. Passing symbols,
which no regular expression can step over, are left out for both; patterns are read beforehand,
expressions compiled. Median milliseconds of the processor, one thread, all in turn.
"""

import importlib.util
import sys
import time
from collections.abc import Callable
from statistics import median

import numpy as np
import synthetic

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.model.columns import CELL, PASSING, Columns, Roster, cell_of
from lanindex.search.language import parse
from lanindex.search.match import Finder

CAPTURES = 400_000
ROUNDS = 9
BETWEEN = 0xFF

PATTERNS = {
    "exact": "r_arm right mid -> r_forward high -> place high",
    "classes": "r_arm right/r_forward mid/high -> any? -> place",
    "gap": "r_arm right mid ...[<=3] place high",
}


def one_part(captures: int) -> tuple[Roster, Columns]:
    """Return what the right arm does, without passing symbols."""
    roster, every = synthetic.columns(captures, parts=["r_arm"])
    held = every["r_arm"]
    kept = held.cell & PASSING == 0
    bounds = np.concatenate(([0], np.cumsum(kept)))[held.bounds]
    names = ("cell", "runner", "margin", "start", "stop")
    rows = {name: getattr(held, name)[kept] for name in names}
    return roster, Columns("r_arm", bounds, **rows, seen=held.seen)


def cells(directions: str, levels: str) -> bytes:
    """Return a class of bytes: ``right r_forward``, ``mid high``; nothing said: all of them."""
    each = [
        cell_of(DIRECTIONS.index(direction), LEVELS.index(level))
        for direction in directions.split() or DIRECTIONS
        for level in levels.split() or LEVELS
    ]
    return b"[" + b"".join(b"\\x%02x" % one for one in each) + b"]"


EXPRESSIONS = {
    "exact": cells("right", "mid") + cells("r_forward", "high") + cells("place", "high"),
    "classes": cells("right r_forward", "mid high") + cells("", "") + b"?" + cells("place", ""),
    "gap": cells("right", "mid") + cells("", "") + b"{0,3}" + cells("place", "high"),
}


class Ours:
    """The engine."""

    def __init__(self, roster: Roster, columns: Columns) -> None:
        self.roster, self.columns = roster, columns

    def frames(self, name: str) -> tuple:
        search = Finder(parse(PATTERNS[name]), self.roster, {"r_arm": self.columns}, nothing)
        begun = time.process_time()
        found = search.find("all")
        return time.process_time() - begun, (found.place, found.high)


class Hyperscan:
    """hyperscan, through its Python binding: it calls a function for each match."""

    def __init__(self, columns: Columns) -> None:
        import hyperscan

        captures = len(columns.bounds) - 1
        text = np.full(len(columns) + captures, BETWEEN, np.uint8)
        counts = np.diff(columns.bounds)
        text[np.arange(len(columns)) + np.repeat(np.arange(captures), counts)] = columns.cell & CELL
        self.text, self.stop = text.tobytes(), columns.stop
        self.ends = columns.bounds + np.arange(captures + 1)
        self.databases = {}
        for name, expression in EXPRESSIONS.items():
            self.databases[name] = hyperscan.Database()
            flags = [hyperscan.HS_FLAG_DOTALL]
            self.databases[name].compile(expressions=[expression], ids=[0], elements=1, flags=flags)

    def frames(self, name: str) -> tuple:
        begun = time.process_time()
        found: list[int] = []
        told = found.append
        self.databases[name].scan(
            self.text, match_event_handler=lambda number, low, high, flags, context: told(high)
        )
        last = np.array(found, np.int64) - 1
        capture = np.searchsorted(self.ends, last, "right") - 1
        high = self.stop[last - capture]
        return time.process_time() - begun, (capture, high)


def nothing(places, parts) -> list:
    return []


def ends(capture, high) -> set[tuple[int, int]]:
    return set(zip(capture.tolist(), high.tolist(), strict=True))


def in_turn(peers: dict[str, Callable], name: str) -> dict[str, tuple]:
    """Return the median milliseconds of each, and its answer."""
    spent: dict[str, list[float]] = {peer: [] for peer in peers}
    answers = {}
    for _ in range(ROUNDS + 1):
        for peer, ask in peers.items():
            seconds, answers[peer] = ask(name)
            spent[peer].append(seconds)
    return {peer: (median(times[1:]) * 1e3, answers[peer]) for peer, times in spent.items()}


def one_part_told(captures: int) -> None:
    roster, columns = one_part(captures)
    print(f"one part, {len(columns) / 1e6:.1f} M symbols", flush=True)
    peers = {"ours": Ours(roster, columns)}
    if importlib.util.find_spec("hyperscan"):
        peers["hyperscan"] = Hyperscan(columns)
    else:
        print("  hyperscan is not installed: left out")
    for name in PATTERNS:
        full = in_turn({peer: it.frames for peer, it in peers.items()}, name)
        told = {peer: ends(*answer) for peer, (_, answer) in full.items()}
        hits = len(full["ours"][1][0])
        for peer in peers:
            print(f"  {name:8} {peer:10} {full[peer][0]:8.2f} ms  {hits} hits")
        if not told["ours"] <= told.get("hyperscan", told["ours"]):
            raise SystemExit(f"{name}: the answers differ")


if __name__ == "__main__":
    one_part_told(int((sys.argv[1:] or [CAPTURES])[0]))
