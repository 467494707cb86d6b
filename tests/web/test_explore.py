"""A library as a whole on the page: statistics, motifs, captures that are alike."""

import json
from collections.abc import Callable
from threading import Event
from typing import TYPE_CHECKING, Any

import pytest
from starlette.testclient import TestClient

import lanindex
from lanindex.web.explore import Exploration

if TYPE_CHECKING:
    from playwright.sync_api import Page


def ended(ask: TestClient, **body: Any) -> dict[str, Any]:
    """Return the last state of what is begun."""
    job = ask.post("/api/explore", json=body).json()["job"]
    states = ask.get(f"/api/jobs/{job}/events").text.strip().split("\n\n")
    return json.loads(states[-1].removeprefix("data: "))


def test_motifs_are_patterns_with_as_many_hits(ask: TestClient, library: lanindex.Library) -> None:
    found = ended(ask, what="motifs", path=".bvh", parts=["r_arm"])["found"]
    of = lanindex.Selection("*.bvh*")
    assert found["all"] == len(library.motifs(of, parts=["r_arm"]).found)
    for motif in found["motifs"][:5]:
        assert len(library.search(motif["pattern"], of)) == motif["hits"]
        assert 'data-part="r_arm"' in motif["svg"]


def test_groups_are_those_of_the_library(ask: TestClient, library: lanindex.Library) -> None:
    found = ended(ask, what="similar", where=["format=bvh"])["found"]
    groups = library.similar(lanindex.Selection(where={"format": "bvh"})).groups
    several = [it for it in groups if len(it.captures) > 1]
    assert [[it["capture_id"] for it in one["captures"]] for one in found["groups"]] == [
        [it.id for it in one.captures] for one in several
    ]
    assert found["alone"] == len(groups) - len(several)


def test_two_groups_are_compared(ask: TestClient) -> None:
    pair = ["conducting", "marching"]
    found = ended(ask, what="statistics", by="label", compared=pair, parts=["r_arm"])["found"]
    assert [*found["groups"]] == pair
    conducting, _ = found["moves"]
    assert sum(conducting["cells"].values()) == conducting["movements"] > 0
    assert found["compared"] >= len(found["differences"])


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ({"what": "magic"}, "one of statistics"),
        ({"what": "motifs", "parts": ["wing"]}, "names of parts"),
        ({"what": "motifs", "where": ["label"]}, "column=glob"),
    ],
)
def test_nonsense_is_refused(ask: TestClient, body: dict[str, Any], said: str) -> None:
    refused = ask.post("/api/explore", json=body)
    assert refused.status_code == 400
    assert said in refused.json()["error"]["wanted"]


def test_what_fails_later_is_told_at_the_end(ask: TestClient) -> None:
    state = ended(ask, what="statistics", by="colour")
    assert state["state"] == "failed"
    assert 'no column "colour"' in state["error"]["found"]


def test_the_same_question_is_one_job_until_the_library_changes(ask: TestClient) -> None:
    first, second, other = (
        ask.post("/api/explore", json={"what": "statistics", "path": path}).json()["job"]
        for path in ("a", "a", "b")
    )
    assert first == second != other


def test_what_takes_long_is_broken_off() -> None:
    going = Event()

    def work(progress: Callable[[str, int, int], None]) -> dict[str, Any]:
        for at in range(100_000):
            progress("captures", at, 100_000)
            going.set()
            Event().wait(0.001)
        return {}

    job = Exploration(work)
    assert going.wait(5)
    assert job.told()["state"] == "running"
    job.cancel()
    assert job.wait(5)
    assert job.told()["state"] == "cancelled"
    assert "found" not in job.told()


@pytest.mark.slow
def test_from_a_plot_to_motifs_and_a_search(
    opened: Callable[..., "Page"], violations: Callable[["Page"], list[str]]
) -> None:
    page = opened("/explore?by=label&part=r_arm")
    page.get_by_label("First group").select_option("conducting")
    page.get_by_label("Second group").select_option("marching")
    page.get_by_text("differences matter").wait_for()
    assert "compare=conducting&compare=marching" in page.url
    assert page.get_by_role("img", name="right arm, conducting").count() == 1
    assert page.locator("svg.rates text").all_text_contents()[1:3] == ["beginning", "end"]
    titles = page.locator("svg.cells title").all_text_contents()
    assert any(it.startswith("right forward mid: ") for it in titles)
    assert violations(page) == []
    page.get_by_role("link", name="Motifs").focus()
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Explore").click()
    first = page.locator(".motifs a code").first
    first.wait_for()
    assert "what=motifs" in page.url
    address = page.locator(".motifs a").first.get_attribute("href")
    assert address.startswith("/search?q=r_arm")
    assert violations(page) == []


@pytest.mark.slow
def test_captures_that_are_alike_are_shown(
    opened: Callable[..., "Page"], violations: Callable[["Page"], list[str]]
) -> None:
    page = opened("/explore?what=similar&run=true", color_scheme="dark")
    page.locator(".alike .pose svg").first.wait_for()
    assert page.get_by_role("link", name="compare", exact=True).first.get_attribute("href")
    assert violations(page) == []
