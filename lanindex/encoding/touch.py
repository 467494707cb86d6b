"""What the hands touch: each other, the head, the trunk, the other arm, the legs.

Source: ``encoding/BODY.md``, "Touch".
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import held, runs
from lanindex.encoding.curves import Event, pieces
from lanindex.encoding.ground import FLICKER
from lanindex.encoding.joints import Body
from lanindex.encoding.near import CORE, LEAVES, empty, plan, points
from lanindex.encoding.places import Stretch, stretches

Flags = NDArray[np.bool_]

QUIET, DWELLS = 0.5, 0.25
"""Lengths of an arm a second, and seconds: a hand does not touch what it passes faster, or slowly
for less time."""

RUBS = 1.5
"""Lengths of an arm a second: a hand that comes to pass faster has left."""

MEETS = 1.0
"""Lengths of an arm a second: hands that never pass each other slower do not touch."""

ARMS = ("r_arm", "l_arm")
HANDS = ("RWrist", "LWrist")
_OTHERS = (
    *("Chest", "Head"),
    *(side + it for side in "RL" for it in ("Hand", "Shoulder", "Elbow", "Knee", "Ankle", "Toe")),
)
_TRACKS = ("hands_touch", "r_hand_touch", "l_hand_touch")


def touches(body: Body, arm: float) -> Iterator[tuple[str, Stretch, list[Event]]]:
    """Yield what the hands touch: track, stretch, symbols."""
    rate = float(body.profile.rate)
    core = [name for name in CORE if len(body.known[name])]
    for one in stretches(body, (*HANDS, *core), _OTHERS):
        found, lines = empty(len(one.frames)), plan(one.names)
        for block, places in one.blocks(1):
            near = body.loops.nearest(points(places, arm, lines), lines, rate)
            found.take(near, block)
        for part, what, apart, pace in zip(_TRACKS, *found, strict=True):
            yield part, one, _events(what, apart, pace, rate, part == _TRACKS[0])


def _events(
    what: NDArray[np.int8],
    apart: NDArray[np.float32],
    pace: NDArray[np.float32],
    rate: float,
    together: bool,
) -> list[Event]:
    """Return the touches of a hand, or of both together."""
    meets = apart < 1
    if not meets.any():
        return []
    brief, dwells = round(FLICKER * rate), round(DWELLS * rate)
    stays = apart < LEAVES
    if not together:
        meets, stays = meets & (pace < QUIET), stays & (pace < RUBS)
    found = []
    for start, stop in _joined(runs(held(meets, stays)), brief):
        for first, last in pieces(what[start:stop], brief + 1):
            some = slice(start + first, start + last)
            slow = pace[some]
            calm = max((b - a for a, b in runs(slow < QUIET)), default=0)
            if slow.min() > MEETS if together else calm < dwells:
                continue
            clear = 1 - float(apart[some].min())
            found.append(Event(some.start, some.stop, -1, -1, clear, amount=int(what[some.start])))
    return found


def _joined(parts: list[tuple[int, int]], brief: int) -> list[tuple[int, int]]:
    """Return runs of frames, those as one between which no more frames lie."""
    found = parts[:1]
    for start, stop in parts[1:]:
        if start - found[-1][1] <= brief:
            found[-1] = (found[-1][0], stop)
        else:
            found.append((start, stop))
    return found
