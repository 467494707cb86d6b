"""Features of HumanML3D and KIT-ML → where the joints are; and HumanML3D's of where they are.

A frame holds how far the root turns about y until the next (half the angle), how far it moves
along x and z as it faces then, its height, and x, y, z of each other joint from below the root, as
it faces. Turns, speeds and contacts of the feet, which follow, tell nothing more.

Source: Guo et al. (2022), *Generating Diverse and Natural 3D Human Motions from Text*, CVPR, and
the code published with it.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TITLES = {263: "HumanML3D", 251: "KIT-ML"}
"""By how many numbers a frame has, twelve for each joint but one: whose they are."""


def used(width: int) -> int:
    """Return how many of a frame's numbers tell where joints are."""
    return 4 + 3 * ((width + 1) // 12 - 1)


def placed(values: NDArray[Any]) -> NDArray[np.float32]:
    """Return where joints are.

    Returns (T, J, 3).
    """
    values = values.astype(np.float64)
    turned = 2 * np.cumsum(np.append(0, values[:-1, 0]))
    places = np.zeros((len(values), (values.shape[1] - 4) // 3 + 1, 3))
    places[1:, 0, [0, 2]] = values[:-1, 1:3]
    places[:, 1:] = values[:, 4:].reshape(len(values), -1, 3)
    x, z, cos, sin = places[..., 0], places[..., 2], np.cos(turned), np.sin(turned)
    places[..., 0], places[..., 2] = (
        x * cos[:, None] - z * sin[:, None],
        x * sin[:, None] + z * cos[:, None],
    )
    places[:, 0] = np.cumsum(places[:, 0], axis=0)
    places[:, 1:, [0, 2]] += places[:, :1, [0, 2]]
    places[:, 0, 1] = values[:, 3]
    return places.astype(np.float32)


CHAINS = ((0, 2, 5, 8, 11), (0, 1, 4, 7, 10), (0, 3, 6, 9, 12, 15), (9, 14, 17, 19, 21),
          (9, 13, 16, 18, 20))  # fmt: skip
"""Joints of HumanML3D from the root, or the chest, outwards."""

_AHEAD = (10, 11, 15)
_SIDES = {1: 1, 13: 1, 2: -1, 14: -1}
_UP = (3, 6, 9, 12)
_ACROSS = ((2, 1), (17, 16))  # right and left of hips and of shoulders
_FEET = (7, 10, 8, 11)
_STILL = 0.002  # square metres that a foot goes in a frame, at most, while it is on the floor
_SMOOTH = 20  # frames: the deviation by which the heading is smoothed


def grounded(places: NDArray[Any]) -> Floats:
    """Return places whose lowest is on the floor, whose first root is above the origin, facing z.

    Takes `places` (T, 22, 3).
    """
    places = places - [places[0, 0, 0], places[..., 1].min(), places[0, 0, 2]]
    ahead = _ahead(places[:1])
    return _facing(places, np.arctan2(ahead[:, 0], ahead[:, 1]))


def features(places: NDArray[Any]) -> NDArray[np.float32]:
    """Return HumanML3D's features.

    Takes `places` (T, 22, 3); returns (T - 1, 263).
    """
    heading = _heading(places)
    turns = np.angle(np.exp(1j * np.diff(heading))) / -2
    moved = _facing(np.diff(places, axis=0), heading[:-1])
    root = _facing(np.diff(places[:, :1], axis=0), heading[1:])[:, 0]
    own = places.copy()
    own[..., [0, 2]] -= places[:, :1, [0, 2]]
    own = _facing(own, heading)[:-1]
    steps = (np.diff(places[:, list(_FEET)], axis=0) ** 2).sum(axis=2)
    columns = (
        turns[:, None],
        root[:, [0, 2]],
        own[:, 0, 1:2],
        own[:, 1:].reshape(len(own), -1),
        _turned(places[:-1], heading[:-1]),
        moved.reshape(len(moved), -1),
        steps < _STILL,
    )
    return np.concatenate(columns, axis=1).astype(np.float32)


def _ahead(places: Floats) -> Floats:
    """Return where bodies face, (T, 2): x and z, of length 1; z where nothing tells."""
    across = sum(places[:, right] - places[:, left] for right, left in _ACROSS)
    ahead = np.stack((np.asarray(across)[:, 2], -np.asarray(across)[:, 0]), axis=1)
    size = np.hypot(*ahead.T)[:, None]
    return np.where(size > 0, ahead / np.maximum(size, 1e-12), (0.0, 1.0))


def _heading(places: Floats) -> Floats:
    """Return where a body faces, smoothed, (T,) radians from z to x; 0 in the first frame."""
    far = 4 * _SMOOTH
    weights = np.exp(-0.5 * (np.arange(-far, far + 1) / _SMOOTH) ** 2)
    ahead = np.pad(_ahead(places), ((far, far), (0, 0)), mode="edge")
    x, z = (np.convolve(one, weights / weights.sum(), mode="valid") for one in ahead.T)
    heading = np.arctan2(x, z)
    heading[0] = 0
    return heading


def _facing(places: Floats, heading: Floats) -> Floats:
    """Return places (T, J, 3) as those see them who face somewhere, (T,) or (1,)."""
    cos, sin = np.cos(heading)[:, None], np.sin(heading)[:, None]
    x, y, z = np.moveaxis(places, -1, 0)
    return np.stack((x * cos - z * sin, y, x * sin + z * cos), axis=-1)


def _turned(places: Floats, heading: Floats) -> Floats:
    """Return how bones are turned, (T, 126): the first two columns of each one's matrix."""
    cos, sin, none = np.cos(heading), np.sin(heading), np.zeros(len(heading))
    facing = np.stack((cos, none, -sin, none, none + 1, none, sin, none, cos), -1)
    found = np.zeros((len(places), 21, 6))
    for chain in CHAINS:
        before = facing.reshape(-1, 3, 3)
        for parent, child in pairwise(chain):
            turn = _smallest(_rest(child), places[:, child] - places[:, parent])
            local = before.swapaxes(1, 2) @ turn
            found[:, child - 1] = np.concatenate((local[..., 0], local[..., 1]), axis=1)
            before = turn
    return found.reshape(len(places), -1)


def _rest(joint: int) -> Floats:
    """Return where the bone to a joint points in a body at rest."""
    if joint in _SIDES:
        return np.array((_SIDES[joint], 0.0, 0.0))
    up = 1.0 if joint in _UP else -1.0
    return np.array((0.0, 0.0, 1.0) if joint in _AHEAD else (0.0, up, 0.0))


def _smallest(rest: Floats, bones: Floats) -> Floats:
    """Return the smallest turns (T, 3, 3) from one direction to others; half turns about any."""
    ways = bones / np.maximum(np.sqrt((bones * bones).sum(axis=1)), 1e-12)[:, None]
    middle = rest + ways
    size = (middle * middle).sum(axis=1)
    back = size < 1e-12
    middle[back] = np.roll(rest, 1)
    size[back] = 1.0
    # a turn from rest to way is one to the middle between them and as much again: two mirrors
    outer = 2 * middle[:, :, None] * middle[:, None, :] / size[:, None, None] - np.eye(3)
    mirror = 2 * np.outer(rest, rest) - np.eye(3)
    found: Floats = outer @ mirror
    return found
