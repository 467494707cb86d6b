"""A skeleton in a few of its poses, and what can be measured on it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

_NEAR_PELVIS = 0.35  # of a thigh, from the middle of the hips
_STRAIGHT = 0.95  # mean cosine: a foot of real captures makes at most .91 with its shank
_NOTHING = 0.003  # of the body's extent: two joints in one place


class Rig:
    """A skeleton in a few of its poses.

    `names` (J) as in the file; `parents` (J) parents before children, -1 for a root; None where
    there is no hierarchy: joints then lie beyond each other by their distance alone; `poses` (S, J,
    3) float64, any unit.
    """

    def __init__(
        self, names: tuple[str, ...], parents: Sequence[int] | None, poses: NDArray[np.float64]
    ) -> None:
        self.joined = parents is not None
        parents = (-1,) * len(names) if parents is None else parents
        self.names, self.parents, self.poses = names, parents, poses
        above = [joint if parent < 0 else parent for joint, parent in enumerate(parents)]
        self.bones: list[float] = mean_length(poses - poses[:, above]).tolist()
        self.below: list[list[int]] = [[] for _ in parents]
        for joint, parent in enumerate(parents):
            if parent >= 0:
                self.below[parent].append(joint)
        self.extent = list(self.bones)
        beyond = [0.0] * len(parents)
        for joint in range(len(parents) - 1, -1, -1):
            self.extent[joint] += beyond[joint]
            beyond[above[joint]] = max(beyond[above[joint]], self.extent[joint])
        middle = poses[len(poses) // 2]
        self.nothing = _NOTHING * float((middle.max(axis=0) - middle.min(axis=0)).max())

    def distance(self, one: int, other: int) -> float:
        """Return the mean distance of two joints."""
        return float(mean_length(self.poses[:, one] - self.poses[:, other]))

    def above(self, joint: int) -> list[int]:
        """Return a joint, its parent, and so on up to the root."""
        chain = []
        while joint >= 0:
            chain.append(joint)
            joint = self.parents[joint]
        return chain

    def beyond(self, joint: int, ancestor: int) -> float:
        """Return the length of the bones from an ancestor to a joint, -1 where it is none."""
        if not self.joined:
            return self.distance(joint, ancestor)
        length = 0.0
        while joint != ancestor and joint >= 0:
            length += self.bones[joint]
            joint = self.parents[joint]
        return length if joint == ancestor else -1.0

    def branch(self, joint: int) -> Iterator[int]:
        """Yield the joints away from `joint` on the branch that reaches farthest."""
        length = 0.0
        while self.below[joint]:
            joint = max(self.below[joint], key=self.extent.__getitem__)
            length += self.bones[joint]
            if length > self.nothing:
                yield joint

    def tip(self, outer: int, named: Sequence[int] = (), inner: int | None = None) -> int | None:
        """Return the joint that tells where a hand, a foot or a head points, if there is one."""
        apart = (index for index in named if self.beyond(index, outer) > self.nothing)
        found = (*apart, *self.branch(outer))
        return next((one for one in found if inner is None or self._aside(one, outer, inner)), None)

    def _aside(self, joint: int, outer: int, inner: int) -> bool:
        """Return whether a joint leaves the line from `inner` through `outer`."""
        bone, before = (
            self.poses[:, b] - self.poses[:, a] for a, b in ((outer, joint), (inner, outer))
        )
        sizes = np.linalg.norm(bone, axis=1) * np.linalg.norm(before, axis=1)
        along = np.einsum("si,si->s", bone, before)[sizes > 0] / sizes[sizes > 0]
        return not along.size or float(along.mean()) < _STRAIGHT

    def meeting(self, one: int, other: int) -> int | None:
        """Return the joint where two branches part."""
        above = set(self.above(one))
        return next((joint for joint in self.above(other) if joint in above), None)


def mean_length(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the length of (S, ..., 3) vectors, mean over the first axis."""
    lengths = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
    mean: NDArray[np.float64] = lengths.sum(axis=0) / len(lengths)
    return mean


def near_hips(rig: Rig, index: int, body: dict[str, int]) -> bool:
    """Return whether a joint lies about where the hips are."""
    middle = (rig.poses[:, body["RHip"]] + rig.poses[:, body["LHip"]]) / 2
    apart = float(mean_length(rig.poses[:, index] - middle))
    thigh = rig.distance(body["RHip"], body["RKnee"])
    return apart < _NEAR_PELVIS * thigh and index not in (body["RHip"], body["LHip"])
