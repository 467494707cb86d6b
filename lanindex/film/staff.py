"""The staff beside a figure: pages, each drawn once, and the place of a moment on them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import lru_cache
from io import BytesIO
from math import floor
from typing import TYPE_CHECKING

import numpy as np

from lanindex.draw import draw
from lanindex.draw.layout import (
    BEAT,
    MARGIN,
    NAMES,
    NUMBERS,
    START,
    TimeAxis,
    has_column,
    staff_columns,
    usual_tracks,
)
from lanindex.draw.picture import PIXEL
from lanindex.draw.staff import settled
from lanindex.draw.svg import rendered
from lanindex.film.scene import PAPER
from lanindex.model import Score, Symbol, Track

if TYPE_CHECKING:
    from PIL.Image import Image


class DrawnRows:
    """What is drawn of each track, in order."""

    def __init__(self, score: Score) -> None:
        self.score, self._held = score, {}
        for part, track in score.tracks.items():
            rows = track.symbols[~track.symbols["passing"]]
            ends = np.maximum.accumulate(rows["stop"])  # when it and all before it are over
            self._held[part] = rows, np.ascontiguousarray(rows["start"]), ends

    def around(self, start: float, stop: float, parts: Collection[str] | None = None) -> Score:
        """Return the score with the rows of a stretch alone, seconds: one more on either side."""
        tracks, rate = {}, float(self.score.rate)
        for part, (rows, begins, ends) in self._held.items():
            if parts is None or part in parts:
                first = int(np.searchsorted(ends, start * rate, "right"))
                last = int(np.searchsorted(begins, stop * rate, "left"))
                some = rows[max(first - 1, 0) : max(last, first) + 1]
                tracks[part] = Track(part, some, self.score.tracks[part].known)
        return replace(self.score, tracks=tracks)


USUAL, LARGEST = 1.0, 1.6
"""Usual and largest scale of symbols; the usual one where one page cannot hold a film."""

_BELOW = MARGIN + START + NAMES + MARGIN  # the staff's beginning, in units
_AROUND = 2 * MARGIN + _BELOW
_KNOTS = 33  # moments of a page whose places are worked out; others lie between


class FilmStaff:
    """A score, page by page."""

    def __init__(
        self,
        score: Score,
        start: float,
        stop: float,
        size: tuple[int, int],
        *,
        parts: Sequence[str] | None = None,
        marked: Sequence[Symbol] = (),
        seconds: bool = True,
    ) -> None:
        there = [part for part in score.tracks if len(score.tracks[part])]
        self.score, self.start, self.stop, self.seconds = score, start, stop, seconds
        self.parts = list(parts or (part for part in usual_tracks(there) if has_column(part)))
        self.rate = 1.0 if seconds else float(score.meter.speed / 60)  # counts a second
        own = staff_columns(self.parts)
        wide = 2 * MARGIN + NUMBERS + own.left + own.right
        all_of_it = _AROUND + BEAT * max((stop - start) * self.rate, 1.0)
        fits = min(max(PIXEL * size[1] / all_of_it, USUAL), LARGEST)
        most = (size[0] / wide, size[1] / (_AROUND + BEAT))
        self.scale = min(fits, *(PIXEL * it for it in most))
        self.width, self.height = min(round(wide * self.scale / PIXEL), size[0]), size[1]
        counts = floor((PIXEL * self.height / self.scale - _AROUND) / BEAT + 1e-9)
        self.lasts = max(counts, 1) / self.rate
        self.warnings: dict[str, None] = {}
        self._rows = _rows(score)
        self._marked = defaultdict[int, list[Symbol]](list)
        for symbol in settled(score, marked):
            first, last = (self._page(float(it / score.rate)) for it in (symbol.start, symbol.stop))
            for page in range(max(first, 0), last + 1):
                self._marked[page].append(symbol)
        self._number = -1
        self._shown: tuple[Image, list[float], list[float]]

    def at(self, seconds: float) -> tuple[Image, float]:
        """Return the page that shows a moment, and how far down on it the moment lies, pixels."""
        number = self._page(seconds)
        if number != self._number:
            self._shown, self._number = self._drawn(number), number
        picture, times, downs = self._shown
        return picture, float(np.interp(seconds, times, downs))

    def _page(self, seconds: float) -> int:
        return floor((seconds - self.start) / self.lasts + 1e-9)

    def _drawn(self, number: int) -> tuple[Image, list[float], list[float]]:
        """Return a page, some of its moments, and their places from the top."""
        from PIL import Image

        start = self.start + number * self.lasts
        stop = min(start + self.lasts, self.stop)
        score = self._rows.around(start, stop)
        picture = draw(
            score,
            parts=self.parts,
            start=start,
            stop=stop,
            bars=None,
            seconds=self.seconds,
            marked=self._marked.get(number, ()),
        )
        self.warnings |= dict.fromkeys(picture.warnings)
        scale = min(self.scale, PIXEL * self.height / picture.height)
        with Image.open(BytesIO(rendered(picture, "png", scale))) as image:
            page = Image.new("RGB", (self.width, self.height), PAPER)
            page.paste(image.convert("RGB"), (0, self.height - image.height))
        clock = TimeAxis(score, self.seconds)
        times = np.linspace(start, stop, _KNOTS).tolist()
        begin = clock.at(start)
        ups = [_BELOW + (clock.at(it) - begin) * BEAT for it in times]
        return page, times, [self.height - up * scale / PIXEL for up in ups]


@lru_cache(maxsize=1)  # for many films of one capture
def _rows(score: Score) -> DrawnRows:
    return DrawnRows(score)
