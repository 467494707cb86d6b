"""Rows of numbers equal those that Python reads, bit for bit."""

import math
import struct
from decimal import Decimal

import numpy as np
import pytest
from both_loops import plain_and_compiled
from hypothesis import given
from hypothesis import strategies as st

from lanindex.formats.text_rows import fault, number_rows


def frames_of(data: bytes) -> np.ndarray:
    starts = [0, *(i + 1 for i, byte in enumerate(data) if byte == 10)]
    stops = [*(i for i, byte in enumerate(data) if byte == 10), len(data)]
    return np.array(
        [(a, b) for a, b in zip(starts, stops, strict=True) if b > a], np.int64
    ).reshape(-1, 2)


def read(lines: list[str], width: int):
    """Read rows in both ways, which give the same bits."""
    data = "\n".join(lines).encode()
    frames = frames_of(data)
    (values, bad), compiled = plain_and_compiled(lambda: number_rows(data, frames, width))
    assert compiled[1] == bad
    assert compiled[0][:bad].tobytes() == values[:bad].tobytes()
    return values, bad


def bits(values) -> list[bytes]:
    return [struct.pack("<d", value) for value in values]


numbers = st.floats(-1e9, 1e9) | st.floats(-360, 360).map(lambda value: round(value, 6))
formats = st.sampled_from(["{!r}", "{:.6f}", "{:g}", "{:.17g}", "{:e}", "{:.25f}", "{:+.3E}"])
written = st.builds(lambda form, value: form.format(value), formats, numbers)


@given(st.lists(written, min_size=1, max_size=20))
def test_words_are_what_python_reads(words):
    wanted = bits(map(float, words))
    values, bad = read([" ".join(words)], len(words))
    assert bad is None
    assert bits(values[0]) == wanted


@given(st.floats(1e-5, 1e8), st.integers(15, 40))
def test_the_middle_between_two_floats(value, digits):
    between = (Decimal(value) + Decimal(math.nextafter(value, math.inf))) / 2
    word = str(between)[:digits]
    values, bad = read([word], 1)
    assert bad is None
    assert bits(values[0]) == bits([float(word)])


spellings = ["1", "-1", "+1", "1.", ".5", "-.5", "007", "0", "-0", "-0.0", "1e2", "1E+2", "1e-2"]
spellings += ["0e-400", "1e-400", "0." + "0" * 30 + "1", "1" + "0" * 8 + ".5", "1.e1", "5e-324"]
spellings += ["123456789.123456789012345678901234567890", "2.2250738585072011e-308"]


@pytest.mark.parametrize("word", spellings)
def test_spellings(word):
    values, bad = read([word], 1)
    assert bad is None
    assert bits(values[0]) == bits([float(word)])


no_numbers = ["x", "1x", "x1", "1_0", "--1", "+-1", "1-1", "e5", "1e", "1e+", ".", "-", "+", "-."]
no_numbers += ["1,5", "1.2.3", "0x10", "nan", "inf", "-inf", "Infinity", "1e999", "1e10", "\0"]
no_numbers += ["1000000001", "é", "1e5.5", "2e9", "1" * 400, "9" * 25]


@pytest.mark.parametrize("word", no_numbers)
def test_what_is_no_number_is_refused(word):
    lines = ["1 2", f"3 {word}", "x x"]
    _, bad = read(lines, 2)
    assert bad == 1
    found, wanted = fault(lines[1].encode(), 2)
    assert "as number 2" in found
    assert wanted


@pytest.mark.parametrize(("line", "count"), [("1", 1), ("1 2 3", 3), ("1 2 3 x", None)])
def test_the_count_is_held(line, count):
    _, bad = read(["1 2", line, "1 2"], 2)
    assert bad == 1
    if count:
        assert fault(line.encode(), 2) == (
            f"has {count} numbers",
            "2 as the hierarchy declares",
        )


def test_one_line_short_and_the_next_long_is_seen():
    assert read(["1 2 3", "4 5", "6 7 8 9"], 3)[1] == 1


def test_any_blanks_between():
    values, bad = read(["\t1\t \v2\f 3 \r"], 3)
    assert bad is None
    assert values.tolist() == [[1, 2, 3]]


def test_a_frame_of_many_blocks():
    lines = [f"{i} {-i}.5" for i in range(9001)]
    values, bad = read(lines, 2)
    assert bad is None
    assert values[8999].tolist() == [8999, -8999.5]
    assert read([*lines, "nan 0"], 2)[1] == 9001
