"""Joints without names: orders of joints, poses of SMPL (AMASS), features of HumanML3D and KIT-ML.

An order is known by the number of its joints, and by their bones.

Poses are turns, and the shape of the body is weights of a model that may not be handed on. Here all
bodies have the mean shape, in millimetres as published with many programs: directions, of which
symbols are made, are exact for the mean body and within a few degrees for others, for the shape
changes how bones lie at rest; lengths may be off by a tenth.

A frame of features holds how far the root turns about y until the next (half the angle), how far it
moves along x and z as it faces then, its height, and x, y, z of each other joint from below the
root, as it faces. Turns, speeds and contacts of the feet, which follow, tell nothing more.

Sources: Loper et al. (2015), *SMPL*, ACM Trans. Graph. 34(6), mean male joints, and its extensions
SMPL-H and SMPL-X, whose first 22 joints HumanML3D takes; Mahmood et al. (2019), *AMASS*, ICCV; Guo
et al. (2022), *Generating Diverse and Natural 3D Human Motions from Text*, CVPR, and the code
published with it; KIT-ML as HumanML3D orders it; Human3.6M as Martinez et al. (2017) reduce it;
COCO's keypoints; OpenPose's BODY_25; Kinect v2's JointType, as NTU RGB+D has it; MediaPipe's pose
landmarks, which FreeMoCap puts before hands and face.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body import sampled
from lanindex.data import shipped
from lanindex.formats.turning import UNSCALED, UNTURNED, of_vectors, place

Floats = NDArray[np.float64]


_BONES = (("shoulder", "elbow"), ("elbow", "wrist"), ("hip", "knee"), ("knee", "ankle"))
_STEADY = 0.2  # of its length: what a bone may change by, middle half of the poses
_EVEN = 1.5  # how many times as long a bone may be on one side as on the other
_NEXT = 2.3  # how many times as long it may be as the one next to it


@dataclass(frozen=True, slots=True)
class Order:
    """One order of joints."""

    title: str  # as people call it
    names: tuple[str, ...]  # (J) the joints
    rate: str = ""  # frames a second that its files have, where none is given; empty: unknown


def _orders() -> tuple[Order, ...]:
    """Return all orders that are known: those of `joint_orders.toml`."""
    found = []
    for told in shipped("formats/joint_orders.toml")["order"]:
        names = told["names"].split()
        if "face" in told:
            names += [f"{side}_hand_{point}" for side in ("right", "left") for point in range(21)]
            names += [f"face_{point}" for point in range(told["face"])]
        found.append(Order(told["title"], tuple(names), told.get("rate", "")))
    return tuple(found)


ORDERS = _orders()
SMPL = next(order.names for order in ORDERS if order.title == "SMPL")
"""The joints of SMPL; the first 22 are those of SMPL-H, SMPL-X and HumanML3D too."""


def order_of(places: NDArray[Any]) -> Order | None:
    """Return the one order in which places (T, J, 3) make a body."""
    poses = places[sampled(len(places))].astype(np.float64)
    fitting = [one for one in ORDERS if len(one.names) == places.shape[1] and _fits(one, poses)]
    return fitting[0] if len(fitting) == 1 else None


def _fits(order: Order, poses: NDArray[np.float64]) -> bool:
    """Return whether the bones of an order are bones."""
    ends = [[order.names.index(f"{side}_{end}") for end in bone]
            for bone in _BONES for side in ("left", "right")]  # fmt: skip
    bones = poses[:, [first for first, _ in ends]] - poses[:, [last for _, last in ends]]
    lengths = np.sqrt((bones * bones).sum(axis=2))
    lengths = lengths[np.isfinite(lengths).all(axis=1)]
    if not len(lengths):
        return False
    low, usual, high = np.percentile(lengths, (25, 50, 75), axis=0)
    steady = (high - low <= _STEADY * usual).all() and (usual > 0).all()
    return bool(
        steady
        and _similar_lengths(usual[0::2], usual[1::2], _EVEN)
        and _similar_lengths(usual[0::4], usual[2::4], _NEXT)
    )


def _similar_lengths(one: NDArray[np.float64], other: NDArray[np.float64], most: float) -> bool:
    return bool((np.maximum(one, other) <= most * np.minimum(one, other)).all())


# numbers of a pose: three for each joint; the first 66 are those of the body in all
WIDTHS = {66: "SMPL", 72: "SMPL", 156: "SMPL-H", 165: "SMPL-X"}
TURNED = 22  # joints that turn; the hands of `SMPL` follow their wrists
PARENTS = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21)
REST = (-0.002, -0.241, 0.029)  # of the pelvis, metres: where it is when nothing is moved
OFFSETS = np.array(shipped("formats/skeletons.toml")["smpl"]["offsets"]) / 1000.0
"""(24, 3) metres, y up, facing z: of each joint from its parent, arms stretched sideways."""

BLOCK = 4096  # frames that are turned at a time


def posed(poses: NDArray[Any], shift: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return positions (T, 24, 3) and rotations (T, 24, 4) of poses (T, 66) and shifts (T, 3)."""
    places = np.empty((len(poses), len(SMPL), 3), np.float32)
    turns = np.empty((len(poses), len(SMPL), 4), np.float32)
    joints = range(len(SMPL))
    for start in range(0, len(poses), BLOCK):
        block = slice(start, start + BLOCK)
        vectors = poses[block, : 3 * TURNED].astype(np.float64).reshape(-1, TURNED, 3)
        local, root = of_vectors(vectors), shift[block].astype(np.float64) + REST

        def standing(
            joint: int, local: Floats = local, root: Floats = root
        ) -> tuple[Floats, Floats, Floats]:
            own = local[:, joint] if joint < TURNED else UNTURNED
            return OFFSETS[[joint]] if joint else root, own, UNSCALED

        place(joints, joints, PARENTS, standing, places[block], turns[block])
    return places, turns


# by how many numbers a frame of features has, twelve for each joint but one: whose they are
TITLES = {263: "HumanML3D", 251: "KIT-ML"}


def used(width: int) -> int:
    """Return how many of a frame's numbers tell where joints are."""
    return 4 + 3 * ((width + 1) // 12 - 1)


def placed(values: NDArray[Any]) -> NDArray[np.float32]:
    """Return where the joints of features (T, W) are, (T, J, 3)."""
    values = values.astype(np.float64)
    turned = 2 * np.cumsum(np.append(0, values[:-1, 0]))
    places = np.zeros((len(values), (values.shape[1] - 4) // 3 + 1, 3))
    places[1:, 0, [0, 2]] = values[:-1, 1:3]
    places[:, 1:] = values[:, 4:].reshape(len(values), -1, 3)
    places = _in_facing_frame(places, turned)
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
    """Return places (T, 22, 3) on the floor, the first root above the origin and facing z."""
    places = places - [places[0, 0, 0], places[..., 1].min(), places[0, 0, 2]]
    ahead = _facing_directions(places[:1])
    return _in_facing_frame(places, np.arctan2(ahead[:, 0], ahead[:, 1]))


def features(places: NDArray[Any]) -> NDArray[np.float32]:
    """Return HumanML3D's features (T - 1, 263) of places (T, 22, 3)."""
    heading = _heading(places)
    turns = np.angle(np.exp(1j * np.diff(heading))) / -2
    moved = _in_facing_frame(np.diff(places, axis=0), heading[:-1])
    root = _in_facing_frame(np.diff(places[:, :1], axis=0), heading[1:])[:, 0]
    own = places.copy()
    own[..., [0, 2]] -= places[:, :1, [0, 2]]
    own = _in_facing_frame(own, heading)[:-1]
    steps = (np.diff(places[:, list(_FEET)], axis=0) ** 2).sum(axis=2)
    columns = (
        turns[:, None],
        root[:, [0, 2]],
        own[:, 0, 1:2],
        own[:, 1:].reshape(len(own), -1),
        _bone_rotations(places[:-1], heading[:-1]),
        moved.reshape(len(moved), -1),
        steps < _STILL,
    )
    return np.concatenate(columns, axis=1).astype(np.float32)


def _facing_directions(places: Floats) -> Floats:
    """Return where bodies face, (T, 2): x and z, of length 1; z where nothing tells."""
    across = sum(places[:, right] - places[:, left] for right, left in _ACROSS)
    ahead = np.stack((np.asarray(across)[:, 2], -np.asarray(across)[:, 0]), axis=1)
    size = np.hypot(*ahead.T)[:, None]
    return np.where(size > 0, ahead / np.maximum(size, 1e-12), (0.0, 1.0))


def _heading(places: Floats) -> Floats:
    """Return where a body faces, smoothed, (T,) radians from z to x; 0 in the first frame."""
    far = 4 * _SMOOTH
    weights = np.exp(-0.5 * (np.arange(-far, far + 1) / _SMOOTH) ** 2)
    ahead = np.pad(_facing_directions(places), ((far, far), (0, 0)), mode="edge")
    x, z = (np.convolve(one, weights / weights.sum(), mode="valid") for one in ahead.T)
    heading = np.arctan2(x, z)
    heading[0] = 0
    return heading


def _in_facing_frame(places: Floats, heading: Floats) -> Floats:
    """Return places (T, J, 3) turned into the frame of a body with a heading, (T,) or (1,)."""
    cos, sin = np.cos(heading)[:, None], np.sin(heading)[:, None]
    x, y, z = np.moveaxis(places, -1, 0)
    return np.stack((x * cos - z * sin, y, x * sin + z * cos), axis=-1)


def _bone_rotations(places: Floats, heading: Floats) -> Floats:
    """Return how bones are turned, (T, 126): the first two columns of each one's matrix."""
    cos, sin, none = np.cos(heading), np.sin(heading), np.zeros(len(heading))
    facing = np.stack((cos, none, -sin, none, none + 1, none, sin, none, cos), -1)
    found = np.zeros((len(places), 21, 6))
    for chain in CHAINS:
        before = facing.reshape(-1, 3, 3)
        for parent, child in pairwise(chain):
            turn = _smallest_turns(_rest_direction(child), places[:, child] - places[:, parent])
            local = before.swapaxes(1, 2) @ turn
            found[:, child - 1] = np.concatenate((local[..., 0], local[..., 1]), axis=1)
            before = turn
    return found.reshape(len(places), -1)


def _rest_direction(joint: int) -> Floats:
    """Return where the bone to a joint points in a body at rest."""
    if joint in _SIDES:
        return np.array((_SIDES[joint], 0.0, 0.0))
    up = 1.0 if joint in _UP else -1.0
    return np.array((0.0, 0.0, 1.0) if joint in _AHEAD else (0.0, up, 0.0))


def _smallest_turns(rest: Floats, bones: Floats) -> Floats:
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
