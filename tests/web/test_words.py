"""The dictionary on the page: what the server says of words, and the screen."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from page_client import asking

import lanindex
from lanindex.search.dictionary import entries, load

if TYPE_CHECKING:
    from playwright.sync_api import Page

CORPUS = Path(__file__).parents[2] / "corpus"
OWN = 'reach = {pattern = "r_arm forward mid", sentence = "A hand goes forward."}'


@pytest.fixture
def library(corpus_library: Path, tmp_path: Path):
    """Return a copy of the corpus's library with a word of its user's own."""
    shutil.copy(corpus_library, tmp_path / "own.db")
    (tmp_path / "own.toml").write_text(OWN)
    with lanindex.open_library(tmp_path / "own.db", words=tmp_path / "own.toml") as opened:
        yield opened


def test_all_words_are_listed_with_their_figures(library: lanindex.Library) -> None:
    with asking(library) as ask:
        words = {it["name"]: it for it in ask.get("/api/words").json()["words"]}
    assert [*words] == [it.name for it in entries(load(library.words))]
    assert [it["name"] for it in words.values() if it["own"]] == ["reach"]
    assert words["walk"]["precision"] >= 0.8
    assert words["raise_right"]["mirror_image"] == "raise_left"


def test_a_word_is_told_in_english_by_any_of_its_names(library: lanindex.Library) -> None:
    with asking(library) as ask:
        word = ask.get("/api/words/hands up").json()
        assert word["name"] == "hands_up"
        assert word["explained"].startswith("(Both arms together move low")
        assert ask.get("/api/words/reach").json()["own"]
        refused = ask.get("/api/words/jump")
        assert refused.status_code == 400
        assert "try: jump" in refused.json()["error"]["found"]


def test_the_example_of_a_word_is_its_clearest_hit(library: lanindex.Library) -> None:
    with asking(library) as ask:
        (best,) = library.search("raise", best=1)
        hit = ask.get("/api/words/raise/example").json()["hit"]
        assert (hit["capture_id"], hit["start_frame"], hit["end_frame"]) == (
            *(best.capture.id, best.start, best.stop),
        )
        assert hit["words"]
        assert ask.get("/api/words/kneel/example").json() == {"hit": None, "bundled": False}


@pytest.mark.slow
def test_a_choreography_moves_where_the_library_has_nothing(
    own_page: Callable[..., "Page"], tmp_path: Path
) -> None:
    path = tmp_path / "own.db"
    with lanindex.open_library(path, create=True) as library:
        library.ingest(CORPUS / "compass.bvh")
        assert not [*library.search("wave")]
        with asking(library) as ask:
            found = ask.get("/api/words/wave/example").json()
            assert (found["bundled"], Path(found["hit"]["capture"]).parent) == (True, CORPUS)
            figure = f"/api/choreographies/{found['hit']['capture_id']}/figure"
            assert ask.get(figure).json()["frames"] > 100
            assert ask.get("/api/choreographies/99/figure").status_code == 404
    page = own_page(path, "/words?word=wave")
    page.get_by_text(
        "This is a choreography that comes with LanIndex, traffic_police.bvh"
    ).wait_for()
    page.get_by_role("button", name="Pause").wait_for()


def test_an_example_holds_until_the_library_changes(library: lanindex.Library) -> None:
    with asking(library) as ask:
        first = ask.get("/api/words/reach/example").json()["hit"]
        library.remove(first["capture_id"])
        second = ask.get("/api/words/reach/example").json()["hit"]
    assert second["capture_id"] != first["capture_id"]


@pytest.mark.slow
def test_a_word_moves_and_is_searched_for(
    opened: Callable[..., "Page"], violations: Callable[["Page"], list[str]]
) -> None:
    page = opened("/words?word=bow")
    page.get_by_role("heading", name="bow", exact=True).wait_for()
    page.get_by_role("button", name="Pause").wait_for()
    frame, figure = (page.locator(it).bounding_box() for it in (".clip .stage", ".clip canvas"))
    assert frame
    assert figure
    for side in ("width", "height"):
        assert figure[side] == pytest.approx(frame[side], abs=3)
    page.get_by_label("Filter words").fill("hands above")
    links = page.get_by_label("Words", exact=True).get_by_role("link")
    links.first.wait_for()
    assert links.all_inner_texts() == ["hands up"]
    links.first.focus()
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="hands up").wait_for()
    assert "word=hands_up&q=hands+above" in page.url
    search = page.get_by_role("link", name="Search for it")
    assert search.get_attribute("href") == "/search?q=hands_up"
    assert violations(page) == []
