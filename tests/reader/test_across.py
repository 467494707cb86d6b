"""Flights, bows of touches and circles of weight: what is read is drawn as the same marks again."""

import sys
from collections import Counter
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cv2")
sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))

import cv2
from reader import matched, wrong
from reader_pages import made

from lanindex.alphabet import FEET, TOUCHED, kind_of
from lanindex.draw import draw, svg
from lanindex.draw.picture import MarkGroup, Picture
from lanindex.notation import lnd
from lanindex.reader.score import DOUBTFUL, Read, read_signs, score_of

BESIDE = ("jump", "touch", "stance")
LND = """\
#speed=60
#rhythm 4/4
#unit_total 4
#unit0
support r_support place mid 0 0
support l_support place mid 0 0
direction r_arm place low 0 0
direction l_arm place low 0 0
direction head place high 0 0
#unit1
stance r_stance mid 0 1
stance l_stance mid 0 1
touch hands_touch hand 0.5 1.5
support r_support forward low 1.5 2
support l_support right mid 1.5 2
jump jump place spring 1 2
direction r_arm right mid 1 3
stance r_stance low 2 3
stance l_stance mid 2 3
support r_support forward mid 3.5 4
jump jump forward sissonne 3 4
#unit2
stance r_stance mid 0 1
support r_support back mid 1.5 2
jump jump back hop 1 2
touch r_hand_touch head 1.25 2
stance r_stance mid 2 2.5
support l_support forward low 2.75 3
jump jump forward leap 2.5 3
stance l_stance low 3 4.5
#unit3
touch l_hand_touch thigh 0 1
support r_support place high 1 2
support l_support place high 1 2
jump jump place assemble 0.5 2
stance r_stance high 2 8
stance l_stance high 2 8
"""


def page(text: str, bars: int = 2) -> tuple[Picture, Read]:
    """Return a score as it is drawn, and as it is read."""
    picture = draw(lnd.read(text), bars=bars)
    drawn = np.frombuffer(svg.image(svg.write(picture, scale=1.6, ink=svg.INK)), np.uint8)
    return picture, read_signs(np.asarray(cv2.imdecode(drawn, cv2.IMREAD_GRAYSCALE), np.uint8))


def marks(picture: Picture) -> list[tuple[str, str]]:
    """Return the marks of flights and touches, and the circles."""
    groups = [it for it in picture.marks if isinstance(it, MarkGroup) and it.marks]
    found = [it for it in groups if not it.data or kind_of(it.data["part"]) in BESIDE]
    return sorted((it.data.get("part", it.title), str(it.marks)) for it in found)


def test_the_same_marks_are_drawn_again() -> None:
    picture, read = page(LND)
    assert not read.unknown
    again = lnd.write(score_of([read], Fraction(60)))
    assert Counter(part for part, _ in marks(picture)) == {
        **{"jump": 5, "stands on both feet": 3, "stands on the right foot": 2},
        **{"stands on the left foot": 2, "hands_touch": 1, "r_hand_touch": 1, "l_hand_touch": 1},
    }
    assert marks(draw(lnd.read(again), bars=2)) == marks(picture)


def test_supports_tell_of_flights_and_levels() -> None:
    _, read = page(LND)
    score = lnd.read(LND)
    for part in ("jump", "r_stance", "l_stance"):
        told = [
            (it.start, it.direction, it.level, it.amount) for it in read.records if it.part == part
        ]
        written = [(it.tick / 8, it.direction, it.level, it.amount) for it in score.symbols(part)]
        assert sorted(told) == written
    assert [FEET[it.amount] for it in score.symbols("jump")] == [
        *("spring", "sissonne", "hop", "leap", "assemble")
    ]


def test_what_a_bow_may_mean_otherwise_is_doubtful() -> None:
    _, read = page(LND)
    touches = {it.part: it for it in read.records if it.kind == "touch"}
    assert touches["r_hand_touch"].confidence > DOUBTFUL
    thigh = touches["l_hand_touch"]  # or the knee, the shank, or the foot
    assert TOUCHED[thigh.amount] == "thigh"
    assert thigh.confidence < DOUBTFUL


@pytest.mark.parametrize(("seed", "damage"), [(12, "clean"), (32, "clean"), (16, "photo")])
def test_marks_beside_columns_of_made_pages_are_read(seed: int, damage: str) -> None:
    made_page = made(seed, damage)
    kinds = {it.kind for it in made_page.truth}
    assert kinds & {"jump", "touch"}
    for sign, found in matched(made_page.truth, read_signs(made_page.image).records):
        if sign is None:
            assert found.kind not in BESIDE, found
        elif sign.kind in BESIDE:
            assert found, sign
            assert wrong(sign, found) == []


def test_a_landing_that_is_shorter_than_the_grid_is_read() -> None:
    text = LND.replace("right mid 1.5 2\njump jump place spring 1 2", "right mid 1.9 2.1").replace(
        "r_support forward low 1.5 2",
        "r_support forward low 1.9 2.1\njump jump place spring 1.7 2.1",
    )
    _, read = page(text)
    landed = [it for it in read.records if it.part.endswith("support") and it.end == 2]
    assert [(it.start, it.level) for it in landed] == [(1.75, "low"), (1.75, "mid")]
    assert FEET[next(it for it in read.records if it.kind == "jump").amount] == "spring"
