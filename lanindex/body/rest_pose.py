"""Loose joints joined to a skeleton: which joint is whose parent, and the rest pose.

At rest a body stands with its arms to the sides, facing +z, y up. Trunk and hips have their usual
shape, seen from pelvis and chest; a limb's bones have their usual lengths (medians).
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from lanindex.data import shipped

Floats = NDArray[np.float64]

_SKELETON = shipped("body/rest_pose.toml")
_ACROSS = {"Pelvis": "Hip", "Chest": "Shoulder"}
_UPWARDS = ("Chest", "Neck", "Head")


def parents_of(joints: Sequence[str]) -> list[int]:
    """Return for each of some joints of the body its parent among them; -1: it has none."""
    place = {joint: number for number, joint in enumerate(joints)}
    return [
        next((place[up] for up in _SKELETON["parents"].get(joint, ()) if up in place), -1)
        for joint in joints
    ]


def rest_offsets(places: Mapping[str, Floats]) -> Floats:
    """Return the offsets (J, 3) of joints from their parents in the rest pose; 0 for roots."""
    joints = list(places)
    ups = parents_of(joints)
    frames = {above: _frame(places, joints[above]) for above in {*ups} - {-1}}
    offsets = np.zeros((len(joints), 3))
    for number, (joint, above) in enumerate(zip(joints, ups, strict=True)):
        if above < 0:
            continue
        away = places[joint] - places[joints[above]]
        frame = frames[above]
        seen = away if frame is None else np.einsum("tij,tj->ti", frame, away)
        seen = seen[np.isfinite(seen).all(axis=1)]
        if frame is not None and len(seen):
            offsets[number] = np.median(seen, axis=0)
            continue
        sided = joint[0] in "RL" and joint[1:2].isupper()
        way = np.array(_SKELETON["directions"][joint[1:] if sided else joint], np.float64)
        way[0] *= -1 if sided and joint[0] == "R" else 1
        away = away[np.isfinite(away).all(axis=1)]
        length = np.median(np.linalg.norm(away, axis=1)) if len(away) else 0.0
        offsets[number] = length * way / np.linalg.norm(way)
    return offsets


def _frame(places: Mapping[str, Floats], joint: str) -> Floats | None:
    """Return the axes of pelvis or chest, (T, 3, 3): to the left, up, forward; else None."""
    pair = _ACROSS.get(joint, "")
    top = next((up for up in _UPWARDS if up in places and up != joint), None)
    if not pair or top is None or not {f"R{pair}", f"L{pair}"} <= places.keys():
        return None
    left = _unit(places[f"L{pair}"] - places[f"R{pair}"])
    forward = _unit(np.cross(left, places[top] - places[joint]))
    return np.stack((left, np.cross(forward, left), forward), axis=1)


def _unit(vectors: Floats) -> Floats:
    with np.errstate(invalid="ignore", divide="ignore"):
        unit: Floats = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return unit
