"""A search that gives up in time."""

from __future__ import annotations

from time import monotonic

from lanindex.errors import LanindexError


class Timeout:
    """Watches a search, and breaks it off after some seconds.

    Parameters
    ----------
    seconds : float
        How long it may take.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds, self._end = seconds, monotonic() + seconds

    def __call__(self, done: int, captures: int) -> None:
        """Take note of how many captures are done.

        Raises
        ------
        LanindexError
            Where it has taken too long.
        """
        if monotonic() > self._end:
            raise LanindexError(
                f"the search took longer than {self._seconds:g} s, "
                f"and was through with {done} of {captures} captures",
                remedy='Bound what it tries: write "...[<5s]" for "...", or search fewer captures.',
            )
