"""Real C3D files, their clips, and what other readers see."""

import warnings
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from lanindex import formats
from lanindex.alphabet import JOINTS
from lanindex.errors import BodyError
from lanindex.formats.c3d import places, scan
from lanindex.model import Motion, Span

TIPS = {"RHand", "LHand"}
ARMS_ONLY = {side + joint for side in "RL" for joint in ("Knee", "Ankle", "Toe", "Hand")}
LEGS = {"Pelvis", *(side + joint for side in "RL" for joint in ("Hip", "Knee", "Ankle"))}
TRUNK = set(JOINTS) - LEGS
LEFT_AND_LEGS = {"Head", "LElbow", "LHand", "LShoulder", "LWrist"} | ARMS_ONLY - {"RHand"}
# file: frames, rate, set, joints that are missing, what is doubted
FILES = {
    "c3dorg_Eb015pi": (450, 50, "clusters of markers", TRUNK, "sideways"),
    "c3dorg_Eb015vi": (450, 50, "clusters of markers", TRUNK, "sideways"),
    "c3dorg_sgi_int": (89, 50, "clusters of markers", TRUNK, "sideways"),
    "qualisys_ezc3d": (340, 200, "ISB names (Qualisys, Visual3D)", set(), "says that -z is up"),
    "rehazenter_2014001_C1_01": (387, 100, "ISB names (Qualisys, Visual3D)", {"Head"}, ""),
    "theia_rotations": (340, 85, "Theia", TIPS, ""),
    "vicon_pig_59993_Static": (371, 100, "Plug-in Gait", set(), ""),
    "vicon_pig_Movement_trial": (323, 120, "Plug-in Gait", set(), ""),
    "vicon_upperbody_25hz": (670, 25, "Plug-in Gait", ARMS_ONLY, "may be misnamed"),
    "vicon_upperbody_ezc3d": (580, 100, "right upper limb (S2M, Montreal)", LEFT_AND_LEGS, ""),
}


@pytest.fixture(params=FILES)
def name(request) -> str:
    return request.param


def motion(captures: Path, name: str) -> Motion:
    return formats.read(captures / "c3d" / f"{name}.c3d")


def test_what_is_seen(captures, name):
    frames, rate, markers, missing, doubt = FILES[name]
    found = motion(captures, name)
    assert (len(found), found.rate, found.source.set) == (frames, rate, markers)
    assert (found.source.unit, found.source.up) == ("mm", "z")
    assert set(JOINTS) - found.skeleton.played().keys() == missing
    feet = {"RAnkle", "LAnkle"} & missing
    assert any("no two feet" in warning for warning in found.warnings) == bool(feet)
    doubts = [it for it in found.warnings if " gap" not in it and "no two feet" not in it]
    assert len(doubts) == bool(doubt), doubts
    assert all(doubt in warning for warning in doubts)


def test_what_has_no_body(captures):
    with pytest.raises(BodyError, match="no human skeleton"):
        motion(captures, "optotrak_unlabelled")


def body(motion: Motion) -> dict[str, np.ndarray]:
    return {
        joint: motion.positions[:, index].astype(float)
        for joint, index in zip(JOINTS, motion.skeleton.body, strict=True)
        if index >= 0
    }


def test_labels_say_what_is_done(captures):
    lifted = body(motion(captures, "vicon_upperbody_ezc3d"))["RWrist"][:, 1]
    assert np.nanmin(lifted) < 300
    assert np.nanmax(lifted) > 850
    raised = body(motion(captures, "vicon_upperbody_25hz"))
    for side in "RL":
        above = raised[side + "Wrist"][:, 1] - raised[side + "Shoulder"][:, 1]
        assert above.min() < -300
        assert above.max() > 200
    fallen = body(motion(captures, "vicon_pig_Movement_trial"))["Pelvis"][:, 1]
    assert fallen[0] - fallen[-1] > 700
    still = body(motion(captures, "vicon_pig_59993_Static"))
    assert np.nanmax(np.ptp(still["Pelvis"], axis=0)) < 60
    walked = body(motion(captures, "qualisys_ezc3d"))["Pelvis"]
    assert 2400 < np.linalg.norm((walked[-1] - walked[0])[[0, 2]]) < 2600


def test_clusters_walk(captures):
    """Knees bend backwards, one leg after the other; no foot is above the knee."""
    for name in ("c3dorg_Eb015pi", "c3dorg_sgi_int"):
        at = body(motion(captures, name))
        forward = np.cross([0, 1, 0], at["RHip"] - at["LHip"])
        for side in "RL":
            thigh, shank = (
                at[side + one] - at[side + other]
                for one, other in (("Knee", "Hip"), ("Ankle", "Knee"))
            )
            cos = (thigh * shank).sum(axis=1)
            cos /= np.linalg.norm(thigh, axis=1) * np.linalg.norm(shank, axis=1)
            bent = np.degrees(np.arccos(cos))
            stiff = (name, side) == ("c3dorg_Eb015pi", "L")
            assert (20 if stiff else 40) < np.nanmax(bent) < 80, (name, side)
            assert np.nanmin(bent) < 20
            behind = (forward * (shank - thigh)).sum(axis=1)[bent > 20]
            assert (behind < 0).mean() > 0.9, (name, side)
            assert np.nanmedian(at[side + "Ankle"][:, 1]) < 130
            assert 750 < np.nanmedian(at[side + "Hip"][:, 1]) < 950


def test_bodies_have_human_sizes(captures, name):
    at = body(motion(captures, name))
    for joints, least, most in (("Hip Knee Ankle", 650, 950), ("Shoulder Elbow Wrist", 430, 640)):
        for side in "RL":
            chain = [at.get(side + joint) for joint in joints.split()]
            if all(place is not None for place in chain):
                bones = pairwise(chain)
                length = sum(np.nanmedian(np.linalg.norm(a - b, axis=1)) for a, b in bones)
                assert least < length < most, (side, joints, length)


def every(captures: Path) -> list[Path]:
    return sorted((captures / "c3d").glob("*.c3d"))


def there(data: bytes) -> np.ndarray:
    return places(data, scan(formats.File("x.c3d", data)))


def test_clips_are_the_sources_frames(captures):
    for path in every(captures):
        data = path.read_bytes()
        whole, cut = there(data), formats.cutter(formats.opened(path))
        for start, stop in ((0, len(whole)), (3, 20), (len(whole) - 1, len(whole))):
            clip = cut(Span(start, stop))
            assert np.array_equal(there(clip), whole[start:stop], equal_nan=True), path
            assert scan(formats.File("x.c3d", clip)).doubts == []


def test_clips_of_bodies_are_read(captures, name):
    path = captures / "c3d" / f"{name}.c3d"
    whole = formats.read(path)
    clip = formats.cutter(formats.opened(path))(Span(30, 80))
    again = formats.read("clip.c3d", data=clip, up=whole.source.up)
    assert np.array_equal(again.markers.positions, whole.markers.positions[30:80], equal_nan=True)
    if whole.source.set == "clusters of markers":
        return  # fewer frames tell the joints less well
    order = [again.skeleton.names.index(joint) for joint in whole.skeleton.names]
    np.testing.assert_allclose(again.positions[:, order], whole.positions[30:80], atol=8.0)


def test_integers_of_intel_and_dec_are_the_same(captures):
    one, other = ((captures / "c3d" / f"c3dorg_Eb015{it}.c3d").read_bytes() for it in ("pi", "vi"))
    assert np.array_equal(there(one), there(other), equal_nan=True)


def test_places_are_those_of_ezc3d(captures, tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    for path in every(captures):
        if path.stem == "c3dorg_sgi_int":
            continue  # it does not read MIPS
        clip = tmp_path / "clip.c3d"
        clip.write_bytes(formats.cutter(formats.opened(path))(Span(5, 25)))
        for one in (path, clip):
            told = ezc3d.c3d(str(one))["data"]
            theirs = told["points"][:3].transpose(2, 1, 0)
            if path.stem == "theia_rotations":
                theirs = told["rotations"][:3, 3].transpose(2, 1, 0)
            ours = there(one.read_bytes())
            assert np.array_equal(ours, theirs.astype(np.float32), equal_nan=True), one


def test_places_are_those_of_c3d(captures, tmp_path):
    c3d = pytest.importorskip("c3d")
    for path in every(captures):
        if path.stem == "theia_rotations":
            continue  # it does not read files without points
        clip = tmp_path / "clip.c3d"
        clip.write_bytes(formats.cutter(formats.opened(path))(Span(5, 25)))
        for one in (path, clip):
            with warnings.catch_warnings(), one.open("rb") as file:
                warnings.simplefilter("ignore")
                theirs = np.array([rows for _, rows, _ in c3d.Reader(file).read_frames()])
            theirs[theirs[..., 3] < 0] = np.nan
            ours = there(one.read_bytes())
            assert np.array_equal(ours, theirs[..., :3].astype(np.float32), equal_nan=True), one
