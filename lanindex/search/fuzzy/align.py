"""What the best match of a line costs that ends with each symbol, for many stretches at once.

What is remembered is, for each place where one may wait for a step, how cheaply one can stand
there. What a match costs, where it begins and how clear it is share a number, so that the smallest
is the cheapest, of the cheapest the one that begins last, and of these the clearest.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import THOUSANDTHS
from lanindex.search.fuzzy.net import FREE, MISSING, SKIPPED, Net

Keys = NDArray[np.int64]
Ask = Callable[[], None]
"""Is asked now and then whether to go on; it raises where not."""

COST, FIRST = 42, 10
"""From which bit on a key tells the cost and the beginning; below stands what is not clear."""

BLUR = (1 << FIRST) - 1
LATEST = (1 << COST - FIRST) - 1
NOTHING = 1 << 60
"""The key where no match ends."""

PATIENCE = 1 << 14
"""Steps and arrows of positions in a stretch after which it is asked again whether to go on."""


def cost_of(keys: Keys) -> Keys:
    """Return what matches cost, in parts of an edit."""
    return keys >> COST


def first_of(keys: Keys) -> Keys:
    """Return the places at which matches begin."""
    return LATEST - (keys >> FIRST & LATEST)


def blur_of(keys: Keys) -> Keys:
    """Return what the symbols that fit lack to a margin of 1, in thousandths."""
    return keys & BLUR


def key_of(costs: Keys, blur: Keys) -> Keys:
    """Return the keys of matches of one symbol each, but for where they begin."""
    return (costs << COST) + blur


class Rows(NamedTuple):
    """Symbols to be aligned, stretch by stretch.

    Attributes
    ----------
    new : ndarray
        (R,) bool: where a stretch begins; the first one does.
    shown : ndarray
        (R,) bool: which symbols a score shows.
    skipped : ndarray
        (R,) int64: how many shown ones that match no step lie between each and the one before.
    costs : ndarray
        (K, R) int16: by step what each symbol costs as that one.
    blur : ndarray
        (R,) int16: what each lacks to a margin of 1, in thousandths.
    entry, exit : ndarray
        (W, R) int32: what it costs besides to begin or end here, by way as in `Net.entry`.
    """

    new: NDArray[np.bool_]
    shown: NDArray[np.bool_]
    skipped: Keys
    costs: NDArray[np.int16]
    blur: NDArray[np.int16]
    entry: NDArray[np.int32]
    exit: NDArray[np.int32]


def blurs(margins: NDArray[np.uint16]) -> NDArray[np.int16]:
    """Return what symbols lack to a margin of 1, in thousandths, from their margins."""
    return (THOUSANDTHS - np.minimum(margins, THOUSANDTHS)).astype(np.int16)


def align(net: Net, rows: Rows, most: int, ask: Ask) -> Keys:
    """Return the best match that ends with each symbol and costs no more than `most`.

    Returns
    -------
    ndarray
        (R,) int64 keys, for `cost_of`, `first_of` and `blur_of`; `NOTHING` where none ends. The
        line is no stay.
    """
    begins = np.flatnonzero(rows.new)
    lengths = np.diff(np.append(begins, len(rows.new)))
    order = np.argsort(-lengths, kind="stable")
    begins, lengths = begins[order], lengths[order]
    longest = int(lengths.max(initial=0))
    count = np.searchsorted(-lengths, -np.arange(longest), side="left")
    found = np.full(len(rows.new), NOTHING, np.int64)
    steps = _Steps(net, most, len(lengths))
    patience = max(PATIENCE // (len(net.edges) + len(net.states)), 1)
    for position in range(longest):
        if position % patience == 0:
            ask()
        here = begins[: count[position]] + position
        found[here] = steps.over(rows, here)
    return found


class _Steps:
    """What waits before each step, stretch by stretch, the longest first."""

    def __init__(self, net: Net, most: int, stretches: int) -> None:
        self._most, many = most, len(net.doors)
        self._waits = np.full((2, len(net.states)), many)  # a door that nobody waits at
        for state, doors in enumerate(net.waits):
            self._waits[: len(doors), state] = doors
        self._tight = np.array([not later for _, later in net.doors], np.bool_)
        self._comes = np.array([state for it in net.comes for state in it], np.int64)
        self._begins = np.cumsum([0, *map(len, net.comes)])[:-1]
        ways = sorted(net.missing(most), key=lambda it: it[1])
        self._from, self._onto, steps = np.array(ways, np.int64).reshape(-1, 3).T
        self._missing = (steps * MISSING << COST)[:, None]
        self._news = np.flatnonzero(np.diff(self._onto, prepend=-1))
        self._entry, self._exit = (
            [(way, np.array(costs)[:, None] << COST) for way, costs in enumerate(ways)
             if min(costs) <= most] for ways in (net.entry, net.exit)
        )  # fmt: skip
        self._waiting = np.full((many + 1, stretches), NOTHING, np.int64)

    def over(self, rows: Rows, here: Keys) -> Keys:
        """Go over one row in each of some stretches; return the best match that ends with it."""
        waiting = self._waiting[:, : len(here)]
        tight = np.flatnonzero(self._tight)
        if rows.skipped[here].any():
            waiting[tight] += rows.skipped[here] * (SKIPPED << COST)
        arrived = self._arrived(rows, here, waiting)
        best = np.full(len(here), NOTHING, np.int64)
        for way, missing in self._exit:
            besides = rows.exit[way - 1][here].astype(np.int64) << COST if way > FREE else 0
            best = np.minimum(best, (arrived + missing).min(axis=0) + besides)
        waiting[tight] += rows.shown[here] * np.int64(SKIPPED << COST)
        if len(self._comes):
            came = np.minimum.reduceat(arrived[self._comes], self._begins, axis=0)
            np.minimum(waiting[:-1], came, out=waiting[:-1])
        if len(self._from):
            missing = waiting[self._from] + self._missing
            onto = self._onto[self._news]
            waiting[onto] = np.minimum(
                waiting[onto], np.minimum.reduceat(missing, self._news, axis=0)
            )
        waiting[waiting >> COST > self._most] = NOTHING
        return np.where(best >> COST > self._most, NOTHING, best)

    def _arrived(self, rows: Rows, here: Keys, waiting: Keys) -> Keys:
        """Return the best match that stands at each step with these rows: (K, N)."""
        keys = np.minimum(waiting[self._waits[0]], waiting[self._waits[1]])
        begun = LATEST - here << FIRST
        for way, missing in self._entry:
            besides = rows.entry[way - 1][here].astype(np.int64) << COST if way > FREE else 0
            keys = np.minimum(keys, missing + (begun + besides))
        costs = rows.costs[:, here].astype(np.int64)
        keys += costs << COST
        blur = np.where(costs == 0, np.maximum(keys & BLUR, rows.blur[here]), keys & BLUR)
        return np.where(keys >> COST > self._most, NOTHING, keys & ~BLUR | blur)


class _Way(NamedTuple):
    """A way to a step: its cost, what is not clear, and the rows with the steps they match."""

    cost: int
    blur: int
    rows: tuple[tuple[int, int], ...]


class Stretch(NamedTuple):
    """The rows of a match: costs, blur and shown as of `Rows`.

    `entry` and `exit` are by step what it costs to begin at the first row, and to end at the last.
    """

    costs: NDArray[np.int16]
    blur: NDArray[np.int16]
    shown: NDArray[np.bool_]
    entry: list[int]
    exit: list[int]


def trace(net: Net, rows: Stretch, most: int) -> tuple[tuple[int, int], ...]:
    """Return the best match from the first of some rows to the last, as rows, from 0, and steps.

    It costs `most`; of the cheapest it is the clearest. The line is no stay.
    """
    behind = np.cumsum(rows.shown)
    missing = net.missing(most)
    waiting: dict[int, _Way] = {}
    arrived: dict[int, _Way] = {}
    before = 0
    for row in np.flatnonzero((rows.costs <= most).any(axis=0)).tolist():
        shown, blur = int(rows.shown[row]), int(rows.blur[row])
        waiting = _past(net, waiting, int(behind[row]) - shown - before)  # what matches no step
        arrived = {}
        for state, cost in enumerate(rows.costs[:, row].tolist()):
            ways = [waiting[door] for door in net.waits[state] if door in waiting]
            ways += [_Way(rows.entry[state], 0, ())] if row == 0 else []
            if ways and cost <= most:
                best = min(ways)
                unclear = max(best.blur, blur) if cost == 0 else best.blur
                arrived[state] = _Way(best.cost + cost, unclear, (*best.rows, (row, state)))
        waiting = _past(net, waiting, shown)
        for state, way in arrived.items():
            for door in net.goes[state]:
                waiting[door] = min(way, waiting.get(door, way))
        complete = dict(waiting)
        for near, far, steps in missing:
            if near in complete:
                way = complete[near]._replace(cost=complete[near].cost + MISSING * steps)
                waiting[far] = min(way, waiting.get(far, way))
        waiting = {door: way for door, way in waiting.items() if way.cost <= most}
        before = int(behind[row])
    return min(way._replace(cost=way.cost + rows.exit[it]) for it, way in arrived.items()).rows


def _past(net: Net, waiting: dict[int, _Way], shown: int) -> dict[int, _Way]:
    """Return the ways that wait behind so many more shown rows."""
    return {
        door: way if net.doors[door][1] else way._replace(cost=way.cost + SKIPPED * shown)
        for door, way in waiting.items()
    }
