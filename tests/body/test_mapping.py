"""Joints without a hierarchy map to the same body by name; derived joints."""

from fractions import Fraction

import numpy as np
import pytest
from bvh_bodies import SCHEMES, SIMPLE, named, person

from lanindex import formats
from lanindex.alphabet import JOINTS
from lanindex.body import body_of, map_body
from lanindex.body.mapping import DERIVED_JOINTS, weighted_sum
from lanindex.errors import BodyError
from lanindex.model import Motion, Reading, Skeleton

RATE = Fraction(30)


def understood(motion: Motion, names: tuple[str, ...], parents: tuple[int, ...] | None):
    places = motion.positions.astype(np.float64)
    return map_body(names, parents, places, places[:2], RATE, Reading("mm", "y"), "x.trc")


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_hierarchy_is_not_needed_where_names_tell(scheme):
    motion = formats.read("x.bvh", data=person(names=named(SCHEMES[scheme]), ends=False))
    names = motion.skeleton.names
    joined = understood(motion, names, tuple(motion.skeleton.parents.tolist()))
    loose = understood(motion, names, None)
    roles = dict(zip(JOINTS, joined.body.tolist(), strict=True))
    found = dict(zip(JOINTS, loose.body.tolist(), strict=True))
    # Where trunk and arms part, and the tip of a foot whose name says nothing, need a hierarchy.
    differing = {joint: found[joint] for joint in JOINTS if found[joint] != roles[joint]}
    assert differing.keys() <= {"Chest", "LToe", "RToe"}
    assert all(index == -1 for joint, index in differing.items() if joint != "Chest")
    assert (loose.unit, loose.up, loose.first) == (joined.unit, joined.up, joined.first)


def test_without_hierarchy_and_names_there_is_no_body():
    motion = formats.read("x.bvh", data=person())
    names = tuple(f"M{number}" for number in range(len(motion.skeleton.names)))
    with pytest.raises(BodyError, match=r"x\.trc: no human skeleton.* with --body FILE"):
        understood(motion, names, None)


def test_joints_in_one_place_are_no_limb_without_a_hierarchy():
    motion = formats.read("x.bvh", data=person(ends=False))
    names = motion.skeleton.names
    places = motion.positions.copy()
    places[:, names.index(SIMPLE["LElbow"])] = places[:, names.index(SIMPLE["LShoulder"])]
    still = Motion(motion.skeleton, RATE, places, motion.source)
    assert understood(still, names, None).body[JOINTS.index("LElbow")] == -1


def test_a_middle_is_bit_for_bit_the_mean():
    left, right = np.random.default_rng(1).normal(size=(2, 99, 3)) * 1e3
    left[5, 1] = np.nan
    middle = weighted_sum([(left, 0.5), (right, 0.5)])
    assert np.array_equal(middle, np.stack([left, right]).mean(axis=0), equal_nan=True)
    assert np.isnan(middle[5, 1])


def test_a_regression_is_a_weighted_sum_and_changes_nothing_else():
    one, other, third = np.random.default_rng(2).normal(size=(3, 9, 3))
    before = one.copy()
    made = weighted_sum([(one, 0.2), (other, 0.5), (third, -1.3)])
    assert made == pytest.approx(0.2 * one + 0.5 * other - 1.3 * third)
    assert np.array_equal(one, before)


def test_made_joints_are_of_the_body_and_whole():
    for joint, shares in DERIVED_JOINTS.items():
        assert {joint, *shares} <= set(JOINTS)
        assert sum(shares.values()) == 1
        assert not shares.keys() & DERIVED_JOINTS.keys()  # none is made of what is made itself


def test_joints_that_stay_are_joined_to_the_nearest_above():
    body = np.full(20, -1, np.int16)
    body[[0, 3]] = 3, 1
    offsets = np.array([(1, 0, 0), (0, 2, 0), (0, 0, 4), (8, 0, 0)], np.float32)
    skeleton = Skeleton(("a", "b", "c", "d"), np.array([-1, 0, 1, 2], np.int16), offsets, body)
    kept, small = body_of(skeleton)
    assert kept.tolist() == [1, 3]
    assert small.names == ("b", "d")
    assert small.parents.tolist() == [-1, 0]
    assert small.offsets.tolist() == [[1, 2, 0], [8, 0, 4]]
    assert small.played() == {JOINTS[0]: "d", JOINTS[3]: "b"}


def test_the_first_joint_of_a_file_counts_like_any_other():
    motion = formats.read("x.bvh", data=person(ends=False))
    order = [motion.skeleton.names.index(SIMPLE["RWrist"])]
    order += [joint for joint in range(len(motion.skeleton.names)) if joint not in order]
    names = tuple(motion.skeleton.names[joint] for joint in order)
    places = motion.positions[:, order].astype(np.float64)
    places[0, 0] += 10_000  # in a frame: the wrist leaves a calibration pose
    found = map_body(names, None, places[1:], places[:2], RATE, Reading("mm", "y"))
    assert found.first == 1
