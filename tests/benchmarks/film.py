"""How long films take, how large they are, and how much memory ten minutes of them need.

python tests/benchmarks/film.py
"""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np

import lanindex
from lanindex.film.figure import figure
from lanindex.film.film import FORMS, RATE, RATES, Film
from lanindex.model import Motion, Score

CORPUS = Path(__file__).parents[2] / "corpus"


def danced(seconds: float) -> tuple[Motion, Score]:
    """Return the greetings of the corpus again and again, on a way of five metres to and fro."""
    motion = lanindex.read(CORPUS / "greetings.bvh")
    count = round(seconds * motion.rate)
    places = np.resize(motion.positions, (count, *motion.positions.shape[1:]))
    way = 2500 * np.sin(np.arange(count) / float(motion.rate) / 5)
    places[..., 0] += way[:, None].astype(np.float32)
    motion = replace(motion, positions=places, rotations=None, axes={})
    return motion, lanindex.encode(motion)


def made(motion: Motion, score: Score, form: str) -> tuple[float, float]:
    """Return the seconds that a film takes, and its size in MB."""
    began = time.process_time()
    content = Film(figure(motion), score, rate=RATES.get(form, RATE)).written(form)
    return time.process_time() - began, len(content) / 1e6


def memory(form: str, minutes: float) -> None:
    """Print what one film takes in a process of its own."""
    motion, score = danced(60 * minutes)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    took, size = made(motion, score, form)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{form:5} {minutes:7g} {took:9.1f} {size:9.1f} {before:9.0f} {peak - before:9.0f}")


def main() -> None:
    """Print the tables."""
    print("form  seconds  times real time  MB a minute   (median of three)")
    for seconds in (2, 30):
        motion, score = danced(seconds)
        for form in FORMS:
            made(motion, score, form)
            runs = [made(motion, score, form) for _ in range(3)]
            took = median(run[0] for run in runs)
            print(f"{form:5} {seconds:7} {seconds / took:16.1f} {runs[0][1] * 60 / seconds:12.1f}")
    print("form  minutes   seconds        MB  MB before    MB more")
    for form in FORMS:
        for minutes in ("1", "10"):
            command = [sys.executable, __file__, form, minutes]
            print(
                subprocess.run(command, capture_output=True, text=True, check=True).stdout, end=""
            )


if __name__ == "__main__":
    if len(sys.argv) > 1:
        memory(sys.argv[1], float(sys.argv[2]))
    else:
        main()
