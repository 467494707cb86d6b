"""Frames to a film: MP4, animated WebP and GIF, each frame encoded as soon as it is drawn.

MP4 and WebP are made by PyAV. Pillow's writer of WebP wants all frames at once; its GIF, too, so
here a GIF is put together frame by frame, each only what has changed, with Pillow's compression.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from fractions import Fraction
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import UsageError, shown
from lanindex.film.paint import COLORS, PAPER

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
"""Film frames a second where nobody asks for some: of most forms, and of some."""

FASTEST = {"gif": 50}
"""What viewers play no faster."""

_CLEAR, _NOWHERE = 255, (1, 254, 1)  # the colour of a GIF that means "as before": no other
_STEP = 10  # from one shade to the next: Pillow mixes up those that are closer


def form_of(name: str) -> str:
    """Return the form that a file's ending tells."""
    ending = name.rpartition(".")[2].lower() if "." in name else ""
    if ending not in FORMS:
        raise UsageError(f'"{shown(name)}"', wanted=f"an ending of {', '.join(FORMS)}")
    return ending


def reel(frames: Iterable[Image], form: str, size: tuple[int, int], rate: Fraction) -> bytes:
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
