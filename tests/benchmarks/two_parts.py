"""Two parts at once, beside DuckDB: ``python tests/benchmarks/two_parts.py [CAPTURES]``.

A line of two movements of one arm while the other one is somewhere. DuckDB, where it is installed,
holds the same columns in tables, one row a symbol, and is asked the same: of each beginning the
frames of the best hit; the answers must be equal. Passing symbols are left out for both. Median
milliseconds of the processor, one thread, all in turn.
"""

import importlib.util
import sys
import time

import numpy as np
import synthetic
from peers import in_turn, nothing

from lanindex.alphabet import DIRECTION_CODES, LEVEL_CODES
from lanindex.model.columns import CELL, PASSING, STARTING, Columns, Roster
from lanindex.search.language import parse
from lanindex.search.match import Finder

CAPTURES = 300_000
PARTS = ("r_arm", "l_arm")

PATTERNS = {
    "rare": ("right mid", "high", "low"),
    "common": ("low", "high", "high"),
}
"""First and second of the right arm, and what the left one does."""


def two_parts(captures: int) -> tuple[Roster, dict[str, Columns]]:
    """Return what both arms do, without passing symbols."""
    roster, every = synthetic.columns(captures, parts=list(PARTS))
    found = {}
    for part, held in every.items():
        kept = held.cell & PASSING == 0
        bounds = np.concatenate(([0], np.cumsum(kept)))[held.bounds]
        names = ("cell", "runner", "margin", "start", "stop")
        rows = {name: getattr(held, name)[kept] for name in names}
        found[part] = Columns(part, bounds, **rows, seen=held.seen)
    return roster, found


class Ours:
    """The engine."""

    def __init__(self, roster: Roster, columns: dict[str, Columns]) -> None:
        self.roster, self.columns = roster, columns

    def ask(self, name: str) -> tuple:
        first, second, beside = PATTERNS[name]
        query = parse(f"r_arm {first} -> {second} with l_arm {beside}")
        begun = time.process_time()
        found = Finder(query, self.roster, self.columns, nothing).find("all")
        return time.process_time() - begun, (found.place, found.low, found.high)


class DuckDB:
    """DuckDB with one thread, its tables in memory."""

    def __init__(self, columns: dict[str, Columns]) -> None:
        import duckdb

        self.base = duckdb.connect()
        self.base.execute("set threads = 1")
        for part, held in columns.items():
            captures = np.arange(len(held.bounds) - 1, dtype=np.int32)
            symbols = {  # found by its name, in the sentence below
                "row": np.arange(len(held), dtype=np.int32),
                "capture": np.repeat(captures, np.diff(held.bounds)),
                "direction": ((held.cell & CELL) & 15).astype(np.int8) - 1,
                "level": ((held.cell & CELL) >> 4).astype(np.int8) - 1,
                "starting": held.cell & STARTING > 0,
                "start": held.start,
                "stop": held.stop,
            }
            self.base.execute(f"create table {part} as select * from symbols")
            assert len(symbols["row"]) == len(held)

    def ask(self, name: str) -> tuple:
        first, second, beside = map(said, ("one", "two", "other"), PATTERNS[name])
        begun = time.process_time()
        found = self.base.execute(f"""
            with pairs as (
                select one.row, one.capture,
                    least(one.start, other.start) low, greatest(two.stop, other.stop) high
                from r_arm one
                join r_arm two on two.row = one.row + 1 and two.capture = one.capture
                join l_arm other on other.capture = one.capture
                    and other.start < two.stop and other.stop > one.start
                where {first} and {second} and {beside}
                    and not two.starting and not other.starting
            )
            select any_value(capture) capture, arg_max(low, low - high * 100000000::bigint) low,
                min(high) high
            from pairs group by row
        """).fetchnumpy()
        spent = time.process_time() - begun
        return spent, tuple(np.asarray(found[it]) for it in ("capture", "low", "high"))


def said(table: str, words: str) -> str:
    """Return as a condition on a table what a pattern says in words."""
    conditions = [
        f"{table}.direction = {DIRECTION_CODES[word]}"
        if word in DIRECTION_CODES
        else f"{table}.level = {LEVEL_CODES[word]}"
        for word in words.split()
    ]
    return " and ".join(conditions)


def main(captures: int = CAPTURES) -> None:
    roster, columns = two_parts(captures)
    print(" + ".join(f"{len(it) / 1e6:.1f} M symbols" for it in columns.values()), flush=True)
    peers = {"ours": Ours(roster, columns).ask}
    if importlib.util.find_spec("duckdb"):
        peers["duckdb"] = DuckDB(columns).ask
    else:
        print("  DuckDB is not installed: left out")
    for name in PATTERNS:
        told = in_turn(peers, name)
        frames = [sorted(zip(*map(list, answer), strict=True)) for _, answer in told.values()]
        for peer, (spent, answer) in told.items():
            print(f"  {name:8} {peer:10} {spent:8.1f} ms  {len(answer[0])} hits")
        if any(it != frames[0] for it in frames):
            raise SystemExit(f"{name}: the answers differ")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
