"""A glTF file as it is read: its JSON, its buffers and accessors, nodes, people, animations.

Khronos Group, glTF 2.0 Specification, 2021: 3.6 (accessors), 3.7 (skins), 3.11 (animations).
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import ceil
from pathlib import PurePosixPath
from typing import Any, NoReturn
from urllib.parse import unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from lanindex import locations
from lanindex.errors import CaptureError, quoted
from lanindex.formats import archives
from lanindex.formats.file import Content, File, on_disk, opened
from lanindex.formats.rates import nearest_rate
from lanindex.formats.turning import JointTree, ancestry, between, joint_tree, quaternions, unit
from lanindex.model import Reading

Floats = NDArray[np.float64]

MAGIC = b"glTF"
JSON_CHUNK, BINARY_CHUNK = b"JSON", b"BIN\0"
MOST_VALUES = 4_000_000  # values in the JSON: a capture of an hour has some thousands
MOST_BUFFERS = 10_000
SPARE = 1 << 20  # bytes of numbers that may be read though the file is smaller than half of that
LARGEST = 1e9  # numbers beyond this are taken for damage
# numbers in an element; smaller matrices have gaps in them: no capture needs them
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}

_PACKED = "EXT_meshopt_compression"
DEEPEST = 500  # nodes in each other: a finger's tip is the twentieth
MOST_NODES = 100_000
MOST_JOINTS = 32_000  # what an int16 index can hold
PATHS = {"translation": 3, "rotation": 4, "scale": 3}  # what moves joints, and in how many numbers
KINDS = ("LINEAR", "STEP", "CUBICSPLINE")
ON_GRID = 0.1  # of a frame: keys as near as this to a frame are on it
SLOW, USUAL = 15, 30  # keys rarer than so many a second are read between them, so often at least
MOST_BETWEEN = 10_000  # frames that a key may stand for


@dataclass(frozen=True, slots=True)
class Value:
    """A value of the JSON, and where it stands; whatever it should be it is asked for."""

    value: Any
    where: str
    path: str

    def __contains__(self, key: str) -> bool:
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
    return locations.beside(on_disk(file.name), "/".join(parts))


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


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """The nodes of a file."""

    names: tuple[str, ...]  # (N) as the file has them; empty where it has none
    parents: tuple[int, ...]  # (N) -1 for a root
    order: tuple[int, ...]  # (N) all of them, parents before children, limb after limb
    depths: tuple[int, ...]  # (N) how many are above each
    meshed: frozenset[int]  # those that show a mesh or are a camera
    # (N, 3), (N, 4), (N, 3): where each stands within its parent while nothing moves it
    shifts: Floats
    turns: Floats
    scales: Floats


def nodes_of(document: Document) -> Nodes:
    """Return the nodes of a file."""
    values = document.root.get("nodes")
    count = values.count()
    if count > MOST_NODES:
        Value(count, "the number of nodes", document.file.name).wrong(f"at most {MOST_NODES}")
    parents, children = [-1] * count, [list[int]() for _ in range(count)]
    shifts, turns, scales = np.zeros((count, 3)), np.zeros((count, 4)), np.ones((count, 3))
    turns[:, 0] = 1
    names, meshed = [], set()
    for number, node in enumerate(values):
        names.append(node.get("name", "").text())
        if "mesh" in node or "camera" in node:
            meshed.add(number)
        for child in node.get("children"):
            below = child.one_of(values)
            if parents[below] >= 0:
                child.wrong("a node that is in no other node")
            parents[below] = number
            children[number].append(below)
        shifts[number], turns[number], scales[number] = _standing(node)
    order, depths = list[int](), [0] * count
    waiting = [number for number in reversed(range(count)) if parents[number] < 0]
    while waiting:
        number = waiting.pop()
        order.append(number)
        depths[number] = depths[parents[number]] + 1 if parents[number] >= 0 else 0
        waiting.extend(reversed(children[number]))
    deepest = max(depths, default=0)
    if len(order) < count or deepest > DEEPEST:
        odd = values[next(n for n in range(count) if n not in set(order) or depths[n] == deepest)]
        odd.get("children").wrong(f"nodes that are not in themselves, nor {DEEPEST} in each other")
    frozen = frozenset(meshed)
    return Nodes(
        *(tuple(names), tuple(parents), tuple(order), tuple(depths), frozen, shifts, turns, scales)
    )


def _standing(node: Value) -> tuple[Floats, Floats, Floats]:
    """Return where a node stands: shift, turn, scale."""
    if "matrix" not in node:
        x, y, z, w = node.get("rotation", [0, 0, 0, 1]).numbers(4)
        return (
            np.array(node.get("translation", [0, 0, 0]).numbers(3)),
            unit(np.array([w, x, y, z])),
            np.array(node.get("scale", [1, 1, 1]).numbers(3)),
        )
    matrix = np.array(node.get("matrix").numbers(16)).reshape(4, 4).T
    scale = np.sqrt((matrix[:3, :3] ** 2).sum(axis=0))
    if np.linalg.det(matrix[:3, :3]) < 0:
        scale[0] = -scale[0]
    return matrix[:3, 3], quaternions(matrix[:3, :3] / np.where(scale == 0, 1, scale)), scale


def people(document: Document, nodes: Nodes, moved: set[int]) -> list[tuple[str, JointTree]]:
    """Return the skeletons of a file, each by the name of its skin or, without one, topmost node.

    Skins that share joints, or hang on each other's, are clothes of one person. Nodes between and
    below joints are joints, unless they show a mesh. Without skins, moving nodes under one root are
    one.
    """
    groups = list[tuple[str, set[int]]]()
    skinned = _skins(document, nodes)
    for name, joints in skinned or _trees(nodes, moved):
        known, top = _joined(nodes, set(joints))
        if top is not None and (top in moved or not skinned):
            known.add(top)
        groups.append((name, known))
    owner = {node: number for number, (_, known) in enumerate(groups) for node in known}
    members: list[list[int]] = [[] for _ in groups]
    for node in nodes.order:
        above = nodes.parents[node]
        if node not in owner and above in owner and not (skinned and node in nodes.meshed):
            owner[node] = owner[above]
        if node in owner:
            members[owner[node]].append(node)
    most = max(map(len, members), default=0)
    if most > MOST_JOINTS:
        Value(most, "the number of joints", document.file.name).wrong(f"{MOST_JOINTS}")
    trees = [joint_tree(joints, nodes.names, nodes.parents) for joints in members]
    return [(name, tree) for (name, _), tree in zip(groups, trees, strict=True)]


def _skins(document: Document, nodes: Nodes) -> list[tuple[str, list[int]]]:
    """Return the joints of skins, those of one person together."""
    leader = dict[int, int]()

    def first(node: int) -> int:
        while leader[node] != node:
            leader[node] = leader[leader[node]]
            node = leader[node]
        return node

    called = dict[int, str]()
    for skin in document.root.get("skins"):
        joints = [joint.one_of(document.root.get("nodes")) for joint in skin.get("joints")]
        for joint in joints:
            leader.setdefault(joint, joint)
            leader[first(joint)] = first(joints[0])
        if joints:
            called.setdefault(joints[0], skin.get("name", "").text())
    nearest = dict[int, int]()  # the joint above each node
    for node in nodes.order:
        above = nodes.parents[node]
        near = above if above in leader else nearest.get(above, -1)
        nearest[node] = near
        if node in leader and near >= 0:
            leader[first(node)] = first(near)
    groups = dict[int, list[int]]()
    for joint in leader:
        groups.setdefault(first(joint), []).append(joint)
    named = dict[int, str]()
    for joint, name in called.items():
        named[first(joint)] = named.get(first(joint)) or name
    return [(named.get(number, ""), joints) for number, joints in groups.items()]


def _trees(nodes: Nodes, moved: set[int]) -> list[tuple[str, list[int]]]:
    """Return the nodes that move, those under one root together."""
    roots = dict[int, int]()
    groups = dict[int, list[int]]()
    for node in nodes.order:
        roots[node] = roots.get(nodes.parents[node], node)
        if node in moved:
            groups.setdefault(roots[node], []).append(node)
    return [(nodes.names[root], joints) for root, joints in groups.items()]


def _joined(nodes: Nodes, joints: set[int]) -> tuple[set[int], int | None]:
    """Return joints, the nodes between them, and the one above all, where it is none of them."""
    above = ancestry(joints, nodes.parents)
    below = Counter(nodes.parents[node] for node in above)
    if below[-1] > 1:  # roots of their own
        return above, None
    path = sorted(above, key=nodes.depths.__getitem__)  # one node after the other, to the first:
    first = next(n for n, node in enumerate(path) if node in joints or below[node] > 1)
    if path[first] in joints:
        return set(path[first:]), None
    return set(path[first + 1 :]), path[first]


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """How one thing changes."""

    node: int  # whose; -1: of no node
    path: str  # ``translation``, ``rotation``, ``scale``; another: nothing that moves joints
    kind: str  # ``LINEAR``, ``STEP`` or ``CUBICSPLINE``
    times: Floats  # (K,) seconds, not falling
    # (K, W); of a spline (K, 3, W): the tangent before, the value, the tangent behind. Turns are
    # (x, y, z, w).
    values: NDArray[Any]
    keys: Floats  # (K,) the times in frames

    def at(self, frames: NDArray[np.int64], *, exactly: bool = False) -> Floats:
        """Return values (T, W) in frames; rotations (w, x, y, z), unit or `exactly` as keys."""
        keys = self.keys
        last = len(keys) - 1
        before = np.clip(np.searchsorted(keys, frames, side="right") - 1, 0, last)
        found = self._key(before)
        if self.kind != "STEP" and last:
            after = np.minimum(before + 1, last)
            wide = keys[after] - keys[before]
            part = np.clip((frames - keys[before]) / np.where(wide > 0, wide, 1), 0, 1)
            on = np.flatnonzero(part)
            if len(on):
                found[on] = self._between(before[on], after[on], part[on])
        return unit(found) if self.path == "rotation" and not exactly else found

    def _key(self, index: NDArray[np.int64], which: int = 1) -> Floats:
        """Return values (T, W) of keys, or of a spline's a tangent: 0 before it, 2 behind."""
        rows = self.values[index, which] if self.kind == "CUBICSPLINE" else self.values[index]
        rows = rows.astype(np.float64)
        return rows[:, [3, 0, 1, 2]] if self.path == "rotation" else rows

    def _between(self, before: NDArray[np.int64], after: NDArray[np.int64], u: Floats) -> Floats:
        """Return values between keys; on cubic Hermite splines as appendix C of glTF 2.0 says."""
        start, stop = self._key(before), self._key(after)
        if self.kind == "LINEAR" and self.path == "rotation":
            return between(unit(start), unit(stop), u)
        u = u[:, None]
        if self.kind == "LINEAR":
            return np.asarray(start + u * (stop - start))
        seconds = (self.times[after] - self.times[before])[:, None]
        square, cube = u * u, u * u * u
        found = (2 * cube - 3 * square + 1) * start + (3 * square - 2 * cube) * stop
        found += seconds * (cube - 2 * square + u) * self._key(before, 2)
        found += seconds * (cube - square) * self._key(after, 0)
        return np.asarray(found)


@dataclass(frozen=True, slots=True)
class Clock:
    """When frames are."""

    rate: Fraction  # frames a second
    pace: float  # the same as the keys have it, not rounded
    start: float  # seconds at frame 0
    count: int  # how many frames there are
    tied: float  # of a frame: keys as near as this to one are on it
    doubts: tuple[str, ...] = ()  # what was odd

    def frames(self, times: Floats) -> Floats:
        """Return when times are, in frames."""
        frames = (times - self.start) * self.pace
        nearest = np.rint(frames)
        return np.where(np.abs(frames - nearest) <= self.tied, nearest, frames)


def takes(document: Document) -> list[tuple[str, Value]]:
    """Return the animations by their names, those without one by their numbers from 1 on."""
    animations = enumerate(document.root.get("animations"), 1)
    return [(take.get("name", "").text() or str(number), take) for number, take in animations]


def moved(document: Document, take: Value) -> set[int]:
    """Return the nodes that an animation moves, its numbers not looked at."""
    nodes = document.root.get("nodes")
    found = set()
    for channel in take.get("channels"):
        target = channel.get("target")
        if str(target.get("path").value) in PATHS and "node" in target:
            found.add(target.get("node").one_of(nodes))
    return found


def tracks(document: Document, take: Value, wanted: Iterable[int] | None = None) -> list[Track]:
    """Return the tracks of an animation."""
    nodes, chosen = document.root.get("nodes"), None if wanted is None else set(wanted)
    samplers = take.get("samplers")
    known = dict[int, NDArray[Any]]()
    found = []
    for channel in take.get("channels"):
        target = channel.get("target")
        path = str(target.get("path").value)
        node = target.get("node").one_of(nodes) if "node" in target else -1
        if chosen is not None and (path not in PATHS or node not in chosen):
            continue
        sampler = samplers[channel.get("sampler").one_of(samplers)]
        found.append(_track(document, sampler, node, path, known))
    return found


def _track(
    document: Document, sampler: Value, node: int, path: str, arrays: dict[int, NDArray[Any]]
) -> Track:
    kind = sampler.get("interpolation", "LINEAR").word(KINDS)
    spline = kind == "CUBICSPLINE"
    start, stop = sampler.get("input"), sampler.get("output")
    keys, (count, width) = shape(document, start), shape(document, stop)
    elements = keys[0] * (3 if spline else 1)
    fits = (
        (count == elements and width == PATHS[path])
        if path in PATHS
        else not count * width % elements
    )
    if keys[1] != 1 or not fits:
        raise CaptureError(
            f"{sampler.where} has {keys[0]} keys of {keys[1]} and {count} values of {width}",
            place=document.file.name,
            wanted=f"times and as many values as a {kind} {path} has",
        )
    if start.integer() not in arrays:
        times = numbers(document, start)[:, 0].astype(np.float64)
        if (np.diff(times) < 0).any():
            raise CaptureError(
                f"the times of {sampler.where} go back at key {int(np.diff(times).argmin()) + 1}",
                place=document.file.name,
                wanted="times that rise",
            )
        arrays[start.integer()] = times
    if stop.integer() not in arrays:
        arrays[stop.integer()] = numbers(document, stop)
    values = arrays[stop.integer()]
    values = values.reshape(keys[0], 3, -1) if spline else values.reshape(keys[0], -1)
    times = arrays[start.integer()]
    return Track(node, path, kind, times, values, times)


def clock(times: Sequence[Floats], path: str) -> Clock:
    """Return the frames of an animation, at the times of the keys of its densest track.

    Frames without keys lie between even keys; sparse or uneven keys are read between, too.
    """
    densest = max(times, key=len)
    first = min(float(one[0]) for one in times)
    last = max(float(one[-1]) for one in times)
    steps = np.diff(densest)
    steps = steps[steps > 0]
    if not len(steps):
        return Clock(Fraction(USUAL), float(USUAL), first, 1, 0.0)
    step = float(np.sort(steps)[(len(steps) - 1) // 2])
    usual = steps[np.abs(steps - step) < step / 2]
    whole = np.maximum(np.rint(steps / float(usual.mean())), 1)
    pace = float(whole.sum() / steps.sum())
    even = bool(np.abs(np.cumsum(steps) * pace - np.cumsum(whole)).max() <= ON_GRID)
    if not even:
        pace = 1 / step
    doubts: tuple[str, ...] = ()
    often = ceil(USUAL / pace) if pace < SLOW else 1
    keys = f"keys are {1 / pace:.3g} s apart"
    pace *= often
    if not first + 1e5 > last or (last - first) * pace > MOST_BETWEEN * len(densest):
        raise CaptureError(
            f"{len(densest)} keys from {first:g} to {last:g} s, {step:g} s apart",
            place=path,
            wanted=f"keys that stand for {MOST_BETWEEN} frames at most, in a day",
        )
    rate = nearest_rate(Fraction(pace).limit_denominator(10**6))
    tied = ON_GRID if even else 1e-3
    pace = pace if even else float(rate)
    start = float(densest[0])
    start -= np.floor((start - first) * pace + tied) / pace
    found = Clock(rate, pace, start, 1, tied)
    frames = int(np.floor(found.frames(np.array([last]))[0] + tied)) + 1
    if often > 1:
        doubts = (f"{keys}: it is read at {float(rate):g} frames a second",)
    in_frames = (found.frames(one) for one in times)
    if not even or any((one != np.rint(one)).any() for one in in_frames):
        doubts = (f"keys are at uneven times: it is read at {float(rate):g} frames a second",)
    return Clock(rate, pace, start, frames, tied, doubts)


def timed(untimed: Sequence[Track], clock: Clock) -> list[Track]:
    """Return tracks that know their keys in frames."""
    known = {id(track.times): clock.frames(track.times) for track in untimed}
    return [replace(track, keys=known[id(track.times)]) for track in untimed]
