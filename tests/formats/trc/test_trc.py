"""TRC, good and bad; its clips; motions written as TRC."""

from fractions import Fraction

import numpy as np
import pytest
from made_points import NAMES, person
from mutations import fuzzed

from lanindex import formats
from lanindex.errors import BodyError, CaptureError
from lanindex.formats import trc
from lanindex.model import Motion, Span


def made(
    separator="\t", frames=20, rate="60", count=None, unit="mm", scale=1.0, start=1, step=1 / 60,
    names=NAMES, blank="\n", end="\n", tail="", form="{:.3f}",
) -> bytes:  # fmt: skip
    """Return a TRC file of a person."""
    keys = "DataRate CameraRate NumFrames NumMarkers Units OrigDataRate OrigDataStartFrame"
    count = frames if count is None else count
    values = [rate, rate, count, len(NAMES), unit, rate, start]
    axes = [f"{axis}{k}" for k in range(1, len(NAMES) + 1) for axis in "XYZ"]
    lines = [
        ["PathFileType", "4", "(X/Y/Z)", "C:\\My Documents\\walk 1.trc"],
        keys.split(),
        values,
        ["Frame#", "Time", *(cell for name in names for cell in (name, "", ""))],
        ["", "", *axes],
    ]
    text = "".join(separator.join(map(str, line)) + end for line in lines) + blank
    for number, row in enumerate((person(frames) * scale).tolist()):
        cells = [str(start + number), f"{number * step:.4f}"]
        cells += [form.format(value) for point in row for value in point]
        text += separator.join(cells) + tail + end
    return text.encode()


def read(data: bytes, **told: object) -> Motion:
    return formats.read("walk.trc", data=data, **told)


def places(motion: Motion) -> np.ndarray:
    """Return a motion's joints in the order of `NAMES`."""
    return motion.positions[:, [motion.skeleton.names.index(name) for name in NAMES]]


KINDS = {
    "tabs": {},
    "commas": {"separator": ","},
    "semicolons": {"separator": ";"},
    "no blank line": {"blank": ""},
    "a line of commas": {"separator": ",", "blank": "," * 46 + "\n"},
    "CRLF": {"end": "\r\n", "blank": "\r\n"},
    "CR": {"end": "\r", "blank": "\r"},
    "a trailing tab": {"tail": "\t"},
    "metres": {"unit": "m", "scale": 1e-3, "form": "{:.6f}"},
    "inches": {"unit": "inches", "scale": 1 / 25.4, "form": "{:.6f}"},
    "no unit": {"unit": "?"},
    "frames from 101": {"start": 101},
    "blanks before numbers": {"form": "  {:.3f} "},
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_person_in_every_manner(kind):
    motion = read(made(**KINDS[kind]))
    np.testing.assert_allclose(places(motion), person(), atol=2e-3)
    assert (motion.rate, motion.source.format, motion.warnings) == (60, "trc", ())


def test_a_ragged_header():
    lines = made().split(b"\n")
    lines[0] += b"\t" * 40
    lines[1] += b"\t" * 40
    lines[2] = b"  60.0\t\t  60.0\t\t    20\t\t     15\t\t mm\t  60.0\t      1"
    motion = read(b"\n".join(lines))
    assert (motion.rate, motion.source.unit, motion.warnings) == (60, "mm", ())


def test_what_is_blank_is_unknown():
    lines = made().split(b"\n")
    cells = lines[8].split(b"\t")
    cells[2 + 3 * 5] = b""
    cells[2 + 3 * 8 : 2 + 3 * 9] = b"nan", b"NaN", b" "
    lines[8] = b"\t".join(cells)
    found = places(read(b"\n".join(lines)))
    unknown = np.isnan(found).all(axis=2)
    assert np.argwhere(unknown).tolist() == [[2, 5], [2, 8]]
    assert not np.isnan(found[~unknown]).any()


@pytest.mark.parametrize("separator", ["\t", ";"])
def test_commas_in_numbers(separator):
    head, blank, rows = made(separator, step=0.02, rate="50").partition(b"\n\n")
    motion = read(head + blank + rows.replace(b".", b","))
    np.testing.assert_allclose(places(motion), person(), atol=1e-3)
    assert (motion.rate, motion.warnings) == (50, ())


def test_two_markers_of_one_name_are_told():
    names = ["left_knee" if name == "neck" else name for name in NAMES]
    told = "several markers are called 'left_knee': the first is read"
    assert read(made(names=names)).warnings[0] == told


def test_what_jumps_to_the_origin_is_unknown():
    lines = made().split(b"\n")
    cells = lines[8].split(b"\t")
    cells[2 + 3 * 5 : 2 + 3 * 6] = b"0", b"0.000", b"-0"
    lines[8] = b"\t".join(cells)
    motion = read(b"\n".join(lines))
    assert np.isnan(places(motion)[2, 5]).all()
    assert motion.warnings[0] == "left_wrist at 0, 0, 0 in 1 frames: taken as unknown"


def test_a_count_that_lies():
    motion = read(made(count=652))
    assert len(motion) == 20
    assert motion.warnings == ("its header says '652' frames, the file has 20",)


@pytest.mark.parametrize(
    ("rate", "step", "found", "warning"),
    [
        ("120", 1 / 60, 60, "says 120 frames a second, its times say 60: the times believed"),
        ("0", 1 / 60, 60, None),
        ("", 1 / 50, 50, None),
        ("60", 0, 60, None),
        ("29.97", 1001 / 30000, Fraction(30000, 1001), None),
    ],
)
def test_rate_and_times(rate, step, found, warning):
    motion = read(made(rate=rate or "?", step=step))
    assert float(motion.rate) == pytest.approx(float(found), rel=1e-3)
    assert motion.warnings == ((warning,) if warning else ())


def test_a_rate_that_is_told_overrules_both():
    assert read(made(rate="?", step=0), rate=25).rate == 25
    with pytest.raises(CaptureError, match="Give the rate with --fps"):
        read(made(rate="?", step=0))


def test_frames_that_are_missing_are_told():
    lines = made().splitlines(keepends=True)
    motion = read(b"".join(lines[:12] + lines[17:]))
    assert motion.rate == 60
    assert "1 of 14 steps in time differ from the usual 0.0167 s" in motion.warnings[-1]


BAD = {
    "no frames": (b"\n".join(made().split(b"\n")[:6]), "no frames"),
    "a header alone": (b"PathFileType\t4\n", "the file ends in its header"),
    "a word": (made().replace(b"\t0.0333\t", b"\t0.0333\tx"), "frame 2 has 'x.* in column 3"),
    "an underscore": (made().replace(b"\t0.0333\t", b"\t0.0333\t1_0"), "has '1_0.* in column 3"),
    "infinity": (made().replace(b"\t0.0333\t", b"\t0.0333\tinf\t"), "has 'inf' in column 3"),
    "too large": (made().replace(b"\t0.0333\t", b"\t0.0333\t9e9\t"), "has '9e9' in column 3"),
    "too many": (made().replace(b"\n3\t", b"\n3\t\t9\t"), "frame 2 has 49 cells, wanted 47"),
    "too few": (made()[:-30], "last line: the file may be cut short"),
    "no names": (made(names=()), None),
    "too few names": (made().replace(b"neck\t\t\thead\t\t\t", b"neck\t"), "14 names over 15 ma"),
}


@pytest.mark.parametrize("kind", BAD)
def test_errors_name_the_place(kind):
    data, found = BAD[kind]
    with pytest.raises(CaptureError, match=found) as caught:
        read(data)
    assert str(caught.value).startswith("walk.trc")


def test_a_clip_is_lines_of_the_source():
    source = made(separator=",", count=652)
    clip = formats.cutter(formats.File("walk.trc", source))(Span(3, 9))
    lines = source.splitlines(keepends=True)
    lines[2] = lines[2].replace(b",652,", b",6,")
    assert clip == b"".join(lines[:6] + lines[9:15])
    np.testing.assert_array_equal(places(read(clip)), places(read(source))[3:9])


def test_clips_of_real_files_read_back(captures):
    for path in sorted((captures / "trc").glob("*.trc")):
        whole = formats.read(path)
        clip = formats.cutter(formats.opened(path))(Span(20, 60))
        again = formats.read(path, data=clip, up=whole.source.up)
        assert (len(again), again.rate) == (40, whole.rate), path
        np.testing.assert_array_equal(again.markers.positions, whole.markers.positions[20:60])
        assert {*again.warnings} <= {*whole.warnings}, path


def test_real_files_write_back(captures):
    for path in sorted((captures / "trc").glob("*.trc")):
        whole = formats.read(path)
        again = read(trc.write(whole))
        assert again.markers.names == whole.markers.names
        assert (again.rate, again.source.up) == (whole.rate, "y")
        np.testing.assert_allclose(again.markers.positions, whole.markers.positions, atol=1e-3)


def test_joints_of_a_camera_are_not_taken_for_markers(captures):
    motion = formats.read(captures / "trc" / "pose2sim_balancing.trc")
    assert motion.source.set == "joints (OpenPose, Pose2Sim)"
    assert motion.source.made["RShoulder"] == "RShoulder"


def test_joints_are_written_where_there_are_no_markers():
    motion = formats.read("corpus/compass.bvh")
    again = read(trc.write(motion))
    assert again.skeleton.played() == motion.skeleton.played()
    joints = [again.skeleton.names.index(name) for name in motion.skeleton.names]
    np.testing.assert_allclose(again.positions[:, joints], motion.positions, atol=1e-3)


def test_a_blank_at_the_end_of_a_line_is_a_cell():
    """OpenSim counts what stands before a tab, or behind the last one."""
    rows = made().replace(f"{person()[0, -1, 0]:.3f}".encode(), b"").splitlines(keepends=True)
    motion = read(b"".join(rows))
    assert np.isnan(places(motion)[0, -1]).all()
    for line in trc.write(motion).splitlines()[6:]:
        assert line.count(b"\t") == 2 + 3 * len(NAMES)


def test_names_that_would_break_the_table():
    names = ("a\tb", *NAMES[1:])
    data = made(names=[name.replace("\t", " ") for name in names])
    assert b"\ta b\t" in trc.write(read(data))


def test_fuzzing():
    seen = fuzzed(
        "walk.trc", [made(), made(separator=",", count=652, blank="," * 46 + "\n")], 500, 1
    )
    assert min(seen.values()) > 50, seen


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_long_fuzzing(captures):
    real = [
        b"\n".join(path.read_bytes().split(b"\n")[:20]) + b"\n"
        for path in sorted((captures / "trc").glob("*.trc"))
    ]
    seen = fuzzed("walk.trc", [made(frames=5), made(frames=5, separator=","), *real], 5_000, 2)
    assert min(seen.values()) > 200, seen


def test_a_wrong_marker_in_what_is_told_of_the_body_names_that_file(tmp_path):
    told = tmp_path / "body.toml"
    told.write_text('RWrist = "nowhere"')
    with pytest.raises(BodyError, match=r'body\.toml: no "nowhere" for RWrist'):
        read(made(), body=str(told))
