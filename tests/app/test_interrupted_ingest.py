"""An ingest that is interrupted or not alone stores whole captures; the next run finishes."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from dances import BOW, RAISE, dance

from lanindex.library import migrate
from lanindex.pipeline.library import open_library

COUNT = 24
MAIN = "from lanindex.app.cli import main\nif __name__ == '__main__': main()\n"


@pytest.fixture
def place(tmp_path: Path) -> Path:
    folder = tmp_path / "in"
    contents = [
        dance(folder / f"{name}.bvh", text, rate=60).read_bytes()
        for name, text in (("raise", RAISE), ("bow", BOW))
    ]
    for number in range(COUNT - 2):
        (folder / f"{number:02}.bvh").write_bytes(contents[number % 2])
    (tmp_path / "command.py").write_text(MAIN)
    return tmp_path


def start(place: Path, *words: str) -> subprocess.Popen[str]:
    return started(place, "ingest", "in", "--json", *words)


def started(place: Path, *words: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "command.py", *words],
        cwd=place,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        start_new_session=True,
    )


def held(place: Path) -> int:
    assert migrate.check(place / "lanindex.db") == []
    with open_library(place / "lanindex.db", readonly=True) as library:
        captures = library.captures()
        for capture in captures:
            assert len(library.score(capture.id).tracks) >= 16
        return len(captures)


# Both of whatever they differ in are tried by default, all that may meet with `--slow`
@pytest.mark.parametrize(
    ("signalled", "after", "jobs"),
    [
        (signal.SIGINT, 7, "2"),
        (signal.SIGKILL, 1, "1"),
        pytest.param(signal.SIGINT, 1, "1", marks=pytest.mark.slow),
        pytest.param(signal.SIGKILL, 1, "2", marks=pytest.mark.slow),
        pytest.param(signal.SIGKILL, 7, "1", marks=pytest.mark.slow),
        pytest.param(signal.SIGINT, 1, "2", marks=pytest.mark.slow),
        pytest.param(signal.SIGINT, 7, "1", marks=pytest.mark.slow),
        pytest.param(signal.SIGKILL, 7, "2", marks=pytest.mark.slow),
    ],
    ids=lambda it: getattr(it, "name", it),
)
def test_broken_off(place: Path, signalled: signal.Signals, after: int, jobs: str) -> None:
    process = start(place, "--jobs", jobs)
    assert process.stdout
    for _ in range(after):
        assert '"added"' in process.stdout.readline()
    if signalled is signal.SIGINT:
        os.killpg(process.pid, signalled)  # as a terminal does: to all of them
    else:
        process.kill()
    _, errors = process.communicate(timeout=60)
    if signalled is signal.SIGINT:
        assert process.returncode == 130, errors
        assert errors == "lanindex: interrupted; what was finished is kept\n"
    assert after <= held(place) < COUNT
    again = start(place, "--jobs", jobs)
    output, errors = again.communicate(timeout=120)
    assert again.returncode == 0, errors
    assert output.count('"unchanged"') >= after
    assert held(place) == COUNT


def test_an_interrupted_export_kept_nothing(place: Path) -> None:
    open_library(place / "lanindex.db", create=True).close()
    process = started(place, "export", "-")
    assert process.stdin
    process.stdin.write("\n" * 500_000)  # more than a pipe holds: it has begun to read
    process.stdin.flush()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (130, "lanindex: interrupted\n")


def test_a_demo_that_is_ended_leaves_no_folder(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (place / "temporary").mkdir()
    monkeypatch.setenv("TMPDIR", str(place / "temporary"))
    process = started(place, "demo")
    assert process.stdout
    assert process.stdout.readline().startswith("Read ")
    process.terminate()
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (130, "lanindex: interrupted\n")
    assert not [*(place / "temporary").iterdir()]


def test_two_at_once(place: Path) -> None:
    both = [start(place, "--jobs", "1") for _ in range(2)]
    for process in both:
        _, errors = process.communicate(timeout=120)
        assert process.returncode == 0, errors
    assert held(place) == COUNT
