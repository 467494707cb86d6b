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
    """Where a parameter's values lie.

    Attributes
    ----------
    kind : int
        -1 text, 1 bytes, 2 integers, 4 floats: the bytes of one value.
    sizes : tuple of int
        Of its dimensions, the first running fastest; of text the first is its width.
    at : int
        The first byte, in the section.
    """

    kind: int
    sizes: tuple[int, ...]
    at: int

    @property
    def count(self) -> int:
        """How many values or, of text, characters."""
        return math.prod(self.sizes)


class Parameters:
    """All parameters of a file.

    Parameters
    ----------
    data : bytes
        The section, at most to where the data begin.
    processor : Processor
        How its numbers are written.

    Attributes
    ----------
    found : dict of str to Parameter
        By ``GROUP:NAME``.
    doubts : tuple of str
        What is wrong with the chain.
    """

    def __init__(self, data: bytes, processor: Processor) -> None:
        self.data, self.processor = data, processor
        self.found: dict[str, Parameter] = {}
        self.doubts: tuple[str, ...] = ()
        self._follow()

    def _follow(self) -> None:
        """Go through the chain; a broken one is followed as far as it goes."""
        data = self.data
        groups: dict[int, str] = {}
        entries: list[tuple[int, str, Parameter]] = []
        at = 4
        while at + 2 <= len(data) and data[at]:
            length = min(data[at], 256 - data[at])  # below 0: locked
            name = text(data[at + 2 : at + 2 + length]).upper()
            number, link = data[at + 1], at + 2 + length
            entry = data[link : link + 4]
            if len(entry) < 4:
                self.doubts = (f"its parameters break off at {shown(name)!r}",)
                break
            if number > 127:
                groups[256 - number] = name
            else:
                first = link + 4 + entry[3]
                one = Parameter((entry[2] ^ 128) - 128, tuple(data[link + 4 : first]), first)
                if one.kind in _KINDS and first + one.count * abs(one.kind) <= len(data):
                    entries.append((number, name, one))
                else:
                    self.doubts = (f"its parameter {shown(name)!r} is damaged",)
            onwards = int(self.processor.ints(entry, 1)[0]) & 0xFFFF
            at = link + onwards if onwards else len(data)
        for number, name, one in entries:
            self.found.setdefault(f"{groups.get(number, number)}:{name}", one)

    def numbers(self, key: str) -> tuple[float, ...]:
        """Return the numbers of a parameter; none where there is none, or it is text."""
        one = self.found.get(key)
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
        if not values or not 0 <= abs(values[0]) < 2**31:
            return None
        if self.found[key].kind == 4:
            return int(values[0]) if values[0] >= 0 else None
        low, high = (int(value) & 0xFFFF for value in (*values, 0)[:2])
        return low + (high << 16)

    def texts(self, key: str) -> tuple[str, ...]:
        """Return the texts of a parameter and of those that carry it on: LABELS, LABELS2 ..."""
        found: list[str] = []
        for number in ("", *map(str, range(2, 257))):
            one = self.found.get(key + number)
            if one is None or one.kind != TEXT:
                break
            width = one.sizes[0] if one.sizes else 1
            stop = one.at + one.count
            found += [text(self.data[at : at + width]) for at in range(one.at, stop, width or 1)]
        return tuple(found)

    def put(self, data: bytearray, key: str, values: Sequence[float]) -> None:
        """Write numbers over the first ones of a parameter, if there is one, in a copy."""
        one = self.found.get(key)
        if one is not None and one.kind != TEXT:
            written = self.processor.written(values[: one.count], one.kind)
            data[one.at : one.at + len(written)] = written

    def put_count(self, data: bytearray, key: str, count: int) -> None:
        """Write a number of things as `count` reads it; 65,535 where a larger one has no room."""
        one = self.found.get(key)
        if one is not None:
            halves = (count & 0xFFFF, count >> 16) if one.count > 1 else (min(count, FULL),)
            self.put(data, key, (float(count),) if one.kind == 4 else halves)


def text(data: bytes) -> str:
    """Return a text without the blanks that fill it up."""
    stripped = data.partition(b"\0")[0].strip()
    try:
        return stripped.decode()
    except UnicodeDecodeError:
        return stripped.decode("latin-1")
