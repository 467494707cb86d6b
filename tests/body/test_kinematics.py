"""Kinematics: array code = plain loops = scipy."""

import numpy as np
import plain_kinematics
from both_loops import plain_and_compiled
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lanindex.body import kinematics


@st.composite
def skeletons(draw):
    joints = draw(st.integers(1, 8))
    parents = [-1] + [draw(st.integers(-1 if j > 5 else 0, j - 1)) for j in range(1, joints)]
    number = st.sampled_from([0.0, 0.0, 1.5, -10.0, 37.25])
    offsets = [[draw(number) for _ in range(3)] for _ in range(joints)]
    codes = st.lists(st.integers(0, 5), max_size=7)
    channels = [draw(codes) for _ in range(joints)]
    return parents, offsets, channels


@st.composite
def movements(draw):
    parents, offsets, channels = draw(skeletons())
    width = sum(map(len, channels))
    seed = draw(st.integers(0, 10_000))
    frames = draw(st.integers(1, 5))
    numbers = np.random.default_rng(seed)
    values = numbers.uniform(-400, 400, (frames, width))
    values[numbers.random(values.shape) < 0.2] = draw(st.sampled_from([0.0, 90.0, -180.0, 1e6]))
    return parents, offsets, channels, values


@given(movements(), st.booleans())
def test_arrays_are_the_plain_loops(movement, child_first):
    parents, offsets, channels, values = movement
    work = kinematics.plan(parents, offsets, channels, child_first)
    plain, compiled = plain_and_compiled(lambda: kinematics.positions(work, values))
    assert np.array_equal(plain, compiled)
    loops = plain_kinematics.positions(parents, offsets, channels, values.tolist(), child_first)
    reach = 1.0 + np.abs(values).max(initial=0)
    np.testing.assert_allclose(plain, np.array(loops), atol=1e-9 * reach)


@given(movements())
def test_parent_first_is_what_scipy_gives(movement):
    parents, offsets, channels, values = movement
    work = kinematics.plan(parents, offsets, channels)
    places = kinematics.positions(work, values)
    for frame, numbers in enumerate(values.tolist()):
        numbers = iter(numbers)
        turns = []
        for joint, parent in enumerate(parents):
            shift, turn = list(offsets[joint]), Rotation.identity()
            for code in channels[joint]:
                if code < 3:
                    shift[code] = next(numbers)
                else:
                    turn *= Rotation.from_euler("xyz"[code - 3], next(numbers), degrees=True)
            above = turns[parent] if parent >= 0 else Rotation.identity()
            turns.append(above * turn)
            wanted = above.apply(shift) + (places[frame, parent] if parent >= 0 else 0)
            np.testing.assert_allclose(places[frame, joint], wanted, atol=1e-6)


@given(movements(), st.booleans(), st.integers(0, 7))
def test_vectors_turn_with_a_joint_as_what_hangs_on_it_does(movement, child_first, joint):
    parents, offsets, channels, values = movement
    joint, axes = min(joint, len(parents) - 1), np.array([[0.0, 1, 0], [0.6, 0, 0.8]])
    work = kinematics.plan(parents, offsets, channels, child_first)
    aimed = kinematics.aimed(work, channels, joint, axes)
    longer = kinematics.plan(
        [*parents, joint, joint], [*offsets, *axes.tolist()], [*channels, [], []], child_first
    )
    places = kinematics.positions(longer, values)
    wanted = places[:, -2:] - places[:, [joint]]
    reach = 1.0 + np.abs(places).max(initial=0)
    for found in plain_and_compiled(lambda: kinematics.positions(aimed, values)):
        np.testing.assert_allclose(found[:, -2:], wanted, atol=1e-9 * reach)


@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=30))
def test_sine_and_cosine(degrees):
    angles = np.array(degrees)
    sine, cosine = kinematics.sine_cosine(angles)
    reduced = np.radians(np.remainder(angles, 360.0))
    np.testing.assert_allclose(sine, np.sin(reduced), atol=3e-15)
    np.testing.assert_allclose(cosine, np.cos(reduced), atol=3e-15)
    np.testing.assert_allclose(sine**2 + cosine**2, 1, atol=1e-15)


def test_right_angles_are_exact():
    sine, cosine = kinematics.sine_cosine(np.array([0.0, 90.0, 180.0, 270.0, -90.0, 720.0]))
    assert sine.tolist() == [0, 1, 0, -1, -1, 0]
    assert cosine.tolist() == [1, 0, -1, 0, 0, 1]


def test_positions_replace_the_offset_each_coordinate_for_itself():
    channels = [[0, 1, 2], [1]]
    work = kinematics.plan([-1, 0], [[9, 9, 9], [1, 2, 3]], channels)
    places = kinematics.positions(work, np.array([[4.0, 5, 6, 70]]))
    assert places.tolist() == [[[4, 5, 6], [5, 75, 9]]]


def test_many_frames_are_done_in_blocks():
    values = np.linspace(0, 360, 1500)[:, None]
    work = kinematics.plan([-1, 0], [[0, 0, 0], [1, 0, 0]], [[5], []])
    places, compiled = plain_and_compiled(lambda: kinematics.positions(work, values))
    assert np.array_equal(places, compiled)
    np.testing.assert_allclose(places[:, 1, 0], np.cos(np.radians(values[:, 0])), atol=1e-12)


def test_depth_needs_no_recursion():
    joints = 5000
    parents, offsets = [*range(-1, joints - 1)], [[0, 1, 0]] * joints
    work = kinematics.plan(parents, offsets, [[3]] + [[]] * (joints - 1))
    for places in plain_and_compiled(lambda: kinematics.positions(work, np.array([[90.0]]))):
        np.testing.assert_allclose(places[0, -1], [0, 1, joints - 1], atol=1e-9)
