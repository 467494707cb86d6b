"""Random scores of steps and other supports: kneeling, sitting, lying."""

from __future__ import annotations

import random

from random_steps import RATE, Draft, score_of

from lanindex.alphabet import CARRIERS, DIRECTIONS
from lanindex.model import Score
from lanindex.perform.travel import OTHER, WEIGHT

TRACKS = (OTHER, *WEIGHT)
SHORTEST = {"hand": RATE // 2, "other": RATE * 3 // 4}
"""Frames that one lasts at least; the others a third of a second."""


def drawn(seed: int, number: int = 8) -> Score:
    """Return a score: steps, then something else carries; and steps again, at once or later."""
    pick = random.Random(seed)
    draft = Draft()
    draft.rows[OTHER] = []
    for _ in range(number):
        way, level = pick.choice(DIRECTIONS), pick.choice(("low", "mid", "mid", "high"))
        for _ in range(pick.randrange(4)):
            draft.step(pick, way, level, pick.randrange(30, 54))
        draft.time += pick.randrange(RATE * 2 // 3, 2 * RATE)
        what = pick.choice(CARRIERS)
        least = SHORTEST.get(what, RATE // 3)
        length = pick.choice((pick.randrange(least, RATE), pick.randrange(RATE, 4 * RATE)))
        row = (draft.time, draft.time + length, -1, -1, CARRIERS.index(what))
        draft.rows[OTHER].append(row)
        draft.time += length + pick.choice((0, pick.randrange(RATE * 2 // 3, 2 * RATE)))
    return score_of(draft)
