"""A library in groups: captures that are like each other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from lanindex.alphabet import kind_of
from lanindex.errors import UsageError
from lanindex.library.store import Store
from lanindex.model import Capture
from lanindex.pipeline.deadline import Deadline
from lanindex.pipeline.example import sampled, source_of
from lanindex.search.example.groups import Grouped, grouped

ALIKE = 0.4
"""The mean likeness down to which groups are joined where nothing else is said."""

SAMPLE = 2000
"""Captures that the command compares: of more, so many taken at random."""


@dataclass(frozen=True, slots=True)
class Similar:
    """Captures that are like each other."""

    captures: tuple[Capture, ...]
    likeness: float


@dataclass(frozen=True, slots=True)
class Groups:
    """A library in groups."""

    groups: list[Similar]
    captures: int
    of: int
    pairs: int
    every: bool


def similar(
    store: Store,
    chosen: Iterable[int] | None,
    *,
    least: float = ALIKE,
    wanted: int | None = None,
    sample: int | None = None,
    deadline: Deadline | None = None,
) -> Groups:
    """Return the captures of a library in groups."""
    if not 0 < least <= 1:
        raise UsageError(f"{least}", place="--alike", wanted="more than 0, 1 at the most")
    if wanted is not None and wanted < 1:
        raise UsageError(f"{wanted}", place="--groups", wanted="1 or more")
    limbs = [part for part in store.parts(checked=False) if kind_of(part) == "gesture"]
    roster, source = source_of(store, chosen, limbs)
    found, numbers = Grouped([], 0, True), roster.number
    if len(roster) and limbs:
        watch, places = deadline or Deadline(), sampled(len(roster), sample)
        clips, numbers = source.taken(places, watch), numbers[places]
        found = grouped(clips, least=least, wanted=wanted, watch=watch)
    captures = store.captures_numbered(numbers.tolist())
    groups = [
        Similar(tuple(captures[one] for one in group.members), group.likeness)
        for group in found.groups
    ]
    return Groups(groups, len(captures), len(roster), found.pairs, found.every)
