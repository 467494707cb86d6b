"""Where a figure, the floor below it and its way over that stand on a picture, frame by frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.errors import ExportError
from lanindex.film.figure import Figure
from lanindex.film.view import View

Floats = NDArray[np.float32]

ROOM = 1.3
"""How many times as high as the body the picture is at most: whoever goes further is followed."""

DEEPEST = 4000.0
"""Millimetres towards the eye in which the floor is drawn."""

LEAST = 600.0
"""Millimetres that are shown, at least."""

ROUND = 160.0
"""Millimetres left free around the figure: a head is larger than its joint."""

STEADY = 1.0
"""Seconds on both sides over which the eye that follows is steadied."""

SQUARE = 500.0
"""Millimetres from one line of the floor to the next."""

_FEET = [JOINT_CODES[side + joint] for side in "RL" for joint in ("Ankle", "Toe")]
_LOWEST = 0.01  # of the frames may have a foot below the floor: a camera errs
_USUAL = 0.99  # of the frames tell how large a body is: in others a joint may fly away
_FAR = 50  # squares to the side: of more no floor is drawn


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A figure on a picture."""

    size: tuple[int, int]  # Width and height, pixels
    scale: float  # Pixels in a millimetre
    # (N, 20, 2) float32, pixels from the upper left corner, x to the right, y down: the joints, a
    # row each film frame; NaN where unknown
    points: Floats
    depths: Floats  # (N, 20) float32, mm towards the eye
    # (N, 3) float64, mm to the right, up and towards the eye (level): what is in the middle
    eye: NDArray[np.float64]
    view: View  # From where it is seen
    floor: float | None  # How high the floor is, mm; None where no foot tells it
    # (N, 2) float32, pixels as if seen with the first frame's eye: the pelvis, on the floor
    path: Floats

    def __len__(self) -> int:
        """Return the number of film frames."""
        return len(self.points)

    def shift(self, frame: int) -> tuple[float, float]:
        """Return how far what stands still has gone on the picture since the first frame."""
        right, up, _ = (self.eye[0] - self.eye[frame]) * self.scale
        return float(right), float(-up)

    def lines(self, frame: int) -> list[tuple[float, float, float, float]]:
        """Return the lines of the floor, as far as they are seen: from x, y to x, y, pixels."""
        (width, height), scale = self.size, self.scale
        wide = width / scale / 2
        if self.floor is None or wide > _FAR * SQUARE:
            return []
        right, up, near = self.eye[frame].tolist()
        rows = _marks(near - DEEPEST / 2, near + DEEPEST / 2)
        ys = [height / 2 + (up - _laid(it, self.floor, self.view)) * scale for it in rows]
        xs = [width / 2 + (it - right) * scale for it in _marks(right - wide, right + wide)]
        top, bottom = max(min(ys), 0), min(max(ys), height - 1)
        level = [(0, y, width - 1, y) for y in ys if top <= y <= bottom]
        return [*level, *((x, top, x, bottom) for x in xs if x < width and top < bottom)]


def _laid(near: Any, floor: float, view: View) -> Any:
    """Return how high on the picture places on the floor are that are so near, mm."""
    tilt = math.radians(view.tilt)
    return math.cos(tilt) * floor - math.sin(tilt) * near


def _placed(
    right: NDArray[np.floating], up: NDArray[np.floating], size: tuple[int, int], scale: float
) -> Floats:
    """Return where on the picture something is that lies so far from its middle, mm."""
    x, y = right * scale + size[0] / 2, size[1] / 2 - up * scale
    return np.stack([x, y], axis=-1).astype(np.float32)


def _marks(start: float, stop: float) -> list[float]:
    """Return where lines of the floor stand between two places."""
    return [
        step * SQUARE for step in range(math.ceil(start / SQUARE), math.floor(stop / SQUARE) + 1)
    ]


def scene(
    figure: Figure, frames: NDArray[np.int64], view: View, size: tuple[int, int], rate: float
) -> Scene:
    """Return where a figure stands on a picture.

    All that moves is shown at one scale; where that would make it small, whoever goes is followed.

    `frames`: (N,) int64, which frame of the motion each film frame shows.
    """
    places = figure.places[frames]
    known = ~np.isnan(places[..., 0])
    if not known.any():
        raise ExportError("no joint is known in this stretch", wanted="a body that is seen")
    level = places @ View(view.turn, 0).axes().T.astype(np.float32)
    seen = places @ view.axes().T.astype(np.float32)
    seen[..., 2] = level[..., 2]
    lows, highs = _ends(seen, known)
    low, high = lows.min(axis=0), highs.max(axis=0)
    body = np.quantile(highs - lows, _USUAL, axis=0, method="higher")[:2]
    most = np.maximum(body, ROOM * body[1] * np.array([size[0] / size[1], 1]))
    shown = np.maximum(np.minimum((high - low)[:2], most), LEAST)
    scale = float((np.array(size) / shown).min())
    room = np.array([size[0] / scale, size[1] / scale, DEEPEST])
    eye = np.repeat((low + high)[None] / 2, len(frames), axis=0)
    if (far := high - low > room * 1.001).any():
        steady = _steadied((lows + highs) / 2, round(STEADY * rate))
        eye[:, far] = np.clip(steady, highs - room / 2, lows + room / 2)[:, far]
    floor = _floor(places[:, _FEET, 1])
    points = _placed(seen[..., 0] - eye[:, :1], seen[..., 1] - eye[:, 1:2], size, scale)
    path = np.full((len(frames), 2), np.nan, np.float32)
    if floor is not None:
        right, _, near = level[:, JOINT_CODES["Pelvis"]].T
        path = _placed(right - eye[0, 0], _laid(near, floor, view) - eye[0, 1], size, scale)
    return Scene(size, scale, points, level[..., 2], eye, view, floor, path)


def _ends(
    seen: Floats, known: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return from where to where the body is and `ROUND` more, (N, 3); in gaps as if it went on."""
    there, frames = np.flatnonzero(known.any(axis=1)), np.arange(len(seen))
    ends = []
    for edge, sign in ((np.min, 1), (np.max, -1)):
        held = np.where(known[there, :, None], seen[there], sign * np.float32(np.inf))
        found = edge(held, axis=1).astype(np.float64) - sign * ROUND
        filled = [np.interp(frames, there, found[:, axis]) for axis in range(3)]
        ends.append(np.stack(filled, axis=1))
    return ends[0], ends[1]


def _floor(heights: Floats) -> float | None:
    """Return how high the floor is on which the lowest foot stands, mm."""
    lowest = np.nanmin(np.where(np.isnan(heights), np.inf, heights), axis=1)
    lowest = np.sort(lowest[np.isfinite(lowest)])
    return float(lowest[int(_LOWEST * len(lowest))]) if len(lowest) else None


def _steadied(middle: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Return a way, (N, 3), the mean over so many frames on both sides taken twice."""
    frames = np.arange(len(middle))
    first, last = np.maximum(frames - reach, 0), np.minimum(frames + reach + 1, len(frames))
    for _ in range(2):  # so that the eye neither starts nor stops suddenly
        sums = np.concatenate([np.zeros((1, 3)), np.cumsum(middle, axis=0)])
        middle = (sums[last] - sums[first]) / (last - first)[:, None]
    return middle
