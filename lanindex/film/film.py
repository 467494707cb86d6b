"""A motion and its score as a film: the figure, and beside it the staff with a line that moves."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from io import BytesIO
from math import floor, inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import ExportError, UsageError, shown
from lanindex.film.figure import Figure, View, front, view
from lanindex.film.scene import COLORS, LINE, PAPER, Painter, scene
from lanindex.film.staff import FilmStaff
from lanindex.model import Score, Symbol

if TYPE_CHECKING:
    from PIL.Image import Image


_X264 = "bframes=0:subme=1:me=dia"  # a third faster on lines that move, a tenth larger

_AV: dict[str, tuple[str, str, dict[str, str], dict[str, str]]] = {
    "mp4": (
        "libx264",
        "yuv420p",
        {"preset": "veryfast", "crf": "23", "x264-params": _X264},
        {},
    ),
    "webp": (
        "libwebp_anim",
        "bgra",
        {"lossless": "1", "quality": "10", "compression_level": "1"},
        {"loop": "0"},
    ),
}
"""By ending: codec, pixels, options of the codec and of the file; flat colours are kept as they
are by WebP, which is also faster than to blur them."""

FORMS = (*_AV, "gif")
"""What a film can be written as."""

RATE, RATES = Fraction(25), {"webp": Fraction(20), "gif": Fraction(20)}
"""Default frames a second: of most forms, and of some."""

FASTEST = {"gif": 50}
"""What viewers play no faster."""

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
        raise UsageError(f"{float(rate):g} frames a second", place="--fps", wanted=wanted)
    if form == "gif":
        return b"".join(_gif(frames, size, rate))
    return _av(frames, form, size, rate)


def _av(frames: Iterable[Image], form: str, size: tuple[int, int], rate: Fraction) -> bytes:
    import av

    shots: Any = av.VideoFrame
    codec, pixels, how, options = _AV[form]
    content = BytesIO()
    with av.open(content, "w", format=form, options=options) as container:
        stream: Any = container.add_stream(codec, rate=rate, options=how)
        stream.width, stream.height = size
        stream.pix_fmt = pixels
        stream.codec_context.thread_count = 1  # the same film is then the same bytes everywhere
        for number, frame in enumerate(frames):
            shot = shots.from_image(frame)
            shot.pts, shot.time_base = number, 1 / rate
            container.mux(stream.encode(shot))
        container.mux(stream.encode(None))
    return content.getvalue()


def _palette() -> list[int]:
    """Return the colours of a GIF: shades from paper to all that is drawn."""
    shades = []
    for color in COLORS:
        way = np.array(color) - PAPER
        share = np.linspace(0, 1, 1 + abs(way).max() // _STEP)
        shades.append(PAPER + share[:, None] * way)
    table: list[int] = np.concatenate(shades).round().astype(int).ravel().tolist()
    return table + [*_NOWHERE] * (256 - len(table) // 3)


def _gif(frames: Iterable[Image], size: tuple[int, int], rate: Fraction) -> Iterator[bytes]:
    """Yield the pieces of a GIF."""
    from PIL import Image
    from PIL.GifImagePlugin import getdata

    table, colors = Image.new("P", (1, 1)), _palette()
    table.putpalette(colors)
    yield b"GIF89a" + struct.pack("<HHBBB", *size, 0xF7, 0, 0)  # 256 colours follow
    yield bytes(colors)
    yield b"\x21\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00"  # again and again
    before, over = None, 0
    for number, frame in enumerate(frames, 1):
        now = np.asarray(frame.quantize(palette=table, dither=Image.Dither.NONE))
        piece, corner = _changed(now, before)
        until = round(number * 100 / rate)
        how = {"duration": (until - over) * 10, "transparency": _CLEAR, "disposal": 1}
        yield from getdata(Image.fromarray(piece), corner, **how)
        before, over = now, until
    yield b";"


def _changed(
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
        self.staff = FilmStaff(
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
        """Return the view."""
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
            return film_bytes(watched(self.pictures()), form, self.size, self.rate)
        except ImportError as error:
            remedy = "It comes with: pip install 'lanindex[film]'."
            raise ExportError(
                f"{error.name} is not installed", place=form, remedy=remedy
            ) from error


def turned_of(named: str | float) -> float:
    """Return the degrees from the front of a view given by name or in degrees.

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
