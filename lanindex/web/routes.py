"""Routes of ``/api``: a function from a call to JSON, run in a thread, its errors as JSON.

Work is done in threads so that a slow answer stops no other; the event loop only waits.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

from anyio import fail_after
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from lanindex import records
from lanindex.data import shipped
from lanindex.errors import (
    AbsentError,
    LanindexError,
    LibraryBusyError,
    LibraryError,
    PatternError,
    UsageError,
)

if TYPE_CHECKING:
    from lanindex.web.server import Site

LARGEST_BODY = 1 << 20
"""Bytes of a request, but for uploads."""


class Refused(LanindexError):
    """The server does not do this for this caller."""


class Gone(LanindexError):
    """The server had this, and does not keep it any more."""


_STATUS = {
    Refused: 403,
    Gone: 404,
    AbsentError: 404,
    LibraryBusyError: 503,
    LibraryError: 409,
    PatternError: 400,
    UsageError: 400,
}
PATIENCE = 30.0
"""Seconds within which a request must have come, but for uploads."""

_log = logging.getLogger("lanindex.web")


@dataclass(frozen=True, slots=True)
class Call:
    """A request as a function sees it."""

    site: Site
    path: dict[str, Any]  # what stands in the braces of the route
    query: dict[str, list[str]]
    body: dict[str, Any] = field(default_factory=dict)

    def text(self, name: str, default: str = "") -> str:
        """Return a text of the query."""
        return self.query.get(name, [default])[-1]

    def number(self, name: str, default: float, least: float = 0, most: float = 1e9) -> float:
        """Return a number of the query, within its limits."""
        text = self.text(name)
        try:
            value = float(text) if text else default
        except ValueError:
            value = float("nan")
        if not least <= value <= most:
            raise UsageError(f'"{text[:20]}"', place=name, wanted=f"{least:g} to {most:g}")
        return value

    def said(self, name: str, kind: type, default: Any = None) -> Any:
        """Return a value of the body that must be of a type, or is not there."""
        value = self.body.get(name, default)
        if value is not default and (not isinstance(value, kind) or isinstance(value, bool)):
            raise UsageError(f"{value!r:.40}", place=name, wanted=f"a {kind.__name__}")
        return value

    def conditions(self) -> list[tuple[str, str]]:
        """Return the columns of captures of the body, each with what it must be like."""
        found = []
        for text in self.said("where", list, []):
            name, equals, glob = str(text).partition("=")
            if not equals:
                raise UsageError(f'"{text!s:.40}"', place="where", wanted="column=glob")
            found.append((name, glob))
        return found


Work = Callable[[Call], Any]


def refused_when_read_only(work: Work) -> Work:
    """Return work that a library that is only shown refuses."""

    def checked(call: Call) -> Any:
        if call.site.readonly:
            raise Refused("this library is only shown", remedy="Ask its owner to change it.")
        return work(call)

    return checked


def works() -> Iterator[tuple[str, Work, str]]:
    """Yield the path, the function and the method of each route of ``routes.toml``."""
    for section, routes in shipped("web/routes.toml").items():
        for request, name in routes.items():
            method, _, path = request.partition(" ")
            work = _late(*name.split("."))
            yield path, refused_when_read_only(work) if section == "changes" else work, method


def _late(module: str, function: str) -> Work:
    """Return what calls a function of a module that is imported with the first call."""

    def work(call: Call) -> Any:
        return getattr(import_module(f"lanindex.web.{module}"), function)(call)

    return work


def import_all() -> None:
    """Import the modules of all routes, so that no first request waits for them."""
    for routes in shipped("web/routes.toml").values():
        for name in routes.values():
            import_module(f"lanindex.web.{name.partition('.')[0]}")
    import_module("numpy.ma")  # numpy imports it in the first call of `unique`


def route(site: Site, path: str, work: Work, *methods: str) -> Route:
    """Return the route of a function; what it returns is a response, or becomes JSON."""

    async def endpoint(request: Request) -> Response:
        try:
            body = await _body(request) if request.method in ("POST", "PUT", "PATCH") else {}
            query: dict[str, list[str]] = {}
            for name, value in request.query_params.multi_items():
                query.setdefault(name, []).append(value)
            call = Call(site, dict(request.path_params), query, body)
            return await run_in_threadpool(_answered, work, call)
        except ClientDisconnect:
            return Response(status_code=499)
        except Exception as error:
            return failed(error, request.url.path)

    return Route(path, endpoint, methods=methods or ("GET",))


def _answered(work: Work, call: Call) -> Response:
    call.site.check()
    found = work(call)
    return found if isinstance(found, Response) else as_json(found)


def as_json(value: Any, status: int = 200) -> Response:
    """Return a value as JSON."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return Response(text.encode(errors="replace"), status, media_type="application/json")


def failed(error: Exception, path: str) -> Response:
    """Return what a caller is told of an error; one that nobody expected is logged, too."""
    if isinstance(error, LanindexError):
        status = next((it for kind, it in _STATUS.items() if isinstance(error, kind)), 422)
        return JSONResponse({"error": records.of_error(error)}, status)
    _log.exception("%s failed", path)
    found = f"the server failed at this ({type(error).__name__})"
    return JSONResponse({"error": {"found": found, "remedy": "Its terminal tells more."}}, 500)


async def received(request: Request, most: int) -> bytes:
    """Return the body of a request: so many bytes at most."""
    parts, size = [], 0
    try:
        with fail_after(PATIENCE):
            async for part in request.stream():
                size += len(part)
                if size > most:
                    wanted = f"{most:,} bytes at most"
                    raise UsageError("a request that is too long", wanted=wanted)
                parts.append(part)
    except TimeoutError as error:
        raise LanindexError("the request came too slowly", remedy="Send it again.") from error
    return b"".join(parts)


async def _body(request: Request) -> dict[str, Any]:
    """Return the JSON object of a request; nothing where it has none."""
    content = await received(request, LARGEST_BODY)
    if not content:
        return {}
    try:
        value = json.loads(content)
        json.dumps(value, ensure_ascii=False).encode()  # halves of letters cannot be kept
    except (ValueError, RecursionError) as error:
        raise UsageError("a request that is no JSON", wanted="a JSON object") from error
    if not isinstance(value, dict):
        raise UsageError("a request that is no object", wanted="a JSON object")
    return value
