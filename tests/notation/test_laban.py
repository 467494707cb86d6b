"""MAE's scores: columns, measures, and slips of their authors."""

from xml.etree import ElementTree

import pytest
from effort import examples
from hypothesis import assume, given
from random_scores import scores, shown

import lanindex
from lanindex.errors import NotationError
from lanindex.model import Score
from lanindex.notation import laban


def movement(column: str, measure: str, beat: str, duration: str, says: str) -> str:
    level, _, way = says.partition(" ")
    sign = (f"<laban:direction><laban:vertical>{level}</laban:vertical>"
            f"<laban:horizontal>{way}</laban:horizontal></laban:direction>")  # fmt: skip
    return (f"<laban:movement><laban:column>{column}</laban:column><laban:measure>{measure}"
            f"</laban:measure><laban:beat>{beat}</laban:beat><laban:duration>{duration}"
            f"</laban:duration><laban:hold>{str(says == 'hold').lower()}</laban:hold>"
            f"{sign if way else ''}</laban:movement>")  # fmt: skip


def defined(column: str, limb: str, side: str) -> str:
    return (f"<laban:columnDefinition><laban:index>{column}</laban:index><laban:preSign>"
            f"<laban:bodyPart><laban:limb><laban:default><laban:limb>{limb}</laban:limb>"
            f"</laban:default></laban:limb><laban:side>{side}</laban:side></laban:bodyPart>"
            "</laban:preSign></laban:columnDefinition>")  # fmt: skip


def score(*movements: str, columns: str = "", timing: str = "") -> bytes:
    timing = timing or (
        "<laban:timing><laban:timeUnit>millisecond</laban:timeUnit><laban:measure>"
        "<laban:index>0</laban:index><laban:beatDuration>200</laban:beatDuration>"
        "<laban:beats>5</laban:beats></laban:measure></laban:timing>"
    )
    return (
        '<laban:score xmlns:laban="http://www.example.org/labanotation"><laban:staff>'
        f"<laban:measures>6</laban:measures>{timing}<laban:columns>{columns}</laban:columns>"
        f"<laban:movements>{''.join(movements)}</laban:movements></laban:staff></laban:score>"
    ).encode()


def test_columns_and_measures() -> None:
    found = laban.read(
        score(
            movement("4", "0", "0.0", "1.0", "low place"),
            movement("4", "1", "0.0", "2.5", "middle right-forward"),
            movement("4", "2", "1.25", "2.5", "high left-backward"),
            movement("4", "3", "0", "5", "hold"),
            movement("-9", "1", "0", "5", "middle backward"),
            columns=defined("-9", "lower_arm", "left"),
        ),
        "x",
    )
    assert found.frames / found.rate == 8
    assert [
        (it.part, it.words, it.start / found.rate, it.stop / found.rate) for it in found.symbols()
    ] == [
        ("r_arm", "place low", 0, 0),
        ("r_arm", "r_forward mid", 0, 0.5),
        ("r_arm", "l_back high", 1.25, 1.75),
        ("l_forearm", "back mid", 0, 1),
    ]
    assert found.warnings == ()


def test_what_was_drawn_too_long_is_cut() -> None:
    one, two = (movement("4", "1", beat, "1.0", "low left") for beat in ("0.01", "0.95"))
    found = laban.read(score(two, one), "x")
    times = [(it.start * 1000 / found.rate, it.stop * 1000 / found.rate) for it in found.symbols()]
    assert times == [(2, 190), (190, 390)]
    assert found.warnings == ("r_arm: what begins at 0.002 s was drawn too long: cut",)
    with pytest.raises(NotationError, match=r"r_arm at 0\.16 s: begins before"):
        laban.read(score(one, movement("4", "1", "0.8", "1", "low left")), "x")


def test_other_signs_are_left_out() -> None:
    arm = movement("4", "1", "0", "1", "low left")
    found = laban.read(score(arm, movement("4", "1", "1", "1", "turn")), "x")
    assert len(found.symbols()) == 1
    assert found.warnings == ("signs that are no directions: left out",)


RIGHT = ("4", "1", "0", "1", "low left")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (score(movement("2", *RIGHT[1:])), 'x: movement 1: the column "2", wanted 4 -4'),
        (score(movement("8", *RIGHT[1:]), columns=defined("8", "tail", "left")), 'column "8"'),
        (score(movement(*RIGHT[:4], "lofty left")), 'the level "lofty", wanted low middle high'),
        (score(movement(*RIGHT[:4], "low up")), 'r_arm at 0 s: "up low", wanted right r_forward'),
        (score(movement("4", "1", "-1", *RIGHT[3:])), 'the beat "-1", wanted a number like 1.5'),
        (score(movement("4", "1", "0", "", "low left")), 'the duration "", wanted a number'),
        (score(movement("4", "999999999", *RIGHT[2:])), "wanted at most 24 hours"),
        (score(movement(*RIGHT), timing="<laban:x/>"), 'the unit of time "", wanted millisecond'),
        (score().replace(b">200<", b">0<"), "1 timings, wanted one for the whole score"),
        (score().replace(b"staff", b"page"), "no staff, wanted a score of MAE"),
        (score()[:-9], "x:1: damaged XML"),
        (b"<score/>", "XML of <score>, wanted <{http://www.example.org/labanotation}score>"),
    ],
)
def test_what_is_wrong_is_said(content: bytes, said: str) -> None:
    with pytest.raises(NotationError) as caught:
        laban.read(content, "x")
    assert said in str(caught.value)


@given(score=scores(laban.PARTS))
@examples(100)
def test_what_is_written_is_read(score: Score) -> None:
    assume(score.rate <= 1000)  # others have ticks of less than 1 ms
    again = laban.read(laban.write(score), "x")
    wanted = {
        part: [it for it in entries if it[3] < it[4] or it[4] == 0]
        for part, entries in shown(score).items()
    }
    assert shown(again) == {part: it for part, it in wanted.items() if it}
    assert again.warnings == ()


def test_what_is_written() -> None:
    lnd = """
#unit0
direction l_thigh place low 0 0
#unit1
direction r_arm r_back high 1.5 6.005
direction l_thigh back mid 1 2
direction head forward high 1 2
"""
    root = ElementTree.fromstring(laban.write(lanindex.read_lnd(lnd)))
    told = [[it.tag.partition("}")[2], it.text or ""] for it in root.iter() if not len(it)]
    assert told[:9] == [
        *(["version", "0.5"], ["author", "LanIndex"], ["title", ""], ["description", ""]),
        *(["measures", "8"], ["timeUnit", "millisecond"], ["index", "0"]),
        *(["beatDuration", "200"], ["beats", "5"]),
    ]
    assert told[9:12] == [["index", "-8"], ["limb", "upper_leg"], ["side", "left"]]
    assert [text for _, text in told[12:]] == [
        *("-8", "0", "0", "1", "false", "low", "place"),
        *("-8", "2", "0", "5", "false", "middle", "backward"),
        *("4", "2", "2.5", "22.525", "false", "high", "right-backward"),
    ]


def test_real_scores_come_back(captures) -> None:
    for path in (captures / "laban" / "mae").rglob("*.laban"):
        score = laban.read(path.read_bytes(), path.name)
        again = laban.read(laban.write(score), path.name)
        assert lanindex.write_lnd(again) == lanindex.write_lnd(score)


def test_real_scores(captures) -> None:
    paths = sorted((captures / "laban" / "mae").rglob("*.laban"))
    assert len(paths) == 25
    said = {}
    for path in paths:
        found = laban.read(path.read_bytes(), path.name)
        assert 2 <= len(found.symbols()) <= 12
        said[path.name] = found.warnings
    assert {name for name, warnings in said.items() if warnings} == {"wheel.laban"}
