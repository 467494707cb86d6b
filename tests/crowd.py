"""Writers and readers of one library, each a process, and how long they wait for each other.

    python tests/crowd.py write URL FIRST COUNT
    python tests/crowd.py read URL

A writer stores so many samples, joins columns now and then, and prints how long each transaction
waited to begin and how long it took. A reader asks every other second until its input ends, looks
whether all that it sees is one state, and prints how long each question took.
"""

from __future__ import annotations

import json
import select
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from random import Random
from threading import Event, Thread
from time import perf_counter
from typing import Any

HERE = Path(__file__).parent
JOIN_EVERY = 40
"""Captures after which a writer joins columns."""

PAUSE = 2.0
"""Seconds between the questions of a reader, on average."""

WAITING = "SELECT usename FROM pg_stat_activity WHERE wait_event_type = 'Lock'"


def write(url: str, first: int, count: int) -> dict[str, list[float]]:
    """Store samples, and return seconds: before each transaction, and within it."""
    from sample_library import add_sample

    from lanindex.library.connect import Session
    from lanindex.library.store import Store

    told: dict[str, list[float]] = {"waited": [], "took": []}
    plain = Session.writing

    @contextmanager
    def timed(session: Session) -> Iterator[Any]:
        begun = perf_counter()
        with plain(session) as link:
            told["waited"].append(perf_counter() - begun)
            yield link
        told["took"].append(perf_counter() - begun - told["waited"][-1])

    Session.writing = timed  # type: ignore[method-assign]
    with Store.open(url) as store:
        go()
        for number in range(first, first + count):
            add_sample(store, number)
            if number % JOIN_EVERY == 0:
                store.cache.compact()
    return told


def read(url: str) -> dict[str, list[float]]:
    """Ask until the input ends, and return the seconds of each question."""
    from lanindex.library import read
    from lanindex.library.connect import ask
    from lanindex.pipeline.library import open_library

    told, random, before = list[float](), Random(), 0
    with open_library(url, readonly=True) as library:
        library.search("r_arm any")
        go()
        while not select.select([sys.stdin], [], [], 2 * PAUSE * random.random())[0]:
            begun = perf_counter()
            found = library.search("r_arm any").captures
            told.append(perf_counter() - begun)
            assert found >= before, (found, before)
            before = found
            with library.store.session.reading() as link:
                captures = read.read_state(link).captures
                ((rows,),) = ask(link, "SELECT count(*) FROM capture")
                ((tracks,),) = ask(link, "SELECT coalesce(sum(symbols), 0) FROM track")
                ((symbols,),) = ask(link, "SELECT count(*) FROM symbol_code")
                assert (rows, symbols) == (captures, tracks)
    return {"took": told}


def go() -> None:
    """Tell that all is ready, and wait until the others are."""
    print(flush=True)
    sys.stdin.readline()


def crowd(
    server: Any, writer: str, reader: str, *, writers: int, readers: int, each: int
) -> tuple[list[dict[str, list[float]]], list[dict[str, list[float]]], set[str]]:
    """Let processes write and read, and return what they told, and who waited for a lock.

    Writers store `each` captures, one behind the numbers of another; the library has none yet.
    """
    with ExitStack() as stack:
        asking = [started(stack, "read", reader) for _ in range(readers)]
        storing = [
            started(stack, "write", writer, str(first * each), str(each))
            for first in range(writers)
        ]
        for process in (*asking, *storing):
            assert process.stdout.readline() == "\n", process.stderr.read()
        done, waiting = Event(), set[str]()
        watch = Thread(target=watched, args=(server, done, waiting))
        watch.start()
        for process in (*asking, *storing):
            process.stdin.write("\n")
            process.stdin.flush()
        wrote = [told_by(process) for process in storing]
        done.set()
        watch.join()
        return wrote, [told_by(process) for process in asking], waiting


def started(stack: ExitStack, *words: str) -> Any:
    """Start a process, which ends with the stack."""
    pipe = subprocess.PIPE
    command = [sys.executable, str(HERE / "crowd.py"), *words]
    process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True)
    stack.enter_context(process)
    stack.callback(process.kill)
    return process


def told_by(process: Any) -> dict[str, list[float]]:
    """Return what a process tells at its end; a reader ends with its input."""
    said, trouble = process.communicate(timeout=120)
    assert process.returncode == 0, trouble
    return json.loads(said)


def watched(server: Any, done: Event, waiting: set[str]) -> None:
    """Note the users who wait for a lock."""
    with closing(server.connect(autocommit=True)) as link:
        while not done.wait(0.01):
            waiting.update(name for (name,) in link.execute(WAITING))


if __name__ == "__main__":
    verb, url, *numbers = sys.argv[1:]
    print(json.dumps(write(url, *map(int, numbers)) if verb == "write" else read(url)))
