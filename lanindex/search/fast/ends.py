"""Ends of ways that remember: with the frames of them, and what they remember."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lanindex.search.automaton import Program
from lanindex.search.fast.lines import cost_of, end_of
from lanindex.search.fast.memory import BEYOND, EVENT, GROUPS, LOW, ROOT, START, Memory, together
from lanindex.search.fast.ragged import Mask, Numbers, Whole
from lanindex.search.fast.setting import Setting


@dataclass(slots=True, eq=False)
class Found:
    """Ends of ways through a line.

    Attributes
    ----------
    entry, root : ndarray
        (N,) by which entry it began, and at which event.
    capture, start, until, low, high : ndarray
        (N,) int64 frames, those of all beside it in `low` and `high`.
    alone : ndarray
        (N,) bool: whether it is no more than a starting position.
    part, row : ndarray
        (N,) int64: its last symbol.
    cost : ndarray
        (N,) int64: what is missing to a fit of 1, in thousandths; -1: that is not known.
    node : ndarray
        (N,) int64.
    memory : Memory
        The rest.
    """

    entry: Whole
    root: Whole
    capture: Whole
    start: Whole
    until: Whole
    low: Whole
    high: Whole
    alone: Mask
    part: Whole
    row: Whole
    cost: Whole
    node: Whole
    memory: Memory

    def at(self, chosen: Numbers) -> Found:
        """Return some of them."""
        columns = {name: getattr(self, name)[chosen] for name in _ENDS}
        return replace(self, **columns, memory=self.memory.at(chosen))


_ENDS = (
    "entry",
    "root",
    "capture",
    "start",
    "until",
    "low",
    "high",
    "alone",
    "part",
    "row",
    "cost",
    "node",
)


def ends_of(
    setting: Setting, program: Program, firsts: list[Whole], ends: list[tuple[int, Memory]]
) -> Found:
    """Return ends as one table.

    Parameters
    ----------
    setting : Setting
        Where.
    program : Program
        Of the line.
    firsts : list of ndarray
        By entry, at which events ways began.
    ends : list of tuple of int and Memory
        States, and the ways that end there; of state -1 only their values are known, as from
        `value_of`: instead of events.
    """
    memory = together([rows for _, rows in ends])
    many = [len(rows) for _, rows in ends]
    state = np.repeat([number for number, _ in ends], many)
    columns, cost = np.full((4, len(memory)), -1), np.full(len(memory), -1)
    alone = np.zeros(len(memory), bool)
    settled = memory.columns[EVENT][state < 0]
    columns[:2, state < 0] = end_of(settled)
    if not program.whole.companions:
        cost[state < 0] = cost_of(settled)
    for number in set(state[state >= 0].tolist()):
        own = np.flatnonzero(state == number)
        told = program.states[number]
        events = setting.block.events(told).at(memory.columns[EVENT][own])
        until = np.where(events.starting, events.until, events.end)
        part = np.full(len(own), setting.asked.code(told.members[-1]))
        columns[:, own] = until, events.end, part, events.last[-1]
        alone[own] = events.starting
    until, end, part, row = columns
    high = np.maximum(memory.columns[GROUPS + BEYOND], end)
    bounds = np.cumsum([0, *map(len, firsts)])
    entry = np.searchsorted(bounds, memory.columns[ROOT], "right") - 1
    first = np.concatenate(firsts)[memory.columns[ROOT]]
    capture = captures_of(setting, program, firsts)[memory.columns[ROOT]]
    start, low = memory.columns[GROUPS + START], memory.columns[GROUPS + LOW]
    frames = (capture, start, until, low, high)
    return Found(entry, first, *frames, alone, part, row, cost, memory.came, memory)


def captures_of(setting: Setting, program: Program, firsts: list[Whole]) -> Whole:
    """Return the captures of ways that began by some entries at some events."""
    states = (program.states[entry.state] for entry in program.entries)
    events = (setting.block.events(state) for state in states)
    return np.concatenate([it.capture[first] for it, first in zip(events, firsts, strict=True)])
