"""One part's rows in some captures, with what follows what worked out.

Rows are *shown* if the score shows them, else *passing*; nothing crosses a gap, so rows on both
sides of one are of different *stretches*.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from lanindex.alphabet import is_limb
from lanindex.model.columns import PASSING, STARTING, THOUSANDTHS, Columns, parted, ranges
from lanindex.model.measures import GRADES, graded, measures_of
from lanindex.search.language.words import WORD_KINDS
from lanindex.search.match.arrays import FAR, AnyArray, BoolArray, IntArray


class Rows:
    """The rows of one part in some captures.

    Parameters
    ----------
    columns : Columns
        Of the part, in all captures.
    places : ndarray
        (N,) int64, growing: which captures; here they are counted from 0.
    frames : ndarray
        (N,) int64, how many each of them has.

    Attributes
    ----------
    bounds : ndarray
        (captures + 1,): the rows of each capture.
    cell : ndarray
        (S,) uint8, as in `Columns`.
    capture, start, stop : ndarray
        (S,) int32, as the columns are: rows are many, and of most little is asked.
    passing, starting : ndarray
        (S,) bool.
    stretch : ndarray
        (S,) int32: which stretch of known frames each lies in, counted over all captures.
    stretch_rows : ndarray
        (stretches + 1,): the first row of each.
    stretch_begin, stretch_end : ndarray
        (stretches,): its frames.
    """

    def __init__(self, columns: Columns, places: IntArray, frames: IntArray) -> None:
        self.frames, self._columns = frames, columns
        self._grades: dict[str, AnyArray] = {}
        firsts, behind = columns.bounds[places], columns.bounds[places + 1]
        self._here: AnyArray | slice
        if len(places) and places[-1] - places[0] < len(places):
            self.bounds = np.append(firsts, behind[-1]) - firsts[0]
            self._here = slice(int(firsts[0]), int(behind[-1]))
        else:
            self.bounds, here = ranges(firsts, behind)
            self._here = here.astype(np.int32)
        self.capture = np.repeat(np.arange(len(places), dtype=np.int32), np.diff(self.bounds))
        self.cell = columns.cell[self._here]
        self.start: AnyArray = columns.start[self._here]
        self.stop: AnyArray = columns.stop[self._here]
        self.passing: BoolArray = (self.cell & PASSING) > 0
        self.starting: BoolArray = (self.cell & STARTING) > 0
        begins = self.starting.copy()
        begins[self.bounds[:-1][self.bounds[:-1] < self.bounds[1:]]] = True
        if not is_limb(columns.part) and len(columns.gaps):
            begins |= parted(places[self.capture], self.start, columns.gaps)
        self.stretch = np.cumsum(begins, dtype=np.int32) - 1
        self.stretch_rows = np.append(np.flatnonzero(begins), len(self.cell))
        self._known(columns.gaps, places)

    def __len__(self) -> int:
        """Return how many rows there are."""
        return len(self.cell)

    def _known(self, gaps: AnyArray, places: IntArray) -> None:
        """Work out the frames of each stretch."""
        rows = self.stretch_rows[:-1]
        capture, begin = (it[rows].astype(np.int64) for it in (self.capture, self.start))
        self.stretch_begin, self.stretch_end = np.zeros_like(begin), self.frames[capture].copy()
        if not len(rows):
            return
        gaps = gaps[slice(*np.searchsorted(gaps[:, 0], places[[0, -1]] + (0, 1)))]
        gaps = gaps.astype(np.int64)
        which = np.searchsorted(places, gaps[:, 0])
        gaps[:, 0], own = which, places[which] == gaps[:, 0]
        gaps = gaps[own]
        if not len(gaps):
            return
        gappy = np.isin(capture, gaps[:, 0])
        gaps = gaps[gaps[:, 1] < gaps[:, 2]]  # a part that was never seen has one without frames
        places = np.searchsorted(gaps[:, 0] * FAR + gaps[:, 1], capture * FAR + begin, "right") - 1
        found = np.append(gaps, [[-1, 0, 0]], axis=0)[places]
        inside = gappy & (places >= 0) & (found[:, 0] == capture) & (begin <= found[:, 2])
        self.stretch_begin[gappy] = begin[gappy]
        self.stretch_begin[inside] = found[inside, 1]
        self.stretch_end[inside] = found[inside, 2]

    @cached_property
    def runner(self) -> AnyArray:
        """The cell across the nearest border of each row, (S,) uint8."""
        return self._columns.runner[self._here]

    @cached_property
    def amount(self) -> AnyArray:
        """The amount of each row, (S,) int16; -1: it has none."""
        held = self._columns.amount
        return np.full(len(self), -1, np.int16) if held is None else held[self._here]

    def measure(self, name: str) -> AnyArray:
        """Return a measure of each row, (S,) as columns have it; 0: not known."""
        held: AnyArray | None = getattr(self._columns, name)
        if held is None:
            if len(self) and name in measures_of(self._columns.part):
                raise ValueError(f"the {name} of {self._columns.part} was not read")
            return np.zeros(len(self), np.uint16)
        return held[self._here]

    def grade(self, kind: str) -> AnyArray:
        """Return how each row's speed or size is called, (S,) int8; -1: it is not known."""
        if kind not in self._grades:
            values = self.measure(GRADES[kind])
            self._grades[kind] = graded(self._columns.part, kind, values)
        return self._grades[kind]

    @cached_property
    def cost(self) -> AnyArray:
        """What is missing to a margin of 1, in thousandths, (S,) int16."""
        return THOUSANDTHS - self._columns.margin[self._here].astype(np.int16)

    @cached_property
    def shown(self) -> AnyArray:
        """Which rows are shown, int32."""
        return np.flatnonzero(~self.passing).astype(np.int32)

    @cached_property
    def rank(self) -> AnyArray:
        """How many shown rows come before each, (S + 1,) int32."""
        rank = np.zeros(len(self) + 1, np.int32)
        np.cumsum(~self.passing, out=rank[1:])
        return rank

    @cached_property
    def _joined(self) -> BoolArray:
        """Which shown rows another one of their stretch follows; of the last one it is not told."""
        stretch = self.stretch[self.shown]
        joined: BoolArray = stretch[1:] == stretch[:-1]
        return joined

    def until(self, rows: IntArray) -> IntArray:
        """Return until when each of some shown rows is the last."""
        behind, stretch = self.rank[rows + 1], self.stretch[rows]
        after = self.row_of(behind + 1) - 1
        follows = (behind < len(self.shown)) & (self.stretch[after] == stretch)
        return np.where(follows, self.start[after], self.stretch_end[stretch])

    @cached_property
    def change(self) -> AnyArray:
        """How each row's level compares with the one before it, (S,) int8 codes."""
        codes = WORD_KINDS["change"].codes
        level = ((self.cell >> 4) & 3).astype(np.int8) - 1
        change = np.where(level >= 0, np.int8(codes["neither"]), np.int8(-1))
        before, after = level[self.shown[:-1]], level[self.shown[1:]]
        told = self._joined & (np.minimum(before, after) >= 0) & (before != after)
        said = np.where(before < after, codes["rising"], codes["sinking"]).astype(np.int8)
        change[self.shown[1:][told]] = said[told]
        return change

    @cached_property
    def arrival(self) -> AnyArray:
        """The frame in which each row is achieved, (S,) int32."""
        arrival: AnyArray = np.where(self.starting, self.start, self.stop - 1)
        return arrival

    @cached_property
    def left_at_once(self) -> BoolArray:
        """Which rows are starting positions that alone are no stay, (S,) bool."""
        left, rows = np.zeros(len(self), bool), np.flatnonzero(self.starting)
        left[rows] = self.until(rows) <= self.start[rows]
        return left

    def row_of(self, rank: IntArray) -> IntArray:
        """Return the first row before which at least so many rows are shown."""
        row: IntArray = self._behind[np.clip(rank, 0, len(self._behind) - 1)].astype(np.int64)
        return row

    @cached_property
    def _behind(self) -> AnyArray:
        """The first row, those behind each shown one, and that behind the last, int32."""
        return np.concatenate(([0], self.shown + 1, [len(self)]), dtype=np.int32)

    def beginnings(self, manner: str) -> tuple[IntArray, IntArray]:
        """Return the shown rows that begin something, and when: a movement, stay or rest."""
        rows, frames = self.shown, self.start
        if manner == "at":
            frames = self.arrival
        elif manner == "hold":
            rows, frames = rows[self.stop[rows] < self.until(rows)], self.stop
        else:
            rows = rows[~self.starting[rows]]
        return rows.astype(np.int64), frames[rows].astype(np.int64)

    @cached_property
    def stretch_keys(self) -> IntArray:
        """Capture and first frame of each stretch as one number, growing."""
        capture = self.capture[self.stretch_rows[:-1]].astype(np.int64)
        keys: IntArray = capture * FAR + self.stretch_begin
        return keys

    def stretch_at(self, capture: IntArray, frame: IntArray) -> IntArray:
        """Return the stretch of a capture that a frame lies in, -1: in none."""
        if not len(self.stretch_keys):
            return np.full(len(frame), -1)
        place = np.searchsorted(self.stretch_keys, capture * FAR + frame, "right") - 1
        found = np.searchsorted(self.stretch_keys, self.stretch_keys[np.maximum(place, 0)])
        same = self.capture[self.stretch_rows[found]] == capture
        return np.where((place >= 0) & same & (frame < self.stretch_end[found]), found, -1)
