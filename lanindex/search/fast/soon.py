"""Ways that end soon are looked for first: such a one is better than any that goes on for longer.

Else a line that may wander through a capture would be followed from each beginning to each of its
ends: the square of its symbols.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from lanindex.search.automaton import Program
from lanindex.search.fast.block import Block
from lanindex.search.fast.ragged import Mask, Whole
from lanindex.search.language.times import Length, Time

SOON = 4
"""Seconds that are soon; the next are so many times as many."""


def widening(block: Block, left: list[Mask], soon: int | None) -> Iterator[Whole | None]:
    """Yield in how many frames ways are looked for, by capture; at last, or at once, in all.

    It ends where none is `left`, as `settled` has it, to be looked for.
    """
    if soon:
        within = block.bounds(Length("<=", Time(Fraction(soon), "s")))[1]
        most = int(block.frames.max(initial=0))
        while int(within.min(initial=most)) < most:
            yield within
            if not any(map(np.any, left)):
                return
            within = soon * within
    yield None


def settled(
    block: Block,
    program: Program,
    left: list[Mask],
    within: Whole | None,
    ways: tuple[Whole, Whole, Whole],
) -> Whole:
    """Return the places of the ways that are the best ones; `left` loses what is settled by now.

    Parameters
    ----------
    block : Block
        Where.
    program : Program
        The line.
    left : list of ndarray
        By entry, from which events of its state ways were looked for, (N,) bool.
    within : ndarray or None
        (captures,) int64: in how many frames; in no more than a capture has nothing else is found.
    ways : tuple of ndarray
        Entry, event and end of the best of each beginning, of those that were found.
    """
    entry, root, high = ways
    best = np.ones(len(entry), bool)
    for place, (way_in, fits) in enumerate(zip(program.entries, left, strict=True)):
        own = np.flatnonzero(entry == place)
        if within is not None:
            events = block.events(program.states[way_in.state])
            frames = within[events.capture]
            best[own] = high[own] - events.start[root[own]] <= frames[root[own]]
            fits &= frames < block.frames[events.capture]
        fits[root[own[best[own]]]] = False
    return np.flatnonzero(best)
