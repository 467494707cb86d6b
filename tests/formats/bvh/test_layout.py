"""Byte offsets of a file: clips cut by them hold the right bytes."""

import numpy as np
import pytest
from bvh_bodies import hierarchy, motion, person
from hypothesis import given
from hypothesis import strategies as st

from lanindex.formats.bvh import scan

ENDS = ("\n", "\r\n", "\r")


def lines_of(data: bytes) -> list[bytes]:
    layout = scan(data)
    return [data[start:stop] for start, stop in layout.frames.tolist()]


def test_the_layout_of_a_small_file():
    data = person(3)
    layout = scan(data, "walk.bvh")
    assert data[slice(*layout.count)] == b"3"
    assert layout.declared == 3
    assert layout.time == "0.0333333"
    assert data[slice(*layout.time_line)] == b"Frame Time: 0.0333333"
    assert data[: layout.first].endswith(b"Frame Time: 0.0333333\n")
    assert layout.frames.dtype == layout.ends.dtype == np.int64
    assert layout.ends.tolist()[-1] == len(data)
    assert (
        b"".join(data[a:b] for a, b in zip(layout.frames[:, 0], layout.ends, strict=True))
        == (data[layout.first :])
    )


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("last", [True, False])
def test_any_line_end(end, last):
    data = person(4).replace(b"\n", end.encode())
    if not last:
        data = data[: -len(end)]
    layout = scan(data)
    assert len(layout.frames) == 4
    for (start, stop), behind in zip(layout.frames.tolist(), layout.ends.tolist(), strict=True):
        assert data[start:stop].split()[0] == b"0"
        assert data[stop:behind].decode() in ENDS or (behind == len(data) and not last)


@given(st.lists(st.tuples(st.sampled_from(ENDS), st.integers(0, 2)), min_size=1, max_size=8))
def test_mixed_line_ends_and_blank_lines(ends):
    head = hierarchy({"Pelvis": "Hips"}) + "MOTION\nFrames: 9\nFrame Time: 0.1\n"
    rows = [f"0 {k} 0 0 0 0" for k in range(len(ends))]
    text = head
    for row, (end, blanks) in zip(rows, ends, strict=True):
        text += row + end + f"  {end}" * blanks
    assert [line.decode() for line in lines_of(text.encode())] == rows


def test_blanks_around_a_frame_belong_to_its_line():
    text = hierarchy({"Pelvis": "Hips"}) + motion([[1] * 6]).replace("1 1", " \t1 1", 1)
    (line,) = lines_of(text.replace("\n", " \n").encode())
    assert line == b" \t1 1 1 1 1 1 "


@pytest.mark.parametrize(
    "written",
    [
        "MOTION\nFrames: 2\nFrame Time: 0.1\n",
        "MOTION\r\nFrames:\t2\r\nFrame Time:\t0.1\r\n",
        "motion\n\n  frames : 2  \n\nFRAME TIME:0.1 \n",
        "MOTION Frames: 2\nFrame Time: 0.1\n\n",
    ],
)
def test_the_head_of_the_motion_may_be_written_in_many_ways(written):
    data = (hierarchy({"Pelvis": "Hips"}) + written + "0 1 0 0 0 0\n0 2 0 0 0 0\n").encode()
    layout = scan(data)
    assert data[slice(*layout.count)] == b"2"
    assert layout.time == "0.1"
    assert lines_of(data) == [b"0 1 0 0 0 0", b"0 2 0 0 0 0"]


def test_a_missing_frame_time_is_left_to_the_reader():
    data = (hierarchy({"Pelvis": "Hips"}) + "MOTION\nFrames: 1\n0 1 0 0 0 0\n").encode()
    layout = scan(data)
    assert layout.time is None
    assert layout.time_line[0] == layout.time_line[1]
    assert lines_of(data) == [b"0 1 0 0 0 0"]


def test_the_count_is_not_believed():
    data = person(3).replace(b"Frames: 3", b"Frames: 999999999999")
    layout = scan(data)
    assert layout.declared == 999999999999
    assert len(layout.frames) == 3


def test_a_file_longer_than_a_block():
    data = person(3000)
    assert len(data) > 1 << 18
    assert len(scan(data).frames) == 3000
    windows = data.replace(b"\n", b"\r\n")
    assert len(scan(windows).frames) == 3000
    assert scan(windows).ends[-1] == len(windows)
