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
from dataclasses import dataclass, field
from importlib import import_module
from tempfile import TemporaryFile
from typing import Any, BinaryIO
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


def _read(file: BinaryIO) -> Kept:
    """Return what was written into a file."""
    file.seek(0)
    line = file.readline()
    head, offset, arrays = json.loads(line), len(line), {}
    for name, (kind, shape) in head["arrays"].items():
        arrays[name] = np.dtype(kind), tuple(shape), offset
        offset += int(np.prod(shape, dtype=np.int64)) * np.dtype(kind).itemsize
    return Kept(head["about"], offset, file, arrays)


class Cache:
    """What was worked out, by what it was worked out from; the least recently used is let go."""

    def __init__(self, most_bytes: int = BYTES, most: int = FILES) -> None:
        self.most_bytes, self.most = most_bytes, most
        self._lock, self._aside = threading.Lock(), threading.Semaphore(ASIDE)
        self._kept: OrderedDict[Hashable, Future[Kept]] = OrderedDict()

    def __len__(self) -> int:
        """Return how many are kept or being worked out."""
        return len(self._kept)

    def holds(self, key: Hashable) -> bool:
        """Return whether something is worked out."""
        with self._lock:
            return key in self._kept and self._kept[key].done()

    def get(self, key: Hashable, job: Job, arguments: Mapping[str, Any], *, aside: bool) -> Kept:
        """Return what a job makes; whoever asks meanwhile waits for the one who makes it."""
        return self.begin(key, job, arguments, aside=aside).result()

    def begin(
        self, key: Hashable, job: Job, arguments: Mapping[str, Any], *, aside: bool
    ) -> Future[Kept]:
        """Begin a job unless it is done or under way: here and now, or `aside`, by a process."""
        with self._lock:
            future, mine = self._kept.get(key), key not in self._kept
            if future is None:
                future = self._kept[key] = Future[Kept]()
            self._kept.move_to_end(key)
        work = (key, future, job, arguments)
        if mine and aside:
            threading.Thread(target=self._make, args=(*work, self._process), daemon=True).start()
        elif mine:
            self._make(*work, _here)
        return future

    def _make(
        self,
        key: Hashable,
        future: Future[Kept],
        job: Job,
        arguments: Mapping[str, Any],
        run: Callable[[Job, Mapping[str, Any], BinaryIO], None],
    ) -> None:
        """Do a job; what failed is tried again by the next who asks."""
        file: Any = TemporaryFile(buffering=0)  # noqa: SIM115 (closed with what is kept in it)
        try:
            run(job, arguments, file)
            future.set_result(_read(file))
        except BaseException as error:
            file.close()
            with self._lock:
                self._kept.pop(key, None)
            future.set_exception(error)
            if not isinstance(error, Exception):  # Ctrl-C
                raise
        else:
            self._let_go()

    def _let_go(self) -> None:
        """Let go of the least recently used; a file goes when its last reader has done."""
        with self._lock:
            done = [(key, it.result()) for key, it in self._kept.items() if it.done()]
            size = sum(kept.size for _, kept in done)
            for key, kept in done[:-1]:
                if size <= self.most_bytes and len(self._kept) <= self.most:
                    break
                del self._kept[key]
                size -= kept.size

    def _process(self, job: Job, arguments: Mapping[str, Any], file: BinaryIO) -> None:
        """Have a job done by a process of its own."""
        call = {"path": sys.path, "module": job.__module__, "job": job.__name__}
        command = [sys.executable, "-c", _CHILD, json.dumps({**call, "arguments": arguments})]
        with self._aside:
            done = subprocess.run(
                command, stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.PIPE, check=False
            )
        if done.returncode == FAILED:
            kind, facts = json.loads(done.stderr.splitlines()[-1])
            raise getattr(errors, kind)(**facts)
        if done.returncode:
            lines = done.stderr.decode(errors="replace").splitlines()
            found = f"the process that read it ended ({done.returncode}): {''.join(lines[-1:])}"
            raise errors.ExportError(found, place=str(arguments.get("path", "")))


def _here(job: Job, arguments: Mapping[str, Any], file: BinaryIO) -> None:
    write(job(**arguments), file)


FAILED = 3
"""What the process ends with where the last line it wrote is an error."""

_CHILD = (
    "import json, sys; call = json.loads(sys.argv[1]); sys.path[:] = call.pop('path'); "
    "from lanindex.pipeline.kept import child; child(**call)"
)


def child(module: str, job: str, arguments: Mapping[str, Any]) -> None:
    """Do a job: what the process runs."""
    try:
        made = getattr(import_module(module), job)(**arguments)
    except errors.LanindexError as error:
        facts = {name: getattr(error, name) for name in ("found", "place", "wanted", "remedy")}
        print(json.dumps((type(error).__name__, facts)), file=sys.stderr)
        sys.exit(FAILED)
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as file:
        write(made, file)


CACHE = Cache()
"""What this process keeps."""
