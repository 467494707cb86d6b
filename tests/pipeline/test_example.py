"""Search by example in a library: what may be an example, and what results say."""

import json
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dances import BOW, RAISE, dance
from made_clips import clips_of

from lanindex.errors import CaptureError, LanindexError, UsageError
from lanindex.library.selection import Selection
from lanindex.library.store import Store
from lanindex.model import Span
from lanindex.pipeline import example
from lanindex.pipeline.example import Alike, source_of
from lanindex.pipeline.library import Library, open_library
from lanindex.search.example import likeness

TWICE = RAISE.replace("unit_total 2", "unit_total 8") + "".join(
    f"#unit{unit}\ndirection r_arm {cell} mid 0.5 1.5\ndirection r_arm place low 2 3.5\n"
    for unit, cell in ((4, "left"), (5, "back"), (6, "left"), (7, "back"))
)


@pytest.fixture
def library(tmp_path: Path):
    dance(tmp_path / "raise.bvh")
    dance(tmp_path / "again.bvh", rate=60)
    dance(tmp_path / "bow.bvh", BOW)
    dance(tmp_path / "long.bvh", TWICE)
    (tmp_path / "raise.lnd").write_text(RAISE)
    with open_library(tmp_path / "l.db", create=True) as opened:
        opened.ingest(tmp_path)
        yield opened


def names(hits) -> list[str]:
    return [Path(hit.path).name for hit in hits]


def test_the_likest_is_first_and_the_example_is_left_out(library: Library) -> None:
    found = library.like("raise.bvh")
    assert set(names(found.hits)[:2]) == {"again.bvh", "long.bvh"}  # which begins alike
    assert "raise.bvh" not in names(found.hits)
    assert found.hits[1].fit > 0.9
    assert list(found.hits) == list(found.hits.by_fit())
    assert (found.captures, found.sure) == (4, True)
    assert all(symbol.part == found.hits[0].symbols[0].part for symbol in found.hits[0].symbols)


def test_a_file_a_number_and_a_hit_are_examples_too(library: Library, tmp_path: Path) -> None:
    wanted = [(hit.path, hit.span, round(hit.fit, 5)) for hit in library.like("raise.bvh").hits]
    elsewhere = tmp_path / "elsewhere" / "same.bvh"
    elsewhere.parent.mkdir()
    elsewhere.write_bytes((tmp_path / "raise.bvh").read_bytes())
    number = library.capture("raise.bvh").id
    frames = library.capture("raise.bvh").frames
    line = {"capture": str(tmp_path / "raise.bvh"), "start_frame": 0, "end_frame": frames}
    for named in (number, str(number), json.dumps(line), f"raise.bvh:0-{frames}"):
        told = [(hit.path, hit.span, round(hit.fit, 5)) for hit in library.like(named).hits]
        assert told == wanted
    outside = {Path(hit.path).name: hit.fit for hit in library.like(elsewhere).hits}
    assert outside["raise.bvh"] == pytest.approx(1)
    assert outside["bow.bvh"] < 0.5 < outside["again.bvh"]


def test_of_a_long_capture_the_best_stretch_is_told(library: Library) -> None:
    hits = {Path(hit.path).name: hit for hit in library.like("raise.bvh").hits}
    hit = hits["long.bvh"]
    assert hit.span.stop <= library.capture("raise.bvh").frames + 15
    assert hit.fit > 0.8
    assert hits["again.bvh"].span.stop == library.capture("again.bvh").frames


def test_only_captures_that_fit_are_looked_through(library: Library) -> None:
    assert names(library.like("raise.bvh", Selection("*.lnd")).hits) == ["raise.lnd"]
    assert names(library.like("raise.bvh", Selection(where={"format": "lnd"})).hits) == [
        "raise.lnd"
    ]
    assert len(library.like("raise.bvh", limit=1).hits) == 1
    assert names(library.like("raise.bvh", Selection("none")).hits) == []


def test_a_large_library_is_read_in_parts(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def told(found: Alike) -> list[tuple[str, Span, float]]:
        return [(hit.path, hit.span, hit.fit) for hit in found.hits]

    wanted, parts, source_of = told(library.like("raise.bvh")), [], example.source_of

    def counted(store: Store, numbers: Iterable[int] | None, *others: Any) -> Any:
        parts.append(numbers)
        return source_of(store, numbers, *others)

    def written(store: Store, numbers: Iterable[int] | None, *others: Any) -> Any:
        with open_library(tmp_path / "l.db") as other:
            other.label(2, f"{len(parts)}")
        return counted(store, numbers, *others)

    monkeypatch.setattr(likeness, "TOGETHER", 2)
    for read, reads in ((counted, [2, 2, 4]), (written, [2, None])):
        parts.clear()
        monkeypatch.setattr(example, "source_of", read)
        assert told(library.like("raise.bvh")) == wanted
        assert [None if it is None else len(it) for it in parts] == reads


def test_captures_are_laid_out_as_their_rows_would_be(library: Library) -> None:
    score = library.score("long.bvh")
    symbols = score.tracks["r_arm"].symbols.copy()
    symbols["swings"] = np.arange(len(symbols)) % 3
    symbols["passing"] = np.arange(len(symbols)) % 4 == 2
    tracks = {**score.tracks, "r_arm": replace(score.tracks["r_arm"], symbols=symbols)}
    library.store.add("own.lnd", replace(score, tracks=tracks), format="lnd", sha256="0")
    library.store.cache.compact()
    held = list(library.tracks())
    rows = [{part: one.symbols for part, one in tracks.items()} for _, tracks in held]
    rates = [float(capture.rate) for capture, _ in held]
    wanted = clips_of(rows, rates, library.parts())
    roster, source = source_of(library.store, None, library.parts())
    found = source.clips(np.arange(len(source)))
    assert roster.number.tolist() == [capture.id for capture, _ in held]
    assert np.array_equal(found.first, wanted.first)
    for name in ("points", "sizes", "paces", "swings", "starts", "stops", "rows"):
        np.testing.assert_array_equal(getattr(found.moves, name), getattr(wanted.moves, name))


def test_what_takes_too_long_is_broken_off(library: Library) -> None:
    for ask in (library.similar, library.motifs, lambda **how: library.like("raise.bvh", **how)):
        with pytest.raises(LanindexError, match="longer than 0 s, and was through with 0 of"):
            ask(timeout=0)


@pytest.mark.parametrize(
    ("named", "message"),
    [
        ("none.bvh", r"no capture and no file none.bvh"),
        ("raise.bvh:9-9", r"frames 9 to 9, wanted from less than to, and no more than its"),
        ("raise.bvh:0-99999", r"frames 0 to 99999"),
        ("raise.bvh:0-2", r"nothing moves there, wanted one movement at least"),
        ('{"capture": 1}', r"capture is 1, wanted text"),
        ("{", r"wanted a line of"),
        (99, r"there is no capture 99"),
    ],
)
def test_what_is_no_example_is_told(library: Library, named, message: str) -> None:
    with pytest.raises(Exception, match=message) as caught:
        library.like(named)
    assert caught.type.__module__ == "lanindex.errors"


def test_a_limit_is_one_at_least(library: Library) -> None:
    with pytest.raises(UsageError, match="a limit of 0"):
        library.like("raise.bvh", limit=0)


def test_a_file_that_cannot_be_read_is_told(library: Library, tmp_path: Path) -> None:
    (tmp_path / "empty.bvh").write_text("")
    with pytest.raises(CaptureError, match=r"empty\.bvh"):
        library.like(tmp_path / "empty.bvh")


def test_the_best_are_ranked_by_their_joints(library: Library, tmp_path: Path) -> None:
    found = library.like("raise.bvh", rerank=True)
    assert "again.bvh" in names(found.hits)[:2]
    assert "raise.lnd" not in names(found.hits)  # a score has no joints
    likeness = [hit.fit for hit in found.hits]
    assert likeness == sorted(likeness, reverse=True)
    assert likeness[0] > 0.9 > likeness[-1]
    assert [line for line in found.notes if "a score has no joints" in line] == list(found.notes)


def test_files_that_are_gone_or_changed_are_told(library: Library, tmp_path: Path) -> None:
    before = library.like("raise.bvh", rerank=True)
    (tmp_path / "again.bvh").unlink()
    dance(tmp_path / "bow.bvh", BOW, rate=25)
    found = library.like("raise.bvh", rerank=True)
    assert set(names(found.hits)) == {*names(before.hits)} - {"again.bvh", "bow.bvh"}
    assert len(found.notes) == 3
    assert any("again.bvh" in line for line in found.notes)
    assert any("bow.bvh: has changed since" in line for line in found.notes)
    (tmp_path / "raise.bvh").unlink()
    with pytest.raises(UsageError, match=r"--rerank: no joint positions: .*raise\.bvh"):
        library.like("raise.bvh", rerank=True)
    with pytest.raises(UsageError, match="a score has no joints"):
        library.like("raise.lnd", rerank=True)
