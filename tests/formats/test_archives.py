"""Captures in archives: found, read, exported, refused."""

import _compression
import io
import tarfile
import zipfile
from pathlib import Path
from random import Random

import pytest

from lanindex import formats
from lanindex.errors import CaptureError, LanindexError
from lanindex.formats import archives, point_tables
from lanindex.formats.file import siblings
from lanindex.pipeline.ingest import discover
from lanindex.pipeline.library import open_library

COMPASS = Path(__file__).parents[2] / "corpus" / "compass.bvh"


def zipped(path: Path, files: dict[str, bytes], **options) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, **options) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return path


def tarred(path: Path, files: dict[str, bytes], mode: str = "w:gz") -> Path:
    with tarfile.open(path, mode) as archive:
        for name, content in files.items():
            info = tarfile.TarInfo(name)
            info.size = len(content)
            archive.addfile(info, io.BytesIO(content))
    return path


@pytest.fixture
def files() -> dict[str, bytes]:
    bvh = COMPASS.read_bytes()
    return {
        "deep/er/walk.bvh": bvh[:-1],
        "walk.bvh": bvh,
        "notes.txt": b"nothing",
        "in.zip": b"PK",
        "deep/.hidden.bvh": bvh,
        "__MACOSX/walk.bvh": b"x",
    }


@pytest.fixture(params=["a.zip", "a.tar.gz", "a.tar", "a.tar.xz"])
def archive(request, tmp_path: Path, files: dict[str, bytes]) -> Path:
    path = tmp_path / request.param
    kinds = {"a.tar.gz": "w:gz", "a.tar": "w", "a.tar.xz": "w:xz"}
    return tarred(path, files, kinds[path.name]) if path.name in kinds else zipped(path, files)


def test_what_is_in_an_archive_is_found_and_read(archive: Path) -> None:
    others: list[str] = []
    found = list(discover([archive.parent], others))
    inside = [path.partition("!/")[2] for path in found]
    assert inside == ["deep/er/walk.bvh", "walk.bvh"]
    assert sorted(path.partition("!/")[2] for path in others) == ["in.zip", "notes.txt"]
    read = formats.read(found[1])
    assert (read.positions == formats.read(COMPASS).positions).all()


def test_a_packed_tar_is_unpacked_twice_at_most(tmp_path: Path, monkeypatch) -> None:
    rewound, rewind = [], _compression.DecompressReader._rewind
    monkeypatch.setattr(
        _compression.DecompressReader, "_rewind", lambda it: rewound.append(1) or rewind(it)
    )
    rows = point_tables.write(formats.read(COMPASS)).splitlines(keepends=True)
    files = {f"{it:02}.csv": b"".join(rows[: 9 + it]) for it in reversed(range(20))}
    path = tarred(tmp_path / "a.tgz", files)
    found = list(discover([path]))
    assert [one.partition("!/")[2] for one in found] == list(files)
    for one in found:
        assert formats.opened(one).content == files[one.partition("!/")[2]]
    assert len(rewound) <= 2  # once to list them, once from the first again


def test_clips_come_out_of_an_archive(archive: Path, tmp_path: Path) -> None:
    with open_library(tmp_path / "l.db", create=True) as library:
        assert [it.status for it in library.ingest(archive)] == ["added"] * 2
        assert [it.status for it in library.ingest(archive)] == ["unchanged"] * 2
        assert library.store.missing() == []
        hits = library.search("r_arm right mid")
        library.export(hits[:1], tmp_path / "out")
        archive.unlink()
        assert len(library.store.missing()) == 2
    (clip,) = (tmp_path / "out").glob("*.bvh")
    span = hits[0].span
    whole = formats.read(COMPASS).positions[span.start : span.stop]
    assert (formats.read(clip).positions == whole).all()


@pytest.mark.parametrize(
    "name", ["/etc/walk.bvh", "../walk.bvh", "a/../../w.bvh", "C:/w.bvh", "w\n.bvh"]
)
def test_names_that_lead_elsewhere_are_refused(tmp_path: Path, name: str) -> None:
    for path in (
        zipped(tmp_path / "a.zip", {name: b"x"}),
        tarred(tmp_path / "a.tgz", {name: b"x"}),
    ):
        with pytest.raises(CaptureError, match="a member called"):
            archives.members(str(path))


def test_bombs_are_refused(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(archives, "FREE", 1 << 16)
    bomb = {"walk.bvh": bytes(1 << 25)}
    with pytest.raises(CaptureError, match="to 1 at most"):
        formats.opened(f"{zipped(tmp_path / 'a.zip', bomb)}!/walk.bvh")
    with pytest.raises(CaptureError, match="in an archive of its size"):
        formats.opened(f"{tarred(tmp_path / 'a.tgz', bomb)}!/walk.bvh")
    monkeypatch.setattr(archives, "LARGEST", 1 << 20)
    with pytest.raises(CaptureError, match="1 MB at most"):
        formats.opened(f"{zipped(tmp_path / 'b.zip', bomb)}!/walk.bvh")
    monkeypatch.setattr(archives, "MANY", 3)
    with pytest.raises(CaptureError, match="more than 3 members"):
        archives.members(str(zipped(tmp_path / "c.zip", dict.fromkeys("abcd", b""))))


def test_a_member_that_is_not_there(archive: Path) -> None:
    with pytest.raises(CaptureError, match="no such file in the archive"):
        formats.read(f"{archive}!/run.bvh")
    with pytest.raises(CaptureError, match="an archive of 6 files"):
        formats.read(archive)


def test_whatever_the_bytes_only_own_errors(archive: Path, tmp_path: Path) -> None:
    content, random = archive.read_bytes(), Random(1)
    for number in range(60):
        damaged = bytearray(content)
        for _ in range(random.randrange(1, 6)):
            damaged[random.randrange(len(damaged))] = random.randrange(256)
        path = tmp_path / f"{number}{archive.name}"
        path.write_bytes(damaged[: random.choice((len(damaged), random.randrange(len(damaged))))])
        try:
            for name in archives.members(str(path)):
                formats.read(f"{path}!/{name}")
        except LanindexError:
            pass


def test_a_sibling_is_found_in_the_same_folder_of_an_archive(tmp_path: Path) -> None:
    path = zipped(tmp_path / "a.zip", {"x/01_01.amc": b"a", "x/01_01.ASF": b"s", "01_01.asf": b"t"})
    found = siblings(f"{path}!/x/01_01.amc", ".asf")
    assert [formats.opened(it).content[:] for it in found] == [b"s"]
    assert siblings(f"{path}!/x/01_01.amc", ".trc") == []


def test_an_archive_names_a_capture_in_it(tmp_path: Path) -> None:
    path = zipped(tmp_path / "pack.zip", {"01.asf": b"", "notes.pdf": b"", "walk.bvh": b""})
    with pytest.raises(CaptureError, match=r"Name what is in it: .*pack\.zip!/walk\.bvh"):
        formats.read(path)


def test_a_table_that_nobody_knows_can_be_told(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("hello")
    with pytest.raises(CaptureError, match="say what its columns are with --columns"):
        formats.read(path)
