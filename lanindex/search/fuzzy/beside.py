"""How the leading line and another one must lie to each other, for many of both at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Frames = NDArray[np.int64]
Truths = NDArray[np.bool_]


class Found(NamedTuple):
    """The matches of a line in a capture, column by column.

    Attributes
    ----------
    start, until : ndarray
        (N,) frames, half-open.
    cost : ndarray
        (N,) parts of an edit.
    first, last : ndarray
        (N,) rows of the capture's track.
    alone : ndarray
        (N,) whether it is no more than a starting position.
    """

    start: Frames
    until: Frames
    cost: Frames
    first: Frames
    last: Frames
    alone: Truths

    def chosen(self, which: Frames | Truths) -> Found:
        """Return some of them."""
        return Found._make(column[which] for column in self)

    def cheapest(self) -> Found:
        """Return of those that begin alike the cheapest, of these the one that ends first."""
        order = np.lexsort((self.until, self.cost, self.first))
        _, begins = np.unique(self.first[order], return_index=True)
        return self.chosen(order[begins])


class Limits(NamedTuple):
    """How exactly edges must agree, and how many frames may lie between."""

    slack: int
    least: int
    most: int | None

    def allow(self, between: Frames) -> Truths:
        """Return whether so many frames may lie between; never fewer than none."""
        fits = (between >= max(self.least, 0)) & (between >= 0)
        return fits if self.most is None else fits & (between <= self.most)


def _shares(line: Found, other: Found, limits: Limits) -> Truths:
    before = other.start[None] - line.until[:, None]
    after = line.start[:, None] - other.until[None]
    most = -1 if limits.most is None else limits.most
    shares: Truths = np.maximum(before, after) <= most
    return shares


def _starts(line: Found, other: Found, limits: Limits) -> Truths:
    agrees: Truths = np.abs(line.start[:, None] - other.start[None]) <= limits.slack
    return agrees


def _ends(line: Found, other: Found, limits: Limits) -> Truths:
    agrees: Truths = np.abs(line.until[:, None] - other.until[None]) <= limits.slack
    return agrees


def _inside(line: Found, other: Found, limits: Limits) -> Truths:
    begins = other.start[None] <= line.start[:, None]
    inside: Truths = begins & (line.until[:, None] <= other.until[None])
    return inside


RELATIONS: dict[str, Callable[[Found, Found, Limits], Truths]] = {
    "with": _shares,
    "during": _inside,
    "starting with": _starts,
    "ending with": _ends,
    "exactly with": lambda line, other, limits: (
        _starts(line, other, limits) & _ends(line, other, limits)
    ),
    "after": lambda line, other, limits: limits.allow(line.start[:, None] - other.until[None]),
    "before": lambda line, other, limits: limits.allow(other.start[None] - line.until[:, None]),
}
"""By relation: (N, M) which of the leading line's matches go with which of the other's."""

OUTSIDE = ("during", "after", "before")
"""Relations that add no frames to a hit."""
