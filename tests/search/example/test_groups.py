"""Groups of similar clips: average linkage against its definition."""

from itertools import combinations

import numpy as np
import pytest
from effort import examples
from hypothesis import given
from hypothesis import strategies as st
from made_clips import PARTS, clips, clips_of, dance

from lanindex.search.example import likeness
from lanindex.search.example.likeness import (
    compared,
    grouped,
    linked,
    near,
    signatures,
    unwatched,
)


def plainly(count: int, table: np.ndarray, least: float) -> set[frozenset[int]]:
    """Join the two groups that are most alike on average, again and again."""
    groups = [frozenset([one]) for one in range(count)]

    def mean(pair) -> float:
        return float(np.mean([table[a, b] for a in pair[0] for b in pair[1]]))

    while len(groups) > 1:
        best = max(combinations(groups, 2), key=mean)
        if mean(best) < least or mean(best) <= 0:
            break
        groups = [group for group in groups if group not in best] + [best[0] | best[1]]
    return set(groups)


@examples(40)
@given(st.integers(1, 8), st.integers(0, 999), st.sampled_from([0.2, 0.5, 0.8]))
def test_linkage_is_what_it_says(count, seed, least) -> None:
    table = np.random.default_rng(seed).random((count, count))
    table = np.triu(table, 1) + np.triu(table, 1).T
    pairs = np.stack(np.triu_indices(count, 1), axis=1)
    found = linked([1] * count, pairs, table[pairs[:, 0], pairs[:, 1]], least, 1, unwatched)
    assert {frozenset(group) for group in found} == plainly(count, table, least)


@examples(20)
@given(st.lists(clips(), min_size=1, max_size=6))
def test_groups_hold_every_clip_and_their_medoid_is_first(many) -> None:
    laid_out = clips_of(many, [30.0] * len(many), PARTS)
    found = grouped(laid_out, least=0.3)
    assert found.every
    assert sorted(one for group in found.groups for one in group.members) == list(range(len(many)))
    table = np.array(
        [compared(clips_of([one], [30.0], PARTS), laid_out.full_windows()) for one in many]
    )
    for group in found.groups:
        inside = table[np.ix_(group.members, group.members)]
        assert inside[0].sum() == pytest.approx(inside.sum(axis=1).max(), abs=1e-3)
        assert list(inside[0, 1:]) == pytest.approx(sorted(inside[0, 1:], reverse=True), abs=1e-5)
        if len(group.members) > 1:
            assert group.likeness == pytest.approx(inside[0, 1:].mean(), abs=1e-3)
            assert inside[~np.eye(len(inside), dtype=bool)].mean() >= 0.3 - 1e-3


def families(count: int, each: int):
    """Return clips of several families, each of its own cells, with a stray symbol a clip."""
    random = np.random.default_rng(1)
    many = []
    for _ in range(count):
        cells = [(int(random.integers(9)), int(random.integers(3))) for _ in range(8)]
        for _ in range(each):
            own = [*cells]
            own[int(random.integers(1, 8))] = (int(random.integers(9)), int(random.integers(3)))
            many.append(dance(own))
    return clips_of(many, [30.0] * len(many), ["r_arm"])


def test_of_many_clips_only_the_nearest_are_compared_and_groups_are_of_any_size(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(likeness, "PAIRS", 600)
    monkeypatch.setattr(likeness, "FEWEST", 4)
    found = grouped(families(3, 60), least=0.5)
    assert not found.every
    assert found.pairs < 180 * 10
    largest = [frozenset(group.members) for group in found.groups[:3]]
    for first in (0, 60, 120):
        assert any(len(group & set(range(first, first + 60))) >= 55 for group in largest)


def test_so_many_groups_as_are_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    laid_out = families(5, 4)
    assert len(grouped(laid_out, least=0.9, wanted=5).groups) == 5
    assert len(grouped(laid_out, least=0.9, wanted=1).groups) == 1
    monkeypatch.setattr(likeness, "PAIRS", 10)
    monkeypatch.setattr(likeness, "FEWEST", 3)
    assert len(grouped(laid_out, least=0.9, wanted=5).groups) == 5


@pytest.mark.parametrize("pairs", [60_000, 10])
def test_groups_that_have_nothing_in_common_are_joined_where_fewer_are_wanted(
    monkeypatch: pytest.MonkeyPatch, pairs: int
) -> None:
    monkeypatch.setattr(likeness, "PAIRS", pairs)
    cells = [(direction, level) for direction in range(8) for level in (0, 2)]
    many = [dance([(8, 1), cell, (8, 1)]) for cell in cells]
    many = [{PARTS[number % 3]: clip["r_arm"]} for number, clip in enumerate(many)]
    laid_out = clips_of(many, [30.0] * len(many), PARTS)
    for wanted in (1, 2, 7, 16):
        assert len(grouped(laid_out, least=0.9, wanted=wanted).groups) == wanted
    assert len(grouped(laid_out, least=0.9, wanted=17).groups) == 16


def test_no_pair_stands_twice() -> None:
    pairs = near(signatures(families(20, 6)), 8)
    assert (pairs[:, 0] < pairs[:, 1]).all()
    assert len(np.unique(pairs, axis=0)) == len(pairs)
    assert (np.bincount(pairs.ravel(), minlength=120) >= 8).all()


def test_blocks_find_nearly_all_that_is_nearest(monkeypatch: pytest.MonkeyPatch) -> None:
    found = np.random.default_rng(3).normal(size=(500, 4)).astype(np.float32)
    wanted = set(map(tuple, near(found, 5).tolist()))
    monkeypatch.setattr(likeness, "_NEIGHBOURS", 128)
    told = set(map(tuple, near(found, 5).tolist()))
    assert len(told & wanted) > 0.95 * len(wanted)


def test_a_pair_is_aligned_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    plain = likeness.paired

    def paired(one, two):
        asked.append(len(one.low[0]))
        return plain(one, two)

    monkeypatch.setattr(likeness, "paired", paired)
    known = likeness._Likenesses(families(2, 4), lambda noun, done, total: None)
    pairs = np.array([[0, 1], [2, 0], [3, 3]])
    first = known.alike(pairs)
    assert (first[2], len(known), sum(asked)) == (1, 2, 2)
    assert known.alike(pairs[:, ::-1]).tolist() == first.tolist()
    assert sum(asked) == 2
