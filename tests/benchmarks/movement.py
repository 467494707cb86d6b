"""How long statistics of movement take, of more and more symbols.

python tests/benchmarks/movement.py
"""

from __future__ import annotations

import resource
import time
from typing import Any, cast

import numpy as np

from lanindex.library.store import Store
from lanindex.model.columns import STARTING, Columns, Roster
from lanindex.pipeline.movement import USUAL, movement

LENGTH = 150
"""Symbols of a part in a capture."""


class Made:
    """A library that is made up: captures of random symbols."""

    def __init__(self, captures: int) -> None:
        self.captures = captures

    def called(self, name: str, numbers: Any = None) -> dict[int, str]:
        """Return labels, two of them in turn."""
        return {number: "ab"[number % 2] for number in range(1, self.captures + 1)}

    def columns(self, parts: list[str], numbers: list[int]) -> tuple[Roster, dict[str, Columns]]:
        """Return the columns of a part."""
        draws, count = np.random.default_rng(0), self.captures * LENGTH
        start = np.tile(np.arange(LENGTH, dtype=np.int32) * 20, self.captures)
        cell = draws.integers(1, 10, count).astype(np.uint8)
        cell |= draws.integers(1, 4, count).astype(np.uint8) << 4
        cell[::LENGTH] |= STARTING
        columns = Columns(
            parts[0],
            np.arange(self.captures + 1) * LENGTH,
            cell,
            *(np.zeros(count, np.uint8), np.zeros(count, np.uint16)),
            *(start, start + 20, np.empty((0, 3), np.int32)),
        )
        roster = Roster(
            np.array(numbers),
            np.full(self.captures, LENGTH * 20, np.int32),
            np.tile([60, 1], (self.captures, 1)),
            np.tile([60, 1], (self.captures, 1)),
        )
        return roster, {parts[0]: columns}


def main() -> None:
    """Print all."""
    for captures in (67, 667, 6_667, 66_667):
        made = cast(Store, Made(captures))
        spare = time.process_time()
        for part in USUAL:
            made.columns([part], range(captures))
        spare = time.process_time() - spare
        began = time.process_time()
        found = movement(made.store, None, by="label")
        spent = time.process_time() - began - spare
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        told = sum(one.matters for one in found.differences)
        print(f"{captures * LENGTH * len(USUAL):10,} symbols, {captures:6,} captures:", end=" ")
        print(f"{spent:5.2f} s, {told} of {len(found.differences)} told, peak {peak} MB")


if __name__ == "__main__":
    main()
