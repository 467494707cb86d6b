"""Programs → where a pattern begins and ends, in a block of captures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lanindex.search.automaton import Entry, Program, State
from lanindex.search.fast.arrows import begins
from lanindex.search.fast.block import Block
from lanindex.search.fast.events import Events
from lanindex.search.fast.ragged import Mask, Whole, best_of_each, in_order


@dataclass(slots=True, eq=False)
class Answers:
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
        (A, 2) the first symbols: rows in the block; -1: there is one only.
    """

    capture: Whole
    low: Whole
    high: Whole
    cost: Whole
    program: Whole
    parts: Whole
    rows: Whole

    def at(self, chosen: Whole | Mask) -> Answers:
        """Return some of them."""
        return Answers(*(getattr(self, name)[chosen] for name in _FIELDS))

    def arranged(self, order: Whole) -> Answers:
        """Return the same ones in another order, in which most may stand where they stood."""
        moved = np.flatnonzero(order != np.arange(len(order)))
        found = Answers(*(getattr(self, name).copy() for name in _FIELDS))
        for name in _FIELDS:
            getattr(found, name)[moved] = getattr(self, name)[order[moved]]
        return found

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.capture)


_FIELDS = ("capture", "low", "high", "cost", "program", "parts", "rows")


def joined(answers: list[Answers]) -> Answers:
    """Return several tables as one."""
    if not answers:
        none = np.empty(0, np.int64)
        return Answers(none, none, none, none, none, none, none.reshape(0, 2))
    if len(answers) == 1:
        return answers[0]
    return Answers(*(np.concatenate([getattr(it, name) for it in answers]) for name in _FIELDS))


def firsts(state: State, parts: list[tuple[str, ...]]) -> tuple[int, list[int]]:
    """Return the place of a state's parts in a list, where they are added, and their order."""
    order = sorted(range(len(state.members)), key=lambda it: state.members[it])
    key = tuple(state.members[it] for it in order)
    if key not in parts:
        parts.append(key)
    return parts.index(key), order


def roots(block: Block, program: Program, entry: Entry) -> Mask:
    """Tell at which events of its state a line may begin."""
    state = program.states[entry.state]
    events = block.events(state)
    fits = ~events.passing if state.manner != "via" else np.ones(len(events), bool)
    for arrow in entry.from_start:
        fits &= begins(block, state, events, arrow)
    return fits


def table(
    number: int,
    state: State,
    parts: list[tuple[str, ...]],
    events: Events,
    ends: tuple[Whole, Whole, Whole],
) -> Answers:
    """Return answers that begin at some events of a state, with low, high and cost of each."""
    place, order = firsts(state, parts)
    rows = np.full((len(events), 2), -1)
    for column, member in enumerate(order):
        rows[:, column] = events.first[member]
    many = len(events)
    return Answers(events.capture, *ends, np.full(many, number), np.full(many, place), rows)


def best(answers: Answers) -> Answers:
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


def _settled(answers: Answers) -> bool:
    """Tell whether answers are of one part, one from each place, and in order already."""
    if not len(answers):
        return True
    row, other = answers.rows.T
    once = (row[:-1] < row[1:]).all() and not (other >= 0).any()
    if not once or (answers.parts != answers.parts[0]).any():
        return False
    ordered: Mask = np.zeros(len(answers) - 1, bool)
    same = ~ordered
    for column in (answers.capture, answers.low, answers.high, answers.cost):
        before, behind = column[:-1], column[1:]
        ordered |= same & (before < behind)
        same &= before == behind
        if ordered.all():
            return True
    return bool((ordered | same).all())


def own_rows(
    answers: Answers, parts: list[tuple[str, ...]], bounds: Callable[[str], Whole]
) -> Answers:
    """Return answers whose rows are counted in their own captures.

    Parameters
    ----------
    answers : Answers
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


def _once(answers: Answers) -> bool:
    """Tell whether answers are in order of their places already, one from each."""
    if (answers.rows[:, 1] >= 0).any():
        return False
    part, row = np.diff(answers.parts), np.diff(answers.rows[:, 0])
    return bool(((part > 0) | ((part == 0) & (row > 0))).all())
