"""Where time lies on paper: staves that stand side by side, each upwards."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import floor

from lanindex.draw.clock import Clock
from lanindex.draw.columns import Columns
from lanindex.draw.picture import C

BEAT = round(3.5 * C)
"""Height of a beat, or of a second, where nothing else is asked for."""

LEAST = round(0.35 * C)
"""Height of a symbol, at least, where there is room."""

GAP = C // 16
"""Left free below and above each symbol."""

MARGIN = round(0.6 * C)
"""Round the picture, and between starting position and double line."""

NUMBERS = round(1.3 * C)
"""Width left of each staff, for the numbers of bars."""

START = BEAT
"""Height of the starting position."""

NAMES = round(4.2 * C)
"""Height of the names of columns."""


@dataclass(frozen=True, slots=True)
class Piece:
    """What one staff shows of a symbol."""

    x: int  # The staff's centre line, and where the piece ends below
    y: int
    low: int  # From and to which height of the symbol
    high: int


@dataclass(frozen=True, slots=True)
class Layout:
    """Staves on paper."""

    start: float  # Counts that the staves begin and end with
    stop: float
    # Heights above the beginning at which the staves begin, and the last one ends
    edges: tuple[int, ...]
    columns: Columns  # Of each staff
    tallest: int  # Height of the tallest staff
    score: int = 0  # Which of how many scores that share the paper, staff beside staff
    scores: int = 1
    beat: int = BEAT  # Height of a count

    @property
    def pitch(self) -> int:
        """From one staff's centre to the next."""
        return NUMBERS + self.columns.left + self.columns.right + MARGIN

    @property
    def base(self) -> int:
        """Where all staves begin, counted from the top."""
        return 2 * MARGIN + self.tallest

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture."""
        width = MARGIN + self.pitch * (len(self.edges) - 1) * self.scores
        return width, self.base + MARGIN + START + NAMES + MARGIN

    @property
    def staves(self) -> tuple[int, ...]:
        """Where each staff, or those of all scores beside each other, begins."""
        step = self.pitch * self.scores
        return tuple(MARGIN + staff * step for staff in range(len(self.edges) - 1))

    def height(self, staff: int) -> int:
        """Return the height of a staff."""
        return self.edges[staff + 1] - self.edges[staff]

    def centre(self, staff: int) -> int:
        """Return where a staff's centre line stands."""
        place = staff * self.scores + self.score
        return MARGIN + NUMBERS + self.columns.left + place * self.pitch

    def up(self, count: float) -> int:
        """Return how high above the beginning a count lies, all staves on top of each other."""
        return round((min(max(count, self.start), self.stop) - self.start) * self.beat)

    def pieces(self, low: int, high: int) -> Iterator[Piece]:
        """Yield what each staff shows of what lies between two heights above the beginning."""
        for staff in range(max(bisect_right(self.edges, low) - 1, 0), len(self.edges) - 1):
            bottom, top = self.edges[staff : staff + 2]
            if bottom >= high:
                return
            if top > low:
                start, stop = max(low, bottom), min(high, top)
                y = self.base - (start - bottom)
                yield Piece(self.centre(staff), y, start - low, stop - low)


def laid_out(
    clock: Clock, start: float, stop: float, bars: int | None, own: Columns, beat: int = BEAT
) -> Layout:
    """Return staves of so many bars each, or one long strip; `beat` is the height of a count."""
    edges = [0]
    if bars:
        step = bars * clock.bar
        at = (floor(start / step + 1e-9) + 1) * step
        while at < stop - 1e-9:
            edges.append(round((at - start) * beat))
            at += step
    edges.append(max(round((stop - start) * beat), beat))
    tallest = max(high - low for low, high in pairwise(edges))
    return Layout(start, start + max(stop - start, 1.0), tuple(edges), own, tallest, beat=beat)


def apart(spans: Sequence[tuple[int, int]], least: int) -> list[tuple[int, int]]:
    """Return heights of symbols that follow each other, none shorter than it need be.

    One that is too short grows into what is free above and below it; where nothing is, it takes
    up to a third of the one below.
    """
    found: list[tuple[int, int]] = []
    for index, (low, high) in enumerate(spans):
        if high - low < least:
            above = spans[index + 1][0] if index + 1 < len(spans) else low + least
            high = max(high, min(above, low + least))
            below = found[-1][1] if found else low
            low = min(low, max(below, high - least))
            if high - low < least and found and low <= below:
                bottom = found[-1][0]
                low = max(high - least, below - (below - bottom) // 3)
                found[-1] = (bottom, low)
        found.append((low, high))
    return found
