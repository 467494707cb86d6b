"""Motion to BVH: a hierarchy, and how its joints turn."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from lanindex.body import sampled
from lanindex.errors import ExportError
from lanindex.formats.animation import rest_of_axes, turn_to_axes
from lanindex.formats.points import END
from lanindex.model import Motion, Skeleton
from lanindex.rotation import euler, rotations

Floats = NDArray[np.float64]

UNIT = 10.0
"""Millimetres in the file's unit, a centimetre."""

RIGID = 0.02
"""Millimetres: what bones may change their lengths by in a file of rotations alone."""

DEEPEST = 200
"""Joints that hang on each other in a row; each is written a step further to the right."""

ROTATIONS = "Zrotation Xrotation Yrotation"
POSITIONS = "Xposition Yposition Zposition"


def write(motion: Motion) -> bytes:
    """Write a motion as BVH, in centimetres, with the motion's own axes.

    Joints turn from the rest pose of the skeleton (see `lanindex.rotation`). Where bones change
    their lengths every joint has position channels too, which stand in for its OFFSET; only an
    End Site cannot have them.
    """
    skeleton, points = motion.skeleton, motion.positions.astype(np.float64)
    _check(motion, points)
    turns = rotations(points, skeleton.offsets.astype(float), skeleton.parents.astype(int))
    if motion.axes:
        rest = rest_of_axes(motion, skeleton.offsets, turns[sampled(len(motion))])
        turn_to_axes(rest, motion.axes, slice(None), turns)
    places, angles = _channels(points, turns, skeleton.parents.astype(int))
    stiff = bool(np.abs(places[:, 1:] - skeleton.offsets[1:]).max(initial=0) <= RIGID)
    ends = _ends(skeleton)
    columns = [
        values[:, joint]
        for joint in _downwards(skeleton, 0)
        if joint not in ends
        for values in ((angles,) if stiff and joint else (places / UNIT, angles))
    ]
    lines = chain(
        ["HIERARCHY", *_hierarchy(skeleton, 0, ends, stiff)],
        ["MOTION", f"Frames: {len(motion)}", f"Frame Time: {float(1 / motion.rate):.9g}"],
        (" ".join(map(_short, row)) for row in np.concatenate(columns, axis=1).tolist()),
    )
    return ("\n".join(lines) + "\n").encode()


def _channels(points: Floats, turns: Floats, parents: NDArray[np.int_]) -> tuple[Floats, Floats]:
    """Return each joint's place as its parent sees it, mm, and its own angles, degrees."""
    world = np.broadcast_to(np.eye(3), (len(points), 1, 3, 3))
    above = np.concatenate([world, turns], axis=1)[:, parents + 1]
    places = points.copy()
    places[:, 1:] -= points[:, parents[1:]]
    places = np.einsum("tjki,tjk->tji", above, places)
    return places, euler(np.swapaxes(above, 2, 3) @ turns)


def _check(motion: Motion, points: Floats) -> None:
    place, names = motion.source.path, motion.skeleton.names
    roots = [name for name, up in zip(names, motion.skeleton.parents, strict=True) if up < 0]
    if roots != [names[0]]:
        raise ExportError(
            f"the roots {', '.join(roots)}", place=place, wanted="one, the first joint"
        )
    deep = [0] * len(names)
    for joint, parent in enumerate(motion.skeleton.parents.tolist()):
        deep[joint] = deep[parent] + 1 if parent >= 0 else 1
    if max(deep) > DEEPEST:
        found = f"{max(deep)} joints, each on the one before"
        raise ExportError(found, place=place, wanted=f"{DEEPEST} at most in a BVH file")
    unknown = np.argwhere(~np.isfinite(points))
    if len(unknown):
        found = f"{names[unknown[0][1]]} is unknown in frame {unknown[0][0]}"
        raise ExportError(found, place=place, wanted="every joint in every frame")


def _ends(skeleton: Skeleton) -> set[int]:
    """Return the joints that are the End Sites of their parents."""
    parents = skeleton.parents.tolist()
    return {
        joint
        for joint, parent in enumerate(parents)
        if skeleton.names[joint].endswith(END)
        and joint not in parents
        and parents.count(parent) == 1
    }


def _downwards(skeleton: Skeleton, joint: int) -> Iterator[int]:
    """Yield a joint and all below it, in the order in which a file has them."""
    yield joint
    for child in np.flatnonzero(skeleton.parents == joint).tolist():
        yield from _downwards(skeleton, child)


def _hierarchy(skeleton: Skeleton, joint: int, ends: set[int], stiff: bool) -> Iterator[str]:
    """Yield the lines of a joint and of all below it."""
    offset = " ".join(_short(float(value) / UNIT) for value in skeleton.offsets[joint])
    if joint in ends:
        yield from ("End Site", "{", f"\tOFFSET {offset}", "}")
        return
    name = skeleton.names[joint]
    yield f"JOINT {name}" if joint else f"ROOT {name}"
    yield "{"
    yield f"\tOFFSET {offset}" if joint else "\tOFFSET 0 0 0"
    few = stiff and joint
    yield f"\tCHANNELS 3 {ROTATIONS}" if few else f"\tCHANNELS 6 {POSITIONS} {ROTATIONS}"
    children = np.flatnonzero(skeleton.parents == joint).tolist()
    for child in children:
        yield from (f"\t{line}" for line in _hierarchy(skeleton, child, ends, stiff))
    if not children:
        yield from ("\tEnd Site", "\t{", "\t\tOFFSET 0 0 0", "\t}")
    yield "}"


def _short(value: float) -> str:
    """Write a number with four places at most."""
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
