"""What the server answers, without a browser."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from time import monotonic, sleep
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from page_client import asking
from starlette.testclient import TestClient

import lanindex
from lanindex.errors import LanindexError
from lanindex.search.limits import tick
from lanindex.search.match.finder import Finder
from lanindex.web import watch


@pytest.fixture(params=["sqlite", pytest.param("postgres", marks=pytest.mark.slow)])
def library(request: pytest.FixtureRequest) -> Iterator[lanindex.Library]:
    if request.param == "sqlite":
        yield request.getfixturevalue("own_library")
        return
    with lanindex.open_library(request.getfixturevalue("own_address")) as opened:
        yield opened


def test_the_library_is_described(ask: TestClient, library: lanindex.Library) -> None:
    about = ask.get("/api/library").json()
    assert about["name"] == "own"
    assert about["captures"] == len(library.captures())
    assert set(about["parts"]) <= set(library.parts())
    assert "r_arm" in about["parts"]
    assert {it: about["names"][it] for it in ("r_arm_bend", "body_travel", "l_back")} == {
        "r_arm_bend": "right arm bend",
        "body_travel": "travel",
        "l_back": "left back",
    }
    assert not any("_" in about["names"][part] for part in about["parts"])
    assert not about["readonly"]


def test_a_hit_is_told_in_words_and_as_tall_as_its_poses(ask: TestClient) -> None:
    job = ask.post("/api/searches", json={"pattern": "r_forearm r_forward high"}).json()["job"]
    assert '"state":"done"' in ask.get(f"/api/jobs/{job}/events").text
    card = ask.get(f"/api/searches/{job}/hits/0/card").json()
    assert card["words"] == "right forearm right forward high"
    assert 1500 < card["tall"] < 6000  # mm
    staff = ElementTree.fromstring(card["staff"])
    texts = staff.iter("{http://www.w3.org/2000/svg}text")
    (name,) = (it for it in texts if it.text == "forearm")
    assert float(name.get("y", 0)) > float(staff.get("viewBox", "").split()[3])  # it is cut


def test_captures_are_filtered_counted_and_sorted(ask: TestClient) -> None:
    every = ask.get("/api/captures").json()
    assert every["total"] == every["all"] == len(every["captures"])
    some = ask.get("/api/captures", params={"where": "label=conducting", "sort": "-length"}).json()
    assert [it["label"] for it in some["captures"]] == ["conducting"] * 4
    assert some["captures"][0]["seconds"] >= some["captures"][1]["seconds"]
    assert some["folder"] + "compass.bvh" in {it["capture"] for it in every["captures"]}
    named = ask.get("/api/captures", params={"q": "GREET"}).json()
    assert ["greetings" in it["capture"] for it in named["captures"]] == [True] * named["total"]
    page = ask.get("/api/captures", params={"at": 2, "n": 3}).json()
    assert page["captures"] == every["captures"][2:5]
    assert ask.get("/api/captures", params={"n": -1}).status_code == 400
    assert ask.get("/api/captures", params={"sort": "-weight"}).status_code == 400


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("compass.bvh", "compass.bvh"),  # the name of a file
        ("PASS.B", "compass.bvh"),  # a part of one path alone
        ("compass", ""),  # of two
        ("conductor_f bvh", "conductor_four.bvh"),  # words
        ("bvh", ""),
        ("zzz", ""),
    ],
)
def test_a_text_means_the_one_capture_that_fits_it(ask: TestClient, text: str, meant: str) -> None:
    found = ask.get("/api/captures/fitting", params={"q": text}).json()
    names = {it["capture_id"]: Path(it["capture"]).name for it in found["captures"]}
    assert names.get(found["one"], "") == meant
    assert (found["total"] == 0) == (text == "zzz")


def test_what_has_no_movement_is_not_offered_where_one_is_needed(ask: TestClient) -> None:
    every, moving = (
        ask.get("/api/captures/fitting", params={"q": "compass", **wanted}).json()
        for wanted in ({}, {"moving": "true"})
    )
    assert {Path(it["capture"]).name for it in every["captures"]} == {"compass.bvh", "compass.lnd"}
    assert [Path(it["capture"]).name for it in moving["captures"]] == ["compass.bvh"]
    assert moving["one"] == moving["captures"][0]["capture_id"]
    for it in every["captures"]:
        one = ask.get(f"/api/captures/{it['capture_id']}").json()
        assert one["moves"] == it["capture"].endswith(".bvh")


def test_a_facet_counts_what_each_of_its_values_would_find(ask: TestClient) -> None:
    def facet(name: str, *where: str) -> dict[str, int]:
        facets = ask.get("/api/captures", params={"where": where}).json()["facets"]
        return next(dict(it["values"]) for it in facets if it["name"] == name)

    every = facet("label")
    assert every["conducting"] == 4
    assert facet("label", "label=conducting") == every
    assert facet("format", "label=conducting") == {"bvh": 2, "lnd": 2}
    assert facet("label", "label=conducting", "format=none") == {}
    some = {"where": ["label=conducting", "label=marching"]}
    assert ask.get("/api/captures", params=some).json()["total"] == 4 + every["marching"]
    numbers = ask.get("/api/captures/numbers", params=some).json()["captures"]
    assert len(numbers) == 4 + every["marching"]


def test_labels_are_changed_and_captures_removed(
    ask: TestClient, library: lanindex.Library
) -> None:
    number = library.capture("compass.bvh").id
    change = {"captures": [number], "label": "<b>rose</b>", "columns": {"year": "1928"}}
    done = ask.patch("/api/captures", json={"changes": [change]}).json()
    assert done["changed"] == 1
    assert library.capture(number).label == "<b>rose</b>"
    assert library.capture(number).metadata["year"] == "1928"
    for wrong in ({"label": 3}, {"columns": {"": "x"}}, {"columns": {"year": 3}}):
        change = {"changes": [{"captures": [number], **wrong}]}
        assert ask.patch("/api/captures", json=change).status_code == 400
    assert ask.patch("/api/captures", json={"changes": done["undo"]}).json()["changed"] == 1
    assert library.capture(number).label == "compass"
    assert "year" not in library.capture(number).metadata
    assert ask.post("/api/captures/remove", json={"captures": [number]}).status_code == 200
    assert ask.get(f"/api/captures/{number}").status_code == 404
    listed = ask.get("/api/captures").json()["captures"]
    assert number not in [it["capture_id"] for it in listed]


def test_an_undo_leaves_what_somebody_else_has_changed(
    ask: TestClient, library: lanindex.Library
) -> None:
    number = library.capture("compass.bvh").id
    ours = {"captures": [number], "label": "ours", "columns": {"year": "1928"}}
    undo = ask.patch("/api/captures", json={"changes": [ours]}).json()["undo"]
    theirs = {"captures": [number], "label": "theirs"}
    ask.patch("/api/captures", json={"changes": [theirs]})
    answer = ask.patch("/api/captures", json={"changes": undo})
    assert answer.status_code == 400
    assert "changed by somebody else" in answer.json()["error"]["found"]
    assert library.capture(number).label == "theirs"
    ask.patch("/api/captures", json={"changes": [{**theirs, "label": "ours"}]})
    assert ask.patch("/api/captures", json={"changes": undo}).json()["changed"] == 1
    assert library.capture(number).label == "compass"


@pytest.mark.parametrize("name", ["a=b", "path", "label", "folder", " format"])
def test_a_column_has_a_name_that_can_be_filtered_for(
    ask: TestClient, library: lanindex.Library, name: str
) -> None:
    change = {"captures": [library.capture("compass.bvh").id], "columns": {name: "x"}}
    answer = ask.patch("/api/captures", json={"changes": [change]})
    assert answer.status_code == 400
    assert name.strip() in answer.json()["error"]["found"]
    assert name.strip() not in library.capture("compass.bvh").metadata


def test_many_are_changed_at_once_or_none_and_undone_at_once(
    ask: TestClient, library: lanindex.Library
) -> None:
    before = {it.id: (it.label, dict(it.metadata)) for it in library.captures()}
    assert len({label for label, _ in before.values()}) > 2
    every = {"captures": list(before), "label": "all", "columns": {"set": "1"}}
    gone = {"captures": [*before, 10_000], "label": "none"}
    assert ask.patch("/api/captures", json={"changes": [gone]}).status_code == 404
    assert {it.id: (it.label, dict(it.metadata)) for it in library.captures()} == before
    stamp = library.stamp
    done = ask.patch("/api/captures", json={"changes": [every]}).json()
    assert done["changed"] == len(before)
    assert library.stamp == stamp + 1
    listed = ask.get("/api/captures").json()
    assert {it["label"] for it in listed["captures"]} == {"all"}
    assert [it["name"] for it in listed["facets"]][-1] == "set"
    ask.patch("/api/captures", json={"changes": done["undo"]})
    assert {it.id: (it.label, dict(it.metadata)) for it in library.captures()} == before


def test_a_change_by_another_is_listed_too(ask: TestClient, library: lanindex.Library) -> None:
    first, second = (it.id for it in library.captures()[:2])
    ask.get("/api/captures")
    with lanindex.open_library(library.store.session.target.name) as other:
        other.label(second, "theirs")
    change = {"changes": [{"captures": [first], "label": "ours"}]}
    ask.patch("/api/captures", json=change)
    listed = ask.get("/api/captures").json()["captures"]
    assert [it["label"] for it in listed[:2]] == ["ours", "theirs"]


def test_captures_whose_files_are_gone_are_told(tmp_path: Path) -> None:
    names = ["compass.bvh", "greetings.bvh"]
    for name in names:
        shutil.copy(Path(__file__).parents[2] / "corpus" / name, tmp_path / name)
    with lanindex.open_library(tmp_path / "own.db", create=True) as library:
        library.ingest(*(tmp_path / name for name in names))
        (tmp_path / names[1]).unlink()
        with asking(library, readonly=True) as ask:
            wanted = {"captures": [library.capture(names[1]).id]}
            assert ask.get("/api/captures/missing").json() == wanted


def test_nothing_is_changed_where_a_library_is_only_shown(corpus_library: Path) -> None:
    before = corpus_library.read_bytes()
    with (
        lanindex.open_library(corpus_library, readonly=True) as library,
        asking(library, readonly=True) as ask,
    ):
        for answer in (
            ask.patch("/api/captures", json={"changes": [{"captures": [1], "label": "x"}]}),
            ask.post("/api/captures/remove", json={"captures": [1]}),
            ask.put("/api/uploads/x.bvh", content=b"HIERARCHY"),
        ):
            assert answer.status_code == 403
            assert "only shown" in answer.json()["error"]["found"]
    assert corpus_library.read_bytes() == before


def test_tiles_are_the_movement(ask: TestClient, library: lanindex.Library) -> None:
    number = library.capture("conductor_four.bvh").id
    about = ask.get(f"/api/captures/{number}/figure").json()
    whole = library.motion(number, fps=60)
    assert about["frames"] == len(whole)
    parts = []
    for tile in range(-(-about["frames"] // about["tile"])):
        data = ask.get(f"/api/captures/{number}/motion/{tile}").content
        origin = np.frombuffer(data, "<f4", 3)
        parts.append(np.frombuffer(data, "<i2", offset=12).reshape(-1, 21, 3) + origin)
    places = np.concatenate(parts)
    assert places.shape == whole.places.shape
    assert np.abs(places - whole.places).max() <= 0.51
    assert ask.get(f"/api/captures/{number}/motion/999").status_code == 400


def test_pieces_of_a_staff_that_are_drawn_are_answered(
    ask: TestClient, library: lanindex.Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    number, asked = library.capture("conductor_four.bvh").id, list[Any]()

    def piece(store: Any, *window: Any, begin: bool) -> bytes | None:
        asked.append((*window, begin))
        return None if len(asked) == 1 else b'{"svg":"<svg/>"}'

    monkeypatch.setattr(watch, "piece", piece)
    path = f"/api/captures/{number}/staff?from=0&to=2&zoom=2&parts=r_arm"
    assert ask.get(path).json()["times"] == [0, 2]
    assert ask.get(path).json() == {"svg": "<svg/>"}
    assert ask.get(f"{path}&early=1").json() == {"svg": "<svg/>"}
    assert asked == [(number, 0, 2, ["r_arm"], 2, it) for it in (True, True, False)]


def test_every_capture_has_a_pose(ask: TestClient, library: lanindex.Library) -> None:
    for capture in library.captures():
        picture = ask.get(f"/api/captures/{capture.id}/pose")
        assert picture.headers["content-type"] == "image/svg+xml"
        assert picture.text.startswith("<svg")


def test_a_pose_is_one_that_is_known() -> None:
    body = SimpleNamespace(places=np.zeros((3, 21, 3), np.float32))
    body.places[1] = np.nan
    body.places[2, 4:, 1] = 500
    assert watch._unlike(body) == [2]  # type: ignore[arg-type]
    body.places[:] = np.nan
    with pytest.raises(LanindexError, match="nothing of the body"):
        watch._unlike(body)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "kept"),
    [
        ("walk.bvh", "walk.bvh"),
        ("a/%2E%2E/%2E%2E/walk.bvh", "a/walk.bvh"),
        ("..%2F..%2Fetc%2Fpasswd", "etc/passwd"),
        ("C:%5Cx%5Cy.c3d", "C_/x/y.c3d"),
        ("%3Cscript%3E.bvh", "_script_.bvh"),
        (".profile", "profile"),
        ("con.bvh", "_con.bvh"),
    ],
)
def test_what_is_sent_is_kept_below_one_folder(
    ask: TestClient, library: lanindex.Library, name: str, kept: str
) -> None:
    folder = library.store.session.target.beside("captures")
    answer = ask.put(f"/api/uploads/{name}", content=b"some bytes")
    assert answer.json() == {"name": kept}
    assert (folder / kept).read_bytes() == b"some bytes"
    assert ask.put(f"/api/uploads/{name}", content=b"some bytes").json() == {"name": kept}
    other = ask.put(f"/api/uploads/{name}", content=b"other bytes").json()["name"]
    assert other != kept
    assert {it.name for it in folder.parent.iterdir()} - {"own.db"} == {folder.name}


def test_a_link_does_not_lead_out_of_the_folder(
    ask: TestClient, library: lanindex.Library, tmp_path: Path
) -> None:
    folder = library.store.session.target.beside("captures")
    ask.put("/api/uploads/a.bvh", content=b"1")
    (tmp_path / "outside").mkdir()
    (folder / "away").symlink_to(tmp_path / "outside")
    (folder / "b.bvh").symlink_to(__file__)
    assert ask.put("/api/uploads/away/x.bvh", content=b"1").status_code == 400
    assert ask.put("/api/uploads/b.bvh", content=b"1").json() == {"name": "b 2.bvh"}
    assert list((tmp_path / "outside").iterdir()) == []


def test_too_much_is_refused_before_it_is_read(ask: TestClient, tmp_path: Path) -> None:
    headers = {"content-length": str(10 << 30)}
    answer = ask.put("/api/uploads/big.bvh", content=iter([b"x" * 10]), headers=headers)
    assert answer.status_code == 400
    assert "too long" in answer.json()["error"]["found"]
    assert ask.post("/api/captures/remove", content=b" " * (2 << 20)).status_code == 400
    assert not list(tmp_path.rglob("*.part"))


@pytest.mark.parametrize("path", ["/../server.py", "/%2e%2e/server.py", "/vendor/../../server.py"])
def test_no_path_leads_out_of_the_page(ask: TestClient, path: str) -> None:
    assert ask.get(f"/static{path}").status_code == 404


def test_a_search_in_one_large_capture_tells_that_it_goes_on(
    ask: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = Finder._in_batch

    def slow(finder: Finder, places: Any) -> Any:
        until = monotonic() + 1.2
        while monotonic() < until:
            sleep(0.05)
            tick()
        return search(finder, places)

    monkeypatch.setattr(Finder, "_in_batch", slow)
    job = ask.post("/api/searches", json={"pattern": "r_arm low -> any -> low"}).json()["job"]
    events = ask.get(f"/api/jobs/{job}/events").text
    told = [json.loads(it[6:]) for it in events.splitlines() if it.startswith("data: ")]
    assert len({it["seconds"] for it in told if not it["found"]}) > 4
