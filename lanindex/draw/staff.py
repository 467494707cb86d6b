"""A score as a picture: where things stand on the paper, and the marks of its staff."""

from bisect import bisect_right
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from math import ceil, floor
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, KINDS, PLACE, group_of, kind_of, plain
from lanindex.data import shipped
from lanindex.draw.picture import (
    BOW,
    GAP,
    SIGNS,
    C,
    Circle,
    Label,
    Mark,
    MarkGroup,
    Picture,
    bow,
    box,
    line,
    sign,
    turn,
)
from lanindex.errors import UsageError
from lanindex.model import Score, Symbol
from lanindex.model.derived import STEP, SUPPORTS
from lanindex.model.score import rows_of
from lanindex.model.symbol import blank, joined, listed

PITCH = round(1.2 * C)  # from one column to the next
PITCHES = {"bend": C, "turn": round(1.5 * C)}
"""The same by kinds of symbols, whose signs are narrow or whose numbers, in films, are wide."""

FIVE = 5  # seconds in a bar where seconds are counted
_COLUMNS = shipped("draw/signs.toml")["columns"]
_INSIDE, _OUTSIDE, BESIDE = (_COLUMNS[it] for it in ("inside", "outside", "beside"))
_ALWAYS = ("r_support", "r_leg")  # they and their twins have columns, whatever the score has
TURN = "body_turn"
STANCES = frozenset({"r_stance", "l_stance"})  # tracks that are drawn as holds
_FINER: dict[str, list[str]] = shipped("draw/signs.toml")["limbs"]
_LEGS = ("leg", *_FINER["leg"])
_LIMB_OF = {
    f"{it}_{part}": f"{it}_{limb}" for limb in _FINER for part in _FINER[limb] for it in "rl"
}

_TOUCHED: dict[str, list[str]] = shipped("draw/signs.toml")["touched"]
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
    return [part for part in tracks if part != STEP and _LIMB_OF.get(part) not in tracks]


def has_column(part: str) -> bool:
    """Return whether a track has a place on a staff."""
    return part in BESIDE or part in STANCES or any(part in pair for pair in (*_INSIDE, *_OUTSIDE))


def staff_columns(parts: Iterable[str]) -> StaffColumns:
    """Return the columns of tracks."""
    wanted, places = set(parts), dict[str, int]()
    at = inner = ends_left = ends_right = 0
    inside = [pair for pair in _INSIDE if pair[0] in _ALWAYS or wanted & {*pair}]
    outside = [pair for pair in _OUTSIDE if wanted & {*pair}]
    for number, (right, left) in enumerate([*inside, *outside]):
        wide = PITCHES.get(kind_of(right), PITCH)
        places |= {right: at + wide // 2, left: -at - wide // 2}
        at += wide
        inner = at if number + 1 == len(inside) else inner
        ends_left = at if left in wanted else ends_left
        ends_right = at if right in wanted else ends_right
    own = {part: x for part, x in places.items() if part in wanted}
    return StaffColumns(own, inner, max(inner, ends_left), max(inner, ends_right))


@dataclass(frozen=True, slots=True)
class TimeAxis:
    """The counts along a staff: beats, or seconds."""

    score: Score
    seconds: bool  # Whether it counts seconds, not beats

    @property
    def bar(self) -> int:
        """Counts in a bar."""
        return FIVE if self.seconds else self.score.meter.beats

    def symbols(self, rows: NDArray[np.void]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the counts at which rows, (S,), begin and end."""
        if self.seconds:
            rate = float(self.score.rate)
            return rows["start"] / rate, rows["stop"] / rate
        beats = self.score.meter.beats / self.score.meter.division
        return rows["tick"] * beats, (rows["tick"] + rows["ticks"]) * beats

    def at(self, seconds: float) -> float:
        """Return the count at a time; where beats are uneven, from the symbols around it."""
        if self.seconds:
            return seconds
        score, meter = self.score, self.score.meter
        frames, ticks = self.knots()
        frame, rate = seconds * float(score.rate), float(meter.tick_rate / score.rate)
        past = max(frame - float(frames[-1]), 0.0) * rate
        return float((np.interp(frame, frames, ticks) + past) * meter.beats / meter.division)

    def knots(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the frames (K,) at which symbols tell where beats are, and their ticks."""
        rows = joined(track.symbols for track in self.score.tracks.values())
        frames = np.concatenate([[0], rows["start"], rows["stop"]])
        ticks = np.concatenate([[0], rows["tick"], rows["tick"] + rows["ticks"]])
        frames, first = np.unique(frames, return_index=True)
        return frames, np.maximum.accumulate(ticks[first])

    def number(self, count: float) -> str:
        """Return the label of a bar that begins at a count: its number, or the second."""
        return f"{count:g}" if self.seconds else str(floor(count / self.bar + 1e-9) + 1)


BEAT = 4 * C  # default height of a beat or a second: a quarter is as tall as a symbol is wide
LEAST = C // 2  # height of a symbol, at least: it shows its shading
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
    """The staves of a score on paper."""

    clock: TimeAxis
    start: float  # First and last count
    stop: float
    # Heights at which the staves begin and the last one ends
    edges: tuple[int, ...]
    columns: StaffColumns  # Of each staff
    base: int  # Where all staves begin, counted from the top
    beat: int  # Height of a count
    number: int  # Of this score among those side by side
    scores: int
    head: int = 0  # Height of the lines above the staves

    @property
    def pitch(self) -> int:
        """From one staff's centre to the next."""
        return NUMBERS + self.columns.left + self.columns.right + MARGIN

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

    def centre(self, staff: int) -> int:
        """Return x of a staff's centre line."""
        place = staff * self.scores + self.number
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
                if stop - start < min(C // 4, high - low):  # what is left of it says nothing
                    continue
                y = self.base - (start - bottom)
                yield Piece(self.centre(staff), y, start - low, stop - low)


def spread_heights(
    spans: Sequence[tuple[int, int]], least: int, kept: Collection[int] = (), top: int = 1 << 60
) -> list[tuple[int, int] | None]:
    """Return heights of successive symbols, none lower than `least` where there is room.

    A short one grows upwards as far as there is room, and then down into the one below. None: what
    would end before it begins is too short to be drawn, unless its number is one of the `kept`.
    """
    heights: list[tuple[int, int] | None] = []
    below = min(spans[-1][1] + least, top) if spans else 0
    for index in range(len(spans) - 1, -1, -1):
        low, high = spans[index]
        end = min(max(high, low + least), below)
        begin = max(min(low, end - least), min(spans[0][0], end - 1))
        squeezed = end - begin < least // 2 and index + 1 < len(spans)
        if (end <= low or squeezed) and index not in kept:
            heights.append(None)
        else:
            heights.append((begin, end))
            below = begin
    return heights[::-1]


BARS = 4  # bars of a staff
LETTERS = ("A", "B")  # what stands above the staves of either of two scores


def draw(
    score: Score,
    *,
    title: str = "",
    heading: Sequence[str] = (),
    parts: Sequence[str] | None = None,
    start: float = 0.0,
    stop: float | None = None,
    bars: int | None = BARS,
    seconds: bool = False,
    marked: Iterable[Symbol] = (),
    legend: bool = False,
    beat: int = BEAT,
) -> Picture:
    """Draw a score, below the lines of its heading."""
    last = last_second(float(score.frames / score.rate), start, stop)
    marked = list(settled(score, marked))
    drawn, missing = chosen(score, parts, {it.part for it in marked})
    clock = TimeAxis(score, seconds)
    ends = clock.at(start), clock.at(last)
    if parts is None:  # what says nothing in this stretch has no column
        drawn = [it for it in drawn if _tells(clock, rows_of(score, it), it, *ends)] or drawn
    layout, marks, (symbols,) = _staves([clock], [drawn], [marked], ends, bars, beat, len(heading))
    lines = [
        Label(MARGIN, MARGIN + _LINE * row, text, _HEADING, "begin")
        for row, text in enumerate(heading, 1)
    ]
    marks += lines
    told = f"{short(last - start)} s, {symbols} of {', '.join(drawn)}"
    width, height = layout.size
    if legend:  # beside the staves, below the heading
        kinds = {*map(kind_of, drawn), *["marked"] * bool(marked)}
        rows = legend_rows(kinds, width, layout.head + MARGIN)
        marks += rows
        low = layout.head + len(rows) * _PITCH + 2 * MARGIN
        width, height = width + LEGEND_WIDTH, max(height, low)
    width = max([width, *(2 * MARGIN + round(0.62 * _HEADING * len(it.text)) for it in lines)])
    summary, staves = f"Labanotation, time upwards: {told}", layout.staves
    return Picture(width, height, title or "score", summary, tuple(marks), tuple(missing), staves)


def draw_pair(
    scores: Sequence[Score],
    marked: Sequence[Iterable[Symbol]],
    *,
    titles: Sequence[str] = LETTERS,
    parts: Sequence[str] | None = None,
    bars: int | None = BARS,
    seconds: bool = True,
) -> Picture:
    """Draw two scores beside each other, in the same columns and at the same heights."""
    last = max(float(score.frames / score.rate) for score in scores)
    wanted = [parts and [it for it in parts if it in score.tracks] for score in scores]
    drawn, missing = zip(*map(chosen, scores, wanted), strict=True)
    clocks = [TimeAxis(score, seconds) for score in scores]
    begin, end = clocks[0].at(0.0), max(clock.at(last) for clock in clocks)
    layout, marks, counts = _staves(clocks, drawn, marked, (begin, end), bars, BEAT)
    symbols = ", ".join(f"{name}: {it}" for name, it in zip(LETTERS, counts, strict=True))
    summary = f"{symbols}; Labanotation, time upwards: {short(last)} s"
    warnings = tuple(dict.fromkeys(text for own in missing for text in own))
    title = ", ".join(f"{name}: {it}" for name, it in zip(LETTERS, titles, strict=True))
    return Picture(*layout.size, title, summary, tuple(marks), warnings, layout.staves)


def last_second(end: float, start: float, stop: float | None) -> float:
    """Return the last second that is shown of a score that ends at a time."""
    last = end if stop is None else min(stop, end)
    if not 0 <= start < last:
        found = f"nothing from {start:g} s to {last:g} s"
        raise UsageError(found, wanted=f"a stretch of 0 to {end:g} s")
    return last


def chosen(
    score: Score, parts: Sequence[str] | None, marked: Collection[str] = ()
) -> tuple[list[str], list[str]]:
    """Return the tracks that are drawn, those of marked symbols among them, and warnings."""
    there = [part for part in score.tracks if len(score.tracks[part])]
    if not there and parts is None:
        raise UsageError("an empty score", wanted="a symbol in it")
    if parts is None:
        odd = [part for part in there if part != STEP and not has_column(part)]
        wanted = {*usual_tracks(there), *marked}
        drawn = [part for part in there if part in wanted and has_column(part)]
        if not drawn:
            raise UsageError(f"no column for {', '.join(there)}", wanted="a part that has one")
        return drawn, [f"no column for {part}: it is not drawn" for part in odd]
    for part in parts:
        if part not in score.tracks:
            raise UsageError(f'there is no part "{part}"', wanted=f"one of {' '.join(there)}")
        if not has_column(part):
            raise UsageError(f"no column for {part}", wanted="a part that has one")
    wanted = {*parts, *filter(has_column, marked)}
    return [part for part in score.tracks if part in wanted], []


def _tells(clock: TimeAxis, rows: NDArray[np.void], part: str, start: float, stop: float) -> bool:
    """Return whether rows of a track say something of a stretch, from count to count."""
    begins, ends = clock.symbols(rows)
    seen = (ends > start) | (begins == ends) | KINDS[kind_of(part)].lasts
    return bool((seen & (begins < stop)).any())


def _staves(
    clocks: Sequence[TimeAxis],
    parts: Sequence[Sequence[str]],
    marked: Sequence[Iterable[Symbol]],
    ends: tuple[float, float],
    bars: int | None,
    beat: int,
    heading: int = 0,
) -> tuple[PageLayout, list[Mark], list[str]]:
    """Return scores side by side, from count to count: layout, marks, and symbols in words."""
    (start, stop), edges = ends, [0]
    if bars:  # else it is one long strip
        unit = 1 if clocks[0].seconds else clocks[0].bar
        first = floor(start / unit + _EPS) * unit
        staves = max(ceil((stop - first) / (bars * clocks[0].bar) - _STUB), 1)
        length = ceil((stop - first) / staves / unit - _EPS) * unit
        more = [round((first + length * it - start) * beat) for it in range(1, staves)]
        edges += [it for it in more if it < round((stop - start) * beat)]
    edges.append(max(round((stop - start) * beat), beat))
    head = _LINE * heading
    base = head + 2 * MARGIN + max(high - low for low, high in pairwise(edges))
    columns = staff_columns(
        part
        for clock, drawn in zip(clocks, parts, strict=True)
        for part in drawn
        if part != TURN or any(_tells(clock, it, TURN, *ends) for it in turns(clock.score)[1:])
    )
    marks, counts, stop = list[Mark](), list[str](), start + max(stop - start, 1.0)
    for number, (clock, drawn, symbols) in enumerate(zip(clocks, parts, marked, strict=True)):
        layout = PageLayout(
            clock, start, stop, tuple(edges), columns, base, beat, number, len(clocks), head
        )
        painter = SymbolPainter(layout, keys_of(clock.score, symbols))
        groups = [it for part in drawn if part not in STANCES for it in painter.track(part)]
        held = holds(layout, painter.tops) if STANCES & {*drawn} else []
        letters = [
            Label(layout.centre(staff), head + MARGIN + C // 4, LETTERS[number], C // 2)
            for staff in range(len(edges) - 1 if len(clocks) > 1 else 0)
        ]
        marks += [*painter.bands, *held, *_lines(layout), *letters, *groups]
        told = sum(bool(it.marks) for it in groups)
        short_ones = f" and {len(groups) - told} too short to be drawn" * (told < len(groups))
        counts.append(f"{told} symbol{'s' * (told != 1)}{short_ones}")
    return layout, marks, counts


DOUBLE = C // 5
NAME = round(0.45 * C)
_HEADING, _LINE = round(0.55 * C), round(0.9 * C)  # size and distance of the lines of a heading
_STUB = 0.25  # of a staff: what is left of a score for the last one is shared out, if no more
_EPS = 1e-6
_TICKS = C // 4  # height of a count from which on each has its tick


def _lines(layout: PageLayout) -> list[Mark]:
    """Return lines of all staves, ticks of beats, numbers of bars, and names of columns."""
    marks = list[Mark]()
    last, inner, base = len(layout.edges) - 2, layout.columns.inner, layout.base
    roof = layout.head + 2 * MARGIN  # of all staves: the last one is as tall, if shorter in time
    for staff in range(last + 1):
        x, (low, high) = layout.centre(staff), layout.edges[staff : staff + 2]
        top, foot = base - (high - low), base + (MARGIN + START if staff == 0 else 0)
        marks += [line(x + side, foot, x + side, roof, "staff") for side in (-inner, 0, inner)]
        ends = [base, *[base + DOUBLE] * (staff == 0), top, *[top + DOUBLE] * (staff == last)]
        marks += [line(x - inner, y, x + inner, y, "staff") for y in ends]
        first = ceil(layout.start + low / layout.beat - _EPS)
        last_one = floor(layout.start + high / layout.beat + _EPS)
        marks += count_lines(layout, staff, range(first, last_one + 1))
        marks += column_names(layout, x, base + MARGIN + (MARGIN + START if staff == 0 else 0))
    return marks


def count_lines(layout: PageLayout, staff: int, numbers: range) -> list[Mark]:
    """Return ticks of some counts of a staff, and lines and numbers of the bars among them."""
    marks, clock, base = list[Mark](), layout.clock, layout.base
    bars = ceil(C / (clock.bar * layout.beat))  # that share a number, where they stand close
    x, (low, high), inner = (
        layout.centre(staff),
        layout.edges[staff : staff + 2],
        layout.columns.inner,
    )
    top = base - (high - low)
    for number in numbers:
        y = base - (round((number - layout.start) * layout.beat) - low)
        within = top < y < base
        begins = number % clock.bar == 0 and number // clock.bar % bars == 0
        if number % clock.bar and within and layout.beat >= _TICKS:
            marks.append(line(x - C // 4, y, x + C // 4, y, "staff"))
        if begins and within:
            style = "light" if clock.seconds else "staff"
            marks.append(line(x - inner, y, x + inner, y, style))
        if (begins and y > top) or (clock.seconds and y == base):
            at = x - layout.columns.left - GAP * 4
            marks.append(Label(at, y + C // 5, clock.number(number), C // 2 + 10, "end"))
    return marks


def column_names(layout: PageLayout, x: int, y: int) -> list[Mark]:
    """Return the names of the columns of a staff, which end at a height."""
    return [
        Label(x + at + NAME // 3, y, name_of(part), NAME, "under", True)
        for part, at in layout.columns.places.items()
    ]


def name_of(part: str) -> str:
    """Return a part's name below its column: there its side is plain to see."""
    return plain(group_of(part))


# How wide the circle is that keeps the weight on one foot, or on both
ONE, BOTH = round(0.55 * C), round(0.8 * C)
_HELD = {
    **{"r": (ONE, "stands on the right foot"), "l": (ONE, "stands on the left foot")},
    **{"rl": (BOTH, "stands on both feet"), "?": (ONE, "what carries is not known")},
}
"""By what holds the weight: size and meaning of what is drawn."""

# What tells the weight beside stances: supports stand for themselves, others beside the feet
_CARRYING = {"support": "+", "jump": "+", "turn": "+", "carrier": "c"}
_LASTS = 0.25  # least counts without a symbol of support that are drawn as a hold of weight


def holds(layout: PageLayout, tops: Mapping[int, int]) -> list[MarkGroup]:
    """Return a circle wherever feet hold the weight and supports have no symbol, else a question.

    `tops`: by the height at which supports end, that at which they end on paper.
    """
    score = layout.clock.score
    end = min(layout.stop, layout.clock.at(float(score.frames / score.rate)))
    changes: list[tuple[float, str, int]] = [(end, "+", 1)]
    for part, track in score.tracks.items():
        rows = turns(score)[0] if part == TURN else track.symbols
        if key := part[0] if part in STANCES else _CARRYING.get(kind_of(part)):
            for start, stop in zip(*layout.clock.symbols(rows), strict=True):
                if start < stop:
                    changes += [(start, key, 1), (stop, key, -1)]
    changes.sort()
    found, state, since, feet = [], {"+": 0, "r": 0, "l": 0, "c": 0}, 0.0, ""
    low = 0  # where a hold begins: where the support before it ends on paper
    for time, together in groupby(changes, key=lambda it: it[0]):
        for _, key, change in together:
            state[key] += change
        now = "+" if state["+"] else "".join(it for it in "rlc" if state[it]) or "?"
        if now == feet:
            continue
        held, start, foot = feet.removesuffix("c"), since, low  # anew where other support comes
        since, feet, low = time, now, tops.get(layout.up(time), layout.up(time))
        if held not in _HELD or time - start < _LASTS or time <= layout.start:
            continue
        size, words = _HELD[held]
        at = layout.columns.places.get(f"{held}_support", 0)
        for piece in layout.pieces(foot, layout.up(time)):  # on each staff anew
            if piece.high - piece.low >= size + GAP:
                x, y = piece.x + at, piece.y - GAP
                marks: list[Mark] = [Circle(x, y - size // 2, size // 2)]
                if held == "?":
                    marks = [Label(x + side, y, held, size) for side in (-PITCH // 2, PITCH // 2)]
                found.append(MarkGroup(tuple(marks), words))
    return found


_CURVE, _STEP = 3, 90  # steps of a way that curves, at least; degrees that each turns, at most


def turns(score: Score) -> tuple[NDArray[np.void], ...]:
    """Return the turns of the body: while no foot takes the weight, along curves, and others."""
    own, steps = rows_of(score, TURN), rows_of(score, STEP)
    right, left = (_meet(own, rows_of(score, part)) for part in SUPPORTS)
    spot = ~(right | left)
    middles = (steps["start"] + steps["stop"]) / 2
    ends = (np.searchsorted(middles, own[it]).tolist() for it in ("start", "stop"))
    within = [steps["direction"][slice(*it)] for it in zip(*ends, strict=True)]
    most = _STEP * np.array([_onward(ways) for ways in within], int)
    curve = (own["amount"] <= most) & (most >= _STEP * _CURVE)
    return own[spot], own[curve & ~spot], own[~(curve | spot)]


def _onward(ways: NDArray[np.int8]) -> int:
    """Return how many steps lead somewhere, 0 if some lie beyond 45 degrees of one another."""
    ways = ways[ways != PLACE]
    return len(ways) if np.isin((ways[:, None] - ways) % 8, (0, 1, 7)).all() else 0


def _meet(rows: NDArray[np.void], others: NDArray[np.void]) -> NDArray[np.bool_]:
    """Return which rows share frames with any of others."""
    later, sooner = rows["start"][:, None] < others["stop"], others["start"] < rows["stop"][:, None]
    return np.asarray((later & sooner).any(axis=1))


Key = tuple[str, int, int]  # identifies a symbol of a score: its part, first frame and end


def settled(score: Score, symbols: Iterable[Symbol]) -> Iterator[Symbol]:
    """Yield symbols of a score, passing ones replaced by those that they lead to."""
    shown: dict[str, NDArray[np.intp]] = {}
    for symbol in symbols:
        if symbol.passing:
            part, rows = symbol.part, score.tracks[symbol.part].symbols
            if part not in shown:
                shown[part] = np.flatnonzero(~rows["passing"])
            after = rows[shown[part][np.searchsorted(shown[part], symbol.ordinal)]]
            start, stop = int(after["start"]), int(after["stop"])
            symbol = replace(symbol, start=start, stop=stop, passing=False)
        yield symbol


def keys_of(score: Score, symbols: Iterable[Symbol]) -> frozenset[Key]:
    """Return keys of marked symbols: the foot's for a step, the next one's for a passing one."""
    found: set[Key] = set()
    for symbol in settled(score, symbols):
        parts = ("r_support", "l_support") if symbol.part == STEP else (symbol.part,)
        found |= {(part, symbol.start, symbol.stop) for part in parts}
    return frozenset(found)


@dataclass(frozen=True, slots=True, eq=False)
class Heights:
    """The symbols of a track that a staff shows, and how high they are."""

    rows: NDArray[np.void]  # (S,) of `SYMBOL`
    numbers: NDArray[np.int64]  # (S,) which of the track's rows they are, passing ones left out
    times: NDArray[np.int64]  # (S, 2) heights at which each begins and ends
    # (S, 2) heights at which it is drawn: a short one is taller; -1: too short to be drawn
    drawn: NDArray[np.int64]


class SymbolPainter:
    """Symbols as they come to paper, and the bands below those that are marked."""

    def __init__(self, layout: PageLayout, marked: frozenset[Key]) -> None:
        self.layout, self.marked, self.score = layout, marked, layout.clock.score
        self.pivots, self.circles, _ = ({*it["start"].tolist()} for it in turns(self.score))
        self.bands: list[Mark] = []
        self.tops: dict[int, int] = {}  # Where supports end on paper, by where they would
        self.flights = layout.clock.symbols(rows_of(self.score, "jump"))

    def on(self, layout: PageLayout) -> Self:
        """Return what draws the same symbols on another piece of the same staff."""
        other = copy(self)
        other.layout, other.bands = layout, []
        return other

    def track(self, part: str) -> list[MarkGroup]:
        """Return the symbols of a track: the one in force at the beginning, and those behind."""
        heights = self.heights(part)
        symbols = listed(part, heights.rows)
        begun = [group for _, group in self.begun(part, self.layout.start)]
        return begun + self.drawn(symbols, heights.times, heights.drawn)

    def heights(self, part: str) -> Heights:
        """Return the symbols of a track that the staff shows, and how high they are."""
        layout, kind = self.layout, KINDS[kind_of(part)].name
        rows = rows_of(self.score, part)
        begins, ends = layout.clock.symbols(rows)
        numbers = np.flatnonzero((ends > layout.start) & (begins < layout.stop))
        rows, begins, ends = rows[numbers], begins[numbers], ends[numbers]
        if kind == "support":
            begins = self._landed(begins, ends)
        lows, highs = (list(map(layout.up, it.tolist())) for it in (begins, ends))
        times = np.array((lows, highs), np.int64).T.reshape(-1, 2)
        if part in BESIDE:
            return Heights(rows, numbers, times, times)
        kept = range(len(rows)) if kind == "support" else self._marked(part, rows)
        spread = spread_heights([*zip(lows, highs, strict=True)], LEAST, kept, layout.edges[-1])
        drawn = np.array([own or (-1, -1) for own in spread], np.int64).reshape(-1, 2)
        if kind == "support":
            for high, own in zip(highs, spread, strict=True):
                if own:
                    self.tops[high] = max(own[1], self.tops.get(high, 0))
        return Heights(rows, numbers, times, drawn)

    def _marked(self, part: str, rows: NDArray[np.void]) -> set[int]:
        """Return which rows of a part are marked."""
        if not any(marked == part for marked, *_ in self.marked):
            return set()
        spans = zip(rows["start"].tolist(), rows["stop"].tolist(), strict=True)
        return {at for at, span in enumerate(spans) if (part, *span) in self.marked}

    def begun(self, part: str, count: float) -> list[tuple[int, MarkGroup]]:
        """Return what of a track is in force at a count, below the staff: its row, and its marks.

        Passing rows are not counted.
        """
        layout, kind, rows = self.layout, KINDS[kind_of(part)], rows_of(self.score, part)
        begins, ends = layout.clock.symbols(rows)
        over = (ends <= count) & (kind.lasts | (begins == ends))
        found = []
        for number in np.flatnonzero(over)[-1:].tolist():
            (symbol,) = listed(part, rows[[number]])
            if group_of(part) in _LEGS and self._carried(symbol, count):
                continue
            if part in BESIDE:
                found.append((number, self._beside(symbol, 0, 0)))
                continue
            base, centre = layout.base + MARGIN // 2, layout.centre(0)
            marks = self._sign(symbol, centre, base + START, START, (0, START))
            found.append((number, symbol_group(symbol, self.score, marks)))
            self._band(symbol, centre + self._across(symbol), base + START, base)
        return found

    def drawn(
        self, symbols: Sequence[Symbol], times: NDArray[np.int64], drawn: NDArray[np.int64]
    ) -> list[MarkGroup]:
        """Return symbols of one track at their heights; those too short to be drawn are empty."""
        groups = []
        for symbol, (low, high), own in zip(symbols, times.tolist(), drawn.tolist(), strict=True):
            if symbol.part in BESIDE:
                groups.append(self._beside(symbol, low, high))
            elif own[0] < 0:
                groups.append(symbol_group(symbol, self.score, []))
            else:
                groups.append(self._placed(symbol, own[0], own[1], seen_again=low == high))
        return groups

    def _carried(self, symbol: Symbol, count: float) -> bool:
        """Return whether the foot took the weight between a gesture and a count."""
        rows = rows_of(self.score, f"{symbol.part[:2]}stance")
        later = rows[rows["start"] > symbol.start]
        return bool((self.layout.clock.symbols(later)[0] <= count).any())

    def _landed(
        self, begins: NDArray[np.float64], ends: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return when supports begin on paper: before a landing both columns of support rest."""
        starts, stops = self.flights
        if not len(starts):
            return begins
        at = np.searchsorted(starts, ends - 1e-9, "right") - 1
        lands = (at >= 0) & (starts[at] < ends) & (ends <= stops[at] + 1e-9)
        return np.where(lands, np.maximum(begins, (starts[at] + ends) / 2), begins)

    def _placed(self, symbol: Symbol, low: int, high: int, *, seen_again: bool) -> MarkGroup:
        """Return a symbol in its column, on each staff that shows a piece of it."""
        gap = min(GAP, (high - low) // 4)
        low, high = low + gap, high - gap
        marks: list[Mark] = []
        for piece in self.layout.pieces(low, high):
            marks += self._sign(symbol, piece.x, piece.y, high - low, (piece.low, piece.high))
            x, top = piece.x + self._across(symbol), piece.top
            if seen_again:  # a line above where it is known from
                marks.append(line(x - C // 2, top - gap, x + C // 2, top - gap, "staff"))
            self._band(symbol, x, piece.y + gap, top - gap, 2 * PITCH if x == piece.x else PITCH)
        return symbol_group(symbol, self.score, marks)

    def _across(self, symbol: Symbol) -> int:
        """Return where a symbol stands, from the centre: on it where the body turns on the spot."""
        if symbol.part == TURN and symbol.start in self.pivots:
            return 0
        return self.layout.columns.places[symbol.part]

    def _lit(self, symbol: Symbol) -> bool:
        return (symbol.part, symbol.start, symbol.stop) in self.marked

    def _band(self, symbol: Symbol, x: int, y: int, top: int, wide: int = PITCH) -> None:
        """Lay a band over the middle of a symbol's column, if it is marked."""
        if self._lit(symbol):
            self.bands.append(box(x - wide // 2, top, wide, y - top, "band"))

    def _sign(
        self, symbol: Symbol, centre: int, y: int, height: int, seen: tuple[int, int]
    ) -> list[Mark]:
        x = centre + self._across(symbol)
        if x == centre:
            return turn(symbol, x, y, max(seen[1] - seen[0], 1), PITCH)
        kind = kind_of(symbol.part)
        if symbol.part == TURN and symbol.start in self.circles:
            kind = "circle"
        elif kind == "gesture" and symbol.direction is None:
            kind = "again"
        if own := SIGNS.get(kind):
            return own(symbol, x, y, max(seen[1] - seen[0], 1))
        direction, level = symbol.direction, symbol.level
        return sign(x - C // 2, y, direction, level, max(height, 1), seen, left=x < centre)

    def _beside(self, symbol: Symbol, low: int, high: int) -> MarkGroup:
        """Return a symbol without a column: a flight, or a touch."""
        marks, start, stop = list[Mark](), -PITCH, PITCH
        kind = KINDS[kind_of(symbol.part)]
        if kind.name == "touch":
            thing = kind.amount(symbol.amount or 0)
            start, stop = self.layout.columns.touched(symbol.part, thing)
        for piece in self.layout.pieces(low, max(high, low + 1)):
            if kind.name == "jump":
                ends = piece.y - GAP, piece.top + GAP
                marks += [line(x, ends[0], x, ends[1]) for x in (piece.x + start, piece.x + stop)]
            elif piece.low == 0:
                marks.append(bow(piece.x + start, piece.x + stop, piece.y + BOW // 2))
            self._band(symbol, piece.x + (start + stop) // 2, piece.y, piece.top, stop - start)
        return symbol_group(symbol, self.score, marks)


def short(seconds: float) -> str:
    """Return a time in as few digits as tell milliseconds."""
    return f"{seconds:.3f}".rstrip("0").rstrip(".")


def symbol_group(symbol: Symbol, score: Score, marks: list[Mark]) -> MarkGroup:
    """Return the marks of a symbol with its words and what programs read."""
    span = symbol.start, symbol.stop
    start, stop = (short(score.rate.denominator * it / score.rate.numerator) for it in span)
    data = {"part": symbol.part, "direction": symbol.direction, "level": symbol.level}
    data |= {"amount": None if symbol.amount is None else str(symbol.amount)}
    data |= {"start": start, "end": stop}
    when = f"{start} s" if start == stop else f"{start}-{stop} s"
    words = plain(symbol.words) or "goes on so" * (kind_of(symbol.part) == "gesture")
    known = {name: it for name, it in data.items() if it is not None}
    told = ", ".join(filter(None, (plain(symbol.part), words, when)))
    return MarkGroup(tuple(marks), told, known)


LEGEND_WIDTH = 13 * C  # room for signs and words

_PITCH = round(1.35 * C)


def legend_rows(kinds: Collection[str], x: int, y: int) -> list[MarkGroup]:
    """Return the rows of the legend: marks and what they mean."""
    rows = [row for row in shipped("draw/legend.toml")["rows"] if not row[1] or row[1] in kinds]
    return [_legend_row(*row, x=x, y=y + _PITCH * number) for number, row in enumerate(rows)]


def legend_signs() -> list[Picture]:
    """Return each sign of the legend alone, with what it means as its title."""
    rows = [_legend_row(*row, x=0, y=0) for row in shipped("draw/legend.toml")["rows"]]
    return [Picture(2 * C, _PITCH, it.title, it.title, it.marks[:-1]) for it in rows]


def _legend_row(
    name: str, kind: str, direction: str, degree: Any, words: str, *, x: int, y: int
) -> MarkGroup:
    """Return a sign from a height downwards, and its words."""
    middle, left = x + C, x + C // 2
    base = y + _PITCH - (_PITCH - C) // 2
    marks: dict[str, list[Mark]] = {
        "cell": sign(left, base, direction, degree or None, C),
        "hold": [Circle(middle, base - C // 2, ONE // 2)],
        "touch": [bow(left, left + C, base - C // 2 + BOW // 2)],
        "flight": [line(middle + at, base, middle + at, base - C) for at in (-C // 3, C // 3)],
        "band": [box(left, base - C, C, C, "band")],
    }
    if name in SIGNS:
        row = blank(1)
        row["direction"], row["amount"] = DIRECTION_CODES.get(direction, -1), degree
        marks[name] = SIGNS[name](listed("other_support", row)[0], middle, base, C)
    told = Label(x + 2 * C, y + _PITCH // 2 + NAME // 3, words, NAME, "begin")
    return MarkGroup((*marks[name], told), words)
