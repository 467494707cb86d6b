"""Stage 4: what a move passes through, and where each direction is achieved.

Source: METHOD, stage 4; the paper, 4.5.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lanindex.encode.direction import Course


@dataclass(slots=True)
class Run:
    """Frames in a row that lie in one cell.

    Attributes
    ----------
    cell : int
        direction · 3 + level.
    start, stop : int
        Resampled frames, half-open.
    achieved : int
        The frame at which the cell's direction is achieved.
    angle : float
        Degrees from the reference direction there.
    apart : float
        Distance from the middle of the cell there, as in `direction.Course`.
    outcome : str
        ``symbol``, or why it is none: ``not achieved``, ``in force``, ``joined`` with an equal
        neighbour, ``passing`` (deleted by a rule), ``rejoined`` with an equal neighbour that a
        deletion left.
    rule : int
        Line of the rule that deleted it, else 0.
    """

    cell: int
    start: int
    stop: int
    achieved: int
    angle: float
    apart: float
    outcome: str = "symbol"
    rule: int = 0


def runs(course: Course, first: int, last: int) -> list[Run]:
    """Return the runs of a move, each with the frame that comes nearest to its reference.

    Parameters
    ----------
    course : Course
        The cells of the whole stretch.
    first, last : int
        The move's frames, both included.

    Returns
    -------
    list of Run
        In order of time; the last is achieved at the move's end.
    """
    codes = course.cells[first : last + 1]
    edges = (np.flatnonzero(codes[1:] != codes[:-1]) + first + 1).tolist()
    found = []
    for start, stop in pairwise([first, *edges, last + 1]):
        achieved = start + int(course.apart[start:stop].argmin()) if stop <= last else last
        angle = float(course.angle[achieved])
        apart = float(course.apart[achieved])
        found.append(Run(int(course.cells[start]), start, stop, achieved, angle, apart))
    return found


def achieve(found: Sequence[Run], in_force: int, within: float) -> None:
    """Decide which runs of a move become symbols, and tell each its outcome.

    A run that is joined with a later one hands it its nearest frame if that comes nearer.

    Parameters
    ----------
    found : sequence of Run
        All of the move, in order.
    in_force : int
        The cell of the last symbol before.
    within : float
        Degrees: runs but the last that come no nearer to their reference are dropped.
    """
    kept: list[Run] = []
    for run in found:
        if run.angle > within and run is not found[-1]:
            run.outcome = "not achieved"
        elif kept and kept[-1].cell == run.cell:
            before = kept[-1]
            if before.apart <= run.apart and run is not found[-1]:
                run.achieved, run.angle, run.apart = before.achieved, before.angle, before.apart
            before.outcome = "joined"
            kept[-1] = run
        else:
            kept.append(run)
    if kept and kept[0].cell == in_force:
        kept[0].outcome = "in force"
