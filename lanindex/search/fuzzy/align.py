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

PATIENCE = 256
"""Symbols of a stretch after which it is asked again whether to go on."""


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
    costs : ndarray
        (K, R) int16: by step what each symbol costs as that one.
    blur : ndarray
        (R,) int16: what each lacks to a margin of 1, in thousandths.
    entry, exit : ndarray
        (W, R) int32: what it costs besides to begin or end here, by way as in `Net.entry`.
    """

    new: NDArray[np.bool_]
    shown: NDArray[np.bool_]
    costs: NDArray[np.int16]
    blur: NDArray[np.int16]
    entry: NDArray[np.int32]
    exit: NDArray[np.int32]


def blurs(margins: NDArray[np.uint16]) -> NDArray[np.int16]:
    """Return what symbols lack to a margin of 1, in thousandths, from their margins."""
    return (THOUSANDTHS - np.minimum(margins, THOUSANDTHS)).astype(np.int16)


def align(net: Net, rows: Rows, most: int, ask: Ask) -> Keys:
    """Return the best match that ends with each symbol.

    Parameters
    ----------
    net : Net
        The line; no stay.
    rows : Rows
        The symbols.
    most : int
        What a match may cost.
    ask : callable
        Is asked now and then whether to go on.

    Returns
    -------
    ndarray
        (R,) int64 keys, for `cost_of`, `first_of` and `blur_of`; `NOTHING` where none ends.
    """
    begins = np.flatnonzero(rows.new)
    lengths = np.diff(np.append(begins, len(rows.new)))
    order = np.argsort(-lengths, kind="stable")
    begins, lengths = begins[order], lengths[order]
    longest = int(lengths.max(initial=0))
    count = np.searchsorted(-lengths, -np.arange(longest), side="left")
    found = np.full(len(rows.new), NOTHING, np.int64)
    waiting = np.full((len(net.doors), len(lengths)), NOTHING, np.int64)
    for position in range(longest):
        if position % PATIENCE == 0:
            ask()
        here = begins[: count[position]] + position
        held = waiting[:, : len(here)]
        arrived = [_arrived(net, state, rows, here, held, most) for state in range(len(net.states))]
        found[here] = _ended(net, rows, here, arrived, most)
        _wait(net, held, arrived, rows.shown[here], most)
    return found


def _within(keys: Keys, most: int) -> Keys:
    return np.where(keys >> COST > most, NOTHING, keys)


def _arrived(net: Net, state: int, rows: Rows, here: Keys, waiting: Keys, most: int) -> Keys:
    """Return the best match that stands at a step with these rows."""
    keys = np.full(len(here), NOTHING, np.int64)
    begun = LATEST - here << FIRST
    for way, missing in enumerate(net.entry):
        if missing[state] <= most:
            besides = np.int64(missing[state]) + (rows.entry[way - 1][here] if way > FREE else 0)
            keys = np.minimum(keys, (besides << COST) + begun)
    for door in net.waits[state]:
        keys = np.minimum(keys, waiting[door])
    costs = rows.costs[state][here].astype(np.int64)
    keys = keys + (costs << COST)
    blur = np.where(costs == 0, np.maximum(keys & BLUR, rows.blur[here]), keys & BLUR)
    return _within(keys & ~BLUR | blur, most)


def _ended(net: Net, rows: Rows, here: Keys, arrived: list[Keys], most: int) -> Keys:
    """Return the best match that ends with these rows."""
    best = np.full(len(here), NOTHING, np.int64)
    for way, missing in enumerate(net.exit):
        for state, keys in enumerate(arrived):
            if missing[state] <= most:
                besides = missing[state] + (rows.exit[way - 1][here] if way > FREE else 0)
                best = np.minimum(best, keys + (np.int64(besides) << COST))
    return _within(best, most)


def _wait(
    net: Net, waiting: Keys, arrived: list[Keys], shown: NDArray[np.bool_], most: int
) -> None:
    """Let what waits pass over a row, and what has arrived wait; then let steps be missing."""
    passed = np.where(shown, SKIPPED << COST, 0)
    for door, (_, later) in enumerate(net.doors):
        if not later:
            waiting[door] += passed
        for before in net.comes[door]:
            np.minimum(waiting[door], arrived[before], out=waiting[door])
    for _ in range(net.rounds(most)) if most >= MISSING else ():
        for state, doors in enumerate(net.goes):
            if doors and net.waits[state]:
                missing = waiting[list(net.waits[state])].min(axis=0) + (MISSING << COST)
                for door in doors:
                    np.minimum(waiting[door], missing, out=waiting[door])
    waiting[:] = _within(waiting, most)
