"""The server: the routes of a library's page, and the process that answers them."""

from __future__ import annotations

import asyncio
import logging
import secrets
import socket
import threading
from collections.abc import Callable, Hashable
from contextlib import asynccontextmanager
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.gzip import GZipMiddleware
from starlette.routing import BaseRoute, Route

from lanindex.errors import LibraryError, UsageError
from lanindex.pipeline.kept import Latest
from lanindex.web import files, jobs, names, printed
from lanindex.web.guard import Guard
from lanindex.web.jobs import Jobs
from lanindex.web.routes import import_all, route, works
from lanindex.web.uploads import Uploads, receive

if TYPE_CHECKING:
    from lanindex.pipeline.library import Library
    from lanindex.web.captures import CaptureTable
    from lanindex.web.convert import Workshop

IDLE = 1.0
"""Seconds after the start, behind the first page, at which all modules are imported."""

SCREENS = (
    *("/", "/search", "/captures/{number:int}", "/convert", "/edit", "/compare", "/explore"),
    *("/words", "/help", "/help/{topic}"),
)
"""Addresses of the page; its script shows the screen of each."""


def _identity(library: Library) -> tuple[int, int] | None:
    """Return which file a library is; None where it is in none."""
    path = library.store.session.target.path
    try:
        found = path.stat() if path else None
    except OSError:
        return None
    return (found.st_dev, found.st_ino) if found else None


class Site:
    """What all requests share: the library, and what is kept of it."""

    def __init__(self, library: Library, *, readonly: bool = False) -> None:
        self.library, self.readonly = library, readonly
        self.poses = Latest[str](4096)
        self.answers = Latest[Any](512)
        self.jobs = Jobs()
        self.names = names.PatternNames(library.store.session.target)
        self.uploads = Uploads(library.store.session.target)
        self._file = _identity(library)
        if not readonly:
            self.uploads.clear()

    @cached_property
    def table(self) -> CaptureTable:
        """The records of the captures."""
        from lanindex.web.captures import CaptureTable

        return CaptureTable(self.library)

    @cached_property
    def workshop(self) -> Workshop:
        """The profiles, and what was written down with them."""
        from lanindex.web.convert import Workshop

        return Workshop(self.library)

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


def application(site: Site, *, token: str, host: str, port: int) -> Starlette:
    """Return the application that answers for a site; it closes the site when it ends."""

    @asynccontextmanager
    async def lifespan(app: Starlette) -> Any:
        watch = asyncio.create_task(site.jobs.watch())
        yield
        watch.cancel()
        site.close()

    routes: list[BaseRoute] = [
        *(route(site, path, work, method) for path, work, method in works()),
        Route("/api/jobs/{job}/events", partial(jobs.events, site)),
        Route("/api/uploads/{name:path}", partial(receive, site), methods=["PUT"]),
        Route("/api/scores/printed", partial(printed.receive, site), methods=["POST"]),
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
    importing = threading.Timer(IDLE, import_all)
    importing.daemon = True
    importing.start()
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
