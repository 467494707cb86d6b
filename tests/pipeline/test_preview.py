"""Previews of hits: missing and changed sources are named, the others drawn."""

from pathlib import Path

import pytest
from dances import BOW, RAISE, dance

from lanindex.errors import ExportError
from lanindex.pipeline import preview as previews
from lanindex.pipeline.library import Library, open_library
from lanindex.pipeline.preview import preview


@pytest.fixture
def library(tmp_path: Path):
    for name in ("one", "two", "three"):
        dance(tmp_path / f"{name}.bvh", RAISE.replace("#speed=60", f"#speed=60\n//{name}"))
    (tmp_path / "four.lnd").write_text(RAISE)
    dance(tmp_path / "bow.bvh", BOW)
    with open_library(tmp_path / "l.db", create=True) as opened:
        opened.ingest(tmp_path)
        yield opened


def shown(library: Library, path: str, pattern: str = "r_arm place high"):
    return list(preview(library.store, library.search(pattern), Path(path)))


def test_a_score_is_carried_out(library: Library) -> None:
    ((file, content, troubles),) = shown(library, "hits.html")
    assert (file, troubles) == (Path("hits.html"), [])
    assert content.decode().count("data-joints=") == 4
    assert content.decode().count('class="poses"') == 4
    assert content.decode().count('class="staff"') == 4


def test_what_is_gone_or_changed_is_said_and_all_else_drawn(
    library: Library, tmp_path: Path
) -> None:
    (tmp_path / "one.bvh").unlink()
    (tmp_path / "two.bvh").write_text("HIERARCHY")
    ((_, content, troubles),) = shown(library, "hits.html")
    assert len(troubles) == 2
    gone, changed = sorted(troubles)
    assert f"{tmp_path}/one.bvh 1.27-2.00 s: " in gone
    assert "has changed since it was ingested. Ingest it again" in changed
    text = content.decode()
    assert (text.count("data-joints="), text.count('class="trouble"')) == (2, 2)
    assert text.count('class="staff"') == 4
    ((_, drawn, troubles),) = shown(library, "hits.svg")
    assert len(troubles) == 2
    assert b"has changed since" in drawn


def test_each_capture_is_read_once(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    read, told = [], []
    original = previews.stored_motion

    def counted(library, capture, rate):
        read.append(capture.path)
        return original(library, capture, rate)

    monkeypatch.setattr(previews, "stored_motion", counted)
    hits = library.search("arm any", overlaps="all")
    assert len(hits) > 12
    mixed = hits.arranged(sorted(range(len(hits)), key=lambda it: it % 3))
    ((_, content, _),) = preview(library.store, mixed, Path("a.html"), lambda *it: told.append(it))
    assert len(read) == 5
    assert len({*read}) == 5
    assert told[-1] == ("hits", len(hits), len(hits))
    order = [f">{hit.path}<" for hit in mixed]
    text, at = content.decode(), 0
    for path in order:  # in their own order
        at = text.index(path, at) + 1


def test_a_sheet_that_is_full_goes_on_in_another(
    library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(previews, "SHEET_HITS", 3)
    files = shown(library, "some/contact.svg")
    assert [str(file) for file, *_ in files] == ["some/contact.svg", "some/contact-2.svg"]
    assert [content.count(b'stroke="#ccc"') for _, content, _ in files] == [3, 1]
    assert shown(library, "hits.html")[0][1].count(b"<li ") == 4


def test_forms_are_told_by_endings(library: Library) -> None:
    assert shown(library, "a.PNG")[0][1].startswith(b"\x89PNG")
    assert shown(library, "a.svg")[0][1].startswith(b"<svg")


def test_what_makes_pictures_may_be_missing(
    library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "resvg_py", None)
    with pytest.raises(ExportError, match=r"pip install 'lanindex\[pictures\]'"):
        shown(library, "a.png")
    assert shown(library, "a.svg")
    assert shown(library, "a.html")
