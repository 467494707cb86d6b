"""Motions written as C3D read back equal, here and in other programs."""

from fractions import Fraction

import numpy as np
import pytest
from made_c3d import c3d, standing

from lanindex import formats
from lanindex.formats.c3d import names_of, places, scan, write
from lanindex.model import Motion, Skeleton, Source


def motion(names: tuple[str, ...], positions: np.ndarray, rate: Fraction = Fraction(30)) -> Motion:
    """Return a motion of loose points."""
    count = len(names)
    skeleton = Skeleton(
        names,
        np.full(count, -1, np.int16),
        np.zeros((count, 3), np.float32),
        np.full(20, -1, np.int16),
    )
    return Motion(skeleton, rate, positions, Source("made", "bvh", "mm", 1.0, "y"))


def loose(frames: int, count: int) -> np.ndarray:
    return np.random.default_rng(7).normal(0, 500, (frames, count, 3)).astype(np.float32)


def opened(data: bytes):
    layout = scan(formats.File("x.c3d", data))
    return layout, places(data, layout)


@pytest.mark.parametrize(("frames", "count"), [(1, 1), (7, 3), (70_000, 2), (3, 300), (3, 700)])
def test_points_are_read_back_to_the_last_bit(frames, count):
    positions = loose(frames, count)
    positions[0, -1] = np.nan
    names = tuple(f"joint {number} ä" for number in range(count))
    layout, found = opened(write(motion(names, positions, Fraction(30000, 1001))))
    assert layout.doubts == []
    assert np.array_equal(found, positions, equal_nan=True)
    assert tuple(names_of(layout).values()) == names
    assert layout.rate == pytest.approx(30000 / 1001)


def test_a_point_at_zero_is_not_unknown():
    _, found = opened(write(motion(("a", "b"), np.zeros((2, 2, 3), np.float32))))
    assert np.abs(found).max() < 1e-5


def test_long_names_are_cut():
    layout, _ = opened(write(motion(("ä" * 100, "b"), loose(2, 2))))
    assert list(names_of(layout).values()) == ["ä" * 63, "b"]


def test_joints():
    source = formats.read("corpus/compass.bvh")
    again = formats.read("x.c3d", data=write(source))
    assert (again.rate, again.source.unit, again.source.up) == (source.rate, "mm", "y")
    assert again.warnings == ()
    assert again.skeleton.played() == source.skeleton.played()
    order = [again.skeleton.names.index(name) for name in source.skeleton.names]
    assert np.array_equal(again.positions[:, order], source.positions)


def test_markers():
    points = standing(20)
    points[4, 5, 3] = -1
    source = formats.read("x.c3d", data=c3d(points))
    again = formats.read("x.c3d", data=write(source))
    assert again.markers.names == source.markers.names
    assert np.array_equal(again.markers.positions, source.markers.positions, equal_nan=True)
    np.testing.assert_allclose(again.positions, source.positions, atol=1e-3)


def test_others_read_it(tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    positions = loose(9, 300)
    positions[3, 4] = np.nan
    path = tmp_path / "x.c3d"
    path.write_bytes(write(motion(tuple(f"m{it}" for it in range(300)), positions)))
    theirs = ezc3d.c3d(str(path))["data"]["points"][:3].transpose(2, 1, 0)
    assert np.array_equal(theirs.astype(np.float32), positions, equal_nan=True)
