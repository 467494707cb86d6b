"""Random choreographies, performed and encoded again."""

from fractions import Fraction
from functools import cache

import numpy as np

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.symbol import blank
from lanindex.perform.limbs import FOLDED, direction_vector

FRAMES = 60
"""Frames a second."""

CELLS = [
    (code, level)
    for code in range(len(DIRECTIONS))
    for level in range(len(LEVELS))
    if (code, level) != FOLDED
]


@cache
def neighbours(cell: tuple[int, int]) -> list[tuple[int, int]]:
    """Return the cells whose references are less than 60 degrees away."""
    cosines = {other: float(direction_vector(cell) @ direction_vector(other)) for other in CELLS}
    return [other for other in CELLS if other != cell and cosines[other] > 0.5 + 1e-6]


def choreography(seed: int, parts: tuple[str, ...], moves: int = 8) -> Score:
    """Return a score of METHOD's law: moves of 0.3 to 1.2 s, holds of 0.2 to 1 s."""
    random = np.random.default_rng(seed)
    tracks: dict[str, np.ndarray] = {}
    for part in parts:
        rows = blank(moves + 1)
        cell = CELLS[random.integers(len(CELLS))]
        frame = 0
        for index, row in enumerate(rows):
            if index:
                cell = neighbours(cell)[random.integers(len(neighbours(cell)))]
                row["start"] = frame + round(random.uniform(0.2, 1) * FRAMES)
                row["stop"] = frame = row["start"] + round(random.uniform(0.3, 1.2) * FRAMES)
            row["direction"], row["level"] = cell
        tracks[part] = rows
    frames = max(int(rows["stop"][-1]) for rows in tracks.values()) + FRAMES // 2
    return Score(
        Fraction(FRAMES),
        frames,
        Meter(),
        {part: Track(part, rows, (Span(0, frames),)) for part, rows in tracks.items()},
    )


def shown(score: Score, part: str) -> np.ndarray:
    """Return the rows of a part that a score shows."""
    rows = score.tracks[part].symbols
    return rows[~rows["passing"]]


def spoken(score: Score, part: str) -> list[str]:
    """Return directions and levels, for reading."""
    return [f"{DIRECTIONS[row['direction']]} {LEVELS[row['level']]}" for row in shown(score, part)]
