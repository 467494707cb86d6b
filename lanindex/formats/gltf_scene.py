"""What a glTF file shows: nodes, the joints of people among them, and animations of keys at times.

Khronos Group, glTF 2.0 Specification, 2021: 3.7 (skins), 3.11 (animations).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from heapq import heapify, heappop, heappush
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError
from lanindex.formats.gltf_document import Document, Value, numbers, shape
from lanindex.formats.rates import nearest_rate
from lanindex.formats.turning import JointTree, between, joint_tree, quaternions, unit

Floats = NDArray[np.float64]

DEEPEST = 500  # nodes in each other: a finger's tip is the twentieth
MOST_NODES = 100_000
MOST_JOINTS = 32_000  # what an int16 index can hold
PATHS = {"translation": 3, "rotation": 4, "scale": 3}  # what moves joints, and in how many numbers
KINDS = ("LINEAR", "STEP", "CUBICSPLINE")
ON_GRID = 0.1  # of a frame: keys as near as this to a frame are on it
SLOW, USUAL = 15, 30  # keys rarer than so many a second are read between them, so often at least
MOST_BETWEEN = 10_000  # frames that a key may stand for


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """The nodes of a file."""

    names: tuple[str, ...]  # (N) as the file has them; empty where it has none
    parents: tuple[int, ...]  # (N) -1 for a root
    order: tuple[int, ...]  # (N) all of them, parents before children, limb after limb
    depths: tuple[int, ...]  # (N) how many are above each
    meshed: frozenset[int]  # those that show a mesh or are a camera
    # (N, 3), (N, 4), (N, 3): where each stands within its parent while nothing moves it
    shifts: Floats
    turns: Floats
    scales: Floats


def nodes_of(document: Document) -> Nodes:
    """Return the nodes of a file."""
    values = document.root.get("nodes")
    count = values.count()
    if count > MOST_NODES:
        Value(count, "the number of nodes", document.file.name).wrong(f"at most {MOST_NODES}")
    parents, children = [-1] * count, [list[int]() for _ in range(count)]
    shifts, turns, scales = np.zeros((count, 3)), np.zeros((count, 4)), np.ones((count, 3))
    turns[:, 0] = 1
    names, meshed = [], set()
    for number, node in enumerate(values):
        names.append(node.get("name", "").text())
        if "mesh" in node or "camera" in node:
            meshed.add(number)
        for child in node.get("children"):
            below = child.one_of(values)
            if parents[below] >= 0:
                child.wrong("a node that is in no other node")
            parents[below] = number
            children[number].append(below)
        shifts[number], turns[number], scales[number] = _standing(node)
    order, depths = list[int](), [0] * count
    waiting = [number for number in reversed(range(count)) if parents[number] < 0]
    while waiting:
        number = waiting.pop()
        order.append(number)
        depths[number] = depths[parents[number]] + 1 if parents[number] >= 0 else 0
        waiting.extend(reversed(children[number]))
    deepest = max(depths, default=0)
    if len(order) < count or deepest > DEEPEST:
        odd = values[next(n for n in range(count) if n not in set(order) or depths[n] == deepest)]
        odd.get("children").wrong(f"nodes that are not in themselves, nor {DEEPEST} in each other")
    frozen = frozenset(meshed)
    return Nodes(
        *(tuple(names), tuple(parents), tuple(order), tuple(depths), frozen, shifts, turns, scales)
    )


def _standing(node: Value) -> tuple[Floats, Floats, Floats]:
    """Return where a node stands: shift, turn, scale."""
    if "matrix" not in node:
        x, y, z, w = node.get("rotation", [0, 0, 0, 1]).numbers(4)
        return (
            np.array(node.get("translation", [0, 0, 0]).numbers(3)),
            unit(np.array([w, x, y, z])),
            np.array(node.get("scale", [1, 1, 1]).numbers(3)),
        )
    matrix = np.array(node.get("matrix").numbers(16)).reshape(4, 4).T
    scale = np.sqrt((matrix[:3, :3] ** 2).sum(axis=0))
    if np.linalg.det(matrix[:3, :3]) < 0:
        scale[0] = -scale[0]
    return matrix[:3, 3], quaternions(matrix[:3, :3] / np.where(scale == 0, 1, scale)), scale


def people(document: Document, nodes: Nodes, moved: set[int]) -> list[tuple[str, JointTree]]:
    """Return the skeletons of a file, each by the name of its skin or, without one, topmost node.

    Skins that share joints, or hang on each other's, are clothes of one person. Nodes between and
    below joints are joints, unless they show a mesh. Without skins, moving nodes under one root are
    one.
    """
    groups = list[tuple[str, set[int]]]()
    skinned = _skins(document, nodes)
    for name, joints in skinned or _trees(nodes, moved):
        known = set(joints)
        top = _joined(nodes, known, joints)
        if top is not None and (top in moved or not skinned):
            known.add(top)
        groups.append((name, known))
    owner = {node: number for number, (_, known) in enumerate(groups) for node in known}
    members: list[list[int]] = [[] for _ in groups]
    for node in nodes.order:
        above = nodes.parents[node]
        if node not in owner and above in owner and not (skinned and node in nodes.meshed):
            owner[node] = owner[above]
        if node in owner:
            members[owner[node]].append(node)
    most = max(map(len, members), default=0)
    if most > MOST_JOINTS:
        Value(most, "the number of joints", document.file.name).wrong(f"{MOST_JOINTS}")
    trees = [joint_tree(joints, nodes.names, nodes.parents) for joints in members]
    return [(name, tree) for (name, _), tree in zip(groups, trees, strict=True)]


def _skins(document: Document, nodes: Nodes) -> list[tuple[str, list[int]]]:
    """Return the joints of skins, those of one person together."""
    leader = dict[int, int]()

    def first(node: int) -> int:
        while leader[node] != node:
            leader[node] = leader[leader[node]]
            node = leader[node]
        return node

    called = dict[int, str]()
    for skin in document.root.get("skins"):
        joints = [joint.one_of(document.root.get("nodes")) for joint in skin.get("joints")]
        for joint in joints:
            leader.setdefault(joint, joint)
            leader[first(joint)] = first(joints[0])
        if joints:
            called.setdefault(joints[0], skin.get("name", "").text())
    nearest = dict[int, int]()  # the joint above each node
    for node in nodes.order:
        above = nodes.parents[node]
        near = above if above in leader else nearest.get(above, -1)
        nearest[node] = near
        if node in leader and near >= 0:
            leader[first(node)] = first(near)
    groups = dict[int, list[int]]()
    for joint in leader:
        groups.setdefault(first(joint), []).append(joint)
    named = dict[int, str]()
    for joint, name in called.items():
        named[first(joint)] = named.get(first(joint)) or name
    return [(named.get(number, ""), joints) for number, joints in groups.items()]


def _trees(nodes: Nodes, moved: set[int]) -> list[tuple[str, list[int]]]:
    """Return the nodes that move, those under one root together."""
    roots = dict[int, int]()
    groups = dict[int, list[int]]()
    for node in nodes.order:
        roots[node] = roots.get(nodes.parents[node], node)
        if node in moved:
            groups.setdefault(roots[node], []).append(node)
    return [(nodes.names[root], joints) for root, joints in groups.items()]


def _joined(nodes: Nodes, known: set[int], joints: Iterable[int]) -> int | None:
    """Add the nodes between some to them; return the one above all, where it is none of them."""
    waiting = [(-nodes.depths[joint], joint) for joint in joints]
    heapify(waiting)
    seen = {joint for _, joint in waiting}
    while len(waiting) > 1:
        _, node = heappop(waiting)
        known.add(node)
        above = nodes.parents[node]
        if above < 0:  # roots of their own
            known.update(joint for _, joint in waiting)
            return None
        if above not in seen:
            seen.add(above)
            heappush(waiting, (-nodes.depths[above], above))
    return None if not waiting or waiting[0][1] in known else waiting[0][1]


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """How one thing changes."""

    node: int  # whose; -1: of no node
    path: str  # ``translation``, ``rotation``, ``scale``; another: nothing that moves joints
    kind: str  # ``LINEAR``, ``STEP`` or ``CUBICSPLINE``
    times: Floats  # (K,) seconds, not falling
    # (K, W); of a spline (K, 3, W): the tangent before, the value, the tangent behind. Turns are
    # (x, y, z, w).
    values: NDArray[Any]
    keys: Floats  # (K,) the times in frames

    def at(self, frames: NDArray[np.int64], *, exactly: bool = False) -> Floats:
        """Return values (T, W) in frames; rotations (w, x, y, z), unit or `exactly` as keys."""
        keys = self.keys
        last = len(keys) - 1
        before = np.clip(np.searchsorted(keys, frames, side="right") - 1, 0, last)
        found = self._key(before)
        if self.kind != "STEP" and last:
            after = np.minimum(before + 1, last)
            wide = keys[after] - keys[before]
            part = np.clip((frames - keys[before]) / np.where(wide > 0, wide, 1), 0, 1)
            on = np.flatnonzero(part)
            if len(on):
                found[on] = self._between(before[on], after[on], part[on])
        return unit(found) if self.path == "rotation" and not exactly else found

    def _key(self, index: NDArray[np.int64], which: int = 1) -> Floats:
        """Return values (T, W) of keys, or of a spline's a tangent: 0 before it, 2 behind."""
        rows = self.values[index, which] if self.kind == "CUBICSPLINE" else self.values[index]
        rows = rows.astype(np.float64)
        return rows[:, [3, 0, 1, 2]] if self.path == "rotation" else rows

    def _between(self, before: NDArray[np.int64], after: NDArray[np.int64], u: Floats) -> Floats:
        """Return values between keys; on cubic Hermite splines as appendix C of glTF 2.0 says."""
        start, stop = self._key(before), self._key(after)
        if self.kind == "LINEAR" and self.path == "rotation":
            return between(unit(start), unit(stop), u)
        u = u[:, None]
        if self.kind == "LINEAR":
            return np.asarray(start + u * (stop - start))
        seconds = (self.times[after] - self.times[before])[:, None]
        square, cube = u * u, u * u * u
        found = (2 * cube - 3 * square + 1) * start + (3 * square - 2 * cube) * stop
        found += seconds * (cube - 2 * square + u) * self._key(before, 2)
        found += seconds * (cube - square) * self._key(after, 0)
        return np.asarray(found)


@dataclass(frozen=True, slots=True)
class Clock:
    """When frames are."""

    rate: Fraction  # frames a second
    pace: float  # the same as the keys have it, not rounded
    start: float  # seconds at frame 0
    count: int  # how many frames there are
    tied: float  # of a frame: keys as near as this to one are on it
    doubts: tuple[str, ...] = ()  # what was odd

    def frames(self, times: Floats) -> Floats:
        """Return when times are, in frames."""
        frames = (times - self.start) * self.pace
        nearest = np.rint(frames)
        return np.where(np.abs(frames - nearest) <= self.tied, nearest, frames)


def takes(document: Document) -> list[tuple[str, Value]]:
    """Return the animations by their names, those without one by their numbers from 1 on."""
    animations = enumerate(document.root.get("animations"), 1)
    return [(take.get("name", "").text() or str(number), take) for number, take in animations]


def moved(document: Document, take: Value) -> set[int]:
    """Return the nodes that an animation moves, its numbers not looked at."""
    nodes = document.root.get("nodes")
    found = set()
    for channel in take.get("channels"):
        target = channel.get("target")
        if str(target.get("path").value) in PATHS and "node" in target:
            found.add(target.get("node").one_of(nodes))
    return found


def tracks(document: Document, take: Value, wanted: Iterable[int] | None = None) -> list[Track]:
    """Return the tracks of an animation."""
    nodes, chosen = document.root.get("nodes"), None if wanted is None else set(wanted)
    samplers = take.get("samplers")
    known = dict[int, NDArray[Any]]()
    found = []
    for channel in take.get("channels"):
        target = channel.get("target")
        path = str(target.get("path").value)
        node = target.get("node").one_of(nodes) if "node" in target else -1
        if chosen is not None and (path not in PATHS or node not in chosen):
            continue
        sampler = samplers[channel.get("sampler").one_of(samplers)]
        found.append(_track(document, sampler, node, path, known))
    return found


def _track(
    document: Document, sampler: Value, node: int, path: str, arrays: dict[int, NDArray[Any]]
) -> Track:
    kind = sampler.get("interpolation", "LINEAR").word(KINDS)
    spline = kind == "CUBICSPLINE"
    start, stop = sampler.get("input"), sampler.get("output")
    keys, (count, width) = shape(document, start), shape(document, stop)
    elements = keys[0] * (3 if spline else 1)
    fits = (
        (count == elements and width == PATHS[path])
        if path in PATHS
        else not count * width % elements
    )
    if keys[1] != 1 or not fits:
        raise CaptureError(
            f"{sampler.where} has {keys[0]} keys of {keys[1]} and {count} values of {width}",
            place=document.file.name,
            wanted=f"times and as many values as a {kind} {path} has",
        )
    if start.integer() not in arrays:
        times = numbers(document, start)[:, 0].astype(np.float64)
        if (np.diff(times) < 0).any():
            raise CaptureError(
                f"the times of {sampler.where} go back at key {int(np.diff(times).argmin()) + 1}",
                place=document.file.name,
                wanted="times that rise",
            )
        arrays[start.integer()] = times
    if stop.integer() not in arrays:
        arrays[stop.integer()] = numbers(document, stop)
    values = arrays[stop.integer()]
    values = values.reshape(keys[0], 3, -1) if spline else values.reshape(keys[0], -1)
    times = arrays[start.integer()]
    return Track(node, path, kind, times, values, times)


def clock(times: Sequence[Floats], path: str) -> Clock:
    """Return the frames of an animation, at the times of the keys of its densest track.

    Frames without keys lie between even keys; sparse or uneven keys are read between, too.
    """
    densest = max(times, key=len)
    first = min(float(one[0]) for one in times)
    last = max(float(one[-1]) for one in times)
    steps = np.diff(densest)
    steps = steps[steps > 0]
    if not len(steps):
        return Clock(Fraction(USUAL), float(USUAL), first, 1, 0.0)
    step = float(np.sort(steps)[(len(steps) - 1) // 2])
    usual = steps[np.abs(steps - step) < step / 2]
    whole = np.maximum(np.rint(steps / float(usual.mean())), 1)
    pace = float(whole.sum() / steps.sum())
    even = bool(np.abs(np.cumsum(steps) * pace - np.cumsum(whole)).max() <= ON_GRID)
    if not even:
        pace = 1 / step
    doubts: tuple[str, ...] = ()
    often = ceil(USUAL / pace) if pace < SLOW else 1
    keys = f"keys are {1 / pace:.3g} s apart"
    pace *= often
    if not first + 1e5 > last or (last - first) * pace > MOST_BETWEEN * len(densest):
        raise CaptureError(
            f"{len(densest)} keys from {first:g} to {last:g} s, {step:g} s apart",
            place=path,
            wanted=f"keys that stand for {MOST_BETWEEN} frames at most, in a day",
        )
    rate = nearest_rate(Fraction(pace).limit_denominator(10**6))
    tied = ON_GRID if even else 1e-3
    pace = pace if even else float(rate)
    start = float(densest[0])
    start -= np.floor((start - first) * pace + tied) / pace
    found = Clock(rate, pace, start, 1, tied)
    frames = int(np.floor(found.frames(np.array([last]))[0] + tied)) + 1
    if often > 1:
        doubts = (f"{keys}: it is read at {float(rate):g} frames a second",)
    in_frames = (found.frames(one) for one in times)
    if not even or any((one != np.rint(one)).any() for one in in_frames):
        doubts = (f"keys are at uneven times: it is read at {float(rate):g} frames a second",)
    return Clock(rate, pace, start, frames, tied, doubts)


def timed(untimed: Sequence[Track], clock: Clock) -> list[Track]:
    """Return tracks that know their keys in frames."""
    known = {id(track.times): clock.frames(track.times) for track in untimed}
    return [replace(track, keys=known[id(track.times)]) for track in untimed]
