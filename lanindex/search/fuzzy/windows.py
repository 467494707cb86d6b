"""Which symbols need to be aligned at all: those near some that cost little.

Of a match that may cost so much, one step of some few must be there for its share of that: rows
where none is are left out, and of the others only what a match around them can cover is aligned.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import ranges
from lanindex.search import compiled
from lanindex.search.fuzzy.costs import Kinds
from lanindex.search.fuzzy.net import MISSING, SKIPPED, Net

Whole = NDArray[np.int64]
Mask = NDArray[np.bool_]
Codes = NDArray[np.unsignedinteger[Any]]
Costs = NDArray[np.int16]

TILE = 512
"""Rows of a long track that are aligned as a stretch of their own, where matches are short."""

BLOCK = 1 << 18
"""Rows that are aligned at once."""

FEW = 4
"""How many times its rows a part must have, that windows around them are worth it."""


class Windows(NamedTuple):
    """Stretches of rows to be aligned, each in one capture.

    Attributes
    ----------
    low, high : ndarray
        (N,) rows, half-open.
    take : ndarray
        (N,) the first row of each whose matches count; those before have been looked at.
    """

    low: Whole
    take: Whole
    high: Whole

    def blocks(self) -> Iterator[Windows]:
        """Yield them by so many as have about `BLOCK` rows."""
        sizes = np.cumsum(self.high - self.low)
        first = 0
        while first < len(sizes):
            done = int(sizes[first - 1]) if first else 0
            last = max(int(np.searchsorted(sizes, done + BLOCK, side="right")), first + 1)
            yield Windows(*(column[first:last] for column in self))
            first = last


class Seeds(NamedTuple):
    """Symbols of which a match has one.

    Attributes
    ----------
    kinds : ndarray
        (K,) which kinds they are of.
    steps : tuple of int
        As which step of the line it is there; none: as any.
    """

    kinds: Mask
    steps: tuple[int, ...]


def wanted(net: Net, tables: list[Costs], counts: Whole, most: int) -> Seeds:
    """Return what a match must have one of.

    Parameters
    ----------
    net : Net
        The line.
    tables : list of ndarray
        By step: (K,) what each kind costs at least.
    counts : ndarray
        (K,) how many symbols of each kind there are.
    most : int
        What a match may cost.
    """
    steps = net.unavoidable
    choices = [Seeds(np.any([table <= most for table in tables], axis=0), ())]
    for number in range(most // MISSING + 1, len(steps) + 1):
        # were each of so many dearer than its share, or missing, all were dearer than they may
        fits = {step: tables[step] <= most // number for step in steps}
        rarest = sorted(steps, key=lambda it: int(counts[fits[it]].sum()))[:number]
        choices.append(Seeds(np.any([fits[it] for it in rarest], axis=0), tuple(rarest)))
    return min(choices, key=lambda it: int(counts[it.kinds].sum()))


class Beside(NamedTuple):
    """What the two rows next to a step, before it or behind it, cost at least.

    Attributes
    ----------
    near, far : ndarray
        (K,) int16: what each kind costs in the nearer row, and in the one beyond.
    instead : ndarray
        (K,) int16: the same of the one beyond where the nearer one is passing, and matches nothing.
    most : int
        What both cost at most.
    """

    near: Costs
    far: Costs
    instead: Costs
    most: int

    def least(self, kinds: Kinds, one: Codes, two: Codes) -> Costs:
        """Return what rows cost at least, by the kinds of both."""
        instead = np.where(kinds.passing[one], self.instead[two], np.int16(self.most))
        least: Costs = np.minimum(self.near[one] + self.far[two], instead)
        return least


class Role(NamedTuple):
    """A seed as a step of a line: what each kind costs, and what the rows beside it do."""

    own: Costs
    before: Beside
    behind: Beside


def roles(net: Net, tables: list[Costs], kinds: Kinds, seeds: Seeds, most: int) -> list[Role]:
    """Return as what seeds can be in a match, where the rows beside them tell whether they are.

    A match costs as much at least as the seed and the two rows before it and behind it: as the
    steps next to that one, or what it costs to pass over a symbol, whichever is less.
    """
    found = [
        Role(tables[step], *(_beside(net, tables, kinds, step, way) for way in (-1, 1)))
        for step in seeds.steps
    ]
    return found if all(max(it.before.most, it.behind.most) > most for it in found) else []


def likely(roles: list[Role], kinds: Kinds, seeds: Mask, most: int) -> Whole:
    """Return the rows of some kinds that can be in a match as one of some roles, growing."""
    fast = compiled.chosen("fuzzy", int(kinds.counts[seeds].sum()) * len(roles))
    if not fast or not kinds.by_kind_for(seeds):
        rows = kinds.where(seeds)
    else:
        rows = _between(fast, roles, kinds, seeds, most)
    last = len(kinds.code) - 1
    near = [kinds.code[np.clip(rows + away, 0, last)] for away in (-2, -1, 0, 1, 2)]
    fits = np.zeros(len(rows), np.bool_)
    for role in roles:
        before = role.before.least(kinds, near[1], near[0])
        fits |= role.own[near[2]] + before + role.behind.least(kinds, near[3], near[4]) <= most
    return rows[fits]


def _between(fast: ModuleType, roles: list[Role], kinds: Kinds, seeds: Mask, most: int) -> Whole:
    """Return of these rows, growing, those beside which none is that is too dear by itself."""
    held = kinds.by_kind, kinds.ends, kinds.counts, kinds.passed
    found = []
    for own, *sides in roles:
        fits = np.array([[it.near for it in sides], [it.far for it in sides]]) <= most
        narrow = (np.array([it.most for it in sides]) > most) & ~fits.all(axis=2)
        fits[1] &= ~kinds.passing  # those are let through anyway
        narrow &= FEW * (fits @ kinds.counts) < len(kinds.code)
        found.append(fast.between(seeds & (own <= most), *fits, narrow, *held))
    return np.unique(np.concatenate(found)) if len(found) > 1 else found[0]


def _beside(net: Net, tables: list[Costs], kinds: Kinds, step: int, way: int) -> Beside:
    ends = [min(costs) for costs in zip(*(net.exit if way > 0 else net.entry), strict=True)]
    edges = [edge if way > 0 else (edge[1], edge[0], edge[2]) for edge in net.edges]

    def after(steps: set[int]) -> tuple[set[int], Costs, int]:
        """Return the steps next to some, what each kind costs as one of them, and the most."""
        onto = {(there, later) for here, there, later in edges if here in steps}
        most = min([SKIPPED, *(ends[it] for it in steps)])
        most = 0 if any(later for _, later in onto) else most
        fits = [tables[it] for it, _ in onto]
        costs = np.min([np.full(len(kinds.counts), most, np.int16), *fits], axis=0)
        return {it for it, _ in onto}, costs, most

    steps, near, most = after({step})
    _, far, _ = after(steps)
    nothing = np.int16(0)
    far, instead = (np.where(kinds.passing, nothing, it) for it in (far, near))
    return Beside(near, far, instead, most)


def around(
    kinds: Kinds, rows: Whole, able: Mask, net: Net, most: int, whole: bool = False
) -> Windows:
    """Return the windows that hold every match that covers one of some rows.

    Parameters
    ----------
    kinds : Kinds
        Of the part.
    rows : ndarray
        (N,) int64, growing.
    able : ndarray
        (K,) which kinds may match any of the steps.
    net : Net
        The line.
    most : int
        What a match may cost.
    whole : bool
        Whether the rows are beginnings, and the windows whole stretches.
    """
    if whole or net.reach(most) is None:
        begins = kinds.stretches
        stretch = np.unique(np.searchsorted(begins, rows, side="right") - 1)
        return tiled(kinds, begins[stretch], begins[stretch + 1], net, most)
    low = _away(kinds, rows, able, -1, net, most)
    high = _away(kinds, rows, able, 1, net, most) + 1
    long = high - low >= len(net.unavoidable) - most // MISSING
    low, high = low[long], high[long]
    first = np.flatnonzero(np.append(True, low[1:] >= high[:-1])[: len(low)])
    last = np.append(first[1:], len(low))[: len(first)] - 1
    return tiled(kinds, low[first], high[last], net, most)


def tiled(kinds: Kinds, low: Whole, high: Whole, net: Net, most: int) -> Windows:
    """Return windows of which none is long, where matches are short."""
    if net.reach(most) is None or not (high - low > 2 * TILE).any():
        return Windows(low, low, high)
    pieces = np.maximum((high - low + TILE - 1) // TILE, 1)
    begins = np.repeat(low, pieces)
    first = np.cumsum(pieces) - pieces
    take = begins + (np.arange(len(begins)) - np.repeat(first, pieces)) * TILE
    before = take > begins
    back = take.copy()
    any_kind = np.ones(len(kinds.counts), np.bool_)
    back[before] = _away(kinds, take[before], any_kind, -1, net, most)
    return Windows(back, take, np.minimum(take + TILE, np.repeat(high, pieces)))


def _away(kinds: Kinds, rows: Whole, able: Mask, step: int, net: Net, most: int) -> Whole:
    """Return the last rows, up or down, that a match can reach from some."""
    shown = ~kinds.passing
    skipped = shown & ~able
    reach = net.reach(most)
    assert reach is not None
    there = rows.copy()
    left, spare = np.full(len(rows), reach), np.full(len(rows), most // SKIPPED)
    going = np.arange(len(rows))
    while len(going):
        here = there[going]
        inside = ~kinds.begins[here + max(step, 0)]
        going, further = going[inside], here[inside] + step
        code = kinds.code[further]
        left[going] -= shown[code]
        spare[going] -= skipped[code]
        inside = (left[going] >= 0) & (spare[going] >= 0)
        going = going[inside]
        there[going] = further[inside]
    return there


def spread(windows: Windows) -> tuple[Whole, Whole, Mask]:
    """Return the rows of windows, where each begins among them, and which of them count."""
    bounds, rows = ranges(windows.low, windows.high)
    return rows, bounds[:-1], rows >= np.repeat(windows.take, windows.high - windows.low)
