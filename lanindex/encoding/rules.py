"""Stage 5: which symbols of a move are only passed on the way.

Source: ``encoding/METHOD.md``, stage 5; Matsumoto and Hachimura (2001), 4.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.achieve import Run
from lanindex.encoding.direction import CELLS
from lanindex.notation.ldd import Rule


class Rules:
    """The rules of a part, ready to be looked up."""

    def __init__(self, rules: Sequence[Rule]) -> None:
        self._by_opening: dict[tuple[int, ...], list[tuple[tuple[int, ...], Rule]]] = {}
        for rule in rules:
            cells = tuple(direction * 3 + level for direction, level in rule.cells)
            self._by_opening.setdefault(cells[:2], []).append((cells, rule))

    @cached_property
    def table(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Which rules begin with each two cells, (27 · 27 + 1,) borders, and all of them, (R, 4).

        Of a rule: how many cells, the third, those that are deleted as bits, and its line.
        """
        pairs = [divmod(number, CELLS) for number in range(CELLS * CELLS)]
        those = [self._by_opening.get(pair, []) for pair in pairs]
        rows = [
            (
                len(cells),
                cells[-1],
                sum(gone << place for place, gone in enumerate(rule.deleted)),
                rule.line,
            )
            for some in those
            for cells, rule in some
        ]
        borders = np.cumsum([0, *map(len, those)], dtype=np.int64)
        return borders, np.array(rows, np.int64).reshape(-1, 4)

    def first_match(self, cells: Sequence[int]) -> tuple[int, Rule] | None:
        """Return where the first rule applies, and which; the ends are never deleted."""
        for start, opening in enumerate(pairwise(cells)):
            for wanted, rule in self._by_opening.get(opening, ()):
                stop = start + len(wanted)
                if (
                    tuple(cells[start:stop]) == wanted
                    and not (start == 0 and rule.deleted[0])
                    and not (stop == len(cells) and rule.deleted[-1])
                ):
                    return start, rule
        return None


def apply(runs: Sequence[Run], in_force: int, rules: Rules) -> list[Run]:
    """Mark the symbols that the rules delete as passing, and join equal neighbours."""
    result = list(runs)
    alive = [index for index, run in enumerate(runs) if run.outcome == "symbol"]
    while match := rules.first_match([in_force, *[runs[index].cell for index in alive]]):
        start, rule = match
        gone = [alive[start + place - 1] for place, deleted in enumerate(rule.deleted) if deleted]
        for index in gone:
            result[index] = runs[index]._replace(outcome="passing", rule=rule.line)
        alive = [index for index in alive if index not in gone]
    for before, after in pairwise(alive):
        if runs[before].cell == runs[after].cell:
            result[before] = runs[before]._replace(outcome="rejoined")
    return result
