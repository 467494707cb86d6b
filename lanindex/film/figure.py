"""The stick figure of a motion: its bones, the view that shows it best, and its pictures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, PARTS, TRACKS, kind_of
from lanindex.errors import EncodeError, ExportError, UsageError
from lanindex.model import Motion
from lanindex.model.symbol import frozen

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

BONES: tuple[tuple[str, tuple[str, ...], str], ...] = (
    ("Chest", ("Pelvis",), "torso"),
    ("Neck", ("Chest", "Pelvis"), "torso"),
    ("Head", ("Neck", "Chest"), "head"),
    *((side + "Shoulder", ("Neck", "Chest", "Pelvis"), "torso") for side in "RL"),
    *((side + "Hip", ("Pelvis",), "torso") for side in "RL"),
    *(
        (PARTS[part].child, (PARTS[part].parent,), part)
        for group in ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")
        for part in (f"r_{group}", f"l_{group}")
    ),
)
"""By joint: the candidates for its bone's inner joint, best first, and the bone's part."""

_ARM, _LEG = ("upper_arm", "forearm"), ("thigh", "shank")
_GROUPS = {
    "arm": _ARM,
    "leg": _LEG,
    "palm": ("hand",),
    "support": (*_LEG, "foot"),
    "stance": ("foot",),
    "arm_bend": _ARM,
    "leg_bend": _LEG,
    "hand_touch": ("forearm", "hand"),
}
"""The bones of tracks with a side, where their names differ."""

_LEGS = tuple(f"{side}_{part}" for side in "rl" for part in _GROUPS["support"])
_WHOLE = {
    "step": _LEGS,
    "jump": _LEGS,
    "torso_twist": ("torso",),
    "torso_incline": ("torso",),
    "head_turn": ("head",),
    "head_incline": ("head",),
    "hands_touch": tuple(f"{side}_{part}" for side in "rl" for part in _GROUPS["hand_touch"]),
    **dict.fromkeys(
        ("body_travel", "body_turn", "other_support"), tuple({part: 0 for _, _, part in BONES})
    ),
}
"""The same of tracks of the whole body."""

_INSTEAD = {"hand": "forearm", "foot": "shank"}
"""What stands for an end that a capture does not have."""


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """The body of a motion, frame by frame."""

    # (T, 20, 3) float32, mm, y up: ``alphabet.JOINTS`` at the frames of the source; NaN where a
    # joint is absent or unknown
    places: NDArray[np.float32]
    # (B, 2) int64: the two joints of each bone, the inner one first; both are there, though there
    # may be frames in which they are unknown
    bones: NDArray[np.int64]
    # (B) of which part each bone is, the finest that there is: ``torso``, ``head``,
    # ``r_upper_arm``, ``l_foot``
    parts: tuple[str, ...]
    rate: Fraction  # Frames a second

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.places)

    def shown(self, tracks: Iterable[str]) -> NDArray[np.bool_]:
        """Return which bones show tracks, (B,) bool."""
        parts: set[str] = set()
        for track in tracks:
            if track not in TRACKS:
                raise UsageError(f'there is no part "{track}"', wanted=f"one of {' '.join(TRACKS)}")
            side, group = track[:2], track[2:]
            if track in _WHOLE or side not in ("r_", "l_"):
                parts.update(_WHOLE.get(track, (track,)))
            else:
                parts.update(side + part for part in _GROUPS.get(group, (group,)))
        for end, before in _INSTEAD.items():
            for side in ("r_", "l_"):
                if side + end in parts and side + end not in self.parts:
                    parts.add(side + before)
        return np.array([part in parts for part in self.parts], bool)


def figure(motion: Motion) -> Figure:
    """Return the stick figure of a motion."""
    path = motion.source.path
    if not len(motion):
        raise EncodeError("no frames", place=path, wanted="one at least")
    body = motion.skeleton.body
    places = motion.positions.take(body, axis=1)
    places[:, body < 0] = np.nan
    if body[JOINT_CODES["Pelvis"]] < 0:
        hips = [JOINT_CODES[side + "Hip"] for side in "LR"]
        places[:, JOINT_CODES["Pelvis"]] = places[:, hips].sum(axis=1) / 2
    if 0 < motion.first < len(places):
        places[: motion.first] = places[motion.first]
    known = np.isfinite(places.sum(axis=2))
    places[~known] = np.nan  # a place is known as a whole
    there = {joint for joint, code in JOINT_CODES.items() if known[:, code].any()}
    bones = [
        (JOINT_CODES[inner], JOINT_CODES[outer], part)
        for outer, sources, part in BONES
        if outer in there and (inner := next((it for it in sources if it in there), None))
    ]
    if not bones:
        raise EncodeError("no bone of a body is known", place=path, wanted="one at least")
    pairs = np.array([pair for *pair, _ in bones], np.int64)
    return Figure(frozen(places), frozen(pairs), tuple(part for *_, part in bones), motion.rate)


TILT = 12.0  # degrees from which a figure is looked down upon, so that the floor is seen
SAMPLES = 2048  # frames that are looked at, at most, spread evenly
WORTH = 0.1  # share by which another view must show more than the front does

_ACROSS = (("LHip", "RHip"), ("LShoulder", "RShoulder"))
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

    def project(self, places: NDArray[np.floating]) -> NDArray[np.float32]:
        """Return places, (..., 3) mm, y up, on the picture: (..., 2) float32 mm."""
        seen: NDArray[np.float32] = places.astype(np.float32) @ self.axes()[:2].T.astype(np.float32)
        return seen


def view(
    figure: Figure, tracks: Sequence[str] | None = None, start: int = 0, stop: int | None = None
) -> View:
    """Return the view in which the parts that move spread widest, or else the front.

    The front is kept where no other view shows a tenth more. Of the two sides of a line the one
    nearer to the front is taken; of left and right the right, but the left for parts of the left.
    """
    places = _sampled(figure, start, stop)
    turn = ahead = _front(places)
    moves = []
    for track in tracks or ("body_travel",):
        joints = np.unique(figure.bones[figure.shown([track])])
        moves.append(places[:, joints])
        if kind_of(track) in _STAYS:  # relative to where a limb hangs
            part = PARTS.get(track.removesuffix("_bend"))
            hangs = JOINT_CODES[part.parent if part else "Pelvis"]
            moves[-1] = moves[-1] - places[:, hangs, None]
    spread = _spread(np.concatenate(moves, axis=1))
    xx, xz, zz = spread[0, 0], spread[0, 2], spread[2, 2]
    if math.hypot(xx - zz, 2 * xz) > 1e-9 * (xx + zz):  # else all turns are equal
        best = -0.5 * math.atan2(2 * xz, xx - zz)
        if _spread_seen(spread, best) > (1 + WORTH) * _spread_seen(spread, ahead):
            side = 1.0 if {track[:2] for track in tracks or ()} == {"l_"} else -1.0
            off = (best - ahead + math.pi) % (2 * math.pi) - math.pi
            ways = (off, off - math.copysign(math.pi, off))  # from this side of it or the other
            turn = ahead + min(ways, key=lambda it: (round(abs(it), 1), -side * it))
    return _view(turn)


def front(figure: Figure, start: int = 0, stop: int | None = None, turned: float = 0.0) -> View:
    """Return the view from where the body faces, on average."""
    return _view(_front(_sampled(figure, start, stop)) + math.radians(turned))


def _view(turn: float) -> View:
    return View(round((math.degrees(turn) + 180) % 360 - 180, 6) + 0.0)


def _sampled(figure: Figure, start: int, stop: int | None) -> NDArray[np.float64]:
    """Return the joints in some frames of a span, (S, 20, 3)."""
    stop = len(figure) if stop is None else stop
    if not 0 <= start < stop <= len(figure):
        found = f"nothing from frame {start} to {stop}"
        raise UsageError(found, wanted=f"a stretch of 0 to {len(figure)}")
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
ROOM = 1.3
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
        ys = [height / 2 + (up - _floor_height(it, self.floor, self.view)) * scale for it in rows]
        xs = [width / 2 + (it - right) * scale for it in _marks(right - wide, right + wide)]
        top, bottom = max(min(ys), 0), min(max(ys), height - 1)
        level = [(0, y, width - 1, y) for y in ys if top <= y <= bottom]
        return [*level, *((x, top, x, bottom) for x in xs if x < width and top < bottom)]


def _floor_height(near: Any, floor: float, view: View) -> Any:
    """Return the height on the picture of places on the floor, by their nearness, mm."""
    tilt = math.radians(view.tilt)
    return math.cos(tilt) * floor - math.sin(tilt) * near


def _pixels(
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
    """Place frames, (N,), of a figure on a picture, at one scale or followed by the eye."""
    places = figure.places[frames]
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
    scale = float((np.array(size) / shown).min())
    room = np.array([size[0] / scale, size[1] / scale, DEEPEST])
    eye = np.repeat((low + high)[None] / 2, len(frames), axis=0)
    if (far := high - low > room * 1.001).any():
        steady, reach = (lows + highs) / 2, round(STEADY * rate)
        count = np.arange(len(frames))
        first, last = np.maximum(count - reach, 0), np.minimum(count + reach + 1, len(frames))
        for _ in range(2):  # averaged twice: the eye neither starts nor stops suddenly
            sums = np.concatenate([np.zeros((1, 3)), np.cumsum(steady, axis=0)])
            steady = (sums[last] - sums[first]) / (last - first)[:, None]
        eye[:, far] = np.clip(steady, highs - room / 2, lows + room / 2)[:, far]
    heights = places[:, _FEET, 1]
    lowest = np.nanmin(np.where(np.isnan(heights), np.inf, heights), axis=1)
    lowest = np.sort(lowest[np.isfinite(lowest)])
    floor = float(lowest[int(_LOWEST * len(lowest))]) if len(lowest) else None
    points = _pixels(seen[..., 0] - eye[:, :1], seen[..., 1] - eye[:, 1:2], size, scale)
    right, _, near = seen[:, JOINT_CODES["Pelvis"]].T
    up = _floor_height(near, floor or 0.0, view)
    path = _pixels(right - eye[0, 0], up - eye[0, 1], size, scale)
    return FigureScene(size, scale, points, seen[..., 2], eye, view, floor, path)


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


Color = tuple[int, int, int]

PAPER: Color = (255, 255, 255)
INK: Color = (34, 34, 34)
LEFT: Color = (140, 140, 140)  # of the limbs on the left: so that sides are told apart
LIT: Color = (224, 112, 0)  # of parts that matched

FLOOR: Color = (222, 222, 222)
WAY: Color = (120, 160, 210)
LINE: Color = (200, 16, 46)  # of the line that moves over the staff
# All that is drawn on paper; the first and the last are the staff's ink and band
COLORS = ((0, 0, 0), INK, LEFT, LIT, FLOOR, WAY, LINE, (252, 227, 178))
SMOOTH = 2  # how many times larger it is drawn than shown
# Millimetres: how thick bones are; the radius of a head, and of the spot below the pelvis
BONE, HEAD, SPOT = 26.0, 95.0, 45.0
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
        points = [*self._path(draw, frame), *self._body(draw, frame)]
        if not points:
            return
        free = max(self.head, self.spot, self.bone) + SMOOTH
        ends, size = np.array(points), np.array(self.size)
        low = np.clip(ends.min(axis=0) - free, 0, size - SMOOTH).astype(int) // SMOOTH
        high = np.clip((ends.max(axis=0) + free).astype(int) // SMOOTH + 1, 1, size // SMOOTH)
        small = (*low.tolist(), *high.tolist())
        left, top, right, bottom = (it * SMOOTH for it in small)
        box = left, top, right, bottom
        below = page.crop(small)
        page.paste(ImageChops.darker(below, canvas.reduce(SMOOTH, box)), small[:2])
        canvas.paste(PAPER, box)

    @cached_property
    def _canvas(self) -> Image:
        """What a figure is drawn on, larger than it is shown; empty before and after each."""
        from PIL import Image

        return Image.new("RGB", self.size, PAPER)

    def _path(self, draw: ImageDraw, frame: int) -> list[tuple[float, float]]:
        """Draw where the pelvis has gone, and where it is, on the floor."""
        if self.scene.floor is None:
            return []
        path = self.scene.path[max(frame - self.trail, 0) : frame + 1]
        path = (path + np.array(self.scene.shift(frame), np.float32)) * SMOOTH
        gaps = np.flatnonzero(np.isnan(path[:, 0]))
        drawn: list[tuple[float, float]] = []
        for piece in np.split(path, gaps):
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
