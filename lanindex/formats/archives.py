"""Captures in archives: ZIP and tar, read without unpacking to disk, and never more than is safe.

A member is called ``archive.zip!/folder/walk.bvh``. An archive within another is not opened.
"""

from __future__ import annotations

import atexit
import os
import re
import tarfile
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from lzma import LZMAError
from pathlib import PurePosixPath
from typing import TypeVar

from lanindex.errors import CaptureError

MARK = "!/"
"""Stands between an archive and what is in it."""

ZIPPED = (".zip",)
TARRED = (".tar", ".tar.gz", ".tgz", ".tar.bz2", ".tbz2", ".tar.xz", ".txz")

LARGEST = 1 << 30
"""Bytes of a member at most: it is held in memory."""

RATIO, FREE = 200, 64 << 20
"""How many times its own size what is in an archive may be, beyond so many bytes that it may."""

MANY = 1_000_000
"""Members at most."""

LONGEST = 1000
"""Letters of a member's name."""

_BYTE = re.compile(r"\\x([89a-f][0-9a-f])")

Info = TypeVar("Info")

_DAMAGED = (zipfile.BadZipFile, tarfile.TarError, zlib.error, LZMAError, EOFError, OSError,
            NotImplementedError, RuntimeError, ValueError, OverflowError)  # fmt: skip


def is_archive(path: str) -> bool:
    """Return whether a file's ending is an archive's."""
    return path.lower().endswith(ZIPPED + TARRED)


def native(path: str) -> str:
    r"""Return a path as the system spells it.

    Names that are no UTF-8 are shown, and kept in libraries, with ``\xff`` for such a byte.
    """
    if "\\x" not in path or os.path.lexists(path):
        return path
    return _BYTE.sub(lambda found: chr(0xDC00 + int(found[1], 16)), path)


def split(path: str) -> tuple[str, str]:
    """Return the archive and the member that a path names; ``("", "")`` where it names none.

    Examples
    --------
    >>> from lanindex.formats.archives import split
    >>> split("corpus/compass.bvh!/walk.bvh"), split("walk.bvh")
    (('', ''), ('', ''))
    """
    path = native(path) if MARK in path else path
    start = path.find(MARK)
    while start >= 0:
        if is_archive(path[:start]) and os.path.isfile(path[:start]):
            return path[:start], path[start + len(MARK) :]
        start = path.find(MARK, start + 1)
    return "", ""


@dataclass(slots=True)
class _Archive:
    """An archive that is open, and its members by name."""

    path: str
    state: tuple[int, int, int]
    file: zipfile.ZipFile | tarfile.TarFile
    members: Mapping[str, zipfile.ZipInfo | tarfile.TarInfo]
    last: tuple[str, bytes] = "", b""

    def content(self, name: str) -> bytes:
        """Return a member, which is kept: to go back in a packed tar is to unpack it anew."""
        if self.last[0] != name:
            self.last = name, self.read(name)
        return self.last[1]

    def read(self, name: str) -> bytes:
        info = self.members[name]
        size = info.file_size if isinstance(info, zipfile.ZipInfo) else info.size
        if size > LARGEST:
            raise _refused(self.path, f"{name} has {size >> 20} MB", f"{LARGEST >> 20} MB at most")
        if isinstance(self.file, zipfile.ZipFile):
            assert isinstance(info, zipfile.ZipInfo)
            if size > FREE and size > RATIO * max(info.compress_size, 1):
                raise _refused(self.path, f"{name} was packed {size} to {info.compress_size}",
                               f"{RATIO} to 1 at most")  # fmt: skip
            with self.file.open(info) as stream:
                data = stream.read(size + 1)
        else:
            assert isinstance(info, tarfile.TarInfo)
            taken = self.file.extractfile(info)
            data = taken.read(size + 1) if taken else b""
        if len(data) != size:
            raise CaptureError(f"{name} is cut short", place=self.path, wanted=f"{size} bytes")
        return data


_open: list[_Archive] = []
"""The archive that was read last: its members are read one after the other."""


def members(path: str) -> list[str]:
    """Return the names of the files in an archive, in the order in which to read them.

    Of a tar that is its own: what is read in another is unpacked again and again.
    """
    return list(_archive(path).members)


def member(path: str, name: str) -> bytes:
    """Return the content of a file in an archive."""
    archive = _archive(path)
    if name not in archive.members:
        raise CaptureError("there is no such file in the archive", place=path + MARK + name)
    try:
        return archive.content(name)
    except _DAMAGED as error:
        raise _damaged(path + MARK + name, error) from error


def _archive(path: str) -> _Archive:
    try:
        status = os.stat(path)
        state = status.st_ino, status.st_size, status.st_mtime_ns
        if _open and (_open[0].path, _open[0].state) == (path, state):
            return _open[0]
        _close()
        zipped = path.lower().endswith(ZIPPED)
        with ExitStack() as opening:  # it stays open for its other members, if all is well
            file: zipfile.ZipFile | tarfile.TarFile
            if zipped:
                file = opening.enter_context(zipfile.ZipFile(path))
            else:
                file = opening.enter_context(tarfile.open(path))
            archive = _Archive(path, state, file, _members(path, file, status.st_size))
            opening.pop_all()
        _open.append(archive)
    except _DAMAGED as error:
        raise _damaged(path, error) from error
    return archive


@atexit.register
def _close() -> None:
    while _open:
        with suppress(*_DAMAGED):
            _open.pop().file.close()


def _members(
    path: str, file: zipfile.ZipFile | tarfile.TarFile, size: int
) -> Mapping[str, zipfile.ZipInfo | tarfile.TarInfo]:
    if isinstance(file, zipfile.ZipFile):
        zipped = sorted(
            (info for info in file.infolist() if not info.is_dir()), key=lambda it: it.filename
        )
        return dict(_checked(path, ((info.filename, info) for info in zipped)))
    tarred = (info for info in _bounded(path, file, RATIO * size + FREE) if info.isfile())
    return dict(_checked(path, ((info.name, info) for info in tarred)))


def _bounded(path: str, file: tarfile.TarFile, most: int) -> Iterator[tarfile.TarInfo]:
    for info in file:
        if info.offset_data + info.size > most:
            raise _refused(path, f"{info.name} lies {info.offset_data + info.size >> 20} MB on",
                           f"{most >> 20} MB at most in an archive of its size")  # fmt: skip
        yield info


def _checked(path: str, named: Iterator[tuple[str, Info]]) -> Iterator[tuple[str, Info]]:
    for number, (name, info) in enumerate(named):
        if number >= MANY:
            raise _refused(path, f"more than {MANY} members", f"{MANY} at most")
        name = name.removeprefix("./")
        if len(name) > LONGEST or "\\" in name or not name.isprintable():
            raise _refused(path, f"a member called {name[:60]!r}", "a plain name")
        if name.startswith("/") or ".." in PurePosixPath(name).parts or name[1:2] == ":":
            raise _refused(path, f"a member called {name[:60]!r}", "a name that stays inside")
        yield name, info


def _refused(path: str, found: str, wanted: str) -> CaptureError:
    return CaptureError(found, place=path, wanted=wanted, remedy="Unpack it yourself, with care.")


def _damaged(path: str, error: Exception) -> CaptureError:
    return CaptureError(
        f"cannot be unpacked ({str(error)[:80] or type(error).__name__})",
        place=path,
        wanted="a ZIP or tar archive that is whole and not encrypted",
    )
