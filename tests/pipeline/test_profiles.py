"""Profiles that are changed and saved, and limbs that are written down anew with them."""

import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import lanindex
from lanindex.encoding.profile import files_of, load, made_of
from lanindex.errors import LanindexError
from lanindex.library.connect import target
from lanindex.pipeline import anew
from lanindex.pipeline.profiles import Changes, Shelf, changed, record

CORPUS = Path(__file__).parent.parent.parent / "corpus"


def changes(**said: object) -> Changes:
    return Changes.read(said)


def test_nothing_changed_is_the_same_profile() -> None:
    files = files_of("default")
    assert changed(files, changes()) == files
    assert made_of(files).digest == load("default").digest


def test_changes_of_numbers_borders_and_rules_are_read_back() -> None:
    told = record(files_of("default"))
    space = {**told["spaces"]["r_arm"], "mid": 61.25, "place": 190.5, "relative": False}
    rules = told["files"]["all.ldd"][:2]
    said = changes(
        parameters={"distance": "0.12 L", "speed": 92, "rhythm": "3/4"},
        spaces={"r_arm": space},
        rules={"l_arm": rules},
    )
    files = changed(files_of("default"), said)
    made, default = made_of(files), load("default")
    assert made.distance.value == 0.12
    assert (made.meter.speed, made.meter.beats) == (92, 3)
    assert (made.ranges["r_arm"].mid, made.ranges["r_arm"].radius(500)) == (61.25, 190.5)
    assert made.ranges["l_arm"] == default.ranges["l_arm"]
    assert [rule.cells for rule in made.rules["l_arm"].all] == [
        rule.cells for rule in default.rules["l_arm"].all[:2]
    ]
    again = record(files)
    assert again["spaces"]["r_arm"] == space
    assert again["files"][again["rules"]["l_arm"]] == rules
    assert {it["name"]: it["value"] for it in again["parameters"]}["distance"] == "0.12 L"
    assert b"# d_t:" in files["profile.toml"]  # its comments stay


def test_every_parameter_says_what_it_is() -> None:
    told = record(files_of("paper"))
    assert all(it["says"] for it in told["parameters"])
    assert {it["name"]: it["value"] for it in told["parameters"]}["smoothing"] == "83 ms"


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ({"parameters": {"rate": 0}}, "rate = 0, wanted a number from 0.1 to 1000"),
        ({"parameters": {"colour": 1}}, '"colour", wanted a parameter'),
        ({"parameters": {"rate": [1]}}, "wanted a number or a text"),
        ({"parameters": {"rhythm": '4/4"\nname = "x'}}, 'wanted "4/4"'),
        ({"spaces": {"tail": {}}}, 'no part "tail"'),
        ({"spaces": {"head": {"starts": [1]}}}, "wanted 8 starts"),
        ({"spaces": 3}, "wanted an object"),
        ({"rules": {"head": [{"cells": ["up mid"], "deleted": []}]}}, "wanted cells such as"),
        (
            {"rules": {"head": [{"cells": ["right mid", "left mid"], "deleted": []}]}},
            "deletes nothing",
        ),
    ],
)
def test_what_is_not_allowed_is_said(said: dict[str, object], message: str) -> None:
    with pytest.raises(LanindexError, match=r".") as error:
        made_of(changed(files_of("default"), changes(**said)), "own")
    assert message in str(error.value)


def test_borders_out_of_order_are_refused() -> None:
    space = record(files_of("default"))["spaces"]["head"]
    for wrong in ({"mid": 120}, {"starts": [337.5, 70, 67.5, 112.5, 157.5, 202.5, 247.5, 292.5]}):
        files = changed(files_of("default"), changes(spaces={"head": {**space, **wrong}}))
        with pytest.raises(LanindexError, match=r"head\.lpd"):
            made_of(files, "own")


def test_a_saved_profile_is_read_whole(tmp_path: Path) -> None:
    shelf = Shelf(target(tmp_path / "dance.db"))
    files = changed(files_of("paper"), changes(parameters={"onset": 0.05}))
    assert shelf.save("../my profile", files) == "my profile"
    assert shelf.names() == ["default", "paper", "my profile"]
    place = shelf.place("my profile")
    assert Path(place).parent == tmp_path / "dance-profiles"
    read = lanindex.load_profile(place)
    named = made_of(changed(files, changes(parameters={"name": "my profile"})))
    assert (read.name, read.onset, read.digest) == ("my profile", 0.05, named.digest)
    assert (read.ranges, read.meter) == (named.ranges, named.meter)


def test_no_profile_is_written_in_part_or_over_another(tmp_path: Path) -> None:
    shelf = Shelf(target(tmp_path / "dance.db"))
    good = files_of("default")
    broken = changed(good, changes(parameters={"onset": 2}))
    with pytest.raises(LanindexError, match="onset"):
        shelf.save("mine", broken)
    assert not shelf.folder.exists()
    shelf.save("mine", good)
    with pytest.raises(LanindexError, match='there is a profile "mine"'):
        shelf.save("mine", files_of("paper"))
    with pytest.raises(LanindexError, match="onset"):
        shelf.save("mine", broken, replace_it=True)
    assert load(shelf.place("mine")).distance == load("default").distance
    shelf.save("mine", files_of("paper"), replace_it=True)
    assert load(shelf.place("mine")).distance == load("paper").distance
    assert [it.name for it in shelf.folder.iterdir()] == ["mine"]
    for name in ("default", " ", "..", ""):
        with pytest.raises(LanindexError, match="the name"):
            shelf.save(name, good)
    with pytest.raises(LanindexError, match="no profile"):
        shelf.place("../mine")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> lanindex.Library:
    library = lanindex.open_library(tmp_path_factory.mktemp("anew") / "own.db", create=True)
    library.ingest(CORPUS)
    return library


def test_unchanged_numbers_give_the_stored_symbols(library: lanindex.Library) -> None:
    profile, moved = load("default"), 0
    for capture in library.captures():
        if capture.format == "lnd":
            with pytest.raises(LanindexError, match="has no movement"):
                anew.known(library.store, capture, profile)
            continue
        parts = anew.known(library.store, capture, profile)
        stored = library.score(capture.id)
        score = anew.encoded(library.store, capture, parts, profile, own_tempo=True)
        assert {*score.tracks} == {*stored.tracks}
        for part, track in stored.tracks.items():
            assert np.array_equal(track.symbols, score.tracks[part].symbols), (capture.path, part)
            assert track.known == score.tracks[part].known
        assert score.meter == stored.meter
        moved += 1
    assert moved == 10


def test_other_numbers_give_what_an_ingest_with_them_gives(library: lanindex.Library) -> None:
    space = record(files_of("default"))["spaces"]["r_arm"]
    said = changes(
        parameters={"distance": "0.2 L", "smoothing": "150 ms", "speed": 80},
        spaces={"r_arm": {**space, "mid": 50}},
    )
    profile = made_of(changed(files_of("default"), said))
    capture = library.capture("traffic_police.bvh")
    score = anew.encoded(library.store, capture, ["r_arm"], profile, own_tempo=False)
    whole = lanindex.encode(lanindex.read(CORPUS / "traffic_police.bvh"), profile)
    assert np.array_equal(score.tracks["r_arm"].symbols, whole.tracks["r_arm"].symbols)
    stored = library.score(capture.id)
    names = [name for name in stored.tracks["l_arm"].symbols.dtype.names if "tick" not in name]
    left = [it.tracks["l_arm"].symbols[names] for it in (score, stored)]
    assert np.array_equal(*left)
    assert score.meter.speed == 80


def test_a_tempo_of_its_own_is_kept(tmp_path: Path) -> None:
    with lanindex.open_library(tmp_path / "own.db", create=True) as library:
        library.ingest(CORPUS / "marching.bvh", reading=lanindex.model.Reading(tempo="auto"))
        capture, profile = library.capture("marching.bvh"), load("default")
        stored = library.score(capture.id)
        assert stored.meter.speed != 60
        for own, wanted in ((True, stored.meter.speed), (False, 60)):
            made = anew.encoded(library.store, capture, ["head"], profile, own_tempo=own)
            assert made.meter.speed == wanted
        kept = anew.encoded(library.store, capture, ["head"], profile, own_tempo=True)
        assert np.array_equal(kept.tracks["r_leg"].symbols, stored.tracks["r_leg"].symbols)
        found = anew.tempo(library.store, capture, profile)
        assert found is not None
        assert found.speed == stored.meter.speed


def test_a_library_is_written_down_anew_by_a_profile(tmp_path: Path) -> None:
    folder = tmp_path / "captures"
    folder.mkdir()
    for name in ("marching.bvh", "compass.bvh", "compass.lnd", "greetings.bvh"):
        shutil.copy(CORPUS / name, folder)
    with lanindex.open_library(tmp_path / "own.db", create=True) as library:
        library.ingest(folder / "compass.bvh", folder / "compass.lnd", folder / "greetings.bvh")
        library.ingest(folder / "marching.bvh", reading=lanindex.model.Reading(tempo="auto"))
        marching, score = (library.capture(it).id for it in ("marching.bvh", "compass.lnd"))
        library.label(marching, "march", {"year": "1920"})
        gone = library.capture("greetings.bvh").id
        kept = library.score(gone).tracks["r_arm"].symbols
        lines = library.score(score).tracks["r_arm"].symbols
        (folder / "greetings.bvh").unlink()
        job = library.begin_encode("paper")
        assert sorted(Counter(it.status for it in job).items()) == [("added", 2), ("failed", 1)]
        wanted = lanindex.encode(lanindex.read(folder / "marching.bvh"), "paper", tempo="auto")
        found = library.score(marching)
        assert np.array_equal(found.tracks["r_leg"].symbols, wanted.tracks["r_leg"].symbols)
        assert found.meter == wanted.meter
        capture = library.capture(marching)
        assert (capture.label, capture.metadata) == ("march", {"year": "1920"})
        assert np.array_equal(library.score(gone).tracks["r_arm"].symbols, kept)
        assert np.array_equal(library.score(score).tracks["r_arm"].symbols, lines)
        again = library.begin_encode("paper")
        assert [it.status for it in again] == ["failed"]  # all others have it already
        for profile in ("none", tmp_path):
            with pytest.raises(lanindex.LanindexError, match="no profile"):
                library.begin_encode(profile)
