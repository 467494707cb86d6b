"""What is called fast and slow, large and small, by group of parts.

Source: ``encode/BODY.md``, "Measures".
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import KINDS, PARTS, kind_of
from lanindex.model.symbol import FIELDS

GRADES = {"pace": "speed", "extent": "size"}
"""By kind of words, the measure that they speak of."""

BELOW, USUAL, ABOVE = range(3)
"""Grades: of slow and small, of what has no word, of fast and large."""

LIMITS: dict[str, dict[str, tuple[float, float]]] = {
    "arm": {"speed": (2.2, 5.9), "size": (19, 55)},
    "forearm": {"speed": (2.4, 7.7), "size": (20, 54)},
    "upper_arm": {"speed": (2.0, 6.0), "size": (18, 44)},
    "hand": {"speed": (2.4, 8.8), "size": (19, 50)},
    "palm": {"speed": (2.1, 8.7), "size": (17, 44)},
    "leg": {"speed": (1.2, 3.3), "size": (11, 30)},
    "thigh": {"speed": (1.4, 4.3), "size": (13, 35)},
    "shank": {"speed": (2.0, 6.0), "size": (17, 45)},
    "foot": {"speed": (3.4, 8.4), "size": (18, 48)},
    "head": {"speed": (1.2, 2.9), "size": (13, 31)},
    "torso": {"speed": (1.4, 2.8), "size": (12, 38)},
    "body_travel": {"speed": (0.6, 1.6)},
    "body_turn": {"speed": (0.3, 0.85)},
}
"""By group of parts: less than the first is slow or small, more than the second fast or large."""


def measures_of(part: str) -> tuple[str, ...]:
    """Return which measures can be known of a part's symbols."""
    return KINDS[kind_of(part)].measures


def limits(part: str, measure: str) -> tuple[float, float] | None:
    """Return between which values a measure has no word; None of parts that nobody knows."""
    group = PARTS[part].group if part in PARTS else part
    return LIMITS.get(group, {}).get(measure)


def stored(name: str, values: NDArray[Any]) -> NDArray[np.int64]:
    """Return a measure as columns have it: in its smallest unit, and one more; 0: not known.

    `values`: (S,) as a track's rows have it.
    """
    whole: NDArray[np.int64] = np.rint(values.astype(np.float64) * FIELDS[name].scale)
    return whole.astype(np.int64) + 1


def graded(part: str, kind: str, values: NDArray[Any]) -> NDArray[np.int8]:
    """Return the grade of each symbol, -1 where it is not known.

    `values`: (S,) its measure, as from `stored`.
    """
    name, known = GRADES[kind], values > 0
    between = limits(part, name)
    if between is None:
        return np.full(len(values), -1, np.int8)
    low, high = (round(it * FIELDS[name].scale) + 1 for it in between)
    grades = np.where(values < low, BELOW, np.where(values > high, ABOVE, USUAL))
    return np.where(known, grades, -1).astype(np.int8)
