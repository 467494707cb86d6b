"""The staves of a library's captures."""

import json
import shutil
import sqlite3
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import ceil
from pathlib import Path
from typing import Any

import pytest
from dances import BOW, RAISE, dance

import lanindex
from lanindex.draw import strip
from lanindex.draw.strip import Staff
from lanindex.errors import ExportError, LibraryError
from lanindex.model import Span, Track
from lanindex.model.symbol import joined
from lanindex.pipeline import kept, staves
from lanindex.pipeline.kept import Latest
from lanindex.pipeline.library import Library, open_library

CORPUS = Path(__file__).parents[2] / "corpus"


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


DANCES = ("marching", "greetings", "radio_gymnastics", "port_de_bras", "traffic_police", "compass")


@pytest.fixture(scope="module")
def long_library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Library]:
    """Yield a library of one capture, several dances one after the other."""
    scores = [lanindex.encode(lanindex.read(CORPUS / f"{it}.bvh")) for it in (*DANCES, *DANCES)]
    assert {it.rate for it in scores} == {30}
    rows, frames = {part: list[Any]() for part in scores[0].tracks}, 0
    for score in scores:
        for part, track in score.tracks.items():
            own = track.symbols.copy()
            own["start"] += frames
            own["stop"] += frames
            rows[part].append(own)
        frames += score.frames
    known = (Span(0, frames),)
    tracks = {part: Track(part, joined(it), known) for part, it in rows.items()}
    whole = replace(scores[0], frames=frames, tracks=tracks)
    with lanindex.open_library(tmp_path_factory.mktemp("long") / "l.db", create=True) as library:
        library.store.add("long.bvh", whole, format="bvh", sha256="0" * 64)
        yield library


def test_windows_of_a_long_capture_are_those_of_the_whole(long_library: Library) -> None:
    usual = long_library.staff(1)
    assert usual.duration > staves.LONG
    columns = long_library.staff(1, 0, 10, near=True).tracks
    assert {*usual.tracks} <= {*columns}
    drawn = Staff(long_library.score(1), seconds=True, title="long.bvh", columns=columns)
    for start in range(0, int(usual.duration) - 7, 7):
        near = long_library.staff(1, start, start + 7, near=True)
        assert 0 < len(near.score.symbols("r_arm")) < len(drawn.score.symbols("r_arm")) / 3
        assert near.symbols(start, start + 7) == drawn.symbols(start, start + 7)
        assert near.tile(start, start + 7) == drawn.tile(start, start + 7)


def test_windows_of_a_long_capture_show_all_of_chosen_parts(long_library: Library) -> None:
    hit = long_library.search("r_arm place high -> right mid")[-1]
    for which, parts in ((1, ["r_arm", "r_support", "r_stance", "l_support"]), (hit, ["r_arm"])):
        window = {} if which is hit else {"start": 200, "stop": 207}
        near, whole = (
            long_library.staff(which, **window, parts=parts, near=it) for it in (True, False)
        )
        assert near.window == whole.window
        assert near.score is not whole.score
        assert near.svg() == whole.svg()
        assert [*near.symbols()] == [*whole.symbols()]


@pytest.mark.parametrize(("parts", "stretch"), [(None, 1.0), (["r_arm", "r_stance"], 2.0)])
def test_pieces_of_a_long_capture_are_drawn_beforehand(
    long_library: Library, parts: list[str] | None, stretch: float
) -> None:
    seconds = long_library.staff(1).duration
    starts = [at * staves.PIECE for at in range(ceil(seconds / staves.PIECE))]
    assert seconds % staves.PIECE
    ask = partial(staves.piece, long_library.store, 1, parts=parts, stretch=stretch)
    before = len(kept.CACHE)
    assert ask(0.0, staves.PIECE, begin=False) is None
    for _ in range(kept.ASIDE):
        kept.CACHE._aside.acquire()
    assert ask(0.0, staves.PIECE) is None  # others are busy
    for _ in range(kept.ASIDE):
        kept.CACHE._aside.release()
    assert len(kept.CACHE) == before
    assert ask(0.0, staves.PIECE) is None  # it begins
    (future,) = [
        it for key, it in kept.CACHE._kept.items() if key[0] == "staff" and key[-1] == stretch
    ]
    future.result(60)
    for start in starts:
        stop = min(start + staves.PIECE, seconds)
        near = long_library.staff(1, start, stop, parts=parts, stretch=stretch, near=True)
        assert json.loads(ask(start, stop, begin=False) or b"") == near.tile(start, stop)
    assert ask(1.0, 1.0 + staves.PIECE) is None
    before = len(kept.CACHE)
    assert ask(0.0, staves.PIECE, parts=["none"]) is None
    assert len(kept.CACHE) == before
    assert ask(0.0, staves.PIECE - 1) is None
    assert ask(starts[-1] + staves.PIECE, seconds) is None


def test_pieces_that_cannot_be_drawn_are_not_tried_again(
    long_library: Library, tmp_path: Path
) -> None:
    copy = tmp_path / "copy.db"
    shutil.copy(long_library.store.place, copy)
    with sqlite3.connect(copy) as connection:
        connection.execute("UPDATE symbol_code SET sign = 15 WHERE ordinal = 3")
    connection.close()
    with open_library(copy) as library:
        ask = partial(staves.piece, library.store, 1, 200.0, 210.0, ["r_arm"], 1.0)
        assert ask() is None
        (future,) = [it for key, it in kept.CACHE._kept.items() if str(copy) in key]
        assert isinstance(future.exception(60), LibraryError)
        until = time.monotonic() + 10
        while not any(str(copy) in key for key in staves.FAILED):
            assert time.monotonic() < until
            time.sleep(0.01)
        assert ask() is None
        assert not any(str(copy) in key for key in kept.CACHE._kept)


def test_pieces_of_a_short_capture_are_not(library: Library) -> None:
    assert staves.piece(library.store, 1, 0.0, library.staff(1).duration, None, 1.0) is None
    assert not any(key[0] == "staff" and key[1] == library.store.place for key in kept.CACHE._kept)


def test_a_stretch_that_is_damaged_is_refused(long_library: Library, tmp_path: Path) -> None:
    before = long_library.staff(1, 0, 7, parts=["r_arm"], near=True)
    copy = tmp_path / "copy.db"
    shutil.copy(long_library.store.place, copy)
    for change in ("start = 'x'", "length = 1 << 40", "sign = 15"):
        with sqlite3.connect(copy) as connection:
            connection.execute(f"UPDATE symbol_code SET {change} WHERE ordinal = 3")
        connection.close()
        with open_library(copy) as library, pytest.raises(LibraryError, match="is damaged"):
            library.staff(1, 0, 7, parts=["r_arm"], near=True)
        shutil.copy(long_library.store.place, copy)
    with open_library(copy) as library:
        assert library.staff(1, 0, 7, parts=["r_arm"], near=True).svg() == before.svg()
