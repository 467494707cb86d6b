"""Decimal numbers out of text, many at once: eight digits are one word of 64 bits.

A number's digits make a whole number below 2^53, which is divided by a power of ten up to 10^22:
a float holds both exactly, so it is rounded once, as `float` rounds it. What has more digits is
left to `float`, as is what is no number: between blanks the number alone, if few are so, else the
row.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lanindex import compiled

LARGEST = 1e9
"""Numbers beyond this are taken for damage."""

PIECE = 1 << 17  # bytes worked on at a time: what comes between stays in the processor's cache

_EIGHT = 8
DIGITS = 15  # so many are below 2^53
TENS = 10.0 ** np.arange(23)
_SIGNS = np.array([1.0, -1.0])
_LINE, _RETURN, _SPACE, _PLUS, _MINUS, _E = b"\n\r +-e"
_BLANK = np.isin(np.arange(256), list(b" \t\r\n\v\f"))
RARE = 16  # numbers, of which at most one goes to `float` by itself; where more do rows are quicker
_STRIPPED = 4  # blanks on a side of a cell; where there are more `float` takes them off

_LAST = np.array([(1 << 64) - (1 << 8 * (_EIGHT - n)) for n in range(_EIGHT + 1)], np.uint64)
_ONES, _POINTS, _ZEROS, _OVER, _HIGH = (
    np.uint64(byte * 0x0101010101010101) for byte in (0x01, ord("."), ord("0"), 0x76, 0x80)
)  # a byte above nine and _OVER make _HIGH
_PLACES = np.uint64(0x0706050403020100)
_PAIRS = np.uint64(0x000000FF000000FF)
_EVEN, _ODD = np.uint64(100 + (1000000 << 32)), np.uint64(1 + (10000 << 32))
_ONE, _SEVEN, _BYTE, _TEN, _TWO, _HALF, _TOP = map(np.uint64, (1, 7, 8, 10, 16, 32, 56))

Floats = NDArray[np.float64]
Places = NDArray[np.int64]
Words = NDArray[np.uint64]
Flags = NDArray[np.bool_]


def fill(
    values: Floats, data: bytes, lines: Places, separator: bytes, columns: Sequence[int], width: int
) -> Flags:
    """Read the lines, (T, 2), in which every number is plain, (T, C); tell which, (T,)."""
    read, wanted = np.zeros(len(lines), bool), np.array(columns)
    if compiled.chosen("numbers", len(data)):
        from lanindex.formats import decimals_fast

        slots = np.full(wanted.max() + 1, -1)  # of each column, which of the values it is
        slots[wanted] = np.arange(len(wanted))
        text, mark = np.frombuffer(data, np.uint8), np.uint8(separator[0])
        odd = np.empty((values.size // RARE, 4), np.int64)
        many = decimals_fast.fill(text, lines, mark, width, slots, values, read, odd)
        for row, slot, first, stop in odd[:many].tolist():
            values[row, slot], plain = _number(data[first:stop])
            read[row] &= plain
        return read
    start = 0
    while start < len(lines):
        stop = int(np.searchsorted(lines[:, 1], lines[start, 0] + PIECE))
        piece = slice(start, max(stop, start + 1))
        read[piece] = _piece(values[piece], data, lines[piece], separator, wanted, width)
        if 2 * np.count_nonzero(read[piece]) < piece.stop - start:
            break  # numbers of this kind are better read one by one
        start = piece.stop
    return read


def _piece(
    values: Floats, data: bytes, lines: Places, separator: bytes, wanted: Places, width: int
) -> Flags:
    """Read a few lines."""
    begin = int(lines[0, 0]) - _EIGHT
    text = b"".join((bytes(_EIGHT), data[begin + _EIGHT : int(lines[-1, 1])], b"\n"))
    starts, stops = _cells(text, separator)
    first, last = (np.searchsorted(starts, lines[:, side] - begin) for side in (0, 1))
    some = np.append(0, np.cumsum(stops > starts))
    good: Flags = last - first > wanted.max()
    good &= some[last] == some[np.minimum(first + width, last)]
    found, plain = _numbers(text, starts, stops)
    cells = first[good, None] + wanted
    odd = np.unique(cells[~plain[cells]])
    if separator == b" " and RARE * len(odd) <= cells.size:
        for cell, first, stop in zip(odd.tolist(), starts[odd], stops[odd], strict=True):
            found[cell], plain[cell] = _number(text[first:stop])
    values[good] = found[cells]
    good[good] = plain[cells].all(axis=1)
    return good


def _number(word: bytes) -> tuple[float, bool]:
    """Return a number as `float` reads it, and whether it is one."""
    try:
        return float(word), b"_" not in word  # 1_0 is none
    except ValueError:
        return np.nan, False


def _cells(text: bytes, separator: bytes) -> tuple[Places, Places]:
    """Return the bytes of the cells of a text that begins with eight bytes of nothing."""
    letters = np.frombuffer(text, np.uint8)[_EIGHT:]
    if separator == b" ":
        marks = np.flatnonzero(letters <= _SPACE)
        blank = _BLANK[letters[marks]]  # other bytes are left to what knows them
        marks = marks if blank.all() else marks[blank]
    else:
        line = _LINE if b"\n" in text[:-1] else _RETURN
        marks = np.flatnonzero((letters == ord(separator)) | (letters == line))
        marks = marks if line == _LINE else np.append(marks, len(letters) - 1)
    stops = marks + _EIGHT
    starts = np.append(_EIGHT, stops[:-1] + 1)
    if separator == b" ":
        some = stops > starts
        return starts[some], stops[some]
    return _strip(text, starts, stops)


def _strip(text: bytes, starts: Places, stops: Places) -> tuple[Places, Places]:
    """Take blanks off the cells."""
    letters = np.frombuffer(text, np.uint8)
    for _ in range(_STRIPPED):
        blank = _BLANK[letters[starts]] & (starts < stops)
        starts = starts + blank
        over = _BLANK[letters[stops - 1]] & (starts < stops)
        stops = stops - over
        if not (blank.any() or over.any()):
            break
    return starts, stops


def _numbers(text: bytes, starts: Places, stops: Places) -> tuple[Floats, Flags]:
    """Read the numbers of cells, and tell which are plain."""
    letters = np.frombuffer(text, np.uint8)
    # from each byte on, the eight there as one number
    words = np.ndarray((len(text) - _EIGHT + 1,), "<u8", text, strides=(1,))
    blank = starts == stops
    first = letters[starts]
    negative = first == _MINUS
    begun = starts + (negative | (first == _PLUS))
    ended, exponent = stops, None
    if b"e" in text or b"E" in text:
        ended, exponent = _exponents(words, letters, starts, stops)
    last = words[ended - _EIGHT]
    pointed, fraction = _behind_point(last, ended - begun)
    point = ended - fraction
    point -= pointed
    whole = point - begun
    digits = whole + fraction
    plain = (whole <= _EIGHT) & (digits > 0) & (digits <= DIGITS)
    before, sound = _eight(words[point - _EIGHT], whole)
    plain &= sound
    behind, sound = _eight(last, fraction)
    plain &= sound
    values = before * TENS[fraction]
    values += behind
    if exponent is not None:
        fraction -= exponent
        plain &= (fraction >= 0) & (fraction < len(TENS))
        fraction[~plain] = 0
    values /= TENS[fraction]
    values *= _SIGNS[negative.view(np.uint8)]
    values[~plain | blank] = np.nan
    return values, plain | blank


def _exponents(
    words: Words, letters: NDArray[np.uint8], starts: Places, stops: Places
) -> tuple[Places, Places]:
    """Return where the digits before an exponent end, and the exponents: huge if it is none."""
    marks = np.flatnonzero((letters | 0x20) == _E)
    cells = np.searchsorted(stops, marks, "right")
    ended, exponent = stops.copy(), np.zeros_like(stops)
    ended[cells] = marks
    sign = letters[np.minimum(marks + 1, stops[cells] - 1)]
    negative = sign == _MINUS
    length = stops[cells] - marks - 1 - (negative | (sign == _PLUS))
    size, sound = _eight(words[stops[cells] - _EIGHT], length)
    size[~sound | (length <= 0)] = 1e9
    exponent[cells] = np.where(negative, -size, size).astype(np.int64)
    return ended, exponent


def _behind_point(last: Words, lengths: Places) -> tuple[Flags, Places]:
    """Return whether a point is in the last eight bytes of cells, and how many stand behind it."""
    other = last ^ _POINTS
    found = other - _ONES
    found &= ~other
    found &= _HIGH
    found &= _LAST[np.minimum(lengths, _EIGHT)]
    lowest = found & (~found + _ONE)
    lowest >>= _SEVEN
    lowest *= _PLACES
    lowest >>= _TOP
    return found != 0, lowest.view(np.int64)


def _eight(digits: Words, lengths: Places) -> tuple[Floats, Flags]:
    """Return the whole numbers that the last digits of words make, and which are all digits."""
    digits = digits ^ _ZEROS
    digits &= _LAST[np.minimum(lengths, _EIGHT)]
    over = digits + _OVER
    over |= digits
    over &= _HIGH
    tens = digits >> _BYTE
    digits *= _TEN
    digits += tens
    odd = digits >> _TWO
    odd &= _PAIRS
    odd *= _ODD
    digits &= _PAIRS
    digits *= _EVEN
    digits += odd
    digits >>= _HALF
    return digits.astype(np.float64), (over == 0) & (lengths <= _EIGHT)
