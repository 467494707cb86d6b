"""Windows of one staff fit together, and its symbols have names."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_scores import scores

import lanindex
from lanindex.draw import draw
from lanindex.draw.picture import PIXEL, Label, MarkGroup, Polyline
from lanindex.draw.staff import MARGIN
from lanindex.draw.strip import Staff
from lanindex.errors import UsageError
from lanindex.model import Score

CORPUS = Path(__file__).parents[2] / "corpus"
NAMED = ("compass", "marching", "jumping_jacks", "greetings", "radio_gymnastics")


def encoded(name: str) -> Score:
    return lanindex.encode(lanindex.read(CORPUS / f"{name}.bvh"))


def moved(mark, down: int):
    if isinstance(mark, MarkGroup):
        data = {name: it for name, it in mark.data.items() if name != "symbol"}
        return replace(mark, marks=tuple(moved(it, down) for it in mark.marks), data=data)
    return replace(mark, y=mark.y + down)


def groups(staff: Staff, start: float, stop: float) -> dict[str, MarkGroup]:
    """Return the symbols of a window as they stand on the whole staff."""
    down = round(staff.y(stop) * PIXEL / staff.scale)
    found = staff.picture(start, stop, foot=False).groups()
    return {it.data["symbol"]: moved(it, down) for it in found}


@pytest.mark.parametrize("name", NAMED)
def test_the_whole_is_what_is_drawn_as_one_strip(name: str) -> None:
    score = encoded(name)
    for seconds in (True, False):
        staff = Staff(score, seconds=seconds, detail="full")
        one = staff.picture(foot=False).groups()
        strip = draw(score, parts=staff.tracks, bars=None, seconds=seconds)
        those = [moved(it, -2 * MARGIN) for it in strip.groups()]
        assert len(one) > 20
        assert all(moved(it, 0) in those for it in one)
        assert "r_arm.0" in staff.symbols()
        ours = [moved(it, 0) for it in staff.picture().groups()]
        assert all(it in ours for it in those if it.marks)


@pytest.mark.parametrize("name", NAMED)
@pytest.mark.parametrize("each", [0.7, 3.0])
def test_windows_fit_together(name: str, each: float) -> None:
    staff = Staff(encoded(name), seconds=True)
    whole = groups(staff, 0, staff.duration)
    edges = [at * each for at in range(int(staff.duration / each) + 1)] + [staff.duration]
    edges = sorted({it for it in edges if staff.duration - it > 1e-3 or it == staff.duration})
    seen: dict[str, MarkGroup] = {}
    for start, stop in pairwise(edges):
        for symbol, group in groups(staff, start, stop).items():
            assert group == whole[symbol]
            seen[symbol] = group
        tall = float(ElementTree.fromstring(staff.svg(start, stop, foot=False)).get("height"))
        assert tall == pytest.approx(staff.y(start) - staff.y(stop), abs=0.11)
    assert seen == whole


def test_a_symbol_at_the_edge_is_in_both_windows() -> None:
    staff = Staff(encoded("compass"), seconds=True)
    name, symbol = next(
        (name, it) for name, it in staff.symbols().items() if it["end"] - it["start"] > 0.5
    )
    middle = (symbol["start"] + symbol["end"]) / 2
    assert groups(staff, 0, middle)[name] == groups(staff, middle, staff.duration)[name]


@given(scores(), st.booleans(), st.floats(0.3, 3))
def test_time_and_height_are_each_others_inverse(score: Score, seconds: bool, scale: float) -> None:
    try:
        staff = Staff(score, seconds=seconds, detail="full", scale=scale)
    except UsageError:  # nothing in it that has a column
        return
    assert staff.y(0) == pytest.approx(staff.height)
    times = [staff.duration * it / 40 for it in range(41)]
    ys = [staff.y(it) for it in times]
    assert ys == sorted(ys, reverse=True)
    assert [staff.seconds(y) for y in ys] == pytest.approx(times, abs=1e-6)


def test_heights_follow_uneven_beats() -> None:
    text = "#speed=60\n#unit1\ndirection r_arm right mid 0 2\ndirection r_arm place low 2 4\n"
    score = lanindex.read_lnd(text)
    rows = score.tracks["r_arm"].symbols.copy()
    rows["start"][-1] = rows["stop"][-2] = rows["stop"][-2] // 2  # its first beats are shorter
    track = replace(score.tracks["r_arm"], symbols=rows)
    uneven = replace(score, tracks={"r_arm": track})
    staff, even = Staff(uneven, detail="full"), Staff(score, detail="full")
    middle, end = (float(rows["stop"][at] / score.rate) for at in (-2, -1))
    assert staff.y(middle) == pytest.approx(even.y(2 * middle))
    assert staff.y(end) == pytest.approx(even.y(end))
    assert staff.seconds(staff.y(middle / 2)) == pytest.approx(middle / 2)


@pytest.mark.parametrize("name", NAMED)
def test_symbols_have_one_name_in_every_staff(name: str) -> None:
    score = encoded(name)
    plain, full = Staff(score, seconds=True), Staff(score, seconds=True, detail="full")
    of_full = full.symbols()
    for symbol, told in plain.symbols().items():
        part, _, ordinal = symbol.rpartition(".")
        own = score.symbols(part)[int(ordinal)]
        assert own.start == told["start_frame"] or own.stop == told["end_frame"]
        assert (own.direction or told["direction"]) == (told["direction"] or own.direction)
        if symbol in of_full:
            assert of_full[symbol]["part"] == part
    names = [it.data["symbol"] for it in plain.picture(foot=False).groups()]
    assert len(names) == len({*names})
    assert {*names} <= {*plain.symbols()}
    some = plain.symbols(1, 2)
    assert {*some} < {*plain.symbols()}
    assert all(it["end"] >= 1 and it["start"] < 2 for it in some.values())


def test_names_words_and_ink_are_in_the_svg() -> None:
    staff = Staff(encoded("compass"), seconds=True, parts=["r_arm"])
    root = ElementTree.fromstring(staff.svg(0, 4))
    drawn = {it.get("data-symbol"): it for it in root.iter() if it.get("data-symbol")}
    symbol = staff.symbols(0, 4)[name := next(iter(drawn))]
    title = drawn[name].find("{http://www.w3.org/2000/svg}title")
    assert title.text == symbol["words"]
    assert root.get("fill") == root.get("stroke") == "currentColor"
    assert float(root.get("width")) == pytest.approx(staff.width, abs=0.1)
    left, right = staff.columns["r_arm"]
    shapes = [it for it in drawn[name].iter() if it.get("d")]
    x = float(shapes[0].get("d")[1:].split()[0].split("-")[0]) / PIXEL
    assert left <= x <= right


def test_a_foot_has_the_names_and_the_positions_in_force() -> None:
    staff = Staff(encoded("compass"), seconds=True, parts=["r_arm"])
    with_foot, without = (staff.picture(9, 12, foot=it) for it in (True, False))
    names = [it.text for it in with_foot.marks if isinstance(it, Label) and it.turned]
    assert names == ["arm"]
    assert not [it for it in without.marks if isinstance(it, Label) and it.turned]
    (begun,) = (it for it in with_foot.groups() if float(it.data["end"]) <= 9)
    part, _, ordinal = begun.data["symbol"].rpartition(".")
    assert float(staff.score.symbols(part)[int(ordinal)].stop / staff.score.rate) <= 9
    window = round((staff.y(9) - staff.y(12)) * PIXEL)
    for group in with_foot.groups():  # nothing of the window reaches below it
        for mark in group.marks if group is not begun else ():
            if isinstance(mark, Polyline):
                assert max(mark.y + y for line in mark.lines for _, y in line) <= window


def test_marked_symbols_have_a_band() -> None:
    score = encoded("compass")
    symbol = score.symbols("r_arm")[3]
    staff = Staff(score, seconds=True, marked=[symbol])
    bands = [it for it in staff.picture().marks if getattr(it, "style", "") == "band"]
    assert len(bands) == 1


def test_what_makes_no_sense_is_refused() -> None:
    score = encoded("compass")
    with pytest.raises(UsageError, match='"some", wanted plain or full'):
        Staff(score, detail="some")
    with pytest.raises(UsageError, match="a scale of 0"):
        Staff(score, scale=0)
    with pytest.raises(UsageError, match='there is no part "tail"'):
        Staff(score, parts=["tail"])
    with pytest.raises(UsageError, match="nothing from 2 s to 1 s"):
        Staff(score).svg(2, 1)


def test_names_of_real_captures_are_their_own(captures: Path) -> None:
    paths = sorted((captures / "bvh").rglob("*.bvh"))[::9]
    told = 0
    for path in paths:
        score = lanindex.encode(lanindex.read(path))
        for name, symbol in Staff(score, seconds=True).symbols().items():
            part, _, ordinal = name.rpartition(".")
            own = score.symbols(part)[int(ordinal)]
            edges = own.start == symbol["start_frame"] or own.stop == symbol["end_frame"]
            assert edges, f"{path}: {name}"
            assert not own.passing
            told += 1
    assert told > 500
