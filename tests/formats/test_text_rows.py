"""Tables of numbers: a plain loop, rows, damage."""

import random

import numpy as np
import pytest
from both_loops import plain_and_compiled

from lanindex.errors import CaptureError
from lanindex.formats import text_rows
from lanindex.formats.file import File

CELLS = [
    "0", "-1", "+2.5", ".5", "5.", "1e3", "-1.5E-3", "123456789.123456789", "0.1", "1e-320", "1e9",
    "89810293609", "3.14159265358979323846", "", "  ", "nan", "NaN", " 7 ", "-0", "00012.50",
]  # fmt: skip
ODD = ["x", "1_0", "1e", "--1", "1 2", "inf", "-inf", "1e10", "1e999", "0x10", "1.2.3", "\x00", "é"]


def table(lines: np.ndarray, separator: bytes, width: int, pick: random.Random) -> text_rows.Table:
    columns = pick.sample(range(width), pick.randrange(1, width + 1))
    heads = pick.randrange(len(columns))
    return text_rows.Table(lines, separator, width, tuple(columns[:heads]), tuple(columns[heads:]))


def plain(data: bytes, one: text_rows.Table) -> tuple[list[list[float]], int | None]:
    """Read rows cell by cell; return those before the first damaged one, and which that is."""
    rows = []
    for number, (first, stop) in enumerate(one.lines.tolist()):
        cells = data[first:stop].split(None if one.separator == b" " else one.separator)
        try:
            row = [float(cells[column].strip() or b"nan") for column in one.columns]
        except (ValueError, IndexError):
            return rows, number
        most = [1e18] * len(one.heads) + [1e9] * len(one.points)
        beyond = any(cell.strip() for cell in cells[one.width :])
        large = any(abs(value) > limit for value, limit in zip(row, most, strict=True))
        if beyond or large or any(b"_" in cells[column] for column in one.columns):
            return rows, number
        rows.append(row)
    return rows, None


@pytest.mark.parametrize("separator", ["\t", ",", ";", " "])
def test_rows_are_what_a_plain_loop_reads(separator):
    pick = random.Random(7)
    bad = 0
    for _ in range(400):
        width = pick.randrange(1, 9)
        choices = CELLS if pick.randrange(4) else CELLS + ODD
        text = ""
        for _ in range(pick.randrange(1, 6)):
            cells = [pick.choice(choices) for _ in range(width + pick.choice((0, 0, 0, 1, -1)))]
            cells = [cell for cell in cells if cell.strip()] if separator == " " else cells
            text += separator.join(cells) + pick.choice(("\n", "\r\n", separator + "\n"))
        data = text.encode()
        one = table(text_rows.rows(data, 0), separator.encode(), width, pick)
        wanted, damaged = plain(data, one)
        (values, first), compiled = plain_and_compiled(
            lambda data=data, one=one: text_rows.parse(data, one.lines, one)
        )
        assert compiled[1] == first, data
        np.testing.assert_array_equal(compiled[0][:first], values[:first])
        assert first == damaged, data
        np.testing.assert_array_equal(
            values[:first], np.array(wanted).reshape(-1, len(one.columns))
        )
        bad += damaged is not None
    assert 50 < bad < 350


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("piece", [7, 1 << 17])
def test_rows(monkeypatch, end, piece):
    monkeypatch.setattr(text_rows, "_PIECE", piece)
    lines = ["1,2,3", "", ",,,", "-4,5,6", " ", " 7,8,9", ",,5"]
    data = ("head" + end + end.join(lines)).encode()
    found = text_rows.rows(data, 4 + len(end))
    assert [data[first:stop].decode().rstrip() for first, stop in found.tolist()] == [
        "1,2,3", "-4,5,6", " 7,8,9", ",,5",
    ]  # fmt: skip
    assert len(text_rows.rows(data, len(data))) == 0


def test_a_comma_for_the_point():
    data = b"1;0,5;1,25;-2,0;x\n2;0,6;;3,0;y\n"
    one = text_rows.Table(text_rows.rows(data, 0), b";", 5, (0,), (1, 2, 3), comma=True)
    heads, points = text_rows.read(File("a.csv", data), one)
    assert heads.tolist() == [[1], [2]]
    assert points[0, 0].tolist() == [0.5, 1.25, -2.0]
    assert np.isnan(points[1]).all()


def test_nothing_is_allocated_for_rows_that_are_too_short():
    data = b"1\n" * 200_000
    columns = tuple(range(3 * 100_000))
    one = text_rows.Table(text_rows.rows(data, 0), b",", len(columns), (), columns)
    with pytest.raises(CaptureError, match="frame 0 has 1 cells, wanted 300000"):
        text_rows.read(File("a.csv", data), one)


def test_places_of_nothing():
    places = np.ones((4, 3, 3), np.float32)
    places[1, 0] = places[:, 1] = 0
    doubts = text_rows.at_origin(places, ("a", "b", "c"))
    assert doubts == ("a at 0, 0, 0 in 1 frames: taken as unknown",)
    assert np.argwhere(np.isnan(places[..., 0])).tolist() == [[1, 0]]
