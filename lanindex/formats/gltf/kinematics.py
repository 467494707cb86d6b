"""From the nodes' shifts, turns and scales to where joints are, all frames of a block at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lanindex.formats.gltf.scene import Nodes, Person
from lanindex.formats.gltf.tracks import Track
from lanindex.formats.turning import worlds

BLOCK = 2048
"""Frames at a time."""

Floats = NDArray[np.float64]


def above(nodes: Nodes, person: Person) -> list[int]:
    """Return the joints of a person and all nodes above them, parents before children."""
    needed = set[int]()
    for joint in person.joints:
        node = joint
        while node >= 0 and node not in needed:
            needed.add(node)
            node = nodes.parents[node]
    return [node for node in nodes.order if node in needed]


def placed(
    nodes: Nodes,
    person: Person,
    tracks: Sequence[Track] = (),
    frames: NDArray[np.int64] | None = None,
) -> tuple[Floats, Floats]:
    """Return where joints are and how they are turned, in the axes of the scene.

    Parameters
    ----------
    nodes : Nodes
        The file's.
    person : Person
        Whose joints.
    tracks : sequence of Track
        What moves them; without any they stand.
    frames : ndarray, optional
        (T,) which.

    Returns
    -------
    tuple of ndarray and ndarray
        (T, J, 3) and (T, J, 4) quaternions (w, x, y, z); T is 1 where nothing moves.
    """
    moved = {(track.node, track.path): track for track in tracks}
    count = 1 if frames is None else len(frames)
    place = {node: number for number, node in enumerate(person.joints)}
    points, turned = np.empty((count, len(place), 3)), np.empty((count, len(place), 4))

    def at(node: int, path: str, still: Floats) -> Floats:
        track = moved.get((node, path))
        if track is None or frames is None:
            return still[None]
        return track.at(frames)

    def standing(node: int) -> tuple[Floats, Floats, Floats]:
        return (
            at(node, "translation", nodes.shifts[node]),
            at(node, "rotation", nodes.turns[node]),
            at(node, "scale", nodes.scales[node]),
        )

    needed = ((node, nodes.parents[node]) for node in above(nodes, person))
    for node, point, turn in worlds(needed, standing):
        if node in place:
            points[:, place[node]], turned[:, place[node]] = point, turn
    return points, turned
