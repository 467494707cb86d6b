"""Motifs, sequences of symbols that recur: what a library is full of, before one knows what to ask.

The count of a motif is the number of hits that a search for it has, so its rules are those of the
language.
"""

from __future__ import annotations

from collections.abc import Callable
from heapq import heapify, heappop, heappush
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.model.columns import PASSING, Columns, codes_of, ranges
from lanindex.search.example.likeness import Numbers
from lanindex.search.match.arrays import starts_of
from lanindex.search.match.hits import from_left, nearest

LONGEST = 12  # steps of a motif at most
MOST = 5_000_000  # occurrences of motifs that are extended at most, for one part
RANKED = 200  # motifs that are ranked by what they alone account for

_CELLS = [*(f"{it} {level}" for it in DIRECTIONS for level in LEVELS), *DIRECTIONS]
"""Cells as they are written; the last ones are those of a part whose symbols have no level."""

_FLAT = len(DIRECTIONS) * len(LEVELS)  # the first of these

_Name = tuple[int, ...]  # the cells of a motif


class PartSymbols(NamedTuple):
    """The N symbols of one part in many captures, one capture after the other."""

    cells: Numbers  # (N,) places in `_CELLS`, -1 where a symbol has none
    starts: Numbers  # (N,) frames, half-open; equal at a starting position
    stops: Numbers
    passing: NDArray[np.bool_]
    captures: Numbers  # (N,) numbers, growing


def line_of(columns: Columns, captures: Numbers) -> PartSymbols:
    """Return the rows of columns as a line; `captures` is (C,) the number of each capture."""
    direction, level = (codes.astype(np.int64) for codes in codes_of(columns.cell))
    if (level < 0).all():
        cells = np.where(direction >= 0, _FLAT + direction, -1)
    else:
        known = (direction >= 0) & (level >= 0)
        cells = np.where(known, direction * len(LEVELS) + level, -1)
    owners = np.repeat(captures, np.diff(columns.bounds))
    starts, stops = columns.start.astype(np.int64), columns.stop.astype(np.int64)
    return PartSymbols(cells, starts, stops, (columns.cell & PASSING) > 0, owners)


class Motif(NamedTuple):
    """A sequence that recurs: a cell for each step, in how many captures, how often, and where."""

    part: str
    cells: _Name
    captures: int
    hits: int
    line: PartSymbols
    rows: NDArray[np.int32]  # (H, 2) of each hit its first and its last row in the line

    @property
    def places(self) -> Numbers:
        """(H, 3) of each hit: capture, first frame, frame after the last."""
        first, last = self.rows.T
        edges = self.line.starts[first], self.line.stops[last]
        return np.stack([self.line.captures[first], *edges], axis=1)

    @property
    def pattern(self) -> str:
        """As one types it into a search."""
        return f"{self.part} {' -> '.join(_CELLS[cell] for cell in self.cells)}"


class Motifs(NamedTuple):
    """What recurs in a part: motifs that no longer one of the same count contains."""

    found: list[Motif]
    cut: int  # steps from which on too many occurrences were not extended; 0: all were


class _Occurrences(NamedTuple):
    """Where motifs occur: which, the row of its first step, and of its last; (K,) each."""

    motif: Numbers
    first: Numbers
    last: Numbers

    def at(self, rows: NDArray[np.bool_] | Numbers) -> _Occurrences:
        return _Occurrences(self.motif[rows], self.first[rows], self.last[rows])


def motifs(
    part: str,
    line: PartSymbols,
    *,
    least: int,
    shortest: int,
    longest: int = LONGEST,
    most: int = MOST,
    tick: Callable[[], None] = lambda: None,
) -> Motifs:
    """Return what recurs at least `least` times in a part; `most` occurrences are extended."""
    follows = _following(line)
    shown = np.flatnonzero(~line.passing & (line.cells >= 0))
    occurrences = _Occurrences(line.cells[shown], shown, shown)
    names: list[_Name] = [(cell,) for cell in range(len(_CELLS))]
    frequent: dict[_Name, Motif] = {}
    cut = 0
    for steps in range(2, longest + 2):
        tick()
        occurrences, names = _extended(line, follows, _frequent(occurrences, least), names)
        if len(occurrences.last) > most:
            cut = steps
            break
        if not len(occurrences.last):
            break
        for motif in _motifs_ending(part, line, occurrences, names, least):
            frequent[motif.cells] = motif
    closed = [motif for motif in _maximal(frequent) if shortest <= len(motif.cells) <= longest]
    return Motifs(closed, cut)


def _following(line: PartSymbols) -> Numbers:
    """Return to how many rows right behind each row an arrow may lead, (N,).

    They are the passing ones and the next that is shown; none at the end of a capture or at a gap.
    """
    count = len(line.cells)
    shown = np.where(line.passing, count, np.arange(count))
    ahead = np.minimum.accumulate(np.append(shown, count)[::-1])[::-1][1:]
    same = np.append(line.captures, -1)[ahead] == line.captures
    begins = np.append(line.starts == line.stops, True)[ahead]
    return np.where(same & ~begins, ahead - np.arange(count), 0)


def _frequent(occurrences: _Occurrences, least: int) -> _Occurrences:
    """Return only those of motifs with enough beginnings, however often each goes on."""
    far = int(occurrences.first.max(initial=0)) + 1
    begun = np.sort(occurrences.motif * far + occurrences.first)
    counts = np.bincount(begun[starts_of(begun)] // far)
    return occurrences.at(counts[occurrences.motif] >= least)


def _extended(
    line: PartSymbols, follows: Numbers, occurrences: _Occurrences, names: list[_Name]
) -> tuple[_Occurrences, list[_Name]]:
    """Return motifs with one more step, and their names."""
    counts = follows[occurrences.last]
    _, last = ranges(occurrences.last + 1, occurrences.last + 1 + counts)
    motif, first = np.repeat(occurrences.motif, counts), np.repeat(occurrences.first, counts)
    longer = _Occurrences(motif, first, last).at(line.cells[last] >= 0)
    pairs = longer.motif * len(_CELLS) + line.cells[longer.last]
    keys, motif = np.unique(pairs, return_inverse=True)
    named = [
        (*names[name], cell) for name, cell in (divmod(it, len(_CELLS)) for it in keys.tolist())
    ]
    return longer._replace(motif=motif), named


def _motifs_ending(
    part: str, line: PartSymbols, occurrences: _Occurrences, names: list[_Name], least: int
) -> list[Motif]:
    """Return the motifs that end here often enough, with their hits."""
    ends = occurrences.at(~line.passing[occurrences.last])
    ends = ends.at(np.lexsort((ends.last, ends.first, ends.motif)))
    ends = ends.at(starts_of(ends.motif, ends.first))  # of each beginning the first end
    owner: Numbers = np.cumsum(starts_of(ends.motif, line.captures[ends.first]))
    kept = np.flatnonzero(nearest(owner, ends.first, line.stops[ends.last]))
    frames = line.starts[ends.first[kept]], line.stops[ends.last[kept]]
    kept = kept[from_left(owner[kept], *frames)]
    ends, owner = ends.at(kept), owner[kept]
    rows = np.stack([ends.first, ends.last], axis=1).astype(np.int32)
    edges = np.append(0, np.cumsum(np.bincount(ends.motif, minlength=len(names))))
    other = np.cumsum(starts_of(owner))
    frequent = []
    for one in np.flatnonzero(np.diff(edges) >= least).tolist():
        low, high = edges[one : one + 2].tolist()
        captures = int(other[high - 1] - other[low]) + 1
        frequent.append(Motif(part, names[one], captures, high - low, line, rows[low:high]))
    return frequent


def _maximal(motifs_by_name: dict[_Name, Motif]) -> list[Motif]:
    """Return the motifs that no motif with one more step and as many hits contains."""
    within = {
        shorter
        for cells, motif in motifs_by_name.items()
        for shorter in (cells[1:], cells[:-1])
        if shorter in motifs_by_name and motifs_by_name[shorter].hits == motif.hits
    }
    return [motif for cells, motif in motifs_by_name.items() if cells not in within]


def ranked(candidates: list[Motif], most: int = RANKED) -> list[Motif]:
    """Return motifs in order: each accounts for most symbols that those before it leave.

    Where nothing is left, or `most` are ranked, they are ordered by their symbols alone.
    """
    queue = [
        (-motif.hits * len(motif.cells), motif.part, motif.cells, index)
        for index, motif in enumerate(candidates)
    ]
    order = [index for *_, index in sorted(queue)]
    heapify(queue)
    covered = {motif.part: np.zeros(len(motif.line.cells), bool) for motif in candidates}
    first: list[int] = []
    while queue and len(first) < most:
        _, part, cells, index = heappop(queue)
        low, high = candidates[index].rows.astype(np.int64).T
        _, rows = ranges(low, high + 1)
        fresh = int((~covered[part][rows]).sum())  # no more than it was when it was asked before
        if queue and -fresh > queue[0][0]:
            if fresh:
                heappush(queue, (-fresh, part, cells, index))
            continue
        covered[part][rows] = True
        first.append(index)
    return [candidates[index] for index in dict.fromkeys([*first, *order])]
