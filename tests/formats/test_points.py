"""Named points → Motion: units and axes checked by the body, gaps, a hierarchy for loose joints."""

from fractions import Fraction

import numpy as np
import pytest

import lanindex
from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.body import Declared
from lanindex.errors import BodyError
from lanindex.formats import File, Wanted
from lanindex.formats.points import Points, motion_of
from lanindex.model import Reading

FILE = File("x.csv", b"")


@pytest.fixture(scope="module")
def compass():
    return lanindex.read("corpus/compass.bvh")


def points(motion, declared: Declared = Declared(), **options) -> Points:  # noqa: B008
    """Return a motion's joints as a file in metres with z up has them."""
    places = motion.positions[..., [0, 2, 1]].astype(float) * [1, -1, 1] / 1000
    return Points(motion.skeleton.names, places, motion.rate, declared, **options)


@pytest.mark.parametrize(
    ("declared", "doubts"),
    [
        (Declared(), ()),
        (Declared("m", "z"), ()),
        (Declared("mm", "z"), ("says mm, in which its leg is 1 mm: m believed",)),
        (
            Declared("m", "y"),
            ("says that y is up, but the body stands along z: that believed",),
        ),
        (Declared("furlong", "w"), ()),
    ],
)
def test_what_a_file_states_is_held_against_the_body(compass, declared, doubts) -> None:
    motion = motion_of(points(compass, declared), FILE, "csv", Reading(), Wanted())
    assert motion.warnings == doubts
    assert (motion.source.scale, motion.source.up) == (1000, "z")
    for joint in JOINTS:
        one, other = (it.positions[:, it.skeleton.body[JOINT_CODES[joint]]]
                      for it in (motion, compass))  # fmt: skip
        assert np.abs(one - other).max() < 0.01, joint


def test_what_a_user_says_is_believed(compass) -> None:
    told = Reading("cm", "z", Fraction(60))
    motion = motion_of(points(compass, Declared("m", "z")), FILE, "csv", told, Wanted())
    assert (motion.source.unit, motion.source.up, motion.warnings) == ("cm", "z", ())


def test_loose_joints_hang_together_as_a_body_does(compass) -> None:
    motion = motion_of(points(compass), FILE, "csv", Reading(), Wanted())
    names, parents = motion.skeleton.names, motion.skeleton.parents.tolist()
    body = {joint: int(motion.skeleton.body[JOINT_CODES[joint]]) for joint in JOINTS}
    assert parents[body["RElbow"]] == body["RShoulder"]
    assert parents[body["LHip"]] == body["Pelvis"]
    assert parents[body["Neck"]] == body["Chest"]
    assert [parents[number] for number in range(20, len(names))] == [-1] * (len(names) - 20)
    rest = motion.skeleton.offsets
    assert rest[body["LElbow"]][0] > 100  # its arms to the sides, facing +z
    assert rest[body["RElbow"]][0] < -100
    assert rest[body["RKnee"]][1] < -300


def test_gaps_are_kept_and_never_looked_at(compass) -> None:
    held = points(compass)
    wrist = compass.skeleton.names.index("RightHand")
    held.places[100:200, wrist] = np.nan
    held.places[0] = np.nan
    motion = motion_of(held, FILE, "csv", Reading(), Wanted(True))
    unknown = np.isnan(motion.positions[:, motion.skeleton.body[JOINT_CODES["RWrist"]], 0])
    assert np.flatnonzero(unknown).tolist() == [0, *range(100, 200)]
    assert motion.skeleton.played()["RWrist"] == "RightHand"
    assert motion.warnings == ("21 gaps left open",)  # that, and all joints in the first frame


def test_short_gaps_are_said(compass) -> None:
    held = points(compass)
    wrist = compass.skeleton.names.index("RightHand")
    for start, stop in ((50, 56), (100, 107), (200, 201), (838, 840)):
        held.places[start:stop, wrist, 1] = np.nan
    motion = motion_of(held, FILE, "csv", Reading(), Wanted(True))
    assert motion.warnings == ("2 gaps of at most 0.2 s filled", "2 gaps left open")


def test_a_joint_that_is_never_known_is_absent(compass) -> None:
    held = points(compass)
    held.places[:, compass.skeleton.names.index("LeftForeArm")] = np.nan
    motion = motion_of(held, FILE, "csv", Reading(), Wanted())
    assert "LElbow" not in motion.skeleton.played()


def test_nothing_known_is_no_body(compass) -> None:
    held = points(compass)
    held.places[:] = np.nan
    with pytest.raises(BodyError, match=r"x\.csv: no point is known in any frame"):
        motion_of(held, FILE, "csv", Reading(), Wanted())


def test_rotations_are_turned_with_the_axes(compass) -> None:
    turns = np.zeros((*compass.positions.shape[:2], 4))
    turns[..., 0] = turns[..., 3] = np.sqrt(0.5)  # a quarter about the file's z, which is up
    parents = tuple(compass.skeleton.parents.tolist())
    held = points(compass, Declared("m", "z"), parents=parents, rotations=turns)
    motion = motion_of(held, FILE, "csv", Reading(), Wanted())
    assert motion.rotations[5, 3] == pytest.approx([np.sqrt(0.5), 0, np.sqrt(0.5), 0])
    assert motion.skeleton.names == compass.skeleton.names
