import os
import re
from pathlib import Path
from typing import IO

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lanindex.errors import ExportError
from lanindex.pipeline.files import safe_stem, write_all


@pytest.mark.parametrize(
    ("path", "stem"),
    [
        ("a/b/walk.bvh", "walk"),
        ("C:\\takes\\walk 01.bvh", "walk 01"),
        ("../../etc/passwd", "passwd"),
        ("..", "clip"),
        (".bvh", "bvh"),
        ("-rf.bvh", "rf"),
        ("walk\n$(rm).bvh", "walk___rm_"),
        ("踊り.bvh", "踊り"),
        ("", "clip"),
        ("=1+1.bvh", "1+1"),
        ("-.@=a.bvh", "a"),
        ("e\N{COMBINING ACUTE ACCENT}tude.bvh", "étude"),
        ("नृत्य.bvh", "नृत्य"),
        ("a\x1b[31m\u202eb.bvh", "a__31m_b"),
        ("CON.bvh", "_CON"),
        ("nul.tar.bvh", "_nul.tar"),
        ("lpt1 .bvh", "_lpt1"),
        ("COM².bvh", "_COM²"),
        ("console.bvh", "console"),
        ("踊" * 83 + ".bvh", "踊" * 66),
        ("a" + "踊" * 83 + ".bvh", "a" + "踊" * 66),
        ("a" * 199 + " b.bvh", "a" * 199),
    ],
    ids=lambda text: text[:20],
)
def test_stems(path: str, stem: str) -> None:
    assert safe_stem(path) == stem


@given(st.text())
def test_a_stem_never_leaves_its_folder(path: str) -> None:
    stem = safe_stem(path)
    assert 0 < len(stem.encode()) <= 200
    assert not set(stem) & set("/\\\0\n\r\t")
    assert stem not in (".", "..")
    assert stem[0] not in ".-=+@ "


def test_all_are_written(tmp_path: Path) -> None:
    write_all([(tmp_path / "a" / "x", b"1"), (tmp_path / "y", b"2")])
    assert (tmp_path / "a" / "x").read_bytes() == b"1"
    assert (tmp_path / "y").read_bytes() == b"2"


def test_what_is_written_may_be_read_by_whom_other_files_may(tmp_path: Path) -> None:
    (tmp_path / "plain").write_bytes(b"")
    write_all([(tmp_path / "x", b"")])
    assert (tmp_path / "x").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_failure_leaves_no_trace(tmp_path: Path) -> None:
    (tmp_path / "b").write_bytes(b"old")
    with pytest.raises(ExportError, match="exists already"):
        write_all([(tmp_path / "a", b"1"), (tmp_path / "b", b"2")])
    assert [path.name for path in tmp_path.iterdir()] == ["b"]

    def broken():
        yield tmp_path / "a", b"1"
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_all(broken())
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


def test_a_folder_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    with pytest.raises(ExportError, match="is a folder"):
        write_all([(tmp_path / "a", b"")], force=True)
    (tmp_path / "file").write_bytes(b"")
    said = re.escape(f"{tmp_path / 'file'}: is a file, wanted a folder")
    for below in ("x", "y/z/x"):
        with pytest.raises(ExportError, match=said):
            write_all([(tmp_path / "file" / below, b"")])


@pytest.mark.parametrize("force", [True, False])
def test_only_regular_files_are_replaced(tmp_path: Path, force: bool) -> None:
    os.mkfifo(tmp_path / "pipe")
    os.symlink(tmp_path / "pipe", tmp_path / "link")
    for name in ("pipe", "link"):
        with pytest.raises(ExportError, match=f"{name}: is no regular file"):
            write_all([(tmp_path / name, b"")], force=force)
    assert (tmp_path / "pipe").is_fifo()
    assert (tmp_path / "link").is_symlink()


def test_a_link_to_a_file_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"old")
    os.symlink(tmp_path / "file", tmp_path / "link")
    write_all([(tmp_path / "link", b"new")], force=True)
    assert (tmp_path / "link").read_bytes() == b"new"
    assert (tmp_path / "file").read_bytes() == b"old"


def test_a_source_is_never_replaced(tmp_path: Path) -> None:
    source = tmp_path / "a.bvh"
    source.write_bytes(b"source")
    (tmp_path / "folder").mkdir()
    os.symlink(source, tmp_path / "soft")
    os.link(source, tmp_path / "hard")
    for path in (
        source,
        tmp_path / "folder" / ".." / "a.bvh",
        tmp_path / "soft",
        tmp_path / "hard",
    ):
        with pytest.raises(ExportError, match="is the file that is read, wanted another file"):
            write_all([(path, b"new")], force=True, sources=[source])
    assert source.read_bytes() == b"source"
    assert (tmp_path / "soft").is_symlink()
    write_all([(tmp_path / "b.bvh", b"new")], sources=[source])
    write_all([(tmp_path / "c.bvh", b"new")], sources=[tmp_path / "gone"])


def test_sources_too_many_to_list_are_asked_for_once(tmp_path: Path) -> None:
    for name in "abc":
        (tmp_path / name).write_bytes(b"old")
    os.link(tmp_path / "b", tmp_path / "source")
    asked = []

    def suspects(replaced):
        asked.append([path.name for path in replaced])
        return [str(tmp_path / "gone"), str(tmp_path / "source")]

    def write(*names: str) -> None:
        files = [(tmp_path / name, b"new") for name in names]
        write_all(files, force=True, suspects=suspects)

    with pytest.raises(ExportError, match=r"b: is the file that is read, wanted another file"):
        write("a", "new", "b")
    assert (tmp_path / "a").read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b", "c", "source"]
    write("new")
    write("new", "c")
    assert asked == [["a", "b"], ["new", "c"]]
    assert (tmp_path / "c").read_bytes() == b"new"


def test_a_dead_link_is_not_followed(tmp_path: Path) -> None:
    os.symlink(tmp_path / "outside", tmp_path / "link")
    with pytest.raises(ExportError, match="exists already"):
        write_all([(tmp_path / "link", b"1")])
    write_all([(tmp_path / "link", b"1")], force=True)
    assert not (tmp_path / "outside").exists()


def test_folders_that_were_made_for_nothing_go_again(tmp_path: Path) -> None:
    def broken(file: IO[bytes]) -> None:
        raise OSError(28, "No space left on device")

    (tmp_path / "own").mkdir()
    files = [(tmp_path / "own/a/b/one", b"1"), (tmp_path / "own/a/two", broken)]
    with pytest.raises(ExportError, match="No space left"):
        write_all(files)
    assert list(tmp_path.iterdir()) == [tmp_path / "own"]
    assert list((tmp_path / "own").iterdir()) == []
