"""From runs to rows: which frames each symbol takes.

Source: ``encoding/METHOD.md``, stages 2b, 4 and 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.achieve import Run
from lanindex.encoding.arithmetic import dist
from lanindex.encoding.direction import Space, margins
from lanindex.encoding.segment import Segment
from lanindex.model.symbol import blank

Floats = NDArray[np.float64]

_SHOWN = ("symbol", "passing", "rejoined")
_COPIED = ("start", "stop", "passing", "rule", "swings")


@dataclass(slots=True)
class Row:
    """A symbol in the making; frames from the stretch's first, half-open."""

    cell: int
    start: int
    stop: int
    achieved: int
    rule: int = 0
    passing: bool = False
    swings: int = 0


class Writer:
    """Writes the symbols of one part, move by move.

    `curve` (N, 3) float64, mm.
    """

    def __init__(
        self, curve: Floats, cell: int, around: Space, distance: float, *, lengthen: bool
    ) -> None:
        self.curve, self.around, self.distance, self.lengthen = curve, around, distance, lengthen
        self.rows = [Row(cell, 0, 0, 0)]
        self.in_force = self.rows[0]
        self.idle: list[Segment] = []

    def add(self, move: Segment, runs: list[Run]) -> None:
        """Add a move."""
        shown = [run for run in runs if run.outcome in _SHOWN]
        if not shown:
            self._stay(move)
            return
        cut = start = max(self._begin(move, shown[0].cell), self.in_force.stop)
        end = max(move.end + 1, start)
        for run in shown:
            stop = min(max(run.achieved + 1, cut), end)
            if run.outcome == "passing":
                self.rows.append(Row(run.cell, cut, stop, run.achieved, run.rule, passing=True))
            elif run.outcome == "symbol":
                stop = end if run is runs[-1] else stop
                self.in_force = Row(run.cell, start, stop, run.achieved)
                self.rows.append(self.in_force)
                start = stop
            cut = stop
        self.idle.clear()

    def _stay(self, move: Segment) -> None:
        """Count a move that leaves the symbol in force as it is."""
        if self._way(move) >= self.distance:
            self.in_force.swings += 1
        touches = self.in_force.stop > 0 and move.begin <= self.in_force.stop
        if self.lengthen and touches and self._gain(move, self.in_force.cell) > 0:
            self.in_force.stop = max(self.in_force.stop, move.end + 1)
        else:
            self.idle.append(move)

    def _begin(self, move: Segment, cell: int) -> int:
        """Return where the first symbol begins: perhaps with moves before that had none."""
        begin = move.begin
        for before in reversed(self.idle if self.lengthen else []):
            if before.end + 1 < begin or self._gain(before, cell) < self._way(before) / 2:
                break
            begin = before.begin
        return begin

    def _way(self, move: Segment) -> float:
        """Return how far apart a move's ends are, in mm."""
        return dist(*self.curve[[move.first, move.last]].tolist())

    def _gain(self, move: Segment, cell: int) -> float:
        """Return by how many mm a move comes nearer to the middle of a cell."""
        middle = self.around.reference(cell).tolist()
        before, after = self.curve[[move.first, move.last]].tolist()
        return dist(before, middle) - dist(after, middle)


def table_of(writers: Sequence[Writer], begin: int) -> NDArray[Any]:
    """Return the rows with their margins, part by part.

    `writers` (P) of parts that are known over one stretch; returned (S,) of `model.SYMBOL`, start
    and stop in resampled frames.
    """
    counts = [len(writer.rows) for writer in writers]
    rows = [row for writer in writers for row in writer.rows]
    cells, *copied = np.array(list(map(attrgetter("cell", *_COPIED), rows))).T
    points = [writer.curve[[row.achieved for row in writer.rows]] for writer in writers]
    limb = np.arange(len(writers)).repeat(counts)
    clear, other = margins(np.concatenate(points), cells, [one.around for one in writers], limb)
    table = blank(len(rows))
    table["direction"], table["level"] = np.divmod(cells, 3)
    for name, column in zip(_COPIED, copied, strict=True):
        table[name] = column
    table["start"] += begin
    table["stop"] += begin
    table["margin"] = np.round(clear, 3)
    table["runner_direction"], table["runner_level"] = np.divmod(other, 3)
    return table
