"""``similar`` and ``motifs`` as a user types them."""

import json
from functools import partial
from pathlib import Path

import command
import pytest
from command import screen, shown
from dances import BOW, RAISE, dance

from lanindex.pipeline.library import open_library


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("similar")
    dance(folder / "bow.bvh", BOW)
    dance(folder / "raise.bvh", RAISE)
    dance(folder / "again.bvh", RAISE, 60)
    with open_library(folder / "own.db", create=True) as library:
        library.ingest(folder)
        library.label("raise.bvh", "raise")
    return folder


@pytest.fixture
def run(place: Path):
    return partial(command.run, cwd=place, env={"LANINDEX_DB": "own.db"})


def test_groups_are_told(run, place: Path) -> None:
    done = run("similar", "--json")
    assert done.returncode == 0, done.stderr
    groups = [json.loads(line) for line in done.stdout.splitlines()]
    assert [group["count"] for group in groups] == [2, 1]
    assert groups[0]["captures"][0] == groups[0]["capture"]
    assert done.stderr == "1 group of 3 captures; 1 capture like no other\n"
    piped = [line.split("\t") for line in run("similar").stdout.splitlines()]
    assert [line[0] for line in piped] == ["captures", "2", "1"]
    lines = screen(shown("similar", "--db", "own.db", cwd=place)).splitlines()
    assert lines[1].split()[:2] == ["captures", "alike"]
    assert len(lines) == 4  # a capture by itself is counted only
    assert lines[0] not in lines[2]  # the folder of all


def test_motifs_are_told(run, place: Path) -> None:
    words = ("motifs", "--min-count", "2", "--length", "2", "--part", "r_arm")
    done = run(*words, "--json")
    assert done.returncode == 0, done.stderr
    motifs = [json.loads(line) for line in done.stdout.splitlines()]
    for motif in motifs[:3]:
        found = run("search", motif["pattern"], "--json")
        hits = [json.loads(line) for line in found.stdout.splitlines()]
        keys = ("capture", "capture_id", "start_frame", "end_frame")
        assert [{key: hit[key] for key in keys} for hit in hits] == motif["places"]
        assert motif["hits"] == len(hits)
    piped = run(*words).stdout.splitlines()
    assert [line.split("\t")[2] for line in piped] == [motif["pattern"] for motif in motifs]
    lines = screen(shown(*words, "--limit", "1", "--db", "own.db", cwd=place)).splitlines()
    assert lines[0] == motifs[0]["pattern"]
    assert lines[1].strip().startswith(f"{motifs[0]['hits']} hits in ")
    assert "is shown, --limit shows more" in lines[2]


def test_a_sample_says_so(run, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = {
        "similar": ["similar"],
        "motifs": ["motifs", "--min-count", "2", "--length", "2", "--part", "r_arm"],
    }
    for verb, words in asked.items():
        module = {"similar": "example"}.get(verb, verb)
        monkeypatch.setattr(f"lanindex.pipeline.{module}.SAMPLE", 2)
        done = run(*words, "--json")
        assert done.stderr.startswith("2 of 3 captures, taken at random, were "), done.stderr
        assert "--all " in done.stderr
        assert "in 2 captures" in done.stderr or "of 2 captures" in done.stderr
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        # nothing recurs in the two that are drawn
        assert {(line["sampled"], line["of"]) for line in lines} == (
            {(2, 3)} if verb == "similar" else set()
        )
        every = run(*words, "--all", "--json")
        assert "taken at random" not in every.stderr
        lines = [json.loads(line) for line in every.stdout.splitlines()]
        assert {(line["sampled"], line["of"]) for line in lines} == {(3, 3)}


def test_groups_that_are_wanted_are_counted(run) -> None:
    done = run("similar", "--groups", "2")
    assert done.stderr == "2 groups of 3 captures, 1 of them of one capture\n"


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (("similar", "--groups", "2", "--alike", "0.5"), 2, "--groups and --alike, wanted one"),
        (("similar", "--alike", "2"), 2, "--alike: 2.0"),
        (("similar", "--in", "none"), 1, "0 groups of 0 captures"),
        (("motifs", "--min-count", "99"), 1, "0 motifs in 3 captures"),
        (("motifs", "--part", "tail"), 2, '--part: "tail", wanted one of'),
    ],
)
def test_what_cannot_be_is_told(run, words: tuple[str, ...], code: int, message: str) -> None:
    done = run(*words)
    assert done.returncode == code
    assert message in done.stderr
    assert "Traceback" not in done.stderr
