"""Scan with costs: what each symbol costs where a step asks for another, by the angle between them.

Up to half a cell beside the middle of what was asked for costs nothing; from there on each cell's
width costs an edit: a neighbour in its middle costs half an edit, the next but one an edit and a
half.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import UsageError
from lanindex.model.columns import CELL, THOUSANDTHS, Columns, ranges
from lanindex.search.language.words import WORD_KINDS
from lanindex.search.match.arrays import AnyArray, BoolArray, IntArray
from lanindex.search.match.batch import Batch, cells_of
from lanindex.search.plan import State
from lanindex.search.sphere import KNOWN, MIDDLES, points_of

Costs = NDArray[np.int16]

UNIT = 64  # parts of an edit in which costs are counted, so that equal ones are equal
WIDTH, FREE = 45.0, 22.5  # degrees: from one cell to the next, and what costs nothing
DRAWN_IN = 60.0  # degrees between a direction and place mid
MOST = 2 * UNIT  # what a symbol costs at most: more than to leave out the step and pass over it
CHANGE = UNIT  # what a change of level costs that is not the one asked for
NEVER = 30000  # what a symbol costs that no edit makes a match
BUCKETS = 16  # steps of the margin
CARRYING = 2  # steps that a share of edits is not given for: without them nothing is left

# by thousandths of a margin, its step
_BUCKET = (np.arange(THOUSANDTHS + 1) * BUCKETS // THOUSANDTHS).astype(np.uint8)


def angles(some: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angles between (N, 3) and (M, 3) vectors: (N, M) degrees.

    Between a vector of no length and another one it is `DRAWN_IN`.
    """
    one, other = np.linalg.norm(some, axis=1)[:, None], np.linalg.norm(others, axis=1)
    cosine = some @ others.T / np.maximum(one * other, 1e-12)
    found = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    found = np.where((one < 1e-6) ^ (other < 1e-6), DRAWN_IN, found)
    return np.where((one < 1e-6) & (other < 1e-6), 0.0, found)


class Kinds:
    """The symbols of a part by kind: those of a kind have cell, runner-up and margin in common."""

    code: AnyArray  # (S,) which kind each symbol is of
    counts: IntArray  # (K,) how many symbols are of each kind
    bucket: IntArray  # (K,) the step of their margin

    def __init__(self, columns: Columns) -> None:
        numbers = (columns.cell & CELL).astype(np.int32)
        numbers *= CELL + 1
        numbers += columns.runner & CELL
        numbers *= BUCKETS + 1
        numbers += _BUCKET[np.minimum(columns.margin, THOUSANDTHS)]
        counts = np.bincount(numbers)
        known = np.flatnonzero(counts)
        places = np.zeros(len(counts), np.min_scalar_type(len(known)))
        places[known] = np.arange(len(known))
        self.code = places[numbers]
        self.counts, self.bucket = counts[known], known % (BUCKETS + 1)
        self._cell, runner = np.divmod(known // (BUCKETS + 1), CELL + 1)
        self._turns = _turns(self._cell, runner, self.bucket)
        self._bounds = columns.bounds

    def table(self, state: State) -> Costs:
        """Return what each kind costs as what a state asks for: (K,), changes left out."""
        wanted = cells_of(state, 0)[: CELL + 1]
        table = self._turns[:, wanted].min(axis=1, initial=MOST)
        return np.where(wanted[self._cell], np.int16(0), table)

    def having(self, some: BoolArray) -> BoolArray:
        """Return which captures have a symbol of some kinds, (captures,)."""
        by_kind, ends = self._by_kind
        _, places = ranges((ends - self.counts)[some], ends[some])
        found = np.zeros(len(self._bounds) - 1, np.bool_)
        found[by_kind[places]] = True
        return found

    @cached_property
    def _by_kind(self) -> tuple[NDArray[np.int32], IntArray]:
        """The captures of all symbols, those of a kind together, and where each kind ends."""
        captures = np.arange(len(self._bounds) - 1, dtype=np.int32)
        order = np.argsort(self.code, kind="stable")
        return np.repeat(captures, np.diff(self._bounds))[order], np.cumsum(self.counts)


def kinds_of(columns: Columns) -> Kinds:
    """Return the kinds of columns, which are kept with them."""
    if __name__ not in columns.kept:
        columns.kept[__name__] = Kinds(columns)
    kept: Kinds = columns.kept[__name__]
    return kept


def _turns(cell: IntArray, runner: IntArray, bucket: IntArray) -> Costs:
    """Return what kinds of symbols cost where each cell is asked for: (K, cells)."""
    turned = angles(points_of(cell, runner, bucket / BUCKETS), MIDDLES)
    costs = np.rint(np.maximum(turned - FREE, 0) / WIDTH * UNIT)
    directed = KNOWN[cell][:, None] & KNOWN
    return np.where(directed, np.minimum(costs, MOST), MOST).astype(np.int16)


def costs_of(state: State, costs: Costs, batch: Batch, row: IntArray) -> Costs:
    """Return what rows (R,) cost at a state, of which `costs` (R,) are those of their kinds."""
    rows = batch.rows(state.members[0])
    if "change" in state.fits[0]:
        neither = WORD_KINDS["change"].codes["neither"]
        change = np.where(rows.change[row] < 0, neither, rows.change[row])
        wrong = ~np.isin(change, list(state.fits[0]["change"]))
        costs = np.minimum(costs + wrong * np.int16(CHANGE), np.maximum(costs, MOST))
    if state.length:
        start, stop = rows.start[row].astype(np.int64), rows.stop[row].astype(np.int64)
        lasts = batch.meets(rows.capture[row].astype(np.int64), stop - start, state.length)
        costs = np.where(lasts & (start < stop), costs, np.int16(NEVER))
    return np.where(rows.passing[row], np.int16(NEVER), costs) if state.manner == "at" else costs


@dataclass(frozen=True, slots=True)
class Allowance:
    """How much a match may differ from its pattern.

    Examples
    --------
    >>> from lanindex.search.fuzzy import Allowance
    >>> Allowance.read("2").of(5), Allowance.read("20%").of(7)
    (128, 64)
    """

    edits: Fraction  # in all, or as a share for each step but the first `CARRYING`
    share: bool = False

    @classmethod
    def read(cls, text: str) -> Allowance:
        """Return what ``2``, ``0.5`` or ``20%`` means; a `UsageError` where it is none of these."""
        number = text.strip().removesuffix("%")
        share = number != text.strip()
        if not number.replace(".", "", 1).isdecimal() or len(number) > 9:
            raise UsageError(f'"{text}" edits', wanted="a number of edits, 2, or a share, 20%")
        return cls(Fraction(number) / (100 if share else 1), share)

    def of(self, steps: int) -> int:
        """Return how much a pattern of so many steps may cost, in parts of an edit."""
        edits = self.edits * max(steps - CARRYING, 0) if self.share else self.edits
        return int(edits * UNIT)
