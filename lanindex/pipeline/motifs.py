"""What recurs in a library: sequences of symbols, ready to be searched for."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import UsageError
from lanindex.library.connect import Progress
from lanindex.library.store import Store
from lanindex.model import Capture, Span
from lanindex.pipeline.example import sampled
from lanindex.search.example.motifs import LONGEST, Motif, line_of, motifs, ranked

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


def recurring(
    store: Store,
    numbers: Iterable[int] | None,
    parts: Iterable[str] | None,
    least: int,
    shortest: int,
    sample: int | None,
    watch: Progress,
) -> Motifs:
    """Return the sequences that recur in the captures of a library."""
    names = list(parts or store.parts(checked=False))
    store.check_parts(names)
    if least < 2:
        raise UsageError(f"{least}", place="--min-count", wanted="2 or more")
    if not 2 <= shortest <= LONGEST:
        raise UsageError(f"{shortest}", place="--length", wanted=f"2 to {LONGEST}")
    roster, columns = store.columns(names, numbers)
    places = sampled(len(roster), sample)
    found: list[Motif] = []
    notes: list[str] = []
    for done, part in enumerate(names):
        tick = partial(watch, "parts", done, len(names))
        tick()
        symbols = columns.pop(part)
        if not len(symbols):
            continue
        line = line_of(symbols.at(places), roster.number[places])
        of_part = motifs(part, line, least=least, shortest=shortest, tick=tick)
        if of_part.cut:
            notes.append(f"{part}: too many places for motifs of {of_part.cut} steps and more")
        found += of_part.found
    held: set[int] = set()
    for motif in found:
        held.update(np.unique(motif.line.captures[motif.rows[:, 0]]).tolist())
    captures = {capture.id: capture for capture in store.captures_numbered(sorted(held))}
    listed = [
        Recurring(one.pattern, one.part, len(one.cells), one.captures, one.hits, one, captures)
        for one in ranked(found)
    ]
    return Motifs(listed, len(places), len(roster), notes)
