"""How movement is spread: where parts go, from where, how often, and how two groups differ.

The counts are made from a library's columns, part by part, without an object for any symbol. One
capture is one observation, since its symbols depend on each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, KINDS, LEVELS, TRACKS, kind_of
from lanindex.errors import UsageError, shown
from lanindex.library.store import Store
from lanindex.model.columns import PASSING, STARTING, Columns, Roster, codes_of

if TYPE_CHECKING:
    from lanindex.library.dialect import Link
    from lanindex.pipeline.shards import Shard, State
    from lanindex.pipeline.spread import Spread, Tick

Floats = NDArray[np.float64]
IntArray = NDArray[np.int64]

CELLS = tuple(f"{direction} {level}" for direction in DIRECTIONS for level in LEVELS)
"""The names of cells; the index of a cell is 3 times the code of its direction plus its level's."""

USUAL = ("l_arm", "r_arm", "l_leg", "r_leg", "torso", "head")
"""The parts that are counted by default."""

COUNTABLE_PARTS = tuple(
    part for part in TRACKS if {"direction", "level"} <= {*KINDS[kind_of(part)].fields}
    and KINDS[kind_of(part)].lasts
)  # fmt: skip
"""The parts that can be counted: those that have a direction and a level at all times."""

BINS = 20
"""Number of equal stretches into which the time of a capture is divided."""


@dataclass(frozen=True, slots=True, eq=False)
class Moves:
    """What a part does in a group of captures: (27,) cells, (27, 27) transitions, (BINS,) rates."""

    group: str
    part: str
    captures: int
    seconds: float
    total_seconds: float
    cells: IntArray
    transitions: IntArray
    over_time: Floats

    @property
    def rate(self) -> float:
        """Movements a second, while the part is known."""
        return int(self.cells.sum()) / self.seconds if self.seconds else 0.0

    @property
    def coverage(self) -> float:
        """The share of all time in which the part is known."""
        return self.seconds / self.total_seconds if self.total_seconds else 0.0

    def record(self, by: str) -> dict[str, Any]:
        """Return the counts as JSON has them."""
        came, went = np.nonzero(self.transitions)
        order = np.argsort(-self.transitions[came, went], kind="stable")
        return {
            "by": by,
            "group": self.group,
            "part": self.part,
            "captures": self.captures,
            "movements": int(self.cells.sum()),
            "seconds": round(self.seconds, 3),
            "coverage": round(self.coverage, 4),
            "rate": round(self.rate, 4),
            "cells": {name: int(it) for name, it in zip(CELLS, self.cells, strict=True) if it},
            "transitions": [
                [CELLS[came[it]], CELLS[went[it]], int(self.transitions[came[it], went[it]])]
                for it in order.tolist()
            ],
            "over_time": [round(it, 4) for it in self.over_time.tolist()],
        }


@dataclass(frozen=True, slots=True)
class Difference:
    """How two groups differ in one measure: a cell's share of the movements, or the rate."""

    part: str
    what: str
    values: tuple[float, float]
    captures: tuple[int, int]
    movements: tuple[int, int]
    least: float
    most: float
    p: float

    @property
    def matters(self) -> bool:
        """Whether the difference is significant."""
        return self.p <= 1 - CONFIDENCE

    def record(self, by: str, groups: tuple[str, str]) -> dict[str, Any]:
        """Return the difference as JSON has it."""
        return {
            "by": by,
            "groups": list(groups),
            "part": self.part,
            "what": self.what,
            "values": [round(it, 5) for it in self.values],
            "captures": list(self.captures),
            "movements": list(self.movements),
            "difference": round(self.values[1] - self.values[0], 5),
            "least": round(self.least, 5),
            "most": round(self.most, 5),
            "p": round(self.p, 4),
            "matters": self.matters,
        }


@dataclass(frozen=True, slots=True)
class Movement:
    """How the movement of some groups of captures is spread."""

    by: str
    groups: Mapping[str, int]
    moves: tuple[Moves, ...]
    differences: tuple[Difference, ...]

    def of(self, group: str, part: str) -> Moves:
        """Return what a part does in a group."""
        return next(one for one in self.moves if (one.group, one.part) == (group, part))

    @property
    def parts(self) -> list[str]:
        """The parts that were counted."""
        return list(dict.fromkeys(one.part for one in self.moves))


def movement(
    store: Store,
    numbers: Sequence[int] | None,
    *,
    by: str = "",
    compared: tuple[str, str] | None = None,
    parts: Iterable[str] = (),
    spread: Spread | None = None,
) -> Movement:
    """Count how movement is spread, here or by other processes."""
    counted = list(dict.fromkeys(parts)) or list(USUAL)
    if unknown := [part for part in counted if part not in COUNTABLE_PARTS]:
        wanted = f"one of {' '.join(COUNTABLE_PARTS)}"
        raise UsageError(f'no part "{shown(unknown[0])}"', wanted=wanted)
    values = _values(store, numbers, by)
    names = sorted(set(values.values()))
    if compared:
        if compared[0] == compared[1]:
            found, wanted = f'"{shown(compared[0])}" twice', "two different groups"
            raise UsageError(found, place=f"--by {by}", wanted=wanted)
        if lacking := [name for name in compared if name not in names]:
            listed = ", ".join(map(shown, names[:20])) or "a capture"
            raise UsageError(f'no "{shown(lacking[0])}"', place=f"--by {by}", wanted=listed)
        names = list(compared)
    if not names:
        return Movement(by, {}, (), ())
    place = {name: place for place, name in enumerate(names)}
    chosen = sorted(number for number, value in values.items() if value in place)
    group = np.array([place[values[number]] for number in chosen], np.int64)
    unit, sides = gathered(group)
    moves: list[Moves] = []
    measures: list[_Measure] = []

    def counts_here() -> Iterator[_Counts]:
        for part in counted:
            roster, columns = store.columns([part], chosen)
            yield _counts(roster, columns[part], group, len(names))

    by_part = counts_here()
    if spread is not None:
        by_part = _counted_by(spread, store, counted, chosen, group, len(names))
    for part, counts in zip(counted, by_part, strict=True):
        moves += _moves(part, counts, names, group)
        if len(names) == 2:
            measures += _measures(part, counts, group, unit)
    moves.sort(key=lambda one: place[one.group])
    sizes = dict(zip(names, np.bincount(group).tolist(), strict=True))
    return Movement(by, sizes, tuple(moves), _differences(measures, sides))


def _values(store: Store, numbers: Sequence[int] | None, by: str) -> dict[int, str]:
    """Return the value of a column, which names the group, by the number of the capture."""
    if not by:
        return dict.fromkeys(store.texts("path", numbers), "all")
    if by in ("label", "format", "path"):
        return {number: str(value or "") for number, value in store.texts(by, numbers).items()}
    metadata = store.texts("metadata", numbers)
    columns = sorted({name for one in metadata.values() for name in one})
    if by not in columns:
        wanted = ", ".join(("label", "format", *columns))
        raise UsageError(f'no column "{shown(by)}"', place="--by", wanted=f"one of {wanted}")
    return {number: one.get(by, "") for number, one in metadata.items()}


def _histogram(
    shape: tuple[int, ...], *indices: IntArray, weights: Floats | None = None
) -> NDArray[Any]:
    """Count the rows with the same indices, or add up their weights: an array of that shape."""
    flat = np.ravel_multi_index(indices, shape)
    return np.bincount(flat, weights, minlength=math.prod(shape)).reshape(shape)


class _Counts(NamedTuple):
    """What a part does in C captures of G groups, with its M movements."""

    cells: IntArray  # (G, 27)
    transitions: IntArray  # (G, 27, 27)
    over_time: IntArray  # (G, BINS)
    capture: IntArray  # (M,) places
    cell: IntArray  # (M,)
    known: Floats  # (C,) seconds in which the part is known
    total: Floats  # (C,) seconds


def _counts(roster: Roster, columns: Columns, group: IntArray, groups: int) -> _Counts:
    """Count the movements of a part; `group` is (C,) the group of each capture."""
    rows = np.diff(columns.bounds)
    capture = np.repeat(np.arange(len(rows)), rows)
    direction, level = codes_of(columns.cell)
    cell = direction.astype(np.int64) * len(LEVELS) + level
    stops = (columns.cell & PASSING == 0) & (direction >= 0) & (level >= 0)
    moved = stops & (columns.cell < STARTING)
    steps = np.flatnonzero(stops)
    came, went = steps[:-1], steps[1:]
    follow = moved[went] & (capture[came] == capture[went])
    came, went = came[follow], went[follow]
    of, size = group[capture], len(CELLS)
    frames = np.maximum(roster.frames[capture[moved]], 1).astype(np.int64)
    time = np.minimum(columns.start[moved].astype(np.int64) * BINS // frames, BINS - 1)
    return _Counts(
        _histogram((groups, size), of[moved], cell[moved]),
        _histogram((groups, size, size), of[went], cell[came], cell[went]),
        _histogram((groups, BINS), of[moved], time),
        capture[moved],
        cell[moved],
        *_seconds(roster, rows > 0, columns.seen),
    )


def _moves(part: str, counts: _Counts, names: Sequence[str], group: IntArray) -> Iterator[Moves]:
    """Yield the movements of a part in each group."""
    each = (
        np.bincount(group, it, len(names)) for it in (counts.known > 0, counts.known, counts.total)
    )
    for place, (name, seen, seconds, total) in enumerate(zip(names, *each, strict=True)):
        rates = counts.over_time[place] * BINS / seconds if seconds else np.zeros(BINS)
        moved = counts.cells[place], counts.transitions[place], rates
        yield Moves(name, part, int(seen), float(seconds), float(total), *moved)


# The same, counted by other processes.


class _Task(NamedTuple):
    """Some captures in which parts are to be counted, and the group of each, (C,)."""

    state: State
    shard: Shard
    parts: list[str]
    group: IntArray
    places: IntArray  # (C,) of all that are counted


def _counted_in(task: _Task, tick: Tick) -> tuple[IntArray, IntArray, list[_Counts]]:
    """Return the places of captures, the groups that they are of, and what each part does."""
    from lanindex.pipeline.shards import columns_at

    _, roster, columns = columns_at(task.state, task.shard, task.parts, (), tick)
    groups, group = np.unique(task.group, return_inverse=True)
    counts = [_counts(roster, columns[part], group, len(groups)) for part in task.parts]
    return task.places, groups, counts


def _counted_by(
    spread: Spread, store: Store, parts: list[str], chosen: list[int], group: IntArray, groups: int
) -> Iterator[_Counts]:
    """Yield what each part does, counted in shards of the library."""
    from lanindex.pipeline import shards

    numbers = np.array(chosen, np.int64)

    def task(connection: Link, state: State, shard: Shard) -> _Task:
        places = np.searchsorted(numbers, shards.numbers_in(connection, shard))
        return _Task(state, shard, parts, group[places], places)

    watch = partial(store.session.progress, "captures")
    told, _ = shards.results(spread, store, parts, chosen, _counted_in, task, watch)
    for number in range(len(parts)):
        yield _joined(
            [(places, own, counts[number]) for places, own, counts in told], len(chosen), groups
        )


def _joined(
    told: Sequence[tuple[IntArray, IntArray, _Counts]], captures: int, groups: int
) -> _Counts:
    """Return the counts of some captures each as one: those of one process, to the last bit."""
    size = len(CELLS)
    cells, transitions = (np.zeros((groups, *[size] * it), np.int64) for it in (1, 2))
    over_time, known, total = np.zeros((groups, BINS), np.int64), *np.zeros((2, captures))
    for places, own, counts in told:
        cells[own] += counts.cells
        transitions[own] += counts.transitions
        over_time[own] += counts.over_time
        known[places], total[places] = counts.known, counts.total
    none = np.empty(0, np.int64)
    capture = np.concatenate([none, *(places[it.capture] for places, _, it in told)])
    cell = np.concatenate([none, *(it.cell for *_, it in told)])
    order = np.argsort(capture, kind="stable")
    return _Counts(cells, transitions, over_time, capture[order], cell[order], known, total)


class _Measure(NamedTuple):
    """What two groups are compared in: a value of each observation (U,), NaN where unknown."""

    part: str
    what: str
    values: Floats
    captures: tuple[int, int]
    movements: tuple[int, int]


def _measures(part: str, counted: _Counts, group: IntArray, unit: IntArray) -> Iterator[_Measure]:
    """Yield the measures of a part: the share of each cell in the movements, and their rate."""
    capture, cell, known = counted.capture, counted.cell, counted.known
    size, units = len(CELLS), int(unit.max()) + 1
    count = np.bincount(capture, minlength=len(known))
    counts = _histogram((2, size), group[capture], cell)
    shares = _histogram((units, size), unit[capture], cell, weights=1 / count[capture])
    rates = np.divide(count, known, out=np.zeros(len(known)), where=known > 0)

    def measure(what: str, sums: NDArray[Any], there: Any, moved: NDArray[Any]) -> _Measure:
        of = np.bincount(unit[there], minlength=units)
        values = np.divide(sums, of, out=np.full(units, np.nan), where=of > 0)
        few, many = np.bincount(group[there], minlength=2).tolist()
        return _Measure(part, what, values, (few, many), (int(moved[0]), int(moved[1])))

    for one in np.flatnonzero(counts.sum(axis=0)).tolist():
        yield measure(CELLS[one], shares[:, one], count > 0, counts[:, one])
    rate = np.bincount(unit, rates, minlength=units)
    yield measure("rate", rate, known > 0, counts.sum(axis=1))


def _differences(measures: Sequence[_Measure], sides: IntArray) -> tuple[Difference, ...]:
    """Return the differences in all measures, the most significant first."""
    if not measures:
        return ()
    values = np.stack([one.values for one in measures], axis=1)
    means, spread, p, wide = permutation_test(values, sides)
    (first, second), margin = means, wide * spread
    least, most = second - first - margin, second - first + margin
    numbers = np.stack((first, second, least, most, p), axis=1).tolist()
    differences = [
        Difference(it.part, it.what, (a, b), it.captures, it.movements, low, high, chance)
        for it, (a, b, low, high, chance) in zip(measures, numbers, strict=True)
        if min(it.captures) > 0
    ]
    return tuple(sorted(differences, key=lambda it: (it.p, -abs(it.values[1] - it.values[0]))))


def _seconds(roster: Roster, there: Any, seen: NDArray[np.int32]) -> tuple[Floats, Floats]:
    """Return the seconds in which each capture knows a part, and all its seconds, (C,) each."""
    frames = np.where(there, roster.frames, 0).astype(np.float64)
    known = np.bincount(
        seen[:, 0], (seen[:, 2] - seen[:, 1]).astype(np.float64), minlength=len(frames)
    )
    frames = np.where(np.isin(np.arange(len(frames)), seen[:, 0]), known, frames)
    second = roster.rate[:, 1] / roster.rate[:, 0]
    return frames * second, roster.frames * second


PERMUTATIONS = 999
CONFIDENCE = 0.95

GATHERED = 400
"""The most observations of a group; of more captures, several make one observation."""


def gathered(group: IntArray) -> tuple[IntArray, IntArray]:
    """Return the observation of each capture (C,), and the group of each observation (U,).

    A capture is one observation. A group of more than `GATHERED` captures has that many
    observations, among which its captures are divided at random.
    """
    random = np.random.default_rng(0)
    unit, sides = np.zeros(len(group), np.int64), list[int]()
    for side in range(int(group.max()) + 1):
        members = random.permutation(np.flatnonzero(group == side))
        many = min(len(members), GATHERED)
        unit[members] = len(sides) + np.arange(len(members)) % many
        sides += [side] * many
    return unit, np.array(sides, np.int64)


def permutation_test(values: Floats, sides: IntArray) -> tuple[Floats, Floats, Floats, float]:
    """Compare two groups in M measures of U observations: `values` (U, M), NaN where unknown.

    `sides` (U,) is 0 or 1, the group of each observation. Returns the means (2, M) of the groups,
    the standard error (M,) of their difference, p (M,) adjusted for all measures, and the number
    of standard errors that no difference exceeds in a share `CONFIDENCE` of the permutations.
    """
    known = np.isfinite(values)
    filled = np.where(known, values, 0.0)
    random = np.random.default_rng(0)
    permuted = [random.permutation(sides) for _ in range(PERMUTATIONS)]
    second = np.array([sides, *permuted], float)
    members = np.stack((1 - second, second))
    numbers, sums = members @ known.astype(float), members @ filled
    means = np.divide(sums, numbers, out=np.zeros_like(sums), where=numbers > 0)
    count = known.sum(axis=0)
    middle = filled.sum(axis=0) / np.maximum(count, 1)
    square = np.where(known, (values - middle) ** 2, 0.0).sum(axis=0) / np.maximum(count - 1, 1)
    spread = np.sqrt(square * (1 / np.maximum(numbers[:, 0], 1)).sum(axis=0))
    both = (numbers > 0).all(axis=0)
    apart = np.where(both, np.abs(means[1] - means[0]), 0.0)
    apart = np.divide(apart, spread, out=np.zeros_like(apart), where=spread > 1e-12)
    largest = apart.max(axis=1)
    p = (largest[:, None] >= apart[0] - 1e-12).mean(axis=0)
    return means[:, 0], spread, p, float(np.quantile(largest, CONFIDENCE, method="higher"))
