"""``play`` as a user types it."""

import json
from functools import partial
from pathlib import Path

import command
import pytest
from dances import RAISE, dance
from film_frames import seen

from lanindex.film.figure import PALETTE


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("play")
    (folder / "raise.lnd").write_text(RAISE)
    dance(folder / "raise.bvh")
    (folder / "empty.lnd").write_text("#unit1\n")
    assert command.run("ingest", "raise.bvh", cwd=folder).returncode == 0
    return folder


@pytest.fixture
def run(place: Path):
    return partial(command.run, cwd=place)


def test_a_score_is_carried_out(run, place: Path) -> None:
    done = run("play", "raise.lnd", "--size", "320x240")
    assert done.returncode == 0, done.stderr
    assert "raise.webp: " in done.stderr
    first = seen((place / "raise.webp").read_bytes(), "webp")
    assert first.size == (320, 240)
    assert run("play", "raise.lnd").returncode == 2  # it is there
    assert run("play", "raise.lnd", "--force", "--to", "1").returncode == 0


def test_a_capture_of_the_library_is_played_as_its_file_is(run, place: Path) -> None:
    how = ("--to", "2", "--size", "320x240", "--film-fps", "10", "--highlight", "r_arm")
    stored = run("play", "raise.bvh", "-o", "a.webp", *how)
    assert stored.returncode == 0, stored.stderr
    assert stored.stderr.splitlines()[-1] == "a.webp: 20 frames at 10 Hz, 2.00 s"
    fresh = run("play", "raise.bvh", "-o", "b.webp", *how, "--db", "none.db")
    assert fresh.returncode == 0, fresh.stderr
    assert (place / "a.webp").read_bytes() == (place / "b.webp").read_bytes()


def test_a_hit_is_played(run, place: Path) -> None:
    line = run("search", "r_arm mid", "--limit", "1", "--json").stdout.splitlines()[0]
    hit = json.loads(line)
    done = run("play", "-", "-o", "hit.gif", text=line)
    assert done.returncode == 0, done.stderr
    played = seen((place / "hit.gif").read_bytes(), "gif")
    assert played.seconds == pytest.approx(hit["end"] - hit["start"], abs=0.05)
    orange = (abs(played.frames[-1].astype(int) - PALETTE["lit"]) < 30).all(axis=-1)
    assert orange[:, :300].any()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("raise.lnd", "-o", "a.avi"), '"a.avi", wanted an ending of mp4, webp or gif'),
        (
            ("raise.lnd", "-o", "c.gif", "--film-fps", "60"),
            "--film-fps: 60 frames a second, wanted 50",
        ),
        (("raise.lnd", "-o", "c.gif", "--size", "640"), '--size: "640", wanted WIDTHxHEIGHT'),
        (("raise.lnd", "-o", "c.gif", "--size", "9x9"), "a film of 9x9 pixels"),
        (("raise.lnd", "-o", "c.gif", "--view", "top"), 'the view "top"'),
        (("raise.lnd", "-o", "c.gif", "--from", "90"), "nothing from 90 s"),
        (("empty.lnd", "-o", "c.gif"), "wanted"),
        (("none.bvh", "-o", "c.gif"), "none.bvh"),
        (("1", "-o", "c.gif", "--unit", "m"), "--unit for 1, wanted a file"),
        (("1", "-o", "c.gif", "--fps", "30"), "--fps for 1, wanted a file"),
    ],
)
def test_what_cannot_be_played_is_refused(run, place: Path, words, said: str) -> None:
    done = run("play", *words)
    assert done.returncode == 2, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not (place / words[2]).exists()


def test_a_source_that_has_changed_is_no_longer_played(run, place: Path) -> None:
    dance(place / "gone.bvh")
    run("ingest", "gone.bvh")
    with (place / "gone.bvh").open("a") as file:
        file.write("\n")
    done = run("play", "gone.bvh", "-o", "d.gif")
    assert done.returncode == 2
    assert "has changed since it was ingested" in done.stderr
