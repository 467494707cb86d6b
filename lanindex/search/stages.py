"""What a pipe makes of hits: sorted, the first ones, or counted.

``sort by`` puts the smallest first and what is missing last, ties as they were; ``count by`` puts
the most frequent value first, of equally frequent ones the smallest.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, overload

from lanindex.errors import UsageError
from lanindex.model.capture import readable
from lanindex.search.fields import Value, is_of_span, order, value_of, value_of_span
from lanindex.search.hits import FEW, Hits
from lanindex.search.language.clauses import Reference, Stage


@dataclass(frozen=True, slots=True)
class Counted:
    """How many hits have one value of a field."""

    value: str | float | None  # times in seconds; None where it is missing, or all are counted
    count: int


class Counts(Sequence[Counted]):
    """How many hits of a pattern there are, or how many for each value of a field, in order.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     counts = library.search("arms place high | count by clip.label | first 2")
    >>> for one in counts:
    ...     print(one.value, one.count)
    radio gymnastics 4
    port de bras 1
    >>> counts.total, counts.dicts()[0]
    (5, {'by': 'clip.label', 'value': 'radio gymnastics', 'count': 4})
    """

    def __init__(self, found: Iterable[Counted], pattern: str, by: Reference | None) -> None:
        self._counts = tuple(found)
        self.pattern, self.by = pattern, by

    @overload
    def __getitem__(self, index: int) -> Counted: ...
    @overload
    def __getitem__(self, index: slice) -> Counts: ...
    def __getitem__(self, index: int | slice) -> Counted | Counts:
        """Return one of them, or some."""
        if isinstance(index, slice):
            return Counts(self._counts[index], self.pattern, self.by)
        return self._counts[index]

    def __len__(self) -> int:
        """Return how many values there are."""
        return len(self._counts)

    def __bool__(self) -> bool:
        """Return whether anything was counted."""
        return self.total > 0

    def __repr__(self) -> str:
        """Return the first of them, a line each."""
        lines = [f"  {readable(str(one.value))}  {one.count}" for one in self._counts[:FEW]]
        hits = f"{self.total} hit{'s'[: self.total != 1]}{f' by {self.by}' if self.by else ''}"
        head = f"<{hits}: {readable(self.pattern)}>"
        return "\n".join([head, *(lines if self.by else [])])

    @property
    def total(self) -> int:
        """All of them together."""
        return sum(one.count for one in self._counts)

    def dicts(self) -> list[dict[str, Any]]:
        """Return them as dictionaries, as the command prints with ``--json``."""
        by = str(self.by) if self.by else None
        return [{"by": by, "value": one.value, "count": one.count} for one in self._counts]


def piped(stages: Sequence[Stage], found: Hits | Counts) -> Hits | Counts:
    """Return what the stages of a pipe make of hits, which come by capture, start and end."""
    for stage in stages:
        if stage.verb == "first":
            found = found[: stage.most]
        elif isinstance(found, Hits):
            by = stage.by
            found = _sorted(found, by) if by and stage.verb == "sort" else _counts(found, by)
    return found


def hits_in(found: Hits | Counts) -> Hits:
    """Return the hits; refuse counts, which have no clips."""
    if isinstance(found, Counts):
        raise UsageError("hits that are only counted", wanted='a pattern without "| count"')
    return found


def _values(hits: Hits, by: Reference) -> Iterator[Value]:
    """Yield a field of each hit, without making objects where it can."""
    if is_of_span(by):
        return (value_of_span(by, capture, span) for capture, span in hits.spans())
    return (value_of(by, hit) for hit in hits)


def _sorted(hits: Hits, by: Reference) -> Hits:
    orders = [order(by, value) for value in _values(hits, by)]
    return hits.arranged(sorted(range(len(orders)), key=orders.__getitem__))


def _counts(hits: Hits, by: Reference | None) -> Counts:
    if by is None:
        return Counts([Counted(None, len(hits))], hits.pattern, None)
    numbers = Counter(_values(hits, by))
    ordered = sorted(numbers, key=lambda value: (-numbers[value], order(by, value)))
    counted = [Counted(_shown(value), numbers[value]) for value in ordered]
    return Counts(counted, hits.pattern, by)


def _shown(value: Value) -> str | float | None:
    if value is None or isinstance(value, str):
        return value
    return int(value) if value.denominator == 1 else round(float(value), 6)
