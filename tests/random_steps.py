"""Random scores of steps, jumps and turns that a person could perform in that time."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction

from lanindex.alphabet import (
    DIRECTION_CODES,
    DIRECTIONS,
    FEET,
    KINDS,
    LEVEL_CODES,
    LEVELS,
    kind_of,
)
from lanindex.encoding.timing import quantise
from lanindex.model import Meter, Score, Span, Symbol, Track
from lanindex.model.symbol import blank
from lanindex.perform.travel import WEIGHT

RATE = 60
LEADS = {"r": "l", "l": "r"}


@dataclass
class Draft:
    """What has been drawn so far; frames."""

    time: int = RATE
    foot: str = "r"
    rows: dict[str, list[tuple[int, int, int, int, int]]] = field(
        default_factory=lambda: {part: [] for part in WEIGHT}
    )

    def add(self, part: str, length: int, way: str, level: str | None, amount: int = -1) -> None:
        code = -1 if level is None else LEVEL_CODES[level]
        row = (self.time, self.time + length, DIRECTION_CODES[way], code, amount)
        self.rows[part].append(row)

    def step(self, pick: random.Random, way: str, level: str, length: int) -> None:
        self.add(f"{self.foot}_support", length, way, level)
        self.time += length
        self.foot = LEADS[self.foot]

    def jump(self, pick: random.Random) -> None:
        self.step(pick, "place", "mid", 30)  # both feet together
        self.time += RATE // 2
        length, way = pick.randrange(15, 26), pick.choice(DIRECTIONS)
        self.add("jump", length, way, None, FEET.index("spring"))
        for side in "rl":
            self.add(f"{side}_support", length, way, "mid")
        self.time += length + RATE

    def turn(self, pick: random.Random) -> None:
        count, length = pick.randrange(2, 5), pick.randrange(24, 40)
        degrees = pick.choice((45, 60)) * count
        side = pick.choice(("left", "right"))
        self.time += RATE
        self.rows["body_turn"].append(
            (self.time, self.time + count * length, DIRECTION_CODES[side], -1, degrees)
        )
        for _ in range(count):
            self.step(pick, "place", "mid", length)
        self.time += RATE


def drawn(seed: int, number: int = 12) -> Score:
    """Return a score: phrases of steps with rests, jumps and turns between."""
    pick = random.Random(seed)
    draft = Draft()
    for _ in range(number):
        kind = pick.random()
        if kind < 0.15:
            draft.time += RATE // 2
            draft.jump(pick)
        elif kind < 0.3:
            draft.turn(pick)
        else:
            way, level = pick.choice(DIRECTIONS), pick.choice(("low", "mid", "mid", "high"))
            for _ in range(pick.randrange(1, 5)):
                draft.step(pick, way, level, pick.randrange(24, 54))
            draft.time += pick.choice((0, RATE))
    return score_of(draft)


def score_of(draft: Draft) -> Score:
    """Return the score of a draft."""
    frames = draft.time + RATE
    tracks = {}
    for part, those in draft.rows.items():
        begin = int(kind_of(part) == "support")
        rows = blank(len(those) + begin)
        if begin:
            rows[0]["direction"], rows[0]["level"] = DIRECTION_CODES["place"], LEVELS.index("mid")
        for row, values in zip(rows[begin:], those, strict=True):
            for name, value in zip(("start", "stop", "direction", "level", "amount"), values,
                                   strict=True):  # fmt: skip
                row[name] = value
        rows["margin"] = 1
        tracks[part] = rows
    meter = quantise(tracks.values(), frames, Fraction(RATE), Meter())
    known = (Span(0, frames),)
    of_all = {part: Track(part, rows, known) for part, rows in tracks.items()}
    return Score(Fraction(RATE), frames, meter, of_all)


@dataclass
class Tally:
    """How many symbols there were, came back, were added, and how many frames borders are off."""

    wanted: int = 0
    exact: int = 0
    added: int = 0
    starts: list[int] = field(default_factory=list)
    stops: list[int] = field(default_factory=list)


DEGREES = 5
"""How far an angle may be off."""


def compared(
    score: Score, found: Score, tally: dict[str, Tally], parts: Iterable[str] = WEIGHT
) -> None:
    """Add what became of the symbols of a score that was carried out and written down again.

    Those belong together that end nearest to each other; angles may differ by 5 degrees.
    """
    for part in parts:
        counts = tally.setdefault(part, Tally())
        ours, left = (_moves(one, part) for one in (score, found))
        for symbol in ours:
            counts.wanted += 1
            start, stop = (round(it * RATE / score.rate) for it in (symbol.start, symbol.stop))
            near = min(left, key=lambda it: abs(it.stop - stop), default=None)
            if near is None or abs(near.stop - stop) > RATE // 3:
                continue
            left.remove(near)
            same = (symbol.direction, symbol.level) == (near.direction, near.level)
            apart = abs((symbol.amount or 0) - (near.amount or 0))
            counts.exact += same and apart <= (0 if KINDS[kind_of(part)].amounts else DEGREES)
            counts.starts.append(abs(start - near.start))
            counts.stops.append(abs(stop - near.stop))
        counts.added += len(left)


def _moves(score: Score, part: str) -> list[Symbol]:
    if part not in score.tracks:
        return []
    return [it for it in score.symbols(part) if it.start < it.stop and not it.passing]
