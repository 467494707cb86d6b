"""The files of the page, read once and kept compressed; no path leads to any other file."""

from __future__ import annotations

import gzip
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response

_FOLDER = Path(__file__).parent / "static"
ICON = "icon.svg"
_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
}


class _File(NamedTuple):
    content: bytes
    packed: bytes  # the same, compressed
    kind: str
    tag: str


@lru_cache(maxsize=1)
def _files() -> dict[str, _File]:
    """Return the files by their paths below ``static``."""
    files = {}
    for path in sorted(_FOLDER.rglob("*")):
        if path.suffix in _TYPES and path.is_file():
            content = path.read_bytes()
            tag = f'"{sha256(content).hexdigest()[:20]}"'
            packed = gzip.compress(content, 9, mtime=0)
            name = path.relative_to(_FOLDER).as_posix()
            files[name] = _File(content, packed, _TYPES[path.suffix], tag)
    return files


def answer(request: Request, name: str) -> Response:
    """Return a file by its path, compressed where the caller can read that."""
    file = _files().get(name)
    if file is None:
        return PlainTextResponse("There is no such page.\n", 404)
    # a browser asks for the icon with each change of the address
    lasts = "max-age=3600" if name == ICON else "no-cache"
    headers = {"etag": file.tag, "cache-control": lasts, "vary": "accept-encoding"}
    if request.headers.get("if-none-match") == file.tag:
        return Response(status_code=304, headers=headers)
    packs = "gzip" in request.headers.get("accept-encoding", "")
    if packs:
        headers["content-encoding"] = "gzip"
    return Response(file.packed if packs else file.content, headers=headers, media_type=file.kind)


async def page(request: Request) -> Response:
    """Return the page: one for all screens, which its script tells by their address."""
    return answer(request, "index.html")


async def static(request: Request) -> Response:
    """Return a script, a style or a picture of the page."""
    return answer(request, request.path_params["name"])
