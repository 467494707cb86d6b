"""Claims that no later step or line can want any more: two ways that differ in them are one.

A repeat with lines beside it would else remember every set of movements that these could have
taken, twice as many with each movement.
"""

from __future__ import annotations

import numpy as np

from lanindex.search.automaton import Companion, Program
from lanindex.search.fast.memory import EVENT, GROUPS, START, Memory
from lanindex.search.fast.ragged import FAR, Whole, smallest_from_here
from lanindex.search.fast.setting import MANNERS, Setting, open_groups
from lanindex.search.fast.taken import Taken, in_sets

_FROM_HERE = ("with", "during", "starting with", "ending with", "exactly with", "before")
"""Relations to lines that end after the beginning of what they stand beside."""


class Expiry:
    """Tells which claims of a line are still wanted.

    Parameters
    ----------
    setting : Setting
        Where.
    program : Program
        The line.
    """

    def __init__(self, setting: Setting, program: Program) -> None:
        self._setting, self._program = setting, program
        self._open = open_groups(program)
        groups = (program.whole, *program.brackets)
        self._companions = [it for group in groups for it in group.companions]
        self._earliest: dict[Companion, tuple[Whole, Whole]] = {}
        self.known = (
            bool(setting.contested.get(program) or self._companions)
            and program not in setting.outside
            and all(map(_ends_later, self._companions))
        )

    def dropped(self, state: int, rows: Memory) -> Memory:
        """Return ways that stand at a state, without the claims that nothing can want any more."""
        if not (self.known and rows.taken):
            return rows
        events = self._setting.block.events(self._program.states[state])
        event = rows.columns[EVENT]
        capture, here = events.capture[event], events.start[event]
        since = here
        for group in (self._program.whole, *self._open[state], *self._program.brackets):
            if not group.companions:
                continue
            levels = [self._program.whole, *self._open[state]]
            level = levels.index(group) if group in levels else None
            begun = here if level is None else rows.columns[GROUPS + 3 * level + START]
            for companion in group.companions:
                since = np.minimum(since, self._from(companion, capture, begun))
        rows.taken = self._after(rows.taken, capture, since)
        return rows

    def _from(self, companion: Companion, capture: Whole, begun: Whole) -> Whole:
        """Return the first frame of all lines that can stand beside what has begun then."""
        if companion not in self._earliest:
            found = [self._setting.company.others(it, companion).lines for it in companion.programs]
            owner, until, start = (
                np.concatenate([getattr(it, name) for it in found])
                for name in ("capture", "until", "start")
            )
            order = np.argsort(owner * FAR + until, kind="stable")
            earliest = smallest_from_here(start[order], owner[order])
            keys = (owner * FAR + until)[order]
            self._earliest[companion] = keys, np.append(owner[order] * FAR + earliest, FAR << 20)
        keys, earliest = self._earliest[companion]
        slack = self._setting.slack[capture]
        place = np.searchsorted(keys, capture * FAR + begun - slack)
        frames: Whole = np.minimum(earliest[place] - capture * FAR, FAR - 1)
        return frames

    def _after(self, had: Taken, capture: Whole, since: Whole) -> Taken:
        """Return the claims of movements, stays and rests that do not end before a frame."""
        first = had.first.copy()
        for part, rows in self._setting.claimed():
            for manner in MANNERS:
                lane = self._setting.lane(manner, part)
                shown = rows.shown
                ends = rows.stop[shown] if manner == "move" else rows.until(shown)
                keys = rows.capture[shown].astype(np.int64) * FAR + ends
                begin = lane + np.searchsorted(keys, capture * FAR + since)
                own = (first >= lane) & (first <= lane + len(rows))
                first = np.where(own, np.maximum(first, begin), first)
        return in_sets(first, had.last)


def _ends_later(companion: Companion) -> bool:
    """Tell whether a line takes nothing that ends before what it stands beside begins."""
    lone = not any(
        group.companions for it in companion.programs for group in (it.whole, *it.brackets)
    )
    return companion.relation in _FROM_HERE and not companion.within and lone
