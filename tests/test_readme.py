"""The README does what it shows: its sessions are typed on a terminal, its Python is run."""

import os
import pty
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import REPOSITORY

README = REPOSITORY / "README.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(language: str) -> list[str]:
    return [match[2] for match in BLOCK.finditer(README.read_text()) if match[1] == language]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("readme")
    shutil.copytree(REPOSITORY / "corpus", folder / "corpus")
    command = folder / "bin" / "lanindex"
    command.parent.mkdir()
    guarded = "from lanindex.app.cli import main\nif __name__ == '__main__':\n    main()\n"
    command.write_text(f"#!{sys.executable}\n{guarded}")
    command.chmod(0o755)
    return folder


def typed(command: str, place: Path) -> str:
    """Return what a terminal shows, output and notes together."""
    ours, theirs = pty.openpty()
    path = f"{place / 'bin'}:{os.environ['PATH']}"
    process = subprocess.Popen(
        command,
        shell=True,
        cwd=place,
        stdin=subprocess.DEVNULL,
        stdout=theirs,
        stderr=theirs,
        env={**os.environ, "PATH": path, "NO_COLOR": "1", "COLUMNS": "200"},
    )
    os.close(theirs)
    seen = b""
    while True:
        try:
            chunk = os.read(ours, 65536)
        except OSError:  # the other end is closed
            break
        if not chunk:
            break
        seen += chunk
    os.close(ours)
    process.wait()
    shown = re.sub(r"(?m)^.*\r(?!\n)", "", seen.decode().replace("\r\n", "\n"))
    return shown.replace("\x1b[K", "")


def settled(text: str) -> str:
    """Return text without what differs from run to run."""
    return re.sub(r"in \d+\.\d s", "in 1.0 s", text)


def test_sessions_are_real(place: Path, request: pytest.FixtureRequest) -> None:
    def replay(match: re.Match[str]) -> str:
        if match[1] != "console":
            return match[0]
        commands = re.findall(r"^\$ (.*)$", match[2], re.MULTILINE)
        shown = "".join(f"$ {command}\n{typed(command, place)}" for command in commands)
        return f"```console\n{shown}```"

    text = README.read_text()
    replayed = BLOCK.sub(replay, text)
    if request.config.getoption("--bless"):
        README.write_text(replayed)
    else:
        assert settled(replayed) == settled(text)


def test_shell_lines_work(place: Path) -> None:
    (line,) = [block for block in blocks("sh") if "export -" in block]
    assert "manifest" not in os.listdir(place)
    assert "clip" in typed(line, place)
    assert (place / "contrasts" / "manifest.csv").is_file()


@pytest.mark.parametrize("number", range(len(blocks("python"))))
def test_python_runs(place: Path, number: int) -> None:
    code = blocks("python")[number]
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], cwd=place, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "torso" in done.stdout


def test_examples_of_the_language_are_understood() -> None:
    from lanindex.search.language import parse

    (block,) = blocks("text")
    for line in block.splitlines():
        pattern = re.split(r" {3,}", line)[0]
        assert parse(pattern)


def test_the_test_command_is_what_ci_runs() -> None:
    (line,) = [block for block in blocks("sh") if "[dev]" in block]
    assert line.startswith("python3 -m venv .venv && ")
    assert line.rstrip().endswith("pytest -n auto")


def test_rooms_are_those_of_the_house() -> None:
    rooms = README.read_text().partition("| `lanindex/app/`")[2].partition("\n\n")[0]
    named = set(re.findall(r"`(?:lanindex/)?(\w+)(?:/|\.py)`", rooms)) - {"profiles", "migrations"}
    package = REPOSITORY / "lanindex"
    there = {path.parent.name for path in package.glob("*/__init__.py")}
    there |= {path.stem for path in package.glob("*.py") if not path.stem.startswith("_")}
    assert {"app", *named} == there
