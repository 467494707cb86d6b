"""How far limbs are bent, and torso and head are turned and lean: angles, and what is told of them.

Source: ``encoding/BODY.md``, "Bends", "Twists" and "Inclines".
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from lanindex.alphabet import BENDS, PARTS
from lanindex.encoding.arithmetic import Floats, bend
from lanindex.encoding.inclines import INCLINED, leaning
from lanindex.encoding.joints import Body
from lanindex.encoding.places import Stretch, together
from lanindex.encoding.swings import Angles
from lanindex.encoding.twists import TRUNK, TWISTED, head, torso, trunk
from lanindex.model import Span

Places = dict[str, Floats]


Told = tuple[str, Span, int, Floats]
"""A track over one stretch: its name, the frames of the source, the first resampled one, and its
events, as from `events.table`."""


class Lean(NamedTuple):
    """How a track is found."""

    needed: tuple[str, ...]  # Joints without which it is not known
    # What makes of their places, and of the heading, how far they are turned, or lean
    angles: Callable[[Places, Floats], Angles]
    away: float  # Degrees: what is turned less is in place
    eighths: bool  # Whether its directions are eight, not right and left alone


HEAD = ("Head up",)
LEANS = {
    "torso_twist": Lean(TRUNK, lambda places, _: torso(places), TWISTED, False),
    "head_turn": Lean((*TRUNK, "Head right"), lambda places, _: head(places), TWISTED, False),
    "torso_incline": Lean(TRUNK, lambda it, front: leaning(trunk(it), front), INCLINED, True),
    "head_incline": Lean(HEAD, lambda it, front: leaning(it[HEAD[0]], front), INCLINED, True),
}
_NEEDED = {part: lean.needed for part, lean in LEANS.items()}
_CHAINS = {part: PARTS[limb].chain for limb, part in BENDS.items()}


def bends(body: Body) -> Iterator[Told]:
    """Yield how each arm and leg bends, stretch by stretch."""
    find = body.stages.bends
    for stretch, parts in together(body, _CHAINS):
        found = find(_angles(stretch, parts), body.profile)
        for part, those in zip(parts, found, strict=True):
            yield part, stretch.known, stretch.frames.start, those


def _angles(stretch: Stretch, parts: Sequence[str]) -> Floats:
    """Return by how many degrees lower bones are turned from upper ones, (P, N)."""
    angles = np.empty((len(parts), len(stretch.frames)))
    chains = list(zip(*(_CHAINS[part] for part in parts), strict=True))
    for block, places in stretch.blocks():
        upper, middle, lower = (
            np.array([places[joint].T for joint in joints]).swapaxes(0, 1) for joints in chains
        )
        angles[:, block.inner] = bend(middle - upper, lower - middle)
    return angles


def leans(body: Body, turn: Floats) -> Iterator[Told]:
    """Yield where torso and head are turned, and lean, stretch by stretch.

    `turn` (N,) radians, as from `lanindex.encoding.heading.heading`.
    """
    for over, parts in together(body, _NEEDED):
        front = turn[over.frames.start : over.frames.stop]
        angles = np.empty((len(parts), len(over.frames)), np.complex128)
        for block, places in over.blocks():
            for part, own in zip(parts, angles, strict=True):
                own[block.inner] = LEANS[part].angles(places, front[block.inner])
        for part, own in zip(parts, angles, strict=True):
            _, _, away, eighths = LEANS[part]
            found = body.stages.arrivals(own, away, body.profile, eighths)
            yield part, over.known, over.frames.start, found
