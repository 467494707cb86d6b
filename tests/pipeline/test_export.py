import csv
import io
import json
import os
import re
from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from dances import BOW, RAISE, dance
from film_frames import seen

from lanindex.errors import ExportError, UsageError
from lanindex.film.figure import PALETTE
from lanindex.film.film import Film
from lanindex.formats import read
from lanindex.formats.bvh import scan
from lanindex.library.selection import Selection
from lanindex.library.store import Store
from lanindex.model import Span
from lanindex.notation import lnd
from lanindex.pipeline import preview
from lanindex.pipeline.export import ClipOptions, clips, export, pad_frames
from lanindex.pipeline.library import Library, open_library
from lanindex.pipeline.named import Request, from_hits, from_lines, from_range, matched


@pytest.fixture
def library(tmp_path: Path):
    with ingested(tmp_path) as opened:
        yield opened


@pytest.fixture(scope="module")
def untouched(tmp_path_factory: pytest.TempPathFactory):
    """Return a library for tests that change neither it nor its captures."""
    with ingested(tmp_path_factory.mktemp("untouched")) as opened:
        yield opened


@contextmanager
def ingested(folder: Path):
    dance(folder / "raise.bvh")
    dance(folder / "bow.bvh", BOW)
    (folder / "score.lnd").write_text(RAISE)
    with open_library(folder / "l.db", create=True) as opened:
        opened.ingest(folder)
        yield opened


def frame_lines(data: bytes) -> list[bytes]:
    return data[data.index(b"Frame Time:") :].splitlines(keepends=True)[1:]


@pytest.mark.parametrize("newline", [b"\n", b"\r\n"])
@pytest.mark.parametrize("last_newline", [True, False])
def test_clips_are_the_sources_bytes(
    tmp_path: Path, library: Library, newline: bytes, last_newline: bool
) -> None:
    source = tmp_path / "raise.bvh"
    data = source.read_bytes().replace(b"\n", newline)
    source.write_bytes(data if last_newline else data.removesuffix(newline))
    library.ingest(source)
    data = source.read_bytes()
    capture = library.capture(str(source))
    spans = [Span(0, 1), Span(7, 40), Span(200, capture.frames), Span(0, capture.frames)]
    rows = export(library.store, [Request(capture, span) for span in spans], tmp_path / "out")
    for row, span in zip(rows, spans, strict=True):
        clip = (tmp_path / "out" / row["clip"]).read_bytes()
        count = b"Frames: " + str(len(span)).encode()
        head = data[: data.index(b"Frame Time:")]
        assert clip[: clip.index(b"Frame Time:")] == head.replace(
            b"Frames: " + str(capture.frames).encode(), count
        )
        assert frame_lines(clip) == frame_lines(data)[span.start : span.stop]
        assert read(tmp_path / "out" / row["clip"]).positions.tobytes() == (
            read(source).positions[span.start : span.stop].tobytes()
        )
    whole = (tmp_path / "out" / rows[-1]["clip"]).read_bytes()
    assert whole == data


def test_hits_become_clips_with_scores_and_a_manifest(tmp_path: Path, library: Library) -> None:
    hits = library.search("r_arm right mid -> place high", Selection("raise.bvh"))
    rows = library.export(hits, tmp_path / "out", pad="0.5s")
    (hit,), (row,) = hits, rows
    assert row["clip"] == f"raise_{hit.span.start - 15}-{hit.span.stop + 15}.bvh"
    assert (row["hit_start_frame"], row["hit_end_frame"]) == (hit.span.start, hit.span.stop)
    assert len(scan((tmp_path / "out" / row["clip"]).read_bytes()).frames) == len(hit.span) + 30
    score = lnd.read(tmp_path / "out" / row["clip"].replace(".bvh", ".lnd"))
    said = [f"{one.direction} {one.level}" for one in score.symbols("r_arm")]
    assert said == ["place low", "right mid", "place high"]
    manifest = (tmp_path / "out" / "manifest.jsonl").read_text()
    assert [json.loads(line) for line in manifest.splitlines()] == rows
    (line,) = csv.DictReader(io.StringIO((tmp_path / "out" / "manifest.csv").read_text()))
    assert line["pattern"] == "r_arm right mid -> place high"
    assert line["symbols"].startswith("r_arm right mid ")


def test_scores_are_exported_as_scores(tmp_path: Path, library: Library) -> None:
    hits = library.search("r_arm place high", Selection("*.lnd"))
    (row,) = library.export(hits, tmp_path / "out")
    assert row["clip"].endswith(".lnd")
    score = lnd.read(tmp_path / "out" / row["clip"])
    assert [one.direction for one in score.symbols("r_arm")] == ["right", "place"]


def test_padding_is_clamped(tmp_path: Path, library: Library) -> None:
    capture = library.capture("bow.bvh")
    (row,) = export(
        library.store, [Request(capture, Span(5, 20))], tmp_path / "out", ClipOptions(pad="60s")
    )
    assert (row["clip_start_frame"], row["clip_end_frame"]) == (0, capture.frames)


def test_no_name_twice(tmp_path: Path, library: Library) -> None:
    dance(tmp_path / "other" / "RAISE.bvh", BOW)
    library.ingest(tmp_path / "other")
    wanted = [
        from_range(library.store, path, 3, 9)
        for path in (str(tmp_path / "raise.bvh"), str(tmp_path / "other" / "RAISE.bvh"))
    ]
    rows = export(library.store, [*wanted, wanted[0]], tmp_path / "out")
    assert len({row["clip"].casefold() for row in rows}) == 3


def test_a_changed_source_is_refused_and_nothing_written(tmp_path: Path, library: Library) -> None:
    wanted = [from_range(library.store, name, 0, 9) for name in ("bow.bvh", "raise.bvh")]
    dance(tmp_path / "raise.bvh", BOW)
    with pytest.raises(ExportError, match=r"raise\.bvh: has changed since it was ingested"):
        export(library.store, wanted, tmp_path / "out")
    assert list((tmp_path / "out").glob("*")) == []


def test_hits_of_another_library_are_refused(tmp_path: Path, library: Library) -> None:
    hits = library.search("r_arm place high", Selection("raise.bvh"))
    number = hits[0].capture.id
    said = f"raise.bvh: is not what this library holds as number {number}. Search this library"
    with open_library(tmp_path / "other.db", create=True) as other:
        with pytest.raises(ExportError, match=rf"raise\.bvh: there is no capture {number}"):
            other.export(hits, tmp_path / "out")
        other.ingest(dance(tmp_path / str(copy) / "bow.bvh", BOW) for copy in range(number))
        own = Request(other.capture(number), Span(0, 9))
        with pytest.raises(ExportError, match=re.escape(said)):
            export(other.store, [own, *from_hits(hits, "")], tmp_path / "out")
    assert list((tmp_path / "out").glob("*")) == []


def test_a_number_given_anew_is_refused(tmp_path: Path, library: Library) -> None:
    hits = list(library.search("r_arm place high", Selection("raise.bvh")))
    dance(tmp_path / "raise.bvh", BOW)
    library.ingest(tmp_path / "raise.bvh")
    with pytest.raises(ExportError, match="is not what this library holds"):
        library.export(hits, tmp_path / "out")


def test_a_source_that_is_gone_is_refused(tmp_path: Path, library: Library) -> None:
    wanted = [from_range(library.store, "raise.bvh", 0, 9)]
    (tmp_path / "raise.bvh").unlink()
    with pytest.raises(ExportError, match=r"there is no such file.*lanindex remove --missing"):
        export(library.store, wanted, tmp_path / "out")


def test_nothing_is_overwritten_without_force(tmp_path: Path, library: Library) -> None:
    wanted = [from_range(library.store, "raise.bvh", 0, 9)]
    export(library.store, wanted, tmp_path / "out")
    before = {path: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    with pytest.raises(ExportError, match=r"exists already.*force=True"):
        export(
            library.store, [from_range(library.store, "bow.bvh", 0, 5), *wanted], tmp_path / "out"
        )
    assert {path: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before
    export(library.store, wanted, tmp_path / "out", force=True)


@pytest.mark.parametrize("span", [Span(5, 5), Span(-1, 4), Span(0, 10**6), Span(9, 3)])
def test_ranges_outside_are_refused(tmp_path: Path, library: Library, span: Span) -> None:
    with pytest.raises(ExportError, match="wanted a range inside 0 to"):
        export(library.store, [Request(library.capture("bow.bvh"), span)], tmp_path / "out")


def test_other_formats_are_refused(tmp_path: Path, library: Library) -> None:
    fbx = ClipOptions(format="fbx")
    with pytest.raises(UsageError, match="native, bvh, glb, c3d, trc, csv, npz, lnd"):
        export(library.store, [from_range(library.store, "bow.bvh", 0, 5)], tmp_path, fbx)
    with pytest.raises(ExportError, match="came as lnd, wanted a bvh source"):
        export(
            library.store,
            [from_range(library.store, "score.lnd", 0, 5)],
            tmp_path / "o",
            ClipOptions(format="bvh"),
        )


@pytest.mark.parametrize(
    ("text", "frames"), [("0", 0), ("0.5s", 15), ("10f", 10), ("100ms", 3), ("0.01s", 1)]
)
def test_pads(text: str, frames: int) -> None:
    assert pad_frames(text, Fraction(30)) == frames


@pytest.mark.parametrize("text", ["", "1", "-1s", "1x", "s", "1 s", "9" * 5000 + "s"])
def test_bad_pads(text: str) -> None:
    with pytest.raises(UsageError, match="wanted a time such as"):
        pad_frames(text, Fraction(30))


def test_hits_as_json_lines_come_back(library: Library) -> None:
    hits = library.search("r_arm place low")
    lines = [json.dumps(record) for record in hits.dicts()]
    lines += ["", json.dumps({"summary": {"pattern": "r_arm place low", "hits": 3}})]
    wanted = from_lines(library.store, lines)
    assert [(one.capture.id, one.hit) for one in wanted] == [
        (hit.capture.id, hit.span) for hit in hits
    ]
    assert {one.pattern for one in wanted} == {"r_arm place low"}


HIT = '"capture": "bow.bvh", "start_frame": 1, "end_frame": 2'
SYMBOL = '"part": "r_arm", "direction": "left", "start_frame": 1, "end_frame": 2'


def test_what_a_hit_says_is_taken_over(library: Library) -> None:
    line = (
        f'{{{HIT}, "fit": 1, "pattern": "x", "symbols": [{{{SYMBOL}, "level": null}}], "y": [NaN]}}'
    )
    for text in (line, line.encode(), b"\xef\xbb\xbf" + line.encode()):
        (wanted,) = from_lines(library.store, [text])
        assert (wanted.fit, wanted.pattern, wanted.hit) == (1, "x", Span(1, 2))
        assert wanted.symbols == (
            {
                "part": "r_arm",
                "direction": "left",
                "level": None,
                "start_frame": 1,
                "end_frame": 2,
            },
        )


def test_a_number_of_another_library_is_none(tmp_path: Path, library: Library) -> None:
    bow, other = (library.capture(name) for name in ("bow.bvh", "raise.bvh"))
    hit = {"capture": bow.path, "capture_id": other.id, "start_frame": 1, "end_frame": 2}
    (wanted,) = from_lines(library.store, [json.dumps(hit)])
    assert wanted.capture == bow
    (wanted,) = from_lines(library.store, [json.dumps({**hit, "capture_id": bow.id})])
    assert wanted.capture == bow


@pytest.mark.parametrize(
    ("line", "said"),
    [
        *(
            (f'{{{HIT}, "capture_id": {value}}}', "wanted a whole number, as in a line of")
            for value in (
                "1.5",
                "null",
                "true",
                "[1]",
                '"1"',
                "-1",
                "1e999",
                str(1 << 63),
                "9" * 25,
            )
        ),
        *(
            (f'{{{HIT}, "fit": {value}}}', "wanted a number from 0 to 1, as in")
            for value in ("NaN", "Infinity", "1e999", '"=1+1"', "null", "true", "-0.1", "1.01")
        ),
        *((f'{{{HIT}, "fit": {"9" * digits}}}', "9…") for digits in (400, 4000)),
        (f'{{{HIT}, "fit": {"9" * 5000}}}', "…, wanted a line of lanindex"),
        *(
            (
                f'{{"capture": "bow.bvh", "start_frame": {value}, "end_frame": 2}}',
                "a frame, counted",
            )
            for value in ("1" * 25, "-1", "1.5", "null", "1.0")
        ),
        *(
            (f'{{{HIT}, "pattern": {value}}}', "pattern is ")
            for value in ("3", "null", '["r_arm"]', '"\\ud800"')
        ),
        *(
            (f'{{"capture": {value}, "start_frame": 1, "end_frame": 2}}', "capture is ")
            for value in ("1", "null", "{}", '"\\udfff"')
        ),
        (f'{{{HIT}, "symbols": null}}', "symbols is None, wanted a list of symbols"),
        (f'{{{HIT}, "symbols": [[]]}}', "[], wanted a line of"),
        (f'{{{HIT}, "symbols": [{{{SYMBOL}, "level": 3}}]}}', "level is 3, wanted a word"),
        (f'{{{HIT}, "symbols": [{{{SYMBOL}}}]}}', "no level, wanted a line of"),
        (f'{{{HIT}, "symbols": [{{{SYMBOL}, "level": "mid", "amount": NaN}}]}}', "amount is nan"),
        ('{"summary": {"pattern": 3}}', "pattern is 3, wanted text"),
        (
            '{"capture": "' + "x" * 5000 + '", "start_frame": 1, "end_frame": 2}',
            "there is no capture",
        ),
        (b"\xff\xfe", "bytes that are no UTF-8, wanted a line of"),
    ],
    ids=lambda line: str(line)[:80],
)
def test_wrong_types_are_refused_with_their_line(
    untouched: Library, line: str | bytes, said: str
) -> None:
    with pytest.raises(UsageError, match="standard input:1: ") as caught:
        from_lines(untouched.store, [line])
    assert said in str(caught.value)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    "line",
    [
        "raise.bvh\t1\t2",
        "[]",
        "[" * 100_000,
        "{}",
        '{"capture": "bow.bvh", "start_frame": 1, "end_frame": "2"}',
        '{"capture": "bow.bvh", "start_frame": true, "end_frame": 2}',
        '{"capture": "bow.bvh", "start_frame": 1, "end_frame": 2, "symbols": 3}',
        '{"capture": "bow.bvh", "start_frame": 1, "end_frame": 2, "symbols": [{"part": 1}]}',
        '{"capture": "gone.bvh", "start_frame": 1, "end_frame": 2}',
    ],
    ids=lambda line: line[:80],
)
def test_other_lines_are_refused(untouched: Library, line: str) -> None:
    with pytest.raises(UsageError, match="standard input:2"):
        from_lines(untouched.store, ["", line])


@pytest.fixture
def ingested_clip(tmp_path: Path, library: Library):
    """Return a function that ingests an earlier clip under some path and exports it again."""
    hits = library.search("r_arm place high", Selection("raise.bvh"))
    (row,) = library.export(hits, tmp_path / "clips")
    clip = tmp_path / "clips" / row["clip"]

    def again(path: Path) -> None:
        library.ingest(path)
        before = clip.read_bytes()
        with pytest.raises(ExportError, match="is the file that is read, wanted another file"):
            library.export(hits, tmp_path / "clips", pad="0s", force=True)
        assert clip.read_bytes() == before

    again.clip = clip
    return again


def test_no_clip_takes_the_place_of_a_capture(ingested_clip) -> None:
    ingested_clip(ingested_clip.clip)


@pytest.mark.parametrize("link", [os.symlink, os.link])
def test_nor_of_one_that_is_known_by_a_link(tmp_path: Path, ingested_clip, link) -> None:
    link(ingested_clip.clip, tmp_path / "other name.bvh")
    ingested_clip(tmp_path / "other name.bvh")


def test_nor_of_one_that_is_known_by_a_linked_folder(tmp_path: Path, ingested_clip) -> None:
    os.symlink(tmp_path / "clips", tmp_path / "linked")
    ingested_clip(tmp_path / "linked" / ingested_clip.clip.name)


def test_nor_of_one_that_has_changed_since(tmp_path: Path, library: Library, ingested_clip) -> None:
    library.ingest(ingested_clip.clip)
    dance(ingested_clip.clip, BOW)
    os.symlink(tmp_path / "clips", tmp_path / "linked")
    hits = library.search("r_arm place high", Selection("raise.bvh"))
    for folder in ("clips", "linked"):
        with pytest.raises(ExportError, match="is the file that is read, wanted another file"):
            library.export(hits, tmp_path / folder, force=True)


def test_an_export_does_not_go_through_all_captures(
    tmp_path: Path, library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    hits = library.search("r_arm place high", Selection("raise.bvh"))
    for through_all in ("captures", "known"):
        monkeypatch.setattr(Store, through_all, None)
    for _ in range(2):
        library.export(hits, tmp_path / "clips", force=True)


def test_clips_come_as_bytes_with_a_name(tmp_path: Path, library: Library) -> None:
    wanted = [from_range(library.store, name, 3, 9) for name in ("bow.bvh", "score.lnd")]
    manifest: list[dict[str, object]] = []
    notes: list[str] = []
    files = list(clips(library.store, wanted, ClipOptions(), manifest, notes.append))
    names = ["bow_3-9.bvh", "bow_3-9.lnd", "score_3-9.lnd", "manifest.csv", "manifest.jsonl"]
    assert [file.name for file in files] == names
    assert [row["clip"] for row in manifest] == ["bow_3-9.bvh", "score_3-9.lnd"]
    assert export(library.store, wanted, tmp_path / "out") == manifest
    for file in files:
        assert (tmp_path / "out" / file.name).read_bytes() == file.content
    assert list(clips(library.store, [], ClipOptions(), [], notes.append)) == []


def test_names_at_the_limit_of_the_file_system(tmp_path: Path, library: Library) -> None:
    name = "踊" * 83 + ".bvh"
    dance(tmp_path / name)
    library.ingest(tmp_path / name)
    wanted = [from_range(library.store, name, 3, 9)] * 2
    rows = export(library.store, wanted, tmp_path / "out")
    assert [row["clip"] for row in rows] == ["踊" * 66 + end for end in ("_3-9.bvh", "_3-9_2.bvh")]


@pytest.mark.parametrize("first", ["=", "+", "-", "@", "\t", "\r", "\n"])
def test_no_cell_of_the_table_is_a_formula(library: Library, first: str) -> None:
    capture = replace(library.capture("bow.bvh"), label=first + "cmd()")
    said = {"part": first + "1", "direction": None, "level": "mid", "start_frame": 1}
    wanted = Request(capture, Span(3, 9), first + "> r_arm", 0.5, ({**said, "end_frame": 2},))
    manifest: list[dict[str, object]] = []
    files = clips(library.store, [wanted], ClipOptions(), manifest, print)
    content = {file.name: file.content for file in files}
    table = csv.DictReader(io.StringIO(content["manifest.csv"].decode(), newline=""))
    (row,) = table
    shown = first.replace("\r", "\n")
    assert row["pattern"] == f"'{shown}> r_arm"
    assert row["symbols"] == f"'{shown}1 mid 1-2"
    assert (row["fit"], row["clip"]) == ("0.5", "bow_3-9.bvh")
    assert json.loads(content["manifest.jsonl"]) == manifest[0]
    assert manifest[0]["pattern"] == first + "> r_arm"


@pytest.mark.parametrize("form", ["webp", "gif", "mp4"])
def test_films_stand_beside_clips(tmp_path: Path, library: Library, form: str) -> None:
    hits = library.search("r_arm -> r_arm", Selection("*raise.bvh"))[:1]
    folder = tmp_path / "films"
    rows = library.export(hits, folder, pad="0.2s", preview=form)
    assert rows
    for row in rows:
        assert row["preview"] == Path(row["clip"]).with_suffix(f".{form}").name
        film = seen((folder / row["preview"]).read_bytes(), form)
        assert film.seconds == pytest.approx(row["end"] - row["start"], abs=0.05)
        orange = abs(np.subtract(film.frames, PALETTE["lit"], dtype=np.int16)).max(axis=-1) < 60
        assert orange.any()
    written = [json.loads(it) for it in (folder / "manifest.jsonl").read_text().splitlines()]
    assert written == rows
    assert library.export(hits, tmp_path / "clips")[0].keys() == rows[0].keys() - {"preview"}


def test_films_of_one_export_are_seen_from_one_side(
    tmp_path: Path, library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    turns = []
    monkeypatch.setattr(Film, "written", lambda film, _: turns.append(film.scene.view.turn) or b"")
    raised, bowed = (
        library.search("r_arm -> r_arm", Selection(it)) for it in ("*se.bvh", "*w.bvh")
    )
    for number, hits in enumerate((raised, bowed, [*raised, *bowed])):
        library.export(hits, tmp_path / f"films{number}", preview="mp4")
    assert turns[: len(raised)] != turns[-len(bowed) :]
    assert len(set(turns[len(raised) + len(bowed) :])) == 1


def test_a_capture_that_is_filmed_alone_is_read_once(
    tmp_path: Path, library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, stored_motion = [], preview.stored_motion

    def counted(store, capture, rate):
        read.append(capture.path)
        return stored_motion(store, capture, rate)

    monkeypatch.setattr(preview, "stored_motion", counted)
    monkeypatch.setattr(Film, "written", lambda film, _: b"")
    hits = library.search("r_arm", Selection("*raise.bvh"))
    assert len(library.export(hits, tmp_path / "films", preview="mp4")) > 1
    assert len(read) == 1


def test_scores_have_films_too(tmp_path: Path, library: Library) -> None:
    hits = library.search("r_arm", Selection("*score.lnd"))[:1]
    (row,) = library.export(hits, tmp_path / "films", preview="gif")
    assert row["clip"].endswith(".lnd")
    assert seen((tmp_path / "films" / row["preview"]).read_bytes(), "gif").frames


def test_an_unknown_kind_of_film_is_refused(tmp_path: Path, library: Library) -> None:
    hits = library.search("r_arm")
    with pytest.raises(UsageError, match="avi") as caught:
        library.export(hits, tmp_path / "films", preview="avi")
    assert "webp" in caught.value.wanted
    assert not (tmp_path / "films").exists()


def test_the_symbols_of_a_hit_are_those_of_its_score(library: Library) -> None:
    hits = library.search("arms -> arms", overlaps="all")
    for hit, request in zip(hits, from_hits(hits, ""), strict=True):
        score = library.score(hit.capture.id)
        found = matched(score, request)
        assert {str(it) for it in found} == {str(it) for it in hit.symbols}
        assert all(score.tracks[it.part].listed()[it.ordinal] == it for it in found)
