"""A contact sheet as SVG."""

from xml.etree import ElementTree

import pytest
from sample_hits import SCORE, hit_of, shot_of

from lanindex.draw.svg import image
from lanindex.film.figure import View
from lanindex.film.hits import HitPreview, sheet
from lanindex.model import Span

SVG = "{http://www.w3.org/2000/svg}"
GONE = HitPreview("walk.bvh", "walk", "0.50-1.20 s", "r_arm high", trouble="is gone")
SEEN = shot_of(hit_of(SCORE, Span(30, 120), "r_arm"))


def words(text: str) -> list[str]:
    return [it.text for it in ElementTree.fromstring(text).iter(f"{SVG}text") if it.text]


def test_each_hit_has_its_card() -> None:
    text = sheet([SEEN, GONE], "r_arm high", View(0))
    said = words(text)
    assert said[:3] == ["r_arm high", "swing.bvh", f"0.50-2.00 s \u00b7 swing \u00b7 {SEEN.words}"]
    assert said[-3:] == ["walk.bvh", "0.50-1.20 s \u00b7 walk \u00b7 r_arm high", "is gone"]
    assert image(text).startswith(b"\x89PNG")


@pytest.mark.parametrize(("hits", "columns"), [(1, 1), (3, 1), (12, 2), (27, 3), (200, 5)])
def test_many_hits_fill_several_columns(hits: int, columns: int) -> None:
    root = ElementTree.fromstring(sheet([GONE] * hits, "walk", View(0)))
    cards = [it.attrib["d"] for it in root.iter(f"{SVG}path")]
    assert len(cards) == hits
    assert len({card.split()[0] for card in cards}) == columns
    assert int(root.attrib["height"]) >= 180 * hits // columns


def test_names_are_escaped_and_cut() -> None:
    name = "<script>&" + "x" * 300 + "\x00.bvh"
    text = sheet([HitPreview(name, '"', "0-1 s", "]]>", trouble="</text>")], "<r_arm>", View(0))
    said = words(text)
    assert said[0] == "<r_arm>"
    assert said[1].startswith("<script>&xxx")
    assert "\u2026" in said[1]
    assert len(said[1]) <= 80
    assert said[-1] == "</text>"


def test_nothing_is_a_sheet_too() -> None:
    assert words(sheet([], "walk", View(0))) == ["walk"]
