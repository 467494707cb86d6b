"""A glTF file: its JSON, looked at with care, and its buffers and accessors of numbers.

Khronos Group, glTF 2.0 Specification, 2021: 3.6 (accessors).
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, NoReturn
from urllib.parse import unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError, quoted
from lanindex.formats import archives
from lanindex.formats.file import Content, File, on_disk, opened
from lanindex.model import Reading

MAGIC = b"glTF"
JSON_CHUNK, BINARY_CHUNK = b"JSON", b"BIN\0"
MOST_VALUES = 4_000_000  # values in the JSON: a capture of an hour has some thousands
MOST_BUFFERS = 10_000
SPARE = 1 << 20  # bytes of numbers that may be read though the file is smaller than half of that
LARGEST = 1e9  # numbers beyond this are taken for damage
# numbers in an element; smaller matrices have gaps in them: no capture needs them
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
VERTICES, INDICES = 34962, 34963  # what a buffer view of a mesh is for

_PACKED = "EXT_meshopt_compression"
_KINDS = {width: name for name, width in WIDTHS.items()}
_CODES = {kind: code for code, kind in TYPES.items()}


@dataclass(frozen=True, slots=True)
class Value:
    """A value of the JSON, and where it stands; whatever it should be it is asked for."""

    value: Any
    where: str
    path: str

    def __contains__(self, key: str) -> bool:
        """Return whether an object has something of that name."""
        return isinstance(self.value, dict) and self.value.get(key) is not None

    def get(self, key: str, default: Any = None) -> Value:
        """Return what an object has of that name, else the default."""
        if not isinstance(self.value, dict):
            self.wrong("an object")
        found = self.value.get(key)
        where = f"{self.where}.{key}" if self.where else key
        return Value(default if found is None else found, where, self.path)

    def __iter__(self) -> Iterator[Value]:
        """Yield the values of a list; of nothing, none."""
        if self.value is None:
            return
        if not isinstance(self.value, list):
            self.wrong("a list")
        for number, value in enumerate(self.value):
            yield Value(value, f"{self.where}[{number}]", self.path)

    def __getitem__(self, number: int) -> Value:
        """Return a value of a list."""
        return Value(self.value[number], f"{self.where}[{number}]", self.path)

    def count(self) -> int:
        """Return how many values a list has."""
        if not isinstance(self.value, list | None):
            self.wrong("a list")
        return len(self.value or ())

    def integer(self, least: int = 0, most: int = 2**53) -> int:
        """Return a whole number."""
        value = self.value
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
            self.wrong(f"a whole number from {least} to {most}")
        return value

    def one_of(self, things: Value) -> int:
        """Return the number of one of some things."""
        count = things.count()
        if not count:
            self.wrong(f"a number of {things.where}, of which there are none")
        return self.integer(0, count - 1)

    def numbers(self, count: int) -> list[float]:
        """Return as many finite numbers."""
        value = self.value
        if not isinstance(value, list) or len(value) != count or not all(map(_finite, value)):
            self.wrong(f"{count} finite numbers")
        return [float(number) for number in value]

    def text(self) -> str:
        """Return a text."""
        if not isinstance(self.value, str):
            self.wrong("a text")
        return self.value

    def word(self, words: Iterable[str]) -> str:
        """Return a text that is one of some words."""
        if not isinstance(self.value, str) or self.value not in words:
            self.wrong(" or ".join(words))
        return self.value

    def wrong(self, wanted: str, remedy: str = "") -> NoReturn:
        """Say that it is not what it should be."""
        found = "not there" if self.value is None else quoted(self.value)
        raise CaptureError(
            f"{self.where or 'the JSON'} is {found}", place=self.path, wanted=wanted, remedy=remedy
        )


def _finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e30


@dataclass(slots=True)
class Document:
    """A glTF file."""

    file: File  # its content and name
    root: Value  # its JSON
    binary: tuple[int, int]  # where in the content the numbers of a GLB lie
    spent: int = 0  # bytes of numbers that were read
    _buffers: dict[int, tuple[Content, int, int]] = field(default_factory=dict)

    @property
    def is_glb(self) -> bool:
        """Whether all of it is in one file of bytes."""
        return self.file.content[:4] == MAGIC

    def view(self, number: Value) -> tuple[int, int, int, int | None]:
        """Return a buffer view: its buffer, its first byte, how many, and from one to the next."""
        views = self.root.get("bufferViews")
        view = views[number.one_of(views)]
        buffer = view.get("buffer").one_of(self.root.get("buffers"))
        offset, length = view.get("byteOffset", 0).integer(), view.get("byteLength").integer(1)
        stride = view.get("byteStride").integer(1, 252) if "byteStride" in view else None
        _, first, stop = self._bytes(buffer)
        if offset + length > stop - first:
            self._short(f"{view.where} ends at byte {offset + length}", f"at most {stop - first}")
        return buffer, offset, length, stride

    def spend(self, count: int, what: Value) -> None:
        """Count bytes that are read; refuse a file whose parts lie on each other."""
        self.spent += count
        most = SPARE + 2 * sum(stop - first for _, first, stop in self._buffers.values())
        if self.spent > most:
            self._short(f"{what.where} is the same bytes once more", "bytes that are used once")

    def bytes(self, buffer: int, start: int, stop: int) -> bytes | memoryview:
        """Return a stretch of a buffer that lies in it: what is in memory, not once more."""
        content, first, _ = self._bytes(buffer)
        there = memoryview(content) if isinstance(content, bytes) else content
        return there[first + start : first + stop]

    def _bytes(self, number: int) -> tuple[Content, int, int]:
        """Return where the bytes of a buffer are: the first, and the one behind the last."""
        if number not in self._buffers:
            buffer = self.root.get("buffers")[number]
            length = buffer.get("byteLength").integer(1)
            content, first, stop = self._source(number, buffer)
            if stop - first < length:
                self._short(f"{buffer.where} has {stop - first} bytes", f"{length}, as it says")
            self._buffers[number] = content, first, first + length
        return self._buffers[number]

    def _source(self, number: int, buffer: Value) -> tuple[Content, int, int]:
        if "uri" not in buffer:
            if number == 0 and self.binary[1] > self.binary[0]:
                return self.file.content, *self.binary
            packed = _PACKED in (it.value for it in self.root.get("extensionsUsed", []))
            remedy = f"It is packed by {_PACKED}: write it without that." * packed
            buffer.wrong("bytes in the file, or a uri", remedy)
        uri = buffer.get("uri")
        if uri.text()[:5].lower() == "data:":
            data = _decoded(uri)
            return data, 0, len(data)
        path = _beside(self.file, uri)
        try:
            content = opened(path).content
        except CaptureError as error:
            found = f"{uri.where} is {quoted(uri.value)}: {error.found}"
            raise CaptureError(found, place=self.file.name, wanted="its numbers") from None
        return content, 0, len(content)

    def _short(self, found: str, wanted: str) -> NoReturn:
        remedy = "The file may be cut short."
        raise CaptureError(found, place=self.file.name, wanted=wanted, remedy=remedy)


def _decoded(uri: Value) -> bytes:
    head, comma, data = uri.text().partition(",")
    with suppress(binascii.Error, ValueError):
        if comma and head.lower().endswith(";base64"):
            return base64.b64decode(data if "%" not in data else unquote_to_bytes(data))
        if comma:
            return unquote_to_bytes(data)
    uri.wrong("data:...;base64, and bytes as base64")


def _beside(file: File, uri: Value) -> str:
    """Return a file that a uri names: beside the file, or in a folder beside it."""
    name = unquote_to_bytes(uri.text()).decode("utf-8", "replace")
    parts = PurePosixPath(name).parts
    if not parts or parts[0] == "/" or ".." in parts or any(c in name for c in ":\\\0?#"):
        uri.wrong("the name of a file beside it")
    archive, member = archives.split(file.name)
    if archive:
        return f"{archive}{archives.MARK}{PurePosixPath(member).parent.joinpath(*parts)}"
    return str(Path(on_disk(file.name)).parent.joinpath(*parts))


def opened_document(file: File) -> Document:
    """Return what a glTF or GLB file is made of."""
    value, binary = file.once(_parsed)
    root = Value(value, "", file.name)
    version = root.get("asset").get("version").text()
    if version.split(".")[0] != "2":
        root.get("asset").get("version").wrong("2.0")
    if root.get("buffers").count() > MOST_BUFFERS:
        raise CaptureError("has too many buffers", place=file.name, wanted=f"{MOST_BUFFERS}")
    return Document(file, root, binary)


def companions(file: File, options: Reading) -> tuple[File, ...]:
    """Return the files of numbers that a glTF file names, as far as they are there."""
    found: list[File] = []
    for buffer in opened_document(file).root.get("buffers"):
        if "uri" in buffer and buffer.get("uri").text()[:5].lower() != "data:":
            with suppress(CaptureError):  # said when it is read
                found.append(opened(_beside(file, buffer.get("uri"))))
    return tuple(found)


def _parsed(file: File) -> tuple[Any, tuple[int, int]]:
    """Return the JSON, and where the numbers of a GLB lie."""
    content, binary = file.content, (0, 0)
    if content[:4] == MAGIC:
        first, stop, binary = _chunks(file)
        text = content[first:stop]
    else:
        text = content[:].removeprefix(b"\xef\xbb\xbf")
    return _json(text, file.name), binary


def _chunks(file: File) -> tuple[int, int, tuple[int, int]]:
    """Return where the JSON and the numbers of a GLB lie."""
    content, size = file.content, len(file.content)
    head = content[:20]
    if len(head) < 20:
        raise CaptureError(
            f"has {size} bytes", place=file.name, wanted="the 20 with which a GLB begins"
        )
    version, _, length = struct.unpack("<III", head[4:16])
    if version != 2 or head[16:20] != JSON_CHUNK:
        found = f"GLB {version}, whose first chunk is {quoted(head[16:20])}"
        raise CaptureError(found, place=file.name, wanted="GLB 2 with JSON first")
    first, stop = 20, 20 + length
    if stop > size:
        raise CaptureError(
            f"has {size} bytes",
            place=file.name,
            wanted=f"{stop} at least, as its JSON is said to be long",
            remedy="The file may be cut short.",
        )
    binary = (0, 0)
    following = content[stop : stop + 8]
    if len(following) == 8 and following[4:] == BINARY_CHUNK:
        binary = (stop + 8, min(stop + 8 + int.from_bytes(following[:4], "little"), size))
    return first, stop, binary


def _json(text: bytes, path: str) -> Any:
    """Read JSON that is not larger or deeper than it may be."""
    wanted, found = "JSON", ""
    if sum(map(text.count, (b",", b"[", b"{"))) > MOST_VALUES:
        wanted, found = f"at most {MOST_VALUES} values in its JSON", "is too large"
    else:
        try:
            return json.loads(text.decode("utf-8"), parse_constant=_no_number)
        except UnicodeDecodeError as error:
            found = f"byte {error.start} of its JSON is no UTF-8"
        except json.JSONDecodeError as error:
            found = f"its JSON breaks at line {error.lineno}, column {error.colno}: {error.msg}"
        except (ValueError, RecursionError):
            found = "its JSON has numbers too long or lists too deep"
    raise CaptureError(found, place=path, wanted=wanted)


def _no_number(word: str) -> NoReturn:
    raise json.JSONDecodeError(f"{word} is no number", "", 0)


def shape(document: Document, number: Value) -> tuple[int, int]:
    """Return how many elements an accessor has and of how many numbers, without reading them."""
    accessors = document.root.get("accessors")
    accessor = accessors[number.one_of(accessors)]
    return accessor.get("count").integer(1), WIDTHS[accessor.get("type").word(WIDTHS)]


def numbers(document: Document, number: Value) -> NDArray[Any]:
    """Return the elements of an accessor."""
    count, width = shape(document, number)
    accessor = document.root.get("accessors")[number.integer()]
    code = accessor.get("componentType")
    kind = np.dtype(TYPES.get(code.integer(), "V1"))
    if kind.kind == "V":
        code.wrong(" or ".join(map(str, TYPES)))
    sparse = accessor.get("sparse")
    if "bufferView" in accessor:
        found = _elements(document, accessor, kind, count, width, True)
    else:  # all are 0 but those that are named: no more than twice as many as that
        named = sparse.get("count").integer(1) if sparse.value is not None else 1
        if count > 2 * named + 16:
            accessor.get("count").wrong("elements that are somewhere")
        found = np.zeros((count, width), kind)
    if sparse.value is not None:
        found = _with_replacements(document, sparse, found)
    if accessor.get("normalized", False).value is True and kind.kind != "f":
        found = np.maximum(found / np.iinfo(kind).max, -1.0).astype(np.float32)
    if not -LARGEST < float(found.min()) <= float(found.max()) < LARGEST:
        row = int((~(np.abs(found) < LARGEST)).any(axis=1).argmax())
        raise CaptureError(
            f"element {row} of {accessor.where} is {found[row].tolist()}",
            place=document.file.name,
            wanted=f"finite numbers up to {LARGEST:g}",
        )
    return found


def _elements(
    document: Document, one: Value, kind: np.dtype[Any], count: int, width: int, strided: bool
) -> NDArray[Any]:
    """Return (N, width) numbers out of a buffer view."""
    buffer, first, length, stride = document.view(one.get("bufferView"))
    size = kind.itemsize * width
    step = stride if strided and stride is not None else size
    offset = one.get("byteOffset", 0).integer()
    if step < size or offset + step * (count - 1) + size > length:
        raise CaptureError(
            f"{one.where} needs {count} elements of {size} bytes, {step} apart from {offset} on",
            place=document.file.name,
            wanted=f"what lies in the {length} bytes of its bufferView",
        )
    document.spend(size * count, one)
    data = document.bytes(buffer, first + offset, first + offset + step * (count - 1) + size)
    return np.ndarray((count, width), kind, data, strides=(step, kind.itemsize))


def _with_replacements(document: Document, sparse: Value, elements: NDArray[Any]) -> NDArray[Any]:
    """Return elements, some of which are replaced."""
    count = sparse.get("count").integer(1, len(elements))
    where, what = sparse.get("indices"), sparse.get("values")
    code = where.get("componentType")
    if code.value not in (5121, 5123, 5125):
        code.wrong("5121 or 5123 or 5125")
    index = np.dtype(TYPES[code.integer()])
    places = _elements(document, where, index, count, 1, False)[:, 0]
    if int(places.max()) >= len(elements):
        where.wrong(f"indices below {len(elements)}")
    result = elements.copy()
    values = _elements(document, what, elements.dtype, count, elements.shape[1], False)
    result[places.astype(np.int64)] = values
    return result


@dataclass(slots=True)
class Pack:
    """Numbers, and the accessors and buffer views that tell of them."""

    views: list[Any] = field(default_factory=list)
    accessors: list[Any] = field(default_factory=list)
    free_views: list[int] = field(default_factory=list)  # those that may be overwritten
    free_accessors: list[int] = field(default_factory=list)
    size: int = 0  # bytes
    parts: list[bytes | memoryview] = field(default_factory=list)

    def copy(self) -> Pack:
        """Return the same once more."""
        free = (list(self.free_views), list(self.free_accessors))
        return Pack(list(self.views), list(self.accessors), *free, self.size, list(self.parts))

    def fill(self, number: int) -> None:
        """Let what is free yet be the same as an accessor."""
        entry = self.accessors[number]
        for free in self.free_accessors:
            self.accessors[free] = entry
        for free in self.free_views:
            self.views[free] = self.views[entry["bufferView"]]

    def lay(self, data: bytes | memoryview) -> dict[str, int]:
        """Lay bytes behind the others; return where, as a buffer view tells it."""
        gap = -self.size % 4
        self.parts += [b"\0" * gap, data]
        place = {"buffer": 0, "byteOffset": self.size + gap, "byteLength": len(data)}
        self.size += gap + len(data)
        return place

    def accessor(
        self,
        values: NDArray[Any],
        kind: str = "<f4",
        *,
        target: int | None = None,
        bounds: bool = False,
    ) -> int:
        """Add an accessor of (N, width) numbers; return its number."""
        rows = np.ascontiguousarray(values, kind).reshape(len(values), -1)
        view = self.lay(rows.tobytes()) | ({} if target is None else {"target": target})
        entry: dict[str, Any] = {
            "bufferView": _place_item(self.views, view, self.free_views),
            "componentType": _CODES[kind],
            "count": len(rows),
            "type": _KINDS[rows.shape[1]],
        }
        if bounds:
            entry |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        return _place_item(self.accessors, entry, self.free_accessors)


def _place_item(items: list[Any], item: Any, free: list[int]) -> int:
    """Put an item into a free place, else behind the others; return its number."""
    if free:
        items[free[-1]] = item
        return free.pop()
    items.append(item)
    return len(items) - 1


def glb(root: dict[str, Any], pack: Pack) -> bytes:
    """Return a GLB of its JSON and its numbers."""
    data = b"".join(pack.parts)
    text = json.dumps(root, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    rest = -len(data) % 4
    binary = struct.pack("<I4s", len(data) + rest, BINARY_CHUNK) if data else b""
    size = 20 + len(text) + len(binary) + (len(data) + rest)
    head = struct.pack("<4sIII4s", MAGIC, 2, size, len(text), JSON_CHUNK)
    return b"".join((head, text, binary, data, b"\0" * rest))
