"""Hits as text, in notebooks and as tables."""

import sys
from dataclasses import replace
from fractions import Fraction
from types import ModuleType
from typing import Any

import pytest

from lanindex import records
from lanindex.errors import LanindexError
from lanindex.model import Capture, Hit, Span, Symbol
from lanindex.search.hits import ListedHits


def symbol(part: str, direction: str, level: str, start: int, stop: int) -> Symbol:
    rest = (start, stop - start, False, 0, 0, 1.0, None, None, None)
    return Symbol(part, 0, direction, level, start, stop, *rest)


def hit(path: str = "walk.bvh", start: int = 30, label: str = "") -> Hit:
    capture = Capture(1, path, "bvh", "0" * 64, label, Fraction(30), 300)
    arm = [symbol("r_arm", "right", "mid", start, 45), symbol("r_arm", "place", "high", 45, 60)]
    head = symbol("head", "forward", "low", 45, 60)
    return Hit(capture, Span(start, 60), 0.5, (tuple(arm), (head,)))


def test_a_hit_is_told_on_a_line() -> None:
    told = "<Hit walk.bvh [30, 60) 1.00-2.00 s, fit 0.50: r_arm right mid, place high, "
    assert repr(hit()) == told + "head forward low>"
    assert repr(hit("a\x1b\n\u202eb.bvh")).startswith("<Hit a\\x1b\\n\\u202eb.bvh [30, ")
    assert (hit().path, hit().start, hit().stop) == ("walk.bvh", 30, 60)


def test_hits_are_told_on_lines() -> None:
    assert repr(ListedHits([], "head low")).splitlines() == [
        "<0 hits in 0 captures: head low>",
        "  library.suggest(pattern) tells what is near",
    ]
    lines = repr(ListedHits([hit("a\x1b.bvh")] * 12, "head\n\x1blow")).splitlines()
    assert lines[0] == "<12 hits in 1 capture: head\\n\\x1blow>"
    assert lines[1] == "  a\\x1b.bvh  [30, 60) 1.00-2.00 s, fit 0.50"
    assert lines[-1] == "  ... 2 more"
    assert len(lines) == 12


@pytest.mark.parametrize("count", [1, 10, 11])
def test_no_more_than_ten_are_told(count: int) -> None:
    lines = repr(ListedHits([hit(start=k) for k in range(count)], "head")).splitlines()
    assert lines[0].startswith(f"<{count} hit{'s' if count > 1 else ''} in 1 capture: ")
    assert lines[1].endswith("[0, 60) 0.00-2.00 s, fit 0.50")
    assert len(lines) == 1 + count
    assert lines[10:11] != ["  ... 1 more"]
    assert lines[11:] == ["  ... 1 more"][: count - 10]


def test_the_clearest_first_and_ties_as_they_were() -> None:
    mixed = ListedHits([hit(start=1), replace(hit(start=2), fit=0.9), hit(start=3)], "")
    assert [it.start for it in mixed.by_fit()] == [2, 1, 3]
    assert [it.start for it in mixed[1:]] == [2, 3]
    assert mixed.numpy()[["start", "stop"]].tolist() == [(1, 60), (2, 60), (3, 60)]


def test_a_notebook_shows_a_table() -> None:
    page = ListedHits([hit("<script>\u202e.bvh", label="a&b")] * 12, "r_arm <2s").html_table()
    assert page.startswith("<table><caption>12 hits in 1 capture: r_arm &lt;2s</caption><tr><th>")
    assert page.count("<td>&lt;script&gt;\\u202e.bvh</td><td>a&amp;b</td>") == 10
    assert page.endswith("</table><p>... 2 more</p>")
    assert "<p>" not in ListedHits([hit()], "r_arm").html_table()


@pytest.mark.parametrize("installed", [["pandas"], ["polars"], ["pandas", "polars"]])
@pytest.mark.parametrize("count", [0, 2])
def test_a_data_frame(monkeypatch: pytest.MonkeyPatch, installed: list[str], count: int) -> None:
    for name in ("pandas", "polars"):
        module: Any = ModuleType(name)
        module.DataFrame = lambda columns, name=name: (name, columns)
        monkeypatch.setitem(sys.modules, name, module if name in installed else None)
    found = ListedHits([hit()] * count, "r_arm")
    name, columns = found.to_frame()
    assert name == installed[0]
    assert list(columns) == list(records.HIT)
    assert [
        dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
    ] == (found.dicts())


def test_no_data_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setitem(sys.modules, "polars", None)
    with pytest.raises(LanindexError, match="Type: pip install pandas"):
        ListedHits([], "r_arm").to_frame()


def test_a_broken_library_of_data_frames_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    (tmp_path / "pandas.py").write_text("import nothing_of_this_name")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "pandas", raising=False)
    with pytest.raises(ModuleNotFoundError, match="nothing_of_this_name"):
        ListedHits([hit()], "r_arm").to_frame()
