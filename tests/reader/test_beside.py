"""Nothing on a page is passed over in silence: what is painted on one is told."""

import sys
from pathlib import Path

import command
import numpy as np
import pytest
from effort import thinned
from numpy.typing import NDArray

import lanindex

cv2 = pytest.importorskip("cv2")
sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))

from printed_page import clean  # noqa: E402
from reader_pages import Made, made  # noqa: E402

from lanindex.draw import staff  # noqa: E402
from lanindex.draw.staff import MARGIN, NUMBERS, draw  # noqa: E402
from lanindex.draw.svg import rendered  # noqa: E402
from lanindex.notation import lnd  # noqa: E402
from lanindex.reader.score import Read, read_signs  # noqa: E402
from lanindex.reader.staff import staves  # noqa: E402

Page = NDArray[np.uint8]
CORPUS = Path(lanindex.__file__).parents[1] / "corpus"
STAVES = 1  # seed of a page of three staves


def at(page: Page, across: float, count: float) -> tuple[int, int]:
    """Return where a place of `clean` is, widths of a symbol from the centre line, and counts."""
    (only,) = staves(page)
    unit = only.inner / 2.4
    return round(only.centre + across * unit), round(only.base - 4 * unit * count)


def framed(page: Page, across: float, count: float) -> None:
    """Paint a sign as high as a count."""
    left, foot = at(page, across - 0.5, count)
    right, top = at(page, across + 0.5, count + 1)
    cv2.rectangle(page, (left, top), (right, foot), 0, 2)


@pytest.mark.parametrize(("across", "count"), [(-4.2, 2), (4.2, -1.25), (0.6, 2), (-1.8, -1.25)])
def test_a_sign_without_a_column_is_told(across: float, count: float) -> None:
    page = clean().copy()
    framed(page, across, count)
    (found,) = read_signs(page).unknown
    assert (found.part, found.start, found.end) == ("", max(count, 0), max(count + 1, 0))
    corners = *at(page, across - 0.5, count + 1), *at(page, across + 0.5, count)
    assert np.abs(np.subtract(found.box, corners)).max() < 20  # a tick may hide an edge of it


def test_it_is_shown_among_the_doubts(tmp_path: Path) -> None:
    page = clean().copy()
    framed(page, 4.2, 2)
    cv2.imwrite(str(tmp_path / "page.png"), page)
    done = command.run("read-score", "page.png", "--doubts", "doubts.html", cwd=tmp_path)
    told = "page 1, staff 1, where no column has a name, count 2 to 3: not known, left out"
    assert done.returncode == 1
    assert told in done.stderr
    assert told in (tmp_path / "doubts.html").read_text()


def without(page: Made, number: int) -> Page:
    """Return a page without one of its staves, its columns, numbers and names."""
    image, columns = page.image.copy(), page.columns
    centre, base = page.drawn[number]
    ends = (centre - columns.left - NUMBERS, 0), (centre + columns.right + MARGIN // 2, base)
    (left, _), (right, _) = page.forward(np.array(ends)).round().astype(int).tolist()
    image[:, left:right] = 255
    return image


def test_a_staff_that_is_missing_is_told() -> None:
    page = made(STAVES)
    assert len(page.staves) == 3
    assert read_signs(page.image).notes == []
    told = "between staff 1 and 2: room for a staff, and none is found"
    assert read_signs(without(page, 1)).notes == [told]


@pytest.mark.parametrize("other", ["Ellenbogen", "pelvis"])
def test_names_that_are_hardly_like_known_ones_are_told(
    other: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = staff.name_of
    monkeypatch.setattr(staff, "name_of", lambda it: other if it == "head" else known(it))
    content = rendered(draw(lnd.read(CORPUS / "greetings.lnd")), "png", 1.5)
    monkeypatch.undo()
    (told,) = read(content).notes
    assert told.startswith("below the staves: a name that is read as ")


def test_names_that_are_not_known_are_told() -> None:
    page = clean().copy()
    x, y = at(page, 3.0, -1.27)
    page[y:, x - 14 : x + 20] = 255
    word = np.full((20, 100), 255, np.uint8)
    cv2.putText(word, "Ellenbogen", (2, 15), 0, 0.45, 0, 1, cv2.LINE_AA)
    page[y : y + 100, x - 10 : x + 10] = word.T[::-1]
    found = read_signs(page)
    assert found.notes == ["below staff 1: 1 name of a column not known"]
    assert any(not it.part for it in found.unknown)


def read(content: bytes) -> Read:
    page = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_GRAYSCALE)
    return read_signs(np.asarray(page))


def test_legends_headings_and_numbers_are_no_signs() -> None:
    heading = ("A title of many words, which goes over several staves", "slowly")
    score = lnd.read(CORPUS / "semaphore.lnd")
    page = read(rendered(draw(score, heading=heading, seconds=True, legend=True), "png", 1.5))
    assert page.notes == []
    assert [it for it in page.unknown if not it.part] == []


@pytest.mark.parametrize("damage", thinned(["photo", "clean", "light", "hard"], 4))
def test_made_pages_have_no_such_ink(damage: str) -> None:
    page = read_signs(made(STAVES, damage).image)
    assert page.notes == []
    assert [it for it in page.unknown if not it.part] == []
