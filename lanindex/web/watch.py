"""What a screen that plays a capture is given: its figure, its movement in tiles, poses."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from starlette.responses import Response

from lanindex.draw import svg
from lanindex.draw.staff import MARGIN, NAMES
from lanindex.errors import AbsentError, LanindexError, UsageError, shown
from lanindex.film import tiles
from lanindex.film.figure import Figure, faced, stood
from lanindex.film.hits import Playback, poses, seen_from
from lanindex.pipeline.motion import check
from lanindex.pipeline.motion import motion as motion_of
from lanindex.pipeline.motion import rate_of as motion_rate
from lanindex.pipeline.staves import piece
from lanindex.search.example.stretch import pattern_of_symbol
from lanindex.web.routes import Call

if TYPE_CHECKING:
    from lanindex.draw.strip import Staff
    from lanindex.model import Capture
    from lanindex.pipeline.library import Library

RATE = 60
"""Frames a second that are played, at most."""

MOST = 60
"""Seconds of a piece of a staff, at most."""

_STAMPED = {"cache-control": "private, max-age=86400"}  # the address changes with the library


def rate_of(capture: Capture) -> Fraction:
    """Return how many frames a second of a capture are played."""
    return min(motion_rate(capture), Fraction(RATE))


def figure(call: Call) -> dict[str, Any]:
    """Return the figure of a capture: its strokes, its rate, and how it is cut into tiles."""
    return figure_of(call.site.library, call.path["number"], wait=not call.text("early"))


def motion(call: Call) -> Response:
    """Return a tile of a capture's movement."""
    number, tile = call.path["number"], call.path["tile"]
    return tile_of(call.site.library, number, tile, wait=not call.text("early"))


def source(call: Call) -> dict[str, Any]:
    """Answer once the file of a capture is known to be the one that was ingested."""
    check(call.site.library.store, call.path["number"])
    return {}


def figure_of(library: Library, number: int, *, wait: bool = True) -> dict[str, Any]:
    """Return the figure of a capture of a library; `source` tells what it does not wait for."""
    capture = library.capture(number)
    rate, seconds = rate_of(capture), float(capture.frames / capture.rate)
    frames = ceil(seconds * float(rate) - 1e-6)
    body = motion_of(library.store, capture.id, 0, min(seconds, tiles.SECONDS), RATE, wait=wait)
    known = body.places[np.isfinite(body.places).all(axis=2)]
    return {
        "rate": float(rate),
        "frames": frames,
        "tile": round(tiles.SECONDS * rate),
        "seconds": round(seconds, 6),
        "floor": float(np.percentile(known[:, 1], 0.5)) if len(known) else None,
        **tiles.described(body),
    }


def tile_of(library: Library, number: int, tile: int, *, wait: bool = True) -> Response:
    """Return a tile of the movement of a library's capture."""
    capture = library.capture(number)
    rate, seconds = rate_of(capture), float(capture.frames / capture.rate)
    length = float(round(tiles.SECONDS * rate) / rate)
    start = tile * length
    if start >= seconds:
        raise UsageError(f"tile {tile}", wanted=f"one of {ceil(seconds / length)}")
    stop = min(start + length, seconds)
    body = motion_of(library.store, capture.id, start, stop, RATE, wait=wait)
    kind, headers = "application/octet-stream", _STAMPED if wait else {"cache-control": "no-store"}
    return Response(tiles.packed(body.places), media_type=kind, headers=headers)


_LOOKED_AT = 20.0, 12  # seconds of a capture in which its pose is looked for, frames a second


def pose(call: Call) -> Response:
    """Return the pose that tells most of a capture as a picture: it is most unlike all others."""
    library = call.site.library
    capture = library.capture(call.path["number"])

    def drawn() -> str:
        seconds, rate = _LOOKED_AT
        whole = float(capture.frames / capture.rate)
        body = library.motion(capture.id, 0, min(seconds, whole), rate)
        frames = np.arange(len(body))
        played = Playback(faced(body, frames), _unlike(body), (), 0, whole, (0, 0))
        return svg.write(poses(played, seen_from([played]), capture.path))

    picture = call.site.poses.made((capture.location, capture.sha256), drawn)
    return Response(picture, media_type="image/svg+xml", headers=_STAMPED)


def _unlike(body: Figure) -> NDArray[np.int64]:
    """Return the frame, (1,), whose pose is most unlike the usual one, of those best known."""
    known = np.isfinite(body.places).all(axis=2).sum(axis=1)
    if not known.any():
        raise LanindexError("nothing of the body is known where its pose is looked for")
    about = np.nan_to_num(body.places - stood(body.places)[:, None])
    apart = np.square(about - np.median(about, axis=0)).sum(axis=(1, 2))
    return np.array([np.where(known == known.max(), apart, -1).argmax()])


def _parts(call: Call) -> list[str] | None:
    """Return the parts that a request names, if it does."""
    return [it for it in call.text("parts").split(",") if it] or None


def staff(call: Call) -> Response | dict[str, Any]:
    """Return a piece of a capture's staff, with the heights of its seconds."""
    library, number = call.site.library, call.path["number"]
    seconds = float(library.capture(number).frames / library.capture(number).rate)
    start = call.number("from", 0.0, 0, seconds)
    stop = min(call.number("to", start + tiles.SECONDS, start, start + MOST), seconds)
    parts, zoom = _parts(call), call.number("zoom", 1, 0.1, 10)
    begin = not call.text("early")  # no work beside what is shown first
    drawn = piece(library.store, number, start, stop, parts, zoom, begin=begin)
    if drawn is not None:
        return Response(drawn, media_type="application/json")
    whole = library.staff(number, start, stop, parts=parts, stretch=zoom, near=True)
    return whole.tile(start, stop)


def symbol(call: Call) -> dict[str, Any]:
    """Return what a symbol of a capture's staff is, in words and as a pattern."""
    library, number, name = call.site.library, call.path["number"], call.text("name")
    seconds = float(library.capture(number).frames / library.capture(number).rate)
    begins = call.number("at", 0.0, 0, seconds)
    start, stop = max(begins - 0.01, 0.0), min(begins + 0.5, seconds)
    whole = library.staff(number, start, stop, parts=_parts(call), near=True)
    record = whole.symbols(start, stop).get(name)
    if record is None:
        raise AbsentError(f'no symbol "{shown(name)}"', place=f"second {begins:g}")
    return {"words": record["words"], "pattern": pattern_of_symbol(record)}


def unnamed(staff: Staff) -> str:
    """Return a small staff as SVG, without the names of its columns: nobody could read them."""
    picture = staff.picture()
    return svg.write(replace(picture, height=picture.height - NAMES - MARGIN), scale=staff.scale)


def curves(call: Call) -> dict[str, Any]:
    """Return how a limb of a capture went in a window, and what the method made of it."""
    library, number = call.site.library, call.path["number"]
    capture = library.capture(number)
    seconds = float(capture.frames / capture.rate)
    start = call.number("from", 0.0, 0, seconds)
    stop = min(call.number("to", start + tiles.SECONDS, start, start + MOST), seconds)
    return library.curves(number, call.text("part"), start, stop).record()


def pattern(call: Call) -> dict[str, Any]:
    """Return what some seconds of a capture are as a pattern."""
    start, stop = call.number("from", 0), call.number("to", 0)
    found = call.site.library.pattern_of(call.path["number"], start, stop, _parts(call))
    return {"pattern": found}
