"""How far off is what there is? The nearest number that a limit would have to allow."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from lanindex.search.explain.changes import Limit
from lanindex.search.language.query import Repeat, Skips
from lanindex.search.language.times import Clock, Length, Time

_UNITS = {
    "s": (Fraction(1, 100), "s"),
    "ms": (Fraction(10), "ms"),
    "f": (Fraction(1), "frames"),
    "b": (Fraction(1, 100), "beats"),
}
"""By unit, the steps in which a length is looked for, and what it is called."""

_DOUBLINGS = 24
"""How often a limit is doubled before what lies beyond is given up."""

_AROUND = 6
"""How far from a number of skipped movements the next one is looked for."""

_Met = Callable[[int, int | None], bool]
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
        count = _below(limit.least, None, lambda least, _: found(Repeat(least, None)), 1)
        return None if count is None else (Repeat(count, None), str(count))
    if isinstance(limit, Skips):
        return _nearest_skips(limit, found)
    return _nearest_length(limit, found)


def _nearest_skips(limit: Skips, found: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
    if not limit.form:  # just so many: no range, so look around
        around = (limit.count + sign * away for away in range(1, _AROUND) for sign in (-1, 1))
        exact = next((it for it in around if it >= 0 and found(Skips("", it))), None)
        return None if exact is None else (Skips("", exact), str(exact))

    def skips(least: int, most: int | None) -> Skips:
        return Skips(">=", least) if most is None else Skips("<=", most)

    met = _nearest(*limit.bounds, lambda *bounds: found(skips(*bounds)))
    return met and (skips(*met[1]), str(met[0]))


def _nearest_length(limit: Length, found: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
    unit = limit.time.unit
    if limit.last and limit.last.unit != unit:
        return None  # from seconds to beats: there is no one number between
    finest, name = _UNITS[unit]
    last = limit.last and Time(limit.last.number / finest, "f")
    steps = Length(limit.form, Time(limit.time.number / finest, "f"), last)

    def length(least: int, most: int | None) -> Length:
        begin = Time(least * finest, unit)
        if most is None:
            return Length("+", begin)
        end = Time(most * finest, unit)
        return Length("..", begin, end) if least else Length("<=", end)

    bounds = steps.bounds(Clock(Fraction(1), Fraction(1)))
    met = _nearest(*bounds, lambda *bounds: found(length(*bounds)))
    return met and (length(*met[1]), f"{float(met[0] * finest):g} {name}")


def _nearest(least: int, most: int | None, met: _Met) -> tuple[int, tuple[int, int | None]] | None:
    """Return the number nearest to a range in which there is none, and the range with it."""
    above = None if most is None else _above(least, most, met)
    below = _below(least, most, met) if least > 0 else None
    if above is not None and (below is None or above - (most or 0) <= least - below):
        return above, (least, above)
    return None if below is None else (below, (below, most))


def _above(least: int, most: int, met: _Met) -> int | None:
    if not met(least, None):
        return None
    fails, fits = most, max(2 * most, most + 1)
    for _ in range(_DOUBLINGS):
        if met(least, fits):
            return _bisected(fits, fails, lambda middle: met(least, middle))
        fails, fits = fits, 2 * fits
    return None


def _below(least: int, most: int | None, met: _Met, smallest: int = 0) -> int | None:
    if not met(smallest, most):
        return None
    return _bisected(smallest, least, lambda middle: met(middle, most))


def _bisected(fits: int, fails: int, met: Callable[[int], bool]) -> int:
    """Return the number that fits and is next to one that fails."""
    while abs(fits - fails) > 1:
        middle = (fits + fails) // 2
        fits, fails = (middle, fails) if met(middle) else (fits, middle)
    return fits
