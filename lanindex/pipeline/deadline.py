"""How far a long job is: told to whoever waits, and broken off when its time is up."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import monotonic

from lanindex.errors import LanindexError

Tell = Callable[[str, int, int], None]
"""Is told what is gone through (``captures``), how many of them are done, and how many there are;
it may raise."""


def silent(noun: str, done: int, total: int) -> None:
    """Tell nobody."""


class Deadline:
    """What a job tells now and then how far it is; raises once that has taken too long."""

    def __init__(
        self, tell: Tell, seconds: float | None, job: str = "search", remedy: str = ""
    ) -> None:
        self._tell, self._seconds, self._job, self._remedy = tell, seconds, job, remedy
        self._begun = monotonic()

    def __call__(self, noun: str, done: int, total: int) -> None:
        """Take note of how many of something are done, and of how many there are."""
        self._tell(noun, done, total)
        if self._seconds is not None and monotonic() - self._begun > self._seconds:
            raise LanindexError(
                f"the {self._job} took longer than {self._seconds:g} s, "
                f"and was through with {done:,} of {total:,} {noun}",
                remedy=self._remedy,
            )

    def of(self, noun: str) -> Callable[[int, int], None]:
        """Return what is told how many of one thing are done, and how many there are."""
        return partial(self, noun)
