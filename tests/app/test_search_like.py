"""``search --like`` as a user types it."""

import json
from functools import partial
from pathlib import Path

import command
import pytest
from command import screen, shown
from dances import BOW, dance

from lanindex.pipeline.library import open_library


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("alike")
    dance(folder / "raise.bvh")
    dance(folder / "again.bvh", rate=60)
    dance(folder / "bow.bvh", BOW)
    with open_library(folder / "own.db", create=True) as library:
        library.ingest(folder)
    return folder


@pytest.fixture
def run(place: Path):
    return partial(command.run, cwd=place, env={"LANINDEX_DB": "own.db"})


def test_it_tells_what_is_like_a_capture(run, place: Path) -> None:
    done = run("search", "--like", "raise.bvh", "--json")
    assert done.returncode == 0, done.stderr
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert [Path(line["capture"]).name for line in lines] == ["again.bvh", "bow.bvh"]
    assert lines[0]["pattern"] == "like raise.bvh"
    assert "the 2 most like of 2 captures" in done.stderr
    first = run("search", "--like", "raise.bvh", "--limit", "1").stdout.split("\t")
    assert first[:3] == [lines[0]["capture"], "0", str(lines[0]["end_frame"])]
    again = run("search", "--like", "-", "--json", text=done.stdout.splitlines()[0])
    assert json.loads(again.stdout.splitlines()[0])["capture"].endswith("raise.bvh")
    exported = run("export", "-", "-o", "clips", text=done.stdout)
    assert exported.returncode == 0, exported.stderr
    assert len(list((place / "clips").glob("*.bvh"))) == 2


def test_it_tells_it_in_columns_on_a_terminal(run, place: Path) -> None:
    lines = screen(shown("search", "--like", "raise.bvh", "--db", "own.db", cwd=place)).splitlines()
    assert lines.pop(0) == f"{place}/"
    assert lines[0].split() == [
        "like",
        "capture",
        "label",
        "frames",
        "seconds",
        "most",
        "in",
        "common",
    ]
    assert "again.bvh" in lines[1]
    assert lines[-1] == "the 2 most like of 2 captures, the likest first"


def test_it_ranks_by_joints_and_says_what_it_could_not_use(run, place: Path) -> None:
    (place / "bow.bvh").rename(place / "away.bvh")
    done = run("search", "--like", "raise.bvh", "--rerank")
    (place / "away.bvh").rename(place / "bow.bvh")
    assert done.returncode == 0
    assert "joints not compared: " in done.stderr
    assert "bow.bvh" in done.stderr


def test_what_is_like_it_is_drawn(run, place: Path) -> None:
    done = run("search", "--like", "raise.bvh", "--preview", "like.svg")
    assert (done.returncode, done.stdout) == (0, "like.svg\n"), done.stderr
    sheet = (place / "like.svg").read_text()
    assert ">like raise.bvh \u00b7 " in sheet
    assert sheet.index("again.bvh</text>") < sheet.index("bow.bvh</text>")


def test_nothing_like_it_is_exit_code_1(run) -> None:
    done = run("search", "--like", "raise.bvh", "--in", "none")
    assert (done.returncode, done.stdout) == (1, "")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "nothing to search for, wanted a pattern or --like"),
        (("r_arm high", "--rerank"), "--rerank, wanted --like"),
        (("r_arm high", "--like", "raise.bvh"), "--like and a pattern, wanted one of them"),
        (("--like", "raise.bvh", "--count"), "--like and --count, wanted one of them"),
        (("--like", "raise.bvh", "--why", "1"), "--like and --why, wanted one of them"),
        (("--like", "raise.bvh", "--fuzzy", "1"), "--like and --fuzzy, wanted one of them"),
        (("--like", "none"), "--like: there is no capture and no file none"),
        (("--like", "-"), "standard input: 0 lines, wanted one hit"),
    ],
)
def test_what_does_not_go_together_is_told(run, words: tuple[str, ...], message: str) -> None:
    done = run("search", *words)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
