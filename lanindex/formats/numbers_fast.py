"""Tables of numbers as text: the compiled path (extra ``fast``).

What is short and plain is read here; a row with anything else in it is left to the plain path.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from lanindex.formats import tables
from lanindex.formats.bvh.floats_fast import (
    _MINUS,
    _NIL,
    _NOTHING,
    _ONE,
    _PLUS,
    _POINT,
    _SHORT,
    _TENS,
    _blank,
    _digits,
    _number,
)  # fmt: skip
from lanindex.formats.bvh.hierarchy import LARGEST

_SPACE = np.uint8(32)
_MOST = tables.MOST


@numba.njit(inline="always")
def _value(text, at, stop, separator):
    """Read a number; return it, the byte behind it, and whether it could be read here."""
    begin = at
    negative = text[at] == _MINUS
    if negative or text[at] == _PLUS:
        at += _ONE
    first, power = at, _NOTHING
    whole, at = _digits(text, at, stop, _NIL)
    digits = at - first
    if at < stop and text[at] == _POINT:
        first = at + _ONE
        whole, at = _digits(text, first, stop, whole)
        power = at - first
        digits += power
    clean = at >= stop or text[at] == separator or _blank(text[at])
    if clean and _NOTHING < digits <= _SHORT:
        value = np.float64(whole) / _TENS[power]
        return -value if negative else value, at, True
    value, at, proper = _number(text, begin, stop)
    return value, at, proper and not np.isnan(value)


@numba.njit
def _row(text, at, stop, separator, width, slots, heads, row):
    """Read one line into `row`; tell whether all of it could be read here."""
    column, many = 0, len(slots)
    runs = separator == _SPACE
    while True:
        while at < stop and _blank(text[at]) and (runs or text[at] != separator):
            at += _ONE
        slot = slots[column] if column < many else -1
        ended = at >= stop
        if ended and runs:
            return column >= many
        if slot < 0:
            if column >= width and not ended and text[at] != separator:
                return False
            while at < stop and text[at] != separator and not (runs and _blank(text[at])):
                at += _ONE
        elif ended or text[at] == separator:
            row[slot] = np.nan
        else:
            row[slot], at, proper = _value(text, at, stop, separator)
            if not proper or abs(row[slot]) > (_MOST if slot < heads else LARGEST):
                return False
            while not runs and at < stop and text[at] != separator and _blank(text[at]):
                at += _ONE
            if at < stop and text[at] != separator and not (runs and _blank(text[at])):
                return False
        column += 1
        if at >= stop:
            return column >= many
        at += _ONE


@numba.njit(cache=True, nogil=True)
def _rows(text, lines, separator, width, slots, heads, values, read):
    for row in range(len(lines)):
        start, stop = np.uintp(lines[row, 0]), np.uintp(lines[row, 1])
        read[row] = _row(text, start, stop, separator, width, slots, heads, values[row])


def parse(
    data: bytes, lines: NDArray[np.int64], table: tables.Table
) -> tuple[NDArray[np.float64], int | None]:
    """Read some rows: see `lanindex.formats.tables.parse`."""
    slots = np.full(max(table.columns) + 1, -1, np.int64)
    slots[list(table.columns)] = np.arange(len(table.columns))
    values = np.empty((len(lines), len(table.columns)))
    read = np.zeros(len(lines), np.bool_)
    text, separator = np.frombuffer(data, np.uint8), np.uint8(table.separator[0])
    _rows(text, lines, separator, table.width, slots, len(table.heads), values, read)
    for row in np.flatnonzero(~read).tolist():
        first, stop = lines[row].tolist()
        if not tables.fill(values[row], data[first:stop], table):
            return values, row
    return values, None
