"""Where things stand on the paper: columns of tracks, counts of time, staves."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import floor

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import kind_of
from lanindex.draw.picture import C
from lanindex.model import Score
from lanindex.model.derived import STEP

PITCH = round(1.2 * C)  # from one column to the next
NARROW = round(0.8 * C)  # the same for narrow signs

_INSIDE = (
    ("r_support", "l_support"),
    ("r_leg", "l_leg"),
    ("r_thigh", "l_thigh"),
    ("r_shank", "l_shank"),
    ("r_foot", "l_foot"),
    ("r_leg_bend", "l_leg_bend"),
)
_OUTSIDE = (
    ("torso", "torso_twist"),
    ("r_arm", "l_arm"),
    ("r_upper_arm", "l_upper_arm"),
    ("r_forearm", "l_forearm"),
    ("r_arm_bend", "l_arm_bend"),
    ("r_hand", "l_hand"),
    ("r_palm", "l_palm"),
    ("head", "torso_incline"),
    ("head_turn", "other_support"),
    ("head_incline", ""),
    ("body_turn", ""),
    ("body_travel", ""),
)
"""Tracks to the right and to the left of the centre, from it outwards."""

_ALWAYS = 2  # columns inside the staff's lines on each side, whatever the score has

BESIDE = ("jump", "hands_touch", "r_hand_touch", "l_hand_touch")
"""Tracks that have no column: they are drawn across those of others."""

STANCES = frozenset({"r_stance", "l_stance"})  # tracks that are drawn as holds

_FINER = {"leg": ("thigh", "shank", "foot"), "arm": ("upper_arm", "forearm")}
"""Limbs, and the finer tracks that are drawn where a score has no track of the limb."""

_TOUCHED = {
    "hand": ("hand", "palm", "forearm", "arm", "upper_arm"),
    "head": ("head",),
    "trunk": ("torso",),
    "arm": ("arm", "upper_arm", "forearm"),
    "thigh": ("thigh", "leg", "support"),
    "knee": ("leg", "shank", "support"),
    "shank": ("shank", "leg", "support"),
    "foot": ("foot", "support", "leg"),
}
"""What can be touched, and the columns that stand for it, best first."""


@dataclass(frozen=True, slots=True)
class StaffColumns:
    """The columns of a staff."""

    # By track, the middle of its column, counted from the centre line, units
    places: dict[str, int]
    inner: int  # From the centre to the staff's outer lines
    left: int  # From the centre to the end of the columns on either side
    right: int

    def touched(self, part: str, thing: str) -> tuple[int, int]:
        """Return the ends of a bow from a hand to what it touches."""
        side = part[:2]
        if part == "hands_touch":
            ends = self._place("l_", "hand"), self._place("r_", "hand")
        else:
            across = {"r_": "l_", "l_": "r_"}[side] if thing == "arm" else side
            ends = self._place(side, "hand"), self._place(across, thing)
        start, stop = sorted(ends)
        return (start, stop) if stop - start >= PITCH else (start - PITCH // 2, stop + PITCH // 2)

    def _place(self, side: str, thing: str) -> int:
        for group in _TOUCHED[thing]:
            for part in (side + group, group):
                if part in self.places:
                    return self.places[part]
        return self.right if side == "r_" else -self.left


def usual_tracks(tracks: Collection[str]) -> list[str]:
    """Return the tracks that are drawn by default: not the finer ones of whole limbs."""
    hidden = {
        side + bone
        for limb, bones in _FINER.items()
        for side in ("r_", "l_")
        for bone in bones
        if side + limb in tracks
    }
    return [part for part in tracks if part != STEP and part not in hidden]


def has_column(part: str) -> bool:
    """Return whether a track has a place on a staff."""
    return part in BESIDE or part in STANCES or any(part in pair for pair in (*_INSIDE, *_OUTSIDE))


def staff_columns(parts: Iterable[str]) -> StaffColumns:
    """Return the columns of tracks."""
    wanted, places = set(parts), dict[str, int]()
    at = inner = ends_left = ends_right = 0
    inside = [pair for rank, pair in enumerate(_INSIDE) if rank < _ALWAYS or wanted & {*pair}]
    outside = [pair for pair in _OUTSIDE if wanted & {*pair}]
    for number, (right, left) in enumerate([*inside, *outside]):
        wide = NARROW if kind_of(right) == "bend" else PITCH
        places |= {right: at + wide // 2, left: -at - wide // 2}
        at += wide
        inner = at if number + 1 == len(inside) else inner
        ends_left = at if left in wanted else ends_left
        ends_right = at if right in wanted else ends_right
    own = {part: x for part, x in places.items() if part in wanted}
    return StaffColumns(own, inner, max(inner, ends_left), max(inner, ends_right))


FIVE = 5  # seconds in a bar where seconds are counted


@dataclass(frozen=True, slots=True)
class TimeAxis:
    """The counts along a staff: beats, or seconds."""

    score: Score
    seconds: bool  # Whether it counts seconds, not beats

    @property
    def bar(self) -> int:
        """Counts in a bar."""
        return FIVE if self.seconds else self.score.meter.beats

    def symbols(self, rows: NDArray[np.void]) -> tuple[list[float], list[float]]:
        """Return the counts at which rows begin and end."""
        if self.seconds:
            rate = float(self.score.rate)
            return (rows["start"] / rate).tolist(), (rows["stop"] / rate).tolist()
        beats = self.score.meter.beats / self.score.meter.division
        return (rows["tick"] * beats).tolist(), ((rows["tick"] + rows["ticks"]) * beats).tolist()

    def at(self, seconds: float) -> float:
        """Return the count at a time; where beats are uneven, from the symbols around it."""
        if self.seconds:
            return seconds
        score, meter = self.score, self.score.meter
        rows = [track.symbols for track in score.tracks.values()]
        frames = np.concatenate([[0], *(it[name] for it in rows for name in ("start", "stop"))])
        ticks = np.concatenate(
            [[0], *(part for it in rows for part in (it["tick"], it["tick"] + it["ticks"]))]
        )
        frames, first = np.unique(frames, return_index=True)
        ticks, frame = np.maximum.accumulate(ticks[first]), seconds * float(score.rate)
        rate = float(meter.tick_rate / score.rate)
        past = max(frame - float(frames[-1]), 0.0) * rate
        return float((np.interp(frame, frames, ticks) + past) * meter.beats / meter.division)

    def number(self, count: float) -> str:
        """Return the label of a bar that begins at a count: its number, or the second."""
        bar = floor(count / self.bar + 1e-9)
        return str(bar * FIVE) if self.seconds else str(bar + 1)


BEAT = round(3.5 * C)  # default height of a beat or a second
LEAST = round(0.35 * C)  # height of a symbol, at least, where there is room
GAP = C // 16  # left free below and above each symbol
MARGIN = round(0.6 * C)  # round the picture, and between starting position and double line
NUMBERS = round(1.3 * C)  # width left of each staff, for the numbers of bars
START = BEAT  # height of the starting position
NAMES = round(4.2 * C)  # height of the names of columns


@dataclass(frozen=True, slots=True)
class Piece:
    """The piece of a symbol on one staff."""

    x: int  # Of the staff's centre line
    y: int  # Of the piece's lower end
    low: int  # Height within the symbol at which the piece begins
    high: int

    @property
    def top(self) -> int:
        """Where the piece's upper end is."""
        return self.y - self.high + self.low


@dataclass(frozen=True, slots=True)
class PageLayout:
    """Staves on paper."""

    start: float  # First and last count
    stop: float
    # Heights at which the staves begin and the last one ends
    edges: tuple[int, ...]
    columns: StaffColumns  # Of each staff
    tallest: int  # Height of the tallest staff
    score: int = 0  # Number of this score among those side by side
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
        """Return x of a staff's centre line."""
        place = staff * self.scores + self.score
        return MARGIN + NUMBERS + self.columns.left + place * self.pitch

    def up(self, count: float) -> int:
        """Return the height of a count, all staves stacked."""
        return round((min(max(count, self.start), self.stop) - self.start) * self.beat)

    def pieces(self, low: int, high: int) -> Iterator[Piece]:
        """Yield the pieces on each staff of what lies between two heights."""
        for staff in range(max(bisect_right(self.edges, low) - 1, 0), len(self.edges) - 1):
            bottom, top = self.edges[staff : staff + 2]
            if bottom >= high:
                return
            if top > low:
                start, stop = max(low, bottom), min(high, top)
                y = self.base - (start - bottom)
                yield Piece(self.centre(staff), y, start - low, stop - low)


def page_layout(
    clock: TimeAxis,
    start: float,
    stop: float,
    bars: int | None,
    own: StaffColumns,
    beat: int = BEAT,
) -> PageLayout:
    """Return staves of `bars` bars each, or one long strip; `beat` is the height of a count."""
    edges = [0]
    if bars:
        step = bars * clock.bar
        at = (floor(start / step + 1e-9) + 1) * step
        while at < stop - 1e-9:
            edges.append(round((at - start) * beat))
            at += step
    edges.append(max(round((stop - start) * beat), beat))
    tallest = max(high - low for low, high in pairwise(edges))
    return PageLayout(start, start + max(stop - start, 1.0), tuple(edges), own, tallest, beat=beat)


def spread_heights(spans: Sequence[tuple[int, int]], least: int) -> list[tuple[int, int]]:
    """Return the heights of successive symbols, the short ones grown to `least` if there is room.

    One that is too short grows into what is free above and below it; where nothing is, it takes
    up to a third of the one below.
    """
    heights: list[tuple[int, int]] = []
    for index, (low, high) in enumerate(spans):
        above = spans[index + 1][0] if index + 1 < len(spans) else low + least
        high = max(high, min(above, low + least))
        below = heights[-1][1] if heights else low
        low = min(low, max(below, high - least))
        if high - low < least and heights and low <= below:
            bottom = heights[-1][0]
            low = max(high - least, below - (below - bottom) // 3)
            heights[-1] = (bottom, low)
        heights.append((low, high))
    return heights
