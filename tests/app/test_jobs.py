"""Verbs that read many files say which they left out."""

import json
import subprocess
from pathlib import Path

import command
import pytest
from dances import BOW, RAISE, dance
from made_gltf import Made, body, waving
from made_mvnx import mvnx, subject


@pytest.fixture
def place(tmp_path: Path) -> Path:
    dance(tmp_path / "in" / "bow.bvh", BOW)
    (tmp_path / "in" / "raise.lnd").write_text(RAISE)
    return tmp_path


@pytest.fixture
def run(place: Path):
    def call(*words: str, text: bytes = b"", code: int = 0) -> command.Done:
        done = command.run(*words, cwd=place, text=text)
        assert done.returncode == code, done.stderr
        return done

    return call


class TestIngest:
    def test_what_is_left_out_is_told(self, run, place: Path) -> None:
        for name in ("a.vmd", "b.vmd", "c.htr", "notes.txt"):
            (place / "in" / name).write_text("")
        (place / "in" / "l.csv").write_text("file,label\nbow.bvh,bow\nnone.bvh,bow\n")
        words = ("ingest", "in", "--db", "in/l.db", "--labels", "in/l.csv")
        for _ in range(2):
            said = run(*words).stderr.splitlines()
            assert said[0] == "in/l.csv: 1 of 2 rows name no file that is read"
            left = "left out: 2 .vmd, 1 .htr (formats that are not read yet); 1 other file"
            assert said[2] == left
        assert "left out" not in run(*words, "-q").stderr
        lines = [json.loads(line) for line in run(*words, "--json").stdout.splitlines()]
        assert [line["status"] for line in lines] == ["unchanged"] * 2

    def test_a_table_may_name_people_of_a_file(self, run, place: Path) -> None:
        duo = mvnx(subject(label="Ada"), subject(label="Ben"))
        (place / "in" / "duo.mvnx").write_bytes(duo)
        (place / "l.csv").write_text("file,label\nin/duo.mvnx#Ada,bow\nin/duo.mvnx#Cid,bow\n")
        said = run("ingest", "in", "--labels", "l.csv").stderr.splitlines()
        assert said[0] == "l.csv: 1 of 2 rows name no file that is read"
        assert said[1].startswith("4 files: 4 added; ")
        assert run("ingest", "in").stderr == "nothing new: 4 files unchanged\n"

    def test_what_is_read_with_a_capture_is_not_left_out(self, run, place: Path) -> None:
        made = Made()
        waving(made, body(made))
        (place / "in" / "a.gltf").write_bytes(made.gltf("a.bin"))
        (place / "in" / "a.bin").write_bytes(made.bytes)
        (place / "in" / "body.toml").write_text('RWrist = "RightHand"')
        for _ in range(2):
            assert "left out" not in run("ingest", "in", "--body", "in/body.toml").stderr
        (place / "in" / "b.bin").write_bytes(made.bytes)
        (place / "in" / "b.asf").write_bytes(b"")
        said = run("ingest", "in", "--body", "in/body.toml").stderr.splitlines()
        assert said[-1] == "left out: 2 other files"

    def test_nothing_but_what_is_left_out(self, run, place: Path) -> None:
        (place / "out").mkdir()
        (place / "out" / "a.htr").write_text("")
        said = "no capture or score in out, but 1 .htr (formats that are not read yet)\n"
        assert run("ingest", "out", code=1).stderr.endswith(said)

    def test_what_no_reader_understands_is_refused_once(self, run, place: Path) -> None:
        said = run("ingest", "in", "--unit", "furlong", code=2).stderr
        assert said.startswith("lanindex: ")
        assert "furlong" in said
        assert said.count("\n") == 1
        assert not (place / "lanindex.db").exists()

    def test_what_moved_is_told(self, run, place: Path) -> None:
        run("ingest", "in")
        (place / "in" / "bow.bvh").rename(place / "in" / "deep bow.bvh")
        before, summary = run("ingest", "in", "-v").stderr.splitlines()
        assert before == f"in/deep bow.bvh: was {place / 'in' / 'bow.bvh'} before"
        assert summary.startswith("2 files: 1 unchanged, 1 moved;")
        assert run("ingest", "in").stderr == "nothing new: 2 files unchanged\n"

    def test_nothing_new(self, run) -> None:
        run("ingest", "in")
        assert run("ingest", "in").stderr == "nothing new: 2 files unchanged\n"
        assert run("ingest", "in/bow.bvh").stderr == "nothing new: 1 file unchanged\n"
        assert "2 written anew" in run("ingest", "in", "--force").stderr


class TestExport:
    @pytest.mark.parametrize(
        "line",
        [
            b'{"capture": "in/bow.bvh", "capture_id": 1.5, "start_frame": 1, "end_frame": 2}',
            b'{"capture": "in/bow.bvh", "start_frame": 1, "end_frame": 9999999999999999999999999}',
            b'{"capture": "in/bow.bvh", "start_frame": 1, "end_frame": 2, "fit": NaN}',
            b"\xff",
        ],
    )
    def test_lines_that_are_no_hits(self, run, place: Path, line: bytes) -> None:
        run("ingest", "in")
        said = run("export", "-", "-o", "out", text=b"\n" + line, code=2).stderr
        assert said.startswith("lanindex: standard input:2: ")
        assert said.count("\n") == 1
        assert not (place / "out").exists()

    def test_closed_standard_input_holds_no_hits(self, run, place: Path) -> None:
        run("ingest", "in")
        words = [*command.COMMAND, "export", "-", "-o", "out"]
        done = subprocess.run(
            ["sh", "-c", 'exec "$@" <&-', "sh", *words],
            cwd=place,
            capture_output=True,
            text=True,
            check=False,
        )
        assert (done.returncode, done.stderr) == (1, "0 clips in out\n")


class TestEvaluate:
    """Rows and labels that fit nothing, and where what was judged wrongly is told."""

    WORDS = ("evaluate", "in", "--labels", "l.csv", "--patterns", "p.toml")

    def test_misses_stand_in_their_patterns_record(self, run, place: Path) -> None:
        (place / "l.csv").write_text("file,label\nin/bow.bvh,bow\nin/raise.lnd,raise\n")
        (place / "p.toml").write_text(
            'up = {pattern = "r_arm high", positives = ["b*"]}\n'
            'bow = {pattern = "r_arm forward mid", positives = ["bow"]}\n'
        )
        lines = run(*self.WORDS, "--misses", "--json").stdout.splitlines()
        up, bow, mean = map(json.loads, lines)
        assert [miss["kind"] for miss in up["misses"]] == ["missed", "wrong"]
        assert (up["f1"], bow["f1"], bow["misses"]) == (0, 1, [])
        assert list(mean) == ["pattern", "mean_f1", "standard_error", "clips", "patterns"]
        assert (mean["pattern"], mean["mean_f1"], mean["clips"]) == ("(mean)", 0.5, 2)

    @pytest.mark.parametrize("words", [(), ("--json",)])
    def test_nothing_to_measure(self, run, place: Path, words: tuple[str, ...]) -> None:
        (place / "l.csv").write_text("file,label\nin/bow.bvh,bow\n")
        (place / "p.toml").write_text('up = {pattern = "r_arm high", positives = ["walk*"]}\n')
        done = run(*self.WORDS, *words, code=1)
        assert done.stderr == (
            "up: no clip has the label walk*\n"
            "nothing was measured: no clip has a label that a pattern should find\n"
        )

    def test_a_file_that_cannot_be_read(self, run, place: Path) -> None:
        (place / "in" / "bow.bvh").write_text("HIERARCHY\n")
        (place / "l.csv").write_text("file,label\nin/bow.bvh,bow\n")
        (place / "p.toml").write_text('up = {pattern = "r_arm high", positives = ["bow"]}\n')
        done = run(*self.WORDS, "-q", code=2)
        assert done.stderr.startswith("lanindex: in/bow.bvh")
        assert done.stderr.endswith("; it counts as not found\n")
        assert done.stdout.splitlines()[-1] == "mean F1 0.000 ± 0.000, 1 pattern, 1 clip"

    def test_rows_that_name_no_clip(self, run, place: Path) -> None:
        (place / "p.toml").write_text('up = {pattern = "r_arm high", positives = ["bow"]}\n')
        (place / "l.csv").write_text("file,label\nin/bow.bvh,bow\nin/gone.bvh,bow\n")
        said = run(*self.WORDS).stderr
        assert said == "l.csv: 1 of 2 rows name no file that is read\n"
        (place / "l.csv").write_text("file,label\nbow.bvh,bow\n")
        said = run(*self.WORDS, code=2).stderr
        assert said.startswith("lanindex: l.csv: no row names a file that is read; the first names")
        assert f"is it {place / 'in' / 'bow.bvh'}?" in said
