"""``score`` as a user types it."""

import json
import re
import subprocess
import sys
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import command
import pytest
from dances import RAISE, dance

MAIN = "from lanindex.app.cli import main; main()"
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("score")
    (folder / "raise.lnd").write_text(RAISE)
    dance(folder / "raise.bvh")
    (folder / "tail.lnd").write_text("#unit1\ndirection tail left low 0 1\n")
    (folder / "long.lnd").write_text("#unit99\ndirection r_arm left low 0 1\n")
    (folder / "empty.lnd").write_text("#unit1\n")
    return folder


@pytest.fixture
def run(place: Path):
    return partial(command.run, cwd=place)


def parts_in(text: str) -> set[str]:
    groups = ElementTree.fromstring(text).iter(f"{SVG}g")
    return {group.attrib["data-part"] for group in groups if group.attrib}


def test_a_score_is_drawn(run, place: Path) -> None:
    done = run("score", "raise.lnd")
    assert done.returncode == 0, done.stderr
    assert done.stderr.startswith("raise.svg: ")
    assert "r_arm" in parts_in((place / "raise.svg").read_text())
    assert run("score", "raise.lnd").returncode == 2  # it is there
    assert run("score", "raise.lnd", "--force").returncode == 0


def test_the_heading_says_what_the_score_leaves_open(run) -> None:
    full, plain, arm = (
        run("score", name, "-o", "-", *more).stdout
        for name, *more in (
            *(("raise.lnd", "--detail", "full"), ("raise.bvh",)),
            ("raise.bvh", "--parts", "r_arm"),
        )
    )
    assert "full score; the weight is not told<" in full
    assert re.search(r"a tick a second; plain score, method \d+<", plain)
    assert re.search(r"full score, method \d+; the weight is not told<", arm)
    assert run("score", "raise.lnd", "--detail", "some").returncode == 2


def test_a_capture_of_the_library_is_drawn(run) -> None:
    assert run("ingest", "raise.bvh").returncode == 0
    stored = run("score", "1", "-o", "-")
    assert stored.returncode == 0, stored.stderr
    fresh = run("score", "raise.bvh", "-o", "-", "--db", "none.db")
    assert fresh.stdout == stored.stdout


def test_options_of_reading_mean_the_file(run) -> None:
    assert run("ingest", "raise.bvh").returncode == 0
    for option in (("--fps", "15"), ("--profile", "paper")):
        as_held, anew = (run("score", "raise.bvh", "-o", "-", *more) for more in ((), option))
        assert anew.returncode == 0, anew.stderr
        assert anew.stdout != as_held.stdout
        of_library = run("score", "1", "-o", "-", *option)
        assert of_library.returncode == 2
        assert f"{option[0]} for 1, wanted a file" in of_library.stderr


def test_a_damaged_library_is_no_missing_one(run, place: Path) -> None:
    (place / "damaged.db").write_bytes(b"no library" * 100)
    done = run("score", "raise.bvh", "-o", "-", "--db", "damaged.db")
    assert (done.returncode, done.stdout) == (2, "")
    assert "damaged.db" in done.stderr


def test_a_hit_is_drawn_with_its_symbols_marked(run) -> None:
    assert run("ingest", "raise.bvh").returncode == 0
    line = run("search", "r_arm high", "--json", "--limit", "1").stdout
    assert line.count("\n") == 1
    drawn = run("score", "-", "-o", "-", text=line)
    assert drawn.returncode == 0, drawn.stderr
    assert drawn.stdout.count('fill-opacity=".3"') == 1
    begin, end = (json.loads(line)[key] for key in ("start_frame", "end_frame"))
    stretch = run("score", f"raise.bvh:{begin}-{end}", "-o", "-")
    assert parts_in(stretch.stdout) == parts_in(drawn.stdout)
    assert f"<title>raise.bvh:{begin}-{end}</title>" in stretch.stdout
    several = run("score", "-", "-o", "-", text=2 * line)
    assert "standard input: 2 lines, wanted one hit" in several.stderr


def test_a_legend_is_drawn_where_it_is_asked_for(run) -> None:
    plain, told = (
        run("score", "raise.lnd", "-o", "-", *more).stdout for more in ((), ("--legend",))
    )
    assert "<title>right forward</title>" in told
    assert "<title>right forward</title>" not in plain


@pytest.mark.parametrize(("name", "begins"), [("a.png", b"\x89PNG"), ("a.pdf", b"%PDF")])
def test_images_are_made(run, place: Path, name: str, begins: bytes) -> None:
    done = run("score", "raise.lnd", "-o", name, "--highlight", "r_arm high", "--scale", "2")
    assert done.returncode == 0, done.stderr
    assert done.stderr.splitlines()[0] == "1 hit"
    assert (place / name).read_bytes().startswith(begins)


def test_hits_are_highlighted(run) -> None:
    plain, marked = (
        run("score", "raise.lnd", "-o", "-", *more).stdout.count('fill-opacity=".3"')
        for more in ((), ("--highlight", "r_arm high"))
    )
    assert (plain, marked) == (0, 1)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("none.bvh",), "there is no"),
        (("raise.lnd:5-5",), "frames 5 to 5"),
        (("raise.lnd", "-o", "-", "--strip", "--bars", "2"), "--strip and --bars"),
        (("raise.lnd", "-o", "a.gif"), "wanted an ending of svg, png or pdf"),
        (("raise.lnd", "-o", "-", "--parts", "wing"), 'there is no part "wing"'),
        (("raise.lnd", "-o", "-", "--from", "900"), "nothing from 900 s"),
        (("raise.lnd", "-o", "-", "--highlight", "r_arm hihg"), "hihg"),
        (("raise.lnd", "-o", "-", "--highlight", "r_arm high | count"), "without a pipe"),
        (("long.lnd", "-o", "long.png", "--strip", "--scale", "9"), "million pixels"),
        (("tail.lnd", "-o", "-"), "no column for tail"),
        (("empty.lnd", "-o", "-"), "an empty score"),
    ],
)
def test_mistakes_are_said(run, words: tuple[str, ...], said: str) -> None:
    done = run("score", *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("words", "library", "extra"),
    [
        (["score", "none.lnd", "-o", "b.png"], "resvg_py", "pictures"),
        (["search", "r_arm high", "--preview", "b.png"], "resvg_py", "pictures"),
        (["play", "none.lnd", "-o", "b.gif"], "PIL", "film"),
    ],
)
def test_a_missing_library_for_images_is_said_first(
    place: Path, words: list[str], library: str, extra: str
) -> None:
    code = (
        f"import sys; sys.modules['{library}'] = None\n"
        f"sys.argv = {['lanindex', *words, '--db', 'none.db']}\n{MAIN}"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=place, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    said = f"{library} is not installed. It comes with: pip install 'lanindex[{extra}]'.\n"
    assert done.stderr == f"lanindex: {words[-1][2:]}: {said}"
    assert not (place / words[-1]).exists()
