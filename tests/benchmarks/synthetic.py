"""Libraries of any size for the benchmarks: the real captures, varied.

    python tests/benchmarks/synthetic.py LIBRARY COUNT [SEED]

writes a library with rows and columns. `columns` gives columns alone, as many as memory holds:
400,000 captures are about 60 million symbols. The same seed gives the same captures in both, the
first ones of a larger count being those of a smaller.

Each capture is a real one, seen in a mirror or not, slowed down, turned, some of its parts upside
down, some symbols moved to the next direction, each margin a little off.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from places import CAPTURES

from lanindex.errors import LibraryError
from lanindex.library import store
from lanindex.library.rows import Encoding
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.columns import (
    CELL,
    EXTRA,
    Columns,
    Roster,
    columns_of,
    enrolled,
    joined_columns,
    ranges,
    roster_of,
)
from lanindex.pipeline.library import open_library

BLOCK = 4096
"""Captures that are varied at once; each block has random numbers of its own."""

FLAGS = 0xFF - CELL
MIRRORED = np.array([0, 5, 4, 3, 2, 1, 8, 7, 6, 9, *range(10, 16)], np.uint8)
UPSIDE_DOWN = np.array([0, 3, 2, 1], np.uint8)


@dataclass(frozen=True)
class Real:
    """The real captures, and after them the same in a mirror."""

    roster: Roster
    columns: dict[str, Columns]
    symbols: dict[str, Any]
    names: list[str]


def real() -> Real:
    """Return the real captures, from a library that is kept among temporary files."""
    path = Path(tempfile.gettempdir()) / "lanindex-real-captures.db"
    try:
        library = open_library(path, create=True)
    except LibraryError:  # of another version
        path.unlink()
        library = open_library(path, create=True)
    with library:
        library.ingest(CAPTURES / "bvh")
        held = list(library.tracks())
    captures = [capture for capture, _ in held]
    once = roster_of(captures)
    twice = once.at(np.tile(np.arange(len(once)), 2))
    columns, symbols = {}, {}
    parts = dict.fromkeys(part for _, tracks in held for part in tracks)
    plain = {p: columns_of(p, captures, [tracks.get(p) for _, tracks in held]) for p in parts}
    for part in parts:
        other = mirrored_part(part)
        columns[part] = joined_columns(part, [plain[part], mirrored(plain[other])], [len(once)] * 2)
        symbols[part] = np.concatenate(
            [tracks[one].symbols for one in (part, other) for _, tracks in held if one in tracks]
        )
    return Real(twice, columns, symbols, [Path(one.path).stem for one in captures] * 2)


def mirrored_part(part: str) -> str:
    swapped = {"r_": "l_", "l_": "r_"}.get(part[:2])
    return part if swapped is None else swapped + part[2:]


def mirrored(columns: Columns) -> Columns:
    def cells(array):
        return MIRRORED[array & 15] | array & 0xF0

    return Columns(
        columns.part,
        columns.bounds,
        cells(columns.cell),
        cells(columns.runner),
        columns.margin,
        columns.start,
        columns.stop,
        columns.seen,
        **{name: getattr(columns, name) for name in ("amount", *EXTRA)},
    )


@dataclass(frozen=True)
class Block:
    """Some captures, as they are varied."""

    roster: Roster
    sources: Any
    columns: dict[str, Columns]
    rows: dict[str, Any]
    """By part, which rows of the real captures the symbols were."""


def blocks(found: Real, count: int, seed: int, parts: list[str]) -> Iterator[Block]:
    """Yield captures, numbered from 1."""
    for first in range(0, count, BLOCK):
        size = min(BLOCK, count - first)
        random = np.random.default_rng((seed, first))
        # whatever the count, a block's captures are the same
        sources = random.integers(0, len(found.roster), BLOCK)[:size]
        slower = random.integers(16, 25, BLOCK)[:size]
        turned = np.where(random.random(BLOCK) < 0.6, 0, random.integers(0, 8, BLOCK))[:size]
        plain = found.roster.at(sources)
        roster = Roster(
            np.arange(first + 1, first + 1 + size),
            (plain.frames.astype(np.int64) * slower // 16).astype(np.int32),
            plain.rate,
            plain.speed,
        )
        columns, rows_of = {}, {}
        for place, part in enumerate(found.columns):
            if part in parts:
                own = np.random.default_rng((seed, first, place))
                columns[part], rows_of[part] = varied(
                    found.columns[part], sources, slower, turned, own
                )
        yield Block(roster, sources, columns, rows_of)


def varied(source: Columns, sources, slower, turned, random) -> tuple[Columns, Any]:
    """Return the columns of a part in a block of captures, and which rows they were."""
    bounds, picked = ranges(source.bounds[:-1][sources], source.bounds[1:][sources])
    sizes = np.diff(bounds)
    down = np.repeat(random.random(BLOCK)[: len(sources)] < 0.1, sizes)
    turn = np.repeat(turned, sizes)
    cell, runner = (
        changed(getattr(source, name)[picked], turn, down) for name in ("cell", "runner")
    )
    moved = changed(cell, 1, np.False_)
    alone = random.random(len(cell)) < 0.05
    for step in (1, -1):  # neither the next row nor the last may say the same, or be moved itself
        alone &= ~np.roll(alone, step) & ((np.roll(cell, step) ^ moved) & CELL != 0)
    cell = np.where(alone, moved, cell)
    margin = source.margin[picked].astype(np.int32) + random.integers(-50, 51, len(cell))
    pace = np.repeat(slower, sizes)
    start, stop = (
        (getattr(source, name)[picked] * pace // 16).astype(np.int32) for name in ("start", "stop")
    )
    seen = source.at(sources).seen
    seen = np.column_stack([seen[:, 0], seen[:, 1:] * slower[seen[:, 0], None] // 16])
    margin = margin.clip(0, 1000).astype(np.uint16)
    held = {name: getattr(source, name) for name in ("amount", *EXTRA)}
    more = {name: None if it is None else it[picked] for name, it in held.items()}
    seen = seen.astype(np.int32)
    found = Columns(source.part, bounds, cell, runner, margin, start, stop, seen, **more)
    return found, picked


def changed(cells, turn, down):
    """Return cells with their directions turned, and upside down where they shall be."""
    direction = cells & 15
    around = (direction > 0) & (direction < 9)
    direction = np.where(around, (direction - 1 + turn) % 8 + 1, direction)
    level = cells >> 4 & 3
    level = np.where(down, UPSIDE_DOWN[level], level)
    return (direction | level << 4 | cells & FLAGS).astype(np.uint8)


def columns(
    count: int, seed: int = 0, parts: list[str] | None = None
) -> tuple[Roster, dict[str, Columns]]:
    """Return the roster and the columns of so many captures.

    Parameters
    ----------
    count : int
        How many; 400,000 are about 60 million symbols, 700 MB.
    seed : int
        Another one gives others.
    parts : list of str, optional
        Only these; the symbols of each are the same whichever others are asked for.
    """
    found = real()
    wanted = [part for part in found.columns if parts is None or part in parts]
    made = list(blocks(found, count, seed, wanted))
    rosters = [one.roster for one in made]
    sizes = [len(roster) for roster in rosters]
    whole = {
        part: joined_columns(part, [one.columns.pop(part) for one in made], sizes)
        for part in wanted
    }
    return enrolled(rosters), whole


def library(name: Path | str, count: int, seed: int = 0) -> Path | str:
    """Write a library with rows; with the same columns as `columns` gives."""
    found = real()
    if "://" not in str(name):
        Path(name).unlink(missing_ok=True)
    with open_library(name, create=True) as made:
        for block in blocks(found, count, seed, list(found.columns)):
            with made.store.changing() as connection:
                for place in range(len(block.roster)):
                    put(connection, found, block, place)
            made.store.cache.compact()
    return name


def put(connection, found: Real, block: Block, place: int) -> None:
    """Store a capture as `Library.add` does, in the transaction of a whole block."""
    number, frames = int(block.roster.number[place]), int(block.roster.frames[place])
    tracks = {}
    for part, own in block.columns.items():
        here = slice(own.bounds[place], own.bounds[place + 1])
        if here.start < here.stop:
            symbols = found.symbols[part][block.rows[part][here]]
            symbols["direction"] = (own.cell[here] & 15).astype(np.int8) - 1
            symbols["level"] = (own.cell[here] >> 4 & 3).astype(np.int8) - 1
            symbols["runner_direction"] = (own.runner[here] & 15).astype(np.int8) - 1
            symbols["runner_level"] = (own.runner[here] >> 4 & 3).astype(np.int8) - 1
            symbols["margin"] = own.margin[here] / 1000
            symbols["start"], symbols["stop"] = own.start[here], own.stop[here]
            tracks[part] = Track(part, symbols, (Span(0, frames),))
    rate = Fraction(*block.roster.rate[place].tolist())
    meter = Meter(Fraction(*block.roster.speed[place].tolist()))
    score = Score(rate, frames, meter, tracks)
    name = f"{found.names[block.sources[place]]}/{number:06}.bvh"
    values = {"path": name, "location": f"/synthetic/{name}", "format": "bvh"}
    values |= {"sha256": f"{number:064x}", "warnings": "[]"}
    put_number, new = store.put_capture(connection, values, score, Encoding("default", "d" * 64))
    store.describe(connection, put_number, found.names[block.sources[place]], {}, new)


if __name__ == "__main__":
    library(sys.argv[1], int(sys.argv[2]), int((sys.argv[3:] or ["0"])[0]))
