"""The stages of one part in a row, with everything that a researcher may ask about.

Source: ``encoding/METHOD.md``, stages 2 to 5.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.encoding.arithmetic import parted
from lanindex.encoding.direction import Course, Space, course, space
from lanindex.encoding.limbs import Limbs
from lanindex.encoding.measures import measure
from lanindex.encoding.profile import Profile
from lanindex.encoding.segment import Hold, Segment, candidates, holds, segments, speeds
from lanindex.encoding.symbols import Run, Writer, achieve, apply, runs, table_of
from lanindex.encoding.timing import to_source
from lanindex.model import Span
from lanindex.model.symbol import joined

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """How one part was written down, over one stretch of the capture.

    All frames are resampled ones (60 a second by default), counted from the stretch's first.
    """

    part: str  # Its name
    known: Span  # The stretch, in frames of the source
    begin: int  # Number of the stretch's first resampled frame
    curve: Floats  # (N, 3) float64, mm: forward, up, right of the joint that it is seen from
    space: Space  # Length of the part and the cells around the joint
    speed: Floats  # (N,) float64, mm/s
    course: Course  # The cell of each frame, and how near to its middle
    candidates: NDArray[np.int64]  # (C,) int64, frames at which the part may have stopped
    holds: list[Hold]  # Candidates grouped
    segments: list[Segment]  # The moves between the holds
    runs: list[list[Run]]  # By segment: the cells that the move passes, and what became of each
    rows: NDArray[Any]  # (S,) of `model.SYMBOL`: the result, in frames of the source

    def __str__(self) -> str:
        """Return the moves and what became of each of their runs, a line each."""
        lines = [
            f"{self.part}: length {self.space.length:.0f} mm, {len(self.curve)} frames, "
            f"{len(self.candidates)} candidates, {len(self.segments)} moves"
        ]
        for segment, found in zip(self.segments, self.runs, strict=True):
            lines.append(
                f"  move {segment.first}-{segment.last}, seen {segment.begin}-{segment.end}"
            )
            for run in found:
                name = f"{DIRECTIONS[run.cell // 3]} {LEVELS[run.cell % 3]}"
                rule = f" by the rule of line {run.rule}" if run.rule else ""
                lines.append(
                    f"    {run.start}-{run.stop - 1} {name}: {run.outcome}{rule} "
                    f"({run.angle:.0f} degrees off at {run.achieved})"
                )
        return "\n".join(lines)


class Written(NamedTuple):
    """What stays of a part over one stretch."""

    part: str
    known: Span
    rows: NDArray[Any]


def written(limbs: Limbs, profile: Profile) -> list[Written]:
    """Do `write_limbs` and let go of all that led to the rows."""
    traces = write_limbs(limbs, profile, traced=False)
    return [Written(one.part, one.known, one.rows) for one in traces]


def together(written: Iterable[Written]) -> dict[str, tuple[NDArray[Any], tuple[Span, ...]]]:
    """Return the rows of each part, slices of one table, and the stretches in which it is known.

    Parts come in the order of their first stretches.
    """
    found: dict[str, list[Written]] = {}
    for one in written:
        found.setdefault(one.part, []).append(one)
    ordered = sorted(found.items(), key=lambda it: it[1][0].known)
    table = joined(one.rows for _, those in ordered for one in those)
    parts, first = {}, 0
    for part, those in ordered:
        begin, first = first, first + sum(len(one.rows) for one in those)
        parts[part] = table[begin:first], tuple(one.known for one in those)
    return parts


def write_limbs(limbs: Limbs, profile: Profile, *, traced: bool = True) -> Iterator[Trace]:
    """Write down parts that are known over one stretch."""
    around = [
        space(profile.ranges[part], length)
        for part, length in zip(limbs.parts, limbs.lengths.tolist(), strict=True)
    ]
    speed = speeds(limbs.curve, float(profile.rate))
    parts = list(zip(limbs.parts, limbs.curve, around, speed, strict=True))
    moved = [_moves(*part[1:], profile) for part in parts]
    # the cells come last: what leads to the moves takes as much memory again
    if not traced:
        speed = np.empty((len(parts), 0))
        parts = [(*part[:3], none) for part, none in zip(parts, speed, strict=True)]
    passed = course(limbs.curve, around)
    followed = [
        _follow(*part[:3], cells, moves, profile, traced)
        for part, cells, (*_, moves) in zip(parts, passed, moved, strict=True)
    ]
    counts = [len(writer.rows) for _, writer in followed]
    table = table_of([writer for _, writer in followed], limbs.begin)
    measure(table, counts, limbs, profile)
    to_source(table, counts, [limbs.known] * len(counts), limbs.rate, profile.rate)
    for part, stops, cells, (found, _), rows in zip(
        parts, moved, passed, followed, parted(table, counts), strict=True
    ):
        yield Trace(part[0], limbs.known, limbs.begin, *part[1:], cells, *stops, found, rows)


def _moves(
    curve: Floats, around: Space, speed: Floats, profile: Profile
) -> tuple[NDArray[np.int64], list[Hold], list[Segment]]:
    """Return where a part may have stopped, where it did, and the moves between."""
    length = around.length
    still = profile.still.of(length)
    distance = profile.distance.of(length)
    stops = candidates(
        speed, profile.candidate_speed.of(length), profile.prominence.of(length), still
    )
    grouped = holds(curve, stops, distance, profile.path_check * distance)
    return stops, grouped, segments(speed, grouped, profile.onset, still)


def _follow(
    part: str,
    curve: Floats,
    around: Space,
    passed: Course,
    moves: list[Segment],
    profile: Profile,
    traced: bool,
) -> tuple[list[list[Run]], Writer]:
    """Return what became of the runs of each move, if wanted, and the writer of the symbols."""
    distance = profile.distance.of(around.length)
    writer = Writer(curve, int(passed.cells[0]), around, distance, lengthen=profile.onset > 0)
    found = []
    for move, seen in zip(moves, runs(passed, moves), strict=True):
        cell = writer.in_force.cell
        judged = apply(achieve(seen, cell, profile.achieved_within), cell, profile.rules[part])
        writer.add(move, judged)
        if traced:
            found.append(judged)
    return found, writer
