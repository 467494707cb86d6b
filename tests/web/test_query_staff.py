"""The staff on which a query is drawn: by keys alone, by the line, and back to text."""

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest
from generated_patterns import random_patterns
from playwright.sync_api import expect

from lanindex.search.dictionary import load
from lanindex.search.language import parse

pytestmark = pytest.mark.slow  # journeys in a browser

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

Opened = Callable[..., "Page"]

DRAWN = """async (patterns) => {
    const { QueryStaff } = await import("/static/query_staff.js");
    const { send, get } = await import("/static/api.js");
    const staff = new QueryStaff({ about: await get("/api/query"), changed: async () => null });
    const found = [];
    for (const text of patterns) {
        const { tree } = await send("POST", "/api/parse", { text });
        staff.show({ text, tree, error: null });
        const drawn = await send("POST", "/api/text", { tree: staff.tree });
        const columns = [...staff.root.querySelectorAll("[role=listbox]")];
        found.push({ text: drawn.text, steps: columns.map((it) => it.children.length) });
    }
    return found;
}"""


def line(page: "Page") -> "Locator":
    return page.get_by_role("textbox", name="What is searched for")


def chosen(page: "Page") -> "Locator":
    """Return the step that is chosen."""
    return page.locator(".q-sheet [aria-selected=true]")


def test_what_is_drawn_says_the_same_as_its_text(opened: Opened) -> None:
    patterns = list(random_patterns(26, 60))
    found = opened("/search").evaluate(DRAWN, patterns)
    for text, drawn in zip(patterns, found, strict=True):
        query = parse(text)
        assert parse(drawn["text"]) == query, text
        first = query.pattern.alternatives[0]
        lines = [first.first, *(it.line for it in first.others)]
        assert sorted(drawn["steps"]) == sorted(len(it.items) for it in lines), text


def test_a_query_is_drawn_by_keys_alone(opened: Opened) -> None:
    page = opened("/search")
    expect(page.get_by_role("listbox", name="right arm")).to_be_visible()  # beside the line
    line(page).press("Tab")
    page.keyboard.press("Tab")
    for key in ("6", "m", "Enter", "h", "c", "Enter", "l"):
        page.keyboard.press(key)
    expect(line(page)).to_have_value("r_arm right mid -> high with l_arm low")
    expect(page.locator(".said")).to_contain_text("the left arm moves low")
    expect(page.locator(".summary")).to_have_text(re.compile(r"\d+ hits? in \d+ captures?"))
    expect(chosen(page)).to_be_focused()
    for text in ("r_arm right mid -> high with l_arm", "r_arm right mid -> high"):
        page.keyboard.press("Control+z")
        expect(line(page)).to_have_value(text)
    page.keyboard.press("Control+Shift+z")
    expect(line(page)).to_have_value("r_arm right mid -> high with l_arm")


def test_the_staff_follows_the_line(opened: Opened) -> None:
    page = opened("/search?draw=1&q=head+left+x2+-%3E+(mid+or+low)+never+r_leg+low+or+l_arm+high")
    head = page.get_by_role("listbox", name="head").get_by_role("option")
    expect(head).to_have_count(2)
    expect(head.nth(1)).to_have_accessible_name("step 2 of 2: locked: (mid or low)")
    expect(page.locator(".q-struck")).to_contain_text("right leg")
    line(page).fill("l_leg forward ... back")
    steps = page.get_by_role("listbox", name="left leg").get_by_role("option")
    expect(steps.nth(1)).to_have_accessible_name("step 2 of 2: back, after a gap")
    line(page).fill("l_leg forward bakc")
    expect(page.locator(".q-note")).to_contain_text("not understood")
    expect(steps).to_have_count(2)  # what was drawn stays
    chosen(page).focus()
    for key in ("9", "Control+z"):
        page.keyboard.press(key)
        expect(page.locator("#status")).to_contain_text("the line is not understood")
        expect(line(page)).to_have_value("l_leg forward bakc")  # nobody's words are taken away
    page.get_by_role("button", name="Write what is drawn").press("Enter")
    expect(line(page)).to_have_value("l_leg forward ... back")
    expect(page.locator(".q-note")).to_have_text("")
    chosen(page).focus()
    page.keyboard.press("Control+z")
    expect(line(page)).to_have_value(re.compile("^head left x2 -> "))


@pytest.mark.slow
def test_keys_go_on_behind_a_press_on_the_palette(opened: Opened) -> None:
    page = opened("/search?draw=1")
    page.get_by_role("button", name="right", exact=True).click()
    page.keyboard.press("h")
    expect(line(page)).to_have_value("r_arm right high")
    for clause, text in [
        ("match.length > 0.1s", "r_arm right high where match.length > 0.1s"),
        (
            "| count by clip.label",
            "r_arm right high where match.length > 0.1s | count by clip.label",
        ),
    ]:
        page.keyboard.press("w")
        page.get_by_role("textbox", name="Clause").fill(clause)
        page.keyboard.press("Enter")
        expect(line(page)).to_have_value(text)
    page.get_by_role("button", name="undo").click()
    expect(line(page)).to_have_value("r_arm right high where match.length > 0.1s")


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        ("n", "r_arm not right -> high"),
        ("/ 4", "r_arm right/left -> high"),
        ("o", "r_arm hold right -> high"),
        ("a", "r_arm any -> high"),
        ("Numpad7", "r_arm l_forward -> high"),
        ("t 1 s Enter", "r_arm right 1s -> high"),
        ("x x 2 Enter", "r_arm right x2 -> high"),
        ("e", "r_arm right -> high either side"),
        ("v l", "r_arm right -> high or r_arm low"),
        ("ArrowUp g", "r_arm right ... high"),
        ("ArrowUp Delete", "r_arm right"),
        ("Delete", "r_arm high"),
        ("Insert 2", "r_arm right -> back -> high"),
        ("c Enter r r", "r_arm right -> high during l_arm"),
        ("Shift+Enter 5", "r_arm place -> right -> high"),
        ("c Enter l Shift+R 1 s Enter", "r_arm right -> high with[1s] l_arm low"),
        ("F2 Control+a h e a d Enter", "head -> r_arm high"),
        ("Alt+ArrowUp", "r_arm high -> right"),
        ("Enter 2 g Alt+ArrowDown Alt+ArrowUp Alt+ArrowUp", "r_arm right ... high -> back"),
    ],
)
def test_each_key_does_what_it_says(opened: Opened, keys: str, text: str) -> None:
    page = opened("/search?draw=1&q=r_arm+right+-%3E+high")
    expect(page.get_by_role("listbox", name="right arm").get_by_role("option")).to_have_count(2)
    chosen(page).focus()
    for key in keys.split():
        page.keyboard.press(key)
    expect(line(page)).to_have_value(text)
    page.get_by_role("button", name="undo").click()
    expect(line(page)).not_to_have_value(text)


def test_a_word_and_brackets_are_unfolded_where_they_can_be_drawn(opened: Opened) -> None:
    page = opened("/search?draw=1&q=@wave")
    expect(page.get_by_role("option", name="step 1 of 1: locked: @wave")).to_be_visible()
    chosen(page).focus()
    page.keyboard.press("u")
    expect(line(page)).to_have_value(re.compile("^r_forearm .* either side$"))
    assert parse(line(page).input_value()) == parse(load()["wave"].pattern)
    expect(page.get_by_role("listbox").first).to_be_visible()
    expect(page.get_by_role("button", name="or 2")).to_be_visible()
    expect(chosen(page)).to_be_focused()
    page.keyboard.press("Control+z")
    expect(line(page)).to_have_value("@wave")
    line(page).fill("r_arm low ... (r_arm mid -> high) -> l_arm low")
    steps = page.get_by_role("listbox", name="right arm").get_by_role("option")
    expect(steps).to_have_count(3)
    chosen(page).focus()
    for key in ("ArrowUp", "u"):
        page.keyboard.press(key)
    expect(line(page)).to_have_value("r_arm low ... r_arm mid -> high -> l_arm low")
    expect(steps).to_have_count(4)
    line(page).fill("r_arm low ... (mid -> high)")
    expect(steps).to_have_count(2)
    chosen(page).press("u")
    expect(line(page)).to_have_value("r_arm low ... mid -> high")
    line(page).fill("r_arm low ... @raise")
    expect(steps).to_have_count(2)
    chosen(page).focus()
    page.keyboard.press("u")
    expect(page.locator("#status")).to_contain_text("@raise cannot be drawn here")
    expect(line(page)).to_have_value("r_arm low ... @raise")


def test_columns_stand_as_on_a_staff_and_the_text_stays(opened: Opened) -> None:
    text = "head high with r_arm right with r_leg low with l_arm left without l_leg low"
    page = opened(f"/search?q={text}")
    expect(page.get_by_role("listbox")).to_have_count(5)
    heads = page.locator(".q-head b")
    assert heads.all_inner_texts() == ["left arm", "left leg", "right leg", "right arm", "head"]
    expect(page.locator(".q-middle .q-head b")).to_have_text("right leg")
    expect(line(page)).to_have_value(text)
    chosen(page).focus()  # the first of the text
    for name in ("right arm", "right leg", "left leg", "left arm", "left arm"):
        page.keyboard.press("ArrowLeft")
        assert name in page.evaluate("document.activeElement.parentElement.ariaLabel")
    page.keyboard.press("h")
    expect(line(page)).to_have_value(text.replace("left", "left high"))


@pytest.mark.parametrize("width", [1100, 1280, 1800, 900])
def test_the_staff_is_beside_the_line_and_hits_where_there_is_room(
    opened: Opened, width: int
) -> None:
    page = opened("/search?q=arms+high", viewport={"width": width, "height": 720})
    page.locator(".hit .poses svg").first.wait_for()
    staff = page.locator(".q-staff")
    if width < 1100:
        page.get_by_text("Draw it").click()
        expect(page).to_have_url(re.compile("draw=1"))
    staff.wait_for()
    boxes = [page.locator(it).first.bounding_box() for it in (".q-staff", ".typed", ".hit")]
    drawn, typed, hit = (it or {} for it in boxes)
    if width < 1100:
        assert drawn["y"] > typed["y"]
        assert hit["y"] > drawn["y"] + drawn["height"]
        return
    for one in (typed, hit):
        assert drawn["x"] >= one["x"] + one["width"]
    assert drawn["y"] + drawn["height"] <= 720  # all of it is seen, as hits are
    assert hit["y"] + hit["height"] <= 720
    page.get_by_text("Draw it").click()
    expect(staff).to_be_hidden()
    expect(page).to_have_url(re.compile("draw=0"))
    page.reload()
    page.locator(".hit").first.wait_for()
    expect(staff).to_be_hidden()


def test_the_mouse_does_it_too(opened: Opened) -> None:
    page = opened("/search?draw=1&q=@wave or r_leg low where match.length > 1s | first 3")
    press = page.locator(".q-staff").get_by_role("button", name=re.compile("")).filter
    expect(page.get_by_role("option", name="step 1 of 1: locked: @wave")).to_be_visible()
    press(has_text="or 2").click()
    expect(page.get_by_role("listbox", name="right leg")).to_be_visible()
    page.locator(".q-pad button").nth(1).click()
    press(has_text="low").filter(has_text="L").click()
    press(has_text="+ step of right leg").click()
    press(has_text="remove first 3").click()
    press(has_text="match.length > 1s").first.click()
    page.get_by_label("condition").fill("match.length > 2s")
    page.get_by_role("button", name="Take").click()
    text = "@wave or r_leg forward -> r_leg where match.length > 2s"
    expect(line(page)).to_have_value(text)
    for _ in range(5):
        press(has_text="undo").click()
    expect(line(page)).to_have_value("@wave or r_leg low where match.length > 1s | first 3")
    press(has_text="undo").click()  # no further than what the page opened with
    expect(page.locator("#status")).to_have_text("nothing to undo")


def test_three_columns_fit_a_phone(opened: Opened) -> None:
    pattern = "r_arm right mid -> (low or mid) x2 with l_arm low/high 1s without r_leg low"
    phone = {"width": 400, "height": 800}
    page = opened(f"/search?draw=1&q={pattern}", viewport=phone)
    expect(page.get_by_role("listbox")).to_have_count(3)
    wide, seen = page.locator(".q-sheet").evaluate("(it) => [it.scrollWidth, it.clientWidth]")
    assert wide == seen


PATTERN = "r_arm right/left not low 1s ... (low or mid) x2 without[1s] l_arm high or head low"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("pattern", ["", "r_arm rigth", f"{PATTERN} either side"])
def test_nothing_keeps_anyone_out(
    opened: Opened, violations: Callable[["Page"], list[str]], scheme: str, pattern: str
) -> None:
    page = opened(f"/search?q={pattern}", color_scheme=scheme, bypass_csp=True)
    page.get_by_role("listbox").first.wait_for()
    page.locator(".hit, .summary:has-text('hits'), .wrong, .ways").first.wait_for()
    assert violations(page) == []
