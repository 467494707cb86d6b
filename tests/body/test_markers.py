"""Markers → joints: sets as data, hips by regression, shoulders below their tops."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from lanindex import formats
from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.body.mapping import read_body_file
from lanindex.body.markers import BELL, SHOULDER_BELOW, marker_set_of
from lanindex.errors import BodyError, UsageError
from lanindex.formats.file import File, Wanted
from lanindex.formats.points import Points, motion_of
from lanindex.model import Reading

PELVIS = {  # forward x, up y, right z: width 240, depth 150
    "RASI": (0, 1000, 120),
    "LASI": (0, 1000, -120),
    "RPSI": (-150, 1000, 50),
    "LPSI": (-150, 1000, -50),
}
REST = {
    "RSHO": (0, 1500, 200),
    "LSHO": (0, 1500, -200),
    "RELB": (0, 1200, 220),
    "RWRA": (30, 950, 220),
    "RWRB": (-30, 950, 220),
    "RKNE": (0, 550, 130),
    "RANK": (0, 100, 130),
    "C7": (-80, 1550, 0),
    "CLAV": (60, 1450, 0),
}


def made(markers: dict[str, tuple], turn: np.ndarray | None = None, scale: float = 1.0):
    """Return how joints are made of some markers, and where they are, in mm."""
    marker_set = marker_set_of(tuple(markers))
    assert marker_set is not None
    places = np.array([list(markers.values())], float) / scale
    if turn is not None:
        places = places @ turn.T
    _, at = marker_set.over(places, scale, 1)
    return marker_set, dict(zip(marker_set.joints, at(slice(None))[0] * scale, strict=True))


def test_hips_by_the_regression_of_harrington() -> None:
    marker_set, found = made(PELVIS | REST)
    assert marker_set.set == "Plug-in Gait"
    assert found["RHip"] == pytest.approx([-45.9, 1000 - 82.9, 86.5])
    assert found["LHip"] == pytest.approx([-45.9, 1000 - 82.9, -86.5])
    assert found["Pelvis"] == pytest.approx([-45.9, 1000 - 82.9, 0])


@pytest.mark.parametrize("scale", [1.0, 10.0, 1000.0, 25.4])
def test_neither_place_nor_unit_matters(scale: float) -> None:
    rng = np.random.default_rng(3)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    _, still = made(PELVIS | REST)
    _, found = made(PELVIS | REST, turn, scale)
    for joint, place in still.items():
        assert found[joint] == pytest.approx(turn @ place), joint


def test_hips_by_the_two_in_front_alone() -> None:
    markers = {name: place for name, place in (PELVIS | REST).items() if "PSI" not in name}
    _, found = made(markers)
    up = np.array([-10.0, 500, 0])  # from the front to the neck
    forward, upwards, across = (share * 240 for share in BELL)
    up /= np.linalg.norm(up)
    ahead = np.cross(up, [0, 0, 1])
    wanted = np.array([0, 1000, 0]) + forward * ahead + upwards * up + [0, 0, across]
    assert found["RHip"] == pytest.approx(wanted, abs=1e-6)


def test_shoulders_lie_below_their_tops() -> None:
    _, found = made(PELVIS | REST)
    down = found["Pelvis"] - np.array([0, 1500, 0])
    away = SHOULDER_BELOW * 400 * down / np.linalg.norm(down)
    assert found["RShoulder"] == pytest.approx(np.array([0, 1500, 200]) + away)
    _, alone = made({name: REST[name] for name in ("RSHO", "LSHO", "RELB", "RWRA", "RWRB")})
    assert alone["RShoulder"] == pytest.approx([0, 1500, 200])  # no trunk tells which way is down


def test_a_middle_of_markers_and_a_single_one() -> None:
    marker_set, found = made(PELVIS | REST)
    assert found["RWrist"] == pytest.approx([0, 950, 220])
    assert found["RElbow"] == pytest.approx(REST["RELB"])
    told = marker_set.sources(tuple(PELVIS | REST))
    assert told["RWrist"] == "RWRA RWRB"
    assert told["RShoulder"] == "RSHO, below"
    assert told["RHip"] == "RASI LASI RPSI LPSI, by regression"
    assert told["Pelvis"] == "the middle of the hips"


def test_what_is_unknown_stays_so() -> None:
    names = tuple(PELVIS | REST)
    marker_set = marker_set_of(names)
    places = np.tile(np.array(list((PELVIS | REST).values()), float), (3, 1, 1))
    places[1, names.index("RWRB")] = np.nan
    places[2, names.index("LPSI")] = np.nan
    known, _ = marker_set.over(places, 1.0, 3)
    joints = marker_set.joints
    assert [joints[joint] for joint in np.flatnonzero(~known[1] & known[0])] == ["RWrist"]
    lost = {joints[joint] for joint in np.flatnonzero(~known[2] & known[0])}
    assert lost == {"RHip", "LHip", "Pelvis"}


@pytest.mark.parametrize("lost", [None, "LASI"])
@pytest.mark.parametrize("names", [tuple(PELVIS | REST), tuple({**PELVIS, "T10": 0, **REST})[1:]])
def test_many_frames_are_made_as_few_are(names: tuple[str, ...], lost: str | None) -> None:
    """Block by block: sizes and the way down from the shoulders are those of all frames."""
    rest = {**PELVIS, "T10": (-90, 1250, 0), **REST}
    numbers = np.random.default_rng(4)
    places = np.array([rest[name] for name in names]) + numbers.normal(0, 20, (50, len(names), 3))
    places[numbers.random(places.shape[:2]) < 0.05] = np.nan
    if lost is not None and lost in names:
        places[:, names.index(lost)] = np.nan
    marker_set = marker_set_of(names)
    whole = marker_set.over(places, 1.0, 50)[1](slice(None))
    for block in (1, 7, 50):
        known, at = marker_set.over(places, 1.0, block)
        np.testing.assert_array_equal(at(slice(None)), whole)
        np.testing.assert_array_equal(at(np.array([30, 3])), whole[[30, 3]])
        np.testing.assert_array_equal(known, np.isfinite(whole).all(axis=2))


@pytest.mark.parametrize(
    "names",
    [
        JOINTS,
        [f"{side}{joint}" for side in "RL" for joint in ("Hip", "Knee", "Ankle")],
        ["a", "b", "c"],
        ["RASI", "LASI", "C7"],
        [],
    ],
)
def test_joints_are_no_markers(names: list[str]) -> None:
    assert marker_set_of(tuple(names)) is None


def test_of_one_marker_no_two_joints_are_made() -> None:
    """A segment of one set is called as a joint of another: a hand, which begins at the wrist."""
    parts = ("uarm", "larm", "hand", "thigh", "shank", "foot")
    made = marker_set_of(["pelvis", *(f"{side}_{part}" for side in "rl" for part in parts)])
    assert made is not None
    assert made.set == "Theia"
    assert {"RWrist", "LWrist"} <= set(made.joints)
    assert not {"RHand", "LHand"} & set(made.joints)


def test_subjects_cases_and_separators_do_not_matter() -> None:
    names = tuple(f"Bob:{name.lower()}" for name in PELVIS | REST)
    assert marker_set_of(names).joints == marker_set_of(tuple(PELVIS | REST)).joints


def test_what_a_user_says_comes_first(tmp_path: Path) -> None:
    file = tmp_path / "body.toml"
    file.write_text('RWrist = "RWRA"\nRElbow = ["RSHO", "RWRB"]\n')
    marker_set = marker_set_of(tuple(PELVIS | REST), read_body_file(str(file)))
    told = marker_set.sources(tuple(PELVIS | REST))
    assert (told["RWrist"], told["RElbow"]) == ("RWRA", "RSHO RWRB")
    assert marker_set.set == "as told, Plug-in Gait"
    with pytest.raises(BodyError, match='no "nose" for Head'):
        marker_set_of(tuple(PELVIS | REST), {"Head": ("nose",)})


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("RWrst = 'a'", '"RWrst"'),
        ("RWrist = 3", "RWrist = 3"),
        ("RWrist = []", r"RWrist = \[\]"),
        ("", "nothing"),
        ("RWrist", "cannot be read"),
    ],
)
def test_what_no_user_can_say(tmp_path: Path, text: str, found: str) -> None:
    file = tmp_path / "body.toml"
    file.write_text(text)
    with pytest.raises(UsageError, match=found):
        read_body_file(str(file))


SETS = {
    "c3d/qualisys_ezc3d.c3d": ("ISB names (Qualisys, Visual3D)", 20),
    "c3d/rehazenter_2014001_C1_01.c3d": ("ISB names (Qualisys, Visual3D)", 19),
    "c3d/vicon_pig_59993_Static.c3d": ("Plug-in Gait", 20),
    "c3d/vicon_upperbody_25hz.c3d": ("Plug-in Gait", 12),
    "c3d/theia_rotations.c3d": ("Theia", 18),
    "trc/opencap_walk.trc": ("OpenCap, Pose2Sim with added markers", 16),
    "trc/opensim_rajagopal_walk.trc": ("OpenSim", 15),
}


@pytest.mark.parametrize(("name", "wanted"), SETS.items())
def test_real_sets_are_known(captures: Path, name: str, wanted: tuple[str, int]) -> None:
    motion = formats.read(captures / name)
    assert (motion.source.set, len(motion.source.made)) == wanted
    assert motion.markers is not None
    legs = [
        motion.positions[:, motion.skeleton.body[JOINT_CODES[f"{side}Hip"]], 1] for side in "RL"
    ]
    assert all(600 < np.nanmedian(hip) < 1200 for hip in legs) or "upperbody" in name


def motive(prefix: str = "") -> dict[str, tuple]:
    """Return a person with the markers of Motive's Baseline set, in the way of `REST`."""
    middle = {"HeadTop": (0, 1800, 0), "BackTop": (-80, 1550, 0), "Chest": (60, 1450, 0)}
    sides = {
        "Waist{}Front": (0, 1000, 120),
        "Waist{}Back": (-150, 1000, 50),
        "{}ShoulderTop": (0, 1500, 200),
        "{}ElbowOut": (0, 1200, 220),
        "{}WristOut": (30, 950, 220),
        "{}WristIn": (-30, 950, 220),
        "{}HandOut": (0, 850, 220),
        "{}KneeOut": (0, 550, 130),
        "{}AnkleOut": (0, 100, 130),
        "{}ToeIn": (120, 40, 110),
        "{}ToeOut": (120, 40, 150),
    }
    both = {
        name.format(side): (x, y, sign * z)
        for name, (x, y, z) in sides.items()
        for side, sign in (("R", 1), ("L", -1))
    }
    return {prefix + name: place for name, place in (middle | both).items()}


@pytest.mark.parametrize("prefix", ["", "Ada:", "Ada_", "take_2_"])
def test_markers_of_motive(prefix) -> None:
    marker_set, found = made(motive(prefix))
    _, of_vicon = made(PELVIS | REST)
    assert marker_set.set == "Motive, Qualisys Animation"
    for joint in of_vicon:
        assert found[joint] == pytest.approx(of_vicon[joint]), joint
    assert found["LToe"] == pytest.approx([120, 40, -130])
    assert found["RHand"] == pytest.approx([0, 850, 220])


def test_a_side_before_all_names_is_no_subject() -> None:
    names = tuple(f"R_{name}" for name in ("SAJ", "HLE", "HME", "RSP", "USP", "IAS", "IPS"))
    assert marker_set_of((*names, "R_LSAJ")) is None  # a right arm alone tells not where it faces
    assert marker_set_of((*names, "L_SAJ")).sources((*names, "L_SAJ"))["RElbow"] == "R_HLE R_HME"


def test_what_a_user_says_of_one_arm_makes_no_body() -> None:
    names = tuple(f"R{number}" for number in range(6))
    arm = {"RShoulder": ("R0",), "RElbow": ("R1",), "RWrist": ("R2",)}
    assert marker_set_of(names, arm) is None  # nobody knows where it faces
    assert marker_set_of(names, {"RShoulder": ("R0",), "LShoulder": ("R3",)}) is None  # no limb
    assert marker_set_of(names, arm | {"LShoulder": ("R3",)}) is not None


def test_who_says_joints_may_leave_the_subject_out(tmp_path) -> None:
    body = tmp_path / "body.toml"
    names = tuple(motive("Ada_"))
    for name in ("LElbowOut", "Ada_LElbowOut"):
        body.write_text(f'RElbow = "{name}"', "utf-8")
        assert (
            marker_set_of(names, read_body_file(str(body))).sources(names)["RElbow"]
            == "Ada_LElbowOut"
        )


def test_hips_and_legs_that_were_never_seen_are_not_found() -> None:
    markers = motive()
    places = np.tile(np.array(list(markers.values()), float), (9, 1, 1))
    unseen = [
        name.startswith(("Waist", "RKnee", "LKnee", "RA", "LA", "RT", "LT")) for name in markers
    ]
    places[:, unseen] = np.nan
    points = Points(tuple(markers), places, Fraction(60))
    motion = motion_of(points, File("x.trc", b""), "trc", Reading(), Wanted())
    found = {joint[1:] for joint in motion.skeleton.played() if joint[0] in "RL"}
    assert found == {"Shoulder", "Elbow", "Wrist", "Hand"}
    assert motion.warnings[-1].startswith("no two feet")
