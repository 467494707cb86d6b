"""A figure on a picture: where its joints lie, and the frames painted from that."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.errors import ExportError
from lanindex.film.figure import Figure, View

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw


Floats = NDArray[np.float32]

ROOM = 1.3
"""How many times as high as the body the picture is at most: whoever goes further is followed."""

DEEPEST = 4000.0  # millimetres towards the eye in which the floor is drawn
LEAST = 600.0  # millimetres that are shown, at least
ROUND = 160.0  # millimetres left free around the figure: a head is larger than its joint
STEADY = 1.0  # seconds on both sides over which the eye that follows is steadied
SQUARE = 500.0  # millimetres from one line of the floor to the next

_FEET = [JOINT_CODES[side + joint] for side in "RL" for joint in ("Ankle", "Toe")]
_LOWEST = 0.01  # of the frames may have a foot below the floor: a camera errs
_USUAL = 0.99  # of the frames tell how large a body is: in others a joint may fly away
_FAR = 50  # squares to the side: of more no floor is drawn


@dataclass(frozen=True, slots=True, eq=False)
class FigureScene:
    """A figure placed on a picture, for all film frames."""

    size: tuple[int, int]  # Width and height, pixels
    scale: float  # Pixels in a millimetre
    # (N, 20, 2) float32, pixels from the upper left corner, x to the right, y down: the joints, a
    # row each film frame; NaN where unknown
    points: Floats
    depths: Floats  # (N, 20) float32, mm towards the eye
    # (N, 3) float64, mm to the right, up and towards the eye (level): the picture's middle
    eye: NDArray[np.float64]
    view: View
    floor: float | None  # How high the floor is, mm; None where no foot tells it
    # (N, 2) float32, pixels as if seen with the first frame's eye: the pelvis, on the floor
    path: Floats

    def __len__(self) -> int:
        """Return the number of film frames."""
        return len(self.points)

    def shift(self, frame: int) -> tuple[float, float]:
        """Return how far the background has moved on the picture since the first frame."""
        right, up, _ = (self.eye[0] - self.eye[frame]) * self.scale
        return float(right), float(-up)

    def lines(self, frame: int) -> list[tuple[float, float, float, float]]:
        """Return the visible lines of the floor: from x, y to x, y, pixels."""
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
    """Return the height on the picture of places on the floor, by their nearness, mm."""
    tilt = math.radians(view.tilt)
    return math.cos(tilt) * floor - math.sin(tilt) * near


def _placed(
    right: NDArray[np.floating], up: NDArray[np.floating], size: tuple[int, int], scale: float
) -> Floats:
    """Return pixels on the picture of millimetres from its middle."""
    x, y = right * scale + size[0] / 2, size[1] / 2 - up * scale
    return np.stack([x, y], axis=-1).astype(np.float32)


def _marks(start: float, stop: float) -> list[float]:
    """Return where lines of the floor stand between two places."""
    return [
        step * SQUARE for step in range(math.ceil(start / SQUARE), math.floor(stop / SQUARE) + 1)
    ]


def scene(
    figure: Figure, frames: NDArray[np.int64], view: View, size: tuple[int, int], rate: float
) -> FigureScene:
    """Place a figure on a picture: all at one scale, or followed where that would be small.

    `frames` (N,) are the frames of the motion that the film frames show.
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
    heights = places[:, _FEET, 1]
    lowest = np.nanmin(np.where(np.isnan(heights), np.inf, heights), axis=1)
    lowest = np.sort(lowest[np.isfinite(lowest)])
    floor = float(lowest[int(_LOWEST * len(lowest))]) if len(lowest) else None
    points = _placed(seen[..., 0] - eye[:, :1], seen[..., 1] - eye[:, 1:2], size, scale)
    path = np.full((len(frames), 2), np.nan, np.float32)
    if floor is not None:
        right, _, near = level[:, JOINT_CODES["Pelvis"]].T
        path = _placed(right - eye[0, 0], _laid(near, floor, view) - eye[0, 1], size, scale)
    return FigureScene(size, scale, points, level[..., 2], eye, view, floor, path)


def _ends(
    seen: Floats, known: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return lower and upper ends of the body, `ROUND` wider, (N, 3); interpolated in gaps."""
    there, frames = np.flatnonzero(known.any(axis=1)), np.arange(len(seen))
    ends = []
    for edge, sign in ((np.min, 1), (np.max, -1)):
        held = np.where(known[there, :, None], seen[there], sign * np.float32(np.inf))
        found = edge(held, axis=1).astype(np.float64) - sign * ROUND
        filled = [np.interp(frames, there, found[:, axis]) for axis in range(3)]
        ends.append(np.stack(filled, axis=1))
    return ends[0], ends[1]


def _steadied(middle: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    """Return a path, (N, 3), averaged twice over `reach` frames on both sides."""
    frames = np.arange(len(middle))
    first, last = np.maximum(frames - reach, 0), np.minimum(frames + reach + 1, len(frames))
    for _ in range(2):  # so that the eye neither starts nor stops suddenly
        sums = np.concatenate([np.zeros((1, 3)), np.cumsum(middle, axis=0)])
        middle = (sums[last] - sums[first]) / (last - first)[:, None]
    return middle


Color = tuple[int, int, int]

PAPER: Color = (255, 255, 255)
INK: Color = (34, 34, 34)
LEFT: Color = (140, 140, 140)  # of the limbs on the left: so that sides are told apart
LIT: Color = (224, 112, 0)  # of parts that matched

FLOOR: Color = (222, 222, 222)
WAY: Color = (120, 160, 210)
LINE: Color = (200, 16, 46)  # of the line that moves over the staff

COLORS = ((0, 0, 0), INK, LEFT, LIT, FLOOR, WAY, LINE, (252, 227, 178))
"""All that is drawn on paper; the first and the last are the staff's ink and band."""

SMOOTH = 2  # how many times larger it is drawn than shown

BONE, HEAD, SPOT = 26.0, 95.0, 45.0
"""Millimetres: how thick bones are; the radius of a head, and of the spot below the pelvis."""

TRAIL = 5.0  # seconds for which the way stays on the floor

_HEAD = JOINT_CODES["Head"]


class Painter:
    """Draws a figure in a scene."""

    def __init__(
        self, figure: Figure, scene: FigureScene, lit: NDArray[np.bool_], rate: float
    ) -> None:
        self.scene, self.lit, self.trail = scene, lit, round(TRAIL * rate)
        self.bones = figure.bones.tolist()
        self.colors = [LEFT if part.startswith("l_") else INK for part in figure.parts]
        self.size = (scene.size[0] * SMOOTH, scene.size[1] * SMOOTH)
        size = SMOOTH * scene.scale
        self.bone, self.head, self.spot = max(BONE * size, 3.0), HEAD * size, SPOT * size
        self.still = bool((scene.eye == scene.eye[0]).all())
        outer = {joint for _, joint in self.bones}
        self.joined = [inner in outer for inner, _ in self.bones]

    def ground(self, page: Image, frame: int = 0) -> None:
        """Draw the floor on a page: its lines are level or upright, and need no smoothing."""
        from PIL import ImageDraw

        draw = ImageDraw.Draw(page)
        for line in self.scene.lines(frame):
            draw.line(line, fill=FLOOR)

    def paint(self, frame: int, page: Image) -> None:
        """Draw a film frame in the left of a page, which has the floor already if it is still."""
        from PIL import ImageChops, ImageDraw

        if not self.still:
            self.ground(page, frame)
        canvas = self._canvas
        draw = ImageDraw.Draw(canvas)
        points = [*self._way(draw, frame), *self._body(draw, frame)]
        if not points:
            return
        free = max(self.head, self.spot, self.bone) + SMOOTH
        (left, right), (top, bottom) = (
            (
                min(max(int(min(it) - free), 0), most - SMOOTH) // SMOOTH * SMOOTH,
                min(max(int(max(it) + free) // SMOOTH * SMOOTH + SMOOTH, SMOOTH), most),
            )
            for it, most in zip(zip(*points, strict=True), self.size, strict=True)
        )
        box = left, top, right, bottom
        small = left // SMOOTH, top // SMOOTH, right // SMOOTH, bottom // SMOOTH
        below = page.crop(small)
        page.paste(ImageChops.darker(below, canvas.reduce(SMOOTH, box)), small[:2])
        canvas.paste(PAPER, box)

    @cached_property
    def _canvas(self) -> Image:
        """What a figure is drawn on, larger than it is shown; empty before and after each."""
        from PIL import Image

        return Image.new("RGB", self.size, PAPER)

    def _way(self, draw: ImageDraw, frame: int) -> list[tuple[float, float]]:
        """Draw where the pelvis has gone, and where it is, on the floor."""
        if self.scene.floor is None:
            return []
        path = self.scene.path[max(frame - self.trail, 0) : frame + 1]
        path = (path + np.array(self.scene.shift(frame), np.float32)) * SMOOTH
        gaps = np.flatnonzero(np.isnan(path[:, 0]))
        drawn: list[tuple[float, float]] = []
        for piece in np.split(path, gaps) if len(gaps) else [path]:
            points = [(x, y) for x, y in piece.tolist() if x == x]
            if len(points) > 1:
                draw.line(points, fill=WAY, width=2 * SMOOTH)
            drawn += points
        if not len(gaps) or gaps[-1] != len(path) - 1:
            (x, y), r = path[-1].tolist(), self.spot
            draw.ellipse((x - r, y - r / 3, x + r, y + r / 3), fill=WAY)
        return drawn

    def _body(self, draw: ImageDraw, frame: int) -> list[tuple[float, float]]:
        """Draw the bones that are known, the farthest first."""
        scene, half = self.scene, self.bone / 2
        points = (scene.points[frame] * SMOOTH).tolist()
        depths, lit = scene.depths[frame].tolist(), self.lit[frame].tolist()
        shown = []
        for bone, (inner, outer) in enumerate(self.bones):
            depth = depths[inner] + depths[outer]
            if depth == depth:
                shown.append((depth, bone, points[inner], points[outer]))
        shown.sort(key=lambda it: it[:2])
        for _, bone, (x, y), (a, b) in shown:
            color = LIT if lit[bone] else self.colors[bone]
            draw.line((x, y, a, b), fill=color, width=round(self.bone))
            for at, to in ((x, y), (a, b))[self.joined[bone] :]:
                draw.ellipse((at - half, to - half, at + half, to + half), fill=color)
            if self.bones[bone][1] == _HEAD:
                r = self.head
                draw.ellipse((a - r, b - r, a + r, b + r), fill=color)
        return [point for _, _, *ends in shown for point in ends]
