"""Converted motions keep the positions of their joints."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lanindex
from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.encoding.limbs import heading
from lanindex.errors import ExportError, UsageError
from lanindex.formats.animation import complete
from lanindex.model import Skeleton, Span
from lanindex.pipeline.convert import TARGETS, file_content, from_origin, stretch, target_of
from lanindex.pipeline.library import open_library

NEAR = 0.01  # mm


def read(content: bytes, form: str):
    return lanindex.read(f"x.{form}", data=content)


def assert_same(one, other) -> None:
    """The joints of the body that both have lie where they lay, frame by frame."""
    assert (len(one), one.rate) == (len(other), other.rate)
    both = 0
    for joint in JOINTS:
        here, there = (it.skeleton.body[JOINT_CODES[joint]] for it in (one, other))
        if here < 0 or there < 0:
            continue
        both += 1
        known = np.isfinite(one.positions[:, here]).all(axis=1)
        apart = np.abs(one.positions[known, here] - other.positions[known, there]).max(initial=0)
        assert apart < NEAR, joint
    assert both >= 9


@pytest.fixture(scope="module")
def compass():
    return lanindex.read("corpus/compass.bvh")


def loose(motion, gap: slice = slice(0, 0)):
    """Return a motion's body as joints that hang on nothing, one of them unknown for a while."""
    body = motion.skeleton.body
    places = motion.positions[:, body].copy()
    places[gap, JOINT_CODES["RWrist"]] = np.nan
    none = np.full(len(JOINTS), -1, np.int16)
    skeleton = Skeleton(JOINTS, none, np.zeros((20, 3), np.float32), np.arange(20, dtype=np.int16))
    return replace(motion, skeleton=skeleton, positions=places)


@pytest.mark.parametrize("form", TARGETS)
def test_every_format_holds_every_motion(compass, form: str) -> None:
    for motion in (compass, loose(compass), stretch(compass, Span(100, 131))):
        content, said = file_content(motion, form)
        assert said == ()
        assert_same(motion, read(content, form))


@pytest.mark.parametrize("form", TARGETS)
def test_gaps_are_kept_or_said(compass, form: str) -> None:
    motion = loose(compass, slice(50, 90))
    content, said = file_content(motion, form)
    found = read(content, form)
    assert_same(motion, found)
    wrist = found.positions[:, found.skeleton.body[JOINT_CODES["RWrist"]]]
    unknown = np.isnan(wrist).any(axis=1)
    if form in ("bvh", "glb"):
        assert not unknown.any()
        assert said == ("0.2% of its places are unknown: they are filled in straight lines",)
        ends = motion.positions[[49, 90], JOINT_CODES["RWrist"]]
        assert wrist[70] == pytest.approx(ends[0] + (ends[1] - ends[0]) * 21 / 41, abs=NEAR)
    else:
        assert np.flatnonzero(unknown).tolist() == list(range(50, 90))
        assert said == ()


def test_one_skeleton_is_left_as_it_is(compass) -> None:
    assert complete(compass) is compass


def test_what_is_never_known_is_left_out(compass) -> None:
    places = compass.positions.copy()
    elbow = compass.skeleton.names.index("RightForeArm")
    places[:, elbow] = np.nan
    found = complete(replace(compass, positions=places))
    assert "RightForeArm" not in found.skeleton.names
    hand = found.skeleton.names.index("RightHand")
    above = found.skeleton.names[found.skeleton.parents[hand]]
    assert above == "RightArm"
    with pytest.raises(ExportError, match="no body to speak of"):
        complete(
            replace(loose(compass), positions=np.full((5, 20, 3), np.nan, np.float32), axes={})
        )


def test_the_origin_is_below_and_ahead_is_forward(compass) -> None:
    turn = np.radians(130)
    ring = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
    places = (compass.positions @ ring.T + [500, 300, -900]).astype(np.float32)
    found = from_origin(replace(compass, positions=places))
    assert np.abs(found.positions - from_origin(compass).positions).max() < 0.01
    assert np.degrees(heading(found, found.rate)[0]) + 90 == pytest.approx(0, abs=0.01)
    pelvis = found.positions[0, found.skeleton.body[JOINT_CODES["Pelvis"]]]
    assert pelvis[[0, 2]] == pytest.approx([0, 0], abs=0.01)
    assert np.nanmin(found.positions[:, found.skeleton.body]) < 100


def test_targets_by_ending() -> None:
    assert [target_of(f"walk.{form}") for form in TARGETS] == list(TARGETS)
    assert target_of("walk", "trc") == "trc"
    for path in ("walk", "walk.fbx", "walk."):
        with pytest.raises(UsageError, match="one of bvh"):
            target_of(path)


@pytest.mark.parametrize("form", TARGETS)
def test_clips_in_another_format(tmp_path: Path, form: str) -> None:
    with open_library(tmp_path / "l.db", create=True) as library:
        library.ingest("corpus/compass.bvh")
        hits = library.search("r_arm right mid")[:1]
        (row,) = library.export(hits, tmp_path / "out", format=form)
        (moved,) = library.export(hits, tmp_path / "moved", format=form, origin=True)
    span = hits[0].span
    source = lanindex.read("corpus/compass.bvh")
    clip = stretch(source, span)
    assert row["clip"] == f"compass_{span.start}-{span.stop}.{form}"
    assert_same(clip, lanindex.read(tmp_path / "out" / row["clip"]))
    assert_same(
        from_origin(stretch(source, span)), lanindex.read(tmp_path / "moved" / moved["clip"])
    )
