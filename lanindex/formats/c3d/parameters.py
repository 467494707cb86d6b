"""The parameters of a C3D file: a chain of groups, and of what each group holds.

Source: *The C3D File Format, User Guide*, Motion Lab Systems (c3d.org), "The parameter section".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from lanindex.errors import shown
from lanindex.formats.c3d.processors import Processor

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
