"""Where a pattern begins and ends, in a batch of captures: the best match from each beginning."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lanindex.search.automaton import State
from lanindex.search.match.arrays import FAR, BoolArray, IntArray, best_of_each, in_order, starts_of
from lanindex.search.match.scan import Events


def nearest(capture: IntArray, low: IntArray, high: IntArray) -> BoolArray:
    """Return which hits start last of those of a capture that end together."""
    best: BoolArray = np.zeros(len(low), bool)
    order = in_order((capture, high, -low))
    new = starts_of(capture[order]) | starts_of(high[order])
    best[order[new]] = True
    return best


def from_left(capture: IntArray, low: IntArray, high: IntArray) -> BoolArray:
    """Return which hits begin at or after the end of the one that stayed before them.

    Parameters
    ----------
    capture, low, high : ndarray
        (H,) in order of capture, start, end.
    """
    kept: BoolArray = np.zeros(len(low), bool)
    after = np.searchsorted(capture * FAR + low, capture * FAR + high)
    here = np.flatnonzero(starts_of(capture)) if len(low) else after
    while len(here):
        kept[here] = True
        behind = after[here]
        inside = behind < len(low)
        behind, here = behind[inside], here[inside]
        here = behind[capture[behind] == capture[here]]
    return kept


@dataclass(slots=True, eq=False)
class HitTable:
    """Places where a pattern begins, with how it ends best.

    Attributes
    ----------
    capture, low, high : ndarray
        (A,) where, and the frames of it.
    cost : ndarray
        (A,) what is missing to a fit of 1, in thousandths; where that is not known ``~missing``
        of as much as is missing at least.
    program : ndarray
        (A,) which one answers.
    parts : ndarray
        (A,) which parts the first symbols are of: a place in the list of `Finder`.
    rows : ndarray
        (A, 2) the first symbols: rows in the batch; -1: there is one only.
    """

    capture: IntArray
    low: IntArray
    high: IntArray
    cost: IntArray
    program: IntArray
    parts: IntArray
    rows: IntArray

    def at(self, chosen: IntArray | BoolArray) -> HitTable:
        """Return some of them."""
        return HitTable(*(getattr(self, name)[chosen] for name in _FIELDS))

    def arranged(self, order: IntArray) -> HitTable:
        """Return the same ones in another order, in which most may stand where they stood."""
        moved = np.flatnonzero(order != np.arange(len(order)))
        found = HitTable(*(getattr(self, name).copy() for name in _FIELDS))
        for name in _FIELDS:
            getattr(found, name)[moved] = getattr(self, name)[order[moved]]
        return found

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.capture)


_FIELDS = ("capture", "low", "high", "cost", "program", "parts", "rows")


def joined(answers: list[HitTable]) -> HitTable:
    """Return several tables as one."""
    if not answers:
        none = np.empty(0, np.int64)
        return HitTable(none, none, none, none, none, none, none.reshape(0, 2))
    if len(answers) == 1:
        return answers[0]
    return HitTable(*(np.concatenate([getattr(it, name) for it in answers]) for name in _FIELDS))


def firsts(state: State, parts: list[tuple[str, ...]]) -> tuple[int, list[int]]:
    """Return the place of a state's parts in a list, where they are added, and their order."""
    order = sorted(range(len(state.members)), key=lambda it: state.members[it])
    key = tuple(state.members[it] for it in order)
    if key not in parts:
        parts.append(key)
    return parts.index(key), order


def table(
    number: int,
    state: State,
    parts: list[tuple[str, ...]],
    events: Events,
    ends: tuple[IntArray, IntArray, IntArray],
) -> HitTable:
    """Return answers that begin at some events of a state, with low, high and cost of each."""
    place, order = firsts(state, parts)
    rows = np.full((len(events), 2), -1)
    for column, member in enumerate(order):
        rows[:, column] = events.first[member]
    many = len(events)
    return HitTable(events.capture, *ends, np.full(many, number), np.full(many, place), rows)


def best(answers: HitTable) -> HitTable:
    """Return the best answer from each place, in order of capture, start, end and fit.

    The best one ends first; of these it begins last, and of those it shows most clearly.
    """
    if _settled(answers):
        return answers
    if _once(answers):
        columns = (answers.capture, answers.low, answers.high, answers.cost)
        return answers.arranged(in_order(columns))
    keys = (answers.parts, answers.rows[:, 0], answers.rows[:, 1])
    chosen = best_of_each(keys, (answers.high, -answers.low, answers.cost))
    first = best_of_each(keys, (np.arange(len(answers)),))
    found = answers.at(chosen)
    order = in_order((found.capture, found.low, found.high, found.cost, first))
    return answers.at(chosen[order])


def _settled(answers: HitTable) -> bool:
    """Tell whether answers are of one part, one from each place, and in order already."""
    if not len(answers):
        return True
    row, other = answers.rows.T
    once = (row[:-1] < row[1:]).all() and not (other >= 0).any()
    if not once or (answers.parts != answers.parts[0]).any():
        return False
    ordered: BoolArray = np.zeros(len(answers) - 1, bool)
    same = ~ordered
    for column in (answers.capture, answers.low, answers.high, answers.cost):
        before, behind = column[:-1], column[1:]
        ordered |= same & (before < behind)
        same &= before == behind
        if ordered.all():
            return True
    return bool((ordered | same).all())


def own_rows(
    answers: HitTable, parts: list[tuple[str, ...]], bounds: Callable[[str], IntArray]
) -> HitTable:
    """Return answers whose rows are counted in their own captures.

    Parameters
    ----------
    answers : HitTable
        Whose rows are counted over all captures.
    parts : list of tuple of str
        Of `Finder`.
    bounds : callable
        Gives, of a part, the first row of each capture.
    """
    rows = answers.rows.copy()
    for place, members in enumerate(parts):
        own = np.flatnonzero(answers.parts == place) if len(parts) > 1 else slice(None)
        for member, part in enumerate(members if len(answers.parts[own]) else ()):
            rows[own, member] -= bounds(part)[answers.capture[own]]
    return replace(answers, rows=rows)


def _once(answers: HitTable) -> bool:
    """Tell whether answers are in order of their places already, one from each."""
    if (answers.rows[:, 1] >= 0).any():
        return False
    part, row = np.diff(answers.parts), np.diff(answers.rows[:, 0])
    return bool(((part > 0) | ((part == 0) & (row > 0))).all())
