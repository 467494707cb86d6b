from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from effort import examples
from hypothesis import given
from hypothesis import strategies as st
from random_scores import scores, seconds

from lanindex.alphabet import BODY, CONTACTS, kind_of
from lanindex.errors import NotationError
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.symbol import blank
from lanindex.notation import lnd

PAPER = """\
#speed=80
#rhythm 4/4
#unit_per_line 5
#unit_total 10
#unit1
//direction part direction level start end
direction l_arm left mid 0.0 1.0
direction r_arm right high 1.5 2.5
"""


WHOLE = ("r_arm", "torso", "tail", "r_arm_bend", *(part for part in BODY if part != "step"))
"""Parts whose tracks LND writes."""

BODY_LINES = """\
#speed=60
#rhythm 4/4
#unit_per_line 4
#unit_total 3
#unit0
direction r_arm place low 0 0
support r_support place mid 0 0
support l_support place mid 0 0
twist torso_twist place 0 0 0
twist head_turn right 40 0 0
incline torso_incline forward 20 0 0
incline head_incline place 0 0 0
#unit1
support r_support forward mid 0 1
travel body_travel forward 20 0 6
jump jump r_forward leap 1 1.25
support l_support forward low 1.25 2
rotation body_turn left 90 2 4
twist torso_twist left 45 2 3
#unit2
incline torso_incline l_back 25 1 2
travel body_travel place 0 2 8
jump jump place spring 3 3.5
"""


def test_the_whole_body() -> None:
    score = lnd.read(BODY_LINES)
    assert lnd.write(score) == BODY_LINES
    assert list(score.tracks) == ["r_arm", *BODY]
    assert {part: track.kind for part, track in score.tracks.items() if part in BODY} == {
        part: kind_of(part) for part in BODY
    }
    assert [str(symbol) for part in BODY[2:] for symbol in score.symbols(part)] == [
        "step forward mid [0, 8)",
        "step forward low [10, 16)",
        "jump r_forward leap [8, 10)",
        "jump place spring [56, 60)",
        "body_travel forward 20deg [0, 48)",
        "body_travel place [48, 96)",
        "body_turn left 90deg [16, 32)",
        "torso_twist place [0, 0)",
        "torso_twist left 45deg [16, 24)",
        "head_turn right 40deg [0, 0)",
        "torso_incline forward 20deg [0, 0)",
        "torso_incline l_back 25deg [40, 48)",
        "head_incline place [0, 0)",
    ]


def test_touches_and_carriers() -> None:
    text = (
        "#speed=60\n#rhythm 4/4\n#unit_per_line 4\n#unit_total 1\n#unit1\n"
        "stance r_stance mid 0 1\nstance l_stance low 0 2\n"
        "carrier other_support knee 0 3\ntouch hands_touch hand 0 1\n"
        "touch r_hand_touch head 1 2\ntouch l_hand_touch knee 2 4\n"
    )
    assert lnd.write(lnd.read(text)) == text
    assert [str(it) for part in CONTACTS for it in lnd.read(text).symbols(part)] == [
        "r_stance mid [0, 8)",
        "l_stance low [0, 16)",
        "other_support knee [0, 24)",
        "hands_touch hand [0, 8)",
        "r_hand_touch head [8, 16)",
        "l_hand_touch knee [16, 32)",
    ]


def test_a_line_of_the_body_that_is_taken_apart_at_a_bar_line_is_one() -> None:
    text = "#unit1\nrotation body_turn left 90 3 4\n#unit2\nrotation body_turn left 90 0 1\n"
    assert shown(text, "body_turn") == ["body_turn left 90deg [24, 40)"]
    text = text.replace("left 90 0", "left 45 0")
    assert [it.split(" ", 1)[1] for it in shown(text, "body_turn")] == [
        "left 90deg [24, 32)",
        "left 45deg [32, 40)",
    ]


def shown(text: str, part: str = "r_arm") -> list[str]:
    return [str(symbol) for symbol in lnd.read(text).symbols(part)]


def test_the_papers_example() -> None:
    score = lnd.read(PAPER)
    assert score.meter == Meter(Fraction(80), 4, 4, 32)
    assert score.rate == Fraction(32, 3)
    assert score.frames == 320
    assert shown(PAPER) == ["r_arm right high [12, 20)"]
    assert shown(PAPER, "l_arm") == ["l_arm left mid [0, 8)"]
    assert score.tracks["r_arm"].known == (Span(0, 320),)
    assert lnd.write(score) == PAPER.replace(".0", "")


@given(scores(WHOLE))
def test_what_is_written_is_read(score: Score) -> None:
    again = lnd.read(lnd.write(score))
    written, kept = (
        {part: rows for part, rows in seconds(one).items() if rows} for one in (score, again)
    )
    assert kept == written
    assert replace(again.meter, division=1) == replace(score.meter, division=1)
    assert again.frames / again.rate == score.frames / score.rate
    for part, track in again.tracks.items():
        mine = score.tracks[part].known
        assert [s.start / again.rate for s in track.known] == [s.start / score.rate for s in mine]


@given(scores(WHOLE))
def test_its_own_output_is_stable_to_the_byte(score: Score) -> None:
    text = lnd.write(score)
    assert lnd.write(lnd.read(text)) == text


LINES = st.sampled_from(
    [
        "#unit1",
        "#unit2",
        "#unit4",
        "// a comment",
        "//",
        "support r_foot forward mid 0 1",
        "hold r_arm 0 2",
        "rotation torso left 45 0 2",
        "#unit_per_line 7",
        "#title Swan  Lake",
        "gesture, whatever that is",
        "direction head forward mid 0 1 // looks up",
        "",
    ]
)


@given(st.lists(LINES, max_size=12).filter(lambda lines: sum("head" in line for line in lines) < 2))
def test_lines_not_understood_survive(lines: list[str]) -> None:
    text = lnd.write(lnd.read("\n".join(["#speed=60", "#unit3", *lines])))
    assert lnd.write(lnd.read(text)) == text
    for line in filter(None, lines):
        if not line.startswith(("#unit1", "#unit2", "#unit4", "direction")):
            assert text.count(line) >= lines.count(line)


def test_lines_not_understood_keep_their_unit() -> None:
    header = "// title\n#speed=60\n#rhythm 4/4\n#unit_per_line 4\n#unit_total 3\n"
    text = f"{header}#unit2\nhold r_arm 0 1\n"
    assert lnd.read(text).other == ("// title", "#unit2", "hold r_arm 0 1")
    assert lnd.write(lnd.read(text)) == text


def test_a_symbol_across_the_bar_line_stands_in_its_starting_unit() -> None:
    text = "#unit1\ndirection r_arm right mid 3 6\n"
    assert shown(text) == ["r_arm right mid [24, 48)"]
    assert lnd.read(text).frames == 64
    assert "#unit1\ndirection r_arm right mid 3 6\n" in lnd.write(lnd.read(text))


def test_halves_are_joined() -> None:
    halves = (
        "#unit1\ndirection r_arm right mid 3 4\n#unit2\ndirection r_arm right mid 0 4\n"
        "#unit3\ndirection r_arm right mid 0 1"
    )
    assert shown(halves) == ["r_arm right mid [24, 72)"]


def test_repeats_are_not_joined() -> None:
    inside = "#unit1\ndirection r_arm right mid 1 2\ndirection r_arm right mid 2 3"
    assert shown(inside) == ["r_arm right mid [8, 16)", "r_arm right mid [16, 24)"]
    border = "#unit1\ndirection r_arm right mid 3 4\ndirection r_arm right mid 4 5"
    assert shown(border) == ["r_arm right mid [24, 32)", "r_arm right mid [32, 40)"]
    assert shown(lnd.write(lnd.read(border))) == shown(border)


def test_other_directions_at_a_bar_line_are_not_joined() -> None:
    text = "#unit1\ndirection r_arm right mid 3 4\n#unit2\ndirection r_arm right high 0 1"
    assert len(shown(text)) == 2


def test_unit_0_holds_starting_positions_whatever_their_times() -> None:
    text = "#unit0\ndirection r_arm place low 1 2\n#unit1\ndirection r_arm right mid 0 1"
    assert shown(text) == ["r_arm place low [0, 0)", "r_arm right mid [0, 8)"]
    assert "#unit0\ndirection r_arm place low 0 0\n" in lnd.write(lnd.read(text))


def test_a_symbol_without_length_opens_a_new_stretch() -> None:
    text = (
        "#unit_total 2\n#unit0\ndirection head place high 0 0\n#unit1\ndirection head left mid 2 2"
    )
    assert lnd.read(text).tracks["head"].known == (Span(0, 16), Span(16, 64))


def test_a_part_seen_anew_at_a_bar_line() -> None:
    text = (
        "#speed=60\n#rhythm 4/4\n#unit_per_line 4\n#unit_total 3\n"
        "#unit1\ndirection r_arm right mid 2 4\n"
        "#unit2\ndirection r_arm right mid 0 0\ndirection r_arm right mid 0 4\n"
        "#unit3\ndirection r_arm left mid 0 0\n"
    )
    score = lnd.read(text)
    assert shown(text) == [
        "r_arm right mid [16, 32)",
        "r_arm right mid [32, 32)",
        "r_arm right mid [32, 64)",
        "r_arm left mid [64, 64)",
    ]
    assert score.tracks["r_arm"].known == (Span(0, 32), Span(32, 64), Span(64, 96))
    assert lnd.write(score) == text


def test_a_part_may_be_seen_late() -> None:
    text = "#unit_total 2\n#unit1\ndirection head left mid 2 2\n"
    assert lnd.read(text).tracks["head"].known == (Span(16, 64),)


@pytest.mark.parametrize(
    ("rhythm", "time", "division"),
    [("4/4", "0.125", 32), ("4/4", "0.0625", 64), ("3/4", "1", 96), ("4/4", "0.1", 160)],
)
def test_the_grid_is_as_fine_as_the_file_needs(rhythm: str, time: str, division: int) -> None:
    score = lnd.read(f"#rhythm {rhythm}\n#unit1\ndirection r_arm right mid 0 {time}")
    assert score.meter.division == division
    assert int(score.tracks["r_arm"].symbols[0]["stop"]) / score.rate == Fraction(time)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: text.replace("\n", "\r"),
        lambda text: b"\xef\xbb\xbf" + text.encode(),
        lambda text: text.encode("utf-16"),
        lambda text: text.upper(),
        lambda text: (
            text.replace("=80", " 80").replace("m 4/4", "m=4/4").replace("unit1", "unit 1")
        ),
        lambda text: text.replace(" ", "  \t").replace("#", "  # "),
    ],
)
def test_other_ways_of_writing_are_read(change: Callable[[str], str]) -> None:
    changed = lnd.read(change(PAPER))
    assert seconds(changed) == seconds(lnd.read(PAPER))
    assert changed.meter == lnd.read(PAPER).meter


def test_ticks_that_ran_over_a_gap_stay_readable() -> None:
    """A stretch may begin in the tick in which the last symbol before the gap still lasts."""
    rows = blank(4)
    rows["start"], rows["stop"] = [0, 0, 12, 13], [0, 10, 12, 13]
    rows["tick"], rows["ticks"] = [0, 0, 2, 2], [0, 3, 0, 0]
    rows["direction"], rows["level"] = [8, 0, 1, 2], 0
    track = Track("r_arm", rows, (Span(0, 10), Span(12, 13), Span(13, 60)))
    text = lnd.write(Score(Fraction(60), 60, Meter(), {"r_arm": track}))
    assert shown(text) == [
        "r_arm place low [0, 0)",
        "r_arm right low [0, 3)",
        "r_arm forward low [3, 3)",
    ]


HEAD = "#speed=60\n#unit1\n"


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("", 0, "no line of LND"),
        ("HIERARCHY\nROOT Hips\n", 0, "no line of LND"),
        (HEAD + "direction r_arm rihgt mid 0 1", 3, 'Did you mean "right"?'),
        (HEAD + "direction r_arm right midd 0 1", 3, 'Did you mean "mid"?'),
        (HEAD + "rotation body_turn left 0 1", 3, "4 words behind rotation, wanted five: part "),
        (HEAD + "travel body_travel left mid 0 1", 3, 'the degrees "mid", wanted a whole number'),
        (HEAD + "rotation body_turn forward 90 0 1", 3, 'the direction "forward", wanted right'),
        (HEAD + "rotation body_turn left -90 0 1", 3, 'the degrees "-90", wanted a whole number'),
        (HEAD + "rotation body_turn left 32767 0 1", 3, "a turn by 32767 degrees, wanted at most"),
        (HEAD + "jump jump forward hopp 0 1", 3, 'Did you mean "hop"?'),
        (HEAD + "jump body_travel forward hop 0 1", 3, '"jump" of body_travel, wanted "travel"'),
        (HEAD + "support r_suport forward mid 0 1", 3, '"support" of r_suport, wanted "direction"'),
        (HEAD + "direction jump forward mid 0 1", 3, '"direction" of jump, wanted "jump"'),
        (HEAD + "direction step forward mid 0 1", 3, "of step, wanted the supports that it is"),
        (HEAD + "touch r_hand head 0 1", 3, '"touch" of r_hand, wanted "direction"'),
        (HEAD + "touch r_hand_touch elbow 0 1", 3, 'the touched "elbow", wanted head trunk arm'),
        (HEAD + "touch r_hand_touch hand 0 1", 3, 'the touched "hand", wanted head trunk arm'),
        (HEAD + "touch hands_touch knee 0 1", 3, 'the touched "knee", wanted hand'),
        (HEAD + "touch r_hand_touch 0 1", 3, "3 words behind touch, wanted four: part touched"),
        (HEAD + "carrier knee 0 1", 3, "3 words behind carrier, wanted four: part carrier start"),
        (HEAD + "carier other_support knee 0 1", 3, '"carier", wanted "carrier"'),
        (HEAD + "suport r_support forward mid 0 1", 3, '"suport", wanted "support"'),
        (HEAD + "rotaton body_turn left 90 0 1", 3, '"rotaton", wanted "rotation"'),
        (HEAD + "travels body_travel left 0 0 1", 3, '"travels", wanted "travel"'),
        (HEAD + "direction r_arm right 0 1", 3, "4 words behind direction, wanted five"),
        (HEAD + "direction r_arm right mid 0 x", 3, 'the end "x", wanted a number like 1.5'),
        (HEAD + "direction r_arm right mid -1 1", 3, 'the start "-1"'),
        (HEAD + "direction r_arm right mid nan 1", 3, 'the start "nan"'),
        (HEAD + "direction r_arm right mid 0 1e999", 3, 'the end "1e999"'),
        (HEAD + "direction r_arm right mid 2 1", 3, "an end at 1, wanted at 2 or later"),
        (HEAD + "direction r2-d2 right mid 0 1", 3, 'the part "r2-d2"'),
        (HEAD + "diretion r_arm right mid 0 1", 3, '"diretion", wanted "direction"'),
        ("#sped=60", 1, 'wanted "#speed"'),
        ("#speed=0", 1, "a speed of 0, wanted 0.1 to 1000 beats a minute"),
        ("#speed=0.09", 1, "a speed of 0.09, wanted 0.1 to 1000 beats a minute"),
        ("#speed=.000000000000000000001", 1, "a speed of .0000"),
        ("#speed=1000.1", 1, "a speed of 1000.1, wanted 0.1 to 1000 beats a minute"),
        ("#speed=1e-21", 1, 'the speed "1e-21", wanted a number like 1.5'),
        ("#rhythm 100/4", 1, 'the rhythm "100/4"'),
        ("#rhythm 4/100", 1, 'the rhythm "4/100"'),
        ("#unit_total 21601", 0, "21601 units of 4 beats at 60 beats a minute, 24 hours, wanted"),
        ("#unit_total 21601\n#unit21601\ndirection head left mid 0 4", 0, "21601 units of 4"),
        ("#speed .1\n#unit37\ndirection head left mid 0 1", 3, "37 units of 4 beats at 0.1 beats"),
        (HEAD + "direction head left mid 0 86401\n#unit_total 9", 3, "wanted at most 24 hours"),
        ("#speed=fast", 1, 'the speed "fast"'),
        ("#speed=60\n#speed=70", 2, "a second speed"),
        ("#rhythm 4", 1, 'the rhythm "4", wanted beats/note like 4/4'),
        ("#rhythm 0/4", 1, 'the rhythm "0/4"'),
        ("#rhythm 3/4\n#rhythm 4/4", 2, "a second rhythm"),
        ("#unit_total many", 1, 'the total "many", wanted a whole number'),
        ("#unit -1", 1, 'the unit "-1"'),
        ("direction r_arm right mid 0 1", 1, "a symbol before any unit"),
        (HEAD + "direction head left mid 0 2\ndirection head left mid 1 3", 4, "on line 3"),
        ("#unit0\ndirection head left mid 0 0\ndirection head back mid 0 0", 3, "on line 2"),
        ("#unit999999999\ndirection head left mid 0 1", 2, "wanted at most 24 hours"),
        (
            HEAD + "\n".join(f"direction r_arm left mid {n} {n}.{10**9 + n}" for n in range(99)),
            4,
            "at most 2147483647 ticks. Round the times to a few decimals.",
        ),
        (b"#speed=60\n\x80\n", 2, "byte 10 is no UTF-8, wanted LND. Save"),
        (b"#speed=60\n\0\0\n", 2, "binary data"),
    ],
)
def test_bad_lines_are_named(text: str | bytes, line: int, said: str) -> None:
    with pytest.raises(NotationError) as caught:
        lnd.read(text + "\n" if isinstance(text, str) else text, place="walk.lnd")
    assert caught.value.place == (f"walk.lnd:{line}" if line else "walk.lnd")
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "line",
    [
        "direction r_arm {} mid 0 1",
        "direction r_arm left {} 0 1",
        "direction r_arm left mid {} 1",
        "direction r_arm left mid 0 {}",
        "direction r-{} left mid 0 1",
        "direction r_arm left mid 1.0{zeros} 0.{zeros}",
        "#speed={}",
        "#speed=0.{zeros}1",
        "#rhythm {}",
        "#unit_total {}",
        "#unit {}",
    ],
)
def test_a_long_word_is_cut(line: str) -> None:
    with pytest.raises(NotationError) as caught:
        lnd.read(HEAD.replace("60", "61") + line.format("x" * 5000, zeros="0" * 28) + "\n")
    assert len(str(caught.value)) < 250


def test_the_longest_and_the_slowest_score() -> None:
    day = lnd.read("#speed=0.1\n#unit_total 36\n#unit1\ndirection head left mid 0 144\n")
    assert day.frames / day.rate == 24 * 3600
    assert lnd.read("#speed=1000\n#rhythm 99/99\n").meter == Meter(Fraction(1000), 99, 99)


@given(st.binary(max_size=200) | st.text(max_size=200))
@examples(300)
def test_anything_else_is_read_or_refused(content: bytes | str) -> None:
    with suppress(NotationError):
        score = lnd.read(content if isinstance(content, bytes) else content + "\n")
        assert lnd.write(lnd.read(lnd.write(score))) == lnd.write(score)


def test_files(tmp_path: Path) -> None:
    path = tmp_path / "paper.lnd"
    path.write_text(PAPER)
    assert seconds(lnd.read(path)) == seconds(lnd.read(PAPER))
    assert seconds(lnd.read(str(path))) == seconds(lnd.read(PAPER))
    for wrong in (tmp_path, tmp_path / "none.lnd"):
        with pytest.raises(NotationError, match="cannot be read") as caught:
            lnd.read(wrong)
        assert caught.value.place == str(wrong)


@given(st.data())
@examples(200)
def test_damage_is_read_or_refused(data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(PAPER)))
    stop = data.draw(st.integers(start, min(start + 3, len(PAPER))))
    with suppress(NotationError):
        score = lnd.read(PAPER[:start] + data.draw(st.text(max_size=3)) + PAPER[stop:])
        assert lnd.write(lnd.read(lnd.write(score))) == lnd.write(score)
