"""Names below the columns of made pages."""

import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("cv2")
sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))

import cv2
from reader_pages import made
from reader_scores import GRID, random_track

import lanindex
from lanindex.alphabet import TRACKS
from lanindex.draw import svg
from lanindex.draw.picture import C, Label
from lanindex.draw.plain import plain
from lanindex.draw.staff import draw, staff_columns
from lanindex.errors import CaptureError
from lanindex.model import Meter, Score
from lanindex.model.symbol import listed
from lanindex.reader.names import WIDEST, columns
from lanindex.reader.score import read_signs
from lanindex.reader.staff import staves


@pytest.mark.parametrize(
    ("seed", "damage"), [(9, "hard"), (15, "hard"), (26, "hard"), (16, "photo"), (23, "photo")]
)
def test_columns_are_where_their_names_are(seed: int, damage: str) -> None:
    page = made(seed, damage)
    unit, found, _ = columns(staves(page.image))
    assert unit == pytest.approx(C / page.columns.inner)
    places = {it.part: it.x * C for it in found}
    assert places == pytest.approx(page.columns.places)


def test_columns_of_the_widest_score_are_looked_at() -> None:
    places = staff_columns(TRACKS).places.values()
    assert max(abs(it) / C for it in places) + 1 < WIDEST


def without_names(score: Score) -> NDArray[np.uint8]:
    picture = draw(score, seconds=True)
    marks = [it for it in picture.marks if not (isinstance(it, Label) and it.style == "under")]
    shown = svg.image(svg.write(replace(picture, marks=tuple(marks)), scale=1.5, ink=svg.INK))
    image = cv2.imdecode(np.frombuffer(shown, np.uint8), cv2.IMREAD_GRAYSCALE)
    return np.asarray(image, np.uint8)


USUAL = ["r_support", "l_support", "r_leg", "l_leg", "torso", "r_arm", "l_arm", "head"]


@pytest.mark.parametrize(
    "parts",
    [
        USUAL,
        USUAL[4:],
        ["r_arm", "l_arm"],  # in the column of the torso
        ["torso", "r_upper_arm", "l_upper_arm", "r_forearm", "l_forearm", "head"],
    ],
)
def test_columns_without_names_are_where_they_usually_are(parts: list[str]) -> None:
    rng = np.random.default_rng(3)
    ticks = 24 * GRID
    tracks = {it: random_track(it, ticks, rng) for it in parts}
    score = Score(Fraction(GRID), ticks, Meter(Fraction(60), 4, 4, 4 * GRID), tracks)
    page = read_signs(without_names(score))
    assert any("taken by their places" in it for it in page.notes)
    assert {it.part for it in page.records} == {*parts}
    found = {(it.part, it.direction, it.level, it.start, it.end) for it in page.records}
    drawn = {
        (it.part, it.direction, it.level, it.start / GRID, it.stop / GRID)
        for part in parts
        for it in listed(part, tracks[part].symbols)
        if it.direction
    }
    assert len(found & drawn) > 0.9 * len(drawn)
    assert len(found - drawn) < 0.1 * len(drawn)


def test_names_that_cannot_be_read_are_refused() -> None:
    page = made(17)  # of one staff
    low = round(page.staves[0].foot[1])
    blurred = page.image.copy()
    blurred[low + 8 :] = cv2.GaussianBlur(blurred[low + 8 :], (0, 0), 6)
    with pytest.raises(CaptureError, match="no names of columns that can be read"):
        columns(staves(blurred))


def test_a_column_nearer_to_the_next_staff_than_to_its_own_is_found() -> None:
    corpus = Path(lanindex.__file__).parents[1] / "corpus"
    score = plain(lanindex.encode(lanindex.read(corpus / "greetings.bvh")))
    picture = draw(score, seconds=True)
    drawn = np.frombuffer(svg.image(svg.write(picture, scale=1.5, ink=svg.INK)), np.uint8)
    found = columns(staves(np.asarray(cv2.imdecode(drawn, cv2.IMREAD_GRAYSCALE), np.uint8)))[1]
    named = {it.part: round(it.x * C) for it in found}
    parts = {it.data["part"] for it in picture.groups()}
    places = staff_columns(parts).places
    assert "head_incline" in named
    assert {it: places[it] for it in named} == named
