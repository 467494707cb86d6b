"""A staff in plain text: what its rows say is what the score has, and they fit."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_scores import scores
from sample_library import sample_score

import lanindex
from lanindex.alphabet import KINDS, SIXTHS, TRACKS, kind_of
from lanindex.draw.text import ASCII, UNICODE, TextStaff, names_of
from lanindex.errors import UsageError
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.symbol import blank

WAVE = """
#unit0
direction r_arm place low 0 0
direction l_arm place low 0 0
direction head place high 0 0
#unit1
direction r_arm right high 0 1
direction l_arm left mid 2 3
#unit2
direction r_arm forward low 0.5 1
"""


def text(lines) -> list[str]:
    return ["".join(piece for piece, _ in line) for line in lines]


def shown(score, *args, signs=UNICODE, **how) -> list[str]:
    return text(TextStaff(score, signs).lines(*args, **how))


def test_a_staff_begins_above_and_left_is_left() -> None:
    assert shown(lanindex.read_lnd(WAVE)) == [
        "       L   │ R",
        "       arm │ arm",
        "       □▼  │ □▼",
        "      ═══════════",
        " 0.00      │ →▲",
        "           │ ░░",
        "           │ ░░",
        "           │ ░░",
        " 1.00      │",
        "           │",
        "           │",
        "           │",
        " 2.00  ←·  │",
        "       ▒▒  │",
        "       ▒▒  │",
        "       ▒▒  │",
        " 3.00      │",
        "    ⋮      │",
        " 4.50      │ ↑▼",
        "           │ ██",
        " 5.00      │",
        "    ⋮      │",
        "      ═══════════",
        "still: head □▲",
    ]


def test_a_stretch_says_what_is_in_force_and_what_is_marked() -> None:
    score = lanindex.read_lnd(WAVE)
    (held,) = (it for it in score.symbols("l_arm") if it.direction == "left")
    begin, end = (int(at * score.rate) for at in (2, 4))
    lines = shown(score, begin, end, marked=[held], signs=ASCII)
    assert lines[:6] == [
        "       L",
        "       arm",
        "       oL",
        "      ------",
        " 2.00 >lm",
        "    : >++",
    ]
    assert lines[-1] == "still: r_arm rH, head oH"


def test_what_is_not_known_is_no_stillness() -> None:
    rows = blank(4)
    rows["start"], rows["stop"] = [0, 10, 60, 70], [0, 20, 60, 80]
    rows["direction"], rows["level"] = 0, 1
    tracks = {"r_arm": Track("r_arm", rows, (Span(0, 30), Span(60, 90)))}
    lines = shown(Score(Fraction(20), 90, Meter(), tracks))
    cells = [line[7:].strip() for line in lines[4:-1]]
    # one folded row for 1.75 to 3 s; a position is a sign without a bar
    assert cells == ["", "", "→·", "▒▒", "", "", "?", "?", "→·", "", "→·", "▒▒", "", ""]
    inside = shown(Score(Fraction(20), 90, Meter(), tracks), 40, 70)
    assert inside[2].startswith("      ─")  # nothing is in force where nothing is known


def test_feet_that_stand_hold_the_weight() -> None:
    support, stance = blank(2), blank(1)
    support["start"], support["stop"], support["direction"], support["level"] = (
        [0, 0],
        [0, 10],
        2,
        1,
    )
    stance["start"], stance["stop"] = 10, 30
    whole = (Span(0, 60),)
    tracks = {
        "r_support": Track("r_support", support, whole),
        "r_stance": Track("r_stance", stance, whole),
    }
    lines = shown(Score(Fraction(20), 60, Meter(), tracks))
    rows = [(line[:6].strip(), line[7:].strip()) for line in lines[4:-1]]
    assert rows == [("0.00", "↑·"), ("⋮", "▒▒"), ("0.50", "○"), ("⋮", "○"), ("1.50", ""), ("⋮", "")]


def test_a_foot_that_stands_has_a_column_where_the_score_has_nothing_else() -> None:
    lines = shown(lanindex.read_lnd("#unit1\nstance r_stance mid 0.5 2\n"))
    assert [line.strip() for line in lines[:2]] == ["R", "stnd"]
    assert any(line.endswith("·") for line in lines)


@pytest.mark.parametrize("signs", [UNICODE, ASCII])
def test_every_sign_is_distinct_and_fits(signs) -> None:
    for kind in KINDS.values():
        directions = range(9) if "direction" in kind.fields else [-1]
        levels = range(3) if "level" in kind.fields else [-1]
        amounts = range(len(kind.amounts)) or range(1, 1000)
        amounts = range(SIXTHS + 1) if kind.name == "bend" else amounts  # either way
        amounts = amounts if "amount" in kind.fields else [-1]
        names = [
            signs.of(kind, where, how, much)
            for where in directions
            if where < 0 or lanindex.alphabet.DIRECTIONS[where] in kind.directions
            for how in levels
            for much in amounts
        ]
        assert len({*names}) == len(names)
        assert all(0 < len(name) <= signs.cell for name in names)
    assert signs.of(KINDS["turn"], 0, -1, 720)[1:] == "720"
    assert signs.of(KINDS["turn"], 0, -1, 32_000)[1:] == "88x"


def test_plain_characters_are_plain_and_names_fit() -> None:
    for line in shown(sample_score(), signs=ASCII):
        assert line.isascii()
    assert ASCII.legend.isascii()
    heads = [*zip(*names_of(TRACKS), strict=True)]
    assert len({*heads}) == len(TRACKS)
    assert all(len(word) <= UNICODE.cell for head in heads for word in head)


@given(score=scores(), width=st.integers(10, 200) | st.none())
def test_each_symbol_begins_once_and_lines_fit(score, width) -> None:
    there = [part for part in score.tracks if len(score.tracks[part])]
    if not there or score.frames == 0:
        return
    rows = {part: score.tracks[part].symbols for part in there}
    drawn = [part for part in there if (~rows[part]["passing"]).any()]
    staff = TextStaff(score)
    if not drawn:
        with pytest.raises(UsageError):
            staff.lines()
        return
    lines = list(staff.lines(parts=drawn, width=width))
    if width is not None and width >= 20:
        assert all(len(line) <= width for line in text(lines))
    if width is None:
        top = next(at for at, line in enumerate(lines) if "═" in line[0][0])
        quiet = {*UNICODE.bars, UNICODE.hold, "?", ""}
        cells = [cell[1:].strip() for line in lines[top + 1 :] for cell, _ in line[2::2]]
        begun = [rows[part][~rows[part]["passing"]]["stop"] > 0 for part in drawn]
        assert sum(cell not in quiet for cell in cells) == sum(it.sum() for it in begun)


@pytest.mark.parametrize("symbols", [10, 100, 1000])
def test_rows_are_no_more_than_the_score_says(symbols: int) -> None:
    rows = blank(symbols)
    rows["start"] = np.arange(symbols) * 5000
    rows["stop"] = rows["start"] + 1
    score = Score(Fraction(60), symbols * 5000, Meter(), {"r_arm": Track("r_arm", rows, ())})
    assert len(shown(score)) < 6 * symbols + 10


def test_shorter_than_a_row_is_not_lost() -> None:
    rows = blank(6)
    rows["start"], rows["stop"] = np.arange(6) * 2, np.arange(6) * 2 + 2
    rows["direction"], rows["level"] = np.arange(6), 1
    tracks = {"r_arm": Track("r_arm", rows, (Span(0, 600),))}
    lines = shown(Score(Fraction(120), 600, Meter(), tracks))
    assert [line[7:].strip() for line in lines[3:9]] == [f"{it}·" for it in "→↗↑↖←↙"]


def test_what_has_no_room_is_named() -> None:
    score = sample_score(parts=("r_arm", "l_arm", "head", "torso", "r_foot"))
    lines = shown(score, width=19)
    assert lines[-2:] == ["no room for head,", "torso, r_foot"]
    assert all(len(line) <= 19 for line in lines)
    marked = [it for it in score.symbols("r_foot") if it.start == 21]
    assert "foot" in shown(score, width=19, marked=marked)[1]


@pytest.mark.parametrize(
    ("start", "stop", "parts", "said"),
    [
        (0, 0, None, "nothing from frame 0 to 0"),
        (70, None, None, "nothing from frame 70 to 60"),
        (0, None, ["tail"], 'there is no part "tail"'),
    ],
)
def test_what_cannot_be_shown_is_said(start, stop, parts, said) -> None:
    with pytest.raises(UsageError, match=said):
        TextStaff(sample_score()).lines(start, stop, parts=parts)


def test_an_empty_score_is_said() -> None:
    with pytest.raises(UsageError, match="an empty score"):
        TextStaff(Score(Fraction(30), 30, Meter(), {})).lines()


def test_every_kind_of_track_can_be_shown() -> None:
    score = sample_score(parts=TRACKS)
    assert {kind_of(part) for part in score.tracks} == {*KINDS}
    lines = shown(score, parts=list(TRACKS))
    for before, after in pairwise(lines[4:-1]):
        assert before[:6] != after[:6] or not before[:6].strip()
