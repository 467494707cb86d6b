"""What a library says of a pattern that finds nothing: why, and what is near."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from lanindex.library import store

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lanindex.errors import LanindexError
    from lanindex.library.find import Where
    from lanindex.search.explain import Advice, Trace
    from lanindex.search.language.builder import Pattern
    from lanindex.search.language.query import Query


class Asking(store.Store):
    """A library that can be asked about patterns."""

    refused: Sequence[LanindexError] = ()
    """Of the searches so far: an error for each capture that was too rich to be answered."""

    if TYPE_CHECKING:

        def _asked(
            self, pattern: str | Pattern, within: str | None, where: Where | None, strict: bool
        ) -> tuple[Query, list[int] | None]: ...

    def suggest(
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
    ) -> Advice:
        """Say why a pattern finds nothing, and what would be found.

        Parameters
        ----------
        pattern, tolerance, overlaps, within, where, strict, near, fuzzy
            As for `search`; what is offered is counted in the same way.

        Returns
        -------
        Advice
            What is found without each condition, and the nearest patterns that find something;
            what has been looked at after some two seconds. Captures that are too rich for one of
            them are left out: `refused` has an error for each.

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
        ...     advice = library.suggest("torso forward high <0.5s")
        >>> print(advice)
        without "<0.5s": 1 hit, the nearest takes 1.4 s
        The nearest patterns that find something:
          torso forward high <=1.4s  1 hit in 1 capture
          torso forward high         1 hit in 1 capture
        """
        from lanindex.pipeline.advise import suggest
        from lanindex.pipeline.how import How

        how = How.read(tolerance, overlaps, near, fuzzy)
        query, chosen = self._asked(pattern, within, where, strict)
        advice, refused = suggest(self, query, chosen, how)
        self.refused = [*self.refused, *refused]
        return advice

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

        Raises
        ------
        PatternError
            Where the pattern is not understood.
        LibraryError
            Where there is no such capture, or it cannot be read.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     (stop,) = library.why("torso forward high <0.5s", "greetings.bvh").stops
        >>> stop.reason
        'torso forward high [482, 524) takes 1.40 s, wanted <0.5s'
        """
        from lanindex.pipeline.how import How
        from lanindex.search.explain import trace

        how = How.read(tolerance, overlaps, near)
        query = replace(self._asked(pattern, None, None, strict)[0], near=how.near)
        held, tracks = next(self.tracks([self.capture(capture).id]))
        return trace(query, held, tracks, tolerance=how.tolerance, overlaps=how.overlaps)
