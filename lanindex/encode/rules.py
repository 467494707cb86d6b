"""Stage 5: which symbols of a move are only passed on the way.

Source: METHOD, stage 5; the paper, 4.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from lanindex.encode.achieve import Run
from lanindex.notation.ldd import Rule


def _first_match(cells: Sequence[int], rules: Sequence[Rule]) -> tuple[int, Rule] | None:
    """Return where the first rule applies; the ends of `cells` are never deleted."""
    for start in range(len(cells)):
        for rule in rules:
            stop = start + len(rule.cells)
            if stop > len(cells):
                continue
            wanted = [direction * 3 + level for direction, level in rule.cells]
            deleted = [start + offset for offset, gone in enumerate(rule.deleted) if gone]
            ends = {0, len(cells) - 1}
            if list(cells[start:stop]) == wanted and not ends.intersection(deleted):
                return start, rule
    return None


def apply(runs: list[Run], in_force: int, rules: Sequence[Rule]) -> list[Run]:
    """Mark the symbols that the rules delete as passing, and join equal neighbours.

    Parameters
    ----------
    runs : list of Run
        All of a move, as from `achieve`.
    in_force : int
        The cell of the last symbol before: the left context, never deleted.
    rules : sequence of Rule
        In their file's order: left to right the first that matches is applied, then again from
        the left, until nothing matches.

    Returns
    -------
    list of Run
        The same runs, some of them ``passing`` or ``rejoined``.
    """
    result = list(runs)
    alive = [index for index, run in enumerate(result) if run.outcome == "symbol"]
    if len(alive) < 2:
        return result
    while match := _first_match([in_force, *(result[index].cell for index in alive)], rules):
        start, rule = match
        gone = [start + offset - 1 for offset, deleted in enumerate(rule.deleted) if deleted]
        for position in gone:
            index = alive[position]
            result[index] = replace(result[index], outcome="passing", rule=rule.line)
        alive = [index for position, index in enumerate(alive) if position not in gone]
    for before, after in pairwise(alive):
        if result[before].cell == result[after].cell:
            result[before] = replace(result[before], outcome="rejoined")
    return result
