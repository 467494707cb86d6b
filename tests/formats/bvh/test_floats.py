"""Numbers: the plain and the compiled path read what Python reads, bit for bit."""

import math
import struct
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lanindex.formats.bvh import floats

floats_fast = pytest.importorskip("lanindex.formats.bvh.floats_fast")
PATHS = (floats, floats_fast)


def frames_of(data: bytes) -> np.ndarray:
    starts = [0, *(i + 1 for i, byte in enumerate(data) if byte == 10)]
    stops = [*(i for i, byte in enumerate(data) if byte == 10), len(data)]
    return np.array(
        [(a, b) for a, b in zip(starts, stops, strict=True) if b > a], np.int64
    ).reshape(-1, 2)


def read(path, lines: list[str], width: int):
    data = "\n".join(lines).encode()
    return path.parse(data, frames_of(data), width)


def bits(values) -> list[bytes]:
    return [struct.pack("<d", value) for value in values]


numbers = st.floats(-1e9, 1e9) | st.floats(-360, 360).map(lambda value: round(value, 6))
formats = st.sampled_from(["{!r}", "{:.6f}", "{:g}", "{:.17g}", "{:e}", "{:.25f}", "{:+.3E}"])
written = st.builds(lambda form, value: form.format(value), formats, numbers)


@settings(deadline=None)
@given(st.lists(written, min_size=1, max_size=20))
def test_both_read_what_python_reads(words):
    wanted = bits(map(float, words))
    for path in PATHS:
        values, bad = read(path, [" ".join(words)], len(words))
        assert bad is None
        assert bits(values[0]) == wanted


@settings(deadline=None)
@given(st.floats(1e-5, 1e8), st.integers(15, 40))
def test_the_middle_between_two_floats(value, digits):
    between = (Decimal(value) + Decimal(math.nextafter(value, math.inf))) / 2
    word = str(between)[:digits]
    for path in PATHS:
        values, bad = read(path, [word], 1)
        assert bad is None
        assert bits(values[0]) == bits([float(word)])


spellings = ["1", "-1", "+1", "1.", ".5", "-.5", "007", "0", "-0", "-0.0", "1e2", "1E+2", "1e-2"]
spellings += ["0e-400", "1e-400", "0." + "0" * 30 + "1", "1" + "0" * 8 + ".5", "1.e1", "5e-324"]
spellings += ["123456789.123456789012345678901234567890", "2.2250738585072011e-308"]


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("word", spellings)
def test_spellings(path, word):
    values, bad = read(path, [word], 1)
    assert bad is None
    assert bits(values[0]) == bits([float(word)])


no_numbers = ["x", "1x", "x1", "1_0", "--1", "+-1", "1-1", "e5", "1e", "1e+", ".", "-", "+", "-."]
no_numbers += ["1,5", "1.2.3", "0x10", "nan", "inf", "-inf", "Infinity", "1e999", "1e10", "\0"]
no_numbers += ["1000000001", "é", "1e5.5", "2e9", "1" * 400, "9" * 25]


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("word", no_numbers)
def test_what_is_no_number_is_refused(path, word):
    lines = ["1 2", f"3 {word}", "x x"]
    _, bad = read(path, lines, 2)
    assert bad == 1
    found, wanted = floats.fault(lines[1].encode(), 2)
    assert "as number 2" in found
    assert wanted


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize(("line", "count"), [("1", 1), ("1 2 3", 3), ("1 2 3 x", None)])
def test_the_count_is_held(path, line, count):
    _, bad = read(path, ["1 2", line, "1 2"], 2)
    assert bad == 1
    if count:
        assert floats.fault(line.encode(), 2) == (
            f"has {count} numbers",
            "2 as the hierarchy declares",
        )


@pytest.mark.parametrize("path", PATHS)
def test_one_line_short_and_the_next_long_is_seen(path):
    assert read(path, ["1 2 3", "4 5", "6 7 8 9"], 3)[1] == 1


@pytest.mark.parametrize("path", PATHS)
def test_any_blanks_between(path):
    values, bad = read(path, ["\t1\t \v2\f 3 \r"], 3)
    assert bad is None
    assert values.tolist() == [[1, 2, 3]]


anything = st.text(st.sampled_from("0123456789+-.eE_ \txn"), max_size=12)


@settings(deadline=None)
@given(st.lists(anything, min_size=1, max_size=4), st.integers(1, 3))
def test_both_agree_on_anything(lines, width):
    (plain, first), (fast, second) = (read(path, lines, width) for path in PATHS)
    assert first == second
    rows = len(plain) if first is None else first
    assert plain[:rows].tobytes() == fast[:rows].tobytes()


def test_a_frame_of_many_blocks():
    lines = [f"{i} {-i}.5" for i in range(9001)]
    for path in PATHS:
        values, bad = read(path, lines, 2)
        assert bad is None
        assert values[8999].tolist() == [8999, -8999.5]
        assert read(path, [*lines, "nan 0"], 2)[1] == 9001
