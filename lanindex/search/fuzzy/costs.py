"""What a symbol costs where a step asks for another: the angle between the two.

A symbol is known finer than by its cell: the margin tells how far it is from the border to the
runner-up, so it stands for a direction between the middles of the two. Up to half a cell beside
the middle of what was asked for costs nothing, from there on it costs an edit for every cell's
width: a neighbour in its middle costs half an edit, the next but one an edit and a half.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS, MID, PLACE
from lanindex.model.columns import CELL, PASSING, STARTING, THOUSANDTHS, Columns
from lanindex.search.automaton import State
from lanindex.search.language.words import WORD_KINDS

UNIT = 64
"""Parts of an edit in which costs are counted, so that equal ones are equal."""

WIDTH = 45.0
"""Degrees from the middle of one cell to the next."""

FREE = WIDTH / 2
"""Degrees beside the middle that cost nothing."""

DRAWN_IN = 60.0
"""Degrees between any direction and none, which is what place mid is."""

MOST = 2 * UNIT
"""What a symbol costs at most; more than leaving out the step and passing over the symbol."""

BUCKETS = 16
"""Steps of the margin that are told apart."""

CHANGE = UNIT
"""What a change of level costs that is not the one asked for."""

_LEVELS = len(LEVELS)

_BUCKET = (np.arange(THOUSANDTHS + 1) * BUCKETS // THOUSANDTHS).astype(np.int32)
"""By thousandths of a margin, its step."""


@lru_cache(maxsize=1)
def middles() -> NDArray[np.float64]:
    """Return the middle of each cell: (27, 3) unit vectors, right, forward, up; place mid is 0."""
    vectors = np.zeros((len(DIRECTIONS), _LEVELS, 3))
    for level in range(_LEVELS):
        up = np.radians(WIDTH * (level - MID))
        for direction in range(PLACE):
            around = np.radians(WIDTH * direction)
            flat = np.cos(up)
            vectors[direction, level] = flat * np.cos(around), flat * np.sin(around), np.sin(up)
        vectors[PLACE, level] = 0, 0, level - MID
    return vectors.reshape(-1, 3)


def angles(some: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angles between vectors, degrees.

    Parameters
    ----------
    some, others : ndarray
        (N, 3) and (M, 3), not all of them of length 1.

    Returns
    -------
    ndarray
        (N, M); `DRAWN_IN` between a vector of no length and another one.
    """
    lengths = np.linalg.norm(some, axis=1)[:, None], np.linalg.norm(others, axis=1)[None]
    none = lengths[0] < 1e-6, lengths[1] < 1e-6
    product = np.maximum(lengths[0] * lengths[1], 1e-12)
    found = np.degrees(np.arccos(np.clip(some @ others.T / product, -1, 1)))
    found = np.where(none[0] ^ none[1], DRAWN_IN, found)
    result: NDArray[np.float64] = np.where(none[0] & none[1], 0.0, found)
    return result


@lru_cache(maxsize=1)
def _turns() -> NDArray[np.int16]:
    """Return what a symbol costs where a cell is asked for: (64, 64, BUCKETS + 1, 27).

    By cell, runner-up and margin of the symbol, as columns hold them. What stands for no direction
    costs the most; one without a runner-up stands for the middle of its cell.
    """
    middle, place = middles(), _place(np.arange(CELL + 1))
    share = (1 - np.arange(BUCKETS + 1) / BUCKETS)[None, None, :, None] / 2
    towards = middle[None, :, None] - middle[:, None, None]
    standing = np.concatenate(
        [
            middle[:, None, None] + share * towards,
            np.broadcast_to(middle[:, None, None], (len(middle), 1, BUCKETS + 1, 3)),
        ],
        axis=1,
    )
    turned = angles(standing.reshape(-1, 3), middle).reshape(*standing.shape[:-1], len(middle))
    costs = np.rint(np.maximum(turned - FREE, 0) / WIDTH * UNIT)
    known: NDArray[np.int16] = np.minimum(costs, MOST).astype(np.int16)[place][:, place]
    known[place < 0] = MOST
    return known


def _place(cell: NDArray[Any]) -> NDArray[np.intp]:
    """Return the index in `middles` of cells as columns hold them; -1 where something is absent."""
    direction, level = (cell & 15) - 1, (cell >> 4 & 3) - 1
    known = (direction >= 0) & (direction < len(DIRECTIONS)) & (level >= 0)
    return np.where(known, direction * _LEVELS + level, -1)


@lru_cache(maxsize=2)
def _kinds(columns: Columns) -> NDArray[np.int32]:
    """Return cell, runner-up and margin of each symbol as one number, as in `_turns`: (S,)."""
    kinds = (columns.cell & CELL).astype(np.int32)
    kinds *= CELL + 1
    kinds += columns.runner
    kinds *= BUCKETS + 1
    kinds += _BUCKET[columns.margin]
    return kinds


def _asked(state: State, member: int) -> NDArray[np.bool_]:
    """Return which cells a state asks for: (64,) by the bits of a cell."""
    fits = state.fits[member]
    asked = np.ones(CELL + 1, np.bool_)
    for cell in range(CELL + 1):
        codes = {"direction": (cell & 15) - 1, "level": (cell >> 4) - 1}
        asked[cell] = all(codes[kind] in fits[kind] for kind in codes if kind in fits)
    return asked


def substitutions(state: State, member: int, columns: Columns) -> NDArray[np.int64]:
    """Return what each symbol costs as one that a state asks for.

    Parameters
    ----------
    state : State
        A movement or a stay of one part.
    member : int
        Which of its members.
    columns : Columns
        Of that part.

    Returns
    -------
    ndarray
        (S,) int64, parts of an edit: `UNIT` is a whole one, `MOST` the most.
    """
    asked = _asked(state, member)
    wanted = _place(np.flatnonzero(asked))
    wanted = wanted[wanted >= 0]
    table = np.full((CELL + 1, CELL + 1, BUCKETS + 1), MOST, np.int16)
    if len(wanted):
        table = _turns()[..., wanted].min(axis=-1)
    table[asked] = 0
    costs = table.ravel()[_kinds(columns)].astype(np.int64)
    if "change" in state.fits[member]:
        costs += _changed(state.fits[member]["change"], columns)
    return np.minimum(costs, MOST)


def _changed(wanted: frozenset[int], columns: Columns) -> NDArray[np.int64]:
    """Return what rows cost whose change of level from the shown one before is not asked for."""
    codes = WORD_KINDS["change"].codes
    change = np.full(len(columns), codes["neither"])
    shown = np.flatnonzero(columns.cell & PASSING == 0)
    level = (columns.cell[shown] >> 4 & 3).astype(np.int64) - 1
    follows = columns.cell[shown] & STARTING == 0
    follows[:1] = False
    more = np.sign(np.diff(level, prepend=level[:1]))
    known = (level >= 0) & (np.roll(level, 1) >= 0) & follows
    said = np.where(more > 0, codes["rising"], codes["sinking"])
    change[shown] = np.where(known & (more != 0), said, codes["neither"])
    wrong = ~np.isin(change, list(wanted))
    return np.where(wrong, np.int64(CHANGE), np.int64(0))
