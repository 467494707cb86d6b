"""Statistics of movement: counts, and what differs from chance."""

import re
from collections import Counter
from io import BytesIO

import numpy as np
import pytest
from dances import BOW, RAISE, dance

from lanindex.errors import ExportError, UsageError
from lanindex.library.selection import Selection
from lanindex.pipeline import charts
from lanindex.pipeline.library import Library, open_library
from lanindex.pipeline.movement import (
    BINS,
    CELLS,
    COUNTABLE_PARTS,
    GATHERED,
    USUAL,
    gathered,
    permutation_test,
)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("movement")
    rows = ["file,label,style"]
    for number in range(6):
        for name, text in (("raise", RAISE), ("bow", BOW)):
            dance(folder / f"{name}{number}.bvh", text, 30 + number)
            rows.append(f"{name}{number}.bvh,{name},{'ab'[number % 2]}")
    (folder / "own.lnd").write_text(RAISE)
    (folder / "labels.csv").write_text("\n".join(rows))
    with open_library(folder / "l.db", create=True) as opened:
        opened.ingest(folder, labels=folder / "labels.csv")
        yield opened


def counted(library: Library, part: str, label: str) -> tuple[Counter, Counter, np.ndarray, float]:
    """Count symbol by symbol."""
    cells, ways, over, seconds = Counter(), Counter(), np.zeros(BINS), 0.0
    for capture, tracks in library.tracks():
        if capture.label != label or part not in tracks:
            continue
        seconds += float(sum(len(span) for span in tracks[part].known) / capture.rate)
        before = None
        for symbol in tracks[part].listed():
            if symbol.passing:
                continue
            here = f"{symbol.direction} {symbol.level}"
            if symbol.start < symbol.stop:
                cells[here] += 1
                ways[before, here] += 1
                over[min(symbol.start * BINS // capture.frames, BINS - 1)] += 1
            before = here
    return cells, ways, over, seconds


@pytest.mark.parametrize("label", ["raise", "bow"])
@pytest.mark.parametrize("part", ["r_arm", "l_arm", "r_forearm", "r_leg"])
def test_counts_are_those_of_the_symbols(library: Library, label: str, part: str) -> None:
    found = library.movement(by="label", parts=[part])
    moves = found.of(label, part)
    cells, ways, over, seconds = counted(library, part, label)
    record = moves.record("label")
    assert record["cells"] == dict(cells)
    assert {(one, other): count for one, other, count in record["transitions"]} == dict(ways)
    assert moves.seconds == pytest.approx(seconds)
    assert np.allclose(moves.over_time * seconds / BINS, over)
    assert moves.captures == found.groups[label] == 6
    assert moves.rate == pytest.approx(sum(cells.values()) / seconds)
    assert moves.coverage == 1


def test_what_differs_is_told_and_nothing_else(library: Library) -> None:
    found = library.movement(by="label", compared=("bow", "raise"))
    told = {(one.part, one.what): one for one in found.differences if one.matters}
    assert ("r_arm", "forward mid") in told
    assert ("r_arm", "right mid") in told
    one = told["r_arm", "right mid"]
    assert one.values[0] == 0 < one.least < one.values[1] < one.most
    assert one.captures == (6, 6)
    assert one.movements[0] == 0 < one.movements[1]
    assert not [one for one in told.values() if "leg" in one.part]
    same = library.movement(by="style", compared=("a", "b"))
    assert not [one for one in same.differences if one.matters]
    turned = library.movement(by="label", compared=("raise", "bow"))
    other = next(it for it in turned.differences if (it.part, it.what) == (one.part, one.what))
    assert other.values == one.values[::-1]


def test_few_captures_tell_nothing(library: Library) -> None:
    found = library.movement(
        by="label", compared=("bow", "raise"), selection=Selection("*[01].bvh")
    )
    assert found.groups == {"bow": 2, "raise": 2}
    assert not [one for one in found.differences if one.matters]


def test_chance_is_told_as_chance() -> None:
    """Of groups that do not differ one in twenty looks as if it did, in any of many columns."""
    random, false = np.random.default_rng(1), 0
    sides = np.repeat([0, 1], 15)
    for _ in range(100):
        values = random.exponential(size=(30, 12)) * (random.random((30, 12)) < 0.5)
        values[random.random((30, 12)) < 0.1] = np.nan
        false += bool((permutation_test(values, sides)[2] <= 0.05).any())
    assert false <= 12
    values = random.normal(size=(30, 12))
    values[15:, 3] += 3
    means, spread, p, wide = permutation_test(values, sides)
    assert np.flatnonzero(p <= 0.05).tolist() == [3]
    assert means[1, 3] - means[0, 3] > wide * spread[3]


def test_many_captures_are_gathered_by_chance() -> None:
    group = np.repeat([0, 1], [3 * GATHERED + 5, 7])
    unit, sides = gathered(group)
    assert len(sides) == GATHERED + 7
    assert np.bincount(unit).max() == 4
    assert (sides[unit] == group).all()


def test_every_capture_is_one_group_where_nobody_groups_them(library: Library) -> None:
    found = library.movement()
    assert found.groups == {"all": 13}
    assert found.parts == list(USUAL)
    assert found.differences == ()
    assert set(USUAL) < set(COUNTABLE_PARTS)
    assert "step" not in COUNTABLE_PARTS
    assert len(CELLS) == 27
    nothing = library.movement(Selection("*.c3d"))
    assert nothing.groups == {}
    assert nothing.moves == ()


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"by": "shoe"}, 'no column "shoe", wanted one of label, format, style'),
        ({"by": "label", "compared": ("raise", "wave")}, 'no "wave", wanted , bow, raise'),
        ({"parts": ["tail"]}, 'no part "tail"'),
        ({"parts": ["step"]}, 'no part "step"'),
    ],
)
def test_what_there_is_not_is_refused(library: Library, how: dict, said: str) -> None:
    with pytest.raises(UsageError) as error:
        library.movement(**how)
    assert said in str(error.value)


@pytest.mark.parametrize("form", charts.FORMS)
def test_pictures_are_drawn(library: Library, form: str) -> None:
    pytest.importorskip("matplotlib")
    found = library.movement(by="label", compared=("bow", "raise"), parts=["r_arm", "l_arm"])
    content = charts.charted(found, form)
    assert content[:5].startswith({"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}[form])
    assert content == charts.charted(found, form)
    if form == "png":
        from matplotlib.image import imread

        assert imread(BytesIO(content)).std() > 0.05
    if form == "svg":
        assert b"r_arm" in content
        text = content.decode()
        assert all(text.count(f">{label}: where to<") == 1 for label in ("bow", "raise"))
        assert text.count(">second less first, % (mean of captures)<") == 1
        assert "differences matter (framed)" in text


def test_of_one_group_no_difference_is_drawn(library: Library) -> None:
    pytest.importorskip("matplotlib")
    text = charts.charted(library.movement(parts=["r_arm"]), "svg").decode()
    assert re.findall(r">([^<>]*): where to<", text) == ["all"]
    assert "differences matter" not in text


def test_pictures_that_cannot_be_drawn_are_refused(library: Library, monkeypatch) -> None:
    found = library.movement(by="path", parts=["r_arm"])
    with pytest.raises(UsageError, match="13 groups"):
        charts.charted(found, "svg")
    with pytest.raises(UsageError, match='"gif"'):
        charts.charted(found, "gif")
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    with pytest.raises(ExportError, match=r"lanindex\[plots\]"):
        charts.charted(library.movement(parts=["r_arm"]), "svg")


def test_a_part_that_never_moves_is_drawn(library: Library) -> None:
    pytest.importorskip("matplotlib")
    assert charts.charted(library.movement(parts=["head"], selection=Selection("*bow*")), "svg")
