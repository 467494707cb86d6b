"""How the process listens: it ends at once, and hangs up on callers that ask for nothing."""

from __future__ import annotations

import logging
import socket
from asyncio import BaseTransport
from typing import TYPE_CHECKING, Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

if TYPE_CHECKING:
    from lanindex.web.server import Site

PATIENCE = 30.0
"""Seconds within which a caller must have asked for something."""

_FILES = 10_000  # that are open at once: more than any page needs, fewer than macOS refuses


class Connection(H11Protocol):
    """A connection that is closed where a request does not come, or comes too slowly."""

    def connection_made(self, transport: BaseTransport) -> None:
        """Begin to wait for the first request."""
        super().connection_made(transport)  # type: ignore[arg-type]
        self.loop.call_later(PATIENCE, self._look, None)

    def _look(self, before: Any) -> None:
        """Hang up where nothing was asked since a request that is answered."""
        if self.transport.is_closing():
            return
        waits = self.cycle is None or self.cycle.response_complete
        if waits and self.cycle is before:
            self.transport.close()
        else:
            self.loop.call_later(PATIENCE, self._look, self.cycle)


class Server(uvicorn.Server):
    """A server that ends what goes on before it waits for the answers."""

    def __init__(self, config: uvicorn.Config, site: Site) -> None:
        super().__init__(config)
        self._site = site

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Break off all jobs, so that nobody follows them any more, and end."""
        self._site.close()
        logging.getLogger("uvicorn.error").disabled = True  # an answer that is cut off is no error
        await super().shutdown(sockets)


def open_many() -> None:
    """Let the process have as many connections as the machine allows."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return
    now, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = _FILES if most == resource.RLIM_INFINITY else min(most, _FILES)
    if now != resource.RLIM_INFINITY and now < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, most))
