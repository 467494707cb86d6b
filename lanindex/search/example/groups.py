"""Clustering of clips that are alike: average linkage over the pairs that may be alike."""

from __future__ import annotations

from collections.abc import Iterator
from heapq import heapify, heappop, heappush
from typing import NamedTuple

import numpy as np

from lanindex.search.example.likeness import (
    Clips,
    Doubles,
    Floats,
    Numbers,
    Watch,
    lowest,
    paired,
    unwatched,
)
from lanindex.search.sphere import CELLS, MIDDLES

PAIRS = 60_000  # pairs that are aligned, about
FEWEST = 8  # neighbours of each clip that are aligned at least
_AXES, _TURNS = 32, 4  # numbers of a signature, and rounds of looking for their axes
_AT_ONCE = 1 << 12  # pairs that are aligned at a time
_NOTHING = 0.01  # the likeness below which two clips have nothing in common
_NEAREST = 1e-6  # the least likeness of clips with one signature, where a number is wanted
_BLOCK, _TREES = 2048, 8  # clips of a block, and how often more are split into blocks


class SimilarClips(NamedTuple):
    """Clips that are like each other."""

    members: list[int]  # the medoid, which is most like all others, then the likest to it
    likeness: float  # the mean of the others' to the medoid; of one clip alone 1


class Grouped(NamedTuple):
    """All clips in groups."""

    groups: list[SimilarClips]  # the largest first
    pairs: int  # how many were aligned
    every: bool  # whether these are all pairs


def grouped(
    clips: Clips, *, least: float, wanted: int | None = None, watch: Watch = unwatched
) -> Grouped:
    """Join groups down to a mean likeness of `least`, or until no more than `wanted` are left."""
    vectors, likenesses = signatures(clips), _Likenesses(clips, watch)
    groups = [[clip] for clip in range(len(clips))]
    floor, every, settled = least, False, False
    while not every and (wanted or not settled):
        medoids = np.array([group[0] for group in groups], np.int64)
        reach = max(FEWEST, 2 * PAIRS // max(1, len(groups)))
        every = reach >= len(groups) - 1
        pairs = near(vectors[medoids], reach, watch)
        alike = likenesses.alike(medoids[pairs])
        if wanted:
            apart = np.linalg.norm(np.diff(vectors[medoids[pairs]], axis=1)[:, 0], axis=1)
            alike = np.maximum(alike, _NEAREST / (1 + apart))
        weights = [len(group) for group in groups]
        last = 0.0 if wanted and (every or floor <= _NOTHING) else floor
        joined = linked(weights, pairs, alike, last, wanted or 1, watch)
        order = _medoids_first(joined, weights, pairs, alike)
        settled = len(order) == len(groups)
        groups = [[clip for one in group for clip in groups[one]] for group in order]
        if wanted and len(groups) <= wanted:
            break
        floor = floor / 2 if settled else floor
    aligned, all_pairs = len(likenesses), len(clips) * (len(clips) - 1) // 2
    return Grouped(_ranked(groups, likenesses), aligned, aligned == all_pairs)


class _Likenesses:
    """How alike pairs of clips are, each aligned once."""

    def __init__(self, clips: Clips, watch: Watch) -> None:
        self._clips, self._watch = clips, watch
        self._values: dict[int, float] = {}

    def __len__(self) -> int:
        return len(self._values)

    def alike(self, pairs: Numbers) -> Doubles:
        """Return how alike pairs of clips are: (K,), of a clip with itself 1."""
        low, high = np.sort(pairs, axis=1).T
        keys, clips, done = low * len(self._clips) + high, self._clips.full_windows(), 0
        unique = np.unique(keys[low < high])
        new = unique[[key not in self._values for key in unique.tolist()]]
        for some in np.array_split(new, len(new) // _AT_ONCE + 1):
            self._watch("pairs", done, len(new))
            one, two = (clips.at(np.s_[:, it]) for it in np.divmod(some, len(self._clips)))
            alike = paired(one, two)
            self._values.update(zip(some.tolist(), alike.tolist(), strict=True))
            done += len(some)
        return np.array([self._values.get(key, 1.0) for key in keys.tolist()])


def near(vectors: Floats, reach: int, watch: Watch = unwatched) -> Numbers:
    """Return the pairs that may be alike: (K, 2), the lower number first, each once.

    Each clip is in pairs with the `reach` others whose signatures, (C, A), are nearest to its own.
    """
    count = len(vectors)
    if reach >= count - 1:
        return np.stack(np.triu_indices(count, 1), axis=1)
    squares = np.square(vectors).sum(axis=1)
    keys, gaps, done = [], [], 0
    trees = _TREES if count > _BLOCK else 1
    for block in _blocks(vectors, trees):
        watch("captures", done // trees, count)
        own, done = vectors[block], done + len(block)
        apart = squares[block, None] + squares[block] - 2 * own @ own.T
        np.fill_diagonal(apart, np.inf)
        nearest = np.argpartition(apart, reach, axis=1)[:, :reach]
        keys.append((block[:, None] * count + block[nearest]).ravel())
        gaps.append(np.take_along_axis(apart, nearest, axis=1).ravel())
    key, once = np.unique(np.concatenate(keys), return_index=True)
    kept = lowest(key // count, np.concatenate(gaps)[once], reach)
    pairs = np.sort(np.stack(np.divmod(key[kept], count), axis=1), axis=1)
    return np.stack(np.divmod(np.unique(pairs @ [count, 1]), count), axis=1)


def _blocks(vectors: Floats, trees: int) -> Iterator[Numbers]:
    """Yield clips in blocks of neighbours, all of them once for each tree."""
    random = np.random.default_rng(0)
    todo = [np.arange(len(vectors))] * trees
    while todo:
        block = todo.pop()
        if len(block) <= _BLOCK:
            yield block
            continue
        one, two = vectors[block[random.choice(len(block), 2, replace=False)]]
        middle = len(block) // 2
        order = np.argpartition(vectors[block] @ (one - two), middle)
        todo += [block[order[:middle]], block[order[middle:]]]


def signatures(clips: Clips) -> Floats:
    """Return how much each part of each clip moves to which cell, in a few numbers: (C, A)."""
    cells, count = MIDDLES[CELLS].astype(np.float32), len(clips)
    table = np.zeros((count, len(clips.parts), len(cells)), np.float32)
    for part, borders in enumerate(clips.first):
        moves = clips.moves.at(slice(borders[0], borders[-1]))
        nearest = np.argmax(moves.points @ cells.T - np.square(cells).sum(axis=1) / 2, axis=1)
        places = np.repeat(np.arange(count), np.diff(borders)) * len(cells) + nearest
        own = np.bincount(places, moves.sizes, count * len(cells))
        table[:, part] = own.reshape(count, -1)
    table = np.sqrt(table.reshape(count, -1))
    table -= table.mean(axis=0)
    # the axes along which they differ most, nearly: all of them would take longer than the rest
    axes = np.random.default_rng(0).normal(size=(table.shape[1], _AXES)).astype(np.float32)
    for _ in range(_TURNS):
        axes, _ = np.linalg.qr(table.T @ (table @ axes))
    vectors: Floats = table @ axes
    return vectors


def linked(
    weights: list[int], pairs: Numbers, alike: Doubles, floor: float, wanted: int, watch: Watch
) -> list[list[int]]:
    """Return groups by average linkage: joined down to a mean likeness, or until few are left.

    Each item stands for as many clips as its weight says. (K, 2) pairs are (K,) alike, others not.
    """
    sums: dict[int, dict[int, float]] = {one: {} for one in range(len(weights))}
    for first in range(0, len(pairs), _AT_ONCE):
        watch("pairs", first, len(pairs))
        some = slice(first, first + _AT_ONCE)
        for (one, two), value in zip(pairs[some].tolist(), alike[some].tolist(), strict=True):
            if value > 0:
                sums[one][two] = sums[two][one] = value * weights[one] * weights[two]
    size = dict(enumerate(weights))
    members = {one: [one] for one in sums}
    queue = [
        (-value / (size[one] * size[two]), one, two)
        for one in sums
        for two, value in sums[one].items()
        if one < two
    ]
    heapify(queue)
    new = len(weights)
    while queue and len(members) > wanted:
        value, one, two = heappop(queue)
        if one not in members or two not in members:
            continue
        if -value < floor:
            break
        watch("captures", new - len(weights), len(weights))
        members[new] = members.pop(one) + members.pop(two)
        size[new] = size[one] + size[two]
        own, other = sums.pop(one), sums.pop(two)
        sums[new] = {}
        for third in sorted((own.keys() | other.keys()) - {one, two}):
            total = sums[third].pop(one, 0.0) + sums[third].pop(two, 0.0)
            sums[new][third] = sums[third][new] = total
            heappush(queue, (-total / (size[new] * size[third]), third, new))
        new += 1
    return list(members.values())


def _medoids_first(
    joined: list[list[int]], weights: list[int], pairs: Numbers, alike: Doubles
) -> list[list[int]]:
    """Return groups, the member of each first that is most like all others of it."""
    count = len(weights)
    owner = np.zeros(count, np.int64)
    for number, group in enumerate(joined):
        owner[group] = number
    inside = owner[pairs[:, 0]] == owner[pairs[:, 1]]
    (one, two), value = pairs[inside].T, alike[inside]
    weight = np.array(weights, np.float64)
    total = np.bincount(one, value * weight[two], count)
    total += np.bincount(two, value * weight[one], count)
    order = np.lexsort((np.arange(count), -total, owner))
    ends = np.cumsum(np.bincount(owner, minlength=len(joined)))
    return [part.tolist() for part in np.split(order, ends[:-1])]


def _ranked(groups: list[list[int]], likenesses: _Likenesses) -> list[SimilarClips]:
    """Return groups, the largest first, their members by likeness to the medoid."""
    alike = likenesses.alike(np.array([(group[0], one) for group in groups for one in group]))
    ranked, ends = [], np.cumsum([len(group) for group in groups])
    for group, own in zip(groups, np.split(alike, ends[:-1]), strict=True):
        order = np.argsort(-own[1:], kind="stable").tolist()
        mean = float(own[1:].mean()) if order else 1.0
        ranked.append(SimilarClips([group[0], *(group[1 + place] for place in order)], mean))
    return sorted(ranked, key=lambda group: (-len(group.members), group.members[0]))
