"""A long job shows progress on a terminal; interrupted, it says how far it came."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import command
import pytest
from command import screen, start_on_terminal
from dances import dance

from lanindex.app import output
from lanindex.app.output import Output, end_progress, how_far
from lanindex.pipeline.library import Library, open_library

AT_ONCE = "from lanindex.app import output; output.PATIENCE = -1; "
MAIN = AT_ONCE + "from lanindex.app.cli import main; main()"
BROKEN_OFF = """
from lanindex.search import match
def find(self, overlaps, watch, best, refused, found):
    watch(12, 1300)
    raise KeyboardInterrupt
match.Finder.find = find
from lanindex.app.cli import main; main()
"""


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("how_far")
    for name in ("one", "two"):
        dance(folder / f"{name}.bvh")
    with open_library(folder / "lanindex.db", create=True) as library:
        library.ingest(folder)
    (folder / "up.toml").write_text('up = {pattern = "r_arm high", positives = ["a"]}')
    (folder / "labels.csv").write_text("file,label\none.bvh,a\ntwo.bvh,b\n")
    return folder


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (["search", "r_arm high"], "0/2 captures"),
        (["search", "--like", "one.bvh"], "0/1 captures"),
        (["similar"], "0/1 pairs"),
        (["motifs", "--min-count", "2"], "0/31 parts"),
        (["export", "r_arm high", "-o", "cut", "--force"], "0/2 clips"),
        (["evaluate", ".", "--labels", "labels.csv", "--patterns", "up.toml"], "0/1 patterns"),
    ],
)
def test_it_is_shown_on_a_terminal_while_it_lasts(
    place: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], shown: str
) -> None:
    seen = start_on_terminal([sys.executable, "-c", MAIN, *words], place)
    assert shown in seen
    assert shown not in screen(seen)
    monkeypatch.setattr(output, "PATIENCE", -1)
    assert shown in command.shown(*words, cwd=place)
    assert shown not in command.shown(*words, "-q", cwd=place)
    piped = command.run(*words, cwd=place)
    assert shown not in piped.stderr
    assert piped.returncode == 0


@pytest.mark.parametrize(
    "job",
    [
        lambda library: library.search("r_arm high"),
        lambda library: library.search("r_arm high with (l_arm low or head)", fuzzy=1),
        lambda library: library.search("r_arm high", fuzzy=1, best=1),
        lambda library: library.like("one.bvh", rerank=True),
        lambda library: library.similar(),
        lambda library: library.motifs(min_count=2),
        lambda library: library.captures(),
    ],
)
def test_it_never_falls_and_ends_at_its_end(place: Path, job: Callable[[Library], object]) -> None:
    seen = dict[tuple[str, int], list[int]]()

    def progress(noun: str, done: int, total: int) -> None:
        if (noun, total) not in seen:
            assert all(counts[-1] == most for (_, most), counts in seen.items())
        seen.setdefault((noun, total), []).append(done)

    with open_library(place / "lanindex.db", progress=progress) as library:
        job(library)
    assert seen
    for (_, total), counts in seen.items():
        assert counts == sorted(counts)
        assert counts[-1] == total


def test_the_clips_of_a_folder_are_counted_not_the_labels(place: Path) -> None:
    (place / "labels.csv").write_text("file,label\none.bvh,a\ntwo.bvh,b\nfar/three.bvh,a\n")
    words = ["evaluate", ".", "--labels", "labels.csv", "--patterns", "up.toml"]
    seen = start_on_terminal([sys.executable, "-c", MAIN, *words], place)
    assert "2/2 clips" in seen


def test_columns_that_are_made_anew_show_it(place: Path) -> None:
    with (
        open_library(place / "lanindex.db") as library,
        library.store.session.writing() as connection,
    ):
        connection.execute("UPDATE state SET columns = -1")
    seen = start_on_terminal([sys.executable, "-c", MAIN, "search", "r_arm high"], place)
    assert "0/2 captures" in seen
    assert "2/2 captures" in seen
    told = screen(seen).splitlines()
    assert told[0].startswith("the library's columns were out of date")
    assert told[-1] == "2 hits in 2 captures"


@pytest.mark.parametrize(("total", "text"), [(1, ""), (2, " after 1 of 2 captures")])
def test_one_thing_has_no_middle(total: int, text: str) -> None:
    Output(quiet=True).watch("captures", 1, total)
    assert how_far() == text
    end_progress()
    assert how_far() == ""


def test_a_line_ends_the_job(capsys: pytest.CaptureFixture[str]) -> None:
    out = Output()
    out.watch("captures", 1, 3)
    out.line("found")
    assert how_far() == ""
    assert capsys.readouterr().out == "found\n"


def test_what_is_broken_off_says_how_far_it_came(place: Path) -> None:
    words = [sys.executable, "-c", BROKEN_OFF, "search", "r_arm high"]
    done = subprocess.run(words, cwd=place, capture_output=True, text=True)
    assert done.stderr == "lanindex: interrupted after 12 of 1,300 captures\n"
    assert done.returncode == 130


@pytest.mark.parametrize(
    "words", [["show", "--all", "-o", "all.csv"], ["db", "check"]], ids=["show", "check"]
)
def test_long_looks_show_how_far_they_are(place: Path, words: list[str]) -> None:
    seen = start_on_terminal([sys.executable, "-c", MAIN, *words], place)
    assert "2/2 captures" in seen
