"""What the server answers to the screen Convert, without a browser."""

from typing import Any

import numpy as np
import pytest
from page_client import asking
from starlette.testclient import TestClient

import lanindex
from lanindex.encoding.direction import course, space
from lanindex.pipeline import anew


@pytest.fixture
def library(own_library: lanindex.Library) -> lanindex.Library:
    return own_library


def encoded(ask: TestClient, number: int, **body: Any) -> dict[str, Any]:
    answer = ask.post(f"/api/captures/{number}/encode", json={"parts": ["r_arm"], **body})
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def test_unchanged_numbers_change_no_symbol(ask: TestClient, library: lanindex.Library) -> None:
    for capture in library.captures():
        if capture.format == "lnd":
            answer = ask.post(f"/api/captures/{capture.id}/encode", json={"parts": ["r_arm"]})
            assert answer.status_code == 400
            assert "no movement" in answer.json()["error"]["found"]
            continue
        found = encoded(ask, capture.id, parts=["r_arm", "l_leg", "head"])
        stored = library.score(capture.id).tracks
        shown = sum((~stored[it].symbols["passing"]).sum() for it in ("r_arm", "l_leg", "head"))
        assert (found["changed"], found["same"]) == (0, shown)
        assert found["before"]["svg"].count("<g data-") == found["after"]["svg"].count("<g data-")


def test_an_angle_changes_symbols_and_says_which(
    ask: TestClient, library: lanindex.Library
) -> None:
    number = library.capture("traffic_police.bvh").id
    told = ask.get("/api/profiles/default").json()
    changes = {"spaces": {"r_arm": {**told["spaces"]["r_arm"], "mid": 95, "high": 150}}}
    found = encoded(ask, number, changes=changes, to=10)
    assert found["changed"] > 0
    assert sum(found["kinds"].values()) == found["changed"] == len(found["differences"])
    replaced = next(it for it in found["differences"] if it["kind"] == "replaced")
    assert replaced["before"][0] != replaced["after"][0]
    assert 'class="band"' in found["after"]["svg"] or "#f5a300" in found["after"]["svg"]
    other = encoded(ask, number, changes=changes, parts=["l_arm"])
    assert other["changed"] == 0
    slower = encoded(ask, number, changes={"parameters": {"speed": 30, "rhythm": "3/4"}})
    assert (slower["speed"], slower["rhythm"], slower["changed"]) == (30, "3/4", 0)
    for other_tempo in (slower, encoded(ask, number, changes={"parameters": {"speed": 97}})):
        ends = [[it["ys"][0] - it["ys"][-1]] for it in map(other_tempo.get, ("before", "after"))]
        assert ends[1] == pytest.approx(ends[0], rel=0.01)  # seconds are equally high on both
    without = encoded(ask, number, changes={"rules": {"r_arm": []}})
    assert without["rules"]["r_arm"] == []
    before = encoded(ask, number)["rules"]["r_arm"]
    rows = library.score(number).tracks["r_arm"].symbols
    assert sum(before) == (rows["rule"] > 0).sum() > 0


def test_a_way_lies_in_the_cells_that_the_method_says(
    ask: TestClient, library: lanindex.Library
) -> None:
    capture = library.capture("compass.bvh")
    way = ask.post(f"/api/captures/{capture.id}/way", json={"part": "r_arm", "to": 10}).json()
    profile = lanindex.load_profile()
    (limb,) = anew.curves(library.store, capture, "r_arm", profile)
    around = space(profile.ranges["r_arm"], limb.lengths[0])
    cells = course(limb.curve, [around])[0].cells
    points = np.array(way["points"])[:, [2, 1, 0]] * way["length"]
    again = course(points[None], [around])[0].cells
    frames = np.rint(np.array(way["times"]) * 60).astype(int)
    assert len(frames) == len(points) > 250
    assert np.mean(again == cells[frames]) > 0.995  # on a border, rounding may tell another cell


@pytest.mark.parametrize(
    ("path", "body", "said"),
    [
        ("encode", {"parts": []}, "1 to 8 parts"),
        ("encode", {"parts": ["tail"]}, 'no part "tail"'),
        ("encode", {"parts": ["r_arm"], "profile": "../../etc"}, "no profile"),
        ("encode", {"parts": ["r_arm"], "from": 1e9}, "wanted less than"),
        ("encode", {"parts": ["r_arm"], "zoom": 0}, "0.1 to 10"),
        ("encode", {"parts": ["r_arm"], "changes": {"parameters": {"rate": -1}}}, "0.1 to 1000"),
        ("way", {"part": "r_arm", "from": "x"}, "seconds from 0"),
    ],
)
def test_what_cannot_be_is_refused_with_a_sentence(
    ask: TestClient, library: lanindex.Library, path: str, body: dict[str, Any], said: str
) -> None:
    number = library.capture("compass.bvh").id
    answer = ask.post(f"/api/captures/{number}/{path}", json=body)
    assert answer.status_code in (400, 422)
    error = answer.json()["error"]
    text = f"{error['found']}, wanted {error.get('wanted', '')}"
    assert said in text
    assert "/" not in error.get("place", "").removeprefix("default/")


def test_a_profile_is_saved_beside_the_library(ask: TestClient, library: lanindex.Library) -> None:
    told = ask.get("/api/profiles/paper").json()
    changes = {"spaces": {"head": {**told["spaces"]["head"], "mid": 70}}}
    body = {"name": "low heads", "profile": "paper", "changes": changes}
    saved = ask.post("/api/profiles", json=body).json()
    assert saved["name"] == "low heads"
    read = lanindex.load_profile(saved["folder"])
    assert read.ranges["head"].mid == 70
    assert read.ranges["r_arm"] == lanindex.load_profile("paper").ranges["r_arm"]
    assert ask.get("/api/profiles").json()["profiles"] == ["default", "paper", "low heads"]
    assert ask.get("/api/profiles/low heads").json()["spaces"]["head"]["mid"] == 70
    again = ask.post("/api/profiles", json=body)
    assert again.status_code == 400
    assert ask.post("/api/profiles", json={**body, "replace": True}).status_code == 200
    assert ask.get("/api/profiles/none").status_code == 400


def test_nothing_is_saved_where_a_library_is_only_shown(
    library: lanindex.Library,
) -> None:
    with asking(library, readonly=True) as ask:
        assert ask.post("/api/profiles", json={"name": "mine"}).status_code == 403
        assert ask.post("/api/library/encode", json={"profile": "paper"}).status_code == 403
        assert ask.get("/api/profiles").json()["profiles"] == ["default", "paper"]
