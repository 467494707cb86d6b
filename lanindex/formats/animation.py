"""What animation files need of a motion: one skeleton without gaps, heads and hands turned.

- Joints that hang on no other are hung where a body has them. Without a hierarchy, joints that
  are not of the body are left out, and so are joints that are never known.
- A joint that is unknown for a while goes straight from its last place to its next, and stays
  where it is known first or last at the ends.
- A skeleton that was put together stands at rest as `lanindex.body.rest_pose` says.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.body import sampled
from lanindex.body.axes import rest_axes, rest_palms, seen_axes
from lanindex.body.mapping import skeleton_of
from lanindex.body.rest_pose import parents_of, rest_offsets
from lanindex.errors import ExportError
from lanindex.formats.points import usual
from lanindex.model import Motion, Skeleton

Floats = NDArray[np.float64]


def complete(motion: Motion) -> Motion:
    """Return a motion of one skeleton in which every joint is known in every frame."""
    unknown = _unknown(motion)
    roots = int((motion.skeleton.parents < 0).sum())
    if roots == 1 and not unknown.any():
        return motion
    if roots > 1:
        motion = _connected_body(motion)
        unknown = _unknown(motion)
    never: NDArray[np.bool_] = np.logical_and.reduce(unknown, axis=0)
    if never.any():
        motion, unknown = _without_joints(motion, never), unknown[:, ~never]
    if not unknown.any():
        return motion
    places = without_gaps(motion.positions)
    said = f"{unknown.mean():.1%} of its places are unknown: they are filled in straight lines"
    rotations = motion.rotations
    if rotations is not None and not np.isfinite(rotations).all():
        rotations = None
    return replace(motion, positions=places, rotations=rotations, warnings=(*motion.warnings, said))


def without_gaps(places: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return places, (T, J, 3), in straight lines where a joint is unknown for a time."""
    places, frames = places.copy(), np.arange(len(places))
    unknown = np.asarray(~np.isfinite(places).all(axis=2))
    for joint in np.flatnonzero(unknown.any(axis=0) & ~unknown.all(axis=0)).tolist():
        known = ~unknown[:, joint]
        for axis in range(3):
            places[:, joint, axis] = np.interp(frames, frames[known], places[known, joint, axis])
    return places


def _unknown(motion: Motion) -> NDArray[np.bool_]:
    """Return which joints are unknown in which frames, (T, J)."""
    return np.asarray(~np.isfinite(motion.positions).all(axis=2))


def _connected_body(motion: Motion) -> Motion:
    """Return the joints of the body, hung on each other."""
    found = {
        joint: motion.positions[:, index].astype(np.float64)
        for joint, index in zip(JOINTS, motion.skeleton.body.tolist(), strict=True)
        if index >= 0 and np.isfinite(motion.positions[:, index]).all(axis=1).any()
    }
    if "Pelvis" not in found and {"RHip", "LHip"} <= found.keys():
        found["Pelvis"] = (found["RHip"] + found["LHip"]) / 2
    found = {joint: found[joint] for joint in JOINTS if joint in found}
    if len(found) < 2:
        raise ExportError("no body to speak of", place=motion.source.path, wanted="two joints")
    names = list(found)
    parents = np.array(parents_of(names), np.int16)
    parents[1:][parents[1:] < 0] = 0
    played = np.full(len(JOINTS), -1, np.int16)
    played[[JOINT_CODES[joint] for joint in names]] = np.arange(len(names))
    offsets = rest_offsets(found).astype(np.float32)
    for number in np.flatnonzero(np.array(parents_of(names)) < 0).tolist()[1:]:
        offsets[number] = usual(found[names[number]] - found[names[0]])
    skeleton = Skeleton(tuple(names), parents, offsets, played)
    places = np.stack([found[joint] for joint in names], axis=1).astype(np.float32)
    return replace(motion, skeleton=skeleton, positions=places, rotations=None, markers=None)


def _without_joints(motion: Motion, omitted: NDArray[np.bool_]) -> Motion:
    """Leave joints out; what hangs on them hangs on the nearest above that stays, or the first."""
    kept = np.flatnonzero(~omitted)
    skeleton = skeleton_of(motion.skeleton, kept)
    parents = skeleton.parents.copy()
    parents[1:][parents[1:] < 0] = 0
    skeleton = replace(skeleton, parents=parents)
    turns = None if motion.rotations is None else motion.rotations[:, kept]
    places = motion.positions[:, kept]
    return replace(motion, skeleton=skeleton, positions=places, rotations=turns)


def axes_at_rest(
    names: tuple[str, ...],
    parents: Sequence[int],
    offsets: Any,
    body: NDArray[np.int16],
    poses: Floats,
    turned: Callable[[int], Floats],
) -> dict[str, tuple[int, Floats]]:
    """Return by hand and head the joint that it turns with, and its axes at rest, (2, 3)."""
    found = rest_palms(names, parents, offsets, body)
    head = int(body[JOINT_CODES["Head"]])
    if head >= 0:
        rest = rest_axes(parents, offsets, body)
        if rest is None:
            rest = seen_axes(parents, body, poses, turned)
        if rest is not None:
            found["Head"] = head, rest
    return found


def rest_of_axes(
    motion: Motion, offsets: NDArray[Any], turned: Floats
) -> dict[str, tuple[int, Floats]]:
    """Return `axes_at_rest` of what has axes in a motion, by sampled rotations (S, J, 3, 3)."""
    skeleton = motion.skeleton
    poses = motion.positions[sampled(len(motion))].astype(np.float64)
    parents = skeleton.parents.tolist()
    found = axes_at_rest(
        skeleton.names, parents, offsets, skeleton.body, poses, lambda joint: turned[:, joint]
    )
    return {name: it for name, it in found.items() if name in motion.axes}


def turn_to_axes(
    rest: Mapping[str, tuple[int, Floats]],
    axes: Mapping[str, NDArray[np.float32]],
    frames: slice,
    turns: Floats,
) -> None:
    """Turn joints as far as axes tell it, in place."""
    for name, (joint, own) in rest.items():
        there = axes[name][frames].astype(np.float64)
        known = np.isfinite(there).all(axis=(1, 2))
        then = np.swapaxes(_frames(own[None]), 1, 2)
        turns[known, joint] = _frames(there[known]) @ then


def _frames(axes: Floats) -> Floats:
    """Return two axes and what is at right angles to them, exactly, as the columns of (T, 3, 3)."""
    first, third = axes[:, 0], np.cross(axes[:, 0], axes[:, 1])
    first, third = (it / np.linalg.norm(it, axis=1, keepdims=True) for it in (first, third))
    return np.stack((first, np.cross(third, first), third), axis=2)
