"""Sequences of symbols that recur: what a library is full of, before one knows what to ask.

A motif is a pattern of one part, `r_arm place low -> right mid -> place high`, each step a whole
cell; its count is the number of hits that a search for it has. So its rules are those of the
language: between its first and its last step a motif may also go through what is only passed, no
arrow crosses a gap, of the ways from one start the one that ends first counts, of those that end
together the nearest, and hits that overlap are taken from left to right.

Motifs grow by one step at a time, all at once, from the rows at which they stand. What occurs too
seldom is not grown: no longer motif that begins with it occurs more often. So time and memory are
those of what is frequent, and `most` bounds them.
"""

from __future__ import annotations

from heapq import heapify, heappop, heappush
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.model.columns import PASSING, Columns, codes_of
from lanindex.search.example.clips import Watch, unwatched

Numbers = NDArray[np.int64]

LONGEST = 12
"""Steps of a motif, at the most."""

MOST = 5_000_000
"""Places at which motifs stand that are grown, at the most, for one part."""

TOLD = 200
"""Motifs that are told in the order of what they alone account for."""

_FLAT = len(DIRECTIONS) * len(LEVELS)
"""The first cell of a part whose symbols have no level."""

_CELLS = _FLAT + len(DIRECTIONS)


class Line(NamedTuple):
    """The symbols of one part in many captures, one capture after the other.

    Attributes
    ----------
    cells : ndarray
        (N,) 3 * direction + level, -1 where a symbol has no such thing.
    starts, stops : ndarray
        (N,) frames, half-open; equal at a starting position.
    passing : ndarray
        (N,) bool, whether it is only passed.
    captures : ndarray
        (N,) whose it is; grows.
    """

    cells: Numbers
    starts: Numbers
    stops: Numbers
    passing: NDArray[np.bool_]
    captures: Numbers


class Motif(NamedTuple):
    """A sequence that recurs.

    Attributes
    ----------
    part : str
        Whose.
    cells : tuple of int
        3 * direction + level, a step each.
    captures, hits : int
        In how many captures it occurs, and how often.
    line : Line
        The symbols of that part.
    rows : ndarray
        (H, 2) int32 of each hit its first and its last row there.
    """

    part: str
    cells: tuple[int, ...]
    captures: int
    hits: int
    line: Line
    rows: NDArray[np.int32]

    @property
    def places(self) -> Numbers:
        """(H, 3) of each hit: capture, first frame, frame after the last."""
        first, last = self.rows.T
        edges = self.line.starts[first], self.line.stops[last]
        return np.stack([self.line.captures[first], *edges], axis=1)

    @property
    def pattern(self) -> str:
        """As one types it into a search."""
        steps = (_said(cell) for cell in self.cells)
        return f"{self.part} {' -> '.join(steps)}"


class Motifs(NamedTuple):
    """What recurs in a part.

    Attributes
    ----------
    found : list of Motif
        Those that no longer one of the same count contains.
    cut : int
        Steps from which on motifs were not grown, there being too many places; 0: all were.
    """

    found: list[Motif]
    cut: int


class _Stand(NamedTuple):
    """Where motifs stand: which, where they began, where they are."""

    motif: Numbers
    first: Numbers
    row: Numbers


def _said(cell: int) -> str:
    if cell >= _FLAT:
        return DIRECTIONS[cell - _FLAT]
    return f"{DIRECTIONS[cell // len(LEVELS)]} {LEVELS[cell % len(LEVELS)]}"


def _cells(direction: NDArray[np.int8], level: NDArray[np.int8]) -> Numbers:
    """Return direction and level as one number; -1 where a symbol lacks what others have."""
    wide = direction.astype(np.int64)
    if (level < 0).all():
        return np.where(wide >= 0, _FLAT + wide, -1)
    return np.where((wide >= 0) & (level >= 0), wide * len(LEVELS) + level, -1)


def line_of(tracks: list[NDArray[Any]], captures: list[int]) -> Line:
    """Return the rows of one part, those of each capture, side by side."""
    rows = np.concatenate(tracks)
    cells = _cells(rows["direction"], rows["level"])
    owners = np.repeat(np.array(captures, np.int64), [len(track) for track in tracks])
    starts, stops = rows["start"].astype(np.int64), rows["stop"].astype(np.int64)
    return Line(cells, starts, stops, rows["passing"].copy(), owners)


def line_in(columns: Columns, captures: NDArray[np.int64]) -> Line:
    """Return the rows of columns side by side; of each capture its number is told, (C,)."""
    cells = _cells(*codes_of(columns.cell))
    owners = np.repeat(captures, np.diff(columns.bounds))
    starts, stops = columns.start.astype(np.int64), columns.stop.astype(np.int64)
    return Line(cells, starts, stops, (columns.cell & PASSING) > 0, owners)


def motifs(
    part: str,
    line: Line,
    *,
    least: int,
    shortest: int,
    longest: int = LONGEST,
    most: int = MOST,
    watch: Watch = unwatched,
) -> Motifs:
    """Return the motifs of a part.

    Parameters
    ----------
    part : str
        Its name.
    line : Line
        Its symbols.
    least : int
        How often a motif occurs at least.
    shortest, longest : int
        How many steps it has.
    most : int
        Places that are grown at the most.
    watch : callable, optional
        Is told how far it is; it may raise.
    """
    follows = _following(line)
    stand = _begun(line)
    names: list[tuple[int, ...]] = [(cell,) for cell in range(_CELLS)]
    counted: dict[tuple[int, ...], Motif] = {}
    cut = 0
    for steps in range(2, longest + 2):
        watch("steps", steps - 2, longest)
        stand, names = _grown(line, follows, _frequent(stand, least), names)
        if len(stand.row) > most:
            cut = steps
            break
        if not len(stand.row):
            break
        for motif in _counted(part, line, stand, names, least):
            counted[motif.cells] = motif
    closed = [motif for motif in _closed(counted) if shortest <= len(motif.cells) <= longest]
    return Motifs(closed, cut)


def _begun(line: Line) -> _Stand:
    """Return where motifs of one step stand: at all that a score shows."""
    rows = np.flatnonzero(~line.passing & (line.cells >= 0))
    return _Stand(line.cells[rows], rows, rows)


def _following(line: Line) -> Numbers:
    """Return by row to how many rows an arrow may lead, which lie right behind it.

    They are those that are passed on the way, and the next one that a score shows; none where a
    capture ends, or the part is unknown for a while.
    """
    count = len(line.cells)
    shown = np.where(line.passing, count, np.arange(count))
    ahead = np.minimum.accumulate(np.append(shown, count)[::-1])[::-1][1:]
    same = np.append(line.captures, -1)[ahead] == line.captures
    begins = np.append(line.starts == line.stops, True)[ahead]
    return np.where(same & ~begins, ahead - np.arange(count), 0)


def _frequent(stand: _Stand, least: int) -> _Stand:
    """Return only those that have begun often enough."""
    # A motif that stands at several rows from one beginning has begun once.
    far = int(stand.first.max(initial=0)) + 1
    pairs = np.sort(stand.motif * far + stand.first)
    begun = np.bincount(pairs[np.diff(pairs, prepend=-1) != 0] // far)
    kept = begun[stand.motif] >= least
    return _Stand(stand.motif[kept], stand.first[kept], stand.row[kept])


def _grown(
    line: Line,
    counts: Numbers,
    stand: _Stand,
    names: list[tuple[int, ...]],
) -> tuple[_Stand, list[tuple[int, ...]]]:
    """Return motifs with one more step, and their names."""
    here = counts[stand.row]
    index = np.repeat(np.arange(len(here)), here)
    offset = np.arange(len(index)) - np.repeat(np.cumsum(here) - here, here)
    rows = stand.row[index] + 1 + offset
    kept = line.cells[rows] >= 0
    index, rows = index[kept], rows[kept]
    keys, motif = np.unique(stand.motif[index] * _CELLS + line.cells[rows], return_inverse=True)
    longer = [(*names[key // _CELLS], int(key % _CELLS)) for key in keys.tolist()]
    return _Stand(motif, stand.first[index], rows), longer


def _counted(
    part: str, line: Line, stand: _Stand, names: list[tuple[int, ...]], least: int
) -> list[Motif]:
    """Return the motifs that end here often enough, with their hits."""
    ends = ~line.passing[stand.row]
    motif, first, row = stand.motif[ends], stand.first[ends], stand.row[ends]
    order = np.lexsort((row, first, motif))
    motif, first, row = motif[order], first[order], row[order]
    # From one beginning the way that ends first counts.
    fresh = np.ones(len(motif), bool)
    fresh[1:] = (np.diff(motif) != 0) | (np.diff(first) != 0)
    motif, first, row = motif[fresh], first[fresh], row[fresh]
    kept = _apart(motif, line.captures[first], line.starts[first], line.stops[row])
    motif, rows = motif[kept], np.stack([first[kept], row[kept]], axis=1).astype(np.int32)
    owners = line.captures[rows[:, 0]]
    ends = np.cumsum(np.bincount(motif, minlength=len(names)))
    other = np.cumsum((np.diff(motif, prepend=-1) != 0) | (np.diff(owners, prepend=-1) != 0))
    found = []
    for one in np.flatnonzero(np.diff(ends, prepend=0) >= least).tolist():
        low, high = int(ends[one - 1]) if one else 0, int(ends[one])
        captures = int(other[high - 1] - other[low]) + 1
        found.append(Motif(part, names[one], captures, high - low, line, rows[low:high]))
    return found


def _apart(motif: Numbers, owner: Numbers, start: Numbers, stop: Numbers) -> Numbers:
    """Return which hits stay; they come in the order of motif, capture and start.

    Of those of a motif that end together it is the one that begins last; of the others, from left
    to right, those that begin when the one before is over.
    """
    told = np.flatnonzero(_last(motif, owner, stop))
    changes = (np.diff(motif[told], prepend=-1) != 0) | (np.diff(owner[told], prepend=-1) != 0)
    line, far = np.cumsum(changes), int(stop.max(initial=0)) + 1
    begins, ends = line * far + start[told], line * far + stop[told]
    behind = np.searchsorted(begins, ends)  # the next that begins when this one is over
    kept, here = np.zeros(len(told), bool), np.flatnonzero(changes)
    while len(here):  # a hit of each capture that has any left
        kept[here] = True
        ahead = behind[here]
        same = np.append(line, -1)[ahead] == line[here]
        here = ahead[same]
    return told[kept]


def _last(motif: Numbers, owner: Numbers, stop: Numbers) -> NDArray[np.bool_]:
    """Return of the hits of a motif that end together the one that stands last."""
    order = np.lexsort((stop, owner, motif))  # what is the same stays in order
    alike = np.ones(len(order[1:]), bool)
    for column in (motif, owner, stop):
        alike &= np.diff(column[order]) == 0
    last = np.ones(len(order), bool)
    last[order[:-1]] = ~alike
    return last


def _closed(counted: dict[tuple[int, ...], Motif]) -> list[Motif]:
    """Return the motifs that no motif with one more step and as many hits contains."""
    within: set[tuple[int, ...]] = set()
    for cells, motif in counted.items():
        for shorter in (cells[1:], cells[:-1]):
            if shorter in counted and counted[shorter].hits == motif.hits:
                within.add(shorter)
    return [motif for cells, motif in counted.items() if cells not in within]


def told_first(found: list[Motif], most: int = TOLD) -> list[Motif]:
    """Return motifs in the order in which one wants to hear of them.

    First the one that accounts for most symbols, then the one that accounts for most of the
    others, and so on; where nothing is left, or `most` are told, by symbols alone.
    """
    covered: dict[str, NDArray[np.bool_]] = {}
    for motif in found:
        reach = int(motif.rows.max()) + 1
        if len(covered.get(motif.part, ())) < reach:
            covered[motif.part] = np.zeros(reach, bool)
    queue = [
        (-motif.hits * len(motif.cells), motif.part, motif.cells, index)
        for index, motif in enumerate(found)
    ]
    order = [index for *_, index in sorted(queue)]
    heapify(queue)
    first: list[int] = []
    while queue and len(first) < most:
        _, part, cells, index = heappop(queue)
        rows = _between(found[index].rows)
        fresh = int((~covered[part][rows]).sum())  # no more than it was when it was asked before
        if queue and -fresh > queue[0][0]:
            if fresh:
                heappush(queue, (-fresh, part, cells, index))
            continue
        covered[part][rows] = True
        first.append(index)
    told = set(first)
    return [found[index] for index in [*first, *(one for one in order if one not in told)]]


def _between(rows: NDArray[np.int32]) -> Numbers:
    """Return all rows from the firsts to the lasts."""
    counts = rows[:, 1] - rows[:, 0] + 1
    offsets = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.asarray(np.repeat(rows[:, 0], counts) + offsets)
