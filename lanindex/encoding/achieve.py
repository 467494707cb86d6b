"""Stage 4: what a move passes through, and where each direction is achieved.

Source: ``encoding/METHOD.md``, stage 4; Matsumoto and Hachimura (2001), 4.5.3.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import blocks
from lanindex.encoding.direction import Course
from lanindex.encoding.segment import Segment


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
