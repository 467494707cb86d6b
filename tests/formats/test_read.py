"""`read` chooses a reader and reports bad files."""

import os
import re
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from bvh_bodies import SIMPLE, hierarchy, motion, person

from lanindex import formats
from lanindex.errors import BodyError, CaptureError, UsageError


@pytest.fixture
def walk(tmp_path):
    path = tmp_path / "walk.bvh"
    path.write_bytes(person(5))
    return path


def test_a_motion(walk):
    motion = formats.read(walk)
    assert len(motion) == 5
    assert motion.rate == Fraction(30)
    assert motion.positions.dtype == np.float32
    assert motion.positions.shape == (5, len(motion.skeleton.names), 3)
    assert not motion.positions.flags.writeable
    assert motion.skeleton.offsets.dtype == np.float32
    assert motion.skeleton.parents.dtype == np.int16
    assert motion.first == 0
    assert motion.source.path == str(walk)
    assert motion.source.format == "bvh"


def test_data_at_hand_is_not_read_again(walk):
    motion = formats.read("elsewhere.bvh", data=walk.read_bytes())
    assert motion.source.path == "elsewhere.bvh"
    assert len(motion) == 5


def test_a_person_stands_where_the_file_says():
    data = (hierarchy(channels="Zrotation Xrotation Yrotation")).encode()
    frame = [10, 92, -20] + [0.0] * (person().split(b"\n")[-2].count(b" ") - 2)
    frame[5] = 90.0  # about the vertical: it faces +x now
    data += motion([frame]).encode()
    found = formats.read("x.bvh", data=data)
    at = {name: found.positions[0, index] for index, name in enumerate(found.skeleton.names)}
    np.testing.assert_allclose(at["Pelvis"], [100, 920, -200], atol=1e-3)
    np.testing.assert_allclose(at["LHip"], [100, 880, -290], atol=1e-3)
    np.testing.assert_allclose(at["LToe"], [230, 0, -290], atol=1e-3)
    np.testing.assert_allclose(at["Head End"], [110, 1690, -200], atol=1e-3)


ORDERS = ["Xrotation Yrotation Zrotation", "Yrotation Zrotation Xrotation", "Zrotation", ""]


@pytest.mark.parametrize("order", ORDERS)
def test_any_order_of_channels(order):
    found = formats.read("x.bvh", data=person(channels=order))
    np.testing.assert_allclose(found.positions, formats.read("x", data=person()).positions)


def test_positions_on_every_joint_replace_the_offset():
    text = hierarchy(channels="Xposition Yposition Zposition Zrotation Xrotation Yrotation")
    text = text.replace(
        "CHANNELS 9 Xposition Yposition Zposition Xpos", "CHANNELS 6 Xpos"
    )  # the root had them already
    offsets = [
        line.split()[1:]
        for line, following in zip(text.splitlines(), text.splitlines()[1:], strict=False)
        if line.startswith("OFFSET") and following.startswith("CHANNELS")
    ]
    frame = [number for offset in offsets for number in (*map(float, offset), 0.0, 0.0, 0.0)]
    wrong = "\n".join(
        "OFFSET 1 2 3" if line.startswith("OFFSET") and k < 40 else line
        for k, line in enumerate(text.split("\n"))
    )
    data = (text + motion([frame])).encode()
    moved = (wrong + motion([frame])).encode()
    assert data != moved
    one, other = formats.read("x.bvh", data=data), formats.read("x.bvh", data=moved)
    joints = [k for k, name in enumerate(one.skeleton.names) if not name.endswith(" End")]
    assert np.array_equal(one.positions[:, joints], other.positions[:, joints])


def test_turns_can_be_composed_the_other_way_round():
    text = hierarchy()
    width = person().split(b"\n")[-2].count(b" ") + 1
    frame = [0, 92, 0, 30, 40, 50, *([20.0, -70.0, 35.0] * (width // 3))][:width]
    data = (text + motion([frame] * 2)).encode()
    parent = formats.read("x.bvh", data=data, compose="parent")
    child = formats.read("x.bvh", data=data, compose="child")
    assert np.array_equal(parent.positions, formats.read("x.bvh", data=data).positions)
    assert np.abs(parent.positions - child.positions).max() > 100
    with pytest.raises(UsageError, match="compose 'both', wanted parent or child"):
        formats.read("x.bvh", data=data, compose="both")


def test_an_exporter_that_composes_child_first_is_known_by_its_joints():
    names = {"Chest": "TORSO#", "Neck": "NECK#", "Head": "HEAD"}
    for side, word in (("L", "LEFT"), ("R", "RIGHT")):
        names |= {f"{side}Shoulder": f"{word}_SHOULDER#", f"{side}Elbow": f"{word}_ELBOW"}
        names |= {f"{side}Wrist": f"{word}_HAND", f"{side}Hip": f"{word}_HIP#"}
        names |= {f"{side}Knee": f"{word}_KNEE", f"{side}Ankle": f"{word}_FOOT"}
    text = hierarchy(names)
    helpers = "".join(
        f"JOINT {name} {{ OFFSET 0 0 0 CHANNELS 3 Zrotation Xrotation Yrotation }}\n"
        for name in ("TLS", "TRS", "TLH", "TRH", "TN")
    )
    end = text.rindex("}")
    known = text[:end] + helpers + text[end:]
    for kind, wanted in ((known, "child"), (text, "parent")):
        count = sum(map(int, re.findall(r"CHANNELS (\d+)", kind)))
        data = (kind + motion([[0, 92, 0, *[25.0] * (count - 3)]])).encode()
        found = formats.read("x.bvh", data=data)
        assert np.array_equal(
            found.positions, formats.read("x.bvh", data=data, compose=wanted).positions
        )


def test_a_wrong_count_is_said_and_the_frames_are_there():
    for written in ("2", "999999999999", "0", "-1"):
        data = person(3).replace(b"Frames: 3", f"Frames: {written}".encode())
        motion = formats.read("x.bvh", data=data)
        assert len(motion) == 3
        assert motion.warnings == (f"Frames: says {int(written)}, the file has 3",)


UNREADABLE = {
    "empty": (b"", "the file is empty"),
    "blank": (b" \n\n", "holds nothing but blanks"),
    "binary": (b"\x00\x01\x02\x03BINARY!", "binary data that begins with 00 01 02 03"),
    "utf-16": ("HIERARCHY".encode("utf-16"), "begins as UTF-16 text"),
    "text": (b"Dear diary,\n", "begins with 'Dear diary,'"),
    "latin": (b"\xfc\xfc\n", "begins with"),
}


def test_angles_are_refused_with_the_reason(tmp_path):
    path = tmp_path / "walk.mot"
    path.write_text("Coordinates\nversion=1\nnRows=1\nendheader\ntime\thip_flexion_r\n0\t10\n")
    with pytest.raises(CaptureError, match="MOT holds angles") as caught:
        formats.read(path)
    assert str(caught.value).endswith("Read the TRC of the same take.")


@pytest.mark.parametrize("case", UNREADABLE)
def test_what_no_reader_knows(case, tmp_path):
    data, found = UNREADABLE[case]
    path = tmp_path / "odd.bvh"
    path.write_bytes(data)
    with pytest.raises(CaptureError) as caught:
        formats.read(path)
    assert caught.value.place == str(path)
    assert found in caught.value.found
    assert all(form.title in caught.value.wanted for form in formats.FORMATS)
    with pytest.raises(CaptureError):
        formats.cutter(formats.File("odd.bvh", data))


def test_a_folder_is_no_capture(tmp_path):
    with pytest.raises(CaptureError, match="is a folder, wanted a file that can be read"):
        formats.read(tmp_path)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(CaptureError, match=r"gone\.bvh: there is no such file"):
        formats.read(tmp_path / "gone.bvh")


def test_a_dead_link(tmp_path):
    link = tmp_path / "link.bvh"
    link.symlink_to(tmp_path / "gone.bvh")
    with pytest.raises(CaptureError, match="a link that leads nowhere"):
        formats.read(link)


def test_a_link_in_a_circle(tmp_path):
    link = tmp_path / "link.bvh"
    link.symlink_to(link)
    with pytest.raises(CaptureError, match=r"link\.bvh"):
        formats.read(link)


def test_a_file_that_may_not_be_read(walk, monkeypatch):
    walk.chmod(0)
    if os.access(walk, os.R_OK):  # as root every file may be read

        def refuse(*_):
            raise PermissionError(13, "Permission denied", str(walk))

        monkeypatch.setattr("builtins.open", refuse)
    with pytest.raises(CaptureError, match="Permission denied, wanted a file that can be read"):
        formats.read(walk)


def test_a_name_that_is_no_name():
    with pytest.raises(CaptureError, match="null"):
        formats.read("a\0b.bvh")


def test_a_body_error_is_a_capture_error(walk):
    walk.write_bytes(person(names={"Pelvis": "Lamp"}))
    with pytest.raises(BodyError):
        formats.read(walk)
    assert issubclass(BodyError, CaptureError)


def test_without_numba_files_are_read_all_the_same(walk):
    code = (
        "import sys; sys.modules['numba'] = None\n"
        "from lanindex.formats import read\n"
        "from lanindex import compiled\n"
        "compiled.LOAD, compiled.cached = 0, lambda name: True\n"
        f"print(len(read({str(walk)!r})))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.strip() == "5", result.stderr


def test_small_work_does_not_load_numba(walk):
    code = (
        f"import sys; from lanindex.formats import read; read({str(walk)!r})\n"
        "print('numba' in sys.modules)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.strip() == "False", result.stderr


def test_importing_is_cheap():
    code = "import sys, lanindex.formats; print('numpy' in sys.modules, 'numba' in sys.modules)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.split() == ["False", "False"]


@pytest.mark.parametrize(("compose", "place"), [("parent", (0, 0, 240)), ("child", (-240, 0, 0))])
def test_whose_turn_stands_first(compose, place):
    # the root turns by a quarter about z, the chest about x; the neck lies 24 cm above the chest
    width = person().split(b"\n")[-2].count(b" ") + 1
    frame = [0.0, 92, 0, 90, 0, 0, 0, 90, *[0.0] * (width - 8)]
    data = (hierarchy() + motion([frame] * 2)).encode()
    seen = formats.read("x.bvh", data=data, compose=compose, up="y", unit="cm")
    chest, neck = (seen.positions[0, seen.skeleton.names.index(name)] for name in ("Chest", "Neck"))
    assert neck - chest == pytest.approx(place, abs=1e-3)


def test_every_role_of_the_test_body_is_a_joint():
    assert len(SIMPLE) == 22


def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.bvh")
    with pytest.raises(CaptureError, match="is no regular file, wanted a file that can"):
        formats.read(tmp_path / "pipe.bvh")
