"""What tracks of the whole body are made of.

Source: ``encoding/BODY.md``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SECTOR = 22.5
"""Degrees from the middle of a direction to its border."""


class Event(NamedTuple):
    """A foot that stands anew, or a flight; frames as in `Ground`, half-open."""

    start: int  # From when the weight goes there until all of it is there; of a flight, its frames
    stop: int
    direction: int  # Codes of the alphabet; -1: none
    level: int
    margin: float  # As of a symbol
    foot: int = 0  # 0 right, 1 left; of a flight 0
    amount: int = -1  # Of a flight, which feet; of a turn and a way, degrees; else -1
    # The highest: of a way in legs a second, of a turn in whole turns; below 0 not measured
    speed: float = -0.01
    beside: int = -1  # The direction across the nearest border; -1: none


def table(found: Sequence[Event]) -> Floats:
    """Return events as the rows of a table, (E, 9) float64: a column for each field."""
    return np.array(found, np.float64).reshape(-1, len(Event._fields))
