"""Pages of a picture: all of it, each mark on the page of its staff."""

import re
from collections import Counter
from pathlib import Path

import pytest

import lanindex
from lanindex.draw import draw
from lanindex.draw.picture import PIXEL, MarkGroup, Picture
from lanindex.draw.svg import A4, EDGE, pages, rendered


@pytest.fixture
def picture(repository: Path) -> Picture:
    score = lanindex.encode(lanindex.read(repository / "corpus" / "semaphore.bvh"))
    return draw(score, bars=1, seconds=True, legend=True)


def counted(*drawn: Picture) -> Counter:
    marks = [mark for picture in drawn for mark in picture.marks]
    return Counter(
        one for mark in marks for one in (mark.marks if isinstance(mark, MarkGroup) else (mark,))
    )


def test_pages_hold_what_the_picture_holds(picture: Picture) -> None:
    found = pages(picture)
    assert len(found) > 2
    assert counted(*found) == counted(picture)
    assert [it for page in found for it in page.staves] == [*picture.staves]


def test_each_page_is_no_wider_than_a_sheet_and_holds_its_own(picture: Picture) -> None:
    found = pages(picture)
    across, up = (PIXEL * (side - 2 * EDGE) for side in A4)
    for page in found[:-1]:  # the last one has the legend, too
        assert page.width * min(1.0, up / page.height) <= across
    for page in found:
        for group in page.groups():
            assert all(page.left <= mark.x <= page.left + page.width for mark in group.marks)


def test_a_strip_is_one_page(repository: Path) -> None:
    picture = draw(lanindex.read_lnd(repository / "corpus" / "semaphore.lnd"), bars=None)
    assert pages(picture) == [picture]


def test_a_pdf_has_the_pages(picture: Picture) -> None:
    content = rendered(picture, "pdf")
    assert len(re.findall(rb"/Type /Page\b", content)) == len(pages(picture))
