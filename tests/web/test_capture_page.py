"""The screen of a capture: its curves, and what a symbol says and finds."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

import pytest
from page_client import serving
from starlette.testclient import TestClient

import lanindex
from lanindex.alphabet import kind_of

pytestmark = pytest.mark.slow  # journeys in a browser

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


@pytest.fixture(scope="module")
def jacks(library: lanindex.Library) -> str:
    return f"/captures/{library.capture('jumping_jacks.bvh').id}"


def test_curves_are_those_of_the_library(
    ask: TestClient, library: lanindex.Library, jacks: str
) -> None:
    answer = ask.get(f"/api{jacks}/curves", params={"part": "r_arm", "from": 1, "to": 3})
    assert answer.json() == library.curves("jumping_jacks.bvh", "r_arm", 1, 3).record()
    refused = ask.get(f"/api{jacks}/curves", params={"part": "step"})
    assert refused.status_code == 400
    assert refused.json()["error"]["found"] == 'no part "step" is known'


def test_a_symbol_s_pattern_finds_it(ask: TestClient, library: lanindex.Library) -> None:
    found: dict[str, set[tuple[int, str, int]]] = {}
    kinds = set()
    for capture in library.captures():
        names = library.staff(capture.id, detail="full").symbols()
        parts = [*dict.fromkeys(name.rpartition(".")[0] for name in names)]
        stop = min(float(capture.frames / capture.rate), 60)
        staff = library.staff(capture.id, 0, stop, parts=parts)
        for name, record in staff.symbols().items():
            if int(name.rpartition(".")[2]) % 5 > 1:
                continue  # two of five will do
            where = {"name": name, "at": f"{record['start']:.3f}", "parts": ",".join(parts)}
            told = ask.get(f"/api/captures/{capture.id}/symbol", params=where).json()
            assert told["words"] == record["words"]
            pattern, begins = told["pattern"], record["start_frame"] == record["end_frame"]
            assert (pattern == "") == begins
            if begins:
                continue
            kinds.add(kind_of(record["part"]))
            if pattern not in found:
                found[pattern] = {
                    (hit.capture.id, it.part, frame)
                    for hit in library.search(pattern)
                    for it in hit.symbols
                    for frame in (it.start, it.stop)
                }
            # what is drawn joins symbols: it has the start of the first, the end of the last
            edges = {
                (capture.id, record["part"], record[it]) for it in ("start_frame", "end_frame")
            }
            assert edges & found[pattern], (name, pattern)
    assert {"gesture", "bend", "support", "stance", "incline", "touch", "travel"} <= kinds


def test_a_capture_is_labelled_and_taken_to_other_screens(
    own_page: Callable[..., Page], corpus_library: Path, tmp_path: Path
) -> None:
    path = Path(shutil.copy(corpus_library, tmp_path / "own.db"))
    with lanindex.open_library(path) as library:
        number = library.capture("compass.bvh").id
    page = own_page(path, f"/captures/{number}")
    label = page.get_by_role("button", name="label of compass.bvh")
    label.press("Enter")
    page.keyboard.type("rose")
    page.keyboard.press("Enter")
    page.get_by_role("button", name="label of compass.bvh: rose").wait_for()
    page.get_by_text("label changed").wait_for()
    page.keyboard.press("Control+z")
    page.get_by_role("button", name="label of compass.bvh: compass").wait_for()
    page.wait_for_function("document.activeElement.matches('.editable')")
    for link, shown in {
        "Edit": ".edit-drawn [data-symbol]",
        "Convert": ".convert .staff g[data-part]",
        "Compare with": ".picker input:focus",
    }.items():
        page.get_by_role("navigation", name="This capture").get_by_role("link", name=link).click()
        page.locator(shown).first.wait_for()
        assert page.get_by_role("combobox").first.input_value().endswith("compass.bvh") or (
            link == "Edit"
        )
        page.go_back()


def test_curves_move_with_the_player(opened: Callable[..., Page], jacks: str) -> None:
    page = opened(f"{jacks}?t=2.5")
    page.get_by_text("Curves", exact=True).click()
    plot = page.locator("svg.curves")
    page.locator("svg.curves .candidate").first.wait_for()
    assert plot.locator(".move").count() > 2
    assert "v0 621 mm/s, d_t 51 mm" in (plot.get_attribute("aria-label") or "")
    said = page.locator(".said-now")
    assert re.match(r"2\.50 s: \d+ mm/s, .* right", said.inner_text())
    page.get_by_label("Limb").select_option("l_leg")
    page.locator("svg.curves[aria-label^='left leg']").wait_for()
    assert "curve=l_leg" in page.url
    line, before = plot.locator(".now"), plot.locator(".now").get_attribute("x1")
    page.locator("body").press("ArrowRight")
    said.filter(has_text=re.compile(r"^3\.50 s: ")).wait_for()
    assert float(line.get_attribute("x1") or 0) > float(before or 0)
    box = plot.bounding_box()
    assert box
    plot.click(position={"x": box["width"] * 0.1, "y": 20})
    said.filter(has_not_text=re.compile(r"^3\.50 s: ")).wait_for()
    page.wait_for_url(lambda url: "t=3.500" not in url)
    page.reload()
    page.locator("svg.curves .candidate").first.wait_for()
    assert page.get_by_label("Limb").input_value() == "l_leg"


def test_all_columns_can_be_read_on_a_phone(
    opened: Callable[..., Page], ask: TestClient, jacks: str
) -> None:
    parts = [*ask.get(f"/api{jacks}").json()["parts"]]
    assert "step" not in parts  # it has no column
    assert len(parts) > 25
    page = opened(f"{jacks}?t=2.4&parts={','.join(parts)}", viewport={"width": 400, "height": 800})
    page.locator(".staff g[data-part=r_arm]").first.wait_for()
    staff = page.locator(".staff")
    wide, across, at = staff.evaluate("(it) => [it.clientWidth, it.scrollWidth, it.scrollLeft]")
    assert across > wide
    assert at == pytest.approx((across - wide) / 2, abs=1)  # its centre is seen
    for name in ("line", "layer", "names"):
        assert page.locator(f".staff-{name}").evaluate("(it) => it.offsetWidth") == across
    staff.focus()
    for way in ("Left", "Right"):
        for _ in range(len(parts)):
            page.keyboard.press(f"Arrow{way}")
        chosen, box = page.locator(".staff g.chosen").bounding_box(), staff.bounding_box()
        assert chosen
        assert box
        assert box["x"] <= chosen["x"] < chosen["x"] + chosen["width"] <= box["x"] + box["width"]
    assert page.evaluate("document.documentElement.scrollWidth") == 400


def test_curves_are_as_wide_as_a_phone(opened: Callable[..., Page], jacks: str) -> None:
    page = opened(f"{jacks}?t=0&curve=r_arm", viewport={"width": 400, "height": 800})
    page.locator("svg.curves .candidate").first.wait_for()
    line, plot = page.locator("svg.curves .now"), page.locator("svg.curves").bounding_box()
    assert plot
    assert plot["x"] + plot["width"] <= 400
    for seconds in range(1, 5):
        page.locator("body").press("ArrowRight")
        page.locator(".said-now", has_text=re.compile(rf"^{seconds}\.00 s: ")).wait_for()
        there = line.bounding_box()
        assert there
        assert plot["x"] <= there["x"] <= plot["x"] + plot["width"]


def test_curves_show_what_the_method_makes_of_them(
    opened: Callable[..., Page], ask: TestClient, jacks: str
) -> None:
    page = opened(f"{jacks}?t=2.5&curve=r_arm")
    plot = page.locator("svg.curves")
    plot.locator(".candidate").first.wait_for()
    asked = {"part": "r_arm", "from": 0, "to": 10}
    told = ask.get(f"/api{jacks}/curves", params=asked).json()
    kept = {it for hold in told["holds"] for it in hold}
    assert plot.locator(".candidate").count() == len(told["candidates"])
    assert plot.locator(".candidate.kept").count() == len(kept & {*told["candidates"]})
    labels = plot.locator("text.label").all_text_contents()
    assert {"v0 621", "d_t 51", "right forward", "left back", "low", "mid", "high"} <= {*labels}
    left = sum(it["outcome"] == "symbol" for it in told["runs"])
    struck = plot.locator("line.struck").count()
    assert left < plot.locator("rect.cell").count() - struck <= 2 * left  # both strips
    here = plot.locator("text.label.here").all_text_contents()
    said = page.locator(".said-now").inner_text()
    assert " ".join(reversed(here)) in said  # the bands of direction and level in which it is
    page.set_viewport_size({"width": 700, "height": 800})
    page.wait_for_timeout(200)
    box, mark = plot.bounding_box(), plot.locator("text.label").first.bounding_box()
    assert box
    assert mark
    assert box["width"] < 700
    assert mark["height"] == pytest.approx(14, abs=3)  # words stay as large as they are


VOICE = """
window.spoken = [];
const voice = (name, localService) => ({ name, localService, lang: "en-GB" });
const getVoices = () => [voice("far", false), voice("own", true)];
const speak = (it) => spoken.push([it.text, it.voice.name]);
Object.defineProperty(window, "speechSynthesis", { value: { getVoices, speak, cancel() {} } });
window.SpeechSynthesisUtterance = class { constructor(text) { this.text = text; } };
"""


def test_a_symbol_is_spoken_by_a_voice_of_this_machine(
    opened: Callable[..., Page], jacks: str
) -> None:
    page = opened(f"{jacks}?t=2.4&parts=r_arm")
    page.add_init_script(VOICE)
    page.reload()
    symbol = page.locator(".staff g[data-symbol]")
    symbol.first.wait_for()
    page.locator(".staff").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    assert page.evaluate("spoken") == []
    page.get_by_role("button", name="Speak").press("Enter")
    page.locator(".staff").focus()
    page.keyboard.press("Enter")
    said = page.evaluate("spoken.at(-1)")
    assert said == [page.locator(".chosen-one span span").first.inner_text(), "own"]
    assert said[0].startswith("right arm, right ")
    page.reload()
    symbol.first.wait_for()
    assert page.get_by_role("button", name="Speak").get_attribute("aria-pressed") == "true"


def test_a_symbol_is_told_and_searched_for(opened: Callable[..., Page], jacks: str) -> None:
    page = opened(f"{jacks}?t=2.4&parts=r_arm")
    page.locator(".staff g[data-symbol]").first.wait_for()
    page.locator(".staff").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    link = page.get_by_role("link", name="search for r_arm")
    assert link.inner_text() in ("search for r_arm right mid", "search for r_arm right high")
    heading = page.locator("h1")
    assert heading.inner_text() == "jumping_jacks.bvh"
    assert (heading.get_attribute("title") or "").endswith("corpus/jumping_jacks.bvh")
    link.click()
    page.wait_for_url(re.compile(r"/search\?q=r_arm\+right\+(mid|high)"))
    page.locator(".hit").first.wait_for()
    page.go_back()
    page.wait_for_url(re.compile(r"/captures/.*parts=r_arm"))
    page.locator(".staff g[data-symbol]").first.wait_for()


def test_a_browser_that_cannot_speak_shows_all_else(
    opened: Callable[..., Page], jacks: str
) -> None:
    page = opened("/help")
    page.add_init_script("delete Window.prototype.speechSynthesis; delete window.speechSynthesis;")
    page.goto(page.url.partition("/help")[0] + f"{jacks}?t=2.4&parts=r_arm")
    page.locator(".staff g[data-symbol]").first.wait_for()
    assert not page.get_by_text("Speak", exact=True).is_visible()


def test_columns_are_chosen_by_keys_while_it_plays(
    opened: Callable[..., Page], jacks: str, tabbed: Callable[..., None]
) -> None:
    page = opened(f"{jacks}?t=0.5")
    arm = page.locator(".staff g[data-part=r_arm]")
    arm.first.wait_for(state="attached")
    tabbed(page, "Speed")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowUp")  # a quarter as fast: it still plays when the columns have come
    tabbed(page, "Play", "Shift+Tab")
    page.keyboard.press("Space")
    tabbed(page, "Columns of the staff")
    page.keyboard.press("Enter")
    page.get_by_label("right arm bend", exact=True).wait_for()
    page.get_by_label("right arm", exact=True).wait_for()
    page.keyboard.press("Tab")
    while page.evaluate("document.activeElement.value") != "r_arm":
        page.keyboard.press("Tab")
    page.keyboard.press("Space")
    arm.first.wait_for(state="detached")
    assert arm.count() == 0
    page.locator(".staff g[data-part=l_arm]").first.wait_for(state="attached")
    page.get_by_role("button", name="Pause").wait_for()
    parts = parse_qs(urlsplit(page.url).query)["parts"][0].split(",")
    assert "l_arm" in parts
    assert "r_arm" not in parts
    page.keyboard.press("Space")
    arm.first.wait_for(state="attached")
    assert "parts=" not in page.url


def test_a_capture_whose_file_is_gone_is_told_and_its_staff_plays(
    browser: Browser, tmp_path: Path
) -> None:
    source = tmp_path / "away.bvh"
    shutil.copy(Path(__file__).parents[2] / "corpus" / "jumping_jacks.bvh", source)
    with lanindex.open_library(tmp_path / "own.db", create=True) as library:
        library.ingest(source)
        number = library.captures()[0].id
    source.unlink()
    with serving(tmp_path / "own.db") as link:
        context = browser.new_context()  # of its own: the refusal stands in the console, too
        page = context.new_page()
        page.goto(link)
        page.goto(link.partition("/?")[0] + f"/captures/{number}?t=1")
        told = page.locator(".stage .trouble")
        told.wait_for()
        assert "away.bvh" in told.inner_text()
        assert "Traceback" not in told.inner_text()
        beside = page.locator(".stage .staff").bounding_box()
        frame = told.bounding_box()
        assert frame
        assert beside
        assert frame["height"] < beside["height"] / 2  # as high as its words
        page.locator(".staff g[data-part=r_arm]").first.wait_for(state="attached")
        page.locator("body").press("ArrowRight")
        page.locator(".clock", has_text="0:02.00").wait_for()
        page.wait_for_url("**t=2.000**")
        context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_is_open_to_all(
    opened: Callable[..., Page], violations: Any, jacks: str, scheme: str
) -> None:
    page = opened(f"{jacks}?t=2.5&curve=r_arm", color_scheme=scheme, bypass_csp=True)
    page.locator("svg.curves .candidate").first.wait_for()
    assert violations(page) == []


def test_tiles_carry_the_stamp_of_the_library(
    opened: Callable[..., Page], jacks: str, library: lanindex.Library
) -> None:
    page = opened("/help")
    with page.expect_response("**/motion/0*") as first, page.expect_response("**/source"):
        page.goto(page.url.partition("/help")[0] + jacks)
    assert first.value.url.endswith(f"/motion/0?v={library.stamp}&early=1")
    assert first.value.headers["cache-control"] == "no-store"
    with page.expect_response("**/motion/1*") as second:
        page.get_by_label("Time", exact=True).fill("9000")
    assert second.value.url.endswith(f"/motion/1?v={library.stamp}")
    assert "max-age" in second.value.headers["cache-control"]


def test_what_has_no_curves_says_so(browser: Browser, link: str, library: lanindex.Library) -> None:
    score = library.capture("compass.lnd").id
    context = browser.new_context()  # of its own: the refusal stands in the console, too
    page = context.new_page()
    page.goto(link)
    page.goto(link.partition("/?")[0] + f"/captures/{score}?curve=r_arm")
    page.get_by_text("There are no curves: a score, which has no movement").wait_for()
    page.locator("svg.curves").wait_for(state="hidden")
    context.close()


def test_on_a_phone_the_buttons_that_play_are_seen(opened: Callable[..., Page], jacks: str) -> None:
    page = opened(jacks, viewport={"width": 390, "height": 700})
    page.locator(".staff-layer svg").first.wait_for()
    play = page.get_by_role("button", name="Play").bounding_box()
    assert play
    assert play["y"] + play["height"] <= 700


def test_the_names_of_columns_can_be_read(opened: Callable[..., Page], jacks: str) -> None:
    page = opened(jacks)
    names = page.locator(".staff-names text")
    names.first.wait_for(state="attached")
    boxes = names.evaluate_all("(all) => all.map((it) => it.getBoundingClientRect().toJSON())")
    frame = page.locator(".staff-names").bounding_box()
    assert frame
    assert "arm" in names.all_text_contents()
    for box in boxes:
        assert box["width"] >= 10  # they stand upright
        assert box["bottom"] <= frame["y"] + frame["height"]
