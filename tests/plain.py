"""METHOD's encoding, from joint positions to symbols, as plain loops: the tests' slow twin.

Written from the page alone, one frame after the other, with nothing of `lanindex.encoding` in it:
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

from lanindex.alphabet import ALWAYS, PARTS


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
    for part in parts or ALWAYS:
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
    arm = plain_body.across(joints[PARTS[part].parent], joints[PARTS[part].child])
    if all(vector is None for vector in arm):
        return []
    length = plain_body.length_of(part, joints)
    if length == 0:
        return []
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
    joining = profile.onset > 0
    first = Row(*space.cell(stretch.curve[0]), 0, -1, 0)
    stretch.rows = [first]
    in_force, free, silent = first, 0, []
    for segment in stretch.segments:
        found = plain_symbol.runs(stretch.curve, segment.start, segment.stop, space)
        stretch.runs.append(found)
        kept = plain_symbol.achieved(found, profile.achieved_within)
        if kept[0].cell == in_force.cell:
            kept = kept[1:]
        if kept:
            begins = segment.begins
            if joining:
                begins = earlier(stretch, silent, begins, kept[0].cell, space)
            rows = plain_symbol.rows_of(kept, max(begins, free), segment.ends)
            plain_symbol.apply_rules(in_force.cell, rows, profile.rules[stretch.part])
            stretch.rows += plain_symbol.joined(rows)
            in_force, silent = rows[-1], []
        else:
            ends = (stretch.curve[segment.start], stretch.curve[segment.stop])
            in_force.swings += distance(*ends) >= near
            if joining and goes_on(stretch, segment, in_force, space):
                in_force.ends = max(in_force.ends, segment.ends)
            else:
                silent.append(segment)
        free = in_force.ends + 1
    shown = [row for row in stretch.rows if not row.passing]
    for row, after in zip(shown, [*shown[1:], None], strict=True):
        rest = stretch.curve[row.ends + 1 : after.begins if after else None]
        if rest and not row.swings:
            mean = tuple(math.fsum(axis) / len(rest) for axis in zip(*rest, strict=True))
            row.swings = int(any(distance(point, mean) > near / 2 for point in rest))
    for row in stretch.rows:
        row.margin, row.runner = space.margin(stretch.curve[row.achieved])


def gain(stretch: Stages, segment: Segment, cell: plain_symbol.Cell, space: Space) -> float:
    """Return by how many mm a move comes nearer to the reference of a cell."""
    reference = space.reference(cell)
    before, after = stretch.curve[segment.start], stretch.curve[segment.stop]
    return distance(before, reference) - distance(after, reference)


def goes_on(stretch: Stages, segment: Segment, last: Row, space: Space) -> bool:
    """Return whether a move without a symbol touches the last symbol and goes on with it."""
    is_symbol = last is not stretch.rows[0]
    touches = segment.begins <= last.ends + 1
    return is_symbol and touches and gain(stretch, segment, last.cell, space) > 0


def earlier(
    stretch: Stages, silent: list[Segment], begins: int, cell: plain_symbol.Cell, space: Space
) -> int:
    """Return where a symbol begins: with the moves before it that already head for it."""
    for segment in reversed(silent):
        way = distance(stretch.curve[segment.start], stretch.curve[segment.stop])
        heads = gain(stretch, segment, cell, space) >= 0.5 * way
        if segment.ends + 1 < begins or not heads:
            break
        begins = segment.begins
    return begins


def count_frames(stretch: Stages, step: Fraction) -> None:
    """Give every row its frames of the source: borders rounded up, no symbol left empty."""
    begin, end = stretch.source
    for row in stretch.rows:
        row.start = min(max(math.ceil((stretch.offset + row.begins) * step), begin), end)
        row.stop = min(max(math.ceil((stretch.offset + row.ends + 1) * step), begin), end)
    first, *rows = stretch.rows
    first.start = first.stop = begin
    shown = [row for row in rows if not row.passing]
    while len(shown) > end - begin:
        shown.pop(0).passing = True
    free = begin
    for row in shown:
        row.start = max(row.start, free)
        row.stop = free = max(row.stop, row.start + 1)
    limit = end
    for row in reversed(shown):
        row.stop = min(row.stop, limit)
        row.start = limit = min(row.start, row.stop - 1)
    outer = first
    for row in reversed(rows):
        if not row.passing:
            outer = row
            continue
        row.start = min(max(row.start, outer.start), outer.stop - 1)
        row.stop = min(max(row.stop, row.start + 1), outer.stop)
