"""How near what there is comes to what is asked for: the nearest number, the nearest symbol."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from math import inf

import numpy as np

from lanindex.alphabet import PLACE
from lanindex.model import Symbol
from lanindex.model.columns import GRADES, graded, stored
from lanindex.search.language.query import Repeat, Skips, Step
from lanindex.search.language.times import Clock, Length, Time
from lanindex.search.language.words import ABSENT, AMOUNTS, BESIDE_CELLS, UNITS, WORD_KINDS
from lanindex.search.plan import fits

Limit = Length | Skips | Repeat
"""A condition on a number."""

_FINEST = {"s": Fraction(1, 100), "ms": Fraction(10), "f": Fraction(1), "b": Fraction(1, 100)}
"""By unit, the steps in which a length is looked for."""

_STEPS = Clock(Fraction(100), Fraction(1))
"""By this clock a frame is such a step, in any unit."""

_DOUBLINGS = 24
"""How often a limit is doubled before what lies beyond is given up."""

_AROUND = 6
"""How far from a number of skipped movements the next one is looked for."""


def nearest_limit(limit: Limit, found: Callable[[Limit], bool]) -> tuple[Limit, str] | None:
    """Return the limit nearest to one that finds nothing, and the number it allows; None: none.

    `found` tells whether another limit in its place finds something.
    """
    least, most, smallest = 0, None, 0
    match limit:
        case Skips("", count):  # just so many: no range, so look around
            around = (count + sign * away for away in range(1, _AROUND) for sign in (-1, 1))
            others = (Skips("", it) for it in around if it >= 0)
            exact = next(filter(found, others), None)
            return None if exact is None else (exact, str(exact))
        case Skips():
            least, most = limit.bounds
        case Repeat():
            least, smallest = limit.least, 1
        case Length(_, time, last):
            if last and last.unit != time.unit:
                return None  # from seconds to beats: there is no one number between
            least, most = limit.bounds(_STEPS)

    def met(least: int, most: int | None) -> bool:
        return found(_between(limit, least, most))

    above = None if most is None else _above(least, most, met)
    below = None
    if least > smallest and met(smallest, most):
        below = bisect_left(range(least), True, smallest, key=lambda it: not met(it, most)) - 1
    if above is not None and (below is None or above - (most or 0) <= least - below):
        return _between(limit, least, above), _number(limit, above)
    return None if below is None else (_between(limit, below, most), _number(limit, below))


def _above(least: int, most: int, met: Callable[[int, int | None], bool]) -> int | None:
    """Return the least number above a range up to which something is found."""
    if not met(least, None):
        return None
    fails = most
    for doubling in range(_DOUBLINGS):
        fits = max(2 * most, 1) << doubling
        if met(least, fits):
            return bisect_left(range(fits), True, fails + 1, key=lambda it: met(least, it))
        fails = fits
    return None


def _between(limit: Limit, least: int, most: int | None) -> Limit:
    """Return a limit like another, from one number of steps to another, None: without end."""
    if isinstance(limit, Repeat):
        return Repeat(least, None)
    if isinstance(limit, Skips):
        return Skips(">=", least) if most is None else Skips("<=", most)
    unit = limit.time.unit
    begin = Time(least * _FINEST[unit], unit)
    if most is None:
        return Length("+", begin)
    end = Time(most * _FINEST[unit], unit)
    return Length("..", begin, end) if least else Length("<=", end)


def _number(limit: Limit, steps: int) -> str:
    if not isinstance(limit, Length):
        return str(steps)
    return f"{float(steps * _FINEST[limit.time.unit]):g} {UNITS[limit.time.unit]}"


# Symbols.

_RUNNER_UP = 0.5
"""How far what nearly fits is, of which another cell's width is 1."""

_FAR = 9.0
"""How far what has no direction or no level is from what has one."""


def away(symbol: Symbol | None, step: Step) -> float:
    """Return how far a symbol is from what a step says: 0 where it fits, infinity of none.

    Less than 1 where its runner-up fits, the less the nearer it is to that border; else how many
    levels and directions lie between, and how many of its other words do not fit. Changes of level
    are not looked at.
    """
    if symbol is None:
        return inf
    wanted = fits(step, symbol.part)
    others = [kind for kind in wanted if kind in BESIDE_CELLS]
    wrong = sum(_code(symbol, kind) not in wanted[kind] for kind in others)
    cell = _apart((symbol.direction, symbol.level), wanted)
    if cell and symbol.runner_up and not _apart(symbol.runner_up, wanted):
        cell = _RUNNER_UP * (0.01 + symbol.margin)
    return cell + wrong


def nearest(symbols: Iterable[Symbol], step: Step) -> Symbol | None:
    """Return the symbol that comes nearest to a step, of equals the first; None of none."""
    return min(symbols, key=lambda symbol: away(symbol, step), default=None)


def doubts(symbol: Symbol) -> str:
    """Return how clearly a symbol is what it is: ``margin 0.12, else forward high``."""
    other = f", else {' '.join(symbol.runner_up)}" if symbol.runner_up else ""
    return f"margin {symbol.margin:.2f}{other}"


def _apart(cell: tuple[str | None, str | None], wanted: Mapping[str, frozenset[int]]) -> float:
    """Return how many directions and levels lie between a cell and those that are wanted."""
    total = 0.0
    for (kind, between), value in zip(_BETWEEN.items(), cell, strict=True):
        if kind in wanted:
            code = WORD_KINDS[kind].codes.get(value or ABSENT)
            total += _FAR if code is None else min(between(code, it) for it in wanted[kind])
    return total


def _turned(one: int, other: int) -> int:
    """Return how many directions lie between two; upright is next to all of them."""
    if one != other and PLACE in (one, other):
        return 1
    return min((one - other) % 8, (other - one) % 8)


def _raised(one: int, other: int) -> int:
    return abs(one - other)


_BETWEEN = {"direction": _turned, "level": _raised}


def _code(symbol: Symbol, kind: str) -> int:
    """Return the code of a symbol's amount, speed or size; -1: it has none."""
    if kind in AMOUNTS:
        return -1 if symbol.amount is None else symbol.amount
    measure = getattr(symbol, GRADES[kind])
    if measure is None:
        return -1
    return int(graded(symbol.part, kind, stored(GRADES[kind], np.array([measure])))[0])
