"""What columns do not tell: captures and tracks, fetched where they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lanindex.model import Capture, Track
from lanindex.search.automaton import Program
from lanindex.search.fast.asking import possible
from lanindex.search.fast.block import Block
from lanindex.search.fast.ragged import Whole

Recordings = Callable[
    [Sequence[int], Collection[str]], Iterable[tuple[Capture, Mapping[str, Track]]]
]
"""Captures with the tracks of some parts, by their places in the roster."""


@dataclass(slots=True)
class Source:
    """What columns do not tell of the captures of a block."""

    recordings: Recordings
    places: Whole
    block: Block
    programs: tuple[Program, ...]

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the block."""
        return [it for it, _ in self.recordings(self.places[list(places)].tolist(), ())]

    def swings(self, part: str) -> Whole:
        """Return how often each row of a part swings, -1 where nothing can match anyway."""
        rows = self.block.rows(part)
        found = np.full(len(rows), -1)
        matching = np.any([possible(self.block, it) for it in self.programs], axis=0)
        places = np.flatnonzero(matching & (np.diff(rows.bounds) > 0))
        recordings = self.recordings(self.places[places].tolist(), (part,))
        for place, (_, tracks) in zip(places.tolist(), recordings, strict=True):
            found[slice(*rows.bounds[place : place + 2])] = tracks[part].symbols["swings"]
        return found
