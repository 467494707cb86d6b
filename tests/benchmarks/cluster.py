"""What two processes of a local cluster make of searches and of an ingest, against one process.

    python tests/benchmarks/cluster.py [LIBRARY] [FILES]
    python tests/benchmarks/cluster.py pinned [FILES] [KINDS]
    python tests/benchmarks/cluster.py clips [CLIPS]

A library of 20,000 captures is made if none is named, as `synthetic.py` does; 1,000 files are read
if no other number is named. Times are those of the clock, and, where others use the machine, of the
processors: one process against the busiest worker. Starting the cluster does not count; it is told.

``pinned`` is an ingest by up to 8 workers on fewer processors. The files are read and written down
once, and the seconds of the processor that each takes are noted. Then workers wait as long for each
file, and return what was written down; all else is done: cutting the work into batches, giving them
out, transferring what they return, and storing it. The files are copies of so many captures, the
smallest ones; 20 if nobody says. ``clips`` exports 1,000 hits in short and in long captures.
"""

import os
import pickle
import re
import sys
import tempfile
import time
from functools import lru_cache
from pathlib import Path
from statistics import median
from typing import Any

import synthetic
from places import CAPTURES

from lanindex.encoding.profile import load
from lanindex.pipeline import prepare, shards
from lanindex.pipeline.cluster import Cluster
from lanindex.pipeline.library import open_library

ROUNDS = 5
PATTERNS = (
    "r_arm right mid -> r_forward high -> place high",
    "arms low ... high",
    "r_forearm any ... any during l_forearm any ... any",
    "r_arm any x3+ with l_arm any x3+",
)


def timed(call: tuple[Any, Any], tick: Any) -> tuple[Any, int, float]:
    """Do work in a worker; tell which one it is, and the seconds that it took its processor."""
    work, item = call
    begun = time.process_time()
    return work(item, tick), os.getpid(), time.process_time() - begun


class Timed:
    """A cluster that adds up the seconds of each worker."""

    def __init__(self, cluster: Cluster) -> None:
        self.cluster, self.tasks, self.spent = cluster, cluster.tasks, dict[int, float]()

    def results(self, work: Any, items: Any, tick: Any) -> Any:
        self.spent = {}
        calls = ((work, item) for item in items)
        for result, who, seconds in self.cluster.results(timed, calls, tick):
            self.spent[who] = self.spent.get(who, 0) + seconds
            yield result

    def close(self) -> None:
        pass


def searches(path: str, cluster: Timed) -> None:
    """Print how long searches take; what is searched is in memory by then."""
    merges: list[float] = []
    joined = shards.joined

    def told(*them: Any) -> Any:
        begun = time.perf_counter()
        found = joined(*them)
        merges.append(time.perf_counter() - begun)
        return found

    shards.joined = told
    print("   hits      one      two  share |  one CPU  busiest  share | merge")
    with open_library(path, readonly=True) as library:
        for pattern in PATTERNS:
            figures = []
            for spread in (None, cluster):
                vars(library)["spread"] = spread
                library.search(pattern)
                clock, spent = [], []
                for _ in range(ROUNDS):
                    begun, own = time.perf_counter(), time.process_time()
                    hits = len(library.search(pattern))
                    clock.append(time.perf_counter() - begun)
                    own = time.process_time() - own
                    spent.append(own + max(cluster.spent.values()) if spread else own)
                figures += [median(clock), median(spent)]
            one, own, two, busiest = figures
            print(
                f"{hits:7} {one:7.3f}s {two:7.3f}s  {two / one:4.2f}x | {own:7.3f}s {busiest:7.3f}s"
                f"  {busiest / own:4.2f}x | {1e3 * median(merges):3.0f} ms  {pattern}",
                flush=True,
            )
            merges.clear()
    shards.joined = joined


def small_files(folder: Path, count: int, kinds: int = 20) -> list[Path]:
    """Write small captures, all different."""
    real = sorted((CAPTURES / "bvh").rglob("*.bvh"), key=lambda it: it.stat().st_size)[:kinds]
    files = []
    for number in range(count):
        files.append(folder / f"{number:04}.bvh")
        files[-1].write_bytes(real[number % len(real)].read_bytes() + b"\n" * (number // len(real)))
    return files


def ingests(folder: Path, count: int) -> None:
    """Print how long it takes to read files, by one process and by workers."""
    files = small_files(folder, count)
    begun, own = time.perf_counter(), time.process_time()
    with open_library(folder / "one.db", create=True) as library:
        library.ingest(files)
    one, own = time.perf_counter() - begun, time.process_time() - own
    print(f"ingest of {count} files: one process {one:.1f} s, {own:.1f} s CPU")
    for workers in (1, 2):
        with Cluster(f"local:{workers}") as cluster:
            timer = Timed(cluster)
            begun, client = time.perf_counter(), time.process_time()
            with open_library(folder / f"{workers}.db", create=True) as library:
                vars(library)["spread"] = timer
                library.ingest(files)
            clock, client = time.perf_counter() - begun, time.process_time() - client
        busiest = max(timer.spent.values())
        print(
            f"  {workers} workers: {clock:.1f} s, {one / clock / workers:.0%} of {workers} x one; "
            f"CPU of the busiest worker {busiest:.1f} s, of the client {client:.1f} s: "
            f"{own / max(busiest, client) / workers:.0%}",
            flush=True,
        )


@lru_cache(1)
def written_down(path: str) -> dict[str, tuple[float, prepare.Outcomes]]:
    """Return what each file takes and becomes; a process reads it once."""
    return pickle.loads(Path(path).read_bytes())


def waited(path: str, task: prepare.Task) -> prepare.Outcomes:
    """Wait as long as a file takes, and return what it becomes."""
    seconds, outcomes = written_down(path)[task.path]
    time.sleep(seconds)
    return outcomes


def waited_batch(item: tuple[str, Any], tick: Any) -> list[prepare.Outcome]:
    """Do so with a batch, in a worker."""
    path, (_, tasks) = item
    return [one for task in tasks for one in waited(path, task)]


def began(path: str, tick: Any) -> None:
    """Have a worker hold what it is going to return."""
    written_down(path)
    time.sleep(0.5)  # so that each worker takes one


class Pinned:
    """A cluster whose workers wait in place of reading files."""

    def __init__(self, cluster: Cluster, path: str) -> None:
        self.cluster, self.tasks, self.path = cluster, cluster.tasks, path

    def results(self, work: Any, items: Any, tick: Any) -> Any:
        yield from self.cluster.results(waited_batch, ((self.path, it) for it in items), tick)

    def close(self) -> None:
        pass


def pinned(folder: Path, count: int, kinds: int) -> None:
    """Print what an ingest takes whose workers wait: by one process, and 1 to 8 workers."""
    files, found, profile = small_files(folder, count, kinds), {}, load()
    for file in files:
        begun = time.process_time()
        outcomes = prepare.prepare(prepare.Task(str(file), profile))
        found[str(file)] = time.process_time() - begun, outcomes
    path = str(folder / "written.pickle")
    Path(path).write_bytes(pickle.dumps(found))
    whole = sum(seconds for seconds, _ in found.values())
    print(f"{count} files take {whole:.1f} s of CPU")

    def ingest(name: str, spread: Any) -> tuple[float, float, float]:
        with open_library(folder / f"{name}.db", create=True) as library:
            vars(library)["spread"] = spread
            clocks = time.perf_counter, time.process_time, time.thread_time
            begun = [clock() for clock in clocks]
            library.ingest(files, jobs=1)
            clock, own, thread = (one() - it for one, it in zip(clocks, begun, strict=True))
            return clock, own, thread

    real, prepare.prepare = prepare.prepare, lambda task: waited(path, task)
    one, own, _ = ingest("one", None)
    prepare.prepare = real
    print(f"one process {one:.1f} s, {own:.1f} s CPU beside the waiting")
    for workers in (1, 2, 4, 8):
        with Cluster(f"local:{workers}") as cluster:
            list(cluster.results(began, [path] * workers, lambda: None))
            clock, client, storing = ingest(str(workers), Pinned(cluster, path))
        share, alone = one / clock / workers, (whole + own) / max(whole / workers, client) / workers
        print(
            f"  {workers} workers: {clock:.1f} s, {share:.0%} of {workers} x one; the client takes "
            f"{client:.1f} s of CPU, {storing:.1f} without Dask's threads: {alone:.0%} on machines "
            "of their own",
            flush=True,
        )


def clips(folder: Path, count: int) -> None:
    """Print what an export takes: of hits in many short captures, and in a few long ones."""
    large = sorted((CAPTURES / "bvh").rglob("*.bvh"), key=lambda it: it.stat().st_size)[-3:]
    long = [folder / f"long{number}.bvh" for number in range(6)]
    for number, file in enumerate(long):  # the same frames several times
        head, frames = re.split(rb"(?<=Frame Time:)", large[number % 3].read_bytes())
        time_line, *lines = frames.strip().splitlines()
        head = re.sub(rb"(?<=Frames:)\s*\d+", b" %d" % (12 * len(lines)), head)
        file.write_bytes(b"\n".join([head + time_line, *lines * 12, b""]))
    found = {}
    for name, files in (("short", small_files(folder, 300, 60)), ("long", long)):
        with open_library(folder / f"{name}.db", create=True) as library:
            library.ingest(files)
            hits = library.search("r_arm any")
            found[name] = list(hits[:: max(1, len(hits) // count)][:count])
    with Cluster("local:2") as cluster:
        timer = Timed(cluster)
        for name, hits in found.items():
            for form in ("native", "csv"):
                with open_library(folder / f"{name}.db", readonly=True) as library:
                    for spread in (None, timer):
                        vars(library)["spread"], where = spread, folder / f"{form}{spread is None}"
                        begun, own = time.perf_counter(), time.process_time()
                        library.export(hits, where / name, pad="0.5s", format=form)
                        own, clock = time.process_time() - own, time.perf_counter() - begun
                        busiest = max(timer.spent.values(), default=0)
                        print(
                            f"{len(hits)} clips of {name} captures as {form}: {clock:.1f} s; CPU: "
                            f"here {own:.1f} s"
                            + f", the busiest worker {busiest:.1f} s"
                            * (spread is not None),
                            flush=True,
                        )


def main(named: str = "", files: str = "1000", kinds: str = "20") -> None:
    with tempfile.TemporaryDirectory() as folder:
        if named == "pinned":
            return pinned(Path(folder), int(files), int(kinds))
        if named == "clips":
            return clips(Path(folder), int(files))
        path = Path(named) if named else synthetic.library(Path(folder) / "l.db", 20_000)
        begun = time.perf_counter()
        with Cluster("local:2") as cluster:
            print(f"{path.name}, 8 shards; two workers are there in", end=" ")
            print(f"{time.perf_counter() - begun:.1f} s", flush=True)
            searches(str(path), Timed(cluster))
        ingests(Path(folder), int(files))


if __name__ == "__main__":
    main(*sys.argv[1:])
