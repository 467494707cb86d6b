"""Processes of Dask, on this machine or on many, that do the work of a library's jobs.

A task is a function of this package and its argument, pickled: nothing else has to be on the
machines but the same LanIndex, and the files under the same paths. A task whose process dies is
done again by another one.
"""

from __future__ import annotations

import logging
import pickle
import re
import signal
import subprocess
from collections import Counter, deque
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from importlib import import_module
from itertools import islice
from threading import Event
from time import monotonic, time
from typing import TYPE_CHECKING, Any, Self
from uuid import uuid4

from lanindex.errors import AbsentError, LanindexError, UsageError, extra, shown
from lanindex.pipeline.prepare import interrupts_later

if TYPE_CHECKING:
    from lanindex.pipeline.spread import Tick, Work

TASKS = 4
"""Tasks for each thread of the workers: the last ones end at about the same time."""

AHEAD = 2
"""So many times as many tasks are given at once: the results of those that wait take memory."""

PATIENCE = 10
"""Seconds that a scheduler has to answer, and three times as many its first worker."""

NEAR = 2
"""Seconds that a worker has to answer this machine."""

TICK = 0.1
"""Seconds after which who waits for a result is told."""

_ENVIRONMENT = "distributed.nanny.pre-spawn-environ"

_CONFIGURED = "See to jobqueue.slurm in the configuration of Dask: lanindex guide growing"

WANTED = "tcp://HOST:PORT, local or slurm"


class _Abandoned(Exception):
    """Raised in a task for which nobody waits any more."""


class Cluster:
    """Workers of Dask, to which tasks are given.

    Parameters
    ----------
    named : str
        The address of a scheduler; ``local``: processes of this machine, as many as it has
        processors, or ``local:4``; ``slurm``: a job of Slurm as the configuration of
        dask-jobqueue has it, or ``slurm:20``.
    note : callable, optional
        Is told what jobs wait for that have to.
    """

    def __init__(self, named: str, note: Callable[[str], None] = lambda _: None) -> None:
        kind, _, number = named.partition(":")
        if kind not in ("local", "slurm") and not re.fullmatch(r"(tcp|tls)://[^/]+:\d+", named):
            raise UsageError(f'"{shown(named)}"', place="--cluster", wanted=WANTED)
        count = None
        if kind in ("local", "slurm") and number:
            count = int(number) if number.isdecimal() else 0
            if count < 1:
                raise UsageError(f'"{shown(named)}"', place="--cluster", wanted=f"{kind}:4")
        self.named = named
        with extra("cluster", "--cluster", UsageError):
            distributed: Any = import_module("distributed")
        for logger in ("distributed", "distributed.client"):  # their levels differ
            logging.getLogger(logger).setLevel(logging.CRITICAL)
        config: Any = import_module("dask.config")
        config.set({"distributed.admin.large-graph-warning-threshold": "1 GB"})  # a batch of clips
        secured = distributed.Security().get_connection_args("client")["ssl_context"]
        if kind == "tls" and not secured:
            remedy = "Name them in Dask's configuration: distributed.comm.tls.client"
            raise UsageError("Dask has no certificates for it", place=named, remedy=remedy)
        self._made: Any = None
        self._client: Any = None
        self._jobs: set[str] = set()
        self._note = note
        try:
            if kind == "slurm":
                self._made = _slurm()
                self._jobs = _submitted(self._made, count or 1)
            with self._told("no scheduler answers there", "Start one there: dask scheduler"):
                if kind == "local":
                    self._made = _local(count)
                at = named if self._made is None else self._made
                self._client = distributed.Client(at, timeout=PATIENCE, set_as_default=False)
            with self._gone():
                self._wait_for_workers("no worker has joined it")
            self._client.direct_to_workers = self._reaches_workers()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the cluster; one that was made for this is ended."""
        busy = self.named.startswith("slurm")  # it may take its time to take a job and to end one
        for one in (self._client, self._made):
            if one is not None:
                with suppress(OSError, TimeoutError):
                    one.close(timeout=3 * PATIENCE if busy else 5)

    def _wait_for_workers(self, found: str) -> None:
        """Raise an error if there are none for long; jobs of Slurm may wait for longer."""
        if self._jobs:
            self._wait_for_jobs(found)
            return
        own = self._made is None
        remedy = f"Start one, with this LanIndex: dask worker {self.named}" if own else ""
        try:
            self._client.wait_for_workers(1, timeout=3 * PATIENCE)
        except TimeoutError as error:
            raise LanindexError(found, place=self.named, remedy=remedy) from error

    def _wait_for_jobs(self, found: str) -> None:
        """Wait for a worker for as long as a job of Slurm may still become one."""
        said = ""
        while True:
            with suppress(TimeoutError):
                self._client.wait_for_workers(1, timeout=PATIENCE)
                return
            left = _in_queue(self._jobs)
            if left == []:
                raise LanindexError(
                    f"{found}, and its jobs have ended",
                    place=self.named,
                    remedy="Their output says why, such as memory or walltime: slurm-*.out, or "
                    "in the log-directory of dask-jobqueue.",
                )
            states = ", ".join(f"{number} {state}" for state, number in Counter(left).items())
            if states not in ("", said):  # nothing, where Slurm does not say
                said = states
                self._note(f"{self.named}: no worker yet; its jobs: {states}")

    def _reaches_workers(self) -> bool:
        """Return whether this machine reaches workers, whose network may be closed to it.

        If not, the scheduler passes results on, which takes twice as long.
        """
        client = self._client

        async def reach(address: str) -> None:
            client.rpc.reuse(address, await client.rpc.connect(address, timeout=NEAR))

        try:
            client.sync(reach, next(iter(client.nthreads())))
        except (OSError, TimeoutError, StopIteration):
            return False
        return True

    @property
    def threads(self) -> int:
        """How many tasks are done at the same time, once all jobs of Slurm have begun."""
        with self._gone():
            joined = sum(map(int, self._client.nthreads().values()))
        if self._jobs:
            config: Any = import_module("dask.config")
            joined = max(joined, len(self._jobs) * int(config.get("jobqueue.slurm.cores")))
        return max(1, joined)

    @property
    def tasks(self) -> int:
        """Into how many tasks work is best cut."""
        return TASKS * self.threads

    def results(self, work: Work, items: Iterable[Any], tick: Tick) -> Iterator[Any]:
        """Yield the results of work on items, in their order; a few are done ahead.

        Whoever breaks off waits for nothing: tasks that run are told to end.
        """
        left, waiting = enumerate(items), deque[tuple[int, Any, Any]]()
        ahead, ended, looked = AHEAD * self.tasks, Event(), monotonic()
        job, silent = uuid4().hex, set[str]()
        with self._gone():
            workers = self._workers()

        def given(place: int, item: Any) -> Any:
            # the same place goes to the same worker each time: it may still hold what it read
            how = {"workers": workers[place % len(workers)], "allow_other_workers": True}
            call, key = _Call(work, item), f"lanindex-{job}-{place}"
            with self._gone():
                future = self._client.submit(call, key=key, pure=False, **how)
            future.add_done_callback(lambda _: ended.set())
            return future

        fetched: Any = None  # the first result that is waited for, on its way
        try:
            while True:
                for place, item in islice(left, ahead - len(waiting)):
                    waiting.append((place, item, given(place, item)))
                if not waiting:
                    return
                tick()
                ended.clear()
                if fetched is None and waiting[0][2].done():
                    fetched = self._fetched(waiting[0][2])
                    fetched.add_done_callback(lambda _: ended.set())
                if fetched is not None and fetched.done():
                    result, fetched = self._result(fetched), None
                    waiting.popleft()
                    yield result
                    continue
                ended.wait(TICK)
                if monotonic() - looked > PATIENCE:
                    now = list[str]()
                    with self._gone(), suppress(OSError):  # a link cut for good ends the tasks
                        now = self._workers()
                        silent = self._told_of_silent(silent)
                    looked = monotonic()
                    if now and {*now}.isdisjoint(workers):
                        # what they had left, Dask gives to nobody who comes later
                        workers, job, fetched = now, uuid4().hex, None
                        for number, (place, item, had) in enumerate(waiting):
                            if not had.done():
                                waiting[number] = place, item, given(place, item)
        finally:
            if waiting and self._client.status == "running":
                self._client.cancel([future for _, _, future in waiting], force=True)

    def _fetched(self, future: Any) -> Any:
        """Return what will have the result of a task that has ended; its worker may die yet."""
        from asyncio import run_coroutine_threadsafe

        fetch = self._client.gather(future, asynchronous=True)
        return run_coroutine_threadsafe(fetch, self._client.loop.asyncio_loop)

    def _workers(self) -> list[str]:
        """Wait for workers, and return their addresses."""
        while True:
            self._wait_for_workers("no worker is left")
            if found := sorted(self._client.nthreads()):  # the last one may have died since
                return found

    def _told_of_silent(self, told: Collection[str]) -> set[str]:
        """Return the workers that stand still, and tell the user of those that are new."""
        silent: set[str] = self._client.run_on_scheduler(_silent, 3 * PATIENCE)
        for worker in sorted(silent.difference(told)):
            self._note(
                f"{self.named}: nothing heard from the worker {worker} for {3 * PATIENCE} s; "
                "others do its work once it ends or Dask gives it up "
                "(distributed.scheduler.worker-ttl)"
            )
        return silent

    def _result(self, future: Any) -> Any:
        """Return what a task returned, or raise its error."""
        from distributed import KilledWorker

        try:
            with self._gone():
                error, result = future.result()
            if error is None:
                return pickle.loads(result)
        except KilledWorker as killed:
            raise LanindexError(
                f"{killed.allowed_failures + 1} workers died of the same task (out of memory?)",
                place=self.named,
                remedy="Give them more memory, or choose fewer captures.",
            ) from killed
        except (ImportError, RuntimeError) as unread:
            if isinstance(unread, RuntimeError) and "deserialization" not in str(unread):
                raise
            raise LanindexError(
                f"its processes cannot read this work: {unread.__cause__ or unread}",
                place=self.named,
                remedy="Install the same LanIndex for its scheduler and its workers.",
            ) from unread
        if self._made is None:  # the same may be right on this machine
            error.place = ": ".join(filter(None, (f"a worker of {self.named}", error.place)))
            if isinstance(error, AbsentError):
                error.remedy = "Workers open it themselves: under the same path, or in PostgreSQL."
        raise error

    def _gone(self) -> AbstractContextManager[None]:
        """Raise errors of the connection to the scheduler."""
        return self._told("the scheduler is gone", "Start it again.")

    @contextmanager
    def _told(self, found: str, remedy: str) -> Iterator[None]:
        """Raise errors of the connection as one that names the cluster."""
        from concurrent.futures import CancelledError

        try:
            yield
        except Exception as error:
            # Dask closes its client where a scheduler does not come back
            closed = self._client is not None and self._client.status in ("closing", "closed")
            if not closed and not isinstance(error, (OSError, TimeoutError, CancelledError)):
                raise
            raise LanindexError(found, place=self.named, remedy=remedy) from error


def _local(count: int | None) -> Any:
    """Return processes of this machine, which leave Ctrl-C to this one."""
    import os
    from multiprocessing.resource_tracker import ensure_running

    distributed: Any = import_module("distributed")
    how: dict[str, Any] = {"threads_per_worker": 1, "memory_limit": 0}
    how |= {"dashboard_address": "127.0.0.1:0", "scheduler_kwargs": {"dashboard": False}}
    how |= {"n_workers": count or os.cpu_count() or 1, "silence_logs": logging.CRITICAL}
    config: Any = import_module("dask.config")
    # glibc, told when to give memory back, takes all larger arrays from the system each time
    own = {name: it for name, it in config.get(_ENVIRONMENT).items() if "MALLOC" not in name}
    ensure_running()  # which lets signals through once it has begun
    with interrupts_later(), config.set({_ENVIRONMENT: own}):
        return distributed.LocalCluster(**how)


def _slurm() -> Any:
    """Return a scheduler for jobs of Slurm, configured as dask-jobqueue says."""
    with extra("cluster", "--cluster slurm", UsageError), _no_handlers():
        jobqueue: Any = import_module("dask_jobqueue")
    config: Any = import_module("dask.config")
    lacking = [it for it in ("cores", "memory") if config.get(f"jobqueue.slurm.{it}") is None]
    if lacking:
        raise UsageError(
            f"dask-jobqueue is not told the {' and '.join(lacking)} of a job",
            place="--cluster slurm",
            remedy=_CONFIGURED,
        )
    # without the page of Dask, whose port another search may have
    options = {"dashboard": False, "dashboard_address": ":0"}
    options |= config.get("jobqueue.slurm.scheduler-options")
    with _refused(), interrupts_later():  # sbatch and scancel inherit that
        return jobqueue.SLURMCluster(scheduler_options=options, silence_logs=logging.CRITICAL)


@contextmanager
def _no_handlers() -> Iterator[None]:
    """Let an import set no handler of a signal: that of dask-jobqueue takes Ctrl-C for itself.

    To put the old one back would not do: in any thread but the first the import itself fails.
    """
    names, before = vars(signal), signal.signal
    names["signal"] = lambda *_: None
    try:
        yield
    finally:
        names["signal"] = before


def _submitted(cluster: Any, jobs: int) -> set[str]:
    """Submit jobs, and return their numbers."""
    from distributed import Status

    for _ in range(jobs):
        cluster.worker_spec.update(cluster.new_worker_spec())
    try:
        with _refused():
            cluster.sync(cluster._correct_state)  # `scale` only logs what goes wrong
    except LanindexError:
        for job in cluster.workers.values():
            job.status = Status.closing  # of others Dask thinks that they were forgotten
        raise
    return {job.job_id for job in cluster.workers.values()}


@contextmanager
def _refused() -> Iterator[None]:
    """Raise what dask-jobqueue or Slurm refuses, in errors of many kinds, as one of LanIndex."""
    try:
        yield
    except FileNotFoundError as error:
        found, remedy = f"there is no {error.filename} here", "Run this where jobs are submitted."
        raise UsageError(found, place="--cluster slurm", remedy=remedy) from error
    except Exception as error:
        said = str(error).strip().splitlines() or [type(error).__name__]
        found = shown(said[-1].removeprefix("sbatch: error: "), 200)
        raise UsageError(found, place="--cluster slurm", remedy=_CONFIGURED) from error


def _in_queue(jobs: Collection[str]) -> list[str] | None:
    """Return in which states those of some jobs are that have not ended; None: Slurm is silent."""
    words = ["squeue", "--me", "--noheader", "--format=%i %T (%r)"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=3 * PATIENCE)
    except (OSError, subprocess.TimeoutExpired):
        return None
    if done.returncode:
        return None
    lines = (line.partition(" ") for line in done.stdout.splitlines())
    return [state for job, _, state in lines if job in jobs]


@dataclass(frozen=True, slots=True)
class _Call:
    """Work on an item, in a worker: returns an error of LanIndex or None, and a pickled result."""

    work: Work
    item: Any = field(repr=False)  # Dask logs what fails; a library's URL may have a password

    def __call__(self) -> tuple[LanindexError | None, Any]:
        try:
            # as one: Dask sends each of many small arrays by itself, which takes longer
            return None, pickle.dumps(self.work(self.item, _tick()))
        except LanindexError as error:
            return error, None
        except OSError as error:  # raised, it would look like one of the connection
            place = str(error.filename or "")
            return LanindexError(f"cannot go on ({error.strerror or error})", place=place), None
        except _Abandoned:
            return None, None


def _silent(seconds: float, dask_scheduler: Any) -> set[str]:
    """Return the workers of which a scheduler, in whose process this runs, has heard nothing."""
    since = time() - seconds
    return {it.address for it in dask_scheduler.workers.values() if it.last_seen < since}


def _tick() -> Callable[[], None]:
    """Return what raises once the task that runs in this thread is wanted no more."""
    from distributed import get_worker

    worker = get_worker()
    key, tasks = worker.get_current_task(), worker.state.tasks

    def tick() -> None:
        task = tasks.get(key)
        if task is None or task.state == "cancelled":  # also where whoever wanted it is gone
            raise _Abandoned

    return tick
