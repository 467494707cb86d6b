"""The stick figure of a motion."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from motions import motion_of, swung

import lanindex
from lanindex.alphabet import JOINT_CODES, TRACKS
from lanindex.errors import EncodeError, UsageError
from lanindex.film.figure import JOINTS, NOSTRIL, Strokes, View, faced, figure

SIDES = ("r_", "l_")


def body_with(*gone: str) -> np.ndarray:
    body = swung(1, 30, Fraction(30), 0.0)
    body[:, [JOINT_CODES[joint] for joint in gone]] = np.nan
    return body


def test_each_joint_but_the_pelvis_has_a_bone() -> None:
    found = figure(motion_of(body_with(), Fraction(30)))
    assert sorted(found.bones[:, 1].tolist()) == list(range(1, 21))
    assert (len(found), found.rate) == (30, 30)


def test_every_track_has_bones() -> None:
    found = figure(motion_of(body_with(), Fraction(30)))
    for track in TRACKS:
        sides = {
            part[:2] for part, own in zip(found.parts, found.shown([track]), strict=True) if own
        }
        assert sides, track
        if track.startswith(SIDES):
            assert sides == {track[:2]}


def test_a_way_leaves_limbs_to_what_matched_beside_it() -> None:
    found = figure(motion_of(body_with(), Fraction(30)))
    for track in ("body_travel", "body_turn"):
        lit = found.shown([track])
        assert {part for part, own in zip(found.parts, lit, strict=True) if own} == {"torso"}


def test_what_is_absent_is_left_out_and_nothing_is_invented() -> None:
    gone = ("Chest", "RHand", "LToe", "Pelvis")
    found = figure(motion_of(body_with(*gone), Fraction(30)))
    ends = found.bones[:, 1].tolist()
    assert not {JOINT_CODES[joint] for joint in gone} & {*ends}
    assert (JOINT_CODES["Pelvis"], JOINT_CODES["Neck"]) in [
        tuple(it) for it in found.bones.tolist()
    ]
    middle = found.places[:, [JOINT_CODES["RHip"], JOINT_CODES["LHip"]]].mean(axis=1)
    assert np.allclose(found.places[:, 0], middle, atol=1e-3)
    shown = found.shown(["r_hand"])
    assert [part for part, own in zip(found.parts, shown, strict=True) if own] == ["r_forearm"]


def test_a_gap_stays_a_gap() -> None:
    body = body_with()
    body[10:12, JOINT_CODES["RWrist"], 1] = np.inf
    found = figure(motion_of(body, Fraction(30)))
    unknown = np.isnan(found.places[:, JOINT_CODES["RWrist"]])
    assert unknown.all(axis=1).nonzero()[0].tolist() == [10, 11]
    assert not unknown[12:].any()


def test_a_calibration_pose_is_not_shown() -> None:
    body = body_with()
    found = figure(motion_of(body, Fraction(30), first=2))
    assert (found.places[:2, :20] == body[2].astype(np.float32)).all()


def test_what_has_no_body_is_refused() -> None:
    nothing = np.full((5, 20, 3), np.nan)
    with pytest.raises(EncodeError, match="no bone of a body"):
        figure(motion_of(nothing, Fraction(30)))
    with pytest.raises(EncodeError, match="no frames"):
        figure(motion_of(body_with()[:0], Fraction(30)))
    with pytest.raises(UsageError, match='no part "arm"'):
        figure(motion_of(body_with(), Fraction(30))).shown(["arm"])


@pytest.mark.parametrize("name", ["mvnx/*", "csv/kinect/*.csv", "c3d/**/*.c3d"])
def test_real_captures_have_figures(name: str, captures: Path) -> None:
    path = next(iter(sorted(captures.glob(name))), None)
    if path is None:
        pytest.skip(f"no {name}")
    found = figure(lanindex.read(path))
    lengths = np.diff(found.places[:, found.bones], axis=2)[:, :, 0]
    middle = np.nanmedian(np.sqrt((lengths * lengths).sum(axis=-1)), axis=0)
    assert ((middle > 10) & (middle < 800)).all()


def looking(found, frame: int = 0) -> np.ndarray:
    way = found.places[frame, JOINTS["Nose"]] - found.places[frame, JOINTS["Head"]]
    return way / np.linalg.norm(way)


def test_the_nose_is_where_the_head_looks() -> None:
    motion = motion_of(body_with(), Fraction(30))
    hips = motion.positions[0, JOINT_CODES["LHip"]] - motion.positions[0, JOINT_CODES["RHip"]]
    ahead = np.cross(hips, (0, 1, 0))
    assert np.allclose(looking(figure(motion)), ahead / np.linalg.norm(ahead), atol=1e-5)
    axes = np.tile(np.array([[0, 0, -1], [0, 1, 0]], np.float32), (30, 1, 1))  # right, up
    axes[1] = np.nan
    own = figure(replace(motion, axes={"Head": axes}))
    assert np.allclose(looking(own), (-1, 0, 0), atol=1e-5)
    assert np.allclose(looking(own, 1), looking(figure(motion)), atol=1e-5)


@pytest.mark.parametrize(("turn", "over"), [(0, True), (-90, True), (90, True), (180, False)])
def test_a_nose_is_seen_from_the_front_and_the_side(turn: int, over: bool) -> None:
    """It is drawn over the head from the front, beside it from the side, behind it from behind."""
    body = faced(figure(motion_of(body_with(), Fraction(30))), np.arange(30))
    seen = body.places[0] @ View(turn, 0).axes().T
    strokes = Strokes(body).of(seen[:, :2], seen[:, 2], [False] * len(body.bones))
    head = next(it for it in strokes if it[3] == "head")
    nose = next(it for it in strokes if it[2] == NOSTRIL)
    beside = np.linalg.norm(np.subtract(nose[1], head[1])) > head[2] / 2
    assert beside == (abs(turn) == 90)
    assert (beside or strokes.index(nose) > strokes.index(head)) == over
