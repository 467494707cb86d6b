"""Turn the curves of the parts of one stretch into rows of symbols: stages 2 to 6 of the method.

This module finds the holds of each part, the moves between the holds, the runs of cells that each
move passes (`direction` computes the cells) and the runs that become symbols. `Trace` keeps all
of these for a researcher who asks why a symbol was written.

Source: ``encoding/METHOD.md``, stages 2, 2b, 4, 5 and 6; Matsumoto and Hachimura (2001), 4.3, 4.4,
4.5.3 and 4.6.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.encoding.arithmetic import blocks, dist, dot, median, parted, sizes, slopes
from lanindex.encoding.direction import CELLS, Course, Space, course, margins, space
from lanindex.encoding.limbs import Limbs
from lanindex.encoding.measures import measure
from lanindex.encoding.profile import Profile
from lanindex.encoding.timing import to_source
from lanindex.model import Span
from lanindex.model.columns import ranges
from lanindex.model.symbol import blank, joined

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

RESTING = 1 << 16
"""Frames of rests, of all parts, that are looked at together."""

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
    speed = np.empty(curve.shape[:-1])
    for part in blocks(curve.shape[-2], 1):
        slope = slopes(curve[..., part.outer, :].swapaxes(-1, -2))[..., part.within] * rate
        speed[..., part.inner] = sizes(slope.swapaxes(-1, -2))
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
    before, strays = origin, _strayed(curve, stops) if path_check else np.zeros(len(stops))
    for stop, strayed in zip(stops[1:].tolist(), strays.data, strict=False):
        point = curve[stop].tolist()
        near = dist(point, origin) <= within
        if near and dist(before, origin) + strayed > _SURELY * limit:  # else it is near enough
            near = sizes(curve[last:stop] - curve[first]).max() <= limit
        if not near:
            found.append(Hold(first, last))
            first, origin = stop, point
        last, before = stop, point
    return [*found, Hold(first, last)]


_SURELY = 1 - 1e-9  # of a distance: what rounding leaves


def _strayed(curve: Floats, stops: NDArray[np.int64]) -> Floats:
    """Return how far a curve (N, 3) is at most from each candidate before the next, (C - 1,)."""
    away = np.zeros(max(len(curve) - 1, 1))
    origins = stops[:-1].repeat(np.diff(stops))
    for part in blocks(len(origins)):
        away[part.inner] = sizes(curve[part.inner] - curve[origins[part.inner]])
    return np.maximum.reduceat(away, stops[:-1])


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


OUTCOMES = ("symbol", "passing", "rejoined", "not achieved", "joined", "in force")
"""What becomes of a run: a symbol; passing, deleted by a rule; rejoined with an equal run that
became its neighbour through a deletion; or no symbol, because it is not achieved, is joined with an
equal neighbour, or is in force already."""

_SYMBOL, _PASSING, _REJOINED, _NOT_ACHIEVED, _JOINED, _IN_FORCE = range(len(OUTCOMES))


class Run(NamedTuple):
    """Consecutive frames that lie in one cell."""

    cell: int  # direction · 3 + level
    start: int  # Resampled frames, half-open
    stop: int
    achieved: int  # The frame at which the cell's direction is achieved
    angle: float  # Degrees from the reference direction there
    apart: float  # Distance from the middle of the cell there, as in `direction.Course`
    outcome: str  # Of `OUTCOMES`
    rule: int  # Line of the rule that deleted it, else 0


def runs(course: Course, moves: Sequence[Segment]) -> tuple[Ints, Floats, Floats, Ints]:
    """Return the runs (R, 4) of moves, `apart` and `angle` (R,) of each; how many a move has, (M,).

    A run is its cell, its frames, and the frame that comes nearest to its reference.
    """
    cells = course.cells
    changed = np.append(True, cells[1:] != cells[:-1])
    borders = np.flatnonzero(changed)
    changed[[move.first for move in moves]] = True
    starts = np.flatnonzero(changed)
    stops = np.append(starts[1:], len(cells))
    edges = np.array([move[:2] for move in moves], np.int64).reshape(-1, 2)
    inside = borders.searchsorted(edges, side="right")
    counts = inside[:, 1] - inside[:, 0] + 1
    behind = counts.cumsum()
    begins = behind - counts
    within = np.arange(counts.sum()) + (inside[:, 0] - 1 - begins).repeat(counts)
    chosen = starts.searchsorted(borders)[within]
    chosen[begins] = starts.searchsorted(edges[:, 0])
    nearest = _nearest(course.apart, starts, stops)
    table = np.stack((cells[starts], starts, stops, nearest), axis=1)[chosen]
    table[behind - 1, 2:] = edges[:, 1:] + (1, 0)
    return table, course.apart[table[:, 3]], course.angle[table[:, 3]], counts


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


_FIELDS = ("cell", "start", "stop", "achieved", "rule", "passing", "swings")
ROW = np.dtype([(name, np.int64) for name in _FIELDS])
"""A symbol that a later move may lengthen; frames are half-open, from the stretch's first."""


def _way(curve: Floats, move: Ints) -> float:
    """Return the distance between the ends of a move, in mm."""
    return dist(curve[:, move[0]], curve[:, move[1]])


def _gain(curve: Floats, move: Ints, middle: Floats) -> float:
    """Return by how many mm a move approaches the middle of a cell."""
    return dist(curve[:, move[0]], middle) - dist(curve[:, move[1]], middle)


def achieve(
    cells: Any,
    achieved: Any,
    apart: Any,
    angle: Any,
    in_force: int,
    within: float,
    outcome: Any,
    alive: Ints,
) -> int:
    """Write the outcomes of the runs of a move before rules; return how many are symbols.

    These are listed in `alive`.
    """
    last, many = len(cells) - 1, 0
    for run in range(last + 1):
        outcome[run] = _SYMBOL
        if angle[run] > within and run < last:
            outcome[run] = _NOT_ACHIEVED
            continue
        before = alive[many - 1]
        if many and cells[before] == cells[run]:
            if apart[before] <= apart[run] and run < last:
                achieved[run] = achieved[before]
                apart[run], angle[run] = apart[before], angle[before]
            outcome[before] = _JOINED
            many -= 1
        alive[many] = run
        many += 1
    if many and cells[alive[0]] == in_force:
        outcome[alive[0]] = _IN_FORCE
        many -= 1
        for place in range(many):
            alive[place] = alive[place + 1]
    return many


def apply_rules(
    cells: Any,
    in_force: int,
    alive: Ints,
    many: int,
    openings: Ints,
    rules: Ints,
    outcome: Any,
    deleted: Any,
) -> None:
    """Write which symbols rules delete, and which are joined with an equal neighbour."""
    start = 0
    while start < many:
        before = in_force if start == 0 else cells[alive[start - 1]]
        opening = before * CELLS + cells[alive[start]]
        found = -1
        for rule in range(openings[opening], openings[opening + 1]):
            length, third, gone, _ = rules[rule]
            if start + length > many + 1 or (start == 0 and gone & 1):
                continue
            if start + length == many + 1 and gone >> (length - 1) & 1:
                continue
            if length == 2 or cells[alive[start + 1]] == third:
                found = rule
                break
        if found < 0:
            start += 1
            continue
        length, _, gone, line = rules[found]
        kept = start - 1 if start else 0
        for place in range(0 if start else 1, length):
            run = alive[start + place - 1]
            if gone >> place & 1:
                outcome[run], deleted[run] = _PASSING, line
            else:
                alive[kept] = run
                kept += 1
        rest = many - (start + length - 1)
        for place in range(rest):
            alive[kept + place] = alive[start + length - 1 + place]
        many = kept + rest
        start = max(start - 2, 0)
    for place in range(many - 1):
        if cells[alive[place]] == cells[alive[place + 1]]:
            outcome[alive[place]] = _REJOINED


def symbol_begin(curve: Floats, moves: Ints, move: Ints, idle: Ints, middle: Floats) -> int:
    """Return where the first symbol of a move begins: at the first idle move towards its cell."""
    begin: int = move[2]
    for number in idle[::-1]:
        before = moves[number]
        if before[3] + 1 < begin or _gain(curve, before, middle) < _way(curve, before) / 2:
            break
        begin = before[2]
    return begin


def _put(
    cells: Any,
    achieved: Any,
    outcome: Any,
    deleted: Any,
    start: int,
    end: int,
    rows: Ints,
    many: int,
    now: int,
) -> tuple[int, int]:
    """Write the rows of a move; return how many there are, and which is in force."""
    cut = start
    for run in range(len(cells)):
        if outcome[run] > _REJOINED:
            continue
        stop = min(max(achieved[run] + 1, cut), end)
        if outcome[run] != _REJOINED:
            passing = outcome[run] == _PASSING
            if not passing and run == len(cells) - 1:
                stop = end
            begin = cut if passing else start
            row = (cells[run], begin, stop, achieved[run], deleted[run], int(passing), 0)
            rows[many] = row
            if not passing:
                now, start = many, stop
            many += 1
        cut = stop
    return many, now


def write_rows(
    curve: Floats,
    cell: int,
    moves: Ints,
    cells: Any,
    achieved: Any,
    apart: Any,
    angle: Any,
    outcome: Any,
    deleted: Any,
    within: float,
    distance: float,
    middles: Floats,
    lengthen: bool,
    openings: Ints,
    rules: Ints,
) -> Ints:
    """Return the rows of a part, (S, 7) as of `ROW`, in frames from the stretch's first.

    `curve` (3, N) mm; `moves` (M, 5), a `Segment` and the number of its runs; of all runs, (R,)
    each, arrays or the faster `memoryview` of plain loops: `cells`, the frames in which they are
    `achieved`, and `apart` and `angle` there; `outcome` and the line of the rule by which each is
    `deleted`, zeros, to be written; the rest as from `settings`.
    """
    alive = np.empty(max(1, moves[:, 4].max()) if len(moves) else 1, np.int64)
    idle = np.empty(len(moves), np.int64)
    rows = np.zeros((len(cells) + 1, 7), np.int64)
    rows[0, 0] = cell
    many, now, waiting, behind = 1, 0, 0, 0
    for number in range(len(moves)):
        move, begun, force = moves[number], behind, int(rows[now, 0])
        behind = begun + int(move[4])
        some, there = cells[begun:behind], achieved[begun:behind]
        told, gone = outcome[begun:behind], deleted[begun:behind]
        near, off = apart[begun:behind], angle[begun:behind]
        symbols = achieve(some, there, near, off, force, within, told, alive)
        if symbols == 0:  # count it as a swing; lengthen the symbol in force or keep the move
            rows[now, 6] += _way(curve, move) >= distance
            touches = rows[now, 2] > 0 and move[2] <= rows[now, 2]
            if lengthen and touches and _gain(curve, move, middles[force]) > 0:
                rows[now, 2] = max(rows[now, 2], move[3] + 1)
            else:
                idle[waiting] = number
                waiting += 1
            continue
        first = some[alive[0]]
        apply_rules(some, force, alive, symbols, openings, rules, told, gone)
        earlier = idle[: waiting if lengthen else 0]
        begin = symbol_begin(curve, moves, move, earlier, middles[first])
        waiting, start = 0, int(max(begin, rows[now, 2]))
        end = int(max(move[3] + 1, start))
        many, now = _put(some, there, told, gone, start, end, rows, many, now)
    return rows[:many].copy()


def settings(part: str, around: Space, profile: Profile) -> tuple[Any, ...]:
    """Return what `write_rows` knows of a part beside its movement.

    Degrees within which a run is achieved; d_t, mm; the middles of cells (27, 3) mm; whether moves
    without symbols lengthen others; and the rules, as of `Rules.table`.
    """
    return (
        profile.achieved_within,
        profile.distance.of(around.length),
        around.references * around.length,
        profile.onset > 0,
        *profile.rules[part].table,
    )


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
    rows["passing"], rows["rule"] = table["passing"], table["rule"]
    rows["swings"] = np.maximum(table["swings"], _strays(table, limb, limbs, profile))
    rows["start"], rows["stop"] = table["start"] + limbs.begin, table["stop"] + limbs.begin
    rows["margin"] = np.round(clear, 3)
    rows["runner_direction"], rows["runner_level"] = np.divmod(other, 3)
    measure(rows, counts, limbs, profile, fast)
    to_source(rows, counts, [limbs.known] * len(counts), limbs.rate, profile.rate)
    each = zip(limbs.parts, parted(rows, counts), strict=True)
    return [Written(part, limbs.known, of_part) for part, of_part in each]


def _strays(table: NDArray[Any], limb: Ints, limbs: Limbs, profile: Profile) -> NDArray[np.bool_]:
    """Tell during the rests behind which rows, (S,), a part strays from its mean place there."""
    strays, curves = np.zeros(len(table), bool), limbs.curve.transpose(2, 0, 1)
    rows = np.flatnonzero(table["passing"] == 0)
    begins, ends = table["stop"][rows], np.append(table["start"][rows[1:]], 0)
    ends[np.append(limb[rows[1:]] != limb[rows[:-1]], True)] = curves.shape[2]
    rests = ends > begins
    rows, begins, ends = rows[rests], begins[rests], ends[rests]
    least = np.square([profile.distance.of(length) / 2 for length in limbs.lengths.tolist()])
    groups = -(-int((ends - begins).sum()) // RESTING)
    for some in np.array_split(np.arange(len(rows)), groups) if groups else ():
        bounds, frames = ranges(begins[some], ends[some])
        part, first, counts = limb[rows[some]], bounds[:-1], np.diff(bounds)
        places = curves[:, part.repeat(counts), frames]
        places -= (np.add.reduceat(places, first, axis=1) / counts).repeat(counts, axis=1)
        strays[rows[some]] = np.maximum.reduceat(dot(places, places), first) > least[part]
    return strays


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
    table = np.concatenate([rows for _, rows in followed]).view(ROW)[:, 0]
    counts = [len(rows) for _, rows in followed]
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
) -> tuple[list[list[Run]], Ints]:
    """Return the runs of each move, if `traced`, and the rows of the symbols."""
    table, apart, angle, counts = runs(passed, moves)
    cells, _, _, achieved = columns = table.T.copy()
    outcome, deleted = np.zeros((2, len(table)), np.int64)
    counted = np.column_stack((np.array(moves, np.int64).reshape(-1, 4), counts))
    of_runs: list[Any] = [it.data for it in (cells, achieved, apart, angle, outcome, deleted)]
    told, begin = settings(part, around, profile), int(passed.cells[0])
    rows = write_rows(curve.T, begin, counted, *of_runs, *told)
    if not traced:
        return [], rows
    outcomes = [OUTCOMES[code] for code in outcome.tolist()]
    fields = (*columns.tolist(), angle.tolist(), apart.tolist(), outcomes, deleted.tolist())
    found = iter(map(Run, *fields))
    return [list(islice(found, count)) for count in counts.tolist()], rows
