"""One part's rows in some captures, with what follows what worked out.

As on the language's page: rows are *shown* if the score shows them, else *passing*; nothing
crosses a gap, so rows on both sides of one are of different *stretches*.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from lanindex.model.columns import PASSING, STARTING, THOUSANDTHS, Columns
from lanindex.search.fast.ragged import FAR, Mask, Numbers, Whole, starts_of
from lanindex.search.language.words import WORD_KINDS


class Rows:
    """The rows of one part in the captures from `first` up to, not including, `last`.

    Parameters
    ----------
    columns : Columns
        Of the part, in all captures.
    first, last : int
        Which captures; here they are counted from 0.
    frames : ndarray
        (last - first,) int64, how many each of them has.

    Attributes
    ----------
    bounds : ndarray
        (captures + 1,): the rows of each capture.
    cell, runner : ndarray
        (S,) uint8, as in `Columns`.
    capture, start, stop : ndarray
        (S,) int64.
    cost : ndarray
        (S,) int64: what is missing to a margin of 1, in thousandths.
    passing, starting : ndarray
        (S,) bool.
    rank : ndarray
        (S + 1,): how many shown rows come before.
    shown : ndarray
        Which rows are shown.
    stretch : ndarray
        (S,): which stretch of known frames each row lies in, counted over all captures.
    stretch_rows : ndarray
        (stretches + 1,): the first row of each.
    stretch_begin, stretch_end : ndarray
        (stretches,): its frames.
    until : ndarray
        (S,): until when a shown row is the last.
    """

    def __init__(self, columns: Columns, first: int, last: int, frames: Whole) -> None:
        self.frames = frames
        here = slice(int(columns.bounds[first]), int(columns.bounds[last]))
        self.bounds = columns.bounds[first : last + 1] - columns.bounds[first]
        counts = np.diff(self.bounds)
        self.capture = np.repeat(np.arange(last - first), counts)
        self.cell, self.runner = columns.cell[here], columns.runner[here]
        self.start = columns.start[here].astype(np.int64)
        self.stop = columns.stop[here].astype(np.int64)
        self.cost = THOUSANDTHS - columns.margin[here].astype(np.int64)
        self.passing: Mask = (self.cell & PASSING) > 0
        self.starting: Mask = (self.cell & STARTING) > 0
        self.shown = np.flatnonzero(~self.passing)
        self.rank = np.concatenate(([0], np.cumsum(~self.passing)))
        begins = self.starting | starts_of(self.capture)
        self.stretch = np.cumsum(begins) - 1
        self.stretch_rows = np.append(np.flatnonzero(begins), len(self.cell))
        self._known(columns.gaps, first, last)
        self._follow()

    def __len__(self) -> int:
        """Return how many rows there are."""
        return len(self.cell)

    def _known(self, gaps: Numbers, first: int, last: int) -> None:
        """Work out the frames of each stretch."""
        rows = self.stretch_rows[:-1]
        capture, begin = self.capture[rows], self.start[rows]
        self.stretch_begin, self.stretch_end = np.zeros_like(begin), self.frames[capture].copy()
        gaps = gaps[(gaps[:, 0] >= first) & (gaps[:, 0] < last)].astype(np.int64)
        if not len(gaps):
            return
        gaps[:, 0] -= first
        gappy = np.isin(capture, gaps[:, 0])
        gaps = gaps[gaps[:, 1] < gaps[:, 2]]  # a part that was never seen has one without frames
        places = np.searchsorted(gaps[:, 0] * FAR + gaps[:, 1], capture * FAR + begin, "right") - 1
        found = np.append(gaps, [[-1, 0, 0]], axis=0)[places]
        inside = gappy & (places >= 0) & (found[:, 0] == capture) & (begin <= found[:, 2])
        self.stretch_begin[gappy] = begin[gappy]
        self.stretch_begin[inside] = found[inside, 1]
        self.stretch_end[inside] = found[inside, 2]

    def _follow(self) -> None:
        shown, stretch = self.shown, self.stretch[self.shown]
        self._joined = stretch[1:] == stretch[:-1]
        until = self.stretch_end[stretch]
        until[:-1][self._joined] = self.start[shown[1:]][self._joined]
        self.until = np.zeros(len(self), np.int64)
        self.until[shown] = until

    @cached_property
    def change(self) -> Numbers:
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
    def arrival(self) -> Whole:
        """The frame in which each row is achieved, (S,)."""
        arrival: Whole = np.where(self.starting, self.start, self.stop - 1)
        return arrival

    @cached_property
    def left_at_once(self) -> Mask:
        """Which rows are starting positions that alone are no stay, (S,) bool."""
        return self.starting & (self.until <= self.start)

    def row_of(self, rank: Whole) -> Whole:
        """Return the first row before which at least so many rows are shown."""
        behind = np.append(self.shown + 1, len(self))
        found = behind[np.clip(rank - 1, 0, len(behind) - 1)]
        row: Whole = np.where(rank > 0, found, 0)
        return row

    def beginnings(self, manner: str) -> tuple[Whole, Whole]:
        """Return the shown rows that begin something, and when: a movement, stay or rest."""
        rows = self.shown
        if manner == "at":
            return rows, self.arrival[rows]
        if manner == "hold":
            rows = rows[self.stop[rows] < self.until[rows]]
            return rows, self.stop[rows]
        rows = rows[~self.starting[rows]]
        return rows, self.start[rows]

    @cached_property
    def stretch_keys(self) -> Whole:
        """Capture and first frame of each stretch as one number, growing."""
        keys: Whole = self.capture[self.stretch_rows[:-1]] * FAR + self.stretch_begin
        return keys

    def stretch_at(self, capture: Whole, frame: Whole) -> Whole:
        """Return the stretch of a capture that a frame lies in, -1: in none."""
        if not len(self.stretch_keys):
            return np.full(len(frame), -1)
        place = np.searchsorted(self.stretch_keys, capture * FAR + frame, "right") - 1
        found = np.searchsorted(self.stretch_keys, self.stretch_keys[np.maximum(place, 0)])
        same = self.capture[self.stretch_rows[found]] == capture
        return np.where((place >= 0) & same & (frame < self.stretch_end[found]), found, -1)
