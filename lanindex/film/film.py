"""A motion and its score as a film: the figure, and beside it the staff with a line that moves."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import lru_cache
from io import BytesIO
from math import floor, inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.draw import draw
from lanindex.draw.picture import PIXEL
from lanindex.draw.plain import plain
from lanindex.draw.staff import (
    BEAT,
    MARGIN,
    NAMES,
    NUMBERS,
    START,
    TimeAxis,
    chosen,
    last_second,
    settled,
    staff_columns,
)
from lanindex.draw.svg import rendered
from lanindex.errors import ExportError, UsageError, extra, shown
from lanindex.film.figure import COLORS, LINE, PAPER, Figure, Painter, front, scene
from lanindex.film.figure import view as best_view
from lanindex.model import Score, Symbol

if TYPE_CHECKING:
    from PIL.Image import Image


_X264 = "bframes=0:subme=1:me=dia"  # a third faster on lines that move, a tenth larger

_AV: dict[str, tuple[str, str, dict[str, str], dict[str, str]]] = {
    "mp4": ("libx264", "yuv420p", {"preset": "veryfast", "crf": "23", "x264-params": _X264}, {}),
    "webp": (
        "libwebp_anim",
        "bgra",
        {"lossless": "1", "quality": "10", "compression_level": "1"},
        {"loop": "0"},
    ),
}
"""By ending: codec, pixels, options of the codec and of the file; flat colours are kept as they
are by WebP, which is also faster than to blur them."""

FORMS = (*_AV, "gif")  # what a film can be written as
# Default frames a second: of most forms, and of some
RATE, RATES = Fraction(25), {"webp": Fraction(20), "gif": Fraction(20)}
FASTEST = {"gif": 50}  # what viewers play no faster
_CLEAR, _NOWHERE = 255, (1, 254, 1)  # the colour of a GIF that means "as before": no other
_STEP = 10  # from one shade to the next: Pillow mixes up those that are closer


def form_of(name: str) -> str:
    """Return the form of a file's ending."""
    ending = name.rpartition(".")[2].lower() if "." in name else ""
    if ending not in FORMS:
        raise UsageError(f'"{shown(name)}"', wanted=f"an ending of {', '.join(FORMS)}")
    return ending


def film_bytes(frames: Iterable[Image], form: str, size: tuple[int, int], rate: Fraction) -> bytes:
    """Return frames as a film."""
    if rate > (most := FASTEST.get(form, 1000)):
        wanted = f"{most} at most: viewers of {form} show no more"
        raise UsageError(f"{float(rate):g} frames a second", place="--film-fps", wanted=wanted)
    if form == "gif":
        return b"".join(_gif(frames, size, rate))
    import av

    shots: Any = av.VideoFrame
    codec, pixels, codec_options, options = _AV[form]
    content = BytesIO()
    with av.open(content, "w", format=form, options=options) as container:
        stream: Any = container.add_stream(codec, rate=rate, options=codec_options)
        stream.width, stream.height = size
        stream.pix_fmt = pixels
        stream.codec_context.thread_count = 1  # the same film is then the same bytes everywhere
        for number, frame in enumerate(frames):
            shot = shots.from_image(frame)
            shot.pts, shot.time_base = number, 1 / rate
            container.mux(stream.encode(shot))
        container.mux(stream.encode(None))
    return content.getvalue()


def _gif(frames: Iterable[Image], size: tuple[int, int], rate: Fraction) -> Iterator[bytes]:
    """Yield the pieces of a GIF."""
    from PIL import Image
    from PIL.GifImagePlugin import getdata

    shades = []  # from paper to all that is drawn
    for color in COLORS:
        way = np.array(color) - PAPER
        share = np.linspace(0, 1, 1 + abs(way).max() // _STEP)
        shades.append(PAPER + share[:, None] * way)
    colors: list[int] = np.concatenate(shades).round().astype(int).ravel().tolist()
    colors += [*_NOWHERE] * (256 - len(colors) // 3)
    table = Image.new("P", (1, 1))
    table.putpalette(colors)
    yield b"GIF89a" + struct.pack("<HHBBB", *size, 0xF7, 0, 0)  # 256 colours follow
    yield bytes(colors)
    yield b"\x21\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00"  # again and again
    before, over = None, 0
    for number, frame in enumerate(frames, 1):
        now = np.asarray(frame.quantize(palette=table, dither=Image.Dither.NONE))
        piece, corner = _changed_rectangle(now, before)
        until = round(number * 100 / rate)
        how = {"duration": (until - over) * 10, "transparency": _CLEAR, "disposal": 1}
        yield from getdata(Image.fromarray(piece), corner, **how)
        before, over = now, until
    yield b";"


def _changed_rectangle(
    now: NDArray[np.uint8], before: NDArray[np.uint8] | None
) -> tuple[NDArray[np.uint8], tuple[int, int]]:
    """Return the rectangle that has changed, clear where it has not, and its corner."""
    if before is None:
        return now, (0, 0)
    new = now != before
    rows, columns = (np.flatnonzero(new.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return np.full((1, 1), _CLEAR, np.uint8), (0, 0)
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    piece = np.where(new[box], now[box], np.uint8(_CLEAR))
    return piece, (int(columns[0]), int(rows[0]))


SIZE = (640, 480)  # width and height of a film, pixels
SMALLEST, LARGEST = 120, 4096  # pixels that either may be
SHARE = 0.5  # of the width that the staff takes, at most
FLASH = 0.2  # seconds for which a bone is lit, at least

AUTO = "auto"
SIDES = {"front": 0.0, "side": -90.0}
"""Views by name: degrees from where the body faces, to its left."""


class Film:
    """A motion beside its score, frame by frame."""

    def __init__(
        self,
        figure: Figure,
        score: Score,
        *,
        start: float = 0.0,
        stop: float | None = None,
        rate: Fraction | int = RATE,
        size: tuple[int, int] = SIZE,
        view: str | float = "auto",
        parts: Sequence[str] | None = None,
        marked: Sequence[Symbol] = (),
        seconds: bool = True,
    ) -> None:
        if len(figure) < 2:
            raise ExportError("a capture of one frame", wanted="a movement")
        if any(not SMALLEST <= side <= LARGEST or side % 2 for side in size):
            wanted = f"even numbers of {SMALLEST} to {LARGEST}"
            raise UsageError(f"a film of {size[0]}x{size[1]} pixels", wanted=wanted)
        end = min(float(len(figure) / figure.rate), float(score.frames / score.rate))
        stop = last_second(end, start, stop)
        self.rate, self.size = Fraction(rate), size
        count = max(round((stop - start) * self.rate), 1)
        self.times = start + np.arange(count) / float(self.rate)
        shown = np.floor(self.times * float(figure.rate) + 1e-6).astype(np.int64)
        self.frames = np.minimum(shown, len(figure) - 1)
        half = round(SHARE * size[0]), size[1]
        self.staff = FilmStaff(
            score, start, stop, half, parts=parts, marked=marked, seconds=seconds
        )
        first, last = int(self.frames[0]), int(self.frames[-1]) + 1
        if view != AUTO:
            eye = front(figure, first, last, turned_of(view))
        else:
            if marked:
                ratio = figure.rate / score.rate
                begin = max(first, floor(min(it.start for it in marked) * ratio))
                end_of_hit = min(last, floor(max(it.stop for it in marked) * ratio))
                if begin < end_of_hit:
                    first, last = begin, end_of_hit
                parts = list(dict.fromkeys(it.part for it in marked))
            eye = best_view(figure, parts, first, last)
        lit = np.zeros((count, len(figure.bones)), bool)  # which bones are coloured when
        for symbol in marked:
            begins, ends = (float(it / score.rate) for it in (symbol.start, symbol.stop))
            edges = begins - 1e-6, max(ends, begins + FLASH) - 1e-6
            lit[slice(*np.searchsorted(self.times, edges)), figure.shown([symbol.part])] = True
        room = (size[0] - self.staff.width, size[1])
        self.scene = scene(figure, self.frames, eye, room, float(self.rate))
        self.painter = Painter(figure, self.scene, lit, float(self.rate))

    def __len__(self) -> int:
        """Return the number of film frames."""
        return len(self.times)

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
        with extra("film", form):
            return film_bytes(watched(self.pictures()), form, self.size, self.rate)


def turned_of(view: str | float) -> float:
    """Return the degrees from the front of a view given by name or in degrees."""
    try:
        degrees = SIDES[view] if isinstance(view, str) and view in SIDES else float(view)
    except ValueError:
        degrees = inf
    if not -360 <= degrees <= 360:
        wanted = f"{AUTO}, {', '.join(SIDES)} or degrees of -360 to 360"
        raise UsageError(f'the view "{shown(str(view))}"', wanted=wanted)
    return degrees


# Usual and largest scale of symbols; the usual one where one page cannot hold a film
USUAL_SCALE, LARGEST_SCALE = 1.0, 1.6
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
        self._marked = list(settled(score, marked))
        score = score if parts else plain(score, self._marked)
        self.score, self.start, self.stop, self.seconds = score, start, stop, seconds
        self.parts, _ = chosen(score, parts or None, {it.part for it in self._marked})
        self.rate = 1.0 if seconds else float(score.meter.speed / 60)  # counts a second
        own = staff_columns(self.parts)
        wide = 2 * MARGIN + NUMBERS + own.left + own.right
        all_of_it = _AROUND + BEAT * max((stop - start) * self.rate, 1.0)
        fits = min(max(PIXEL * size[1] / all_of_it, USUAL_SCALE), LARGEST_SCALE)
        most = (size[0] / wide, size[1] / (_AROUND + BEAT))
        self.scale = min(fits, *(PIXEL * it for it in most))
        self.width, self.height = min(round(wide * self.scale / PIXEL), size[0]), size[1]
        counts = floor((PIXEL * self.height / self.scale - _AROUND) / BEAT + 1e-9)
        self.lasts = max(counts, 1) / self.rate
        self.warnings: dict[str, None] = {}
        self._drawn = lru_cache(maxsize=1)(self._page_image)  # the page that is being filmed

    def at(self, seconds: float) -> tuple[Image, float]:
        """Return the page that shows a moment, and how far down on it the moment lies, pixels."""
        picture, times, downs = self._drawn(self._page(seconds))
        return picture, float(np.interp(seconds, times, downs))

    def _page(self, seconds: float) -> int:
        return floor((seconds - self.start) / self.lasts + 1e-9)

    def _page_image(self, number: int) -> tuple[Image, list[float], list[float]]:
        """Return a page, some of its moments, and their places from the top."""
        from PIL import Image

        start = self.start + number * self.lasts
        stop = min(start + self.lasts, self.stop)
        picture = draw(
            self.score,
            parts=self.parts,
            start=start,
            stop=stop,
            bars=None,
            seconds=self.seconds,
            marked=self._marked,
        )
        self.warnings |= dict.fromkeys(picture.warnings)
        scale = min(self.scale, PIXEL * self.height / picture.height)
        with Image.open(BytesIO(rendered(picture, "png", scale))) as image:
            page = Image.new("RGB", (self.width, self.height), PAPER)
            page.paste(image.convert("RGB"), (0, self.height - image.height))
        clock = TimeAxis(self.score, self.seconds)
        times = np.linspace(start, stop, _KNOTS).tolist()
        begin = clock.at(start)
        ups = [_BELOW + (clock.at(it) - begin) * BEAT for it in times]
        return page, times, [self.height - up * scale / PIXEL for up in ups]
