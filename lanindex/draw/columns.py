"""In which column of a staff each track stands."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

from lanindex.alphabet import kind_of
from lanindex.draw.picture import C
from lanindex.model.steps import STEP

PITCH = round(1.2 * C)
"""From one column to the next."""

NARROW = round(0.8 * C)
"""The same, where signs are narrow."""

_INSIDE = (
    ("r_support", "l_support"),
    ("r_leg", "l_leg"),
    ("r_thigh", "l_thigh"),
    ("r_shank", "l_shank"),
    ("r_foot", "l_foot"),
    ("r_leg_bend", "l_leg_bend"),
)
_OUTSIDE = (
    ("torso", "torso_twist"),
    ("r_arm", "l_arm"),
    ("r_upper_arm", "l_upper_arm"),
    ("r_forearm", "l_forearm"),
    ("r_arm_bend", "l_arm_bend"),
    ("r_hand", "l_hand"),
    ("r_palm", "l_palm"),
    ("head", "torso_incline"),
    ("head_turn", "other_support"),
    ("head_incline", ""),
    ("body_turn", ""),
    ("body_travel", ""),
)
"""Tracks to the right and to the left of the centre, from it outwards."""

_ALWAYS = 2
"""Columns inside the staff's lines, each side, whatever the score has."""

BESIDE = ("jump", "hands_touch", "r_hand_touch", "l_hand_touch")
"""Tracks that have no column: they are drawn across those of others."""

STANCES = frozenset({"r_stance", "l_stance"})
"""Tracks that are drawn as holds."""

_FINER = {"leg": ("thigh", "shank", "foot"), "arm": ("upper_arm", "forearm")}
"""Limbs in one, and what is drawn instead where a score has no such track."""

_TOUCHED = {
    "hand": ("hand", "palm", "forearm", "arm", "upper_arm"),
    "head": ("head",),
    "trunk": ("torso",),
    "arm": ("arm", "upper_arm", "forearm"),
    "thigh": ("thigh", "leg", "support"),
    "knee": ("leg", "shank", "support"),
    "shank": ("shank", "leg", "support"),
    "foot": ("foot", "support", "leg"),
}
"""What can be touched, and the columns that stand for it, the best first."""


@dataclass(frozen=True, slots=True)
class Columns:
    """The columns of a staff."""

    # By track, the middle of its column, counted from the centre line, units
    places: dict[str, int]
    inner: int  # From the centre to the staff's outer lines
    left: int  # From the centre to the end of the columns on either side
    right: int

    def touched(self, part: str, thing: str) -> tuple[int, int]:
        """Return from where to where a bow goes: from a hand to what it touches."""
        sides = ("l_", "r_") if part == "hands_touch" else (part[:2],)
        own = [self._place(side, "hand") for side in sides]
        other = own[-1] if part == "hands_touch" else self._other(part[:2], thing)
        start, stop = sorted((own[0], other))
        return (start, stop) if stop - start >= PITCH else (start - PITCH // 2, stop + PITCH // 2)

    def _other(self, side: str, thing: str) -> int:
        across = {"r_": "l_", "l_": "r_"}[side] if thing == "arm" else side
        return self._place(across, thing)

    def _place(self, side: str, thing: str) -> int:
        for group in _TOUCHED[thing]:
            for part in (side + group, group):
                if part in self.places:
                    return self.places[part]
        return self.right if side == "r_" else -self.left


def usual(tracks: Collection[str]) -> list[str]:
    """Return which tracks are drawn where nobody asks for some: the finer ones are not."""
    hidden = {
        side + bone
        for limb, bones in _FINER.items()
        for side in ("r_", "l_")
        for bone in bones
        if side + limb in tracks
    }
    return [part for part in tracks if part != STEP and part not in hidden]


def known(part: str) -> bool:
    """Return whether there is a place for a track on a staff."""
    return part in BESIDE or part in STANCES or any(part in pair for pair in (*_INSIDE, *_OUTSIDE))


def columns(parts: Iterable[str]) -> Columns:
    """Return where the columns of some tracks stand."""
    wanted, places = set(parts), dict[str, int]()
    at = inner = ends_left = ends_right = 0
    inside = [pair for rank, pair in enumerate(_INSIDE) if rank < _ALWAYS or wanted & {*pair}]
    outside = [pair for pair in _OUTSIDE if wanted & {*pair}]
    for number, (right, left) in enumerate([*inside, *outside]):
        wide = NARROW if kind_of(right) == "bend" else PITCH
        places |= {right: at + wide // 2, left: -at - wide // 2}
        at += wide
        inner = at if number + 1 == len(inside) else inner
        ends_left = at if left in wanted else ends_left
        ends_right = at if right in wanted else ends_right
    own = {part: x for part, x in places.items() if part in wanted}
    return Columns(own, inner, max(inner, ends_left), max(inner, ends_right))
