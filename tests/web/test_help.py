"""The guide on the page: its pages as trees, its links, its patterns, the signs."""

import re
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest
from starlette.testclient import TestClient

from lanindex.data import shipped
from lanindex.web import markdown

if TYPE_CHECKING:
    from playwright.sync_api import Page

TOPICS = [*shipped("guide/topics.toml")]


def inside(node: Any) -> Iterator[Any]:
    yield node
    for child in node[2:] if isinstance(node, list) else ():
        yield from inside(child)


def nodes_of(ask: TestClient, topic: str) -> list[Any]:
    nodes = ask.get(f"/api/help/{topic}").json()["nodes"]
    return [it for node in nodes for it in inside(node) if isinstance(it, list)]


def test_what_markdown_becomes() -> None:
    text = """# A *small* page

A line with `code|x`, **bold [link](other.md)** and
a second one.

- one
  goes on
- two `a\\|b`

| a | b |
|---|---|
| 1 | `x\\|y` |

```text
r_arm *
```

    indented
"""
    found = markdown.tree(text, lambda link: f"/to/{link}")
    link = ["a", {"href": "/to/other.md"}, "link"]
    assert found[0] == ["h1", {"id": "a-small-page"}, "A ", ["em", {}, "small"], " page"]
    assert found[1] == [
        *("p", {}, "A line with ", ["code", {}, "code|x"], ", "),
        *(["strong", {}, "bold ", link], " and a second one."),
    ]
    assert found[2] == [
        *("ul", {}, ["li", {}, "one goes on"]),
        ["li", {}, "two ", ["code", {}, "a|b"]],
    ]
    head = ["thead", {}, ["tr", {}, ["th", {}, "a"], ["th", {}, "b"]]]
    body = ["tbody", {}, ["tr", {}, ["td", {}, "1"], ["td", {}, ["code", {}, "x|y"]]]]
    assert found[3] == ["table", {}, head, body]
    shown = markdown.tree("![two *a*](../b.png)", lambda link: f"/to/{link}")
    assert shown == [["p", {}, ["img", {"src": "/to/../b.png", "alt": "two *a*"}]]]
    assert found[4:] == [["pre", {"lang": "text"}, "r_arm *"], ["pre", {"lang": ""}, "indented"]]


@pytest.mark.parametrize("topic", TOPICS)
def test_no_mark_of_markdown_is_left(ask: TestClient, topic: str) -> None:
    nodes = ask.get(f"/api/help/{topic}").json()["nodes"]
    assert nodes[0][0] == "h1"
    for node in nodes:
        if node[0] != "pre":
            coded = {id(text) for it in inside(node) if it[0] == "code" for text in it[2:]}
            texts = [it for it in inside(node) if isinstance(it, str) and id(it) not in coded]
            assert not [it for it in texts if re.search(r"\*\*|`|\]\(|^\s*[|#]", it)]


@pytest.mark.parametrize("topic", TOPICS)
def test_links_lead_somewhere(ask: TestClient, topic: str) -> None:
    names = {it[1]["id"] for it in nodes_of(ask, topic) if it[0] in ("h1", "h2", "h3")}
    for node in nodes_of(ask, topic):
        if node[0] != "a" or node[1]["href"].startswith("http"):
            continue
        path, _, heading = node[1]["href"].partition("#")
        if path.startswith("/help/"):
            there = nodes_of(ask, path.removeprefix("/help/"))
            headings = {it[1]["id"] for it in there if it[0] in ("h1", "h2", "h3")}
            assert not heading or heading in headings
        elif not path.startswith("/search?"):
            assert not path
            assert heading in names


def test_pictures_are_those_of_the_guide(ask: TestClient) -> None:
    pictures = [it for topic in TOPICS for it in nodes_of(ask, topic) if it[0] == "img"]
    assert len(pictures) >= 2
    for _, attributes in pictures:
        answer = ask.get(attributes["src"])
        assert answer.headers["content-type"] == "image/png"
        assert attributes["alt"]
    for name in ("labels.csv", "compass.bvh", "none.png", "..%2fcorpus%2fsigns.png"):
        assert ask.get(f"/api/help/pictures/{name}").status_code == 404


@pytest.mark.slow
def test_pictures_are_seen_on_a_phone(opened: Callable[..., "Page"]) -> None:
    page = opened("/help/looking", viewport={"width": 400, "height": 800})
    pictures = page.locator(".guide img")
    for picture in (pictures.first, pictures.nth(1)):
        picture.scroll_into_view_if_needed()
        assert picture.evaluate("(it) => it.decode().then(() => it.naturalWidth)") > 400
    assert page.evaluate("document.documentElement.scrollWidth") == 400
    with page.expect_popup() as opening:
        pictures.first.click()
    whole = opening.value
    whole.wait_for_load_state()
    assert whole.url.endswith(pictures.first.get_attribute("src"))
    assert whole.locator("img").evaluate("(it) => it.naturalWidth") > 400


def test_patterns_can_be_tried(ask: TestClient) -> None:
    tried = [it[1]["aria-label"] for it in nodes_of(ask, "asking") if it[1].get("class") == "try"]
    assert "Try it: r_arm right mid -> hold 2s+" in tried
    assert "Try it: arms low -> high" in tried  # of a command
    assert not any("ingest" in it for it in tried)


def test_every_sign_is_drawn_beside_its_words(ask: TestClient) -> None:
    signs = ask.get("/api/help/signs").json()["signs"]
    assert [it["means"] for it in signs] == [row[-1] for row in shipped("draw/legend.toml")["rows"]]
    assert all(re.search("<(path|circle)", it["svg"]) for it in signs)
    assert ask.get("/api/help/sings").status_code == 400


@pytest.mark.slow
def test_from_the_guide_to_a_heading_and_a_search(
    opened: Callable[..., "Page"], violations: Callable[["Page"], list[str]]
) -> None:
    page = opened("/help")
    page.get_by_role("heading", level=1, name="The page in a browser").wait_for()
    page.get_by_label("Help", exact=True).get_by_role("link", name="Method Reference").click()
    page.get_by_role("heading", level=1).wait_for()
    page.locator('a[href="/help/body#palms"]').click()
    page.wait_for_url("**/help/body#palms")
    page.locator("#palms").wait_for()
    assert page.evaluate("document.getElementById('palms').getBoundingClientRect().top") < 100
    page.goto(page.url.partition("/help")[0] + "/help/language")
    tried = page.get_by_role("link", name="Try it: r_arm right mid", exact=True)
    assert tried.get_attribute("href") == "/search?q=r_arm+right+mid"
    assert violations(page) == []
    page.get_by_label("Help", exact=True).get_by_role("link", name="Keys The").click()
    page.get_by_role("row", name="Space").first.wait_for()
    assert violations(page) == []
