"""Which clips can be like one at all: a bound that needs no alignment.

What two clips share is at most what each movement of one saves if it may take the place of the best
of the other, whatever the order. That is one look at each symbol, and never less than what an
alignment finds; so clips are aligned in the order of their bounds, and when the bound falls below
the likeness of the worst that is wanted, the rest need not be looked at.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lanindex.search.example.align import POSE, REPLACED, likeness, savings_of
from lanindex.search.example.moves import STEP, Clips, Floats, Moves, Numbers

LONGEST = 2048
"""Movements of one part of the example that are each compared with every movement."""

_FARTHEST = 2.0
"""How far a movement can go."""


class Promise(NamedTuple):
    """How alike clips can be to one.

    Attributes
    ----------
    whole : ndarray
        (C,) float32, no less than the likeness of each whole clip.
    stretch : ndarray
        (C,) float32, about how alike its best stretch may be.
    share : ndarray
        (N,) float32, by row of the clips what it may save at most.
    """

    whole: Floats
    stretch: Floats
    share: Floats


def promises(query: Clips, clips: Clips) -> Promise:
    """Return how alike each of many clips can be to one clip, which has the same parts."""
    saved = np.zeros(len(clips), np.float32)
    found = np.zeros(len(clips), np.float32)
    share = np.zeros(len(clips.moves.rows), np.float32)
    cumulated = np.concatenate([[0], np.cumsum(clips.moves.sizes, dtype=np.float64)])
    sizes = np.diff(cumulated[clips.first], axis=1).sum(axis=0).astype(np.float32)
    for part, borders in enumerate(clips.first):
        low, high = query.first[part]
        there = np.flatnonzero(np.diff(borders))
        if low == high or not len(there):
            continue
        own, first = query.moves.some(slice(low, high)), borders[there]
        rows = slice(first[0], borders[-1])
        most, best = _savings(own, clips.moves.some(rows), first - first[0])
        share[rows] = best
        saved[there] += np.minimum(most, np.add.reduceat(best, first - first[0]))
        saved[there] += _begun(own, clips.moves.some(first))
        found[there] += most
    asked = query.moves.sizes.sum()
    total = sizes + asked
    stretch = found / np.maximum(asked + found / 2, np.float32(1e-6))  # 0 where nothing is asked
    return Promise(likeness(total - saved, total), np.clip(stretch, 0, 1), share)


def _savings(own: Moves, rows: Moves, first: Numbers) -> tuple[Floats, Floats]:
    """Return by clip what the query's movements save at most, and by row what it saves at most.

    `first` is where each clip begins among the rows.
    """
    most = np.zeros(len(first), np.float32)
    best = np.zeros(len(rows.rows), np.float32)
    beginning = np.zeros(len(rows.rows), bool)
    beginning[first] = True
    if len(own.rows) > LONGEST:
        most += _most(own)[1:].sum()
        return most, np.where(beginning, np.float32(0), _most(rows))
    for saving in savings_of(own, rows, slice(None)):
        np.maximum(saving, 0, out=saving)
        saving[beginning] = 0
        most += np.maximum.reduceat(saving, first)
        np.maximum(best, saving, out=best)
    return most, best


def _most(moves: Moves) -> Floats:
    """Return what each movement saves at most, whatever it may take the place of.

    That is what it and its like cost, and what is not asked for how much farther the other goes; a
    starting position behind a gap, which costs nothing of its own, may stand for a whole movement.
    """
    farther = np.float32((1 - REPLACED) * _FARTHEST)
    starting = np.float32(STEP + _FARTHEST)
    most: Floats = 2 * moves.sizes + np.where(moves.starts < moves.stops, farther, starting)
    return most


def _begun(own: Moves, begins: Moves) -> Floats:
    """Return what is saved by where the part begins; less than 0 where that lies apart."""
    apart = np.sqrt(np.square(begins.points - own.points[0]).sum(axis=1))
    swings = begins.swings + own.swings[0] - np.abs(begins.swings - own.swings[0])
    begun: Floats = swings - np.float32(POSE) * apart
    return begun
