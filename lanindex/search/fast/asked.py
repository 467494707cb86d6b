"""What the clauses behind a pattern ask of many ways at once: rhythm and conditions.

What a label has matched is noted as far as a condition speaks of it: where it begins and ends, what
its last symbol is, or of which symbols it is, one after the other.
"""

from __future__ import annotations

from math import lcm

import numpy as np

from lanindex.alphabet import MIRRORED, mirrored_part
from lanindex.model.columns import CELL, cell_of, has_amount
from lanindex.search.automaton import State
from lanindex.search.conditions import about, names_in
from lanindex.search.fast.block import Block
from lanindex.search.fast.ragged import FAR, Mask, Whole
from lanindex.search.language.clauses import (
    CLIP,
    MATCH,
    Mirrors,
    references_in,
)
from lanindex.search.language.query import Query

MET = FAR
"""What is noted of a label instead, once all that is asked of it is met: ways may be alike then."""

TIMES = {"start": ("start",), "end": ("end",), "length": ("start", "end")}
_LAST = ("part", "row")
"""What is noted of a label, by the field that is asked for; of any other one the last symbol."""


class Asked:
    """The clauses of a query.

    Parameters
    ----------
    query : Query
        With its rhythm and conditions.

    Attributes
    ----------
    of_capture : tuple of Condition
        Those that a capture meets or does not, whatever matches.
    conditions : tuple of Condition
        The others.
    labels : dict of Condition to frozenset of str
        Of which each of those speaks.
    of_all : frozenset of Condition
        Those that speak of all that matched.
    of_frames : bool
        Whether they speak of the frames of all that matched.
    columns : dict of tuple of str to int
        By label and what is noted of it: where.
    """

    def __init__(self, query: Query) -> None:
        names = {it: names_in([it]) - {CLIP} for it in query.where}
        self.of_capture = tuple(it for it in query.where if not names[it])
        self.conditions = tuple(dict.fromkeys(it for it in query.where if names[it]))
        self.labels = {it: names[it] - {MATCH} for it in self.conditions}
        self.of_all = frozenset(it for it in self.conditions if MATCH in names[it])
        asked = set(references_in(self.conditions))
        self.of_frames = any(it.name == MATCH and it.field in TIMES for it in asked)
        noted = [
            (it.name, what)
            for it in asked
            if it.name not in (CLIP, MATCH)
            for what in TIMES.get(it.field, _LAST)
        ]
        for it in self.conditions:
            if isinstance(it, Mirrors):
                noted += [(it.first, "mirrored"), (it.second, "shown")]
        self.columns = {it: place for place, it in enumerate(sorted(set(noted)))}
        parts = query.parts | {mirrored_part(part) for part in query.parts}
        self._parts = {part: code for code, part in enumerate(sorted(parts))}
        self._sequences: dict[tuple[int, int], int] = {}
        several = lcm(*(share.denominator for share in query.rhythm))
        self.rhythm = [int(share * several) for share in query.rhythm]

    def __bool__(self) -> bool:
        """Return whether ways have to remember anything."""
        return bool(self.conditions or self.rhythm)

    def place(self, label: str) -> int:
        """Return where something is noted of a label."""
        return min(place for (name, _), place in self.columns.items() if name == label)

    def code(self, part: str) -> int:
        """Return the number of a part."""
        return self._parts[part]

    def parts(self) -> list[str]:
        """Return the parts by their numbers."""
        return list(self._parts)

    def noted(self, block: Block, state: State, events: Whole, seen: Whole) -> Whole:
        """Return what is known of labels once some events have matched a state."""
        wanted = [it for it in self.columns if it[0] in state.labels]
        if not wanted:
            return seen
        found, own = seen.copy(), block.events(state).at(events)
        for label, what in wanted:
            column = found[self.columns[label, what]]
            if what == "start":
                column[:] = np.where(column < 0, own.start, np.minimum(column, own.start))
            elif what == "end":
                column[:] = np.maximum(column, own.end)
            elif what == "part":
                column[:] = self._parts[state.members[-1]]
            elif what == "row":
                column[:] = own.last[-1]
            else:
                ends = zip(state.members, own.first, own.last, strict=True)
                for part, first, last in ends:
                    self._follow(block, part, (first, last), column, what == "mirrored")
        return found

    def _follow(
        self, block: Block, part: str, ends: tuple[Whole, Whole], column: Whole, mirrored: bool
    ) -> None:
        """Add symbols, or their mirror images, to those that a label had before."""
        first, last = ends
        rows = block.rows(part)
        named = self._parts[mirrored_part(part) if mirrored else part] << 8
        cells = MIRRORED_CELLS if mirrored else np.arange(CELL + 1)
        for behind in range(int((last - first).max(initial=-1)) + 1):
            row = first + behind
            here = np.flatnonzero(row <= last)
            here = here[~rows.passing[row[here]] | (first == last)[here]]
            codes = named | cells[rows.cell[row[here]] & CELL]
            if has_amount(part):
                codes |= about(part, rows.amount[row[here]].astype(np.int64)) << 20
            pairs, place = np.unique((column[here] + 1) << 32 | codes, return_inverse=True)
            told = [
                self._sequences.setdefault((it >> 32, it & 0xFFFFFFFF), len(self._sequences))
                for it in pairs.tolist()
            ]
            column[here] = np.array(told, np.int64)[place]

    def may_be_in_rhythm(self, beats: Whole) -> Mask:
        """Tell where no two steps' lengths are too far from their shares, (R, N) → (N,)."""
        fits = np.ones(beats.shape[1], bool)
        shares = np.array(self.rhythm, object if max(self.rhythm) >> 28 else np.int64)
        for place, beat in enumerate(beats):
            for other, before in enumerate(beats[:place]):
                one, two = beat * shares[other], before * shares[place]
                near = (3 * one <= 5 * two) & (3 * two <= 5 * one)
                fits &= near.astype(bool, copy=False) | (beat < 0)
        return fits

    def in_rhythm(self, beats: Whole) -> Mask:
        """Tell which steps last in the proportion that is asked for, (R, N) → (N,)."""
        whole = sum(self.rhythm)
        beats = beats.astype(object) if whole >> 28 else beats
        total = beats.sum(axis=0)
        fits: Mask = np.min(beats, axis=0) >= 0
        for share, beat in zip(self.rhythm, beats, strict=True):
            off = 4 * abs(beat * whole - share * total)
            fits &= np.asarray(off <= share * total, bool)
        return fits


MIRRORED_CELLS = np.array(
    [
        cell_of(MIRRORED[direction] if 0 <= direction < len(MIRRORED) else direction, level)
        for level, direction in ((it // 16 - 1, it % 16 - 1) for it in range(CELL + 1))
    ]
)
