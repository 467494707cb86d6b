"""A library searched: its columns for the engine, its rows for the hits that are shown."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import nullcontext
from fractions import Fraction
from typing import TYPE_CHECKING

from lanindex.errors import LibraryError
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Track
from lanindex.search.fast import Finder, Found, Watch
from lanindex.search.language.query import Query

if TYPE_CHECKING:
    from lanindex.model.columns import Roster
    from lanindex.search.fast.find import Recordings
    from lanindex.search.fuzzy import Allowance


def search(
    library: Store,
    query: Query,
    numbers: Sequence[int] | None,
    *,
    tolerance: Fraction,
    overlaps: str,
    watch: Watch | None = None,
) -> Found:
    """Find a pattern in a library.

    Parameters
    ----------
    library : Store
        Where. Hits that are looked at once it is closed are fetched from its file.
    query : Query
        What to find.
    numbers : sequence of int or None
        Only in these captures; None: in all.
    tolerance : Fraction
        Seconds within which edges agree.
    overlaps : str
        ``none`` or ``all``.
    watch : callable, optional
        Is told now and then how many captures are done, of how many; it may raise.

    Returns
    -------
    Found

    Raises
    ------
    LibraryError
        Where the library cannot be read.
    """
    roster, columns = library.columns(query.parts, numbers)
    finder = Finder(query, roster, columns, _recordings(library, roster), tolerance)
    return finder.find(overlaps, watch)


def nearly(
    library: Store,
    query: Query,
    numbers: Sequence[int] | None,
    allowance: Allowance,
    *,
    tolerance: Fraction,
    overlaps: str,
    watch: Watch | None = None,
) -> list[Hit]:
    """Find what is nearly a pattern in a library.

    Parameters
    ----------
    allowance : Allowance
        How much a match may differ.
    library, query, numbers, tolerance, overlaps, watch
        As for `search`.

    Returns
    -------
    list of Hit

    Raises
    ------
    LibraryError
        Where the library cannot be read.
    UsageError
        Where the pattern says what has no edits.
    """
    from lanindex.search import fuzzy

    roster, columns = library.columns(query.parts, numbers)
    recordings = _recordings(library, roster)
    return list(
        fuzzy.find(
            query,
            roster,
            columns,
            lambda places: recordings(places, query.parts),
            allowance,
            tolerance=tolerance,
            overlaps=overlaps,
            watch=watch,
        )
    )


def _recordings(library: Store, roster: Roster) -> Recordings:
    """Return what fetches captures with some of their tracks, by their places in a roster."""

    def recordings(
        places: Sequence[int], parts: Collection[str]
    ) -> Iterable[tuple[Capture, Mapping[str, Track]]]:
        wanted = roster.number[list(places)].tolist()
        with (
            nullcontext(library)
            if library.is_open
            else type(library).open(library.place, readonly=True) as opened
        ):
            found = list(opened.tracks(wanted, parts))
        if len(found) != len(wanted):
            raise LibraryError(
                f"{len(wanted) - len(found)} captures with hits are gone",
                place=library.place,
                remedy="Search again: the library has changed since.",
            )
        return found

    return recordings
