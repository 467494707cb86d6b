"""Stages 4 to 6: the runs that a move passes, which become symbols, and the rows of a table.

Source: ``encoding/METHOD.md``, stages 2b, 4 and 5; Matsumoto and Hachimura (2001), 4.5.3 and 4.6.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import blocks, dist
from lanindex.encoding.direction import CELLS, Course, Space, margins
from lanindex.encoding.segment import Segment
from lanindex.model.symbol import blank
from lanindex.notation.lpd_ldd import Rule


class Run(NamedTuple):
    """Frames in a row that lie in one cell."""

    cell: int  # direction · 3 + level
    start: int  # Resampled frames, half-open
    stop: int
    achieved: int  # The frame at which the cell's direction is achieved
    angle: float  # Degrees from the reference direction there
    apart: float  # Distance from the middle of the cell there, as in `direction.Course`
    # ``symbol``, or why it is none: ``not achieved``, ``in force``, ``joined`` with an equal
    # neighbour, ``passing`` (deleted by a rule), ``rejoined`` with an equal neighbour that a
    # deletion left
    outcome: str = "symbol"
    rule: int = 0  # Line of the rule that deleted it, else 0


def runs(course: Course, moves: Sequence[Segment]) -> Iterator[list[Run]]:
    """Yield the runs of each move, each with the frame that comes nearest to its reference."""
    cells, apart, angle = course.cells, course.apart, course.angle
    changed = np.append(True, cells[1:] != cells[:-1])
    borders = np.flatnonzero(changed)
    changed[[move.first for move in moves]] = True
    starts = np.flatnonzero(changed)
    stops = np.append(starts[1:], len(cells))
    nearest = _nearest(apart, starts, stops)
    # as views: Python's own numbers take four times the memory, and each is wanted once
    fields = [
        np.ascontiguousarray(field).data
        for field in (cells[starts], starts, stops, nearest, angle[nearest], apart[nearest])
    ]
    edges = np.array([move[:2] for move in moves], np.int64).reshape(-1, 2)
    begins = starts.searchsorted(edges[:, 0]).tolist()
    inside, places = (
        borders.searchsorted(edges, side="right").tolist(),
        starts.searchsorted(borders),
    )
    for (first, stop), begin, (_, last, *_) in zip(inside, begins, moves, strict=True):
        chosen = (begin, *places[first:stop].tolist())
        passed = [Run(*[field[index] for field in fields]) for index in chosen]
        end = float(angle[last]), float(apart[last])
        passed[-1] = Run(passed[-1].cell, passed[-1].start, last + 1, last, *end)
        yield passed


def _nearest(
    apart: NDArray[np.float64], starts: NDArray[np.int64], stops: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the frame of each run that is least apart, the first of equals; (R,), by blocks."""
    nearest = np.empty_like(starts)
    for runs, *_ in blocks(len(starts)):
        begin, some = starts[runs][0], starts[runs] - starts[runs][0]
        near = apart[begin : stops[runs][-1]]
        least = np.minimum.reduceat(near, some).repeat(stops[runs] - starts[runs])
        found = np.flatnonzero(near == least)
        nearest[runs] = begin + found[found.searchsorted(some)]
    return nearest


def achieve(found: Sequence[Run], in_force: int, within: float) -> list[Run]:
    """Decide which runs of a move become symbols."""
    result, last = list(found), len(found) - 1
    kept: list[int] = []
    for index, run in enumerate(found):
        if run.angle > within and index < last:
            result[index] = run._replace(outcome="not achieved")
        elif kept and found[kept[-1]].cell == run.cell:
            before = result[kept[-1]]
            if before.apart <= run.apart and index < last:
                result[index] = run._replace(
                    achieved=before.achieved, angle=before.angle, apart=before.apart
                )
            result[kept[-1]] = before._replace(outcome="joined")
            kept[-1] = index
        else:
            kept.append(index)
    if kept and found[kept[0]].cell == in_force:
        result[kept[0]] = result[kept[0]]._replace(outcome="in force")
    return result


class Rules:
    """The rules of a part, ready to be looked up."""

    def __init__(self, rules: Sequence[Rule]) -> None:
        self._by_opening: dict[tuple[int, ...], list[tuple[tuple[int, ...], Rule]]] = {}
        for rule in rules:
            cells = tuple(direction * 3 + level for direction, level in rule.cells)
            self._by_opening.setdefault(cells[:2], []).append((cells, rule))

    @cached_property
    def table(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Which rules begin with each two cells, (27 · 27 + 1,) borders, and all of them, (R, 4).

        Of a rule: how many cells, the third, those that are deleted as bits, and its line.
        """
        pairs = [divmod(number, CELLS) for number in range(CELLS * CELLS)]
        those = [self._by_opening.get(pair, []) for pair in pairs]
        rows = [
            (
                len(cells),
                cells[-1],
                sum(gone << place for place, gone in enumerate(rule.deleted)),
                rule.line,
            )
            for some in those
            for cells, rule in some
        ]
        borders = np.cumsum([0, *map(len, those)], dtype=np.int64)
        return borders, np.array(rows, np.int64).reshape(-1, 4)

    def first_match(self, cells: Sequence[int]) -> tuple[int, Rule] | None:
        """Return where the first rule applies, and which; the ends are never deleted."""
        for start, opening in enumerate(pairwise(cells)):
            for wanted, rule in self._by_opening.get(opening, ()):
                stop = start + len(wanted)
                if (
                    tuple(cells[start:stop]) == wanted
                    and not (start == 0 and rule.deleted[0])
                    and not (stop == len(cells) and rule.deleted[-1])
                ):
                    return start, rule
        return None


def apply(runs: Sequence[Run], in_force: int, rules: Rules) -> list[Run]:
    """Mark the symbols that the rules delete as passing, and join equal neighbours."""
    result = list(runs)
    alive = [index for index, run in enumerate(runs) if run.outcome == "symbol"]
    while match := rules.first_match([in_force, *[runs[index].cell for index in alive]]):
        start, rule = match
        gone = [alive[start + place - 1] for place, deleted in enumerate(rule.deleted) if deleted]
        for index in gone:
            result[index] = runs[index]._replace(outcome="passing", rule=rule.line)
        alive = [index for index in alive if index not in gone]
    for before, after in pairwise(alive):
        if runs[before].cell == runs[after].cell:
            result[before] = runs[before]._replace(outcome="rejoined")
    return result


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
