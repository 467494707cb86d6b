"""glTF 2.0 (GL Transmission Format), and GLB, all of it in one file: read, cut, write."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body.mapping import Declared, sampled
from lanindex.errors import CaptureError, UsageError, quoted
from lanindex.formats import gltf_scene, turning
from lanindex.formats.animation import rest_of_axes, turn_to_axes
from lanindex.formats.file import File, Wanted
from lanindex.formats.gltf_scene import (
    BINARY_CHUNK,
    JSON_CHUNK,
    MAGIC,
    TYPES,
    WIDTHS,
    Clock,
    Document,
    Nodes,
    Track,
    Value,
    companions,
    opened_document,
)
from lanindex.formats.people import distinct, is_human, named, others, person, take_doubt
from lanindex.formats.points import BLOCK, Frames, Places, Points, motion_of
from lanindex.formats.rates import given_rate
from lanindex.formats.turning import JointTree
from lanindex.model import Motion, Reading, Span
from lanindex.rotation import rotations

__all__ = ["companions", "cutter", "read", "subjects", "write"]

Floats = NDArray[np.float64]

MOST = 20_000_000  # places of joints in a file that is smaller than four bytes for each
# metres: farther away a place is no number of 32 bits any more, in millimetres
FARTHEST = 1e30
VERTICES, INDICES = 34962, 34963  # what a buffer view of a mesh is for

_KINDS = {width: name for name, width in WIDTHS.items()}
_CODES = {kind: code for code, kind in TYPES.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Performance:
    """Somebody in a take."""

    document: Document  # the file
    nodes: Nodes  # its nodes
    person: JointTree  # whose joints
    take: Value  # the animation
    tracks: list[Track]  # what moves the joints
    clock: Clock  # when frames are

    def placed(self, frames: NDArray[np.int64]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return where joints are in some frames, (T, J, 3), and how they are turned."""
        return placed(self.nodes, self.person.joints, self.tracks, frames)


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read a glTF or GLB file: the joints of a skin, or the nodes that move."""
    found, doubts = chosen(file, options.take)
    whose, ticks = found.person, found.clock
    rate = rate_of(found) if options.rate is None else given_rate(options.rate)
    rest, upright = placed(found.nodes, whose.joints)
    offsets = turning.from_parents(rest[0], whose.parents)
    gaps = unknown(found)
    known = np.ones((ticks.count, len(whose.joints)), np.bool_)
    for joint, spans in gaps.items():
        for start, stop in spans:
            known[start:stop, joint] = False
    every = np.arange(ticks.count)

    def at(frames: Frames, joints: NDArray[np.int64]) -> tuple[NDArray[Any], NDArray[Any]]:
        nodes = [whose.joints[joint] for joint in joints]
        which = every[frames]
        with np.errstate(over="ignore", invalid="ignore"):  # scales in scales: they are refused
            points, turned = placed(found.nodes, nodes, found.tracks, which, upright[0, joints])
        _check(points, [whose.names[joint] for joint in joints], which, file.name)
        if gaps:
            missing = ~known[frames][:, joints]
            points[missing], turned[missing] = np.nan, np.nan
        return points, turned

    places: NDArray[Any] | Places = Places(known, at)
    turns = None
    if ticks.count <= BLOCK:  # at once is faster
        places, turns = at(slice(None), np.arange(len(whose.joints)))
    doubts = (*doubts, *(ticks.doubts if options.rate is None else ()))
    declared = Declared("m", "y")
    about = (rate, declared, whose.parents, offsets, turns, doubts)
    return motion_of(Points(whose.names, places, *about), file, "gltf", options, wanted)


def _check(
    points: NDArray[Any], names: Sequence[str], frames: NDArray[np.int64], path: str
) -> None:
    """Refuse places where nobody is."""
    if not -FARTHEST < points.min() <= points.max() < FARTHEST:
        frame, joint = np.argwhere(~(np.abs(points) < FARTHEST).all(axis=2))[0].tolist()
        where = points[frame, joint].tolist()
        raise CaptureError(
            f"{quoted(names[joint])} is at {where} in frame {frames[frame]}",
            place=path,
            wanted=f"places up to {FARTHEST:g}",
        )


def rate_of(performance: Performance) -> Fraction:
    """Return the rate; a single key tells none, LanIndex's own files do."""
    beside = extras(performance)
    if performance.clock.count == 1 and isinstance(beside.get("rate"), str):
        with suppress(UsageError):
            return given_rate(beside["rate"])
    return performance.clock.rate


def extras(performance: Performance) -> dict[str, Any]:
    """Return what LanIndex wrote beside an animation, if all its frames are there."""
    beside = performance.take.get("extras").value
    fits = isinstance(beside, dict) and beside.get("frames") == performance.clock.count
    return beside if fits else {}


def unknown(performance: Performance) -> dict[int, list[tuple[int, int]]]:
    """Return by joint in which frames LanIndex wrote that its place was unknown."""
    spans_by_name = extras(performance).get("unknown")
    place = {name: joint for joint, name in enumerate(performance.person.names)}
    gaps = dict[int, list[tuple[int, int]]]()
    for name, spans in spans_by_name.items() if isinstance(spans_by_name, dict) else ():
        for span in spans if isinstance(spans, list) and name in place else ():
            if isinstance(span, list) and [type(it) for it in span] == [int, int]:
                gaps.setdefault(place[name], []).append((max(span[0], 0), max(span[1], 0)))
    return gaps


def subjects(file: File) -> tuple[str, ...]:
    """Return the names of the people that a file holds; none where there is one alone."""
    found = performers(opened_document(file), None)
    return tuple(found) if len(found) > 1 else ()


def chosen(file: File, take: str | None) -> tuple[Performance, tuple[str, ...]]:
    """Return who is meant in a file, in which take, and who and what else there is."""
    document = opened_document(file)
    found = performers(document, take)
    name, doubts = person(file, list(found))
    meant, known = found[name], gltf_scene.takes(document)
    read = next(called for called, value in known if value.where == meant.take.where)
    return meant, (*doubts, *take_doubt([called for called, _ in known], read, take))


def performers(document: Document, take: str | None) -> dict[str, Performance]:
    """Return the people of a file by their names; somebody who is not human only where none is."""
    path, known = document.file.name, gltf_scene.takes(document)
    nodes = gltf_scene.nodes_of(document)
    meant = known if take is None else [one for one in known if one[0] == take]
    if not meant:
        raise CaptureError(
            "has no animation" if take is None else f"has no take {quoted(take)}",
            place=path,
            wanted=others(name for name, _ in known) or "an animation of a skeleton",
        )
    moving = [(value, gltf_scene.moved(document, value)) for _, value in meant]
    skeletons = gltf_scene.people(document, nodes, set().union(*(which for _, which in moving)))
    found = list[tuple[str, Performance]]()
    for name, skeleton in skeletons:
        needed = set(above(nodes, skeleton.joints))
        for value, which in moving:
            if which & needed:
                found.append((name, _performance(document, nodes, skeleton, value, needed)))
                break
    if not found:
        raise CaptureError(
            "no animation moves a skeleton", place=path, wanted="one that moves its joints"
        )
    if len(found) > 1:
        found = [one for one in found if _is_human(one[1])] or found[:1]
    numbers = range(1, len(found) + 1)
    names = [name or str(number) for number, (name, _) in zip(numbers, found, strict=True)]
    ones = (one for _, one in found)
    return named(dict(zip(distinct(names, numbers), ones, strict=True)))


def _is_human(performance: Performance) -> bool:
    poses, _ = performance.placed(sampled(performance.clock.count))
    return is_human(performance.person.names, performance.person.parents, poses)


def _performance(
    document: Document, nodes: Nodes, person: JointTree, take: Value, needed: set[int]
) -> Performance:
    found = gltf_scene.tracks(document, take, needed)
    ticks = gltf_scene.clock([track.times for track in found], document.file.name)
    count = ticks.count * len(person.joints)
    if count > max(MOST, len(document.file.content) // 4):
        raise CaptureError(
            f"{ticks.count} frames of {len(person.joints)} joints",
            place=document.file.name,
            wanted="as many as such a file can hold",
        )
    return Performance(document, nodes, person, take, gltf_scene.timed(found, ticks), ticks)


def above(nodes: Nodes, joints: Iterable[int]) -> list[int]:
    """Return joints and all nodes above them, parents before children."""
    needed = turning.ancestry(joints, nodes.parents)
    return [node for node in nodes.order if node in needed]


def placed(
    nodes: Nodes,
    joints: Sequence[int],
    tracks: Sequence[Track] = (),
    frames: NDArray[np.int64] | None = None,
    rest: Floats | None = None,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return positions (T, J, 3) and rotations (T, J, 4) in frames (T,), from rest (J, 4)."""
    by_path = {(track.node, track.path): track for track in tracks}
    shape = 1 if frames is None else len(frames), len(joints)
    kind = np.float64 if rest is None else np.float32
    points, turned = np.empty((*shape, 3), kind), np.empty((*shape, 4), kind)

    def at(node: int, path: str, still: Floats) -> Floats:
        track = by_path.get((node, path))
        return still[None] if track is None or frames is None else track.at(frames)

    def standing(node: int) -> tuple[Floats, Floats, Floats]:
        return (
            at(node, "translation", nodes.shifts[node]),
            at(node, "rotation", nodes.turns[node]),
            at(node, "scale", nodes.scales[node]),
        )

    turning.place(joints, above(nodes, joints), nodes.parents, standing, points, turned, rest)
    return points, turned


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a glTF or GLB file, in the same form.

    A clip has one animation, with a key for each frame from second 0 on, and all else of the file.
    """
    performance, _ = chosen(file, options.take if options else None)
    document = performance.document
    tracks = gltf_scene.timed(gltf_scene.tracks(document, performance.take), performance.clock)
    moving = {(track.node, track.path) for track in performance.tracks}
    first = [(track.node, track.path) in moving for track in tracks].index(True)
    other = {key: value for key, value in document.root.value.items() if key != "animations"}
    rest = _without_animations(document, other)

    def cut(span: Span) -> bytes:
        frames = np.arange(span.start, span.stop)
        pack = rest.copy()
        seconds = np.arange(len(span)) / float(rate_of(performance))
        every = pack.accessor(seconds, bounds=True)
        once = pack.accessor(seconds[:1], bounds=True)
        take = deepcopy(performance.take.value)
        take["samplers"] = []
        for number, track in enumerate(tracks):
            values = track.at(frames, exactly=True)
            values = values[:, [1, 2, 3, 0]] if track.path == "rotation" else values
            values = values.astype(np.float32)
            still = number != first and not (values != values[0]).any()
            values = values[:1] if still else values
            output = pack.accessor(values.reshape(-1, gltf_scene.PATHS.get(track.path, 1)))
            sampler = {"input": once if still else every, "output": output}
            step = {"interpolation": "STEP"} if track.kind == "STEP" else {}
            take["samplers"].append({**sampler, **step})
            take["channels"][number]["sampler"] = number
        take["extras"] = _extras_of(performance, span)
        pack.fill(once)
        root = {**other, "animations": [take], **pack.description()}
        if document.is_glb:
            return glb(root, pack)
        data = base64.b64encode(b"".join(pack.parts)).decode()
        root["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{data}"
        return json.dumps(root, allow_nan=False).encode()

    return cut


def _without_animations(document: Document, other: dict[str, Any]) -> Pack:
    """Lay down the numbers of a file that are not of its animations, `other` its JSON but these."""
    free = sorted(_samplers(document) - _accessors(other))
    accessors: list[Any] = deepcopy(other.get("accessors") or [])
    others = [one for number, one in enumerate(accessors) if number not in set(free)]
    used = {
        it["bufferView"]
        for it in _objects([others, {**other, "accessors": None}])
        if isinstance(it.get("bufferView"), int)
    }
    views: list[Any] = deepcopy(other.get("bufferViews") or [])
    unused = [number for number in range(len(views)) if number not in used]
    pack = Pack(views, accessors, unused[::-1], free[::-1])
    for number in sorted(used):
        where = Value(number, "a bufferView", document.file.name)
        buffer, first, length, _ = document.view(where)
        views[number] |= pack.lay(document.bytes(buffer, first, first + length))
    return pack


def _extras_of(performance: Performance, span: Span) -> dict[str, Any]:
    """Return what stands beside the animation, of some frames."""
    old = performance.take.get("extras").value
    beside = dict(old) if isinstance(old, dict) else {}
    beside |= {"frames": len(span), "rate": str(rate_of(performance))}
    if "unknown" in extras(performance):
        beside["unknown"] = {
            performance.person.names[joint]: [
                [max(start, span.start) - span.start, min(stop, span.stop) - span.start]
                for start, stop in gaps
                if start < span.stop and stop > span.start
            ]
            for joint, gaps in unknown(performance).items()
        }
    return beside


def _samplers(document: Document) -> set[int]:
    """Return the accessors that animations use."""
    found = set()
    accessors = document.root.get("accessors")
    for take in document.root.get("animations"):
        for sampler in take.get("samplers"):
            found |= {sampler.get(end).one_of(accessors) for end in ("input", "output")}
    return found


def _objects(value: Any) -> Iterator[dict[str, Any]]:
    """Yield the objects anywhere in JSON."""
    waiting = [value]
    while waiting:
        one = waiting.pop()
        if isinstance(one, dict):
            yield one
            waiting.extend(one.values())
        elif isinstance(one, list):
            waiting.extend(one)


def _accessors(value: Any) -> set[int]:
    """Return the accessors that meshes, skins and extensions use."""
    found = list[Any]()
    for one in _objects(value):
        found += [one.get("indices"), one.get("inverseBindMatrices")]
        for name in ("attributes", "targets"):
            within = one.get(name)
            for part in within if isinstance(within, list) else [within]:
                found += part.values() if isinstance(part, dict) else ()
    return {number for number in found if isinstance(number, int)}


@dataclass(slots=True)
class Pack:
    """Numbers, and the accessors and buffer views that tell of them."""

    views: list[Any] = field(default_factory=list)
    accessors: list[Any] = field(default_factory=list)
    free_views: list[int] = field(default_factory=list)  # those that may be overwritten
    free_accessors: list[int] = field(default_factory=list)
    size: int = 0  # bytes
    parts: list[bytes | memoryview] = field(default_factory=list)

    def copy(self) -> Pack:
        """Return the same once more."""
        free = (list(self.free_views), list(self.free_accessors))
        return Pack(list(self.views), list(self.accessors), *free, self.size, list(self.parts))

    def description(self) -> dict[str, Any]:
        """Return what the JSON says of the numbers."""
        buffers = [{"byteLength": self.size}]
        return {"accessors": self.accessors, "bufferViews": self.views, "buffers": buffers}

    def fill(self, number: int) -> None:
        """Let what is free yet be the same as an accessor."""
        entry = self.accessors[number]
        for free in self.free_accessors:
            self.accessors[free] = entry
        for free in self.free_views:
            self.views[free] = self.views[entry["bufferView"]]

    def lay(self, data: bytes | memoryview) -> dict[str, int]:
        """Lay bytes behind the others; return where, as a buffer view tells it."""
        gap = -self.size % 4
        self.parts += [b"\0" * gap, data]
        place = {"buffer": 0, "byteOffset": self.size + gap, "byteLength": len(data)}
        self.size += gap + len(data)
        return place

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
        view = self.lay(rows.tobytes()) | ({} if target is None else {"target": target})
        entry: dict[str, Any] = {
            "bufferView": _place_item(self.views, view, self.free_views),
            "componentType": _CODES[kind],
            "count": len(rows),
            "type": _KINDS[rows.shape[1]],
        }
        if bounds:
            entry |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        return _place_item(self.accessors, entry, self.free_accessors)


def _place_item(items: list[Any], item: Any, free: list[int]) -> int:
    """Put an item into a free place, else behind the others; return its number."""
    if free:
        items[free[-1]] = item
        return free.pop()
    items.append(item)
    return len(items) - 1


def glb(root: dict[str, Any], pack: Pack) -> bytes:
    """Return a GLB of its JSON and its numbers."""
    data = b"".join(pack.parts)
    text = json.dumps(root, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    rest = -len(data) % 4
    binary = struct.pack("<I4s", len(data) + rest, BINARY_CHUNK) if data else b""
    size = 20 + len(text) + len(binary) + (len(data) + rest)
    head = struct.pack("<4sIII4s", MAGIC, 2, size, len(text), JSON_CHUNK)
    return b"".join((head, text, binary, data, b"\0" * rest))


METRE = 1000.0  # millimetres
RIGID = 0.005  # millimetres by which a bone may change its length and still not move in its parent
WRONG = 0.2  # of a bone's length: what the skeleton's may be off by and still tell the rest pose
STILL = 1e-7  # what a quaternion's numbers may change by where a joint does not turn
WIDTH = 0.08  # half of a bone's thickness, of its length
RING = 0.15  # where it is thickest, of its length
TIP = 0.02  # metres that the last joint of a limb is shown by


def write(motion: Motion) -> bytes:
    """Write a motion of one root without gaps as GLB: m, y up, an octahedron for each bone.

    A joint rotates as the motion says, else from the rest pose (`lanindex.rotation`), or from the
    first frame if lengths of bones contradict the rest pose.
    """
    skeleton = motion.skeleton
    parents = skeleton.parents.astype(int)
    points = motion.positions.astype(np.float64)
    turns, offsets = _rotations_from_rest(motion, points, parents)
    ways, turned = _local_transforms(points, turns, parents)
    pack = Pack()
    children = [np.flatnonzero(parents == joint).tolist() for joint in range(len(parents))]
    nodes: list[dict[str, Any]] = [
        {"name": name, "translation": offset, **({"children": below} if below else {})}
        for name, offset, below in zip(
            skeleton.names, (offsets / METRE).astype(np.float32).tolist(), children, strict=True
        )
    ]
    nodes.append({"name": "bones", "mesh": 0, "skin": 0})
    standing = offsets / METRE  # at rest
    for joint, parent in enumerate(parents.tolist()):
        if parent >= 0:
            standing[joint] += standing[parent]
    mesh = _mesh(pack, standing, parents.tolist())
    animation = _animation(pack, motion, ways / METRE, turned, offsets / METRE)
    animation["extras"] = {"frames": len(motion), "rate": str(motion.rate)}
    binding = np.tile(np.eye(4), (len(parents), 1, 1))  # from the mesh into each joint's own axes
    binding[:, 3, :3] = -standing  # column after column
    joints = {"joints": list(range(len(parents))), "inverseBindMatrices": pack.accessor(binding)}
    root = {
        "asset": {"version": "2.0", "generator": "LanIndex"},
        "scene": 0,
        "scenes": [{"nodes": [0, len(nodes) - 1]}],
        "nodes": nodes,
        "meshes": [mesh],
        "skins": [joints],
        "animations": [animation],
        **pack.description(),
    }
    return glb(root, pack)


def _rotations_from_rest(
    motion: Motion, points: Floats, parents: NDArray[np.int_]
) -> tuple[Floats, Floats]:
    """Return how joints are turned from rest, (T, J, 4), and the offsets at rest."""
    offsets = motion.skeleton.offsets.astype(np.float64)
    if motion.rotations is not None:
        turns = motion.rotations.astype(np.float64)
        known = np.isfinite(turns).all(axis=2)
        last = np.maximum.accumulate(np.where(known, np.arange(len(turns))[:, None], 0), axis=0)
        held = np.take_along_axis(turns, last[..., None], axis=0)
        return turning.unit(np.nan_to_num(held)), offsets
    below = np.flatnonzero(parents >= 0)
    now = np.median(np.linalg.norm(points[:, below] - points[:, parents[below]], axis=2), axis=0)
    rest = np.linalg.norm(offsets[below], axis=1)
    if (np.abs(rest - now) > WRONG * now + RIGID).any():
        pose = points[min(motion.first, len(points) - 1)]
        offsets = turning.from_parents(pose, parents.tolist())
    turns = np.empty((*points.shape[:2], 4))
    some = points[sampled(len(points))] if motion.axes else points[:0]
    rest = rest_of_axes(motion, offsets, rotations(some, offsets, parents)) if motion.axes else {}
    for start in range(0, len(points), BLOCK):
        part = slice(start, start + BLOCK)
        block = rotations(points[part], offsets, parents)
        turn_to_axes(rest, motion.axes, part, block)
        turns[part] = turning.quaternions(block)
    return turns, offsets


def _local_transforms(
    points: Floats, turns: Floats, parents: NDArray[np.int_]
) -> tuple[Floats, Floats]:
    """Return where joints are and how they are turned as their parents see it."""
    ways, turned = points.copy(), turns.copy()
    for joint, parent in enumerate(parents.tolist()):
        if parent < 0:
            continue
        back = turning.inverse(turns[:, parent])
        way = points[:, joint] - points[:, parent]
        ways[:, joint] = np.einsum("tij,tj->ti", turning.matrices(back), way)
        turned[:, joint] = turning.product(back, turns[:, joint])
    return ways, turning.without_flips(turning.unit(turned))


def _animation(
    pack: Pack, motion: Motion, shifts: Floats, turned: Floats, offsets: Floats
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
        way, turn = shifts[:, joint], turned[:, joint][:, [1, 2, 3, 0]]
        if joint == 0 or np.abs(way - np.float32(offsets[joint])).max() > RIGID / METRE:
            still = joint > 0 and np.ptp(way, axis=0).max() <= RIGID / METRE
            track(joint, "translation", way, still)
        track(joint, "rotation", turn, np.ptp(turn, axis=0).max() <= STILL)
    return {"name": "capture", "channels": channels, "samplers": samplers}


def _mesh(pack: Pack, standing: Floats, parents: Sequence[int]) -> dict[str, Any]:
    corners, joints, faces = octahedra(standing, parents)
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


_FACES = np.array(
    [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 1, 4], [5, 1, 2], [5, 2, 3], [5, 3, 4], [5, 4, 1]]
)


def octahedra(
    places: Floats, parents: Sequence[int]
) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """Return bones as octahedra: corners (6 B, 3), the joint of each, and faces (8 B, 3)."""
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
