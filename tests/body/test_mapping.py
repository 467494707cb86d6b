"""Joints without a hierarchy map to the same body by name; derived joints."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from bvh_bodies import SCHEMES, SIMPLE, named, person

from lanindex import formats
from lanindex.alphabet import JOINTS
from lanindex.body import body_of, map_body
from lanindex.encoding.joints import body as joints_of_body
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


def test_a_missing_pelvis_is_bit_for_bit_the_mean_of_the_hips():
    motion = formats.read("x.bvh", data=person(ends=False))
    played = motion.skeleton.body.copy()
    played[JOINTS.index("Pelvis")] = -1
    motion = replace(motion, skeleton=replace(motion.skeleton, body=played))
    found = joints_of_body(motion)
    hips = np.stack([found["RHip"], found["LHip"]])
    assert np.array_equal(found["Pelvis"], hips.mean(axis=0))


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
