"""From the nodes' shifts, turns and scales to where joints are, all frames at once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.formats.gltf.scene import Nodes
from lanindex.formats.gltf.tracks import Track
from lanindex.formats.turning import inverse, product, worlds

Floats = NDArray[np.float64]


def above(nodes: Nodes, joints: Iterable[int]) -> list[int]:
    """Return joints and all nodes above them, parents before children."""
    needed = set[int]()
    for node in joints:
        while node >= 0 and node not in needed:
            needed.add(node)
            node = nodes.parents[node]
    return [node for node in nodes.order if node in needed]


def placed(
    nodes: Nodes,
    joints: Sequence[int],
    tracks: Sequence[Track] = (),
    frames: NDArray[np.int64] | None = None,
    rest: Floats | None = None,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return where joints are and how they are turned, in the axes of the scene.

    Takes `frames` (T,), `rest` (J, 4); returns (T, J, 3), (T, J, 4).
    """
    moved = {(track.node, track.path): track for track in tracks}
    count = 1 if frames is None else len(frames)
    place = {node: number for number, node in enumerate(joints)}
    kind = np.float64 if rest is None else np.float32
    points, turned = (np.empty((count, len(place), width), kind) for width in (3, 4))
    back = None if rest is None else inverse(rest)

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

    needed = ((node, nodes.parents[node]) for node in above(nodes, joints))
    for node, point, turn in worlds(needed, standing):
        joint = place.get(node)
        if joint is not None:
            points[:, joint] = point
            turned[:, joint] = turn if back is None else product(turn, back[joint])
    return points, turned
