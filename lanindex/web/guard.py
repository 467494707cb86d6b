"""Who may ask: foreign hosts, cross-site requests and callers without the token are refused.

The page itself (HTML, scripts, styles) holds nothing of the library and needs no token, so that a
link that somebody sent opens it; all that it shows comes from ``/api``, which needs the cookie that
the link of ``lanindex serve`` sets, or the token as a bearer.
"""

from __future__ import annotations

import socket
from hmac import compare_digest
from ipaddress import ip_address
from urllib.parse import urlencode

from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_POLICY = "; ".join(
    [
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' blob: data:",
        "connect-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
        "require-trusted-types-for 'script'",
        "trusted-types svg",  # the one policy: staves are parsed as XML, in dom.js
    ]
)

_HEADERS = {
    "content-security-policy": _POLICY,
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
}

_YEAR = 365 * 24 * 3600
_LOOPBACK = ("127.0.0.1", "localhost", "[::1]")


class Guard:
    """Middleware that lets requests through to the application, or refuses them.

    Parameters
    ----------
    app : ASGI application
        What is guarded.
    token : str
        What a caller must know.
    host, port : str, int
        Where the server listens; any address of the machine where `host` is ``0.0.0.0`` or ``::``.
    """

    def __init__(self, app: ASGIApp, *, token: str, host: str, port: int) -> None:
        self.app, self.token, self.port = app, token, port
        self.anywhere = host in ("0.0.0.0", "::")
        own = (socket.gethostname().lower(),) if self.anywhere else ()
        self.names = {*_LOOPBACK, host.lower(), f"[{host.lower()}]", *own}
        self.cookie = f"lanindex-{port}"  # browsers share cookies between the ports of a host

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or hand it on."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers[name] = value
                headers.setdefault("cache-control", "no-store")
            await send(message)

        request = Request(scope)
        answer = self._refusal(request) or self._welcome(request)
        await (answer or self.app)(scope, receive, send_guarded)

    def _refusal(self, request: Request) -> Response | None:
        """Return what is said to a request that is not let through; None if it is."""
        if not self._knows(request.headers.getlist("host")):
            return PlainTextResponse("This server does not go by that name.\n", 421)
        api = request.url.path.startswith("/api/")
        reads = request.method in ("GET", "HEAD")
        fetched = request.headers.get("sec-fetch-site", "")
        page = not api and reads and request.headers.get("sec-fetch-mode") == "navigate"
        if fetched not in ("", "none", "same-origin") and not page:
            return PlainTextResponse("Requests from other sites are refused.\n", 403)
        origin = request.headers.get("origin")
        if origin is not None and origin.partition("://")[2] != request.headers["host"]:
            return PlainTextResponse("Requests from other sites are refused.\n", 403)
        if not reads and not api:
            return PlainTextResponse("There is nothing to change here.\n", 405)
        if not api:
            return None
        kind, _, bearer = request.headers.get("authorization", "").partition(" ")
        if kind.lower() == "bearer" and self._is_token(bearer):
            return None
        # no browser changes anything without saying from where
        said = reads or fetched or origin
        if said and self._is_token(request.cookies.get(self.cookie, "")):
            return None
        error = {
            "found": "this browser is not let in yet",
            "remedy": "Open the link that lanindex serve printed.",
        }
        return JSONResponse({"error": error}, 401)

    def _welcome(self, request: Request) -> Response | None:
        """Turn the token of a link into a cookie; the address loses it."""
        given = request.query_params.get("token")
        if given is None or request.url.path.startswith("/api/"):
            return None
        if not self._is_token(given):
            remedy = "This link has an old token. Open the link that lanindex serve printed last.\n"
            return PlainTextResponse(remedy, 403)
        rest = urlencode([it for it in request.query_params.multi_items() if it[0] != "token"])
        path = "/" + request.url.path.lstrip("/")  # two slashes would name another host
        answer = RedirectResponse(path + (f"?{rest}" if rest else ""), 303)
        answer.set_cookie(
            self.cookie, self.token, max_age=_YEAR, httponly=True, samesite="strict", path="/"
        )
        return answer

    def _is_token(self, text: str) -> bool:
        return compare_digest(text.encode(), self.token.encode())

    def _knows(self, hosts: list[str]) -> bool:
        """Return whether a Host header names this server: a page elsewhere may point here."""
        if len(hosts) != 1:
            return False
        name, _, port = hosts[0].lower().rpartition(":")
        if port != str(self.port):
            return False
        if name in self.names:
            return True
        try:
            return self.anywhere and bool(ip_address(name.strip("[]")))
        except ValueError:
            return False
