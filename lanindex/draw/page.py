"""The symbols of a score as they come to paper."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import KINDS, kind_of
from lanindex.draw import columns as places
from lanindex.draw.clock import Clock
from lanindex.draw.holds import holds
from lanindex.draw.layout import GAP, LEAST, MARGIN, START, Layout, apart
from lanindex.draw.picture import C, Group, Mark, box, line
from lanindex.draw.shapes import sign
from lanindex.draw.signs import BOW, SIGNS, bow
from lanindex.model import Score, Symbol
from lanindex.model.steps import STEP
from lanindex.model.symbol import listed

Key = tuple[str, int, int]
"""What tells a symbol of a score from others: its part, first frame and end."""


def _key(symbol: Symbol) -> Key:
    return symbol.part, symbol.start, symbol.stop


def settled(score: Score, symbols: Iterable[Symbol]) -> Iterator[Symbol]:
    """Yield symbols of a score; of what is passed that on whose way it is."""
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
    """Return what is marked: of a step that of the foot, of what is passed that on whose way."""
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


class Page:
    """Symbols as they come to paper."""

    def __init__(self, score: Score, clock: Clock, layout: Layout, marked: frozenset[Key]) -> None:
        self.score, self.clock, self.layout, self.marked = score, clock, layout, marked
        self.bands: list[Mark] = []
        self.flights = self._flights()

    def marks(self, parts: Iterable[str]) -> tuple[list[Group], list[Mark]]:
        """Return the symbols of some tracks, and what else there is: bands below, and holds."""
        parts = list(parts)
        symbols = [it for part in parts if part not in places.STANCES for it in self._track(part)]
        held = holds(self.score, self.clock, self.layout) if places.STANCES & {*parts} else []
        return symbols, [*self.bands, *held]

    def _track(self, part: str) -> list[Group]:
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
        spans = apart([(one.low, one.high) for one in found], LEAST)
        return [*groups, *(self._placed(*both) for both in zip(found, spans, strict=True))]

    def _within(self, part: str) -> tuple[Symbol | None, list[_Drawn]]:
        """Return what is in force at the beginning, and the symbols behind it."""
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

    def _placed(self, one: _Drawn, span: tuple[int, int]) -> Group:
        """Return a symbol in its column, on each staff that shows some of it."""
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

    def _band(self, symbol: Symbol, x: int, y: int, top: int, wide: int = places.PITCH) -> None:
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

    def _beside(self, one: _Drawn) -> Group:
        """Return a symbol without a column: a flight, or a touch."""
        symbol, marks = one.symbol, list[Mark]()
        start, stop = -places.PITCH, places.PITCH
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


def _group(symbol: Symbol, score: Score, marks: list[Mark]) -> Group:
    """Return a symbol's marks with what they say."""
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
    return Group(tuple(marks), f"{part}, {words}{when}",
                 {name: it for name, it in said.items() if it is not None})  # fmt: skip
