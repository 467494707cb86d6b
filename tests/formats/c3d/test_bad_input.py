"""Damaged C3D files give a motion or an error that says what is wrong."""

import random
import time

import numpy as np
import pytest
from effort import some
from made_c3d import c3d, standing

from lanindex import formats
from lanindex.errors import CaptureError
from lanindex.model import Span

TRIAL = {"TRIAL:ACTUAL_START_FIELD": [1, 0], "TRIAL:ACTUAL_END_FIELD": [40, 0]}
GOOD = c3d(standing(40), more=TRIAL)
SMALL = [
    GOOD,
    c3d(standing(30), processor=86, scale=1.0, analog=np.ones((30, 6))),
    c3d(standing(30), processor=85, first=12),
    c3d(standing(30), processor=85, scale=1.0),
]

# case: data, found, wanted
CASES = {
    "nothing behind the header": (GOOD[:512], "has no parameters", "a whole C3D file"),
    "no data": (
        GOOD[: 512 * (GOOD[16] - 1) + 100],
        "ends before its first frame does",
        "a whole C3D file",
    ),
    "no points": (c3d(standing(3)[:, :0], more={"POINT:LABELS": None}), "has no points", "whole"),
    "no scale": (c3d(standing(3), scale=0.0), "does not say a scale", "a whole C3D file"),
    "no data start": (
        c3d(standing(3), more={"POINT:DATA_START": None}, words={9: 0}),
        "does not say that its data begin",
        "a whole C3D file",
    ),
    "no rate": (c3d(standing(3), rate=0.0), "nothing tells its rate", "1 to 1000000 frames"),
    "a slow rate": (c3d(standing(3), rate=0.01), "a rate of '0.0", "--fps"),
    "nobody": (c3d(standing(3), [f"m{it}" for it in range(28)]), "no human skeleton", "hips"),
    "each known for a moment": (
        c3d(np.where(np.eye(28)[:, :, None] > 0, standing(28), -1), [f"m{it}" for it in range(28)]),
        "in no two frames the same points are known",
        "a body that moves",
    ),
    "nothing known": (c3d(standing(3) * 0), "no point is known", "a body that moves"),
}


@pytest.mark.parametrize("case", CASES)
def test_errors_say_what_is_wrong(case):
    data, found, wanted = CASES[case]
    with pytest.raises(CaptureError) as error:
        formats.read("x.c3d", data=data)
    assert found in str(error.value), error.value
    assert wanted in str(error.value), error.value
    assert str(error.value).startswith("x.c3d: ")


def test_a_huge_file_that_is_none_takes_no_memory():
    """Counts far beyond the file's length are checked against it first."""
    data = c3d(standing(3), words={5: 65534}, more={"POINT:FRAMES": 65534})
    motion = formats.read("x.c3d", data=data)
    assert len(motion) == 3
    assert "3 believed" in motion.warnings[0]


def outcome(data: bytes) -> str:
    """Read and cut; say what came of it."""
    start = time.process_time()
    file = formats.File("x.c3d", data)
    try:
        motion = formats.read("x.c3d", data=data)
        formats.read("x.c3d", data=data, body_only=True)
        clip = formats.cutter(file)(Span(0, len(motion)))
        assert len(formats.read("clip.c3d", data=clip)) == len(motion)
        found = "motion"
    except CaptureError as error:
        found = "error"
        if not error.place.endswith("x.c3d"):
            raise
    assert time.process_time() - start < 20
    return found


def mutated(data: bytes, numbers: random.Random) -> bytes:
    """Return a file with some of its bytes changed, left out, repeated or exchanged."""
    mutable = bytearray(data)
    front = min(len(mutable), 6000)
    for _ in range(numbers.randint(1, 4)):
        at = numbers.randrange(front if numbers.random() < 0.8 else max(len(mutable), 1))
        length = numbers.choice((1, 1, 2, 4, 30, 512))
        kind = numbers.randrange(6)
        if kind == 0:
            mutable[at : at + length] = b""
        elif kind == 1:
            mutable[at:at] = mutable[at : at + length]
        elif kind == 2:
            mutable[at : at + length] = numbers.randbytes(length)
        elif kind == 3:
            mutable[at : at + 2] = numbers.choice((b"\0\0", b"\xff\xff", b"\xff\x7f", b"\1\0"))
        elif kind == 4:
            mutable[at : at + 4] = numbers.choice(
                (
                    b"\0\0\x80\x7f",
                    b"\0\0\xc0\x7f",
                    b"\xff\xff\x7f\x7f",
                    b"\0\0\x80\xbf",
                    b"\1\0\0\0",
                )
            )
        else:
            del mutable[at if numbers.random() < 0.3 else len(mutable) :]
        front = max(1, min(len(mutable), front))
    return bytes(mutable)


def test_short_fuzzing():
    numbers = random.Random(512)
    seen = {"motion": 0, "error": 0}
    for _ in some(500, 150):
        seen[outcome(mutated(numbers.choice(SMALL), numbers))] += 1
    assert min(seen.values()) > 20, seen


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_long_fuzzing(captures):
    """Mutations of made and real files; `--slow` runs it."""
    numbers = random.Random(20240229)
    real = [path.read_bytes()[:15_000] for path in sorted((captures / "c3d").glob("*.c3d"))]
    seen = {"motion": 0, "error": 0}
    for number in range(5_000):
        seen[outcome(mutated(numbers.choice(SMALL if number % 2 else real), numbers))] += 1
    assert min(seen.values()) > 50, seen
