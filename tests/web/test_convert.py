"""The screen Convert in a browser: an angle is edited, symbols change, a profile is saved."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import lanindex

pytestmark = pytest.mark.slow  # journeys in a browser

if TYPE_CHECKING:
    from playwright.sync_api import Page

    Opened = Callable[..., Page]


@pytest.fixture
def number(corpus_library: Path) -> int:
    with lanindex.open_library(corpus_library) as library:
        return library.capture("traffic_police.bvh").id


def summary(page: Page, text: str) -> None:
    page.wait_for_function(
        "text => document.querySelector('.summary')?.textContent.includes(text)", arg=text
    )


def test_an_angle_changes_symbols_at_once_and_back(opened: Opened, number: int) -> None:
    page = opened(f"/convert?capture={number}&part=r_arm")
    summary(page, "No symbol changed")
    page.wait_for_selector(".staff svg g[data-part]")
    level = page.get_by_label("mid begins at", exact=True)
    level.fill("95")
    summary(page, "symbols changed")
    assert '"mid":95' in page.evaluate("new URLSearchParams(location.search).get('changes')")
    assert page.locator(".staff").nth(1).locator("[fill='#f5a300']").count() > 0
    level.press("Control+z")
    summary(page, "No symbol changed")
    assert level.input_value() == "67.5"
    page.get_by_role("button", name="Redo").click()
    summary(page, "symbols changed")
    page.reload()  # the address says all of it
    summary(page, "symbols changed")
    assert page.get_by_label("mid begins at", exact=True).input_value() == "95"
    seen = page.evaluate(
        """() => new Promise((done) => {
          let least = Infinity;
          const count = () => {
            least = Math.min(least, document.querySelectorAll(".staff svg g[data-part]").length);
          };
          const watch = new MutationObserver(count);
          watch.observe(document.querySelector(".views"), { childList: true, subtree: true });
          const field = document.querySelector("input[type=number]");
          field.value = "85";
          field.dispatchEvent(new Event("input"));
          setTimeout(() => done(least), 1000);
        })"""
    )
    assert seen > 0  # the staves are never empty in between
    page.get_by_role("button", name="mid begins at: paper 60°").click()
    assert page.get_by_label("mid begins at", exact=True).input_value() == "60"


def test_another_capture_is_chosen_by_a_part_of_its_path(opened: Opened, number: int) -> None:
    page = opened(f"/convert?capture={number}&part=l_arm")
    summary(page, "No symbol changed")
    field = page.get_by_role("combobox", name="Capture")
    field.fill("compass.lnd")
    field.press("Enter")
    page.get_by_text("No capture of a movement fits compass.lnd.").wait_for()
    field.fill("ompass")
    field.press("Enter")
    page.wait_for_url(lambda url: f"capture={number}" not in url and "part=l_arm" in url)
    summary(page, "No symbol changed")
    assert field.input_value().endswith("compass.bvh")


def test_another_profile_is_a_step_that_can_be_undone(opened: Opened, number: int) -> None:
    page = opened(f"/convert?capture={number}&part=r_arm")
    summary(page, "No symbol changed")
    level = page.get_by_label("mid begins at", exact=True)
    profile = page.get_by_role("combobox", name="Profile", exact=True)
    level.fill("85")
    profile.select_option("paper")
    page.wait_for_url("**profile=paper**")
    assert level.input_value() == "60"
    page.get_by_role("button", name="Undo").click()
    assert (level.input_value(), profile.input_value()) == ("85", "default")
    page.get_by_role("button", name="Redo").click()
    assert (level.input_value(), profile.input_value()) == ("60", "paper")


def test_what_is_not_allowed_is_said_beside_the_field(opened: Opened, number: int) -> None:
    page = opened(f"/convert?capture={number}&part=r_arm")
    summary(page, "No symbol changed")
    level = page.get_by_label("high begins at", exact=True)
    level.fill("50")
    wrong = page.get_by_text("50 is not allowed: a number from 68 to 179.5°.")
    wrong.wait_for()
    assert level.get_attribute("aria-invalid") == "true"
    level.fill("120")
    summary(page, "of")
    assert level.get_attribute("aria-invalid") in (None, "false")
    assert page.get_by_text("is not allowed").count() == 0


def test_both_sides_change_as_in_a_mirror(opened: Opened, number: int) -> None:
    page = opened(f"/convert?capture={number}&part=r_arm")
    summary(page, "No symbol changed")
    page.get_by_label("right forward begins at", exact=True).fill("30")
    changes = page.evaluate("JSON.parse(new URLSearchParams(location.search).get('changes'))")
    assert changes["spaces"]["r_arm"]["starts"][1] == 30
    assert changes["spaces"]["l_arm"]["starts"][4] == 150  # where left begins


def test_the_page_and_the_method_name_the_same_cells(opened: Opened, number: int) -> None:
    page = opened(f"/convert?capture={number}&part=r_arm")
    summary(page, "No symbol changed")
    points = [[x / 4, y / 4, z / 4] for x in range(-4, 5) for y in range(-4, 5) for z in (-3, 0, 3)]
    space = lanindex.load_profile().ranges["r_arm"]
    told = {
        "place": space.place,
        "relative": True,
        "starts": space.starts,
        "mid": space.mid,
        "high": space.high,
    }
    found = page.evaluate(
        """async ([space, points]) => {
          const { cellOf } = await import("/static/cells.js");
          return points.map((it) => cellOf(space, space.place, ...it));
        }""",
        [told, points],
    )
    import numpy as np

    from lanindex.encoding import direction

    around = direction.space(space, 1.0)
    wanted = direction.course(np.array([points])[:, :, [2, 1, 0]], [around])[0].cells
    assert found == wanted.tolist()


def test_the_sphere_turns_by_keys_and_borders_are_drawn(opened: Opened, number: int) -> None:
    page = opened(f"/convert?capture={number}&part=r_arm", viewport={"width": 1280, "height": 900})
    summary(page, "No symbol changed")
    page.get_by_label("sphere at the limb").uncheck()
    canvas = page.locator("canvas.sphere")
    before = canvas.screenshot()
    canvas.focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_timeout(100)
    assert canvas.screenshot() != before
    page.keyboard.press("0")
    for _ in range(9):
        page.keyboard.press("ArrowUp")  # to where it is seen level: 18 degrees, then below
    for _ in range(2):
        page.keyboard.press("ArrowDown")
    box = canvas.bounding_box()
    assert box is not None
    field = page.get_by_label("mid begins at", exact=True)
    assert field.input_value() == "67.5"
    x = box["x"] + box["width"] / 2
    heights = range(int(box["y"]) + 40, int(box["y"] + box["height"]) - 40, 2)
    for y in heights:  # the border is where the pointer says so
        page.mouse.move(x, y)
        if page.evaluate("document.querySelector('canvas.sphere').style.cursor") == "move":
            break
    page.mouse.down()
    page.mouse.move(x, y + 12)
    page.mouse.up()
    assert page.get_by_role("button", name="Undo").is_enabled()
    summary(page, "of")


def test_a_profile_is_saved_by_the_keyboard(
    own_page: Opened, corpus_library: Path, tmp_path: Path, number: int
) -> None:
    path = tmp_path / "own.db"
    shutil.copy(corpus_library, path)
    page = own_page(path, f"/convert?capture={number}&part=r_arm")
    summary(page, "No symbol changed")
    page.get_by_label("mid begins at", exact=True).fill("95")
    summary(page, "symbols changed")
    page.get_by_label("Name of the profile").focus()
    page.keyboard.type("wide arms")
    page.keyboard.press("Enter")
    page.get_by_text("Saved. Encode the library with it").wait_for()
    assert page.get_by_role("combobox", name="Profile", exact=True).input_value() == "wide arms"
    saved = lanindex.load_profile(path.with_name("own-profiles") / "wide arms")
    assert saved.ranges["r_arm"].mid == saved.ranges["l_arm"].mid == 95
    assert saved.ranges["r_leg"] == lanindex.load_profile().ranges["r_leg"]


def test_a_library_is_encoded_with_what_was_edited(
    own_page: Opened, corpus_library: Path, tmp_path: Path, number: int
) -> None:
    path, pattern = tmp_path / "own.db", "r_arm right mid"
    shutil.copy(corpus_library, path)
    with lanindex.open_library(path) as library:
        before = len(library.search(pattern))
        labels = [it.label for it in library.captures()]
    page = own_page(path, f"/convert?capture={number}&part=r_arm")
    summary(page, "No symbol changed")
    page.get_by_label("mid begins at", exact=True).fill("95")
    summary(page, "symbols changed")
    encode = page.get_by_role("button", name="Encode the library with")
    assert encode.is_disabled()  # what was changed must be saved first
    page.get_by_label("Name of the profile").fill("high arms")
    page.get_by_role("button", name="Save as a profile").click()
    page.get_by_text("Saved. Encode the library with it").wait_for()
    summary(page, "symbols changed")
    encode.click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_text("10 captures are read again").wait_for()
    assert "10 scores" in dialog.inner_text()
    page.keyboard.press("Escape")
    assert dialog.count() == 0
    encode.click()
    with page.expect_response(lambda it: it.url.endswith("/api/library/encode")):
        dialog.get_by_role("button", name="Encode the library").click()
    page.reload()  # it goes on, and is found again
    page.get_by_role("region", name="Encode the library").get_by_text(
        "Done: 10 captures written down anew."
    ).wait_for(timeout=60_000)
    summary(page, "No symbol changed")  # the library has them now
    with lanindex.open_library(path) as library:
        assert len(library.search(pattern)) != before
        assert [it.label for it in library.captures()] == labels
    encode.click()
    page.get_by_text("All captures have the profile high arms already.").wait_for()


def test_an_encoding_is_cancelled_by_keys_and_the_rest_stays(
    own_page: Opened, tmp_path: Path, tabbed: Callable[..., None]
) -> None:
    corpus, folder = Path(__file__).parents[2] / "corpus", tmp_path / "dances"
    folder.mkdir()
    for copy in range(40):
        shutil.copy(corpus / "greetings.bvh", folder / f"{copy}.bvh")
    with lanindex.open_library(tmp_path / "own.db", create=True) as library:
        library.ingest(folder)
        number = library.captures()[0].id
    page = own_page(tmp_path / "own.db", f"/convert?capture={number}&part=r_arm")
    summary(page, "No symbol changed")
    profile = page.get_by_role("combobox", name="Profile", exact=True)
    other = next(it for it in profile.locator("option").all_inner_texts() if it != "default")
    profile.select_option(label=other)
    page.get_by_role("button", name="Encode the library with").focus()
    page.keyboard.press("Enter")
    page.get_by_role("dialog").get_by_text("40 captures are read again").wait_for()
    tabbed(page, "Leave it as it is")
    tabbed(page, "Encode the library", "Shift+Tab")
    page.keyboard.press("Enter")
    region = page.get_by_role("region", name="Encode the library")
    region.locator("button:focus", has_text="Cancel").wait_for()
    page.keyboard.press("Enter")
    region.get_by_text(re.compile(r"^Cancelled: \d+ captures? written down anew")).wait_for()
    assert region.locator("button:focus").inner_text().startswith("Encode the library with")
    with lanindex.open_library(tmp_path / "own.db") as library:
        assert len(library.captures()) == 40
        assert library.stats().profiles["default"] > 0


@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(
    opened: Opened,
    violations: Callable[[Page], list[str]],
    number: int,
    width: int,
    scheme: str,
) -> None:
    page = opened(
        f"/convert?capture={number}&part=r_arm",
        bypass_csp=True,
        color_scheme=scheme,
        viewport={"width": width, "height": 800},
    )
    summary(page, "No symbol changed")
    page.get_by_label("mid begins at", exact=True).fill("95")
    summary(page, "symbols changed")
    page.evaluate("for (const it of document.querySelectorAll('details')) it.open = true")
    assert violations(page) == []
