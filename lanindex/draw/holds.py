"""Holds of weight: where supports are silent and feet still stand."""

from __future__ import annotations

from lanindex.alphabet import kind_of
from lanindex.draw.clock import Clock
from lanindex.draw.layout import GAP, Layout
from lanindex.draw.picture import C, Circle, Group
from lanindex.model import Score

ONE, BOTH = round(0.55 * C), round(0.8 * C)
"""How wide the circle is that keeps the weight on one foot, or on both."""

_LASTS = 0.5
"""Counts for which supports are silent, at least, before weight is said to be held."""


def holds(score: Score, clock: Clock, layout: Layout) -> list[Group]:
    """Return a circle wherever supports fall silent, or feet change meanwhile, and some stand."""
    found = []
    for start, stop, feet in _stands(score, clock):
        if stop - start < _LASTS or not layout.start < start < layout.stop:
            continue
        both = len(feet) == 2
        size = BOTH if both else ONE
        low = layout.up(start) + GAP
        piece = next(layout.pieces(low, low + size), None)
        if piece is None or piece.high - piece.low < size:
            continue
        at = 0 if both else layout.columns.places.get(f"{feet[0]}_support", 0)
        sides = "both feet" if both else {"r": "the right foot", "l": "the left foot"}[feet]
        circle = Circle(piece.x + at, piece.y - size // 2, size // 2)
        found.append(Group((circle,), f"stands on {sides}"))
    return found


def _stands(score: Score, clock: Clock) -> list[tuple[float, float, str]]:
    """Return the stretches in which no symbol tells of supports, and which feet hold the weight."""
    changes: list[tuple[float, str, int]] = []
    for part, track in score.tracks.items():
        key = {"stance": part[0], "support": "+", "jump": "+"}.get(kind_of(part))
        if key:
            for start, stop in zip(*clock.symbols(track.symbols), strict=True):
                if start < stop:
                    changes += [(start, key, 1), (stop, key, -1)]
    changes.sort()
    found, state, since, feet = [], {"+": 0, "r": 0, "l": 0}, 0.0, ""
    for index, (time, key, change) in enumerate(changes):
        state[key] += change
        if index + 1 < len(changes) and changes[index + 1][0] <= time:
            continue
        now = "" if state["+"] else "".join(foot for foot in "rl" if state[foot])
        if now != feet:
            if feet:
                found.append((since, time, feet))
            since, feet = time, now
    return found
