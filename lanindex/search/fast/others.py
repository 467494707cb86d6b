"""The ways of a line that stands beside another, as that one sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lanindex.search.fast import beside, taken
from lanindex.search.fast.beside import Stretches
from lanindex.search.fast.memory import Nodes
from lanindex.search.fast.ragged import Numbers, Whole
from lanindex.search.fast.taken import Taken, filled


@dataclass(slots=True, eq=False)
class Others:
    """The ways of a line, of one side, that stands beside another.

    Attributes
    ----------
    lines : Stretches
        Their frames.
    taken, owed, seen
        What they remember, as in `Memory`.
    node : ndarray
        (N,) int64: where they end.
    end : ndarray
        (N,) int64: numbers in `Joins`.
    nodes : Nodes or None
        What goes on in what, of a line that runs on as long as it can.
    """

    lines: Stretches
    taken: Taken
    owed: Whole
    seen: Whole
    node: Whole
    end: Whole
    nodes: Nodes | None

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.node)

    def at(self, chosen: Numbers) -> Others:
        """Return some of them."""
        memory = self.taken.at(chosen), self.owed[:, chosen], self.seen[:, chosen]
        ends = self.node[chosen], self.end[chosen]
        return Others(self.lines.at(chosen), *memory, *ends, self.nodes)

    @property
    def free(self) -> bool:
        """Whether they remember nothing."""
        return not (self.taken or self.owed.size) and int(self.seen.max(initial=-1)) < 0

    def last(self) -> Others:
        """Return those that do not go on in another one."""
        if not self.nodes:
            return self
        line = np.zeros(len(self), np.int64)
        last = self.at(np.flatnonzero(~self.nodes.behind(line, self.node)))
        last.nodes = None
        return last

    def keys(self) -> list[Whole]:
        """Return what they look like from outside."""
        lines = self.lines
        frames = [lines.capture, lines.start, lines.until, lines.low, lines.high]
        rest = [*self.taken.first, *self.taken.last, *self.owed, *self.seen]
        return [*frames, lines.alone.astype(np.int64), *rest]


def gathered(tables: list[Others]) -> Others:
    """Return the ways of all sides; it is not told any more which goes on in which."""
    return Others(
        beside.gathered([it.lines for it in tables]),
        taken.beside_each_other([it.taken for it in tables]),
        filled([it.owed for it in tables]),
        np.concatenate([it.seen for it in tables], axis=1),
        np.concatenate([it.node for it in tables]),
        np.concatenate([it.end for it in tables]),
        None,
    )
