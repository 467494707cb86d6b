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
    """How a search is made."""

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
        """Return what a user says of it."""
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
        """Find a query in columns."""
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
