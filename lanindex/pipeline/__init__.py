"""The main job in one place: a library that reads, finds and exports."""

from __future__ import annotations

import os
from fractions import Fraction
from itertools import chain
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex.alphabet import PARTS
from lanindex.errors import PatternError, UsageError
from lanindex.library import store
from lanindex.search.hits import Hits

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from lanindex.library.find import Where
    from lanindex.model import Capture, Hit, Reading, Track
    from lanindex.pipeline.example import Alike
    from lanindex.pipeline.motifs import Motifs
    from lanindex.pipeline.prepare import Outcome
    from lanindex.pipeline.similar import Groups
    from lanindex.search.language.query import Query


class Library(store.Store):
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
            One a file: added, unchanged or failed, and why.

        Raises
        ------
        CaptureError
            Where one of several processes could not start, or died.
        LibraryError
            Where the library cannot be written.
        NotationError, UsageError
            Where profile or labels cannot be read.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("own.db", create=True) as library:
        ...     for outcome in library.ingest("corpus/compass.bvh", "corpus/compass.lnd"):
        ...         print(outcome.status, outcome.path)
        added corpus/compass.bvh
        added corpus/compass.lnd
        """
        from lanindex.encode.profile import load
        from lanindex.pipeline.ingest import discover, ingest
        from lanindex.pipeline.labels import read_labels

        named = read_labels(labels) if labels is not None else {}
        lists = ([path] if isinstance(path, str | os.PathLike) else path for path in paths)
        found = discover(chain.from_iterable(lists))
        chosen = load(os.fspath(profile))
        return list(
            ingest(self, found, chosen, reading=reading, labels=named, jobs=jobs, force=force)
        )

    def search(
        self,
        pattern: str,
        *,
        tolerance: float = 0.1,
        overlaps: str = "none",
        within: str | None = None,
        where: Where | None = None,
    ) -> Hits:
        """Find movement by pattern.

        Parameters
        ----------
        pattern : str
            ``r_arm right mid -> high``; ``search/LANGUAGE.md`` has the whole language.
        tolerance : float
            Seconds within which edges agree.
        overlaps : str
            ``none``, or ``all``.
        within : str, optional
            Only captures whose path matches this glob.
        where : Mapping of str to str, optional
            Only captures that fit these globs by label, format, path or a column of their own.

        Returns
        -------
        Hits
            In order of capture, start and end.

        Raises
        ------
        PatternError
            Where the pattern is not understood.
        LibraryError
            Where the library cannot be read.

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
        from lanindex.search.plain import find

        if not 0 <= tolerance < inf:
            raise UsageError(f"a tolerance of {tolerance} s", wanted="0 or more")
        query, recordings = self._asked(pattern, within, where)
        span = Fraction(str(tolerance))
        return Hits(find(query, recordings, tolerance=span, overlaps=overlaps), pattern)

    def like(
        self,
        clip: int | str | os.PathLike[str],
        *,
        limit: int = 100,
        rerank: bool = False,
        within: str | None = None,
        where: Where | None = None,
    ) -> Alike:
        """Find captures that are like one; that one itself is left out.

        Parameters
        ----------
        clip : int, str or path-like
            A capture of the library (number or path) or a file elsewhere, each also with
            ``:from-to`` behind it (frames, half-open), or a line of ``search --json``.
        limit : int
            How many captures are wanted.
        rerank : bool
            Put the best hundred in the order in which their joints move alike, from their files.
        within : str, optional
            Only captures whose path matches this glob.
        where : Mapping of str to str, optional
            Only captures that fit these globs by label, format, path or a column of their own.

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
        from lanindex.pipeline.example import alike, example

        if limit < 1:
            raise UsageError(f"a limit of {limit}", wanted="1 or more")
        found = alike(self, example(self, clip), self._chosen(within, where), limit)
        if rerank:
            from lanindex.pipeline.rerank import reranked

            found = reranked(self, found)
        return found

    def similar(
        self,
        *,
        groups: int | None = None,
        alike: float = 0.4,
        within: str | None = None,
        where: Where | None = None,
    ) -> Groups:
        """Group the captures that are like each other.

        Parameters
        ----------
        groups : int, optional
            How many groups there shall be.
        alike : float
            Else the mean likeness, 0 to 1, of a group's captures at least.
        within : str, optional
            Only captures whose path matches this glob.
        where : Mapping of str to str, optional
            Only captures that fit these globs by label, format, path or a column of their own.

        Returns
        -------
        Groups
            The largest first, each with the capture first that is most like all others.

        Raises
        ------
        UsageError
            Where a number makes no sense.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     first = library.similar(alike=0.7).groups[0]
        >>> [capture.label for capture in first.captures], round(first.likeness, 2)
        (['conducting', 'conducting'], 0.79)
        """
        from lanindex.pipeline.similar import similar

        return similar(self, self._chosen(within, where), least=alike, wanted=groups)

    def motifs(
        self,
        *,
        min_count: int = 5,
        length: int = 3,
        parts: Iterable[str] | None = None,
        within: str | None = None,
        where: Where | None = None,
    ) -> Motifs:
        """List the sequences of symbols that recur.

        Parameters
        ----------
        min_count : int
            How often one occurs at least.
        length : int
            How many symbols it has at least.
        parts : iterable of str, optional
            Only of these parts.
        within : str, optional
            Only captures whose path matches this glob.
        where : Mapping of str to str, optional
            Only captures that fit these globs by label, format, path or a column of their own.

        Returns
        -------
        Motifs
            First what accounts for most symbols, then what accounts for most of the others.

        Raises
        ------
        UsageError
            Where a number makes no sense, or the library has no such part.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     motif = library.motifs(parts=["l_arm"]).found[0]
        ...     motif.pattern, motif.hits, len(library.search(motif.pattern))
        ('l_arm left mid -> left low -> place low', 17, 17)
        """
        from lanindex.pipeline.motifs import recurring

        chosen = self._chosen(within, where)
        return recurring(self, chosen, parts, least=min_count, shortest=length)

    def _chosen(self, within: str | None, where: Where | None) -> list[int] | None:
        """Return the numbers of the captures that are asked for, None for all."""
        if within is None and not where:
            return None
        return [capture.id for capture in self.captures(within, where)]

    def explain(
        self, pattern: str, *, within: str | None = None, where: Where | None = None
    ) -> str:
        """Say how a pattern is understood.

        Parameters
        ----------
        pattern : str
            As for `search`.
        within : str, optional
            Only captures whose path matches this glob.
        where : Mapping of str to str, optional
            Only captures that fit these globs by label, format, path or a column of their own.

        Returns
        -------
        str
            In plain English; the symbols that each step alone would match; the order of work.

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
        from lanindex.search.explain import explanation

        return explanation(*self._asked(pattern, within, where))

    def _asked(
        self, pattern: str, within: str | None, where: Where | None
    ) -> tuple[Query, Iterator[tuple[Capture, dict[str, Track]]]]:
        """Return a query, and what of the library it concerns."""
        from lanindex.search.language import parse

        # a part that is encoded, though in none of these captures, is no mistake: it never moves
        try:
            query = parse(pattern, self.parts(checked=False), known=PARTS)
        except PatternError:
            self.parts()  # is a part unknown because the library is damaged? That would be said
            raise
        return query, self.tracks(self._chosen(within, where), query.parts)

    def export(
        self,
        hits: Iterable[Hit],
        folder: str | os.PathLike[str],
        *,
        pad: str = "0",
        format: str = "native",
        force: bool = False,
    ) -> list[dict[str, Any]]:
        """Write hits as clips in the format they came in.

        Parameters
        ----------
        hits : Hits, or any Hit in an iterable
            What to cut.
        folder : path-like
            Where to.
        pad : str
            Time before and after each: ``0.5s``, ``10f``.
        format : str
            ``native``, ``bvh`` or ``lnd``.
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
        from lanindex.pipeline.export import export
        from lanindex.pipeline.requests import from_hits

        wanted = from_hits(hits, getattr(hits, "pattern", ""))
        return export(self, wanted, Path(folder), pad=pad, format=format, force=force)


open_library = Library.open
