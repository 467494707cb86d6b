"""Hits as one page: it asks nobody for anything, and nothing in it is taken for markup."""

import re
from base64 import b64decode
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from sample_hits import SCORE, hit_of, shot_of

from lanindex.draw.svg import BODY
from lanindex.film.figure import LEGEND, View
from lanindex.film.hits import FRAMES, HitPreview, page
from lanindex.model import Span

GONE = HitPreview("walk.bvh", "walk", "0.50-1.20 s", "r_arm high", trouble="is gone")
SEEN = shot_of(hit_of(SCORE, Span(30, 120), "r_arm"))
EVIL = [
    "</script><script>alert(1)</script>",
    '" onclick="alert(1)',
    "' autofocus onfocus='alert(1)",
    "<img src=http://x.test/y>",
    "$title ${cards} $$ \\u003c",
    "]]> --> &lt; \x00\x1b",
]


class Read(HTMLParser):
    """What a browser makes of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.words: list[str] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in ("meta", "link", "input", "path", "circle", "br"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)

    def all(self, tag: str, **wanted: str) -> list[dict[str, str]]:
        return [
            own
            for name, own in self.tags
            if name == tag and all(own.get(key) == it for key, it in wanted.items())
        ]


def hits_of(read: Read) -> list[dict[str, str]]:
    return [own for _, own in read.tags if own.get("class") == "hit"]


def test_a_hit_is_a_button_that_plays() -> None:
    read = Read(page([SEEN, GONE], "r_arm high", View(0)))
    assert read.open == []
    seen, gone = hits_of(read)
    assert "data-joints" not in gone
    assert len(read.all("button", **{"class": "hit"})) == 1
    places = np.frombuffer(b64decode(seen["data-joints"]), "<i2").reshape(-1, 21, 3)
    assert np.array_equal(places, SEEN.played.body.places.round())
    strokes = [stroke.split(",") for stroke in seen["data-strokes"].split()]
    assert {color for *_, color, _ in strokes} == {*BODY} - {"lit"}
    assert sum(lit == "1" for *_, lit in strokes) == 2  # upper arm and forearm
    assert (seen["data-start"], seen["data-seconds"]) == ("0.5", "1.5")
    assert (seen["data-from"], seen["data-to"]) == ("0", "1.5")
    assert [own["data-find"] for own in read.all("li")] == ["swing.bvh swing", "walk.bvh walk"]
    assert "is gone" in read.words


def test_a_page_asks_nobody_for_anything() -> None:
    text = page([SEEN, GONE], "r_arm high", View(0))
    assert re.findall(r"http[^\"]*", text.replace("http-equiv", "")) == [
        "http://www.w3.org/2000/svg"
    ] * text.count("<svg ")
    for word in ("src=", "@import", "url(", "fetch(", "XMLHttpRequest", "import(", "//cdn"):
        assert word not in text
    assert "default-src 'none'" in text
    for own in (attributes for _, attributes in Read(text).tags):
        assert own.get("href", "data:,").startswith("data:")


@pytest.mark.parametrize("evil", EVIL)
def test_names_are_text_and_nothing_else(evil: str) -> None:
    plain = [it for it, _ in Read(page([SEEN, GONE], "arms", View(0))).tags]
    shots = [replace(it, path=evil, label=evil, words=evil) for it in (SEEN, GONE)]
    shots[1] = replace(shots[1], trouble=evil)
    read = Read(page(shots, evil, View(0)))
    assert [it for it, _ in read.tags] == plain
    assert not any(name.startswith("on") for _, own in read.tags for name in own)
    kept = re.sub("[\x00-\x1f]", "\ufffd", evil)
    assert read.words.count(kept) >= 3  # the title, the path, the trouble
    assert hits_of(read)[0].keys() == hits_of(Read(page([SEEN], "arms", View(0))))[0].keys()


def test_the_script_finds_what_it_looks_for() -> None:
    text = page([SEEN], "r_arm high", View(0))
    ids = {own["id"] for _, own in Read(text).tags if "id" in own}
    assert {*re.findall(r'\$\("([a-z]+)"\)', text)} == ids - {
        "hits",
        "keys",
        "stage",
        "controls",
    } | ({"hits"})
    wanted = {*re.findall(r"data\.([a-z]+)", text)}
    assert {f"data-{name}" for name in wanted} == {
        name for name in hits_of(Read(text))[0] if name.startswith("data-")
    }


def test_a_page_of_a_thousand_hits_stays_small() -> None:
    body = replace(SEEN.played.body, places=np.zeros((FRAMES, 21, 3)))
    most = replace(SEEN, played=replace(SEEN.played, body=body))
    each = (len(page([most] * 11, "arms", View(0))) - len(page([most], "arms", View(0)))) / 10
    assert each < 65_000  # the longest; 1.5 s as here take a quarter
    assert (
        len(page([SEEN] * 11, "arms", View(0))) - len(page([SEEN], "arms", View(0)))
    ) / 10 < 20_000


def test_a_page_loops_has_speeds_and_says_what_is_filtered() -> None:
    read = Read(page([SEEN, GONE], "r_arm high", View(30)))
    assert "checked" in read.all("input", id="loop")[0]
    assert {float(own["value"]) for own in read.all("option")} == {0.1, 0.25, 0.5, 1, 2}
    assert [own for own in read.all("option") if "selected" in own] == read.all("option", value="1")
    assert "2 hits" in read.words
    assert "empty shows all" in read.all("input", id="find")[0]["placeholder"]
    assert "hidden" in read.all("p", id="none")[0]
    assert [word for word in read.words if "turn = 30 *" in word]  # all from one side
    assert [*LEGEND] == [word.strip() for word in read.words if word.strip() in LEGEND][:3]
