"""How near what there is comes to what is asked for: the nearest number, the nearest symbol."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from lanindex.alphabet import DIRECTION_CODES, FEET, LEVEL_CODES, PLACE
from lanindex.model import Symbol
from lanindex.model.measures import GRADES, graded, stored
from lanindex.search.language.query import Repeat, Skips, Step, meaning
from lanindex.search.language.times import Clock, Length, Time
from lanindex.search.language.words import ABSENT, AMOUNTS, BESIDE_CELLS, UNITS, WORD_KINDS

Limit = Length | Skips | Repeat
"""A condition on a number."""

_FINEST = {"s": Fraction(1, 100), "ms": Fraction(10), "f": Fraction(1), "b": Fraction(1, 100)}
"""By unit, the steps in which a length is looked for."""

_DOUBLINGS = 24
"""How often a limit is doubled before what lies beyond is given up."""

_AROUND = 6
"""How far from a number of skipped movements the next one is looked for."""

_Met = Callable[[int, int | None], bool]
"""Tells whether anything is found from one number to another, None: without end."""


def nearest_limit(limit: Limit, found: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
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
    if isinstance(limit, Skips) and not limit.form:  # just so many: no range, so look around
        around = (limit.count + sign * away for away in range(1, _AROUND) for sign in (-1, 1))
        others = (Skips("", count) for count in around if count >= 0)
        exact = next(filter(found, others), None)
        return None if exact is None else (exact, str(exact))
    scale = _scale(limit)
    if scale is None:
        return None
    met = _nearest(scale, lambda *bounds: found(scale.limit(*bounds)))
    return None if met is None else (scale.limit(*met[1]), scale.words(met[0]))


class _Scale(NamedTuple):
    """A limit as a range of whole numbers, and what makes a limit and words of such numbers."""

    least: int
    most: int | None
    limit: Callable[[int, int | None], Limit]
    words: Callable[[int], str] = str
    smallest: int = 0


def _scale(limit: Limit) -> _Scale | None:
    if isinstance(limit, Repeat):
        return _Scale(limit.least, None, lambda least, _: Repeat(least, None), smallest=1)
    if isinstance(limit, Skips):
        return _Scale(
            *limit.bounds,
            lambda least, most: Skips(">=", least) if most is None else Skips("<=", most),
        )
    unit = limit.time.unit
    if limit.last and limit.last.unit != unit:
        return None  # from seconds to beats: there is no one number between
    finest = _FINEST[unit]

    def length(least: int, most: int | None) -> Length:
        begin = Time(least * finest, unit)
        if most is None:
            return Length("+", begin)
        end = Time(most * finest, unit)
        return Length("..", begin, end) if least else Length("<=", end)

    last = limit.last and Time(limit.last.number / finest, "f")
    steps = Length(limit.form, Time(limit.time.number / finest, "f"), last)
    bounds = steps.bounds(Clock(Fraction(1), Fraction(1)))
    return _Scale(*bounds, length, lambda number: f"{float(number * finest):g} {UNITS[unit]}")


def _nearest(scale: _Scale, met: _Met) -> tuple[int, tuple[int, int | None]] | None:
    """Return the number nearest to a range in which there is none, and the range with it."""
    least, most = scale.least, scale.most
    above = None if most is None else _above(least, most, met)
    below = None
    if least > scale.smallest and met(scale.smallest, most):
        below = _bisected(scale.smallest, least, lambda middle: met(middle, most))
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


def _bisected(fits: int, fails: int, met: Callable[[int], bool]) -> int:
    """Return the number that fits and is next to one that fails."""
    while abs(fits - fails) > 1:
        middle = (fits + fails) // 2
        fits, fails = (middle, fails) if met(middle) else (fits, middle)
    return fits


# Symbols.

_RUNNER_UP = 0.5
"""How far what nearly fits is, of which another cell's width is 1."""

_FAR = 9.0
"""How far what has no direction or no level is from what has one."""


def away(symbol: Symbol, step: Step) -> float:
    """Return how far a symbol is from what a step says: 0 where it fits.

    Less than 1 where its runner-up fits, the less the nearer it is to that border; else how many
    levels and directions lie between. Changes of level are not looked at.
    """
    exact = _apart((symbol.direction, symbol.level), symbol.part, step)
    beside = _words_apart(symbol, step)
    if exact and symbol.runner_up and not _apart(symbol.runner_up, symbol.part, step):
        return _RUNNER_UP * (0.01 + symbol.margin) + beside
    return exact + beside


def nearest(symbols: Iterable[Symbol], step: Step) -> Symbol | None:
    """Return the symbol that comes nearest to a step, of equals the first; None of none."""
    return min(symbols, key=lambda symbol: away(symbol, step), default=None)


def doubts(symbol: Symbol) -> str:
    """Return how clearly a symbol is what it is: ``margin 0.12, else forward high``."""
    other = f", else {' '.join(symbol.runner_up)}" if symbol.runner_up else ""
    return f"margin {symbol.margin:.2f}{other}"


def _apart(cell: tuple[str | None, str | None], part: str, step: Step) -> float:
    total = 0.0
    for (kind, between), value in zip(_BETWEEN.items(), cell, strict=True):
        wanted = meaning(step.words, kind, part)
        if (value or ABSENT) not in wanted:
            total += min((between(value, it) for it in wanted if value and it), default=_FAR)
    return total


def _turned(first: str, second: str) -> float:
    """Return how many directions lie between two; upright is next to all of them."""
    one, other = DIRECTION_CODES[first], DIRECTION_CODES[second]
    return 1.0 if PLACE in (one, other) else min((one - other) % 8, (other - one) % 8)


def _raised(first: str, second: str) -> float:
    return abs(LEVEL_CODES[first] - LEVEL_CODES[second])


_BETWEEN = {"direction": _turned, "level": _raised}


def _words_apart(symbol: Symbol, step: Step) -> int:
    """Return how many kinds of words of a step are not true of how far, fast or large it is."""
    kinds = {word.kind for word in step.words if word.kind in BESIDE_CELLS}
    return sum(_called(symbol, it) not in meaning(step.words, it, symbol.part) for it in kinds)


def _called(symbol: Symbol, kind: str) -> str:
    """Return what a symbol's amount, speed or size is called: ``90``, ``fast``; of none nothing."""
    if kind in AMOUNTS:
        number = symbol.amount
        return ABSENT if number is None else FEET[number] if kind == "feet" else str(number)
    measure = getattr(symbol, GRADES[kind])
    if measure is None:
        return ABSENT
    (code,) = graded(symbol.part, kind, stored(GRADES[kind], np.array([measure]))).tolist()
    return next((name for name, own in WORD_KINDS[kind].codes.items() if own == code), ABSENT)
