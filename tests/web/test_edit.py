"""A score is written in a browser, played, saved, put into the library and found."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

import pytest
from page_client import serving

import lanindex

pytestmark = pytest.mark.slow  # journeys in a browser

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page, Response

CORPUS = Path(__file__).parent.parent.parent / "corpus"

STAFF = "[role=application][aria-label^='The staff']"


@pytest.fixture
def library(tmp_path: Path) -> Path:
    path = tmp_path / "own.db"
    with lanindex.open_library(path, create=True) as library:
        library.ingest(CORPUS / "compass.bvh", CORPUS / "jumping_jacks.bvh")
    return path


def typed(page: Page, *keys: str) -> str:
    """Press keys, and return what is told then."""
    for key in keys:
        page.keyboard.press(key)
    return page.text_content(".edit-state") or ""


def drawn(page: Page, many: int) -> None:
    """Wait until the staff shows so many symbols."""
    from playwright.sync_api import expect

    expect(page.locator(".edit-drawn [data-symbol]")).to_have_count(many)


def kept(page: Page) -> list[list[Any]]:
    """Return the symbols of the draft."""
    script = "() => JSON.parse(Object.values(localStorage)[0]).score.symbols"
    return [[it["part"], it["start"], it["stop"], *it["words"]] for it in page.evaluate(script)]


def test_a_score_is_written_played_saved_and_found(
    own_page: Callable[..., Page], library: Path, tmp_path: Path
) -> None:
    page = own_page(library, "/edit", accept_downloads=True)
    page.wait_for_selector(".edit-drawn svg")
    assert typed(page, "6") == "right arm, right mid, bar 1 beat 1, 1 beat"
    assert typed(page, "ArrowUp", "ArrowUp") == "right arm, bar 1 beat 2, empty"
    typed(page, "8", "h", "Shift+ArrowUp")
    assert typed(page, "Home") == "right arm, the starting position, empty"
    assert typed(page, "5", "l") == "right arm, place low, the starting position"
    drawn(page, 3)
    page.wait_for_selector("canvas.figure:not(.edit-waits)")
    standing = page.locator("canvas.figure").screenshot()
    page.keyboard.press("Space")
    page.locator(".clock", has_text=re.compile(r"0:0(1\.[5-9]|2)")).wait_for()
    assert page.locator(".edit-line").is_visible()
    page.keyboard.press("Space")
    assert page.locator("canvas.figure").screenshot() != standing

    page.get_by_label("Name").fill("reach")
    with page.expect_download() as coming:
        page.get_by_role("button", name="Save").click()
    assert coming.value.suggested_filename == "reach.lnd"
    coming.value.save_as(tmp_path / "reach.lnd")
    score = lanindex.read_lnd(tmp_path / "reach.lnd")
    assert [(it.words, it.tick, it.ticks) for it in score.symbols("r_arm")] == [
        ("place low", 0, 0),
        ("right mid", 0, 8),
        ("forward high", 8, 12),
    ]

    page.get_by_role("button", name="Put into the library").click()
    page.wait_for_selector(".edit-found a")
    page.get_by_role("button", name="Search for it").click()
    page.wait_for_url("**/search?*")
    page.locator(".hit", has_text="reach.lnd").first.wait_for()
    pattern = parse_qs(urlsplit(page.url).query)["q"][0]
    assert pattern == "r_arm right mid -> forward high"
    with lanindex.open_library(library) as opened:
        number = opened.capture(str(library.with_name("own-captures") / "reach.lnd")).id
        assert number in [hit.capture.id for hit in opened.search(pattern)]


def test_symbols_are_changed_by_keys_and_every_edit_is_undone(
    own_page: Callable[..., Page], library: Path
) -> None:
    page = own_page(library, "/edit")
    page.wait_for_selector(".edit-drawn svg")
    states = [[]]

    def edit(*keys: str) -> list[list[Any]]:
        typed(page, *keys)
        states.append(kept(page))
        return states[-1]

    assert edit("3") == [["r_arm", 0, 24, "r_back", "mid"]]
    assert edit("Shift+ArrowUp") == [["r_arm", 0, 36, "r_back", "mid"]]
    assert edit("Shift+ArrowRight") == [["r_arm", 12, 36, "r_back", "mid"]]
    assert edit("Alt+ArrowUp") == [["r_arm", 24, 48, "r_back", "mid"]]
    assert edit("Shift+M") == [["l_arm", 24, 48, "l_back", "mid"]]
    typed(page, "Control+c", "PageUp")
    twice = edit("Control+v")
    assert twice[1] == ["l_arm", 120, 144, "l_back", "mid"]
    assert edit("Control+a", "h") == [[*it[:-1], "high"] for it in twice]
    assert edit("Delete") == []
    assert "64" in edit("+") or page.get_by_label("Tempo").input_value() == "64"
    for before in states[-2::-1]:
        typed(page, "Control+z")
        assert kept(page) == before
    for after in states[1:]:
        typed(page, "Control+Shift+z")
        assert kept(page) == after


def test_some_symbols_are_chosen_by_keys(own_page: Callable[..., Page], library: Path) -> None:
    page = own_page(library, "/edit")
    page.wait_for_selector(".edit-drawn svg")
    typed(page, "6", "ArrowUp", "ArrowUp", "8", "ArrowUp", "ArrowUp", "4")
    first = "right arm, right mid, bar 1 beat 1, 1 beat"
    for _ in range(3):
        typed(page, "Control+ArrowDown")
    assert typed(page, "Control+ArrowDown") == f"{first}, not chosen, 1 chosen"
    assert typed(page, "Control+Enter") == f"{first}, 2 chosen"
    drawn(page, 3)
    assert page.locator(".edit-chosen").count() == 2
    typed(page, "Shift+M")
    assert sorted(it[0] for it in kept(page)) == ["l_arm", "l_arm", "r_arm"]
    assert typed(page, "Control+Enter").endswith(", 1 chosen")


def test_every_kind_of_symbol_is_written_by_keys(
    own_page: Callable[..., Page], library: Path
) -> None:
    page = own_page(library, "/edit")
    page.wait_for_selector(".edit-drawn svg")
    page.locator("summary", has_text="Columns").click()
    for box in page.locator(".edit-columns input").all():
        box.check()
    page.locator(STAFF).focus()
    lanes = page.locator(".edit-names span")
    lanes.nth(36).wait_for()
    for _ in range(lanes.count()):
        typed(page, "ArrowLeft")
    written = set()
    fits = "(all) => all.every((it) => it.scrollWidth <= it.clientWidth)"
    for _ in range(lanes.count()):
        assert page.locator(".edit-palette button").evaluate_all(fits)
        for group in page.locator(".edit-palette [role=group]").all():
            faces = group.locator("button:enabled").evaluate_all(
                "(all) => all.map((it) => it.textContent + it.querySelector('svg')?.innerHTML)"
            )
            assert len({*faces}) == len(faces)  # none looks as another
        typed(page, "Enter", "ArrowRight")
    written = {it[0] for it in kept(page)}
    alphabet = page.evaluate("async () => await (await fetch('/api/scores/alphabet')).json()")
    assert written == {it["part"] for it in alphabet["tracks"]}
    page.get_by_label("Notation").wait_for()
    with page.expect_download() as coming:
        page.get_by_role("button", name="Save").click()
    assert {*lanindex.read_lnd(coming.value.path()).tracks} >= written


def test_an_edit_of_a_long_score_asks_for_what_is_near_alone(
    own_page: Callable[..., Page], library: Path, tmp_path: Path
) -> None:
    ways = ("forward mid", "right mid", "right high", "place low")
    lines = [
        line
        for bar in range(1, 301)
        for line in (
            f"#unit{bar}",
            *(f"direction r_arm {ways[beat]} {beat} {beat + 1}" for beat in range(4)),
        )
    ]
    long = tmp_path / "long.lnd"
    long.write_text("\n".join(["#speed=60", "#rhythm 4/4", "#unit_total 300", *lines]))
    page = own_page(library, "/edit")
    page.wait_for_selector(".edit-drawn svg")
    page.locator("input[type=file]").set_input_files(long)
    page.locator(".edit-drawn [data-symbol]").nth(4).wait_for(state="attached")
    page.locator(STAFF).focus()

    def asked(what: str, *keys: str, whole: bool = False) -> dict[str, Any]:
        """Return what is asked for a window, or for all, when keys are pressed."""

        def fits(it: Response) -> bool:
            there = it.url.endswith(f"/api/scores/{what}")
            return there and ("to" in it.request.post_data_json) is not whole

        with page.expect_response(fits) as coming:
            typed(page, *keys)
        return dict(coming.value.request.post_data_json)

    drawing = asked("draw", "4")
    assert len(kept(page)) == 1200
    assert 4 < len(drawing["score"]["symbols"]) < 60
    typed(page, "End")
    there = asked("motion", "6")
    assert there["from"] > 1100
    assert there["to"] - there["from"] < 10
    assert len(there["score"]["symbols"]) < 20
    page.wait_for_selector("canvas.figure:not(.edit-waits)")
    typed(page, "Home", "ArrowUp")
    asked("motion", "4")
    playing = asked("motion", "Space", whole=True)
    assert len(playing["score"]["symbols"]) == 1200  # what is played: all of it


WINDOWS = """async ([from, to]) => {
  const { around, grain, packed, unpacked } = await import("/static/edit/score.js");
  const ask = async (path, how) => (await fetch(`/api/scores/${path}`, how)).json();
  const headers = { "content-type": "application/json" };
  const send = (path, body) => ask(path, { method: "POST", headers, body: JSON.stringify(body) });
  const whole = unpacked((await ask("captures/2")).score), beat = grain(whole), found = [];
  const parts = [...new Set(whole.symbols.map((it) => it.part))];
  for (const reach of [4, 0]) {
    const near = around(whole, (from - reach) * beat, (to + reach) * beat);
    for (const score of [whole, near].map(packed)) {
      const asked = reach ? { score, parts, from, to } : { score, from, to };
      const told = await send(reach ? "draw" : "motion", asked);
      found.push([score.symbols.length, told.svg ?? told.places]);
    }
  }
  return found;
}"""
"""Returns staff and figure of a window in seconds, of all symbols and of those near it."""


def test_symbols_near_a_window_make_the_same_staff_and_figure(
    own_page: Callable[..., Page], library: Path
) -> None:
    page = own_page(library, "/edit")
    for window in ([1, 3], [7, 9]):  # a beat is a second
        whole, near, moves, moved = page.evaluate(WINDOWS, window)
        assert near[0] < whole[0] > moved[0]
        drawings = [
            re.sub(r' data-\w+="[^"]*"|<title>.*?</title>', "", it[1]) for it in (whole, near)
        ]
        assert drawings[0].count("<path") > 20
        assert drawings[0] == drawings[1]
        assert moves[1] == moved[1]


def test_degrees_are_changed_by_keys(own_page: Callable[..., Page], library: Path) -> None:
    page = own_page(library, "/edit")
    page.wait_for_selector(".edit-drawn svg")
    while not typed(page, "ArrowRight").startswith("turn"):
        pass
    assert typed(page, "4", "]", "]") == "turn, left 120, bar 1 beat 1, 1 beat"
    assert kept(page) == [["body_turn", 0, 24, "left", "120"]]
    page.get_by_label("Degrees").fill("45")
    page.keyboard.press("Enter")
    assert kept(page) == [["body_turn", 0, 24, "left", "45"]]


def test_symbols_are_written_and_dragged_with_a_pointer(
    own_page: Callable[..., Page], library: Path
) -> None:
    page = own_page(library, "/edit")
    page.wait_for_selector(".edit-drawn svg")
    cell = page.locator(".edit-cursor").bounding_box()
    assert cell
    x, y = cell["x"] + cell["width"] / 2, cell["y"] + cell["height"] / 2
    page.mouse.click(x, y)
    drawn(page, 1)
    assert kept(page) == [["r_arm", 0, 24, "place", "mid"]]
    box = page.locator(".edit-chosen").bounding_box()
    assert box

    def drag(start: float, stop: float) -> None:
        page.mouse.move(x, start)
        page.mouse.down()
        page.mouse.move(x, (start + stop) / 2)
        page.mouse.move(x, stop)
        page.mouse.up()

    drag(box["y"] + 2, box["y"] + 2 - box["height"])  # its end
    assert kept(page) == [["r_arm", 0, 48, "place", "mid"]]
    drag(box["y"], box["y"] - box["height"] / 2)  # its middle
    assert kept(page) == [["r_arm", 12, 60, "place", "mid"]]


def test_a_finger_drags_symbols_and_scrolls_elsewhere(
    own_page: Callable[..., Page], library: Path
) -> None:
    page = own_page(library, "/edit", has_touch=True, viewport={"width": 900, "height": 700})
    page.wait_for_selector(".edit-drawn svg")
    typed(page, "6", "Home", "ArrowUp")
    drawn(page, 1)
    box = page.locator(".edit-chosen").bounding_box()
    assert box
    x, device = box["x"] + box["width"] / 2, page.context.new_cdp_session(page)

    def drag(x: float, start: float, stop: float) -> None:
        for kind, y in [
            ("touchStart", start),
            *[("touchMove", start + (stop - start) * at / 8) for at in range(1, 9)],
            ("touchEnd", None),
        ]:
            points = [] if y is None else [{"x": x, "y": y}]
            device.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def scrolled() -> float:
        page.wait_for_timeout(300)
        return float(page.locator(STAFF).evaluate("(it) => it.scrollTop + window.scrollY"))

    before = scrolled()
    drag(x, box["y"] + 12, box["y"] + 12 - box["height"])  # its end, as fat as a finger
    assert kept(page) == [["r_arm", 0, 48, "right", "mid"]]
    drag(x, box["y"], box["y"] - box["height"] / 2)  # its middle
    assert kept(page) == [["r_arm", 12, 60, "right", "mid"]]
    assert scrolled() == before
    drag(x - 90, box["y"] - 100, box["y"])  # where there is no symbol
    assert scrolled() < before
    assert kept(page) == [["r_arm", 12, 60, "right", "mid"]]


def test_lanes_beside_the_staff_have_signs(own_page: Callable[..., Page], library: Path) -> None:
    from playwright.sync_api import expect

    page = own_page(library, "/edit")
    page.wait_for_selector(".edit-drawn svg")
    page.locator("summary", has_text="Columns").click()
    page.get_by_label("right hand touch").check()
    page.locator(STAFF).focus()
    for lane in ("jump", "right hand touch"):
        while not typed(page, "ArrowRight").startswith(lane):
            pass
        typed(page, "Enter")
    typed(page, "Escape")
    flight = page.locator(".edit-block.edit-jump")
    expect(flight).to_have_css("border-left-width", "2px")
    expect(flight).to_have_css("border-top-width", "0px")
    page.wait_for_function("""() => {
  const bow = document.querySelector(".edit-block.edit-touch");
  return bow && getComputedStyle(bow, "::after").borderBottomWidth === "2px";
}""")


def test_each_tab_keeps_its_own_draft_and_new_asks(
    own_page: Callable[..., Page], library: Path
) -> None:
    page = own_page(library, "/edit")
    page.wait_for_selector(".edit-drawn svg")
    other = page.context.new_page()
    other.goto(page.url)
    other.wait_for_selector(".edit-drawn svg")
    typed(page, "6")
    typed(other, "4")
    page.get_by_text("Another tab writes").wait_for()
    page.reload()
    page.wait_for_selector(".edit-drawn [data-symbol]")
    page.locator(STAFF).focus()
    typed(page, "Home")
    assert typed(page, "ArrowUp") == "right arm, right mid, bar 1 beat 1, 1 beat"
    page.get_by_role("button", name="New").click()
    page.get_by_role("button", name="Cancel").click()
    drawn(page, 1)
    page.get_by_role("button", name="New").click()
    page.get_by_role("button", name="Begin a new one").click()
    drawn(page, 0)


def test_a_sign_within_a_step_of_the_grid_is_chosen(
    own_page: Callable[..., Page], library: Path
) -> None:
    page = own_page(library, "/edit")
    page.wait_for_selector(".edit-drawn svg")
    grid = page.get_by_label("Grid")
    grid.select_option("1/4")
    page.locator(STAFF).focus()
    typed(page, "ArrowUp", "6")
    assert typed(page, "Escape") == "right arm, right mid, bar 1 beat 1.25, 1 beat, not chosen"
    grid.select_option("1")
    page.locator(STAFF).focus()
    typed(page, "Home")
    assert typed(page, "ArrowUp").startswith("right arm, right mid, bar 1 beat 1")


def test_what_the_figure_cannot_carry_out_is_said(browser: Browser, library: Path) -> None:
    with serving(library) as link:
        page = browser.new_context().new_page()  # a request that is refused is told in its console
        page.goto(link)
        page.goto(link.partition("/?")[0] + "/edit")
        page.wait_for_selector(".edit-drawn svg")
        page.get_by_label("Bars").fill("5000")
        page.get_by_label("Bars").press("Enter")
        page.get_by_text("a score of 600000 frames").wait_for()
        page.get_by_label("Bars").fill("4")
        page.get_by_label("Bars").press("Enter")
        page.get_by_text("a score of 600000 frames").wait_for(state="detached")
        page.context.close()


def test_a_capture_is_edited_and_held_against_itself(
    own_page: Callable[..., Page], library: Path
) -> None:
    page = own_page(library, "/edit?capture=1")
    page.wait_for_selector(".edit-drawn [data-symbol='r_arm.3']")
    page.get_by_role("button", name="Compare with it").click()
    page.wait_for_selector(".edit-found p")
    assert ", 0 differences." in (page.text_content(".edit-found") or "")
    page.locator(STAFF).focus()
    typed(page, "Home", "ArrowUp", "PageUp", "9")
    page.get_by_role("button", name="Compare with it").click()
    page.locator(".edit-found li", has_text="right forward").first.wait_for()
    page.locator(".edit-differs").first.wait_for()
    typed(page, "Control+z")
    assert page.locator(".edit-differs").count() == 0
    page.locator(STAFF).focus()
    whole = page.evaluate(
        "async () => (await (await fetch('/api/scores/captures/1')).json()).score"
    )
    typed(page, "Control+a", "Shift+M")
    assert kept(page) != whole["symbols"]
    typed(page, "Shift+M")
    assert sorted(kept(page)) == sorted(whole["symbols"])
    field = page.get_by_role("combobox", name="Capture")
    assert field.input_value().endswith("compass.bvh")
    field.fill("jumping")
    field.press("Enter")
    page.locator(".edit-found .path", has_text="jumping_jacks.bvh").wait_for()
    page.reload()
    page.get_by_role("button", name="Begin again").click()
    page.get_by_role("link", name="Open all tracks").click()
    page.wait_for_selector(".edit-drawn [data-symbol='r_forearm.3']")
    page.goto(page.url.partition("?")[0] + "?capture=1&from=4&to=9.5")
    page.wait_for_selector(".edit-drawn [data-symbol]")
    page.get_by_role("button", name="Compare with it").click()
    page.get_by_text(", 0 differences.").wait_for()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_of_the_editor_is_out_of_reach(
    own_page: Callable[..., Page],
    library: Path,
    violations: Callable[[Page], list[str]],
    scheme: str,
) -> None:
    page = own_page(library, "/edit?capture=2", bypass_csp=True, color_scheme=scheme)
    page.wait_for_selector(".edit-drawn [data-symbol]")
    assert violations(page) == []
