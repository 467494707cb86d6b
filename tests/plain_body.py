"""Stages 0 and 1 as plain loops: gaps, lengths, frames at the profile's rate, the body's frame.

A point is a tuple of three floats, or None where it is not known.
"""

import itertools
import math
from fractions import Fraction
from statistics import median

from lanindex.alphabet import JOINTS, PARTS

Vector = tuple[float, float, float]
Points = list[Vector | None]

LONGEST_GAP = Fraction(1, 5)
SHORTEST_HIPS = 1.0


def less(one: Vector, other: Vector) -> Vector:
    return (one[0] - other[0], one[1] - other[1], one[2] - other[2])


def distance(one: Vector, other: Vector) -> float:
    x, y, z = less(one, other)
    return math.sqrt(x * x + y * y + z * z)


def stretches(points: Points) -> list[tuple[int, int]]:
    """Return first and last frame of every run of known points."""
    found: list[tuple[int, int]] = []
    for frame, point in enumerate(points):
        if point is None:
            continue
        if found and found[-1][1] == frame - 1:
            found[-1] = (found[-1][0], frame)
        else:
            found.append((frame, frame))
    return found


def filled(points: Points, rate: Fraction) -> Points:
    """Return the points with straight lines across every gap of at most 0.2 s."""
    result = list(points)
    known = stretches(points)
    for (_, before), (after, _) in itertools.pairwise(known):
        if Fraction(after - before - 1) / rate > LONGEST_GAP:
            continue
        first, last = points[before], points[after]
        assert first is not None
        assert last is not None
        for frame in range(before + 1, after):
            share = (frame - before) / (after - before)
            x, y, z = less(last, first)
            result[frame] = (
                first[0] + share * x,
                first[1] + share * y,
                first[2] + share * z,
            )
    return result


def joints_of(body: list[list[list[float]]], rate: Fraction, first: int) -> dict[str, Points]:
    """Return each joint's points over time: calibration pose replaced, gaps filled."""
    pelvis = JOINTS.index("Pelvis")
    lacks_pelvis = all(math.isnan(sum(frame[pelvis])) for frame in body)
    frames = list(body)
    if first < len(frames):
        frames[:first] = [frames[first]] * first
    joints: dict[str, Points] = {}
    for index, name in enumerate(JOINTS):
        points: Points = []
        for frame in frames:
            x, y, z = frame[index]
            points.append(None if math.isnan(x + y + z) else (x, y, z))
        joints[name] = points
    if lacks_pelvis:
        for frame, (right, left) in enumerate(zip(joints["RHip"], joints["LHip"], strict=True)):
            if right is not None and left is not None:
                x, y, z = (0.5 * (a + b) for a, b in zip(right, left, strict=True))
                joints["Pelvis"][frame] = (x, y, z)
    return {name: filled(points, rate) for name, points in joints.items()}


def across(start: Points, end: Points) -> Points:
    """Return the way from one joint to another, where both are known."""
    return [
        None if one is None or other is None else less(other, one)
        for one, other in zip(start, end, strict=True)
    ]


def length_of(part: str, joints: dict[str, Points]) -> float:
    """Return L, mm: the median over time of the sum of the part's bones."""
    ends = (PARTS[part].parent, PARTS[part].child)
    present = [
        name
        for name in PARTS[part].chain
        if name in ends or any(point is not None for point in joints[name])
    ]
    sums = bone_sums([joints[name] for name in present])
    return median(sums or bone_sums([joints[name] for name in ends]))


def bone_sums(chain: list[Points]) -> list[float]:
    """Return the length of a chain of joints in every frame that knows them all."""
    sums = []
    for points in zip(*chain, strict=True):
        known = [point for point in points if point is not None]
        if len(known) == len(points):
            bones = (distance(a, b) for a, b in itertools.pairwise(known))
            sums.append(sum(bones))
    return sums


def slope(points: list[Vector], frame: int) -> Vector:
    """Return the central difference, one-sided at the ends, per frame."""
    before, after = max(frame - 1, 0), min(frame + 1, len(points) - 1)
    if before == after:
        return (0.0, 0.0, 0.0)
    x, y, z = less(points[after], points[before])
    return (x / (after - before), y / (after - before), z / (after - before))


def between(points: list[Vector], position: Fraction) -> Vector:
    """Return the cubic Hermite curve through the points at a position in frames."""
    frame = math.floor(position)
    if position == frame:
        return points[frame]
    u = float(position - frame)
    here, there = points[frame], points[frame + 1]
    leaving, arriving = slope(points, frame), slope(points, frame + 1)
    x, y, z = (
        (2 * u**3 - 3 * u**2 + 1) * here[axis]
        + (u**3 - 2 * u**2 + u) * leaving[axis]
        + (-2 * u**3 + 3 * u**2) * there[axis]
        + (u**3 - u**2) * arriving[axis]
        for axis in range(3)
    )
    return (x, y, z)


def resampled(points: Points, rate: Fraction, grid: Fraction) -> dict[int, Vector]:
    """Return the points at every frame of the grid that a known stretch covers."""
    found: dict[int, Vector] = {}
    step = rate / grid
    for first, last in stretches(points):
        known = [point for point in points[first : last + 1] if point is not None]
        frame = math.ceil(first / step)
        while frame * step <= last:
            found[frame] = between(known, frame * step - first)
            frame += 1
    return found


def rights(joints: dict[str, Points], rate: Fraction, grid: Fraction) -> list[tuple[float, float]]:
    """Return, per frame of the grid, the unit vector (x, z) from the left hip to the right.

    A body without any hips is turned by its shoulders.
    """
    axis_points = across(joints["LHip"], joints["RHip"])
    if all(point is None for point in axis_points):
        axis_points = across(joints["LShoulder"], joints["RShoulder"])
    frames = math.floor((len(axis_points) - 1) / (rate / grid)) + 1
    known = resampled(axis_points, rate, grid)
    seen: list[tuple[float, float] | None] = []
    for frame in range(frames):
        seen.append(None)
        if frame in known:
            x, _, z = known[frame]
            size = math.sqrt(x * x + z * z)
            if size >= SHORTEST_HIPS:
                seen[frame] = (x / size, z / size)
    last = next((axis for axis in seen if axis is not None), (0.0, 1.0))
    turns = []
    for axis in seen:
        last = last if axis is None else axis
        turns.append(last)
    return turns


def window_of(seconds: float, grid: Fraction) -> int:
    """Return the odd number of frames nearest to a duration."""
    return 2 * max(0, math.floor((seconds * grid - 1) / 2 + 0.5)) + 1


def averaged(points: list[Vector], window: int) -> list[Vector]:
    """Return the centred moving average; at the ends of the frames that exist."""
    half = window // 2
    result = []
    for frame in range(len(points)):
        near = points[max(0, frame - half) : frame + half + 1]
        x, y, z = (sum(point[axis] for point in near) / len(near) for axis in range(3))
        result.append((x, y, z))
    return result


def turned(vector: Vector, right: tuple[float, float]) -> Vector:
    """Return the vector seen from the body: +z its right, +x its front, y up."""
    x, y, z = vector
    return (x * right[1] - z * right[0], y, x * right[0] + z * right[1])
