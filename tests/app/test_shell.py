"""Shell completion, locales, ``python -m``."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from command import run
from dances import dance

from lanindex.app.cli import VERBS

COMMAND = [sys.executable, "-W", "error", "-m", "lanindex"]


def called(
    place: Path, *words: str | bytes, **env: str | None
) -> subprocess.CompletedProcess[bytes]:
    told = {**os.environ, **env}
    return subprocess.run(
        [*COMMAND, *words],
        cwd=place,
        capture_output=True,
        env={key: value for key, value in told.items() if value is not None},
    )


def called_here(
    place: Path, *words: str | bytes, **env: str | None
) -> subprocess.CompletedProcess[bytes]:
    """Call the command in this process, whose locale is that of most terminals."""
    done = run(*map(os.fsdecode, words), cwd=place)
    out, errors = (os.fsencode(text) for text in (done.stdout, done.stderr))
    return subprocess.CompletedProcess(words, done.returncode, out, errors)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a library of one capture, and patterns in files."""
    folder = tmp_path_factory.mktemp("completed")
    dance(folder / "dance.bvh")
    (folder / "kept").mkdir()
    for name in ("raise.lq", "other.txt", "kept/bow.lq"):
        (folder / name).write_text("r_arm high")
    assert called(folder, "ingest", "dance.bvh").returncode == 0
    return folder


class TestCompletion:
    @pytest.mark.parametrize(
        ("typed", "offered"),
        [
            ("lanindex ", set(VERBS)),
            ("lanindex se", {"search"}),
            ("lanindex search --li", {"--limit"}),
            ("lanindex db ", {"status", "upgrade", "check"}),
            ("lanindex nothing", set()),
        ],
    )
    def test_verbs_and_options(self, tmp_path: Path, typed: str, offered: set[str]) -> None:
        at = str(len(typed.split(" ")) - 1)
        asked = {"_LANINDEX_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": at}
        done = called(tmp_path, **asked)
        assert done.stderr == b""
        assert offered <= set(done.stdout.decode().split())
        assert offered or not done.stdout.strip()

    @pytest.mark.parametrize(
        ("typed", "offered"),
        [
            ('search "r_a', {"r_arm", "r_arm_bend"}),
            ('search "', {"r_arm", "arms", "head"}),
            ('search "r_arm ri', {"r_arm right", "r_arm rising"}),
            ('search "r_arm low -> hi', {"r_arm low -> high"}),
            ('export "arms hi', {"arms high"}),
            ("search @ra", {"@raise.lq"}),
            ("search @kept/bo", {"@kept/bow.lq"}),
            ("show da", {"dance.bvh"}),
            ("export --capture da", {"dance.bvh"}),
            ("remove ", {"dance.bvh"}),
            ("search --why da", {"dance.bvh"}),
            ("show --db none.db da", set()),
            ("show --db sqlite : ///lanindex.db da", {"dance.bvh"}),  # as bash takes words apart
            ("show --db postgresql : //me @ /none?host = /none da", set()),
            ("show --db = lanindex.db da", {"dance.bvh"}),
            ('search "let up = arm hi', {"let up = arm high"}),
        ],
    )
    def test_words_and_captures(self, made: Path, typed: str, offered: set[str]) -> None:
        typed = f"lanindex {typed}"
        at = len(typed.partition('"')[0].split(" ")) - 1
        asked = {"_LANINDEX_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": str(at)}
        done = run(cwd=made, env=asked)
        assert done.stderr == ""
        assert set(done.stdout.split("\n")[:40]) >= offered
        assert len(offered) != 1 or done.stdout.strip() == next(iter(offered))
        assert offered or not done.stdout.strip()

    def test_installed_once_and_only_when_asked(self, tmp_path: Path) -> None:
        home = {"HOME": str(tmp_path), "SHELL": "/bin/zsh"}
        code = (
            "import shellingham, sys\n"
            "def detect_shell(): raise shellingham.ShellDetectionFailure\n"
            "shellingham.detect_shell = detect_shell\n"
            "from lanindex.app.cli import main; main()"
        )
        for option, words in (("--show-completion", []), ("--install-completion", [])):
            assert not list(tmp_path.iterdir())
            done = subprocess.run(
                [sys.executable, "-c", code, option, *words],
                capture_output=True,
                text=True,
                env={**os.environ, **home},
            )
            assert done.returncode == 0, done.stderr
        assert "completes lanindex in zsh" in done.stderr
        assert "_LANINDEX_COMPLETE" in (tmp_path / ".zfunc" / "_lanindex").read_text()

    def test_an_unknown_shell(self, tmp_path: Path) -> None:
        code = (
            "import shellingham\n"
            "shellingham.detect_shell = lambda: ('tcsh', '/bin/tcsh')\n"
            "from lanindex.app.cli import main; main()"
        )
        done = subprocess.run(
            [sys.executable, "-c", code, "--show-completion"], capture_output=True, text=True
        )
        assert done.returncode == 2
        assert done.stderr.startswith('lanindex: no shell that is known ("tcsh"), wanted bash or')


ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": None}


class TestLocale:
    def test_an_ascii_locale_reads_names_and_arrows(self, tmp_path: Path) -> None:
        dance(tmp_path / "in" / "歩く é.bvh")
        done = called(tmp_path, "ingest", "in", "--jobs", "2", **ASCII)
        assert (done.returncode, done.stdout) == (0, b""), done.stderr
        arrow = "r_arm right mid → place high".encode()
        done = called(tmp_path, "search", arrow, "--in", "in/歩*".encode(), **ASCII)
        assert done.returncode == 0, done.stderr
        assert done.stdout.decode().startswith("in/歩く é.bvh\t")
        done = called(tmp_path, "inspect", "in/歩く é.bvh".encode(), **ASCII)
        assert done.returncode == 0, done.stderr

    @pytest.mark.parametrize(
        ("call", "env"), [(called_here, {}), pytest.param(called, ASCII, marks=pytest.mark.slow)]
    )
    def test_a_name_that_is_no_utf_8_is_shown_escaped(
        self, tmp_path: Path, call: Callable[..., subprocess.CompletedProcess[bytes]], env: dict
    ) -> None:
        dance(tmp_path / "plain.bvh")
        name = b"w\xff\xe4lk.bvh"
        os.rename(tmp_path / "plain.bvh", os.path.join(os.fsencode(tmp_path), name))
        (tmp_path / "labels.csv").write_text("file,label\nw\\xff\\xe4lk.bvh,walk\n")
        shown = rb"w\xff\xe4lk.bvh"
        for said in (b"1 file: 1 added", b"nothing new: 1 file unchanged"):
            done = call(tmp_path, "ingest", ".", "--labels", "labels.csv", **env)
            assert (done.returncode, said in done.stderr) == (0, True), done.stderr
        listed = call(tmp_path, "list", **env).stdout.split(b"\n")[1].split(b"\t")
        assert listed[1:3] == [b"./" + shown, b"walk"]
        for named in (name, shown):
            assert call(tmp_path, "show", named, **env).returncode == 0
            done = call(tmp_path, "inspect", named, **env)
            assert (done.returncode, shown in done.stdout) == (0, True), done.stderr
        done = call(tmp_path, "export", "r_arm right", "-o", "clips", **env)
        assert done.returncode == 0, done.stderr
        assert sorted(path.suffix for path in (tmp_path / "clips").glob("w_xff_xe4lk_*"))
        assert call(tmp_path, "remove", "--missing", **env).returncode == 1


def test_python_runs_it_by_name(tmp_path: Path) -> None:
    import lanindex

    assert called(tmp_path, "--version").stdout.decode() == f"lanindex {lanindex.__version__}\n"
    asked_nothing = called(tmp_path)
    assert asked_nothing.returncode == 2
    assert asked_nothing.stderr.decode().count("\n") > len(VERBS)
