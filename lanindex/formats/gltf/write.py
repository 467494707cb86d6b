"""Motion → GLB: a skeleton with an octahedron for each bone, and how its joints turn."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body import sampled
from lanindex.formats.animation import rest_of_axes, turn_to_axes
from lanindex.formats.gltf.document import BINARY_CHUNK, JSON_CHUNK, MAGIC
from lanindex.formats.turning import inverse, matrices, product, quaternions, unit, without_flips
from lanindex.model import Motion
from lanindex.rotation import rotations

Floats = NDArray[np.float64]

METRE = 1000.0
"""Millimetres."""

RIGID = 0.005
"""Millimetres: what a bone may change its length by and still not move within its parent."""

WRONG = 0.2
"""Of a bone's length: what the skeleton's own may be off by and still tell how it is at rest."""

STILL = 1e-7
"""What a quaternion's numbers may change by where a joint does not turn."""

BLOCK = 2048
"""Frames at a time."""


def write(motion: Motion) -> bytes:
    """Write a motion as GLB: one skeleton, m, y up, its joints called as they are.

    A joint turns as the motion says or, where that has positions alone, from the rest pose of its
    skeleton (see `lanindex.rotation`); where the lengths of its bones contradict that (points
    that were measured have no rest), from its first frame. The root moves, and each joint that
    does not stay where it is within its parent. An octahedron shows each bone.

    A joint whose place is unknown keeps the way from its parent that it had last, as a viewer has
    to show something; the file tells in the animation's ``extras`` in which frames, and is read
    back as unknown.
    """
    skeleton = motion.skeleton
    parents = skeleton.parents.astype(int)
    points, unknown = _held(motion, parents)
    turns, offsets = _turned(motion, points, parents)
    ways, turned = _within(points, turns, parents)
    pack = Pack()
    nodes: list[dict[str, Any]] = [
        {"name": name, "translation": _rounded(offset / METRE)}
        for name, offset in zip(skeleton.names, offsets, strict=True)
    ]
    for joint, parent in enumerate(parents.tolist()):
        if parent >= 0:
            nodes[parent].setdefault("children", []).append(joint)
    roots: list[int] = np.flatnonzero(parents < 0).tolist()
    if len(roots) > 1:
        nodes.append({"name": "roots", "children": roots})
        roots = [len(nodes) - 1]
    mesh = _mesh(pack, offsets / METRE, parents)
    nodes.append({"name": "bones", "mesh": 0, "skin": 0})
    animation = _animation(pack, motion, ways / METRE, turned, offsets / METRE)
    animation |= _extras(motion, unknown)
    root = {
        "asset": {"version": "2.0", "generator": "LanIndex"},
        "scene": 0,
        "scenes": [{"nodes": [*roots, len(nodes) - 1]}],
        "nodes": nodes,
        "meshes": [mesh],
        "skins": [
            {
                "joints": list(range(len(parents))),
                "inverseBindMatrices": _binding(pack, offsets / METRE, parents),
            }
        ],
        "animations": [animation],
        "accessors": pack.accessors,
        "bufferViews": pack.views,
        "buffers": [{"byteLength": pack.size}],
    }
    return glb(root, pack.numbers())


def _rounded(values: Floats) -> list[float]:
    return [float(np.float32(value)) for value in values]


def _held(motion: Motion, parents: NDArray[np.int_]) -> tuple[Floats, NDArray[np.bool_]]:
    """Return positions without gaps, and where there were gaps (T, J)."""
    points = motion.positions.astype(np.float64)
    unknown = np.asarray(np.isnan(points).any(axis=2))
    for joint in np.flatnonzero(unknown.any(axis=0)).tolist():
        parent = parents[joint]
        base = points[:, parent] if parent >= 0 else np.zeros((len(points), 3))
        known = ~unknown[:, joint]
        if parent >= 0 and (known & ~unknown[:, parent]).any():
            known &= ~unknown[:, parent]
        way = points[:, joint] - base
        if not known.any():
            way[:] = motion.skeleton.offsets[joint]
        else:
            last = np.maximum.accumulate(np.where(known, np.arange(len(points)), -1))
            way = way[np.where(last < 0, known.argmax(), last)]
        missing = unknown[:, joint]
        points[missing, joint] = (base + way)[missing]
    return points, unknown


def _turned(motion: Motion, points: Floats, parents: NDArray[np.int_]) -> tuple[Floats, Floats]:
    """Return how joints are turned from rest, (T, J, 4), and the offsets at rest."""
    offsets = motion.skeleton.offsets.astype(np.float64)
    if motion.rotations is not None:
        turns = motion.rotations.astype(np.float64)
        known = np.isfinite(turns).all(axis=2)
        last = np.maximum.accumulate(np.where(known, np.arange(len(turns))[:, None], 0), axis=0)
        return unit(np.nan_to_num(np.take_along_axis(turns, last[..., None], axis=0))), offsets
    below = np.flatnonzero(parents >= 0)
    now = np.median(np.linalg.norm(points[:, below] - points[:, parents[below]], axis=2), axis=0)
    rest = np.linalg.norm(offsets[below], axis=1)
    if (np.abs(rest - now) > WRONG * now + RIGID).any():
        pose = points[min(motion.first, len(points) - 1)]
        offsets = pose.copy()
        offsets[below] -= pose[parents[below]]
    turns = np.empty((*points.shape[:2], 4))
    some = points[sampled(len(points))] if motion.axes else points[:0]
    rest = rest_of_axes(motion, offsets, rotations(some, offsets, parents)) if motion.axes else {}
    for start in range(0, len(points), BLOCK):
        part = slice(start, start + BLOCK)
        block = rotations(points[part], offsets, parents)
        turn_to_axes(rest, motion.axes, part, block)
        turns[part] = quaternions(block)
    return turns, offsets


def _within(points: Floats, turns: Floats, parents: NDArray[np.int_]) -> tuple[Floats, Floats]:
    """Return where joints are and how they are turned as their parents see it."""
    ways, turned = points.copy(), turns.copy()
    for joint, parent in enumerate(parents.tolist()):
        if parent < 0:
            continue
        back = inverse(turns[:, parent])
        way = points[:, joint] - points[:, parent]
        ways[:, joint] = np.einsum("tij,tj->ti", matrices(back), way)
        turned[:, joint] = product(back, turns[:, joint])
    return ways, without_flips(unit(turned))


def _animation(
    pack: Pack, motion: Motion, ways: Floats, turned: Floats, offsets: Floats
) -> dict[str, Any]:
    """Lay down the tracks; what never changes has one key."""
    parents = motion.skeleton.parents
    seconds = np.arange(len(motion)) / float(motion.rate)
    every = pack.accessor(seconds, bounds=True)
    once = every if len(seconds) == 1 else pack.accessor(seconds[:1], bounds=True)
    channels, samplers = list[Any](), list[Any]()

    def track(joint: int, path: str, values: Floats, still: bool) -> None:
        output = pack.accessor(values[:1] if still else values)
        samplers.append({"input": once if still else every, "output": output})
        target = {"node": joint, "path": path}
        channels.append({"sampler": len(samplers) - 1, "target": target})

    for joint in range(len(parents)):
        way, turn = ways[:, joint], turned[:, joint][:, [1, 2, 3, 0]]
        if joint == 0 or np.abs(way - np.float32(offsets[joint])).max() > RIGID / METRE:
            still = joint > 0 and np.ptp(way, axis=0).max() <= RIGID / METRE
            track(joint, "translation", way, still)
        track(joint, "rotation", turn, np.ptp(turn, axis=0).max() <= STILL)
    return {"name": "capture", "channels": channels, "samplers": samplers}


def _extras(motion: Motion, unknown: NDArray[np.bool_]) -> dict[str, Any]:
    """Return what keys do not tell: the rate of a single pose, and what was unknown."""
    extras: dict[str, Any] = {"frames": len(motion), "rate": str(motion.rate)}
    gaps = {}
    for joint in np.flatnonzero(unknown.any(axis=0)).tolist():
        edges = np.flatnonzero(np.diff(unknown[:, joint].astype(np.int8), prepend=0, append=0))
        gaps[motion.skeleton.names[joint]] = edges.reshape(-1, 2).tolist()
    return {"extras": {**extras, "unknown": gaps} if gaps else extras}


def _binding(pack: Pack, offsets: Floats, parents: NDArray[np.int_]) -> int:
    """Lay down what takes the mesh at rest into each joint's own axes."""
    matrix = np.tile(np.eye(4), (len(parents), 1, 1))
    matrix[:, 3, :3] = -_standing(offsets, parents)  # column after column
    return pack.accessor(matrix)


def _standing(offsets: Floats, parents: NDArray[np.int_]) -> Floats:
    """Return where joints are at rest."""
    places = offsets.copy()
    for joint, parent in enumerate(parents.tolist()):
        if parent >= 0:
            places[joint] += places[parent]
    return places


def _mesh(pack: Pack, offsets: Floats, parents: NDArray[np.int_]) -> dict[str, Any]:
    corners, joints, faces = octahedra(_standing(offsets, parents), parents.tolist())
    follows = np.zeros((len(corners), 4), int)
    follows[:, 0] = joints
    weights = np.tile([1.0, 0, 0, 0], (len(corners), 1))
    attributes = {
        "POSITION": pack.accessor(corners, target=VERTICES, bounds=True),
        "JOINTS_0": pack.accessor(follows, "<u2", target=VERTICES),
        "WEIGHTS_0": pack.accessor(weights, target=VERTICES),
    }
    indices = pack.accessor(faces.reshape(-1, 1), "<u4", target=INDICES)
    return {"name": "bones", "primitives": [{"attributes": attributes, "indices": indices}]}


WIDTH = 0.08
"""Half of a bone's thickness, of its length."""

RING = 0.15
"""Where it is thickest, of its length."""

TIP = 0.02
"""Metres that the last joint of a limb is shown by."""

_FACES = np.array(
    [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 1, 4], [5, 1, 2], [5, 2, 3], [5, 3, 4], [5, 4, 1]]
)


def octahedra(
    places: Floats, parents: Sequence[int]
) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """Return the bones of a skeleton as octahedra.

    Takes `places` (J, 3); returns (6 B, 3), (8 B, 3).
    """
    bones = [
        (parent, places[parent], places[joint])
        for joint, parent in enumerate(parents)
        if parent >= 0 and np.linalg.norm(places[joint] - places[parent]) > 1e-4
    ]
    ended = set(range(len(parents))) - {joint for joint, _, _ in bones}
    bones += [(joint, places[joint], places[joint] + [0, TIP, 0]) for joint in sorted(ended)]
    corners = np.concatenate([_corners(start, stop) for _, start, stop in bones])
    joints = np.repeat([joint for joint, _, _ in bones], 6)
    faces = np.concatenate([_FACES + 6 * number for number in range(len(bones))])
    return corners, joints, faces


def _corners(start: Floats, stop: Floats) -> Floats:
    """Return the corners of a bone: its head, four about it, its tail."""
    along = stop - start
    across = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    across *= WIDTH * np.linalg.norm(along) / np.linalg.norm(across)
    other = np.cross(along, across) / np.linalg.norm(along)
    middle = start + RING * along
    ring = (middle + across, middle + other, middle - across, middle - other)
    return np.stack([start, *ring, stop])


KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
CODES = {"<u2": 5123, "<u4": 5125, "<f4": 5126}
VERTICES, INDICES = 34962, 34963
"""What a buffer view of a mesh is for."""


class Pack:
    """Numbers, and the accessors and buffer views that tell of them."""

    def __init__(self, views: list[Any] | None = None, accessors: list[Any] | None = None) -> None:
        self.views: list[Any] = [] if views is None else views
        self.accessors: list[Any] = [] if accessors is None else accessors
        self.size = 0
        self.free: tuple[list[int], list[int]] = ([], [])
        self._parts: list[bytes | memoryview] = []

    def copy(self, accessors: list[int], views: list[int]) -> Pack:
        """Return the same once more, some of whose accessors and views may be overwritten."""
        made = Pack(list(self.views), list(self.accessors))
        made.size, made._parts = self.size, list(self._parts)
        made.free = (accessors[::-1], views[::-1])
        return made

    def fill(self, number: int) -> None:
        """Let what is free yet be the same as an accessor."""
        entry = self.accessors[number]
        for free in self.free[0]:
            self.accessors[free] = entry
        for free in self.free[1]:
            self.views[free] = self.views[entry["bufferView"]]

    def numbers(self) -> bytes:
        """Return the numbers."""
        return b"".join(self._parts)

    def lay(self, data: bytes | memoryview) -> dict[str, int]:
        """Lay bytes behind the others; return where, as a buffer view tells it."""
        gap = -self.size % 4
        self._parts += [b"\0" * gap, data]
        place = {"buffer": 0, "byteOffset": self.size + gap, "byteLength": len(data)}
        self.size += gap + len(data)
        return place

    def view(self, data: bytes, target: int | None = None) -> int:
        """Add a buffer view; return its number."""
        entry = self.lay(data)
        entry = entry if target is None else {**entry, "target": target}
        return _put(self.views, entry, self.free[1])

    def accessor(
        self,
        values: NDArray[Any],
        kind: str = "<f4",
        *,
        target: int | None = None,
        bounds: bool = False,
    ) -> int:
        """Add an accessor of (N, width) numbers; return its number."""
        rows = np.ascontiguousarray(values, kind).reshape(len(values), -1)
        entry: dict[str, Any] = {
            "bufferView": self.view(rows.tobytes(), target),
            "componentType": CODES[kind],
            "count": len(rows),
            "type": KINDS[rows.shape[1]],
        }
        if bounds:
            entry |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        return _put(self.accessors, entry, self.free[0])


def _put(things: list[Any], thing: Any, free: list[int]) -> int:
    """Put a thing where one is free, else behind the others; return its number."""
    if free:
        things[free[-1]] = thing
        return free.pop()
    things.append(thing)
    return len(things) - 1


def glb(root: dict[str, Any], data: bytes) -> bytes:
    """Return a GLB of its JSON and its numbers."""
    text = json.dumps(root, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    rest = -len(data) % 4
    binary = struct.pack("<I4s", len(data) + rest, BINARY_CHUNK) if data else b""
    size = 20 + len(text) + len(binary) + (len(data) + rest)
    head = struct.pack("<4sIII4s", MAGIC, 2, size, len(text), JSON_CHUNK)
    return b"".join((head, text, binary, data, b"\0" * rest))
