"""Random scores of elbows and knees that bend and stretch."""

from __future__ import annotations

import random
from fractions import Fraction

from lanindex.alphabet import BENDS, DEGREES_BENT, DIRECTION_CODES, LEVEL_CODES
from lanindex.encoding.timing import quantise
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.derived import bending, stretching, with_bends
from lanindex.model.symbol import blank

RATE = 60
WAYS = ("forward mid", "right mid", "left mid", "forward low", "forward high", "place low")
"""Where the arms of a drawn score point meanwhile."""


def drawn(seed: int, number: int = 12) -> Score:
    """Return a score in which each arm and leg bends and stretches so often, with rests between.

    Two that go the same way have half a second between; else they were one.
    """
    pick = random.Random(seed)
    rows = {}
    for limb, part in BENDS.items():
        degree, time, found, way = 0, RATE, [(0, 0, bending(0))], None
        for _ in range(number):
            then = pick.choice([it for it in range(6) if it != degree])
            length = pick.randrange(15, 25) * (1 + abs(then - degree) // 2)
            amount = bending(then) if then > degree else stretching(then)
            time += 30 if (then > degree) == way else pick.choice((0, 0, 20, 40))
            found.append((time, time + length, amount))
            degree, time, way = then, time + length, then > degree
        rows[part] = _rows(found, "start", "stop", "amount")
        if limb.endswith("arm"):
            cells = [pick.choice(WAYS).split() for _ in range(3)]
            held = [
                (200 * it, 200 * it + 90 * bool(it), DIRECTION_CODES[way], LEVEL_CODES[level])
                for it, (way, level) in enumerate(cells)
            ]
            rows[limb] = _rows(held, "start", "stop", "direction", "level")
    frames = max(int(own["stop"].max()) for own in rows.values()) + RATE
    meter = quantise(rows.values(), frames, Fraction(RATE), Meter())
    tracks = {part: Track(part, own, (Span(0, frames),)) for part, own in rows.items()}
    return Score(Fraction(RATE), frames, meter, with_bends(tracks))


def _rows(found, *names):
    rows = blank(len(found))
    for row, values in zip(rows, found, strict=True):
        for name, value in zip(names, values, strict=True):
            row[name] = value
    rows["margin"] = 1
    return rows


def said(score: Score, part: str) -> list[str]:
    """Return the bends of a score, without the degree at its beginning."""
    return [DEGREES_BENT[it.amount] for it in score.symbols(part) if it.start < it.stop]
