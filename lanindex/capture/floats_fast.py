"""Numbers out of text, frame by frame: the compiled path (extra ``fast``).

A number is whole digits times a power of ten. Where both are exact as floats, one multiplication
or division rounds correctly; up to 19 digits, the division's remainder tells the rest. What is
left (longer, or with a large exponent, or too close to the middle between two floats to tell) is
handed to Python's ``float``.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from lanindex.capture.bvh_hierarchy import LARGEST

_TENS = np.array([10.0**power for power in range(23)])
_EXACT = np.uint64(1 << 53)
_SPLIT = 134217729.0  # 2**27 + 1 halves a float's digits
_DOUBT = 2.0**-40
_NONE, _HARD, _BAD = 0, 1, 2


@numba.njit(cache=True)
def _quotient(whole, power):  # type: ignore[no-untyped-def]  # numba
    """Return whole / power correctly rounded, or NaN where that cannot be told."""
    high = np.float64(whole)
    low = np.float64(np.int64(whole - np.uint64(high)))
    quotient = high / power
    part = _SPLIT * quotient
    q_high = part - (part - quotient)
    q_low = quotient - q_high
    part = _SPLIT * power
    p_high = part - (part - power)
    p_low = power - p_high
    product = quotient * power
    error = ((q_high * p_high - product) + q_high * p_low + q_low * p_high) + q_low * p_low
    rest = (((high - product) - error) + low) / power
    upper, lower = quotient + rest * (1 + _DOUBT), quotient + rest * (1 - _DOUBT)
    return upper if upper == lower else np.nan


@numba.njit(cache=True)
def _value(whole, digits, power):  # type: ignore[no-untyped-def]  # numba
    """Return whole times ten to the power, or NaN where Python has to do it."""
    if whole == 0 and digits <= 19:
        return 0.0
    if digits > 19 or power < -22 or power > 22:
        return np.nan
    if whole <= _EXACT:
        return np.float64(whole) * _TENS[power] if power >= 0 else np.float64(whole) / _TENS[-power]
    return _quotient(whole, _TENS[-power]) if power <= 0 else np.nan


@numba.njit(cache=True)
def _number(text, at, stop):  # type: ignore[no-untyped-def]  # numba
    """Read one number; return its value, the byte behind it, and whether it is one."""
    negative = text[at] == 45
    if negative or text[at] == 43:
        at += 1
    whole, digits, power, any_digit = np.uint64(0), 0, 0, False
    point = False
    while at < stop:
        digit = np.uint8(text[at] - 48)
        if digit < 10:
            any_digit = True
            if digits or digit:
                digits += 1
            if digits <= 19:
                whole = whole * np.uint64(10) + np.uint64(digit)
            power -= point
        elif digit == 254 and not point:
            point = True
        else:
            break
        at += 1
    if any_digit and at < stop and (text[at] | 32) == 101:
        at += 1
        down = at < stop and text[at] == 45
        if at < stop and (text[at] == 45 or text[at] == 43):
            at += 1
        any_digit, exponent = False, 0
        while at < stop and np.uint8(text[at] - 48) < 10:
            any_digit = True
            if exponent < 100_000:
                exponent = exponent * 10 + int(text[at] - 48)
            at += 1
        power += -exponent if down else exponent
    value = _value(whole, digits, power)
    return -value if negative else value, at, any_digit


@numba.njit(cache=True)
def _frame(text, at, stop, row):  # type: ignore[no-untyped-def]  # numba
    """Read one line into `row`; NaN stands where Python has to read the number."""
    count, hard = 0, False
    while True:
        while at < stop and (text[at] == 32 or 9 <= text[at] <= 13):
            at += 1
        if at >= stop:
            break
        if count == len(row):
            return _BAD
        value, at, sound = _number(text, at, stop)
        if not sound or (at < stop and not (text[at] == 32 or 9 <= text[at] <= 13)):
            return _BAD
        if np.isnan(value):
            hard = True
        elif abs(value) > LARGEST:
            return _BAD
        row[count] = value
        count += 1
    if count != len(row):
        return _BAD
    return _HARD if hard else _NONE


@numba.njit(cache=True, nogil=True)
def _frames(text, frames, values, states):  # type: ignore[no-untyped-def]  # numba
    for row in range(len(frames)):
        states[row] = _frame(text, frames[row, 0], frames[row, 1], values[row])
        if states[row] == _BAD:
            return row
    return -1


def parse(
    data: bytes, frames: NDArray[np.int64], width: int
) -> tuple[NDArray[np.float64], int | None]:
    """Read the numbers of each frame: see `lanindex.capture.floats.parse`."""
    values = np.empty((len(frames), width))
    states = np.zeros(len(frames), np.uint8)
    bad = int(_frames(np.frombuffer(data, np.uint8), frames, values, states))
    for row in np.flatnonzero(states == _HARD).tolist():
        first, stop = frames[row].tolist()
        values[row] = list(map(float, data[first:stop].split()))
        if not (np.abs(values[row]) <= LARGEST).all():
            return values, row
    return values, bad if bad >= 0 else None
