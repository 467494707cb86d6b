"""What may match a state of a program, anywhere in a batch of captures, as columns.

A movement spans its row and is achieved in its last frame; a stay (``at``) lasts from there until
the part leaves; a rest (``hold``) from the row's end to the next one's start. Of two parts at once
each pair that shares a frame is one event.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lanindex.alphabet import MOST_AMOUNT
from lanindex.model.arrays import frozen
from lanindex.model.columns import CELL, THOUSANDTHS
from lanindex.model.measures import GRADES
from lanindex.search import nearly
from lanindex.search.automaton import State
from lanindex.search.language.words import AMOUNTS
from lanindex.search.match.arrays import FAR, AnyArray, BoolArray, IntArray, spread
from lanindex.search.match.rows import Rows


@dataclass(slots=True, eq=False)
class Events:
    """Movements, stays or rests, in order of their rows.

    Attributes
    ----------
    capture : ndarray
        (N,) int64.
    first, last : tuple of ndarray
        (N,) each, one a member: their rows; only a stay has several.
    start, end, until : ndarray
        (N,) frames, half-open, and the end for sharing frames.
    cost : ndarray
        (N,) what is missing to a fit of 1, in thousandths.
    passing, starting : ndarray
        (N,) bool: whether one of them is on the way only, or a starting position.
    """

    capture: IntArray
    first: tuple[IntArray, ...]
    last: tuple[IntArray, ...]
    start: IntArray
    end: IntArray
    until: IntArray
    cost: IntArray
    passing: BoolArray
    starting: BoolArray

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.capture)

    def at(self, chosen: AnyArray) -> Events:
        """Return some of them."""
        return Events(
            self.capture[chosen],
            tuple(rows[chosen] for rows in self.first),
            tuple(rows[chosen] for rows in self.last),
            *(getattr(self, name)[chosen] for name in _FRAMES),
        )


_FRAMES = ("start", "end", "until", "cost", "passing", "starting")


def cells_of(state: State, member: int) -> BoolArray:
    """Return which cells a state asks for, (256,) bool, whatever their flags."""
    return _cells(frozenset(state.fits[member].items()))


@lru_cache(256)
def _cells(fits: frozenset[tuple[str, frozenset[int]]]) -> BoolArray:
    cells = np.arange(256)
    table = np.ones(256, bool)
    said = {"direction": (cells & 15) - 1, "level": ((cells & CELL) >> 4) - 1}
    for kind, codes in fits:
        if kind in said:
            table &= np.isin(said[kind], sorted(codes))
    return frozen(table)


def fitting(rows: Rows, state: State, member: int) -> tuple[BoolArray, IntArray]:
    """Return which rows are what a state says of a member, and what is missing to a fit of 1.

    One may also be so by the cell across its nearest border, if that is near enough.
    """
    table = cells_of(state, member)
    fits, cost = table[rows.cell], rows.cost
    if state.near:
        margin = THOUSANDTHS - cost.astype(np.int64)
        across = ~fits & table[rows.runner] & (margin < state.near)
        cost = np.where(across, nearly.across(margin, state.near), nearly.own(margin, state.near))
        fits |= across
    if "change" in state.fits[member]:
        fits &= np.isin(rows.change, sorted(state.fits[member]["change"]))
    for kind in AMOUNTS:
        if kind in state.fits[member]:
            fits &= _amounts(state.fits[member][kind])[rows.amount]
    for kind in GRADES:
        if kind in state.fits[member]:
            fits &= np.isin(rows.grade(kind), sorted(state.fits[member][kind]))
    return fits, cost


@lru_cache(64)
def _amounts(codes: frozenset[int]) -> BoolArray:
    """Return which amounts are among some codes; the last one is that of what has none."""
    table = np.zeros(MOST_AMOUNT + 2, bool)
    table[list(codes)] = True
    return frozen(table)


def events_of(rows: Rows, state: State, member: int) -> Events:
    """Return what a member of a state may match."""
    fits, cost = fitting(rows, state, member)
    if state.manner == "at":
        return _stays(rows, fits, cost)
    if state.manner == "hold":
        return _rests(rows, fits, cost)
    return _movements(rows, fits if state.names_passing else fits & ~rows.passing, cost)


def _movements(rows: Rows, fits: BoolArray, cost: IntArray) -> Events:
    row = np.flatnonzero(fits)
    start, end = rows.start[row].astype(np.int64), rows.stop[row].astype(np.int64)
    starting = rows.starting[row]
    until, waiting = end.copy(), np.flatnonzero(starting)
    until[waiting] = np.maximum(rows.until(row[waiting]), start[waiting] + 1)
    capture, cost = rows.capture[row].astype(np.int64), cost[row].astype(np.int64)
    return Events(capture, (row,), (row,), start, end, until, cost, rows.passing[row], starting)


def _stays(rows: Rows, fits: BoolArray, cost: IntArray) -> Events:
    first, last, start, end, cost = staying(rows, fits, cost)
    nothing = np.zeros(len(first), bool)
    capture = rows.capture[first].astype(np.int64)
    return Events(capture, (first,), (last,), start, end, end, cost, nothing, nothing)


def staying(rows: Rows, fits: BoolArray, costs: IntArray) -> IntArray:
    """Return first and last row, start, end and cost of the stays where rows fit, (5, N)."""
    shown = np.flatnonzero(fits[rows.shown])  # places among the shown rows
    row = rows.shown[shown]
    if not len(row):
        return np.empty((5, 0), np.int64)
    begins = np.ones(len(row), bool)
    begins[1:] = (np.diff(shown) > 1) | (np.diff(rows.stretch[row]) > 0)
    places = np.flatnonzero(begins)
    first, last = row[places], row[np.append(places[1:], len(row)) - 1]
    cost = np.maximum.reduceat(costs[row], places)
    found = np.stack((first, last, rows.arrival[first], rows.until(last), cost))
    return found[:, found[2] < found[3]]


def _rests(rows: Rows, fits: BoolArray, cost: IntArray) -> Events:
    row = rows.shown[fits[rows.shown]].astype(np.int64)
    end = rows.until(row)
    waits = rows.stop[row] < end
    row, end = row[waits], end[waits]
    nothing = np.zeros(len(row), bool)
    capture, start, cost = (it[row].astype(np.int64) for it in (rows.capture, rows.stop, cost))
    return Events(capture, (row,), (row,), start, end, end, cost, nothing, nothing)


def overlapping(one: Events, other: Events) -> tuple[IntArray, IntArray]:
    """Return all pairs of events of a capture that share a frame, in order."""
    ones, others = (it.capture * FAR + it.start for it in (one, other))
    by_one, by_other = (np.argsort(keys, kind="stable") for keys in (ones, others))
    ones, others = ones[by_one], others[by_other]
    # Either the other begins while the one lasts, or the one after the other did, while it lasts.
    until = one.capture * FAR + one.until
    low = np.searchsorted(others, one.capture * FAR + one.start)
    first, second = spread(low, np.searchsorted(others, until))
    until = other.capture * FAR + other.until
    low = np.searchsorted(ones, other.capture * FAR + other.start, "right")
    fourth, third = spread(low, np.searchsorted(ones, until))
    left = np.concatenate((first, by_one[third]))
    right = np.concatenate((by_other[second], fourth))
    order = np.lexsort((right, left))
    return left[order], right[order]


def paired(manner: str, one: Events, other: Events) -> Events:
    """Return the pairs of two parts' events that share a frame.

    Two movements span both; two stays or rests last while both do.
    """
    left, right = overlapping(one, other)
    one, other = one.at(left), other.at(right)
    together = manner in ("at", "hold")
    start = (np.maximum if together else np.minimum)(one.start, other.start)
    end = np.minimum(one.until, other.until) if together else np.maximum(one.end, other.end)
    return Events(
        one.capture,
        one.first + other.first,
        one.last + other.last,
        start,
        end,
        end if together else np.maximum(one.until, other.until),
        np.maximum(one.cost, other.cost),
        one.passing | other.passing,
        one.starting | other.starting,
    )


def ordered(events: Events) -> bool:
    """Tell whether both members of pairs go on in the same order, so that ranges are ranges."""
    return len(events.first) == 1 or bool((np.diff(events.first[1]) >= 0).all())
