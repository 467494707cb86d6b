"""The stick figure of a motion: its bones, the view that shows it best, and its strokes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, PARTS, TRACKS, kind_of
from lanindex.data import shipped
from lanindex.draw.svg import BODY
from lanindex.errors import EncodeError, ExportError, UsageError
from lanindex.model import Motion
from lanindex.model.symbol import frozen

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

JOINTS = {**JOINT_CODES, "Nose": len(JOINT_CODES)}
"""The joints of the body by name, and what shows where its head looks."""

_TABLES = shipped("film/figure.toml")
_INSTEAD = {"hand": "forearm", "foot": "shank"}
"""What stands for an end that a capture does not have."""


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """The body of a motion, frame by frame."""

    # (T, 21, 3) float32, mm, y up: `JOINTS` at the frames of the source; NaN where one is absent
    # or unknown
    places: NDArray[np.float32]
    # (B, 2) int64: the two joints of each bone, the inner one first; both are there, though there
    # may be frames in which they are unknown
    bones: NDArray[np.int64]
    # (B) of which part each bone is, the finest that there is: ``torso``, ``head``,
    # ``r_upper_arm``, ``l_foot``
    parts: tuple[str, ...]
    rate: Fraction  # Frames a second
    # (T,) float64, radians about the vertical: from where the body is seen from the front, 0 from
    # where +z points; where nothing tells, the last one known
    fronts: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.places)

    def shown(self, tracks: Iterable[str]) -> NDArray[np.bool_]:
        """Return which bones show tracks, (B,) bool."""
        parts: set[str] = set()
        for track in tracks:
            if track not in TRACKS:
                raise UsageError(f'there is no part "{track}"', wanted=f"one of {' '.join(TRACKS)}")
            side = track[:2] if track[1] == "_" else ""
            names = _TABLES["tracks"].get(name := track.removeprefix(side), [name])
            parts |= {own + it for it in names for own in ([side] if side else ["r_", "l_", ""])}
        for end, before in _INSTEAD.items():
            for side in ("r_", "l_"):
                if side + end in parts and side + end not in self.parts:
                    parts.add(side + before)
        return np.array([part in parts for part in self.parts], bool)


def figure(motion: Motion) -> Figure:
    """Return the stick figure of a motion."""
    path, head = motion.source.path, JOINTS["Head"]
    if not len(motion):
        raise EncodeError("no frames", place=path, wanted="one at least")
    played = np.append(motion.skeleton.body, -1)  # no file has a nose
    places = motion.positions.take(played, axis=1)
    places[:, played < 0] = np.nan
    if played[JOINTS["Pelvis"]] < 0:
        hips = [JOINTS[side + "Hip"] for side in "LR"]
        places[:, JOINTS["Pelvis"]] = places[:, hips].sum(axis=1) / 2
    fronts = _fronts(places)
    looks = np.stack([np.sin(fronts), 0 * fronts, np.cos(fronts)], axis=1)
    if (axes := motion.axes.get("Head")) is not None:
        own = np.cross(axes[:, 1], axes[:, 0])
        looks = np.where(np.isnan(own), looks, own)
    places[:, JOINTS["Nose"]] = places[:, head] + NOSE * looks
    if 0 < motion.first < len(places):
        places[: motion.first], fronts[: motion.first] = places[motion.first], fronts[motion.first]
    known = np.isfinite(places.sum(axis=2))
    places[~known] = np.nan  # a place is known as a whole
    there = {joint for joint, code in JOINTS.items() if known[:, code].any()}
    bones = [
        (JOINTS[inner], JOINTS[outer], part)
        for outer, (part, *sources) in _TABLES["bones"].items()
        if outer in there and (inner := next((it for it in sources if it in there), None))
    ]
    if not bones:
        raise EncodeError("no bone of a body is known", place=path, wanted="one at least")
    pairs = np.array([pair for *pair, _ in bones], np.int64)
    parts = tuple(part for *_, part in bones)
    return Figure(frozen(places), frozen(pairs), parts, motion.rate, frozen(fronts))


_ACROSS = (("LHip", "RHip"), ("LShoulder", "RShoulder"))


def _fronts(places: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return from where the body is seen from the front in each frame, (T,) radians."""
    for left, right in _ACROSS:
        x, _, z = (places[:, JOINTS[left]] - places[:, JOINTS[right]]).astype(np.float64).T
        clear = np.flatnonzero(np.hypot(x, z) > 1.0)
        if len(clear):
            last = np.maximum(clear.searchsorted(np.arange(len(places)), "right") - 1, 0)
            found: NDArray[np.float64] = np.arctan2(-z, x)[clear[last]]
            return found
    return np.zeros(len(places))


def faced(
    figure: Figure, frames: NDArray[np.int64], about: NDArray[np.int64] | None = None
) -> Figure:
    """Return some frames of a figure, turned so that its front is seen from where +z points.

    What counts is the mean over the frames `about`, or the middle one if it turns round. The first
    pelvis that is known comes to stand above the origin, and the floor is at the lowest joint.
    """
    fronts = figure.fronts[frames if about is None else about]
    mean = np.exp(1j * fronts).mean()
    front = float(np.angle(mean) if abs(mean) > 0.5 else fronts[len(fronts) // 2])
    places = figure.places[frames]
    stands = stood(places)
    if len(known := np.flatnonzero(~np.isnan(stands[:, 0]))):
        origin = stands[known[0]] + (0, np.nanmin(places[..., 1]), 0)
        places = (places - origin) @ View(math.degrees(front), 0).axes().T
    return replace(figure, places=places.astype(np.float32), fronts=figure.fronts[frames] - front)


def stood(places: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the point of the floor below the pelvis, or the body's middle, (F, 3)."""
    with np.errstate(invalid="ignore"):  # a frame of which nothing is known
        middle = np.nansum(places, axis=1) / (~np.isnan(places)).sum(axis=1)
    pelvis = places[:, JOINTS["Pelvis"]]
    found = np.where(np.isnan(pelvis), middle, pelvis)
    found[:, 1] = 0
    return found


# Millimetres: how thick a bone is; how much wider what is laid under one that matched; the radius
# of a head; how far its nose reaches from its middle, and how thick that is
BONE, BAND, HEAD, NOSE, NOSTRIL = 26.0, 60.0, 95.0, 140.0, 46.0
LEGEND: dict[str, str] = _TABLES["legend"]
"""What a legend explains, and the colour of it."""

Point = tuple[float, ...]  # x and y
Stroke = tuple[Point, Point, float, str]
"""A line with round ends, its width in mm and its colour: all of a body is made of such."""


class Strokes:
    """The strokes of a figure, in films and on sheets, pages and notebooks."""

    def __init__(self, figure: Figure) -> None:
        # by stroke: its bone, which share of that is left out, its width and colour
        self.table: list[tuple[int, float, float, str]] = []
        for bone, (part, outer) in enumerate(zip(figure.parts, figure.bones[:, 1], strict=True)):
            color = {"r_": "right", "l_": "left"}.get(part[:2], "bone")
            nose = outer == JOINTS["Nose"]
            self.table.append((bone, HEAD / NOSE if nose else 0, NOSTRIL if nose else BONE, color))
            if outer == JOINTS["Head"]:
                self.table.append((bone, 1, 2 * HEAD, "head"))
        bones, shares, *_ = zip(*self.table, strict=True)
        self.inner, self.outer = figure.bones[[*bones]].T
        self._share = np.array(shares, np.float32)

    def of(
        self, points: NDArray[np.floating], depths: NDArray[np.floating], lit: Sequence[bool]
    ) -> list[Stroke]:
        """Return the strokes of a pose, the farthest first, below all of them what is lit, (B).

        `points` (21, 2) and `depths` (21,) are those of the joints; what is unknown is left out.
        """
        inner, outer, share = points[self.inner], points[self.outer], self._share
        starts = (inner + (outer - inner) * share[:, None]).tolist()
        ends = list(zip(map(tuple, starts), map(tuple, outer.tolist()), strict=True))
        near = depths[self.inner] * (1 - share) + depths[self.outer] * (1 + share)
        near += (share == 1) * HEAD  # a ball hides its neck
        known = len(near) - int(np.isnan(near).sum())
        rows = [(*ends[row], *self.table[row]) for row in near.argsort(kind="stable")[:known]]
        bands = [(a, b, width + BAND, "lit") for a, b, bone, _, width, _ in rows if lit[bone]]
        return bands + [(a, b, width, color) for a, b, _, _, width, color in rows]


TILT = 12.0  # degrees from which a figure is looked down upon, so that the floor is seen
SAMPLES = 2048  # frames that are looked at, at most, spread evenly
WORTH = 0.1  # share by which another view must show more than the front does

_STAYS = ("gesture", "bend", "touch", "twist", "incline")
"""Kinds of tracks in which a limb moves against the body, not the body over the floor."""


@dataclass(frozen=True, slots=True)
class View:
    """A direction from which a figure is seen, without perspective."""

    turn: float  # Degrees about the vertical: 0 from where +z points, +x to the right; 90 from +x
    tilt: float = TILT  # Degrees above the horizon

    def axes(self) -> NDArray[np.float64]:
        """Return the vectors right, up and towards the eye, (3, 3), a row each."""
        turn, tilt = math.radians(self.turn), math.radians(self.tilt)
        sin, cos, sine, cosine = math.sin(turn), math.cos(turn), math.sin(tilt), math.cos(tilt)
        up, toward = [-sine * sin, cosine, -sine * cos], [cosine * sin, sine, cosine * cos]
        return np.array([[cos, 0.0, -sin], up, toward])


def view(bodies: Iterable[tuple[Figure, Sequence[str]]]) -> View:
    """Return the one view in which the parts that move spread widest, or else the front.

    Each body is `faced`, and has the tracks that are looked at; without any it is all of it. The
    front is kept where no other view shows a tenth more. Of the two sides of a line the one nearer
    to the front is taken; of left and right the right, but the left for parts of the left alone.
    """
    spread, sides, turn = np.zeros((3, 3)), set[str](), 0.0
    for figure, tracks in bodies:
        sides |= {track[:2] for track in tracks}
        frames = np.linspace(0, len(figure) - 1, min(len(figure), SAMPLES)).astype(np.int64)
        places, moves = figure.places[frames].astype(np.float64), []
        for track in tracks or ("other_support",):  # that may be any part of it
            joints = np.unique(figure.bones[figure.shown([track])])
            moves.append(places[:, joints])
            if kind_of(track) in _STAYS:  # relative to where a limb hangs
                part = PARTS.get(track.removesuffix("_bend"))
                hangs = JOINTS[part.parent if part else "Pelvis"]
                moves[-1] = moves[-1] - places[:, hangs, None]
        spread += _spread(np.concatenate(moves, axis=1))
    xx, xz, zz = spread[0, 0], spread[0, 2], spread[2, 2]
    if math.hypot(xx - zz, 2 * xz) > 1e-9 * (xx + zz):  # else all turns are equal
        off = -0.5 * math.atan2(2 * xz, xx - zz)
        if _spread_seen(spread, off) > (1 + WORTH) * _spread_seen(spread, 0):
            side = 1.0 if sides == {"l_"} else -1.0
            ways = (off, off - math.copysign(math.pi, off))  # from this side of it or the other
            turn = min(ways, key=lambda it: (round(abs(it), 1), -side * it))
    return View(round(math.degrees(turn), 6) + 0.0)


def _spread(moves: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean products of x, y and z about their means, all joints taken together."""
    joints = moves.reshape(len(moves), -1, 3)
    known = ~np.isnan(joints).any(axis=2, keepdims=True)
    count = np.maximum(known.sum(axis=0), 1)
    held = np.where(known, joints, 0.0)
    away = np.where(known, held - held.sum(axis=0) / count, 0.0).reshape(-1, 3)
    spread: NDArray[np.float64] = away.T @ away / max(int(known.sum()), 1)
    return spread


def _spread_seen(spread: NDArray[np.float64], turn: float) -> float:
    """Return how far a movement spreads on the picture, squared."""
    right = np.array([math.cos(turn), 0.0, -math.sin(turn)])
    return float(right @ spread @ right + spread[1, 1])


Floats = NDArray[np.float32]

# How many times as high as the body the picture is at most: whoever goes further is followed
ROOM = 1.05
DEEPEST = 4000.0  # millimetres towards the eye in which the floor is drawn
LEAST = 600.0  # millimetres that are shown, at least
ROUND = 120.0  # millimetres left free around the figure: a head is larger than its joint
STEADY = 1.0  # seconds on both sides over which the eye that follows is steadied
SQUARE = 500.0  # millimetres from one line of the floor to the next

_FEET = [JOINTS[side + joint] for side in "RL" for joint in ("Ankle", "Toe")]
_LOWEST = 0.01  # of the frames may have a foot below the floor: a camera errs
_USUAL = 0.99  # of the frames tell how large a body is: in others a joint may fly away
_FAR = 50  # squares to the side: of more no floor is drawn


@dataclass(frozen=True, slots=True, eq=False)
class FigureScene:
    """A figure placed on a picture, for all film frames."""

    size: tuple[int, int]  # Width and height, pixels
    middle: tuple[float, float]  # Of the part that the figure fills, pixels
    scale: float  # Pixels in a millimetre
    # (N, 21, 2) float32, pixels from the upper left corner, x to the right, y down: the joints, a
    # row each film frame; NaN where unknown
    points: Floats
    depths: Floats  # (N, 21) float32, mm towards the eye
    # (N, 3) float64, mm to the right, up and towards the eye (level): the picture's middle
    eye: NDArray[np.float64]
    view: View
    floor: float | None  # How high the floor is, mm; None where no foot tells it
    # (N, 2) float32, pixels as if seen with the first frame's eye: the pelvis, on the floor
    path: Floats

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
        across, down = self.middle
        ys = [down + (up - _floor_height(it, self.floor, self.view)) * scale for it in rows]
        xs = [across + (it - right) * scale for it in _marks(right - wide, right + wide)]
        top, bottom = max(min(ys), 0), min(max(ys), height - 1)
        level = [(0, y, width - 1, y) for y in ys if top <= y <= bottom]
        return [*level, *((x, top, x, bottom) for x in xs if x < width and top < bottom)]


def _floor_height(near: Any, floor: float, view: View) -> Any:
    """Return the height on the picture of places on the floor, by their nearness, mm."""
    tilt = math.radians(view.tilt)
    return math.cos(tilt) * floor - math.sin(tilt) * near


def _marks(start: float, stop: float) -> list[float]:
    """Return where lines of the floor stand between two places."""
    return [
        step * SQUARE for step in range(math.ceil(start / SQUARE), math.floor(stop / SQUARE) + 1)
    ]


def scene(
    figure: Figure, view: View, size: tuple[int, int], rate: float, head: int = 0
) -> FigureScene:
    """Place a figure on a picture below its head, at one scale or followed by the eye."""
    places = figure.places
    known = ~np.isnan(places[..., 0])
    if not known.any():
        raise ExportError("no joint is known in this stretch", wanted="a body that is seen")
    axes = view.axes()
    axes[2] = View(view.turn, 0).axes()[2]  # the floor is level: what is nearer is not higher
    seen = places @ axes.T.astype(np.float32)
    lows, highs = _ends(seen, known)
    low, high = lows.min(axis=0), highs.max(axis=0)
    body = np.quantile(highs - lows, _USUAL, axis=0, method="higher")[:2]
    most = np.maximum(body, ROOM * body[1] * np.array([size[0] / size[1], 1]))
    shown = np.maximum(np.minimum((high - low)[:2], most), LEAST)
    fills = size[0], size[1] - head
    scale, middle = float((np.array(fills) / shown).min()), (size[0] / 2, head + fills[1] / 2)
    room = np.array([fills[0] / scale, fills[1] / scale, DEEPEST])
    eye = np.repeat((low + high)[None] / 2, len(places), axis=0)
    if (far := high - low > room * 1.001).any():
        steady, reach = (lows + highs) / 2, round(STEADY * rate)
        count = np.arange(len(places))
        first, last = np.maximum(count - reach, 0), np.minimum(count + reach + 1, len(places))
        for _ in range(2):  # averaged twice: the eye neither starts nor stops suddenly
            sums = np.concatenate([np.zeros((1, 3)), np.cumsum(steady, axis=0)])
            steady = (sums[last] - sums[first]) / (last - first)[:, None]
        eye[:, far] = np.clip(steady, highs - room / 2, lows + room / 2)[:, far]
    heights = places[:, _FEET, 1]
    lowest = np.nanmin(np.where(np.isnan(heights), np.inf, heights), axis=1)
    lowest = np.sort(lowest[np.isfinite(lowest)])
    floor = float(lowest[int(_LOWEST * len(lowest))]) if len(lowest) else None
    onto = np.array((scale, -scale))
    points = ((seen[..., :2] - eye[:, None, :2]) * onto + middle).astype(np.float32)
    right, _, near = seen[:, JOINTS["Pelvis"]].T
    up = _floor_height(near, floor or 0.0, view)
    path = ((np.stack([right, up], axis=1) - eye[0, :2]) * onto + middle).astype(np.float32)
    return FigureScene(size, middle, scale, points, seen[..., 2], eye, view, floor, path)


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


Color = tuple[int, ...]

PAPER: Color = (255, 255, 255)
PALETTE: dict[str, Color] = {
    kind: (*bytes.fromhex(color[1:]),) for kind, color in (BODY | _TABLES["colors"]).items()
}
"""Red, green and blue of all that is drawn in a film but its staff."""

SMOOTH = 2  # how many times larger it is drawn than shown
SPOT = 45.0  # millimetres, the radius of the spot below the pelvis
TRAIL = 5.0  # seconds for which the way stays on the floor
SPARSE = 3  # film frames from one of its points to the next


class Painter:
    """Draws a figure in a scene."""

    def __init__(
        self, figure: Figure, scene: FigureScene, lit: NDArray[np.bool_], rate: float
    ) -> None:
        self.scene, self.lit, self.trail = scene, lit, round(TRAIL * rate)
        self.strokes = Strokes(figure)
        self.scale = SMOOTH * scene.scale
        self.still = bool((scene.eye == scene.eye[0]).all())

    def ground(self, page: Image, frame: int = 0) -> None:
        """Draw the floor on a page: its lines are level or upright, and need no smoothing."""
        from PIL import ImageDraw

        draw = ImageDraw.Draw(page)
        for line in self.scene.lines(frame):
            draw.line(line, fill=PALETTE["floor"])

    def paint(self, frame: int, page: Image) -> None:
        """Draw a film frame in the left of a page, which has the floor already if it is still."""
        from PIL import ImageChops, ImageDraw

        if not self.still:
            self.ground(page, frame)
        canvas = self._canvas
        self._path(ImageDraw.Draw(page), frame)
        if not (boxes := self._body(ImageDraw.Draw(canvas), frame)):
            return
        low, high = np.min(boxes, axis=0)[:2] // SMOOTH, np.max(boxes, axis=0)[2:] // SMOOTH + 1
        size = np.array(self.scene.size)
        low, high = np.clip(low, 0, size - 1).astype(int), np.clip(high, 1, size).astype(int)
        small = (*low.tolist(), *high.tolist())
        box = tuple(it * SMOOTH for it in small)
        below = page.crop(small)
        page.paste(ImageChops.darker(below, canvas.reduce(SMOOTH, box)), small[:2])
        canvas.paste(PAPER, box)

    @cached_property
    def _canvas(self) -> Image:
        """What a figure is drawn on, larger than it is shown; empty before and after each."""
        from PIL import Image

        return Image.new("RGB", (self.scene.size[0] * SMOOTH, self.scene.size[1] * SMOOTH), PAPER)

    def _path(self, draw: ImageDraw, frame: int) -> None:
        """Draw where the pelvis has gone, and where it is, on the floor."""
        if self.scene.floor is None:
            return
        path = self.scene.path[max(frame - self.trail, 0) : frame + 1][::-SPARSE]
        path, r = path + np.array(self.scene.shift(frame), np.float32), SPOT * self.scene.scale
        path[path[:, 0] > self.scene.size[0] - 1 - r] = np.nan  # the staff is there
        for piece in np.split(path, np.flatnonzero(np.isnan(path[:, 0]))):
            points = [(x, y) for x, y in piece.tolist() if x == x]
            if len(points) > 1:
                draw.line(points, fill=PALETTE["way"], width=2)
        x, y = path[0].tolist()
        if x == x:
            draw.ellipse((x - r, y - r / 3, x + r, y + r / 3), fill=PALETTE["way"])

    def _body(self, draw: ImageDraw, frame: int) -> list[tuple[float, ...]]:
        """Draw the body as far as it is known; return the boxes of the ends of its strokes."""
        scene, boxes, ends = self.scene, list[tuple[float, ...]](), set[tuple[float, ...]]()
        points, lit = scene.points[frame] * SMOOTH, self.lit[frame].tolist()
        for start, stop, width, color in self.strokes.of(points, scene.depths[frame], lit):
            wide, fill = max(width * self.scale, 3.0), PALETTE[color]
            draw.line((start, stop), fill=fill, width=round(wide))
            half = wide / 2
            for x, y in {stop, start} - ends | {stop}:  # most begin where another ends
                boxes.append((x - half, y - half, x + half, y + half))
                draw.ellipse(boxes[-1], fill=fill)
            ends |= {start, stop}
        return boxes
