"""When a job gives up: its progress is reported, and it is broken off once its time is up."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import monotonic

from lanindex.errors import LanindexError
from lanindex.library.connect import Progress, no_progress


class Deadline:
    """Passes on the progress of a job, and raises once the job has taken too long."""

    def __init__(
        self,
        progress: Progress = no_progress,
        seconds: float | None = None,
        job: str = "search",
        remedy: str = "",
    ) -> None:
        self._progress, self._seconds, self._job, self._remedy = progress, seconds, job, remedy
        self._begun = monotonic()

    def __call__(self, noun: str, done: int, total: int) -> None:
        """Report how many of something are done, of how many there are."""
        self._progress(noun, done, total)
        if self._seconds is not None and monotonic() - self._begun > self._seconds:
            raise LanindexError(
                f"the {self._job} took longer than {self._seconds:g} s, "
                f"and was through with {done:,} of {total:,} {noun}",
                remedy=self._remedy,
            )

    def of(self, noun: str) -> Callable[[int, int], None]:
        """Return what reports how many of one thing are done, of how many there are."""
        return partial(self, noun)
