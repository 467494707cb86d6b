"""FBX (Autodesk FilmBox), by ``ufbx`` (extra ``fbx``): read.

``ufbx`` 0.0.5 reads all of FBX, pivots, layers and both encodings, and is kept up by the author of
the C library, which is MIT or public domain; but the wheel states no licence, and its Python side
is young: asking it in an ordinary way for an animated element ends the process. So it is never
loaded here, but in a child process that asks little, and whose end is an error like others.
"""

import json
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body.mapping import Declared, sampled
from lanindex.errors import CaptureError
from lanindex.formats import turning
from lanindex.formats.file import File, Wanted
from lanindex.formats.people import distinct, is_human, named, others, person, take_doubt
from lanindex.formats.points import Points, motion_of
from lanindex.formats.rates import given_rate, nearest_rate
from lanindex.formats.turning import JointTree
from lanindex.model import Motion, Reading

MOST = 20_000_000  # nodes times frames that are looked at
TIMEOUT = 600  # seconds that a file may take
WIDTH = 10  # numbers of a node: shift, turn (w, x, y, z), scale
METRES = {0.001: "mm", 0.01: "cm", 1.0: "m", 0.0254: "inch"}  # units by their metres
AXES = ("x", "-x", "y", "-y", "z", "-z")
BLOCK = 2048  # frames that are turned at a time

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """An FBX file in one of its takes."""

    answer: Mapping[str, Any]  # what `fbx_child` answers, as JSON
    still: Floats  # (N, 10), the nodes while nothing moves them
    moving: Mapping[int, Floats]  # (T, 10) by node, those that move

    @property
    def parents(self) -> list[int]:
        """The node that each is in, -1 for the root."""
        return [parent for _, parent, _ in self.answer["nodes"]]


def run_child(file: File, take: str | None) -> Scene:
    """Have an FBX file read."""
    if find_spec("ufbx") is None:
        raise CaptureError(
            "FBX is read by a package that is not installed",
            place=file.name,
            wanted="ufbx",
            remedy="Install it: pip install 'lanindex[fbx]'",
        )
    query = json.dumps({"take": take, "most": max(MOST, len(file.content) // 4)})
    command = [sys.executable, "-P", str(Path(__file__).with_name("fbx_child.py"))]
    try:
        done = subprocess.run(
            command,
            input=b"%s\n%b" % (query.encode(), file.content[:]),
            capture_output=True,
            timeout=TIMEOUT,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise _unreadable(file, f"took ufbx more than {TIMEOUT} seconds") from None
    line, _, numbers = done.stdout.partition(b"\n")
    if done.returncode or not line:
        raise _unreadable(file, f"ended ufbx ({done.returncode})")
    answer = json.loads(line)
    if "error" in answer:
        raise _unreadable(file, f"ufbx says {answer['error']}")
    if answer["take"] < 0:
        _no_take(file, answer, take)
    return _scene(answer, np.frombuffer(numbers).reshape(-1, WIDTH), file)


def _unreadable(file: File, found: str) -> CaptureError:
    return CaptureError(
        found,
        place=file.name,
        wanted="an FBX file of version 6 or later that is whole",
        remedy="Export it again, or as BVH or GLB.",
    )


def _no_take(file: File, answer: Mapping[str, Any], take: str | None) -> None:
    if answer.get("count", 0) < 0:
        found, wanted = "has more frames than such a file can hold", "frames of an hour or so"
    elif not answer["takes"]:
        found, wanted = "has no animation", "an animation of a skeleton"
    elif take is None:
        found, wanted = "no take moves anything", "one that moves a skeleton"
    else:
        found, wanted = f"has no take {take!r}", others(answer["takes"])
    raise CaptureError(found, place=file.name, wanted=wanted)


def _scene(answer: Mapping[str, Any], numbers: Floats, file: File) -> Scene:
    """Share the numbers out among the nodes."""
    count, moved = answer["count"], set(answer["moved"])
    still = np.empty((len(answer["nodes"]), WIDTH))
    moving = dict[int, Floats]()
    at = 0
    for node in range(len(still)):
        still[node] = numbers[at]
        at += 1
        if node in moved:
            moving[node] = numbers[at : at + count]
            at += count
    if at != len(numbers) or not (np.abs(numbers) < 1e12).all():
        raise _unreadable(file, "has places that are not finite")
    return Scene(answer, still, moving)


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read an FBX file: the bones of one person and the nodes below them, at the file's rate."""
    scene = file.once(_first_take) if options.take is None else run_child(file, options.take)
    found = _people(scene)
    if not found:
        raise CaptureError("has no skeleton", place=file.name, wanted="bones that move")
    name, doubts = person(file, list(found))
    whose, takes = found[name], scene.answer["takes"]
    rest, upright = _pose(scene, whose, None)
    offsets = turning.from_parents(rest[0], whose.parents)
    count, size = scene.answer["count"], 1.0
    declared = _declared(scene, file)
    if declared.unit is None:
        size, declared = scene.answer["metres"], Declared("m", declared.up)
    places = np.empty((count, len(whose.joints), 3), np.float32)
    turns = np.empty((count, len(whose.joints), 4), np.float32)
    back = turning.inverse(upright)
    for start in range(0, count, BLOCK):
        frames = np.arange(start, min(start + BLOCK, count))
        points, turned = _pose(scene, whose, frames)
        places[frames], turns[frames] = points * size, turning.product(turned, back)
    rate = nearest_rate(Fraction(scene.answer["rate"]).limit_denominator(10**6))
    read_take = takes[scene.answer["take"]]
    points_of = Points(
        whose.names,
        places,
        rate if options.rate is None else given_rate(options.rate),
        declared,
        whose.parents,
        offsets * size,
        turns,
        (*doubts, *take_doubt(takes, read_take, options.take)),
    )
    return motion_of(points_of, file, "fbx", options, wanted)


def subjects(file: File) -> tuple[str, ...]:
    """Return the names of the people that a file holds; none where there is one alone."""
    found = _people(file.once(_first_take))
    return tuple(found) if len(found) > 1 else ()


def _first_take(file: File) -> Scene:
    return run_child(file, None)


def _declared(scene: Scene, file: File) -> Declared:
    """Return unit and vertical axis."""
    right, up, front = scene.answer["axes"]
    if not all(0 <= axis < len(AXES) for axis in (right, up, front)):
        return Declared(_unit(scene.answer["metres"]))
    across = np.cross(_axis(right), _axis(up))
    if across @ _axis(front) < 0:
        raise CaptureError(
            "has left-handed axes",
            place=file.name,
            wanted="right-handed ones",
            remedy="Export it again so.",
        )
    return Declared(_unit(scene.answer["metres"]), AXES[up])


def _axis(code: int) -> Floats:
    direction: Floats = np.eye(3)[code // 2] * (1 - 2 * (code % 2))
    return direction


def _unit(metres: float) -> str | None:
    return next((unit for size, unit in METRES.items() if abs(metres / size - 1) < 1e-6), None)


def _people(scene: Scene) -> dict[str, JointTree]:
    """Return the skeletons by their names; those that are not human only if none is.

    Bones under one node are one skeleton, under the root each top bone its own. Without bones, all
    nodes that show nothing take their place.
    """
    nodes, parents = scene.answer["nodes"], scene.parents
    kinds = [kind for *_, kind in nodes]
    boned = "bone" in kinds
    owner = dict[int, int]()
    members = dict[int, list[int]]()
    for node, (_, parent, kind) in enumerate(nodes):
        if parent in owner and kind != "shown":
            owner[node] = owner[parent]
        elif kind == "bone" or (not boned and kind == "node" and parent >= 0):
            owner[node] = parent if boned and parent > 0 else node
        if node in owner and kind != "helper":
            members.setdefault(owner[node], []).append(node)
    moved = set(scene.moving)
    names = [name for name, *_ in nodes]
    helpers = {node for node, kind in enumerate(kinds) if kind == "helper"}
    found = list[tuple[str, JointTree]]()
    for top, joints in members.items():
        if moved & turning.ancestry(joints, parents):
            space, colon, _ = names[joints[0]].rpartition(":")
            tree = turning.joint_tree(joints, names, parents, helpers)
            found.append((space if colon else names[top], tree))

    def human(whose: JointTree) -> bool:
        poses, _ = _pose(scene, whose, sampled(scene.answer["count"]))
        return is_human(whose.names, whose.parents, poses)

    if len(found) > 1:
        found = [one for one in found if human(one[1])] or found[:1]
    called = distinct([name for name, _ in found], range(1, len(found) + 1))
    return named(dict(zip(called, (one for _, one in found), strict=True)))


def _pose(
    scene: Scene, whose: JointTree, frames: NDArray[np.int64] | None
) -> tuple[Floats, Floats]:
    """Return where joints are in some frames and how they are turned; at rest without any."""
    moving: Mapping[int, Floats] = {} if frames is None else scene.moving

    def standing(node: int) -> tuple[Floats, Floats, Floats]:
        rows = moving[node][frames] if node in moving else scene.still[node][None]
        return rows[:, :3], turning.unit(rows[:, 3:7]), rows[:, 7:]

    order = sorted(turning.ancestry(whose.joints, scene.parents))
    shape = 1 if frames is None else len(frames), len(whose.joints)
    points, turned = np.empty((*shape, 3)), np.empty((*shape, 4))
    turning.place(whose.joints, order, scene.parents, standing, points, turned)
    return points, turned
