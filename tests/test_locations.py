"""What lies at a URL is read, found, cut and shown as the same file on the disk."""

import hashlib
import http.server
import io
import shutil
import sys
import threading
import zipfile
from collections import Counter
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import command
import fsspec
import made_c3d
import numpy as np
import pytest
from dances import BOW, RAISE, dance
from fsspec.implementations.memory import MemoryFileSystem
from fsspec.registry import known_implementations
from page_client import asking

import lanindex
from lanindex import formats, locations
from lanindex.errors import CaptureError, ExportError
from lanindex.film.figure import figure
from lanindex.library.selection import Selection, absolute, is_gone
from lanindex.model import Hit, Reading, Span
from lanindex.pipeline import ingest as ingests
from lanindex.pipeline.library import Library, open_library
from lanindex.pipeline.preview import _bodies

URL = "counted://bucket/dance"
WALKED = ["counted://bucket/dance/a/bow.bvh", "counted://bucket/dance/raise.lnd"]


class Counted(MemoryFileSystem):
    """A store that counts what it is asked, and can fail."""

    protocol, store, asked = "counted", {}, Counter[str]()
    pseudo_dirs = [""]  # noqa: RUF012
    fails: Exception | None = None
    fetched, gives_parts = 0, True

    @classmethod
    def _strip_protocol(cls, path: str) -> str:
        return str(super()._strip_protocol(path.removeprefix("counted://")))

    def _count(self, what: str) -> None:
        if Counted.fails:
            raise Counted.fails
        Counted.asked[what] += 1

    def info(self, path: str, **how: Any) -> Any:
        self._count("info")
        return super().info(path, **how)

    def ls(self, path: str, detail: bool = True, **how: Any) -> Any:
        self._count("list")
        return super().ls(path, detail, **how)

    def get_file(self, rpath: str, lpath: str, **how: Any) -> None:
        self._count("copy")
        data = bytes(super().cat_file(rpath))
        Counted.fetched += len(data)
        Path(lpath).write_bytes(data)

    def cat_file(self, path: str, start: Any = None, end: Any = None, **how: Any) -> bytes:
        self._count("head" if not start else "part")
        data = bytes(super().cat_file(path, *((start, end) if Counted.gives_parts else ()), **how))
        Counted.fetched += len(data)
        return data


@pytest.fixture(autouse=True)
def alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LANINDEX_CACHE", str(tmp_path / "cache"))
    fsspec.register_implementation("counted", Counted, clobber=True)
    locations._known.clear()
    locations._listed.clear()
    Counted.store.clear()
    Counted.asked.clear()
    Counted.fails, Counted.fetched, Counted.gives_parts = None, 0, True


@pytest.fixture
def store() -> MemoryFileSystem:
    return fsspec.filesystem("counted")


@pytest.fixture
def folder(tmp_path: Path, store: MemoryFileSystem) -> Path:
    """Return a folder that lies in the store, too."""
    folder = tmp_path / "dance"
    dance(folder / "a" / "bow.bvh", BOW)
    (folder / "raise.lnd").write_text(RAISE)
    (folder / "notes.txt").write_text("no capture")
    for path in folder.rglob("*"):
        if path.is_file():
            store.pipe_file(f"/bucket/dance/{path.relative_to(folder)}", path.read_bytes())
    return folder


@pytest.fixture
def library(tmp_path: Path) -> Iterator[Library]:
    with open_library(tmp_path / "l.db", create=True) as opened:
        yield opened


def statuses(outcomes: list[Any]) -> list[tuple[str, str]]:
    return [(outcome.path, outcome.status) for outcome in outcomes]


def test_a_folder_of_a_store_is_walked(library: Library, folder: Path, tmp_path: Path) -> None:
    assert statuses(library.ingest(URL)) == [(path, "added") for path in WALKED]
    assert [capture.location for capture in library.captures()] == WALKED
    assert [it.path for it in library.captures(Selection("counted://bucket/*/a/*"))] == WALKED[:1]
    assert [it.path for it in library.captures(Selection("bow.bvh"))] == WALKED[:1]
    assert library.store.capture(WALKED[0]).path == WALKED[0]
    shutil.rmtree(tmp_path / "cache")
    Counted.asked.clear()
    again = library.ingest(URL)
    assert [one.status for one in again] == ["unchanged", "unchanged"]
    assert Counted.asked["copy"] == 0


def test_a_url_is_read_and_cut_as_its_file(library: Library, folder: Path, tmp_path: Path) -> None:
    library.ingest(URL, folder)
    clips = []
    for where in (URL, folder):
        hits = library.search("r_arm forward mid", Selection(f"{where}/*"))
        library.export(hits, tmp_path / "clips", force=True)
        clips.append([it.read_bytes() for it in sorted((tmp_path / "clips").glob("*.bvh"))])
    assert clips[0] == clips[1] != []
    remote, here = (library.motion(f"{it}/a/bow.bvh", 0.5, 1) for it in (URL, folder))
    assert np.array_equal(remote.places, here.places)
    ours = lanindex.read(folder / "a" / "bow.bvh")
    assert np.array_equal(lanindex.read(WALKED[0]).positions, ours.positions)


def test_the_store_is_asked_for_a_file_once(library: Library, folder: Path, tmp_path: Path) -> None:
    library.ingest(URL)
    assert Counted.asked == {"list": 2, "info": 5, "copy": 2, "head": 1}
    Counted.asked.clear()
    hits = library.search("r_arm forward mid")
    library.export(hits, tmp_path / "clips")
    for start in np.arange(0, 2, 0.1):
        library.motion(WALKED[0], float(start), float(start) + 0.1)
    assert library.store.missing() == []
    assert Counted.asked["copy"] == Counted.asked["head"] == 0
    assert Counted.asked["info"] <= 4


def test_a_large_file_is_read_from_its_copy(
    folder: Path, store: MemoryFileSystem, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("lanindex.formats.file.WHOLE", 100)
    file = formats.opened(WALKED[0])
    assert not isinstance(file.content, bytes)
    assert file.content[10:50] == (folder / "a" / "bow.bvh").read_bytes()[10:50]
    for copy in (tmp_path / "cache" / "captures").iterdir():  # another process needed room
        copy.unlink()
    assert file.sha256() == formats.opened(folder / "a" / "bow.bvh").sha256()
    for copy in (tmp_path / "cache" / "captures").iterdir():
        copy.unlink()
    store.pipe_file("/bucket/dance/a/bow.bvh", b"x" * 5000)
    locations.forget(WALKED[0])
    with pytest.raises(CaptureError, match="changed while it was read"):
        _ = file.content[:10]


TRIAL = "counted://bucket/trial.c3d"


@pytest.fixture
def large(library: Library, store: MemoryFileSystem, tmp_path: Path) -> bytes:
    """Return a C3D of 24 MB that the store holds, and the library; there is no copy of it."""
    analog = np.arange(6000)[:, None] + np.zeros(900)
    content = made_c3d.c3d(made_c3d.standing(6000, 1.0), analog=analog)
    store.pipe_file("/bucket/trial.c3d", content)
    (tmp_path / "trial.c3d").write_bytes(content)
    library.ingest(TRIAL, tmp_path / "trial.c3d")
    shutil.rmtree(tmp_path / "cache")
    Counted.fetched = 0
    return content


def cut(library: Library, folder: Path, path: str = TRIAL, first: int = 1000) -> bytes:
    """Return a clip of 100 frames."""
    hit = Hit(library.store.capture(path), Span(first, first + 100), 1.0, ())
    (row,) = library.export([hit], folder, force=True)
    return (folder / row["clip"]).read_bytes()


def test_a_clip_fetches_its_own_part_of_a_large_file(
    library: Library, large: bytes, tmp_path: Path
) -> None:
    clip = cut(library, tmp_path / "clips")
    assert clip == cut(library, tmp_path / "clips", str(tmp_path / "trial.c3d"))
    assert len(clip) < Counted.fetched < len(large) / 10
    assert not (tmp_path / "cache").exists()
    cut(library, tmp_path / "clips")
    (again,) = library.ingest(TRIAL)
    assert (again.status, again.sha256) == ("unchanged", hashlib.sha256(large).hexdigest())
    assert Counted.asked["copy"] == 1  # to be ingested first


@pytest.mark.parametrize("form", ["c3d", "npz"])
def test_a_film_fetches_little_of_a_large_file(
    library: Library,
    store: MemoryFileSystem,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    form: str,
) -> None:
    for name, size in {"SMALL": 1 << 20, "NEAR": 1 << 10, "FETCHED": 1 << 14}.items():
        monkeypatch.setattr(f"lanindex.formats.file.{name}", size)
    read = lanindex.read("corpus/compass.bvh")
    long = np.tile(read.positions, (10, 1, 1)).astype(float)
    file = io.BytesIO()
    if form == "c3d":
        analog = np.arange(len(long))[:, None] + np.zeros(100)
        file.write(made_c3d.c3d(made_c3d.standing(len(long), 1.0), analog=analog))
    else:
        named = {"joint_names": np.array(read.skeleton.names), "fps": 30, "unit": "mm"}
        np.savez(file, joints=long, **named)
    path, url = tmp_path / f"long.{form}", f"counted://bucket/long.{form}"
    path.write_bytes(file.getvalue())
    store.pipe_file(f"/bucket/long.{form}", file.getvalue())
    assert [it.status for it in library.ingest(url, path)] == ["added", "added"]
    shutil.rmtree(tmp_path / "cache")
    Counted.fetched, span = 0, Span(3000, 3030)
    remote, here = (
        _bodies(library.store, 25)(library.store.capture(it), span) for it in (url, str(path))
    )
    whole = figure(formats.read_file(formats.opened(path), Reading(), formats.Wanted(True)))
    assert np.array_equal(remote.places, here.places, equal_nan=True)
    assert np.abs(remote.places[3000:3030] - whole.places[3000:3030]).max() < 0.1
    assert Counted.fetched < len(file.getvalue()) / 5
    assert not (tmp_path / "cache").exists()


def test_a_large_file_is_copied_where_a_quarter_of_it_or_no_part_is_had(
    library: Library, large: bytes, tmp_path: Path
) -> None:
    Counted.gives_parts = False
    clip = cut(library, tmp_path / "clips")
    assert clip == cut(library, tmp_path / "clips", str(tmp_path / "trial.c3d"))
    assert len(list((tmp_path / "cache" / "captures").iterdir())) == 1
    shutil.rmtree(tmp_path / "cache")
    Counted.gives_parts, Counted.fetched = True, 0
    file = formats.opened(TRIAL, library.store.encoding(TRIAL).version)
    assert not Counted.fetched
    assert file.sha256() == hashlib.sha256(large).hexdigest()
    assert Counted.fetched <= len(large) * 5 / 4


def test_a_large_file_that_changes_is_refused(
    library: Library, large: bytes, store: MemoryFileSystem, tmp_path: Path
) -> None:
    file = formats.opened(TRIAL, library.store.encoding(TRIAL).version)
    assert file.content[:512] == large[:512]
    store.pipe_file("/bucket/trial.c3d", large[:-1] + b"\1")
    for stop in (len(large) // 2 + 512, len(large)):  # a part of it, and all
        with pytest.raises(CaptureError, match="changed while it was read"):
            _ = file.content[len(large) // 2 : stop]
    with pytest.raises(ExportError, match="has changed since it was ingested"):
        cut(library, tmp_path / "clips")
    store.pipe_file("/bucket/trial.c3d", large)  # written anew, as it was
    assert cut(library, tmp_path / "clips")
    before = library.store.encoding(TRIAL).version
    assert library.ingest(TRIAL)[0].status == "unchanged"
    assert library.store.encoding(TRIAL).version != before
    store.rm("/bucket/trial.c3d")
    with pytest.raises(ExportError, match="there is no such file"):
        cut(library, tmp_path / "clips")


def test_a_change_is_noticed(
    library: Library, folder: Path, store: MemoryFileSystem, tmp_path: Path
) -> None:
    library.ingest(URL)
    hits = library.search("r_arm forward mid")
    store.pipe_file("/bucket/dance/a/bow.bvh", (folder / "a" / "bow.bvh").read_bytes() + b"\n")
    with pytest.raises(ExportError, match="has changed since it was ingested"):
        library.export(hits, tmp_path / "clips")
    assert library.ingest(URL)[0].status == "added"


def test_a_file_that_moved_keeps_its_row(
    library: Library, folder: Path, store: MemoryFileSystem
) -> None:
    library.ingest(URL)
    store.mv("/bucket/dance/a/bow.bvh", "/bucket/dance/b/bow.bvh")
    locations._listed.clear()
    locations._known.clear()
    assert [it.path for it in library.store.missing()] == WALKED[:1]
    (moved, _) = library.ingest(URL)
    assert (moved.status, moved.moved) == ("unchanged", WALKED[0])
    assert library.store.encoding(moved.path).version == locations.version(moved.path) != ""


def test_what_tells_no_versions_apart_is_not_remembered(
    library: Library, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(locations, "_WHEN", ())
    library.ingest(URL)
    assert {one.version for _, one in library.store.known().values()} == {""}


def test_only_what_a_store_says_is_not_there_is_gone(folder: Path) -> None:
    assert is_gone(f"{URL}/none.bvh")
    assert is_gone(f"{URL}/none.zip!/a.bvh")
    assert not is_gone(WALKED[0])
    locations._listed.clear()
    locations._known.clear()
    for failure in (PermissionError("denied"), TimeoutError(), OSError("no route")):
        Counted.fails = failure
        assert not is_gone(f"{URL}/none.bvh")


def test_an_ingest_goes_on_where_a_store_fails(library: Library, folder: Path) -> None:
    Counted.fails = TimeoutError()
    lost, here = library.ingest(f"{URL}/a/bow.bvh", folder / "a")
    assert (lost.status, here.status) == ("failed", "added")
    assert lost.error
    assert "no answer in time, wanted a store that answers" in lost.error
    with pytest.raises(CaptureError, match="no answer in time"):
        lanindex.read(WALKED[0])
    Counted.fails = None
    locations._known.clear()
    with pytest.raises(CaptureError, match="there is no such file"):
        lanindex.read(f"{URL}/none.bvh")
    with pytest.raises(CaptureError, match="is a folder"):
        lanindex.read(URL)


def test_archives_and_companions_of_a_store(
    library: Library, store: MemoryFileSystem, folder: Path, captures: Path
) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.write(folder / "a" / "bow.bvh", "in/bow.bvh")
    store.pipe_file("/bucket/a.zip", packed.getvalue())
    member = "counted://bucket/a.zip!/in/bow.bvh"
    assert (member, "added") in statuses(library.ingest("counted://bucket"))
    assert (member, "unchanged") in statuses(library.ingest("counted://bucket/a.zip"))
    assert len(library.motion(1, 0, 1)) == 30
    for name in ("02.asf", "02_06.amc"):
        store.pipe_file(f"/bucket/{name}", (captures / "amc" / "cmu" / name).read_bytes())
    locations._listed.clear()
    (outcome,) = library.ingest("counted://bucket/02_06.amc")
    assert (outcome.status, outcome.beside) == ("added", ("counted://bucket/02.asf",))


def test_labels_name_urls_and_files_beside_their_table(
    library: Library, store: MemoryFileSystem, folder: Path, tmp_path: Path
) -> None:
    (tmp_path / "labels.csv").write_text(f"file,label\n{WALKED[0]},bow\ndance/raise.lnd,raise\n")
    library.ingest(URL, folder, labels=tmp_path / "labels.csv")
    labels = {it.path: it.label for it in library.captures()}
    assert labels[WALKED[0]] == "bow"
    assert labels[str(folder / "raise.lnd")] == "raise"
    assert not labels[WALKED[1]]
    named = (
        "https://nobody/a.bvh",
        "counted://bucket/no.zip!/a.bvh",
        "counted://bucket/no.c3d#Ada",
    )
    (tmp_path / "sent.csv").write_text(
        "file,label\ndance/raise.lnd,up\n" + ",x\n".join((*named, ""))
    )
    Counted.asked.clear()
    ingests.read_labels(tmp_path / "sent.csv", [folder / "raise.lnd"])
    assert not Counted.asked  # a table that was sent to the page asks for nothing
    store.pipe_file("/bucket/tables/l.csv", b"file,label\n../dance/raise.lnd,up\n")
    read = ingests.read_labels("counted://bucket/tables/l.csv")
    assert read == {WALKED[1]: ("up", {})}


def test_one_of_several_people_in_a_file_of_a_store(store: MemoryFileSystem) -> None:
    store.pipe_file("/bucket/trial.c3d", b"x")
    store.pipe_file("/bucket/take#1.bvh", b"y")
    assert formats.opened("counted://bucket/trial.c3d#Ada").subject == "Ada"
    assert formats.opened("counted://bucket/take#1.bvh").subject == ""


def test_a_file_url_is_the_plain_path(library: Library, tmp_path: Path) -> None:
    path = dance(tmp_path / "a b.bvh", BOW)
    assert absolute(path.as_uri()) == str(path)
    (outcome,) = library.ingest(path.as_uri())
    assert outcome.path == str(path)
    assert len(lanindex.read(path.as_uri())) == len(lanindex.read(path))
    with pytest.raises(CaptureError, match="names another computer"):
        lanindex.read("file://there/a.bvh")


def test_copies_that_were_not_used_for_longest_are_let_go(
    store: MemoryFileSystem, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(locations, "BYTES", 250)
    for name in "abc":
        store.pipe_file(f"/bucket/{name}", bytes(100))
        first = locations.local("counted://bucket/a")
        locations.local(f"counted://bucket/{name}")
    copies = list((tmp_path / "cache" / "captures").iterdir())
    assert len(copies) == 2
    assert Path(first) in copies


def test_a_copy_is_whole_or_not_there(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as cut:
        cut.setattr(Counted, "get_file", lambda self, path, to: Path(to).write_bytes(b"HIER"))
        with pytest.raises(CaptureError, match="has changed while it was read"):
            lanindex.read(WALKED[0])
    assert list((tmp_path / "cache" / "captures").iterdir()) == []
    monkeypatch.setenv("LANINDEX_CACHE", str(folder / "raise.lnd"))
    with pytest.raises(CaptureError, match=r"cannot be copied to .*LANINDEX_CACHE"):
        lanindex.read(WALKED[0])


def test_the_command_and_the_page_take_urls(library: Library, folder: Path, tmp_path: Path) -> None:
    run = partial(command.run, cwd=tmp_path)
    done = run("convert", WALKED[0], "--to", "lnd")
    assert done.stdout == run("convert", str(folder / "a" / "bow.bvh"), "--to", "lnd").stdout
    assert run("inspect", WALKED[0]).stdout.startswith(f"file         {WALKED[0]}\n")
    assert run("convert", WALKED[1], "a.bvh").returncode == 2  # a score is animated
    assert run("animate", WALKED[1]).returncode == 0
    assert (tmp_path / "raise.bvh").exists()
    library.ingest(URL, folder)
    with asking(library) as ask:
        numbers = {it.path: it.id for it in library.captures()}
        both = [numbers[path] for path in (WALKED[0], str(folder / "a" / "bow.bvh"))]
        tiles = [ask.get(f"/api/captures/{number}/motion/0").content for number in both]
        assert tiles[0] == tiles[1]
        assert ask.get("/api/captures/missing").json() == {"captures": []}


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("lost://b/a.bvh", "lost:// is opened by a package that is not installed, wanted nowhere"),
        ("nothing://b/a.bvh", "fsspec knows no nothing://"),
    ],
)
def test_a_package_that_is_missing_is_named(url: str, said: str, tmp_path: Path) -> None:
    missing = {"class": "nowhere.files.FileSystem", "err": "Install nowhere"}
    known_implementations["lost"] = missing
    try:
        done = command.run("ingest", url, cwd=tmp_path)
    finally:
        del known_implementations["lost"]
    assert done.returncode == 2
    assert said in done.stderr


def test_fsspec_is_named_where_it_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("fsspec", "fsspec.core"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(CaptureError, match=r"It comes with: pip install 'lanindex\[remote\]'"):
        lanindex.read("s3://bucket/a.bvh")


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *said: Any) -> None:
        pass


def test_a_web_server_is_walked_and_read(library: Library, folder: Path) -> None:
    pytest.importorskip("aiohttp", reason="fsspec opens http:// with aiohttp")
    (folder / "a" / "no.bvh").write_text("")
    handler = partial(_Quiet, directory=str(folder.parent))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        url = f"http://127.0.0.1:{server.server_port}/dance"
        outcomes = library.ingest(url)
        assert statuses(outcomes) == [
            (f"{url}/a/bow.bvh", "added"),
            (f"{url}/a/no.bvh", "failed"),
            (f"{url}/raise.lnd", "added"),
        ]
        local = formats.opened(folder / "a" / "bow.bvh").sha256()
        assert outcomes[0].sha256 == local
        assert is_gone(f"{url}/none.bvh")
        server.shutdown()
    locations._known.clear()
    assert not is_gone(f"{url}/none.bvh")  # nobody answers
