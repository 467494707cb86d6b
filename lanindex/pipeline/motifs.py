"""What recurs in a library: sequences of symbols, ready to be searched for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import repeat
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import UsageError
from lanindex.library.connect import Progress
from lanindex.library.store import Store
from lanindex.model import Capture, Span
from lanindex.pipeline.example import sampled
from lanindex.search.example.motifs import LONGEST, Motif, PartSymbols, line_of, motifs, ranked
from lanindex.search.example.motifs import Motifs as PartMotifs

if TYPE_CHECKING:
    from lanindex.pipeline.spread import Spread

SAMPLE = 5000
"""Captures that the command looks through: of more, so many taken at random."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a motif occurs."""

    capture: Capture
    span: Span


@dataclass(frozen=True, slots=True)
class Recurring:
    """A sequence that recurs."""

    pattern: str
    part: str
    steps: int
    captures: int
    hits: int
    _motif: Motif = field(repr=False)
    _by_number: Mapping[int, Capture] = field(repr=False)

    @property
    def first(self) -> Place:
        """Where it occurs first."""
        return self._at(self._motif.rows[:1])[0]

    @property
    def places(self) -> list[Place]:
        """Where it occurs; made anew each time, for of all motifs they are many."""
        return self._at(self._motif.rows)

    def _at(self, rows: NDArray[np.int32]) -> list[Place]:
        places = self._motif._replace(rows=rows).places.tolist()
        return [Place(self._by_number[number], Span(*span)) for number, *span in places]


@dataclass(frozen=True, slots=True)
class Motifs:
    """What recurs in a library."""

    found: list[Recurring]
    captures: int
    of: int
    notes: list[str]


def _of_part(item: tuple[str, PartSymbols, int, int], tick: Callable[[], None]) -> PartMotifs:
    """Return what recurs in one part: here, or in another process."""
    part, line, least, shortest = item
    return motifs(part, line, least=least, shortest=shortest, tick=tick)


def recurring(
    store: Store,
    numbers: Iterable[int] | None,
    parts: Iterable[str] | None,
    least: int,
    shortest: int,
    sample: int | None,
    watch: Progress,
    spread: Spread | None = None,
) -> Motifs:
    """Return the sequences that recur in the captures of a library."""
    names = list(parts or store.parts(checked=False))
    store.check_parts(names)
    if least < 2:
        raise UsageError(f"{least}", place="--min-count", wanted="2 or more")
    if not 2 <= shortest <= LONGEST:
        raise UsageError(f"{shortest}", place="--length", wanted=f"2 to {LONGEST}")
    every = store.columns([], numbers)[0].number
    roster, columns = store.columns(names, sampled(every, sample).tolist(), kept=False)
    found: list[Motif] = []
    notes: list[str] = []
    names = [part for part in names if len(columns[part])]
    lines = (line_of(columns.pop(part), roster.number) for part in names)
    items = zip(names, lines, repeat(least), repeat(shortest), strict=False)
    done = 0

    def tick() -> None:
        watch("parts", done, len(names))

    tick()
    by_part = (
        spread.results(_of_part, items, tick) if spread else map(_of_part, items, repeat(tick))
    )
    for part, of_part in zip(names, by_part, strict=True):
        if of_part.cut:
            notes.append(f"{part}: too many places for motifs of {of_part.cut} steps and more")
        found += of_part.found
        done += 1
        tick()
    held: set[int] = set()
    for motif in found:
        held.update(np.unique(motif.line.captures[motif.rows[:, 0]]).tolist())
    captures = {capture.id: capture for capture in store.captures_numbered(sorted(held))}
    listed = [
        Recurring(one.pattern, one.part, len(one.cells), one.captures, one.hits, one, captures)
        for one in ranked(found)
    ]
    return Motifs(listed, len(roster), len(every), notes)
