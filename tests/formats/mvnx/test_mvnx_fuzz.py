"""Whatever the bytes: a motion or one of our errors, and a clip that reads back equal."""

import random
import re
from pathlib import Path

import numpy as np
import pytest
from made_mvnx import mvnx, subject
from mutations import mutated

from lanindex import formats
from lanindex.errors import CaptureError
from lanindex.formats.file import File
from lanindex.formats.mvnx import subjects
from lanindex.model import Reading, Span

WORDS = [
    *(b"<frame>", b"</frame>", b"<subject>", b"</subject>", b"<position>", b"</position>", b"<"),
    *(b">", b"/>", b'"', b"&lt;", b"&e;", b"<!--", b"-->", b"<![CDATA[", b"]]>", b"<?x?>", b"x:"),
    *(b"<!DOCTYPE x []>", b'type="normal"', b"<segment/>", b"<pos_b>", b"<frame/>", b"&#0;"),
]


def outcome(data: bytes, meant: str) -> str:
    """Read and cut; anything but a motion or one of our errors is a failure."""
    file, told = File("ada.mvnx", data, meant), Reading(rate=30, unit="m", up="z")
    refused = None
    try:
        found = formats.read_file(file, told, formats.Wanted())
    except CaptureError as error:
        refused = error
    if refused is not None:
        assert refused.place.startswith("ada.mvnx")
        assert refused.wanted
        assert "\n" not in str(refused)
        return "error"
    assert subjects(file)
    half = len(found) // 2
    clip = File("ada.mvnx", formats.cutter(file)(Span(half, len(found))))
    again = formats.read_file(clip, told, formats.Wanted())
    assert np.array_equal(again.positions, found.positions[half:], equal_nan=True)
    return "motion"


VALUE = re.compile(rb'"[^"<>]*"|-?\d+\.\d+')
VALUES = (
    b"",
    b"0",
    b"-1",
    b"nan",
    b"inf",
    b"1e9",
    b"1e39",
    b"Neck",
    b"normal",
    b"1 2",
    b"RightHand",
)


def changed(data: bytes, numbers: random.Random) -> bytes:
    """Return a file that is sound XML still, with a few values changed or lines doubled."""
    for _ in range(numbers.choice((1, 2, 5))):
        if numbers.random() < 0.3:
            lines = data.splitlines(keepends=True)
            at = numbers.randrange(4, len(lines))
            if lines[at].count(b"<") == 2:
                lines[at] *= numbers.choice((0, 2))
            data = b"".join(lines)
            continue
        found = numbers.choice(list(VALUE.finditer(data)))
        quote = b'"' * found.group().startswith(b'"')
        new = quote + numbers.choice(VALUES) + quote
        data = data[: found.start()] + new + data[found.end() :]
    return data


def fuzz(sources: list[bytes], count: int) -> dict[str, int]:
    numbers = random.Random(2018)
    seen = {"motion": 0, "error": 0}
    for _ in range(count):
        meant = numbers.choice(("", "", "Bob"))
        data = numbers.choice(sources)
        damaged = changed(data, numbers) if numbers.random() < 0.5 else None
        seen[outcome(damaged or mutated(data, numbers, WORDS), meant)] += 1
    return seen


MADE = [mvnx(subject(4)), mvnx(subject(3), subject(2, "Bob"))]


@pytest.mark.slow
def test_mutations_give_a_motion_or_an_error() -> None:
    assert min(fuzz(MADE, 500).values()) > 50


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_long_fuzzing(captures: Path) -> None:
    data = (captures / "mvnx" / "subalakshmi_upperbody.mvnx").read_bytes()
    at = data.index(b'<frame time="50"')
    real = data[:at] + data[data.index(b"</frames>") :]
    seen = fuzz([*MADE, real], 5_000)
    assert min(seen.values()) > 50, seen
