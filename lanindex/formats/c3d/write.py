"""Motion to C3D: floats of an Intel processor, millimetres, y up.

Source: *The C3D File Format, User Guide*, Motion Lab Systems (c3d.org).
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

import numpy as np

from lanindex.formats.c3d.layout import BLOCK
from lanindex.formats.c3d.parameters import FULL, PROCESSORS, TEXT
from lanindex.model import Motion

_INTEL = 84
_LIST = 255
"""Texts in one parameter."""

_WIDEST = 127
"""Bytes of a text."""

_FLOATS = -1.0
"""A scale below 0: numbers are floats."""

_UNKNOWN = -1.0
_NEXT_TO_ZERO = 1e-6
"""Millimetres: where a point is that stands at zero, which would be taken as unknown."""

Value = tuple[int, tuple[int, ...], bytes]


def write(motion: Motion) -> bytes:
    """Write a motion as C3D: its markers where it has them, else its joints."""
    shown = motion.markers
    names = shown.names if shown else motion.skeleton.names
    places = shown.positions if shown else motion.positions
    section = _section(motion, names, len(places), 0)
    start = 2 + len(section) // BLOCK
    table = np.zeros((len(places), len(names), 4), "<f4")
    table[..., :3] = places
    table[(places == 0).all(axis=2), 1] = _NEXT_TO_ZERO
    unknown = ~np.isfinite(places).all(axis=2)
    table[unknown] = (0, 0, 0, _UNKNOWN)
    head = bytearray(BLOCK)
    head[:24] = struct.pack(
        "<BB5HfHHf",
        *(2, 0x50, len(names), 0, 1, min(len(places), FULL), 0, _FLOATS, start, 1),
        float(motion.rate),
    )
    data = table.tobytes()
    rest = -len(data) % BLOCK if len(places) <= FULL else 0  # else some count by the file's end
    return b"".join((head, _section(motion, names, len(places), start), data, bytes(rest)))


def _section(motion: Motion, names: Sequence[str], frames: int, start: int) -> bytes:
    """Return the parameters, in whole blocks; the data begin in a block."""
    chain = [
        piece
        for number, (group, values) in enumerate(_told(motion, names, frames, start).items(), 1)
        for piece in (
            _entry(group, -number, b"\0"),
            *(_entry(name, number, _value(value)) for name, value in values.items()),
        )
    ]
    size = 4 + sum(map(len, chain)) + 2
    blocks = math.ceil(size / BLOCK)
    section = bytes((0, 0, min(blocks, 255), _INTEL)) + b"".join(chain)
    return section.ljust(blocks * BLOCK, b"\0")


def _told(
    motion: Motion, names: Sequence[str], frames: int, start: int
) -> dict[str, dict[str, Value]]:
    """Return the parameters by their groups."""
    return {
        "POINT": {
            "USED": _ints(len(names)),
            "SCALE": _floats(_FLOATS),
            "RATE": _floats(float(motion.rate)),
            "DATA_START": _ints(start),
            "FRAMES": _ints(min(frames, FULL)),
            "LONG_FRAMES": _floats(frames),
            **_lists("LABELS", names),
            **_lists("DESCRIPTIONS", [""] * len(names)),
            "UNITS": _texts(["mm"]),
            "X_SCREEN": _texts(["+X"]),
            "Y_SCREEN": _texts(["+Y"]),
        },
        "ANALOG": {
            "USED": _ints(0),
            "LABELS": _texts([]),
            "DESCRIPTIONS": _texts([]),
            "GEN_SCALE": _floats(1),
            "SCALE": _many(4, []),
            "OFFSET": _many(2, []),
            "UNITS": _texts([]),
            "RATE": _floats(float(motion.rate)),
        },
        "FORCE_PLATFORM": {"USED": _ints(0)},
        "TRIAL": {
            "ACTUAL_START_FIELD": _many(2, [1, 0]),
            "ACTUAL_END_FIELD": _many(2, [frames & FULL, frames >> 16]),
        },
    }


def _entry(name: str, number: int, body: bytes) -> bytes:
    """Return a link of the chain."""
    link = struct.pack("<bb", len(name), number) + name.encode()
    return link + struct.pack("<H", len(body) + 2) + body


def _value(value: Value) -> bytes:
    kind, sizes, data = value
    return struct.pack("<bB", kind, len(sizes)) + bytes(sizes) + data + b"\0"


def _many(kind: int, values: Sequence[float]) -> Value:
    return kind, (len(values),), PROCESSORS[_INTEL].written(values, kind)


def _ints(value: int) -> Value:
    return 2, (), PROCESSORS[_INTEL].written([value], 2)


def _floats(value: float) -> Value:
    return 4, (), PROCESSORS[_INTEL].written([value], 4)


def _texts(texts: Sequence[str]) -> Value:
    data = [_cut(text) for text in texts]
    width = max(map(len, data), default=0)
    return TEXT, (width, len(data)), b"".join(it.ljust(width) for it in data)


def _cut(text: str) -> bytes:
    """Return a text in the bytes that there is room for."""
    return text.encode()[:_WIDEST].decode(errors="ignore").encode()


def _lists(name: str, texts: Sequence[str]) -> dict[str, Value]:
    """Return a list of texts by its parameters: LABELS, LABELS2 ..."""
    pieces = [texts[at : at + _LIST] for at in range(0, len(texts), _LIST)] or [()]
    return {name + ("" if it == 1 else str(it)): _texts(piece)
            for it, piece in enumerate(pieces, 1)}  # fmt: skip
