"""A scene drawn: the floor, the way over it, and the figure, its matched parts in colour."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.film.figure import Figure
from lanindex.film.scene import Scene

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

Color = tuple[int, int, int]

PAPER: Color = (255, 255, 255)
INK: Color = (34, 34, 34)
LEFT: Color = (140, 140, 140)
"""Of the limbs on the left: so that sides are told apart."""

LIT: Color = (224, 112, 0)
"""Of parts that matched."""

FLOOR: Color = (222, 222, 222)
WAY: Color = (120, 160, 210)
LINE: Color = (200, 16, 46)
"""Of the line that moves over the staff."""

COLORS = ((0, 0, 0), INK, LEFT, LIT, FLOOR, WAY, LINE, (252, 227, 178))
"""All that is drawn on paper; the first and the last are the staff's ink and band."""

SMOOTH = 2
"""How many times larger it is drawn than shown."""

BONE, HEAD, SPOT = 26.0, 95.0, 45.0
"""Millimetres: how thick bones are; the radius of a head, and of the spot below the pelvis."""

TRAIL = 5.0
"""Seconds for which the way stays on the floor."""

_HEAD = JOINT_CODES["Head"]


class Painter:
    """Draws a figure in a scene."""

    def __init__(self, figure: Figure, scene: Scene, lit: NDArray[np.bool_], rate: float) -> None:
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
        if marks := [*self._way(draw, frame), *self._body(draw, frame)]:
            box = self._box(marks)
            left, top, right, bottom = (it // SMOOTH for it in box)
            below = page.crop((left, top, right, bottom))
            page.paste(ImageChops.darker(below, canvas.reduce(SMOOTH, box)), (left, top))
            canvas.paste(PAPER, box)

    @cached_property
    def _canvas(self) -> Image:
        """What a figure is drawn on, larger than it is shown; empty before and after each."""
        from PIL import Image

        return Image.new("RGB", self.size, PAPER)

    def _box(self, marks: Iterable[tuple[float, float]]) -> tuple[int, int, int, int]:
        """Return what to take over of a canvas on which something was drawn around points."""
        xs, ys = zip(*marks, strict=True)
        free = max(self.head, self.spot, self.bone) + SMOOTH
        (left, right), (top, bottom) = (
            (
                min(max(int(min(it) - free), 0), most - SMOOTH) // SMOOTH * SMOOTH,
                min(max(int(max(it) + free) // SMOOTH * SMOOTH + SMOOTH, SMOOTH), most),
            )
            for it, most in ((xs, self.size[0]), (ys, self.size[1]))
        )
        return left, top, right, bottom

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
