"""The alignment of symbols against its plain twin, and its laws."""

import numpy as np
import pytest
from effort import examples
from hypothesis import given
from hypothesis import strategies as st
from made_clips import PARTS, clips, clips_of, mirrored, source_of
from plain_example import likeness, middle

from lanindex.model import SYMBOL
from lanindex.model.columns import cell_of
from lanindex.search.example import likeness as module
from lanindex.search.example.likeness import bounds_of, compared, nearest, pairs
from lanindex.search.sphere import MIDDLES

RATE = 30.0


def side_by_side(many):
    return clips_of(many, [RATE] * len(many), PARTS)


def alike(one, many):
    found = side_by_side(many)
    return compared(side_by_side([one]), found.full_windows())


def test_cells_lie_where_their_angles_say() -> None:
    for direction in range(9):
        for level in range(3):
            assert MIDDLES[cell_of(direction, level)] == pytest.approx(
                middle(direction, level), abs=1e-6
            )


@examples(40)
@given(clips(), st.lists(clips(), min_size=1, max_size=4))
def test_it_is_what_the_plain_one_says(one, many) -> None:
    wanted = [likeness(one, other, PARTS) for other in many]
    assert alike(one, many) == pytest.approx(wanted, abs=1e-5)


@examples(40)
@given(clips(), st.lists(clips(), min_size=1, max_size=4))
def test_it_is_the_same_however_many_are_worked_on_at_a_time(one, many) -> None:
    wanted = alike(one, many)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_ROWS", 4)
        assert alike(one, many) == pytest.approx(wanted, abs=1e-6)


@examples(40)
@given(clips(), clips())
def test_laws(one, two) -> None:
    (value,) = alike(one, [two])
    assert 0 <= value <= 1
    assert alike(one, [one])[0] == pytest.approx(1, abs=1e-5)
    assert alike(two, [one])[0] == pytest.approx(value, abs=1e-5)
    assert alike(mirrored(one), [mirrored(two)])[0] == pytest.approx(value, abs=1e-5)


@examples(40)
@given(clips(), st.lists(clips(), min_size=1, max_size=4))
def test_no_clip_is_more_like_than_its_bound(one, many) -> None:
    bounds = bounds_of(side_by_side([one]), side_by_side(many))
    assert (bounds.full >= alike(one, many) - 1e-5).all()


@examples(40)
@given(clips(), clips(), st.integers(4, 9))
def test_long_parts_are_compared_piece_by_piece(one, two, square) -> None:
    exact = alike(one, [one, two])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "SQUARE", square)
        patch.setattr(module, "LONGEST", 1)
        found = alike(one, [one, two])
        assert found[0] == pytest.approx(1, abs=1e-5)
        assert found[1] <= exact[1] + 1e-5
        assert alike(two, [one])[0] == pytest.approx(found[1], abs=1e-5)
        bounds = bounds_of(side_by_side([one]), side_by_side([one, two]))
        assert (bounds.full >= found - 1e-5).all()


def test_the_work_of_long_parts_grows_with_their_length(monkeypatch) -> None:
    cells, plain = [], module._saving

    def saving(mine, other, before):
        cells.append(len(before))
        return plain(mine, other, before)

    monkeypatch.setattr(module, "_saving", saving)
    rows = np.arange(20_000)
    long = {"r_arm": np.zeros(len(rows), SYMBOL)}
    long["r_arm"]["direction"], long["r_arm"]["start"] = rows % 8, rows
    long["r_arm"]["stop"] = rows + (rows > 0)
    assert alike(long, [long])[0] == 1
    assert sum(cells) < 2 * len(rows) * 1024


@examples(40)
@given(clips(), clips(most=12), st.integers(0, 60), st.integers(1, 90))
def test_a_stretch_is_as_like_as_the_clip_cut_from_it(one, two, begin, length) -> None:
    query, clip = side_by_side([one]), side_by_side([two])
    window = clip.windows(np.array([0]), np.array([begin]), np.array([begin + length]))
    piece = clip.cut(0, begin, begin + length)
    (inside,) = compared(query, window)
    assert inside == pytest.approx(compared(query, piece.full_windows())[0], abs=1e-5)


@examples(40)
@given(clips(), clips(most=12), st.integers(0, 60), st.integers(1, 90))
def test_no_stretch_is_more_like_than_its_bound(one, two, begin, length) -> None:
    query, clip = side_by_side([one]), side_by_side([two])
    window = clip.windows(np.array([0]), np.array([begin]), np.array([begin + length]))
    most = bounds_of(query, clip).of(window)
    assert most[0] >= compared(query, window)[0] - 1e-5


@examples(40)
@given(clips(), clips())
def test_what_corresponds_saves_what_is_not_different(one, two) -> None:
    query, clip = side_by_side([one]), side_by_side([two])
    sizes = query.moves.sizes.sum() + clip.moves.sizes.sum()
    saved = sum(pair.saving for part in range(3) for pair in pairs(query, clip, part))
    begun = 0.0
    for (a, end), (b, last) in zip(query.first, clip.first, strict=True):
        if a < end and b < last:
            apart = np.linalg.norm(query.moves.points[a] - clip.moves.points[b])
            swings = query.moves.swings[a], clip.moves.swings[b]
            begun += sum(swings) - abs(swings[0] - swings[1]) - 0.5 * apart
    wanted = np.clip(1 - (sizes - saved - begun) / (sizes + 1), 0, 1)
    assert compared(query, clip.full_windows())[0] == pytest.approx(wanted, abs=1e-4)


@examples(40)
@given(clips(), st.lists(clips(), min_size=1, max_size=6), st.integers(1, 3))
def test_the_nearest_are_the_nearest_of_all(one, many, limit) -> None:
    source = source_of(many, [RATE] * len(many), PARTS, [200] * len(many))
    found = nearest(side_by_side([one]), 1e6, source, limit)
    every = sorted((value for value in alike(one, many) if value > 0), reverse=True)
    assert [near.likeness for near in found.near] == pytest.approx(every[:limit], abs=1e-6)
    assert found.sure
