"""The page of a library that many share: in PostgreSQL."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.request import Request, urlopen

import pytest
from page_client import asking, serving

import lanindex
from lanindex.library.connect import target
from lanindex.pipeline import motion

if TYPE_CHECKING:
    from postgres_server import Server

CORPUS = Path(__file__).parents[2] / "corpus"


def test_what_is_no_part_of_a_shared_library_is_the_users_own(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    with server.connect(autocommit=True) as link:
        link.execute("CREATE SCHEMA page")
    address = server.url("page")
    with lanindex.open_library(address, create=True) as library, asking(library) as ask:
        about = ask.get("/api/library").json()
        assert (about["name"], about["file"]) == ("postgres.page", library.store.place)
        name = ask.post("/api/names", json={"text": "arm high"}).json()["name"]
        compass = (CORPUS / "compass.bvh").read_bytes()
        sent = ask.put("/api/uploads/mine.bvh", content=compass).json()["name"]
        saved = {"name": "mine", "profile": "default", "changes": {"parameters": {"onset": 0.05}}}
        kept = Path(ask.post("/api/profiles", json=saved).json()["folder"])
        begun = {"files": {"mine.bvh": sent}, "profile": "mine"}
        job = ask.post("/api/ingests", json=begun).json()["job"]
        assert '"state":"done"' in ask.get(f"/api/jobs/{job}/events").text
        (folder,) = (tmp_path / "lanindex").iterdir()
        assert folder.name.startswith("postgres.page-")
        assert {it.name for it in folder.iterdir()} == {"captures", "patterns.json", "profiles"}
        assert library.capture("mine.bvh").location == str(folder / "captures" / "mine.bvh")
        assert kept == folder / "profiles" / "mine"
    with lanindex.open_library(address, readonly=True) as again:
        with asking(again, readonly=True) as ask:
            assert ask.get(f"/api/names/{name}").json() == {"text": "arm high"}
            assert ask.get("/api/library").json()["file"] == "postgres.page"
        assert again.curves("mine.bvh", "r_arm").profile.onset == 0.05


@pytest.mark.slow
def test_other_processes_open_a_shared_library(
    own_address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(motion, "MANY", 1)
    with lanindex.open_library(own_address, readonly=True) as library:
        assert library.motion("compass.lnd").rate > 0


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("ada:secret@host/lan", "bob@host/lan?connect_timeout=3", True),
        ("host/lan?options=-csearch_path%3Done", "host/lan?options=-csearch_path%3Dtwo", False),
        ("host/lan", "other/lan", False),
        ("host/lan", "host:5433/lan", False),
        ("host/lan", "host/dance", False),
    ],
)
def test_what_is_kept_of_a_library_is_kept_of_no_other(one: str, other: str, same: bool) -> None:
    places = {target(f"postgresql://{it}").beside("captures") for it in (one, other)}
    assert (len(places) == 1) == same
    assert "secret" not in str(places)


@pytest.mark.slow
def test_fifty_browsers_are_answered_while_captures_come(own_address: str) -> None:
    with (
        serving(own_address, "--read-only") as link,
        lanindex.open_library(own_address) as library,
        ThreadPoolExecutor(50) as browsers,
    ):
        host, _, token = link.partition("/?token=")
        header = {"Authorization": f"Bearer {token}"}
        before, symbols = library.captures(), _symbols(library)

        def asked(browser: int) -> None:
            number = before[browser % len(before)].id
            paths = ("library", "captures", f"captures/{number}", f"captures/{number}/staff")
            for path in paths * 3:
                with urlopen(Request(f"{host}/api/{path}", headers=header), timeout=60) as answer:
                    assert answer.status == 200
                    assert answer.read()

        waiting = [browsers.submit(asked, browser) for browser in range(50)]
        library.ingest(CORPUS, force=True, jobs=1)
        for one in waiting:
            one.result(120)
        assert library.captures() == before
        assert _symbols(library) == symbols


def _symbols(library: lanindex.Library) -> list[list[lanindex.Symbol]]:
    return [library.store.score(it.id).symbols() for it in library.captures()]
