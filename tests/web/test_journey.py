"""One way through the page from end to end: from files that are dropped to clips that leave."""

from __future__ import annotations

import re
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING
from zipfile import ZipFile

import pytest
from page_client import DROP
from playwright.sync_api import expect

import lanindex
from lanindex.errors import counted

pytestmark = pytest.mark.slow  # a journey in a browser

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from lanindex.search.hits import Hits

CORPUS = Path(__file__).parent.parent.parent / "corpus"
ALIKE = re.compile(r"^\d+ hits? in \d+ captures?$")


def found(page: Page, hits: Hits) -> None:
    """Wait until a search has found these hits, and shows them."""
    many, captures = (counted(*it) for it in ((len(hits), "hit"), (hits.captures, "capture")))
    expect(page.locator(".summary")).to_have_text(f"{many} in {captures}")
    expect(page.locator(".hit")).to_have_count(min(len(hits), 24))


@pytest.mark.parametrize("database", ["sqlite", "postgres"])
def test_dropped_found_drawn_played_selected_alike_and_exported(
    own_page: Callable[..., Page],
    browser: Browser,
    tmp_path: Path,
    database: str,
    request: pytest.FixtureRequest,
) -> None:
    permissions = ["clipboard-read", "clipboard-write"]
    path = tmp_path / "new.db" if database == "sqlite" else request.getfixturevalue("new_address")
    page = own_page(path, "/", permissions=permissions, accept_downloads=True)
    page.get_by_text("no capture in this library yet").wait_for()
    names = ("compass.bvh", "jumping_jacks.bvh", "semaphore.bvh")
    page.evaluate(DROP, [[name, (CORPUS / name).read_text()] for name in names])
    page.get_by_role("heading", name="3 added").wait_for()

    with lanindex.open_library(path, readonly=True) as library:
        jacks, rights = library.search("jumping jacks"), library.search("r_arm right ... place")
    assert 0 < len(jacks) != len(rights) > 0

    page.get_by_role("link", name="Search").click()
    line = page.get_by_role("textbox", name="What is searched for")
    line.fill("jumping jacks")
    line.press("Enter")
    found(page, jacks)

    line.fill("")
    line.press("Escape")  # what is offered lies above what is below
    page.get_by_role("listbox", name="right arm").get_by_role("option").click()
    for key in ("6", "Enter", "5", "g"):
        page.keyboard.press(key)
    expect(line).to_have_value("r_arm right ... place")
    found(page, rights)

    page.get_by_role("group", name="Copy as").get_by_role("button", name="link").click()
    expect(page.locator("#status")).to_contain_text("the link is copied")
    other = browser.new_context()
    other.add_cookies([it for it in page.context.cookies() if it["name"].startswith("lanindex")])
    second = other.new_page()
    second.goto(page.evaluate("navigator.clipboard.readText()"))
    found(second, rights)
    expect(second.get_by_role("listbox", name="right arm").get_by_role("option")).to_have_count(2)
    other.close()

    page.locator(".hit a.show").first.click()
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play").wait_for()
    page.locator(".staff").press("Shift+ArrowUp")
    for _ in range(5):
        page.keyboard.press("Shift+ArrowUp")
    page.get_by_role("link", name="search for movement like it").click()
    page.wait_for_url(re.compile(r"/search\?like="))
    expect(page.get_by_text("Movement like that of")).to_be_visible()
    expect(page.locator(".summary")).to_have_text(ALIKE)
    page.get_by_role("link", name="more like this").last.click()
    expect(page.get_by_text("Movement like that of")).to_be_visible()
    expect(page.locator(".summary")).to_have_text(ALIKE)

    page.get_by_role("button", name="In the basket").first.click()
    expect(page.locator(".basket")).to_contain_text("1 hit")
    with page.expect_download() as coming:
        page.get_by_role("button", name="Clips").click()
    packed = ZipFile(BytesIO(coming.value.path().read_bytes()))
    endings = sorted(name.rpartition(".")[2] for name in packed.namelist())
    assert endings == ["bvh", "csv", "jsonl", "lnd"]
