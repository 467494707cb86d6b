"""Captures made for the benchmarks: random dances of a standard body, each different."""

from fractions import Fraction
from pathlib import Path

import numpy as np

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.formats import bvh
from lanindex.notation import lnd
from lanindex.perform import perform

PARTS = ("r_arm", "l_arm", "r_leg", "l_leg", "r_forearm", "l_forearm")

CELLS = [
    f"{direction} {level}"
    for direction in DIRECTIONS
    for level in LEVELS
    if (direction, level) != ("place", "mid")  # a bone cannot fold
]


def score(seed: int, seconds: int) -> str:
    """Return a random score as LND: a move of every part each second or so."""
    random = np.random.default_rng(seed)
    lines = ["#speed=60", "#rhythm 4/4", f"#unit_total {seconds // 4}", "#unit0"]
    lines += [f"direction {part} place low 0 0" for part in PARTS]
    for unit in range(1, seconds // 4 + 1):
        lines.append(f"#unit{unit}")
        for part in PARTS:
            for beat in range(4):
                if random.random() < 0.8:
                    word = random.choice(CELLS)
                    stop = beat + random.choice([0.5, 0.75, 1.0])
                    lines.append(f"direction {part} {word} {beat} {stop}")
    return "\n".join(lines) + "\n"


def captures(folder: Path, count: int, seconds: int = 60, rate: int = 60) -> list[Path]:
    """Write `count` different captures of `seconds` each and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for seed in range(count):
        path = folder / f"dance{seed:03}.bvh"
        text = score(seed, seconds).encode()
        motion = perform(lnd.read(text), rate=Fraction(rate))
        path.write_bytes(bvh.write(motion))
        paths.append(path)
    return paths
