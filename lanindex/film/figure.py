"""The stick figure of a motion: joints, the bones between them, and of which part each is.

``figure(motion) -> Figure``; ``Figure.shown(parts) -> (B,) bool`` tells the bones of some tracks.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, TRACKS
from lanindex.body.made import MADE
from lanindex.errors import EncodeError, UsageError
from lanindex.model import Motion
from lanindex.model.arrays import frozen

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
"""By joint: where a bone comes from, the first that the capture has; and of which part it is."""

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
"""The bones of a track that has a side, where they are not called like it."""

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
        """Return which bones show what some tracks say.

        returns (B,) bool.
        """
        found: set[str] = set()
        for track in tracks:
            if track not in TRACKS:
                raise UsageError(f'there is no part "{track}"', wanted=f"one of {' '.join(TRACKS)}")
            found.update(_bones_of(track))
        for end, before in _INSTEAD.items():
            for side in ("r_", "l_"):
                if side + end in found and side + end not in self.parts:
                    found.add(side + before)
        return np.array([part in found for part in self.parts], bool)

    def joints(self, tracks: Iterable[str]) -> NDArray[np.int64]:
        """Return the joints of the bones that show some tracks, (K,), in order."""
        return np.unique(self.bones[self.shown(tracks)])


def _bones_of(track: str) -> tuple[str, ...]:
    """Return the parts whose bones show a track."""
    side, group = track[:2], track[2:]
    if track in _WHOLE or side not in ("r_", "l_"):
        return _WHOLE.get(track, (track,))
    return tuple(side + part for part in _GROUPS.get(group, (group,)))


def figure(motion: Motion) -> Figure:
    """Return the stick figure of a motion."""
    path = motion.source.path
    if not len(motion):
        raise EncodeError("no frames", place=path, wanted="one at least")
    body = motion.skeleton.body
    places = motion.positions.take(body, axis=1)
    places[:, body < 0] = np.nan
    for name, shares in MADE.items():
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
