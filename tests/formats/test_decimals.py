"""Numbers read in bulk equal those of `float`, to the bit, or are left to it."""

import struct

import numpy as np
import pytest
from both_loops import plain_and_compiled
from effort import examples
from hypothesis import given
from hypothesis import strategies as st

from lanindex import compiled
from lanindex.formats import decimals

digits = st.text("0123456789", min_size=0, max_size=9)
written = st.builds(
    "{}{}{}{}{}".format,
    st.sampled_from(["", "-", "+"]),
    digits,
    st.sampled_from(["", "."]),
    digits,
    st.sampled_from(["", "e5", "E-7", "e+0", "e-12", "e22", "e-30", "e"]),
)
cells = written | st.sampled_from(["", " ", "nan", "x", "1_0", "-", ".", "1.2.3", "1e5.5", "e-e5"])


def read(text: str, separator: str, columns: int):
    data = text.encode()
    lines = np.array([[0, len(data)]])
    values = np.full((1, columns), 7.0)
    done = decimals.fill(values, data, lines, separator.encode(), range(columns), columns)
    return values[0], bool(done[0])


@pytest.mark.slow
@examples(500)
@given(st.lists(cells, min_size=1, max_size=6), st.sampled_from([",", "\t", ";", " "]))
def test_what_is_read_is_what_float_reads(row, separator):
    if separator == " ":
        row = [cell for cell in row if cell.strip()] or ["0"]
    line = separator.join(row) + "\r\n"
    for values, done in plain_and_compiled(lambda: read(line, separator, len(row))):
        if done:
            wanted = [float(cell.strip() or "nan") for cell in row]
            assert struct.pack(f"{len(row)}d", *values) == struct.pack(f"{len(row)}d", *wanted)


@pytest.mark.parametrize(
    "number", ["0", "-0", "12345678", "-1234567.7654321", ".5", "5.", "1e-7", "-2.5E-3", "00012.50"]
)
def test_plain_numbers_are_read(number):
    for values, done in plain_and_compiled(lambda: read(f" {number} ,,{number}\n", ",", 3)):
        assert done
        assert values[[0, 2]].tolist() == [float(number)] * 2
        assert np.isnan(values[1])


@pytest.mark.parametrize(
    "text", ["1,2", "1,2,3,4", "1,x,3", "1,1_0,3", "1,1234567890123456,3", "1,1\0,3"]
)
def test_what_is_not_plain_is_left(text):
    for _, done in plain_and_compiled(lambda: read(text + "\n", ",", 3)):
        assert not done


@pytest.mark.parametrize(("odd", "kept"), [("-1.5e-25", True), ("1_0", False), ("x", False)])
def test_a_number_between_blanks_goes_to_float_alone_if_few_do(odd, kept):
    for values, done in plain_and_compiled(lambda: read(" ".join([*"1" * 31, odd]), " ", 32)):
        assert done == kept
        assert not kept or values.tolist() == [*[1.0] * 31, float(odd)]
    for _, done in plain_and_compiled(lambda: read(f"{odd} {odd} 1", " ", 3)):
        assert not done


def test_a_byte_that_is_no_blank_does_not_part_numbers():
    for _, done in plain_and_compiled(lambda: read("1\x002 3\n", " ", 3)):
        assert not done
    for _, done in plain_and_compiled(lambda: read("1\t2 \v3\n", " ", 3)):
        assert done


def test_long_texts_go_piece_by_piece_and_hopeless_ones_no_further(monkeypatch):
    monkeypatch.setattr(compiled, "chosen", lambda name, size: False)
    monkeypatch.setattr(decimals, "PIECE", 40)
    rows = [f"{n},{n / 8}\n" for n in range(100)]
    data = "".join(rows).encode()
    stops = np.cumsum([len(row) for row in rows])
    lines = np.stack((np.append(0, stops[:-1]), stops), axis=1)
    values = np.zeros((100, 2))
    assert decimals.fill(values, data, lines, b",", range(2), 2).all()
    assert values.tolist() == [[n, n / 8] for n in range(100)]
    data = data.replace(b".", b"x")
    done = decimals.fill(values, data, lines, b",", range(2), 2)
    assert not done[20:].any()  # of the first lines only every eighth is whole
