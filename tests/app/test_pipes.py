"""Pipes, patterns in files and pasted scores, as they are typed."""

import json
from pathlib import Path

import command
import pytest
from dances import BOW, RAISE, dance


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pipes")
    dance(folder / "raise.bvh")
    dance(folder / "bow.bvh", BOW)
    (folder / "labels.csv").write_text("file,label,style\nraise.bvh,raise,slow\n")
    assert called(folder, "ingest", ".", "--labels", "labels.csv").returncode == 0
    (folder / "up.lq").write_text("// to overhead\nlet up = mid -> high;\nr_arm place low -> @up\n")
    (folder / "bad.lq").write_text("// to overhead\nr_arm mid\n  -> hihg\n")
    (folder / "score.lnd").write_text(RAISE)
    return folder


def called(place: Path, *words: str) -> command.Done:
    return command.run(*words, cwd=place)


def test_counts_are_a_table(place: Path) -> None:
    done = called(place, "search", "r_arm high | count by clip.label")
    assert done.stdout.splitlines()[:2] == ["clip.label\thits", "raise\t1"]
    assert done.stderr.endswith(" by 1 value\n")
    done = called(place, "search", "r_arm high | count by clip.label", "--json")
    assert json.loads(done.stdout) == {"by": "clip.label", "value": "raise", "count": 1}
    assert called(place, "search", "r_arm high | count").stdout == "1\n"


def test_what_counts_nothing_exits_with_1(place: Path) -> None:
    done = called(place, "search", "r_arm back | count", "-q")
    assert (done.returncode, done.stdout, done.stderr) == (1, "0\n", "")


def test_counts_have_no_clips(place: Path) -> None:
    done = called(place, "export", "r_arm | count")
    assert done.returncode == 2
    assert done.stderr == (
        'lanindex: hits that are only counted, wanted a pattern without "| count"\n'
    )


def test_a_column_that_is_not_there(place: Path) -> None:
    done = called(place, "search", "r_arm | sort by clip.mood")
    assert done.returncode == 2
    assert 'no capture has a column "mood", wanted clip and one of' in done.stderr
    assert "style" in done.stderr


def test_a_pattern_in_a_file(place: Path) -> None:
    done = called(place, "search", "@up.lq", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["pattern"].startswith("// to overhead\nlet up")
    done = called(place, "search", "@bad.lq")
    assert (done.returncode, done.stderr) == (
        2,
        'bad.lq:3:\n  -> hihg\n     ^^^^\nI don\'t know "hihg". Did you mean "high"?\n',
    )
    done = called(place, "search", "@none.lq")
    assert done.returncode == 2
    assert done.stderr.startswith("lanindex: none.lq: cannot be read: no such file")


def test_a_score_as_a_pattern(place: Path) -> None:
    assert called(place, "search", "@score.lnd").returncode == 0
    done = called(place, "search", "@score.lnd", "--strict", "--explain")
    assert done.returncode == 0, done.stderr
    assert " s (a fifth more or less)" in done.stdout
    done = called(place, "search", "r_arm high", "--strict")
    assert done.returncode == 2
    assert "Only the timing of pasted LND can be strict" in done.stderr
