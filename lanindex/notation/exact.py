"""Numbers as notation files write them: decimals that mean exact fractions."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import lru_cache
from itertools import count

DECIMAL = re.compile(r"\d{1,9}(\.\d{0,30})?|\.\d{1,30}")
"""A number of at least 0, without sign or exponent."""


@lru_cache(maxsize=4096)
def fraction(text: str) -> Fraction:
    """Read a decimal exactly, seeing the fraction behind a rounded one.

    Thirds have no decimals: a number of six places or more that lies less than one unit of its
    last place from a fraction with a small denominator means that fraction. The largest
    denominator is 100 at six places and grows tenfold with every two more, so that fractions
    stay a hundred times further apart than the numbers that are written for them.
    """
    value = Fraction(text)
    places = len(text.partition(".")[2])
    if places < 6:
        return value
    near = value.limit_denominator(10 ** (places // 2 - 1))
    return near if abs(near - value) * 10**places < 1 else value


@lru_cache(maxsize=4096)
def number(value: Fraction) -> str:
    """Write a number as the shortest decimal that `fraction` reads as the same."""
    return next(text for places in count() if fraction(text := _rounded(value, places)) == value)


def _rounded(value: Fraction, places: int) -> str:
    digits = str(round(value * 10**places)).rjust(places + 1, "0")
    return f"{digits[: len(digits) - places]}.{digits[len(digits) - places :]}".rstrip(".")
