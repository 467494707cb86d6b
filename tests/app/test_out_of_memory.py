"""Errors of memory name the capture and the remedy."""

import subprocess
import sys
from pathlib import Path

import pytest
from bvh_bodies import person
from sample_library import sample_score
from typer.testing import CliRunner

from lanindex import errors
from lanindex.app.cli import app
from lanindex.pipeline import prepare
from lanindex.pipeline.library import Library, open_library
from lanindex.search.match.finder import Finder

LIMITED = """
import resource, sys
import numpy, lanindex
from lanindex.app import cli
import lanindex.app.commands.search, lanindex.search.match.finder, lanindex.pipeline.search
held = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (held + {spare}, resource.RLIM_INFINITY))
{job}
"""
PATTERN = "r_arm any with a: l_arm any ... b: any where b.end - a.start > 0.1s"


@pytest.fixture
def rich(tmp_path: Path) -> Path:
    """Return a library of a capture that fits in many ways, between two that do not."""
    with open_library(tmp_path / "l.db", create=True) as library:
        for name, length in (("a.lnd", 6), ("long.lnd", 2_400), ("z.lnd", 6)):
            score = sample_score(0, ("r_arm", "l_arm"), length)
            library.store.add(name, score, format="lnd", sha256=name)
    return tmp_path / "l.db"


@pytest.mark.skipif(sys.platform != "linux", reason="the limit is set as Linux counts memory")
@pytest.mark.parametrize("face", ["command", "Python"])
def test_a_search_without_enough_memory_names_the_capture(rich: Path, face: str) -> None:
    jobs = {
        "command": f"sys.argv = ['lanindex', 'search', {PATTERN!r}, '--db', {str(rich)!r}]\n"
        "cli.main()",
        "Python": f"with lanindex.open_library({str(rich)!r}) as library:\n"
        f"    found = library.search({PATTERN!r})\n"
        "    print(*found.counts())\n"
        "    sys.exit(str(*library.refused))",
    }
    code = LIMITED.format(spare=100 << 20, job=jobs[face])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr
    assert "long.lnd: the search ran out of memory in this capture. Bound what" in done.stderr
    assert done.returncode == (2 if face == "command" else 1)
    assert "a.lnd" in done.stdout
    assert "z.lnd" in done.stdout  # the others are answered


def test_fewer_captures_are_tried_before_a_search_gives_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    searched = Finder._in_batch

    def cramped(self, places):
        if len(places) > 1:
            raise MemoryError
        return searched(self, places)

    with open_library(tmp_path / "l.db", create=True) as library:
        for number in range(7):
            score = sample_score(number, ("r_arm", "l_arm"))
            library.store.add(f"{number}.lnd", score, format="lnd", sha256="0")
        wanted = [str(hit) for hit in library.search(PATTERN)]
        monkeypatch.setattr(Finder, "_in_batch", cramped)
        assert [str(hit) for hit in library.search(PATTERN)] == wanted != []


def out_of_memory(*args, **more):
    raise MemoryError


def test_a_file_without_enough_memory_fails_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("a.bvh", "large.bvh", "z.bvh"):
        (tmp_path / name).write_bytes(person())
    read = prepare._encoded
    monkeypatch.setattr(
        prepare,
        "_encoded",
        lambda task, *rest: (out_of_memory if "large" in task.path else read)(task, *rest),
    )
    with open_library(tmp_path / "l.db", create=True) as library:
        outcomes = {Path(one.path).name: one for one in library.ingest(tmp_path)}
    assert [one.status for one in outcomes.values()] == ["added", "failed", "added"]
    assert "large.bvh: not enough memory to read it. " in str(outcomes["large.bvh"].error)


def test_any_verb_says_that_memory_ran_out(rich: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Library, "stats", out_of_memory)
    done = CliRunner().invoke(app, ["stats", "--db", str(rich)])
    assert done.exit_code == 2
    assert "out of memory. Do it in parts" in done.output
    with open_library(rich) as library:
        monkeypatch.setattr(Finder, "find", out_of_memory)
        with pytest.raises(errors.OutOfMemoryError, match=r"l\.db: the search ran out of memory"):
            library.search("r_arm high")
