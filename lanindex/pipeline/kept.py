"""Arrays that are worked out once and kept in files without a name, of which windows are read.

A file goes with whoever holds it: nothing is left behind, however the process ends. What takes
long or much memory is worked out by another process, which writes into the same file.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import import_module
from tempfile import TemporaryFile
from typing import Any, BinaryIO, Generic, TypeVar
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from lanindex import errors

BYTES = 2 << 30
"""Bytes that are kept on the disk, at most, but for the last one asked for."""

FILES = 64
"""Files that are kept, at most."""

ASIDE = 2
"""Processes that work things out at once."""

Made = tuple[Mapping[str, Any], Mapping[str, NDArray[Any]]]
"""What is worked out: what is said of it as JSON, and arrays by name, a row each frame."""

Job = Callable[..., Made]
"""Works something out; for a process of its own the arguments are such as JSON has."""


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Kept:
    """Something that was worked out, in a file."""

    about: Mapping[str, Any]
    size: int  # bytes
    file: BinaryIO
    # by name: type, shape, and the byte at which it begins
    arrays: Mapping[str, tuple[np.dtype[Any], tuple[int, ...], int]]
    turn: threading.Lock = field(default_factory=threading.Lock)

    def __post_init__(self) -> None:
        finalize(self, self.file.close)

    def window(self, name: str, start: int = 0, stop: int | None = None) -> NDArray[Any]:
        """Return some rows of an array, read from the disk."""
        kind, (rows, *row), offset = self.arrays[name]
        first, last, _ = slice(start, stop).indices(rows)
        last, size = max(first, last), int(np.prod(row, dtype=np.int64)) * kind.itemsize
        with self.turn:
            self.file.seek(offset + first * size)
            data = self.file.read((last - first) * size)
        return np.frombuffer(data, kind).reshape(last - first, *row)


def write(made: Made, file: BinaryIO) -> None:
    """Write what was worked out: a line of JSON, and arrays one behind the other."""
    about, arrays = made
    shapes = {name: (it.dtype.str, it.shape) for name, it in arrays.items()}
    file.write(json.dumps({"about": about, "arrays": shapes}).encode() + b"\n")
    for array in arrays.values():
        file.write(np.ascontiguousarray(array).data)
    file.flush()


def _kept(run: Callable[[BinaryIO], None]) -> Kept:
    """Return what is written into a file."""
    file: Any = TemporaryFile(buffering=0)  # noqa: SIM115 (closed with what is kept in it)
    try:
        run(file)
        file.seek(0)
        line = file.readline()
        head, offset, arrays = json.loads(line), len(line), {}
        for name, (kind, shape) in head["arrays"].items():
            arrays[name] = np.dtype(kind), tuple(shape), offset
            offset += int(np.prod(shape, dtype=np.int64)) * np.dtype(kind).itemsize
        return Kept(head["about"], offset, file, arrays)
    except BaseException:
        file.close()
        raise


T = TypeVar("T")


class Latest(Generic[T]):
    """Results by what they are made of, each made once; the least recently used is let go."""

    def __init__(self, most: int, most_bytes: int = sys.maxsize) -> None:
        self.most, self.most_bytes = most, most_bytes
        self._lock = threading.Lock()
        self._kept: OrderedDict[Hashable, Future[T]] = OrderedDict()

    def __len__(self) -> int:
        """Return how many are kept or being made."""
        return len(self._kept)

    def holds(self, key: Hashable) -> bool:
        """Return whether a result is there."""
        with self._lock:
            return key in self._kept and self._kept[key].done()

    def made(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return a result; whoever asks while it is being made waits for the one who makes it."""
        future, mine = self._asked(key)
        if mine:
            self._make(key, future, make)
        return future.result()

    def _asked(self, key: Hashable) -> tuple[Future[T], bool]:
        """Return a result that is there or to come, and whether whoever asks has to make it."""
        with self._lock:
            mine = key not in self._kept
            future = self._kept.setdefault(key, Future())
            self._kept.move_to_end(key)
        return future, mine

    def _make(self, key: Hashable, future: Future[T], make: Callable[[], T]) -> None:
        """Make a result; what failed is tried again by the next who asks."""
        try:
            future.set_result(make())
        except BaseException as error:
            with self._lock:
                self._kept.pop(key, None)
            future.set_exception(error)
            if not isinstance(error, Exception):  # Ctrl-C
                raise
        else:
            self._let_go()

    def _let_go(self) -> None:
        """Let go of the least recently used, but for the last."""
        with self._lock:
            done = [(key, self._size(it.result())) for key, it in self._kept.items() if it.done()]
            size = sum(size for _, size in done)
            for key, own in done[:-1]:
                if size <= self.most_bytes and len(self._kept) <= self.most:
                    break
                del self._kept[key]
                size -= own

    def _size(self, result: T) -> int:
        """Return the bytes of a result that count."""
        return 0


class Cache(Latest[Kept]):
    """What was worked out, in files that go when their last reader has done."""

    def __init__(self, most_bytes: int = BYTES, most: int = FILES) -> None:
        super().__init__(most, most_bytes)
        self._aside = threading.Semaphore(ASIDE)

    def _size(self, result: Kept) -> int:
        return result.size

    def get(self, key: Hashable, job: Job, arguments: Mapping[str, Any], *, aside: bool) -> Kept:
        """Return what a job makes; whoever asks meanwhile waits for the one who makes it."""
        return self.begin(key, job, arguments, aside=aside).result()

    def begin(
        self, key: Hashable, job: Job, arguments: Mapping[str, Any], *, aside: bool
    ) -> Future[Kept]:
        """Begin a job unless it is done or under way: here and now, or `aside`, by a process."""
        future, mine = self._asked(key)
        run = self._process if aside else _here
        work = (key, future, lambda: _kept(lambda file: run(job, arguments, file)))
        if mine and aside:
            threading.Thread(target=self._make, args=work, daemon=True).start()
        elif mine:
            self._make(*work)
        return future

    def idle(self) -> bool:
        """Return whether a process could begin at once."""
        free = self._aside.acquire(blocking=False)
        if free:
            self._aside.release()
        return free

    def _process(self, job: Job, arguments: Mapping[str, Any], file: BinaryIO) -> None:
        """Have a job done by a process of its own."""
        call = {"path": sys.path, "module": job.__module__, "job": job.__name__}
        command = [sys.executable, "-c", _CHILD]
        # Not as an argument: other users read those, and a library's URL may hold a password
        line = json.dumps({**call, "arguments": arguments}).encode() + b"\n"
        pipe = subprocess.PIPE
        with (
            self._aside,
            subprocess.Popen(command, 0, stdin=pipe, stdout=file, stderr=pipe) as process,
        ):
            assert process.stdin is not None
            assert process.stderr is not None
            with suppress(BrokenPipeError):  # it has ended: told below
                process.stdin.write(line)
            said = process.stderr.read()
        if process.returncode == FAILED:
            kind, facts = json.loads(said.splitlines()[-1])
            raise getattr(errors, kind)(**facts)
        if process.returncode:
            lines = said.decode(errors="replace").splitlines()
            found = f"the process that read it ended ({process.returncode}): {''.join(lines[-1:])}"
            raise errors.ExportError(found, place=str(arguments.get("path", "")))


def _here(job: Job, arguments: Mapping[str, Any], file: BinaryIO) -> None:
    write(job(**arguments), file)


FAILED = 3
"""What the process ends with where the last line it wrote is an error."""

_CHILD = (
    "import json, sys; call = json.loads(sys.stdin.buffer.raw.readline()); "
    "sys.path[:] = call.pop('path'); "
    "from lanindex.pipeline.kept import child; child(**call)"
)


def _end_with_parent() -> None:
    """End this process when the one that began it does, which holds the other end of its input."""
    while os.read(0, 1 << 12):
        pass
    os._exit(1)


def child(module: str, job: str, arguments: Mapping[str, Any]) -> None:
    """Do a job: what the process runs."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if hasattr(os, "nice"):  # what is looked at meanwhile comes first
        os.nice(10)
    try:
        made = getattr(import_module(module), job)(**arguments)
    except errors.LanindexError as error:
        facts = {name: getattr(error, name) for name in ("found", "place", "wanted", "remedy")}
        sys.stderr.write(json.dumps((type(error).__name__, facts)) + "\n")
        sys.exit(FAILED)
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as file:
        write(made, file)


CACHE = Cache()
"""What this process keeps."""
