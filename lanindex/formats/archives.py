"""Captures in archives: ZIP and tar, read without unpacking to disk, and never more than is safe.

A member is called ``archive.zip!/folder/walk.bvh``. An archive within another is not opened.
"""

import atexit
import os
import re
import tarfile
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from lzma import LZMAError
from pathlib import PurePosixPath
from typing import Any, NamedTuple

from lanindex import locations
from lanindex.errors import CaptureError

MARK = "!/"  # stands between an archive and what is in it
ZIPPED = (".zip",)
TARRED = (".tar", ".tar.gz", ".tgz", ".tar.bz2", ".tbz2", ".tar.xz", ".txz")
LARGEST = 1 << 30  # bytes of a member at most: it is held in memory
RATIO, FREE = 200, 64 << 20  # how many times its own size an archive may hold, and bytes besides
MANY = 1_000_000  # members at most
LONGEST = 1000  # letters of a member's name

_BYTE = re.compile(r"\\x([89a-f][0-9a-f])")
_DAMAGED = (zipfile.BadZipFile, tarfile.TarError, zlib.error, LZMAError, EOFError, OSError,
            NotImplementedError, RuntimeError, ValueError, OverflowError)  # fmt: skip


def is_archive(path: str) -> bool:
    """Return whether a file's ending is an archive's."""
    return path.lower().endswith(ZIPPED + TARRED)


def native(path: str) -> str:
    r"""Return a path as the system spells it: a byte that is no UTF-8 is shown as ``\xff``."""
    if "\\x" not in path or locations.is_url(path) or os.path.lexists(path):
        return path
    return _BYTE.sub(lambda found: chr(0xDC00 + int(found[1], 16)), path)


def split(path: str) -> tuple[str, str]:
    """Return the archive and the member that a path names; ``("", "")`` where it names none."""
    path = native(path) if MARK in path else path
    start = path.find(MARK)
    while start >= 0:
        if is_archive(path[:start]) and locations.is_file(path[:start]):
            return path[:start], path[start + len(MARK) :]
        start = path.find(MARK, start + 1)
    return "", ""


class _Member(NamedTuple):
    size: int
    packed: int  # bytes in the archive; of a tar, which is packed as a whole, as many as `size`
    info: Any  # what `zipfile` or `tarfile` opens it by


@dataclass(slots=True)
class _Archive:
    """An archive that is open, and its members by name."""

    path: str
    state: locations.Mark
    file: Any  # a `zipfile.ZipFile` or a `tarfile.TarFile`
    members: Mapping[str, _Member]
    last: tuple[str, bytes] = "", b""

    def content(self, name: str) -> bytes:
        """Return a member, which is kept: to go back in a packed tar is to unpack it anew."""
        if self.last[0] != name:
            self.last = name, self._read(name)
        return self.last[1]

    def _read(self, name: str) -> bytes:
        size, packed, info = self.members[name]
        if size > LARGEST:
            raise _refusal(self.path, f"{name} has {size >> 20} MB", f"{LARGEST >> 20} MB at most")
        if size > FREE and size > RATIO * max(packed, 1):
            found = f"{name} was packed {size} to {packed}"
            raise _refusal(self.path, found, f"{RATIO} to 1 at most")
        zipped = isinstance(self.file, zipfile.ZipFile)
        opened: Any = self.file.open if zipped else self.file.extractfile
        with opened(info) as stream:
            data: bytes = stream.read(size + 1)
        if len(data) != size:
            raise CaptureError(f"{name} is cut short", place=self.path, wanted=f"{size} bytes")
        return data


_open: list[_Archive] = []
"""The archive that was read last: its members are read one after the other."""


def members(path: str) -> list[str]:
    """Return the names of an archive's files, a tar's in stored order: it is unpacked once."""
    return list(_archive(path).members)


def member(path: str, name: str) -> bytes:
    """Return the content of a file in an archive."""
    archive = _archive(path)
    if name not in archive.members:
        raise CaptureError("there is no such file in the archive", place=path + MARK + name)
    try:
        return archive.content(name)
    except _DAMAGED as error:
        raise _damage(path + MARK + name, error) from error


def _archive(path: str) -> _Archive:
    try:
        state = locations.mark(path)
        if _open and (_open[0].path, _open[0].state) == (path, state):
            return _open[0]
        _close()
        opened: Callable[[str], Any] = (
            zipfile.ZipFile if path.lower().endswith(ZIPPED) else tarfile.open
        )
        of_disk = locations.local(path)
        with ExitStack() as opening:  # it stays open for its other members, if all is well
            file = opening.enter_context(opened(of_disk))
            archive = _Archive(path, state, file, _members(path, file, os.stat(of_disk).st_size))
            opening.pop_all()
        _open.append(archive)
    except _DAMAGED as error:
        raise _damage(path, error) from error
    return archive


@atexit.register
def _close() -> None:
    while _open:
        with suppress(*_DAMAGED):
            _open.pop().file.close()


def _members(
    path: str, file: zipfile.ZipFile | tarfile.TarFile, size: int
) -> Mapping[str, _Member]:
    """Return the members that are files, by names that are safe."""
    found = dict[str, _Member]()
    for number, (name, member) in enumerate(_listed_members(path, file, size)):
        if number >= MANY:
            raise _refusal(path, f"more than {MANY} members", f"{MANY} at most")
        name = name.removeprefix("./")
        if len(name) > LONGEST or "\\" in name or not name.isprintable():
            raise _refusal(path, f"a member called {name[:60]!r}", "a plain name")
        if name.startswith("/") or ".." in PurePosixPath(name).parts or name[1:2] == ":":
            raise _refusal(path, f"a member called {name[:60]!r}", "a name that stays inside")
        found[name] = member
    return found


def _listed_members(
    path: str, file: zipfile.ZipFile | tarfile.TarFile, size: int
) -> Iterator[tuple[str, _Member]]:
    if isinstance(file, zipfile.ZipFile):
        for zipped in sorted(file.infolist(), key=lambda info: info.filename):
            if not zipped.is_dir():
                yield zipped.filename, _Member(zipped.file_size, zipped.compress_size, zipped)
        return
    most = RATIO * size + FREE
    for info in file:
        if (stop := info.offset_data + info.size) > most:
            found = f"{info.name} lies {stop >> 20} MB on"
            raise _refusal(path, found, f"{most >> 20} MB at most in an archive of its size")
        if info.isfile():
            yield info.name, _Member(info.size, info.size, info)


def _refusal(path: str, found: str, wanted: str) -> CaptureError:
    return CaptureError(found, place=path, wanted=wanted, remedy="Unpack it yourself, with care.")


def _damage(path: str, error: Exception) -> CaptureError:
    return CaptureError(
        f"cannot be unpacked ({str(error)[:80] or type(error).__name__})",
        place=path,
        wanted="a ZIP or tar archive that is whole and not encrypted",
    )
