"""From where a figure is seen: the turn about the vertical in which it moves most.

``view(figure, tracks=None, start=0, stop=None) -> View`` chooses, ``front(figure)`` is that from
where the body faces; ``View.project(places)`` draws
``(..., 3)`` places in mm as ``(..., 2)`` places in mm on the picture, x to the right, y up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, PARTS, kind_of
from lanindex.errors import UsageError
from lanindex.film.figure import Figure

TILT = 12.0
"""Degrees from which a figure is looked down upon, so that the floor is seen."""

SAMPLES = 2048
"""Frames that are looked at, at most, spread evenly."""

WORTH = 0.1
"""By how much more must be seen from elsewhere than from the front, of what is seen from there."""

_ACROSS = (("LHip", "RHip"), ("LShoulder", "RShoulder"))
_STAYS = ("gesture", "bend", "touch", "twist", "incline")
"""Kinds of tracks in which a limb moves against the body, not the body over the floor."""


@dataclass(frozen=True, slots=True)
class View:
    """A direction from which a figure is seen, without perspective."""

    turn: float  # Degrees about the vertical: 0 from where +z points, +x to the right; 90 from +x
    tilt: float = TILT  # Degrees above the horizon

    def axes(self) -> NDArray[np.float64]:
        """Return where right, up and towards the eye are in space, (3, 3), a row each."""
        (sin, cos), (sine, cosine) = (
            (math.sin(it), math.cos(it)) for it in map(math.radians, (self.turn, self.tilt))
        )
        return np.array(
            [
                [cos, 0.0, -sin],
                [-sine * sin, cosine, -sine * cos],
                [cosine * sin, sine, cosine * cos],
            ]
        )

    def project(self, places: NDArray[np.floating]) -> NDArray[np.float32]:
        """Return places on the picture.

        `places`: (..., 3), mm, y up; returns (..., 2) float32, mm.
        """
        seen: NDArray[np.float32] = places.astype(np.float32) @ self.axes()[:2].T.astype(np.float32)
        return seen


def view(
    figure: Figure,
    tracks: Sequence[str] | None = None,
    start: int = 0,
    stop: int | None = None,
    tilt: float = TILT,
) -> View:
    """Return from where a figure is seen best: where what moves is seen to move most.

    Of all turns about the vertical it is the one in which the places of the joints spread widest
    on the picture. What limbs do is counted from where they hang; steps, supports and ways, and
    the body as a whole, on the floor. The front is kept where no other view shows a tenth more:
    of what moves up and down, or all round. Of the two sides of a line the one nearer to the
    front is taken; of left and right the right, but the left for parts of the left alone.
    """
    places = _sampled(figure, start, len(figure) if stop is None else stop)
    turn = ahead = _front(places)
    moves = np.concatenate(
        [_moves(figure, places, track) for track in tracks or ("body_travel",)], axis=1
    )
    spread = _spread(moves)
    best = _best(spread)
    if best is not None and _seen(spread, best) > (1 + WORTH) * _seen(spread, ahead):
        sides = {track[:2] for track in tracks or ()}
        turn = _nearer(best, ahead, left=sides == {"l_"})
    return _view(turn, tilt)


def front(figure: Figure, start: int = 0, stop: int | None = None, turned: float = 0.0) -> View:
    """Return the view from where the body faces, on average."""
    places = _sampled(figure, start, len(figure) if stop is None else stop)
    return _view(_front(places) + math.radians(turned), TILT)


def _view(turn: float, tilt: float) -> View:
    return View(round((math.degrees(turn) + 180) % 360 - 180, 6) + 0.0, tilt)


def _sampled(figure: Figure, start: int, stop: int) -> NDArray[np.float64]:
    """Return the joints in some frames of a span, (S, 20, 3)."""
    if not 0 <= start < stop <= len(figure):
        raise UsageError(
            f"nothing from frame {start} to {stop}", wanted=f"a stretch of 0 to {len(figure)}"
        )
    frames = np.linspace(start, stop - 1, min(stop - start, SAMPLES)).astype(np.int64)
    return figure.places[frames].astype(np.float64)


def _front(places: NDArray[np.float64]) -> float:
    """Return from where the body is seen from the front, radians: on average, or midway."""
    for left, right in _ACROSS:
        across = (places[:, JOINT_CODES[left]] - places[:, JOINT_CODES[right]])[:, [0, 2]]
        size = np.hypot(*across.T)
        ways = across[size > 1.0] / size[size > 1.0, None]
        if len(ways):
            mean = ways.mean(axis=0)
            x, z = mean if np.hypot(*mean) > 0.5 else ways[len(ways) // 2]
            return math.atan2(-z, x)
    return 0.0


def _moves(figure: Figure, places: NDArray[np.float64], track: str) -> NDArray[np.float64]:
    """Return what moves, (S, K, 3): limbs as seen from where they hang."""
    joints = figure.joints([track])
    if kind_of(track) not in _STAYS:
        return places[:, joints]
    part = PARTS.get(track.removesuffix("_bend"))
    hangs = JOINT_CODES[part.parent if part else "Pelvis"]
    return places[:, joints] - places[:, hangs, None]


def _spread(moves: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean products of x, y and z about their means, all joints taken together."""
    joints = moves.reshape(len(moves), -1, 3)
    known = ~np.isnan(joints).any(axis=2, keepdims=True)
    count = np.maximum(known.sum(axis=0), 1)
    held = np.where(known, joints, 0.0)
    away = np.where(known, held - held.sum(axis=0) / count, 0.0).reshape(-1, 3)
    spread: NDArray[np.float64] = away.T @ away / max(int(known.sum()), 1)
    return spread


def _best(spread: NDArray[np.float64]) -> float | None:
    """Return from where the widest way over the floor lies across, radians; None: all are equal."""
    xx, xz, zz = spread[0, 0], spread[0, 2], spread[2, 2]
    if math.hypot(xx - zz, 2 * xz) <= 1e-9 * (xx + zz):
        return None
    return -0.5 * math.atan2(2 * xz, xx - zz)


def _seen(spread: NDArray[np.float64], turn: float) -> float:
    """Return how far a movement spreads on the picture, squared."""
    right = np.array([math.cos(turn), 0.0, -math.sin(turn)])
    return float(right @ spread @ right + spread[1, 1])


def _nearer(turn: float, front: float, *, left: bool) -> float:
    """Return this view or the one from behind, whichever is nearer to the front, or its side."""
    off = (turn - front + math.pi) % (2 * math.pi) - math.pi
    ways = (off, off - math.copysign(math.pi, off))
    side = 1.0 if left else -1.0
    return front + min(ways, key=lambda it: (round(abs(it), 1), -side * it))
