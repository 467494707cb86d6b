"""Two captures beside each other on the page: in what they differ, and how they play in step."""

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest
from page_client import asking

import lanindex
from lanindex.compare import compare

pytestmark = pytest.mark.slow  # journeys in a browser

if TYPE_CHECKING:
    from playwright.sync_api import Page


@pytest.fixture
def pair(library: lanindex.Library) -> list[int]:
    return [library.capture(f"conductor_{it}.bvh").id for it in ("three", "four")]


def test_differences_are_those_of_the_scores(library: lanindex.Library, pair: list[int]) -> None:
    with asking(library) as ask:
        found = ask.get("/api/compare", params=dict(zip("ab", pair, strict=True))).json()
        wanted = compare(*map(library.score, pair))
        assert [it["capture_id"] for it in found["captures"]] == pair
        assert (found["all"], found["same"]) == (len(wanted.differences), wanted.same)
        assert {it["change"] for it in found["differences"]} == {
            it.change for it in wanted.differences
        }
        starts = [
            min(it[side]["start"] for side in ("one", "other") if it[side])
            for it in found["differences"]
        ]
        assert starts == sorted(starts)
        for number in pair:  # both can be drawn in these columns
            parts = ",".join(found["columns"])
            drawn = ask.get(f"/api/captures/{number}/staff", params={"parts": parts})
            assert drawn.status_code == 200


def test_a_capture_that_is_not_there_is_told(library: lanindex.Library, pair: list[int]) -> None:
    with asking(library) as ask:
        assert ask.get(f"/api/compare?a={pair[0]}&b=999999").status_code == 404
        assert ask.get(f"/api/compare?a={pair[0]}").status_code == 400


def test_two_captures_play_in_step(
    opened: Callable[..., "Page"],
    violations: Callable[["Page"], list[str]],
    library: lanindex.Library,
    pair: list[int],
) -> None:
    page = opened(f"/compare?a={pair[0]}", viewport={"width": 1300, "height": 900})
    three, four = map(library.capture, pair)
    field = page.get_by_role("combobox", name="B")
    assert page.get_by_role("combobox", name="A").input_value() == three.path
    page.wait_for_function("document.activeElement.matches('.picker input')")
    page.keyboard.type("nowhere")
    page.keyboard.press("Enter")
    page.get_by_text("No capture fits nowhere.").wait_for()
    field.fill("conductor_four.bv")
    field.press("Enter")
    page.wait_for_url(f"**/compare?a={pair[0]}&b={pair[1]}")
    page.get_by_text("differences in").first.wait_for()
    assert field.input_value() == four.path
    lines = page.locator(".staff g.differs")
    lines.first.wait_for(state="attached")
    later = page.locator(".differences button").filter(has_text=re.compile(r"^20\.")).first
    later.focus()
    page.keyboard.press("Enter")
    page.locator(".clock", has_text="0:20.").wait_for()
    page.wait_for_url("**&t=20.*")
    assert page.locator(".pair canvas").count() == 2
    way = page.get_by_label("In step")
    way.select_option("by length")
    page.wait_for_url("**&step=length**")
    way.select_option("by movement")
    page.wait_for_url("**&step=movement**")
    seconds = library.in_step(*pair)
    there = page.locator(".differences tr td:nth-child(5) button").filter(
        has_text=re.compile(r"^2\d")
    )
    told = float(there.first.inner_text().partition("\u2013")[0])
    there.first.click()
    wanted = float(np.interp(told, seconds[:, 1], seconds[:, 0]))
    page.wait_for_url(lambda url: abs(float(re.findall(r"&t=([\d.]+)", url)[0]) - wanted) < 0.05)
    page.reload()
    page.get_by_text("differences in").first.wait_for()
    assert way.input_value() == "movement"
    assert violations(page) == []


def test_they_are_in_step_as_the_library_says(library: lanindex.Library, pair: list[int]) -> None:
    with asking(library) as ask:
        told = ask.get("/api/compare/step", params=dict(zip("ab", pair, strict=True))).json()
        assert told["times"] == library.in_step(*pair).T.round(4).tolist()
        assert ask.get(f"/api/compare/step?a={pair[0]}&b=999999").status_code == 404
