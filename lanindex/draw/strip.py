"""`Staff`: a score on one upright staff, of which windows are drawn that fit together."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from math import ceil, floor
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from lanindex import records
from lanindex.alphabet import kind_of
from lanindex.draw import svg
from lanindex.draw.picture import PIXEL, C, Circle, Label, Mark, MarkGroup, Picture, line
from lanindex.draw.plain import plain
from lanindex.draw.staff import (
    BEAT,
    DOUBLE,
    MARGIN,
    NAMES,
    PITCH,
    PITCHES,
    STANCES,
    START,
    Heights,
    PageLayout,
    SymbolPainter,
    TimeAxis,
    chosen,
    column_names,
    count_lines,
    holds,
    keys_of,
    last_second,
    settled,
    staff_columns,
    symbol_group,
)
from lanindex.errors import UsageError
from lanindex.model import Score, Symbol
from lanindex.model.score import rows_of
from lanindex.model.symbol import listed

FOOT = MARGIN + START + NAMES + MARGIN
"""Units below a window for the positions in which it begins, and the names of the columns."""

_AROUND = 2 * C  # units above and below a window in which marks that reach into it may stand


class Column(NamedTuple):
    """Where a column is, pixels from the left of the staff."""

    left: float
    right: float


class Staff:
    """A score on one upright staff of any length, of which windows are drawn.

    Pixels are those of the whole staff, counted from its upper end, where the score ends. A
    window from `start` to `stop` shows what lies from ``y(stop)`` down to ``y(start)``: windows
    that follow each other fit together. `lanindex.Library.staff` makes that of a capture.

    Parameters
    ----------
    score : Score
        What is drawn.
    parts : sequence of str, optional
        Its columns; else those that a reader expects. They are the same in all windows.
    detail : str
        ``plain``: what a reader expects; ``full``: all that is known, as `parts` always are.
    marked : iterable of Symbol
        Symbols below which a band is laid.
    seconds : bool
        Whether counts are seconds, not beats.
    start, stop : float, optional
        Seconds of the window that is meant where none is given.
    scale : float
        Pixels of a tenth of a column's width, about: 56 pixels a second at 1.
    stretch : float
        How many times as high a second is, beside signs of the same width.
    title : str
        What it shows.
    columns : collection of str, optional
        Its columns, drawn as a reader expects; else those that this score needs.
    firsts : mapping of str to int, optional
        By track the ordinal of its first row, where the score is a stretch of a longer one.

    Attributes
    ----------
    columns : dict of str to Column
        ``left`` and ``right`` of each track's column, pixels.
    width, height : float
        Of the whole staff, pixels, without what stands below its lower end.
    window : tuple of float
        Seconds from and to which is meant.
    warnings : tuple of str
        What is not drawn.

    Examples
    --------
    >>> import lanindex
    >>> staff = lanindex.Staff(lanindex.read_lnd("corpus/compass.lnd"))
    >>> staff.y(0.0) == staff.height, round(staff.seconds(staff.y(2.5)), 6)
    (True, 2.5)
    >>> for name, symbol in list(staff.symbols(0.0, 3.0).items())[:2]:
    ...     print(name, symbol["words"])
    r_arm.0 right arm, place low, 0 s
    r_arm.1 right arm, forward low, 0-0.75 s
    >>> staff.on(2.0, 4.0).window, staff.picture(2.0, 4.0).warnings
    ((2.0, 4.0), ())
    >>> tile = staff.svg(0.0, 3.0, foot=False)
    >>> tile.startswith("<svg"), 'data-symbol="r_arm.1"' in tile
    (True, True)
    >>> staff.tile(0.0, 1.0)["times"]
    [0.0, 0.75, 1.0]
    """

    def __init__(
        self,
        score: Score,
        *,
        parts: Sequence[str] | None = None,
        detail: str = "plain",
        marked: Iterable[Symbol] = (),
        seconds: bool = False,
        start: float = 0.0,
        stop: float | None = None,
        scale: float = 1.0,
        stretch: float = 1.0,
        title: str = "",
        columns: Collection[str] | None = None,
        firsts: Mapping[str, int] | None = None,
    ) -> None:
        if detail not in ("plain", "full"):
            raise UsageError(f'"{detail}"', wanted="plain or full")
        if not 0 < scale <= 100:
            raise UsageError(f"a scale of {scale:g}", wanted="more than 0, 100 at most")
        if not 0.1 <= stretch <= 10:
            raise UsageError(f"stretched {stretch:g} times", wanted="0.1 to 10 times")
        self.score, self.title, self.scale = score, title or "score", scale
        marks = list(settled(score, marked))
        full = parts is not None or detail == "full"
        self.drawn = score if full else plain(score, marks, columns)
        if columns is not None:
            parts = [part for part in self.drawn.tracks if part in columns]
        self.tracks, missing = chosen(self.drawn, parts, {it.part for it in marks})
        self._firsts = firsts or {}
        self.warnings = tuple(missing)
        self.duration = float(score.frames / score.rate)
        self.window = start, last_second(self.duration, start, stop)
        clock = TimeAxis(self.drawn, seconds)
        self._times, self._counts = self._knots(TimeAxis(score, seconds))
        end, placed = float(self._counts[-1]), staff_columns(self.tracks)
        self._beat = round(BEAT * stretch)
        self._whole = max(round(end * self._beat), self._beat)  # units
        edges = 0, self._whole
        self._layout = PageLayout(clock, 0.0, max(end, 1.0), edges, placed, 0, self._beat, 0, 1)
        self._painter = SymbolPainter(self._layout, keys_of(score, marks))
        centre, pixel = self._layout.centre(0), scale / PIXEL
        self.columns = {
            part: Column((centre + at - half) * pixel, (centre + at + half) * pixel)
            for part, at in placed.places.items()
            for half in [PITCHES.get(kind_of(part), PITCH) // 2]
        }
        self.width, self.height = self._layout.size[0] * pixel, self._whole * pixel

    def _knots(self, clock: TimeAxis) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return seconds (K,) and their counts, between which time passes evenly."""
        if clock.seconds:
            times = np.array([0.0, self.duration])
            return times, times
        frames, ticks = clock.knots()
        rises = np.append(True, np.diff(ticks) > 0)  # else counts would tell no time
        times = frames[rises] / float(self.score.rate)
        counts = ticks[rises] * (self.score.meter.beats / self.score.meter.division)
        more = [self.duration] if times[-1] < self.duration else []
        return np.append(times, more), np.append(counts, [clock.at(it) for it in more])

    def on(self, start: float = 0.0, stop: float | None = None) -> Self:
        """Return the same staff with another window that is meant."""
        window = start, last_second(self.duration, start, stop)
        self._held  # noqa: B018 (worked out once for all)
        other = copy(self)
        other.window = window
        return other

    def y(self, seconds: float) -> float:
        """Return how far down a time is on the whole staff, pixels; later ones are further up."""
        return (self._whole - self._up(seconds)) * self.scale / PIXEL

    def _up(self, seconds: float) -> float:
        return float(np.interp(seconds, self._times, self._counts)) * self._beat

    def seconds(self, y: float) -> float:
        """Return the time at a height of the whole staff, pixels: the inverse of `y`."""
        count = (self._whole - y * PIXEL / self.scale) / self._beat
        return float(np.interp(count, self._counts, self._times))

    def svg(
        self, start: float | None = None, stop: float | None = None, *, foot: bool = True
    ) -> str:
        """Return a window as SVG.

        Each symbol is a group with ``data-symbol``, as `symbols` names it, also where a window
        shows a piece of it only. Ink has the colour of the text around (``currentColor``).

        Parameters
        ----------
        start, stop : float, optional
            Seconds; else those of `window`.
        foot : bool
            Draw below it the positions in which it begins, and the names of the columns.

        Returns
        -------
        str
            As wide as the staff, and ``y(start) - y(stop)`` pixels high without a foot.
        """
        return svg.write(self.picture(start, stop, foot=foot), scale=self.scale)

    def picture(
        self, start: float | None = None, stop: float | None = None, *, foot: bool = True
    ) -> Picture:
        """Return a window as a `Picture`: see `svg`."""
        start, stop = self._within(start, stop)
        low, high = (round(self._up(it)) for it in (start, stop))
        high = max(high, low + 1)
        edge = low if foot else 0  # what reaches below a foot is cut; else windows fit together
        layout = replace(self._layout, base=high - edge, edges=(edge, self._whole))
        painter, groups = self._painter.on(layout), list[MarkGroup]()
        near = low - _AROUND * (not foot), high + _AROUND
        for part in self._shown:
            heights, ordinals = self._heights[part]
            at = _between(heights.drawn, *near)
            symbols, numbers = listed(part, heights.rows[at]), heights.numbers[at].tolist()
            drawn = painter.drawn(symbols, heights.times[at], heights.drawn[at])
            begun = painter.begun(part, low / self._beat) if foot else []
            groups += [
                replace(it, data={"symbol": f"{part}.{ordinals[number]}", **it.data})
                for number, it in (*begun, *zip(numbers, drawn, strict=True))
                if it.marks
            ]
        marks: list[Mark] = [*painter.bands, *self._holds(high, *near)]
        marks += self._lines(layout, low, high, foot=foot)
        title = f"{self.title}, {start:g}-{stop:g} s"
        summary = f"Labanotation, time upwards: {', '.join(self.tracks)}"
        tall = high - low + FOOT * foot
        return Picture(layout.size[0], tall, title, summary, (*marks, *groups), self.warnings)

    def tile(self, start: float, stop: float) -> dict[str, Any]:
        """Return a window as a page takes it that moves the staff below a line.

        Returns
        -------
        dict
            ``svg``: the window, below the first one the starting positions, and below all of them
            the names of the columns; ``times`` (K,) seconds and ``ys`` (K,) how far down they are,
            straight between them; ``names``: how far down the names begin. In units of the
            drawing's ``viewBox``.
        """
        start, stop = self._within(start, stop)
        first, layout = start <= 0, self._layout
        picture = self.picture(start, stop, foot=first)
        high = round(self._up(stop))
        base = picture.height - FOOT if first else picture.height
        if not first:
            names = column_names(layout, layout.centre(0), base + 2 * MARGIN + START)
            marks = (*picture.marks, *names)
            picture = replace(picture, height=base + FOOT, marks=marks)
        inside = self._times[(self._times > start) & (self._times < stop)]
        times = [start, *inside.tolist(), stop]
        ys = [high - self._up(it) for it in times]
        return {
            "svg": svg.write(picture),
            "times": times,
            "ys": ys,
            "names": base + START + 3 * MARGIN // 2,
        }

    def symbols(
        self, start: float | None = None, stop: float | None = None
    ) -> dict[str, dict[str, Any]]:
        """Return the symbols of a window by their names, such as ``r_arm.12``.

        Parameters
        ----------
        start, stop : float, optional
            Seconds; else those of `window`.

        Returns
        -------
        dict of str to dict
            By track and ordinal: ``score.symbols(track)[ordinal]`` is the symbol, whatever the
            staff leaves out. The record of the symbol as it is drawn, beside ``start`` and ``end``
            in seconds, and ``words``.
        """
        start, stop = self._within(start, stop)
        rate, found = float(self.score.rate), dict[str, dict[str, Any]]()
        for part in self.tracks:
            rows, ordinals = rows_of(self.drawn, part), self._heights[part][1]
            at = np.flatnonzero((rows["stop"] >= start * rate) & (rows["start"] < stop * rate))
            for symbol in listed(part, rows[at], ordinals[at].tolist()):
                found[f"{part}.{symbol.ordinal}"] = {
                    **records.of_symbol(symbol),
                    "start": round(symbol.start / rate, 6),
                    "end": round(symbol.stop / rate, 6),
                    "words": symbol_group(symbol, self.score, []).title,
                }
        return found

    def _within(self, start: float | None, stop: float | None) -> tuple[float, float]:
        start = self.window[0] if start is None else start
        stop = self.window[1] if stop is None else stop
        return start, last_second(self.duration, start, stop)

    @cached_property
    def _shown(self) -> list[str]:
        """The tracks whose symbols are drawn; feet that stand are drawn as holds."""
        return [part for part in self.tracks if part not in STANCES]

    @cached_property
    def _heights(self) -> dict[str, tuple[Heights, NDArray[np.int64]]]:
        """By track, how high its symbols are, and which of the score's all those drawn are."""
        return {
            part: (
                self._painter.heights(part),
                self._firsts.get(part, 0)
                + _ordinals(part, self.score.tracks[part].symbols, rows_of(self.drawn, part)),
            )
            for part in self.tracks
        }

    @cached_property
    def _held(self) -> tuple[NDArray[np.int64], list[MarkGroup]]:
        """How far up each hold of weight is, (H, 2) units, and what is drawn there."""
        if not STANCES & {*self.tracks} or not self._heights:  # which tell where supports end
            return np.zeros((0, 2), np.int64), []
        groups = holds(self._layout, self._painter.tops)
        ups = [-mark.y for it in groups for mark in it.marks[:1] if isinstance(mark, _PLACED)]
        return np.stack((ups, ups), axis=1).reshape(-1, 2), groups

    def _holds(self, base: int, low: int, high: int) -> list[MarkGroup]:
        heights, groups = self._held
        return [_moved(groups[at], base) for at in _between(heights, low, high).tolist()]

    def _lines(self, layout: PageLayout, low: int, high: int, *, foot: bool) -> list[Mark]:
        """Return the lines of a window, ticks and numbers of counts, and names of columns."""
        x, inner, base = layout.centre(0), layout.columns.inner, high - low
        below = base + (MARGIN + START) * foot
        marks: list[Mark] = [
            line(x + side, below, x + side, 0, "staff") for side in (-inner, 0, inner)
        ]
        ends = [high, high - self._whole, high - self._whole + DOUBLE]
        ends += [base, base + DOUBLE] * foot
        seen = sorted({it for it in ends if -DOUBLE <= it <= below})
        marks += [line(x - inner, y, x + inner, y, "staff") for y in seen]
        first, last = (
            max(ceil((low - C * (not foot)) / self._beat), 0),
            floor((high + C) / self._beat),
        )
        last = min(last, floor(self._whole / self._beat + 1e-6))
        marks += count_lines(layout, 0, range(first, last + 1))
        return marks + (column_names(layout, x, base + 2 * MARGIN + START) if foot else [])


_PLACED = (Circle, Label)


def _between(heights: NDArray[np.int64], low: int, high: int) -> NDArray[np.int64]:
    """Return which of some heights, (S, 2), reach into a stretch."""
    return np.flatnonzero((heights[:, 1] >= low) & (heights[:, 0] <= high) & (heights[:, 0] > -2))


def _moved(group: MarkGroup, down: int) -> MarkGroup:
    placed = [replace(it, y=it.y + down) for it in group.marks if isinstance(it, _PLACED)]
    return replace(group, marks=tuple(placed))


def _ordinals(part: str, rows: NDArray[Any], told: NDArray[Any]) -> NDArray[np.int64]:
    """Return which rows of a track, (S,), those of them are that are drawn, (D,), in order.

    What was joined with others keeps its end, if it is a gesture that leads somewhere, else where
    it begins.
    """
    ends = np.full(len(told), kind_of(part) == "gesture") & (told["direction"] >= 0)
    passing, edges = rows["passing"].tolist(), (rows["start"].tolist(), rows["stop"].tolist())
    columns = (it.tolist() for it in (ends, told["start"], told["stop"]))
    at, found = 0, []
    for end, start, stop in zip(*columns, strict=True):
        wanted, own = (stop, edges[1]) if end else (start, edges[0])
        while passing[at] or own[at] != wanted:
            at += 1
        found.append(at)
        at += 1
    return np.array(found, np.int64)
