"""Frames a second, exactly: what a file says, or what its user says instead."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

from lanindex.errors import CaptureError, UsageError

_USUAL = (10, 500)
_SLOWEST = 1  # frames a second: a Frame Time of 30 is a rate in the wrong place
_SNAP = Fraction(2, 10_000)


def rate_of(text: str | None, place: str, wanted: Fraction | float | str | None) -> Fraction:
    """Return the frames a second."""
    if wanted is not None:
        return told_rate(wanted)
    time = _fraction(text) if text is not None else None
    if time is None or 1 / time < _SLOWEST:
        raise CaptureError(
            "no Frame Time: line" if text is None else f"Frame Time: {text[:40]!r}",
            place=place,
            wanted=f"seconds a frame, above 0 and at most {1 / _SLOWEST:g}",
            remedy="Give the rate with --fps.",
        )
    return nearest_rate(1 / time)


def told_rate(wanted: Fraction | float | str) -> Fraction:
    """Return the frames a second that the user says."""
    given = _fraction(str(wanted))
    if given is None or given < _SLOWEST:
        raise UsageError(
            f"a rate of {wanted} frames a second", wanted=f"a number of {_SLOWEST} or more"
        )
    return nearest_rate(given)


@lru_cache(maxsize=64)
def _fraction(text: str) -> Fraction | None:
    """Return a number between a millionth and 1000000 exactly, else None."""
    try:
        value = Fraction(text) if len(text) < 24 and "e" not in text.lower() else float(text)
        if not 1e-6 <= value <= 1e6 or "_" in text:
            return None
        return Fraction(value).limit_denominator(10**9)
    except (ValueError, ZeroDivisionError):
        return None


@lru_cache(maxsize=64)
def nearest_rate(rate: Fraction) -> Fraction:
    """Return the nearest n or n * 1000/1001 within 0.02 %, else `rate` itself.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from lanindex.formats.rates import nearest_rate
    >>> nearest_rate(1 / Fraction("0.0333333")), nearest_rate(Fraction("29.97"))
    (Fraction(30, 1), Fraction(30000, 1001))
    """
    slow = Fraction(1000, 1001)
    best = min((Fraction(round(rate)), round(rate / slow) * slow), key=lambda n: abs(n - rate))
    return best if best > 0 and abs(best - rate) <= _SNAP * rate else rate.limit_denominator(10**6)


def rate_doubt(rate: Fraction) -> tuple[str, ...]:
    """Return a warning where a rate is unusual."""
    if _USUAL[0] <= rate <= _USUAL[1]:
        return ()
    return (f"{float(rate):g} frames a second is unusual: if it is wrong, give --fps",)
