"""How torso and head turn and lean, stretch by stretch.

Source: ``encoding/BODY.md``, "Twists" and "Inclines".
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding import curves
from lanindex.encoding.arithmetic import cross, dot
from lanindex.encoding.curves import Angles
from lanindex.encoding.joints import Body
from lanindex.encoding.places import together
from lanindex.model import Span

Floats = NDArray[np.float64]

INCLINED = 15.0
"""Degrees: what leans less is in place."""


def leaning(upward: Floats, turn: Floats) -> Angles:
    """Return the lean to the right, and forward as the imaginary part, (N,) complex128, degrees.

    `upward` (N, 3) in the axes of the capture; `turn` (N,) radians, the heading.
    """
    east, up, south = upward.T
    flat = np.hypot(east, south)
    size = np.degrees(np.arctan2(flat, up)) / np.maximum(flat, 1e-9)
    lean: Angles = size * (south + 1j * east) * np.exp(-1j * turn)
    return lean


TWISTED = 30.0
"""Degrees: what is turned less is in place."""

TRUNK = ("RHip", "LHip", "RShoulder", "LShoulder")


def torso_twist(places: dict[str, Floats]) -> Angles:
    """Return how far the shoulders are turned to the right of the hips, (N,) degrees."""
    hips, shoulders = (places["R" + it] - places["L" + it] for it in ("Hip", "Shoulder"))
    return between(hips, shoulders, trunk_line(places))


def head_turn(places: dict[str, Floats]) -> Angles:
    """Return how far the head is turned to the right of the shoulders, (N,) degrees."""
    shoulders = places["RShoulder"] - places["LShoulder"]
    return between(shoulders, places["Head right"], trunk_line(places))


def trunk_line(places: dict[str, Floats]) -> Floats:
    """Return the way from the middle of the hips to that of the shoulders, (N, 3)."""
    hips, shoulders = (places["R" + it] + places["L" + it] for it in ("Hip", "Shoulder"))
    way: Floats = (shoulders - hips) / 2
    return way


def between(first: Floats, second: Floats, about: Floats) -> Angles:
    """Return the angles (N,) from lines to others about axes, (N, 3) each; degrees to the right."""
    axis = about.T / np.maximum(np.sqrt(dot(about.T, about.T)), 1e-9)
    one, other = (some.T - dot(some.T, axis) * axis for some in (first, second))
    left = dot(cross(one, other), axis)
    angles: Angles = np.degrees(np.arctan2(-left, dot(one, other))) + 0j
    return angles


Places = dict[str, Floats]


Told = tuple[str, Span, int, Floats]
"""A track over one stretch: its name, the frames of the source, the first resampled one, and its
events, as from `table`."""


class Lean(NamedTuple):
    """How a track is found."""

    needed: tuple[str, ...]  # Joints without which it is not known
    # What makes of their places, and of the heading, how far they are turned, or lean
    angles: Callable[[Places, Floats], Angles]
    away: float  # Degrees: what is turned less is in place
    eighths: bool  # Whether its directions are eight, not right and left alone


HEAD = ("Head up",)
LEANS = {
    "torso_twist": Lean(TRUNK, lambda places, _: torso_twist(places), TWISTED, False),
    "head_turn": Lean((*TRUNK, "Head right"), lambda places, _: head_turn(places), TWISTED, False),
    "torso_incline": Lean(TRUNK, lambda it, front: leaning(trunk_line(it), front), INCLINED, True),
    "head_incline": Lean(HEAD, lambda it, front: leaning(it[HEAD[0]], front), INCLINED, True),
}
_NEEDED = {part: lean.needed for part, lean in LEANS.items()}


def leans(body: Body, turn: Floats) -> Iterator[Told]:
    """Yield the events of twists and inclines, by stretch; `turn` (N,) the heading, radians."""
    for over, parts in together(body, _NEEDED):
        front = turn[over.frames.start : over.frames.stop]
        angles = [np.empty(len(over.frames), np.complex128) for _ in parts]
        for block, places in over.blocks():
            for part, own in zip(parts, angles, strict=True):
                own[block.inner] = LEANS[part].angles(places, front[block.inner])
        for part in parts:
            _, _, away, eighths = LEANS[part]
            found = curves.arrivals(angles.pop(0), away, body.profile, eighths, body.fast)
            yield part, over.known, over.frames.start, found
