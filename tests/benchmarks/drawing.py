"""How long a score takes to be drawn, and how large it is: of a minute, and of more symbols.

The last two figures are those of a staff in plain text.

python tests/benchmarks/drawing.py
"""

from __future__ import annotations

import resource
import time
from fractions import Fraction

import numpy as np

import lanindex
from lanindex.draw import draw, svg
from lanindex.draw.text import TextStaff
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.symbol import blank

PARTS = ("r_arm", "l_arm", "r_leg", "l_leg", "head", "torso", "r_support", "l_support")


def random_score(symbols: int) -> Score:
    """Return a score of symbols of 10 to 60 frames, on eight parts."""
    draws, tracks, count = np.random.default_rng(0), {}, symbols // len(PARTS)
    for part in PARTS:
        rows, lengths = blank(count), draws.integers(10, 60, count)
        stops = np.cumsum(lengths)
        rows["start"] = rows["tick"] = stops - lengths
        rows["stop"], rows["ticks"] = stops, lengths
        rows["direction"], rows["level"] = draws.integers(0, 9, count), draws.integers(0, 3, count)
        tracks[part] = Track(part, rows, (Span(0, int(stops[-1])),))
    frames = max(int(track.symbols["stop"][-1]) for track in tracks.values())
    return Score(Fraction(60), frames, Meter(), tracks)


def told(name: str, score: Score) -> None:
    """Print what a score costs."""
    began = time.process_time()
    picture = draw(score, seconds=True)
    text = svg.write(picture)
    spent = time.process_time() - began
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    seconds, symbols = float(score.frames / score.rate), len(picture.groups())
    print(f"{name}: {seconds:.0f} s, {symbols} symbols, {spent * 1000:.0f} ms,", end=" ")
    began = time.process_time()
    rows = sum(1 for _ in TextStaff(score).lines(width=120))
    spent = time.process_time() - began
    print(f"{len(text) / 1000:.0f} kB, peak {peak} MB; {rows} rows of text, {spent * 1000:.0f} ms")


def main() -> None:
    """Print all."""
    for name in ("semaphore", "radio_gymnastics"):
        told(name, lanindex.encode(lanindex.read(f"corpus/{name}.bvh")))
    for symbols in (1_000, 10_000, 100_000):
        told("random", random_score(symbols))


if __name__ == "__main__":
    main()
