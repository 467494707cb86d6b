"""What the hands touch: each other, the head, the trunk, the other arm, the legs.

Source: ``encode/BODY.md``, "Touch".
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import TOUCHED
from lanindex.encode.arithmetic import runs
from lanindex.encode.ground import FLICKER, held
from lanindex.encode.joints import Body
from lanindex.encode.places import Stretch, ever, stretches
from lanindex.encode.steps import Event
from lanindex.encode.ways import pieces

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Places = dict[str, Floats]

PALM = 0.15
"""Lengths of an arm from the wrist to the middle of the palm, towards the hand's joint."""

CROWN = 0.33
"""Lengths of an arm from the neck to the middle of the head, towards the head's joint."""

PALMS, SKULL, TRUNK, SLEEVE = 0.15, 0.25, 0.25, 0.13
"""Lengths of an arm: a palm that is nearer to the other one, to the middle of the head, to the
trunk's lines or to the other arm's touches it."""

THIGH, KNEE, SHANK, FOOT = 0.2, 0.17, 0.15, 0.15
"""The same, of the legs."""

WIDER = 0.05
"""Lengths of an arm that all of these are longer for a hand of which only the wrist is known."""

LEAVES = 1.25
"""Times as far, and touch ends."""

HANGS = 30.0
"""Degrees from the trunk, neck to hips: an arm hangs beside it, if it is straight."""

STRAIGHT = 0.8
"""Lengths of an arm from shoulder to wrist of one that is straight."""

QUIET, DWELLS = 0.5, 0.25
"""Lengths of an arm a second, and seconds: a hand does not touch what it passes faster, or slowly
for less time."""

RUBS = 1.5
"""Lengths of an arm a second: a hand that comes to pass faster has left."""

MEETS = 1.0
"""Lengths of an arm a second: hands that never pass each other slower do not touch."""

ARMS = ("r_arm", "l_arm")
HANDS = ("RWrist", "LWrist")
CORE = ("RHip", "LHip", "Neck")
_OTHERS = (
    *("Chest", "Head"),
    *(side + it for side in "RL" for it in ("Hand", "Shoulder", "Elbow", "Knee", "Ankle", "Toe")),
)
_REACHES = {
    **{"hand": PALMS, "head": SKULL, "trunk": TRUNK, "arm": SLEEVE},
    **{"thigh": THIGH, "knee": KNEE, "shank": SHANK, "foot": FOOT},
}
_LINES = (
    ("head", "Crown", "Crown"),
    *(("trunk", f"{it}Hip", f"{it}Waist") for it in ("", *"RL")),
    *(("trunk", f"{it}Waist", f"{it}Neck") for it in ("", *"RL")),
    *(
        ("arm", *line)
        for line in (("other Shoulder", "other Elbow"), ("other Elbow", "other Wrist"))
    ),
    *(
        (name, side + joint, side + last)
        for side in "RL"
        for name, joint, last in (
            ("thigh", "Hip", "Knee"),
            ("knee", "Knee", "Knee"),
            ("shank", "Knee", "Ankle"),
            ("foot", "Ankle", "Toe"),
            ("foot", "Ankle", "Ankle"),
        )
    ),
)
"""What is touched, and the ends of a line inside it; ``other`` is the other side of the hand's."""

_BESIDE = ("trunk", "thigh")
"""What a hanging arm lies beside."""

_TRACKS = ("hands_touch", "r_hand_touch", "l_hand_touch")
_FAR = 9.0


@dataclass(frozen=True, slots=True, eq=False)
class _Near:
    """What a hand is nearest to, frame by frame.

    Attributes
    ----------
    what : ndarray
        (N,) int8, codes of ``alphabet.TOUCHED``.
    apart : ndarray
        (N,) float32, how far it is, as a part of how near touches.
    pace : ndarray
        (N,) float32, lengths of an arm a second past it.
    together : bool
        Whether it is both hands that are near each other.
    """

    what: NDArray[np.int8]
    apart: NDArray[np.float32]
    pace: NDArray[np.float32]
    together: bool

    @property
    def columns(self) -> tuple[NDArray[Any], ...]:
        """All of them."""
        return self.what, self.apart, self.pace

    @staticmethod
    def far(count: int, part: str) -> _Near:
        """Return a hand, or hands, near nothing."""
        apart, pace = np.full((2, count), _FAR, np.float32)
        return _Near(np.zeros(count, np.int8), apart, pace, part == _TRACKS[0])

    def take(self, name: str, apart: Floats, pace: Floats) -> None:
        """Be near something where it is nearer than what was before."""
        nearer = apart < self.apart
        self.what[nearer] = TOUCHED.index(name)
        self.apart[nearer], self.pace[nearer] = apart[nearer], pace[nearer]


def touches(body: Body, arm: float) -> Iterator[tuple[str, Stretch, list[Event]]]:
    """Yield what the hands touch: track, stretch, symbols.

    Parameters
    ----------
    body : Body
        The capture.
    arm : float
        How long its arms are, mm.
    """
    rate = float(body.profile.rate)
    core = [name for name in CORE if ever(body, name)]
    for one in stretches(body, (*HANDS, *core), _OTHERS):
        found = {part: _Near.far(len(one.frames), part) for part in _TRACKS}
        for block, places in one.blocks(1):
            some = {name: points / arm for name, points in places.items()}
            for part, near in _nearest(_points(some), rate).items():
                for whole, own in zip(found[part].columns, near.columns, strict=True):
                    whole[block.inner] = own[block.within]
        for part, near in found.items():
            yield part, one, _events(near, rate)


def _points(places: Places) -> Places:
    """Return joints, palms and what else lines go through."""
    points = dict(places)
    for side in "RL":
        palm = points[f"{side}Wrist"]
        if f"{side}Hand" in points:
            palm = palm + PALM * _unit(points[f"{side}Hand"] - palm)
        points[f"{side}Palm"] = palm
    if "Neck" in points and "Head" in points:
        points["Crown"] = points["Neck"] + CROWN * _unit(points["Head"] - points["Neck"])
    if all(it in points for it in CORE):
        points["Hip"] = middle = (points["RHip"] + points["LHip"]) / 2
        points["Waist"] = points.get("Chest", (middle + points["Neck"]) / 2)
        for side in "RL":
            for it in ("Waist", "Neck"):
                points[side + it] = points[it] + points[f"{side}Hip"] - middle
    return points


def _nearest(points: Places, rate: float) -> dict[str, _Near]:
    """Return what is near to each hand and to both, of points in lengths of an arm."""
    paces = {name: _pace(it, rate) for name, it in points.items()}
    count = len(points["RPalm"])
    both, right, left = found = [_Near.far(count, part) for part in _TRACKS]
    both.take("hand", *_gap(points, paces, "RPalm", "LPalm", "LPalm", "hand"))
    clasped = both.apart < LEAVES
    for near, side, other in ((right, "R", "L"), (left, "L", "R")):
        hangs = _hangs(points, side)
        for name, *ends in _LINES:
            one, two = (it.replace("other ", other) for it in ends)
            if one not in points or two not in points:
                continue
            apart, pace = _gap(points, paces, f"{side}Palm", one, two, name)
            if name == "arm":
                apart[clasped] = _FAR
            elif name in _BESIDE:
                apart[hangs] = _FAR
            near.take(name, apart, pace)
    return dict(zip(_TRACKS, found, strict=True))


def _gap(
    points: Places, paces: Places, palm: str, one: str, two: str, name: str
) -> tuple[Floats, Floats]:
    """Return how far a palm is from a line, as a part of what touches, and how fast it passes."""
    start, line = points[one], points[two] - points[one]
    along = ((points[palm] - start) * line).sum(axis=1)
    along = np.clip(along / np.maximum((line * line).sum(axis=1), 1e-9), 0, 1)[:, None]
    way = points[palm] - start - along * line
    past = paces[palm] - (1 - along) * paces[one] - along * paces[two]
    reach = _REACHES[name] + (0 if f"{palm[0]}Hand" in points else WIDER)
    return np.linalg.norm(way, axis=1) / reach, np.linalg.norm(past, axis=1)


def _hangs(points: Places, side: str) -> Flags:
    """Tell when an arm hangs beside the trunk; one that is not known whole never does."""
    wrist = points[f"{side}Wrist"]
    if f"{side}Shoulder" not in points or "Hip" not in points:
        return np.zeros(len(wrist), bool)
    arm, trunk = wrist - points[f"{side}Shoulder"], points["Hip"] - points["Neck"]
    along = (_unit(arm) * _unit(trunk)).sum(axis=1)
    hangs: Flags = (np.linalg.norm(arm, axis=1) > STRAIGHT) & (
        along > math.cos(math.radians(HANGS))
    )
    return hangs


def _events(near: _Near, rate: float) -> list[Event]:
    """Return the touches of a hand."""
    brief, dwells = round(FLICKER * rate), round(DWELLS * rate)
    meets, stays = near.apart < 1, near.apart < LEAVES
    if not near.together:
        meets, stays = meets & (near.pace < QUIET), stays & (near.pace < RUBS)
    on = held(meets, stays)
    for start, stop in runs(~on):
        if start > 0 and stop < len(on) and stop - start <= brief:
            on[start:stop] = True
    found = []
    for start, stop in runs(on):
        for first, last in pieces(near.what[start:stop], brief + 1):
            some = slice(start + first, start + last)
            slow = near.pace[some]
            calm = max((b - a for a, b in runs(slow < QUIET)), default=0)
            if slow.min() > MEETS if near.together else calm < dwells:
                continue
            clear = 1 - float(near.apart[some].min())
            found.append(
                Event(some.start, some.stop, -1, -1, clear, amount=int(near.what[some.start]))
            )
    return found


def _unit(vectors: Floats) -> Floats:
    found: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9)
    return found


def _pace(points: Floats, rate: float) -> Floats:
    if len(points) < 2:
        return np.zeros_like(points)
    pace: Floats = np.gradient(points, axis=0) * rate
    return pace
