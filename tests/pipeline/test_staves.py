"""The staves of a library's captures."""

import threading
from pathlib import Path

import pytest
from dances import BOW, RAISE, dance

from lanindex.draw import strip
from lanindex.errors import ExportError
from lanindex.pipeline import staves
from lanindex.pipeline.kept import Latest
from lanindex.pipeline.library import Library, open_library


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(staves, "KEPT", Latest(2))
    dance(tmp_path / "bow.bvh", BOW)
    (tmp_path / "raise.lnd").write_text(RAISE)
    with open_library(tmp_path / "l.db", create=True) as opened:
        opened.ingest(tmp_path)
        yield opened


def test_a_hit_is_a_window_with_its_symbols_marked(library: Library) -> None:
    hit = library.search("r_arm place high")[0]
    staff = library.staff(hit)
    rate = hit.capture.rate
    assert staff.window == (float(hit.start / rate), float(hit.stop / rate))
    assert 'data-part="r_arm"' in staff.svg()
    assert any(getattr(it, "style", "") == "band" for it in staff.picture().marks)
    assert library.staff(hit, 0, 1).window == (0, 1)


def test_a_score_counts_beats_and_a_capture_seconds(library: Library) -> None:
    score, bow = library.staff("raise.lnd"), library.staff("bow.bvh")
    assert bow.y(0) - bow.y(1) == pytest.approx(56)
    beats = float(library.score("raise.lnd").meter.speed) / 60
    assert score.y(0) - score.y(1) == pytest.approx(56 * beats)


def test_a_staff_is_made_once_for_all_threads(
    library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []
    whole, go = strip.Staff.__init__, threading.Event()

    def counted(self, *given, **named) -> None:
        made.append(1)
        go.wait(10)
        whole(self, *given, **named)

    monkeypatch.setattr(strip.Staff, "__init__", counted)
    drawn: list[str] = []
    score = library.score("bow.bvh")
    monkeypatch.setattr(library.store, "score", lambda which: score)
    capture, encoding = library.capture("bow.bvh"), library.store.encoding(1)
    monkeypatch.setattr(library.store, "capture", lambda which: capture)
    monkeypatch.setattr(library.store, "encoding", lambda which: encoding)
    threads = [
        threading.Thread(target=lambda: drawn.append(library.staff("bow.bvh").svg(0, 1)))
        for _ in range(6)
    ]
    for thread in threads:
        thread.start()
    go.set()
    for thread in threads:
        thread.join(30)
    assert (len(made), len({*drawn}), len(drawn)) == (1, 1, 6)


def test_few_staves_are_kept_and_each_has_its_own_columns(library: Library) -> None:
    assert [*library.staff("bow.bvh", parts=["l_leg"]).columns] == ["l_leg"]
    assert [*library.staff("bow.bvh", parts=["head"]).columns] == ["head"]
    assert "r_arm" in library.staff("bow.bvh").columns
    assert len(staves.KEPT) == 2


def test_a_capture_that_is_ingested_anew_has_a_new_staff(library: Library, tmp_path: Path) -> None:
    before = library.staff("raise.lnd").svg()
    (tmp_path / "raise.lnd").write_text(RAISE.replace("high", "low"))
    library.ingest(tmp_path / "raise.lnd")
    assert library.staff("raise.lnd").svg() != before


def test_a_hit_of_another_library_is_refused(library: Library, tmp_path: Path) -> None:
    hit = library.search("r_arm place high")[0]
    with open_library(tmp_path / "other.db", create=True) as other:
        other.ingest(tmp_path / "bow.bvh")
        with pytest.raises(ExportError, match="Search this library again"):
            other.staff(hit)
