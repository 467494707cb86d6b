"""Where the head's own right and up point, where palms face, and fingers.

Many skeletons stand upright at rest, arms to the sides or down, and look ahead: what points to the
body's right then is known in every frame from how a joint is turned. Others have every bone along
one axis at rest. Their chest, which shoulders move little against, tells its own axes; and those of
the head are the same, if it seems to be upright as the chest is.

A palm lies in the plane of its knuckles and its wrist; out of it points what is at right angles to
that plane, on the side that the body's side tells. A skeleton tells it at rest, and how its hand
is turned says where that points in every frame; of points alone it is told frame by frame.

Source: ``encoding/BODY.md``, "Palms".
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.body.recognition import above, candidates, meeting
from lanindex.model import Skeleton

Floats = NDArray[np.float64]

_UPRIGHT, _ASKEW = 0.85, 0.26  # cosines: 32 degrees from an axis, 15 from a right angle
_ALONG, _UPSIDE = 0.87, 0.71  # cosines: 30 degrees from an axis, 45
_BLOCK = 4096


def rest_axes(
    parents: Sequence[int], offsets: Any, body: NDArray[np.int16]
) -> NDArray[np.float64] | None:
    """Return the unit vectors right and up at rest, (2, 3), up along an axis; None if none stands.

    `parents` (J) parents before children, -1 for a root; `offsets` (J, 3) from the parent; `body`
    (20,) as in `Skeleton`.
    """
    index = _corners(body)
    if min(index) < 0:
        return None
    places = np.array(offsets, np.float64).reshape(-1, 3).tolist()
    for joint, parent in enumerate(parents):
        (x, y, z), (a, b, c) = places[joint], places[parent]
        places[joint] = [x + a, y + b, z + c] if parent >= 0 else [0.0, 0.0, 0.0]
    right_hip, left_hip, right, left = np.array([places[joint] for joint in index])
    hips, shoulders = _unit(right_hip - left_hip), _unit(right - left)
    trunk = _unit(right + left - right_hip - left_hip)
    axis = int(np.argmax(np.abs(trunk)))
    if abs(trunk[axis]) < _UPRIGHT or abs(hips @ trunk) > _ASKEW or hips @ shoulders < 1 - _ASKEW:
        return None
    up = np.zeros(3)
    up[axis] = np.sign(trunk[axis])
    across = hips - (hips @ up) * up
    return np.stack((_unit(across), up)) + 0.0


def seen_axes(
    parents: Sequence[int], body: NDArray[np.int16], poses: Floats, turned: Callable[[int], Floats]
) -> Floats | None:
    """Return right and up of chest and head, (2, 3), where all bones lie along one axis at rest.

    `parents` and `body` as for `rest_axes`; `poses` (T, J, 3) positions; None where the chest has
    no such axes, or the head has other ones.
    """
    found, index = _corners(body), int(body[JOINT_CODES["Head"]])
    if min(*found, index) < 0 or (chest := meeting(parents, *found[2:])) is None:
        return None
    seen = []
    right_hip, left_hip, right, left = np.moveaxis(poses[:, found], 1, 0)
    turns, head = turned(chest), turned(index)
    for line, most in ((right - left, _ALONG), (right + left - right_hip - left_hip, _UPSIDE)):
        own, heads = _mean(turns, line), _mean(head, line)
        axis = int(np.argmax(np.abs(own)))
        unit = np.sign(own[axis]) * np.eye(3)[axis] + 0.0
        if not (own @ unit >= _ALONG and np.abs(heads * (1 - np.abs(unit))).max() <= most):
            return None  # nor where a place is not known
        seen.append(unit)
    return None if seen[0] @ seen[1] else np.stack(seen)


def _corners(body: NDArray[np.int16]) -> list[int]:
    """Return the joints of right and left hip, right and left shoulder."""
    return [int(body[JOINT_CODES[s + it]]) for it in ("Hip", "Shoulder") for s in "RL"]


def _mean(turns: Floats, vectors: Floats) -> Floats:
    """Return where vectors (T, 3) point in the mean, as what turns (T, 3, 3) sees them."""
    lengths = np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9)
    mean: Floats = np.einsum("tkc,tk->c", turns, vectors / lengths) / len(vectors)
    return mean


def _unit(vector: Floats) -> Floats:
    unit: Floats = vector / max(float(np.linalg.norm(vector)), 1e-9)
    return unit


def axes_of(
    skeleton: Skeleton, rotations: NDArray[np.float32] | None
) -> dict[str, NDArray[np.float32]]:
    """Return right and up of the head, (T, 2, 3), of `rotations` (T, J, 4), where it has axes."""
    rest = rest_axes(skeleton.parents.tolist(), skeleton.offsets, skeleton.body)
    head = int(skeleton.body[JOINT_CODES["Head"]])
    if rotations is None or rest is None or head < 0:
        return {}
    return turned({"Head": (head, rest)}, lambda joint: rotations[:, joint])


def turned(
    rest: Mapping[str, tuple[int, Floats]], turns: Callable[[int], NDArray[np.float32]]
) -> dict[str, NDArray[np.float32]]:
    """Return two axes of some joints in each frame, (T, 2, 3) by joint of the body.

    `rest` the joint of the file and its axes at rest (2, 3), by joint of the body; `turns` gives
    the unit quaternions (T, 4) of a joint of the file.
    """
    found = {}
    for name, (joint, axes) in rest.items():
        quaternions = turns(joint)
        found[name] = np.empty((len(quaternions), 2, 3), np.float32)
        for start in range(0, len(quaternions), _BLOCK):
            part = slice(start, start + _BLOCK)
            for number, axis in enumerate(axes):
                found[name][part, number] = _about(quaternions[part], axis)
    return found


def _about(turns: NDArray[np.float32], vector: Floats) -> Floats:
    """Return a vector as unit quaternions (T, 4) turn it."""
    real, axes = turns[:, :1].astype(np.float64), turns[:, 1:].astype(np.float64)
    twice = 2 * np.cross(axes, vector)
    turned: Floats = vector + real * twice + np.cross(axes, twice)
    return turned


Plane = tuple[int, int, int]
"""Points of a hand: towards the thumb, towards the little finger, and towards the finger tips."""

HANDS = ("RHand", "LHand")
"""The joints of the body of which `Motion.axes` tells where the palm faces, and the fingers."""

FINGERS = ("Index", "Middle", "Ring", "Little")

FLAT = 0.2
"""Sine of an angle: lines that lie nearer to each other span no plane."""

ALONG = 0.97
"""Cosine of an angle, 14 degrees: fingers that are drawn along an axis."""

HINGED = 30.0
"""Degrees: an elbow that is bent more, and by so much more and less, tells how a forearm turns."""

RIGID = 1.0
"""Degrees: a palm that turns less about its forearm, while the elbow bends, was not measured."""

_SAMPLED = 512


def planes(names: tuple[str, ...]) -> dict[str, Plane]:
    """Return the knuckles that tell the plane of each hand, where two or more are known."""
    knuckles = {hand: _knuckles(names, hand) for hand in HANDS}
    return {hand: (known[0], known[-1], known[0]) for hand, known in knuckles.items() if known[1:]}


def _knuckles(names: tuple[str, ...], hand: str) -> list[int]:
    """Return the joints in which the fingers of a hand begin, as far as they are known."""
    named = candidates(names)
    return [those[0] for finger in FINGERS if (those := named["fingers", hand[0], finger])]


def facing(hand: str, across: Floats, along: Floats) -> Floats:
    """Return the directions (..., 2, 3) of a palm and its fingers; NaN where they are unknown.

    `across` (..., 3) from the little finger's side to the thumb's, `along` from wrist to fingers.
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
    """Return by hand its joint, and the directions of palm and fingers at rest, (2, 3).

    `names` (J) as in the file; `parents`, `offsets` and `body` as for `rest_axes`.
    """
    named, found = candidates(names), dict[str, tuple[int, Floats]]()
    stands = rest_axes(parents, offsets, body) if down else None
    for hand in HANDS:
        side = hand[0]
        wrist, tip, elbow = (int(body[JOINT_CODES[side + it]]) for it in ("Wrist", "Hand", "Elbow"))
        if wrist < 0:
            continue

        def from_wrist(joint: int, start: int = wrist) -> Floats:
            """Return the way from the wrist to a joint."""
            return _place(joint, parents, offsets) - _place(start, parents, offsets)

        thumb = next(iter(named["fingers", side, "Thumb"]), -1)
        fingers = _knuckles(names, hand)
        far = tip if tip >= 0 else next(iter(fingers), -1)
        if len(fingers) > 1:
            across = from_wrist(fingers[0]) - from_wrist(fingers[-1])
            found[hand] = wrist, facing(hand, across, from_wrist(fingers[0]))
        elif thumb >= 0 and far >= 0:
            while not np.any(from_wrist(thumb)) and thumb in parents:
                thumb = list(parents).index(thumb)
            base = parents[far]  # some skeletons have two joints in the wrist's place
            with_it = base if base >= 0 and not np.any(from_wrist(base)) else wrist
            found[hand] = with_it, _as_drawn(facing(hand, from_wrist(thumb), from_wrist(far)))
        elif stands is not None:
            along = from_wrist(tip) if tip >= 0 else -from_wrist(elbow)
            along = along - (along @ stands[1]) * stands[1]
            size = max(float(np.linalg.norm(along)), 1e-9)
            found[hand] = wrist, np.stack((-stands[1], along / size))
    return {hand: it for hand, it in found.items() if np.isfinite(it[1]).all()}


def _place(joint: int, parents: Sequence[int], offsets: Any) -> Floats:
    place = np.zeros(3)
    for one in above(parents, joint):
        place = place + np.asarray(offsets[one], np.float64)
    return place


def _as_drawn(palm: Floats) -> Floats:
    """Return a palm found by a thumb, moved to an axis if the hand lies along one."""
    axis = int(np.argmax(np.abs(palm[0])))
    flat = np.sign(palm[0, axis]) * np.eye(3)[axis]
    if np.abs(palm[1]).max() < ALONG or abs(palm[0, axis]) < 0.5**0.5:
        return palm
    along = palm[1] - (palm[1] @ flat) * flat
    return np.stack((flat, along / np.linalg.norm(along)))


def seen_palms(
    points: NDArray[Any],
    planes_of: Mapping[str, tuple[int, ...]],
    wrists: Mapping[str, NDArray[np.float32]],
    oriented: Callable[[Floats], NDArray[np.float32]],
) -> dict[str, NDArray[np.float32]]:
    """Return by hand the directions of palm and fingers, (T, 2, 3), from `points` (T, M, 3)."""
    found = {}
    for hand, wrist in wrists.items():
        found[hand] = np.empty((len(wrist), 2, 3), np.float32)
        for start in range(0, len(wrist), _BLOCK):
            part = slice(start, start + _BLOCK)
            own = oriented(points[part][:, planes_of[hand]].astype(np.float64)).astype(np.float64)
            thumb, little, far = own.transpose(1, 0, 2)
            found[hand][part] = facing(hand, thumb - little, far - wrist[part])
    return {hand: axes for hand, axes in found.items() if np.isfinite(axes).any()}


def measured_palms(
    axes: Mapping[str, NDArray[np.float32]], positions: NDArray[np.float32], body: NDArray[np.int16]
) -> tuple[dict[str, NDArray[np.float32]], tuple[str, ...]]:
    """Leave out palms that were not measured: they turn exactly as the elbow does."""
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
