"""Windows of a capture's figure are those of the whole, and what is kept is bounded."""

import os
import socket
import subprocess
import sys
import threading
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dances import BOW, RAISE, dance
from made_c3d import STANDING, c3d, standing

import lanindex
from lanindex import formats
from lanindex.errors import CaptureError, ExportError, UsageError
from lanindex.film.figure import Figure, figure
from lanindex.formats import file as files
from lanindex.model import Reading
from lanindex.pipeline import kept, motion
from lanindex.pipeline.kept import Cache, Made
from lanindex.pipeline.library import Library, open_library

CORPUS = Path(__file__).parents[2] / "corpus"
ALL = formats.Wanted(body_only=True)


@pytest.fixture
def library(tmp_path: Path):
    dance(tmp_path / "bow.bvh", BOW)
    (tmp_path / "raise.lnd").write_text(RAISE)
    with open_library(tmp_path / "l.db", create=True) as opened:
        opened.ingest(tmp_path)
        yield opened


@pytest.fixture
def cache() -> Cache:
    return Cache()


def same(window: Figure, whole: Figure, first: int) -> bool:
    last = first + len(window)
    return (
        np.array_equal(window.places, whole.places[first:last], equal_nan=True)
        and np.array_equal(window.fronts, whole.fronts[first:last])
        and np.array_equal(window.bones, whole.bones)
        and window.parts == whole.parts
    )


def test_windows_are_those_of_the_whole(library: Library, tmp_path: Path) -> None:
    whole = figure(lanindex.read(tmp_path / "bow.bvh"))
    assert same(library.motion("bow.bvh"), whole, 0)
    first = round(1.1 * whole.rate)
    window = library.motion("bow.bvh", 1.1, 2.3)
    assert (len(window), window.rate) == (round(1.2 * whole.rate), whole.rate)
    assert same(window, whole, first)
    with pytest.raises(UsageError, match="nothing from 2 s to 1 s"):
        library.motion("bow.bvh", 2, 1)


def test_a_score_is_performed(library: Library) -> None:
    score = lanindex.read_lnd(RAISE)
    whole = figure(lanindex.animate(score))
    window = library.motion("raise.lnd", 0.5, 1.0)
    assert window.rate == 60
    assert same(window, whole, 30)
    assert len(library.motion("raise.lnd")) == len(whole)


def test_a_long_score_is_performed_aside(
    library: Library, cache: Cache, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = library.motion("raise.lnd")
    monkeypatch.setattr(motion, "MANY", 3)
    monkeypatch.setattr(motion, "_performed", None)  # not here
    again = motion.motion(library.store, "raise.lnd", cache=cache)
    assert same(again, whole, 0)


def test_a_score_that_is_too_long_is_performed_slower(
    library: Library, cache: Cache, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(motion, "LONGEST", 31)
    long = library.capture("raise.lnd")
    rate = motion.rate_of(long)
    assert rate == 30 // (long.frames / long.rate) < 60
    window = motion.motion(library.store, "raise.lnd", fps=60, cache=cache)
    assert (window.rate, len(window)) == (rate, rate * long.frames / long.rate)


def test_slower_windows_fit_together(library: Library) -> None:
    whole = library.motion("bow.bvh", fps=7)
    assert whole.rate == 7
    pieces = [library.motion("bow.bvh", at, at + 0.5, fps=7).places for at in (0.0, 0.5, 1.0)]
    joined = np.concatenate(pieces)
    assert np.array_equal(joined, whole.places[: len(joined)])
    source = library.motion("bow.bvh")
    at = [int(Fraction(frame) * source.rate / 7) for frame in range(len(joined))]
    assert np.array_equal(joined, source.places[at])
    assert library.motion("bow.bvh", fps=1000).rate == source.rate
    with pytest.raises(UsageError, match="0 frames a second"):
        library.motion("bow.bvh", fps=0)


def test_people_and_options_are_those_of_the_ingest(library: Library, tmp_path: Path) -> None:
    one = standing(60)
    two = np.concatenate([one, np.add(one, (0, 900, 0, 0))], 1)
    path = tmp_path / "trial.c3d"
    path.write_bytes(c3d(two, [f"{name}:{it}" for name in ("Ada", "Bob") for it in STANDING]))
    library.ingest(path, reading=Reading(rate=10))
    ada, bob = (library.motion(f"trial.c3d#{name}", 1, 2) for name in ("Ada", "Bob"))
    assert (ada.rate, len(ada)) == (10, 10)
    apart = np.nanmedian(bob.places - ada.places, axis=(0, 1))
    assert np.abs(apart).max() == pytest.approx(900, abs=1)


def test_a_source_that_changed_or_is_gone_is_refused(library: Library, tmp_path: Path) -> None:
    path = tmp_path / "bow.bvh"
    library.motion("bow.bvh")  # it is kept, and refused all the same
    content = path.read_bytes()
    path.write_bytes(content.replace(b"Frames:", b"Frames: "))
    with pytest.raises(ExportError, match=r"has changed since it was ingested.*Ingest it again"):
        library.motion("bow.bvh", 0, 1)
    path.write_bytes(content)
    assert len(library.motion("bow.bvh", 0, 1))
    path.unlink()
    with pytest.raises(ExportError, match=r"there is no such file.*remove --missing"):
        library.motion("bow.bvh", 0, 1)


def test_a_large_file_is_read_aside_and_windows_meanwhile(
    library: Library, tmp_path: Path, cache: Cache, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "WHOLE", 0)
    whole = figure(lanindex.read(tmp_path / "bow.bvh"))
    store = library.store
    for _ in range(kept.ASIDE):
        cache._aside.acquire()  # no process begins
    window = motion.motion(store, "bow.bvh", 1, 2, cache=cache)
    assert not cache.holds(next(iter(cache._kept)))
    assert same(window, whole, int(whole.rate))
    for _ in range(kept.ASIDE):
        cache._aside.release()
    (future,) = cache._kept.values()
    future.result(60)
    monkeypatch.setattr(motion, "_stretch", None)
    assert same(motion.motion(store, "bow.bvh", 1, 2, cache=cache), whole, int(whole.rate))
    assert same(motion.motion(store, "bow.bvh", cache=cache), whole, 0)


def test_a_large_file_is_shown_before_it_is_known_to_be_the_same(
    library: Library, tmp_path: Path, cache: Cache, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "WHOLE", 0)
    path, go, check = tmp_path / "bow.bvh", threading.Event(), motion.check_source

    def checked(*of: Any) -> formats.File:
        go.wait(30)
        return check(*of)

    monkeypatch.setattr(motion, "check_source", checked)
    content = path.read_bytes()
    path.write_bytes(content.replace(b"Frames:", b"Frames: "))
    early = partial(motion.motion, library.store, "bow.bvh", 0, 1, cache=cache, wait=False)
    assert len(early())
    go.set()
    for ask in (partial(motion.check, library.store, "bow.bvh"), early):
        with pytest.raises(ExportError, match=r"has changed since it was ingested"):
            ask()
    assert not len(cache)  # nothing is made of it
    path.write_bytes(content)
    motion.check(library.store, "bow.bvh")
    assert len(early())
    assert len(cache) == 1


def test_errors_come_from_the_other_process(cache: Cache, tmp_path: Path) -> None:
    arguments = {"path": str(tmp_path / "none.bvh"), "options": {}, "frames": 1}
    for _ in range(2):  # what failed is not kept
        with pytest.raises(CaptureError, match=r"none\.bvh: there is no such file"):
            cache.get("none", motion.figured, arguments, aside=True)
    with pytest.raises(ExportError, match=r"the process that read it ended \(9\)"):
        cache.get("dead", os._exit, {"status": 9}, aside=True)
    assert not len(cache)


def test_the_other_process_ends_with_the_first() -> None:
    slow = (
        "import socket, sys, threading, time; from lanindex.pipeline import kept; "
        "threading.Thread(target=kept._end_with_parent, daemon=True).start(); "
        "line = socket.create_connection(('127.0.0.1', %d)); line.send(b'.'); time.sleep(120)"
    )
    code = (
        "import sys; from lanindex.pipeline import kept; kept._CHILD = sys.argv[1]; "
        "kept.CACHE.get('slow', kept.child, {}, aside=True)"
    )
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(60)
        command = [sys.executable, "-c", code, slow % listener.getsockname()[1]]
        with subprocess.Popen(command) as first:
            line, _ = listener.accept()
            with line:
                line.settimeout(60)
                assert line.recv(1) == b"."
                first.kill()
                assert line.recv(1) == b""


def numbered(number: int) -> Made:
    return {"number": number}, {"rows": np.full((100, 2), number, np.int32)}


def test_the_least_recently_used_is_let_go() -> None:
    cache = Cache(most_bytes=2500, most=9)
    for number in (1, 2, 1, 3):
        got = cache.get(number, numbered, {"number": number}, aside=False)
        assert got.about == {"number": number}
        assert got.window("rows", 98).tolist() == [[number, number]] * 2
    assert [cache.holds(it) for it in (1, 2, 3)] == [True, False, True]
    few = Cache(most=2)
    for number in range(5):
        few.get(number, numbered, {"number": number}, aside=False)
    assert len(few) == 2
    assert few.holds(4)


def test_several_threads_wait_for_one(cache: Cache) -> None:
    begun, go, found = [], threading.Event(), list[int]()

    def slow() -> Made:
        begun.append(1)
        go.wait(30)
        return numbered(7)

    def ask() -> None:
        rows = cache.get("one", slow, {}, aside=False)
        found.extend(int(rows.window("rows", at, at + 1)[0, 0]) for at in range(100))

    threads = [threading.Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    go.set()
    for thread in threads:
        thread.join(30)
    assert (len(begun), found) == (1, [7] * 800)


def test_stretches_of_real_captures_are_those_of_the_whole(captures: Path) -> None:
    folders = sorted(it for it in (captures / "bvh").iterdir() if it.is_dir())
    tried = 0
    for folder in folders:
        path = min(folder.rglob("*.bvh"), key=lambda it: (it.stat().st_size, it))
        file = formats.opened(path)
        whole = figure(formats.read_file(file, Reading(), formats.Wanted(True)))
        for first in sorted({0, min(1, len(whole) - 1), len(whole) // 2, len(whole) - 1}):
            shown = np.arange(first, min(first + 50, len(whole)))
            part = motion._stretch(file, Reading(), shown, whole.rate, len(whole))
            assert same(part, whole, first), f"{path}: frame {first}"
            tried += 1
    assert tried > 20


def test_stretches_of_real_points_are_those_of_the_whole(captures: Path) -> None:
    tried, most = 0, 0.0
    for kind in ("trc", "c3d", "csv"):
        for path in sorted((captures / kind).rglob(f"*.{kind}")):
            if path.name == "optotrak_unlabelled.c3d":  # no body
                continue
            file = formats.opened(path)
            read = formats.read_file(file, Reading(), formats.Wanted(True))
            whole = figure(read)
            large = replace(file, content=Parts(file.content[:]), results={})
            for first in (0, len(whole) // 2, len(whole) - 1):
                shown = np.arange(first, min(first + 50, len(whole)))
                how = Reading(rate=read.rate), shown, whole.rate, len(whole)
                part = motion._stretch(large, *how)
                assert part is not None
                assert part.parts == whole.parts
                assert np.array_equal(np.isnan(part.places), np.isnan(whole.places[shown]))
                apart = np.abs(part.places - whole.places[shown])
                most, tried = max(most, float(np.nanmax(apart, initial=0))), tried + 1
    assert tried > 40
    assert most < 0.1  # mm: of markers, how far joints are from them is the median of some frames


class Parts:
    """Content that counts how much of it is fetched, as if it lay on a disk."""

    def __init__(self, data: bytes) -> None:
        self.data, self.fetched = data, 0

    def __len__(self) -> int:
        return len(self.data)

    def __getitem__(self, piece: slice) -> bytes:
        found = self.data[piece]
        self.fetched += len(found)
        return found


def test_a_window_of_points_is_read_without_all_others() -> None:
    read = lanindex.read(CORPUS / "compass.bvh")
    long = replace(read, positions=np.tile(read.positions, (20, 1, 1)), axes={})
    shown = np.arange(10_000, 10_050)
    for form in ("trc", "c3d", "csv"):
        written = next(it for it in formats.FORMATS if it.name == form).does.write(long)
        file = formats.File(f"long.{form}", Parts(written))
        part = motion._stretch(file, Reading(rate=30), shown, long.rate, len(long))
        assert part is not None
        whole = figure(formats.read_file(replace(file, content=written), Reading(), ALL))
        assert np.nanmax(np.abs(part.places - whole.places[shown])) < 0.01
        most = 0.2 if form == "c3d" else 1.5  # lines are looked for in all of a text, once
        assert file.content.fetched < most * len(written)
        file.content.fetched = 0
        motion._stretch(file, Reading(rate=30), shown - 5000, long.rate, len(long))
        assert file.content.fetched < 0.2 * len(written)
