"""Searching in a browser: typing, hits, watching one, putting it aside."""

import re
import shlex
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import ZipFile

import command
import pytest
from playwright.sync_api import expect

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

Opened = Callable[..., "Page"]


def test_words_are_searched_for_and_a_hit_is_watched(opened: Opened) -> None:
    page = opened("/search")
    page.get_by_role("textbox", name="What is searched for").fill("waving")
    expect(page.locator(".said")).to_contain_text("forearm")
    expect(page.locator(".summary")).to_have_text(re.compile(r"^\d+ hits in \d+ captures$"))
    first = page.locator(".hit").first
    expect(first.locator(".poses svg")).to_be_visible()
    expect(first.locator(".strip svg")).to_be_visible()
    assert "q=waving" in page.url
    expect(page.locator("#said")).to_have_text(page.locator(".summary").inner_text())  # read out
    expect(page.locator(".query .said")).to_contain_text("forearm")
    first.locator("a.show").click()
    expect(page).to_have_url(re.compile(r"/captures/\d+\?.*from="))
    expect(page.locator(".staff-layer svg").first).to_be_visible()
    expect(page.get_by_role("button", name="Pause")).to_be_visible()  # it moves at once
    page.go_back()
    expect(page.locator(".hit").first).to_be_visible()
    assert "q=waving" in page.url


AS_LARGE = r"""() => {
  const colored = (numbers) => Math.max(...numbers) - Math.min(...numbers) > 60; // a limb
  const numbers = (text) => (text.match(/\d+/g) ?? [0]).map(Number);
  const card = document.querySelector(".hit"), canvas = card.querySelector(".moving");
  if (!canvas?.width) return false;
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height), ys = [];
  for (let at = 0; at < data.length; at += 4) {
    if (colored(data.subarray(at, at + 3))) ys.push(Math.floor(at / 4 / width));
  }
  const limbs = [...card.querySelectorAll(".poses svg path")]
    .filter((it) => colored(numbers(getComputedStyle(it).stroke)))
    .map((it) => it.getBoundingClientRect());
  const still = Math.max(...limbs.map((it) => it.bottom)) - Math.min(...limbs.map((it) => it.top));
  const share = (ys.at(-1) - ys[0]) * canvas.clientHeight / height / still;
  const ground = numbers(getComputedStyle(card).backgroundColor).join();
  return share > 0.85 && share < 1.15 && ground === data.subarray(0, 3).join();
}"""


@pytest.mark.slow
def test_a_hit_moves_as_large_as_it_stands_and_on_the_same_ground(opened: Opened) -> None:
    page = opened("/search?q=arms+place+high&in=*.bvh")
    first = page.locator(".hit").first
    first.locator(".poses svg").wait_for()
    first.hover()
    page.wait_for_function(AS_LARGE, polling=100)  # it moves its arms up again and again


@pytest.mark.slow
def test_what_is_offered_is_taken_and_what_is_wrong_is_marked(opened: Opened) -> None:
    page = opened("/search")
    line = page.get_by_role("textbox", name="What is searched for")
    line.press_sequentially("r_arm ri")
    page.get_by_role("option", name="right", exact=False).first.wait_for()
    line.press("ArrowDown")
    line.press("Tab")
    expect(line).to_have_value("r_arm right ")
    expect(page.locator(".said")).to_contain_text("The right arm moves to the right")
    line.press_sequentially("higgh")
    expect(page.locator(".said.wrong")).to_contain_text("high")
    expect(page.locator(".mirror mark")).to_have_text("higgh")
    expect(line).to_have_attribute("aria-invalid", "true")


@pytest.mark.slow
def test_a_search_that_is_not_kept_any_more_is_made_again(browser: "Browser", link: str) -> None:
    page = browser.new_page()
    forgotten: dict[str, Any] = {"status": 404, "json": {"error": {"found": "not kept any more"}}}
    page.route("**/hits?*", lambda route: route.fulfill(**forgotten), times=1)
    page.goto(link)
    with page.expect_response(lambda it: it.status == 404):
        page.goto(link.partition("/?")[0] + "/search?q=arms+place+high")
    page.locator(".hit").first.wait_for()
    expect(page.locator(".trouble")).to_have_count(0)
    page.context.close()


@pytest.mark.slow
def test_a_link_shows_the_same_in_another_browser(opened: Opened) -> None:
    address = "/search?q=arms+place+high&in=*.bvh&order=capture"
    counts = []
    for _ in range(2):
        page = opened(address)
        expect(page.locator(".summary")).to_have_text(re.compile(r"^\d+ hits? in \d+ captures?$"))
        counts.append(page.locator(".summary").inner_text())
    assert counts[0] == counts[1]
    assert page.get_by_label("Only captures whose path matches").input_value() == "*.bvh"


@pytest.mark.slow
def test_what_is_counted_is_shown(opened: Opened) -> None:
    page = opened("/search?q=arms+place+high+%7C+count+by+clip.label&in=*.bvh")
    expect(page.locator(".counts li")).to_have_text(["radio gymnastics: 4", "port de bras: 1"])


@pytest.mark.slow
def test_nothing_found_says_what_would_be(opened: Opened) -> None:
    page = opened("/search?q=arms+low+-%3E+high&in=*.bvh")
    page.get_by_role("button", name="arms low ... high").click()
    expect(page.locator(".summary")).to_have_text(re.compile(r"18 hits in \d+ captures"))


@pytest.mark.slow
def test_hits_that_are_put_aside_leave_as_a_zip(opened: Opened) -> None:
    page = opened("/search?q=arms+place+high+-%3E+side+mid&in=*.bvh")
    for number in range(2):
        page.get_by_role("button", name="In the basket").nth(number).click()
    expect(page.locator(".basket")).to_contain_text("2 hits")
    with page.expect_download() as download:
        page.get_by_role("button", name="Clips").click()
    packed = ZipFile(BytesIO(download.value.path().read_bytes()))
    endings = sorted(name.rpartition(".")[2] for name in packed.namelist())
    assert endings == ["bvh", "bvh", "csv", "jsonl", "lnd", "lnd"]


@pytest.mark.slow
def test_a_search_is_copied_as_what_finds_the_same(
    opened: Opened, corpus_library: Path, tmp_path: Path
) -> None:
    address = "/search?q=arms+place+high&in=*.bvh&where=label%3Dradio*&near=true"
    page = opened(address, permissions=["clipboard-read", "clipboard-write"])
    expect(page.locator(".summary")).to_have_text(re.compile(r"^\d+ hits? in \d+ captures?$"))
    copied = {}
    for name in ("command", "Python", "link"):
        page.get_by_role("group", name="Copy as").get_by_role("button", name=name).click()
        expect(page.get_by_role("status").last).to_contain_text(f"the {name} is copied")
        copied[name] = page.evaluate("navigator.clipboard.readText()")
    (tmp_path / "dances.db").symlink_to(corpus_library)
    done = command.run(*shlex.split(copied["command"])[1:], "--count", cwd=tmp_path)
    found = int(page.locator(".summary").inner_text().split()[0])
    assert sum(int(line.split("\t")[-1]) for line in done.stdout.splitlines()) == found
    script = f"import os\nos.chdir({str(tmp_path)!r})\n{copied['Python']}"
    names: dict[str, Any] = {}
    exec(script, names)
    assert len(names["hits"]) == found
    assert copied["link"].endswith(address.partition("?")[2])
    page.get_by_role("button", name="label=radio*").click()
    expect(page).to_have_url(re.compile(r"/search\?q=arms(?!.*where)"))


@pytest.mark.slow
def test_more_like_a_hit_and_its_symbols_are_found(opened: Opened) -> None:
    page = opened("/captures/1?from=1&to=4")
    page.get_by_role("button", name="search for its symbols").click()
    expect(page).to_have_url(re.compile(r"/search\?q="))
    expect(page.locator(".hit").first).to_be_visible()
    page.get_by_role("link", name="more like this").first.click()
    expect(page).to_have_url(re.compile(r"/search\?like="))
    expect(page.locator(".hit").first).to_be_visible()


@pytest.mark.slow
@pytest.mark.parametrize("address", ["/search?q=wave", "/captures/3?t=1"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_keeps_anyone_out(
    opened: Opened, violations: Callable[["Page"], list[str]], address: str, scheme: str
) -> None:
    page = opened(address, color_scheme=scheme, bypass_csp=True)
    page.locator(".hit, .staff-layer svg").first.wait_for()
    assert violations(page) == []


@pytest.mark.slow
def test_back_returns_to_what_was_meant_and_to_the_hit_that_was_watched(opened: Opened) -> None:
    page = opened("/")
    page.get_by_role("link", name="Search", exact=True).click()
    line = page.get_by_role("textbox", name="What is searched for")
    expect(line).to_be_focused()
    page.keyboard.type("arms high")
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile("q=arms"))
    summary = page.locator(".summary")
    expect(summary).to_have_text(re.compile("captures?$"))
    before = summary.inner_text()
    line.fill("r_arm any")
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile("q=r_arm"))
    expect(summary).not_to_have_text(before)
    expect(summary).to_have_text(re.compile("captures$"))
    page.get_by_role("button", name="Show more").click()
    expect(page.locator(".hit")).to_have_count(48)
    hit = page.locator(".hit").nth(39)
    times = hit.locator(".num").first.text_content()
    hit.locator("a.show").click()
    expect(page).to_have_url(re.compile("/captures/"))
    page.go_back()
    expect(page.locator(".hit").nth(39)).to_be_in_viewport()
    expect(page.locator(".hit").nth(39).locator(".num").first).to_have_text(times)
    expect(page.locator(".hit").nth(39).locator("a.show")).to_be_focused()
    page.go_back()
    expect(line).to_have_value("arms high")
    expect(page.locator(".hit").first).to_be_visible()


@pytest.mark.slow
def test_hits_are_those_of_the_line(opened: Opened) -> None:
    page = opened("/search?q=r_arm+any")
    more = page.get_by_role("button", name="Show more")
    expect(more).to_be_visible()
    line = page.get_by_role("textbox", name="What is searched for")
    line.fill("my granny")
    expect(page.locator(".said.wrong")).to_be_visible()
    expect(page.locator(".hits.old")).to_be_visible()  # pale, until it is known what is meant
    line.press("Enter")
    expect(page.locator(".hit")).to_have_count(0)
    expect(more).to_be_hidden()
    expect(page.get_by_role("heading", name="Narrow down")).to_have_count(0)
    assert page.get_by_text("granny").count() == 1
    line.fill("r_arm any")
    expect(page.locator(".hit").first).to_be_visible()
    line.fill("")
    expect(page.locator(".hit")).to_have_count(0)
    assert page.locator(".summary").inner_text() == ""


@pytest.mark.slow
def test_hits_stand_by_capture_the_best_first(opened: Opened) -> None:
    page = opened("/search?q=arms+high&in=*.bvh")
    best = page.locator(".hit .path").first
    best.wait_for()
    name = best.inner_text()
    order = page.get_by_role("combobox", name="Order")
    order.select_option("best captures first")
    expect(page).to_have_url(re.compile(r"order=best\+capture"))
    expect(page.locator(".hits > .capture").first).to_contain_text(name)
    expect(page.locator(".hit .path")).to_have_count(0)
    page.locator(".hit .strip svg").first.wait_for()
    paths = page.locator(".hits > .capture .path").all_inner_texts()
    assert len(paths) == len(set(paths)) > 1
    times = page.locator(".capture ~ .hit .num > span:first-child").all_inner_texts()
    assert len(times) > len(paths)


@pytest.mark.slow
def test_an_empty_line_offers_examples_that_find_something(opened: Opened) -> None:
    page = opened("/search")
    ways = page.locator(".ways .way")
    ways.first.wait_for()
    line = page.get_by_role("textbox", name="What is searched for")
    assert ways.count() == 5
    for text in ways.all_inner_texts():
        page.get_by_role("button", name=text, exact=True).click()
        expect(page.locator(".summary")).to_have_text(re.compile(r"^[1-9]\d* hits? in"))
        expect(ways).to_have_count(0)
        expect(line).to_have_value(text)
        line.fill("")


@pytest.mark.slow
def test_what_is_typed_while_less_is_searched_for_is_searched_for_next(opened: Opened) -> None:
    page = opened("/search")
    line = page.get_by_role("textbox", name="What is searched for")
    page.evaluate(
        """() => {
          const ask = window.fetch; // what is typed last is understood late
          window.fetch = async (path, how) => {
            const late = path === "/api/parse" && JSON.parse(how.body).text.endsWith("place");
            if (late) await new Promise((done) => setTimeout(done, 1000));
            return ask(path, how);
          };
        }"""
    )
    line.fill("r_arm right")
    expect(page.locator(".said")).to_contain_text("The right arm moves to the right")
    with page.expect_request(
        lambda it: it.url.endswith("/searches") and "place" in (it.post_data or ""), timeout=10_000
    ):
        line.fill("r_arm right -> place")


@pytest.mark.slow
def test_what_is_like_a_hit_stays_so_when_it_is_narrowed_down(opened: Opened) -> None:
    page = opened("/search?q=arms+high")
    page.get_by_role("link", name="more like this").first.click()
    expect(page).to_have_url(re.compile("like="))
    like = re.search(r"like=([^&]*)", page.url)[1].replace("%3A", ":")
    expect(page.get_by_text("Movement like that of")).to_be_visible()
    expect(page.locator(".hit").first).to_be_visible()
    expect(page.get_by_role("combobox", name="Order")).to_be_disabled()
    page.evaluate("navigator.clipboard.writeText = async (it) => { window.copied = it; }")
    page.get_by_role("button", name="command").click()
    assert f"--like {like} --db " in page.evaluate("copied")
    page.locator(".facets a").first.click()
    expect(page).to_have_url(re.compile("where="))
    assert f"like={like}" in page.url.replace("%3A", ":")
    expect(page.locator(".hit").first).to_be_visible()
    page.get_by_label("Only captures whose path matches").fill("no such file")
    page.keyboard.press("Enter")
    expect(page.locator(".summary")).to_have_text("0 hits in 0 captures")


@pytest.mark.slow
def test_what_is_in_the_basket_is_listed_and_taken_out(opened: Opened) -> None:
    page = opened("/search?q=arms+high", viewport={"width": 400, "height": 800})
    stars = page.get_by_role("button", name="In the basket")
    stars.first.wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") == 400
    for at in range(2):
        stars.nth(at).click()
    page.get_by_text("What is in it").click()
    out = page.get_by_role("button", name=re.compile("^Take out"))
    expect(out).to_have_count(2)
    out.first.press("Enter")
    expect(out).to_have_count(1)
    expect(stars.nth(0)).to_have_attribute("aria-pressed", "false")
    expect(stars.nth(1)).to_have_attribute("aria-pressed", "true")
    expect(out).to_be_focused()


@pytest.mark.slow
def test_a_hit_that_is_not_there_any_more_keeps_nothing_from_the_address(opened: Opened) -> None:
    page = opened("/search?q=arms+high&hit=999")
    expect(page.locator(".summary")).to_have_text(re.compile("captures?$"))
    expect(page.locator(".hit")).not_to_have_count(0)
    page.get_by_role("textbox", name="What is searched for").fill("head left")
    expect(page).to_have_url(re.compile("q=head"))
    assert "hit=" not in page.url
