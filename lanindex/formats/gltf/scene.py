"""The nodes of a glTF file, and which of them are the joints of whom."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from heapq import heapify, heappop, heappush

import numpy as np
from numpy.typing import NDArray

from lanindex.formats.gltf.document import Document, Value
from lanindex.formats.people import distinct
from lanindex.formats.turning import quaternions, unit

DEEPEST = 500
"""Nodes in each other: a finger's tip is the twentieth."""

MOST_NODES = 100_000
MOST_JOINTS = 32_000
"""What an int16 index can hold."""

Floats = NDArray[np.float64]


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


@dataclass(frozen=True, slots=True)
class Person:
    """One skeleton."""

    name: str  # of the skin or, without one, of the topmost node; empty where it has none
    joints: tuple[int, ...]  # (J) nodes, parents before children
    names: tuple[str, ...]  # (J) each its own
    parents: tuple[int, ...]  # (J) joints, by their places in this list, -1 for a root


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


def people(document: Document, nodes: Nodes, moved: set[int]) -> list[Person]:
    """Return the skeletons of a file.

    The joints of a skin are one skeleton; skins that share joints, or hang on each other's, are
    clothes of one person. Nodes between joints and below them are joints too, unless they show a
    mesh. Without a skin, nodes that move under one root are a skeleton.
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
    for node in nodes.order:
        above = nodes.parents[node]
        if node not in owner and above in owner and not (skinned and node in nodes.meshed):
            owner[node] = owner[above]
    members: list[list[int]] = [[] for _ in groups]
    for node in nodes.order:
        if node in owner:
            members[owner[node]].append(node)
    return [
        _person(name, joints, nodes, document)
        for (name, _), joints in zip(groups, members, strict=True)
    ]


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


def _person(name: str, joints: list[int], nodes: Nodes, document: Document) -> Person:
    if len(joints) > MOST_JOINTS:
        Value(len(joints), "the number of joints", document.file.name).wrong(f"{MOST_JOINTS}")
    place, parents = dict[int, int](), []
    for number, joint in enumerate(joints):
        place[joint] = number
        parents.append(place.get(nodes.parents[joint], -1))
    names = distinct([nodes.names[joint] for joint in joints], joints)
    return Person(name, tuple(joints), names, tuple(parents))
