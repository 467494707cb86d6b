"""The server: the routes of a library's page, and the process that answers them."""

from __future__ import annotations

import asyncio
import logging
import os
import secrets
import socket
from collections.abc import Callable, Hashable
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.gzip import GZipMiddleware
from starlette.routing import BaseRoute, Route

from lanindex import __version__
from lanindex.errors import LibraryError, UsageError
from lanindex.pipeline.kept import Latest
from lanindex.web import (
    captures,
    comparison,
    convert,
    explore,
    exports,
    files,
    help,
    ingests,
    jobs,
    names,
    query_staff,
    scores,
    searches,
    watch,
    words,
)
from lanindex.web.guard import Guard
from lanindex.web.jobs import Jobs
from lanindex.web.routes import Call, Work, refused_when_read_only, route
from lanindex.web.uploads import Uploads, receive

if TYPE_CHECKING:
    from lanindex.pipeline.library import Library

PORT = 8421
SCREENS = (
    *("/", "/search", "/captures/{number:int}", "/convert", "/edit", "/compare", "/explore"),
    *("/words", "/help", "/help/{topic}"),
)
"""Addresses of the page; its script shows the screen of each."""


def _identity(library: Library) -> tuple[int, int] | None:
    """Return which file a library is; None where it is in none."""
    try:
        found = os.stat(library.store.place)
    except OSError:
        return None
    return found.st_dev, found.st_ino


class Site:
    """What all requests share: the library, and what is kept of it."""

    def __init__(self, library: Library, *, readonly: bool = False) -> None:
        self.library, self.readonly = library, readonly
        self.table = captures.CaptureTable(library)
        self.poses = Latest[str](4096)
        self.answers = Latest[Any](512)
        self.jobs = Jobs()
        self.workshop = convert.Workshop(library)
        self.names = names.PatternNames(Path(library.store.place))
        self.uploads = Uploads(Path(library.store.place))
        self._file = _identity(library)
        if not readonly:
            self.uploads.clear()

    def check(self) -> None:
        """Raise where the file of the library was removed or replaced: what is open is another."""
        if self._file is not None and self._file != _identity(self.library):
            raise LibraryError(
                "the library is not there any more, or another one is in its place",
                place=self.library.store.place,
                remedy="End lanindex serve and start it again.",
            )

    def kept(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """Return an answer that holds as long as the library does not change."""
        return self.answers.made((self.library.stamp, key), make)

    def parts(self) -> list[str]:
        """Return the parts that any capture has."""
        parts: list[str] = self.kept("parts", lambda: self.library.store.parts(checked=False))
        return parts

    def close(self) -> None:
        """Break off all jobs."""
        self.jobs.close()


def about(call: Call) -> dict[str, Any]:
    """Return what the page needs to know of a library before all else."""
    library = call.site.library
    stats = library.stats()
    return {
        "name": Path(library.store.place).stem,
        "version": __version__,
        "stamp": library.stamp,
        "readonly": call.site.readonly,
        "captures": stats.captures,
        "symbols": stats.symbols,
        "seconds": round(float(stats.seconds), 3),
        "parts": library.store.parts(checked=False),
        "columns": call.site.table.columns(),
        "folder": call.site.table.now().folder,
    }


_ROUTES: list[tuple[str, Work, tuple[str, ...]]] = [
    ("/api/library", about, ("GET",)),
    ("/api/captures", captures.listing, ("GET",)),
    ("/api/captures/{number:int}", captures.one, ("GET",)),
    ("/api/captures", refused_when_read_only(captures.change), ("PATCH",)),
    ("/api/captures/{number:int}/figure", watch.figure, ("GET",)),
    ("/api/captures/{number:int}/motion/{tile:int}", watch.motion, ("GET",)),
    ("/api/captures/{number:int}/pose", watch.pose, ("GET",)),
    ("/api/captures/{number:int}/encode", convert.encode, ("POST",)),
    ("/api/captures/{number:int}/way", convert.way, ("POST",)),
    ("/api/captures/{number:int}/tempo", convert.tempo, ("POST",)),
    ("/api/library/encode", convert.asked_again, ("GET",)),
    ("/api/library/encode", refused_when_read_only(convert.again), ("POST",)),
    ("/api/profiles", convert.profiles, ("GET",)),
    ("/api/profiles", refused_when_read_only(convert.save), ("POST",)),
    ("/api/profiles/{name}", convert.profile, ("GET",)),
    ("/api/ingests", ingests.about, ("GET",)),
    ("/api/ingests", refused_when_read_only(ingests.begin), ("POST",)),
    ("/api/ingests/{job}", ingests.outcomes, ("GET",)),
    ("/api/compare", comparison.compared, ("GET",)),
    ("/api/explore", explore.begin, ("POST",)),
    ("/api/jobs/{job}", jobs.cancel, ("DELETE",)),
    ("/api/captures/numbers", captures.numbers, ("GET",)),
    ("/api/help", help.topics, ("GET",)),
    ("/api/help/signs", help.signs, ("GET",)),
    ("/api/help/{topic}", help.topic, ("GET",)),
    ("/api/words", words.listing, ("GET",)),
    ("/api/words/{word}", words.one, ("GET",)),
    ("/api/words/{word}/example", words.example, ("GET",)),
    ("/api/scores/alphabet", scores.alphabet, ("GET",)),
    ("/api/scores/captures/{number:int}", scores.of_capture, ("GET",)),
    ("/api/scores/read", scores.of_file, ("POST",)),
    ("/api/scores/draw", scores.draw, ("POST",)),
    ("/api/scores/motion", scores.motion, ("POST",)),
    ("/api/scores/save", scores.save, ("POST",)),
    ("/api/scores/pattern", scores.pattern, ("POST",)),
    ("/api/scores/store", refused_when_read_only(scores.store), ("POST",)),
    ("/api/scores/diff", scores.diff, ("POST",)),
    ("/api/captures/{number:int}/staff", watch.staff, ("GET",)),
    ("/api/captures/{number:int}/pattern", watch.pattern, ("GET",)),
    ("/api/captures/{number:int}/curves", watch.curves, ("GET",)),
    ("/api/parse", searches.read, ("POST",)),
    ("/api/text", searches.write, ("POST",)),
    ("/api/query", query_staff.about, ("GET",)),
    ("/api/searches", searches.begin, ("POST",)),
    ("/api/searches/{job}/hits", searches.hits, ("GET",)),
    ("/api/searches/{job}/hits/{hit:int}/card", searches.card, ("GET",)),
    ("/api/searches/{job}/facets", searches.facets, ("GET",)),
    ("/api/searches/{job}/advice", searches.advice, ("GET",)),
    ("/api/names", refused_when_read_only(names.keep), ("POST",)),
    ("/api/names/{name}", names.kept, ("GET",)),
    ("/api/exports", exports.begin, ("POST",)),
    ("/api/exports/{job}/file", exports.packed, ("GET",)),
    ("/api/captures/remove", refused_when_read_only(captures.remove), ("POST",)),
]


def application(site: Site, *, token: str, host: str, port: int) -> Starlette:
    """Return the application that answers for a site; it closes the site when it ends."""

    @asynccontextmanager
    async def lifespan(app: Starlette) -> Any:
        watch = asyncio.create_task(site.jobs.watch())
        yield
        watch.cancel()
        site.close()

    routes: list[BaseRoute] = [
        *(route(site, path, work, *methods) for path, work, methods in _ROUTES),
        Route("/api/jobs/{job}/events", partial(jobs.events, site)),
        Route("/api/uploads/{name:path}", partial(receive, site), methods=["PUT"]),
        *(Route(path, files.page) for path in SCREENS),
        Route("/static/{name:path}", files.static),
    ]
    middleware = [
        Middleware(Guard, token=token, host=host, port=port),
        Middleware(GZipMiddleware, minimum_size=1000, compresslevel=5),
    ]
    return Starlette(routes=routes, middleware=middleware, lifespan=lifespan)


def serve(
    library: Library,
    *,
    host: str,
    port: int,
    readonly: bool,
    ready: Callable[[str], None],
) -> None:
    """Serve a library until it is interrupted; `ready` is given the link that lets in."""
    from uvicorn import Config

    from lanindex.web.process import Connection, Server, open_many

    open_many()
    token = secrets.token_urlsafe(24)
    listener = _listener(host, port)
    port = listener.getsockname()[1]
    logging.getLogger("asyncio").setLevel(logging.CRITICAL)  # peers that hang up are no error
    site = Site(library, readonly=readonly)
    config = Config(
        application(site, token=token, host=host, port=port),
        http=Connection,
        log_level="error",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        timeout_keep_alive=20,
        timeout_graceful_shutdown=2,
        ws="none",
    )
    shown = {"0.0.0.0": socket.gethostname(), "::": socket.gethostname()}.get(host, host)
    shown = f"[{shown}]" if ":" in shown else shown
    ready(f"http://{shown}:{port}/?token={token}")
    Server(config, site).run(sockets=[listener])


def _listener(host: str, port: int) -> socket.socket:
    """Return a socket that listens, or say why it cannot."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM
        )[0]
        listener = socket.socket(family, kind, protocol)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(1024)
    except OSError as error:
        raise UsageError(
            f"nothing can listen there ({error.strerror})",
            place=f"{host}:{port}",
            remedy="Name another port: --port 0 takes a free one.",
        ) from error
    return listener
