"""How near a symbol comes to what a step asks for."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from lanindex.alphabet import DIRECTION_CODES, FEET, LEVEL_CODES, PLACE
from lanindex.model import Symbol
from lanindex.model.measures import GRADES, graded, stored
from lanindex.search.language.query import Step, meaning
from lanindex.search.language.words import AMOUNTS, BESIDE_CELLS, WORD_KINDS

_RUNNER_UP = 0.5
"""How far what nearly fits is, of which another cell's width is 1."""


def away(symbol: Symbol, step: Step) -> float:
    """Return how far a symbol is from what a step says: 0 where it fits.

    Less than 1 where its runner-up fits, the less the nearer it is to that border; else how many
    levels and directions lie between. Changes of level are not looked at.
    """
    cell = (symbol.direction, symbol.level)
    exact = _apart(cell, symbol.part, step)
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
    directions = meaning(step.words, "direction", part)
    levels = meaning(step.words, "level", part)
    direction, level = cell
    total = 0.0
    if (direction or "") not in directions:
        total += min((_turned(direction, it) for it in directions if it), default=9.0)
    if (level or "") not in levels:
        codes = [LEVEL_CODES[it] for it in levels if it]
        total += min((abs(LEVEL_CODES[level] - it) for it in codes), default=9) if level else 9
    return total


def _words_apart(symbol: Symbol, step: Step) -> int:
    """Return how many kinds of words of a step are not true of how far, fast or large it is."""
    kinds = {word.kind for word in step.words if word.kind in BESIDE_CELLS}
    return sum(_called(symbol, it) not in meaning(step.words, it, symbol.part) for it in kinds)


def _called(symbol: Symbol, kind: str) -> str:
    """Return what a symbol's amount, speed or size is called: ``90``, ``fast``; of none nothing."""
    if kind in AMOUNTS:
        number = symbol.amount
        return "" if number is None else FEET[number] if kind == "feet" else str(number)
    measure = getattr(symbol, GRADES[kind])
    if measure is None:
        return ""
    (code,) = graded(symbol.part, kind, stored(GRADES[kind], np.array([measure]))).tolist()
    return next((name for name, own in WORD_KINDS[kind].codes.items() if own == code), "")


def _turned(first: str | None, second: str) -> float:
    """Return how many directions lie between two; upright is next to all of them."""
    if first is None:
        return 9.0
    one, other = DIRECTION_CODES[first], DIRECTION_CODES[second]
    if PLACE in (one, other):
        return 1.0
    return min((one - other) % 8, (other - one) % 8)
