"""``--tempo``: found, stored, shown and searched."""

import json
from pathlib import Path

import pytest
from random_tempos import RATE, walked
from typer.testing import CliRunner

from lanindex.app.cli import app
from lanindex.formats.bvh import write
from lanindex.perform import perform


def said(*words: object) -> str:
    done = CliRunner().invoke(app, [str(word) for word in words])
    assert done.exit_code == 0, done.output
    return done.output


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("tempo") / "walk.bvh"
    file.write_bytes(write(perform(walked(3, 120), rate=RATE)))
    return file


def hits(db: Path, query: str) -> list[tuple[int, int]]:
    lines = said("search", query, "--db", db, "--json", "-q").splitlines()
    return [(one["start_frame"], one["end_frame"]) for one in map(json.loads, lines)]


def test_a_library_holds_the_tempo_and_asks_for_beats_in_it(walk: Path, tmp_path: Path) -> None:
    db = tmp_path / "one.db"
    assert "confidence" in said("ingest", walk, "--tempo", "auto", "--db", db, "-v")
    assert "unchanged" in said("ingest", walk, "--tempo", "auto", "--db", db)
    short = hits(db, "step mid <0.75s")  # those of one beat, which is half a second
    assert 0 < len(short) < len(hits(db, "step mid"))
    assert hits(db, "step mid <1.5b") == short
    assert hits(db, "step mid <1.5b where clip.tempo > 110") == short
    assert "1 written anew" in said("ingest", walk, "--db", db)  # it is no longer asked for
    assert hits(db, "step mid <0.75b") == short


def test_a_changed_file_of_beats_is_counted_anew(walk: Path, tmp_path: Path) -> None:
    db, beats = tmp_path / "one.db", tmp_path / "beats.txt"
    beats.write_text("0.5\n1.0\n1.5\n")
    (record,) = map(json.loads, said("ingest", walk, "--tempo", beats, "--db", db, "--json", "-q")
                    .splitlines())  # fmt: skip
    assert record["tempo"] == "120 beats a minute (the mean of 3 beats)"
    assert "unchanged" in said("ingest", walk, "--tempo", beats, "--db", db)
    beats.write_text("0.5\n1.1\n1.7\n")
    assert "1 written anew" in said("ingest", walk, "--tempo", beats, "--db", db)


def test_inspect_and_convert_count_too(walk: Path, tmp_path: Path) -> None:
    assert "confidence" in said("inspect", walk, "--tempo", "auto")
    assert "\ntempo" not in said("inspect", walk)
    assert "// tempo: " in said("convert", walk, "--tempo", "auto")
    done = CliRunner().invoke(app, ["convert", str(walk), "out.c3d", "--tempo", "auto"])
    assert done.exit_code == 2
    assert "beats in c3d" in done.output


def test_a_bad_file_is_refused_before_anything_is_read(walk: Path, tmp_path: Path) -> None:
    beats = tmp_path / "beats.txt"
    beats.write_text("one\n")
    done = CliRunner().invoke(app, ["ingest", str(walk), "--tempo", str(beats)])
    assert done.exit_code == 2
    assert "beats.txt:1" in done.output
