"""The screen of the library, in a browser."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from page_client import DROP

import lanindex

pytestmark = pytest.mark.slow  # journeys in a browser

if TYPE_CHECKING:
    from playwright.sync_api import Page

    Opened = Callable[..., Page]

MARKUP = "<img src=x onerror=alert(1)>"
MANY = 150
CORPUS = Path(__file__).parents[2] / "corpus"


@pytest.fixture(scope="module")
def crowd(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a library of many captures in folders, one with markup in its name and label."""
    folder = tmp_path_factory.mktemp("crowd")
    score = CORPUS / "compass.lnd"
    for number in range(MANY):
        place = folder / "scores" / f"set {number % 3}"
        place.mkdir(parents=True, exist_ok=True)
        shutil.copy(score, place / f"score {number:03}.lnd")
    marked = folder / "scores" / "set 0" / "<b>score<b>.lnd"
    shutil.copy(score, marked)
    path = folder / "crowd.db"
    with lanindex.open_library(path, create=True) as library:
        library.ingest(folder / "scores")
        library.label(str(marked), MARKUP, {"<i>": MARKUP})
        library.label(str(folder / "scores" / "set 1" / "score 001.lnd"), "north", {"year": "1928"})
    return path


def names(page: Page) -> list[str]:
    """Return what the cards are called, once the list is there."""
    page.wait_for_selector(".shelf > li")
    return page.locator(".shot b").all_inner_texts()


def soon(page: Page, holds: Callable[[], object]) -> None:
    """Wait until something holds."""
    for _ in range(600):
        if holds():
            return
        page.wait_for_timeout(100)
    assert holds()


def count(page: Page) -> int:
    return page.locator(".shot").count()


def test_captures_have_a_pose_a_label_and_what_is_known(opened: Opened) -> None:
    page = opened("/")
    assert "compass.bvh" in names(page)
    card = page.locator(".shot", has_text="conductor_four.bvh")
    card.locator(".pose svg").wait_for()
    assert "conducting" in card.inner_text()
    assert "fps" in card.inner_text()
    card.get_by_role("link").click()
    page.wait_for_url("**/captures/*")


def test_facets_and_filter_are_in_the_address(opened: Opened) -> None:
    page = opened("/")
    names(page)
    page.get_by_role("checkbox", name="conducting").click()
    soon(page, lambda: count(page) == 4)
    assert "where=label%3Dconducting" in page.url
    page.get_by_label("Filter captures").fill("FOUR")
    soon(page, lambda: count(page) == 2)
    link = page.url
    page.reload()
    assert sorted(names(page)) == ["conductor_four.bvh", "conductor_four.lnd"]
    assert page.url == link
    page.get_by_role("button", name="Drop label: conducting").click()
    page.get_by_label("Filter captures").fill("nowhere")
    page.get_by_role("button", name="Show all").click()
    soon(page, lambda: count(page) > 9)


def test_markup_in_names_and_labels_is_text(crowd: Path, own_page: Opened) -> None:
    page = own_page(crowd, "/?sort=label")
    assert names(page)[0] == "<b>score<b>.lnd"
    assert MARKUP in page.locator(".shot").first.inner_text()
    page.get_by_role("list", name="<i>").get_by_label(MARKUP).click()
    soon(page, lambda: names(page) == ["<b>score<b>.lnd"])
    assert page.get_by_role("button", name=f"Drop <i>: {MARKUP}").is_visible()
    assert page.locator("main img, main i i, main b b").count() == 0


def test_back_returns_to_the_same_place(crowd: Path, own_page: Opened) -> None:
    page = own_page(crowd, "/?sort=path")
    names(page)
    for _ in range(40):
        if count(page) == MANY + 1:
            break
        page.mouse.wheel(0, 4000)
        page.wait_for_timeout(50)
    assert len(set(names(page))) == MANY + 1
    link = page.get_by_role("link", name="score 146.lnd")
    link.scroll_into_view_if_needed()
    page.wait_for_timeout(300)
    before = link.bounding_box()
    link.click()
    page.wait_for_url("**/captures/*")
    page.go_back()
    assert "at=1" in page.url
    link.wait_for()
    page.wait_for_timeout(300)
    after = link.bounding_box()
    assert before is not None
    assert after is not None
    assert abs(before["y"] - after["y"]) < 250
    page.mouse.wheel(0, -20_000)
    soon(page, lambda: count(page) == MANY + 1)


@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(
    opened: Opened, violations: Callable[[Page], list[str]], width: int, scheme: str
) -> None:
    page = opened(
        "/?where=label=conducting",
        bypass_csp=True,
        color_scheme=scheme,
        viewport={"width": width, "height": 800},
    )
    names(page)
    if width == 390:
        page.get_by_role("button", name="Facets").click()
    page.get_by_label("Filter captures").focus()
    assert violations(page) == []


def test_files_are_dropped_into_an_empty_library(
    own_page: Opened, violations: Callable[[Page], list[str]], tmp_path: Path
) -> None:
    page = own_page(tmp_path / "new.db", "/", bypass_csp=True)
    page.get_by_text("no capture in this library yet").wait_for()
    assert violations(page) == []
    compass = (CORPUS / "compass.bvh").read_text()
    table = "file,label\ncompass.bvh,rose\n"
    files = [["compass.bvh", compass], [f"{MARKUP}.bvh", "HIERARCHY"], ["labels.csv", table]]
    page.evaluate(DROP, [*files, ["film.mp4", "x"], ["walk.mvn", "x"]])
    page.get_by_role("heading", name="1 added, 1 failed, 2 left out").wait_for()
    told = page.locator(".part").inner_text()
    assert "_img src=x onerror=alert_1__.bvh" in told
    assert page.locator("main img").count() == 0
    page.get_by_text("Left out: 2").click()
    assert "walk.mvn: MVN is not read yet" in page.locator(".part").inner_text()
    soon(page, lambda: names(page) == ["compass.bvh"])
    assert "rose" in page.locator(".shot").inner_text()
    assert violations(page) == []
    page.evaluate(DROP, [["compass.bvh", compass]])
    page.get_by_role("heading", name="0 added, 1 unchanged").wait_for()
    page.get_by_text("Unchanged: 1").click()
    page.get_by_role("link", name="compass.bvh").first.click()
    page.wait_for_url("**/captures/1")


def test_files_are_dropped_on_another_screen(own_page: Opened, tmp_path: Path) -> None:
    page = own_page(tmp_path / "new.db", "/words")
    page.get_by_role("heading", level=1).wait_for()
    page.evaluate(DROP, [["compass.bvh", (CORPUS / "compass.bvh").read_text()]])
    page.get_by_role("heading", name="1 added").wait_for()
    soon(page, lambda: names(page) == ["compass.bvh"])


def test_captures_whose_files_are_gone_are_removed(own_page: Opened, tmp_path: Path) -> None:
    for name in ("compass.lnd", "greetings.lnd"):
        shutil.copy(CORPUS / name, tmp_path / name)
    with lanindex.open_library(tmp_path / "own.db", create=True) as library:
        library.ingest(tmp_path / "compass.lnd", tmp_path / "greetings.lnd")
    page = own_page(tmp_path / "own.db")
    assert len(names(page)) == 2
    soon(page, lambda: page.locator(".pose svg").count() == 2)  # drawn from files that are there
    (tmp_path / "compass.lnd").unlink()
    page.goto(f"{page.url}?missing=yes")
    page.get_by_role("button", name="Remove 1 capture").click()
    soon(page, lambda: names(page) == ["greetings.lnd"])


def test_what_is_sent_can_be_paused_and_cancelled(own_page: Opened, tmp_path: Path) -> None:
    page = own_page(tmp_path / "new.db")
    page.route("**/api/uploads/*", lambda route: None)  # as a server that takes its time
    page.get_by_text("no capture in this library yet").wait_for()
    page.evaluate(DROP, [[f"{number}.bvh", "HIERARCHY"] for number in range(5)])
    page.get_by_role("heading", name="Sending: 0 of 5 files").wait_for()
    assert page.locator(".going li").count() == 3
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("heading", name="Paused: 0 of 5 files").wait_for()
    soon(page, lambda: page.locator(".going li").count() == 0)
    page.unroute("**/api/uploads/*")
    page.get_by_role("button", name="Resume").click()
    page.get_by_role("heading", name="0 added, 5 failed").wait_for()


def test_the_examples_are_added_by_keys_alone(own_page: Opened, tmp_path: Path) -> None:
    page = own_page(tmp_path / "new.db")
    page.get_by_text("no capture in this library yet").wait_for()
    with page.expect_response(lambda it: it.request.method == "POST"):
        page.get_by_role("button", name="Add ten example choreographies").press("Enter")
    page.reload()  # what is read is found again
    page.get_by_role("heading", name="10 added").wait_for(timeout=60_000)
    soon(page, lambda: count(page) == 10)


def test_nothing_can_be_changed_where_a_library_is_only_shown(
    corpus_library: Path, own_page: Opened
) -> None:
    page = own_page(corpus_library, "/", "--read-only")
    names(page)
    assert page.get_by_role("button", name="Add captures").count() == 0
    assert page.locator(".shot input, .shot button").count() == 0


@pytest.fixture
def dances(corpus_library: Path, tmp_path: Path) -> Path:
    """Return a copy of the corpus's library, which a test may change."""
    return Path(shutil.copy(corpus_library, tmp_path / "dances.db"))


def stored(library: Path) -> dict[str, tuple[str, dict[str, str]]]:
    """Return labels and other columns by the names of the files."""
    with lanindex.open_library(library, readonly=True) as opened:
        return {Path(it.path).name: (it.label, dict(it.metadata)) for it in opened.captures()}


def test_labels_and_columns_are_changed_in_place_by_keys(own_page: Opened, dances: Path) -> None:
    page = own_page(dances, "/?q=compass.bvh")
    assert names(page) == ["compass.bvh"]
    label = page.get_by_role("button", name="label of compass.bvh")
    label.press("Enter")
    page.keyboard.type("never")
    page.keyboard.press("Escape")
    assert label.inner_text() == "compass"
    label.press("Enter")
    page.keyboard.type(MARKUP)
    page.keyboard.press("Tab")
    page.keyboard.type("rose")
    page.keyboard.press("Enter")
    soon(page, lambda: stored(dances)["compass.bvh"][1]["kind"] == "rose")
    assert stored(dances)["compass.bvh"][0] == label.inner_text() == MARKUP
    assert page.locator("main img").count() == 0
    page.keyboard.press("Control+z")
    soon(page, lambda: stored(dances)["compass.bvh"][1]["kind"] == "exercise")
    page.get_by_role("button", name="kind of compass.bvh: exercise").wait_for()
    page.wait_for_function("document.activeElement.textContent === 'exercise'")
    assert page.get_by_role("button", name="Undo").count() == 0
    before = label.element_handle()
    page.get_by_label("Filter captures").fill("<img src=x")
    before.wait_for_element_state("hidden")  # the same capture, found anew
    page.get_by_role("button", name="label of compass.bvh").press("Enter")
    page.keyboard.type("wind rose")
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Undo").click()
    soon(page, lambda: stored(dances)["compass.bvh"][0] == MARKUP)


def test_a_label_that_is_typed_stays_while_captures_come(own_page: Opened, dances: Path) -> None:
    page = own_page(dances)
    card = page.locator(".shot", has_text="compass.bvh")
    card.locator(".label .editable").dblclick()
    page.keyboard.type("half")
    page.evaluate(
        """async () => {
          const { adding } = await import("/static/screens/library.js");
          adding().came();
          await new Promise((done) => setTimeout(done, 500));
        }"""
    )
    page.keyboard.type(" done")
    with page.expect_response(lambda it: "/api/captures?" in it.url):  # the list, behind it
        page.keyboard.press("Enter")
    soon(page, lambda: stored(dances)["compass.bvh"][0] == "half done")
    assert "half done" in card.inner_text()


def test_several_are_selected_labelled_and_removed(
    own_page: Opened, violations: Callable[[Page], list[str]], dances: Path
) -> None:
    page = own_page(dances, "/?sort=path&q=.lnd", bypass_csp=True)
    every = names(page)
    page.get_by_label(f"Select {every[0]}").click()
    page.get_by_label(f"Select {every[3]}").click(modifiers=["Shift"])
    page.get_by_text("4 selected").wait_for()
    assert violations(page) == []
    page.get_by_role("button", name="Label …").press("Enter")
    page.keyboard.type("four")
    assert violations(page) == []
    page.keyboard.press("Enter")
    soon(page, lambda: [stored(dances)[it][0] for it in every[:4]] == ["four"] * 4)
    page.get_by_role("checkbox", name="four 4").click()
    soon(page, lambda: count(page) == 4)
    page.get_by_text("4 selected").wait_for()  # they still are
    page.get_by_role("button", name="Column …").click()
    page.get_by_label("Column", exact=True).fill("year")
    page.get_by_label("Value").fill("1928")
    page.keyboard.press("Enter")
    soon(page, lambda: [stored(dances)[it][1].get("year") for it in every[:4]] == ["1928"] * 4)
    page.wait_for_function("document.activeElement.textContent === 'Column …'")
    page.get_by_role("button", name="Clear").click()
    page.get_by_label(f"Select {every[1]}").click()
    page.get_by_role("button", name="Remove …").click()
    assert "files stay where they are" in page.get_by_role("dialog").inner_text()
    page.keyboard.press("Escape")
    assert every[1] in stored(dances)
    page.get_by_role("button", name="Remove …").click()
    page.get_by_role("button", name="Remove 1 capture").click()
    soon(page, lambda: every[1] not in stored(dances))
    soon(page, lambda: count(page) == 3)
    page.wait_for_function("document.activeElement.matches('input[type=search]')")


def test_captures_are_selected_and_removed_by_keys_alone(
    own_page: Opened, dances: Path, tabbed: Callable[..., None]
) -> None:
    page = own_page(dances, "/?sort=path&q=.lnd")
    every = names(page)
    page.get_by_label("Filter captures").focus()
    tabbed(page, f"Select {every[1]}")
    page.keyboard.press("Space")
    tabbed(page, f"Select {every[2]}")
    page.keyboard.press("Space")
    page.get_by_text("2 selected").wait_for()
    tabbed(page, "Remove \u2026", "Shift+Tab")
    page.keyboard.press("Enter")
    page.get_by_role("dialog").wait_for()
    page.keyboard.press("Escape")
    page.get_by_role("dialog").wait_for(state="detached")
    assert len(names(page)) == len(every)
    tabbed(page, "Select all")
    tabbed(page, "Remove \u2026", "Shift+Tab")
    page.keyboard.press("Enter")
    tabbed(page, "Cancel")
    tabbed(page, "Remove 2 captures", "Shift+Tab")
    page.keyboard.press("Enter")
    soon(page, lambda: names(page) == [every[0], *every[3:]])
    assert not {every[1], every[2]} & stored(dances).keys()
    page.get_by_text("2 selected").wait_for(state="hidden")
