"""How the standard body touches: hands brought to each other, to the head, the trunk, the legs.

Source: ``encode/BODY.md``, "Touch", read backwards.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, TOUCHED, amounts_of
from lanindex.model import Score
from lanindex.perform.figure import Body
from lanindex.perform.reach import minimum_jerk

Floats = NDArray[np.float64]

TOUCHES = {"hands_touch": "RL", "r_hand_touch": "R", "l_hand_touch": "L"}
"""The tracks that are carried out here, and whose hands they are of."""

COMES, SETTLES, LEAVES = 0.5, 0.06, 0.12
"""Seconds that a hand is on its way, that it still comes nearer when touch begins, and that it has
been on its way back when touch ends."""

PALM = 0.15
"""Lengths of an arm from the wrist to the middle of the palm."""

FARTHEST = 0.97
"""Part of its length, to the palm, that an arm reaches."""

_BEND = np.array([-0.3, -0.8, 0.6])  # forward, up, out: where an elbow goes
_PLACES: dict[str, tuple[tuple[str, str], float, tuple[float, float, float]]] = {
    "hand": (("Neck", "Pelvis"), 0.35, (0.45, 0.0, 0.06)),
    "head": (("Neck", "Head"), 0.0, (0.12, 0.33, 0.14)),
    "trunk": (("Neck", "Pelvis"), 0.55, (0.18, 0.0, 0.06)),
    "arm": (("other Shoulder", "other Elbow"), 0.75, (0.06, 0.0, -0.07)),
    "thigh": (("own Hip", "own Knee"), 0.6, (0.15, 0.0, 0.0)),
    "knee": (("own Knee", "own Knee"), 0.0, (0.12, 0.0, 0.0)),
    "shank": (("own Knee", "own Ankle"), 0.5, (0.11, 0.0, 0.0)),
    "foot": (("own Ankle", "own Toe"), 0.5, (0.0, 0.1, 0.0)),
}
"""By what is touched: two joints, how far from the first to the second, and from there forward, up
and out to the hand's side in lengths of an arm, where the palm comes to."""


@dataclass(frozen=True, slots=True)
class _Touch:
    """A symbol: its times in seconds, and whose palm comes where."""

    start: float
    stop: float
    before: float
    after: float
    side: str
    thing: str

    def share(self, times: Floats) -> Floats:
        """Return how much the palm is there."""
        begin, end = self.start + SETTLES - self.before, self.stop - LEAVES + self.after
        comes = np.clip((times - begin) / self.before, 0, 1)
        goes = np.clip((end - times) / self.after, 0, 1)
        share: Floats = minimum_jerk(np.minimum(comes, goes))
        return share


def touch(joints: Floats, score: Score, times: Floats, body: Body) -> tuple[str, ...]:
    """Bring hands to what they touch, in place; where they cannot come they stay.

    `joints`: (T, J, 3) mm, of the standard body; `times`: (T,) seconds.
    """
    places = {
        name: joints[:, body.skeleton.body[code]].copy() for name, code in JOINT_CODES.items()
    }
    upper, lower = (
        float(np.linalg.norm(body.skeleton.offsets[body.skeleton.body[JOINT_CODES[it]]]))
        for it in ("RElbow", "RWrist")
    )
    arm, left_out = upper + lower, dict[str, None]()
    for one in _touches(score):
        share = one.share(times)
        some = np.flatnonzero(share > 0)
        if not len(some):
            continue
        seen = {name: it[some] for name, it in places.items()}
        shoulder, axes = seen[one.side + "Shoulder"], _axes(seen, one.side)
        target = _target(seen, axes, one, arm)
        there = np.linalg.norm(target - shoulder, axis=1) <= FARTHEST * (arm + PALM * arm)
        if not there[share[some] > 0.99].all():
            who = f"{one.side.lower()}_hand"
            left_out[f"{who} does not reach the {one.thing}: it stays where its arm points"] = None
            continue
        own = [seen[one.side + it] for it in ("Elbow", "Wrist", "Hand")]
        palm = own[1] + PALM * arm * _unit(own[2] - own[1])
        palm += (target - palm) * share[some, None]
        elbow, wrist = _bent(shoulder, palm, axes, own[0], share[some], (upper, lower), arm)
        _put(joints, body, one.side, some, elbow, wrist, _unit(palm - wrist))
        for name, code in JOINT_CODES.items():
            if name[0] == one.side and name[1:] in ("Elbow", "Wrist", "Hand"):
                places[name][some] = joints[some, body.skeleton.body[code]]
    return tuple(left_out)


def _touches(score: Score) -> Iterator[_Touch]:
    """Yield what hands touch, those that touch each other last, so that they do."""
    for part, sides in reversed(TOUCHES.items()):
        if part not in score.tracks:
            continue
        rows = score.tracks[part].symbols
        rate: Fraction = score.rate
        starts, stops = (rows[it].astype(float) / float(rate) for it in ("start", "stop"))
        rests = np.maximum(starts[1:] - stops[:-1], 0.2) / 2
        before = np.minimum(np.concatenate([[COMES], rests]), COMES)
        after = np.minimum(np.concatenate([rests, [COMES]]), COMES)
        when = np.stack([starts, stops, before[: len(rows)], after[len(after) - len(rows) :]], 1)
        for row, (start, stop, comes, goes) in zip(rows, when.tolist(), strict=True):
            thing = TOUCHED[row["amount"]] if 0 <= row["amount"] < len(TOUCHED) else ""
            if row["passing"] or thing not in amounts_of(part):
                continue
            for side in sides:
                yield _Touch(start, stop, comes, goes, side, thing)


def _axes(places: dict[str, Floats], side: str) -> Floats:
    """Return the ways forward, up and out to a side, of the trunk: (T, 3, 3)."""
    up = _unit(places["Neck"] - places["Pelvis"])
    right = places["RHip"] - places["LHip"]
    right = _unit(right - (right * up).sum(axis=1, keepdims=True) * up)
    found: Floats = np.stack([np.cross(up, right), up, right * (1 if side == "R" else -1)], axis=1)
    return found


def _target(places: dict[str, Floats], axes: Floats, one: _Touch, arm: float) -> Floats:
    """Return where the palm comes to."""
    ends, along, way = _PLACES[one.thing]
    other = {"R": "L", "L": "R"}[one.side]
    first, last = (it.replace("other ", other).replace("own ", one.side) for it in ends)
    there = places[first] + along * (places[last] - places[first])
    found: Floats = there + arm * np.einsum("i,tij->tj", np.array(way), axes)
    return found


def _bent(
    shoulder: Floats,
    palm: Floats,
    axes: Floats,
    elbow: Floats,
    share: Floats,
    bones: tuple[float, float],
    arm: float,
) -> tuple[Floats, Floats]:
    """Return elbow and wrist of an arm whose palm lies there, the hand in line with the forearm."""
    upper, lower = bones[0], bones[1] + PALM * arm
    way = palm - shoulder
    far = np.clip(np.linalg.norm(way, axis=1, keepdims=True), 1e-9, upper + lower)
    way = _unit(way)
    bend = np.einsum("i,tij->tj", _BEND, axes) * share[:, None]
    bend += (elbow - shoulder) / upper * (1 - share[:, None])
    bend = _unit(bend - (bend * way).sum(axis=1, keepdims=True) * way)
    along = (upper**2 - lower**2 + far**2) / (2 * far)
    out = np.sqrt(np.maximum(upper**2 - along**2, 0))
    found = shoulder + along * way + out * bend
    return found, found + bones[1] * _unit(palm - found)


def _put(
    joints: Floats,
    body: Body,
    side: str,
    some: NDArray[np.int64],
    elbow: Floats,
    wrist: Floats,
    hand: Floats,
) -> None:
    """Put the joints of an arm in their places, those beyond the wrist in line."""
    code = body.skeleton.body
    joints[some, code[JOINT_CODES[side + "Elbow"]]] = elbow
    joints[some, code[JOINT_CODES[side + "Wrist"]]] = wrist
    last, far = int(code[JOINT_CODES[side + "Wrist"]]), 0.0
    for number, parent in enumerate(body.skeleton.parents):
        if parent == last:
            far += float(np.linalg.norm(body.skeleton.offsets[number]))
            joints[some, number] = wrist + far * hand
            last = number


def _unit(vectors: Floats) -> Floats:
    found: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
    return found
