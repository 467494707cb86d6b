"""Columns of segments in files that many machines can read: in a folder, or in a bucket.

A file holds the columns of one segment one after the other, each at a multiple of 64 bytes; where,
the segment's listing says. Its name is the sha256 of its bytes. It is written under another name,
is whole on the disk before it gets its own, and only then does a row of ``segment`` name it. It is
never changed, so readers share it without asking each other.

Files are read, not mapped into memory: a mapped file that is cut short, or deleted by another
machine, ends the process that looks at it. What is read is checked block by block, each time, so
that a stretch is read and checked without the rest, and no reader has to remember what was checked.
A file of a bucket is fetched whole, checked by its name on the way, and kept in a folder that all
processes of a machine share.

Whoever takes a segment out lists its file in ``segment_old``. `collect` deletes it when no reader
can need it any more.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError, LibraryError, UsageError, counted
from lanindex.library.connect import ask, dialect_of, first_values, insert
from lanindex.library.dialect import Link
from lanindex.library.selection import printable
from lanindex.locations import asking, copies, is_url, plain

ALIGNED = 64
"""Bytes at a multiple of which a column begins."""

SUFFIX = ".columns"

_NAME = re.compile(rf"[0-9a-f]{{64}}\{SUFFIX}")
_DRAFT = ".part"

_SPARED = 3600
"""Seconds for which a file stays that no segment names: somebody may be about to."""

_WAITED = 30
"""Seconds until a bucket that could not be reached is tried again: to find out takes some, too."""

MOST_CACHED = 32 << 30
"""Bytes of files of buckets that a machine keeps, at most, but for the last one."""

_CHUNK = 1 << 20

_CLAIM = ""
"""In place of a file's name: a move to this place has begun."""

_FORGET = "DELETE FROM segment_old WHERE place = :place AND name = :name"

_WHOLE = "What was stored before is whole; run again when it can be written."


class Distrust(LibraryError):
    """The segments are not those of the rows; they must be made anew."""


class Unreachable(Distrust):
    """The files of the segments are out of reach; it is not known whether they are whole."""

    def __init__(self, found: str, remedy: str = "") -> None:
        remedy = remedy or "Bring it back."
        remedy += " Or keep the columns in the library: lanindex db segments --inside"
        super().__init__(f"out of reach: {found}", remedy=remedy)


class _NoCopy(LibraryError):
    """There is no copy of a file of a bucket, and none can be made."""


class Shelf(Protocol):
    """Where files of segments are."""

    def write(self, contents: Iterable[memoryview | bytes]) -> str:
        """Write columns, one after the other, and return the name of their file."""

    def read(self, name: str, start: int, stop: int) -> NDArray[np.uint8]:
        """Return some bytes of a file: (N,) uint8."""

    def check(self, name: str) -> None:
        """Raise `Distrust` if a file is not what its name says."""

    def forget(self, name: str) -> bool:
        """Delete a copy of a file, and return whether there was one."""

    def remove(self, name: str) -> None:
        """Delete a file; it may be gone already."""

    def names(self) -> list[str]:
        """Return the names of all files of segments, and of drafts that were broken off."""

    def ages(self, names: Collection[str]) -> dict[str, float]:
        """Return the seconds since some files were written, by the clock of where they are."""


def aligned(contents: Iterable[memoryview | bytes]) -> Iterator[memoryview | bytes]:
    """Yield columns with zeros between them, so that each begins where `begin_of` says."""
    end = 0
    for content in contents:
        yield bytes(-end % ALIGNED)
        yield content
        end = begin_of(end) + len(content)


def begin_of(end: int) -> int:
    """Return the byte at which a column begins; `end` is the one at which the last one ends."""
    return end + -end % ALIGNED


@contextmanager
def _unreachable(place: str) -> Iterator[None]:
    """Turn an error of the system into `Unreachable`."""
    try:
        yield
    except OSError as error:
        raise Unreachable(f"{place} cannot be read ({error.strerror or error})") from error


@contextmanager
def _unwritable(place: str, kind: type[LibraryError] = LibraryError) -> Iterator[None]:
    """Turn an error of the system into one that says what could not be written."""
    try:
        yield
    except OSError as error:
        raise kind(error.strerror or str(error), place=place, remedy=_WHOLE) from error


class Folder:
    """A folder of files of segments."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def write(self, contents: Iterable[memoryview | bytes]) -> str:
        """Write columns, one after the other, and return the name of their file."""
        return self.keep(aligned(contents))

    def keep(self, pieces: Iterable[memoryview | bytes], wanted: str | None = None) -> str:
        """Write a file, whole or not at all, and return its name; refuse one not as `wanted`."""
        from hashlib import sha256  # late: searches of rows need none

        draft, digest = self.path / f"{os.urandom(16).hex()}{_DRAFT}", sha256()
        with _unwritable(str(self.path)):
            try:
                with open(draft, "xb") as file:
                    for piece in pieces:
                        digest.update(piece)
                        file.write(piece)
                    file.flush()
                    os.fsync(file.fileno())
                name = f"{digest.hexdigest()}{SUFFIX}"
                if wanted not in (None, name):
                    raise Distrust(f"damaged: the file {wanted} is not what its name says")
                os.replace(draft, self.path / name)
            except BaseException:
                draft.unlink(missing_ok=True)
                raise
            with suppress(OSError):  # Where a folder can be flushed, its new name is kept, too
                folder = os.open(self.path, os.O_RDONLY)
                try:
                    os.fsync(folder)
                finally:
                    os.close(folder)
        return name

    def read(self, name: str, start: int, stop: int) -> NDArray[np.uint8]:
        """Return some bytes of a file: (N,) uint8."""
        content, filled = np.empty(stop - start, np.uint8), 0
        with self._open(name) as file, _unreachable(str(self.path)):
            file.seek(start)
            while filled < len(content):
                count = file.readinto(content[filled:].data)
                if not count:
                    raise Distrust(f"damaged: the file {self.path / name} is cut short")
                filled += count
        return content

    def check(self, name: str) -> None:
        """Raise `Distrust` if a file is not what its name says."""
        with self._open(name) as file, _unreachable(str(self.path)):
            _check_digest(name, file, str(self.path / name))

    def _open(self, name: str) -> Any:
        with _unreachable(str(self.path)):
            try:
                return open(self.path / name, "rb", buffering=0)
            except FileNotFoundError:
                if not self.path.is_dir():
                    raise Unreachable(f"there is no folder {self.path}") from None
        raise Distrust(f"damaged: there is no file {self.path / name}")

    def forget(self, name: str) -> bool:
        """Delete a copy of a file: these are no copies."""
        return False

    def remove(self, name: str) -> None:
        """Delete a file; it may be gone already."""
        with _unwritable(str(self.path)):
            (self.path / name).unlink(missing_ok=True)

    def names(self) -> list[str]:
        """Return the names of all files of segments, and of drafts that were broken off."""
        with _unreachable(str(self.path)):
            return [name for name in os.listdir(self.path) if _is_ours(name)]

    def ages(self, names: Collection[str]) -> dict[str, float]:
        """Return the seconds since some files were written, by the clock of the disk."""
        draft, ages = self.path / f"{os.urandom(16).hex()}{_DRAFT}", {}
        with _unwritable(str(self.path)):
            draft.touch()  # A server's clock may differ from this machine's
            now = draft.stat().st_mtime
            draft.unlink()
            for name in names:
                with suppress(FileNotFoundError):
                    ages[name] = now - (self.path / name).stat().st_mtime
        return ages


class Cache(Folder):
    """Copies of files of buckets, which all processes of a machine share.

    The least recently used go when there are too many. Whoever reads one at that moment reads on,
    and fetches it again the next time.
    """

    def keep(self, pieces: Iterable[memoryview | bytes], wanted: str | None = None) -> str:
        """Write a copy, whole or not at all, and return its name; refuse one not as `wanted`."""
        try:
            return super().keep(pieces, wanted)
        except Distrust:
            raise
        except LibraryError as error:
            raise _NoCopy(error.found, place=error.place, remedy=error.remedy) from error

    def read(self, name: str, start: int, stop: int) -> NDArray[np.uint8]:
        """Return some bytes of a copy: (N,) uint8."""
        try:
            content = super().read(name, start, stop)
        except Distrust as error:  # It is cut short, or has just made room for another one
            with suppress(OSError):
                (self.path / name).unlink()
            raise _NoCopy(error.found) from error
        with suppress(OSError):
            os.utime(self.path / name)
        return content

    @contextmanager
    def turn(self, name: str) -> Iterator[None]:
        """Let one process at a time fetch a file, where the system can do that."""
        try:
            from fcntl import LOCK_EX, flock
        except ImportError:
            yield
            return
        with _unwritable(str(self.path), _NoCopy):
            lock = open(self.path / f"{name[:2]}.lock", "ab")  # noqa: SIM115 (closed below)
        with lock:
            flock(lock, LOCK_EX)
            yield

    def make_room(self, newest: str) -> None:
        """Delete the least recently used copies, but for the newest, while there are too many."""
        with suppress(OSError):
            stats = {name: (self.path / name).stat() for name in self.names() if name != newest}
            total = sum(one.st_size for one in stats.values())
            total += (self.path / newest).stat().st_size
            for name in sorted(stats, key=lambda name: stats[name].st_mtime):
                if total <= MOST_CACHED:
                    break
                # A draft is being written, unless whoever wrote it was killed
                if _NAME.fullmatch(name) or time.time() - stats[name].st_mtime > _SPARED:
                    (self.path / name).unlink()
                    total -= stats[name].st_size


class Bucket:
    """Files of segments at a URL that fsspec understands."""

    def __init__(self, url: str) -> None:
        self.url = url.rstrip("/")
        self._down, self._until = Unreachable(""), 0.0

    @contextmanager
    def _asking(self) -> Iterator[tuple[Any, str]]:
        """Open the store, or raise `Unreachable`; for a while do not try it again then."""
        if time.monotonic() < self._until:
            raise self._down
        try:
            with asking(self.url) as (system, root):
                yield system, root.rstrip("/")
        except CaptureError as error:
            self._down = Unreachable(f"{error.place}: {error.found}", error.remedy)
            self._until = time.monotonic() + _WAITED
            raise self._down from error

    @contextmanager
    def _found(self, name: str) -> Iterator[tuple[Any, str]]:
        """Open the store, and yield where a file is in it; one that is not there is `Distrust`."""
        try:
            with self._asking() as (system, root):
                yield system, f"{root}/{name}"
        except FileNotFoundError:
            raise Distrust(f"damaged: there is no file {self.url}/{name}") from None

    def write(self, contents: Iterable[memoryview | bytes]) -> str:
        """Write columns, one after the other, and return the name of their file."""
        cache = _cache()
        name = cache.write(contents)
        try:
            with self._asking() as (system, root):
                system.put_file(str(cache.path / name), f"{root}/{name}")
        except FileNotFoundError as error:
            raise LibraryError("there is no such bucket", place=self.url, remedy=_WHOLE) from error
        except Unreachable as error:
            raise LibraryError(error.found, remedy=_WHOLE) from error
        cache.make_room(name)
        return name

    def read(self, name: str, start: int, stop: int) -> NDArray[np.uint8]:
        """Return some bytes of a file: (N,) uint8."""
        with suppress(_NoCopy):
            return self._fetched(name).read(name, start, stop)
        with self._found(name) as (system, path):
            content: bytes = system.cat_file(path, start=start, end=stop)
        if len(content) != stop - start:
            raise Distrust(f"damaged: the file {self.url}/{name} is cut short")
        return np.frombuffer(content, np.uint8)

    def _fetched(self, name: str) -> Cache:
        """Return the folder of copies, with one of this file."""
        cache = _cache()
        if not (cache.path / name).exists():
            with cache.turn(name):
                if not (cache.path / name).exists():  # nobody has fetched it meanwhile
                    with self._found(name) as (system, path), system.open(path, "rb") as file:
                        cache.keep(iter(lambda: file.read(_CHUNK), b""), name)
                    cache.make_room(name)
        return cache

    def check(self, name: str) -> None:
        """Raise `Distrust` if a file is not what its name says."""
        with self._found(name) as (system, path), system.open(path, "rb") as file:
            _check_digest(name, file, f"{self.url}/{name}")

    def forget(self, name: str) -> bool:
        """Delete the copy of a file, and return whether there was one."""
        with suppress(LibraryError, OSError):
            (_cache().path / name).unlink()
            return True
        return False

    def remove(self, name: str) -> None:
        """Delete a file; it may be gone already."""
        with suppress(FileNotFoundError), self._asking() as (system, root):
            system.rm_file(f"{root}/{name}")
        self.forget(name)

    def names(self) -> list[str]:
        """Return the names of all files of segments, and of drafts that were broken off."""
        with suppress(FileNotFoundError), self._asking() as (system, root):
            listed = [path.rpartition("/")[2] for path in system.ls(root, detail=False)]
            return [name for name in listed if _is_ours(name)]
        return []

    def ages(self, names: Collection[str]) -> dict[str, float]:
        """Return the seconds since some files were written, by the clock of the bucket."""
        ages = {}
        with self._asking() as (system, root):
            draft = f"{root}/{os.urandom(16).hex()}{_DRAFT}"
            system.pipe_file(draft, b"now")
            now = system.modified(draft)
            system.rm_file(draft)
            for name in names:
                with suppress(FileNotFoundError):
                    ages[name] = (now - system.modified(f"{root}/{name}")).total_seconds()
        return ages


def _is_ours(name: str) -> bool:
    """Return whether a name is that of a file of a segment, or of a draft of one."""
    return _NAME.fullmatch(name) is not None or name.endswith(_DRAFT)


def _is_path(value: Any) -> bool:
    """Return whether a value of a database that may be damaged can be looked for on a disk."""
    return isinstance(value, str) and value.isprintable()


def _check_digest(name: str, file: Any, shown: str) -> None:
    from hashlib import file_digest

    if f"{file_digest(file, 'sha256').hexdigest()}{SUFFIX}" != name:
        raise Distrust(f"damaged: the file {shown} is not what its name says")


def _cache() -> Cache:
    """Return the folder of copies."""
    path = copies("segments")
    with _unwritable(str(path), _NoCopy):
        path.mkdir(parents=True, exist_ok=True)
    return Cache(path)


@lru_cache(maxsize=16)
def shelf_of(place: str) -> Shelf:
    """Return what reads and writes the files at a place: a folder or a URL."""
    return Bucket(place) if is_url(place) else Folder(Path(place))


def current_place(connection: Link) -> str:
    """Return where the files of segments are, an absolute folder or a URL; empty: there are none.

    The columns are in the database then.
    """
    (where,) = ask(connection, "SELECT segments FROM state").fetchone() or (None,)
    return absolute_place(connection, where) if where and _is_path(where) else ""


def absolute_place(connection: Link, where: str) -> str:
    """Return the folder that is named from the one of the library's file; a URL as it is."""
    where = plain(where)
    if is_url(where) or os.path.isabs(where):
        return where
    folder = dialect_of(connection).folder(connection)
    if folder is None:
        raise LibraryError(
            "the library is no file, so there is nothing beside it",
            place=where,
            wanted="an absolute folder, or a URL",
        )
    return os.path.abspath(folder / where)


def set_place(connection: Link, where: str) -> None:
    """Let files of segments be at a place from now on; empty: let columns be in the database."""
    ask(connection, f"DELETE FROM segment_old WHERE name = '{_CLAIM}'")
    ask(connection, "UPDATE state SET segments = :where", {"where": where or None})


def claim(connection: Link, where: str) -> None:
    """Make a place ready to take the files of a library, and refuse that of another library.

    Goes into a transaction of its own: a move that is broken off leaves files there, and the next
    one has to know whose they are.
    """
    if not _is_path(where):
        found, wanted = "the name has letters that cannot be printed", "another folder, or a URL"
        raise UsageError(found, place=printable(where), wanted=wanted)
    place = absolute_place(connection, where)
    if not is_url(place):
        try:
            os.makedirs(place, exist_ok=True)
        except OSError as error:
            found = f"no folder can be made there ({error.strerror})"
            raise LibraryError(found, place=place, wanted="a folder, or a URL") from error
    strange = {*filter(_NAME.fullmatch, shelf_of(place).names())}
    old = ask(connection, "SELECT name FROM segment_old WHERE place = :place", {"place": place})
    known = {*first_values(old)}
    if _CLAIM not in known and place != current_place(connection) and (strange := strange - known):
        raise UsageError(
            f"{counted(len(strange), 'file')} of segments that this library does not name",
            place=place,
            wanted="a place for this library alone",
            remedy="Name another folder, or delete them if no library needs them.",
        )
    if _CLAIM not in known:
        insert(connection, "segment_old", ["place", "name", "since"], [(place, _CLAIM, 0)])


def retire(connection: Link, place: str, names: Iterable[str]) -> None:
    """Note that files are named by no segment any more, from this transaction on."""
    named = [{"place": place, "name": name} for name in names if _NAME.fullmatch(name)]
    if not named:
        return
    ask(connection, _FORGET, named)
    now = dialect_of(connection).moment(connection)
    rows = [(*one.values(), now) for one in named]
    insert(connection, "segment_old", ["place", "name", "since"], rows)


def collect(connection: Link) -> None:
    """Delete the files that no segment names and no reader can need.

    Goes into a transaction that writes, and takes nothing out of segments itself.
    """
    place = current_place(connection)
    asked = "SELECT place, name, since FROM segment_old"
    old = {(where, name): since for where, name, since in ask(connection, asked).fetchall()}
    if not place and not old:
        return
    asked = "SELECT file FROM segment WHERE file IS NOT NULL"
    named = {(place, name) for name in first_values(ask(connection, asked))}
    before = dialect_of(connection).oldest_reader(connection, _SPARED)
    for (where, name), since in old.items():
        sane = _is_path(where) and _is_path(name) and isinstance(since, int)
        if sane and _NAME.fullmatch(name) and since < before:
            with suppress(LibraryError):  # It cannot be deleted now: the next time
                if (where, name) not in named:
                    shelf_of(where).remove(name)
                ask(connection, _FORGET, {"place": where, "name": name})
    if place:
        with suppress(LibraryError):
            shelf = shelf_of(place)
            known = {name for where, name in (*named, *old) if where == place}
            loose = [name for name in shelf.names() if name not in known]
            for name, age in (shelf.ages(loose) if loose else {}).items():
                if age > _SPARED:
                    shelf.remove(name)
