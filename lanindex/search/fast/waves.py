"""Ways at states that lead to each other, in order of time: wave by wave."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lanindex.search.automaton import Program
from lanindex.search.fast.block import Block
from lanindex.search.fast.memory import Memory
from lanindex.search.fast.ragged import Whole, starts_of


def ranks_of(block: Block, program: Program, states: list[int]) -> dict[int, Whole]:
    """Return the order of time of the events of some states in their captures."""
    events = [block.events(program.states[state]) for state in states]
    capture, end = (
        np.concatenate([getattr(it, name) for it in events]) for name in ("capture", "end")
    )
    row = np.concatenate([it.last[0] for it in events])
    order = np.lexsort((row, end, capture))
    new = starts_of(capture[order]) | starts_of(end[order]) | starts_of(row[order])
    dense = np.cumsum(new)
    first = np.searchsorted(capture[order], capture[order])
    ranks = np.empty(len(order), np.int64)
    ranks[order] = dense - dense[first] if len(order) else dense
    bounds = np.cumsum([0, *(len(it) for it in events)])
    return {state: ranks[bounds[place] : bounds[place + 1]] for place, state in enumerate(states)}


def by_rank(ranks: Whole, rows: Memory) -> Iterator[tuple[int, Memory]]:
    """Yield ways by their ranks, those of the same rank together."""
    order = np.argsort(ranks, kind="stable")
    starts = np.flatnonzero(starts_of(ranks[order]))
    for own in np.split(order, starts[1:]) if len(order) else ():
        yield int(ranks[own[0]]), rows.at(own)
