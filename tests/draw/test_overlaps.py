"""Signs, holds and labels of a drawn score lie apart, and inside the picture, in films too."""

from itertools import pairwise
from pathlib import Path

import pytest
from effort import thinned

import lanindex
from lanindex.draw import Picture, draw
from lanindex.draw.picture import PIXEL, C, Circle, Label, Mark, MarkGroup, Polyline
from lanindex.draw.plain import plain
from lanindex.draw.staff import BESIDE
from lanindex.film.film import LETTER, SIZE, FilmStaff

Box = tuple[float, float, float, float]

CORPUS = sorted((Path(__file__).parents[2] / "corpus").glob("*.bvh"))
REAL = (
    *("02_01.amc", "02_05.amc", "dataset-1_bow_feminine_001.bvh", "ya_throw6.bvh"),
    *("dataset-1_dance-short_normal_001.bvh", "dataset-1_kick_normal_001.bvh"),
    *("dataset-1_run_angry_001.bvh", "dataset-1_walk-left_normal_001.bvh"),
    *("dataset-2_walk-turn-right_elderly_004.bvh", "jumping_jacks.bvh", "ah_cut_01.bvh"),
    *("dataset-2_wave-both-hands_feminine_010.bvh", "an_wave7.bvh", "dab.bvh"),
    *("jesse_dance.bvh", "aitviewer_sample.bvh", "vicon_upperbody_25hz.c3d"),
    *("Ges06_chickenwing.csv", "subalakshmi_upperbody.mvnx", "pose2sim_balancing.trc"),
)


def box_of(mark: Mark) -> Box:
    """Return the ends of a mark: left, top, right, bottom."""
    match mark:
        case Polyline():
            xs, ys = zip(*(point for line in mark.lines for point in line), strict=True)
            return mark.x + min(xs), mark.y + min(ys), mark.x + max(xs), mark.y + max(ys)
        case Circle(x, y, radius):
            return x - radius, y - radius, x + radius, y + radius
        case Label(x, y, text, size, style):
            wide, high = 0.6 * size * len(text), 0.75 * size
            if mark.turned:
                return x - high, y, x, y + wide
            left = x - wide * {"begin": 0, "end": 1}.get(style, 0.5)
            return left, y - high, left + wide, y
    raise AssertionError(mark)


def boxes(picture: Picture) -> list[tuple[str, Box]]:
    """Return what has to lie apart: each label, and each piece of a sign or a hold."""
    found = []
    for mark in picture.marks:
        if isinstance(mark, Label):
            found.append((mark.text, box_of(mark)))
        elif isinstance(mark, MarkGroup) and mark.marks:
            if mark.data.get("part") in BESIDE:  # bows and flights are drawn across columns
                continue
            own = sorted(map(box_of, mark.marks))
            breaks = [at for at, (a, b) in enumerate(pairwise(own), 1) if b[0] - a[0] > 2 * C]
            for first, last in pairwise([0, *breaks, len(own)]):
                lows = (min(it[side] for it in own[first:last]) for side in (0, 1))
                highs = (max(it[side] for it in own[first:last]) for side in (2, 3))
                found.append((mark.title, (*lows, *highs)))
    return found


def overlaps(picture: Picture, most: int = 3) -> list[tuple[str, str]]:
    """Return what lies on something else, by more than `most` units, or beside the picture."""
    found, wide, high = [], picture.width, picture.height
    ordered = sorted(boxes(picture), key=lambda it: it[1][0])
    for at, (name, (left, top, right, bottom)) in enumerate(ordered):
        if left < 0 or top < 0 or right > wide or bottom > high:
            found.append((name, "outside"))
        for other, (begin, up, end, down) in ordered[at + 1 :]:
            if begin > right - most:
                break
            if min(bottom, down) - max(top, up) > most < min(right, end) - begin:
                found.append((name, other))
    return found


def check(path: Path) -> None:
    score = lanindex.encode(lanindex.read(path))
    for drawn in (plain(score), score):
        for bars in (4, 1):
            assert overlaps(draw(drawn, heading=(path.name,), bars=bars, legend=True)) == []
    seconds = min(float(score.frames / score.rate), 20)
    for (width, height), letter in ((SIZE, LETTER), ((1280, 720), 19)):
        film = FilmStaff(score, 0, seconds, (width // 2, height), letter)
        for number in range(len(film.edges)):
            assert overlaps(film.page(number)[0], 2 * PIXEL) == []  # its letters are larger


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: path.name)
def test_nothing_overlaps_in_the_corpus(path: Path) -> None:
    check(path)


@pytest.mark.parametrize("name", thinned(REAL, 3))
def test_nothing_overlaps_in_real_captures(name: str, captures: Path) -> None:
    check(next(captures.rglob(name)))
