"""A GLB that is put together: JSON, and one buffer of numbers behind it."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.formats.gltf.document import BINARY_CHUNK, JSON_CHUNK, MAGIC

KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
CODES = {"<u2": 5123, "<u4": 5125, "<f4": 5126}
VERTICES, INDICES = 34962, 34963
"""What a buffer view of a mesh is for."""


class Pack:
    """Numbers, and the accessors and buffer views that tell of them."""

    def __init__(self, views: list[Any] | None = None, accessors: list[Any] | None = None) -> None:
        self.views: list[Any] = [] if views is None else views
        self.accessors: list[Any] = [] if accessors is None else accessors
        self.size = 0
        self.free: tuple[list[int], list[int]] = ([], [])
        self._parts: list[bytes | memoryview] = []

    def copy(self, accessors: list[int], views: list[int]) -> Pack:
        """Return the same once more, some of whose accessors and views may be overwritten."""
        made = Pack(list(self.views), list(self.accessors))
        made.size, made._parts = self.size, list(self._parts)
        made.free = (accessors[::-1], views[::-1])
        return made

    def fill(self, number: int) -> None:
        """Let what is free yet be the same as an accessor."""
        told = self.accessors[number]
        for free in self.free[0]:
            self.accessors[free] = told
        for free in self.free[1]:
            self.views[free] = self.views[told["bufferView"]]

    def numbers(self) -> bytes:
        """Return the numbers."""
        return b"".join(self._parts)

    def lay(self, data: bytes | memoryview) -> dict[str, int]:
        """Lay bytes behind the others; return where, as a buffer view tells it."""
        gap = -self.size % 4
        self._parts += [b"\0" * gap, data]
        place = {"buffer": 0, "byteOffset": self.size + gap, "byteLength": len(data)}
        self.size += gap + len(data)
        return place

    def view(self, data: bytes, target: int | None = None) -> int:
        """Add a buffer view; return its number."""
        told = self.lay(data)
        told = told if target is None else {**told, "target": target}
        return _put(self.views, told, self.free[1])

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
        told: dict[str, Any] = {
            "bufferView": self.view(rows.tobytes(), target),
            "componentType": CODES[kind],
            "count": len(rows),
            "type": KINDS[rows.shape[1]],
        }
        if bounds:
            told |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        return _put(self.accessors, told, self.free[0])


def _put(things: list[Any], thing: Any, free: list[int]) -> int:
    """Put a thing where one is free, else behind the others; return its number."""
    if free:
        things[free[-1]] = thing
        return free.pop()
    things.append(thing)
    return len(things) - 1


def glb(told: dict[str, Any], data: bytes) -> bytes:
    """Return a GLB of its JSON and its numbers."""
    text = json.dumps(told, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    rest = -len(data) % 4
    binary = struct.pack("<I4s", len(data) + rest, BINARY_CHUNK) if data else b""
    size = 20 + len(text) + len(binary) + (len(data) + rest)
    head = struct.pack("<4sIII4s", MAGIC, 2, size, len(text), JSON_CHUNK)
    return b"".join((head, text, binary, data, b"\0" * rest))
