"""Jobs that go on in a thread: a search, an ingest; how far they are, and what they have so far."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from threading import Condition, Thread
from time import monotonic
from typing import Generic, TypeVar

import numpy as np

from lanindex.errors import LanindexError, UsageError
from lanindex.formats import parted
from lanindex.library.connect import Progress
from lanindex.library.store import Store
from lanindex.memory import give_back
from lanindex.model import Hit
from lanindex.pipeline.prepare import Outcome
from lanindex.pipeline.search import check_columns
from lanindex.search.hits import Counts, Found, Hits, counted
from lanindex.search.language.clauses import CLIP, Reference

Result = TypeVar("Result")

ORDERS = ("", "best", "capture", "best capture")
"""In which hits are paged: as the search has them; the clearest first; by capture and start; the
captures with the clearest hits first, the hits of each by start."""


class Cancelled(Exception):
    """Raised in the thread of a job to break it off."""


class Job(Generic[Result]):
    """What goes on in a thread of its own.

    Attributes
    ----------
    progress : tuple of (str, int, int)
        What is counted, such as ``captures``, how many are done, and of how many; of none while
        that is not known.
    state : str
        ``running``, ``done``, ``cancelled`` or ``failed``.
    seconds : float
        How long it has taken, when it told last that it goes on.
    error : Exception, optional
        Why it failed.
    """

    noun = ""

    def __init__(self) -> None:
        self.progress = self.noun, 0, 0
        self.state = "running"
        self.seconds, self._begun = 0.0, monotonic()
        self.error: Exception | None = None
        self._result: Result | None = None
        self._cancelled = False
        self._changed = Condition()

    def __repr__(self) -> str:
        noun, done, total = self.progress
        return f"<{type(self).__name__} {self.state}, {done} of {total} {noun}>"

    @abstractmethod
    def _work(self) -> Result:
        """Do all of it; call `_tell` or `_tick` often."""

    def cancel(self) -> None:
        """Break it off; return at once. What has ended stays as it is."""
        self._cancelled = True

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until it ends, or for some seconds; return whether it has ended."""
        with self._changed:
            return self._changed.wait_for(lambda: self.state != "running", timeout)

    @property
    def result(self) -> Result:
        """What it comes to, once it has ended; raises its error, or that it was cancelled."""
        self.wait()
        if self.error is not None:
            raise self.error
        if self._result is None:
            noun, done, total = self.progress
            raise LanindexError(f"cancelled after {done:,} of {total:,} {noun}")
        return self._result

    def _begin(self) -> None:
        Thread(target=self._run, name=type(self).__name__, daemon=True).start()

    def _run(self) -> None:
        state, error = "done", None
        try:
            self._result = self._work()
        except Exception as raised:
            state, error = "cancelled", None
            if not self._cancelled:
                state, error = "failed", raised
        with self._changed:
            self.state, self.error = state, error
            self._changed.notify_all()
        give_back()

    def _tick(self) -> None:
        self.seconds = monotonic() - self._begun
        if self._cancelled:
            raise Cancelled

    def _tell(self, noun: str, done: int, total: int) -> None:
        self.progress = noun, done, total
        self._tick()


Run = Callable[
    [Progress, Callable[[str], None], list[LanindexError], Found], tuple[Hits, Hits | Counts]
]
"""Searches: returns the hits, and what the stages of the pattern make of them."""


class SearchJob(Job["Hits | Counts"]):
    """A search that goes on in a thread. Made by `Library.begin`.

    Attributes
    ----------
    progress, state, error
        As of `Job`: ``captures`` that have been searched, then ``hits`` that are sorted or counted.
    pattern : str
        What is searched for.
    stamp : int, optional
        The library's stamp when the search began to read it; None until then.
    refused : list of LanindexError
        Once it has ended, an error for each capture that was too rich to be answered.
    notes : list of str
        Sentences that a user should know.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     job = library.begin("arms place high")
    ...     job.wait(timeout=60), job.state, job.progress
    ...     job.found, job.captures, [hit.start for hit in job.page(0, 3, order="best")]
    ...     job.facets("label").dicts()[0]
    ...     job.cancel()  # which it is too late for
    (True, 'done', ('captures', 10, 10))
    (5, 2, [23, 203, 383])
    {'by': 'clip.label', 'value': 'radio gymnastics', 'count': 4}
    """

    noun = "captures"

    def __init__(self, store: Store, pattern: str, run: Run) -> None:
        super().__init__()
        self.pattern = pattern
        self.stamp: int | None = None
        self.refused: list[LanindexError] = []
        self.notes: list[str] = []
        self._store, self._search = store, run
        self._pieces: Sequence[Hits] = ()
        self._ordered: dict[str, tuple[int, Hits]] = {}  # so many are in this order
        self._begin()

    @property
    def found(self) -> int:
        """How many hits there are so far."""
        return sum(map(len, list(self._pieces)))

    @property
    def captures(self) -> int:
        """How many captures have hits so far."""
        return sum(hits.captures for hits in list(self._pieces))

    def page(self, at: int, n: int, order: str = "") -> list[Hit]:
        """Return some of the hits.

        Parameters
        ----------
        at : int
            The first of them, from 0.
        n : int
            How many at most.
        order : str
            As `search` has them; ``best``: the clearest first; ``capture``: by capture, start and
            end; ``best capture``: the captures with the clearest hits first, the hits of each by
            start and end. While it runs, hits come by capture, whatever the order.

        Returns
        -------
        list of Hit
            Of a pattern that ends in ``| count``, the hits that all its stages began with.

        Raises
        ------
        LibraryError
            Where the library has changed since: a hit is gone, or another one now.
        UsageError
            Where there is no such page or order.
        """
        if at < 0 or n < 0:
            raise UsageError(f"{n} hits from {at}", wanted="two numbers from 0")
        if order not in ORDERS:
            raise UsageError(f'order "{order}"', wanted="best, capture or best capture")
        ended, page = self.state == "done", list[Hit]()
        pieces = [self._in_order(order, at + n)] if order and ended else list(self._pieces)
        for hits in pieces:
            page += hits[at : at + n - len(page)]
            at = max(0, at - len(hits))
            if len(page) == n:
                break
        return page

    def _in_order(self, order: str, most: int) -> Hits:
        """Return all hits in an order of which so many will be looked at."""
        (hits,) = self._pieces
        if order == "capture":
            return hits.at(np.lexsort((hits.high, hits.low, hits.place)))
        before, ordered = self._ordered.get(order, (0, hits))
        if before < most:
            most = max(most, 2 * before)
            ordered = hits.by_fit(most) if order == "best" else _best_captures(hits, most)
            self._ordered[order] = most, ordered
        return ordered

    def facets(self, field: str) -> Counts:
        """Count the hits so far by a field of their captures, as ``| count by clip.label`` does.

        Parameters
        ----------
        field : str
            ``label``, ``path``, ``format`` or any other column, with ``clip.`` before it or not.

        Returns
        -------
        Counts
            The most frequent value first.

        Raises
        ------
        LibraryError
            Where the library has changed since.
        UsageError
            Where no capture has such a column.
        """
        by = Reference(CLIP, field.removeprefix(f"{CLIP}.").lower())
        check_columns(self._store, [by])
        return counted(list(self._pieces), self.pattern, by)

    def _work(self) -> Hits | Counts:
        self.stamp = self._store.stamp()
        hits, result = self._search(self._tell, self.notes.append, self.refused, self._take)
        self._pieces = [result if isinstance(result, Hits) else hits]
        return result

    def _take(self, pieces: Sequence[Hits]) -> None:
        self._pieces = pieces
        self._tick()


def _best_captures(hits: Hits, most: int) -> Hits:
    """Return hits by capture, those first that have the clearest ones; so many are in order."""
    clearest = hits.by_fit(most).place  # the captures of so many hits have as many, or more
    first = np.zeros(clearest.max(initial=0) + 1, np.int64)
    first[clearest[::-1]] = np.arange(len(hits))[::-1]
    return hits.at(np.lexsort((hits.high, hits.low, first[hits.place])))


Ingest = Callable[[Callable[[], None]], tuple[int, Generator[Outcome, None, None]]]
"""Ingests, and calls its argument often: returns how many files there are, and their outcomes."""


class IngestJob(Job["list[Outcome]"]):
    """An ingest that goes on in a thread. Made by `begin_ingest` and `begin_encode` of a library.

    Iterated over, it yields the outcomes as they come, and raises its error at the end if it has
    one. It is cancelled between two files: what is stored by then stays, whole. The file
    that comes next is read to its end first, which takes some ten seconds for 76,000 frames.

    Attributes
    ----------
    progress, state, error
        As of `Job`: ``files`` that have been read.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("new.db", create=True) as library:
    ...     job = library.begin_ingest("corpus/compass.bvh")
    ...     job.wait(timeout=60), job.state, [outcome.status for outcome in job.outcomes]
    ...     job.cancel()  # which it is too late for
    (True, 'done', ['added'])
    """

    noun = "files"

    def __init__(self, run: Ingest) -> None:
        super().__init__()
        self._ingest = run
        self._outcomes: list[Outcome] = []
        self._begin()

    @property
    def outcomes(self) -> list[Outcome]:
        """The outcomes so far: one a file, or a person in it."""
        return list(self._outcomes)

    def __iter__(self) -> Iterator[Outcome]:
        """Yield the outcomes as they come."""
        at, ended = 0, False
        while not ended:
            with self._changed:
                while len(self._outcomes) == at and self.state == "running":
                    self._changed.wait()
                ended = self.state != "running"
            for outcome in self._outcomes[at:]:
                at += 1
                yield outcome
        if self.error is not None:
            raise self.error

    def _work(self) -> list[Outcome]:
        total, outcomes = self._ingest(self._tick)
        self._tell(self.noun, 0, total)
        files = set[str]()
        with closing(outcomes):
            for outcome in outcomes:
                files.add(parted(outcome.path)[0])
                with self._changed:
                    self._outcomes.append(outcome)
                    self._changed.notify_all()
                self._tell(self.noun, len(files), total)
        return self.outcomes
