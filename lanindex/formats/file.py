"""Bytes with a name, from wherever they come; of a large file never all at once."""

from __future__ import annotations

import hashlib
import io
import os
import stat
import threading
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any, Protocol, TypeVar

from lanindex import locations
from lanindex.errors import CaptureError
from lanindex.formats import archives

T = TypeVar("T")

WHOLE = 32 << 20
"""Bytes up to which a file of the disk is held whole."""

PIECE = 1 << 20
"""Bytes of a file that are held at a time where it is gone through."""

SMALL = 8 << 20
"""Bytes up to which a file of a store is fetched whole: to ask for parts takes as long."""

FETCHED = 1 << 19
"""Bytes of a file of a store that are fetched at once where fewer are asked."""

KEPT = 16
"""Such pieces of a file that are kept."""

NEAR = 1 << 15
"""Bytes between two stretches of a file of a store that are fetched too: to ask twice is slower."""


class Content(Protocol):
    """What `bytes` can do that a reader may ask for: a length, and slices, which are bytes."""

    def __len__(self) -> int:
        """Return how many bytes there are."""

    def __getitem__(self, piece: slice, /) -> bytes:
        """Return some of them."""


@dataclass(frozen=True, slots=True)
class File:
    """A capture file's bytes, and its name: on a disk, in an archive, from a network."""

    name: str  # a path, as given; messages show it
    content: Content  # all of it; ``content[:]`` has it in memory
    # whom of several people in it is meant, where that is named; its name ends with it
    subject: str = ""
    # what its store says that tells it from all other versions; empty where nothing does
    version: str = ""
    # results computed from the content, by their function: the same for each of its people
    results: dict[Callable[..., Any], Any] = field(default_factory=dict, repr=False, compare=False)

    def once(self, make: Callable[[File], T]) -> T:
        """Return what is made of the content, whoever in it is meant: made once, then kept."""
        if make not in self.results:
            self.results[make] = make(self)
        result: T = self.results[make]
        return result

    def sha256(self) -> str:
        """Return what tells this content from any other."""
        digest = hashlib.sha256()
        for start in range(0, len(self.content), PIECE):
            digest.update(self.content[start : start + PIECE])
        return digest.hexdigest()


def together(files: Iterable[File]) -> str:
    """Return what tells the content of some files from any other; empty where there are none."""
    each = "".join(file.sha256() for file in files)
    return hashlib.sha256(each.encode()).hexdigest() if each else ""


def holding(content: Content, first: int, stop: int) -> tuple[bytes, int]:
    """Return bytes that hold a stretch of some, and which of them is their first."""
    # what is in memory is not copied: of a small file that costs as much as to read it
    return (content, 0) if isinstance(content, bytes) else (content[first:stop], first)


def several(content: Content, pieces: Sequence[tuple[int, int]]) -> list[bytes]:
    """Return stretches of a file (first byte, last + 1; rising)."""
    if isinstance(content, _InStore):
        return content.several(pieces)
    return [content[start:stop] for start, stop in pieces]


def line_of(data: Content, offset: int) -> int:
    """Return the line, counted from 1, that holds a byte; any of the three line ends counts."""
    line, before = 1, b""
    for start in range(0, offset, PIECE):
        piece = data[start : min(start + PIECE, offset)]
        line += piece.count(b"\n") + piece.count(b"\r") - piece.count(b"\r\n")
        line -= before == b"\r" and piece[:1] == b"\n"
        before = piece[-1:]
    return line


def text_of(word: bytes) -> str:
    """Return a name or a damaged word as text that can be printed."""
    try:
        return word.decode()
    except UnicodeDecodeError:
        return word.decode("latin-1")


def clip(content: Content, pieces: Iterable[bytes | tuple[int, int]]) -> bytes:
    """Return new bytes and stretches of a file (first byte, last + 1; rising), put together."""
    out, held, begin = io.BytesIO(), memoryview(b""), 0
    for piece in pieces:
        if isinstance(piece, bytes):
            out.write(piece)
            continue
        at, stop = piece
        while at < stop:
            if not begin <= at < begin + len(held):
                data, begin = holding(content, at, min(at + PIECE, len(content)))
                held = memoryview(data)
            end = min(stop, begin + len(held))
            out.write(held[at - begin : end - begin])
            at = end
    return out.getvalue()


@dataclass(frozen=True, slots=True)
class Wanted:
    """What a motion is read for."""

    body_only: bool = False  # whether the joints of the body will do; else all of the file
    # the frames that will do, from and to, where a format has ``frames``
    frames: tuple[int, int] | None = None


class _OnDisk:
    """A file's bytes, fetched from the disk slice by slice.

    It is opened for each slice, so that nothing has to be closed; if another program changes it
    meanwhile, it is refused. The copy of a URL never changes, and is made again if it was let go.
    """

    def __init__(self, location: str, status: os.stat_result, of_url: locations.Mark) -> None:
        self._location, self._of_url, self._size = location, of_url, status.st_size
        self._mark = locations.mark_of(status)

    def __len__(self) -> int:
        return self._size

    def __getitem__(self, piece: slice, /) -> bytes:
        start, stop, _ = piece.indices(self._size)
        try:
            url, where = self._of_url, self._location
            with open(locations.copy_of(where, url) if url else where, "rb") as file:
                same = url or locations.mark_of(os.fstat(file.fileno())) == self._mark
                file.seek(start)
                data = file.read(max(stop - start, 0))
        except OSError as error:
            raise _error(self._location, error) from error
        if not same or len(data) < stop - start:
            raise locations.changed(self._location)
        return data


class _InStore:
    """A file's bytes, fetched from its store piece by piece; all, once a quarter of them was.

    A piece of another version is refused.
    """

    def __init__(self, url: str, mark: locations.Mark, size: int) -> None:
        self._url, self._mark, self._size, self._fetched = url, mark, size, 0
        self._pieces = dict[int, bytes]()  # by number, the last used last
        self._whole: _OnDisk | None = None
        self._turn = threading.Lock()

    def __len__(self) -> int:
        return self._size

    def __getitem__(self, piece: slice, /) -> bytes:
        start, stop, _ = piece.indices(self._size)
        first, end = start // FETCHED, -(-stop // FETCHED)
        try:
            with self._turn:
                if stop - start > FETCHED:  # one question instead of several
                    return self._part(start, stop)
                data = b"".join(map(self._piece, range(first, end)))
        except OSError as error:
            raise _error(self._url, error) from error
        return data[start - first * FETCHED : stop - first * FETCHED]

    def _piece(self, number: int) -> bytes:
        data = self._pieces.pop(number, None)
        if data is None:
            data = self._part(number * FETCHED, min((number + 1) * FETCHED, self._size))
        self._pieces[number] = data
        if len(self._pieces) > KEPT:
            del self._pieces[next(iter(self._pieces))]
        return data

    def _part(self, start: int, stop: int) -> bytes:
        return self._parts([(start, stop)])[0]

    def _parts(self, ranges: list[tuple[int, int]]) -> list[bytes]:
        if self._whole is None:
            self._fetched += sum(stop - start for start, stop in ranges)
            if self._fetched <= self._size // 4:
                data = locations.parts(self._url, self._mark, ranges)
                if data is not None:
                    return data
            status = os.stat(locations.copy_of(self._url, self._mark))
            self._whole = _OnDisk(self._url, status, self._mark)
        return [self._whole[start:stop] for start, stop in ranges]

    def several(self, pieces: Sequence[tuple[int, int]]) -> list[bytes]:
        """Return stretches, rising, all of which are asked for at once."""
        joined: list[tuple[int, int]] = []
        for start, stop in pieces:
            if joined and start - joined[-1][1] <= NEAR:
                joined[-1] = joined[-1][0], stop
            else:
                joined.append((start, stop))
        try:
            with self._turn:
                held = self._parts(joined)
        except OSError as error:
            raise _error(self._url, error) from error
        begins = [start for start, _ in joined]
        places = [bisect_right(begins, start) - 1 for start, _ in pieces]
        return [
            held[place][start - begins[place] : stop - begins[place]]
            for place, (start, stop) in zip(places, pieces, strict=True)
        ]


SUBJECT = "#"
"""Stands in a capture's name between its file and whom of several people in it is meant."""


def on_disk(path: str) -> str:
    """Return the file that holds a capture: an archive, or what several people share."""
    return archives.split(path)[0] or _of_subject(path)[0]


def _of_subject(path: str) -> tuple[str, str]:
    """Return a file of the disk, and whom of several people in it is meant."""
    path = archives.native(path)
    file, _, subject = path.rpartition(SUBJECT)
    named = bool(file and subject) and locations.is_file(file)
    # of a URL on the web, what stands behind # is no part of the file's name
    return (file, subject) if named and not os.path.lexists(path) else (path, "")


def siblings(path: str, suffix: str) -> list[str]:
    """Return the files with a suffix, in lower case, in the folder of a capture, sorted."""
    archive, member = archives.split(path)
    found: Iterable[str]
    if archive:
        folder = PurePosixPath(member).parent
        names = (it for it in archives.members(archive) if PurePosixPath(it).parent == folder)
        found = (archive + archives.MARK + name for name in names)
    else:
        try:
            found = locations.siblings(on_disk(path))
        except OSError as error:
            raise _error(path, error) from error
    return sorted(it for it in found if it.lower().endswith(suffix))


def opened(path: str | os.PathLike[str], version: str = "") -> File:
    """Return a file, a file in an archive, or one of one person in it: ``trial.c3d#Ada``.

    Of a large one in a store, only what is asked of it is fetched if it still has this version.
    """
    name = locations.plain(path)
    locations.forget(name)
    archive, member = archives.split(name)
    if archive:
        held = member in archives.members(archive)
        inside, _, subject = (member, "", "") if held else member.rpartition(SUBJECT)
        return File(name, archives.member(archive, inside or member), subject)
    where, subject = _of_subject(name)
    try:
        of_url = locations.mark(where) if locations.is_url(where) else ()
        told = locations.version(where)
        size = of_url[1] if told else 0
        whole = size <= SMALL or locations.place_of_copy(where, of_url).exists()
        if told == version and not whole:
            return File(name, _InStore(where, of_url, size), subject, told)
        path = locations.copy_of(where, of_url) if of_url else where
        status = os.stat(path)
        regular = stat.S_ISREG(status.st_mode)
        if not (regular or stat.S_ISDIR(status.st_mode)):  # a pipe might never end
            raise ValueError("is no regular file")
        with open(path, "rb") as file:
            large = regular and status.st_size > WHOLE
            content = _OnDisk(locations.located(where), status, of_url) if large else file.read()
            # what is stored packed has another size
            return File(name, content, subject, told if status.st_size == size else "")
    except (OSError, ValueError) as error:
        raise _error(name, error) from error


def _error(name: str, error: OSError | ValueError) -> CaptureError:
    found = getattr(error, "strerror", None) or str(error)
    if isinstance(error, FileNotFoundError):
        found = "a link that leads nowhere" if os.path.islink(name) else "there is no such file"
    elif isinstance(error, IsADirectoryError):
        found = "is a folder"
    return CaptureError(found, place=name, wanted="a file that can be read")
