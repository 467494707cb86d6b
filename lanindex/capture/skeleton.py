"""Which joints of a file play the 20 joints of the body.

Names first (`bodies.toml`), then, for what names do not tell, the shape of the skeleton
(`shape`). Nothing is invented: a joint that is not there stays absent.

A body is human enough to be encoded if both hips are there (the heading needs them) and both legs
down to the ankles or both arms from shoulder to wrist.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.capture.joint_names import candidates, keys, tables
from lanindex.errors import BodyError

Candidates = Mapping[tuple[str, str, str], tuple[int, ...]]
_Limb = tuple[str, str, str]

_LIMBS: tuple[_Limb, ...] = (("Shoulder", "Elbow", "Wrist"), ("Hip", "Knee", "Ankle"))
_TIPS = {"Wrist": "Hand", "Ankle": "Toe"}
_NEAR_PELVIS = 0.35  # of a thigh, from the middle of the hips
_NOTHING = 0.003  # of the body's extent: two joints in one place
_LIKE = 75  # of 100: how much a misspelt name has to be like the right one
NEEDED = tuple(side + joint for side in "RL" for limb in _LIMBS for joint in limb)


class Rig:
    """A skeleton in a few of its poses.

    Parameters
    ----------
    names : tuple of str
        (J) as in the file.
    parents : tuple of int
        (J) parents before children, -1 for a root.
    poses : ndarray
        (S, J, 3) float64, any unit.

    Attributes
    ----------
    bones : list of float
        (J) mean distance of each joint from its parent; 0 at a root.
    below : list of list of int
        (J) children.
    reach : list of float
        (J) length of the bone to each joint and of the longest branch beyond it.
    nothing : float
        Below this distance two joints are in one place.
    """

    def __init__(
        self, names: tuple[str, ...], parents: tuple[int, ...], poses: NDArray[np.float64]
    ) -> None:
        self.names, self.parents, self.poses = names, parents, poses
        above = [joint if parent < 0 else parent for joint, parent in enumerate(parents)]
        self.bones: list[float] = _mean_length(poses - poses[:, above]).tolist()
        self.below: list[list[int]] = [[] for _ in parents]
        for joint, parent in enumerate(parents):
            if parent >= 0:
                self.below[parent].append(joint)
        self.reach = list(self.bones)
        beyond = [0.0] * len(parents)
        for joint in range(len(parents) - 1, -1, -1):
            self.reach[joint] += beyond[joint]
            beyond[above[joint]] = max(beyond[above[joint]], self.reach[joint])
        middle = poses[len(poses) // 2]
        self.nothing = _NOTHING * float((middle.max(axis=0) - middle.min(axis=0)).max())

    def distance(self, one: int, other: int) -> float:
        """Return the mean distance of two joints."""
        return float(_mean_length(self.poses[:, one] - self.poses[:, other]))

    def above(self, joint: int) -> list[int]:
        """Return a joint, its parent, and so on up to the root."""
        chain = []
        while joint >= 0:
            chain.append(joint)
            joint = self.parents[joint]
        return chain

    def beyond(self, joint: int, ancestor: int) -> float:
        """Return the length of the bones from an ancestor to a joint, -1 where it is none."""
        length = 0.0
        while joint != ancestor and joint >= 0:
            length += self.bones[joint]
            joint = self.parents[joint]
        return length if joint == ancestor else -1.0

    def longest_branch(self, joint: int) -> int | None:
        """Return the first joint away from `joint` on the branch that reaches farthest, if any."""
        length = 0.0
        while self.below[joint]:
            joint = max(self.below[joint], key=self.reach.__getitem__)
            length += self.bones[joint]
            if length > self.nothing:
                return joint
        return None

    def meeting(self, one: int, other: int) -> int | None:
        """Return the joint where two branches part."""
        above = set(self.above(one))
        return next((joint for joint in self.above(other) if joint in above), None)


def _mean_length(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the length of (S, ..., 3) vectors, mean over the first axis."""
    lengths = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
    mean: NDArray[np.float64] = lengths.sum(axis=0) / len(lengths)
    return mean


def find_body(rig: Rig, path: str = "") -> tuple[NDArray[np.int16], tuple[str, ...]]:
    """Find the body.

    Parameters
    ----------
    rig : Rig
        The skeleton.
    path : str
        The file, for errors.

    Returns
    -------
    tuple of ndarray and tuple of str
        (20,) int16, the joint that plays each of ``alphabet.JOINTS``, -1: absent; and warnings.

    Raises
    ------
    BodyError
        This is no human skeleton; names the joints that are missing.
    """
    body = _by_name(rig)
    warnings: tuple[str, ...] = ()
    if not all(joint in body for joint in NEEDED):
        from lanindex.capture.shape import by_shape

        shaped, doubts = by_shape(rig)
        if all(shaped.get(joint, index) == index for joint, index in body.items()):
            found = [joint for joint in JOINTS if joint in shaped and joint not in body]
            body |= {joint: shaped[joint] for joint in found}
            if found:
                warnings = (f"recognised by shape, not by name: {', '.join(found)}", *doubts)
    if not is_human(body):
        raise _no_human(rig, body, path)
    result = np.full(len(JOINTS), -1, np.int16)
    for joint, index in body.items():
        result[JOINT_CODES[joint]] = index
    return result, warnings


def is_human(body: dict[str, int]) -> bool:
    """Tell whether enough of a body is there to encode it."""
    limbs = [all(side + joint in body for side in "RL" for joint in limb) for limb in _LIMBS]
    return any(limbs) and "RHip" in body and "LHip" in body


def _by_name(rig: Rig) -> dict[str, int]:
    """Return what the names tell."""
    found = candidates(rig.names)
    body: dict[str, int] = {}
    for side in "RL":
        for limb in _LIMBS:
            _limb(rig, found, side, limb, body)
    _pelvis(rig, found, body)
    _neck_head(rig, found, body)
    _chest(rig, found, body)
    return body


def _limb(rig: Rig, found: Candidates, side: str, limb: _Limb, body: dict[str, int]) -> None:
    """Walk from the trunk outwards; each joint lies below the one before."""
    last: int | None = None
    for joint in limb:
        for index in found["limbs", side, joint]:
            if last is None or rig.beyond(index, last) > 0.0:
                body[side + joint] = last = index
                break
    outer = body.get(side + limb[-1])
    if outer is not None:
        tip = _tip(rig, found["tips", side, _TIPS[limb[-1]]], outer)
        if tip is not None:
            body[side + _TIPS[limb[-1]]] = tip


def _tip(rig: Rig, named: tuple[int, ...], outer: int) -> int | None:
    """Return the joint that tells where a hand, a foot or a head points."""
    for index in named:
        if rig.beyond(index, outer) > rig.nothing:
            return index
    return rig.longest_branch(outer)


def _pelvis(rig: Rig, found: Candidates, body: dict[str, int]) -> None:
    named = found["middle", "", "Pelvis"]
    if not {"RHip", "LHip", "RKnee"} <= body.keys():
        if named:
            body["Pelvis"] = named[0]
        return
    meeting = rig.meeting(body["RHip"], body["LHip"])
    for index in (*named, *([meeting] if meeting is not None else [])):
        if near_hips(rig, index, body):
            body["Pelvis"] = index
            return


def near_hips(rig: Rig, index: int, body: dict[str, int]) -> bool:
    """Tell whether a joint lies about where the hips are."""
    middle = (rig.poses[:, body["RHip"]] + rig.poses[:, body["LHip"]]) / 2
    apart = float(_mean_length(rig.poses[:, index] - middle))
    thigh = rig.distance(body["RHip"], body["RKnee"])
    return apart < _NEAR_PELVIS * thigh and index not in (body["RHip"], body["LHip"])


def _neck_head(rig: Rig, found: Candidates, body: dict[str, int]) -> None:
    """Find neck and head; a head that stands for both (no neck, or in one place) gives its tip."""
    neck, head = (next(iter(found["middle", "", joint]), None) for joint in ("Neck", "Head"))
    tips = found["tips", "", "Head"]
    if head is None:
        head = _tip(rig, tips, neck) if neck is not None else None
    elif neck is None or rig.distance(neck, head) <= rig.nothing:
        tip = _tip(rig, tips, head)
        neck, head = (head, tip) if tip is not None else (neck, head if neck is None else None)
    body |= {joint: index for joint, index in (("Neck", neck), ("Head", head)) if index is not None}


def _chest(rig: Rig, found: Candidates, body: dict[str, int]) -> None:
    """Take the joint where the arms part from the trunk; where all part at the pelvis, a name."""
    taken = set(body.values())
    if {"RShoulder", "LShoulder"} <= body.keys():
        meeting = rig.meeting(body["RShoulder"], body["LShoulder"])
        above_pelvis = rig.above(body["Pelvis"]) if "Pelvis" in body else ()
        if meeting is not None and meeting not in taken and meeting not in above_pelvis:
            body["Chest"] = meeting
            return
    free = (index for index in found["middle", "", "Chest"] if index not in taken)
    first = next(free, None)
    if first is not None:
        body["Chest"] = first


def _no_human(rig: Rig, body: dict[str, int], path: str) -> BodyError:
    missing = [joint for joint in NEEDED if joint not in body]
    return BodyError(
        f"no human skeleton: among {len(rig.names)} joints there is no "
        f"{', '.join(missing)}{_guess(rig, body, missing)}",
        place=path,
        wanted="both hips, and both legs down to the ankles or both arms down to the wrists",
    )


def _guess(rig: Rig, body: dict[str, int], missing: list[str]) -> str:
    """Return a near miss among the names, if there is one."""
    from rapidfuzz import fuzz, process

    taken = set(body.values())
    for joint in missing:
        aliases = tables()["limbs"][joint[1:]]
        for index, (side, name) in enumerate(keys(rig.names)):
            if side == joint[0] and index not in taken:
                best = process.extractOne(name, aliases, scorer=fuzz.ratio)
                if best is not None and best[1] >= _LIKE:
                    return f" (is {rig.names[index]!r} the {joint}?)"
    return ""
