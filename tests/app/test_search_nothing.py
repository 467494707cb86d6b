"""A search that finds nothing says why, and which patterns would find something."""

from pathlib import Path

import command
import pytest
from dances import BOW, dance


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("nothing")
    dance(folder / "raise.bvh")
    dance(folder / "bow.bvh", BOW)
    assert called(folder, "ingest", ".").returncode == 0
    return folder


def called(place: Path, *words: str) -> command.Done:
    return command.run(*words, cwd=place)


def test_the_nearest_pattern_is_offered(place: Path) -> None:
    done = called(place, "search", "r_arm low -> high")
    assert (done.returncode, done.stdout) == (1, "")
    lines = done.stderr.splitlines()
    assert lines[0] == "0 hits in 0 captures"
    assert 'without "low": 1 hit' in lines
    offered = lines[lines.index("The nearest patterns that find something:") + 1]
    pattern, counts = offered.strip().split("  ")
    assert (pattern, counts) == ("r_arm low ... high", "1 hit in 1 capture")
    assert called(place, "search", pattern).returncode == 0


@pytest.mark.parametrize("option", ["--count", "--json"])
def test_it_is_said_whatever_is_asked_for(place: Path, option: str) -> None:
    done = called(place, "search", "r_arm low -> high", option)
    assert (done.returncode, done.stdout) == (1, "")
    assert "r_arm low ... high" in done.stderr
    assert (len(done.stderr.splitlines()) == 2) == (option == "--json")


def test_quiet_is_quiet(place: Path) -> None:
    done = called(place, "search", "r_arm low -> high", "-q")
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "")


def test_captures_that_were_not_looked_at(place: Path) -> None:
    done = called(place, "search", "r_arm high", "--in", "*bow*")
    assert done.returncode == 1
    assert "in all captures: 1 hit" in done.stderr
    done = called(place, "search", "r_arm high", "--in", "*cow*")
    assert done.returncode == 1
    assert "There is no capture that fits --in and --where." in done.stderr


def test_what_is_found_needs_no_advice(place: Path) -> None:
    done = called(place, "search", "r_arm high")
    assert done.returncode == 0
    assert "nearest" not in done.stderr


def test_one_capture_under_the_glass(place: Path) -> None:
    done = called(place, "search", "r_arm low -> high", "--why", "raise.bvh")
    assert done.returncode == 1
    assert done.stdout.splitlines()[1:3] == ["found:      r_arm low", "not found:  -> high"]
    assert "the next movement is right mid" in done.stdout
    done = called(place, "search", "r_arm mid -> high", "--why", "raise.bvh")
    assert (done.returncode, done.stderr) == (0, "")
    assert "fit 1.00" in done.stdout
    assert "r_arm place high [" in done.stdout
    assert "margin 1.00" in done.stdout


def test_captures_under_the_glass_fit_a_glob(place: Path) -> None:
    done = called(place, "search", "r_arm mid -> high", "--why", "*.bvh")
    assert done.returncode == 0
    assert "bow.bvh\nfound:      r_arm mid\nnot found:" in done.stdout
    assert "raise.bvh\n[" in done.stdout
    assert called(place, "search", "r_arm mid -> high", "--why", "b*.bvh").returncode == 1


def test_a_capture_that_is_not_there(place: Path) -> None:
    done = called(place, "search", "r_arm high", "--why", "rise.bvh")
    assert done.returncode == 2
    assert "there is no capture rise.bvh" in done.stderr
