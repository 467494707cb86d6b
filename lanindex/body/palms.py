"""Where palms face: of hands of which a capture knows fingers, or markers.

A palm lies in the plane of its knuckles and its wrist; out of it points what is at right angles to
that plane, on the side that the body's side tells. A skeleton tells it at rest, and how its hand
is turned says where that points in every frame; of points alone it is told frame by frame.

Source: ``encoding/BODY.md``, "Palms".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.body.by_name import candidates
from lanindex.body.facing import about, rest_axes
from lanindex.model import Skeleton

Floats = NDArray[np.float64]
Plane = tuple[int, int, int]
"""Points of a hand: towards the thumb, towards the little finger, and towards the finger tips."""

HANDS = ("RHand", "LHand")
"""The joints of the body of which `Motion.axes` tells where the palm faces, and the fingers."""

TURNED_BY = {"RHand": "RWrist", "LHand": "LWrist"}
"""The joint of the body that a hand turns with: where it begins."""

FINGERS = ("Index", "Middle", "Ring", "Little")

FLAT = 0.2
"""Sine of an angle: lines that lie nearer to each other span no plane."""

ALONG = 0.97
"""Cosine of an angle, 14 degrees: fingers that are drawn along an axis."""

HINGED = 30.0
"""Degrees: an elbow that is bent more, and by so much more and less, tells how a forearm turns."""

RIGID = 1.0
"""Degrees: a palm that turns less about its forearm, while the elbow bends, was not measured."""

_SAMPLED, _BLOCK = 512, 4096


def planes(names: tuple[str, ...]) -> dict[str, Plane]:
    """Return the knuckles that tell the plane of each hand, where two or more are known."""
    found = {}
    named = candidates(names)
    for hand in HANDS:
        known = [those[0] for it in FINGERS if (those := named["fingers", hand[0], it])]
        if len(known) > 1:
            found[hand] = known[0], known[-1], known[0]
    return found


def facing(hand: str, across: Floats, along: Floats) -> Floats:
    """Return where a palm faces, and its fingers point.

    `across, along` (..., 3) from the little finger's side to the thumb's, and from the wrist to the
    fingers; returned (..., 2, 3) unit vectors at right angles; NaN where both ways are nearly one.
    """
    out = np.cross(across, along) * (1 if hand[0] == "R" else -1)
    size, length = (np.linalg.norm(it, axis=-1, keepdims=True) for it in (out, along))
    wide = np.linalg.norm(across, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        found = np.stack((out / size, along / length), axis=-2)
    found[~(size > FLAT * wide * length)[..., 0]] = np.nan
    return found


def rest_palms(
    names: tuple[str, ...],
    parents: Sequence[int],
    offsets: Any,
    body: NDArray[np.int16],
    down: bool = False,
) -> dict[str, tuple[int, Floats]]:
    """Return where palms face at rest, and fingers point.

    `names` (J) as in the file; `parents` (J) parents before children, -1 for a root; `offsets` (J,
    3) from the parent, at rest; `body` (20,) which joints play the body, as in `Skeleton`.
    """
    knuckles, named, found = planes(names), candidates(names), dict[str, tuple[int, Floats]]()
    stands = rest_axes(parents, offsets, body) if down else None
    for hand in HANDS:
        side = hand[0]
        wrist, tip, elbow = (int(body[JOINT_CODES[side + it]]) for it in ("Wrist", "Hand", "Elbow"))
        if wrist < 0:
            continue

        def way(joint: int, start: int = wrist) -> Floats:
            """Return the way from the wrist to a joint."""
            return _place(joint, parents, offsets) - _place(start, parents, offsets)

        thumb = next(iter(named["fingers", side, "Thumb"]), -1)
        fingers = [those[0] for it in FINGERS if (those := named["fingers", side, it])]
        far = tip if tip >= 0 else next(iter(fingers), -1)
        if hand in knuckles:
            first, last, _ = knuckles[hand]
            found[hand] = wrist, facing(hand, way(first) - way(last), way(first))
        elif thumb >= 0 and far >= 0:
            while not np.any(way(thumb)) and thumb in parents:
                thumb = list(parents).index(thumb)
            base = parents[far]  # some skeletons have two joints in the wrist's place
            with_it = base if base >= 0 and not np.any(way(base)) else wrist
            found[hand] = with_it, _drawn(facing(hand, way(thumb), way(far)))
        elif stands is not None:
            along = way(tip) if tip >= 0 else -way(elbow)
            along = along - (along @ stands[1]) * stands[1]
            size = max(float(np.linalg.norm(along)), 1e-9)
            found[hand] = wrist, np.stack((-stands[1], along / size))
    return {hand: it for hand, it in found.items() if np.isfinite(it[1]).all()}


def _place(joint: int, parents: Sequence[int], offsets: Any) -> Floats:
    place = np.zeros(3)
    while joint >= 0:
        place = place + np.asarray(offsets[joint], np.float64)
        joint = parents[joint]
    return place


def _drawn(palm: Floats) -> Floats:
    """Return a palm that a thumb tells, as who drew the skeleton will have meant it.

    A thumb leads from the palm's plane; a hand that is drawn along an axis is drawn flat.
    """
    axis = int(np.argmax(np.abs(palm[0])))
    flat = np.sign(palm[0, axis]) * np.eye(3)[axis]
    if np.abs(palm[1]).max() < ALONG or abs(palm[0, axis]) < 0.5**0.5:
        return palm
    along = palm[1] - (palm[1] @ flat) * flat
    return np.stack((flat, along / np.linalg.norm(along)))


def rest_of(skeleton: Skeleton, down: bool = False) -> dict[str, tuple[int, Floats]]:
    """Return where the palms of a whole skeleton face at rest, as `rest_palms` does."""
    parents = skeleton.parents.tolist()
    return rest_palms(skeleton.names, parents, skeleton.offsets, skeleton.body, down)


def turned(
    rest: Mapping[str, tuple[int, Floats]], turns: Callable[[int], NDArray[np.float32]]
) -> dict[str, NDArray[np.float32]]:
    """Return where palms face, and fingers point, of hands that are turned so."""
    found = {}
    for hand, (joint, palm) in rest.items():
        own = turns(joint)
        found[hand] = np.empty((len(own), 2, 3), np.float32)
        for start in range(0, len(own), _BLOCK):
            part = slice(start, start + _BLOCK)
            for number, axis in enumerate(palm):
                found[hand][part, number] = about(own[part], axis)
    return found


def seen(
    points: NDArray[Any],
    planes_of: Mapping[str, tuple[int, ...]],
    wrists: Mapping[str, NDArray[np.float32]],
    oriented: Callable[[Floats], NDArray[np.float32]],
) -> dict[str, NDArray[np.float32]]:
    """Return where palms face, and fingers point, of hands whose points are seen.

    `points` (T, M, 3) of the file.
    """
    found = {}
    for hand, wrist in wrists.items():
        found[hand] = np.empty((len(wrist), 2, 3), np.float32)
        for start in range(0, len(wrist), _BLOCK):
            part = slice(start, start + _BLOCK)
            own = oriented(points[part][:, planes_of[hand]].astype(np.float64)).astype(np.float64)
            thumb, little, far = own.transpose(1, 0, 2)
            found[hand][part] = facing(hand, thumb - little, far - wrist[part])
    return {hand: axes for hand, axes in found.items() if np.isfinite(axes).any()}


def measured(
    axes: Mapping[str, NDArray[np.float32]],
    positions: NDArray[np.float32],
    body: NDArray[np.int16],
) -> tuple[dict[str, NDArray[np.float32]], tuple[str, ...]]:
    """Leave out palms that nobody measured: they turn as the elbow does, and never by themselves.

    `positions` (T, J, 3) of the joints; `body` (20,) which joints play the body.
    """
    kept, doubts = dict(axes), list[str]()
    for hand in HANDS:
        codes = [int(body[JOINT_CODES[hand[0] + it]]) for it in ("Shoulder", "Elbow", "Wrist")]
        if hand in axes and min(codes) >= 0 and _rigid(axes[hand], positions, codes):
            del kept[hand]
            part = f"{hand[0].lower()}_palm"
            doubts.append(f"{part} is left out: it never turns about the forearm by itself")
    return kept, tuple(doubts)


def _rigid(axes: NDArray[np.float32], positions: NDArray[np.float32], codes: Sequence[int]) -> bool:
    """Return whether a palm turns about its forearm by no more than `RIGID`."""
    some = np.unique(np.linspace(0, len(axes) - 1, min(len(axes), _SAMPLED)).astype(int))
    places, palm = positions[some][:, codes].astype(np.float64), axes[some, 0].astype(np.float64)
    upper, lower = np.diff(places, axis=1).transpose(1, 0, 2)
    hinge, length = np.cross(upper, lower), np.sqrt(_dot(lower, lower))
    bent = np.degrees(np.arctan2(np.sqrt(_dot(hinge, hinge)), _dot(upper, lower)))
    turn = np.arctan2(_dot(np.cross(hinge, palm), lower), length * _dot(hinge, palm))
    tells = (bent > HINGED) & np.isfinite(turn)
    if not tells.any() or np.ptp(bent[tells]) < HINGED:
        return False
    circle = np.exp(1j * turn[tells])
    return bool(np.abs(np.angle(circle / circle.mean())).max() < np.radians(RIGID))


def _dot(one: Floats, other: Floats) -> Floats:
    product: Floats = np.einsum("ti,ti->t", one, other)
    return product
