"""Kinematics as plain loops over frames and joints."""

import math
from collections.abc import Sequence

Matrix = list[list[float]]
IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


def about(axis: int, degrees: float) -> Matrix:
    """Return the turn about a coordinate axis, right-handed."""
    sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    one, other = (axis + 1) % 3, (axis + 2) % 3
    turn = [row[:] for row in IDENTITY]
    turn[one][one] = turn[other][other] = cosine
    turn[other][one], turn[one][other] = sine, -sine
    return turn


def times(left: Matrix, right: Matrix) -> Matrix:
    """Return the product."""
    return [[sum(left[i][k] * right[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def positions(
    parents: Sequence[int],
    offsets: Sequence[Sequence[float]],
    channels: Sequence[Sequence[int]],
    frames: Sequence[Sequence[float]],
    child_first: bool = False,
) -> list[list[list[float]]]:
    """Return where each joint is in each frame."""
    result = []
    for frame in frames:
        values = iter(frame)
        turns: list[Matrix] = []
        places: list[list[float]] = []
        for joint, parent in enumerate(parents):
            shift, own = list(offsets[joint]), IDENTITY
            for code in channels[joint]:
                if code < 3:
                    shift[code] = next(values)
                else:
                    own = times(own, about(code - 3, next(values)))
            if parent < 0:
                turns.append(own)
                places.append(shift)
                continue
            turn, origin = turns[parent], places[parent]
            turns.append(times(own, turn) if child_first else times(turn, own))
            places.append(
                [origin[i] + sum(turn[i][k] * shift[k] for k in range(3)) for i in range(3)]
            )
        result.append(places)
    return result
