"""Lengths of time in the frames of each capture."""

from __future__ import annotations

from fractions import Fraction
from math import floor

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import Roster
from lanindex.search.language.times import Clock, Length

Frames = NDArray[np.int64]

ENDLESS = 1 << 33
"""More frames than a capture has."""


def bounds_of(roster: Roster, length: Length | None) -> tuple[Frames, Frames]:
    """Return the fewest and the most frames that meet a length, (C,) each; `ENDLESS`: no limit."""
    if length is None:
        return np.zeros(len(roster), np.int64), np.full(len(roster), ENDLESS)
    clocks, which = _clocks(roster)
    bounds = [length.bounds(clock) for clock in clocks]
    limits = [
        (min(least, ENDLESS), ENDLESS if most is None else min(most, ENDLESS))
        for least, most in bounds
    ]
    least, most = np.array(limits, np.int64).reshape(-1, 2)[which].T
    return least, most


def slack_of(roster: Roster, tolerance: Fraction) -> Frames:
    """Return how many frames a tolerance is, (C,), rounded down."""
    clocks, which = _clocks(roster)
    frames = [min(floor(tolerance * clock.rate), ENDLESS) for clock in clocks]
    return np.array(frames, np.int64)[which]


def _clocks(roster: Roster) -> tuple[list[Clock], NDArray[np.intp]]:
    """Return the different clocks of captures, and which each one has."""
    which = np.zeros(len(roster), np.int64)
    for column in (*roster.rate.T, *roster.speed.T):
        values, own = np.unique(column, return_inverse=True)
        _, which = np.unique(which * len(values) + own, return_inverse=True)
    _, first = np.unique(which, return_index=True)
    found = [
        Clock(Fraction(*rate), Fraction(*speed) / 60)
        for rate, speed in zip(
            roster.rate[first].tolist(), roster.speed[first].tolist(), strict=True
        )
    ]
    return found, which
