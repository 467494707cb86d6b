"""Palm directions from knuckles, thumbs, markers and a suit's segments."""

from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from lanindex import encode, read, read_lnd
from lanindex.alphabet import JOINT_CODES
from lanindex.body.axes import facing, measured_palms, planes, rest_palms
from lanindex.body.markers import marker_set_of
from lanindex.encoding.limbs import heading
from lanindex.perform import perform

THUMBS_ALONE = ("RightHand", "RThumb", "RThumb End", "RFingers")
BODY = np.full(20, -1, np.int16)
BODY[JOINT_CODES["RWrist"]], BODY[JOINT_CODES["RHand"]] = 0, 3


def angle(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return degrees between unit vectors."""
    return np.degrees(np.arccos(np.clip(np.sum(one * other, axis=-1, dtype=float), -1, 1)))


def seen(name: Path, hand: str) -> np.ndarray:
    """Return where a palm of a capture faces: forward, up and to the right of the body."""
    motion = read(name, body_only=True)
    turn = heading(motion, motion.rate)
    front, up, right = motion.axes[hand][:, 0].T.astype(float)
    sine, cosine = np.sin(turn), np.cos(turn)
    return np.stack((front * cosine - right * sine, up, front * sine + right * cosine), axis=1)


@pytest.mark.parametrize(("hand", "out"), [("RHand", -1.0), ("LHand", 1.0)])
def test_hands_that_hang_with_thumbs_ahead_face_each_other(hand, out):
    palm, fingers = facing(hand, np.array([1.0, 0, 0]), np.array([0.1, -2.0, 0]))
    assert palm == pytest.approx([0, 0, out])  # forward x, up y, right z
    assert fingers == pytest.approx([0.05, -1, 0], abs=2e-3)


def test_lines_that_are_nearly_one_tell_nothing():
    assert np.isnan(facing("RHand", np.array([0.1, 1, 0]), np.array([0.0, 1, 0]))).all()
    assert np.isnan(facing("RHand", np.zeros((4, 3)), np.ones((4, 3)))).all()


@pytest.mark.parametrize(
    "names",
    [
        ("mixamorig:LeftHandIndex1", "mixamorig:LeftHandPinky1", "mixamorig:LeftHandThumb1"),
        ("lIndex1", "lPinky1", "lHand"),
        ("left_index1", "left_pinky1", "left_wrist"),
        ("f_index.01.L", "f_pinky.01.L", "hand.L"),
        ("J_Bip_L_Index1", "J_Bip_L_Little1", "J_Bip_L_Hand"),
        ("index_01_l", "ring_01_l", "hand_l"),
        ("leftIndexProximal", "leftLittleProximal", "leftHand"),
        tuple(f"Bip01 L {it}" for it in ("Finger1", "Finger4", "Finger0", "Hand", "Forearm")),
    ],
)
def test_knuckles_are_known_by_name(names):
    assert planes(names) == {"LHand": (0, 1, 0)}


def test_one_finger_is_no_plane():
    assert planes(("LeftHandIndex1", "LeftHandIndex2", "LeftHandThumb1")) == {}


@pytest.mark.parametrize("aside", [0.0, -8.0, 8.0])
def test_a_thumb_of_a_hand_along_an_axis_lies_in_its_plane(aside):
    places = [[0, 0, 0], [0, 0, 0], [-29, aside, 29], [-35, 0, 0]]
    joint, palm = rest_palms(THUMBS_ALONE, (-1, 0, 1, 0), places, BODY)["RHand"]
    assert joint == 0
    assert palm == pytest.approx(np.array([[0.0, -1, 0], [-1, 0, 0]]))


def test_a_thumb_of_a_hand_along_no_axis_is_believed():
    places = [[0, 0, 0], [0, 0, 0], [-29, 8, 29], [-25, -25, 0]]
    _, palm = rest_palms(THUMBS_ALONE, (-1, 0, 1, 0), places, BODY)["RHand"]
    assert 5 < angle(palm[0], np.array([0.5**0.5, -(0.5**0.5), 0])) < 60
    assert palm[0] @ [-29, 8, 29] == pytest.approx(0)


def test_the_joint_in_which_fingers_begin_turns_the_palm():
    names = ("RightHand", "RightFingerBase", "RFingers", "RThumb", "RThumb End")
    body = BODY.copy()
    body[JOINT_CODES["RHand"]] = 2
    places = [[0, 0, 0], [0, 0, 0], [-35, 0, 0], [0, 0, 0], [-29, 0, 29]]
    assert rest_palms(names, (-1, 0, 1, 0, 3), places, body)["RHand"][0] == 1


def test_a_thumb_without_length_tells_nothing():
    places = [[0, 0, 0], [0, 0, 0], [0, 0, 0], [-35, 0, 0]]
    assert rest_palms(THUMBS_ALONE, (-1, 0, 1, 0), places, BODY) == {}


LINES = """#unit_total 4
#unit0
direction r_upper_arm place low 0 0
direction r_forearm place low 0 0
direction r_palm left mid 0 0
#unit1
direction r_forearm forward mid 1 2
{}
"""


def test_a_palm_that_never_turns_by_itself_is_left_out():
    still = perform(read_lnd(LINES.format("")), rate=60)
    turned = perform(read_lnd(LINES.format("direction r_palm place high 4 5")), rate=60)
    for motion, gone in ((still, True), (turned, False)):
        kept, said = measured_palms(motion.axes, motion.positions, motion.skeleton.body)
        assert ("RHand" not in kept) == gone == bool(said)
    assert said == ()
    axes = {"RHand": still.axes["RHand"][:60]}
    kept, _ = measured_palms(axes, still.positions[:60], still.skeleton.body)
    assert "RHand" in kept  # the elbow has not bent: nobody knows


def test_markers_tell_palms():
    names = ["LSHO", "RSHO", "C7", "RELB", "RWRA", "RWRB", "RFIN", "LELB", "LWRA", "LWRB"]
    assert marker_set_of(names).palms == {"RHand": (4, 5, 6)}
    both = [f"{side}_{it}" for side in "RL" for it in ("SAJ", "HLE", "RSP", "UHE", "HM2", "HM5")]
    assert marker_set_of([*both, "CV7"]).palms == {"RHand": (4, 5, 4), "LHand": (10, 11, 10)}


WALKS = (
    *("amc/cmu/02_01.amc", "bvh/cmu_cgspeed/cmu_12_01_walk.bvh"),
    *("bvh/sfu_moda/AV_8Walk_Meredith_HVHA_Rep1.bvh", "c3d/qualisys_ezc3d.c3d"),
    *("c3d/rehazenter_2014001_C1_01.c3d", "c3d/vicon_pig_Movement_trial.c3d"),
)


@pytest.mark.parametrize("name", WALKS)
def test_palms_of_walkers_face_their_thighs(captures: Path, name: str):
    for hand, side in (("RHand", -1), ("LHand", 1)):
        front, up, right = np.median(seen(captures / name, hand), axis=0)
        assert right * side > 0.55
        assert front < 0.2
        assert up < 0


def test_two_formats_of_one_take_tell_the_same_palms(captures: Path):
    amc, bvh = (
        read(captures / name, body_only=True).axes
        for name in ("amc/cmu/01_01.amc", "bvh/cmu_cgspeed/01_01.bvh")
    )
    for hand in ("RHand", "LHand"):  # the BVH begins with a pose
        assert angle(amc[hand][1:, 0], bvh[hand][2:, 0]).max() < 0.05


@pytest.mark.parametrize("form", ["bvh", "gltf"])
@pytest.mark.parametrize(
    "name",
    ["bvh/sfu_moda/AV_8Walk_Meredith_HVHA_Rep1.bvh", "bvh/cmu_cgspeed/cmu_12_01_walk.bvh"],
)
def test_files_that_are_written_keep_palms(captures: Path, tmp_path: Path, name: str, form: str):
    motion = read(captures / name)
    write = import_module(f"lanindex.formats.{form}").write
    path = tmp_path / {"bvh": "a.bvh", "gltf": "a.glb"}[form]
    path.write_bytes(write(motion))
    again = read(path)
    for hand in ("RHand", "LHand"):
        assert angle(motion.axes[hand][:, 0], again.axes[hand][:, 0]).max() < 0.1


def test_a_hand_that_waves_faces_forward_and_palms_of_jacks_go_up(captures: Path):
    score = encode(read(captures / "bvh/optical_meta/wave_hello.bvh", body_only=True))
    shown = [it for it in score.symbols("r_palm") if not it.passing]
    assert ("forward", "mid") in [(it.direction, it.level) for it in shown]
    score = encode(read(captures / "bvh/cmu_retargeted/jumping_jacks.bvh", body_only=True))
    for part in ("r_palm", "l_palm"):
        assert {"low", "high"} <= {it.level for it in score.symbols(part)}


def test_a_suit_says_that_palms_face_down_at_rest(captures: Path):
    motion = read(captures / "mvnx/subalakshmi_upperbody.mvnx")
    assert {"RHand", "LHand"} <= motion.axes.keys()
    turns = motion.rotations[:, motion.skeleton.body[JOINT_CODES["RWrist"]]].astype(float)
    w, x, y, z = turns.T
    down = -np.stack((2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)), axis=1)
    assert angle(motion.axes["RHand"][:, 0], down).max() < 0.1


@pytest.mark.parametrize(
    "name",
    ["bvh/rokoko/jesse_dance.bvh", "bvh/bandai1/dataset-1_bow_normal_001.bvh",
     "bvh/mae_openni/clap/ah_clap1.bvh", "csv/kinect/Ges01_wavehand.csv"],
)  # fmt: skip
def test_of_others_nothing_is_told(captures: Path, name: str):
    motion = read(captures / name, body_only=True)
    assert not {"RHand", "LHand"} & motion.axes.keys()
    said = [it for it in motion.warnings if "_palm is left out" in it]
    assert len(said) == (2 if "rokoko" in name else 0)
    assert not {"r_palm", "l_palm"} & encode(motion).tracks.keys()


def test_gaps_and_unknown_frames_part_the_track():
    motion = perform(read_lnd(LINES.format("direction r_palm place high 4 5")), rate=60)
    axes = {"RHand": motion.axes["RHand"].copy()}
    axes["RHand"][200:300] = np.nan
    score = encode(replace(motion, axes=axes))
    assert [(it.start, it.stop) for it in score.tracks["r_palm"].known] == [
        (0, 200),
        (300, len(motion)),
    ]
    assert "l_palm" not in score.tracks
    assert "r_palm" not in encode(replace(motion, axes={})).tracks
