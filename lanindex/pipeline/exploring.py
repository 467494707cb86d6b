"""What a library tells before one knows what to ask: what is like what, and what recurs."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING

from lanindex.errors import UsageError
from lanindex.library import store
from lanindex.pipeline.patience import Patience

if TYPE_CHECKING:
    from lanindex.library.find import Where
    from lanindex.pipeline.example import Alike
    from lanindex.pipeline.motifs import Motifs
    from lanindex.pipeline.movement import Movement
    from lanindex.pipeline.similar import Groups


_FEWER = "Choose fewer captures: --in, --where."
_RARER = "Choose fewer captures (--in, --where) or parts, or ask for what occurs more often."


class Exploring(store.Store):
    """A library that can be explored by example."""

    def like(
        self,
        clip: int | str | os.PathLike[str],
        *,
        limit: int = 100,
        rerank: bool = False,
        within: str | None = None,
        where: Where | None = None,
        timeout: float | None = None,
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
        timeout : float, optional
            Seconds after which to give up.

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
        LanindexError
            Where it takes longer than `timeout`.

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
        patience = Patience(self.watch, timeout, remedy=_FEWER)
        chosen = self._chosen(within, where)
        found = alike(self, example(self, clip), chosen, limit, patience)
        if rerank:
            from lanindex.pipeline.rerank import reranked

            found = reranked(self, found, patience)
        return found

    def similar(
        self,
        *,
        groups: int | None = None,
        alike: float = 0.4,
        sample: int | None = None,
        within: str | None = None,
        where: Where | None = None,
        timeout: float | None = None,
    ) -> Groups:
        """Group the captures that are like each other.

        Parameters
        ----------
        groups : int, optional
            How many groups there shall be; fewer where there are fewer captures.
        alike : float
            Else the mean likeness, 0 to 1, of a group's captures at least.
        sample : int or None
            How many captures are compared: of more, so many taken at random; None: all.
        within : str, optional
            Only captures whose path matches this glob.
        where : Mapping of str to str, optional
            Only captures that fit these globs by label, format, path or a column of their own.
        timeout : float, optional
            Seconds after which to give up.

        Returns
        -------
        Groups
            The largest first, each with the capture first that is most like all others.

        Raises
        ------
        UsageError
            Where a number makes no sense.
        LanindexError
            Where it takes longer than `timeout`.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     first = library.similar(alike=0.7).groups[0]
        >>> [capture.label for capture in first.captures], round(first.likeness, 2)
        (['conducting', 'conducting'], 0.79)
        """
        from lanindex.pipeline.similar import similar

        patience = Patience(self.watch, timeout, "grouping", _FEWER)
        chosen = self._chosen(within, where)
        return similar(self, chosen, least=alike, wanted=groups, sample=sample, patience=patience)

    def motifs(
        self,
        *,
        min_count: int = 5,
        length: int = 3,
        parts: Iterable[str] | None = None,
        sample: int | None = None,
        within: str | None = None,
        where: Where | None = None,
        timeout: float | None = None,
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
        sample : int or None
            How many captures are looked through: of more, so many taken at random; None: all.
        within : str, optional
            Only captures whose path matches this glob.
        where : Mapping of str to str, optional
            Only captures that fit these globs by label, format, path or a column of their own.
        timeout : float, optional
            Seconds after which to give up.

        Returns
        -------
        Motifs
            First what accounts for most symbols, then what accounts for most of the others.

        Raises
        ------
        UsageError
            Where a number makes no sense, or the library has no such part.
        LanindexError
            Where it takes longer than `timeout`.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     motif = library.motifs(parts=["l_arm"]).found[0]
        ...     motif.pattern, motif.hits, len(library.search(motif.pattern))
        ('l_arm left mid -> left low -> place low', 17, 17)
        """
        from lanindex.pipeline.motifs import recurring

        patience = Patience(self.watch, timeout, remedy=_RARER)
        chosen = self._chosen(within, where)
        return recurring(
            self, chosen, parts, least=min_count, shortest=length, sample=sample, patience=patience
        )

    def movement(
        self,
        *,
        by: str = "",
        compared: tuple[str, str] | None = None,
        parts: Iterable[str] = (),
        within: str | None = None,
        where: Where | None = None,
    ) -> Movement:
        """Count how movement is spread: where parts go, from where, how often.

        Parameters
        ----------
        by : str
            What groups captures: ``label``, ``format`` or a column of the user's; empty: nothing.
        compared : tuple of str, optional
            Two of the groups: only these are counted.
        parts : iterable of str
            Which; else arms, legs, torso and head.
        within : str, optional
            Only captures whose path matches this glob.
        where : Mapping of str to str, optional
            Only captures that fit these globs by label, format, path or a column of their own.

        Returns
        -------
        Movement
            By group and part; where there are two groups, also in what they differ.

        Raises
        ------
        UsageError
            Where there is no such column, group or part.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     found = library.movement(by="label", parts=["r_arm"], within="*conductor*")
        >>> conducting = found.of("conducting", "r_arm")
        >>> conducting.captures, int(conducting.cells.sum()), round(conducting.rate, 2)
        (2, 88, 1.61)
        """
        from lanindex.pipeline.movement import movement

        return movement(self, self._chosen(within, where), by=by, compared=compared, parts=parts)

    def _chosen(self, within: str | None, where: Where | None) -> list[int] | None:
        """Return the numbers of the captures that are asked for, None for all."""
        if within is None and not where:
            return None
        return self.numbers(within, where)
