"""``show --staff`` and ``search --context`` as a user types them."""

from functools import partial
from pathlib import Path

import command
import pytest
from command import shown
from dances import BOW, dance


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("staff")
    dance(folder / "raise.bvh")
    (folder / "bow.lnd").write_text(BOW)
    (folder / "empty.lnd").write_text("#unit1\n")
    files = sorted(path.name for path in folder.iterdir())
    assert command.run("ingest", *files, "-q", cwd=folder).returncode == 0
    return folder


@pytest.fixture
def run(place: Path):
    return partial(command.run, cwd=place)


def test_a_capture_is_shown_as_a_staff(run) -> None:
    done = run("show", "bow.lnd", "--staff")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[:6] == [
        "bow.lnd",
        "       R",
        "       arm",
        "       □▼",
        "      ═════",
        " 0.00",
    ]
    assert done.stderr.startswith("time runs down; ↑ forward, → right")
    assert done.stderr.endswith("\n3 symbols\n")


def test_parts_that_are_asked_for_are_shown_even_if_still(run) -> None:
    done = run("show", "raise.bvh", "--staff", "--part", "head", "--part", "r_arm")
    assert done.stdout.splitlines()[1:3] == ["       R", "       arm  head"]
    assert run("show", "bow.lnd", "--staff", "--part", "head").returncode == 1
    assert run("show", "empty.lnd", "--staff").returncode == 1


def test_all_captures_are_shown(run) -> None:
    lines = run("show", "--all", "--staff").stdout.splitlines()
    assert [line for line in lines if line.endswith((".lnd", ".bvh"))] == ["bow.lnd", "raise.bvh"]


def test_hits_stand_in_their_surroundings(run) -> None:
    done = run("search", "r_arm place high", "--context", "0.5s", "--in", "*.bvh")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("raise.bvh\t")  # a line a hit, as without
    assert sum("»□▲" in line for line in lines) == 1
    assert done.stderr.endswith("1 hit in 1 capture\n")


def test_a_staff_fits_the_terminal(place: Path) -> None:
    wide = shown("show", "raise.bvh", "--staff", cwd=place, columns=200)
    assert "no room for" not in wide
    narrow = shown("show", "raise.bvh", "--staff", "-q", cwd=place, columns=30)
    assert "no room for" in narrow
    assert max(map(len, narrow.splitlines())) <= 30
    found = shown("search", "r_arm high", "--context", "0", cwd=place, columns=60)
    assert "»□▲" in found
    assert found.startswith("raise.bvh\n")


def test_where_there_is_no_unicode_there_are_letters(place: Path) -> None:
    ascii = {"PYTHONIOENCODING": "ascii"}
    done = command.start("show", "bow.lnd", "--staff", cwd=place, env=ascii)
    assert done.stdout.isascii()
    assert "\\u" not in done.stdout + done.stderr
    assert "       oL\n" in done.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["show", "1", "--staff", "--json"], "--staff and --json, wanted one of them"),
        (["search", "r_arm", "--context", "1s", "--json"], "--context and --json"),
        (["search", "r_arm", "--context", "1s", "--count"], "--context and --count"),
        (["search", "r_arm", "--context", "1s", "--why", "1"], "--context and --why"),
        (["search", "r_arm", "--context", "1s", "--explain"], "--context and --explain"),
        (["search", "--context", "1s", "--like", "1"], "--context and --like"),
        (["search", "r_arm | count", "--context", "1s"], "--context and | count"),
        (["search", "r_arm", "--context", "long"], '--context: "long", wanted a time such as'),
    ],
)
def test_what_does_not_go_together_is_refused(run, words: list[str], said: str) -> None:
    done = run(*words)
    assert done.returncode == 2
    assert said in done.stderr
    assert not done.stdout
