"""A printed score is opened beside its picture, checked, mended, and saved."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from time import sleep
from typing import TYPE_CHECKING

import command
import numpy as np
import pytest
from page_client import asking, serving
from starlette.testclient import TestClient

import lanindex
from lanindex.web import printed

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

cv2 = pytest.importorskip("cv2")

from printed_page import clean, scribbled  # noqa: E402

from lanindex.reader.staff import staves  # noqa: E402


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a page on which a sign is not known, and what is read of it."""
    folder = tmp_path_factory.mktemp("printed")
    cv2.imwrite(str(folder / "page.png"), scribbled())
    assert command.run("read-score", "page.png", cwd=folder).returncode == 1
    return folder


@pytest.fixture
def library(tmp_path: Path) -> Iterator[lanindex.Library]:
    with lanindex.open_library(tmp_path / "own.db", create=True) as opened:
        yield opened


def test_what_is_opened_is_what_read_score_writes(folder: Path, library: lanindex.Library) -> None:
    library.ingest(folder / "page.png")
    ask = asking(library, readonly=True)
    sent = ask.post("/api/scores/printed?name=page.png", content=(folder / "page.png").read_bytes())
    opened = ask.get("/api/scores/captures/1/printed").json()
    assert sent.json() == {**opened, "title": "page.png"}
    saved = ask.post("/api/scores/save", json={"score": opened["score"], "format": "lnd"})
    assert saved.content == (folder / "page.lnd").read_bytes()
    stored = ask.get("/api/scores/captures/1").json()
    assert stored["score"] == opened["score"]


def test_every_symbol_has_its_box(folder: Path, library: lanindex.Library) -> None:
    sent = (folder / "page.png").read_bytes()
    found = asking(library).post("/api/scores/printed", content=sent).json()
    known = {
        (it["part"], it["start"], it["stop"]) for it in found["signs"] if it["kind"] != "unknown"
    }
    assert {tuple(it[:3]) for it in found["score"]["symbols"]} == known
    assert [it["part"] for it in found["signs"] if it["kind"] == "unknown"] == ["l_arm"]
    (page,) = found["pages"]
    for sign in found["signs"]:
        left, top, right, bottom = sign["box"]
        assert 0 <= left < right <= page["width"]
        assert 0 <= top < bottom <= page["height"]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"no picture", "not a picture that can be read"),
        (cv2.imencode(".png", np.full((300, 300), 255, np.uint8))[1].tobytes(), "no staff"),
        (b"", "an empty file"),
    ],
)
def test_what_is_no_score_is_told(library: lanindex.Library, content: bytes, said: str) -> None:
    answer = asking(library).post("/api/scores/printed?name=x.png", content=content)
    assert answer.status_code == 422
    error = answer.json()["error"]
    assert said in error["found"]
    assert error["place"] == "x.png"


def test_limits(
    folder: Path, library: lanindex.Library, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    ask, white = asking(library), np.full((90, 90), 255, np.uint8)
    cv2.imwritemulti(str(tmp_path / "long.tiff"), [white] * (printed.PAGES + 1))
    answer = ask.post("/api/scores/printed", content=(tmp_path / "long.tiff").read_bytes())
    assert (answer.status_code, answer.json()["error"]["found"]) == (400, "21 pages")
    monkeypatch.setattr(printed, "LARGEST", 100)
    answer = ask.post("/api/scores/printed", content=(folder / "page.png").read_bytes())
    assert answer.json()["error"]["found"] == "a request that is too long"


def test_a_page_without_a_sign_that_is_known_is_opened(library: lanindex.Library) -> None:
    page = cv2.imencode(".png", clean())[1].tobytes()
    ask: TestClient = asking(library)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lanindex.reader.signs._SURE", 2.0)
        patch.setattr("lanindex.reader.outlines._LIKE", 2.0)
        found = ask.post("/api/scores/printed", content=page).json()
    assert (found["score"]["symbols"], found["score"]["beats"]) == ([], 4)
    assert {it["kind"] for it in found["signs"]} == {"unknown"}
    assert ask.post("/api/scores/draw", json={"score": found["score"]}).status_code == 200


def test_what_is_not_known_of_pages_is_told(library: lanindex.Library, tmp_path: Path) -> None:
    (staff,), unnamed = staves(clean()), clean().copy()
    unnamed[round(staff.foot) :] = 255
    white = np.full((90, 90), 255, np.uint8)
    cv2.imwritemulti(str(tmp_path / "pages.tiff"), [unnamed, white])
    sent = (tmp_path / "pages.tiff").read_bytes()
    found = asking(library).post("/api/scores/printed", content=sent).json()
    assert found["notes"] == [
        "page 1: no names of columns, taken by their places for r_arm l_arm",
        "page 2: no staff of Labanotation, left out",
    ]


def test_a_picture_that_has_changed_is_told(library: lanindex.Library, tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "page.png"), clean())
    library.ingest(tmp_path / "page.png")
    cv2.imwrite(str(tmp_path / "page.png"), scribbled())
    error = asking(library).get("/api/scores/captures/1/printed").json()["error"]
    assert error["found"] == "has changed since it was ingested"


def test_a_picture_that_is_sent_is_ingested(folder: Path, library: lanindex.Library) -> None:
    with asking(library) as ask:
        page = (folder / "page.png").read_bytes()
        kept = ask.put("/api/uploads/page.png", content=page).json()["name"]
        job = ask.post("/api/ingests", json={"files": {"page.png": kept}}).json()["job"]
        while (told := ask.get(f"/api/ingests/{job}").json())["state"] == "running":
            sleep(0.05)
    (outcome,) = told["outcomes"]
    assert (outcome["name"], outcome["status"]) == ("page.png", "added")
    assert outcome["doubts"] == ["page 1, staff 1, l_arm, count 4 to 6: not known, left out"]


@pytest.mark.slow
def test_a_picture_is_checked_beside_its_score(
    own_page: Callable[..., Page],
    violations: Callable[[Page], list[str]],
    folder: Path,
    tmp_path: Path,
) -> None:
    from playwright.sync_api import Route, expect

    path = tmp_path / "own.db"
    with lanindex.open_library(path, create=True):
        pass
    page = own_page(path, "/edit", accept_downloads=True, bypass_csp=True)
    page.wait_for_selector(".edit-drawn svg")

    def doubted(route: Route) -> None:
        found = route.fetch().json()
        found["signs"][-2]["kind"] = "doubtful"
        found["signs"].append({**found["signs"][-1], "part": "column 5"})
        found["notes"].append("page 2: no staff of Labanotation, left out")
        route.fulfill(json=found)

    page.route("**/api/scores/printed?*", doubted)
    page.set_input_files("input[type=file]", folder / "page.png")
    page.wait_for_selector(".edit-picture svg")
    with page.expect_download() as coming:
        page.get_by_role("button", name="Save").click()
    coming.value.save_as(tmp_path / "page.lnd")
    assert (tmp_path / "page.lnd").read_bytes() == (folder / "page.lnd").read_bytes()

    state, chosen = page.locator(".edit-state"), page.locator("rect.edit-seen-chosen")
    checks = page.get_by_role("region", name="To be checked")
    expect(checks.locator("h2")).to_have_text("To be checked: 2 signs not known, 1 doubtful")
    expect(checks.get_by_role("listitem")).to_have_text(
        "page 2: no staff of Labanotation, left out"
    )
    expect(page.locator(".edit-gap")).to_have_count(1)
    expect(page.locator(".edit-doubtful")).to_have_count(1)
    assert violations(page) == []
    checks.get_by_role("button", name="column 5, bar 2 beat 1: not known").click()
    expect(state).to_contain_text("Its column has no name that is known")
    expect(chosen).to_have_class("edit-seen-unknown edit-seen-chosen")
    checks.get_by_role("button", name="left arm, bar 2 beat 1: not known").click()
    expect(state).to_have_text("left arm, bar 2 beat 1, not known")
    expect(chosen).to_have_class("edit-seen-unknown edit-seen-chosen")
    page.keyboard.press("8")
    expect(state).to_have_text("left arm, forward mid, bar 2 beat 1, 2 beats")
    expect(checks.locator("h2")).to_have_text("To be checked: 1 sign not known, 1 doubtful")

    page.locator(".edit-picture rect.edit-seen-known").last.click()
    expect(state).to_have_text("left arm, left high, bar 1 beat 1, 4 beats")
    expect(chosen).to_have_class("edit-seen-known edit-seen-chosen")
    page.keyboard.press("l")
    expect(state).to_have_text("left arm, left low, bar 1 beat 1, 4 beats")
    expect(chosen).to_have_count(1)  # it is still the sign that it was

    checks.get_by_role("button", name="It is right").click()
    checks.get_by_role("button", name="Leave out").click()
    expect(checks.get_by_role("button", name="Check off all")).to_be_hidden()
    expect(checks.locator("h2")).to_have_text("All is checked")
    expect(page.locator(".edit-doubtful")).to_have_count(0)
    page.get_by_role("button", name="New").click()
    page.get_by_role("button", name="Begin a new one").click()
    expect(page.locator(".edit-picture")).to_have_count(0)


@pytest.mark.slow
def test_a_capture_is_opened_beside_its_picture(
    browser: Browser, folder: Path, tmp_path: Path
) -> None:
    from playwright.sync_api import expect

    path = tmp_path / "own.db"
    with lanindex.open_library(path, create=True) as library:
        library.ingest(folder / "page.png")
    (tmp_path / "none.png").write_text("no picture")
    with serving(path) as link:
        page = browser.new_context().new_page()  # a request that is refused is told in its console
        page.goto(link)
        page.goto(f"{link.partition('/?')[0]}/edit?capture=1")
        expect(page.locator(".edit-picture rect")).to_have_count(6)
        expect(page.locator(".edit-gap")).to_have_count(1)
        page.get_by_role("button", name="Check off all").click()
        expect(page.locator(".edit-gap")).to_have_count(0)
        page.reload()
        expect(page.locator(".edit-picture rect")).to_have_count(6)
        expect(page.get_by_text("All is checked")).to_be_visible()
        page.set_input_files("input[type=file]", tmp_path / "none.png")
        alert = page.get_by_role("alert")
        expect(alert).to_contain_text("none.png: not a picture that can be read")
        expect(alert.locator("p")).to_have_count(2)
        expect(page.locator(".edit-picture rect")).to_have_count(6)
        page.context.close()
