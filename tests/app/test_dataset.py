"""``export --dataset`` as a user types it."""

import json
from functools import partial
from pathlib import Path

import command
import numpy as np
import pytest
from dances import BOW, RAISE, dance


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    tmp_path = tmp_path_factory.mktemp("dataset")
    rows = ["file,label,subject"]
    for number in range(4):
        for name, text in (("raise", RAISE), ("bow", BOW)):
            dance(tmp_path / f"{name}{number}.bvh", text)
            rows.append(f"{name}{number}.bvh,{name},S{number}")
    (tmp_path / "labels.csv").write_text("\n".join(rows))
    (tmp_path / "two.toml").write_text(
        'up = {pattern = "r_arm right mid", positives = ["raise"]}\n'
        'front = {pattern = "r_arm forward mid", positives = ["raise", "b*"]}\n'
    )
    return tmp_path


@pytest.fixture(scope="module")
def run(place: Path):
    run = partial(command.run, cwd=place)
    assert run("ingest", ".", "--labels", "labels.csv").returncode == 0
    return run


def test_patterns_become_a_data_set(run, place: Path) -> None:
    done = run("export", "--patterns", "two.toml", "--dataset", "two", "--pad", "3f", "--json")
    assert done.returncode == 0, done.stderr
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.stdout == (place / "two" / "clips.jsonl").read_text()
    assert {row["label"] for row in rows} == {"up", "front"}
    assert "up: 8 clips" in done.stderr
    assert "splits by subject." in done.stderr
    assert {row["performer"] for row in rows} == {"S0", "S1", "S2", "S3"}
    card = json.loads((place / "two" / "card.json").read_text())
    assert [one["expected"] for one in card["found"]] == [8, 4]
    assert card["how"]["time around each hit"] == "3f"
    assert card["how"]["tolerance"] == "0.1 s"
    again = run("export", "--patterns", "two.toml", "--dataset", "two")
    assert again.returncode == 2
    assert "--force" in again.stderr
    assert run("export", "--patterns", "two.toml", "--dataset", "two", "--force").returncode == 0


def test_a_pattern_a_pipe_a_range_and_whole_captures(run, place: Path) -> None:
    whole = run("export", "--dataset", "all", "--where", "label=bow", "--fps", "20")
    assert whole.returncode == 0, whole.stderr
    assert "4 clips" in whole.stderr
    clip = np.load(next((place / "all").rglob("*.npz")))
    assert (float(clip["fps"]), str(clip["label"])) == (20, "bow")
    sentence = "The right arm moves forward, at middle height, then stays where it is."
    pattern = run("export", "r_arm forward mid -> hold", "--dataset", "one", "--json")
    assert sentence in json.loads(pattern.stdout.splitlines()[0])["texts"]
    lines = run("search", "r_arm right mid", "--json").stdout
    piped = run("export", "-", "--dataset", "piped", text=lines)
    assert piped.returncode == 0, piped.stderr
    assert "8 clips" in piped.stderr
    ranged = run(
        *("export", "--capture", "bow1.bvh", "--from", "5", "--to", "25", "--dataset", "ranged"),
        *("--split", "0/0/100"),
    )
    assert ranged.returncode == 0, ranged.stderr
    assert np.load(place / "ranged" / "test" / "bow1_5-25.npz")["joints"].shape == (20, 20, 3)
    word = run("export", "raise", "--dataset", "word", "--json")
    assert word.returncode == 0, word.stderr
    assert json.loads(word.stdout.splitlines()[0])["texts"][0] == "raise"
    humanml = run("export", "r_arm any", "--dataset", "ml", "--layout", "humanml3d")
    assert humanml.returncode == 0, humanml.stderr
    assert (place / "ml" / "Mean.npy").exists()


def test_nothing_found_is_said(run, place: Path) -> None:
    done = run("export", "head back low", "--dataset", "none")
    assert done.returncode == 1
    assert "0 clips" in done.stderr
    assert not (place / "none").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("r_arm --patterns two.toml --dataset set", "a pattern and --patterns"),
        ("r_arm --dataset set --format c3d", "--format"),
        ("r_arm --dataset set --origin", "--origin"),
        ("r_arm --dataset set -o clips", "--output"),
        ("r_arm --dataset set --fps 0", "--fps"),
        ("r_arm --dataset set --layout zip", "npz or humanml3d"),
        ("r_arm --dataset set --split 1/2", "--split"),
        ("r_arm --dataset set --split-by shoe", 'no column "shoe"'),
        ("r_arm --dataset set --from 3", "--capture beside them"),
        ("- --dataset set --in *.bvh", "--in and --where"),
        ("r_arm --layout npz", "--layout, wanted --dataset"),
        ("r_arm --fps 20", "--fps, wanted --dataset"),
        ("r_arm --seed 2", "--seed, wanted --dataset"),
        ("--dataset set --pad long", "--pad"),
    ],
)
def test_what_does_not_go_together_is_refused(run, place: Path, words: str, said: str) -> None:
    done = run("export", *words.split(), text="")
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not (place / "set").exists()
