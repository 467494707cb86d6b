"""A stretch of a score as a pattern: what its limbs do in it, one line a limb."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any

from lanindex.alphabet import KINDS, kind_of
from lanindex.errors import UsageError
from lanindex.model import Score, Symbol
from lanindex.records import of_symbol
from lanindex.search.example.motifs import LONGEST

LIMBS = ("r_arm", "l_arm", "r_leg", "l_leg", "torso", "head")
LINES = 3  # limbs of a pattern where nobody says which, those that move most
_DIRECTED = ("gesture", "support", "travel", "incline")


def pattern_of(score: Score, start: float, stop: float, parts: Sequence[str] | None = None) -> str:
    """Return what is written of some seconds as a pattern.

    Symbols belong to it that end within these seconds; `parts` are those that are asked for, else
    the `LIMBS` that move most.
    """
    lines = {part: _steps(score, part, start, stop) for part in parts or LIMBS}
    moving = [part for part, steps in lines.items() if steps]
    if not moving:
        raise UsageError(
            f"nothing moves from {start:.2f} s to {stop:.2f} s",
            wanted=f"movement of {', '.join(parts or LIMBS)}",
            remedy="Choose a longer stretch, or other parts.",
        )
    moving.sort(key=lambda part: -len(lines[part]))
    chosen = moving if parts else moving[:LINES]
    together = f" with[{ceil(10 * (stop - start)) / 10:g}s] "  # one may rest before another moves
    return together.join(f"{part} {' -> '.join(lines[part][:LONGEST])}" for part in chosen)


def _steps(score: Score, part: str, start: float, stop: float) -> list[str]:
    """Return where a part arrives within some seconds, or what it does, as a pattern has it."""
    if part not in score.tracks:
        return []
    said = words_of if kind_of(part) in _DIRECTED else _done
    rate = float(score.rate)
    return [
        said(it)
        for it in score.symbols(part)
        if it.stop > it.start and not it.passing and start < it.stop / rate <= stop + 1e-6
    ]


def words_of(symbol: Symbol) -> str:
    """Return where a symbol points, as a pattern has it."""
    return " ".join(it for it in (symbol.direction, symbol.level) if it) or "any"


def _done(symbol: Symbol) -> str:
    """Return what a symbol says as a pattern has it, without its part."""
    return pattern_of_symbol(of_symbol(symbol)).partition(" ")[2] or "any"


def pattern_of_symbol(record: Mapping[str, Any]) -> str:
    """Return a pattern that finds a symbol and those that say the same, from its record.

    It is empty for a starting position, which nothing leads to.
    """
    if record["start_frame"] == record["end_frame"]:
        return ""
    part, amount = record["part"], record.get("amount")
    kind = KINDS[kind_of(part)]
    told = [record["direction"], record["level"]]
    if kind.name != "gesture" and amount is not None and (kind.amounts or amount):
        told.append(kind.amount(amount))  # how far a limb is bent is only its state by the way
    return " ".join((part, *filter(None, told)))
