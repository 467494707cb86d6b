"""Turn the curves of the parts of one stretch into rows of symbols: stages 2 to 6 of the method.

This module finds the holds of each part, the moves between the holds, the runs of cells that each
move passes (`direction` computes the cells) and the runs that become symbols. `Trace` keeps all
of these for a researcher who asks why a symbol was written.

Source: ``encoding/METHOD.md``, stages 2, 2b, 4, 5 and 6; Matsumoto and Hachimura (2001), 4.3, 4.4,
4.5.3 and 4.6.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.encoding.arithmetic import blocks, dist, median, parted, sizes
from lanindex.encoding.direction import Course, Space, course, margins, space
from lanindex.encoding.limbs import Limbs
from lanindex.encoding.measures import measure
from lanindex.encoding.profile import Profile, Rules
from lanindex.encoding.timing import to_source
from lanindex.model import Span
from lanindex.model.symbol import blank, joined

Floats = NDArray[np.float64]

LONG_HOLD = 6
"""Frames: the noise of a hold, which tells where moves begin, is measured from this length on."""


class Hold(NamedTuple):
    """A stretch of frames in which a part stays near one point, from one candidate to another."""

    first: int  # Resampled frames, both included
    last: int


class Segment(NamedTuple):
    """A move between two holds."""

    # Resampled frames, both included: the last of the hold before, the first of the one after
    first: int
    last: int
    begin: int  # The frames at which the move visibly begins and ends (stage 2b), both included
    end: int


def speeds(curve: Floats, rate: float) -> Floats:
    """Return the speeds (..., N), mm/s, of curves (..., N, 3) mm: central differences."""
    if curve.shape[-2] < 2:
        return np.zeros(curve.shape[:-1])
    speed = np.empty(curve.shape[:-1])
    for part in blocks(curve.shape[-2], 1):
        slope = np.gradient(curve[..., part.outer, :], axis=-2)
        speed[..., part.inner] = sizes(slope[..., part.within, :] * rate)
    return speed


def candidates(speed: Floats, slow: float, prominence: float, still: float) -> NDArray[np.int64]:
    """Return the frames at which the limb may stop, the first and the last frame among them."""
    level = np.maximum(speed, still)
    borders = np.ones(len(level) + 1, bool)
    borders[1:-1] = level[1:] != level[:-1]
    heights = level[borders[:-1]]
    del level  # in a long capture it would take half as much memory again
    rises = np.ones(len(heights) + 1, bool)
    rises[0] = False
    rises[1:-1] = heights[1:] > heights[:-1]
    lowest = np.flatnonzero((rises[1:] > rises[:-1]) & (heights <= slow))
    deep = _deep(heights, lowest, prominence)
    del heights, rises, lowest
    edges = np.flatnonzero(borders)
    chosen = np.zeros(len(speed), bool)
    chosen[0] = chosen[-1] = chosen[edges[deep]] = chosen[edges[deep + 1] - 1] = True
    return np.flatnonzero(chosen)


def _deep(heights: Floats, lowest: NDArray[np.int64], prominence: float) -> NDArray[np.int64]:
    """Remove minima until a rim of `prominence` or more parts each from its lower neighbours."""
    while True:
        depths = heights[lowest]
        rims = np.maximum.reduceat(heights, lowest)[:-1]
        before, after = depths[:-1], depths[1:]
        shallow = np.zeros(len(lowest), bool)
        shallow[:-1] = (before > after) & (rims - before < prominence)
        shallow[1:] |= (after > before) & (rims - after < prominence)
        if not shallow.any():
            return lowest
        lowest = lowest[~shallow]


def holds(
    curve: Floats, stops: NDArray[np.int64], distance: float, path_check: float
) -> list[Hold]:
    """Return the holds of a curve (N, 3): successive candidates near the first one of each hold."""
    limit = path_check or np.inf
    within = min(distance, limit)
    found: list[Hold] = []
    first, last, origin = 0, 0, curve[0].tolist()
    for stop in stops[1:].tolist():
        point = curve[stop].tolist()
        near = dist(point, origin) <= within
        if near and path_check:
            near = sizes(curve[last:stop] - curve[first]).max() <= limit
        if not near:
            found.append(Hold(first, last))
            first, origin = stop, point
        last = stop
    return [*found, Hold(first, last)]


def segments(speed: Floats, stops: Sequence[Hold], onset: float, still: float) -> list[Segment]:
    """Return the moves between the holds, with the frames at which they visibly begin and end."""
    if not onset:
        return [Segment(a.last, b.first, a.last, b.first) for a, b in pairwise(stops)]
    noise = [
        max(still, median(speed[first : last + 1])) if last - first + 1 >= LONG_HOLD else still
        for first, last in stops
    ]
    values = speed.data  # a list of Python numbers would take four times the memory
    found = []
    for (before, after), (quiet, calm) in zip(pairwise(stops), pairwise(noise), strict=True):
        first, last = before.last, after.first
        peak = max(values[first : last + 1])
        fast, slow = peak / 4, onset * peak
        begin = onset_frame(values, before.first, first, last, 1, fast, max(slow, quiet))
        end = onset_frame(values, after.last, last, first, -1, fast, max(slow, calm))
        found.append(Segment(first, last, begin, max(begin, end)))
    return found


def onset_frame(
    speed: Any, hold: int, first: int, last: int, step: int, fast: float, slow: float
) -> int:
    """Return the last slow frame before the first fast one of a move, or the hold's far end."""
    frame = first
    while speed[frame] < fast and frame != last:
        frame += step
    while frame != hold and speed[frame] > slow:
        frame -= step
    return frame


class Run(NamedTuple):
    """Consecutive frames that lie in one cell."""

    cell: int  # direction · 3 + level
    start: int  # Resampled frames, half-open
    stop: int
    achieved: int  # The frame at which the cell's direction is achieved
    angle: float  # Degrees from the reference direction there
    apart: float  # Distance from the middle of the cell there, as in `direction.Course`
    # ``symbol``, or the reason why the run makes no symbol: ``not achieved``; ``in force``;
    # ``joined`` with an equal neighbour; ``passing``, deleted by a rule; ``rejoined`` with an equal
    # run that became its neighbour through a deletion
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
    # views, because a list of Python numbers takes four times the memory
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
    """Return the frame of each run with the smallest `apart`, the first of equal ones, (R,)."""
    nearest = np.empty_like(starts)
    for runs, *_ in blocks(len(starts)):
        begin, some = starts[runs][0], starts[runs] - starts[runs][0]
        near = apart[begin : stops[runs][-1]]
        least = np.minimum.reduceat(near, some).repeat(stops[runs] - starts[runs])
        found = np.flatnonzero(near == least)
        nearest[runs] = begin + found[found.searchsorted(some)]
    return nearest


def achieve(found: Sequence[Run], in_force: int, within: float) -> list[Run]:
    """Return the runs of a move, each with its outcome before the rules are applied."""
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


def apply(runs: Sequence[Run], in_force: int, rules: Rules) -> list[Run]:
    """Return the runs with the symbols that a rule deletes marked as passing, and equals joined."""
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


_SHOWN = ("symbol", "passing", "rejoined")


@dataclass(slots=True)
class Row:
    """A symbol that a later move may lengthen; frames are half-open, from the stretch's first."""

    cell: int
    start: int
    stop: int
    achieved: int
    rule: int = 0
    passing: bool = False
    swings: int = 0


_NAMES = [field.name for field in fields(Row)]
_FIELDS = attrgetter(*_NAMES)
ROW = np.dtype([(name, np.int64) for name in _NAMES])
"""`Row` as a record of a table."""


class Writer:
    """Writes the symbols of one part, `curve` (N, 3) mm, move by move."""

    def __init__(
        self, curve: Floats, cell: int, around: Space, distance: float, *, lengthen: bool
    ) -> None:
        self.curve, self.around, self.distance, self.lengthen = curve, around, distance, lengthen
        self.rows = [Row(cell, 0, 0, 0)]
        self.in_force = self.rows[0]
        self.idle: list[Segment] = []

    def add(self, move: Segment, runs: list[Run]) -> None:
        """Add the symbols of a move, or keep a move that has none."""
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
        """Count a move without symbols as a swing; lengthen the symbol in force or keep it."""
        if self._way(move) >= self.distance:
            self.in_force.swings += 1
        touches = self.in_force.stop > 0 and move.begin <= self.in_force.stop
        if self.lengthen and touches and self._gain(move, self.in_force.cell) > 0:
            self.in_force.stop = max(self.in_force.stop, move.end + 1)
        else:
            self.idle.append(move)

    def _begin(self, move: Segment, cell: int) -> int:
        """Return where the first symbol begins: at the first idle move that leads to its cell."""
        begin = move.begin
        for before in reversed(self.idle if self.lengthen else []):
            if before.end + 1 < begin or self._gain(before, cell) < self._way(before) / 2:
                break
            begin = before.begin
        return begin

    def _way(self, move: Segment) -> float:
        """Return the distance between the ends of a move, in mm."""
        return dist(*self.curve[[move.first, move.last]].tolist())

    def _gain(self, move: Segment, cell: int) -> float:
        """Return by how many mm a move approaches the middle of a cell."""
        middle = self.around.reference(cell).tolist()
        before, after = self.curve[[move.first, move.last]].tolist()
        return dist(before, middle) - dist(after, middle)


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """All steps from the curve of one part to its symbols, in resampled frames of one stretch."""

    part: str  # Its name
    known: Span  # The stretch, in source frames
    begin: int  # Number of the stretch's first resampled frame
    curve: Floats  # (N, 3) float64, mm: forward, up, right of the joint that it is measured from
    space: Space  # Length of the part and the cells around the joint
    speed: Floats  # (N,) float64, mm/s
    course: Course  # The cell of each frame, and how near to its middle
    candidates: NDArray[np.int64]  # (C,) int64, frames at which the part may stop
    holds: list[Hold]  # Candidates grouped
    segments: list[Segment]  # The moves between the holds
    runs: list[list[Run]]  # By segment: the runs of cells that the move passes
    rows: NDArray[Any]  # (S,) of `model.SYMBOL`: the result, in source frames

    def __str__(self) -> str:
        """Return the moves and the outcome of each of their runs, a line each."""
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
    """The rows of one part in one stretch."""

    part: str
    known: Span
    rows: NDArray[Any]


def written(limbs: Limbs, profile: Profile, fast: bool = False) -> list[Written]:
    """Return the rows of parts that are known over one stretch."""
    if fast:
        from lanindex.encoding import written_fast

        return written_fast.written(limbs, profile)
    traces = write_limbs(limbs, profile, traced=False)
    return [Written(one.part, one.known, one.rows) for one in traces]


def together(written: Iterable[Written]) -> dict[str, tuple[NDArray[Any], tuple[Span, ...]]]:
    """Return by part, in order of time, the rows, slices of one table, and the known stretches."""
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


def spaces(limbs: Limbs, profile: Profile) -> list[Space]:
    """Return the space around each part."""
    lengths = limbs.lengths.tolist()
    return list(map(space, (profile.ranges[part] for part in limbs.parts), lengths))


def finished(
    table: NDArray[Any],
    counts: Sequence[int],
    limbs: Limbs,
    around: Sequence[Space],
    profile: Profile,
    fast: bool = False,
) -> list[Written]:
    """Return the rows of each part with margins and measures, in source frames.

    `table` (S,) of `ROW`, part by part; `counts` (P) rows of each part; `around` (P) its spaces.
    """
    limb, cells = np.arange(len(counts)).repeat(counts), table["cell"]
    clear, other = margins(limbs.curve[limb, table["achieved"]], cells, around, limb)
    rows = blank(len(table))
    rows["direction"], rows["level"] = np.divmod(cells, 3)
    for name in ("passing", "rule", "swings"):
        rows[name] = table[name]
    rows["start"], rows["stop"] = table["start"] + limbs.begin, table["stop"] + limbs.begin
    rows["margin"] = np.round(clear, 3)
    rows["runner_direction"], rows["runner_level"] = np.divmod(other, 3)
    measure(rows, counts, limbs, profile, fast)
    to_source(rows, counts, [limbs.known] * len(counts), limbs.rate, profile.rate)
    each = zip(limbs.parts, parted(rows, counts), strict=True)
    return [Written(part, limbs.known, of_part) for part, of_part in each]


def write_limbs(limbs: Limbs, profile: Profile, *, traced: bool = True) -> Iterator[Trace]:
    """Yield the trace of each part that is known over one stretch."""
    around = spaces(limbs, profile)
    speed = speeds(limbs.curve, float(profile.rate))
    parts = list(zip(limbs.parts, limbs.curve, around, speed, strict=True))
    moved = [_moves(*part[1:], profile) for part in parts]
    # the cells come last, because the arrays of the stops take as much memory
    if not traced:
        speed = np.empty((len(parts), 0))
        parts = [(*part[:3], none) for part, none in zip(parts, speed, strict=True)]
    passed = course(limbs.curve, around)
    followed = [
        _follow(*part[:3], cells, moves, profile, traced)
        for part, cells, (*_, moves) in zip(parts, passed, moved, strict=True)
    ]
    rows = [_FIELDS(row) for _, writer in followed for row in writer.rows]
    table = np.array(rows, np.int64).view(ROW)[:, 0]
    counts = [len(writer.rows) for _, writer in followed]
    for part, stops, cells, (found, _), (*_, own) in zip(
        parts, moved, passed, followed, finished(table, counts, limbs, around, profile), strict=True
    ):
        yield Trace(part[0], limbs.known, limbs.begin, *part[1:], cells, *stops, found, own)


def _moves(
    curve: Floats, around: Space, speed: Floats, profile: Profile
) -> tuple[NDArray[np.int64], list[Hold], list[Segment]]:
    """Return the candidates, the holds and the moves of a part."""
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
    """Return the runs of each move, if `traced`, and the writer of the symbols."""
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
