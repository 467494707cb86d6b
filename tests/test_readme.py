"""The README does what it shows: its sessions are typed on a terminal, its Python is run."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from command import screen, start_on_terminal
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
    return screen(start_on_terminal(command, place, PATH=f"{place / 'bin'}:{os.environ['PATH']}"))


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
    typed("lanindex ingest corpus", place)  # the sessions may be typed in another process
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


ROWS: dict[str, set[str]] = {}
for verbs, keys in re.findall(
    r"^\| (`.*`) \| [^|]* \| `(\w+ [\w ]+)` \|$", README.read_text(), re.MULTILINE
):
    for verb in re.findall("`(.*?)`", verbs):
        ROWS.setdefault(verb, set()).add(keys)
ARGUMENTS = {
    "search": "'r_arm high'",
    "search --count": "'r_arm high'",
    "search … count by …": "'r_arm high | count by clip.label'",
    "search --why 1": "'r_arm high'",
    "export": "'r_arm high' --in *greetings.bvh -o records",
    "export --dataset DIR": "'r_arm high' --in *greetings.bvh",
    "export --preview gif": "'torso forward high -> hold 1s+' -o previews",
    "motifs": "--min-count 2 --length 2",
    "show": "1",
    "diff": "corpus/conductor_three.lnd corpus/conductor_four.lnd || test $? = 1",
    "remove": "1 --dry-run",
    "ingest": "corpus/greetings.bvh --force",
    "inspect": "corpus/greetings.bvh",
    "evaluate": "corpus --labels corpus/labels.csv --patterns records.toml",
}


@pytest.mark.parametrize("verb", ROWS)
def test_records_are_as_the_table_says(place: Path, verb: str) -> None:
    env = {**os.environ, "LANINDEX_DB": str(place / "records.db")}
    pattern = 'up = {pattern = "r_arm high", positives = ["semaphore"]}'
    (place / "records.toml").write_text(pattern)
    command = [str(place / "bin" / "lanindex"), *verb.partition(" …")[0].split(), "--json"]
    if not (place / "records.db").exists():
        ingest = [command[0], "ingest", "corpus/greetings.bvh"]
        subprocess.run(ingest, cwd=place, env=env, check=True)
    words = f"{shlex.join(command)} {ARGUMENTS.get(verb, '')}"
    done = subprocess.run(words, cwd=place, env=env, shell=True, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    kinds = {" ".join(json.loads(line)) for line in done.stdout.splitlines()}
    assert kinds == ROWS[verb]


def test_every_verb_with_records_is_in_the_table() -> None:
    commands = (REPOSITORY / "lanindex" / "app" / "commands").glob("*.py")
    told = {path.stem for path in commands if "out.record(" in path.read_text()}
    assert told == {verb.split()[0] for verb in ROWS}
