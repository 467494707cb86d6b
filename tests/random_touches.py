"""Random scores of touches: hands at the head, the trunk, an arm and each other."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

from lanindex import read_lnd
from lanindex.model import Score, Symbol

THINGS = ("head", "trunk", "arm")
RATE = 60
TRACKS = ("hands_touch", "r_hand_touch", "l_hand_touch")


def drawn(seed: int, number: int = 10) -> Score:
    """Return a score: now one hand touches, now the other, now both touch each other."""
    pick, time, lines = random.Random(seed), 1.0, ["#speed=60", "#rhythm 4/4", "#unit1"]
    for _ in range(number):
        part = pick.choice(TRACKS)
        long = pick.choice((0.25, 0.5, 1) if part == TRACKS[0] else (0.5, 0.75, 1, 2))
        thing = "hand" if part == TRACKS[0] else pick.choice(THINGS)
        lines.append(f"touch {part} {thing} {time} {time + long}")
        time += long + pick.choice((1.25, 1.5, 2))
    return read_lnd("\n".join([*lines, f"#unit_total {int(time // 4) + 1}"]))


@dataclass
class Tally:
    """How many touches there were, came back, were added, and how many frames borders are off."""

    wanted: int = 0
    exact: int = 0
    added: int = 0
    starts: list[float] = field(default_factory=list)
    stops: list[float] = field(default_factory=list)


def compared(score: Score, found: Score, tally: Tally) -> None:
    """Add what became of the touches of a score that was carried out and written down again."""
    for part in TRACKS:
        ours = score.symbols(part) if part in score.tracks else []
        left = list(found.symbols(part))
        pace = float(RATE / score.rate)
        for symbol in ours:
            tally.wanted += 1
            near = min(left, key=lambda it: _off(symbol, it, pace), default=None)
            if near is None or _off(symbol, near, pace) > RATE / 2:
                continue
            left.remove(near)
            tally.exact += symbol.words == near.words
            tally.starts.append(abs(symbol.start * pace - near.start))
            tally.stops.append(abs(symbol.stop * pace - near.stop))
        tally.added += len(left)


def _off(one: Symbol, other: Symbol, pace: float) -> float:
    return abs(one.start * pace - other.start)
