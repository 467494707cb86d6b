"""Work spread over processes of Dask has the same results; what goes wrong is one sentence."""

import json
import logging
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from random import Random
from threading import Thread

import numpy as np
import pytest
from cluster_work import failing, killing, measuring, sleeping, waiting, without_room
from command import run
from dances import BOW, RAISE, dance
from in_shards import Here
from made_c3d import c3d, standing
from random_library import PARTS, random_library
from sample_library import fill, sql

from lanindex.encoding.profile import load
from lanindex.errors import ExportError, LanindexError, UsageError
from lanindex.library import connect
from lanindex.model import Score
from lanindex.pipeline import shards
from lanindex.pipeline.cluster import Cluster
from lanindex.pipeline.export import ClipOptions, export
from lanindex.pipeline.library import open_library
from lanindex.pipeline.named import from_range
from lanindex.pipeline.prepare import Task, in_batches, prepare_batch, prepared
from lanindex.search.example import likeness

TABLES = ("capture", "track", "symbol_code", "metadata", "profile", "segment", "segment_column")


def rows_of(path: Path) -> list[list[tuple]]:
    with sql(path) as connection:
        return [connection.execute(f"SELECT * FROM {it}").fetchall() for it in TABLES]


def folder_of(path: Path) -> Path:
    """Write files of all kinds: alike, unreadable, in folders of their own."""
    for number in range(6):
        dance(path / f"{number % 3}" / f"{number}.bvh", BOW if number % 2 else RAISE)
    (path / "1" / "bow.lnd").write_text(BOW)
    (path / "2" / "broken.bvh").write_text("HIERARCHY\nROOT")
    (path / "own.csv").write_text("file,label\n0/0.bvh,raise\n1/bow.lnd,bow\n")
    return path


def test_an_ingest_in_batches_stores_the_same_bytes(tmp_path: Path, monkeypatch) -> None:
    folder_of(tmp_path / "dances")
    monkeypatch.chdir(tmp_path)
    told = []
    for name, spread in (("plain", None), ("spread", Here(3))):
        with open_library(f"{name}.db", create=True) as library:
            vars(library)["spread"] = spread
            outcomes = library.ingest("dances", labels="dances/own.csv")
            outcomes += library.ingest("dances", profile="paper")
            outcomes += library.begin_encode("default").result
            told.append([str(outcome) for outcome in outcomes])
    assert told[0] == told[1]
    assert {"added", "failed"} <= {it.status for it in outcomes}
    assert rows_of(tmp_path / "plain.db") == rows_of(tmp_path / "spread.db")


@pytest.mark.parametrize(
    ("stretches", "how"),
    [(8, {}), (8, {"origin": True}), (8, {"format": "lnd"}), (2, {"preview": "webp"})],
)
def test_an_export_in_batches_writes_the_same_bytes(
    tmp_path: Path, stretches: int, how: dict[str, object]
) -> None:
    dance(tmp_path / "bow.bvh", BOW)
    (tmp_path / "bow.lnd").write_text(BOW)
    events = {"EVENT:USED": 1, "EVENT:TIMES": np.array([[0.0, 0.1]])}
    (tmp_path / "a.c3d").write_bytes(c3d(standing(20), analog=np.ones((20, 4)), more=events))
    options, written = ClipOptions("1f", **how), list[object]()
    with open_library(tmp_path / "l.db", create=True) as library:
        library.ingest(tmp_path)
        names = ["a.c3d", "bow.bvh", "a.c3d"] + ["bow.lnd"] * (not options.origin)
        wanted = [
            from_range(library.store, name, 2 * place, 2 * place + 5)
            for name in names
            for place in range(stretches)
        ]
        for tasks in (0, 1, 2, 7):
            out, spread = tmp_path / str(tasks), Here(tasks) if tasks else None
            library.notes.clear()
            rows = export(library.store, wanted, out, options, spread=spread)
            files = {path.name: path.read_bytes() for path in out.iterdir()}
            written.append((rows, files, [*library.notes]))
    assert all(one == written[0] for one in written)
    assert len(rows) == len(wanted)
    assert library.notes or how


def test_an_export_in_batches_fails_as_one_by_one(tmp_path: Path) -> None:
    folder_of(tmp_path / "dances")
    said = []
    with open_library(tmp_path / "l.db", create=True) as library:
        library.ingest(tmp_path / "dances")
        wanted = [from_range(library.store, it.id, 0, 9) for it in library.captures()]
        dance(tmp_path / "dances" / "1" / "1.bvh", RAISE)
        for spread in (None, Here(7)):
            with pytest.raises(ExportError) as error:
                export(library.store, wanted, tmp_path / "out", spread=spread)
            said.append(str(error.value))
    assert said[0] == said[1]
    assert "1.bvh: has changed since" in said[0]
    assert not (tmp_path / "out").exists()


def test_an_export_in_batches_tells_the_first_error(tmp_path: Path) -> None:
    for name in ("first", "second"):
        dance(tmp_path / f"{name}.bvh", BOW)
    with open_library(tmp_path / "l.db", create=True) as library:
        library.ingest(tmp_path)
        names = ["first.bvh"] + ["second.bvh"] * 5  # the first batch ends with one of these
        wanted = [from_range(library.store, name, 0, 9) for name in names]
        dance(tmp_path / "second.bvh", RAISE)
        there = tmp_path / "out" / "first_0-9.bvh"
        there.parent.mkdir()
        there.touch()
        for spread in (None, Here(1)):
            with pytest.raises(ExportError, match=r"first_0-9\.bvh: exists already"):
                export(library.store, wanted, there.parent, spread=spread)
        there.unlink()
        with pytest.raises(ExportError, match=r"second\.bvh: has changed since"):
            export(library.store, wanted, there.parent, spread=Here(1))


def test_batches_have_about_as_many_bytes() -> None:
    tasks = [Task(str(number), None) for number in range(100)]
    found = list(in_batches(tasks, [1 << 16] * 99 + [1 << 30], 4))
    assert [one for batch in found for one in batch] == tasks
    assert [len(batch) for batch in found] == [99, 1]
    assert [len(it) for it in in_batches(tasks, [0] * 100, 4)] == [12] * 8 + [4]
    assert list(prepared([], 1, Here(3))) == []


def test_what_a_worker_has_read_is_stored_in_one_transaction(tmp_path: Path, monkeypatch) -> None:
    folder_of(tmp_path / "dances")
    begun, transaction = [], connect.transaction

    def counted(link, *, writes=False, **how):
        begun.append(writes)
        return transaction(link, writes=writes, **how)

    monkeypatch.setattr(connect, "transaction", counted)
    with open_library(tmp_path / "l.db", create=True) as library:
        vars(library)["spread"] = Here(1)
        before = sum(begun)
        library.ingest(tmp_path / "dances")
        assert len(library.captures()) == 7
        assert sum(begun) - before < 7


def noted(progress: list, *at: object) -> None:
    progress.append(at)


def test_motifs_are_the_same(tmp_path: Path) -> None:
    fill(tmp_path / "l.db", 30)
    with open_library(tmp_path / "l.db") as library:
        told = []
        for spread in (None, Here(3)):
            vars(library)["spread"] = spread
            progress = list[tuple[str, int, int]]()
            found = library.motifs(min_count=2, length=2, progress=partial(noted, progress))
            places = [(it.pattern, it.hits, it.captures, it.places) for it in found.found]
            told.append([places, found.notes, progress[-1]])
    assert told[0] == told[1]
    assert places


@pytest.mark.parametrize("groups", [None, 3])
def test_groups_are_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, groups: int | None
) -> None:
    monkeypatch.setattr(likeness, "_AT_ONCE", 16)
    random = Random(1)
    with open_library(tmp_path / "l.db", create=True) as library:
        for number in range(40):
            ((capture, tracks),) = random_library(random, captures=1, most=12, known=PARTS)
            score = Score(capture.rate, capture.frames, capture.meter, dict(tracks))
            library.store.add(f"{number}.lnd", score, format="lnd", sha256="0" * 64)
        told = []
        for spread in (None, Here(1), Here(2), Here(7)):
            vars(library)["spread"] = spread
            progress = list[tuple[str, int, int]]()
            found = library.similar(groups=groups, alike=0.3, progress=partial(noted, progress))
            told.append([repr(found), max(it for it in progress if it[0] == "pairs")])
    assert told[1:] == told[:1] * 3
    assert "likeness" in told[0][0]


def test_a_file_that_a_worker_does_not_see(tmp_path: Path) -> None:
    dance(tmp_path / "bow.bvh", BOW)
    batch = str(tmp_path), [Task(it, load()) for it in ("bow.bvh", "gone.bvh")]
    seen, unseen = prepare_batch(batch, lambda: None)
    assert (seen.status, unseen.status) == ("added", "failed")
    assert str(unseen.error).startswith("gone.bvh: a worker does not see this file. Workers read")


def test_a_worker_that_sees_none_of_them_says_so_once(tmp_path: Path) -> None:
    batch = str(tmp_path), [Task(it, load()) for it in ("gone.bvh", "lost.bvh", "none.bvh")]
    with pytest.raises(LanindexError, match=r"^gone.bvh: .* see this file, nor 2 other files\. W"):
        prepare_batch(batch, lambda: None)


@pytest.mark.parametrize(
    "named",
    ["", "here", "local:0", "local:x", "slurm:-1", "tcp://here", "tcp://here:x", "http://here:1"],
)
def test_an_address_that_is_none(named: str) -> None:
    with pytest.raises(UsageError, match="--cluster"):
        Cluster(named)


def test_without_dask_one_sentence_says_what_to_install(tmp_path: Path) -> None:
    fill(tmp_path / "l.db", 2)
    code = (
        "import sys; sys.modules['distributed'] = None; from lanindex.app.cli import main; main()"
    )
    words = [sys.executable, "-c", code, "search", "r_arm any", "--db", str(tmp_path / "l.db")]
    done = subprocess.run([*words, "--cluster", "local"], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == (
        "lanindex: --cluster: distributed is not installed. "
        "It comes with: pip install 'lanindex[cluster]'.\n"
    )


def test_a_summary_is_not_spread(tmp_path: Path) -> None:
    fill(tmp_path / "l.db", 2)
    done = run("stats", "--cluster", "local", "--db", "l.db", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr == "lanindex: --cluster, wanted --by, --part, --plot or --in beside it\n"


def test_slurm_needs_another_package(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "dask_jobqueue", None)
    with pytest.raises(UsageError, match=r"pip install 'lanindex\[cluster\]'"):
        Cluster("slurm")


def test_dask_is_loaded_where_it_is_asked_for_alone(tmp_path: Path) -> None:
    fill(tmp_path / "l.db", 2)
    code = (
        "import sys; from lanindex.app.cli import run\n"
        "for words in (['search', 'r_arm any'], ['stats'], ['motifs'], ['similar'],\n"
        "              ['ingest', sys.argv[2]], ['export', 'r_arm any']):\n"
        "    run([*words, '--db', sys.argv[1], '-q'])\n"
        "print([it for it in sys.modules if it.split('.')[0] in ('dask', 'distributed')])"
    )
    words = [sys.executable, "-c", code, str(tmp_path / "l.db"), str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "[]"


# With processes of Dask.


@pytest.fixture(scope="module")
def cluster():
    with Cluster("local:2") as opened:
        yield opened


@pytest.fixture
def library(tmp_path: Path, cluster: Cluster, monkeypatch):
    monkeypatch.setattr(shards, "FEWEST", 1)
    fill(tmp_path / "l.db", 40)
    with open_library(tmp_path / "l.db") as opened:
        opened.store.cache.compact()
        vars(opened)["spread"] = cluster
        yield opened
        del vars(opened)["spread"]  # it is not the library's own


def test_a_cluster_finds_the_same(library) -> None:
    spread = library.spread
    for text, how in (("r_arm any", {}), ("r_arm any -> any", {"fuzzy": "1", "best": 5})):
        library.spread = spread
        found = library.search(text, **how).dicts()
        library.spread = None
        assert found == library.search(text, **how).dicts()


@pytest.mark.filterwarnings("error")
def test_of_large_items_dask_says_nothing(cluster: Cluster) -> None:
    assert list(cluster.results(measuring, [bytes(11 << 20)], lambda: None)) == [11 << 20]


@pytest.mark.slow
def test_files_are_read_and_cut_by_a_cluster(tmp_path: Path, cluster: Cluster, monkeypatch) -> None:
    folder_of(tmp_path / "dances")
    monkeypatch.chdir(tmp_path)
    names = "plain", "spread"
    for name, spread in zip(names, (None, cluster), strict=True):
        with open_library(f"{name}.db", create=True) as library:
            vars(library)["spread"] = spread
            library.ingest("dances", labels="dances/own.csv")
            library.export(library.search("r_arm any"), name, pad="0.1s")
            vars(library).pop("spread")
    plain, spread = ({it.name: it.read_bytes() for it in Path(name).iterdir()} for name in names)
    assert plain == spread
    assert rows_of(tmp_path / "plain.db") == rows_of(tmp_path / "spread.db")


@pytest.mark.slow
def test_a_process_that_is_killed_is_no_matter(tmp_path: Path, cluster: Cluster) -> None:
    items = [(str(tmp_path / "died"), number) for number in range(12)]
    found = list(cluster.results(killing, items, lambda: None))
    assert [number for number, _ in found] == list(range(12))
    assert (tmp_path / "died").exists()


@pytest.mark.slow
def test_tasks_end_when_nobody_waits(tmp_path: Path, cluster: Cluster) -> None:
    begun = time.monotonic()

    def tick() -> None:
        if len(list(tmp_path.glob("* begun"))) == 2:
            raise KeyboardInterrupt

    paths = [tmp_path / f"{number}" for number in range(2)]
    with pytest.raises(KeyboardInterrupt):
        list(cluster.results(waiting, map(str, paths), tick))
    while not all(path.exists() and path.read_text() for path in paths):
        assert time.monotonic() - begun < 30
        time.sleep(0.05)


@pytest.mark.slow
def test_errors_of_tasks_are_raised_here(cluster: Cluster) -> None:
    with pytest.raises(LanindexError, match=r"^here: number 1\. None\.$"):
        list(cluster.results(failing, [1, 2], lambda: None))


@pytest.mark.slow
def test_results_come_from_workers_that_this_machine_reaches(cluster: Cluster, monkeypatch) -> None:
    client = cluster._client
    assert client.direct_to_workers
    monkeypatch.setattr(client, "nthreads", lambda: {"tcp://127.0.0.1:9": 1})
    assert not cluster._reaches_workers()
    monkeypatch.setattr(client, "nthreads", dict)
    assert not cluster._reaches_workers()
    monkeypatch.undo()
    monkeypatch.setattr(client, "direct_to_workers", False)
    with pytest.raises(LanindexError, match="number 2"):
        list(cluster.results(failing, [2], lambda: None))


@pytest.mark.slow
def test_a_scheduler_that_is_out_of_reach_for_a_while(cluster: Cluster, monkeypatch) -> None:
    monkeypatch.setattr("lanindex.pipeline.cluster.PATIENCE", 0.2)
    asked = []

    def unreached(*_: object, **__: object) -> None:
        asked.append(OSError("Timed out trying to connect"))
        raise asked[-1]

    found = cluster.results(sleeping, [0.1, 1.5], lambda: None)
    assert next(found) == 0.1
    monkeypatch.setattr(cluster._client, "wait_for_workers", unreached)
    assert list(found) == [1.5]
    assert asked


@pytest.mark.slow
def test_nobody_answers() -> None:
    with pytest.raises(LanindexError, match=r"tcp://127.0.0.1:9: no scheduler answers there"):
        Cluster("tcp://127.0.0.1:9")


def dask(*words: str) -> subprocess.Popen:
    own = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", "dask", *words, "--no-dashboard"]
    return subprocess.Popen(command, stderr=subprocess.DEVNULL, env=own)


@contextmanager
def begun(tmp_path: Path):
    """Begin a scheduler and a worker as the guide does; yield the address and both."""
    file = tmp_path / "s.json"
    scheduler = dask("scheduler", "--port", "0", "--scheduler-file", str(file))
    while not file.exists():
        time.sleep(0.1)
    address = json.loads(file.read_text())["address"]
    worker = dask("worker", address, "--no-nanny", "--local-directory", str(tmp_path))
    try:
        yield address, scheduler, worker
    finally:
        for one in (worker, scheduler):
            one.kill()
            one.wait()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("which", "says"), [(0, "the scheduler is gone"), (1, "no worker is left. Start one")]
)
def test_one_of_them_dies(tmp_path: Path, monkeypatch, which: int, says: str) -> None:
    with begun(tmp_path) as (address, *both), Cluster(address) as opened:
        assert not logging.getLogger("distributed.client").isEnabledFor(logging.ERROR)
        monkeypatch.setattr("lanindex.pipeline.cluster.PATIENCE", 2)
        items = [str(tmp_path / "begun")]
        Thread(target=lambda: (time.sleep(3), both[which].kill()), daemon=True).start()
        with pytest.raises(LanindexError, match=f"{address}: {says}"):
            list(opened.results(waiting, items, lambda: None))
        opened._client.close()  # as Dask does where the scheduler stays away
        with pytest.raises(LanindexError, match=f"{address}: the scheduler is gone"):
            list(opened.results(waiting, items, lambda: None))


@pytest.mark.slow
def test_the_only_worker_dies_and_another_one_comes(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("lanindex.pipeline.cluster.PATIENCE", 4)
    others = []

    def replaced() -> None:
        while not (tmp_path / "died").exists():
            time.sleep(0.1)
        others.append(dask("worker", address, "--no-nanny", "--local-directory", str(tmp_path)))

    with begun(tmp_path) as (address, *_), Cluster(address) as opened:
        replacing = Thread(target=replaced, daemon=True)
        replacing.start()
        items = [(str(tmp_path / "died"), number) for number in range(12)]
        found = list(opened.results(killing, items, lambda: None))
        replacing.join()
        others[0].kill()
        others[0].wait()
    assert [number for number, _ in found] == list(range(12))


@pytest.mark.slow
def test_a_worker_that_stands_still_is_told(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("lanindex.pipeline.cluster.PATIENCE", 1)
    notes = list[str]()
    with begun(tmp_path) as (address, _, worker), Cluster(address, notes.append) as opened:
        begin = time.monotonic()

        def tick() -> None:
            assert time.monotonic() < begin + 30
            if len(notes) == 1:
                worker.send_signal(signal.SIGCONT)

        worker.send_signal(signal.SIGSTOP)
        assert list(opened.results(sleeping, [4], tick)) == [4]  # nothing is told while it works
    (said,) = notes
    assert said.startswith(f"{address}: nothing heard from the worker tcp://")


@pytest.mark.slow
def test_errors_of_a_worker_elsewhere_name_it(tmp_path: Path) -> None:
    with begun(tmp_path) as (address, *_), Cluster(address) as opened:
        found = opened.results(failing, [1, 2], lambda: None)
        with pytest.raises(LanindexError, match=rf"^a worker of {address}: here: number 1\."):
            list(found)
        found = opened.results(without_room, [1], lambda: None)
        says = rf"^a worker of {address}: cannot go on \(No space left on device\)$"
        with pytest.raises(LanindexError, match=says):
            list(found)
