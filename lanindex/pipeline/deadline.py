"""When a job gives up: its progress is reported, and it is broken off once its time is up."""

from __future__ import annotations

from time import monotonic

from lanindex.errors import LanindexError
from lanindex.library.connect import Progress


def deadline(
    progress: Progress, seconds: float | None, job: str = "search", remedy: str = ""
) -> Progress:
    """Return a progress that is passed on, and raises once the job has taken too long."""
    begun = monotonic()

    def watch(noun: str, done: int, total: int) -> None:
        progress(noun, done, total)
        if seconds is not None and monotonic() - begun > seconds:
            raise LanindexError(
                f"the {job} took longer than {seconds:g} s, "
                f"and was through with {done:,} of {total:,} {noun}",
                remedy=remedy,
            )

    return watch
