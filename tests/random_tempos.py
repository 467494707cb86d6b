"""Random scores in time to a beat, and how near to it the found tempo comes."""

import random
from fractions import Fraction

from choreography import CELLS, neighbours

from lanindex.alphabet import DIRECTION_CODES, LEVEL_CODES, PLACE
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.symbol import blank

RATE = 60
OCTAVES = (2, 1 / 2, 3, 1 / 3, 3 / 2, 2 / 3, 4, 1 / 4)
NEAR = 0.02


def walked(seed: int, speed: float, count: int = 24) -> Score:
    """Return steps forward, one a beat; of six one in the mean takes two."""
    pick, time, side = random.Random(seed), 2.0, "r"
    spans: dict[str, list[tuple[int, int]]] = {"r": [(0, 0)], "l": [(0, 0)]}
    for _ in range(count):
        begin, time = time, time + 60 / speed * pick.choice((1, 1, 1, 1, 1, 2))
        spans[side].append((round(begin * RATE), round(time * RATE)))
        side = {"r": "l", "l": "r"}[side]
    cells = [(PLACE, 1)] + [(DIRECTION_CODES["forward"], LEVEL_CODES["mid"])] * count
    named = {f"{side}_support": (those, cells) for side, those in spans.items()}
    return _score(named, round((time + 1) * RATE))


def danced(seed: int, speed: float, beats: int = 24) -> Score:
    """Return arms that reach a place on every beat or two, each its own; speed 0: at any time."""
    pick = random.Random(seed)
    named, end = {}, beats * 60 / (speed or 100) + 1
    for part in ("r_arm", "l_arm"):
        spans, cells, time = [(0, 0)], [pick.choice(CELLS)], 0.5
        while time < end:
            length = 60 / speed * pick.choice((1, 1, 1, 2)) if speed else pick.uniform(0.3, 1.5)
            stop = time + length * pick.choice((1, 1, 0.8))
            spans.append((round(time * RATE), round(stop * RATE)))
            cells.append(pick.choice(neighbours(cells[-1])))
            time += length
        named[part] = (spans, cells)
    return _score(named, max(spans[-1][1] for spans, _ in named.values()) + RATE // 2)


def _score(
    named: dict[str, tuple[list[tuple[int, int]], list[tuple[int, int]]]], frames: int
) -> Score:
    tracks = {}
    for part, (spans, cells) in named.items():
        rows = blank(len(spans))
        rows["start"], rows["stop"] = zip(*spans, strict=True)
        rows["direction"], rows["level"] = zip(*cells[: len(spans)], strict=True)
        tracks[part] = Track(part, rows, (Span(0, frames),))
    return Score(Fraction(RATE), frames, Meter(), tracks)


def verdict(found: float, speed: float) -> str:
    """Return whether a tempo is the right one, within 2 %, or a simple multiple of it."""
    if abs(found / speed - 1) <= NEAR:
        return "right"
    return "octave" if any(abs(found / speed / by - 1) <= NEAR for by in OCTAVES) else "wrong"
