"""Damaged files raise errors with line, found and wanted."""

import random
import re
import time

import pytest
from bvh_bodies import hierarchy, motion, person
from effort import examples
from hypothesis import given
from hypothesis import strategies as st

from lanindex import formats
from lanindex.errors import CaptureError, LanindexError
from lanindex.model import Motion

GOOD = person(3)
HEAD = GOOD[: GOOD.index(b"MOTION")]
LINES = GOOD.splitlines(keepends=True)
WIDTH = LINES[-1].count(b" ") + 1
LAST = len(LINES)


def with_line(number: int, line: bytes) -> bytes:
    """Return the good file with one line replaced, counted from 1."""
    return b"".join([*LINES[: number - 1], line, *LINES[number:]])


def frame(*numbers: object, width: int = WIDTH) -> bytes:
    words = [*map(str, numbers), *["0"] * (width - len(numbers))]
    return " ".join(words).encode() + b"\n"


# case: data, line, found, wanted
CASES = {
    "empty": (b"", None, "the file is empty", "BVH"),
    "binary": (b"\x89PNG\r\n\x1a\n\0\0", None, "binary data", "BVH"),
    "binary behind the first word": (b"HIERARCHY\n\0\1\2", 2, "", "OFFSET"),
    "cut in the hierarchy": (b"".join(LINES[:12]), 13, "the file ends inside", "OFFSET, CHANNELS"),
    "cut in the channels": (HEAD[: HEAD.index(b"rotation")], 5, "says 6 and names 3", "as many"),
    "cut behind the hierarchy": (HEAD, None, "the file ends inside the hierarchy", "MOTION"),
    "cut behind MOTION": (HEAD + b"MOTION\n", LAST - 5, "no Frames: line", "whole number"),
    "no frames": (HEAD + b"MOTION\nFrames: 0\nFrame Time: 0.1\n", LAST - 2, "no frames", "lines"),
    "no count": (GOOD.replace(b"Frames: 3", b"Frames:"), LAST - 4, "Frames: ''", "whole number"),
    "a wordy count": (GOOD.replace(b": 3", b": three"), LAST - 4, "Frames: 'three'", "whole"),
    "half a count": (GOOD.replace(b": 3", b": 2.5"), LAST - 4, "Frames: '2.5'", "whole"),
    "cut in a line": (GOOD[:-20], LAST, "frame 2 has", f"{WIDTH} as the hierarchy declares"),
    "too few": (with_line(LAST - 1, frame(width=WIDTH - 3)), LAST - 1, "frame 1 has", str(WIDTH)),
    "too many": (with_line(LAST - 1, frame(width=WIDTH + 1)), LAST - 1, "frame 1 has", str(WIDTH)),
    "a word": (with_line(LAST - 1, frame(0, "one")), LAST - 1, "has 'one' as number 2", "numbers"),
    "a comma": (with_line(LAST - 1, frame("0,5")), LAST - 1, "has '0,5' as number 1", "decimal"),
    "nan": (with_line(LAST, frame(0, 0, "nan")), LAST, "frame 2 has 'nan' as number 3", "finite"),
    "inf": (with_line(LAST, frame("-inf")), LAST, "frame 2 has '-inf' as number 1", "finite"),
    "1e999": (with_line(LAST, frame("1e999")), LAST, "frame 2 has '1e999' as number 1", "finite"),
    "1e300": (with_line(LAST, frame("1e300")), LAST, "frame 2 has '1e300' as number 1", "finite"),
    "words behind the frames": (GOOD + b"END OF FILE\n", LAST + 1, "frame 3 has 'END'", "numbers"),
    "time 0": (GOOD.replace(b"0.0333333", b"0"), LAST - 3, "Frame Time: '0'", "above 0"),
    "time below 0": (GOOD.replace(b"0.0333333", b"-1"), LAST - 3, "Frame Time: '-1'", "above 0"),
    "no time": (GOOD.replace(b"Frame Time: 0.0333333\n", b""), None, "no Frame Time:", "above 0"),
    "empty time": (GOOD.replace(b"0.0333333", b""), LAST - 3, "Frame Time: ''", "above 0"),
    "same names": (GOOD.replace(b"LKnee", b"RKnee"), None, "a second joint named 'RKnee'", "own"),
    "nothing moves": (
        (hierarchy().replace("CHANNELS 6", "#").replace("CHANNELS 3", "#")).encode(),
        5,
        "'# Xposition",
        "OFFSET, CHANNELS",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_damage_is_named(case, tmp_path):
    data, line, found, wanted = CASES[case]
    path = tmp_path / "walk.bvh"
    path.write_bytes(data)
    with pytest.raises(CaptureError) as caught:
        formats.read(path)
    error = caught.value
    assert found in error.found
    assert wanted in error.wanted
    if line is not None:
        assert error.place == f"{path}:{line}"
    assert error.place.startswith(str(path))
    assert "\n" not in str(error)


def test_the_whole_message():
    data = with_line(LAST - 1, frame(width=WIDTH - 3))
    with pytest.raises(CaptureError) as caught:
        formats.read("walk.bvh", data=data)
    assert str(caught.value) == (
        f"walk.bvh:{LAST - 1}: frame 1 has {WIDTH - 3} numbers, "
        f"wanted {WIDTH} as the hierarchy declares"
    )


def test_a_cut_line_has_a_remedy():
    for at in (len(GOOD) - 20, GOOD.index(b"rotation"), GOOD.index(b"JOINT Neck")):
        with pytest.raises(CaptureError, match="the file may be cut short"):
            formats.read("walk.bvh", data=GOOD[:at])


def test_cut_between_frames_is_a_wrong_count():
    motion = formats.read("walk.bvh", data=b"".join(LINES[:-1]))
    assert len(motion) == 2
    assert motion.warnings == ("Frames: says 3, the file has 2",)


def test_a_root_without_channels():
    text = "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n"
    with pytest.raises(CaptureError, match="no joint has CHANNELS, nothing can move"):
        formats.read("walk.bvh", data=text.encode())


def test_no_memory_is_taken_on_trust():
    start = time.perf_counter()
    data = GOOD.replace(b"Frames: 3", b"Frames: 999999999999")
    assert len(formats.read("walk.bvh", data=data)) == 3
    wide = " ".join(["Zrotation"] * 900)
    text = "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 900 " + wide + "\n}\n"
    text += "MOTION\nFrames: 99999999\nFrame Time: 0.1\n" + "1\n" * 100_000
    with pytest.raises(CaptureError, match="frame 0 has 1 numbers, wanted 900"):
        formats.read("walk.bvh", data=text.encode())
    assert time.perf_counter() - start < 60  # it would take minutes, not seconds


def test_a_large_joke_of_a_rate_is_no_work():
    for joke in (b"1e-999999999", b"9" * 5000, b"1e999999999"):
        with pytest.raises(CaptureError, match="Frame Time"):
            formats.read("walk.bvh", data=GOOD.replace(b"0.0333333", joke))


def outcome(data: bytes) -> str:
    """Read; anything but a motion or one of our errors is a failure."""
    try:
        found = formats.read("walk.bvh", data=data)
    except LanindexError as refused:
        error = refused
    else:
        error = None
    if error is not None:
        assert str(error).startswith("walk.bvh")
        return "error"
    assert isinstance(found, Motion)
    assert len(found) >= 1
    return "motion"


words = "{ } - e 1e999 nan OFFSET CHANNELS_3 JOINT End_Site MOTION Frames:_5 ROOT_x"
pieces = st.sampled_from(
    [b"", b"\n", b"\r", b"\0", b"\xff", b" ", b"9" * 30, b"1_0"]
) | st.sampled_from(words.split()).map(lambda word: word.replace("_", " ").encode())


@examples(150)
@given(st.lists(st.tuples(st.integers(0, len(GOOD)), st.integers(0, 60), pieces), max_size=4))
def test_mutations_give_a_motion_or_an_error(edits):
    data = GOOD
    for at, length, piece in edits:
        data = data[:at] + piece + data[at + length :]
    outcome(data)


@examples(100)
@given(st.binary(max_size=200))
def test_bytes_give_an_error(data):
    for start in (b"", b"HIERARCHY\n", HEAD + b"MOTION\nFrames: 1\nFrame Time: .1\n"):
        outcome(start + data)


@examples(60)
@given(st.integers(0, len(GOOD)))
def test_cut_anywhere(at):
    outcome(GOOD[:at])


def mutated(data: bytes, numbers: random.Random) -> bytes:
    """Return data with a few bytes changed, words exchanged, stretches cut or doubled."""
    mutable = bytearray(data)
    for _ in range(numbers.choice((1, 1, 2, 5, 20))):
        at = numbers.randrange(len(mutable) + 1)
        length = min(numbers.choice((0, 1, 3, 30, 500)), len(mutable) - at)
        kind = numbers.randrange(4)
        if kind == 0:
            mutable[at : at + length] = b""
        elif kind == 1:
            mutable[at:at] = mutable[at : at + length]
        elif kind == 2:
            mutable[at : at + length] = numbers.randbytes(length)
        else:
            mutable[at:at] = numbers.choice(
                (b"{", b"}", b"\n", b"\r\n", b" ", b"-", b".", b"e5", b"nan", b"OFFSET ", b"\0")
            )
    return bytes(mutable)


def shortened(data: bytes) -> bytes:
    """Return a BVH file with its first frames alone, which its header counts."""
    head, behind, rows = re.split(rb"Frames:\s*\d+(\s*Frame Time:\s*\S+\s*)", data, maxsplit=1)
    lines = rows.splitlines(keepends=True)[:20]
    return head + b"Frames: %d" % len(lines) + behind + b"".join(lines)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_long_fuzzing(captures):
    """Mutations of real files; `--slow` runs it."""
    numbers = random.Random(20240229)
    sources = [
        GOOD,
        (hierarchy() + motion([[0.0] * WIDTH] * 200)).encode(),
        *(shortened(path.read_bytes()) for path in sorted((captures / "bvh").glob("[b-x]*/*.bvh"))),
    ]
    seen = {"motion": 0, "error": 0}
    for _ in range(5_000):
        seen[outcome(mutated(numbers.choice(sources), numbers))] += 1
    assert min(seen.values()) > 300, seen
