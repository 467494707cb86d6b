"""Staves of made pages, whose lines are known."""

import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import lanindex
from lanindex import notation
from lanindex.draw import staff as drawing
from lanindex.draw import svg
from lanindex.draw.picture import PIXEL
from lanindex.draw.plain import plain
from lanindex.draw.svg import rendered
from lanindex.errors import CaptureError
from lanindex.model import Meter, Score

cv2 = pytest.importorskip("cv2")
pytest.importorskip("resvg_py")
reader = pytest.importorskip("lanindex.reader.staff")
sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))

import reader_pages  # noqa: E402
import reader_scores  # noqa: E402

from lanindex.reader.layout import layout  # noqa: E402

SCALE = 2.0


def made(
    score: Score, monkeypatch: pytest.MonkeyPatch, *, seconds: bool = False
) -> tuple[np.ndarray, drawing.PageLayout]:
    """Return a page of a score, and where its staves are."""
    layouts, lines = [], drawing._lines
    monkeypatch.setattr(drawing, "_lines", lambda it: layouts.append(it) or lines(it))
    picture = drawing.draw(plain(score), seconds=seconds, heading=("A dance", "slowly"))
    content = np.frombuffer(rendered(picture, "png", SCALE), np.uint8)
    return cv2.imdecode(content, cv2.IMREAD_GRAYSCALE), layouts[0]


def score(name: str, repository: Path) -> Score:
    path = str(repository / "corpus" / name)
    if name.endswith(".lnd"):
        return notation.read(path)
    return lanindex.encode(lanindex.read(path))


def turned(page: np.ndarray, degrees: float) -> np.ndarray:
    height, width = page.shape
    place = cv2.getRotationMatrix2D((width / 2, height / 2), degrees, 1.0)
    return cv2.warpAffine(page, place, (width, height), borderValue=255)


@pytest.mark.parametrize("degrees", [0.0, 0.7])
@pytest.mark.parametrize("name", ["port_de_bras.lnd", "marching.lnd", "jumping_jacks.bvh"])
def test_each_staff_is_found_where_it_was_drawn(
    name: str, degrees: float, repository: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seconds = name.endswith(".bvh")
    page, layout = made(score(name, repository), monkeypatch, seconds=seconds)
    height, width = page.shape
    place = cv2.getRotationMatrix2D((width / 2, height / 2), degrees, 1.0)
    found = reader.staves(turned(page, degrees))
    assert len(found) == len(layout.edges) - 1
    for number, staff in enumerate(found):
        centre, inner = layout.centre(number), layout.columns.inner
        low, high = layout.edges[number : number + 2]
        assert staff.inner == pytest.approx(inner / PIXEL * SCALE, abs=1.5)
        assert (staff.first, staff.last) == (number == 0, number == len(found) - 1)
        for y, height_on_staff in ((staff.base, 0), (staff.top, high - low)):
            for side in (-1, 0, 1):
                x, y_drawn = centre + side * inner, layout.base - height_on_staff
                want = place @ [x / PIXEL * SCALE, y_drawn / PIXEL * SCALE, 1]
                assert staff.on_page(staff.centre + side * staff.inner, y) == pytest.approx(
                    want, abs=3
                )
        counts = layout.clock.bar
        beats = [it for it in range(1, round((high - low) / layout.beat)) if it % counts]
        assert len(staff.ticks) == len(beats)
        step = layout.beat / PIXEL * SCALE
        for y in staff.bars:
            bars_up = (staff.base - y) / (step * counts)
            assert bars_up == pytest.approx(round(bars_up), abs=0.02)


@pytest.mark.parametrize(
    ("seed", "damage"),
    [(3, "hard"), (22, "hard"), (23, "hard"), (119, "hard"), (101, "light"), (1, "photo")],
)
def test_staves_of_damaged_pages_are_whole(seed: int, damage: str) -> None:
    page = reader_pages.made(seed, damage)
    found = reader.staves(page.image)
    assert len(found) == len(page.staves)
    for number, (staff, place) in enumerate(zip(found, page.staves, strict=True)):
        assert (staff.first, staff.last) == (number == 0, number + 1 == len(found))
        ends = [(side, y) for y in (staff.base, staff.top) for side in (-1, 1)]
        corners = [staff.on_page(staff.centre + side * staff.inner, y) for side, y in ends]
        assert np.array(corners) == pytest.approx(place.corners, abs=3)
        for ys, points in ((staff.bars, place.bars), (staff.ticks, place.ticks)):
            seen = [staff.on_page(staff.centre, y)[1] for y in ys]
            assert seen == pytest.approx(points[:, 1].tolist(), abs=2)


def test_the_image_holds_what_stands_beside_a_staff(
    repository: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page, layout = made(score("port_de_bras.lnd", repository), monkeypatch)
    first, *_ = reader.staves(turned(page, 1.0))
    outer = layout.columns.right / PIXEL * SCALE
    assert first.centre + outer < first.image.shape[1]
    for side in (-1, 0, 1):
        x = round(first.centre + side * first.inner)
        line = first.image[round(first.top) + 3 : round(first.base) - 3, x - 1 : x + 2]
        assert (line.min(axis=1) < 128).mean() > 0.98


def music() -> np.ndarray:
    page = np.full((1600, 1200), 255, np.uint8)
    for top in range(150, 1400, 200):
        for row in range(5):
            page[top + 16 * row : top + 16 * row + 2, 80:1120] = 0
        for x in range(80, 1121, 260):
            page[top : top + 64, x - 1 : x + 1] = 0
        for number in range(24):
            at = 110 + 42 * number, top + 8 * (number * 5 % 9)
            cv2.ellipse(page, at, (9, 7), -20, 0, 360, 0, -1)
            page[at[1] - 50 : at[1], at[0] + 8 : at[0] + 10] = 0
    return page


def text() -> np.ndarray:
    page = np.full((1000, 800), 255, np.uint8)
    for y in range(60, 960, 24):
        cv2.putText(page, "time runs up the page " * 3, (50, y), 0, 0.6, 0, 2, cv2.LINE_AA)
    cv2.line(page, (400, 40), (400, 970), 0, 2)
    cv2.rectangle(page, (40, 30), (760, 980), 0, 2)
    return page


def photograph() -> np.ndarray:
    noise = np.random.default_rng(1).uniform(0, 255, (900, 1200)).astype(np.float32)
    soft = cv2.GaussianBlur(noise, (0, 0), 12)
    return cv2.normalize(soft, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)


@pytest.mark.parametrize(
    "page",
    [np.full((800, 600), 255, np.uint8), np.zeros((9, 7), np.uint8), music(), text(), photograph()],
)
def test_a_page_without_a_staff_is_refused(page: np.ndarray) -> None:
    with pytest.raises(CaptureError, match="no staff of Labanotation"):
        reader.staves(page)


@pytest.mark.parametrize(
    ("name", "start", "length"),
    [("greetings", 0.0, 2.9), ("semaphore", 5.0, 1.8), ("jumping_jacks", 5.0, 1.4)],
)
def test_signs_of_a_short_score_are_no_staves(name: str, start: float, length: float) -> None:
    score = lanindex.encode(
        lanindex.read(Path(lanindex.__file__).parents[1] / "corpus" / f"{name}.bvh")
    )
    picture = drawing.draw(score, start=start, stop=start + length, seconds=True)
    drawn = np.frombuffer(svg.image(svg.write(picture, scale=1.5, ink=svg.INK)), np.uint8)
    (staff,) = reader.staves(cv2.imdecode(drawn, cv2.IMREAD_GRAYSCALE))
    second = staff.base - staff.ticks[0]
    assert (staff.base - staff.top) / second == pytest.approx(length, abs=0.05)


@pytest.mark.parametrize(
    ("name", "start", "stop", "first"),
    [("jumping_jacks.bvh", 1.0, 9.0, 1.0), ("compass.lnd", 1.6, 8.0, 0.4)],
)
def test_counts_are_found_where_a_page_does_not_begin_with_the_score(
    name: str, start: float, stop: float, first: float, repository: Path
) -> None:
    seconds = name.endswith(".bvh")
    picture = drawing.draw(plain(score(name, repository)), start=start, stop=stop, seconds=seconds)
    drawn = np.frombuffer(rendered(picture, "png", 1.5), np.uint8)
    (staff,) = reader.staves(cv2.imdecode(drawn, cv2.IMREAD_GRAYSCALE))
    lines = sorted(staff.base - y for y in (*staff.ticks, *staff.bars))
    beat = staff.inner / (2 * drawing.PITCH) * drawing.BEAT
    wanted = np.arange(first, stop - start - 0.2)
    assert np.array(lines) / beat == pytest.approx(wanted, abs=0.1)


@pytest.mark.parametrize(
    ("counts", "scale"), [(160, 1.5), pytest.param(320, 2.5, marks=pytest.mark.slow)]
)
def test_a_staff_that_is_much_longer_than_wide_is_found(counts: int, scale: float) -> None:
    rng = np.random.default_rng(1)
    ticks = counts * reader_scores.GRID
    tracks = {it: reader_scores.random_track(it, ticks, rng) for it in ("r_arm", "l_arm")}
    score = Score(Fraction(4), ticks, Meter(Fraction(60), 4, 4, 16), tracks)
    drawn = np.frombuffer(rendered(drawing.draw(score, bars=None), "png", scale), np.uint8)
    image = cv2.imdecode(drawn, cv2.IMREAD_GRAYSCALE)
    (staff,) = reader.staves(image)
    assert len(staff.bars) == counts // 4 - 1
    assert len(staff.ticks) == counts - counts // 4
    assert layout([staff]).counts[-1] == pytest.approx(counts, abs=0.1)


def test_staves_are_found_that_show_a_line_across_each() -> None:
    page = reader_pages.made(10029, "hard")  # the base of one is seen, and the end of the other
    found = reader.staves(page.image)
    assert [(it.first, it.last) for it in found] == [(True, False), (False, True)]
