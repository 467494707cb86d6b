from fractions import Fraction
from pathlib import Path

import numpy as np
import plain_bvh
import pybvh
import pytest
from effort import examples
from hypothesis import given
from hypothesis import strategies as st
from random_scores import scores
from scipy.spatial.transform import Rotation

from lanindex.errors import ExportError
from lanindex.formats import bvh
from lanindex.model import Motion, Score, Skeleton, Source
from lanindex.notation import lnd
from lanindex.perform import perform
from lanindex.rotation import euler

SCORE = lnd.read("""\
#speed=120
#unit0
direction r_arm left mid 0 0
direction torso place low 0 0
#unit1
direction r_arm right mid 0 2
direction l_arm place high 0 1
direction l_arm place mid 1 2
direction torso back mid 0 2
direction r_leg forward mid 0 1
direction r_shank back mid 1 2
direction head l_forward low 1 2
""")


@given(scores(), st.sampled_from([0.0, 2.0]))
@examples(15)
def test_it_reads_back(score: Score, noise: float) -> None:
    motion = perform(score, rate=12 * score.rate / score.frames, noise=noise)
    names, points, time = plain_bvh.positions(bvh.write(motion).decode())
    assert names == list(motion.skeleton.names)
    assert np.abs(points * 10 - motion.positions).max() < 0.05
    assert time == pytest.approx(float(1 / motion.rate))


def test_another_reader_agrees(tmp_path: Path) -> None:
    motion = perform(SCORE, rate=30)
    (tmp_path / "a.bvh").write_bytes(bvh.write(motion))
    read = pybvh.read_bvh_file(tmp_path / "a.bvh")
    assert np.abs(read.node_positions() * 10 - motion.positions).max() < 0.05
    assert read.fps == pytest.approx(30)


def test_angles_do_not_jump_by_whole_turns() -> None:
    lines = bvh.write(perform(SCORE, rate=120)).decode().split("Frame Time")[1].splitlines()[1:]
    numbers = np.array([[float(word) for word in line.split()] for line in lines])
    assert np.abs(np.diff(numbers, axis=0)).max() <= 180


@given(st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_angles_mean_the_rotation(quaternion: list[float]) -> None:
    turn = Rotation.from_quat(quaternion).as_matrix()
    again = Rotation.from_euler("ZXY", euler(turn[None])[0], degrees=True).as_matrix()
    assert np.abs(again - turn).max() < 1e-6


@pytest.mark.parametrize("x", [90.0, -90.0])
@pytest.mark.parametrize("z", [0.0, 30.0, 180.0])
def test_angles_at_a_quarter_turn(x: float, z: float) -> None:
    turn = Rotation.from_euler("ZXY", [z, x, 20.0], degrees=True).as_matrix()
    angles = euler(turn[None])[0]
    again = Rotation.from_euler("ZXY", angles, degrees=True).as_matrix()
    assert np.abs(again - turn).max() < 1e-6


@pytest.mark.parametrize(
    ("rate", "text"),
    [(30, "0.0333333333"), (60, "0.0166666667"), (Fraction(30000, 1001), "0.0333666667")],
)
def test_frame_time(rate: Fraction, text: str) -> None:
    assert f"Frame Time: {text}\n" in bvh.write(perform(SCORE, rate=rate)).decode()


def _motion(parents: list[int], points: list[list[float]]) -> Motion:
    count = len(parents)
    skeleton = Skeleton(
        tuple("abcdefg"[:count]),
        np.array(parents, np.int16),
        np.zeros((count, 3), np.float32),
        np.full(20, -1, np.int16),
    )
    source = Source("dance", "score", "mm", 1.0, "y")
    return Motion(skeleton, Fraction(30), np.array([points], np.float32), source)


def test_a_joint_without_children_gets_an_end() -> None:
    text = bvh.write(_motion([-1, 0], [[0, 0, 0], [10, 20, 30]])).decode()
    names, points, _ = plain_bvh.positions(text)
    assert names == ["a", "b", "b End"]
    assert points[0, 1:].tolist() == [[1, 2, 3], [1, 2, 3]]


def test_unknown_positions_are_refused() -> None:
    with pytest.raises(ExportError, match="dance: b is unknown in frame 0"):
        bvh.write(_motion([-1, 0], [[0, 0, 0], [10, np.nan, 30]]))


def test_several_roots_are_refused() -> None:
    with pytest.raises(ExportError, match="dance: the roots a, b, wanted one"):
        bvh.write(_motion([-1, -1], [[0, 0, 0], [10, 0, 30]]))


def test_a_chain_too_long_to_be_written_is_refused() -> None:
    count = 5000
    names = tuple(f"j{number}" for number in range(count))
    parents = np.arange(-1, count - 1, dtype=np.int16)
    skeleton = Skeleton(names, parents, np.ones((count, 3), np.float32), np.full(20, -1, np.int16))
    places = np.cumsum(np.ones((1, count, 3), np.float32), axis=1)
    motion = Motion(skeleton, Fraction(30), places, Source("a.glb", "gltf", "mm", 1.0, "y"))
    with pytest.raises(ExportError, match="5000 joints, each on the one before"):
        bvh.write(motion)
