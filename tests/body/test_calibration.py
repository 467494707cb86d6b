"""Unit, vertical axis, calibration pose and rate, declared or derived from the body."""

import math
from fractions import Fraction

import bvh_bodies
import numpy as np
import pytest
from bvh_bodies import SIMPLE, hierarchy, motion, person, played, still
from hypothesis import given
from hypothesis import strategies as st

from lanindex import formats
from lanindex.alphabet import JOINT_CODES
from lanindex.body.calibration import (
    AXES,
    UNITS,
    body_lengths,
    first_frame,
    on_four_legs,
    shape_doubts,
    uneven_doubt,
    up_of,
)
from lanindex.errors import CaptureError, UsageError
from lanindex.formats.rates import nearest_rate

IN_CENTIMETRES = {"mm": 10.0, "cm": 1.0, "m": 0.01, "inch": 1 / 2.54, "inch/0.45": 0.45 / 2.54}


def joint(motion, name: str) -> np.ndarray:
    return motion.positions[:, motion.skeleton.body[JOINT_CODES[name]]]


@pytest.mark.parametrize("unit", UNITS)
def test_units_are_told_from_the_leg(unit):
    motion = formats.read("x.bvh", data=person(scale=IN_CENTIMETRES[unit]))
    assert motion.source.unit == f"{unit} (detected)"
    assert motion.source.scale == UNITS[unit]
    assert motion.warnings == ()
    leg = np.linalg.norm(joint(motion, "RKnee") - joint(motion, "RHip"), axis=1)
    np.testing.assert_allclose(leg, 420, rtol=1e-5)
    np.testing.assert_allclose(
        motion.skeleton.offsets[motion.skeleton.names.index("LKnee")], [0, -420, 0], rtol=1e-5
    )


@pytest.mark.parametrize("unit", UNITS)
def test_units_are_told_from_the_arm_where_there_is_no_leg(unit):
    names = {r: n for r, n in SIMPLE.items() if r[1:] not in ("Knee", "Ankle", "Toe")}
    data = person(names=names, scale=IN_CENTIMETRES[unit])
    assert formats.read("x.bvh", data=data).source.unit == f"{unit} (detected)"


def test_a_stated_unit_is_believed():
    motion = formats.read("x.bvh", data=person(), unit="m")
    assert (motion.source.unit, motion.source.scale) == ("m", 1000)
    assert formats.read("x.bvh", data=person(), unit="IN").source.scale == 25.4
    with pytest.raises(UsageError, match="unit 'foot', wanted one of mm, cm"):
        formats.read("x.bvh", data=person(), unit="foot")


def test_a_size_that_fits_no_unit_is_doubted():
    motion = formats.read("x.bvh", data=person(scale=0.12))
    (warning,) = motion.warnings
    assert "its leg is" in warning
    assert "--unit" in warning


@pytest.mark.parametrize("up", AXES)
def test_any_axis_can_be_up(up):
    # the file's axes: coordinate `source` of the file is `sign` times coordinate k of the T-pose
    axes = [(0, 1)] * 3
    for k, (source, sign) in enumerate(AXES[up]):
        axes[source] = (k, sign)
    root = [0.0, 0.0, 0.0]
    root["xyz".index(up[-1])] = -92.0 if up[0] == "-" else 92.0
    text = still(hierarchy(axes=axes), root=root)
    motion = formats.read("x.bvh", data=text.encode(), up=up)
    upright = formats.read("x.bvh", data=person())
    np.testing.assert_allclose(motion.positions, upright.positions, atol=1e-2)
    np.testing.assert_allclose(motion.skeleton.offsets, upright.skeleton.offsets, atol=1e-2)
    assert motion.source.up == up
    if up[-1] != "x":  # a body along x lies on its side rather than in a file with x up
        detected = formats.read("x.bvh", data=text.encode())
        assert detected.source.up == up
        assert detected.warnings == ()


def test_axes_are_turns_not_mirrors():
    for table in AXES.values():
        turn = np.zeros((3, 3))
        for k, (source, sign) in enumerate(table):
            turn[k, source] = sign
        assert np.linalg.det(turn) == pytest.approx(1)
    for up, table in AXES.items():
        assert table[1] == ("xyz".index(up[-1]), -1 if up[0] == "-" else 1)


def test_a_body_that_is_not_upright_is_doubted():
    text = still(hierarchy(), root=(0, 20, 0, 90, 0, 0))
    motion = formats.read("x.bvh", data=text.encode())
    assert motion.source.up == "y"
    assert any("not upright" in warning for warning in motion.warnings)
    assert formats.read("x.bvh", data=text.encode(), up="y").warnings == ()
    with pytest.raises(UsageError, match="up axis 'w', wanted one of y, z"):
        formats.read("x.bvh", data=text.encode(), up="w")


UPRIGHT = {
    "Ankle": (0, 8),
    "Knee": (5, 48),
    "Hip": (0, 88),
    "Shoulder": (5, 138),
    "Wrist": (20, 90),
}
CROUCHED = {"Ankle": (0, 8), "Knee": (50, 30), "Hip": (45, 80), "Shoulder": (110, 65)}
CROUCHED |= {"Wrist": (110, 8), "Neck": (120, 66)}


def seen(forward: int, up: int, *poses: dict[str, tuple[int, int]]) -> np.ndarray:
    """Return poses (S, 20, 3) of joints by how far forward and how high they are, in cm."""
    body = np.full((len(poses), 20, 3), np.nan)
    for pose, places in zip(body, poses, strict=True):
        for joint, (far, high) in places.items():
            for side, apart in (("R", 10), ("L", -10)) if joint != "Neck" else (("", 0),):
                pose[JOINT_CODES[side + joint]] = apart
                pose[JOINT_CODES[side + joint], [forward, up]] = far, high
    return body


@pytest.mark.parametrize("declared", [None, "z"])
def test_who_waits_for_the_start_and_then_runs_stands_upright(declared):
    upright = UPRIGHT | {"Neck": (5, 142)}
    body = seen(1, 2, *[CROUCHED] * 20, *[upright] * 12)
    assert up_of(body, None, declared, on_four_legs(body)) == ("z", ())
    body[:3, JOINT_CODES["Neck"]] = np.nan  # a marker that is hidden at first
    assert up_of(body, None, declared, on_four_legs(body)) == ("z", ())


FOX = (
    *(("Pelvis", None, (0, 50, 0)), ("Chest", "Pelvis", (0, 3, 32)), ("Neck", "Chest", (0, 6, 8))),
    ("Head", "Neck", (0, 6, 12)),
    *(
        (side + joint, side + above if above not in ("Pelvis", "Chest") else above, (x * out, y, z))
        for side, out in (("L", 1), ("R", -1))
        for joint, above, (x, y, z) in (
            ("Shoulder", "Chest", (6, -4, 4)),
            ("Elbow", "Shoulder", (0, -18, -5)),
            ("Wrist", "Elbow", (0, -22, 4)),
            ("Hand", "Wrist", (0, -4, 4)),
            ("Hip", "Pelvis", (6, -2, 0)),
            ("Knee", "Hip", (0, -20, 8)),
            ("Ankle", "Knee", (0, -20, -14)),
            ("Toe", "Ankle", (0, -6, 6)),
        )
    ),
)


def test_what_stands_on_four_legs_is_doubted_and_not_set_upright(monkeypatch):
    monkeypatch.setattr(bvh_bodies, "TREE", FOX)
    motion = formats.read("fox.bvh", data=person(scale=1.5))
    assert motion.source.up == "y"
    assert motion.warnings == (
        "perhaps no human: arms and legs stand across the trunk throughout, as if it had four legs",
    )


def doubts_of(pose: dict[str, tuple[int, int]]) -> tuple[str, ...]:
    """Return what is doubted of a body that stands so throughout."""
    body = seen(2, 1, *[pose] * 3)
    return shape_doubts(body, body_lengths(body), on_four_legs(body))


def test_limbs_that_no_human_has_are_doubted():
    long = UPRIGHT | {"Elbow": (5, 70), "Wrist": (5, 8)}
    (told,) = doubts_of(long)
    assert told == "perhaps no human: its arms are 1.6 times as long as its legs"
    assert doubts_of(UPRIGHT | {"Elbow": (5, 110)}) == ()


def test_a_body_without_feet_says_so():
    names = {role: name for role, name in SIMPLE.items() if role[1:] not in ("Ankle", "Toe")}
    motion = formats.read("x.bvh", data=person(names=names))
    assert motion.warnings[-1] == ("no two feet: neither steps and jumps nor what carries are told")


def test_exchanged_sides_are_doubted():
    names = {
        role: ("RL"["LR".index(role[0])] + role[1:] if role[1:2].isupper() else role)
        for role in SIMPLE
    }
    motion = formats.read("x.bvh", data=person(names=names))
    assert motion.warnings == ("the feet point backwards: left and right may be exchanged",)
    assert motion.skeleton.played() == played(SIMPLE)


def test_an_elbow_that_lies_at_the_wrist_is_doubted(captures):
    """In this file the marker RELB is one of the wrist's."""
    told = formats.read(captures / "c3d" / "vicon_upperbody_25hz.c3d").warnings
    assert told[0].startswith("right upper arm 512 mm, left 273; right forearm 93 mm, left 314: ")


def test_bones_that_are_known_on_one_side_are_not_doubted():
    body = np.full((3, 20, 3), np.nan)
    limbs = {"Hip": 900.0, "Knee": 500.0, "Ankle": 90.0}
    for side in "RL":
        for name, height in limbs.items():
            body[:, JOINT_CODES[side + name]] = 0, height, 0
    assert uneven_doubt(body, 1.0) == ()
    body[:, JOINT_CODES["LKnee"], 1] = 350
    assert uneven_doubt(body, 1.0) == (
        "right shank 410 mm, left 260: a joint or marker may be misnamed, or was badly seen",
    )
    body[:, JOINT_CODES["LAnkle"]] = np.nan
    assert uneven_doubt(body / 1000, 1000.0) == ()


@pytest.mark.parametrize("step", [79.0, 90.0])
def test_a_calibration_pose_is_a_first_frame_that_is_left_too_fast(step):
    width = person().split(b"\n")[-2].count(b" ") + 1
    frames = [[0, 92, 0] + [0.0] * (width - 3) for _ in range(4)]
    frames[0][0] = step  # 30 frames a second: 25 m/s are 83.3 cm a frame
    data = (hierarchy() + motion(frames)).encode()
    found = formats.read("x.bvh", data=data)
    assert found.first == int(step > 83)
    assert len(found) == 4
    assert bool(found.warnings) == (step > 83)


def test_one_frame_is_no_calibration_pose():
    motion = formats.read("x.bvh", data=person(1))
    assert (len(motion), motion.first) == (1, 0)


RATES = {
    "0.0333333": Fraction(30),
    "0.033333": Fraction(30),
    ".03333": Fraction(30),
    "0.0333667": Fraction(30000, 1001),
    "0.041708": Fraction(24000, 1001),
    "0.0083333": Fraction(120),
    "0.00833333": Fraction(120),
    "0.008342": Fraction(120000, 1001),
    "0.016683": Fraction(60000, 1001),
    "0.01": Fraction(100),
    "0.010000": Fraction(100),
    "1e-2": Fraction(100),
    "0.025": Fraction(40),
    "0.08": Fraction(25, 2),
    "0.016": Fraction(125, 2),
}


@pytest.mark.parametrize("time", RATES)
def test_rates_are_exact(time):
    data = person().replace(b"0.0333333", time.encode())
    assert formats.read("x.bvh", data=data).rate == RATES[time]


@given(st.integers(8, 1000), st.booleans(), st.integers(6, 12))
def test_rounded_frame_times_give_their_rate_back(frames, slow, digits):
    rate = Fraction(frames) * (Fraction(1000, 1001) if slow else 1)
    if 1 / rate * Fraction(19, 100_000) < Fraction(1, 2 * 10**digits):
        return  # rounded too coarsely to tell
    time = Fraction(f"{float(1 / rate):.{digits}f}")
    found = nearest_rate(1 / time)
    assert abs(found - rate) <= rate * Fraction(2, 10_000)
    if digits > 8:
        assert found == rate


@given(st.fractions(Fraction(1, 100), 100_000))
def test_a_rate_is_near_what_was_read(rate):
    assert abs(nearest_rate(rate) - rate) <= rate * Fraction(2, 10_000)


@pytest.mark.parametrize(
    ("given_rate", "wanted"), [(24, 24), (29.97, Fraction(30000, 1001)), ("60", 60), ("12.5", 12.5)]
)
def test_a_stated_rate_is_believed(given_rate, wanted):
    motion = formats.read("x.bvh", data=person(), rate=given_rate)
    assert motion.rate == Fraction(wanted)
    bad = person().replace(b"Frame Time: 0.0333333", b"Frame Time: 0")
    assert formats.read("x.bvh", data=bad, rate=given_rate).rate == Fraction(wanted)


@pytest.mark.parametrize("rate", [0, -1, 0.99, "nan", "x", 1e9, "1e999", "1_0"])
def test_a_stated_rate_must_make_sense(rate):
    with pytest.raises(UsageError, match="frames a second, wanted a number of 1 or more"):
        formats.read("x.bvh", data=person(), rate=rate)


@pytest.mark.parametrize("time", ["0.5", "1", "0.0001"])
def test_doubtful_rates_are_doubted(time):
    motion = formats.read("x.bvh", data=person().replace(b"0.0333333", time.encode()))
    (warning,) = motion.warnings
    assert "is unusual" in warning
    assert "--fps" in warning


@pytest.mark.parametrize(
    "time",
    [
        *("0", "-0.03", "nan", "inf", "1e999", "1e-999", "1e-999999999", "fast", "0,033", "1_0"),
        *("30", "1.01", "1e6"),  # a rate in the wrong place: minutes would become days
    ],
)
def test_frame_times_that_make_no_sense(time):
    data = person().replace(b"0.0333333", time.encode())
    line = data[: data.index(b"Frame Time")].count(b"\n") + 1
    with pytest.raises(CaptureError) as caught:
        formats.read("x.bvh", data=data)
    assert caught.value.place == f"x.bvh:{line}"
    assert repr(time) in caught.value.found
    assert caught.value.wanted == "seconds a frame, above 0 and at most 1"


def test_no_frame_time():
    data = person().replace(b"Frame Time: 0.0333333\n", b"")
    with pytest.raises(CaptureError, match="no Frame Time: line, wanted seconds a frame"):
        formats.read("x.bvh", data=data)
    assert formats.read("x.bvh", data=data, rate=30).rate == 30


def test_the_fall_from_a_calibration_pose_is_no_movement():
    speeds = np.array([60.0, 22.0, 13.0, 5.0, 0.7, 3.0])  # m/s

    def first(speeds: np.ndarray, rate: int) -> int:
        places = np.cumsum([0.0, *1000 * speeds / rate])
        return first_frame([[(x, 0, 0)] for x in places], Fraction(rate))

    assert first(speeds, 120) == 4
    assert first(speeds, 24) == 3  # a tenth of a second
    assert first(speeds / 10, 24) == 0
    assert first(np.array([60.0, 3.0, 3.1, 3.0, 2.9]), 120) == 2  # an arm that swings already


def test_wrists_that_are_not_seen_tell_no_calibration_pose():
    assert first_frame([[(math.nan, 0, 0)], [(500, 0, 0)], [(0, 0, 0)]], Fraction(120)) == 0
    assert first_frame([[(0, 0, 0)], [(500, 0, 0)], [(math.nan, 0, 0)]], Fraction(120)) == 1
