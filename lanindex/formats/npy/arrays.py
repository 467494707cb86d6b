"""Arrays of a file, of which nothing is trusted: no pickle is opened, no size believed unchecked.

Source: *numpy.lib.format*, versions 1 to 3; PKWARE *APPNOTE* (ZIP).
"""

from __future__ import annotations

import ast
import io
import math
import re
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError, quoted
from lanindex.formats.file import Content, File

SUFFIX = ".npy"

RATIO, SPARE = 200, 1 << 20
"""How many times its packed size a member may have, and bytes besides: motion packs by 2 or 3."""

_MAGIC = re.compile(rb"\x93NUMPY([\1-\3])[\0-\xff]", re.DOTALL)
_HEADER = 1 << 14  # bytes in which a header ends
_KINDS = re.compile(r"[<>=|]?(?:f[248]|[iu][1248]|b1|[US]\d{1,6})")
_UNPACKING = (
    zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, RuntimeError, KeyError,
    NotImplementedError, OverflowError, IndexError,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Header:
    """What stands before the numbers of an array."""

    kind: np.dtype[Any]  # of its numbers
    shape: tuple[int, ...]  # how many
    fortran: bool  # whether the first axis changes fastest
    first: int  # the byte behind the header

    @property
    def size(self) -> int:
        """Bytes of its numbers."""
        return math.prod(self.shape) * self.kind.itemsize

    def array(self, data: bytes) -> NDArray[Any]:
        """Return the array whose numbers these bytes are."""
        order = "F" if self.fortran else "C"
        return np.frombuffer(data, self.kind).reshape(self.shape, order=order)  # type: ignore[call-overload,no-any-return]


@dataclass(frozen=True, slots=True)
class Arrays:
    """The arrays of a file, read when they are asked for."""

    place: str  # the file, for errors
    headers: dict[str, Header]  # by name; of a file of one array the name is empty
    fetch: Callable[[str, int, int], bytes]  # from name, first byte and last to bytes of a member
    refused: dict[str, str]  # names of what cannot be read, and why

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return an array."""
        header = self.headers[name]
        return header.array(self.fetch(name, header.first, header.first + header.size))


def header_of(head: bytes, there: int, place: str) -> Header:
    """Return the header of an array."""
    found = _MAGIC.match(head)
    wanted = "a NumPy array of version 1, 2 or 3"
    if not found:
        raise CaptureError(f"begins with {quoted(head[:8])}", place=place, wanted=wanted)
    wide = 2 if found[1] == b"\1" else 4
    first = 8 + wide + int.from_bytes(head[8 : 8 + wide], "little")
    if first > min(len(head), _HEADER):
        raise CaptureError(f"a header of {first} bytes", place=place, wanted=wanted)
    kind, shape, fortran = _said(head[8 + wide : first], place)
    header = Header(kind, shape, fortran, first)
    if header.size > there - first:
        found_size = f"an array {shape} of {header.size} bytes, of which {there - first} are there"
        raise CaptureError(
            found_size, place=place, wanted="all of it", remedy="The file may be cut short."
        )
    return header


def _said(text: bytes, place: str) -> tuple[np.dtype[Any], tuple[int, ...], bool]:
    """Return kind, shape and order as a header says them."""
    try:
        said = ast.literal_eval(text.decode("latin-1").strip())
        kind, shape, fortran = said["descr"], said["shape"], said["fortran_order"]
    except (ValueError, SyntaxError, TypeError, KeyError, MemoryError, RecursionError):
        found, wanted = f"the header {quoted(text[:60])}", "descr, fortran_order and shape"
        raise CaptureError(found, place=place, wanted=wanted) from None
    if isinstance(kind, str) and "O" in kind:
        raise CaptureError(
            "holds Python objects (a pickle), which can run any program when they are opened",
            place=place,
            wanted="arrays of numbers",
            remedy="Save its joints alone: numpy.savez(path, joints=..., fps=...).",
        )
    if not isinstance(kind, str) or not _KINDS.fullmatch(kind):
        raise CaptureError(f"numbers of the kind {quoted(kind)}", place=place, wanted="f4 or f8")
    sizes = isinstance(shape, tuple) and all(type(n) is int and 0 <= n < 1 << 40 for n in shape)
    if not sizes or len(shape) > 8:
        found, wanted = f"the shape {quoted(shape)}", "a few whole numbers"
        raise CaptureError(found, place=place, wanted=wanted)
    return np.dtype(kind), shape, bool(fortran)


def arrays(file: File) -> Arrays:
    """Return the arrays of a file."""
    content = file.content
    if content[:2] != b"PK":
        header = header_of(content[:_HEADER], len(content), file.name)
        return Arrays(file.name, {"": header}, lambda _, a, b: content[a:b], {})
    packed = archive(file)
    headers, refused = {}, {}
    for info in packed.infolist():
        name = info.filename.removesuffix(SUFFIX)
        if name == info.filename:
            continue
        try:
            head = unpacked(file.name, packed, info, 0, _HEADER)
            headers[name] = header_of(head, info.file_size, f"{file.name}: {quoted(name)}")
        except CaptureError as error:
            refused[name] = error.found

    def fetch(name: str, first: int, stop: int) -> bytes:
        return unpacked(file.name, packed, packed.getinfo(name + SUFFIX), first, stop)

    return Arrays(file.name, headers, fetch, refused)


def archive(file: File) -> zipfile.ZipFile:
    """Open the ZIP that a file is."""
    try:
        return zipfile.ZipFile(_stream(file.content))
    except _UNPACKING as error:
        raise CaptureError(
            f"a damaged ZIP ({error})",
            place=file.name,
            wanted="NumPy arrays",
            remedy="The file may be cut short.",
        ) from error


def unpacked(
    place: str, packed: zipfile.ZipFile, info: zipfile.ZipInfo, first: int, stop: int
) -> bytes:
    """Return some bytes of a member of a ZIP."""
    if info.file_size > RATIO * info.compress_size + SPARE:
        found = f"{quoted(info.filename)} unpacks to {info.file_size} bytes"
        wanted = f"at most {RATIO} times its packed size of {info.compress_size}"
        raise CaptureError(found, place=place, wanted=wanted)
    stop = min(stop, info.file_size)
    try:
        with packed.open(info) as member:
            member.seek(first)
            data = member.read(max(stop - first, 0))
    except _UNPACKING as error:
        found = f"{quoted(info.filename)} cannot be unpacked ({error})"
        raise CaptureError(found, place=place, wanted="a sound ZIP") from error
    if len(data) < stop - first:
        raise CaptureError(f"{quoted(info.filename)} ends early", place=place, wanted="all of it")
    return data


class _Stream(io.RawIOBase):
    """Content as a stream, for what reads nothing else."""

    def __init__(self, content: Content) -> None:
        super().__init__()
        self._content, self._at = content, 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = 0) -> int:
        self._at = max((0, self._at, len(self._content))[whence] + offset, 0)
        return self._at

    def readinto(self, buffer: Any) -> int:
        data = self._content[self._at : self._at + len(buffer)]
        buffer[: len(data)] = data
        self._at += len(data)
        return len(data)


def _stream(content: Content) -> Any:
    return (
        io.BytesIO(content) if isinstance(content, bytes) else io.BufferedReader(_Stream(content))
    )
