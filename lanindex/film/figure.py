"""The stick figure of a motion: its joints and bones, and the view that shows it best."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, PARTS, TRACKS, kind_of
from lanindex.body.mapping import DERIVED_JOINTS
from lanindex.errors import EncodeError, UsageError
from lanindex.model import Motion
from lanindex.model.symbol import frozen

_LIMBS = (
    ("Shoulder", "Elbow", "upper_arm"),
    ("Elbow", "Wrist", "forearm"),
    ("Wrist", "Hand", "hand"),
    ("Hip", "Knee", "thigh"),
    ("Knee", "Ankle", "shank"),
    ("Ankle", "Toe", "foot"),
)

BONES: tuple[tuple[str, tuple[str, ...], str], ...] = (
    ("Chest", ("Pelvis",), "torso"),
    ("Neck", ("Chest", "Pelvis"), "torso"),
    ("Head", ("Neck", "Chest"), "head"),
    *((side + "Shoulder", ("Neck", "Chest", "Pelvis"), "torso") for side in "RL"),
    *((side + "Hip", ("Pelvis",), "torso") for side in "RL"),
    *(
        (side + outer, (side + inner,), f"{side.lower()}_{part}")
        for inner, outer, part in _LIMBS
        for side in "RL"
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

    def joints(self, tracks: Iterable[str]) -> NDArray[np.int64]:
        """Return the joints of the bones that show tracks, (K,), in order."""
        return np.unique(self.bones[self.shown(tracks)])


def figure(motion: Motion) -> Figure:
    """Return the stick figure of a motion."""
    path = motion.source.path
    if not len(motion):
        raise EncodeError("no frames", place=path, wanted="one at least")
    body = motion.skeleton.body
    places = motion.positions.take(body, axis=1)
    places[:, body < 0] = np.nan
    for name, shares in DERIVED_JOINTS.items():
        if body[JOINT_CODES[name]] < 0:
            parts = (places[:, JOINT_CODES[of]] * np.float32(share) for of, share in shares.items())
            places[:, JOINT_CODES[name]] = sum(parts)
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
    """Return the view in which the moving parts spread widest.

    Of all turns about the vertical it is the one in which the places of the joints spread widest
    on the picture. What limbs do is counted from where they hang; steps, supports and ways, and
    the body as a whole, on the floor. The front is kept where no other view shows a tenth more:
    of what moves up and down, or all round. Of the two sides of a line the one nearer to the
    front is taken; of left and right the right, but the left for parts of the left alone.
    """
    places = _sampled(figure, start, len(figure) if stop is None else stop)
    turn = ahead = _front(places)
    moves = []
    for track in tracks or ("body_travel",):
        joints = figure.joints([track])
        moves.append(places[:, joints])
        if kind_of(track) in _STAYS:  # relative to where a limb hangs
            part = PARTS.get(track.removesuffix("_bend"))
            hangs = JOINT_CODES[part.parent if part else "Pelvis"]
            moves[-1] = moves[-1] - places[:, hangs, None]
    spread = _spread(np.concatenate(moves, axis=1))
    xx, xz, zz = spread[0, 0], spread[0, 2], spread[2, 2]
    if math.hypot(xx - zz, 2 * xz) > 1e-9 * (xx + zz):  # else all turns are equal
        best = -0.5 * math.atan2(2 * xz, xx - zz)
        if _seen(spread, best) > (1 + WORTH) * _seen(spread, ahead):
            side = 1.0 if {track[:2] for track in tracks or ()} == {"l_"} else -1.0
            off = (best - ahead + math.pi) % (2 * math.pi) - math.pi
            ways = (off, off - math.copysign(math.pi, off))  # from this side of it or the other
            turn = ahead + min(ways, key=lambda it: (round(abs(it), 1), -side * it))
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


def _spread(moves: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean products of x, y and z about their means, all joints taken together."""
    joints = moves.reshape(len(moves), -1, 3)
    known = ~np.isnan(joints).any(axis=2, keepdims=True)
    count = np.maximum(known.sum(axis=0), 1)
    held = np.where(known, joints, 0.0)
    away = np.where(known, held - held.sum(axis=0) / count, 0.0).reshape(-1, 3)
    spread: NDArray[np.float64] = away.T @ away / max(int(known.sum()), 1)
    return spread


def _seen(spread: NDArray[np.float64], turn: float) -> float:
    """Return how far a movement spreads on the picture, squared."""
    right = np.array([math.cos(turn), 0.0, -math.sin(turn)])
    return float(right @ spread @ right + spread[1, 1])
