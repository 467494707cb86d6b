"""A staff: its lines, numbers, names, symbols, holds and legend."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, DIRECTIONS, KINDS, kind_of
from lanindex.draw.layout import (
    GAP,
    LEAST,
    MARGIN,
    PITCH,
    STANCES,
    START,
    PageLayout,
    TimeAxis,
    spread_heights,
)
from lanindex.draw.picture import (
    BOW,
    SIGNS,
    C,
    Circle,
    Label,
    Mark,
    MarkGroup,
    bow,
    box,
    line,
    sign,
)
from lanindex.model import Score, Symbol
from lanindex.model.derived import STEP
from lanindex.model.symbol import blank, listed

_DOUBLE = C // 5
_NAME = round(0.45 * C)
_EPS = 1e-6
_TICKS = C // 4
"""Height of a count from which on each has its tick."""


def staves(layout: PageLayout, clock: TimeAxis) -> list[Mark]:
    """Return all staves without symbols."""
    marks: list[Mark] = []
    last = len(layout.edges) - 2
    inner = layout.columns.inner
    for staff in range(last + 1):
        x, base, top = layout.centre(staff), layout.base, layout.base - layout.height(staff)
        foot = base + (MARGIN + START if staff == 0 else 0)
        marks += [line(x + side, foot, x + side, top, "staff") for side in (-inner, 0, inner)]
        marks += _across(x, base, inner, double=staff == 0)
        marks += _across(x, top, inner, double=staff == last)
        marks += _counts(layout, clock, staff)
    return marks


def _across(x: int, y: int, half: int, *, double: bool) -> list[Mark]:
    ys = (y, y + _DOUBLE) if double else (y,)
    return [line(x - half, it, x + half, it, "staff") for it in ys]


def _counts(layout: PageLayout, clock: TimeAxis, staff: int) -> list[Mark]:
    """Return the ticks of beats, the lines of bars, and the numbers beside them."""
    marks: list[Mark] = []
    x, inner = layout.centre(staff), layout.columns.inner
    bottom, top = layout.edges[staff : staff + 2]
    first = ceil(layout.start + bottom / layout.beat - _EPS)
    bars = ceil(C / (clock.bar * layout.beat))  # that share a number, where they stand close
    for count in range(first, floor(layout.start + top / layout.beat + _EPS) + 1):
        y = layout.base - (round((count - layout.start) * layout.beat) - bottom)
        begins, ends = y >= layout.base, y <= layout.base - (top - bottom)
        if count % clock.bar:
            if not (begins or ends) and layout.beat >= _TICKS:
                marks.append(line(x - C // 4, y, x + C // 4, y, "staff"))
            continue
        if count // clock.bar % bars:
            continue
        if not (begins or ends):
            marks.append(line(x - inner, y, x + inner, y, "light" if clock.seconds else "staff"))
        if not ends:
            at = x - layout.columns.left - GAP * 4
            marks.append(Label(at, y + C // 5, clock.number(count), C // 2 + 10, "end"))
    return marks


def names(layout: PageLayout) -> list[Mark]:
    """Return the names of columns below the first staff."""
    x, y = layout.centre(0), layout.base + 2 * MARGIN + START
    return [
        Label(x + at + _NAME // 3, y, name_of(part), _NAME, "under", turned=True)
        for part, at in layout.columns.places.items()
    ]


def name_of(part: str) -> str:
    """Return a part's name below its column: there its side is plain to see."""
    return part.removeprefix("r_").removeprefix("l_").removeprefix("body_").replace("_", " ")


ONE, BOTH = round(0.55 * C), round(0.8 * C)
"""How wide the circle is that keeps the weight on one foot, or on both."""

_LASTS = 0.5
"""Least counts without a symbol of support that are drawn as a hold of weight."""


def holds(score: Score, clock: TimeAxis, layout: PageLayout) -> list[MarkGroup]:
    """Return a circle wherever feet hold the weight and supports have no symbol."""
    found = []
    for start, stop, feet in _stands(score, clock):
        if stop - start < _LASTS or not layout.start < start < layout.stop:
            continue
        both = len(feet) == 2
        size = BOTH if both else ONE
        low = layout.up(start) + GAP
        piece = next(layout.pieces(low, low + size), None)
        if piece is None or piece.high - piece.low < size:
            continue
        at = 0 if both else layout.columns.places.get(f"{feet[0]}_support", 0)
        sides = "both feet" if both else {"r": "the right foot", "l": "the left foot"}[feet]
        circle = Circle(piece.x + at, piece.y - size // 2, size // 2)
        found.append(MarkGroup((circle,), f"stands on {sides}"))
    return found


def _stands(score: Score, clock: TimeAxis) -> list[tuple[float, float, str]]:
    """Return stretches without a symbol of support, with the feet that hold the weight."""
    changes: list[tuple[float, str, int]] = []
    for part, track in score.tracks.items():
        key = {"stance": part[0], "support": "+", "jump": "+"}.get(kind_of(part))
        if key:
            for start, stop in zip(*clock.symbols(track.symbols), strict=True):
                if start < stop:
                    changes += [(start, key, 1), (stop, key, -1)]
    changes.sort()
    found, state, since, feet = [], {"+": 0, "r": 0, "l": 0}, 0.0, ""
    for index, (time, key, change) in enumerate(changes):
        state[key] += change
        if index + 1 < len(changes) and changes[index + 1][0] <= time:
            continue
        now = "" if state["+"] else "".join(foot for foot in "rl" if state[foot])
        if now != feet:
            if feet:
                found.append((since, time, feet))
            since, feet = time, now
    return found


Key = tuple[str, int, int]
"""Identifies a symbol of a score: its part, first frame and end."""


def _key(symbol: Symbol) -> Key:
    return symbol.part, symbol.start, symbol.stop


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


@dataclass(slots=True)
class _Drawn:
    """A symbol, and from and to which height it stands; a position has no length in time."""

    symbol: Symbol
    low: int
    high: int


class SymbolPainter:
    """Symbols as they come to paper."""

    def __init__(
        self, score: Score, clock: TimeAxis, layout: PageLayout, marked: frozenset[Key]
    ) -> None:
        self.score, self.clock, self.layout, self.marked = score, clock, layout, marked
        self.bands: list[Mark] = []
        self.flights = self._flights()

    def marks(self, parts: Iterable[str]) -> tuple[list[MarkGroup], list[Mark]]:
        """Return the symbols of tracks, and the bands and holds to draw below them."""
        parts = list(parts)
        symbols = [it for part in parts if part not in STANCES for it in self._track(part)]
        held = holds(self.score, self.clock, self.layout) if STANCES & {*parts} else []
        return symbols, [*self.bands, *held]

    def _track(self, part: str) -> list[MarkGroup]:
        """Return the symbols of a track."""
        before, found = self._within(part)
        if part not in self.layout.columns.places:
            happen = [_Drawn(before, 0, 0), *found] if before is not None else found
            return [self._beside(one) for one in happen]
        groups = []
        if before is not None:
            base, centre = self.layout.base + MARGIN // 2, self.layout.centre(0)
            marks = self._sign(before, centre, base + START, START, (0, START))
            groups.append(_group(before, self.score, marks))
            self._band(before, centre + self.layout.columns.places[part], base + START, base)
        spans = spread_heights([(one.low, one.high) for one in found], LEAST)
        return [*groups, *(self._placed(*both) for both in zip(found, spans, strict=True))]

    def _within(self, part: str) -> tuple[Symbol | None, list[_Drawn]]:
        """Return the symbol in force at the beginning, and those that follow."""
        rows = self.score.tracks[part].symbols
        rows = rows[~rows["passing"]]
        begins, ends = (np.array(it) for it in self.clock.symbols(rows))
        start, stop = self.layout.start, self.layout.stop
        lasts = KINDS[kind_of(part)].lasts
        before = np.flatnonzero((ends <= start) & (lasts | (begins == ends)))
        last = listed(part, rows[before[-1:]]) if len(before) else []
        seen = (ends > start) & (begins < stop)
        up = self.layout.up
        found = [
            _Drawn(symbol, up(self._lands(part, low, high)), up(high))
            for symbol, low, high in zip(
                listed(part, rows[seen]), begins[seen].tolist(), ends[seen].tolist(), strict=True
            )
        ]
        return (last[0] if last else None), found

    def _flights(self) -> tuple[list[float], list[float]]:
        jump = self.score.tracks.get("jump")
        return self.clock.symbols(jump.symbols) if jump is not None else ([], [])

    def _lands(self, part: str, start: float, stop: float) -> float:
        """Return when a symbol begins on paper: before a landing both columns of support rest."""
        begins, ends = self.flights
        if kind_of(part) == "support" and begins:
            at = bisect_right(begins, stop - 1e-9) - 1
            if at >= 0 and begins[at] < stop <= ends[at] + 1e-9:
                return max(start, (begins[at] + stop) / 2)
        return start

    def _placed(self, one: _Drawn, span: tuple[int, int]) -> MarkGroup:
        """Return a symbol in its column, on each staff that shows a piece of it."""
        symbol, (low, high) = one.symbol, span
        gap = min(GAP, (high - low) // 4)
        low, high = low + gap, high - gap
        marks: list[Mark] = []
        at = self.layout.columns.places[symbol.part]
        for piece in self.layout.pieces(low, high):
            seen = (piece.low, piece.high)
            marks += self._sign(symbol, piece.x, piece.y, high - low, seen)
            if one.low == one.high:  # seen again: a line above where it is known from
                x, y = piece.x + at, piece.y - piece.high + piece.low
                marks.append(line(x - C // 2, y - gap, x + C // 2, y - gap, "staff"))
            top = piece.y - piece.high + piece.low
            self._band(symbol, piece.x + at, piece.y + gap, top - gap)
        return _group(symbol, self.score, marks)

    def _band(self, symbol: Symbol, x: int, y: int, top: int, wide: int = PITCH) -> None:
        """Lay a band over the middle of a symbol's column, if it is marked."""
        if _key(symbol) in self.marked:
            self.bands.append(box(x - wide // 2, top, wide, y - top, "band"))

    def _sign(
        self, symbol: Symbol, centre: int, y: int, height: int, seen: tuple[int, int]
    ) -> list[Mark]:
        x = centre + self.layout.columns.places[symbol.part]
        if own := SIGNS.get(kind_of(symbol.part)):
            return own(symbol, x, y, max(seen[1] - seen[0], 1))
        where, how = symbol.direction, symbol.level
        return sign(x - C // 2, y, where, how, max(height, 1), seen, left=x < centre)

    def _beside(self, one: _Drawn) -> MarkGroup:
        """Return a symbol without a column: a flight, or a touch."""
        symbol, marks = one.symbol, list[Mark]()
        start, stop = -PITCH, PITCH
        kind = KINDS[kind_of(symbol.part)]
        if kind.name == "touch":
            thing = kind.amount(symbol.amount or 0)
            start, stop = self.layout.columns.touched(symbol.part, thing)
        for piece in self.layout.pieces(one.low, max(one.high, one.low + 1)):
            top = piece.y - piece.high + piece.low
            if kind.name == "jump":
                marks += [
                    line(piece.x + at, piece.y - GAP, piece.x + at, top + GAP)
                    for at in (start, stop)
                ]
            elif piece.low == 0:
                marks.append(bow(piece.x + start, piece.x + stop, piece.y + BOW // 2))
            self._band(symbol, piece.x + (start + stop) // 2, piece.y, top, stop - start)
        return _group(symbol, self.score, marks)


def short(seconds: float) -> str:
    """Return a time in as few digits as tell milliseconds."""
    return f"{seconds:.3f}".rstrip("0").rstrip(".")


_SIDES = {"r_": "right ", "l_": "left "}


def _group(symbol: Symbol, score: Score, marks: list[Mark]) -> MarkGroup:
    """Return a symbol's marks with title and data."""
    span = symbol.start, symbol.stop
    start, stop = (short(score.rate.denominator * it / score.rate.numerator) for it in span)
    said = {
        "part": symbol.part,
        "direction": symbol.direction,
        "level": symbol.level,
        "amount": None if symbol.amount is None else str(symbol.amount),
        "start": start,
        "end": stop,
    }
    part = symbol.part
    part = (_SIDES.get(part[:2], part[:2]) + part[2:]).replace("_", " ")
    when = f"{start} s" if start == stop else f"{start}-{stop} s"
    words = f"{symbol.words}, " if symbol.words else ""
    return MarkGroup(tuple(marks), f"{part}, {words}{when}",
                 {name: it for name, it in said.items() if it is not None})  # fmt: skip


LEGEND_WIDTH = 13 * C
"""Room for signs and words."""

_PITCH = round(1.35 * C)
_NAME = round(0.45 * C)

_LEVELS = {
    "high": "high; a support: on the toes",
    "mid": "middle",
    "low": "low; a support: knees bent",
}

_SAMPLES = {
    "turn": ("body_turn", "right", 90, "turns, so many degrees"),
    "twist": ("torso_twist", "left", 45, "is twisted, so many degrees"),
    "incline": ("torso_incline", "forward", 45, "leans, so many degrees"),
    "travel": ("body_travel", "forward", 0, "goes somewhere"),
    "bend": ("r_arm_bend", None, 3, "bends so far (6: all); posts: stretches"),
    "carrier": ("other_support", None, 1, "carries, beside the feet or alone"),
}
"""By kind with a sign of its own: track, direction and amount of a sample, and its meaning."""


def legend_rows(
    kinds: Collection[str], x: int, y: int, *, marked: bool = False
) -> tuple[list[MarkGroup], int]:
    """Return the rows of the legend, and their height."""
    rows = list[MarkGroup]()
    for number, (marks, said) in enumerate(_rows(kinds, x + C, y + _PITCH, marked)):
        words = Label(
            x + 2 * C, y + number * _PITCH + _PITCH // 2 + _NAME // 3, said, _NAME, "begin"
        )
        rows.append(MarkGroup((*marks, words), said))
    return rows, len(rows) * _PITCH


def _rows(kinds: Collection[str], x: int, y: int, marked: bool) -> Iterator[tuple[list[Mark], str]]:
    """Yield the marks and the meaning of each row."""
    step, size, left = _PITCH, C, x - C // 2

    def low() -> int:
        nonlocal y
        y += step
        return y - step - (step - size) // 2

    for name in DIRECTIONS:
        yield (
            sign(left, low(), name, None, size),
            name.replace("r_", "right ").replace("l_", "left "),
        )
    for level, said in _LEVELS.items():
        yield sign(left, low(), "place", level, size), said
    for kind, (part, direction, amount, said) in _SAMPLES.items():
        if kind in kinds:
            yield SIGNS[kind](_sample(part, direction, amount), x, low(), size), said
    if "stance" in kinds:
        yield [Circle(x, low() - size // 2, ONE // 2)], "stands, while supports are silent"
    if "touch" in kinds:
        yield [bow(left, left + C, low() - size // 2 + BOW // 2)], "touches"
    if "jump" in kinds:
        base = low()
        yield [line(x + at, base, x + at, base - size) for at in (-C // 3, C // 3)], "is in the air"
    if marked:
        yield [box(left, low() - size, C, size, "band")], "is what was asked for"


def _sample(part: str, direction: str | None, amount: int) -> Symbol:
    row = blank(1)
    row["direction"] = -1 if direction is None else DIRECTION_CODES[direction]
    row["amount"] = amount
    return listed(part, row)[0]
