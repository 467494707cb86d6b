"""The parameters of a C3D file: groups, names, values; and how three processors write numbers.

Sources: *The C3D File Format, User Guide*, Motion Lab Systems (c3d.org), "The parameter section",
"Processor types"; *VAX Architecture Reference Manual* (1987), F_floating.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import shown


@dataclass(frozen=True, slots=True)
class Processor:
    """How one kind of processor writes numbers."""

    name: str  # as people call it
    order: str  # ``<``, the low byte first, or ``>``
    # whether its floats are those of the VAX: halves exchanged, exponents greater by two
    dec: bool = False

    def ints(self, data: Any, count: int = -1, offset: int = 0) -> NDArray[np.int16]:
        """Return integers of 16 bits, a view."""
        return np.frombuffer(data, self.order + "i2", count, offset)

    def floats(self, data: Any, count: int = -1, offset: int = 0) -> NDArray[np.float32]:
        """Return floats of 32 bits, a view unless they are DEC's."""
        if not self.dec:
            return np.frombuffer(data, self.order + "f4", count, offset)
        return from_dec(np.frombuffer(data, "<u4", count, offset))

    def written(self, values: Any, kind: int) -> bytes:
        """Return numbers as bytes, of a parameter's kind: 1 and 2, integers; 4, floats."""
        if kind == 4 and self.dec:
            return to_dec(np.asarray(values, np.float32)).tobytes()
        code = {1: "u1", 2: "i2", 4: "f4"}[kind]
        array = np.asarray(values)
        if kind == 2:
            array = array.astype(np.int64).astype(np.uint16).view(np.int16)
        return array.astype(self.order + code).tobytes()


PROCESSORS: Mapping[int, Processor] = {
    84: Processor("Intel", "<"),
    85: Processor("DEC", "<", dec=True),
    86: Processor("MIPS", ">"),
}
"""By the fourth byte of the parameters."""


def from_dec(words: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Return VAX F floats, the halves of each exchanged, as numbers.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.formats.c3d.parameters import from_dec
    >>> from_dec(np.array([0x00004348], np.uint32))  # POINT:RATE of a file of 50 Hz
    array([50.], dtype=float32)
    """
    values = ((words >> np.uint32(16)) | (words << np.uint32(16))).view(np.float32)
    with np.errstate(invalid="ignore"):  # of damaged files
        values *= np.float32(0.25)
    return values


def to_dec(values: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Return numbers as VAX F floats."""
    words = (np.ascontiguousarray(values, np.float32) * np.float32(4)).view(np.uint32)
    exchanged: NDArray[np.uint32] = (words >> np.uint32(16)) | (words << np.uint32(16))
    return exchanged.astype("<u4")


FULL = 0xFFFF
"""The most that one integer of a C3D file counts."""

TEXT = -1
_KINDS = (TEXT, 1, 2, 4)


@dataclass(frozen=True, slots=True)
class Parameter:
    """Where a parameter's values lie."""

    kind: int  # -1 text, 1 bytes, 2 integers, 4 floats: the bytes of one value
    # of its dimensions, the first running fastest; of text the first is its width
    sizes: tuple[int, ...]
    at: int  # the first byte, in the section

    @property
    def count(self) -> int:
        """How many values or, of text, characters."""
        return math.prod(self.sizes)


class Parameters:
    """All parameters of a file, each known by ``GROUP:NAME``."""

    def __init__(self, data: bytes, processor: Processor) -> None:
        self.data, self.processor = data, processor
        self.doubts: list[str] = []
        self._groups: dict[str, int] = {}
        self._links: dict[tuple[int, bytes], int] = {}
        self._follow()

    def _follow(self) -> None:
        """Go through the chain; a broken one is followed as far as it goes."""
        data, stop = self.data, len(self.data) - 4
        low, high = (0, 1) if self.processor.order == "<" else (1, 0)
        at = 4
        while at < stop and (length := data[at]):
            length = min(length, 256 - length)  # below 0: locked
            number, link = data[at + 1], at + 2 + length
            name = data[at + 2 : link]
            if link > stop:
                self.doubts.append(f"its parameters break off at {shown(text(name))!r}")
                break
            if number > 127:
                self._groups.setdefault(text(name).upper(), number)
            else:
                self._links.setdefault((256 - number, name.upper()), link)
            onwards = data[link + low] + 256 * data[link + high]
            at = link + onwards if onwards else stop

    def find(self, key: str) -> Parameter | None:
        """Return where a parameter's values lie; None where there is none, or it is damaged."""
        group, _, name = key.partition(":")
        link = self._links.get((self._groups.get(group, 0), name.encode()))
        if link is None:
            return None
        first = link + 4 + self.data[link + 3]
        kind = (self.data[link + 2] ^ 128) - 128
        one = Parameter(kind, tuple(self.data[link + 4 : first]), first)
        if kind in _KINDS and first + one.count * abs(kind) <= len(self.data):
            return one
        if (doubt := f"its parameter {key} is damaged") not in self.doubts:
            self.doubts.append(doubt)
        return None

    def numbers(self, key: str) -> tuple[float, ...]:
        """Return the numbers of a parameter; none where there is none, or it is text."""
        one = self.find(key)
        if one is None or one.kind == TEXT or not one.count:
            return ()
        if one.kind == 4:
            return tuple(self.processor.floats(self.data, one.count, one.at).tolist())
        if one.kind == 2:
            return tuple(self.processor.ints(self.data, one.count, one.at).tolist())
        return tuple(self.data[one.at : one.at + one.count])

    def count(self, key: str) -> int | None:
        """Return a number of things, of 32 bits where two integers of 16 tell it; else None."""
        values = self.numbers(key)
        if not values or not abs(values[0]) < 2**31:
            return None
        if isinstance(values[0], float):
            return int(values[0]) if values[0] >= 0 else None
        low, high = (int(value) & 0xFFFF for value in (*values, 0)[:2])
        return low + (high << 16)

    def texts(self, key: str) -> tuple[str, ...]:
        """Return the texts of a parameter and of those that carry it on: LABELS, LABELS2 ..."""
        found: list[str] = []
        for number in range(1, 257):
            one = self.find(f"{key}{number}" if number > 1 else key)
            if one is None or one.kind != TEXT:
                break
            width = one.sizes[0] if one.sizes else 1
            found += texts(self.data[one.at : one.at + one.count], width)
        return tuple(found)

    def put(self, data: bytearray, key: str, values: Sequence[float]) -> None:
        """Write numbers over the first ones of a parameter, if there is one, in a copy."""
        one = self.find(key)
        if one is not None and one.kind != TEXT:
            written = self.processor.written(values[: one.count], one.kind)
            data[one.at : one.at + len(written)] = written

    def put_count(self, data: bytearray, key: str, count: int) -> None:
        """Write a number of things as `count` reads it; 65,535 where a larger one has no room."""
        one = self.find(key)
        if one is not None:
            halves = (count & 0xFFFF, count >> 16) if one.count > 1 else (min(count, FULL),)
            self.put(data, key, (float(count),) if one.kind == 4 else halves)


def texts(data: bytes, width: int) -> list[str]:
    """Return texts of one width."""
    if data.isascii() and b"\0" not in data:
        whole = data.decode()
        return [whole[at : at + width].strip() for at in range(0, len(whole), width or 1)]
    return [text(data[at : at + width]) for at in range(0, len(data), width or 1)]


def text(data: bytes) -> str:
    """Return a text without the blanks that fill it up."""
    stripped = data.partition(b"\0")[0].strip()
    try:
        return stripped.decode()
    except UnicodeDecodeError:
        return stripped.decode("latin-1")
