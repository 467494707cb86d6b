"""From channels to places, joint by joint, all frames at once.

Sine and cosine are spelt out, so that every machine, and `kinematics_fast`, gives the same bits.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex import compiled
from lanindex.body.recognition import above

Array = NDArray[np.float64]

_BLOCK = 512
SINE = tuple((-1.0) ** k / math.factorial(2 * k + 1) for k in range(7, -1, -1))
COSINE = tuple((-1.0) ** k / math.factorial(2 * k) for k in range(8, -1, -1))
"""Taylor's coefficients, highest power first: below 45 degrees the rest is under 1e-16."""
RADIANS = math.pi / 180.0


class Plan(NamedTuple):
    """What has to be done for each joint, as flat tables."""

    parents: NDArray[np.int64]  # (J,) int64, -1 for a root
    offsets: Array  # (J, 3) float64
    # (J, 3) int64, the column that replaces each coordinate of the offset, -1: none
    places: NDArray[np.int64]
    # (J + 1,) int64: joint j turns by rows ``turns[j]`` to ``turns[j + 1]`` of the next two
    turns: NDArray[np.int64]
    axes: NDArray[np.int64]  # (R,) int64, axis 0 to 2 and column of each turn, in file order
    columns: NDArray[np.int64]
    child_first: bool  # A joint's turn stands before its parent's, not behind it


def plan(
    parents: Sequence[int],
    offsets: Sequence[Sequence[float]],
    channels: Sequence[Sequence[int]],
    child_first: bool = False,
) -> Plan:
    """Return the plan of a hierarchy; joints whose rotation moves nothing do not rotate.

    `parents` (J) parents before children, -1 for a root; `offsets` (J, 3) from the parent;
    `channels` (J) codes in file order: below 3 a coordinate, else 3 + the axis of a rotation.
    """
    matters = [False] * len(parents)
    for joint in range(len(parents) - 1, -1, -1):
        moves = any(offsets[joint]) or any(code < 3 for code in channels[joint])
        if parents[joint] >= 0 and (moves or matters[joint]):
            matters[parents[joint]] = True
    places = np.full((len(parents), 3), -1, np.int64)
    turns, axes, columns = [0], list[int](), list[int]()
    column = 0
    for joint, codes in enumerate(channels):
        for code in codes:
            if code < 3:
                places[joint, code] = column
            elif matters[joint]:
                axes.append(code - 3)
                columns.append(column)
            column += 1
        turns.append(len(axes))
    return Plan(
        np.array(parents, np.int64),
        np.array(offsets, np.float64).reshape(-1, 3),
        places,
        np.array(turns, np.int64),
        np.array(axes, np.int64),
        np.array(columns, np.int64),
        child_first,
    )


def aimed(work: Plan, channels: Sequence[Sequence[int]], joint: int, axes: Array) -> Plan:
    """Return the plan for vectors `axes` (K, 3) at rest that turn with one joint."""
    chain = above(work.parents.tolist(), joint)[::-1]
    begins = np.cumsum([0, *map(len, channels)]).tolist()
    turns = [
        [(code - 3, begins[one] + place) for place, code in enumerate(channels[one]) if code >= 3]
        for one in chain
    ]
    count, many = len(chain), len(axes)
    about = np.array([turn for those in turns for turn in those], np.int64).reshape(-1, 2)
    return Plan(
        np.array([*range(-1, count - 1), *[count - 1] * many], np.int64),
        np.concatenate((np.zeros((count, 3)), axes)),
        np.full((count + many, 3), -1, np.int64),
        np.cumsum([0, *map(len, turns), *[0] * many], dtype=np.int64),
        np.ascontiguousarray(about[:, 0]),
        np.ascontiguousarray(about[:, 1]),
        work.child_first,
    )


def sine_cosine(degrees: Array) -> tuple[Array, Array]:
    """Return sine and cosine of angles."""
    quarter = np.rint(degrees / 90.0)
    rest = (degrees - 90.0 * quarter) * RADIANS
    square = rest * rest
    sine, cosine = np.full_like(rest, SINE[0]), np.full_like(rest, COSINE[0])
    for term in SINE[1:]:
        sine *= square
        sine += term
    for term in COSINE[1:]:
        cosine *= square
        cosine += term
    sine *= rest
    quarter -= 4.0 * np.floor(quarter * 0.25)
    odd = (quarter == 1.0) | (quarter == 3.0)
    return (
        np.where(odd, cosine, sine) * np.where(quarter >= 2.0, -1.0, 1.0),
        np.where(odd, sine, cosine) * np.where((quarter == 1.0) | (quarter == 2.0), -1.0, 1.0),
    )


def positions(work: Plan, values: Array) -> Array:
    """Return the positions (T, J, 3) of `values` (T, C), in units of the file and degrees."""
    if compiled.chosen("numbers", 0):
        from lanindex.body import kinematics_fast

        return kinematics_fast.positions(work, values)
    places = np.empty((len(values), len(work.parents), 3))
    for start in range(0, len(values), _BLOCK):
        part = slice(start, start + _BLOCK)
        _block(work, np.ascontiguousarray(values[part].T), places[part])
    return places


def _block(work: Plan, values: Array, places: Array) -> None:
    """Do `positions` for a few frames: `values` are (C, T), `places` (T, J, 3)."""
    sines, cosines = sine_cosine(values[work.columns])
    if work.child_first:
        np.negative(sines, out=sines)
    frames = values.shape[1]
    # turned[j][a] is column a of joint j's turn (row a where children turn first), (3, T)
    turned: list[Array] = []
    placed = np.empty((len(work.parents), 3, frames))
    identity = np.repeat(np.eye(3)[:, :, None], frames, axis=2)
    tables = (work.parents, work.offsets, work.places, work.turns[:-1], work.turns[1:])
    rows = zip(*(table.tolist() for table in tables), strict=True)
    for joint, (parent, offset, columns, first, stop) in enumerate(rows):
        shift = [
            values[column] if column >= 0 else number
            for column, number in zip(columns, offset, strict=True)
        ]
        base = turned[parent] if parent >= 0 else identity
        if parent < 0:
            for axis in range(3):
                placed[joint, axis] = shift[axis]
        else:
            by_axis = base.swapaxes(0, 1) if work.child_first else base
            moved = by_axis[0] * shift[0]
            moved += by_axis[1] * shift[1]
            moved += by_axis[2] * shift[2]
            np.add(placed[parent], moved, out=placed[joint])
        if first < stop:
            base = base.copy()
            for turn in range(first, stop)[:: -1 if work.child_first else 1]:
                _turn(base, int(work.axes[turn]), sines[turn], cosines[turn])
        turned.append(base)
    places[...] = placed.transpose(2, 0, 1)


def _turn(turn: Array, axis: int, sine: Array, cosine: Array) -> None:
    """Turn three columns from the right, or (with the sine negated) three rows from the left."""
    one, other = turn[axis - 2], turn[axis - 1]
    crossed, back = sine * other, sine * one
    one *= cosine
    one += crossed
    other *= cosine
    other -= back
