"""What stands behind a pattern, as a tree: conditions of ``where``, and the stages of a pipe.

Every node prints as it is written.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from lanindex.alphabet import MEASURES
from lanindex.search.language.times import Time, decimal

CLIP, MATCH = "clip", "match"
"""What may be spoken of besides labels: the capture, and all that matched."""

FIELDS = (
    *("part", "direction", "level", "start", "end", "length", "swings", "margin", "else"),
    *("degrees", "feet", "bend", "touched", "carrier", *MEASURES),
)
"""What a label, or `MATCH`, has; `CLIP` has the capture's own columns."""


@dataclass(frozen=True, slots=True)
class Reference:
    """A field of a labelled step, of ``match`` or of ``clip``: ``a.start``."""

    name: str
    field: str

    def __str__(self) -> str:
        """Return it as written."""
        return f"{self.name}.{self.field}"


@dataclass(frozen=True, slots=True)
class Number:
    """A bare number, as for ``margin`` and ``swings``."""

    value: Fraction

    def __str__(self) -> str:
        """Return it as written."""
        return decimal(self.value)


@dataclass(frozen=True, slots=True)
class Text:
    """A text in quotation marks; also a part, which is written without them."""

    text: str

    def __str__(self) -> str:
        """Return it as written."""
        return f'"{self.text}"'


@dataclass(frozen=True, slots=True)
class Value:
    """A direction, a level or a kind of jump: ``right``, ``mid``, ``hop``."""

    kind: str
    value: str

    def __str__(self) -> str:
        """Return it as written."""
        return self.value


Term = Reference | Time | Number | Text | Value


@dataclass(frozen=True, slots=True)
class Sum:
    """Terms added up and taken away; of one term alone it is that one.

    Attributes
    ----------
    terms : tuple of tuple of int and Term
        1 or -1 with each.
    """

    terms: tuple[tuple[int, Term], ...]

    def __str__(self) -> str:
        """Return it as written."""
        said = "".join(f" {'+' if sign > 0 else '-'} {term}" for sign, term in self.terms)
        return said.removeprefix(" + ")


@dataclass(frozen=True, slots=True)
class Comparison:
    """One side compared with the other: ``b.start - a.end < 0.5s``."""

    left: Sum
    compare: str
    right: Sum

    def __str__(self) -> str:
        """Return it as written."""
        return f"{self.left} {self.compare} {self.right}"


@dataclass(frozen=True, slots=True)
class Mirrors:
    """Two labels, one the mirror image of the other, symbol by symbol."""

    first: str
    second: str

    def __str__(self) -> str:
        """Return it as written."""
        return f"{self.first} mirrors {self.second}"


Condition = Comparison | Mirrors


@dataclass(frozen=True, slots=True)
class Count:
    """How many hits there are, or how many for each value of a field."""

    by: Reference | None = None

    def __str__(self) -> str:
        """Return it as written."""
        return f"count by {self.by}" if self.by else "count"


@dataclass(frozen=True, slots=True)
class Sort:
    """Hits by a field, the smallest first."""

    by: Reference

    def __str__(self) -> str:
        """Return it as written."""
        return f"sort by {self.by}"


@dataclass(frozen=True, slots=True)
class First:
    """The first so many."""

    count: int

    def __str__(self) -> str:
        """Return it as written."""
        return f"first {self.count}"


Stage = Count | Sort | First


def references_in(clauses: Iterable[Condition | Stage]) -> Iterator[Reference]:
    """Yield the fields that conditions and stages speak of."""
    for clause in clauses:
        match clause:
            case Comparison(left=left, right=right):
                terms = (term for _, term in (*left.terms, *right.terms))
                yield from (term for term in terms if isinstance(term, Reference))
            case Count(by=Reference() as by) | Sort(by=by):
                yield by
