"""Jobs of Slurm that do the work: by commands that play Slurm, and by Slurm where it runs."""

import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import command
import pytest
from dask import config
from sample_library import fill

from lanindex.errors import UsageError
from lanindex.pipeline.cluster import Cluster, _no_handlers

with _no_handlers():  # pytest has its own of Ctrl-C
    pytest.importorskip("dask_jobqueue", reason="dask-jobqueue submits the jobs")

PLAYED = {
    "sbatch": """
: > {jobs}/$$; cp "$1" {jobs}.$$
setsid sh -c "sh {jobs}.$$; rm -f {jobs}/$$" < /dev/null > {jobs}.$$.out 2>&1 &
echo $! > {jobs}.$$.pid
echo Submitted batch job $$
""",
    "squeue": 'for job in $(ls {jobs}); do echo "$job RUNNING (None)"; done',
    "scancel": "rm -f {jobs}/$1; kill -- -$(cat {jobs}.$1.pid)",
}
"""Slurm as three scripts: a job is a process, and a file while it is in the queue."""

HELD = "id=$(($(ls {jobs} | wc -l) + 1)); : > {jobs}/$id; echo Submitted batch job $id"


class Slurm:
    """Slurm, or what plays it, and the environment in which a command finds it."""

    def __init__(self, folder: Path, **instead: str) -> None:
        self.jobs = folder / "jobs"
        self.jobs.mkdir(parents=True)
        for name, text in (PLAYED | instead).items():
            path = folder / "bin" / name
            path.parent.mkdir(exist_ok=True)
            path.write_text("#!/bin/sh\n" + text.replace("{jobs}", str(self.jobs)))
            path.chmod(0o755)
        own = {"CORES": "1", "MEMORY": "1GB", "INTERFACE": "lo", "LOG_DIRECTORY": str(folder)}
        self.env = {f"DASK_JOBQUEUE__SLURM__{name}": value for name, value in own.items()}
        self.env["PATH"] = f"{folder / 'bin'}:{os.environ['PATH']}"

    def queue(self) -> list[str]:
        return sorted(it.name for it in self.jobs.iterdir())


class Installed(Slurm):
    """Slurm that runs on this machine."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.env["PATH"] = os.environ["PATH"]
        if not shutil.which("sinfo") or "up" not in self._said("sinfo", "--noheader"):
            pytest.skip("no Slurm runs here: Debian's package slurm-wlm")

    def _said(self, *words: str) -> str:
        return subprocess.run(words, capture_output=True, text=True).stdout

    def queue(self) -> list[str]:
        return self._said("squeue", "--me", "--noheader").splitlines()


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Let this process play Slurm as given, configured."""

    def begin(**instead: str) -> Slurm:
        made = Slurm(tmp_path / "slurm", **instead)
        monkeypatch.setenv("PATH", made.env["PATH"])
        return made

    with config.set({"jobqueue.slurm.cores": 1, "jobqueue.slurm.memory": "1GB"}):
        yield begin


@pytest.mark.parametrize("lacking", ["cores", "memory"])
def test_it_is_configured(slurm, lacking: str) -> None:
    with config.set({f"jobqueue.slurm.{lacking}": None}), pytest.raises(UsageError) as raised:
        Cluster("slurm")
    assert str(raised.value) == (
        f"--cluster slurm: dask-jobqueue is not told the {lacking} of a job. "
        "See to jobqueue.slurm in the configuration of Dask: lanindex guide growing"
    )


# what Dask had half made says so when it is let go
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("memory", "lots", "Could not interpret 'lots' as a byte unit"),
        ("interface", "eth99", "'eth99' is not a valid network interface"),
    ],
)
def test_what_dask_jobqueue_refuses(slurm, name: str, value: str, says: str) -> None:
    with config.set({f"jobqueue.slurm.{name}": value}), pytest.raises(UsageError, match=says):
        Cluster("slurm")


def test_there_is_no_slurm(slurm, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(UsageError, match="there is no sbatch here"):
        Cluster("slurm")


def test_slurm_refuses_one_of_two_jobs(slurm) -> None:
    said = "sbatch: error: Batch job submission failed: Job violates accounting policy"
    refusal = f'mkdir {{jobs}}.first || {{ echo "{said}" >&2; exit 1; }}'
    played = slurm(sbatch=f"{refusal}\n{HELD}", scancel="rm {jobs}/$1")
    with pytest.raises(UsageError, match=r"slurm: Batch job submission failed: Job violates"):
        Cluster("slurm:2")
    assert played.queue() == []  # the other was taken back


@pytest.mark.parametrize("begun", ["run()", "it = Thread(target=run); it.start(); it.join()"])
def test_an_interrupt_is_still_ours(begun: str) -> None:
    code = (
        "import signal; before = signal.getsignal(signal.SIGINT)\n"
        "from threading import Thread\n"
        "from lanindex.errors import UsageError\n"
        "from lanindex.pipeline.cluster import _slurm\n"
        "def run():\n"
        "    try: _slurm()\n"
        "    except UsageError: print(signal.getsignal(signal.SIGINT) is before)\n"
    ) + begun
    done = subprocess.run([*command.COMMAND[:1], "-c", code], capture_output=True, text=True)
    assert done.stdout == "True\n", done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("kind", [Slurm, Installed])
def test_jobs_find_the_same(tmp_path: Path, kind: type[Slurm]) -> None:
    slurm = kind(tmp_path / "slurm")
    fill(tmp_path / "l.db", 20)
    words = ["search", "r_arm any -> any", "--db", tmp_path / "l.db", "--json"]
    here, there = (
        command.start(*words, *more, env=slurm.env, cwd=tmp_path)
        for more in ([], ["--cluster", "slurm:2"])
    )
    assert there.stderr == here.stderr
    assert there.stdout == here.stdout != ""
    assert slurm.queue() == []


@pytest.mark.slow
def test_jobs_that_wait_are_told_and_end_with_the_command(tmp_path: Path) -> None:
    waits = 'for job in $(ls {jobs}); do echo "$job PENDING (Priority)"; done'
    slurm = Slurm(tmp_path / "slurm", sbatch=HELD, squeue=waits, scancel="rm {jobs}/$1")
    fill(tmp_path / "l.db", 2)
    words = ["search", "r_arm any", "--db", tmp_path / "l.db", "--cluster", "slurm"]
    own = {**os.environ, **slurm.env}
    begun = subprocess.Popen(
        [*command.COMMAND, *words], env=own, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    )
    assert begun.stderr is not None
    assert begun.stderr.readline() == "slurm: no worker yet; its jobs: 1 PENDING (Priority)\n"
    assert len(slurm.queue()) == 1
    begun.send_signal(signal.SIGINT)
    assert begun.communicate()[1] == "lanindex: interrupted\n"
    assert begun.returncode == 130
    assert slurm.queue() == []


@pytest.mark.slow
def test_jobs_that_end_before_they_work(tmp_path: Path) -> None:
    slurm = Slurm(tmp_path / "slurm")
    fill(tmp_path / "l.db", 2)
    begun, words = time.monotonic(), ["search", "r_arm any", "--db", tmp_path / "l.db"]
    env = {**slurm.env, "DASK_JOBQUEUE__SLURM__PYTHON": "/no/python"}
    done = command.start(*words, "--cluster", "slurm:2", env=env, cwd=tmp_path)
    assert time.monotonic() - begun < 30
    assert done.stderr.startswith(
        "lanindex: slurm:2: no worker has joined it, and its jobs have ended. Their output says"
    )
