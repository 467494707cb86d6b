"""The command as a user types it: output, exit codes, errors."""

import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from functools import partial
from pathlib import Path

import command
import numpy as np
import pytest
from command import Done
from dances import BOW, RAISE, dance
from made_c3d import c3d, standing
from sample_library import sql

from lanindex.alphabet import MEASURES
from lanindex.app.cli import VERBS
from lanindex.app.commands import learn
from lanindex.encoding.profile import BUILT_IN

MAIN = "from lanindex.app.cli import main; main()"


@pytest.fixture
def place(tmp_path: Path) -> Path:
    dance(tmp_path / "raise.bvh")
    dance(tmp_path / "bow.bvh", BOW)
    (tmp_path / "score.lnd").write_text(RAISE)
    (tmp_path / "labels.csv").write_text("file,label,style\nraise.bvh,raise,slow\n")
    return tmp_path


@pytest.fixture
def run(place: Path):
    return partial(command.run, cwd=place)


@pytest.fixture
def filled(run, place: Path):
    done = run("ingest", ".", "--labels", "labels.csv")
    assert done.returncode == 0, done.stderr
    return run


def records(done: Done) -> list[dict]:
    return [json.loads(line) for line in done.stdout.splitlines()]


def refused(done: Done, *words: str) -> None:
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in done.stderr


class TestHelp:
    def test_every_verb_has_help(self, run) -> None:
        for verb in VERBS:
            done = run(verb, "--help")
            assert done.returncode == 0
            assert "Usage: lanindex " + verb in done.stdout

    @pytest.mark.parametrize(("verb", "word"), [("ingest", "PATH..."), ("remove", "CAPTURE...")])
    def test_several_are_shown_as_several(self, run, verb: str, word: str) -> None:
        assert word in run(verb, "--help").stdout.splitlines()[0]

    def test_options_stand_by_what_they_are_about(self, run) -> None:
        shown = run("search", "--help").stdout
        words = ["--like", "Which captures:", "--in", "How:", "--near", "Output:", "--json"]
        assert [shown.index(word) for word in words] == sorted(shown.index(word) for word in words)
        for verb in ("ingest", "inspect", "convert", "score", "play"):
            last = run(verb, "--help").stdout.rpartition("\n\n")[2]
            assert last.startswith("Reading files:\n  --unit")
            assert "  --fps RATE " in last  # of the file, in each verb

        own, of_data_sets = (
            run("export", "--help").stdout.split("Which captures:")[0].split("Data sets:")
        )
        assert "--seed" not in own
        assert all(
            f"  --{name} " in of_data_sets for name in ("dataset", "patterns", "fps", "seed")
        )

    def test_the_language_is_a_page(self, run, repository: Path) -> None:
        page = repository / "lanindex" / "search" / "LANGUAGE.md"
        assert run("language").stdout == page.read_text(encoding="utf-8")
        assert "lanindex language" in run("search", "--help").stdout

    def test_version(self, run) -> None:
        assert run("--version").stdout.startswith("lanindex 0.")

    def test_a_misspelt_verb(self, run) -> None:
        refused(run("serch", "r_arm high"), '"serch" is not a verb. Did you mean search?')
        refused(run("xyzzy"), '"xyzzy" is not a verb. All are shown by: lanindex --help')


class TestIngest:
    def test_json(self, run) -> None:
        done = run("ingest", ".", "--json")
        lines = records(done)
        assert done.returncode == 0
        assert [Path(line["capture"]).name for line in lines] == [
            "bow.bvh",
            "raise.bvh",
            "score.lnd",
        ]
        assert all(
            set(line) == {"capture", "status", "frames", "symbols", "warnings", "error"}
            for line in lines
        )
        assert done.stderr.startswith("3 files: 3 added;")

    def test_a_bad_file_is_told_and_the_rest_goes_in(self, run, place: Path) -> None:
        (place / "bad.bvh").write_text("HIERARCHY\n")
        refused(run("ingest", "."), "bad.bvh", "3 added, 1 failed")
        assert len(records(run("list", "--json"))) == 3

    def test_doubts_are_counted_and_fine_grids_are_none(self, run, place: Path) -> None:
        text = (place / "raise.bvh").read_text()
        (place / "raise.bvh").write_text(text.replace("Frames: 2", "Frames: 3"))
        shutil.copytree(BUILT_IN / "default", place / "coarse")
        numbers = (place / "coarse" / "profile.toml").read_text()
        coarse = re.sub(r"(?m)^division = \d+", "division = 1", numbers)
        (place / "coarse" / "profile.toml").write_text(coarse)
        words = ("ingest", "raise.bvh", "--profile", "coarse", "--force")
        done = run(*words)
        assert done.stderr.splitlines()[1:] == ["1 warning: lanindex list --doubts tells more"]
        tried = run(*words, "--dry-run")
        assert tried.stderr.splitlines()[1:] == ["1 warning: -v shows more"]
        doubt, _, grid = run(*words, "-v").stderr.splitlines()
        assert doubt.startswith("raise.bvh")
        assert grid == "grid finer than 1/1 of a unit: 1 score"
        (line,) = records(run(*words, "--json"))
        assert len(line["warnings"]) == 1
        assert run(*words, "-q").stderr == ""

    def test_a_table_of_other_files_is_told(self, run, place: Path) -> None:
        (place / "other.csv").write_text("file,label\nin/raise.bvh,raise\n")
        done = run("ingest", ".", "--labels", "other.csv", "--db", "new.db")
        assert done.returncode == 2
        assert "other.csv: no row names a file that is read" in done.stderr
        assert not (place / "new.db").exists()
        assert "no row" not in run("ingest", ".", "--labels", "labels.csv").stderr

    def test_what_is_only_labelled_is_told(self, filled, place: Path) -> None:
        (place / "labels.csv").write_text("file,style\nraise.bvh,quick\nbow.bvh,slow\n")
        done = filled("ingest", ".", "--labels", "labels.csv")
        assert "3 unchanged, 2 labelled anew;" in done.stderr
        labels = [line["label"] for line in records(filled("list", "--json"))]
        assert sorted(labels) == ["", "", "raise"]

    def test_what_was_there_is_written_anew(self, filled, place: Path) -> None:
        dance(place / "new.bvh", BOW)
        words = ("ingest", "bow.bvh", "score.lnd", "new.bvh", "--profile", "paper")
        would = filled(*words, "--dry-run").stderr
        assert "1 would be added, 1 would be written anew, 1 unchanged;" in would
        lines = records(filled(*words, "--force", "--json"))
        assert [line["status"] for line in lines] == ["added"] * 3
        assert "3 files: 3 written anew;" in filled(*words, "--force").stderr

    def test_dry_run(self, run, place: Path) -> None:
        done = run("ingest", ".", "--dry-run")
        assert done.returncode == 0
        assert "3 would be added" in done.stderr
        assert not (place / "lanindex.db").exists()

    @pytest.mark.parametrize(
        ("words", "said"),
        [
            (["nowhere.bvh"], "nowhere.bvh: there is no such file"),
            ([".", "--profile", "papre"], 'no profile "papre"'),
            ([".", "--fps", "fast"], '--fps: "fast", wanted 30'),
            ([".", "--labels", "none.csv"], "none.csv"),
            ([".", "--unit", "yard"], "yard"),
            ([".", "--up", "w"], "w"),
            ([".", "--compose", "both"], "both"),
            ([".", "--color", "blue"], '--color: "blue", wanted auto or always or never'),
        ],
    )
    def test_bad_words(self, run, words: list[str], said: str) -> None:
        refused(run("ingest", *words), said)


class TestSearch:
    def test_a_line_a_hit_in_a_pipe(self, filled) -> None:
        done = filled("search", "r_arm right mid -> place high", "--in", "*.bvh")
        assert done.returncode == 0
        path, start, end, begin, stop, _fit, said = done.stdout.strip().split("\t")
        assert Path(path).name == "raise.bvh"
        assert float(begin) == pytest.approx(int(start) / 30, abs=1e-5)
        assert float(stop) == pytest.approx(int(end) / 30, abs=1e-5)
        assert said == "r_arm right mid, place high"
        assert "1 hit in 1 capture" in done.stderr

    def test_json_as_designed(self, filled) -> None:
        (hit,) = records(filled("search", "r_arm place high", "--in", "*.bvh", "--json"))
        keys = "capture capture_id label fps start_frame end_frame start end fit symbols labels"
        assert list(hit) == [*keys.split(), "pattern"]
        assert hit["labels"] == {}
        assert hit["label"] == "raise"
        (symbol,) = hit["symbols"]
        keys = ["part", "direction", "level", "start_frame", "end_frame", "amount"]
        assert list(symbol) == keys  # of an arm: how far it is bent
        assert hit["pattern"] == "r_arm place high"

    def test_labels_in_json(self, filled) -> None:
        pattern = "a: (r_arm right -> place high) with b: l_arm left"
        (hit,) = records(filled("search", pattern, "--in", "*.bvh", "--json"))
        first, second, left = hit["symbols"]
        assert list(hit["labels"]) == ["a", "b"]
        edges = {"start_frame": first["start_frame"], "end_frame": second["end_frame"]}
        label = hit["labels"]["a"]
        assert {**second, **edges}.items() <= label.items()
        assert (label["start"], label["end"]) == (hit["start"], hit["end"])
        assert left.items() <= hit["labels"]["b"].items()
        assert set(label) - set(first) == {*MEASURES, "start", "end", "swings", "margin"}

    def test_limit_count_and_sort(self, filled) -> None:
        done = filled("search", "arm any", "--limit", "2")
        assert len(done.stdout.splitlines()) == 2
        assert "2 are shown" in done.stderr
        counts = [
            line.split("\t") for line in filled("search", "arm any", "--count").stdout.splitlines()
        ]
        assert len(counts) == 3
        fits = [
            hit["fit"] for hit in records(filled("search", "arm any", "--sort", "fit", "--json"))
        ]
        assert fits == sorted(fits, reverse=True)

    def test_the_best_of_a_fuzzy_search(self, filled, place: Path) -> None:
        best = "r_arm high", "--fuzzy", "1", "--sort", "fit"
        every = filled("search", *best)
        total = len(every.stdout.splitlines())
        assert every.stderr.startswith(f"{total} hits in ")
        for limit in (1, total - 1, total, total + 1):
            done = filled("search", *best, "--limit", str(limit))
            assert done.stdout.splitlines() == every.stdout.splitlines()[:limit]
            assert ("there are others" in done.stderr) is (limit < total)
        filled("search", *best, "--limit", "1", "--preview", "best.html")
        assert (place / "best.html").read_text().count('class="hit"') == 1

    def test_nothing_found(self, filled) -> None:
        done = filled("search", "r_leg high")
        assert (done.returncode, done.stdout) == (1, "")

    def test_an_error_shows_the_place(self, filled) -> None:
        done = filled("search", "r_arm rihgt mid")
        refused(done, "r_arm rihgt mid\n", "\n      ^^^^^\n", 'Did you mean "right"?')

    def test_explain(self, filled) -> None:
        done = filled("search", "r_arm right mid -> high", "--explain")
        assert done.returncode == 0
        assert "right" in done.stdout
        (line,) = filled("search", "r_arm right mid", "--explain", "--json").stdout.splitlines()
        record = json.loads(line)
        assert list(record) == ["pattern", "english", "steps", "order", "plan"]
        assert record["english"] == "The right arm moves to the right, at middle height."
        assert [it["step"] for it in record["steps"]] == ["r_arm right mid"]

    def test_explain_plan(self, filled) -> None:
        for words in (("r_arm high", "--explain", "plan"), ("--explain", "plan", "r_arm high")):
            done = filled("search", *words)
            assert done.returncode == 0
            assert done.stdout.splitlines()[1] == "  state 0    r_arm high    begins, ends"

    def test_a_pattern_without_quotes(self, run) -> None:
        refused(run("search", "r_arm", "high"), '"high" behind the pattern', "Quote the pattern.")

    def test_no_library(self, run) -> None:
        refused(run("search", "r_arm high"), "lanindex.db", "lanindex ingest")

    def test_a_closed_pipe_is_silent(self, filled, place: Path) -> None:
        done = subprocess.run(
            f"{sys.executable} -c '{MAIN}' search 'arm any' | true; echo ${{PIPESTATUS[0]}}",
            shell=True,
            executable="/bin/bash",
            cwd=place,
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout == "0\n"
        assert "Traceback" not in done.stderr


class TestExport:
    def test_from_a_search(self, filled, place: Path) -> None:
        hits = filled("search", "r_arm place low", "--json").stdout
        done = filled("export", "-", "-o", "out", text=hits)
        assert done.returncode == 0, done.stderr
        clips = done.stdout.split()
        assert len(clips) == 3
        assert all((place / clip).is_file() for clip in clips)
        assert (place / "out" / "manifest.csv").is_file()

    def test_from_a_pattern_and_a_range(self, filled, place: Path) -> None:
        assert filled("export", "r_arm place low", "-o", "a").returncode == 0
        done = filled("export", "--capture", "bow.bvh", "--from", "3", "--to", "9", "-o", "b")
        assert done.stdout.strip() == os.path.join("b", "bow_3-9.bvh")

    def test_no_more_than_is_wanted(self, filled) -> None:
        clips = [
            one["clip"] for one in records(filled("export", "arm any", "--limit", "2", "--json"))
        ]
        hits = records(filled("search", "arm any", "--limit", "2", "--json"))
        assert [it.rpartition("_")[2].partition(".")[0] for it in clips] == [
            f"{it['start_frame']}-{it['end_frame']}" for it in hits
        ]
        best = records(filled("export", "raise", "-n", "1", "--json", "-o", "best"))
        assert [it["fit"] for it in best] == [
            max(it["fit"] for it in records(filled("search", "raise", "--json")))
        ]

    def test_nothing_found(self, filled, place: Path) -> None:
        assert filled("export", "r_leg high", "-o", "out").returncode == 1
        assert not (place / "out").exists()

    def test_a_changed_source(self, filled, place: Path) -> None:
        dance(place / "raise.bvh", BOW)
        refused(filled("export", "r_arm place high", "-o", "out"), "raise.bvh", "has changed")
        assert list((place / "out").glob("*") if (place / "out").exists() else []) == []

    @pytest.mark.parametrize(
        "words",
        [[], ["r_arm high", "--capture", "1"], ["r_arm high", "--from", "1"], ["--capture", "99"]],
    )
    def test_bad_words(self, filled, words: list[str]) -> None:
        refused(filled("export", *words))


class TestRemove:
    def test_by_number_and_by_name(self, filled) -> None:
        done = filled("remove", "1", "score.lnd", "bow.bvh")
        assert (done.returncode, done.stderr) == (0, "2 captures removed\n")
        assert done.stdout == "id\tpath\n1\t./bow.bvh\n3\t./score.lnd\n"
        assert [line["capture_id"] for line in records(filled("list", "--json"))] == [2]

    def test_a_damaged_one_by_its_number(self, filled, place: Path) -> None:
        with closing(sqlite3.connect(place / "lanindex.db")) as library, library:
            library.execute("UPDATE capture SET location = '/elsewhere' WHERE id = 2")
        for words in (["list"], ["remove", "raise.bvh"], ["remove", "2", "--dry-run"]):
            assert filled(*words).returncode == 2
        assert "capture 2 is damaged" in filled("remove", "2", "--in", "*").stderr
        done = filled("remove", "2")
        assert (done.returncode, done.stderr) == (0, "1 capture removed\n")
        assert [line["capture_id"] for line in records(filled("list", "--json"))] == [1, 3]
        assert filled("remove", "2").returncode == 2

    def test_all_that_are_gone(self, filled, place: Path) -> None:
        assert filled("remove", "--missing").returncode == 1
        (place / "raise.bvh").unlink()
        (place / "score.lnd").unlink()
        tried = filled("remove", "--missing", "--dry-run", "--json")
        lines = records(tried)
        assert "2 captures would be removed" in tried.stderr
        assert [(line["capture_id"], line["label"]) for line in lines] == [(2, "raise"), (3, "")]
        done = filled("remove", "--missing", "--json")
        assert (done.returncode, done.stdout) == (0, tried.stdout)
        assert len(records(filled("list", "--json"))) == 1
        nothing = filled("remove", "--missing", "--json")
        assert (nothing.returncode, records(nothing)) == (1, [])

    @pytest.mark.parametrize(
        ("words", "gone"),
        [
            (["--in", "*.bvh"], [1, 2]),
            (["--in", "./[rs]*"], [2, 3]),
            (["score.lnd", "1", "--in", "*.bvh"], [1]),
            (["--missing", "--in", "*.lnd"], [3]),
            (["score.lnd", "--in", "*.bvh"], []),
            (["--in", "*.c3d"], []),
        ],
    )
    def test_by_glob(self, filled, place: Path, words: list[str], gone: list[int]) -> None:
        for name in ("raise.bvh", "score.lnd"):
            (place / name).unlink()
        done = filled("remove", *words, "--json")
        assert done.returncode == (0 if gone else 1), done.stderr
        assert [line["capture_id"] for line in records(done)] == gone
        left = [line["capture_id"] for line in records(filled("list", "--json"))]
        assert sorted(left + gone) == [1, 2, 3]

    @pytest.mark.parametrize(
        ("words", "said"),
        [
            ([], "nothing to remove, wanted captures, --in, --where or --missing"),
            (["1", "--missing"], "captures and --missing"),
            (["1", "rais.bvh"], "Did you mean"),
        ],
    )
    def test_bad_words(self, filled, words: list[str], said: str) -> None:
        refused(filled("remove", *words), said)
        assert len(records(filled("list", "--json"))) == 3


class TestWhere:
    @pytest.mark.parametrize(
        ("words", "kept"),
        [
            (["label=ra?se"], [2]),
            (["style=slow"], [2]),
            (["format=bvh"], [1, 2]),
            (["format=bvh", "label="], [1]),
            (["label=bow"], []),
        ],
    )
    def test_captures_are_chosen_alike(self, filled, words: list[str], kept: list[int]) -> None:
        where = [f"--where={word}" for word in words]
        code = 0 if kept else 1
        for verb in (["list"], ["search", "r_arm low"], ["show", "--all"], ["remove", "--dry-run"]):
            done = filled(*verb, *where, "--json")
            assert done.returncode == code, done.stderr
            assert sorted({line["capture_id"] for line in records(done)}) == kept
        done = filled("export", "r_arm low", *where, "-o", "out", "--json")
        assert sorted({line["capture_id"] for line in records(done)}) == kept

    @pytest.mark.parametrize(
        ("words", "said"),
        [
            (["list", "--where", "label"], '--where: "label", wanted KEY=GLOB'),
            (["search", "r_arm high", "--where", "=walk"], '--where: "=walk"'),
            (["list", "--where", "lable=walk"], 'no capture has a column "lable"'),
            (["show", "1", "--where", "label=walk"], "wanted --all beside it"),
            (["export", "-", "--where", "label=walk"], "wanted a pattern beside them"),
            (["export", "--capture", "1", "--in", "*"], "wanted a pattern beside them"),
        ],
    )
    def test_bad_words(self, filled, words: list[str], said: str) -> None:
        refused(filled(*words), said)


class TestOthers:
    def test_show(self, filled) -> None:
        done = filled("show", "raise.bvh", "--part", "r_arm", "--json")
        lines = records(done)
        assert [line["direction"] for line in lines if not line["passing"]] == [
            "place",
            "right",
            "place",
            "right",
            "place",
        ]
        assert {line["frames"] for line in lines} == {240}
        assert done.stderr == f"{len(lines)} symbols\n"
        refused(filled("show"), "wanted")
        refused(filled("show", "raise.bvh", "--part", "tail"), "tail", "r_arm")

    def test_show_into_a_table(self, filled, place: Path) -> None:
        lines = filled("show", "--all", "--json").stdout
        for form in ("csv", "jsonl", "parquet"):
            done = filled("show", "--all", "-o", f"all.{form}")
            assert (done.returncode, done.stdout) == (0, "")
            assert done.stderr == f"{len(lines.splitlines())} symbols\n"
        assert (place / "all.jsonl").read_text() == lines
        refused(filled("show", "--all", "-o", "all.csv"), "exists already")
        assert filled("show", "raise.bvh", "-o", "all.csv", "--force").returncode == 0
        refused(filled("show", "--all", "-o", "all.lnd"), "an ending of csv, jsonl or parquet")
        refused(filled("show", "--all", "-o", "a.csv", "--json"), "one of them")
        refused(filled("show", "--all", "--force"), "wanted --output beside it")
        nothing = filled("show", "--all", "--where", "label=none", "-o", "none.csv")
        assert nothing.returncode == 1
        assert not (place / "none.csv").exists()
        one = filled("convert", "all.csv", "--to", "lnd")
        assert one.returncode == 2
        assert filled("convert", "raise.bvh", "raise.symbols.csv").returncode == 0
        assert "direction r_arm place high" in filled("convert", "raise.symbols.csv").stdout
        said = filled("convert", "raise.bvh", "--to", "symbols.parquet")
        refused(said, "symbols.parquet on standard output")

    def test_hits_as_a_tier(self, filled, place: Path) -> None:
        assert filled("convert", "raise.bvh", "r.eaf").returncode == 0
        before = (place / "r.eaf").read_bytes()
        ask = ("search", "r_arm right", "--in", "*raise.bvh")
        found = records(filled(*ask, "--json"))
        refused(filled("search", "arm low", "--into", "r.eaf"), "captures, wanted one. Choose")
        refused(filled(*ask, "--into", "r.eaf", "--json"), "--into and --json, wanted one of them")
        refused(filled(*ask, "--tier", "a"), "--tier, wanted --into beside it")
        refused(filled(*ask, "--force"), "--force, wanted --into or --preview beside it")
        refused(filled(*ask, "--into", "none.eaf"), "no such file")
        refused(filled("search", "r_arm | count", "--into", "r.eaf"), "--into and | count")
        nothing = filled("search", "r_arm back high", "--in", "*raise.bvh", "--into", "r.eaf")
        assert nothing.returncode == 1
        assert (place / "r.eaf").read_bytes() == before
        done = filled(*ask, "--into", "r.eaf", "--tier", "raised")
        assert (done.returncode, done.stdout) == (0, "")
        assert done.stderr.endswith(f"r.eaf: {len(found)} hits in the tier raised\n")
        content = (place / "r.eaf").read_text()
        assert content.count(f"<ANNOTATION_VALUE>r_arm right {found[0]['fit']:.2f}") >= 1
        refused(filled(*ask, "--into", "r.eaf", "--tier", "raised"), "has a tier raised already")
        one = filled(*ask, "--into", "r.eaf", "--tier", "raised", "--force", "-n", "1")
        assert "1 hit in the tier" in one.stderr
        (place / "bad.eaf").write_text(content[:-30])
        refused(filled(*ask, "--into", "bad.eaf"), "damaged XML")
        assert (place / "bad.eaf").read_text() == content[:-30]

    def test_list_and_stats(self, filled) -> None:
        done = filled("list", "--json")
        lines = records(done)
        assert [line["label"] for line in lines] == ["", "raise", ""]
        assert lines[1]["metadata"] == {"style": "slow"}
        assert done.stderr.startswith("3 captures, ")
        assert records(filled("stats", "--json"))[0]["captures"] == 3

    def test_list_what_is_doubtful(self, run, place: Path) -> None:
        text = (place / "raise.bvh").read_text()
        (place / "raise.bvh").write_text(text.replace("Frames: 2", "Frames: 3"))
        run("ingest", ".")
        said = run("list", "--doubts")
        number, path, doubt = said.stdout.splitlines()[0].split("\t")
        assert (number, path) == ("2", "./raise.bvh")
        assert doubt == "Frames: says 340, the file has 240"
        (line,) = records(run("list", "--doubts", "--json"))
        assert doubt in line["warnings"]
        nothing = run("list", "--doubts", "--in", "bow.bvh")
        assert (nothing.returncode, nothing.stdout) == (1, "")

    def test_inspect(self, run) -> None:
        (seen,) = records(run("inspect", "raise.bvh", "--json"))
        assert seen["frames"] > 200
        assert seen["up"] == "y"
        assert all(seen["body"][joint] for joint in ("RWrist", "LAnkle", "Neck"))

    def test_convert_and_animate(self, run, place: Path) -> None:
        text = run("convert", "raise.bvh").stdout
        assert "direction r_arm place high" in text
        assert run("convert", "raise.bvh", "-o", "again.lnd").returncode == 0
        assert (place / "again.lnd").read_text() == text
        refused(run("convert", "raise.bvh", "-o", "again.lnd"), "exists already")
        assert run("convert", "raise.bvh", "-o", "-").stdout == text
        assert run("animate", "again.lnd", "--fps", "60").returncode == 0
        shown = run("animate", "again.lnd", "--fps", "60", "-o", "-").stdout
        assert shown == (place / "again.bvh").read_text()
        assert not (place / "-").exists()
        (seen,) = records(run("inspect", "again.bvh", "--json"))
        assert (Path(seen["capture"]).name, seen["fps"]) == ("again.bvh", 60)

    def test_scores_in_other_notations(self, run, place: Path) -> None:
        assert run("convert", "raise.bvh", "raise.eaf", "--media", "raise.mp4").returncode == 0
        assert b"raise.mp4" in (place / "raise.eaf").read_bytes()
        text = run("convert", "raise.eaf").stdout
        assert "direction r_arm place high" in text
        assert run("convert", "raise.eaf", "--to", "eaf").stdout.startswith("<?xml")
        refused(run("convert", "score.lnd", "raise.eaf"), "exists already")
        before = (place / "raise.eaf").read_bytes()
        refused(
            run("convert", "score.lnd", "--into", "raise.eaf", "--to", "eaf"), "already, wanted"
        )
        refused(
            run("convert", "score.lnd", "-o", "x.lnd", "--into", "raise.eaf"), "wanted --to eaf"
        )
        refused(run("convert", "score.lnd", "-o", "x.bvh"), "lanindex animate score.lnd")
        refused(run("convert", "score.lnd", "--tempo", "auto"), "beats for a score")
        refused(run("convert", "raise.eaf", "--into", "raise.eaf", "--force"), "that is read")
        assert (place / "raise.eaf").read_bytes() == before
        assert run("convert", "score.lnd", "--into", "raise.eaf", "--force").returncode == 0
        (place / "bad.eaf").write_bytes(before[:-20])
        refused(run("convert", "score.lnd", "--into", "bad.eaf", "--force"), "damaged XML")
        assert (place / "bad.eaf").read_bytes() == before[:-20]
        assert run("animate", "raise.eaf", "-o", "carried.bvh").returncode == 0
        said = run("convert", "raise.bvh", "raise.json").stderr
        assert "LabanotationSuite has no room for" in said
        assert "direction r_upper_arm place high" in run("convert", "raise.json").stdout

    def test_what_a_file_holds_beside_its_motion_is_kept_or_told(self, run, place: Path) -> None:
        events = {"EVENT:USED": 1, "EVENT:TIMES": np.array([[0.0, 0.1]])}
        (place / "a.c3d").write_bytes(c3d(standing(20), analog=np.ones((20, 4)), more=events))
        assert run("convert", "a.c3d", "b.c3d").stderr == "b.c3d\n"
        assert (place / "b.c3d").read_bytes() == (place / "a.c3d").read_bytes()
        run("ingest", "a.c3d")
        clip = ("export", "--capture", "a.c3d", "--from", "15", "-o", "cut", "--force")
        assert "not written to the clips: 1 event\n" in run(*clip).stderr
        assert "to the clips: 4 analog channels, 1 event\n" in run(*clip, "--origin").stderr
        assert "not written" not in run(*clip, "--from", "0").stderr
        for words in (("c.c3d", "--origin"), ("c.c3d", "--unit", "mm", "--force"), ("c.bvh",)):
            said = run("convert", "a.c3d", *words).stderr
            assert "a.c3d: not written: 4 analog channels, 1 event\n" in said

    def test_motion_bids_in_all_its_files_or_none(self, run, place: Path) -> None:
        stem = "sub-01_task-raise_tracksys-body"
        (place / f"{stem}_motion.json").write_text("mine")
        refused(run("convert", "raise.bvh", f"{stem}_motion.tsv"), "exists already")
        assert [it.name for it in place.glob("sub-*")] == [f"{stem}_motion.json"]
        done = run("convert", "raise.bvh", f"{stem}_motion.tsv", "--force")
        assert done.returncode == 0
        assert sorted(done.stderr.split()) == sorted(it.name for it in place.glob("sub-*"))
        assert len(done.stderr.split()) == 4
        text = run("convert", f"{stem}_motion.tsv").stdout
        assert "direction r_arm place high" in text
        refused(run("convert", "raise.bvh", "raise_motion.tsv"), "wanted a name like sub-01_task")
        refused(run("convert", "raise.bvh", "--to", "bids"), "bids on standard output")

    @pytest.mark.parametrize(("verb", "name"), [("convert", "bow.bvh"), ("animate", "score.lnd")])
    def test_what_is_read_is_not_written(self, run, place: Path, verb: str, name: str) -> None:
        before = (place / name).read_bytes()
        refused(run(verb, name, "-o", f"./{name}", "--force"), f"{name}: is the file that is read")
        assert (place / name).read_bytes() == before

    def test_db(self, filled) -> None:
        assert "current" in filled("db", "status").stdout
        assert filled("db", "check").returncode == 0
        assert filled("db", "upgrade").returncode == 0

    def test_db_segments(self, filled, place: Path) -> None:
        before = filled("search", "r_arm any")
        assert filled("db", "segments").stdout == "lanindex.db: columns in the library\n"
        told = filled("db", "segments", "cols").stdout
        assert told.startswith(f"lanindex.db: columns in {place / 'cols'}, 1 file, 0.0 MB")
        after = filled("search", "r_arm any")
        assert (after.stdout, after.stderr) == (before.stdout, before.stderr)
        assert len(list((place / "cols").iterdir())) == 1
        refused(filled("db", "segments", "nowhere://x"), "fsspec knows no nowhere://")
        refused(filled("db", "segments", "cols", "--inside"), "--inside")
        assert filled("db", "segments", "--inside").stdout.endswith("in the library\n")
        assert list((place / "cols").iterdir()) == []

    def test_columns_that_another_program_made_untrue(self, filled, place: Path) -> None:
        told = filled("db", "status").stdout
        assert re.search(r"^columns: \d+ symbols in 1 segment$", told, re.MULTILINE)
        before = filled("search", "r_arm any")
        assert "columns" not in before.stderr
        with sql(place / "lanindex.db") as connection:
            connection.execute("UPDATE state SET stamp = stamp + 1")
        assert "columns: out of date" in filled("db", "status").stdout
        assert "the columns are out of date" in filled("db", "check").stdout
        done = filled("search", "r_arm any")
        assert (done.returncode, done.stdout) == (0, before.stdout)
        assert done.stderr == (
            "the library's columns were out of date, for another program has changed the library: "
            f"they are made of its symbols now\n{before.stderr}"
        )
        assert filled("search", "r_arm any").stderr == before.stderr

    @pytest.mark.parametrize(("revision", "state"), [("0000", "older"), ("9999", "newer")])
    def test_a_library_that_does_not_fit(
        self, filled, place: Path, revision: str, state: str
    ) -> None:
        with sql(place / "lanindex.db") as connection:
            connection.execute("UPDATE alembic_version SET version_num = ?", [revision])
        done = filled("db", "status")
        assert (done.returncode, done.stdout) == (1, f"lanindex.db: revision {revision}, {state}\n")
        assert records(filled("db", "status", "--json"))[0]["state"] == state
        refused(filled("list"), "lanindex.db")

    def test_the_library_may_be_named_by_the_environment(self, run, place: Path) -> None:
        env = {"LANINDEX_DB": str(place / "other.db")}
        assert run("ingest", "bow.bvh", env=env).returncode == 0
        assert (place / "other.db").exists()
        assert run("list", env=env).returncode == 0


class TestEvaluate:
    def test_figures(self, run, place: Path) -> None:
        (place / "labels.csv").write_text("file,label\nraise.bvh,raise\nbow.bvh,bow\n")
        (place / "p.toml").write_text(
            'up = {pattern = "r_arm place high", positives = ["raise"]}\n'
            'any = {pattern = "r_arm low", positives = ["raise"]}\n'
            'left = {pattern = "l_arm place high", positives = ["raise"]}\n'
        )
        words = ["evaluate", ".", "--labels", "labels.csv", "--patterns", "p.toml"]
        up, anything, left, last = records(run(*words, "--json"))
        assert last["pattern"] == "(mean)"
        assert (up["precision"], up["recall"], up["f1"]) == (1, 1, 1)
        assert (anything["precision"], anything["recall"]) == (0.5, 1)
        assert (left["missed"], left["f1"]) == (1, 0)
        assert last["mean_f1"] == pytest.approx((1 + 2 / 3 + 0) / 3)
        assert last["clips"] == 2
        said = run(*words, "--misses").stdout
        assert "left: missed" in said
        assert "any: wrongly" in said
        assert said.splitlines()[-1].endswith(", 3 patterns, 2 clips")
        (place / "p.toml").write_text('up = {pattern = "r_arm high", positives = ["raise"]}\n')
        assert run(*words).stdout.endswith(", 1 pattern, 2 clips\n")

    def test_a_table_without_labels(self, run, place: Path) -> None:
        (place / "l.csv").write_text("file,style\nraise.bvh,slow\n")
        (place / "p.toml").write_text('up = {pattern = "r_arm high", positives = ["raise"]}\n')
        done = run("evaluate", ".", "--labels", "l.csv", "--patterns", "p.toml")
        refused(done, 'l.csv: no labels, wanted a column "label"')

    def test_bad_patterns(self, run, place: Path) -> None:
        words = ["evaluate", ".", "--labels", "labels.csv", "--patterns", "p.toml"]
        for text, said in (
            ('up = "r_arm high"', "wanted name = {pattern"),
            ('up = {pattern = "r_arm hihg", positives = ["raise"]}', "hihg"),
            ("up = {", "wanted TOML"),
            ("", "no patterns"),
        ):
            (place / "p.toml").write_text(text)
            refused(run(*words), said)


class TestOddCalls:
    """What a try-out as a new user broke once."""

    def test_a_pattern_may_begin_with_an_arrow(self, filled) -> None:
        refused(filled("search", "-> high"), "Nothing before the arrow. Name a part first")

    @pytest.mark.parametrize(
        ("words", "where"),
        [
            (["search", ""], ""),
            (["ingest", ".", ""], ""),
            (["export", "r_arm high", "-o", ""], "-o: "),
            (["list", "--db", ""], "--db: "),
            (["db", "status", "--db="], "--db: "),
        ],
    )
    def test_an_empty_argument(self, filled, words: list[str], where: str) -> None:
        said = f"lanindex: {where}an empty argument, wanted a value\n"
        done = filled(*words)
        assert (done.returncode, done.stderr) == (2, said)

    def test_an_empty_variable_is_not_set(self, filled) -> None:
        assert filled("list", env={"LANINDEX_DB": ""}).returncode == 0

    @pytest.mark.parametrize("tolerance", ["nan", "inf", "1e400", "-1"])
    def test_no_tolerance(self, filled, tolerance: str) -> None:
        refused(filled("search", "r_arm high", f"--tolerance={tolerance}"), "tolerance")

    @pytest.mark.parametrize("name", ["9" * 20, "\udcff", "nothing"])
    def test_no_such_capture(self, filled, name: str) -> None:
        refused(filled("show", name), "lanindex")
        refused(filled("export", "--capture", name), "lanindex")

    def test_no_room_for_the_output(self, filled, place: Path) -> None:
        if not Path("/dev/full").exists():
            pytest.skip("there is no /dev/full here")
        done = subprocess.run(
            f"{sys.executable} -c '{MAIN}' list >/dev/full",
            shell=True,
            cwd=place,
            capture_output=True,
            text=True,
        )
        refused(done, "standard output: cannot be written")

    def test_a_closed_output_is_no_error(self, filled, place: Path) -> None:
        done = subprocess.run(
            f"{sys.executable} -W error::RuntimeWarning -c '{MAIN}' list >&-",
            shell=True,
            executable="/bin/bash",
            cwd=place,
            capture_output=True,
            text=True,
        )
        assert "Traceback" not in done.stderr

    def test_files_that_all_fail_make_no_library(self, run, place: Path) -> None:
        (place / "bad.bvh").write_text("junk")
        refused(run("ingest", "bad.bvh"), "bad.bvh", "1 file: 1 failed")
        assert not list(place.glob("lanindex.db*"))
        assert run("ingest", "raise.bvh").returncode == 0
        refused(run("ingest", "bad.bvh"), "1 failed")
        assert (place / "lanindex.db").exists()

    @pytest.mark.parametrize("kept", [[], ["--folder", "kept"]])
    def test_a_demo_leaves_what_is_asked_for(
        self, run, place: Path, repository: Path, monkeypatch: pytest.MonkeyPatch, kept: list[str]
    ) -> None:
        (place / "few").mkdir()
        for name in ("radio_gymnastics.bvh", "labels.csv"):
            shutil.copy(repository / "corpus" / name, place / "few")
        monkeypatch.setattr(learn, "choreographies", lambda: place / "few")
        monkeypatch.setattr("tempfile.tempdir", str(place))
        there = {*place.iterdir()}
        done = run("demo", *kept)
        assert done.returncode == 0
        assert {*place.iterdir()} == there | {place / name for name in kept[1:]}
        assert ("lanindex demo --folder" in done.stdout) == (not kept)

    def test_an_empty_folder_makes_no_library(self, run, place: Path) -> None:
        (place / "empty").mkdir()
        done = run("ingest", "empty")
        assert done.returncode == 1
        assert "no capture or score in empty" in done.stderr
        assert not (place / "lanindex.db").exists()

    def test_control_characters_keep_to_their_field(self, run, place: Path) -> None:
        dance(place / "in" / "a\tb\nc.bvh")
        assert run("ingest", "in").returncode == 0
        (line,) = run("search", "r_arm place high").stdout.splitlines()
        assert line.split("\t")[0] == "in/a\\x09b\\x0ac.bvh"

    def test_any_hits_are_exported(self, filled, place: Path) -> None:
        from lanindex.pipeline.library import open_library

        with open_library(place / "lanindex.db") as library:
            hits = [hit for hit in library.search("r_arm place low") if hit.fit > 0]
            assert len(library.export(hits, place / "some")) == len(hits) == 3
