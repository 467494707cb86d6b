from dataclasses import replace

import pytest

from lanindex.alphabet import DIRECTION_CODES
from lanindex.errors import NotationError
from lanindex.notation.lpd_ldd import parse_lpd

PAPER = """\
place	250
forward	67.5
r_forward	22.5
right	337.5
r_back	292.5
back	247.5
l_back	202.5
left	157.5
l_forward	112.5
high	120
mid	60	240
low	300
"""


def test_figure_13_of_the_paper() -> None:
    ranges = parse_lpd(PAPER)
    assert (ranges.place, ranges.relative, ranges.mid, ranges.high) == (250, False, 60, 120)
    assert ranges.radius(500) == 250
    assert [ranges.centre(code) for code in range(8)] == [45.0 * code for code in range(8)]


def test_place_in_limb_lengths() -> None:
    ranges = parse_lpd(PAPER.replace("250", "0.38 L"))
    assert ranges.relative
    assert ranges.radius(500) == pytest.approx(190)


def test_uneven_sectors_have_their_own_middles() -> None:
    ranges = parse_lpd(PAPER.replace("67.5", "57.5"))
    assert ranges.centre(DIRECTION_CODES["r_forward"]) == 40
    assert ranges.centre(DIRECTION_CODES["forward"]) == 85


def test_a_sector_of_more_than_half_the_circle() -> None:
    starts = (0, 200, 210, 220, 230, 240, 250, 260)
    ranges = replace(parse_lpd(PAPER), starts=tuple(map(float, starts)))
    assert [ranges.centre(code) for code in range(8)] == [100, 205, 215, 225, 235, 245, 255, 310]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("place\t250", "place\tfar", 'p.lpd:1: "far", wanted a number of 0 or more'),
        ("place\t250", "place\t-1", 'p.lpd:1: "-1", wanted a number of 0 or more'),
        ("place\t250", "place\tnan", 'p.lpd:1: "nan", wanted a number of 0 or more'),
        ("place\t250", "place\t" + "x" * 5000, f'p.lpd:1: "{"x" * 59}…", wanted a number'),
        ("place\t250", "x" * 5000, f'p.lpd:1: "{"x" * 59}…", wanted a direction or a level'),
        ("place\t250", "place\t1 m", "p.lpd:1: 2 values after place, wanted 1"),
        ("forward\t67.5", "forwards\t67.5", 'p.lpd:2: "forwards", wanted a direction or a level'),
        ("forward\t67.5", "left\t67.5", 'p.lpd:8: "left" stands twice, wanted one line of it'),
        ("low\t300\n", "", "p.lpd: no line for low, wanted all of them"),
        ("mid\t60\t240", "mid\t60", "p.lpd:11: 1 values after mid, wanted 2"),
        ("low\t300", "low\t290", "wanted mid m 360-h, high h, low 360-m"),
        ("high\t120", "high\t50", "wanted mid m 360-h, high h, low 360-m"),
        ("r_forward\t22.5", "r_forward\t67.5", "the directions do not follow each other"),
        ("l_forward\t112.5", "l_forward\t427.5", "the directions do not follow each other"),
        ("right\t337.5", "right\t30", "the directions do not follow each other"),
    ],
    ids=lambda text: text[:40],
)
def test_errors_name_the_line(old: str, new: str, message: str) -> None:
    with pytest.raises(NotationError) as error:
        parse_lpd(PAPER.replace(old, new, 1), "p.lpd")
    assert message in str(error.value)
