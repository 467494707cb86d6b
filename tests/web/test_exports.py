"""What leaves the library as a ZIP, and what is said of what is lost."""

from io import BytesIO
from itertools import pairwise
from pathlib import Path
from shutil import copyfile
from typing import Any
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import pytest
from made_c3d import c3d, standing
from page_client import asking
from starlette.testclient import TestClient

import lanindex


def packed(ask: TestClient, kind: str, hits: list[dict[str, Any]]) -> tuple[ZipFile, list[str]]:
    """Return the ZIP of hits, and what is told beside it."""
    job = ask.post("/api/exports", json={"kind": kind, "hits": hits}).json()["job"]
    told = ask.get(f"/api/jobs/{job}/events").text
    assert '"state":"done"' in told, told
    notes = ask.delete(f"/api/jobs/{job}").json()["notes"]
    return ZipFile(BytesIO(ask.get(f"/api/exports/{job}/file").content)), notes


def test_what_clips_lose_stands_beside_them_and_inside(tmp_path: Path) -> None:
    events = {"EVENT:USED": 1, "EVENT:TIMES": np.array([[0.0, 0.1]])}
    (tmp_path / "a.c3d").write_bytes(c3d(standing(20), analog=np.ones((20, 4)), more=events))
    with lanindex.open_library(tmp_path / "own.db", create=True) as library, asking(library) as ask:
        library.ingest(tmp_path / "a.c3d")
        hit = {"capture": library.captures()[0].path, "capture_id": 1}
        whole, none = packed(ask, "clips", [hit | {"start_frame": 0, "end_frame": 20}])
        part, notes = packed(ask, "clips", [hit | {"start_frame": 15, "end_frame": 20}])
    assert none == []
    assert "NOTES.txt" not in whole.namelist()
    assert notes == ["not written to the clips: 1 event"]
    assert part.read("NOTES.txt").decode() == "not written to the clips: 1 event\n"


def test_hits_that_overlap_keep_their_times_in_tiers_of_their_own(corpus_library: Path) -> None:
    with lanindex.open_library(corpus_library, readonly=True) as library, asking(library) as ask:
        capture = library.capture("compass.bvh")
        spans = [(0, 30), (20, 50), (25, 40), (50, 60)]
        hits = [
            {"capture": capture.path, "capture_id": capture.id, "start_frame": a, "end_frame": b}
            for a, b in spans
        ]
        found, notes = packed(ask, "elan", hits)
        apart, none = packed(ask, "elan", [hits[0], hits[3]])
    assert notes == [f"{capture.id} compass.eaf: hits overlap, and stand in 3 tiers"]
    assert none == []
    assert apart.namelist() == [f"{capture.id} compass.eaf"]
    root = ElementTree.fromstring(found.read(f"{capture.id} compass.eaf"))
    times = {it.get("TIME_SLOT_ID"): int(it.get("TIME_VALUE", "")) for it in root.iter("TIME_SLOT")}
    tiers = {}
    for tier in root.iter("TIER"):
        slots = [
            tuple(times[it.get(f"TIME_SLOT_REF{end}")] for end in "12")
            for it in tier.iter("ALIGNABLE_ANNOTATION")
        ]
        assert all(one[1] <= two[0] for one, two in pairwise(slots))
        tiers[tier.get("TIER_ID")] = slots
    own = [slot for name, slots in tiers.items() if str(name).startswith("hits") for slot in slots]
    rate = float(capture.rate)
    wanted = [(round(a * 1000 / rate), round(b * 1000 / rate)) for a, b in spans]
    assert sorted(own) == sorted(wanted)
    assert {"hits", "hits 2", "hits 3"} <= tiers.keys()


@pytest.mark.parametrize("kind", ["clips", "films", "dataset", "elan"])
def test_what_is_gone_is_left_out_and_the_rest_is_written(tmp_path: Path, kind: str) -> None:
    corpus = Path(__file__).parent.parent.parent / "corpus"
    for name in ("compass", "marching", "greetings"):
        copyfile(corpus / f"{name}.bvh", tmp_path / f"{name}.bvh")
    with lanindex.open_library(tmp_path / "own.db", create=True) as library, asking(library) as ask:
        library.ingest(*sorted(tmp_path.glob("*.bvh")))
        hits = [
            {"capture": it.path, "capture_id": it.id, "start_frame": start, "end_frame": start + 9}
            for it in library.captures()
            for start in (0, 20)
        ]
        (tmp_path / "greetings.bvh").unlink()
        library.remove(library.capture(str(tmp_path / "marching.bvh")).id)
        found, notes = packed(ask, kind, hits)
        lost = [it for it in hits if "marching" in it["capture"]]
        job = ask.post("/api/exports", json={"kind": kind, "hits": lost}).json()["job"]
        refused = ask.get(f"/api/jobs/{job}/events").text
    gone = ["marching"] if kind == "elan" else ["greetings", "marching"]
    assert [Path(it.partition(" of ")[2].partition(".bvh")[0]).name for it in notes] == gone
    assert all(it.startswith("left out: 2 hits of ") for it in notes)
    assert found.read("NOTES.txt").decode().splitlines() == notes
    assert any("compass" in it for it in found.namelist())
    assert not any(name in it for it in found.namelist() for name in gone)
    assert '"error"' in refused
