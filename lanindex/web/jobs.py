"""Jobs that run while the page goes on: searches and ingests, by number, with what they tell."""

from __future__ import annotations

import asyncio
import json
import secrets
from collections import OrderedDict
from collections.abc import AsyncIterator, Callable, Hashable
from threading import Lock
from typing import TYPE_CHECKING, Any, Protocol

from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

from lanindex.errors import LanindexError, UsageError
from lanindex.web.routes import Call, failed

if TYPE_CHECKING:
    from lanindex.web.server import Site

MOST = 100
"""Jobs that are kept: of more, those go that have ended and nobody has asked for the longest."""

RUNNING = 8
"""Jobs that run at once."""

TELLS = 0.1
"""Seconds from one state of a job that is told to the next."""

STILL = 15
"""Seconds after which something is told even where nothing changes."""


class Job(Protocol):
    """What all jobs have."""

    @property
    def state(self) -> str:
        """``running``, ``done``, ``cancelled`` or ``failed``."""

    def cancel(self) -> None:
        """Break it off."""

    def told(self) -> dict[str, Any]:
        """Return what the page is told of it."""


class Jobs:
    """The jobs of a site, by their numbers; the same question is one job."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._jobs: OrderedDict[str, tuple[Job, Hashable]] = OrderedDict()

    def begin(self, key: Hashable, make: Callable[[], Job]) -> str:
        """Return the number of the job of a key: one that runs or is done, else a new one."""
        with self._lock:
            for number, (job, own) in self._jobs.items():
                if own == key and job.state in ("running", "done"):
                    self._jobs.move_to_end(number)
                    return number
            running = sum(job.state == "running" for job, _ in self._jobs.values())
            if running >= RUNNING:
                raise LanindexError(
                    f"{running} jobs are running already", remedy="Wait until one of them ends."
                )
            number = secrets.token_hex(6)
            self._jobs[number] = make(), key
            ended = [it for it, (job, _) in self._jobs.items() if job.state != "running"]
            for old in ended[: max(0, len(self._jobs) - MOST)]:
                del self._jobs[old]
            return number

    def get(self, number: str) -> Any:
        """Return a job."""
        with self._lock:
            if number not in self._jobs:
                raise UsageError("this job is not kept any more", remedy="Begin it again.")
            self._jobs.move_to_end(number)
            return self._jobs[number][0]

    def close(self) -> None:
        """Break off all jobs."""
        with self._lock:
            for job, _ in self._jobs.values():
                job.cancel()


def cancel(call: Call) -> dict[str, Any]:
    """Break off a job, and return how it stands."""
    job: Job = call.site.jobs.get(call.path["job"])
    job.cancel()
    return job.told()


async def events(site: Site, request: Request) -> Response:
    """Answer with the states of a job as they change, until it ends."""
    try:
        job: Job = site.jobs.get(request.path_params["job"])
    except LanindexError as error:
        return failed(error, request.url.path)

    async def states() -> AsyncIterator[str]:
        before, silent = "", 0.0
        while not await request.is_disconnected():
            state = job.told()
            text = json.dumps(state, ensure_ascii=False, separators=(",", ":"))
            if text != before:
                yield f"data: {text}\n\n"
                before, silent = text, 0.0
            elif silent > STILL:
                yield ":\n\n"  # who has gone is noticed
                silent = 0.0
            if state["state"] != "running":
                return
            await asyncio.sleep(TELLS)
            silent += TELLS

    return StreamingResponse(states(), media_type="text/event-stream")
