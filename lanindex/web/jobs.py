"""Jobs that run while the page goes on: searches and ingests, by number, with what they tell."""

from __future__ import annotations

import asyncio
import json
import secrets
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import AsyncIterator, Callable, Hashable
from dataclasses import dataclass, field
from threading import Lock
from time import monotonic
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

from lanindex.errors import LanindexError
from lanindex.records import of_error
from lanindex.web.routes import Call, Gone, failed

if TYPE_CHECKING:
    from lanindex.pipeline.jobs import Job as LibraryJob
    from lanindex.web.server import Site

MOST = 100
"""Jobs that are kept: of more, those go that have ended and nobody has asked for the longest."""

MOST_HITS = 500_000
"""Hits that jobs which have ended keep together; some 200 bytes each."""

RUNNING = 8
"""Jobs that run at once."""

TELLS = 0.1
"""Seconds from one state of a job that is told to the next."""

STILL = 15
"""Seconds after which something is told even where nothing changes."""

LEFT = 60.0
"""Seconds after which a job that nobody follows is broken off: its tab was closed."""


Own = TypeVar("Own", bound="LibraryJob[Any]")


class Job(Protocol):
    """What all jobs have."""

    @property
    def state(self) -> str:
        """``running``, ``done``, ``cancelled`` or ``failed``."""

    def cancel(self) -> None:
        """Break it off."""

    def told(self) -> dict[str, Any]:
        """Return what the page is told of it."""


class Told(Generic[Own], ABC):
    """A job of the library, as the page is told of it."""

    def __init__(self, job: Own) -> None:
        self.job = job

    @property
    def state(self) -> str:
        """As of the job."""
        return self.job.state

    def cancel(self) -> None:
        """Break it off: what is stored by then stays."""
        self.job.cancel()

    @abstractmethod
    def told(self) -> dict[str, Any]:
        """Return how far it is."""


def trouble(error: Exception | None) -> dict[str, Any] | None:
    """Return what the page is told of the error of a job."""
    if error is None:
        return None
    if isinstance(error, LanindexError):
        return of_error(error)
    return {"found": f"the server failed at this ({type(error).__name__})"}


@dataclass(slots=True)
class _Kept:
    job: Job
    key: Hashable
    goes_on: str
    asked: float = field(default_factory=monotonic)  # when somebody last asked for it
    ended: bool = False  # whether somebody was told how it has ended


class Jobs:
    """The jobs of a site, by their numbers; the same question is one job."""

    def __init__(self) -> None:
        self._lock = Lock()
        self.closed = False
        self._jobs: OrderedDict[str, _Kept] = OrderedDict()

    def begin(self, key: Hashable, make: Callable[[], Job], *, goes_on: str = "") -> str:
        """Return the number of the job of a key: one that runs or is done, else a new one.

        A job that `goes_on` does so where nobody follows it; a page finds it again by this name.
        """
        with self._lock:
            for number, kept in self._jobs.items():
                if kept.key == key and kept.job.state in ("running", "done"):
                    self._touch(number)
                    return number
            running = sum(it.job.state == "running" for it in self._jobs.values())
            if running >= RUNNING:
                raise LanindexError(
                    f"{running} jobs are running already", remedy="Wait until one of them ends."
                )
            number = secrets.token_hex(6)
            self._jobs[number] = _Kept(make(), key, goes_on)
            self._forget()
            return number

    def _forget(self) -> None:
        """Let go of jobs that have ended, but for the one that was asked for last."""
        ended = [it for it, kept in self._jobs.items() if kept.job.state != "running"]
        hits = sum(getattr(self._jobs[it].job, "found", 0) for it in ended)
        for number in ended[:-1]:
            if len(self._jobs) <= MOST and hits <= MOST_HITS:
                break
            hits -= getattr(self._jobs.pop(number).job, "found", 0)

    def going_on(self) -> list[tuple[str, str]]:
        """Return number and name of what goes on, until somebody was told how it has ended."""
        with self._lock:
            kept = self._jobs.items()
            return [(number, it.goes_on) for number, it in kept if it.goes_on and not it.ended]

    def get(self, number: str) -> Any:
        """Return a job."""
        with self._lock:
            if number not in self._jobs:
                raise Gone("what was found here is not kept any more", remedy="Ask for it again.")
            return self._touch(number).job

    def _touch(self, number: str) -> _Kept:
        self._jobs.move_to_end(number)
        kept = self._jobs[number]
        kept.asked = monotonic()
        return kept

    def follow(self, number: str, *, ended: bool = False) -> None:
        """Note that somebody follows a job, or was told how it has ended."""
        with self._lock:
            if number in self._jobs:
                self._touch(number).ended |= ended

    async def watch(self) -> None:
        """Break off, for ever and ever, jobs that nobody follows any more; forget old ones."""
        while True:
            await asyncio.sleep(LEFT / 12)
            before = monotonic() - LEFT
            with self._lock:
                for kept in self._jobs.values():
                    if kept.asked < before and not kept.goes_on and kept.job.state == "running":
                        kept.job.cancel()
                self._forget()

    def close(self) -> None:
        """Break off all jobs."""
        self.closed = True
        with self._lock:
            for kept in self._jobs.values():
                kept.job.cancel()


def going_on(call: Call) -> dict[str, Any]:
    """Return the jobs that go on where nobody follows them, for a page to find again."""
    found = call.site.jobs.going_on()
    return {"jobs": [{"job": number, "kind": kind} for number, kind in found]}


def cancel(call: Call) -> dict[str, Any]:
    """Break off a job, and return how it stands."""
    job: Job = call.site.jobs.get(call.path["job"])
    job.cancel()
    return job.told()


async def events(site: Site, request: Request) -> Response:
    """Answer with the states of a job as they change, until it ends."""
    number = request.path_params["job"]
    try:
        job: Job = site.jobs.get(number)
    except LanindexError as error:
        return failed(error, request.url.path)

    async def states() -> AsyncIterator[str]:
        before, silent = "", 0.0
        while not (site.jobs.closed or await request.is_disconnected()):
            site.jobs.follow(number)
            state = job.told()
            text = json.dumps(state, ensure_ascii=False, separators=(",", ":"))
            if text != before:
                yield f"data: {text}\n\n"
                before, silent = text, 0.0
            elif silent > STILL:
                yield ":\n\n"  # who has gone is noticed
                silent = 0.0
            if state["state"] != "running":
                site.jobs.follow(number, ended=True)
                return
            await asyncio.sleep(TELLS)
            silent += TELLS

    return StreamingResponse(states(), media_type="text/event-stream")
