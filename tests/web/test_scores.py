"""What the editor of scores is answered, without a browser."""

from base64 import b64decode
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from page_client import asking
from starlette.testclient import TestClient

import lanindex
from lanindex.alphabet import KINDS, TRACKS, kind_of
from lanindex.notation import NOTATIONS, WRITTEN, edited, lnd, read, write

CORPUS = Path(__file__).parent.parent.parent / "corpus"


@pytest.fixture
def library(tmp_path: Path) -> Iterator[lanindex.Library]:
    with lanindex.open_library(tmp_path / "own.db", create=True) as opened:
        opened.ingest(CORPUS / "jumping_jacks.bvh", CORPUS / "compass.bvh")
        yield opened


def score(name: str = "compass") -> dict[str, object]:
    return edited.of_score(lanindex.read_lnd(CORPUS / f"{name}.lnd"))


EMPTY = score() | {"symbols": []}


def test_the_alphabet_has_every_track_with_its_words(ask: TestClient) -> None:
    found = ask.get("/api/scores/alphabet").json()
    written = [it for it in TRACKS if KINDS[kind_of(it)].keyword]
    assert [it["part"] for it in found["tracks"]] == written
    for track in found["tracks"]:
        fields = lnd.fields_of(track["part"])
        assert {it["name"]: [*fields[it["name"]]] for it in track["fields"]} == {
            it["name"]: it["words"] for it in track["fields"]
        }
        assert track["drawn"]
    assert found["mirrored"]["r_forward"] == "l_forward"
    assert len(found["signs"]["gesture"]) == 27
    assert [it["name"] for it in found["notations"]] == [*WRITTEN]


def test_a_capture_is_opened_whole_or_in_part(ask: TestClient, library: lanindex.Library) -> None:
    capture = library.capture("compass.bvh")
    full = ask.get(f"/api/scores/captures/{capture.id}?detail=full").json()
    assert full["score"] == edited.of_score(library.score(capture.id))
    whole = ask.get(f"/api/scores/captures/{capture.id}").json()
    assert "r_forearm" in whole["left_out"]
    assert whole["score"]["symbols"] == [
        it for it in full["score"]["symbols"] if it[0] not in whole["left_out"]
    ]
    part = ask.get(f"/api/scores/captures/{capture.id}", params={"from": 4, "to": 8}).json()
    assert 0 < len(part["score"]["symbols"]) < len(whole["score"]["symbols"])
    assert part["score"]["units"] == 1
    assert ask.get(f"/api/scores/captures/{capture.id}?from=8&to=4").status_code == 400
    assert ask.get("/api/scores/captures/99").status_code == 404


def test_files_are_read_in_their_notation(ask: TestClient) -> None:
    text = (CORPUS / "compass.lnd").read_text()
    found = ask.post("/api/scores/read", json={"name": "compass.lnd", "text": text}).json()
    assert found["score"] == score()
    broken = ask.post("/api/scores/read", json={"name": "x.lnd", "text": "#unit1\ndirecton r_arm"})
    assert broken.json()["error"]["place"] == "x.lnd:2"


def test_a_staff_is_drawn_by_beats_with_empty_columns(ask: TestClient) -> None:
    asked = {"score": score(), "parts": ["r_arm", "l_arm", "jump"], "scale": 2}
    whole = ask.post("/api/scores/draw", json=asked).json()
    assert whole["beats"] == 28
    assert whole["beat"] == 112
    assert [*whole["columns"]] == ["r_arm", "l_arm"]
    assert whole["seconds"][:3] == [0, 1, 2]
    assert 'data-symbol="r_arm.1"' in whole["svg"]
    assert whole["foot"] > 0
    window = ask.post("/api/scores/draw", json=asked | {"from": 8, "to": 12}).json()
    assert (window["from"], window["to"], window["foot"]) == (8, 12, 0)
    assert 'data-symbol="r_arm.1"' not in window["svg"]
    empty = ask.post("/api/scores/draw", json=asked | {"score": EMPTY}).json()
    assert "data-symbol" not in empty["svg"]
    assert ask.post("/api/scores/draw", json=asked | {"scale": "2"}).status_code == 400


def test_the_figure_carries_out_all_or_some_seconds(ask: TestClient) -> None:
    asked = {"score": score()}
    whole = ask.post("/api/scores/motion", json=asked).json()
    part = ask.post("/api/scores/motion", json=asked | {"from": 8, "to": 10}).json()
    assert (whole["start"], whole["stop"], whole["seconds"]) == (0, 28, 28)
    assert (part["start"], part["figure"]["frames"]) == (8, 60)
    for clip in (whole, part):
        data = np.frombuffer(b64decode(clip["places"]), "<i2", offset=12)
        assert data.size == clip["figure"]["frames"] * 21 * 3
        assert (clip["figure"]["tile"], clip["warnings"]) == (clip["figure"]["frames"], [])
    assert ask.post("/api/scores/motion", json={"score": EMPTY}).status_code == 200


@pytest.mark.parametrize("name", WRITTEN)
def test_a_score_is_saved_in_every_notation(ask: TestClient, name: str) -> None:
    answer = ask.post("/api/scores/save", json={"score": score(), "format": name, "name": "ä/b c"})
    assert answer.status_code == 200
    suffix = NOTATIONS[name].suffix
    assert answer.headers["content-disposition"] == f"attachment; filename*=UTF-8''b%20c{suffix}"
    whole = write(edited.score_of(score()), name)
    again, wanted = (read(f"x{suffix}", it) for it in (answer.content, whole))
    assert list(map(str, again.symbols())) == list(map(str, wanted.symbols()))


def test_what_a_notation_has_no_room_for_is_told(ask: TestClient) -> None:
    symbols = [["torso", 0, 24, "forward", "high"]]
    asked = {"score": EMPTY | {"symbols": symbols}, "format": "json", "name": "x"}
    assert ask.post("/api/scores/save", json=asked).headers["lanindex-left-out"] == "torso"
    assert ask.post("/api/scores/save", json=asked | {"format": "exe"}).status_code == 400


def test_a_score_is_put_into_the_library_and_found(
    ask: TestClient, library: lanindex.Library
) -> None:
    moves = [["l_arm", 0, 24, "back", "high"], ["l_arm", 24, 48, "left", "mid"]]
    own = score() | {"symbols": [["l_arm", 0, 0, "left", "low"], *moves]}
    kept = ask.post("/api/scores/store", json={"score": own, "name": "../wave"}).json()
    assert Path(kept["capture"]).name == "wave.lnd"
    assert library.score(kept["capture_id"]).symbols("l_arm")[1].words == "back high"
    text = ask.post("/api/scores/pattern", json={"score": own}).json()["pattern"]
    assert text == "l_arm back high -> left mid"
    assert kept["capture_id"] in [hit.capture.id for hit in library.search(text)]
    with asking(library, readonly=True) as guest:
        assert guest.post("/api/scores/store", json={"score": own}).status_code == 403


def test_what_any_part_does_is_a_pattern_that_finds_it(
    ask: TestClient, library: lanindex.Library
) -> None:
    tracks = ask.get("/api/scores/alphabet").json()["tracks"]
    kinds = {it["kind"]: it for it in tracks}
    moves = [
        [it["part"], at, at + 24, *((field["words"] or ["40"])[-1] for field in it["fields"])]
        for at, it in enumerate(kinds.values())
    ]
    own = score() | {"symbols": moves}
    text = ask.post("/api/scores/pattern", json={"score": own}).json()["pattern"]
    assert library.parse(text)["error"] is None
    assert text.count(" with[") == len(kinds) - 1
    kept = ask.post("/api/scores/store", json={"score": own, "name": "all"}).json()
    assert kept["capture_id"] in [hit.capture.id for hit in library.search(text)]


def test_a_score_is_held_against_a_capture(ask: TestClient, library: lanindex.Library) -> None:
    number = library.capture("compass.bvh").id
    data = edited.of_score(library.score(number))
    same = ask.post("/api/scores/diff", json={"score": data, "capture": number}).json()
    assert same["same"] > 50
    assert same["count"] == 0
    place = next(at for at, it in enumerate(data["symbols"]) if it[0] == "r_arm" and it[1] > 96)
    data["symbols"][place][3:] = ["left", "low"]
    other = ask.post("/api/scores/diff", json={"score": data, "capture": number}).json()
    assert other["count"] == same["count"] + 1
    assert ("r_arm", "replaced") in [(it["part"], it["difference"]) for it in other["differences"]]


def test_a_stretch_is_held_against_the_same_stretch(
    ask: TestClient, library: lanindex.Library
) -> None:
    number = library.capture("jumping_jacks.bvh").id
    window = {"from": 4, "to": 9.5}
    data = ask.get(f"/api/scores/captures/{number}", params=window).json()["score"]
    body = {"score": data, "capture": number}
    same = ask.post("/api/scores/diff", json=body | window).json()
    assert (same["same"] > 50, same["count"]) == (True, 0)
    assert ask.post("/api/scores/diff", json=body).json()["count"] > 50


def test_what_is_no_score_is_told_in_a_sentence(ask: TestClient) -> None:
    for body in (
        {},
        {"score": []},
        {"score": {"speed": "60"}},
        {"score": EMPTY | {"symbols": [3]}},
    ):
        answer = ask.post("/api/scores/draw", json=body)
        assert answer.status_code in (400, 422)
        assert answer.json()["error"]["wanted"]
