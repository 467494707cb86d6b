"""How much a match may differ from its pattern."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from lanindex.errors import UsageError
from lanindex.search.fuzzy.costs import UNIT

CARRYING = 2
"""Steps that a share of edits is not given for: without them nothing is left of a pattern."""


@dataclass(frozen=True, slots=True)
class Allowance:
    """How much a match may differ from its pattern.

    Attributes
    ----------
    edits : Fraction
        How many edits, or, as a share, how many for each step but the first `CARRYING`.
    share : bool
        Whether it is a share.

    Examples
    --------
    >>> from lanindex.search.fuzzy import Allowance
    >>> Allowance.read("2").of(5), Allowance.read("20%").of(7)
    (128, 64)
    """

    edits: Fraction
    share: bool = False

    @classmethod
    def read(cls, text: str) -> Allowance:
        """Return what ``2``, ``0.5`` or ``20%`` means.

        Raises
        ------
        UsageError
            Where it is none of these.
        """
        number = text.strip().removesuffix("%")
        share = number != text.strip()
        if not number.replace(".", "", 1).isdecimal() or len(number) > 9:
            raise UsageError(f'"{text}" edits', wanted="a number of edits, 2, or a share, 20%")
        edits = Fraction(number) / (100 if share else 1)
        return cls(edits, share)

    def of(self, steps: int) -> int:
        """Return how much a pattern of so many steps may cost, in parts of an edit."""
        edits = self.edits * max(steps - CARRYING, 0) if self.share else self.edits
        return int(edits * UNIT)
