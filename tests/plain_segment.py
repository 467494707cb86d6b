"""Stages 2 and 2b as plain loops: candidates, holds, motion segments, and when a move begins."""

import itertools
import math
from dataclasses import dataclass
from fractions import Fraction
from statistics import median

from plain_body import Vector, distance, less

SHORTEST_HOLD = 6


@dataclass
class Segment:
    """A move from one hold to the next, in frames of the grid, both ends included."""

    start: int
    stop: int
    begins: int
    ends: int


def speeds(curve: list[Vector], rate: Fraction) -> list[float]:
    """Return the child's speed in mm a second: central difference, one-sided at the ends."""
    result = []
    for frame in range(len(curve)):
        before, after = max(frame - 1, 0), min(frame + 1, len(curve) - 1)
        x, y, z = less(curve[after], curve[before])
        way = math.sqrt(x * x + y * y + z * z)
        result.append(way / (after - before) * float(rate) if after > before else 0.0)
    return result


def _rim(speed: list[float], start: int, step: int, lowest: float) -> float:
    """Return the highest speed on one side before a lower one; outside is infinitely high."""
    rim = lowest
    frame = start
    while 0 <= frame < len(speed):
        if speed[frame] < lowest:
            return rim
        rim = max(rim, speed[frame])
        frame += step
    return math.inf


def candidates(speed: list[float], highest: float, prominence: float, still: float) -> list[int]:
    """Return the frames at which the movement may be divided."""
    level = [max(value, still) for value in speed]
    found = {0, len(speed) - 1}
    first = 0
    while first < len(level):
        last = first
        while last + 1 < len(level) and level[last + 1] == level[first]:
            last += 1
        lowest = level[first]
        rim = min(_rim(level, first - 1, -1, lowest), _rim(level, last + 1, 1, lowest))
        above_left = first == 0 or level[first - 1] > lowest
        above_right = last == len(level) - 1 or level[last + 1] > lowest
        minimum = above_left and above_right and lowest <= highest and rim - lowest >= prominence
        if lowest <= still or minimum:
            found |= {first, last}
        first = last + 1
    return sorted(found)


def groups(
    curve: list[Vector], divided: list[int], near: float, path_check: float
) -> list[tuple[int, int]]:
    """Return the first and the last candidate of every hold."""
    found: list[tuple[int, int]] = []
    for candidate in divided:
        joins = False
        if found:
            first, last = found[-1]
            joins = distance(curve[candidate], curve[first]) <= near
            if path_check > 0:
                for frame in range(last, candidate + 1):
                    if distance(curve[frame], curve[first]) > path_check * near:
                        joins = False
        if joins:
            found[-1] = (found[-1][0], candidate)
        else:
            found.append((candidate, candidate))
    return found


def _calm(speed: list[float], hold: tuple[int, int], peak: float, onset: float, still: float):
    """Return the speed at which a move is no longer told from the hold beside it."""
    calm = max(onset * peak, still)
    first, last = hold
    if last - first + 1 >= SHORTEST_HOLD:
        calm = max(calm, median(speed[first : last + 1]))
    return calm


def segments(
    speed: list[float], holds: list[tuple[int, int]], onset: float, still: float
) -> list[Segment]:
    """Return the moves between the holds, with the frames at which they begin and end."""
    found = []
    for before, after in itertools.pairwise(holds):
        segment = Segment(before[1], after[0], before[1], after[0])
        found.append(segment)
        if onset == 0:
            continue
        peak = max(speed[segment.start : segment.stop + 1])
        fast = [
            frame for frame in range(segment.start, segment.stop + 1) if speed[frame] >= 0.25 * peak
        ]
        calm = _calm(speed, before, peak, onset, still)
        segment.begins = fast[0]
        while segment.begins > before[0] and speed[segment.begins] > calm:
            segment.begins -= 1
        calm = _calm(speed, after, peak, onset, still)
        segment.ends = fast[-1]
        while segment.ends < after[1] and speed[segment.ends] > calm:
            segment.ends += 1
    return found
