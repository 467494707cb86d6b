"""Output on a terminal: no control characters of files, lines that fit."""

import json
import re
import sys
from pathlib import Path

import command
import pytest
from command import screen, shown, start, start_on_terminal
from dances import BOW, dance

from lanindex.app import output
from lanindex.app.output import ESCAPED, Output, escaped, say_error
from lanindex.errors import PatternError, UsageError

EVIL = "esc\x1b[31m\x07\x7f\x9b1m\u202e\u2066\u200f\u061c\u2028.bvh"
STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("terminal")
    plain = dance(folder / "a" / ("long" * 30) / "bow.bvh", BOW).read_text()
    (folder / "a" / EVIL).write_text(plain.replace("LeftHand", "Left\x1b[31m\u202eHand"))
    (folder / "a" / ("歩く" * 20 + ".bvh")).write_text(plain)
    (folder / "a" / "bad\x1b[2J.bvh").write_text("HIERARCHY\n")
    (folder / "labels.csv").write_text(f'file,label\n"a/{EVIL}","\x1b]0;title\x07"\n')
    called(folder, "ingest", "a", "--labels", "labels.csv")
    return folder


def called(place: Path, *words: str) -> command.Done:
    return command.run(*words, cwd=place)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["ingest", "a", "--force"], "bad\\x1b[2J.bvh"),
        (["list"], "\\x1b]0;title\\x07"),
        (["search", "r_arm place low"], "esc\\x1b[31m\\x07\\x7f\\x9b1m\\u202e\\u2066"),
        (["search", "r_arm place low", "--count"], "esc\\x1b[31m"),
        (["search", "r_arm \x1b[31m\u202e"], "\\x1b[31m\\u202e"),
        (["search", "r_arm high", "--limit=\x1b[31m"], "\\x1b[31m"),
        (["search", "r_arm high", "--\x1b[31m"], "\\x1b[31m"),
        (["--\x1b[31m"], "\\x1b[31m"),
        (["\x1b[31m"], "\\x1b[31m"),
        (["show", "1", "--part", "torso"], "esc\\x1b[31m"),
        (["show", "\x1b[31m\n"], "\\x1b[31m\\x0a"),
        (["stats"], "label \\x1b]0;title\\x07"),
        (["list", "--db", "\x1b[31m"], "\\x1b[31m"),
        (["inspect", f"a/{EVIL}"], "Left\\x1b[31m\\u202eHand"),
        (["export", "r_arm place low", "-o", "\x1b[31m", "--force"], "\\x1b[31m"),
        (["remove", "1", "--dry-run"], "esc\\x1b[31m"),
    ],
)
def test_nothing_of_a_file_steers_a_terminal(place: Path, words: list[str], said: str) -> None:
    done = called(place, *words)
    assert said in done.stdout + done.stderr
    assert STEERING.findall(done.stdout + done.stderr) == []
    seen = re.sub(r"\x1b\[(\d*[AK]|\?25[lh])|\r", "", shown(*words, cwd=place))
    assert STEERING.findall(seen) == []


def test_colours_of_our_own_stay(place: Path) -> None:
    seen = called(place, "search", "r_arm place low", "--color", "always").stdout
    assert "\x1b" not in seen  # rows of a pipe are records
    seen = shown("search", "r_arm place low", cwd=place, NO_COLOR="")
    assert seen.startswith("\x1b[2ma/\x1b[0m\n\x1b[35mesc\\x1b[31m\\x07\\x7f\\x9b1m")
    assert "\x1b[2m\\x1b]0;title\\x07\x1b[0m" in seen


def test_json_stays_json(place: Path) -> None:
    for words in (["list"], ["search", "r_arm place low"], ["show", "1"], ["stats"]):
        done = called(place, *words, "--json")
        assert STEERING.findall(done.stdout) == []
        records = [json.loads(line) for line in done.stdout.splitlines()]
        assert records[0].get("capture", f"a/{EVIL}") == f"a/{EVIL}"
        assert len({tuple(record) for record in records}) == 1


def test_json_is_read_back_where_the_output_knows_no_unicode(place: Path) -> None:
    done = start("list", "--json", cwd=place, env={"PYTHONIOENCODING": "latin-1"})
    paths = [json.loads(line)["capture"] for line in done.stdout.splitlines()]
    assert "a/" + "歩く" * 20 + ".bvh" in paths


def test_every_control_is_escaped() -> None:
    assert STEERING.findall("".join(map(chr, ESCAPED)))
    assert escaped("".join(map(chr, range(0x3000)))).isascii() is False
    assert STEERING.findall(escaped("".join(map(chr, range(0x3000))))) == []
    assert escaped("plain 歩く é") == "plain 歩く é"
    assert escaped("walk\x1b[31m.bvh") == "walk\\x1b[31m.bvh"


def test_what_is_painted_stands_alone(capsys: pytest.CaptureFixture[str]) -> None:
    out = Output(color="always")
    out.line(out.paint("a\x1bb", "path"), " \x1b", out.paint("c", "dim"))
    assert capsys.readouterr().out == "\x1b[35ma\\x1bb\x1b[0m \\x1b\x1b[2mc\x1b[0m\n"


@pytest.mark.parametrize(
    ("text", "start", "stop", "line", "caret"),
    [
        ("r_arm rihgt", 6, 11, "r_arm rihgt", "      ^^^^^"),
        ("歩く rihgt", 3, 8, "歩く rihgt", "     ^^^^^"),
        ("r_arm\t\x1bhigh", 7, 11, "r_arm\\x09\\x1bhigh", "             ^^^^"),
        ("r_arm high\nwith 歩く", 16, 18, "with 歩く", "     ^^^^"),
        ("r_arm", 5, 5, "r_arm", "     ^"),
    ],
)
def test_the_caret_stands_below_the_word(
    text: str, start: int, stop: int, line: str, caret: str, capsys: pytest.CaptureFixture[str]
) -> None:
    error = PatternError("No.", text=text, start=start, stop=stop)
    say_error(error)
    assert capsys.readouterr().err == f"{line}\n{caret}\nNo.\n"
    try:
        raise UsageError(f"the pattern is not understood\n{error}", place="p\x1b.toml") from error
    except UsageError as outer:
        say_error(outer)
    said = "lanindex: p\\x1b.toml: the pattern is not understood"
    assert capsys.readouterr().err == f"{said}\n{line}\n{caret}\nNo.\n"


class TestWidth:
    @pytest.mark.parametrize(
        ("words", "wide"),
        [
            (["list"], 54),
            (["list"], 90),
            (["list"], 200),
            (["remove", "1", "2", "--dry-run"], 40),
            (["show", "2"], 72),
        ],
    )
    def test_lines_fit(self, place: Path, words: list[str], wide: int) -> None:
        head, *lines = screen(shown(*words, cwd=place, columns=wide)).splitlines()
        assert lines
        for line in lines:
            assert output.width(line) <= wide, (head, line)

    def test_hits_hang_below_their_symbols(self, place: Path) -> None:
        pattern = "r_arm any -> any"
        lines = screen(shown("search", pattern, cwd=place, columns=64)).splitlines()
        begin = next(line.index("r_arm") for line in lines if " fit " in line)
        hanging = [line for line in lines if line.startswith(" " * begin)]
        assert hanging
        assert max(output.width(line) for line in lines if " fit " in line) <= 64

    def test_long_paths_are_cut_in_the_middle(self, place: Path) -> None:
        seen = screen(shown("list", cwd=place, columns=80))
        assert seen.startswith("a/\nid ")
        assert re.search(r"longlong\w*…\w*/bow\.bvh", seen)
        assert re.search(r"(歩く)+歩?…く?(歩く)+\.bvh", seen)

    def test_what_all_paths_begin_with_is_said_once(self, tmp_path: Path) -> None:
        for name in ("a/one/raise.bvh", "a/two/raise.bvh"):
            dance(tmp_path / name)
        called(tmp_path, "ingest", "a")
        lines = screen(shown("search", "r_arm high", cwd=tmp_path)).splitlines()
        assert [lines[0], lines[1], lines[4]] == ["a/", "one/raise.bvh", "two/raise.bvh"]
        lines = screen(shown("search", "r_arm high", "--in", "*one*", cwd=tmp_path)).splitlines()
        assert lines[0] == "a/one/raise.bvh"
        done = called(tmp_path, "search", "r_arm high")
        assert done.stdout.startswith("a/one/raise.bvh\t")
        assert called(tmp_path, "search", "r_arm high", "--preview", "a.svg").returncode == 0
        sheet = (tmp_path / "a.svg").read_text()
        assert "r_arm high \u00b7 a/</text>" in sheet
        assert ">two/raise.bvh</text>" in sheet

    def test_wide_and_combining_characters_count_as_cells(self) -> None:
        assert [output.width(it) for it in ("walk", "歩く", "e\u0301")] == [4, 4, 1]
        assert output.cut("archive/1998/walk.bvh", 13) == "archiv…lk.bvh"
        assert output.wrapped(["r_arm high", "mid", "low"], 16) == ["r_arm high, mid,", "low"]

    def test_cut_leaves_no_half_character(self) -> None:
        for text in ("歩く" * 9, "e\u0301" * 30, "walk" * 9, "歩e\u0301" * 12):
            for most in range(3, 30):
                got = output.cut(text, most)
                assert output.width(got) <= most
                assert output.width(got) >= most - 2
                assert "…\u0301" not in got
        assert output.cut("walk", 4) == "walk"


def test_lists_are_short(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A doubt is said once, above all that it is about; of many labels the most frequent stand."""
    rows = ["file,label"]
    for number, label in enumerate(("bow", "greet", "bow")):
        path = dance(tmp_path / f"{number}.bvh", BOW)
        path.write_text(path.read_text().replace("Frames: ", "Frames: 9"))
        rows.append(f"{path.name},{label}")
    (tmp_path / "labels.csv").write_text("\n".join(rows))
    called(tmp_path, "ingest", ".", "--labels", "labels.csv")
    lines = shown("list", "--doubts", cwd=tmp_path).splitlines()
    assert lines[0].startswith("Frames: says 9")
    assert lines[1:4] == ["  0.bvh", "  1.bvh", "  2.bvh"]
    monkeypatch.setattr("lanindex.app.commands.overview.LABELS_ON_TERMINAL", 1)
    told = shown("stats", cwd=tmp_path)
    assert "label bow" in told
    assert "label greet" not in told
    assert "the 1 most frequent of 2 labels; --json has all" in told
    monkeypatch.setattr("lanindex.app.commands.library.CAPTURES_ON_TERMINAL", 2)
    told = shown("list", cwd=tmp_path)
    assert ["0.bvh" in told, "1.bvh" in told, "2.bvh" in told] == [True, True, False]
    assert "; the first 2 are shown, a pipe or --json has all" in told
    assert len(called(tmp_path, "list", "--json").stdout.splitlines()) == 3


class TestProgress:
    def test_it_is_shown_and_gone_in_the_end(self, place: Path) -> None:
        at_once = "from lanindex.app import cli, output; output.PATIENCE = -1; cli.main()"
        text = start_on_terminal([sys.executable, "-c", at_once, "ingest", "a", "--force"], place)
        assert re.search(r"[1-4]/4 files", text)
        assert "?25h" in text[text.rindex("?25l") :]  # the cursor is there again
        lines = screen(text).splitlines()
        assert lines[0].startswith("lanindex: a/bad\\x1b[2J.bvh")
        assert lines[1].startswith("4 files: ")
        assert not any("/4" in line for line in lines)

    @pytest.mark.parametrize("words", [["-q"], ["--json"]])
    def test_records_stand_on_lines_of_their_own(self, place: Path, words: list[str]) -> None:
        seen = screen(shown("ingest", "a", "--force", *words, cwd=place))
        assert "/4" not in seen
        assert seen.count('"status"') == (4 if words == ["--json"] else 0)

    def test_no_bar_where_nobody_can_see_it(self, place: Path) -> None:
        assert "\x1b" not in called(place, "ingest", "a", "--force").stderr
        assert "/4" not in shown("ingest", "a", "--force", cwd=place, TERM="dumb")

    def test_a_job_that_breaks_off_leaves_no_bar(self, monkeypatch: pytest.MonkeyPatch) -> None:
        class Bar:
            shown = True

            def stop(self) -> None:
                self.shown = False

            def start(self) -> None:
                self.shown = True

        bar = Bar()
        monkeypatch.setattr(output, "_job", output._Job("files", 1, 4, bar=bar))
        output.end_progress()
        say_error("broken off")
        assert not bar.shown
