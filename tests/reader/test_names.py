"""Names below the columns of made pages."""

import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cv2")
sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))

import cv2
from reader_pages import made

import lanindex
from lanindex.draw import svg
from lanindex.draw.picture import C
from lanindex.draw.plain import plain
from lanindex.draw.staff import draw, staff_columns
from lanindex.errors import CaptureError
from lanindex.reader.names import columns
from lanindex.reader.staff import staves


@pytest.mark.parametrize(
    ("seed", "damage"), [(9, "hard"), (15, "hard"), (26, "hard"), (16, "photo"), (23, "photo")]
)
def test_columns_are_where_their_names_are(seed: int, damage: str) -> None:
    page = made(seed, damage)
    unit, found = columns(staves(page.image))
    assert unit == pytest.approx(C / page.columns.inner)
    places = {it.part: it.x * C for it in found}
    assert places == pytest.approx(page.columns.places)


def test_a_page_without_names_is_refused() -> None:
    page = made(17)  # of one staff
    low = page.staves[0].foot[1]
    with pytest.raises(CaptureError, match="no names of columns"):
        columns(staves(np.ascontiguousarray(page.image[: round(low) + 8])))


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
