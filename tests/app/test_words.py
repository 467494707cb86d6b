"""The dictionary of movement: ``words``, and a word as a query."""

import json
from pathlib import Path

import pytest
from dances import BOW, dance
from typer.testing import CliRunner

from lanindex.app.cli import app
from lanindex.pipeline.library import open_library

FIGURES = ("precision", "recall", "clips")
OWN = 'reach = {pattern = "r_arm forward mid", sentence = "A hand goes forward."}'


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("LANINDEX_WORDS", raising=False)
    dance(tmp_path / "raise.bvh")
    dance(tmp_path / "bow.bvh", BOW)
    (tmp_path / "own.toml").write_text(OWN)
    (tmp_path / "labels.csv").write_text("file,label\nraise.bvh,raise slowly\nbow.bvh,bow\n")
    with open_library("lanindex.db", create=True) as library:
        library.ingest(tmp_path / "raise.bvh", tmp_path / "bow.bvh", labels="labels.csv")
    return tmp_path


@pytest.fixture
def run(place: Path):
    return lambda *words, **more: CliRunner().invoke(app, list(words), **more)


def records(done) -> list[dict]:
    return [json.loads(line) for line in done.stdout.splitlines()]


class TestWords:
    def test_lists_all(self, run) -> None:
        lines = run("words").stdout.splitlines()
        assert lines[0].split("\t") == ["word", *FIGURES, "sentence", "pattern"]
        assert any(line.startswith("walk\t0.9") for line in lines)

    def test_shows_one_by_any_name(self, run) -> None:
        shown = run("words", "Wave right hand").stdout
        assert "mirrored   wave_left" in shown
        assert "r_forearm" in shown

    def test_as_records(self, run) -> None:
        (walk,) = records(run("words", "walking", "--json"))
        assert walk["name"] == "walk"
        assert walk["mirror_image"] == "itself"
        assert walk["precision"] >= 0.8
        assert len(records(run("words", "--json"))) > 10

    def test_own_words_by_option_and_variable(self, run) -> None:
        for done in (
            run("words", "reach", "--words", "own.toml"),
            run("words", "reach", env={"LANINDEX_WORDS": "own.toml"}),
        ):
            assert "A hand goes forward." in done.stdout

    def test_a_stranger_is_refused_with_the_nearest(self, run) -> None:
        done = run("words", "wlk")
        assert done.exit_code == 2
        assert 'no word "wlk" in the dictionary of movement. Did you mean walk?' in done.stderr

    @pytest.mark.parametrize("word", ["jump", "Turn around", "point"])
    def test_why_a_word_is_not_there(self, run, word: str) -> None:
        done = run("words", word)
        assert done.exit_code == 2
        assert f'no word "{word}" in the dictionary of movement: ' in done.stderr
        assert "Did you mean" not in done.stderr


class TestSearch:
    @pytest.mark.parametrize("asked", ["raise", "@raise", "Lift"])
    def test_a_word_is_a_query(self, run, asked: str) -> None:
        done = run("search", asked, "--json")
        assert done.exit_code == 0
        assert {Path(hit["capture"]).name for hit in records(done)} == {"raise.bvh"}
        assert records(done)[0]["pattern"].startswith("(arm low or arm at low) ...[<3s] high")

    def test_it_says_what_that_means_and_who_is_labelled_so(self, run) -> None:
        done = run("search", "raise")
        assert "raise: An arm goes up" in done.stderr
        assert '1 capture is labelled "raise slowly"' in done.stderr
        assert 'lanindex list --where "label=raise slowly"' in done.stderr

    def test_nothing_is_said_of_labels_that_nobody_has(self, run) -> None:
        done = run("search", "kick")
        assert done.exit_code == 1
        assert "labelled" not in done.stderr

    def test_a_stranger_may_be_a_label(self, run, place: Path) -> None:
        with open_library("lanindex.db") as library:
            library.label(1, "sit deep")
        done = run("search", "sit")
        assert done.exit_code == 2
        assert 'no word "sit" in the dictionary of movement: there was no labelled' in done.stderr
        assert "Did you mean:  other support seat/other 1s+" in done.stderr
        assert 'lanindex list --where "label=sit deep"' in done.stderr

    @pytest.mark.parametrize("asked", ["walk with raise", "raise with head"])
    def test_a_word_in_a_pattern_is_told_how_it_is_written(self, run, asked: str) -> None:
        assert f'Did you mean "@{asked.split()[0]}"?' in run("search", asked).stderr

    @pytest.mark.parametrize("asked", ["r_arm", "arms", "head"])
    def test_a_part_is_no_stranger(self, run, asked: str) -> None:
        assert "dictionary" not in run("search", asked, "--count").stderr

    def test_own_words(self, run) -> None:
        assert run("search", "reach", "--words", "own.toml").exit_code == 0
        assert run("search", "reach", env={"LANINDEX_WORDS": "own.toml"}).exit_code == 0
        refused = run("search", "reach")
        assert refused.exit_code == 2

    def test_the_best_comes_first_and_a_picture_has_the_word_for_a_title(self, run) -> None:
        Path("own.toml").write_text('move = {pattern = "arm any", sentence = "Anything."}')
        fits = [
            hit["fit"] for hit in records(run("search", "move", "--words", "own.toml", "--json"))
        ]
        by_time = [hit["fit"] for hit in records(run("search", "arm any", "--json"))]
        assert fits == sorted(by_time, reverse=True) != by_time
        done = run("search", "move", "--words", "own.toml", "--preview", "hits.svg", "--limit", "1")
        assert done.exit_code == 0
        assert ">move \u00b7 the first 1 of" in Path("hits.svg").read_text()

    def test_advice_says_the_word(self, run) -> None:
        done = run("search", "@raise -> torso left low")
        assert done.exit_code == 1
        assert '"torso left low" is nowhere' in done.stderr
        offered = [line.strip() for line in done.stderr.splitlines() if "@raise" in line]
        assert offered
        assert "...[<3s] high" not in done.stderr
        assert run("search", offered[-1].partition("  ")[0]).exit_code == 0

    def test_a_word_may_stand_in_a_pattern(self, run) -> None:
        assert run("search", "r_arm during @raise").exit_code == 0
        assert run("search", "@kick or @reach", "--words", "own.toml").exit_code == 0
        stranger = run("search", "r_arm during @reach")
        assert stranger.exit_code == 2
        assert 'There is no pattern "@reach"' in stranger.stderr

    def test_export_and_explain(self, run, place: Path) -> None:
        assert run("export", "raise", "-o", "clips").exit_code == 0
        assert len(list((place / "clips").glob("*.bvh"))) == 1
        assert "arm" in run("search", "raise", "--explain").stdout

    def test_from_python(self, place: Path) -> None:
        with open_library("lanindex.db") as library:
            assert [hit.capture.label for hit in library.search("raise")] == ["raise slowly"]

    def test_a_broken_file_is_refused(self, run, place: Path) -> None:
        (place / "own.toml").write_text('reach = {pattern = "r_arm forwrad"}')
        done = run("search", "reach", "--words", "own.toml")
        assert done.exit_code == 2
        assert "own.toml: reach: the pattern is not understood" in done.stderr
        assert 'Did you mean "forward"?' in done.stderr
