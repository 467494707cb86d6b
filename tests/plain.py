"""METHOD's encoding, from joint positions to symbols, as plain loops: the tests' slow twin.

Written from the page alone, one frame after the other, with nothing of `lanindex.encode` in it:
where the two differ, one of them misreads the page.
"""

import math
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import plain_body
import plain_segment
import plain_symbol
from plain_body import Vector, distance
from plain_profile import Profile, amount, read_profile
from plain_segment import Segment
from plain_symbol import Row, Run, Space

from lanindex.alphabet import PARTS


@dataclass
class Stages:
    """What every stage made of one known stretch of a part.

    Frames count from `offset`, the stretch's first frame of the grid; `source` are the
    stretch's first source frame and the one after its last.
    """

    part: str
    length: float
    offset: int
    source: tuple[int, int]
    curve: list[Vector]
    speed: list[float] = field(default_factory=list)
    candidates: list[int] = field(default_factory=list)
    holds: list[tuple[int, int]] = field(default_factory=list)
    segments: list[Segment] = field(default_factory=list)
    runs: list[list[Run]] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)


def encode_plain(
    body: Any, rate: Fraction, profile_folder: Path, first: int = 0, parts: Any = None
) -> dict[str, list[dict[str, Any]]]:
    """Return every part's symbols in order; `body` is (T, 20, 3), mm, NaN where unknown."""
    staged = stages_plain(body, rate, profile_folder, first, parts)
    return {
        part: [as_dict(row) for stretch in found for row in stretch.rows]
        for part, found in staged.items()
    }


def as_dict(row: Row) -> dict[str, Any]:
    names = ("direction", "level", "start", "stop", "passing", "rule", "swings", "margin", "runner")
    return {name: getattr(row, name) for name in names}


def stages_plain(
    body: Any, rate: Fraction, profile_folder: Path, first: int = 0, parts: Any = None
) -> dict[str, list[Stages]]:
    """Return every part's known stretches with all that the stages made of them."""
    profile = read_profile(Path(profile_folder))
    joints = plain_body.joints_of(body.tolist(), rate, first)
    turns = plain_body.rights(joints, rate, profile.rate)
    result = {}
    for part in parts or PARTS:
        found = curves(part, joints, turns, rate, profile)
        for stretch in found:
            divide(stretch, profile)
            write_down(stretch, profile)
            count_frames(stretch, rate / profile.rate)
        if found:
            result[part] = found
    return result


def curves(
    part: str,
    joints: dict[str, plain_body.Points],
    turns: list[tuple[float, float]],
    rate: Fraction,
    profile: Profile,
) -> list[Stages]:
    """Return the part's known stretches, with the smoothed way of child around parent."""
    arm: plain_body.Points = []
    for parent, child in zip(joints[PARTS[part].parent], joints[PARTS[part].child], strict=True):
        known = parent is not None and child is not None
        arm.append(plain_body.less(child, parent) if known else None)
    if all(vector is None for vector in arm):
        return []
    length = plain_body.length_of(part, joints)
    vectors = plain_body.resampled(arm, rate, profile.rate)
    window = plain_body.window_of(profile.smoothing, profile.rate)
    found = []
    for begin, end in plain_body.stretches(arm):
        frames = [frame for frame in vectors if begin <= frame * rate / profile.rate <= end]
        if frames:
            seen = [plain_body.turned(vectors[frame], turns[frame]) for frame in frames]
            curve = plain_body.averaged(seen, window)
            found.append(Stages(part, length, frames[0], (begin, end + 1), curve))
    return found


def divide(stretch: Stages, profile: Profile) -> None:
    """Find the candidates, the holds and the moves between them."""
    fast, prominence, still, near = (
        amount(text, stretch.length)
        for text in (
            profile.candidate_speed,
            profile.prominence,
            profile.still,
            profile.distance,
        )
    )
    speed = plain_segment.speeds(stretch.curve, profile.rate)
    stretch.speed = speed
    stretch.candidates = plain_segment.candidates(speed, fast, prominence, still)
    stretch.holds = plain_segment.groups(
        stretch.curve, stretch.candidates, near, profile.path_check
    )
    stretch.segments = plain_segment.segments(speed, stretch.holds, profile.onset, still)


def write_down(stretch: Stages, profile: Profile) -> None:
    """Turn every move into symbols, and the moves without one into swings and times."""
    space = Space(profile.cells[stretch.part], stretch.length)
    near = amount(profile.distance, stretch.length)

    def margin(frame: int) -> tuple[float, plain_symbol.Cell]:
        return space.margin(stretch.curve[frame])

    first = Row(*space.cell(stretch.curve[0]), 0, -1, 0)
    first.margin, first.runner = margin(0)
    in_force = first
    moves: list[list[Row]] = []
    for segment in stretch.segments:
        found = plain_symbol.runs(stretch.curve, segment.start, segment.stop, space)
        stretch.runs.append(found)
        kept = plain_symbol.achieved(found, profile.achieved_within)
        rows = plain_symbol.rows_of(in_force.cell, kept, segment.begins, segment.ends, margin)
        plain_symbol.apply_rules(in_force.cell, rows, profile.rules[stretch.part])
        rows = plain_symbol.joined(rows)
        moves.append(rows)
        ends = (stretch.curve[segment.start], stretch.curve[segment.stop])
        if rows:
            in_force = rows[-1]
        elif distance(*ends) >= near:
            in_force.swings += 1
    if profile.onset > 0:
        join_silent(stretch, moves, space)
    stretch.rows = [first, *(row for rows in moves for row in rows)]


def join_silent(stretch: Stages, moves: list[list[Row]], space: Space) -> None:
    """Give the time of a move without a symbol to a neighbour that goes the same way."""
    taken = lengthen_last(stretch, moves, space)
    following: Row | None = None
    for index in reversed(range(len(moves))):
        segment, rows = stretch.segments[index], moves[index]
        if rows:
            following = rows[0]
        elif following is not None and index not in taken:
            start, stop, aim = (
                stretch.curve[frame] for frame in (segment.begins, segment.ends, following.achieved)
            )
            touches = segment.ends + 1 >= following.begins
            nearer = distance(start, aim) - distance(stop, aim)
            if touches and nearer >= 0.5 * distance(start, stop):
                following.begins = segment.begins


def lengthen_last(stretch: Stages, moves: list[list[Row]], space: Space) -> set[int]:
    """Lengthen symbols by the moves that follow and go on; return the indices of those."""
    taken: set[int] = set()
    last: Row | None = None
    for index, (segment, rows) in enumerate(zip(stretch.segments, moves, strict=True)):
        if rows:
            last = rows[-1]
        elif last is not None and segment.begins <= last.ends + 1:
            before = space.nearness(stretch.curve[last.ends], last.cell)
            after = space.nearness(stretch.curve[segment.ends], last.cell)
            if after < before:
                last.ends = max(last.ends, segment.ends)
                taken.add(index)
    return taken


def count_frames(stretch: Stages, step: Fraction) -> None:
    """Give every row its frames of the source: borders rounded up, none left empty."""
    begin, end = stretch.source
    here = math.ceil(stretch.offset * step)
    first, *rows = stretch.rows
    first.start = first.stop = here
    after = here
    for row in rows:
        starts = math.ceil((stretch.offset + row.begins) * step)
        stops = math.ceil((stretch.offset + row.ends + 1) * step)
        row.start = max(starts, after)
        row.stop = max(stops, row.start + 1)
        after = row.stop
    before = end
    for row in reversed(rows):
        row.stop = min(row.stop, before)
        row.start = max(begin, min(row.start, row.stop - 1))
        before = row.start
    lying: Row | None = None
    for row in rows:
        if row.passing:
            lying = lying or row
        elif lying is not None:
            row.start, lying = min(row.start, lying.start), None
