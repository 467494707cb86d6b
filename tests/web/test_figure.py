"""The figure, its motion, the player and the staff, in a browser."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from PIL import Image

from lanindex.draw.svg import BODY

pytestmark = pytest.mark.slow  # journeys in a browser

if TYPE_CHECKING:
    from figure_page import Walker
    from playwright.sync_api import Browser, Page

LEAST = 12  # frames a second on a machine that runs other tests meanwhile; alone it is over 25
SHOWN = ("Ghosts", "Front and side", "Floor plan")
KINDS = ["space", "canvas"]


def picture(page: Page) -> np.ndarray[Any, Any]:
    """Return what is on the canvas, (H, W, 3)."""
    shot = page.locator("#figure").screenshot()
    return np.asarray(Image.open(BytesIO(shot)).convert("RGB")).astype(int)


def near(shown: np.ndarray[Any, Any], color: str, within: int = 60) -> int:
    """Return how many pixels have about a colour."""
    wanted = np.array([*bytes.fromhex(color[1:])])
    return int((abs(shown - wanted).max(axis=2) < within).sum())


def settled(page: Page) -> None:
    """Wait until nothing is drawn any more."""
    before = -1
    while (now := page.evaluate("figure.drawn")) != before:
        before = now
        page.wait_for_timeout(150)


@pytest.mark.parametrize("kind", KINDS)
def test_it_plays_fast_and_in_step_with_the_staff(played: Any, kind: str) -> None:
    page = played(kind)
    assert page.evaluate("figure.kind") == kind
    page.evaluate("log.length = 0; player.play()")
    page.wait_for_timeout(2000)
    frames = page.evaluate("(player.pause(), log)")
    assert all(it["figure"] == it["staff"] for it in frames)
    seconds = (frames[-1]["at"] - frames[0]["at"]) / 1000
    assert len(frames) / seconds > LEAST
    played = frames[-1]["staff"] - frames[0]["staff"]
    assert played == pytest.approx(seconds, abs=0.3)
    drawn = np.diff([it["drawn"] for it in frames])
    assert (drawn == 1).all()  # once a frame, though the eye follows


RENDERER = """const ask = WebGL2RenderingContext.prototype.getParameter;
WebGL2RenderingContext.prototype.getParameter = function (name) {
  return name === 37446 ? %r : ask.call(this, name);
}"""


@pytest.mark.parametrize(
    ("renderer", "kind"),
    [
        (
            "ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero)), SwiftShader driver)",
            "canvas",
        ),
        ("llvmpipe, or similar", "canvas"),
        ("ANGLE (Microsoft, Microsoft Basic Render Driver Direct3D11)", "canvas"),
        ("ANGLE (NVIDIA, NVIDIA GeForce RTX 3060 Direct3D11 vs_5_0)", "space"),
        ("ANGLE (Intel, Mesa Intel(R) UHD Graphics 620 (KBL GT2), OpenGL 4.6)", "space"),
    ],
)
def test_a_graphics_card_draws_in_space_and_software_flat(
    played: Any, renderer: str, kind: str
) -> None:
    page = played("")
    page.context.add_init_script(RENDERER % renderer)
    page.evaluate("sessionStorage.clear()")
    page.reload()
    page.wait_for_selector("body[data-ready]")
    assert page.evaluate("figure.kind") == kind


def test_all_that_can_be_shown_plays_in_step_with_the_staff(played: Any) -> None:
    page = played("")
    for name in SHOWN:
        page.get_by_role("button", name=name).click()
    page.evaluate("log.length = 0; player.play()")
    page.wait_for_timeout(2000)
    frames = page.evaluate("(player.pause(), log)")
    assert all(it["figure"] == it["staff"] for it in frames)
    assert len(frames) / (frames[-1]["at"] - frames[0]["at"]) * 1000 > LEAST


@pytest.mark.parametrize("kind", KINDS)
def test_it_draws_only_when_something_changed(played: Any, kind: str) -> None:
    page = played(kind)
    settled(page)
    before = page.evaluate("[figure.drawn, log.length]")
    page.wait_for_timeout(400)
    assert page.evaluate("[figure.drawn, log.length]") == before


@pytest.mark.parametrize("kind", KINDS)
def test_both_kinds_show_the_colours_of_films(played: Any, kind: str) -> None:
    page = played(kind, color_scheme="light")
    settled(page)
    shown = picture(page)
    for color in ("right", "left", "head"):
        assert near(shown, BODY[color]) > 100
    assert near(shown, BODY["lit"]) == 0
    page.evaluate("state.lit = new Set(['l_leg']), player.refresh()")
    settled(page)
    assert near(picture(page), BODY["lit"]) > 100


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_dark_where_the_page_is(played: Any, kind: str) -> None:
    page = played(kind, color_scheme="light")
    settled(page)
    assert np.median(picture(page)) == 255
    page.emulate_media(color_scheme="dark")
    settled(page)
    shown = picture(page)
    assert np.median(shown) < 40
    assert near(shown, "#eceae5") > 100  # bones are light
    assert near(shown, "#5aa9ef") > 100  # --right of the dark style


@pytest.mark.parametrize("kind", KINDS)
def test_keys_and_pointers_turn_it(played: Any, kind: str) -> None:
    page = played(kind)
    settled(page)
    start, first = page.evaluate("figure.eye"), picture(page)
    page.focus("#figure")
    for key in ("ArrowLeft", "ArrowUp", "+"):
        page.keyboard.press(key)
    eye = page.evaluate("figure.eye")
    assert eye["turn"] == start["turn"] + 10
    assert eye["tilt"] == start["tilt"] + 10
    assert eye["zoom"] == pytest.approx(1.15)
    assert page.evaluate("player.seconds") == 0  # these keys are not the player's
    settled(page)
    assert (picture(page) != first).any()
    page.keyboard.press("0")
    assert page.evaluate("figure.eye") == start
    box = page.locator("#figure").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 50, middle[1] + 20)
    page.mouse.up()
    assert page.evaluate("figure.eye")["turn"] == pytest.approx(start["turn"] - 20)
    assert page.evaluate("figure.eye")["tilt"] == pytest.approx(start["tilt"] + 5)
    page.mouse.wheel(0, -100)
    page.wait_for_timeout(100)
    assert page.evaluate("figure.eye")["zoom"] > 1.1


@pytest.mark.parametrize("kind", KINDS)
def test_plan_two_views_and_ghosts_are_shown(played: Any, kind: str) -> None:
    page = played(kind, color_scheme="light")
    page.evaluate("player.seek(3)")
    settled(page)
    plain = picture(page)
    for name in SHOWN:
        page.get_by_role("button", name=name).click()
        settled(page)
        changed = picture(page)
        assert (changed != plain).any(axis=2).mean() > 0.004, name
        assert page.get_by_role("button", name=name).get_attribute("aria-pressed") == "true"
        page.get_by_role("button", name=name).click()
        settled(page)
        assert (picture(page) != plain).any(axis=2).mean() < 0.001, name


def test_the_eye_follows(played: Any) -> None:
    page = played("canvas", color_scheme="light")

    def middle() -> float:
        page.evaluate("player.seek(3)")
        settled(page)
        columns = np.flatnonzero(abs(picture(page) - [154, 154, 154]).max(axis=2).min(axis=0) < 8)
        return float(columns.mean()) / picture(page).shape[1] if len(columns) else 2.0

    assert 0.4 < middle() < 0.6
    page.evaluate("player.seek(0)")
    settled(page)
    page.get_by_role("button", name="Follow").click()
    assert not 0.4 < middle() < 0.6


def test_canvas_is_taken_where_webgl_is_missing(
    played: Any, browser: Browser, address: str
) -> None:
    page = played("space")
    code = (
        "HTMLCanvasElement.prototype.getContext = new Proxy(HTMLCanvasElement.prototype.getContext,"
    )
    code += "{apply: (get, self, [kind, ...rest]) =>"
    code += " kind.startsWith('webgl') ? null : Reflect.apply(get, self, [kind, ...rest])})"
    page.context.add_init_script(code)
    page.reload()
    page.wait_for_selector("body[data-ready]")
    assert page.evaluate("figure.kind") == "canvas"


def test_poses_are_those_of_the_capture(played: Any, walker: Walker) -> None:
    page = played()
    rate = float(walker.body.rate)
    for seconds in (0.0, 1.0, 1.51, 9.99, 10.0, 12.345):
        page.evaluate(f"player.seek({seconds})")
        page.wait_for_timeout(100)
        found = np.array(page.evaluate(f"[...motion.pose({seconds})]"), float).reshape(-1, 3)
        first = int(seconds * rate)
        part = seconds * rate - first
        places = walker.body.places[first : first + 2].astype(float)
        wanted = places[0] + part * (places[-1] - places[0])
        known = ~np.isnan(wanted)
        assert (known == ~np.isnan(found)).all()
        assert abs(found - wanted)[known].max() < 0.6


MADE = """async ({fails}) => {
  const { Motion } = await import('/static/motion.js');
  const asked = [], aborted = [];
  let failing = fails;
  const fetch = (path, { signal }) => new Promise((resolve, reject) => {
    asked.push(path);
    signal.addEventListener('abort', () => { aborted.push(path); reject(signal.reason); });
    const tile = new ArrayBuffer(12 + 2 * 10 * 6);
    new Int16Array(tile, 12).set([1, 2, 3, -32768, -32768, -32768]);
    new Float32Array(tile, 0, 3)[0] = 100;
    setTimeout(() => resolve(new Response(tile, { status: failing ? 500 : 200 })), 20);
  });
  const description = { rate: 1, frames: 100, tile: 10, joints: ['Pelvis', 'Head'], strokes: [] };
  const motion = new Motion('/c', description, fetch, 3);
  const wait = () => new Promise((done) => setTimeout(done, 60));
  %s
}"""


def test_tiles_are_fetched_one_by_one_ahead_and_let_go(played: Any) -> None:
    code = """
  motion.changed = () => { motion.ready(55); };
  for (const at of [2, 15, 25, 35, 55]) motion.ready(at);
  const first = [...asked];
  await wait();
  const then = [...asked];
  await wait();
  const pose = [...motion.pose(55)], ahead = [...asked];
  motion.changed = () => {};
  for (const at of [74, 84, 94]) { motion.ready(at); await wait(); }
  const { held } = motion, gone = motion.pose(55), last = asked.at(-1);
  motion.ready(45); motion.abort();
  return { first, then, ahead, pose, held, gone, last, aborted };"""
    found = played().evaluate(MADE % code, {"fails": False})
    assert found["first"] == ["/c/motion/0"]  # not what was only passed by
    assert found["then"][:2] == ["/c/motion/0", "/c/motion/5"]
    assert found["ahead"] == ["/c/motion/0", "/c/motion/5", "/c/motion/6"]
    assert found["aborted"] == ["/c/motion/4"]
    assert found["held"] == 3
    assert found["gone"] is None
    assert found["last"] == "/c/motion/9"


def test_a_tile_that_cannot_come_is_told_and_asked_for_again(played: Any) -> None:
    code = """
  motion.ready(2); await wait();
  const told = motion.failure(2)?.message, before = asked.length;
  motion.ready(2); motion.ready(2); const after = asked.length;
  failing = false; motion.retry(); motion.ready(2); await wait();
  return { told, before, after, now: motion.failure(2), pose: [...motion.pose(0)] };"""
    found = played().evaluate(MADE % code, {"fails": True})
    assert "500" in found["told"]
    assert found["before"] == found["after"] == 1
    assert found["now"] is None
    assert found["pose"][:3] == [101, 2, 3]
    assert all(np.isnan(it) for it in found["pose"][3:])


def test_figures_that_are_gone_hold_no_part_of_the_graphics_card(played: Any) -> None:
    page, said = played("space"), list[str]()
    page.on("console", lambda it: said.append(it.text))
    page.evaluate("""async () => {
  const { Figure, spaceDrawer } = await import('/static/figure.js');
  for (let number = 0; number < 20; number++) {
    new Figure(document.createElement('canvas'), { space: await spaceDrawer() }).dispose();
  }
}""")
    page.wait_for_timeout(200)
    assert [it for it in said if "Too many active WebGL contexts" in it] == []
    before = page.evaluate("figure.drawn")
    page.evaluate("figure.turn(10, 0)")
    settled(page)
    assert page.evaluate("figure.drawn") > before


def test_a_body_that_is_unknown_at_first_is_shown_once_it_is_known(played: Any) -> None:
    page = played(color_scheme="light")
    settled(page)
    wanted = picture(page)
    page.evaluate("""() => {
  const pose = motion.pose(0), strokes = description.strokes;
  const other = figure.constructor, canvas = figure.canvas.cloneNode();
  figure.canvas.replaceWith(canvas);
  figure.dispose();
  window.figure = new other(canvas, { kind: 'canvas' });
  window.figure.floor = description.floor;
  window.unknown = () => window.figure.show([{ strokes, pose: pose.map(() => NaN) }]);
  window.known = () => window.figure.show([{ strokes, pose }]);
}""")
    page.evaluate("unknown()")
    page.wait_for_timeout(200)
    page.evaluate("known()")
    settled(page)
    assert (picture(page) != wanted).any(axis=2).mean() < 0.02
