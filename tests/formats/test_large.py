"""Files that are read in pieces, and their memory."""

import hashlib
import itertools
import subprocess
import sys

import numpy as np
import pytest
from bvh_bodies import hierarchy, motion, person

from lanindex import formats
from lanindex.errors import CaptureError
from lanindex.formats import bvh
from lanindex.formats import file as files
from lanindex.model import Span


@pytest.fixture
def pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Treat every file as a large one, and make the pieces small."""
    monkeypatch.setattr(files, "WHOLE", 0)
    monkeypatch.setattr(files, "PIECE", 1000)
    monkeypatch.setattr(bvh, "HEADER", 500)
    monkeypatch.setattr(bvh, "BEYOND", 40)
    monkeypatch.setattr(bvh, "SEARCHED", 997)
    monkeypatch.setattr(bvh, "BLOCK", 7)


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_a_file_in_pieces_reads_like_one_in_memory(tmp_path, pieces, end):
    data = person(40).replace(b"\n", end)
    path = tmp_path / "walk.bvh"
    path.write_bytes(data)
    large = formats.opened(path)
    assert not isinstance(large.content, bytes)
    assert large.content[:] == data
    assert large.sha256() == hashlib.sha256(data).hexdigest()
    assert np.array_equal(formats.read(path).positions, formats.read("x", data=data).positions)
    clip, same = (formats.cutter(one)(Span(3, 30)) for one in (large, formats.File("x", data)))
    assert clip == same


@pytest.mark.parametrize("cut", [b"OFFSET", b"MOTION", b"Frames:", b"Frame Time:", b"0.0333"])
def test_a_header_is_read_whole_wherever_its_first_piece_ends(tmp_path, pieces, monkeypatch, cut):
    data = person(40)
    assert cut in data
    path = tmp_path / "walk.bvh"
    path.write_bytes(data)
    for shift in range(len(cut) + 2):
        monkeypatch.setattr(bvh, "HEADER", data.index(cut) + shift)
        assert bvh.scan(formats.opened(path).content).time == "0.0333333"


def test_damage_in_a_large_file_is_told_as_in_a_small_one(tmp_path, pieces):
    for old, new in ((b"MOTION", b"MOTON"), (b"Frames:", b"Fames:"), (b"\n0 ", b"\nx ")):
        data = person(40).replace(old, new)
        path = tmp_path / "walk.bvh"
        path.write_bytes(data)
        with pytest.raises(CaptureError) as small:
            formats.read(path, data=data)
        with pytest.raises(CaptureError) as large:
            formats.read(path)
        assert str(large.value) == str(small.value)


def test_lines_are_counted_across_pieces(monkeypatch):
    monkeypatch.setattr("lanindex.formats.file.PIECE", 2)
    data = b"a\r\nb\nc\rd\r\n\r\ne"
    for offset in range(len(data) + 1):
        before = data[:offset]
        ends = before.count(b"\n") + before.count(b"\r") - before.count(b"\r\n")
        assert files.line_of(data, offset) == ends + 1


def test_a_file_that_changes_while_it_is_read_is_refused(tmp_path, pieces):
    path = tmp_path / "walk.bvh"
    path.write_bytes(person(40))
    large = formats.opened(path)
    path.write_bytes(person(41))
    with pytest.raises(CaptureError, match="has changed while it was read"):
        large.sha256()
    path.unlink()
    with pytest.raises(CaptureError, match="there is no such file"):
        large.sha256()


def test_a_body_alone_is_what_it_is_among_all_joints():
    text = hierarchy()
    width = person().split(b"\n")[-2].count(b" ") + 1
    data = (text + motion([[float(k)] * width for k in range(9)])).encode()
    whole, body = (formats.read("x", data=data, body_only=alone) for alone in (False, True))
    assert whole.source.joints == body.source.joints == whole.skeleton.names
    assert body.skeleton.played() == whole.skeleton.played()
    assert set(body.skeleton.names) == set(whole.skeleton.played().values())
    for name in body.skeleton.names:
        one, other = (m.skeleton.names.index(name) for m in (body, whole))
        assert np.array_equal(body.positions[:, one], whole.positions[:, other])


def test_what_is_left_out_joins_those_around_it():
    whole = formats.read("x", data=person(2))
    body = formats.read("x", data=person(2), body_only=True)
    rest = {}
    for seen in (whole, body):
        for joint, parent in enumerate(seen.skeleton.parents.tolist()):
            above = rest[id(seen), seen.skeleton.names[parent]] if parent >= 0 else 0
            rest[id(seen), seen.skeleton.names[joint]] = above + seen.skeleton.offsets[joint]
    for name in body.skeleton.names:
        assert np.allclose(rest[id(body), name], rest[id(whole), name])


MEASURE = """
import resource, sys
from lanindex import encode, formats
from lanindex.encoding import joints
from lanindex.formats import file
from lanindex.model import Reading
file.WHOLE, joints.TOGETHER, joints.KEPT = 1 << 20, 1 << 16, 1 << 16
for path in sys.argv[1:]:
    opened = formats.opened(path)
    opened.sha256()
    encode(formats.read_file(opened, Reading(), formats.Wanted(body_only=True)))
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


@pytest.mark.slow
def test_memory_grows_with_the_file_and_modestly(tmp_path):
    head, number = hierarchy(), itertools.count()
    width = person().split(b"\n")[-2].count(b" ") + 1
    lines = [" ".join(f"{next(number) % 7919 / 791:.5f}" for _ in range(width)) for _ in range(99)]
    paths = [tmp_path / "small.bvh", tmp_path / "large.bvh"]
    for path, times in zip(paths, (20, 400), strict=True):
        text = "\n".join(lines * times)
        path.write_text(f"{head}MOTION\nFrames: {99 * times}\nFrame Time: 0.0166667\n{text}\n")
    words = [sys.executable, "-c", MEASURE, *map(str, paths)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    before, after = map(float, done.stdout.split())
    small, large = (path.stat().st_size / 1e6 for path in paths)
    assert large > 20
    assert after - before < 2.5 * (large - small)
