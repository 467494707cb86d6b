"""Small C3D files, written independently of the package."""

import math
import struct
from collections.abc import Mapping, Sequence

import numpy as np

STANDING = {
    "LFHD": (60, 60, 1600), "RFHD": (60, -60, 1600), "LBHD": (-60, 60, 1600),
    "RBHD": (-60, -60, 1600), "C7": (-60, 0, 1450), "T10": (-90, 0, 1200), "CLAV": (60, 0, 1400),
    "STRN": (80, 0, 1250), "LSHO": (0, 180, 1420), "LELB": (0, 260, 1130), "LWRA": (30, 280, 880),
    "LWRB": (-30, 280, 880), "LFIN": (0, 290, 800), "RSHO": (0, -180, 1420),
    "RELB": (0, -260, 1130), "RWRA": (30, -280, 880), "RWRB": (-30, -280, 880),
    "RFIN": (0, -290, 800), "LASI": (90, 120, 950), "RASI": (90, -120, 950),
    "LPSI": (-90, 50, 970), "RPSI": (-90, -50, 970), "LKNE": (0, 140, 500), "RKNE": (0, -140, 500),
    "LANK": (0, 120, 90), "RANK": (0, -120, 90), "LTOE": (160, 130, 40), "RTOE": (160, -130, 40),
}  # fmt: skip
"""Markers of Plug-in Gait on somebody who looks along +x: millimetres, z up."""

ORDERS = {84: "<", 85: "<", 86: ">"}


def standing(frames: int = 5, step: float = 10.0) -> np.ndarray:
    """Return the person walking along: (T, M, 4), the last number a residual of 0."""
    places = np.zeros((frames, len(STANDING), 4))
    places[..., :3] = list(STANDING.values())
    places[..., 0] += step * np.arange(frames)[:, None]
    return places


def vax(value: float) -> bytes:
    """Return a VAX F float: 0.1m * 2 ** (exponent - 128), the halves exchanged."""
    if value == 0:
        return bytes(4)
    fraction, exponent = math.frexp(abs(value))
    mantissa = round(fraction * 2**24) - 2**23
    word = (value < 0) << 31 | (exponent + 128) << 23 | mantissa
    return struct.pack("<HH", word >> 16, word & 0xFFFF)


def number(value: float, kind: int, processor: int) -> bytes:
    """Return a number of a parameter."""
    if kind == 4 and processor == 85:
        return vax(value)
    if kind == 4:
        return struct.pack(ORDERS[processor] + "f", value)
    if kind == 1:
        return bytes([int(value)])
    return struct.pack(ORDERS[processor] + "H", int(value) & 0xFFFF)


def parameter(value: object, processor: int) -> bytes:
    """Return a parameter: text or texts, a float or floats, an int or ints, an array."""
    if isinstance(value, str):
        return bytes((255, 1, len(value))) + value.encode()
    if isinstance(value, np.ndarray):
        flat = b"".join(number(it, 4, processor) for it in value.ravel().tolist())
        return bytes((4, value.ndim, *value.shape[::-1])) + flat
    values = list(value) if isinstance(value, list | tuple) else [value]
    if values and isinstance(values[0], str):
        data = [it.encode() for it in values]
        width = max(map(len, data))
        return bytes((255, 2, width, len(data))) + b"".join(it.ljust(width) for it in data)
    kind = 4 if values and isinstance(values[0], float) else 2
    sizes = (1, len(values)) if isinstance(value, list | tuple) else (0,)
    flat = b"".join(number(it, kind, processor) for it in values)
    return bytes((kind, *sizes)) + flat


def section(told: Mapping[str, object], processor: int) -> bytes:
    """Return the parameters, in whole blocks; groups stand behind what is in them."""
    groups = list(dict.fromkeys(key.partition(":")[0] for key in told))
    order = "<" if processor != 86 else ">"
    chain = b""
    for key, value in told.items():
        group, _, name = key.partition(":")
        body = parameter(value, processor) + b"\0"
        chain += struct.pack("bb", len(name), groups.index(group) + 1) + name.encode()
        chain += struct.pack(order + "H", len(body) + 2) + body
    for index, group in enumerate(groups, 1):
        chain += struct.pack("bb", -len(group), -index) + group.encode()
        chain += struct.pack(order + "H", 3) + b"\0"
    size = -(-(4 + len(chain) + 1) // 512)
    return (bytes((1, 0x50, min(size, 255), processor)) + chain).ljust(size * 512, b"\0")


def c3d(
    points: np.ndarray,
    labels: Sequence[str] = tuple(STANDING),
    *,
    processor: int = 84,
    scale: float = -1.0,
    rate: float = 100.0,
    first: int = 1,
    analog: np.ndarray | None = None,
    more: Mapping[str, object] | None = None,
    words: Mapping[int, int] | None = None,
    behind: bytes = b"",
) -> bytes:
    """Return a file.

    `points` are (T, M, 4), in steps of `scale` where that is above 0; `analog` is (T, N); `more`
    are parameters beside or instead of the usual ones, None leaves one out; `words` of the header,
    counted from 1, stand for what should be there; `behind` comes behind the data.
    """
    frames, width = points.shape[:2]
    order, kind = ORDERS[processor], 4 if scale < 0 else 2
    counted = 0 if analog is None else analog.shape[1]
    told: dict[str, object] = {
        "POINT:USED": width, "POINT:SCALE": float(scale), "POINT:RATE": float(rate),
        "POINT:FRAMES": min(frames, 65535), "POINT:DATA_START": 0, "POINT:LABELS": list(labels),
        "POINT:UNITS": ["mm"], "ANALOG:USED": counted,
    } | dict(more or {})  # fmt: skip
    told = {key: value for key, value in told.items() if value is not None}
    start = 2 + len(section(told, processor)) // 512
    if told.get("POINT:DATA_START") == 0:
        told["POINT:DATA_START"] = start
    head = bytearray(512)
    head[:2] = 2, 0x50
    last = min(first + frames - 1, 65535)
    values = {2: width, 3: counted, 4: first, 5: last, 9: start, 10: 1, **dict(words or {})}
    for word, value in values.items():
        head[2 * word - 2 : 2 * word] = struct.pack(order + "H", value)
    head[12:16], head[20:24] = number(scale, 4, processor), number(rate, 4, processor)
    rows = [points.reshape(frames, -1), *([] if analog is None else [analog])]
    table = np.concatenate(rows, axis=1)
    if kind == 4 and processor == 85:
        data = b"".join(vax(float(np.float32(it))) for it in table.ravel().tolist())
    else:
        data = table.astype(order + ("f4" if kind == 4 else "i2")).tobytes()
    data += bytes(-len(data) % 512)
    return bytes(head) + section(told, processor) + data + behind
