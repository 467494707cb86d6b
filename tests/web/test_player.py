"""The player and the staff, in a browser."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest

pytestmark = pytest.mark.slow  # journeys in a browser

if TYPE_CHECKING:
    from figure_page import Walker
    from playwright.sync_api import Page


SECOND = 560  # units of a second on a staff, as drawn by default


def drawn(page: Page) -> None:
    """Wait until what was asked for is drawn."""
    page.evaluate("new Promise((it) => requestAnimationFrame(() => requestAnimationFrame(it)))")


def now(page: Page) -> float:
    """Return the seconds of the player, after a frame."""
    drawn(page)
    seconds: float = page.evaluate("player.seconds")
    return seconds


def test_keys_move_it(played: Any, walker: Walker) -> None:
    page, frame = played(), 1 / float(walker.body.rate)
    page.get_by_role("button", name="Play").focus()
    for key, seconds in [
        *((".", frame), (".", 2 * frame), (",", frame), ("ArrowRight", 1 + frame)),
        *(("ArrowRight", 2 + frame), ("ArrowLeft", 1 + frame), ("ArrowLeft", frame)),
        *((",", 0), (",", 0), ("ArrowLeft", 0)),
    ]:
        page.keyboard.press(key)
        assert now(page) == pytest.approx(seconds), key
    page.locator("body").press(" ")
    assert page.evaluate("player.playing")
    page.get_by_role("button", name="Pause").wait_for()
    page.locator("body").press(" ")
    page.get_by_role("button", name="Play").wait_for()
    assert now(page) > 0


def test_a_range_is_played_again_and_again(played: Any) -> None:
    page = played()
    page.evaluate("player.range = [2, 2.5]; player.speed = 4")
    page.keyboard.press("l")
    page.locator("[aria-label=Loop][aria-pressed=true]").wait_for()
    page.evaluate("log.length = 0; player.play()")
    page.wait_for_timeout(1000)
    times = page.evaluate("(player.pause(), log.map((it) => it.staff))")[1:]
    assert all(2 <= it <= 2.5 for it in times)
    assert sum(b < a for a, b in pairwise(times)) >= 3


def test_it_ends_at_the_end(played: Any) -> None:
    page = played()
    page.evaluate("player.seek(player.length - 2); player.play()")
    page.get_by_role("button", name="Pause").wait_for()
    page.get_by_role("button", name="Play").wait_for()
    assert now(page) == page.evaluate("player.length")
    page.get_by_role("button", name="Play").click()
    assert 0 < now(page) < 1  # from the start again


@pytest.mark.parametrize("speed", [0.25, 1, 4])
def test_it_is_as_fast_as_chosen(played: Any, speed: float) -> None:
    page = played()
    page.get_by_label("Speed").select_option(str(speed))
    page.evaluate("log.length = 0; player.play()")
    page.wait_for_timeout(1000)
    log = page.evaluate("(player.pause(), log)")
    took = (log[-1]["at"] - log[0]["at"]) / 1000
    assert log[-1]["staff"] - log[0]["staff"] == pytest.approx(speed * took, rel=0.15)


def test_it_waits_for_a_tile_and_says_so(played: Any) -> None:
    page = played()
    held: list[Any] = []
    with page.expect_response("**/motion/1"):
        page.evaluate("player.seek(8)")  # what comes soon is fetched, too
    page.wait_for_function("() => motion.held === 2")
    page.route("**/motion/*", lambda route: held.append(route))
    page.evaluate("player.seek(15)")
    assert now(page) == 15
    assert not page.evaluate("player.waiting")
    page.reload()
    page.get_by_text("Waiting for the movement").wait_for()
    page.evaluate("player.play()")
    assert now(page) == 0
    for route in held:
        route.continue_()
    page.unroute("**/motion/*")
    page.get_by_text("Waiting for the movement").wait_for(state="detached")
    assert now(page) > 0


def test_what_cannot_be_read_is_said(played: Any) -> None:
    page = played()
    page.evaluate("motion.failure = () => new Error('the movement could not be read (500)')")
    page.evaluate("player.play()")
    page.get_by_text("the movement could not be read (500)").wait_for()
    assert not page.evaluate("player.playing")


DRAWN = """() => {
  const line = document.querySelector('.staff-line').getBoundingClientRect();
  const symbols = [];
  let scale = 0;
  for (const piece of document.querySelectorAll('.staff-layer > div')) {
    const around = piece.getBoundingClientRect();
    scale = around.width / piece.firstChild.viewBox.baseVal.width;
    for (const it of piece.querySelectorAll('g[data-part$=support]')) {
      const { top, bottom } = it.getBoundingClientRect(), { start, end } = it.dataset;
      if (start > 0 && bottom > top && top > around.top && bottom < around.bottom) {
        symbols.push([Number(start), Number(end), bottom, top]);
      }
    }
  }
  return { middle: line.top + line.height / 2, scale, symbols };
}"""


@pytest.mark.parametrize("seconds", [0, 4.2, 9.99, 10.01, 18])
def test_symbols_are_as_far_from_the_line_as_in_time(played: Any, seconds: float) -> None:
    page = played()
    page.locator(".staff-layer > div").first.wait_for()
    page.evaluate(f"player.seek({seconds})")
    page.wait_for_function(f"() => ({DRAWN})().symbols.length > 5")
    drawn(page)
    found = page.evaluate(DRAWN)
    second = SECOND * found["scale"]
    for start, end, bottom, top in found["symbols"]:
        assert found["middle"] - bottom == pytest.approx(second * (start - seconds), abs=4)
        assert found["middle"] - top == pytest.approx(second * (end - seconds), abs=4)


def test_a_symbol_is_picked_and_a_blank_place_sought(played: Any) -> None:
    page = played()
    page.evaluate("player.seek(5)")
    drawn(page)
    found = page.wait_for_function(
        """() => {
      const line = document.querySelector('.staff-line').getBoundingClientRect().top;
      for (const it of document.querySelectorAll('g[data-part=r_support]')) {
        const box = it.getBoundingClientRect();
        if (box.height && box.bottom < line - 10 && box.top > 60) {
          return [box.left + box.width / 2, box.top + box.height / 2];
        }
      }
    }"""
    )
    page.mouse.click(*found.json_value())
    assert page.evaluate("said.picked") == ["r_support"]
    assert page.locator(".staff g.chosen").count() == 1
    staff = page.locator("#staff").bounding_box()
    page.mouse.click(staff["x"] + 3, staff["y"] + 30)
    assert now(page) > 6


def test_a_stretch_is_selected_by_dragging(played: Any) -> None:
    page = played()
    page.evaluate("player.seek(5)")
    drawn(page)
    staff = page.locator("#staff").bounding_box()
    line = page.locator(".staff-line").bounding_box()["y"] + 1
    x = staff["x"] + 3
    page.mouse.move(x, line)
    page.mouse.down()
    page.mouse.move(x, line - 40)
    page.mouse.move(x, line - 80)
    page.mouse.up()
    start, stop = page.evaluate("said.selected.at(-1)")
    assert start == pytest.approx(5, abs=0.1)
    assert stop > start + 0.5
    mark = page.locator(".staff-selected").bounding_box()
    assert mark["y"] == pytest.approx(line - 80, abs=2)
    assert mark["y"] + mark["height"] == pytest.approx(line, abs=2)
    assert now(page) == 5  # what is selected is not gone to
    page.locator("#staff").press("Escape")
    assert page.evaluate("said.selected.at(-1)") is None
    assert page.locator(".staff-selected").is_hidden()


def test_the_staff_is_used_by_keys(played: Any) -> None:
    page = played()
    page.locator("#staff").focus()
    for _ in range(4):
        page.keyboard.press("ArrowUp")
    assert now(page) == 1
    for _ in range(3):
        page.keyboard.press("Shift+ArrowUp")
    assert page.evaluate("said.selected.at(-1)") == [1, 1.75]
    page.keyboard.press("Shift+ArrowDown")
    assert page.evaluate("said.selected.at(-1)") == [1, 1.5]
    page.evaluate("player.seek(3.05)")
    now(page)
    page.keyboard.press("ArrowRight")
    first = page.locator(".staff-state").inner_text()
    page.keyboard.press("ArrowRight")
    assert page.locator(".staff-state").inner_text() != first
    page.keyboard.press("Enter")
    assert len(page.evaluate("said.picked")) == 1
    height = "document.querySelector('.staff-layer > div').getBoundingClientRect().height"
    before = page.evaluate(height)
    page.keyboard.press("+")
    page.wait_for_function(f"() => {height} > {1.8 * before}")
    assert page.evaluate(height) <= 2 * before


def test_nobody_is_shut_out(played: Any, violations: Any) -> None:
    for scheme in ("light", "dark"):
        page = played(color_scheme=scheme)
        page.wait_for_timeout(300)
        assert violations(page) == []


def test_pieces_of_the_staff_that_are_passed_by_are_not_fetched(played: Any) -> None:
    page = played()
    found = page.evaluate("""async () => {
  const { StaffView } = await import('/static/staff.js');
  const root = document.createElement('div'), asked = [], aborted = [];
  root.style.height = '300px';
  document.getElementById('stage').append(root);
  let fail = () => {};
  const view = new StaffView(root, { seconds: 1000, parse: null, seek() {}, pick() {}, select() {},
    load: (from, to, zoom, signal) => new Promise((resolve, reject) => {
      asked.push(from);
      fail = () => reject(new Error('none'));
      signal.addEventListener('abort', () => { aborted.push(from); reject(signal.reason); });
    }) });
  for (const at of [5, 55, 105, 155]) view.show(at);
  const first = [...asked];
  fail();
  await new Promise((done) => setTimeout(done, 50));
  const then = [...asked];
  view.dispose();
  return { first, then, aborted };
}""")
    assert found == {"first": [0], "then": [0, 150], "aborted": [150]}
