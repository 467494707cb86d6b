"""Files that are sent are read into the library, and go again where nothing comes of them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

import lanindex
from lanindex.web.jobs import MOST, Jobs
from lanindex.web.server import Site, application

CORPUS = Path(__file__).parents[2] / "corpus"
COMPASS = (CORPUS / "compass.bvh").read_bytes()
MARCHING = (CORPUS / "marching.bvh").read_bytes()
ASF = """:version 1.10
:name VICON
:units
  mass 1.0
  length 0.45
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
:hierarchy
begin
end
"""


@pytest.fixture
def library(tmp_path: Path) -> Iterator[lanindex.Library]:
    with lanindex.open_library(tmp_path / "own.db", create=True) as opened:
        yield opened


@pytest.fixture
def ask(library: lanindex.Library) -> Iterator[TestClient]:
    app = application(Site(library), token="token", host="127.0.0.1", port=8421)
    headers = {"authorization": "Bearer token"}
    with TestClient(app, base_url="http://127.0.0.1:8421", headers=headers) as client:
        yield client


def sent(ask: TestClient, files: dict[str, bytes]) -> dict[str, str]:
    """Send files, and return the names that they are kept by."""
    return {
        name: ask.put(f"/api/uploads/{name}", content=content).json()["name"]
        for name, content in files.items()
    }


def ingested(ask: TestClient, files: dict[str, bytes], **options: Any) -> dict[str, Any]:
    """Send files, read them, and return what became of them."""
    begun = ask.post("/api/ingests", json={"files": sent(ask, files), **options})
    assert begun.status_code == 200, begun.text
    for _ in range(600):
        told: dict[str, Any] = ask.get(f"/api/ingests/{begun.json()['job']}").json()
        if told["state"] != "running":
            return told
        time.sleep(0.05)
    raise AssertionError(told)


def kept(folder: Path) -> list[str]:
    """Return what lies in the folder of what was sent."""
    own = folder / "own-captures"
    return sorted(it.relative_to(own).as_posix() for it in own.rglob("*") if it.is_file())


def test_captures_are_added_and_what_is_none_goes_again(ask: TestClient, tmp_path: Path) -> None:
    table = b"file,label,year\na/compass.bvh,<b>rose</b>,1928\n"
    files = {"a/compass.bvh": COMPASS, "a/broken.bvh": b"HIERARCHY\n", "labels.csv": table}
    told = ingested(ask, {**files, "notes.txt": b"some words"})
    assert told["state"] == "done"
    assert told["counts"] == {"added": 1, "failed": 1}
    assert told["left"] == [{"name": "notes.txt", "reason": "neither a capture nor a score"}]
    compass, broken = told["outcomes"]
    assert broken["error"].startswith("a/broken.bvh")
    (capture,) = ask.get("/api/captures").json()["captures"]
    assert compass["capture_id"] == capture["capture_id"]
    assert (capture["label"], capture["metadata"]) == ("<b>rose</b>", {"year": "1928"})
    assert kept(tmp_path) == ["a/compass.bvh"]


def test_what_is_sent_again_is_unchanged_and_can_be_labelled(
    ask: TestClient, library: lanindex.Library
) -> None:
    ingested(ask, {"compass.bvh": COMPASS})
    again = ingested(ask, {"compass.bvh": COMPASS, "l.csv": b"file;label\ncompass.bvh;rose\n"})
    assert again["counts"] == {"unchanged": 1}
    assert again["labelled"] == 1
    assert [it.label for it in library.captures()] == ["rose"]


def test_a_table_names_files_as_they_were_sent(
    ask: TestClient, library: lanindex.Library, tmp_path: Path
) -> None:
    ingested(ask, {"take.bvh": COMPASS})
    ingested(ask, {"take.bvh": MARCHING, "labels.tsv": b"file\tlabel\ntake.bvh\tmarch\n"})
    assert kept(tmp_path) == ["take 2.bvh", "take.bvh"]
    assert {Path(it.path).name: it.label for it in library.captures()} == {
        "take.bvh": "",
        "take 2.bvh": "march",
    }


def test_a_skeleton_of_the_same_name_is_not_taken_for_another(
    ask: TestClient, tmp_path: Path
) -> None:
    sent(ask, {"cmu/01.asf": b"another skeleton"})
    names = sent(ask, {"cmu/01.asf": ASF.encode(), "cmu/compass.bvh": COMPASS})
    assert names["cmu/01.asf"] == "cmu/01 2.asf"
    begun = ask.post("/api/ingests", json={"files": names}).json()["job"]
    told = ask.get(f"/api/ingests/{begun}").json()
    while told["state"] == "running":
        told = ask.get(f"/api/ingests/{begun}").json()
    assert [it["name"] for it in told["outcomes"]] == ["cmu 2/compass.bvh"]
    assert kept(tmp_path) == ["cmu 2/compass.bvh", "cmu/01.asf"]


@pytest.mark.parametrize(
    ("body", "found"),
    [
        ({}, "no files"),
        ({"files": {"x.bvh": "../own.db"}}, "was not sent"),
        ({"files": {"x.bvh": 3}}, "no files"),
    ],
)
def test_only_what_was_sent_is_read(ask: TestClient, body: dict[str, Any], found: str) -> None:
    answer = ask.post("/api/ingests", json=body)
    assert answer.status_code == 400
    assert found in answer.json()["error"]["found"]


def test_a_table_of_other_files_is_refused_and_nothing_is_left(
    ask: TestClient, tmp_path: Path
) -> None:
    names = sent(ask, {"compass.bvh": COMPASS, "l.csv": b"file,label\nother.bvh,x\n"})
    answer = ask.post("/api/ingests", json={"files": names})
    assert answer.status_code == 400
    assert "names a file" in answer.json()["error"]["found"]
    assert kept(tmp_path) == []


def test_the_choreographies_can_be_added(ask: TestClient) -> None:
    job = ask.post("/api/ingests", json={"choreographies": True}).json()["job"]
    with ask.stream("GET", f"/api/jobs/{job}/events") as told:
        lines = [line for line in told.iter_lines() if line]
    assert '"state":"done"' in lines[-1]
    captures = ask.get("/api/captures").json()["captures"]
    assert len(captures) == 10
    assert all(it["label"] for it in captures)


def test_a_page_finds_what_goes_on_until_it_is_told_the_end(ask: TestClient) -> None:
    job = ask.post("/api/ingests", json={"choreographies": True}).json()["job"]
    listed = [{"job": job, "kind": "ingest"}]
    assert ask.get("/api/jobs").json()["jobs"] == listed
    while ask.get(f"/api/ingests/{job}").json()["state"] == "running":
        pass
    assert ask.get("/api/jobs").json()["jobs"] == listed  # nobody has followed it to its end
    with ask.stream("GET", f"/api/jobs/{job}/events") as told:
        assert '"state":"done"' in [line for line in told.iter_lines() if line][-1]
    assert ask.get("/api/jobs").json()["jobs"] == []
    job = ask.post("/api/library/encode", json={"profile": "paper"}).json()["job"]
    assert ask.get("/api/jobs").json()["jobs"] == [{"job": job, "kind": "encode"}]
    ask.delete(f"/api/jobs/{job}")


def test_an_ingest_can_be_cancelled(ask: TestClient, tmp_path: Path) -> None:
    files = {f"{number}.bvh": MARCHING + b" " * number for number in range(12)}
    job = ask.post("/api/ingests", json={"files": sent(ask, files)}).json()["job"]
    ask.delete(f"/api/jobs/{job}")
    told = ask.get(f"/api/ingests/{job}").json()
    while told["state"] == "running":
        told = ask.get(f"/api/ingests/{job}").json()
    assert told["state"] == "cancelled"
    assert len(kept(tmp_path)) == told["counts"].get("added", 0) < 12


def test_a_job_that_runs_is_kept_however_many_come() -> None:
    class Some:
        def __init__(self, state: str) -> None:
            self.state = state

        def cancel(self) -> None:
            self.state = "cancelled"

        def told(self) -> dict[str, Any]:
            return {"state": self.state}

    jobs, running = Jobs(), Some("running")
    number = jobs.begin("ingest", lambda: running)
    for one in range(MOST + 10):
        jobs.begin(one, lambda: Some("done"))
    assert jobs.get(number) is running
    assert running.state == "running"


@pytest.mark.slow
def test_a_killed_server_leaves_a_whole_library_and_no_half_file(tmp_path: Path) -> None:
    path = tmp_path / "own.db"
    command = [sys.executable, "-m", "lanindex", "serve", str(path), "--port", "0", "--no-open"]
    environment = {**os.environ, "PYTHONPATH": str(CORPUS.parent)}
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    assert server.stdout is not None
    link = server.stdout.readline().strip()
    base, _, token = link.partition("/?token=")
    import httpx2

    headers = {"authorization": f"Bearer {token}"}
    with httpx2.Client(base_url=base, headers=headers, timeout=20) as client:
        names = {}
        for number in range(30):
            name = f"{number}.bvh"
            content = MARCHING + b" " * number
            names[name] = client.put(f"/api/uploads/{name}", content=content).json()["name"]
        client.post("/api/ingests", json={"files": names})
        time.sleep(1.5)
    (tmp_path / "own-captures" / "0123.part").write_bytes(b"half")  # as a broken transfer leaves
    server.send_signal(signal.SIGKILL)
    server.wait()
    server.stdout.close()
    with lanindex.open_library(path) as library:
        stored = library.captures()
        assert [it.frames for it in stored] == [stored[0].frames] * len(stored) if stored else True
        Site(library)
    assert not list(tmp_path.rglob("*.part"))
    assert len(kept(tmp_path)) == 30
    checked = subprocess.run(
        [sys.executable, "-m", "lanindex", "db", "check", "--db", str(path)],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert checked.returncode == 0, checked.stdout + checked.stderr
