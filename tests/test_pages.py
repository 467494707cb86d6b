"""The sessions and the Python on the pages run as shown."""

import json
import os
import re
import shlex
import shutil
import sys
from functools import partial
from pathlib import Path

import command
import pytest
from command import screen, shown, start_on_terminal
from conftest import REPOSITORY

from lanindex.app.cli import VERBS, Verbs

README = REPOSITORY / "README.md"
GUIDE = REPOSITORY / "lanindex" / "guide"
PAGES = [README, *sorted(GUIDE.glob("*.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((?!https?:)([^)#]+)(?:#[^)]*)?\)")
SHELL = re.compile(r"[^\w\s/.,:+=-]")
STARTS_EMPTY = {"README", "first-steps"}


def blocks(language: str, page: Path) -> list[str]:
    return [match[2] for match in BLOCK.finditer(page.read_text()) if match[1] == language]


def new_folder(folder: Path) -> Path:
    """Return a folder with the corpus and the command, as a reader of the pages has them."""
    shutil.copytree(REPOSITORY / "corpus", folder / "corpus")
    command = folder / "bin" / "lanindex"
    command.parent.mkdir()
    guarded = "from lanindex.app.cli import main\nif __name__ == '__main__':\n    main()\n"
    command.write_text(f"#!{sys.executable}\n{guarded}")
    command.chmod(0o755)
    return folder


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return new_folder(tmp_path_factory.mktemp("pages"))


def typed(command: str, place: Path) -> str:
    """Return what a terminal shows, output and notes together; a shell runs what needs one."""
    if command.startswith("lanindex ") and not SHELL.search(re.sub('"[^"]*"', "", command)):
        return screen(shown(*shlex.split(command)[1:], cwd=place))
    return screen(start_on_terminal(command, place, PATH=f"{place / 'bin'}:{os.environ['PATH']}"))


def settled(text: str) -> str:
    """Return text without what differs from run to run."""
    return re.sub(r"in \d+\.\d s", "in 1.0 s", text)


@pytest.fixture(scope="module")
def ingested(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder as the first steps leave it, to be copied."""
    place = new_folder(tmp_path_factory.mktemp("ingested"))
    typed("lanindex ingest corpus --labels corpus/labels.csv", place)
    return place


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_sessions_are_real(page: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    if page.stem in STARTS_EMPTY:
        place = new_folder(tmp_path)
    else:
        made = request.getfixturevalue("ingested")
        place = shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    if page.stem == "lnd":
        (place / "raise.lnd").write_text(blocks("text", page)[0])

    def replay(match: re.Match[str]) -> str:
        if match[1] == "sh" and ".venv" not in match[2]:
            for command in match[2].splitlines():
                typed(f"({command}) || touch failed", place)
                assert not (place / "failed").exists(), command
        if match[1] != "console":
            return match[0]
        commands = re.findall(r"^\$ (.*)$", match[2], re.MULTILINE)
        shown = "".join(f"$ {command}\n{typed(command, place)}" for command in commands)
        return f"```console\n{shown}```"

    text = page.read_text()
    replayed = BLOCK.sub(replay, text)
    if request.config.getoption("--bless"):
        page.write_text(replayed)
    else:
        assert settled(replayed) == settled(text)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_python_runs(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(new_folder(tmp_path))
    for code in blocks("python", page):
        exec(code, {"__name__": "__main__"})
        assert "torso" in capsys.readouterr().out


@pytest.mark.parametrize("page", [*PAGES, GUIDE.parent / "ARCHITECTURE.md"], ids=lambda p: p.stem)
def test_links_lead_somewhere(page: Path) -> None:
    assert [
        link for link in LINK.findall(page.read_text()) if not (page.parent / link).exists()
    ] == []


def test_the_guide_links_to_what_is_installed() -> None:
    from lanindex.app.commands.learn import TOPICS

    pages = [GUIDE.parent / page for page, _ in TOPICS.values()]
    there = {
        (page.parent / it).resolve() for page in pages for it in LINK.findall(page.read_text())
    }
    assert {it.relative_to(REPOSITORY).parts[0] for it in there} == {"lanindex", "corpus"}


@pytest.mark.parametrize("page", [README, GUIDE / "asking.md"], ids=lambda page: page.stem)
def test_examples_of_the_language_are_understood(page: Path) -> None:
    from lanindex.search.language import parse

    (block,) = blocks("text", page)
    for line in block.splitlines():
        pattern = re.split(r" {3,}", line)[0]
        assert parse(pattern)


def test_the_test_command_is_what_ci_runs() -> None:
    (line,) = [block for block in blocks("sh", README) if "[dev]" in block]
    assert line.startswith("python3 -m venv .venv && ")
    assert line.rstrip().endswith("pytest -n auto")


def test_the_readme_is_short() -> None:
    assert len(README.read_text().splitlines()) <= 250


def test_the_guide_has_a_topic_for_each_page() -> None:
    from lanindex.app.commands.learn import TOPICS

    pages = {GUIDE.parent / page for page, _ in TOPICS.values()}
    assert all(page.is_file() for page in pages)
    assert set(GUIDE.glob("*.md")) < pages


def test_the_architecture_names_every_folder() -> None:
    package = REPOSITORY / "lanindex"
    rows = re.findall(r"^\| (`[^|]*)\|", (package / "ARCHITECTURE.md").read_text(), re.MULTILINE)
    named = {name for row in rows for name in re.findall(r"`(\w+)(?:/|\.py)`", row)}
    there = {path.parent.name for path in package.glob("*/__init__.py")}
    there |= {path.stem for path in package.glob("*.py") if not path.stem.startswith("_")}
    assert named == there


ROWS: dict[str, set[str]] = {}
for verbs, keys in re.findall(
    r"^\| (`.*`) \| [^|]* \| `(\w+ [\w ]+)` \|$", (GUIDE / "json.md").read_text(), re.MULTILINE
):
    for verb in re.findall("`(.*?)`", verbs):
        ROWS.setdefault(verb, set()).add(keys)
ARGUMENTS = {
    "search": "'r_arm high'",
    "search --count": "'r_arm high'",
    "search … count by …": "'r_arm high | count by clip.label'",
    "search --explain": "'r_arm high'",
    "search --why 1": "'r_arm high'",
    "export": "'r_arm high' --in *greetings.bvh -o records",
    "export --dataset DIR": "'r_arm high' --in *greetings.bvh",
    "export --preview gif": "'torso forward high -> hold 1s+' -o previews",
    "motifs": "--min-count 2 --length 2",
    "show": "1",
    "diff": "corpus/conductor_three.lnd corpus/conductor_four.lnd",
    "remove": "1 --dry-run",
    "ingest": "corpus/greetings.bvh --force",
    "inspect": "corpus/greetings.bvh",
    "evaluate": "corpus --labels corpus/labels.csv --patterns records.toml",
}


@pytest.mark.parametrize("verb", ROWS)
def test_records_are_as_the_table_says(place: Path, verb: str) -> None:
    run = partial(command.run, cwd=place, env={"LANINDEX_DB": str(place / "records.db")})
    pattern = 'up = {pattern = "r_arm high", positives = ["semaphore"]}'
    (place / "records.toml").write_text(pattern)
    if not (place / "records.db").exists():
        assert run("ingest", "corpus/greetings.bvh").returncode == 0
    words = [*verb.partition(" …")[0].split(), "--json", *shlex.split(ARGUMENTS.get(verb, ""))]
    done = run(*words)
    assert done.returncode == (verb == "diff"), done.stderr
    kinds = {" ".join(json.loads(line)) for line in done.stdout.splitlines()}
    assert kinds == ROWS[verb]


def test_every_verb_with_records_is_in_the_table() -> None:
    verbs = {verb: Verbs().get_command(None, verb) for verb in VERBS}
    told = {
        verb
        for verb, command in verbs.items()
        for below in getattr(command, "commands", {"": command}).values()
        if any("--json" in option.opts for option in below.params)
    }
    assert told == {verb.split()[0] for verb in ROWS}


def test_the_guide_is_printed(place: Path) -> None:
    assert "asking" in typed("lanindex guide", place)
    assert typed("lanindex guide asking", place).startswith("# Asking")
    assert 'no topic "askng"' in (shown := typed("lanindex guide askng", place))
    assert "Did you mean asking?" in shown
