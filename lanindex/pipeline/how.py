"""How a search is made: checked once, whoever asks, and the same for all that follows from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING, Self

from lanindex.errors import LanindexError, UsageError
from lanindex.search.language.query import Query
from lanindex.search.match import Finder, Watch

if TYPE_CHECKING:
    from lanindex.model import Hit
    from lanindex.model.columns import Columns, Roster
    from lanindex.search.fuzzy import Allowance
    from lanindex.search.match.finder import Recordings

NEAR = 250
"""How far out the border of a cell lies with ``--near``, in thousandths of a margin."""


@dataclass(frozen=True, slots=True)
class How:
    """How a search is made.

    Attributes
    ----------
    tolerance : Fraction
        Seconds within which edges agree.
    overlaps : str
        ``none`` or ``all``.
    near : int
        How far out the border of a cell lies, in thousandths of a margin.
    allowance : Allowance or None
        How much a match may differ; None: not at all.
    """

    tolerance: Fraction = Fraction(1, 10)
    overlaps: str = "none"
    near: int = 0
    allowance: Allowance | None = None

    @classmethod
    def read(
        cls,
        tolerance: float = 0.1,
        overlaps: str = "none",
        near: bool = False,
        fuzzy: str | float | None = None,
    ) -> Self:
        """Return what a user says of it.

        Parameters
        ----------
        tolerance : float
            Seconds within which edges agree.
        overlaps : str
            ``none``, or ``all``.
        near : bool
            Whether a symbol also matches by the cell across its nearest border, if it is near.
        fuzzy : str or float, optional
            How many edits a match may cost, 1.5, or how many for each step but the first two, 15%.

        Raises
        ------
        UsageError
            Where a word or a number makes no sense, or two do not go together.
        """
        if not 0 <= tolerance < inf:
            raise UsageError(f"a tolerance of {tolerance} s", wanted="0 or more")
        if overlaps not in ("none", "all"):
            raise UsageError(f'overlaps "{overlaps}"', wanted="none or all")
        if near and fuzzy is not None:
            raise UsageError("near and fuzzy together", remedy="fuzzy counts what is near already.")
        allowance = None
        if fuzzy is not None:
            from lanindex.search.fuzzy import Allowance

            allowance = Allowance.read(str(fuzzy))
        return cls(Fraction(str(tolerance)), overlaps, NEAR if near else 0, allowance)

    def find(
        self,
        query: Query,
        roster: Roster,
        columns: Mapping[str, Columns],
        recordings: Recordings,
        watch: Watch | None = None,
        best: int | None = None,
        memory: int | None = None,
        refused: list[LanindexError] | None = None,
    ) -> Sequence[Hit]:
        """Find a query in columns.

        Parameters
        ----------
        query : Query
            What to find.
        roster : Roster
            The captures.
        columns : Mapping of str to Columns
            Of all ``query.parts``.
        recordings : callable
            Gives captures with some of their tracks, by their places in the roster.
        watch : callable, optional
            Is told now and then how many captures are done, of how many; it may raise.
        best : int, optional
            Only so many, those that fit best, the clearest first.
        memory : int, optional
            Bytes that an exact search may take; a quarter of what is free.
        refused : list of LanindexError, optional
            Takes an error for each capture that is too rich; None: the first one is raised.

        Raises
        ------
        UsageError
            Where the pattern says what has no edits, and some are allowed.
        """
        query = replace(query, near=self.near)
        if self.allowance is None:
            finder = Finder(query, roster, columns, recordings, self.tolerance, memory)
            return finder.find(self.overlaps, watch, best, refused)
        from lanindex.search import fuzzy

        return fuzzy.find(
            query,
            roster,
            columns,
            recordings,
            self.allowance,
            tolerance=self.tolerance,
            overlaps=self.overlaps,
            best=best,
            watch=watch,
            refused=refused,
        )
