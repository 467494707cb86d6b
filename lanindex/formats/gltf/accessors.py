"""Accessors: arrays of numbers in a glTF file's buffers, each checked before it is read."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError
from lanindex.formats.gltf.document import Document, Value

WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
"""Numbers in an element. Smaller matrices have gaps in them; no capture needs them."""

TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""What a number is."""


LARGEST = 1e9
"""Numbers beyond this are taken for damage."""


def shape(document: Document, number: Value) -> tuple[int, int]:
    """Return how many elements an accessor has and of how many numbers, without reading them."""
    accessors = document.root.get("accessors")
    accessor = accessors[number.one_of(accessors)]
    return accessor.get("count").whole(1), WIDTHS[accessor.get("type").word(WIDTHS)]


def numbers(document: Document, number: Value) -> NDArray[Any]:
    """Return the elements of an accessor."""
    count, width = shape(document, number)
    accessor = document.root.get("accessors")[number.whole()]
    code = accessor.get("componentType")
    kind = np.dtype(TYPES.get(code.whole(), "V1"))
    if kind.kind == "V":
        code.wrong(" or ".join(map(str, TYPES)))
    sparse = accessor.get("sparse")
    if "bufferView" in accessor:
        found = _elements(
            document, accessor, accessor.get("bufferView"), kind, count, width, strided=True
        )
    else:
        # all are 0 but those that are named: no more than twice as many as that
        named = sparse.get("count").whole(1) if sparse.value is not None else 1
        if count > 2 * named + 16:
            accessor.get("count").wrong("elements that are somewhere")
        found = np.zeros((count, width), kind)
    if sparse.value is not None:
        found = _replaced(document, sparse, found)
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
    document: Document,
    told: Value,
    view: Value,
    kind: np.dtype[Any],
    count: int,
    width: int,
    *,
    strided: bool = False,
) -> NDArray[Any]:
    """Return (N, width) numbers out of a buffer view."""
    buffer, first, length, stride = document.view(view)
    size = kind.itemsize * width
    step = stride if strided and stride is not None else size
    offset = told.get("byteOffset", 0).whole()
    if step < size or offset + step * (count - 1) + size > length:
        raise CaptureError(
            f"{told.where} needs {count} elements of {size} bytes, {step} apart from {offset} on",
            place=document.file.name,
            wanted=f"what lies in the {length} bytes of its bufferView",
        )
    start = first + offset
    document.spend(size * count, told)
    data = document.bytes(buffer, start, start + step * (count - 1) + size)
    return np.ndarray((count, width), kind, data, strides=(step, kind.itemsize))


def _replaced(document: Document, sparse: Value, found: NDArray[Any]) -> NDArray[Any]:
    """Return elements, some of which are replaced."""
    count = sparse.get("count").whole(1, len(found))
    where, what = sparse.get("indices"), sparse.get("values")
    code = where.get("componentType")
    if code.value not in (5121, 5123, 5125):
        code.wrong("5121 or 5123 or 5125")
    index = np.dtype(TYPES[code.whole()])
    places = _elements(document, where, where.get("bufferView"), index, count, 1)[:, 0]
    if int(places.max()) >= len(found):
        where.wrong(f"indices below {len(found)}")
    result = found.copy()
    result[places.astype(np.int64)] = _elements(
        document, what, what.get("bufferView"), found.dtype, count, found.shape[1]
    )
    return result
