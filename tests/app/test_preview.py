"""``search --preview`` as a user types it."""

import os
from functools import partial
from pathlib import Path

import command
import pytest
from dances import BOW, RAISE, dance


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("preview")
    dance(folder / "raise.bvh")
    (folder / "raise.lnd").write_text(RAISE)
    dance(folder / "bow.bvh", BOW)
    dance(folder / "lost.bvh")
    words = ("ingest", "raise.bvh", "raise.lnd", "bow.bvh", "lost.bvh", "-q")
    assert command.run(*words, cwd=folder).returncode == 0
    (folder / "lost.bvh").unlink()
    return folder


@pytest.fixture
def run(place: Path):
    return partial(command.run, cwd=place)


def test_hits_are_shown_in_a_file(run, place: Path) -> None:
    done = run("search", "r_arm place high", "--preview", "hits.html")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "hits.html\n"
    notes = done.stderr.splitlines()
    assert notes[0].startswith("not drawn: lost.bvh 1.27-2.00 s: ")
    size = (place / "hits.html").stat().st_size
    assert notes[1:] == [f"hits.html: {size / 1000:,.0f} kB", "3 hits in 3 captures"]
    assert (place / "hits.html").read_text().count("data-joints=") == 2
    again = run("search", "r_arm place high", "--preview", "hits.html")
    assert again.returncode == 2
    assert "hits.html: exists already" in again.stderr
    one = run("search", "r_arm place high", "--preview", "hits.html", "--force", "--limit", "1")
    assert one.returncode == 0
    assert one.stderr.endswith("3 hits in 3 captures; 1 is shown, --limit shows more\n")


def test_nothing_found_is_no_file(run, place: Path) -> None:
    done = run("search", "r_arm back high", "--preview", "none.png", "-q")
    assert (done.returncode, done.stdout) == (1, "")
    assert not (place / "none.png").exists()


def test_a_capture_is_not_replaced(run, place: Path) -> None:
    os.link(place / "raise.lnd", place / "raise.svg")
    done = run("search", "r_arm place high", "--preview", "raise.svg", "--force")
    assert done.returncode == 2
    assert "is the file that is read" in done.stderr
    assert (place / "raise.lnd").read_text() == RAISE


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["r_arm", "--preview", "a.gif"], '--preview: "a.gif", wanted an ending of png, svg'),
        (["r_arm", "--preview", "a.png", "--json"], "--preview and --json, wanted one of them"),
        (["r_arm", "--preview", "a.png", "--count"], "--preview and --count"),
        (["r_arm", "--preview", "a.png", "--why", "1"], "--preview and --why"),
        (["r_arm", "--preview", "a.png", "--explain"], "--preview and --explain"),
        (["r_arm", "--preview", "a.png", "--context", "1s"], "--preview and --context"),
        (["r_arm | count", "--preview", "a.png"], "--preview and | count"),
        (["r_arm", "--preview", "a.png", "--into", "b.eaf"], "--preview and --into"),
        (["r_arm", "--force"], "--force, wanted --into or --preview beside it"),
    ],
)
def test_what_does_not_go_together_is_refused(run, place, words: list[str], said: str) -> None:
    done = run("search", *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert not (place / "a.png").exists()
