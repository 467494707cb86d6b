"""The axes of a skeleton at rest, and of joints that turn."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lanindex import animate, read, read_lnd
from lanindex.alphabet import JOINT_CODES
from lanindex.body.axes import axes_of, rest_axes, seen_axes
from lanindex.formats.bvh import write
from lanindex.model import Skeleton

LINES = "#unit0\ntwist head_turn right 40 0 0\n#unit1\ntwist head_turn left 60 1 2\n"


@pytest.fixture(scope="module")
def standing() -> Skeleton:
    return animate(read_lnd(LINES), rate=30).skeleton


def test_a_body_that_stands_at_rest(standing):
    axes = rest_axes(standing.parents.tolist(), standing.offsets, standing.body)
    assert axes.tolist() == [[-1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize("angle", [0, 40, 190])
def test_a_rest_may_face_anywhere(standing, angle):
    about = Rotation.from_euler("y", angle, degrees=True)
    axes = rest_axes(standing.parents.tolist(), about.apply(standing.offsets), standing.body)
    assert axes == pytest.approx(about.apply([[-1, 0, 0], [0, 1, 0]]), abs=1e-6)


def test_bones_along_one_axis_tell_nothing(standing):
    lengths = np.linalg.norm(standing.offsets, axis=1)
    along = np.stack((lengths, 0 * lengths, 0 * lengths), axis=1)
    assert rest_axes(standing.parents.tolist(), along, standing.body) is None
    without = standing.body.copy()
    without[JOINT_CODES["LHip"]] = -1
    assert rest_axes(standing.parents.tolist(), standing.offsets, without) is None


UPRIGHT = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
"""Columns: where a joint's own x, y and z point of who faces +z; x is up, y ahead, -z right."""


def seen(standing: Skeleton, motion, head, chest=UPRIGHT):
    """Return the axes seen in frames whose head and chest are turned so."""
    upper = standing.body[JOINT_CODES["Head"]]
    return seen_axes(
        standing.parents,
        standing.body,
        motion.positions,
        lambda joint: np.tile(head if joint == upper else chest, (len(motion), 1, 1)),
    )


@pytest.fixture(scope="module")
def still():
    return animate(read_lnd("#unit0\n#unit1\nfoot r_support place mid 0 0 1\n"), rate=30)


@pytest.mark.parametrize("angle", [0, 15, 45, -58])
def test_a_chest_tells_its_axes_to_the_head(standing, still, angle):
    about = Rotation.from_euler("y", angle, degrees=True).as_matrix()
    lower = np.array([[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]])  # looks down
    for head in (about, lower @ about):
        axes = seen(standing, still, head @ UPRIGHT)
        assert axes.tolist() == [[0, 0, -1], [1, 0, 0]]
        turned = UPRIGHT @ axes.T
        assert turned[:, 0].tolist() == [-1, 0, 0]
        assert turned[:, 1].tolist() == [0, 1, 0]


@pytest.mark.parametrize("about", ["x", "y", "z"])
def test_a_head_with_other_axes_is_not_told(standing, still, about):
    for angle in (-90, 90):
        other = Rotation.from_euler(about, angle, degrees=True).as_matrix()
        assert seen(standing, still, UPRIGHT @ other) is None


def test_a_chest_whose_axes_lie_askew_tells_nothing(standing, still):
    askew = Rotation.from_euler("y", 40, degrees=True).as_matrix()
    assert seen(standing, still, UPRIGHT, askew @ UPRIGHT) is None
    gap = replace(still, positions=np.full_like(still.positions, np.nan))
    assert seen(standing, gap, UPRIGHT) is None
    without = standing.body.copy()
    without[JOINT_CODES["LShoulder"]] = -1
    assert seen_axes(standing.parents, without, still.positions, lambda _: UPRIGHT[None]) is None


def test_axes_turn_as_joints_do(standing):
    turns = Rotation.random(5, random_state=1)
    rotations = np.tile(turns.as_quat()[:, None, [3, 0, 1, 2]], (1, len(standing.names), 1))
    found = axes_of(standing, rotations.astype(np.float32))["Head"]
    for number, axis in enumerate(([-1, 0, 0], [0, 1, 0])):
        assert found[:, number] == pytest.approx(turns.apply(axis), abs=1e-6)
    assert axes_of(standing, None) == {}


def test_bvh_keeps_how_a_head_is_turned(tmp_path: Path):
    motion = animate(read_lnd(LINES), rate=30)
    path = tmp_path / "head.bvh"
    path.write_bytes(write(motion))
    for only in (True, False):
        again = read(path, body_only=only)
        assert again.axes["Head"] == pytest.approx(motion.axes["Head"], abs=1e-4)
        assert again.positions.shape[1] == (20 if only else len(motion.skeleton.names))


def test_bvh_keeps_a_head_that_only_the_chest_tells(captures: Path, tmp_path: Path):
    motion = read(captures / "bvh/bandai1/dataset-1_walk-left_normal_001.bvh")
    path = tmp_path / "head.bvh"
    path.write_bytes(write(motion))
    assert read(path).axes["Head"] == pytest.approx(motion.axes["Head"], abs=1e-4)


@pytest.mark.parametrize(
    ("name", "there"),
    [
        ("bvh/cmu_cgspeed/cmu_12_01_walk.bvh", True),
        ("amc/cmu/02_01.amc", True),
        ("mvnx/subalakshmi_upperbody.mvnx", True),
        ("gltf/CesiumMan.glb", True),
        ("bvh/bandai1/dataset-1_bow_normal_001.bvh", True),
        ("bvh/bandai1/dataset-1_walk-left_normal_001.bvh", True),
        ("bvh/rokoko/jesse_dance.bvh", False),
        ("bvh/mae_openni/wave/ko_wave1.bvh", False),
        ("c3d/qualisys_ezc3d.c3d", False),
    ],
)
def test_whose_head_is_told(captures: Path, name: str, there: bool):
    assert ("Head" in read(captures / name, body_only=True).axes) == there
