"""Read decimal numbers from text in a compiled loop (extra ``fast``).

The numbers are equal to those of `lanindex.formats.decimals`, bit by bit. As there, a row with a
number that is not plain is left to `float`.
"""

import numba
import numpy as np

from lanindex.formats.decimals import DIGITS, TENS

# unsigned: numba then neither tests an index for a negative value nor widens a byte
_INDEX_0, _ONE, _MOST = np.uintp(0), np.uintp(1), np.uintp(DIGITS)
_U64_0, _TEN = np.uint64(0), np.uint64(10)
_MINUS, _PLUS, _POINT, _ASCII_0, _E = map(np.uint8, b"-+.0e")
_SPACE, _TAB, _BLANKS, _BASE, _SMALL = map(np.uint8, (32, 9, 5, 10, 32))
_POWERS = len(TENS)


@numba.njit
def _blank(byte):
    """Return whether a byte is a space, or one of the five from tab to carriage return."""
    return byte == _SPACE or np.uint8(byte - _TAB) < _BLANKS


@numba.njit
def _digits(text, at, stop, value):
    """Append digits to a number; return the number and the position behind the last digit."""
    while at < stop and np.uint8(text[at] - _ASCII_0) < _BASE:
        value = value * _TEN + np.uint64(text[at] - _ASCII_0)
        at += _ONE
    return value, at


@numba.njit
def _signed(text, at):
    """Return whether a number has a minus sign, and the position behind its sign."""
    negative = text[at] == _MINUS
    return negative, at + _ONE if negative or text[at] == _PLUS else at


@numba.njit
def _number(text, at, stop):
    """Return a number, the position behind it, and whether it is plain."""
    negative, at = _signed(text, at)
    first, power = at, np.int64(0)
    whole, at = _digits(text, at, stop, _U64_0)
    count = at - first
    if at < stop and text[at] == _POINT:
        first = at + _ONE
        whole, at = _digits(text, first, stop, whole)
        power = np.int64(at - first)
        count += at - first
    plain = _INDEX_0 < count <= _MOST
    if plain and at + _ONE < stop and text[at] | _SMALL == _E:
        down, first = _signed(text, at + _ONE)
        exponent, at = _digits(text, first, stop, _U64_0)
        plain = first < at <= first + _MOST
        power += np.int64(exponent) if down else -np.int64(exponent)
    if not plain or power < 0 or power >= _POWERS:
        return 0.0, at, False
    value = np.float64(whole) / TENS[power]
    return -value if negative else value, at, True


@numba.njit
def _spaced(text, at, stop, width, slots, row, odd, many):
    """Read a line of numbers between blanks into `row`; return whether it is complete.

    What is not plain is listed in `odd`, `many` so far: slot and bytes; return how many then.
    """
    column = 0
    while True:
        while at < stop and _blank(text[at]):
            at += _ONE
        if at >= stop:
            return column >= len(slots), many
        slot = slots[column] if column < len(slots) else -1
        if slot >= 0:
            begin = at  # inlined for numbers without an exponent: a third faster than `_number`
            negative, at = _signed(text, at)
            first, power = at, _INDEX_0
            whole, at = _digits(text, at, stop, _U64_0)
            count = at - first
            if at < stop and text[at] == _POINT:
                first = at + _ONE
                whole, at = _digits(text, first, stop, whole)
                power = at - first
                count += power
            if _INDEX_0 < count <= _MOST and (at >= stop or _blank(text[at])):
                value = np.float64(whole) / TENS[power]
                row[slot] = -value if negative else value
            else:
                row[slot], at, plain = _number(text, begin, stop)
                if not plain or (at < stop and not _blank(text[at])):
                    if many == len(odd):
                        return False, many
                    while at < stop and not _blank(text[at]):
                        at += _ONE
                    odd[many, 1], odd[many, 2], odd[many, 3] = slot, begin, at
                    many += 1
        elif column >= width:
            return False, many
        else:
            while at < stop and not _blank(text[at]):
                at += _ONE
        column += 1


@numba.njit
def _separated(text, at, stop, separator, width, slots, row):
    """Read a line of separated cells into `row`; return whether it is complete and plain."""
    column = 0
    while True:
        while at < stop and _blank(text[at]) and text[at] != separator:
            at += _ONE
        slot = slots[column] if column < len(slots) else -1
        if slot < 0:
            if column >= width and at < stop and text[at] != separator:
                return False
            while at < stop and text[at] != separator:
                at += _ONE
        elif at >= stop or text[at] == separator:
            row[slot] = np.nan
        else:
            row[slot], at, plain = _number(text, at, stop)
            while at < stop and text[at] != separator and _blank(text[at]):
                at += _ONE
            if not plain or (at < stop and text[at] != separator):
                return False
        column += 1
        if at >= stop:
            return column >= len(slots)
        at += _ONE


@numba.njit(cache=True, nogil=True)
def fill(text, lines, separator, width, slots, values, row_ok, odd):
    """Read the lines in which every number is plain, as `lanindex.formats.decimals.fill` does.

    Return how many numbers go to `float`, listed in `odd` (O, 4): row, slot, bytes, half-open.
    """
    many = 0
    for row in range(len(lines)):
        start, stop = np.uintp(lines[row, 0]), np.uintp(lines[row, 1])
        if separator == _SPACE:
            begun = many
            row_ok[row], many = _spaced(text, start, stop, width, slots, values[row], odd, many)
            odd[begun:many, 0] = row
        else:
            row_ok[row] = _separated(text, start, stop, separator, width, slots, values[row])
    return many
