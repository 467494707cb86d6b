"""Random scores of palms: forearms turn, arms keep their directions."""

from __future__ import annotations

import random

from lanindex import read_lnd
from lanindex.alphabet import FACING
from lanindex.model import Score

FLAT = ("right", "r_forward", "forward", "l_forward", "left", "l_back", "back", "r_back")

RINGS = {
    "place low": [f"{way} mid" for way in FLAT],
    "forward mid": [
        *("right mid", "right high", "place high", "left high"),
        *("left mid", "left low", "place low", "right low"),
    ],
    "side mid": [
        *("forward mid", "forward high", "place high", "back high"),
        *("back mid", "back low", "place low", "forward low"),
    ],
}
"""By where an arm points, where its palm can face, 45 degrees apart."""


def drawn(seed: int, units: int = 12) -> Score:
    """Return a score in which palms turn now and then, to the next direction or the one before."""
    pick = random.Random(seed)
    begin, moves = [f"#unit_total {units}", "#unit0"], ["#unit1"]
    for part in FACING:
        arm = pick.choice(tuple(RINGS))
        ring = RINGS[arm]
        side = "right" if part[0] == "r" else "left"
        now = pick.randrange(8)
        begin += [f"direction {part[0]}_arm {arm.replace('side', side)} 0 0",
                  f"direction {part} {ring[now]} 0 0"]  # fmt: skip
        time = 8.0  # eighths of a second
        while time < 32 * units - 20:
            length = pick.randrange(3, 11)
            now = (now + pick.choice((-1, 1))) % 8
            moves.append(f"direction {part} {ring[now]} {time / 8} {(time + length) / 8}")
            time += length + pick.randrange(2, 12)
    return read_lnd("\n".join(begin + moves) + "\n")
