"""``stats`` as a user types it."""

import json
from functools import partial
from pathlib import Path

import command
import pytest
from dances import BOW, RAISE, dance


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("stats")
    rows = ["file,label"]
    for number in range(5):
        for name, text in (("raise", RAISE), ("bow", BOW)):
            dance(folder / f"{name}{number}.bvh", text)
            rows.append(f"{name}{number}.bvh,{name}")
    (folder / "labels.csv").write_text("\n".join(rows))
    return folder


@pytest.fixture(scope="module")
def run(place: Path):
    run = partial(command.run, cwd=place, env={"DISPLAY": ""})
    assert run("ingest", ".", "--labels", "labels.csv").returncode == 0
    return run


def test_movement_is_told_and_drawn(run, place: Path) -> None:
    pytest.importorskip("matplotlib")
    words = ("stats", "--by", "label", "--part", "r_arm", "--plot", "out.svg")
    done = run(*words)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0].split("\t")[:4] == ["label", "part", "captures", "moves"]
    assert "r_arm\tright mid\t0.0 % (0)" in done.stdout
    assert "differences matter" in done.stderr
    assert (place / "out.svg").read_text().startswith("<?xml")
    assert run(*words).returncode == 2
    assert run(*words, "--force").returncode == 0


def test_records_are_of_one_kind(run) -> None:
    groups = [
        json.loads(line) for line in run("stats", "--by", "label", "--json").stdout.splitlines()
    ]
    assert {one["group"] for one in groups} == {"bow", "raise"}
    assert len({tuple(one) for one in groups}) == 1
    words = ("stats", "--by", "label", "--compare", "raise", "bow", "--json")
    apart = [json.loads(line) for line in run(*words).stdout.splitlines()]
    assert {tuple(one["groups"]) for one in apart} == {("raise", "bow")}
    keys = "by groups part what values captures movements difference least most p matters"
    assert {" ".join(one) for one in apart} == {keys}
    assert apart[0]["matters"]
    whole = run("stats", "--json")
    assert json.loads(whole.stdout)["captures"] == 10


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ("--compare raise bow", 2, "--by beside it"),
        ("--by shoe", 2, 'no column "shoe"'),
        ("--by label --compare raise wave", 2, 'no "wave"'),
        ("--by label --compare raise raise", 2, "two different"),
        ("--by label --plot out.gif", 2, '"gif"'),
        ("--by label --plot out", 2, "an ending"),
        ("--by path --plot paths.png", 2, "10 groups"),
        ("--part tail", 2, 'no part "tail"'),
        ("--force", 2, "--plot beside it"),
        ("--in *.c3d", 1, ""),
    ],
)
def test_what_cannot_be_is_said(run, words: str, code: int, said: str) -> None:
    done = run("stats", *words.split())
    assert done.returncode == code
    assert said in done.stderr
    assert "Traceback" not in done.stderr
