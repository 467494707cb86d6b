"""Let workers and the scheduler of a cluster die, end or stand still while a verb has them work.

The verb prints and writes the same bytes as without a cluster, or ends with 2 and a sentence. The
library is whole, and the same command ends well on a cluster that is.
"""

from __future__ import annotations

import asyncio
import ctypes
import os
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Coroutine
from contextlib import chdir, suppress
from pathlib import Path
from random import Random
from typing import Any

import common
import kills
from common import called, errors_of
from distributed import Scheduler, Worker
from kills import LIBRARY, Scene, Verb

from lanindex.pipeline import cluster, shards

OWN = ("--db", LIBRARY)
JOBS: dict[str, tuple[str | int, ...]] = {
    "search": ("search", "arm any -> any", "--json", *OWN),
    "fuzzy": ("search", "r_arm low -> mid", "--fuzzy", 1, "--limit", 9, "--json", *OWN),
    "count": ("search", "arm any | count by clip.label", *OWN),
    "export": ("export", "arm any -> any", "-o", "clips", *OWN),
    "motifs": ("motifs", "--min-count", 2, "--length", 2, *OWN),
    "similar": ("similar", "--alike", 0.1, "--json", *OWN),
    "stats": ("stats", "--by", "label", "--json", *OWN),
    "evaluate": ("evaluate", "in", "--labels", "labels.csv", "--patterns", "patterns.toml"),
}
PATTERN = 'low = {pattern = "r_arm low", positives = ["w*"]}\n'
SAYS = ("scheduler", "worker")

READY = Path()
"""A folder with captures, a library, labels and patterns."""

_PDEATHSIG = 1


class Processes:
    """A scheduler and two workers, which need a while for each task and end with this process."""

    def __init__(self) -> None:
        self.folder, self.address = tempfile.mkdtemp(prefix="workers-"), "tcp://127.0.0.1:0"
        self.scheduler, self.workers = 0, list[int]()

    def begin(self) -> None:
        """Start what has ended; all of them, if the scheduler has."""
        if not runs(self.scheduler):
            for one in self.workers:
                kill(one)
            reader, writer = os.pipe()
            self.scheduler = _begun(_schedule(int(self.address.rpartition(":")[2]), writer))
            os.close(writer)
            with open(reader) as said:
                self.address = said.read()
        self.workers = [*filter(runs, self.workers)]
        while len(self.workers) < 2:
            self.work()

    def work(self) -> None:
        """Start a worker."""
        self.workers.append(_begun(_work(self.address, self.folder)))

    def end(self) -> None:
        """Kill all of them."""
        for one in (*self.workers, self.scheduler):
            kill(one)
        shutil.rmtree(self.folder)


THEM: list[Processes] = []
"""Those of this process of the campaign."""


def _begun(serve: Coroutine[Any, Any, None]) -> int:
    sys.stdout.flush()
    child = os.fork()
    if not child:
        ctypes.CDLL(None).prctl(_PDEATHSIG, signal.SIGKILL)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # they say that others are gone
        with suppress(BaseException):
            asyncio.run(serve)
        os._exit(0)
    serve.close()
    return child


async def _schedule(port: int, writer: int) -> None:
    async with Scheduler(host="127.0.0.1", port=port, dashboard=False) as scheduler:
        ended = asyncio.Event()
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, ended.set)
        os.write(writer, scheduler.address.encode())
        os.close(writer)
        await ended.wait()


async def _work(address: str, folder: str) -> None:
    call, choice = cluster._Call.__call__, Random(os.getpid())

    def slowly(self: Any) -> Any:
        time.sleep(choice.random() * 0.1)
        return call(self)

    os.chdir(folder)  # that of the trial goes
    setattr(cluster._Call, "__call__", slowly)  # noqa: B010 (mypy)
    async with Worker(address, nthreads=1, local_directory=folder) as worker:
        await worker.finished()


def runs(process: int) -> bool:
    with suppress(ChildProcessError):  # somebody has waited for it
        return bool(process) and os.waitpid(process, os.WNOHANG) == (0, 0)
    return False


def kill(process: int, how: int = signal.SIGKILL) -> None:
    if runs(process):
        os.kill(process, how)
        os.waitpid(process, 0)


def a_worker_dies(them: Processes, choice: Random) -> None:
    kill(choice.choice(them.workers))


def workers_die(them: Processes, choice: Random) -> None:
    """Kill both workers; mostly another one comes."""
    for one in them.workers:
        kill(one)
    if choice.random() < 0.6:
        time.sleep(choice.random())
        them.work()


def scheduler_dies(them: Processes, choice: Random) -> None:
    """Kill the scheduler; at times another one comes in its place, with workers."""
    kill(them.scheduler)
    if choice.random() < 0.5:
        time.sleep(choice.random())
        them.begin()


def scheduler_ends(them: Processes, choice: Random) -> None:
    kill(them.scheduler, signal.SIGTERM)


def one_stands_still(them: Processes, choice: Random) -> None:
    """Stop one of them for a while."""
    one = choice.choice((them.scheduler, *them.workers))
    os.kill(one, signal.SIGSTOP)
    time.sleep(choice.choice((0.2, 1, 5)))
    os.kill(one, signal.SIGCONT)


WAYS: tuple[Callable[[Processes, Random], None], ...] = (
    *(a_worker_dies, workers_die, scheduler_dies, scheduler_ends, one_stands_still),
)


def a_verb(choice: Random, folder: Path, address: str) -> tuple[str, Verb, dict[str, bytes]]:
    """Return a verb with its name, and what it prints and writes."""
    name = choice.choice((*["ingest"] * 3, *JOBS))
    if name == "ingest":
        scene = Scene(choice, folder)
        if choice.random() < 0.7:
            scene.fill()
        for _ in range(choice.randint(1, 8)):
            scene.put()
        return name, scene.ingest("--cluster", address), {}
    shutil.copytree(READY, folder, dirs_exist_ok=True)
    code, told = called(*JOBS[name]), told_and_written()
    shutil.rmtree("clips", ignore_errors=True)
    words = (*JOBS[name], "--cluster", address)
    return name, Verb(lambda lines: called(*words), [[kills.content(LIBRARY)]], (code,)), told


def told_and_written() -> dict[str, bytes]:
    """Return what a verb has printed, and the clips that it has written."""
    return {str(it): it.read_bytes() for it in (Path("stdout"), *sorted(Path().glob("clips/*")))}


def trial(choice: Random, folder: Path) -> dict[str, int]:
    """Break a cluster in the middle of a verb."""
    if not THEM:
        THEM.append(Processes())
    (them,) = THEM
    them.begin()
    name, verb, told = a_verb(choice, folder, them.address)
    wrong_before = kills.look()[1]
    way, after = choice.choice(WAYS), choice.random() * choice.choice((0.5, 1.5))
    in_time = False

    def work() -> int:
        os.dup2(os.open("logged", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
        with open(os.devnull, "w") as lines:
            code = verb.work(lines=lines.fileno())
        Path("ended").touch()
        return code

    def meanwhile() -> None:
        nonlocal in_time
        time.sleep(after)
        in_time = not Path("ended").exists()
        way(them, choice)

    code = common.forked(work, meanwhile)
    held, wrong = kills.look()
    said, logged = errors_of(), Path("logged").read_text()
    about = name, way.__name__, after, code, said, logged
    assert not logged, about
    assert {*wrong} <= {*wrong_before}, (about, wrong)
    assert held in verb.states, (about, held, verb.states)
    if code == 2:
        lines = [it for it in said.splitlines() if it.startswith("lanindex: ")]
        assert len(lines) == 1, about
        assert any(word in lines[0] for word in SAYS), about
        assert not Path("clips").exists(), about
    else:
        assert code in verb.ends, about
        assert not told or told_and_written() == told, about
        assert held == verb.states[-1], about
        shutil.rmtree("clips", ignore_errors=True)
    them.begin()
    assert common.forked(work) in verb.ends, (about, errors_of())
    assert not told or told_and_written() == told, about
    assert kills.look() == (verb.states[-1], []), about
    outcome = "done" if code != 2 else "refused"
    return {way.__name__.replace("_", " "): 1, outcome: 1, "in time": in_time}


def end() -> None:
    for them in THEM:
        them.end()


def main() -> int:
    """Prepare what is compared with, and run the trials."""
    global READY
    options = common.arguments(__doc__.split("\n")[0], 150).parse_args()
    cluster.PATIENCE, shards.FEWEST, common.LONGEST = 2, 1, 60
    with tempfile.TemporaryDirectory() as name, tempfile.TemporaryDirectory() as other:
        with chdir(name):
            kills.prepare(Path(name))
        READY = Path(other)
        with chdir(READY):
            scene = Scene(Random(1), READY)
            for _ in range(2):
                for _ in range(7):  # less than what other processes are started for
                    scene.put()
                rows = [f"in/{file},{'wb'[number % 2]}\n" for file, number in scene.files.items()]
                Path("labels.csv").write_text("file,label\n" + "".join(rows))
                assert called("ingest", "in", "--labels", "labels.csv", *OWN) == 0, errors_of()
            Path("patterns.toml").write_text(PATTERN)
        return common.run(trial, options, end)


if __name__ == "__main__":
    sys.exit(main())
