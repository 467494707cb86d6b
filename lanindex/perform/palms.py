"""How the standard body holds its palms: knuckles beside the hand's joint.

Source: ``encode/BODY.md``, "Palms", read backwards.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.body.palms import facing, planes
from lanindex.perform.figure import Body

Floats = NDArray[np.float64]

NEARLY = 0.92
"""Cosine of an angle, 23 degrees: a palm that comes no nearer does not face as it is told."""

_SLIGHT = 1e-6


def hold(
    joints: Floats,
    wanted: Mapping[str, tuple[Floats, NDArray[np.int64]]],
    body: Body,
) -> tuple[str, ...]:
    """Put knuckles where palms face as is wanted, in place.

    `joints`: (T, J, 3) mm, of a standard body with knuckles; `wanted`: By part (``r_palm``), (T, 3)
    unit vectors, and the frames in which it has arrived.
    """
    said = []
    for part, (out, arrived) in wanted.items():
        names = part[0].upper() + "Wrist", part[0].upper() + "Hand"
        wrist, tip = (int(body.skeleton.body[JOINT_CODES[name]]) for name in names)
        along = _unit(joints[:, tip] - joints[:, wrist])
        palm = out - _dot(out, along) * along
        size = np.linalg.norm(palm, axis=1)
        if (size[arrived] < NEARLY).any():
            said.append(f"{part} cannot face along the hand: it comes as near as it can")
        none = size < _SLIGHT
        palm[none] = np.cross(along[none], np.eye(3)[np.abs(along[none]).argmin(axis=1)])
        thumb = np.cross(along, _unit(palm)) * (1 if part[0] == "r" else -1)
        for joint in (number for number, bone in enumerate(body.bones) if bone == part):
            far, _, aside = body.skeleton.offsets[joint].tolist()
            above = joints[:, body.skeleton.parents[joint]]
            joints[:, joint] = above + abs(far) * along + aside * thumb
    return tuple(said)


def shown(joints: Floats, body: Body) -> dict[str, NDArray[np.float32]]:
    """Return where palms face, as `Motion.axes`, of a body with knuckles."""
    found = {}
    for hand, (first, last, _) in planes(body.skeleton.names).items():
        wrist = joints[:, body.skeleton.body[JOINT_CODES[hand[0] + "Wrist"]]]
        across, along = joints[:, first] - joints[:, last], joints[:, first] - wrist
        found[hand] = facing(hand, across, along).astype(np.float32)
    return found


def _dot(one: Floats, other: Floats) -> Floats:
    product: Floats = np.sum(one * other, axis=-1, keepdims=True)
    return product


def _unit(vectors: Floats) -> Floats:
    found: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
    return found
