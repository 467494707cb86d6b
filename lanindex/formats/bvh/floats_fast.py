"""Numbers out of text, frame by frame: the compiled path (extra ``fast``).

A number is whole digits times a power of ten. Where both are exact as floats, one multiplication
or division rounds correctly; up to 19 digits and 10**-289, the division's remainder tells the
rest. What is left (longer, larger, or too close to the middle between two floats to tell) is handed
to Python's ``float``.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from lanindex.formats.bvh.hierarchy import LARGEST

_POWERS = 290
_TENS = np.array([float(10**power) for power in range(_POWERS)])
_TENS_REST = np.array([float(10**power - int(float(10**power))) for power in range(_POWERS)])
_EXACT = np.uint64(1 << 53)
_EXACT_POWER = 22
_SPLIT = 134217729.0  # 2**27 + 1 halves a float's digits
_DOUBT = 2.0**-40
_NONE, _HARD, _BAD = 0, 1, 2
# unsigned, so that no index is tested for being negative and no byte turns into a wider number
_NOTHING, _ONE, _SHORT = np.uintp(0), np.uintp(1), np.uintp(15)
_NIL, _TEN = np.uint64(0), np.uint64(10)
_MINUS, _PLUS, _POINT, _ZERO, _BASE, _SMALL, _E = map(np.uint8, (*b"-+.0", 10, 32, ord("e")))
_SPACE, _TAB, _FIVE = map(np.uint8, (32, 9, 5))


@numba.njit
def _quotient(whole, power):
    """Return whole / 10**power correctly rounded, or NaN where that cannot be told."""
    divisor = _TENS[power]
    high = np.float64(whole)
    low = np.float64(np.int64(whole - np.uint64(high)))
    quotient = high / divisor
    part = _SPLIT * quotient
    q_high = part - (part - quotient)
    q_low = quotient - q_high
    part = _SPLIT * divisor
    d_high = part - (part - divisor)
    d_low = divisor - d_high
    product = quotient * divisor
    error = ((q_high * d_high - product) + q_high * d_low + q_low * d_high) + q_low * d_low
    rest = ((high - product) - error) + (low - quotient * _TENS_REST[power])
    rest /= divisor
    upper, lower = quotient + rest * (1 + _DOUBT), quotient + rest * (1 - _DOUBT)
    return upper if upper == lower else np.nan


@numba.njit
def _value(whole, digits, power):
    """Return whole times ten to the power, or NaN where Python has to do it."""
    if digits > 19:
        return np.nan
    if whole <= _EXACT and power >= -_EXACT_POWER:
        if power <= 0:
            return np.float64(whole) / _TENS[-power]
        return np.float64(whole) * _TENS[power] if power <= _EXACT_POWER else np.nan
    return _quotient(whole, -power) if -_POWERS < power <= 0 and whole else np.nan


@numba.njit
def _exponent(text, at, stop):
    """Read what follows an e; return it, and the byte behind, the same byte if it is nothing."""
    begin = at
    down = at < stop and text[at] == _MINUS
    if at < stop and (text[at] == _MINUS or text[at] == _PLUS):
        at += _ONE
    first, exponent = at, np.int64(0)
    while at < stop and np.uint8(text[at] - _ZERO) < _BASE:
        if exponent < 100_000:
            exponent = exponent * 10 + np.int64(text[at] - _ZERO)
        at += _ONE
    return -exponent if down else exponent, at if at > first else begin


@numba.njit
def _digits(text, at, stop, whole):
    """Read digits; return the number they make behind `whole`, and the byte behind them."""
    while at < stop and np.uint8(text[at] - _ZERO) < _BASE:
        whole = whole * _TEN + np.uint64(text[at] - _ZERO)
        at += _ONE
    return whole, at


@numba.njit
def _number(text, at, stop):
    """Read any number; return its value, the byte behind it, and whether it is one."""
    negative = text[at] == _MINUS
    if negative or text[at] == _PLUS:
        at += _ONE
    power = np.int64(0)
    first = at
    whole, at = _digits(text, at, stop, _NIL)
    digits = np.int64(at - first)
    if at < stop and text[at] == _POINT:
        first = at + _ONE
        whole, at = _digits(text, first, stop, whole)
        power = -np.int64(at - first)
        digits -= power
    sound = digits > 0
    if sound and at < stop and (text[at] | _SMALL) == _E:
        exponent, behind = _exponent(text, at + _ONE, stop)
        sound = behind > at + _ONE
        power, at = power + exponent, behind
    value = _value(whole, digits, power)
    return -value if negative else value, at, sound


@numba.njit
def _blank(byte):
    return byte == _SPACE or np.uint8(byte - _TAB) < _FIVE


@numba.njit
def _frame(text, at, stop, row):
    """Read one line into `row`; NaN stands where Python has to read the number.

    What is short and has no exponent is read here, the rest by `_number`: a small loop is twice
    as fast.
    """
    count, state = 0, _NONE
    while True:
        while at < stop and _blank(text[at]):
            at += _ONE
        if at >= stop:
            return state if count == len(row) else _BAD
        if count == len(row):
            return _BAD
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
        sound = digits > _NOTHING and (at >= stop or _blank(text[at]))
        if sound and digits <= _SHORT:
            value = np.float64(whole) / _TENS[power]
            value = -value if negative else value
        else:
            value, at, sound = _number(text, begin, stop)
            if not sound or (at < stop and not _blank(text[at])):
                return _BAD
            if np.isnan(value):
                state = _HARD
        if abs(value) > LARGEST:
            return _BAD
        row[count] = value
        count += 1


@numba.njit(cache=True, nogil=True)
def _frames(text, frames, values, states):
    for row in range(len(frames)):
        start, stop = np.uintp(frames[row, 0]), np.uintp(frames[row, 1])
        states[row] = _frame(text, start, stop, values[row])
        if states[row] == _BAD:
            return row
    return -1


def parse(
    data: bytes, frames: NDArray[np.int64], width: int
) -> tuple[NDArray[np.float64], int | None]:
    """Read the numbers of each frame: see `lanindex.formats.bvh.floats.parse`."""
    values = np.empty((len(frames), width))
    states = np.zeros(len(frames), np.uint8)
    bad = int(_frames(np.frombuffer(data, np.uint8), frames, values, states))
    for row in np.flatnonzero(states == _HARD).tolist():
        first, stop = frames[row].tolist()
        values[row] = list(map(float, data[first:stop].split()))
        if not (np.abs(values[row]) <= LARGEST).all():
            return values, row
    return values, bad if bad >= 0 else None
