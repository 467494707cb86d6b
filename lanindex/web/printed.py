"""Printed scores for the editor: a score, pictures of its pages, and where its signs stand."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
from math import ceil
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from anyio import to_thread
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response

from lanindex import formats
from lanindex.errors import UsageError, counted
from lanindex.notation import edited
from lanindex.web.routes import Call, as_json, failed, received

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lanindex.reader.printed import Printed
    from lanindex.web.server import Site

LARGEST = 64 << 20
"""Bytes of a picture or a PDF that a browser sends."""

PAGES = 20
"""Pages that are read while somebody waits, at most."""

_SIDE = 2200  # pixels of a picture's longer side in an answer, at most


async def receive(site: Site, request: Request) -> Response:
    """Read the picture or PDF in the body of a request; nothing of it is kept."""
    try:
        content = await received(request, LARGEST)
        name = request.query_params.get("name", "picture")
        site.check()
        return as_json(await to_thread.run_sync(_read, name, content))
    except ClientDisconnect:
        return Response(status_code=499)
    except Exception as error:
        return failed(error, request.url.path)


def of_capture(call: Call) -> dict[str, Any]:
    """Return what is read anew of the picture that a capture was read of."""
    capture = call.site.library.capture(call.path["number"])
    file = formats.opened(capture.location)
    if file.sha256() != capture.sha256:
        remedy = "Ingest it again."
        raise UsageError("has changed since it was ingested", place=capture.path, remedy=remedy)
    return _read(capture.path, file.content[:])


def _read(name: str, content: bytes) -> dict[str, Any]:
    from lanindex.reader.printed import open_printed

    def check(done: int, total: int) -> None:
        if total > PAGES:
            remedy = "Read it in a terminal: lanindex read-score."
            wanted = f"{PAGES} at most"
            raise UsageError(counted(total, "page"), place=name, wanted=wanted, remedy=remedy)

    printed = open_printed(name, content, check)
    score = _score(printed)
    return {
        "score": score,
        "title": name,
        "notes": list(printed.about_pages()),
        "pages": [_picture(image) for image in printed.images],
        "signs": list(_signs(printed, score["division"] // score["beats"])),
    }


def _score(printed: Printed) -> dict[str, Any]:
    """Return the score for the editor; an empty one, if no sign is known."""
    pages = [*printed.read.values()]
    if any(page.records for page in pages):
        return edited.of_score(printed.score())
    beats, counts = pages[0].beats, sum(page.counts for page in pages)
    empty = {"other": [], "symbols": [], "speed": "60", "beat": 4, "beats": beats}
    return empty | {"division": edited.GRAIN * beats, "units": max(ceil(counts / beats), 1)}


def _signs(printed: Printed, grain: int) -> Iterator[dict[str, Any]]:
    """Yield each sign of the pages, with its ticks and its box; there are `grain` to a count."""
    from lanindex.reader.boxes import around
    from lanindex.reader.score import DOUBTFUL, joined

    numbers, before = [*printed.read], 0
    signs = [(numbers[at], it) for at, it in joined([*printed.read.values()])]
    for number, page in printed.read.items():
        signs += [(number, it.later(before)) for it in page.unknown]
        before += page.counts
    for number, sign in sorted(signs, key=lambda it: (it[0], _ORDER(it[1]))):
        state = "known" if sign.confidence >= DOUBTFUL else "doubtful"
        yield {
            "part": sign.part,
            "start": round(sign.start * grain),
            "stop": round(sign.end * grain),
            "words": sign.words,
            "page": number - 1,
            "box": sign.box,
            "around": around(printed.images[number - 1], sign.box),
            "kind": state if sign.kind else "unknown",
            "sure": round(sign.confidence, 2),
        }


_ORDER = attrgetter("staff", "start", "end", "part")


def _picture(image: NDArray[np.uint8]) -> dict[str, Any]:
    """Return an image (H, W) as a JPEG that a page shows, and the pixels that it has."""
    import cv2

    height, width = image.shape
    factor = min(_SIDE / max(height, width), 1)
    small = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    jpeg = b64encode(cv2.imencode(".jpg", small)[1].tobytes()).decode()
    return {"image": f"data:image/jpeg;base64,{jpeg}", "width": width, "height": height}
