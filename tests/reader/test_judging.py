"""What judges a reader of printed scores: its figures fall with each mistake, and with no other."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from effort import some

pytest.importorskip("cv2")
sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

from reader import Figures, show, wrong
from reader_damage import LEVELS
from reader_pages import CORPUS, GRID, JUDGING, made


def judged(change, level: str = "clean", seed: int = JUDGING) -> dict[str, float]:
    page, figures = made(seed, level), Figures()
    figures.add(page, lambda _: change(page.truth))
    names = ("right", "direction", "level", "times", "amount", "false")
    return dict(zip(names, map(float, figures.row()[3:9]), strict=True))


def amounts(seed: int) -> bool:
    return any(sign.amount for sign in made(seed).truth)


def test_the_truth_is_all_right() -> None:
    figures = judged(list, "light", next(filter(amounts, range(JUDGING, JUDGING + 100))))
    assert figures.pop("false") == 0
    assert {*figures.values()} == {1}


def test_each_mistake_lowers_its_own_figure() -> None:
    page = made(JUDGING)
    at = next(i for i, it in enumerate(page.truth) if it.level and it.start < it.end)
    one, most = page.truth[at], round(1 - 1 / len(page.truth), 4)
    other = {"direction": "back" if one.direction != "back" else "left"}
    level = {"level": "low" if one.level != "low" else "mid"}
    for name, change in (
        ("direction", other),
        ("level", level),
        ("times", {"end": one.end + 0.25}),
    ):
        read = [*page.truth[:at], replace(one, **change), *page.truth[at + 1 :]]
        figures = judged(lambda _, read=read: read)
        assert {it for it, share in figures.items() if share < 1} == {"right", name, "false"}
        assert figures["right"] == figures[name] == most
        assert figures["false"] == 0


def test_an_eighth_may_be_rounded_either_way() -> None:
    sign = next(sign for sign in made(7).truth if sign.start * GRID % 1)  # a conductor's beat
    for by, faults in ((-0.125, []), (0.125, []), (0.25, ["times"])):
        assert wrong(sign, replace(sign, start=sign.start + by)) == faults


def test_signs_that_are_missed_and_that_are_not_there_count() -> None:
    page = made(JUDGING)
    share = round(1 / len(page.truth), 4)
    assert judged(lambda truth: truth[1:])["right"] == round(1 - share, 4)
    figures = judged(lambda truth: [*truth, replace(truth[-1], part="tail")])
    assert (figures["right"], figures["false"]) == (1, share)
    assert judged(lambda truth: [])["right"] == 0


def test_amounts_are_a_figure_of_their_own() -> None:
    seed = next(filter(amounts, range(JUDGING, JUDGING + 100)))
    figures = judged(lambda truth: [replace(it, amount=None) for it in truth], seed=seed)
    assert (figures["right"], figures["amount"]) == (1, 0)


@pytest.mark.parametrize("level", LEVELS)
def test_every_sign_has_ink_where_it_should(level: str) -> None:
    for seed in range(3):
        page = made(seed, level)
        height, width = page.image.shape
        for sign in page.truth:
            boxes = page.boxes(sign.part, sign.start, sign.end)
            for box in boxes:
                low, high = box.min(axis=0).astype(int), box.max(axis=0).astype(int)
                assert (low >= 0).all()
                assert (high < (width, height)).all()
                seen = page.image[low[1] : high[1], low[0] : high[0]]
                assert seen.min() < np.median(page.image) * 0.8, sign


def test_pages_are_the_same_again_and_their_times_are_legible() -> None:
    assert (made(5, "photo").image == made(5, "photo").image).all()
    for seed in some(4 * len(CORPUS), 8):
        page = made(seed)
        assert page.truth
        for sign in page.truth:
            least = (1 if sign.kind in ("touch", "stance") else 2) / GRID
            assert sign.start == sign.end or sign.end - sign.start >= least, (seed, sign)
        ends = [place.counts for place in page.staves]
        assert ends[0][0] == 0
        assert max(sign.end for sign in page.truth) <= ends[-1][1] + 1e-9


def test_what_is_wrong_is_shown(tmp_path: Path) -> None:
    page = made(JUDGING, "photo")
    show(page, [(page.truth[0], None)], tmp_path / "page.png")
    assert (tmp_path / "page.png").stat().st_size > 1000
