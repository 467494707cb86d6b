"""The digest of a capture covers the files that are read with it."""

import shutil
from pathlib import Path

import pytest
from dances import dance
from made_gltf import Made, body, waving

from lanindex.errors import ExportError
from lanindex.model import Reading
from lanindex.pipeline import prepare
from lanindex.pipeline.library import Library, open_library


@pytest.fixture
def library(tmp_path: Path):
    with open_library(tmp_path / "l.db", create=True) as opened:
        yield opened


def gltf(folder: Path) -> Path:
    """Write a body that waves, its numbers in a file beside it."""
    made = Made()
    waving(made, body(made), 40)
    folder.mkdir(exist_ok=True)
    (folder / "a.bin").write_bytes(made.bytes)
    path = folder / "a.gltf"
    path.write_bytes(made.gltf("a.bin"))
    return path


def statuses(library: Library, *paths: Path, **how) -> list[str]:
    return [one.status for one in library.ingest(*paths, **how)]


def test_other_numbers_beside_a_gltf_file(library: Library, tmp_path: Path) -> None:
    path = gltf(tmp_path / "in")
    assert statuses(library, path.parent) == ["added"]
    assert statuses(library, path.parent) == ["unchanged"]
    numbers = bytearray(path.with_name("a.bin").read_bytes())
    numbers[-4:] = b"\0\0\x80\x3f"
    path.with_name("a.bin").write_bytes(numbers)
    (hit,) = library.search("r_arm place high")[:1]
    for form in ("native", "bvh"):
        with pytest.raises(ExportError, match="what it was read with has changed"):
            library.export([hit], tmp_path / "out", format=form)
    assert statuses(library, path.parent) == ["added"]
    assert statuses(library, path.parent) == ["unchanged"]
    assert library.export(library.search("r_arm place high")[:1], tmp_path / "out")
    path.with_name("a.bin").unlink()
    assert statuses(library, path.parent) == ["failed"]
    assert len(library.captures()) == 1


def test_what_lies_beside_a_file_moves_with_it(library: Library, tmp_path: Path) -> None:
    path = gltf(tmp_path / "in")
    library.ingest(path)
    path.parent.rename(tmp_path / "there")
    (moved,) = library.ingest(tmp_path / "there")
    assert (moved.status, moved.moved) == ("unchanged", str(path))


def test_the_same_file_with_other_numbers_is_no_copy(library: Library, tmp_path: Path) -> None:
    library.ingest(gltf(tmp_path / "in"))
    path = gltf(tmp_path / "other")
    path.with_name("a.bin").write_bytes(path.with_name("a.bin").read_bytes() + b"more")
    (other,) = library.ingest(path)
    assert not any("the same content" in said for said in other.warnings)
    shutil.copytree(tmp_path / "in", tmp_path / "copy")
    (copy,) = library.ingest(tmp_path / "copy")
    assert "the same content as" in copy.warnings[-1]


def test_what_is_told_of_a_body_counts(library: Library, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = dance(tmp_path / "bow.bvh")
    told = Reading(body="body.toml")
    Path("body.toml").write_text('RWrist = "RightHand"\n')
    assert statuses(library, path, reading=told) == ["added"]
    assert statuses(library, path, reading=told) == ["unchanged"]
    assert library.store.encoding("bow.bvh").options == {"body": str(tmp_path / "body.toml")}
    (tmp_path / "else").mkdir()
    monkeypatch.chdir("else")
    assert library.export(library.search("r_arm place high")[:1], "out", format="glb")
    monkeypatch.chdir(tmp_path)
    Path("body.toml").write_text('# again\nRWrist = "RightHand"\n')
    assert statuses(library, path, reading=told) == ["added"]


def test_a_library_that_does_not_know_what_lay_beside(
    library: Library, tmp_path: Path, monkeypatch
) -> None:
    path = gltf(tmp_path / "in")
    with monkeypatch.context() as patch:
        patch.setattr(prepare, "together", lambda files: "")
        library.ingest(path)
    (hit,) = library.search("r_arm place high")
    assert library.export([hit], tmp_path / "out")
    path.parent.rename(tmp_path / "there")
    (moved,) = library.ingest(tmp_path / "there")
    assert (moved.status, moved.moved) == ("added", str(path))
    assert statuses(library, tmp_path / "there") == ["unchanged"]
    assert len(library.captures()) == 1
