"""How far off is what there is? The nearest number that a limit would have to allow."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from lanindex.search.explain.conditions import Limit
from lanindex.search.language.query import Repeat, Skips
from lanindex.search.language.times import Clock, Length, Time

_FINEST = {"s": Fraction(1, 100), "ms": Fraction(10), "f": Fraction(1), "b": Fraction(1, 100)}
"""By unit, the steps in which a length is looked for."""

_DOUBLINGS = 24
"""How often a limit is doubled before what lies beyond is given up."""

_AROUND = 6
"""How far from a number of skipped movements the next one is looked for."""

Allowed = Callable[[int, int | None], bool]
"""Tells whether anything is found from one number to another, None: without end."""


def nearest(limit: Limit, found: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
    """Return the limit that finds something and is nearest to one that does not.

    Parameters
    ----------
    limit : Length, Skips or Repeat
        Which finds nothing.
    found : callable
        Tells whether another limit in its place finds something.

    Returns
    -------
    tuple of Limit and str, or None
        The other limit, and the number that was met; None where there is no such thing.
    """
    if isinstance(limit, Repeat):
        return _nearest_count(limit, found)
    if isinstance(limit, Skips):
        return _nearest_skips(limit, found)
    return _nearest_length(limit, found)


def _nearest_count(limit: Repeat, found: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
    fits, fails = 1, limit.least
    if not found(Repeat(1, None)):
        return None
    while fails - fits > 1:
        middle = (fits + fails) // 2
        fits, fails = (middle, fails) if found(Repeat(middle, None)) else (fits, middle)
    return Repeat(fits, None), str(fits)


def _nearest_skips(limit: Skips, found: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
    least, most = limit.bounds
    if not limit.form:  # just so many: no range, so look around
        around = (limit.count + sign * away for away in range(1, _AROUND) for sign in (-1, 1))
        exact = next((it for it in around if it >= 0 and found(Skips("", it))), None)
        return None if exact is None else (Skips("", exact), str(exact))

    def skips(low: int, high: int | None) -> Skips:
        return Skips(">=", low) if high is None else Skips("<=", high)

    value, low, high = _apart(least, most, lambda low, high: found(skips(low, high)))
    return None if value is None else (skips(low, high), str(value))


def _nearest_length(limit: Length, found: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
    unit = limit.time.unit
    finest = _FINEST[unit]
    last = limit.last if limit.last and limit.last.unit == unit else None
    if limit.last and not last:
        return None  # from seconds to beats: there is no one number between
    steps = Length(
        limit.form,
        Time(limit.time.number / finest, "f"),
        Time(last.number / finest, "f") if last else None,
    )
    least, most = steps.bounds(Clock(Fraction(1), Fraction(1)))

    def length(low: int, high: int | None) -> Length:
        begin = Time(low * finest, unit)
        if high is None:
            return Length("+", begin)
        end = Time(high * finest, unit)
        return Length("..", begin, end) if low else Length("<=", end)

    value, low, high = _apart(least, most, lambda low, high: found(length(low, high)))
    if value is None:
        return None
    return length(low, high), _spoken(value * finest, unit)


def _spoken(number: Fraction, unit: str) -> str:
    names = {"f": "frames", "b": "beats"}
    return f"{float(number):g} {names.get(unit, unit)}"


def _apart(least: int, most: int | None, found: Allowed) -> tuple[int | None, int, int | None]:
    """Return the number nearest to a range in which there is none, and the range with it."""
    above = _above(least, most, found) if most is not None else None
    below = _below(least, most, found) if least > 0 else None
    if above is not None and (below is None or above - (most or 0) <= least - below):
        return above, least, above
    if below is not None:
        return below, below, most
    return None, least, most


def _above(least: int, most: int, found: Allowed) -> int | None:
    if not found(least, None):
        return None
    fails, fits = most, max(2 * most, most + 1)
    for _ in range(_DOUBLINGS):
        if found(least, fits):
            break
        fails, fits = fits, 2 * fits
    else:
        return None
    while fits - fails > 1:
        middle = (fits + fails) // 2
        fits, fails = (middle, fails) if found(least, middle) else (fits, middle)
    return fits


def _below(least: int, most: int | None, found: Allowed) -> int | None:
    if not found(0, most):
        return None
    fits, fails = 0, least
    while fails - fits > 1:
        middle = (fits + fails) // 2
        fits, fails = (middle, fails) if found(middle, most) else (fits, middle)
    return fits
