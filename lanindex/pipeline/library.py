"""`Library`, the Python API: a library of captures that ingests, searches and exports."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from fractions import Fraction
from functools import cached_property, partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar
from weakref import WeakSet

from lanindex.errors import LanindexError, PatternError, UsageError
from lanindex.library.connect import DEFAULT, Progress, no_tick
from lanindex.library.selection import ALL, Selection
from lanindex.library.store import Store
from lanindex.search.hits import Found, Hits, piped
from lanindex.search.limits import deadline, running

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lanindex.draw.strip import Staff
    from lanindex.encoding.profile import Profile
    from lanindex.film.figure import Figure
    from lanindex.library.stats import Stats
    from lanindex.model import Capture, Hit, Reading, Score, Symbol, Track
    from lanindex.pipeline.cluster import Cluster
    from lanindex.pipeline.curves import Curves
    from lanindex.pipeline.example import Alike, Groups
    from lanindex.pipeline.ingest import Labels
    from lanindex.pipeline.jobs import IngestJob, Job, SearchJob
    from lanindex.pipeline.motifs import Motifs
    from lanindex.pipeline.movement import Movement
    from lanindex.pipeline.prepare import Outcome
    from lanindex.pipeline.search import SearchOptions
    from lanindex.search.explain.advice import Advice
    from lanindex.search.explain.english import Explanation
    from lanindex.search.explain.why import Trace
    from lanindex.search.hits import Counts
    from lanindex.search.language.builder import Pattern
    from lanindex.search.language.completion import Completion
    from lanindex.search.language.query import Query

AnyJob = TypeVar("AnyJob", bound="Job[Any]")

_FEWER = "Choose fewer captures: --in, --where."
_RARER = "Choose fewer captures (--in, --where) or parts, or ask for what occurs more often."


class Library:
    """Captures written down, to search and to cut clips from. Made by `open_library`.

    A capture is named by its number, or by its path: as ingested, absolute, or the end of it. What
    captures and symbols there are is the matter of its `store`.

    Several threads may use it at once: they share the columns and texts that are kept in memory,
    and those that write wait for each other. Hits may be looked at in another thread than the one
    that searched. A library in memory belongs to the thread that opened it.

    A pattern that is not understood raises a `PatternError`, a number that makes no sense or a
    name that nothing has a `UsageError`, a capture that is not there or a library that cannot be
    read a `LibraryError`, what takes longer than its `timeout` a `LanindexError`.

    Attributes
    ----------
    store : lanindex.library.store.Store
        The captures and their symbols; it also adds scores and gives symbols as columns.
    words : path-like, optional
        A file of the user's own words, beside those of ``lanindex.search.dictionary``.
    refused : list of LanindexError
        Of the searches so far: an error for each capture that was too rich to be answered.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     score = library.score("compass.bvh")
    ...     for capture in library.captures(lanindex.Selection("marching*")):
    ...         for _, tracks in library.tracks([capture.id], parts=["r_arm"]):
    ...             print(capture.id, capture.label, len(tracks["r_arm"]))
    ...     library.stats().captures, library.parts()[:2]
    6 marching 49
    (10, ['r_arm', 'l_arm'])
    >>> library = lanindex.open_library("dance.db")
    >>> library.label("compass.bvh", "directions")
    True
    >>> library.capture("compass.bvh").label
    'directions'
    >>> library.remove("marching.bvh")
    >>> library.close()
    """

    def __init__(
        self,
        store: Store,
        words: str | os.PathLike[str] | None = None,
        cluster: str | None = None,
    ) -> None:
        self.store, self.words, self.cluster = store, words, cluster
        self.refused: list[LanindexError] = []
        self._jobs: WeakSet[Job[Any]] = WeakSet()

    @classmethod
    def open(
        cls,
        named: str | os.PathLike[str] = DEFAULT,
        *,
        create: bool = False,
        readonly: bool = False,
        timeout: float = 30.0,
        words: str | os.PathLike[str] | None = None,
        note: Callable[[str], None] | None = None,
        progress: Progress | None = None,
        cluster: str | None = None,
    ) -> Self:
        """Open a library; use it as a context manager, or close it.

        Parameters
        ----------
        named : str or path-like
            A file, or an SQLAlchemy URL.
        create : bool
            Make it if there is none.
        readonly : bool
            Refuse to change it.
        timeout : float
            Seconds to wait for another process.
        words : path-like, optional
            A file of the user's own words, beside those of ``lanindex.search.dictionary``.
        note : callable, optional
            Is given each sentence that a user should know, such as what had to be mended; else they
            are kept in `notes`.
        progress : callable, optional
            Is called with what a long job goes through (``captures``), how many are done, and of
            how many; it may raise, which breaks the job off.
        cluster : str, optional
            Who does the work of large jobs, with the same results: the address of a scheduler of
            Dask, ``tcp://HOST:PORT``; ``local``: processes of this machine; ``slurm``. It is
            reached when it is needed first, and let go when the library is closed.

        Returns
        -------
        Library

        Raises
        ------
        LibraryError
            If there is none, it is no library, or it cannot be opened.
        LibraryVersionError
            If it is older or newer than this program.
        LibraryBusyError
            If another process holds it for longer than `timeout`.
        """
        store = Store.open(
            named, create=create, readonly=readonly, timeout=timeout, note=note, progress=progress
        )
        return cls(store, words, cluster)

    def __repr__(self) -> str:
        return f"<Library {self.store.place}>"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the database. Jobs that still run are cancelled."""
        for job in list(self._jobs):
            job.cancel()
        if opened := vars(self).pop("spread", None):
            opened.close()
        self.store.close()

    @cached_property
    def spread(self) -> Cluster | None:
        """The processes of the cluster, where there is one."""
        if self.cluster is None:
            return None
        from lanindex.pipeline.cluster import Cluster

        return Cluster(self.cluster, self.store.session.note)

    @property
    def notes(self) -> list[str]:
        """Sentences that a user should know, where no `note` was given to `open_library`."""
        return self.store.session.notes

    @property
    def stamp(self) -> int:
        """A number that changes with every change of the library."""
        return self.store.stamp()

    def ingest(
        self,
        *paths: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
        profile: str | os.PathLike[str] = "default",
        reading: Reading | None = None,
        labels: str | os.PathLike[str] | None = None,
        jobs: int = 1,
        force: bool = False,
    ) -> list[Outcome]:
        """Read files and folders into the library.

        Parameters
        ----------
        *paths : path-like, or iterable of path-like
            Captures, ``.lnd`` scores, and folders of them, or their URLs.
        profile : path-like
            How to write them down: ``default``, ``paper`` or a folder.
        reading : Reading, optional
            Unit, up axis, rate, order of rotations, where the reader shall not find them itself.
        labels : path-like, optional
            A CSV file with columns ``file``, ``label`` and any others.
        jobs : int
            Processes. Several begin by importing the script that runs: what it does must stand
            under ``if __name__ == "__main__":``.
        force : bool
            Read unchanged files again, too.

        Returns
        -------
        list of Outcome
            One a file, or a person in it: added, unchanged or failed, and why.

        Raises
        ------
        CaptureError
            Where one of several processes could not start, or died.
        LibraryError
            Where the library cannot be written.
        NotationError, UsageError
            Where profile or labels cannot be read, or no row of the labels names one of the files.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("own.db", create=True) as library:
        ...     for outcome in library.ingest("corpus/compass.bvh", "corpus/compass.lnd"):
        ...         print(outcome.status, outcome.path)
        added corpus/compass.bvh
        added corpus/compass.lnd
        """
        return list(self._ingest(paths, profile, reading, labels, jobs, force)[1])

    def begin_ingest(
        self,
        *paths: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
        profile: str | os.PathLike[str] = "default",
        reading: Reading | None = None,
        labels: str | os.PathLike[str] | Labels | None = None,
        jobs: int = 1,
        force: bool = False,
    ) -> IngestJob:
        """Begin to read files and folders into the library, in a thread, and return at once.

        Parameters
        ----------
        *paths, profile, reading, labels, jobs, force
            As for `ingest`; labels also as `lanindex.pipeline.ingest.read_labels` returns them.
            With two or more processes reading leaves this one free for others.

        Returns
        -------
        IngestJob
            How far it is, and the outcomes so far; iterated over, the outcomes as they come. What
            `ingest` raises is its `error`.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("new.db", create=True) as library:
        ...     job = library.begin_ingest("corpus/compass.bvh", "corpus/compass.lnd")
        ...     for outcome in job:
        ...         print(outcome.status, outcome.path)
        added corpus/compass.bvh
        added corpus/compass.lnd
        >>> job.state, job.progress
        ('done', ('files', 2, 2))
        """
        from lanindex.pipeline.jobs import IngestJob

        run = partial(self._ingest, paths, profile, reading, labels, jobs, force)
        return self._begun(IngestJob(run))

    def begin_encode(self, profile: str | os.PathLike[str], *, jobs: int = 1) -> IngestJob:
        """Begin to write all captures down anew by a profile, in a thread, and return at once.

        Parameters
        ----------
        profile : path-like
            ``default``, ``paper`` or a folder. Captures that have it already stay as they are, as
            do scores; others are read as they were when they were ingested, and keep their labels.
        jobs : int
            As for `ingest`.

        Returns
        -------
        IngestJob
            Its outcomes are those of the files that are read; where one is gone or has become
            unreadable, its captures keep the symbols that they have.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("anew.db", create=True) as library:
        ...     _ = library.ingest("corpus/compass.bvh", "corpus/compass.lnd")
        ...     job = library.begin_encode("paper")
        ...     [outcome.status for outcome in job]
        ['added']
        """
        from lanindex.encoding.profile import load
        from lanindex.pipeline.ingest import again
        from lanindex.pipeline.jobs import IngestJob

        chosen = load(os.fspath(profile))
        return self._begun(IngestJob(partial(again, self.store, chosen, jobs, self.spread)))

    def _ingest(
        self,
        paths: Iterable[str | os.PathLike[str] | Iterable[str | os.PathLike[str]]],
        profile: str | os.PathLike[str],
        reading: Reading | None,
        labels: str | os.PathLike[str] | Labels | None,
        jobs: int,
        force: bool,
        tick: Callable[[], None] = no_tick,
    ) -> tuple[int, Generator[Outcome, None, None]]:
        """Return how many files there are, and what reads them; `tick` is called with each."""
        from lanindex.encoding.profile import load
        from lanindex.pipeline.ingest import check_writable, discover, ingest, read_labels

        lists = ([path] if isinstance(path, str | os.PathLike) else path for path in paths)
        files = list[str]()
        for file in discover(chain.from_iterable(lists), apart=False):
            tick()
            files.append(file)
        table = read_labels(labels, files) if isinstance(labels, str | os.PathLike) else labels
        chosen = load(os.fspath(profile))
        check_writable(self.store, files, force=force)  # before a cluster is reached
        how: dict[str, Any] = {"labels": table, "jobs": jobs, "force": force}
        how |= {"spread": self.spread}
        return len(files), ingest(self.store, files, chosen, reading=reading, **how)

    def search(
        self,
        pattern: str | Pattern,
        selection: Selection = ALL,
        *,
        tolerance: float = 0.1,
        overlaps: str = "none",
        strict: bool = False,
        near: bool = False,
        fuzzy: str | float | None = None,
        timeout: float | None = None,
        best: int | None = None,
        memory: float | None = None,
    ) -> Hits | Counts:
        """Find movement by pattern.

        Parameters
        ----------
        pattern : str or Pattern
            ``r_arm right mid -> high``; ``search/LANGUAGE.md`` has the whole language. Or a word
            of ``lanindex.search.dictionary``: ``walk``; or what `lanindex.part` begins.
        selection : Selection
            Only these captures.
        tolerance : float
            Seconds within which edges agree.
        overlaps : str
            ``none``, or ``all``.
        strict : bool
            Whether the timing of pasted LND counts.
        near : bool
            Whether a symbol also matches by the cell across its nearest border, if it is near.
        fuzzy : str or float, optional
            How many edits a match may cost, 1.5, or how many for each step but the first two, 15%.
        timeout : float, optional
            Seconds after which to give up.
        best : int, optional
            Only so many, those that fit best, the clearest first; of a fuzzy search far sooner
            there than all of them.
        memory : float, optional
            Megabytes that the search may take; a quarter of what is free if not given.

        Returns
        -------
        Hits or Counts
            In order of capture, start and end, where the pattern does not sort them; each is made
            when it is looked at. Counts if it ends in ``| count``. Captures that are too rich for
            the pattern, or for the memory, are left out: `refused` has an error for each.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     hits = library.search(
        ...         "arms side high with legs side low", lanindex.Selection("*jacks*")
        ...     )
        >>> for hit in hits[:2]:
        ...     print(hit.capture.path, hit.span)
        corpus/jumping_jacks.bvh Span(start=60, stop=76)
        corpus/jumping_jacks.bvh Span(start=91, stop=106)
        """
        from lanindex.pipeline.search import SearchOptions

        options = SearchOptions.read(tolerance, overlaps, near, fuzzy, best, memory)
        progress = self.store.session.progress

        def counted(noun: str, done: int, total: int) -> None:
            if total:  # else it is not known yet how much there is to do
                progress(noun, done, total)

        told = counted, self.store.session.note, self.refused
        return self._search(pattern, selection, strict, timeout, options, *told)[1]

    def begin(
        self,
        pattern: str | Pattern,
        selection: Selection = ALL,
        *,
        strict: bool = False,
        timeout: float | None = None,
        **options: Any,
    ) -> SearchJob:
        """Begin a search in a thread of its own, and return at once.

        Parameters
        ----------
        pattern, selection, strict, timeout, **options
            As for `search`.

        Returns
        -------
        SearchJob
            How far it is, its hits so far, and what it found in the end, or why it failed.
            Notes and captures that are too rich are the job's, not the library's.

        Raises
        ------
        UsageError
            Where an option makes no sense. All else that is wrong is the job's `error`.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     job = library.begin("torso forward high -> hold 1s+")
        ...     print(len(job.result), job.state, job.page(0, 10)[0].span)
        1 done Span(start=482, stop=602)
        """
        from lanindex.pipeline.jobs import SearchJob
        from lanindex.pipeline.search import SearchOptions

        read = SearchOptions.read(**options)
        run = partial(self._search, pattern, selection, strict, timeout, read)
        return self._begun(SearchJob(self.store, str(pattern), run))

    def _search(
        self,
        pattern: str | Pattern,
        selection: Selection,
        strict: bool,
        timeout: float | None,
        options: SearchOptions,
        progress: Progress,
        note: Callable[[str], None],
        refused: list[LanindexError],
        found: Found | None = None,
    ) -> tuple[Hits, Hits | Counts]:
        """Return the hits of a search, and what the stages of its pipe make of them."""
        from lanindex.pipeline import search, shards
        from lanindex.search.match.finder import NARROWER

        find = partial(shards.search, self.spread) if self.spread else search.search
        tick = partial(progress, "captures", 0, 0)
        query, numbers = self._query(pattern, selection, strict, tick)
        best = options.best
        if query.stages:  # they need all hits
            options = replace(options, best=None)
        with deadline(progress, timeout, "search", NARROWER) as told:
            watch = partial(told, "captures")
            hits = find(self.store, query, numbers, options, watch, refused, note, found)
            hits = hits.of(str(pattern))
            tick = partial(told, "hits", 0, len(hits))
            if query.stages:
                tick()
            with running(options.memory, tick):
                result = piped(query.stages, hits)
                if best is not None and isinstance(result, Hits):
                    result = result.by_fit(best)[:best]
        return hits, result

    def complete(self, text: str, position: int | None = None) -> list[Completion]:
        """Return what may stand at a position of a pattern, the likeliest first.

        Parameters
        ----------
        text, position
            As for `lanindex.complete`; only parts of the library are offered, and its `words`, too.

        Returns
        -------
        list of Completion

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     (arm, *_) = library.complete("r_a")
        >>> arm.text, arm.kind, arm.start, arm.stop
        ('r_arm', 'part', 0, 3)
        """
        from lanindex.search.language.completion import complete

        parts = self.store.parts(checked=False) or None
        return complete(text, position, parts=parts, words=self.words)

    def parse(self, text: str, position: int | None = None) -> dict[str, Any]:
        """Return all that is known of a pattern while it is typed, for JSON.

        Parameters
        ----------
        text, position
            As for `complete`. A word of the dictionary may stand alone.

        Returns
        -------
        dict
            ``tree`` as `lanindex.pattern_tree` returns it, of a lone word that of its ``@name``;
            ``english``, a sentence; ``error`` as `lanindex.records.of_error` has it, then the first
            two are None; ``completions``, a list of the records of `complete`.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     found = library.parse("r_arm hi")
        >>> found["error"]["start"], found["completions"][0]["text"]
        (6, 'high')
        """
        from lanindex import records
        from lanindex.pipeline.search import entry_of_query, query_of
        from lanindex.search.explain.english import sentence
        from lanindex.search.language.written import pattern_tree

        completions = [it.record() for it in self.complete(text, position)]
        found = {"tree": None, "english": None, "error": None, "completions": completions}
        parts, entry = self.store.parts(checked=False), entry_of_query(text, self.words)
        try:
            query = query_of(text, parts, self.words)
            english = (entry and entry.sentence) or sentence(query)
            typed = f"@{entry.name}" if entry else text
            tree = pattern_tree(typed, parts=parts, words=self.words)
        except PatternError as error:
            return {**found, "error": records.of_error(error)}
        return {**found, "tree": tree, "english": english}

    def explain(
        self,
        pattern: str | Pattern,
        selection: Selection = ALL,
        *,
        strict: bool = False,
        plan: bool = False,
    ) -> Explanation:
        """Say how a pattern is understood, or how it is searched.

        Parameters
        ----------
        pattern, selection, strict
            As for `search`.
        plan : bool
            Whether to say how it is searched: states, edges, joins, and what the search leaves out.

        Returns
        -------
        Explanation
            In plain English; the symbols that each step alone would match; the order of work.
            Or the plan. As text all of it.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     print(library.explain("torso forward high -> hold 1s+").english)
        The torso moves forward, high (or begins there), then stays where it is, for at least 1 s.
        """
        from lanindex.search.explain.english import Explanation, explanation, planned, sentence

        query, numbers = self._query(pattern, selection, strict)
        if plan:
            return Explanation(str(query), sentence(query), {}, (), planned(query))
        return explanation(query, self.store.tracks(numbers, query.parts))

    def suggest(
        self,
        pattern: str | Pattern,
        selection: Selection = ALL,
        *,
        tolerance: float = 0.1,
        overlaps: str = "none",
        strict: bool = False,
        near: bool = False,
        fuzzy: str | float | None = None,
    ) -> Advice:
        """Say why a pattern finds nothing, and what would be found.

        Parameters
        ----------
        pattern, selection, tolerance, overlaps, strict, near, fuzzy
            As for `search`; what is offered is counted in the same way.

        Returns
        -------
        Advice
            What is found without each condition, and the nearest patterns that find something;
            what has been looked at after some two seconds. Captures that are too rich for one of
            them are left out: `refused` has an error for each.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     advice = library.suggest("torso forward high <0.5s")
        >>> print(advice)
        without "<0.5s": 1 hit, the nearest takes 1.4 s
        The nearest patterns that find something:
          torso forward high <=1.4s  1 hit in 1 capture
          torso forward high         1 hit in 1 capture
        """
        from lanindex.pipeline.search import SearchOptions, in_words, suggest

        options = SearchOptions.read(tolerance, overlaps, near, fuzzy)
        query, numbers = self._query(pattern, selection, strict)
        advice = suggest(self.store, query, numbers, options, self.refused)
        return in_words(advice, str(pattern), self.words)

    def why(
        self,
        pattern: str | Pattern,
        capture: int | str,
        *,
        tolerance: float = 0.1,
        overlaps: str = "none",
        strict: bool = False,
        near: bool = False,
    ) -> Trace:
        """Say step by step what a pattern met with in one capture.

        Parameters
        ----------
        pattern, tolerance, overlaps, strict, near
            As for `search`.
        capture : int or str
            Its number or path.

        Returns
        -------
        Trace
            The hits with the symbols that matched each step; where there are none, the furthest
            beginning that is found, and what came there instead; or why it cannot be told.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     (stop,) = library.why("torso forward high <0.5s", "greetings.bvh").stops
        >>> stop.reason
        'torso forward high [482, 524) takes 1.40 s, wanted <0.5s'
        """
        from lanindex.pipeline.search import SearchOptions
        from lanindex.search.explain.why import trace

        options = SearchOptions.read(tolerance, overlaps, near)
        query = replace(self._query(pattern, ALL, strict)[0], near=options.near)
        held, tracks = next(self.store.tracks([self.store.capture(capture).id]))
        return trace(query, held, tracks, tolerance=options.tolerance, overlaps=options.overlaps)

    def like(
        self,
        clip: int | str | os.PathLike[str],
        selection: Selection = ALL,
        *,
        limit: int = 100,
        rerank: bool = False,
        timeout: float | None = None,
    ) -> Alike:
        """Find captures that are like one; that one itself is left out.

        Parameters
        ----------
        clip : int, str or path-like
            A capture of the library (number or path) or a file elsewhere, each also with
            ``:from-to`` behind it (frames, half-open), or a line of ``search --json``.
        selection, timeout
            As for `search`.
        limit : int
            How many captures are wanted.
        rerank : bool
            Compare the joints of the best hundred, from their files, and leave out all others.

        Returns
        -------
        Alike
            Its `hits`, the likest first: each a whole capture, or, where that is at least twice
            as long as the example, perhaps a stretch of it. The fit is the likeness, 0 to 1.

        Raises
        ------
        UsageError
            Where there is no such clip, nothing moves in it, or `rerank` finds no joints of it.
        CaptureError, NotationError
            Where its file cannot be read.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     for hit in library.like("conductor_three.bvh", limit=1).hits:
        ...         print(hit.path, hit.span, round(hit.fit, 2))
        corpus/conductor_four.bvh Span(start=0, stop=1000) 0.79
        """
        from lanindex.pipeline.example import alike, example, reranked

        if limit < 1:
            raise UsageError(f"a limit of {limit}", wanted="1 or more")
        numbers = self.store.numbers(selection)
        with self._deadline(timeout, _FEWER) as watch:
            found = alike(self.store, example(self.store, clip), numbers, limit, watch)
            return reranked(self.store, found, watch) if rerank else found

    def similar(
        self,
        selection: Selection = ALL,
        *,
        groups: int | None = None,
        alike: float = 0.4,
        sample: int | None = None,
        timeout: float | None = None,
        progress: Progress | None = None,
    ) -> Groups:
        """Group the captures that are like each other.

        Parameters
        ----------
        selection, timeout
            As for `search`.
        groups : int, optional
            How many groups there shall be; fewer where there are fewer captures.
        alike : float
            Else the mean likeness, 0 to 1, of a group's captures at least.
        sample : int or None
            How many captures are compared: of more, so many taken at random; None: all.
        progress : callable, optional
            Is called with what is counted, how many are done, and of how many; it may raise, which
            breaks it off.

        Returns
        -------
        Groups
            The largest first, each with the capture first that is most like all others.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     first = library.similar(alike=0.7).groups[0]
        >>> [capture.label for capture in first.captures], round(first.likeness, 2)
        (['conducting', 'conducting'], 0.79)
        """
        from lanindex.pipeline.example import similar

        numbers = self.store.numbers(selection)
        with self._deadline(timeout, _FEWER, "grouping", progress) as watch:
            return similar(
                self.store,
                numbers,
                least=alike,
                wanted=groups,
                sample=sample,
                watch=watch,
                spread=self.spread,
            )

    def in_step(self, one: int | str, other: int | str) -> NDArray[np.float64]:
        """Return at which seconds two captures do the same.

        Joints are compared as any body would move anywhere, at most 30 frames a second and 1,500 of
        a capture (dynamic time warping); both begin together and end together.

        Parameters
        ----------
        one, other : int or str
            Their numbers or paths. A score is performed by the standard body.

        Returns
        -------
        numpy.ndarray
            (N, 2) float64, seconds of one and of the other; neither ever falls.

        Raises
        ------
        ExportError
            Where a source is gone or has changed since it was ingested.
        UsageError
            Where the hips or a leg of either are unknown.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     seconds = library.in_step("conductor_three.bvh", "conductor_four.bvh")
        >>> seconds.shape, seconds[150].round(2).tolist()
        ((643, 2), [5.0, 8.35])
        """
        from lanindex.pipeline.warping import in_step

        return in_step(self.store, self.capture(one), self.capture(other))

    def motifs(
        self,
        selection: Selection = ALL,
        *,
        min_count: int = 5,
        length: int = 3,
        parts: Iterable[str] | None = None,
        sample: int | None = None,
        timeout: float | None = None,
        progress: Progress | None = None,
    ) -> Motifs:
        """List the sequences of symbols that recur.

        Parameters
        ----------
        selection, timeout
            As for `search`.
        min_count : int
            How often one occurs at least.
        length : int
            How many symbols it has at least.
        parts : iterable of str, optional
            Only of these parts.
        sample : int or None
            How many captures are looked through: of more, so many taken at random; None: all.
        progress : callable, optional
            As for `similar`.

        Returns
        -------
        Motifs
            First what accounts for most symbols, then what accounts for most of the others.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     motif = library.motifs(parts=["l_arm"]).found[0]
        ...     motif.pattern, motif.hits, len(library.search(motif.pattern))
        ('l_arm left mid -> left low -> place low', 17, 17)
        """
        from lanindex.pipeline.motifs import recurring

        numbers = self.store.numbers(selection)
        sizes = min_count, length, sample
        with self._deadline(timeout, _RARER, progress=progress) as watch:
            return recurring(self.store, numbers, parts, *sizes, watch, self.spread)

    def movement(
        self,
        selection: Selection = ALL,
        *,
        by: str = "",
        compared: tuple[str, str] | None = None,
        parts: Iterable[str] = (),
    ) -> Movement:
        """Count how movement is spread: where parts go, from where, how often.

        Parameters
        ----------
        selection : Selection
            Only these captures.
        by : str
            What groups captures: ``label``, ``format`` or a column of the user's; empty: nothing.
        compared : tuple of str, optional
            Two of the groups: only these are counted.
        parts : iterable of str
            Which; else arms, legs, torso and head.

        Returns
        -------
        Movement
            By group and part; where there are two groups, also in what they differ.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     conductors = lanindex.Selection("*conductor*")
        ...     found = library.movement(conductors, by="label", parts=["r_arm"])
        >>> conducting = found.of("conducting", "r_arm")
        >>> conducting.captures, int(conducting.cells.sum()), round(conducting.rate, 2)
        (2, 88, 1.61)
        """
        from lanindex.pipeline.movement import movement

        how: dict[str, Any] = {"compared": compared, "parts": parts, "spread": self.spread}
        return movement(self.store, self.store.numbers(selection), by=by, **how)

    def export(
        self,
        hits: Iterable[Hit],
        folder: str | os.PathLike[str],
        *,
        pad: str = "0",
        format: str = "native",
        origin: bool = False,
        preview: str | None = None,
        force: bool = False,
    ) -> list[dict[str, Any]]:
        """Write hits as clips, in the format they came in or another.

        Parameters
        ----------
        hits : Hits, or any Hit in an iterable
            What to cut.
        folder : path-like
            Where to.
        pad : str
            Time before and after each: ``0.5s``, ``10f``.
        format : str
            ``native``, or what they shall be written in anew: `lanindex.pipeline.export.FORMATS`.
        origin : bool
            Let clips begin above the floor's origin, facing forward; they are written anew then.
        preview : str, optional
            ``webp``, ``gif`` or ``mp4``: write a film of each clip beside it, too.
        force : bool
            Replace files that are there.

        Returns
        -------
        list of dict
            The manifest, a clip each.

        Raises
        ------
        ExportError
            Where a hit comes from another library, a source has changed or is gone, or a file
            is there already; then nothing is written.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     hits = library.search("torso forward high -> hold 1s+")
        ...     for clip in library.export(hits, "clips", pad="0.5s"):
        ...         print(clip["clip"], clip["clip_start_frame"], clip["clip_end_frame"])
        greetings_467-617.bvh 467 617
        """
        from lanindex.pipeline.export import ClipOptions, export
        from lanindex.pipeline.named import from_hits

        requests = from_hits(hits, getattr(hits, "pattern", ""))
        options = ClipOptions(pad, format, origin, preview)
        how: dict[str, Any] = {"force": force, "spread": self.spread}
        return export(self.store, requests, Path(folder), options, **how)

    def dataset(
        self,
        found: Hits | Mapping[str, Hits] | None,
        folder: str | os.PathLike[str],
        *,
        layout: str = "npz",
        fps: float | str | None = None,
        pad: str = "0",
        split: str = "80/10/10",
        split_by: str | None = None,
        seed: int = 0,
        force: bool = False,
    ) -> dict[str, Any]:
        """Write hits as a data set to train on: joints, symbols and words, in splits, with a card.

        Parameters
        ----------
        found : Hits, or Mapping of str to Hits, or None
            What is in it; by label, where clips shall not have their captures'; None: all captures,
            each as a whole.
        folder, pad
            As for `export`.
        layout : str
            ``npz``, or ``humanml3d``.
        fps : number, optional
            Frames a second; else those of the captures.
        split : str
            Per cent for training, validation and testing.
        split_by : str, optional
            The column that tells what must stay in one split; else performers, where a column of
            that name or a like one tells them, and captures.
        seed : int
            Another one gives other splits.
        force : bool
            Replace a data set that is there.

        Returns
        -------
        dict
            The card: counts by split, label and licence, how it was found, what was left out.

        Raises
        ------
        ExportError
            Where the folder holds things, or a source has changed or is gone; then nothing is
            written.

        Examples
        --------
        >>> import lanindex
        >>> import numpy as np
        >>> with lanindex.open_library("dance.db") as library:
        ...     bows = library.search("torso forward high -> hold 1s+")
        ...     card = library.dataset({"bow": bows}, "bows", fps=20)
        >>> card["clips"], card["by_label"]["bow"]["captures"], card["split_by"]
        (1, 1, 'capture')
        >>> clip = np.load("bows/train/greetings_482-602.npz")
        >>> clip["joints"].shape, float(clip["fps"]), str(clip["texts"][0])
        ((80, 20, 3), 20.0, 'bow')
        """
        from lanindex.pipeline import dataset

        if found is None:
            groups = [dataset.of_captures(self.store.captures())]
        else:
            by_label = found if isinstance(found, Mapping) else {"": found}
            groups = [
                dataset.of_hits(hits, label, words=self.words) for label, hits in by_label.items()
            ]
        rate = None if fps is None else Fraction(fps).limit_denominator(10**6)
        options = dataset.DatasetOptions(layout, rate, pad, split, split_by, seed, force)
        return dataset.write(self.store, groups, Path(folder), options)[1]

    def motion(
        self,
        capture: int | str,
        start: float = 0.0,
        stop: float | None = None,
        fps: float | Fraction | None = None,
    ) -> Figure:
        """Return the stick figure of a capture in a window of time.

        A capture is read once and its figure kept in a temporary file, at most 2 GB of them; each
        window is then read from there, so that an hour takes no more memory than a minute.

        Parameters
        ----------
        capture : int or str
            Its number or path. A score is performed by the standard body, at 60 frames a second;
            one of more than 27 minutes at as many as make 100,000 frames.
        start, stop : float
            Seconds; without `stop` to the end.
        fps : float, optional
            Frames a second, at most; else all of the source.

        Returns
        -------
        Figure
            ``places`` (F, 21, 3) float32 mm, y up: the 20 joints and the nose, NaN where unknown;
            ``bones`` (B, 2), ``parts`` (B,), ``rate``, ``fronts`` (F,) radians. Frame i is that
            of the second ``ceil(start * rate) / rate + i / rate``: windows fit together.

        Raises
        ------
        ExportError
            Where the source is gone or has changed since it was ingested.
        UsageError
            Where the window lies outside of the capture.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     body = library.motion("compass.bvh", 2.0, 4.0, fps=25)
        ...     body.places.shape, body.rate, body.parts[:2]
        ((50, 21, 3), Fraction(25, 1), ('torso', 'torso'))
        """
        from lanindex.pipeline.motion import motion

        return motion(self.store, capture, start, stop, fps)

    def curves(
        self,
        capture: int | str,
        part: str,
        start: float = 0.0,
        stop: float | None = None,
        profile: Profile | str | os.PathLike[str] | None = None,
    ) -> Curves:
        """Return how a limb goes in a window of time, and what the method made of it.

        A limb is followed once through all of a capture and kept; windows are read from there.

        Parameters
        ----------
        capture : int or str
            Its number or path.
        part : str
            A limb: ``r_arm`` ...
        start, stop : float
            Seconds; without `stop` to the end.
        profile : Profile, str or path, optional
            As of `lanindex.encode`; else the one that the capture was written down with.

        Returns
        -------
        Curves
            ``times`` (N,) s, ``speed`` (N,) mm/s, ``azimuth`` and ``elevation`` (N,) degrees,
            ``cells`` (N,); ``thresholds``; ``candidates``, ``holds``, ``moves`` and ``runs`` that
            lie in the window or reach into it; ``record()`` as JSON. Frames are resampled ones.

        Raises
        ------
        ExportError
            Where the source is gone or has changed since it was ingested.
        UsageError
            Where the window lies outside of the capture; where it is a score, which has no limbs
            to follow, or the limb is not known; where its profile is not here any more.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     curves = library.curves("jumping_jacks.bvh", "r_arm", 1.0, 3.0)
        >>> curves.speed.shape, round(curves.thresholds.v0), round(curves.thresholds.d_t)
        ((120,), 621, 51)
        >>> curves.candidates.tolist(), curves.moves.tolist()
        ([118, 150], [[118, 150, 120, 150], [150, 180, 150, 180]])
        >>> [run["cell"] for run in curves.record()["runs"][:4]]
        ['place low', 'right low', 'right mid', 'right high']
        """
        from lanindex.pipeline.curves import curves

        path = os.fspath(profile) if isinstance(profile, os.PathLike) else profile
        return curves(self.store, capture, part, start, stop, path)

    def staff(
        self,
        which: int | str | Hit,
        start: float | None = None,
        stop: float | None = None,
        *,
        parts: Sequence[str] | None = None,
        detail: str = "plain",
        marked: Iterable[Symbol] = (),
        scale: float = 1.0,
        stretch: float = 1.0,
        near: bool = False,
    ) -> Staff:
        """Return the staff of a capture, of which windows are drawn that fit together.

        The staff of a capture is made once; the last eight are kept.

        Parameters
        ----------
        which : int, str or Hit
            A capture by its number or path; or a hit, whose symbols are marked.
        start, stop : float, optional
            Seconds of the window that is meant; else all of the capture, or those of the hit.
        parts : sequence of str, optional
            Tracks that have a column, drawn in full; else those that a reader expects.
        detail : str
            ``plain``: what a reader expects; ``full``: all that is known.
        marked : iterable of Symbol
            Symbols below which a band is laid.
        scale, stretch : float
            1: 56 pixels a second or beat; and how many times as high that is, beside signs of the
            same width.
        near : bool
            Of a capture of more than five minutes read what the window needs alone: other windows
            of this staff lack symbols.

        Returns
        -------
        Staff
            ``svg()``, ``y(seconds)``, ``seconds(y)``, ``columns``, ``symbols()``.

        Raises
        ------
        ExportError
            Where a hit comes from another library.
        UsageError
            Where the window lies outside of the capture, or a part has no column.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     staff = library.staff("compass.bvh", parts=["r_arm"])
        >>> tiles = [staff.svg(at, at + 4, foot=False) for at in (0, 4, 8)]
        >>> round(staff.y(0) - staff.y(4)), list(staff.columns)
        (224, ['r_arm'])
        """
        from lanindex.pipeline.staves import staff

        how: dict[str, Any] = {"parts": parts, "detail": detail, "marked": marked}
        how |= {"scale": scale, "stretch": stretch, "near": near}
        return staff(self.store, which, start, stop, **how)

    def pattern_of(
        self, which: int | str, start: float, stop: float, parts: Sequence[str] | None = None
    ) -> str:
        """Return what some seconds of a capture are as a pattern.

        Parameters
        ----------
        which : int or str
            The capture's number or path.
        start, stop : float
            Seconds; symbols that end within them are steps of the pattern.
        parts : sequence of str, optional
            Limbs that have a line; else the three of arms, legs, torso and head that move most.

        Returns
        -------
        str
            A pattern that finds the stretch, and others like it.

        Raises
        ------
        UsageError
            Where none of the parts moves.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     print(library.pattern_of("compass.bvh", 0, 4.5, ["r_arm"]))
        r_arm forward low -> r_forward low -> right low -> r_back low
        """
        from lanindex.search.example.stretch import pattern_of

        return pattern_of(self.store.score(which), start, stop, parts)

    def captures(self, selection: Selection = ALL) -> list[Capture]:
        """Return the selected captures in the order in which they came; all by default."""
        return self.store.captures(selection)

    def capture(self, which: int | str) -> Capture:
        """Return one capture, by its number or path; a `LibraryError` if none or several fit."""
        return self.store.capture(which)

    def score(self, which: int | str) -> Score:
        """Return the score of a capture, by its number or path, as it was stored."""
        return self.store.score(which)

    def tracks(
        self, captures: Iterable[int] | None = None, parts: Iterable[str] | None = None
    ) -> Iterator[tuple[Capture, dict[str, Track]]]:
        """Yield some captures, by number, or all, with their tracks, or those of some parts."""
        return self.store.tracks(captures, parts)

    def parts(self) -> list[str]:
        """Return the parts that any capture has, in the order of the alphabet."""
        return self.store.parts()

    def stats(self) -> Stats:
        """Count what the library holds."""
        return self.store.stats()

    def label(
        self, which: int | str, label: str | None = None, metadata: Mapping[str, str] | None = None
    ) -> bool:
        """Change the label and the other columns of a capture, and return whether any changed."""
        return self.store.label(which, label, metadata)

    def describe(
        self, changes: Iterable[tuple[int | str, str | None, Mapping[str, str] | None]]
    ) -> list[int]:
        """Change label and other columns of captures as `label` does, all or none.

        Parameters
        ----------
        changes : iterable of (int or str, str or None, mapping or None)
            Capture, label and other columns; None: as it is.

        Returns
        -------
        list of int
            The numbers of those that have changed.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     library.describe([(1, "compass", {"stage": "hall"}), (2, None, None)])
        [1]
        """
        return self.store.describe(changes)

    def remove(self, *which: int | str) -> None:
        """Take captures out, by number or path; none where one of them is not there."""
        self.store.remove(*which)

    def _begun(self, job: AnyJob) -> AnyJob:
        self._jobs.add(job)
        return job

    def _deadline(
        self,
        timeout: float | None,
        remedy: str,
        job: str = "search",
        progress: Progress | None = None,
    ) -> AbstractContextManager[Progress]:
        return deadline(progress or self.store.session.progress, timeout, job, remedy)

    def _query(
        self,
        pattern: str | Pattern,
        selection: Selection,
        strict: bool,
        tick: Callable[[], None] = no_tick,
    ) -> tuple[Query, list[int] | None]:
        """Return a query, and the numbers of the captures that it concerns; None: all."""
        from lanindex.pipeline.search import check_columns, query_of
        from lanindex.search.language.clauses import Reference
        from lanindex.search.language.query import nodes_in

        # the text of a file knows its place
        text = pattern if isinstance(pattern, str) else str(pattern)
        try:
            query = query_of(text, self.store.parts(checked=False), self.words, strict=strict)
        except PatternError:
            self.store.parts(
                tick=tick
            )  # raises if the part is unknown because the library is damaged
            raise
        check_columns(self.store, nodes_in((query.where, query.stages), Reference))
        return query, self.store.numbers(selection)


open_library = Library.open
