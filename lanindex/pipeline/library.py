"""The main job in one place: a library that reads, finds and exports."""

from __future__ import annotations

import os
from itertools import chain
from typing import TYPE_CHECKING

from lanindex.errors import PatternError
from lanindex.pipeline.asking import Asking
from lanindex.pipeline.exploring import Exploring
from lanindex.pipeline.exporting import Exporting
from lanindex.pipeline.patience import Patience
from lanindex.search.hits import Hits, piped

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lanindex.library.find import Where
    from lanindex.model import Reading
    from lanindex.pipeline.prepare import Outcome
    from lanindex.search.hits import Counts
    from lanindex.search.language.builder import Pattern
    from lanindex.search.language.query import Query


class Library(Asking, Exploring, Exporting):
    """Captures written down, to search and to cut clips from. Made by `open_library`.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     score = library.score("compass.bvh")
    ...     for capture, tracks in library.tracks(parts=["r_arm"]):
    ...         if capture in library.captures("marching*"):
    ...             print(capture.id, capture.label, len(tracks["r_arm"]))
    ...     library.stats().captures, library.parts()[:2], library.missing()
    6 marching 49
    (10, ['r_arm', 'l_arm'], [])
    >>> library = lanindex.open_library("dance.db")
    >>> library.label("compass.bvh", "directions")
    True
    >>> library.capture("compass.bvh").label
    'directions'
    >>> library.move("compass.bvh", "elsewhere/compass.bvh")
    >>> library.remove("marching.bvh")
    >>> number = library.add("own.lnd", score, format="lnd", sha256="0" * 64)
    >>> number, len(library.known()), len(library.located([], ["0" * 64]))
    (11, 10, 1)
    >>> library.close()
    """

    words: str | os.PathLike[str] | None = None
    """A file of the user's own words, beside those of ``lanindex.search.dictionary``."""

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
            Captures, ``.lnd`` scores, and folders of them.
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
        from lanindex.encoding.profile import load
        from lanindex.pipeline.discover import discover
        from lanindex.pipeline.ingest import ingest
        from lanindex.pipeline.labels import check_fit, read_labels

        lists = ([path] if isinstance(path, str | os.PathLike) else path for path in paths)
        found = list(discover(chain.from_iterable(lists), apart=False))
        named = {}
        if labels is not None:
            named = read_labels(labels)
            check_fit(named, found, labels)
        chosen = load(os.fspath(profile))
        return list(
            ingest(self, found, chosen, reading=reading, labels=named, jobs=jobs, force=force)
        )

    def search(
        self,
        pattern: str | Pattern,
        *,
        tolerance: float = 0.1,
        overlaps: str = "none",
        within: str | None = None,
        where: Where | None = None,
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
        tolerance : float
            Seconds within which edges agree.
        overlaps : str
            ``none``, or ``all``.
        within : str, optional
            Only captures whose path matches this glob.
        where : Mapping of str to str, optional
            Only captures that fit these globs by label, format, path or a column of their own.
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

        Raises
        ------
        PatternError
            Where the pattern is not understood.
        LibraryError
            Where the library cannot be read.
        LanindexError
            Where it takes longer than `timeout`.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     hits = library.search("arms side high with legs side low", within="*jacks*")
        >>> for hit in hits[:2]:
        ...     print(hit.capture.path, hit.span)
        corpus/jumping_jacks.bvh Span(start=60, stop=76)
        corpus/jumping_jacks.bvh Span(start=91, stop=106)
        """
        from lanindex.pipeline.how import How
        from lanindex.pipeline.search import search
        from lanindex.search.match.finder import NARROWER

        how = How.read(tolerance, overlaps, near, fuzzy)
        query, numbers = self._asked(pattern, within, where, strict)
        patience = Patience(self.watch, timeout, remedy=NARROWER)
        sooner = None if query.stages else best
        limit = None if memory is None else int(memory * 1e6)
        hits, refused = search(self, query, numbers, how, patience.of("captures"), sooner, limit)
        self.refused = [*self.refused, *refused]
        found = Hits(hits, str(pattern))
        told = piped(query.stages, found)
        return told.by_fit(best)[:best] if best is not None and isinstance(told, Hits) else told

    def explain(
        self,
        pattern: str | Pattern,
        *,
        within: str | None = None,
        where: Where | None = None,
        strict: bool = False,
        plan: bool = False,
    ) -> str:
        """Say how a pattern is understood, or how it is searched.

        Parameters
        ----------
        pattern : str or Pattern
            As for `search`.
        within : str, optional
            Only captures whose path matches this glob.
        where : Mapping of str to str, optional
            Only captures that fit these globs by label, format, path or a column of their own.
        strict : bool
            Whether the timing of pasted LND counts.
        plan : bool
            Whether to return the plan: states, edges, joins, and what the search leaves out.

        Returns
        -------
        str
            In plain English; the symbols that each step alone would match; the order of work.
            Or the plan.

        Raises
        ------
        PatternError
            Where the pattern is not understood.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     print(library.explain("torso forward high -> hold 1s+").splitlines()[0])
        The torso moves forward, high (or begins there), then stays where it is, for at least 1 s.
        """
        from lanindex.search.explain import explanation, planned

        query, numbers = self._asked(pattern, within, where, strict)
        if plan:
            return planned(query)
        return explanation(query, self.tracks(numbers, query.parts))

    def _asked(
        self, pattern: str | Pattern, within: str | None, where: Where | None, strict: bool
    ) -> tuple[Query, list[int] | None]:
        """Return a query, and the numbers of the captures that it concerns; None: all."""
        from lanindex.pipeline.columns import check_columns
        from lanindex.pipeline.words import named, said
        from lanindex.search.language import parse

        # the text of a file knows its place
        text = said(pattern if isinstance(pattern, str) else str(pattern), self.words)
        names = named(text, self.words)
        try:
            held = self.parts(checked=False)
            query = parse(text, held, names=names, strict=strict)
        except PatternError:
            self.parts()  # is a part unknown because the library is damaged? That would be said
            raise
        check_columns(self, query)
        return query, self._chosen(within, where)


open_library = Library.open
