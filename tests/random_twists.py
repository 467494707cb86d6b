"""Random scores of twists and inclines of trunk and head."""

from __future__ import annotations

import random

from lanindex import read_lnd
from lanindex.alphabet import DIRECTIONS, kind_of
from lanindex.model import Score

TURNED = ("torso_twist", "head_turn", "torso_incline", "head_incline")
DEGREES = {"torso_twist": (40, 75), "head_turn": (40, 80), "torso_incline": (20, 50),
           "head_incline": (20, 40)}  # fmt: skip
"""From how many degrees to how many a part goes; a twist of less than 30 is none."""


def drawn(seed: int, units: int = 12) -> Score:
    """Return a score in which every part moves now and then, whatever the others do."""
    pick = random.Random(seed)
    lines = [f"#unit_total {units}", "#unit0"]
    lines += [f"{kind_of(part)} {part} place 0 0 0" for part in TURNED]
    lines.append("#unit1")
    for part in TURNED:
        time, now = 8.0, ("place", 0)  # eighths of a second
        while time < 32 * units - 20:
            way = _way(pick, part, now)
            length = pick.randrange(4, 13)
            lines.append(
                f"{kind_of(part)} {part} {way[0]} {way[1]} {time / 8} {(time + length) / 8}"
            )
            time, now = time + length + pick.randrange(6, 20), way
    return read_lnd("\n".join(lines) + "\n")


def _way(pick: random.Random, part: str, now: tuple[str, int]) -> tuple[str, int]:
    """Return where a part goes next: somewhere else."""
    directions = DIRECTIONS[:8] if kind_of(part) == "incline" else ("left", "right")
    if now[1] and pick.random() < 0.5:
        return "place", 0
    others = [way for way in directions if way != now[0]]
    return pick.choice(others), pick.randrange(*DEGREES[part])
