"""MVNX: segments, people, damage, clips, and the real file."""

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from made_mvnx import NAMES, POINTS, REST, TREE, mvnx, subject
from scipy.spatial.transform import Rotation

from lanindex import formats
from lanindex.alphabet import JOINTS
from lanindex.errors import CaptureError
from lanindex.formats import mvnx as reader
from lanindex.formats.file import File
from lanindex.model import Motion, Reading, Span

GOOD = mvnx(subject())
LEGS = ("Knee", "Ankle", "Toe")


def read(data: bytes, meant: str = "", **told: object) -> Motion:
    file = File("ada.mvnx", data, meant)
    return formats.read_file(file, Reading(**told), formats.Wanted())  # type: ignore[arg-type]


@pytest.mark.parametrize("version", ["3", "4"])
def test_joints_are_where_segments_begin(version: str) -> None:
    found = read(mvnx(subject(), version=version))
    assert (found.rate, len(found), found.warnings) == (60, 5, ())
    assert (found.source.format, found.source.unit, found.source.up) == ("mvnx", "m", "z")
    played = found.skeleton.played()
    assert played.keys() == set(JOINTS)
    wanted = {"Hip": "UpperLeg", "Knee": "LowerLeg", "Ankle": "Foot", "Toe": "Toe"}
    wanted |= {"Shoulder": "UpperArm", "Elbow": "ForeArm", "Wrist": "Hand", "Hand": "Hand End"}
    for side, word in (("R", "Right"), ("L", "Left")):
        assert {joint: played[side + joint] for joint in wanted} == {
            joint: word + segment for joint, segment in wanted.items()
        }
    assert [played[it] for it in ("Pelvis", "Chest", "Neck", "Head")] == [
        "Pelvis", "T8", "Neck", "Head"
    ]  # fmt: skip
    for index, name in enumerate(found.skeleton.names):
        segment = name.removesuffix(" End")
        rest = REST[NAMES.index(segment)] + (POINTS[segment][1] if name != segment else (0, 0, 0))
        for frame in range(5):
            angle = 0.05 * frame
            x = rest[0] * np.cos(angle) - rest[1] * np.sin(angle) + frame / 60
            y = rest[0] * np.sin(angle) + rest[1] * np.cos(angle)
            np.testing.assert_allclose(
                found.positions[frame, index] / 1000, (x, rest[2], -y), atol=2e-6
            )
        parent = found.skeleton.parents[index]
        above = found.skeleton.names[parent] if parent >= 0 else ""
        assert above == (dict((it[0], it[1]) for it in TREE)[name] if name == segment else segment)
    turn = (np.cos(0.1), 0, np.sin(0.1), 0)
    assert found.rotations is not None
    np.testing.assert_allclose(found.rotations[4], np.tile(turn, (25, 1)), atol=1e-6)
    away = found.skeleton.offsets[found.skeleton.names.index("RightForeArm")]
    np.testing.assert_allclose(away, (0, 0, 280), atol=2e-3)


def test_without_orientations_there_are_places_alone() -> None:
    found = read(mvnx(subject(turned=False)))
    assert found.rotations is None
    assert "RHand" not in found.skeleton.played()
    ours = read(GOOD).positions[:, : len(NAMES)]
    assert np.array_equal(found.positions, ours)


def test_segments_that_are_not_there_are_absent() -> None:
    names = [name for name in NAMES if name not in ("RightToe", "LeftHand", "RightShoulder")]
    found = read(mvnx(subject(names=names[::-1])))
    assert set(JOINTS) - found.skeleton.played().keys() == {"RToe", "LWrist", "LHand"}
    skeleton = found.skeleton
    arm = skeleton.names.index("RightUpperArm")
    assert skeleton.names[skeleton.parents[arm]] == "T8"


def test_a_segment_of_a_thing_stands_alone() -> None:
    data = GOOD.replace(b'"RightToe"', b'"Prop1"')
    skeleton = read(data).skeleton
    assert skeleton.parents[skeleton.names.index("Prop1")] == -1


@pytest.mark.parametrize(
    ("configuration", "absent"),
    [
        ("FullBody", ""),
        ("FullBodyNoHands", "RHand LHand"),
        ("UpperBody", "RKnee LKnee RAnkle LAnkle RToe LToe"),
        ("UpperBodyNoHands", "RKnee LKnee RAnkle LAnkle RToe LToe RHand LHand"),
        (
            "LowerBody",
            "Chest Neck Head RShoulder LShoulder RElbow LElbow RWrist LWrist RHand LHand",
        ),
        (
            "LowerBodyWithSternum",
            "Head RShoulder LShoulder RElbow LElbow RWrist LWrist RHand LHand",
        ),
    ],
)
def test_what_the_suit_does_not_measure_is_left_out(configuration: str, absent: str) -> None:
    found = read(mvnx(subject(said=f'frameRate="60" configuration="{configuration}"')))
    assert set(JOINTS) - found.skeleton.played().keys() == set(absent.split())
    said = [it for it in found.warnings if it.startswith(f"{configuration}: nothing is measured")]
    assert bool(said) == ("Upper" in configuration or "Lower" in configuration)


def test_the_rate() -> None:
    def at(said: str, **told: object) -> Motion:
        return read(mvnx(subject(said=said)), **told)

    assert at('frameRate="59.94"').rate == Fraction(60000, 1001)
    assert at('frameRate="240"', rate=100).rate == 100
    assert at("", rate=100).rate == 100
    for odd in ('frameRate="fast"', 'frameRate="0"', "", 'frameRate="1e9999"'):
        with pytest.raises(CaptureError, match=r"rate.*Give the rate with --fps"):
            at(odd)


def test_missing_frames_are_said() -> None:
    data = GOOD.replace(b'index="3"', b'index="7"').replace(b'index="4"', b'index="8"')
    assert read(data).warnings == ("frame 7 follows frame 2: taken for the next",)


def test_a_turn_that_is_none_is_unknown() -> None:
    start = GOOD.index(b"<orientation>", GOOD.index(b'index="2"')) + len(b"<orientation>")
    stop = GOOD.index(b"</orientation>", start)
    found = read(GOOD[:start] + b"0 0 0 0 " * len(NAMES) + GOOD[stop:])
    assert found.rotations is not None
    assert np.isnan(found.rotations).any(axis=(1, 2)).tolist() == [False, False, True, False, False]
    tip = found.skeleton.names.index("Head End")
    assert np.isnan(found.positions[:, tip, 0]).tolist() == [False, False, True, False, False]


def test_points_among_frames_are_no_points_of_segments() -> None:
    point = b'<point label="pLeftToe"><pos_b>9 9 9</pos_b></point>'
    data = GOOD.replace(b"</orientation>", b"</orientation>" + point)
    data = data.replace(b"</frame>", b"</frame>" + point)
    assert np.array_equal(read(data).positions, read(GOOD).positions)


class TestPeople:
    """Several subjects."""

    data = mvnx(subject(label="Ada"), subject(4, "Bob", 'frameRate="30"'), subject(3, "Bob"))

    def test_their_names(self) -> None:
        assert reader.subjects(File("x", self.data)) == ("Ada", "Bob", "Bob 3")
        assert reader.subjects(File("x", mvnx(subject(label="")))) == ("subject 1",)

    def test_the_first_is_read_and_said(self) -> None:
        found = read(self.data)
        assert len(found) == 5
        assert found.warnings == ("'Ada' is read; it holds also 'Bob', 'Bob 3'",)

    def test_one_is_named(self) -> None:
        assert (len(read(self.data, "Bob")), read(self.data, "Bob").rate) == (4, 30)
        assert len(read(self.data, "Bob 3")) == 3
        assert read(self.data, "Bob").warnings == ()
        with pytest.raises(CaptureError, match="has no subject 'Eve', wanted Ada or Bob or Bob 3"):
            read(self.data, "Eve")

    @pytest.mark.parametrize("name", ["", "Ada", "Bob", "Bob 3"])
    def test_a_clip_is_of_one(self, name: str) -> None:
        file = File("x.mvnx", self.data, name)
        clip = formats.cutter(file)(Span(1, 3))
        assert reader.subjects(File("x", clip)) == (name.removesuffix(" 3") or "Ada",)
        found = formats.read_file(file, Reading(), formats.Wanted())
        assert np.array_equal(read(clip).positions, found.positions[1:3])


def test_a_clip_is_byte_for_byte() -> None:
    data = mvnx(subject(9)).replace(b"\n", b"\r\n")
    cut = formats.cutter(File("x.mvnx", data))
    assert cut(Span(0, 9)) == data
    frames = re.findall(rb'\t*<frame [^>]*type="normal".*?</frame>\r\n', data, re.DOTALL)
    for start, stop in ((0, 1), (8, 9), (2, 6)):
        left = b"".join(frames[:start]), b"".join(frames[stop:])
        wanted = data
        for piece in left:
            wanted = wanted.replace(piece, b"") if piece else wanted
        assert cut(Span(start, stop)) == wanted
        assert np.array_equal(
            read(cut(Span(start, stop))).positions, read(data).positions[start:stop]
        )


def with_row(name: str, old: bytes, new: bytes) -> bytes:
    """Return the good file with something changed in a row of its second frame of movement."""
    at = GOOD.index(f"<{name}>".encode(), GOOD.index(b'index="1"'))
    return GOOD[:at] + GOOD[at:].replace(old, new, 1)


POSITION = GOOD[: GOOD.index(b"<position>", GOOD.index(b'index="1"'))].count(b"\n") + 1


@pytest.mark.parametrize(
    ("data", "line", "found", "wanted"),
    [
        (with_row("position", b" ", b" 7 "), POSITION, "<position> has 61 numbers", "3 for each"),
        (with_row("position", b"-", b"-x"), POSITION, "<position> has what is no", "numbers up to"),
        (with_row("position", b"0.", b"inf0."), POSITION, "what is no number", "numbers up to"),
        (with_row("position", b"0.", b"9e20."), POSITION, "what is no number", "numbers up to"),
        (with_row("position", b"0.", b"1_0."), POSITION, "what is no number", "numbers up to"),
        (with_row("position", b"position>", b"where>"), POSITION, "mismatched tag", "end"),
        (
            with_row("position", b"<position>", b"<place/><velocity>").replace(
                b"</position>\n<velocity>0 0 0", b"</velocity>\n<velocity>0", 5
            ),
            None,
            "",
            "",
        ),
        (GOOD[:-30], None, "is no sound XML", "elements that end"),
        (GOOD.replace(b"subject", b"person"), None, "has no subject", "a person in it"),
        (GOOD.replace(b'"normal"', b'"tpose"'), 4, "'Ada' has no frames", "of type normal"),
        (GOOD.replace(b"UTF-8", b"UTF-77"), 1, "unknown encoding", ""),
        (GOOD.replace(b"UTF-8", b"rot13"), 1, "is no sound XML", ""),
        (GOOD.replace(b"made", b"m\xffde"), 2, "not well-formed", ""),
        (
            GOOD.replace(b"\t\t\t<frame", b"<frame/>\n\t\t\t<frame", 1),
            None,
            "0 times <position> in 1 frames",
            "once in each",
        ),
    ],
)
def test_damage_is_named(data: bytes, line: int | None, found: str, wanted: str) -> None:
    with pytest.raises(CaptureError) as caught:
        read(data)
    assert found in caught.value.found
    assert wanted in caught.value.wanted
    assert caught.value.place.startswith("ada.mvnx")
    assert line is None or caught.value.place == f"ada.mvnx:{line}"


BOMB = b"".join(
    b'<!ENTITY e%d "%s">' % (number, b"&e%d;" % (number - 1) * 10) for number in range(1, 10)
)


@pytest.mark.parametrize(
    ("data", "found"),
    [
        (b'<!DOCTYPE mvnx [<!ENTITY e0 "x">' + BOMB + b"]>\n<mvnx>&e9;</mvnx>", "document type"),
        (b'<!DOCTYPE mvnx SYSTEM "file:///etc/passwd"><mvnx/>', "a document type"),
        (b"<mvnx>&e9;</mvnx>", "undefined entity"),
        (b"<mvnx>" + b"<a>" * 100_000, "33 elements within each other"),
        (b'<mvnx a="' + b"x" * (5 << 20), "a tag without an end"),
        (b"<mvnx " + b"x" * (5 << 20), "a tag without an end"),
        (b"<mvnx><!--" + b"x" * (5 << 20), "a tag without an end"),
        (
            GOOD.replace(b"<position>", b"<position>" + b" " * (2 << 20), 9),
            "numbers without an end",
        ),
        (GOOD.replace(b"<segments>", b"<segments>" + b"<segment/>" * 1001), "one more segment"),
        (GOOD.replace(b"<segments>", b"<subject><segments>"), "a subject within another"),
    ],
)
def test_what_is_made_to_hurt_is_refused(data: bytes, found: str) -> None:
    for work in (read, lambda it: reader.subjects(File("ada.mvnx", it))):
        if found == "numbers without an end" and work is not read:
            continue  # nobody reads them
        with pytest.raises(CaptureError) as caught:
            work(data)
        assert found in caught.value.found


@pytest.mark.parametrize("piece", [1, 100, 1000])
def test_pieces_of_any_size(piece: int, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = read(GOOD)
    monkeypatch.setattr(reader, "_PARSED", piece)
    assert np.array_equal(read(GOOD).positions, whole.positions)


class TestReal:
    """An upper body, seated or standing, that sings and moves the hands."""

    @pytest.fixture
    def path(self, captures: Path) -> Path:
        return captures / "mvnx" / "subalakshmi_upperbody.mvnx"

    def test_what_is_seen(self, path: Path) -> None:
        found = formats.read(path)
        assert (len(found), found.rate, found.source.up) == (112, 60, "z")
        absent = set(JOINTS) - found.skeleton.played().keys()
        assert absent == {side + joint for side in "RL" for joint in LEGS}
        assert found.warnings == (
            "UpperBody: nothing is measured at RightLowerLeg, RightFoot, RightToe, LeftLowerLeg, "
            "LeftFoot, LeftToe, which are left out",
            "no two feet: neither steps and jumps nor what carries are told",
        )
        assert np.isfinite(found.positions).all()

    def test_segments_are_joined_by_their_turns(self, path: Path) -> None:
        """A segment begins at a point of the one above, turned as that is."""
        found = formats.read(path)
        assert found.rotations is not None
        skeleton = found.skeleton
        for index, above in enumerate(skeleton.parents.tolist()):
            if above < 0:
                continue
            turns = Rotation.from_quat(found.rotations[:, above], scalar_first=True)
            away = found.positions[:, index] - found.positions[:, above]
            np.testing.assert_allclose(turns.apply(skeleton.offsets[index]), away, atol=0.5)

    def test_clips_read_back_equal(self, path: Path) -> None:
        file, whole = formats.opened(path), formats.read(path)
        cut = formats.cutter(file)
        assert cut(Span(0, 112)) == path.read_bytes()
        for start, stop in ((0, 1), (30, 90), (111, 112)):
            clip = formats.read_file(
                replace(file, content=cut(Span(start, stop))), Reading(), formats.Wanted()
            )
            assert np.array_equal(clip.positions, whole.positions[start:stop])
