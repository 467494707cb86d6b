"""What a symbol costs where a step asks for another: the angle between the two.

A symbol is known finer than by its cell: the margin tells how far it is from the border to the
runner-up, so it stands for a direction between the middles of the two. Up to half a cell beside
the middle of what was asked for costs nothing, from there on it costs an edit for every cell's
width: a neighbour in its middle costs half an edit, the next but one an edit and a half.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS, MID, PLACE
from lanindex.errors import UsageError
from lanindex.model.columns import CELL, PASSING, STARTING, THOUSANDTHS, Columns, begins_of, ranges
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

NEVER = 30000
"""What a symbol costs that does not last as long as a step wants: no edit mends that."""

_LEVELS = len(LEVELS)

_BUCKET = (np.arange(THOUSANDTHS + 1) * BUCKETS // THOUSANDTHS).astype(np.int32)
"""By thousandths of a margin, its step."""

FEW = 8
"""How many times the rows wanted a part must have, that they are not looked for one by one."""

_AT_ONCE = 1 << 18
"""Rows whose kinds are worked out at once."""


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
    """Return the angles between (N, 3) and (M, 3) vectors: (N, M) degrees.

    Between a vector of no length and another one it is `DRAWN_IN`.
    """
    lengths = np.linalg.norm(some, axis=1)[:, None], np.linalg.norm(others, axis=1)[None]
    none = lengths[0] < 1e-6, lengths[1] < 1e-6
    product = np.maximum(lengths[0] * lengths[1], 1e-12)
    found = np.degrees(np.arccos(np.clip(some @ others.T / product, -1, 1)))
    found = np.where(none[0] ^ none[1], DRAWN_IN, found)
    result: NDArray[np.float64] = np.where(none[0] & none[1], 0.0, found)
    return result


class Kinds:
    """The kinds of symbols of a part: all that have cell, runner-up and margin in common.

    Attributes
    ----------
    code : ndarray
        (S,) which kind each symbol is of.
    counts : ndarray
        (K,) how many are.
    bucket : ndarray
        (K,) the step of their margin.
    passing : ndarray
        (K,) bool.
    begins : ndarray
        (S + 1,) bool: where a stretch begins that no match reaches over; the one behind the last
        row does.
    """

    def __init__(self, columns: Columns) -> None:
        numbers = np.empty(len(columns), np.int32)
        for first in range(0, len(columns), _AT_ONCE):
            own = slice(first, first + _AT_ONCE)
            kinds = columns.cell[own].astype(np.int32)
            kinds *= CELL + 1
            kinds += columns.runner[own] & CELL
            kinds *= BUCKETS + 1
            kinds += _BUCKET[np.minimum(columns.margin[own], THOUSANDTHS)]
            numbers[own] = kinds
        counts = np.bincount(numbers)
        known = np.flatnonzero(counts)
        places = np.zeros(len(counts), np.min_scalar_type(len(known)))
        places[known] = np.arange(len(known))
        self.code: NDArray[np.unsignedinteger[Any]] = places[numbers]
        self.counts = counts[known]
        self.bucket = known % (BUCKETS + 1)
        cell = known // (BUCKETS + 1) // (CELL + 1)
        self.passing: NDArray[np.bool_] = cell & PASSING != 0
        self.begins = begins_of(
            columns.part, columns.cell, columns.bounds, columns.start, columns.gaps
        )
        self._cell = cell & CELL
        self._turns = _turns(self._cell, known // (BUCKETS + 1) % (CELL + 1), self.bucket)

    def table(self, state: State) -> NDArray[np.int16]:
        """Return what each kind costs as what a state asks for: (K,), changes left out."""
        asked = _asked(state)
        wanted = _place(np.flatnonzero(asked))
        table = self._turns[:, wanted[wanted >= 0]].min(axis=1, initial=MOST)
        return np.where(asked[self._cell], np.int16(0), table)

    def where(self, some: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Return the rows of some kinds: (N,), growing."""
        if FEW * int(self.counts[some].sum()) > len(self.code):
            return np.flatnonzero(some[self.code])
        rows, ends = self._by_kind
        _, places = ranges((ends - self.counts)[some], ends[some])
        return np.sort(rows[places]).astype(np.int64)

    @cached_property
    def stretches(self) -> NDArray[np.int64]:
        """The rows that begin stretches, and the one behind the last."""
        return np.flatnonzero(self.begins)

    @cached_property
    def _by_kind(self) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
        """All rows, those of a kind together, and by kind where its rows end among them."""
        return np.argsort(self.code, kind="stable").astype(np.int32), np.cumsum(self.counts)


_known: WeakKeyDictionary[Columns, Kinds] = WeakKeyDictionary()
"""The kinds of columns, for as long as somebody has these."""


def kinds_of(columns: Columns) -> Kinds:
    """Return the kinds of columns; they are worked out once."""
    found = _known.get(columns)
    if found is None:
        found = _known[columns] = Kinds(columns)
    return found


def _turns(cell: NDArray[Any], runner: NDArray[Any], bucket: NDArray[Any]) -> NDArray[np.int16]:
    """Return what kinds of symbols cost where each of the 27 cells is asked for: (K, 27).

    What stands for no direction costs the most; one without a runner-up stands for the middle of
    its cell.
    """
    middle, place, other = middles(), _place(cell), _place(runner)
    share = ((1 - bucket / BUCKETS) / 2 * (other >= 0))[:, None]
    standing = middle[place] + share * (middle[other] - middle[place])
    costs = np.rint(np.maximum(angles(standing, middle) - FREE, 0) / WIDTH * UNIT)
    known = np.minimum(costs, MOST).astype(np.int16)
    known[place < 0] = MOST
    return known


def _place(cell: NDArray[Any]) -> NDArray[np.intp]:
    """Return the index in `middles` of cells as columns hold them; -1 where something is absent."""
    direction, level = (cell & 15) - 1, (cell >> 4 & 3) - 1
    known = (direction >= 0) & (direction < len(DIRECTIONS)) & (level >= 0)
    return np.where(known, direction * _LEVELS + level, -1)


def _asked(state: State) -> NDArray[np.bool_]:
    """Return which cells a state asks for: (64,) by the bits of a cell."""
    fits, cells = state.fits[0], np.arange(CELL + 1)
    asked = np.ones(CELL + 1, np.bool_)
    for kind, codes in (("direction", (cells & 15) - 1), ("level", (cells >> 4) - 1)):
        if kind in fits:
            asked &= np.isin(codes, list(fits[kind]))
    return asked


def substitutions(
    state: State, table: NDArray[np.int16], columns: Columns, rows: NDArray[np.int64]
) -> NDArray[np.int16]:
    """Return what symbols cost as one that a state, of movement or stay, asks for.

    Parameters
    ----------
    table : ndarray
        What each kind costs, as from `Kinds.table`.
    rows : ndarray
        (R,) int64: which symbols, growing.

    Returns
    -------
    ndarray
        (R,) int16, parts of an edit: `UNIT` is a whole one, `MOST` the most.
    """
    costs: NDArray[np.int16] = table[kinds_of(columns).code[rows]]
    if "change" in state.fits[0]:
        wrong = _changed(state.fits[0]["change"], columns, rows)
        costs = np.minimum(costs + wrong * np.int16(CHANGE), np.maximum(costs, MOST))
    return costs


def _changed(
    wanted: frozenset[int], columns: Columns, rows: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Return at which rows the level has not changed from the shown one before as is asked for."""
    codes = WORD_KINDS["change"].codes
    change = np.full(len(rows), codes["neither"])
    cell = columns.cell[rows]
    places = np.flatnonzero(cell & (PASSING | STARTING) == 0)
    begin = columns.bounds[np.searchsorted(columns.bounds, rows[places], side="right") - 1]
    before = rows[places] - 1
    going = np.arange(len(places))
    while len(going):  # over what is passing, to the shown one before
        there = before[going]
        passing = (there >= begin[going]) & (columns.cell[there] & PASSING > 0)
        going = going[passing]
        before[going] -= 1
    inside = before >= begin
    places, before = places[inside], before[inside]
    level = (cell[places] >> 4 & 3).astype(np.int64) - 1
    lower = (columns.cell[before] >> 4 & 3).astype(np.int64) - 1
    said = np.where(level > lower, codes["rising"], codes["sinking"])
    known = (level >= 0) & (lower >= 0) & (level != lower)
    change[places[known]] = said[known]
    return ~np.isin(change, list(wanted))


CARRYING = 2
"""Steps that a share of edits is not given for: without them nothing is left of a pattern."""


@dataclass(frozen=True, slots=True)
class Allowance:
    """How much a match may differ from its pattern.

    Attributes
    ----------
    edits : Fraction
        How many edits, or, as a share, how many for each step but the first `CARRYING`.
    share : bool
        Whether it is a share.

    Examples
    --------
    >>> from lanindex.search.fuzzy import Allowance
    >>> Allowance.read("2").of(5), Allowance.read("20%").of(7)
    (128, 64)
    """

    edits: Fraction
    share: bool = False

    @classmethod
    def read(cls, text: str) -> Allowance:
        """Return what ``2``, ``0.5`` or ``20%`` means; a `UsageError` where it is none of these."""
        number = text.strip().removesuffix("%")
        share = number != text.strip()
        if not number.replace(".", "", 1).isdecimal() or len(number) > 9:
            raise UsageError(f'"{text}" edits', wanted="a number of edits, 2, or a share, 20%")
        edits = Fraction(number) / (100 if share else 1)
        return cls(edits, share)

    def of(self, steps: int) -> int:
        """Return how much a pattern of so many steps may cost, in parts of an edit."""
        edits = self.edits * max(steps - CARRYING, 0) if self.share else self.edits
        return int(edits * UNIT)
