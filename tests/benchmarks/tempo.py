"""Tempi found again: scores in time to a beat, carried out with noise; and real captures.

    python tests/benchmarks/tempo.py [SCORES] [CAPTURES...]

Prints how many tempi of random scores come back within 2 %, how many as a simple multiple, how many
wrong, and how many are refused; how many are found where nothing keeps time; and of each capture
what is found.
"""

import random
import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
sys.path.insert(0, str(Path(__file__).parents[1]))

from random_tempos import RATE, danced, verdict, walked

import lanindex
from lanindex.encoding.timing import estimated
from lanindex.errors import LanindexError
from lanindex.model import Motion
from lanindex.perform import perform

PROFILE = lanindex.load_profile()


def found(motion: Motion):
    rows = {name: track.symbols for name, track in lanindex.encode(motion).tracks.items()}
    return estimated(motion, PROFILE, rows)


def drawn(name: str, score, speed: float, seed: int) -> str:
    tempo = found(perform(score, rate=RATE, noise=2.0, seed=seed))
    if tempo is None or not tempo.clear:
        return "refused"
    return verdict(float(tempo.speed), speed) if speed else "found"


def main() -> int:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    for name, make in {"steps": walked, "limbs": danced, "to no beat": danced}.items():
        tally: Counter[str] = Counter()
        for seed in range(count):
            speed = 0.0 if name == "to no beat" else random.Random(seed + 5000).uniform(60, 150)
            tally[drawn(name, make(seed, speed), speed, seed)] += 1
        print(f"{name:12} {count} scores: {dict(tally)}")
    for path in sys.argv[2:]:
        try:
            tempo = found(lanindex.read(path))
        except LanindexError as error:
            tempo = error
        print(f"{path[-60:]:60} {tempo}{'' if getattr(tempo, 'clear', False) else ' -'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
