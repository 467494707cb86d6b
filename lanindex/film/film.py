"""A motion and its score as a film: the figure, and beside it the staff with a line that moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from math import floor, inf
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import ExportError, UsageError, shown
from lanindex.film import reel as reels
from lanindex.film.figure import Figure
from lanindex.film.paint import LINE, PAPER, Painter
from lanindex.film.scene import scene
from lanindex.film.staff import Staff
from lanindex.film.view import View, front, view
from lanindex.model import Score, Symbol

if TYPE_CHECKING:
    from PIL.Image import Image

SIZE = (640, 480)
"""Width and height of a film, pixels."""

SMALLEST, LARGEST = 120, 4096
"""Pixels that either may be."""

SHARE = 0.5
"""Of the width that the staff takes, at most."""

FLASH = 0.2
"""Seconds for which a bone is lit, at least."""

AUTO = "auto"
SIDES = {"front": 0.0, "side": -90.0}
"""Views by name: degrees from where the body faces, to its left."""


class Film:
    """A motion beside its score."""

    def __init__(
        self,
        figure: Figure,
        score: Score,
        *,
        start: float = 0.0,
        stop: float | None = None,
        rate: Fraction | int = reels.RATE,
        size: tuple[int, int] = SIZE,
        view: str | float = "auto",
        parts: Sequence[str] | None = None,
        marked: Sequence[Symbol] = (),
        seconds: bool = True,
    ) -> None:
        if len(figure) < 2:
            raise ExportError("a capture of one frame", wanted="a movement")
        _check(size)
        end = min(float(len(figure) / figure.rate), float(score.frames / score.rate))
        stop = end if stop is None else min(stop, end)
        if not 0 <= start < stop:
            wanted = f"a stretch of 0 to {end:g} s"
            raise UsageError(f"nothing from {start:g} s to {stop:g} s", wanted=wanted)
        self.rate, self.size, self.score = Fraction(rate), size, score
        count = max(round((stop - start) * self.rate), 1)
        self.times = start + np.arange(count) / float(self.rate)
        shown = np.floor(self.times * float(figure.rate) + 1e-6).astype(np.int64)
        self.frames = np.minimum(shown, len(figure) - 1)
        self.staff = Staff(
            score,
            start,
            stop,
            (round(SHARE * size[0]), size[1]),
            parts=parts,
            marked=marked,
            seconds=seconds,
        )
        room = (size[0] - self.staff.width, size[1])
        eye = self._eye(figure, view, parts, marked)
        self.scene = scene(figure, self.frames, eye, room, float(self.rate))
        lit = self._lit(figure, marked)
        self.painter = Painter(figure, self.scene, lit, float(self.rate))

    def __len__(self) -> int:
        """Return the number of film frames."""
        return len(self.times)

    def _eye(
        self,
        figure: Figure,
        named: str | float,
        parts: Sequence[str] | None,
        marked: Sequence[Symbol],
    ) -> View:
        """Return from where it is seen."""
        first, last = int(self.frames[0]), int(self.frames[-1]) + 1
        if named != AUTO:
            return front(figure, first, last, turned_of(named))
        if marked:
            ratio = figure.rate / self.score.rate
            begins, ends = (
                floor(edge(getattr(it, name) for it in marked) * ratio)
                for name, edge in (("start", min), ("stop", max))
            )
            some = max(first, begins), min(last, ends)
            if some[0] < some[1]:
                first, last = some
            parts = list(dict.fromkeys(it.part for it in marked))
        return view(figure, parts, first, last)

    def _lit(self, figure: Figure, marked: Sequence[Symbol]) -> NDArray[np.bool_]:
        """Return which bones are coloured when, (N, B)."""
        lit = np.zeros((len(self), len(figure.bones)), bool)
        bones: dict[str, NDArray[np.bool_]] = {}
        for symbol in marked:
            if symbol.part not in bones:
                bones[symbol.part] = figure.shown([symbol.part])
            start, stop = (float(it / self.score.rate) for it in (symbol.start, symbol.stop))
            stop = max(stop, start + FLASH)
            first, last = np.searchsorted(self.times, (start - 1e-6, stop - 1e-6)).tolist()
            lit[first:last, bones[symbol.part]] = True
        return lit

    def pictures(self) -> Iterator[Image]:
        """Yield the frames, RGB, one after another."""
        from PIL import Image, ImageDraw

        left, page, base = self.scene.size[0], None, None
        for number, time in enumerate(self.times.tolist()):
            staff, down = self.staff.at(time)
            if staff is not page or base is None:
                page, base = staff, Image.new("RGB", self.size, PAPER)
                base.paste(staff, (left, 0))
                if self.painter.still:
                    self.painter.ground(base)
            frame = base.copy()
            self.painter.paint(number, frame)
            line = (left, down - 1, self.size[0], down)
            ImageDraw.Draw(frame).rectangle(line, fill=LINE)
            yield frame

    def written(
        self, form: str, watched: Callable[[Iterator[Image]], Iterator[Image]] = iter
    ) -> bytes:
        """Return it as a file."""
        try:
            return reels.reel(watched(self.pictures()), form, self.size, self.rate)
        except ImportError as error:
            remedy = "It comes with: pip install 'lanindex[film]'."
            raise ExportError(
                f"{error.name} is not installed", place=form, remedy=remedy
            ) from error


def turned_of(named: str | float) -> float:
    """Return how far from the front a view is that has a name or is told in degrees.

    >>> from lanindex.film.film import turned_of
    >>> turned_of("side"), turned_of("45")
    (-90.0, 45.0)
    """
    try:
        degrees = SIDES[named] if isinstance(named, str) and named in SIDES else float(named)
    except ValueError:
        degrees = inf
    if not -360 <= degrees <= 360:
        wanted = f"{AUTO}, {', '.join(SIDES)} or degrees of -360 to 360"
        raise UsageError(f'the view "{shown(str(named))}"', wanted=wanted)
    return degrees


def _check(size: tuple[int, int]) -> None:
    for side in size:
        if not SMALLEST <= side <= LARGEST or side % 2:
            wanted = f"even numbers of {SMALLEST} to {LARGEST}"
            raise UsageError(f"a film of {size[0]}x{size[1]} pixels", wanted=wanted)
