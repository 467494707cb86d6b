"""What ways through a program remember, as columns: all that their future depends on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lanindex.search.fast import budget, taken
from lanindex.search.fast.ragged import (
    FAR,
    Mask,
    Numbers,
    Whole,
    in_order,
    once,
    spread,
    starts_of,
)
from lanindex.search.fast.taken import Taken, filled

ROOT, EVENT, GROUPS = range(3)
"""What the first columns are: where a way began, at which event it stands, and then, of the whole
line and of each bracket that is open, the inner ones last, three each:"""

START, LOW, BEYOND = range(3)
"""Where it began; where the hull of all that matched since begins; and where that ends, if what is
beside goes on for longer than the line, else 0."""


@dataclass(slots=True, eq=False)
class Memory:
    """Ways, each with what it remembers.

    Attributes
    ----------
    columns : ndarray
        (W, N) int64: `ROOT`, `EVENT`, three a group, the frames of each step, if they are asked
        for, and what is noted of labels.
    taken : Taken
        What they have taken that another line could want.
    owed : ndarray
        (M, N) int64: matches of lines that must not happen, from which they still have to take
        something; filled up with `FAR`.
    came : ndarray
        (N,) int64: the node that they come from, -1: they begin there.
    link : ndarray
        (N,) int64: what joined since that node, a number in `Joins`; -1: nothing.
    """

    columns: Whole
    taken: Taken
    owed: Whole
    came: Whole
    link: Whole

    def __len__(self) -> int:
        """Return how many there are."""
        return int(self.columns.shape[1])

    def at(self, chosen: Numbers) -> Memory:
        """Return some of them."""
        return Memory(
            *(self.columns[:, chosen], self.taken.at(chosen), self.owed[:, chosen]),
            *(self.came[chosen], self.link[chosen]),
        )

    def alike(self) -> tuple[Memory, Whole]:
        """Return one of those that remember the same, and for each which of those it is."""
        root, event = self.columns[ROOT], self.columns[EVENT]
        if (np.diff(root) + (np.diff(event) > 0) * (np.diff(root) == 0) > 0).all():
            return self, np.arange(len(self))
        chosen, which = distinct([*self.columns, *self.rest()], len(self))
        return self.at(chosen), which

    def rest(self) -> list[Whole]:
        """Return what they remember besides the columns."""
        return [*self.taken.first, *self.taken.last, *self.owed]


def distinct(keys: list[Whole], many: int) -> tuple[Whole, Whole]:
    """Return the places of different columns, and for each column which of those it is."""
    keys = telling(keys)
    if not keys:
        return np.arange(min(many, 1)), np.zeros(many, np.int64)
    order = in_order(tuple(keys))
    new = np.zeros(many, bool)
    for key in keys:
        new |= starts_of(key[order])
    which = np.empty(many, np.int64)
    which[order] = np.cumsum(new) - 1
    return order[new], which


def telling(keys: list[Whole]) -> list[Whole]:
    """Return the columns, of some rows, that tell rows apart, with small numbers for `FAR`."""
    found: list[Whole] = []
    for key in keys:
        if (key != key[:1]).any() and not any(np.array_equal(key, it) for it in found):
            found.append(key)
    return [np.where(it < FAR, it, 1 + (it * (it < FAR)).max()) for it in found]


def beginning(columns: Whole) -> Memory:
    """Return ways that have just begun."""
    many = columns.shape[1]
    none = np.empty((0, many), np.int64)
    return Memory(columns, taken.nothing(many), none, np.full(many, -1), np.full(many, -1))


def carry_out(columns: Whole, own: int, end: Whole) -> None:
    """Add the hull of a group that closes to those around it."""
    low, beyond = columns[own + LOW], columns[own + BEYOND]
    for outer in range(GROUPS, own, 3):
        lows, beyonds = columns[outer + LOW], columns[outer + BEYOND]
        np.minimum(lows, low, out=lows)
        np.maximum(beyonds, np.where(beyond > end, beyond, 0), out=beyonds)
    columns[own : own + 3] = -1


def together(tables: list[Memory]) -> Memory:
    """Return the ways of several tables as one."""
    if len(tables) == 1:
        return tables[0]
    return Memory(
        np.concatenate([it.columns for it in tables], axis=1),
        taken.beside_each_other([it.taken for it in tables]),
        filled([it.owed for it in tables]),
        np.concatenate([it.came for it in tables]),
        np.concatenate([it.link for it in tables]),
    )


class Nodes:
    """Which node of a walk comes from which, to tell what goes on in what."""

    def __init__(self) -> None:
        self.many = 0
        self._before: list[Whole] = []
        self._after: list[Whole] = []
        self._edges: tuple[Whole, Whole] | None = None

    def add(self, many: int, came: Whole, which: Whole) -> Whole:
        """Add nodes with those that they come from, and return their numbers."""
        own = np.arange(self.many, self.many + many)
        self.many, self._edges = self.many + many, None
        fits = came >= 0
        self._before.append(came[fits])
        self._after.append(own[which[fits]])
        return own

    def leading_to(self, nodes: Whole) -> Mask:
        """Return which nodes are some of these, or go on in one of them, (nodes,) bool."""
        found = np.zeros(self.many, bool)
        before, bounds = self._backwards()
        todo = nodes
        while len(todo):
            found[todo] = True
            _, place = spread(bounds[todo], bounds[todo + 1])
            todo = before[place]
            todo = once(todo[~found[todo]])
        return found

    def _backwards(self) -> tuple[Whole, Whole]:
        """Return the nodes that each one comes from, one after the other, and their bounds."""
        if self._edges is None:
            before = np.concatenate(self._before or [np.empty(0, np.int64)])
            after = np.concatenate(self._after or [np.empty(0, np.int64)])
            order = np.argsort(after, kind="stable")
            bounds = np.searchsorted(after[order], np.arange(self.many + 1))
            self._edges = before[order], bounds
        return self._edges

    def behind(self, line: Whole, node: Whole) -> Mask:
        """Tell, of nodes of some lines, which go on in another one of the same line, (N,) bool.

        Parameters
        ----------
        line, node : ndarray
            (N,) int64; node -1: none.

        Raises
        ------
        TooMuch
            Where there are more pairs of a line and a node than the budget allows.
        """
        before, bounds = self._backwards()
        lines, own = np.unique(line, return_inverse=True)
        if len(lines) * self.many > budget.rows(8):
            raise budget.TooMuch
        behind = np.zeros(len(lines) * self.many, bool)
        todo = own * self.many + node
        while len(todo):
            base, last = todo - todo % max(self.many, 1), todo % max(self.many, 1)
            one, place = spread(bounds[last], bounds[last + 1])
            todo = base[one] + before[place]
            todo = once(todo[~behind[todo]])
            behind[todo] = True
        found: Mask = behind[own * self.many + node]
        return found
