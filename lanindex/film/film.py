"""A motion and its score as a film: the figure, and beside it the staff with a line that moves."""

from __future__ import annotations

import struct
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from io import BytesIO
from itertools import combinations
from math import ceil, floor, inf
from typing import TYPE_CHECKING, Any

import numpy as np

from lanindex.alphabet import kind_of
from lanindex.draw import Picture, draw
from lanindex.draw import staff as paper
from lanindex.draw.picture import PIXEL, Label, Mark, MarkGroup
from lanindex.draw.plain import plain
from lanindex.draw.svg import BODY, font, rendered
from lanindex.errors import ExportError, UsageError, extra, shown
from lanindex.film.figure import LEGEND, PALETTE, PAPER, Figure, Painter, View, faced, scene
from lanindex.film.figure import view as best_view
from lanindex.model import Score, Symbol

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw
    from PIL.ImageFont import FreeTypeFont

INK = PALETTE["bone"]


# a third faster on lines that move, a tenth larger
_X264 = "bframes=0:subme=0:me=dia:no-8x8dct=1"

_AV: dict[str, tuple[str, str, dict[str, str], dict[str, str]]] = {
    "mp4": ("libx264", "yuv420p", {"preset": "veryfast", "crf": "23", "x264-params": _X264}, {}),
    "webp": (
        "libwebp_anim",
        "bgra",
        {"lossless": "1", "quality": "0", "compression_level": "1"},
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
_BAND = (252, 227, 178)  # what marks symbols on the staff, whose ink is black
_STEP = 10  # from one shade to the next: Pillow mixes up those that are closer


def _ahead(frames: Iterable[Image]) -> Iterator[Image]:
    """Yield frames, each drawn while the one before is written."""
    with ThreadPoolExecutor(1) as pool:
        left = iter(frames)
        coming = pool.submit(next, left, None)
        while (frame := coming.result()) is not None:
            coming = pool.submit(next, left, None)
            yield frame


def film_bytes(frames: Iterable[Image], form: str, size: tuple[int, int], rate: Fraction) -> bytes:
    """Return frames as a film."""
    if rate > (most := FASTEST.get(form, 1000)):
        wanted = f"{most} at most: viewers of {form} show no more"
        raise UsageError(f"{float(rate):g} frames a second", place="--film-fps", wanted=wanted)
    if form == "gif":
        return b"".join(_gif(frames, size, rate))
    import av
    from av.video.reformatter import VideoReformatter

    shots: Any = av.VideoFrame
    mixer = VideoReformatter()  # one for all frames: to make one takes as long as to use it
    codec, pixels, codec_options, options = _AV[form]
    content = BytesIO()
    with av.open(content, "w", format=form, options=options) as container:
        stream: Any = container.add_stream(codec, rate=rate, options=codec_options)
        stream.width, stream.height = size
        stream.pix_fmt = pixels
        stream.codec_context.thread_count = 1  # the same film is then the same bytes everywhere
        for number, frame in enumerate(_ahead(frames)):
            image = shots.from_image(frame)
            shot: Any = mixer.reformat(image, format=pixels, interpolation="POINT")
            shot.pts, shot.time_base = number, 1 / rate
            container.mux(stream.encode(shot))
        container.mux(stream.encode(None))
    return content.getvalue()


def _gif(frames: Iterable[Image], size: tuple[int, int], rate: Fraction) -> Iterator[bytes]:
    """Yield the pieces of a GIF."""
    from PIL import Image, ImageChops
    from PIL.GifImagePlugin import getdata

    shades = []  # from paper to all that is drawn
    for color in ((0, 0, 0), *PALETTE.values(), _BAND):
        way = np.array(color) - PAPER
        share = np.linspace(0, 1, 1 + abs(way).max() // _STEP)
        shades.append(PAPER + share[:, None] * way)
    quarters = np.array([[1], [2], [3]]) / 4  # in which colours are mixed where limbs cross
    for one, other in combinations([np.array(PALETTE[kind]) for kind in BODY], 2):
        shades.append(one + quarters * (other - one))
    colors: list[int] = np.concatenate(shades).round().astype(int).ravel().tolist()
    colors += [*_NOWHERE] * (256 - len(colors) // 3)
    table = Image.new("P", (1, 1))
    table.putpalette(colors)
    yield b"GIF89a" + struct.pack("<HHBBB", *size, 0xF7, 0, 0)  # 256 colours follow
    yield bytes(colors)
    yield b"\x21\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00"  # again and again
    last, over = Image.new("RGB", size, _NOWHERE), 0
    before = np.full((size[1], size[0]), _CLEAR, np.uint8)
    for number, frame in enumerate(frames, 1):
        left, top, right, bottom = ImageChops.difference(frame, last).getbbox() or (0, 0, 1, 1)
        piece = frame.crop((left, top, right, bottom))
        now = np.asarray(piece.quantize(palette=table, dither=Image.Dither.NONE))
        own = before[top:bottom, left:right]
        changed = np.where(now != own, now, np.uint8(_CLEAR))
        until = round(number * 100 / rate)
        how = {"duration": (until - over) * 10, "transparency": _CLEAR, "disposal": 1}
        yield from getdata(Image.fromarray(changed), (left, top), **how)
        own[:], last, over = now, frame, until
    yield b";"


SIZE = (640, 480)  # width and height of a film, pixels
SMALLEST, LARGEST = 120, 4096  # pixels that either may be
SHARE = 0.5  # of the width that the staff takes, at most
LETTER, LETTERS = 12, 37  # pixels of a letter, at least, and how many are as high as the film
CLOCK = 6  # the width of the clock, in letters' heights
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
        title: str = "",
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
        stop = paper.last_second(end, start, stop)
        self.rate, self.size, self.title = Fraction(rate), size, title
        self.letter = max(round(size[1] / LETTERS), LETTER)
        count = max(round((stop - start) * self.rate), 1)
        self.times = start + np.arange(count) / float(self.rate)
        shown = np.floor(self.times * float(figure.rate) + 1e-6).astype(np.int64)
        self.frames = np.minimum(shown, len(figure) - 1)
        half = round(SHARE * size[0]), size[1]
        self.staff = FilmStaff(
            score, start, stop, half, self.letter, parts=parts, marked=marked, seconds=seconds
        )
        about, looked = self.frames, list(parts or ())
        if marked:
            first, last = min(it.start for it in marked), max(it.stop for it in marked)
            at = about / float(figure.rate / score.rate)
            hit = about[(first <= at) & (at < last)]
            about, looked = hit if len(hit) else about, [it.part for it in marked]
        moving = faced(figure, self.frames, about)
        if view == AUTO:
            eye = best_view([(faced(figure, about), list(dict.fromkeys(looked)))])
        else:
            eye = View(turned_of(view))
        lit = np.zeros((count, len(figure.bones)), bool)  # which bones are coloured when
        for symbol in marked:
            begins, ends = (float(it / score.rate) for it in (symbol.start, symbol.stop))
            edges = begins - 1e-6, max(ends, begins + FLASH) - 1e-6
            lit[slice(*np.searchsorted(self.times, edges)), figure.shown([symbol.part])] = True
        room = (size[0] - self.staff.width, size[1])
        self.scene = scene(moving, eye, room, float(self.rate), 3 * self.letter)
        self.painter = Painter(moving, self.scene, lit, float(self.rate))

    def __len__(self) -> int:
        """Return the number of film frames."""
        return len(self.times)

    def pictures(self) -> Iterator[Image]:
        """Yield the frames, RGB, one after another."""
        from PIL import Image, ImageDraw, ImageFont

        left, page, base, said = self.scene.size[0], None, None, ""
        letters, edge = ImageFont.truetype(font(), self.letter), self.letter // 2
        for number, time in enumerate(self.times.tolist()):
            staff, down = self.staff.at(time)
            if staff is not page or base is None:
                page, base = staff, Image.new("RGB", self.size, PAPER)
                base.paste(staff, (left, 0))
                if self.painter.still:
                    self.painter.ground(base)
                self._head(ImageDraw.Draw(base), letters)
                said = ""
            if said != (said := f"{time:.1f} s"):
                draw = ImageDraw.Draw(base)
                draw.rectangle((left - CLOCK * self.letter, 0, left - 1, edge + self.letter), PAPER)
                draw.text((left - edge, edge), said, INK, letters, "ra")
            frame = base.copy()
            self.painter.paint(number, frame)
            line = (left, down - 1, self.size[0], down)
            ImageDraw.Draw(frame).rectangle(line, fill=PALETTE["line"])
            yield frame

    def _head(self, draw: ImageDraw, letters: FreeTypeFont) -> None:
        """Write the name beside the clock, and below it what the colours mean."""
        edge, line, title = self.letter // 2, self.letter * 3 // 2, self.title
        room = self.scene.size[0] - edge - CLOCK * self.letter
        while title and letters.getlength(title) > room:  # the beginning gives way
            title = title[2:] and f"\u2026{title[2:]}"
        draw.text((edge, edge), title, INK, letters)
        told = list(LEGEND.items())[: None if self.painter.lit.any() else -1]
        for column, (word, color) in enumerate(told):
            across, down = edge + column * CLOCK * self.letter, edge + line
            draw.text((across, down), "\u2014", PALETTE[color], letters)
            draw.text((across + line, down), word, INK, letters)

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


# Usual and largest scale of symbols beside the smallest letters; the usual one where one page
# cannot hold a film
USUAL_SCALE, LARGEST_SCALE = 1.0, 1.6
_AROUND = 4 * paper.MARGIN + paper.START  # height of a page without names and time, units
_KNOTS = 33  # moments of a page whose places are worked out; others lie between
_LETTER_WIDTH = 0.66  # of a letter, in its heights


class FilmStaff:
    """A score, page by page."""

    def __init__(
        self,
        score: Score,
        start: float,
        stop: float,
        size: tuple[int, int],
        letter: int = LETTER,
        *,
        parts: Sequence[str] | None = None,
        marked: Sequence[Symbol] = (),
        seconds: bool = True,
    ) -> None:
        self._marked = list(paper.settled(score, marked))
        score = score if parts else plain(score, self._marked)
        self.score, self.start, self.stop, self.seconds = score, start, stop, seconds
        self.warnings: dict[str, None] = {}
        held = {it.part for it in self._marked}
        self.parts, _ = paper.chosen(score, parts or None, held)
        if not parts:
            self.parts = [it for it in self.parts if it in held or self._moves(it)]
        self.rate = 1.0 if seconds else float(score.meter.speed / 60)  # counts a second
        own = paper.staff_columns(self.parts)
        wide = 2 * paper.MARGIN + paper.NUMBERS + own.left + own.right
        self.letter, self.height = letter, size[1]
        letters = max(len(paper.name_of(part)) for part in ("support", *own.places))
        room = PIXEL * (self.height - round(letters * letter * _LETTER_WIDTH))  # above the names
        fits = room / (_AROUND + paper.BEAT * max((stop - start) * self.rate, 1.0))
        usual, largest = (it * letter / LETTER for it in (USUAL_SCALE, LARGEST_SCALE))
        most = min(largest, PIXEL * size[0] / wide, room / (_AROUND + paper.BEAT))
        self.scale = min(max(fits, usual), most)
        self.width = min(round(wide * self.scale / PIXEL), size[0])
        # height of the names, and of all that is below the staff's beginning, units
        self._names = round((PIXEL * self.height - room) / self.scale)
        self._below = _AROUND - 2 * paper.MARGIN + self._names
        full = max(floor((room / self.scale - _AROUND) / paper.BEAT + 1e-9), 1)  # counts of a page
        counts = (stop - start) * self.rate
        edges = [full * page for page in range(ceil(counts / full - 1e-9))]
        if len(edges) > 1:  # the last two share what is left: neither is a stub
            edges[-1] = edges[-2] + round((counts - edges[-2]) / 2)
        self.edges = [start + it / self.rate for it in edges]  # when pages begin, seconds
        self._drawn = lru_cache(maxsize=1)(self._page_image)  # the page that is being filmed

    def _moves(self, part: str) -> bool:
        """Return whether a track has a symbol that lasts in what is filmed, or carries."""
        rows, rate = self.score.tracks[part].symbols, float(self.score.rate)
        within = (rows["stop"] > self.start * rate) & (rows["start"] < self.stop * rate)
        moves = bool((within & (rows["stop"] > rows["start"])).any())
        return moves or kind_of(part) in ("support", "stance")

    def at(self, seconds: float) -> tuple[Image, float]:
        """Return the page that shows a moment, and how far down on it the moment lies, pixels."""
        number = bisect_right(self.edges, seconds + 1e-9) - 1
        picture, times, downs = self._drawn(number)
        return picture, float(np.interp(seconds, times, downs))

    def page(self, number: int) -> tuple[Picture, float, float]:
        """Return a page, and from when to when it lasts."""
        start, stop = [*self.edges, self.stop][number : number + 2]
        picture = draw(
            self.score,
            parts=self.parts,
            start=start,
            stop=stop,
            bars=None,
            seconds=self.seconds,
            marked=self._marked,
        )
        least = round(self.letter * PIXEL / self.scale)
        marks = tuple(_legible(mark, least) for mark in picture.marks)
        height = picture.height - paper.NAMES + self._names
        return replace(picture, height=height, marks=marks), start, stop

    def _page_image(self, number: int) -> tuple[Image, list[float], list[float]]:
        """Return a page, some of its moments, and their places from the top."""
        from PIL import Image

        picture, start, stop = self.page(number)
        self.warnings |= dict.fromkeys(picture.warnings)
        scale = min(self.scale, PIXEL * self.height / picture.height)
        with Image.open(BytesIO(rendered(picture, "png", scale))) as image:
            page = Image.new("RGB", (self.width, self.height), PAPER)
            page.paste(image.convert("RGB"), (0, self.height - image.height))
        clock = paper.TimeAxis(self.score, self.seconds)
        times = np.linspace(start, stop, _KNOTS).tolist()
        begin = clock.at(start)
        ups = [self._below + (clock.at(it) - begin) * paper.BEAT for it in times]
        return page, times, [self.height - up * scale / PIXEL for up in ups]


def _legible(mark: Mark, least: int) -> Mark:
    """Return a mark with letters that are as large as that, at least."""
    if isinstance(mark, MarkGroup):
        return replace(mark, marks=tuple(_legible(it, least) for it in mark.marks))
    if not isinstance(mark, Label) or mark.size >= least:
        return mark
    more, turned = (least - mark.size) // 3, mark.turned  # the middle of letters stays where it is
    return replace(mark, size=least, x=mark.x + more * turned, y=mark.y + more * (not turned))
