"""A score as a picture: what its symbols say can be read back, and they stand where they should."""

import re
from collections import Counter, defaultdict
from fractions import Fraction
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_scores import scores
from sample_library import sample_score

import lanindex
from lanindex.alphabet import TRACKS, kind_of
from lanindex.draw import draw, svg
from lanindex.draw.picture import Circle, Label, MarkGroup, Polyline
from lanindex.draw.plain import plain
from lanindex.draw.staff import (
    BESIDE,
    MARGIN,
    NUMBERS,
    PITCH,
    STANCES,
    TURN,
    has_column,
    spread_heights,
    staff_columns,
    usual_tracks,
)
from lanindex.errors import UsageError
from lanindex.model import SYMBOL, Meter, Score, Span, Track

SVG = "{http://www.w3.org/2000/svg}"
DRAWN = [part for part in TRACKS if part != "step" and part not in STANCES]


def short(value: Fraction) -> str:
    return f"{float(value):.3f}".rstrip("0").rstrip(".")


def said(score: Score, parts) -> Counter:
    """Return what each symbol of a score tells."""
    found = Counter()
    for part in parts:
        for symbol in score.tracks[part].listed():
            if not symbol.passing:
                known = {
                    "part": part,
                    "direction": symbol.direction,
                    "level": symbol.level,
                    "amount": symbol.amount,
                    "start": short(symbol.start / score.rate),
                    "end": short(symbol.stop / score.rate),
                }
                found[tuple(f"{key}={it}" for key, it in known.items() if it is not None)] += 1
    return found


def read_back(text: str) -> Counter:
    """Return what the groups of an SVG file tell."""
    root = ElementTree.fromstring(text)
    return Counter(
        tuple(f"{key[5:]}={it}" for key, it in group.attrib.items())
        for group in root.iter(f"{SVG}g")
        if group.attrib
    )


def usual(score: Score) -> list[str]:
    there = [part for part in score.tracks if len(score.tracks[part])]
    return [part for part in usual_tracks(there) if part in DRAWN]


@given(scores([*DRAWN, "tail"]), st.booleans(), st.sampled_from([None, 1]))
def test_symbols_are_read_back(score: Score, seconds: bool, bars: int | None) -> None:
    if not usual(score):
        return
    text = svg.write(draw(score, seconds=seconds, bars=bars))
    assert read_back(text) == said(score, usual(score))


def test_a_flight_of_no_length_is_drawn_where_the_staff_begins() -> None:
    drawn = drawn_lnd("direction r_arm right low 0 1", "jump jump right spring 0 0")
    assert "jump" in {it.data["part"] for it in drawn.groups()}


def corners(mark):
    """Return the points of a mark."""
    if isinstance(mark, Polyline):
        return [(mark.x + x, mark.y + y) for line in mark.lines for x, y in line]
    if isinstance(mark, Circle):
        return [(mark.x - mark.radius, mark.y), (mark.x + mark.radius, mark.y)]
    return [(mark.x, mark.y)] if isinstance(mark, Label) else []


COLUMNED = [part for part in DRAWN if part not in BESIDE]
ONE_PLACE = [part for part in COLUMNED if part != TURN]  # that has two: on the spot, and on a way


@given(scores(ONE_PLACE), st.sampled_from([None, 1, 4]))
def test_symbols_stay_in_their_columns_and_apart(score: Score, bars: int | None) -> None:
    if not usual(score):
        return
    picture, own = draw(score, bars=bars), staff_columns(usual(score))
    wide = NUMBERS + own.left + own.right + MARGIN
    taken = defaultdict(list)
    for group in picture.groups():
        middle = MARGIN + NUMBERS + own.left + own.places[group.data["part"]]
        pieces = defaultdict(list)
        for mark in group.marks:
            for x, y in corners(mark):
                assert 0 <= y <= picture.height
                staff, across = divmod(x - middle + PITCH // 2, wide)
                assert 0 <= x <= picture.width
                assert across <= PITCH
                pieces[staff].append(y)
        for staff, ys in pieces.items():
            taken[group.data["part"], staff].append((min(ys), max(ys)))
    for spans in taken.values():
        assert all(one[1] <= other[0] + 1 for one, other in pairwise(sorted(spans)))


@given(st.lists(st.tuples(st.integers(0, 40), st.integers(1, 99)), max_size=9))
def test_heights_are_set_apart(steps: list[tuple[int, int]]) -> None:
    spans, at = [], 0
    for rest, length in steps:
        spans.append((at + rest, at + rest + length))
        at += rest + length
    found = spread_heights(spans, 50)
    left = [it for it in found if it]
    assert all(one[1] <= other[0] for one, other in pairwise(left))
    assert all(top - low >= 25 for low, top in left[:-1])
    assert found[-1:] == left[-1:]  # where the part arrives is always shown
    everything = spread_heights(spans, 50, range(len(spans)))
    assert all(one[1] <= other[0] for one, other in pairwise(everything))
    assert all(top > low for low, top in everything)


def test_short_symbols_are_as_tall_as_their_shading_needs_and_late_ones_win() -> None:
    assert spread_heights([(0, 100), (100, 110), (300, 310)], 50) == [
        *((0, 100), (100, 150), (300, 350))
    ]
    assert spread_heights([(0, 100), (100, 110), (110, 300)], 50) == [
        *((0, 60), (60, 110), (110, 300))
    ]
    assert spread_heights([(0, 100), (100, 110), (110, 120), (120, 300)], 50) == [
        *((0, 70), None, (70, 120), (120, 300))
    ]


def test_what_ends_with_the_staff_grows_downwards() -> None:
    assert spread_heights([(0, 100), (290, 300)], 50, top=300) == [(0, 100), (250, 300)]


def drawn_lnd(*lines: str, **options):
    return draw(lanindex.read_lnd("\n".join(("#unit1", *lines)) + "\n"), seconds=True, **options)


def test_staves_are_of_equal_height_and_each_begins_with_its_second() -> None:
    picture = drawn_lnd("direction r_arm left low 0 13", bars=1)
    tops = Counter(
        mark.y + mark.lines[0][1][1]
        for mark in picture.marks
        if isinstance(mark, Polyline) and mark.lines[0][1][0] == 0
    )
    assert [*tops.values()] == [9]
    labels = [it.text for it in picture.marks if isinstance(it, Label) and it.style == "end"]
    assert labels == ["0", "5", "6", "10", "12", "15"]  # of staves of 6, 6 and 4 seconds


def test_what_is_left_of_a_symbol_on_another_staff_is_no_sliver() -> None:
    picture = drawn_lnd("direction r_arm left low 3 4.05", "direction l_arm left low 0 7", bars=1)
    by_part = {it.data["part"]: len(it.marks) for it in picture.groups()}
    assert by_part == {"r_arm": 1, "l_arm": 2}


def test_what_says_nothing_in_a_stretch_has_no_column() -> None:
    lines = ["travel body_travel forward 0 0 1", "support r_support forward mid 0 1"]
    lines += [f"rotation body_turn right 90 {at} {at + 1}" for at in (0, 3)]  # a circle, a pivot
    for start, names in ((0, {"turn", "travel"}), (2, set())):
        drawn = drawn_lnd(*lines, "direction r_arm left low 0 9", start=start)
        labels = {it.text for it in drawn.marks if isinstance(it, Label)}
        assert labels & {"turn", "travel"} == names
        assert "body_turn" in {it.data["part"] for it in drawn.groups()}


def test_a_bend_has_its_degree_and_a_straight_limb_none() -> None:
    bends = drawn_lnd("bend r_arm_bend bend3 0 0.1", "bend r_arm_bend stretch2 1 2",
                      "bend r_arm_bend stretch0 3 4")  # fmt: skip
    texts = [[it.text for it in group.marks if isinstance(it, Label)] for group in bends.groups()]
    assert texts == [["3"], ["2"], []]
    strokes = [len(group.marks[0].lines) for group in bends.groups()]
    assert strokes == [2, 3, 2]  # a cross; and a line for how long; posts, and that line


def test_odd_names_are_well_formed() -> None:
    score = sample_score()
    title = 'a <b> & "c" \x00\x1b ü \ud800'
    root = ElementTree.fromstring(svg.write(draw(score, title=title)))
    assert root.find(f"{SVG}title").text == 'a <b> & "c" \ufffd\ufffd ü \ufffd'
    assert root.attrib["role"] == "img"
    assert root.attrib["stroke"] == root.attrib["fill"] == "currentColor"


def test_one_frame_is_drawn() -> None:
    rows = np.zeros(1, SYMBOL)
    score = Score(Fraction(60), 1, Meter(), {"r_arm": Track("r_arm", rows, (Span(0, 1),))})
    picture = draw(score, seconds=True)
    assert [group.title for group in picture.groups()] == ["right arm, right low, 0 s"]


def test_symbols_are_told_in_plain_words() -> None:
    picture = drawn_lnd("direction r_arm l_back mid 0 1")
    assert [group.title for group in picture.groups()] == ["right arm, left back mid, 0-1 s"]


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"parts": ["tail"]}, 'there is no part "tail"'),
        ({"start": 9.0}, "nothing from 9 s"),
        ({"start": 1.0, "stop": 1.0}, "nothing from 1 s to 1 s"),
    ],
)
def test_what_cannot_be_drawn_is_said(options, word: str) -> None:
    with pytest.raises(UsageError, match=re.escape(word)):
        draw(sample_score(), **options)


def test_an_empty_score_is_refused() -> None:
    with pytest.raises(UsageError, match="an empty score"):
        draw(Score(Fraction(60), 60, Meter(), {}))


def test_a_part_without_a_column_is_said() -> None:
    score = lanindex.read_lnd("#unit1\ndirection tail left low 0 1\ndirection r_arm left low 0 1\n")
    picture = draw(score)
    assert picture.warnings == ("no column for tail: it is not drawn",)
    with pytest.raises(UsageError, match="no column for tail"):
        draw(score, parts=["tail"])


def test_every_track_has_a_place() -> None:
    assert [part for part in TRACKS if part != "step" and not has_column(part)] == []


def test_what_is_in_force_begins_an_excerpt() -> None:
    score = lanindex.read_lnd("corpus/jumping_jacks.lnd")
    groups = draw(score, parts=["r_arm"], start=5.25, stop=6.5).groups()
    assert [(group.data["start"], group.data["end"]) for group in groups] == [
        *[("4.5", "5"), ("5", "5.5"), ("5.5", "6"), ("6", "6.5")]
    ]


def test_kinds_have_signs() -> None:
    for part in COLUMNED:
        assert kind_of(part) in {
            *("gesture", "support", "bend", "turn", "twist", "incline", "travel", "carrier")
        }


def bands(picture) -> int:
    return sum(isinstance(mark, Polyline) and mark.style == "band" for mark in picture.marks)


def test_a_step_that_is_marked_is_its_foot() -> None:
    score = lanindex.read_lnd(
        "#unit1\nsupport r_support forward mid 0 1\nsupport l_support left mid 1 2\n"
    )
    assert bands(draw(score, marked=score.symbols("step")[:1])) == 1


def test_what_is_passed_is_marked_by_the_movement_that_passes_it() -> None:
    score = lanindex.encode(lanindex.read("corpus/jumping_jacks.bvh"))
    (passed, *_) = (it for it in score.symbols("r_arm") if it.passing)
    after = next(it for it in score.symbols("r_arm")[passed.ordinal :] if not it.passing)
    first, second = (draw(score, marked=[it]) for it in (passed, after))
    assert first.marks == second.marks
    assert bands(first) == 1


def test_what_is_marked_is_drawn() -> None:
    score = lanindex.encode(lanindex.read("corpus/jumping_jacks.bvh"))
    marked = score.symbols("r_forearm")[:1]
    for one in (score, plain(score, marked)):
        assert bands(draw(one, marked=marked)) == 1
    assert "r_forearm" not in plain(score).tracks


def test_touches_and_flights_have_bows_and_strokes() -> None:
    score = lanindex.read_lnd(
        "#unit1\ndirection r_arm left low 0 1\ndirection l_arm left low 0 1\n"
        "touch hands_touch hand 0 1\ntouch r_hand_touch thigh 1 2\njump jump place hop 2 3\n"
    )
    picture = draw(score, marked=score.symbols("hands_touch"))
    drawn = {group.data["part"]: len(group.marks) for group in picture.groups()}
    assert (drawn["hands_touch"], drawn["r_hand_touch"], drawn["jump"]) == (1, 1, 2)
    assert bands(picture) == 1


def test_weight_is_held_where_supports_are_silent() -> None:
    score = lanindex.read_lnd(
        "#unit1\nsupport r_support forward mid 0 1\nsupport l_support left mid 1 2\n"
        "stance r_stance mid 1 3\nstance l_stance mid 2 4\n"
    )
    held = [it.title for it in draw(score).marks if isinstance(it, MarkGroup) and not it.data]
    assert held == ["stands on both feet", "stands on the left foot"]


def test_a_blank_support_is_a_jump_and_a_question_that_nobody_knows() -> None:
    lines = ["stance r_stance mid 0 1", "stance l_stance mid 2 3", "jump jump place hop 3 4"]
    held = [it for it in drawn_lnd(*lines).marks if isinstance(it, MarkGroup) and not it.data]
    said = [[mark.text for mark in it.marks if isinstance(mark, Label)] for it in held]
    assert said == [[], ["?", "?"], []]
    assert held[1].title == "what carries is not known"


def test_a_long_score_has_staves_beside_each_other() -> None:
    score = lanindex.read_lnd("#unit99\ndirection r_arm left low 0 1\n")
    tall, wide = draw(score, bars=None), draw(score, bars=1)
    assert tall.height > 30 * wide.height
    assert wide.width > 30 * tall.width


@pytest.mark.parametrize("jumps", [False, True])
def test_a_legend_says_what_is_drawn(jumps: bool) -> None:
    lines = ["#unit1", "direction r_arm right mid 0 1", "jump jump place hop 1 2"][: 2 + jumps]
    score = lanindex.read_lnd("\n".join(lines) + "\n")
    plain, told = draw(score), draw(score, legend=True)
    said = [mark.title for mark in told.marks[len(plain.marks) :] if isinstance(mark, MarkGroup)]
    assert said[:2] == ["right", "right forward"]
    assert ("is in the air" in said) == jumps
    assert told.groups() == plain.groups()  # it holds no symbols
    assert told.width > plain.width
    assert draw(score, legend=True, heading=("w" * 30,)).width == told.width  # it stands below
