"""Lines of one part, each step a movement: answered from planes of all its rows at once.

Most of what people ask is such a chain. Where each arrow leads over a few symbols at most, the
chain is a few ways in which its steps lie so many symbols apart, and each way a few operations on
planes. What lies further apart is cut there, and what passing symbols match looked at one by one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise, product
from types import ModuleType

import numpy as np

from lanindex.model.columns import THOUSANDTHS, Columns
from lanindex.search import compiled
from lanindex.search.automaton import Program
from lanindex.search.fast.answers import Answers
from lanindex.search.fast.arrows import NONE
from lanindex.search.fast.lines import cost_of, end_of, value_of, with_cost
from lanindex.search.fast.links import Chain, Links
from lanindex.search.fast.planes import (
    GOES_ON,
    WORD,
    Counted,
    Part,
    holds,
    packed,
    part_of,
    places,
)
from lanindex.search.fast.ragged import Whole, smallest_in
from lanindex.search.language.query import Arrow

MOST_CHAINS = 16
"""Ways through a program that are gone one by one."""

MOST_STEPS = 64
"""Steps of a program that is taken apart into chains."""

MOST_WAYS = 32
"""Ways for a chain's steps to lie apart that are tried one by one."""

CHEAP = 4
"""By how many powers of two a row costs less here than one that is walked through."""

FEW = 32
"""What is less than one in so many rows is looked up, not counted."""

AT_ONCE = 1 << 14
"""Rows of which it is told at once what lies beyond, if each wants a few arrays for it."""


def chains_of(program: Program) -> list[Chain] | None:
    """Return all ways through a program, None if it is no bundle of chains."""
    states = program.states
    if program.open_ended or program.brackets or program.whole.companions:
        return None
    if len(states) > MOST_STEPS:
        return None
    plain = all(
        state.manner in ("move", "via")
        and state.members == states[0].members
        and not (state.length or state.near or state.beside_cells)
        for state in states
    )
    through = any(states[it.state].manner == "via" for it in program.entries)
    if not plain or len(states[0].members) > 1 or (through and len(states) > 1):
        return None
    chains: list[Chain] = []
    for entry in program.entries:
        if entry.from_start or not _follow(program, [entry.state], [], chains):
            return None
    return chains


def _follow(program: Program, way: list[int], arrows: list[Arrow], chains: list[Chain]) -> bool:
    """Add all chains that go on from a way; tell whether there are few, and nothing else."""
    leaving = program.exits[way[-1]]
    if leaving:
        chains.append(Chain(tuple(program.states[it] for it in way), tuple(arrows)))
    if len(chains) > MOST_CHAINS or any(it.to_end for it in leaving):
        return False
    for edge in program.edges[way[-1]]:
        state = edge.entry.state
        if state in way or edge.entry.from_start or edge.arrow.length:
            return False
        if not _follow(program, [*way, state], [*arrows, edge.arrow], chains):
            return False
    return True


@dataclass(frozen=True, slots=True)
class Way:
    """Where the steps of a chain lie, in symbols shown from the first."""

    links: Links
    offsets: tuple[int, ...]


def table(columns: Columns, chains: list[Chain], program: int, place: int) -> Answers:
    """Return the answers of a program in all captures, rows counted over all of them.

    Parameters
    ----------
    columns : Columns
        Of its part.
    chains : list of Chain
        All its ways.
    program, place : int
        Which program it is, and where its part stands in the list of `Finder`.
    """
    part = part_of(columns)
    rows, values = answers(part, chains)
    same = np.broadcast_to(np.array([[program], [place]]), (2, len(rows)))
    if fast := compiled.chosen("chains", 0):
        captures = part.filled[0]
        filled = captures if len(captures) < len(columns.bounds) - 1 else captures[:0]
        entered = part.entered.plane
        where, *times, symbols = fast.told(rows, values, part.near, entered, filled, part.start)
        low, high, cost = times
    else:
        where, low = part.captures(rows), part.start[rows].astype(np.int64)
        high, cost = end_of(values), cost_of(values)
        symbols = np.stack((rows, np.full(len(rows), -1)), axis=1)
    return Answers(where, low, high, cost, same[0], same[1], symbols)


def answers(part: Part, chains: list[Chain]) -> tuple[Whole, Whole]:
    """Return where one of some chains begins, and how it ends best.

    Parameters
    ----------
    part : Part
        Of their states.
    chains : list of Chain
        Which.

    Returns
    -------
    ndarray, ndarray
        Rows, growing, and values as from `lines.value_of`.
    """
    ways: list[Way] = []
    found: list[tuple[Whole, Whole]] = []
    for chain in chains:
        links = Links(part, chain)
        offsets = _offsets(chain.arrows)
        passing = any(len(links.passed(number)) for number in range(len(chain.states)))
        linked = [tuple(range(len(chain.states)))]
        if offsets is None or (passing and offsets != linked):
            found.append(_cut(links))
            continue
        ways += [Way(links, it) for it in offsets]
        if passing:
            rows = links.through(0, len(chain.states) - 1)
            found.append(_valued(part, rows, _ending(part, rows[-1])))
    if ways:
        ways.sort(key=lambda way: way.offsets[-1])
        fast = compiled.chosen("chains", len(part) >> CHEAP) if len(ways) <= WORD else None
        found.append(_compiled(fast, part, ways) if fast else _together(part, ways))
    if not found:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    if len(found) == 1:
        return _best(*found[0])
    return _best(*(np.concatenate(one) for one in zip(*found, strict=True)))


def _offsets(arrows: tuple[Arrow, ...]) -> list[tuple[int, ...]] | None:
    """Return how far the steps behind some arrows may lie from the first; None: too many ways."""
    bounds = [arrow.bounds for arrow in arrows]
    if any(most is None or most >= MOST_WAYS for _, most in bounds):
        return None
    steps = [range(least + 1, (most or 0) + 2) for least, most in bounds]
    if np.prod([len(it) for it in steps], dtype=float) > MOST_WAYS:
        return None
    return [tuple(np.cumsum((0, *way)).tolist()) for way in product(*steps)]


def _together(part: Part, ways: list[Way]) -> tuple[Whole, Whole]:
    """Return where ways begin, and how the one that ends first does: with the best fit, of some."""
    planes = [way.links.apart(0, way.offsets) for way in ways]
    every = reduce(np.bitwise_or, planes)
    ranks = places(every)
    values = np.full(len(ranks), NONE)
    shorter = done = np.zeros_like(every)
    for number, (way, plane) in enumerate(zip(ways, planes, strict=True)):
        if number and way.offsets[-1] > ways[number - 1].offsets[-1]:
            shorter = done
        done = done | plane
        mine: Whole | slice = slice(None)
        if len(ways) > 1:
            mine = np.flatnonzero(holds(plane & ~shorter, ranks))
        rows = [part.rows(ranks[mine] + offset) for offset in way.offsets]
        values[mine] = np.minimum(values[mine], _valued(part, rows, _ending(part, rows[-1]))[1])
    return part.rows(ranks), values


def _compiled(fast: ModuleType, part: Part, ways: list[Way]) -> tuple[Whole, Whole]:
    """Return the same as `_together`, compiled."""
    steps, groups, codes = [0], [0], list[int]()
    longest = max(len(way.offsets) for way in ways)
    apart, own, placed = [], [], dict[tuple[int, int], int]()
    for way in ways:
        last = len(way.offsets) - 1
        numbers = [*range(last), *[last] * (longest - last)]
        for number in numbers:
            key = id(way.links), number
            if key not in placed:
                placed[key] = len(placed)
                for group in way.links.groups(number):
                    codes += group
                    groups.append(len(codes))
                steps.append(len(groups) - 1)
        apart.append([way.offsets[number] for number in numbers])
        own.append([placed[id(way.links), number] for number in numbers])
    lists = (np.array(it, np.int64) for it in (steps, groups, codes, apart, own))
    goes_on, shown = (
        part.place(*GOES_ON),
        np.empty(0, np.int32) if part.shown is None else part.shown,
    )
    tables = *lists, shown
    ranks, values = fast.together(part.store, goes_on, *tables, part.margin, part.stop)
    return part.rows(ranks), values


def _ending(part: Part, rows: Whole) -> Whole:
    """Return the values of ending at some rows."""
    return value_of(part.stop[rows].astype(np.int64), part.cost(rows))


def _valued(part: Part, rows: list[Whole], values: Whole) -> tuple[Whole, Whole]:
    """Return where ways begin, and their values, of those from the last step on: all steps pay."""
    if len(rows) > 1:
        margin = part.margin[rows[0]]
        for step in rows[1:-1]:
            margin = np.minimum(margin, part.margin[step])
        values = with_cost(values, THOUSANDTHS - margin.astype(np.int64))
    return rows[0], values


def _cut(links: Links) -> tuple[Whole, Whole]:
    """Return where a chain begins, and how it ends best: cut where it leads further on."""
    part, arrows, steps = links.part, links.chain.arrows, len(links.chain.states)
    cuts = [0, *(it + 1 for it, arrow in enumerate(arrows) if arrow.later), steps]
    begins = values = np.empty(0, np.int64)
    for first, behind in reversed(list(pairwise(cuts))):
        rows = links.linked(first, behind - 1)
        if behind == steps:
            own = _ending(part, rows[-1])
        else:
            some, own = _beyond(part, rows[-1], arrows[behind - 1], begins, values)
            rows = [it[some] for it in rows]
            own = with_cost(own, part.cost(rows[-1]))
        begins, values = _best(*_valued(part, rows, own))
    return begins, values


def _beyond(
    part: Part, rows: Whole, arrow: Arrow, begins: Whole, values: Whole
) -> tuple[Whole, Whole]:
    """Return the places of rows that ``...`` leads on from, and the best values it leads to."""
    before = _before(part, begins, len(rows))
    growing = _growing(part, begins, values)
    at_once = AT_ONCE if growing else len(rows)
    found = [(rows[:0], rows[:0])]
    for first in range(0, len(rows), max(at_once, 1)):
        low, high = map(before, _reached(part, rows[first : first + at_once], arrow))
        some = np.flatnonzero(low < high)
        low, high = low[some], high[some]
        best = values[low] if growing else smallest_in(values, low, high, NONE)
        found.append((some + first, best))
    places, best = (np.concatenate(one) for one in zip(*found, strict=True))
    return places, best


def _before(part: Part, begins: Whole, many: int) -> Callable[[Whole], Whole]:
    """Return what tells how many of some rows come before others, if it is asked of so many."""
    if FEW * many < len(part):
        return lambda rows: np.searchsorted(begins, rows)
    there = np.zeros(len(part) + 1, bool)
    there[begins] = True
    return Counted(packed(there)).before


def _growing(part: Part, rows: Whole, values: Whole) -> bool:
    """Tell whether of the rows of a stretch the first one always has the smallest value."""
    falling = np.flatnonzero(np.diff(values) < 0)
    same = part.behind(rows[falling]) == part.behind(rows[falling + 1])
    return not same.any()


def _best(rows: Whole, values: Whole) -> tuple[Whole, Whole]:
    """Return rows once, in order, each with its smallest value."""
    if not (rows[1:] > rows[:-1]).all():
        order = np.argsort(rows, kind="stable")
        rows, values = rows[order], values[order]
        firsts = np.flatnonzero(np.diff(rows, prepend=-1))
        values = np.minimum.reduceat(values, firsts) if len(rows) else values
        rows = rows[firsts]
    return rows, values


def _reached(part: Part, rows: Whole, arrow: Arrow) -> tuple[Whole, Whole]:
    """Return to which rows ``...`` leads from some: from one up to, not including, another."""
    low, high = rows + 1, part.behind(rows)
    if not arrow.skips:
        return low, high
    least, most = arrow.skips.bounds
    behind, many = part.ranks(rows + 1), len(part.seen)
    if least:
        skipped = part.rows(np.minimum(behind + least, many) - 1)
        low = np.where(behind + least <= many, skipped + 1, high)
    if most is not None:
        last = part.rows(np.minimum(behind + most, many - 1))
        high = np.where(behind + most < many, np.minimum(high, last + 1), high)
    return np.minimum(low, high), high
