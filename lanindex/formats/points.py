"""Points by name → Motion: what every format without a hierarchy of turning joints has in common.

A reader tells the names, where they are, and what the file says of itself; here it is found out
which of them are joints, or what joints the markers make, in which unit, which way up.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.body import BodyMapping, Declared, body_of, map_body
from lanindex.body.axes import axes_of, measured_palms, planes, rest_palms, seen_palms, turned
from lanindex.body.calibration import BEGINNING, UNITS, unit_of
from lanindex.body.mapping import LONGEST_GAP, POSES, read_body_file
from lanindex.body.markers import Clusters, MarkerSet, marker_set_of
from lanindex.body.rest_pose import parents_of, rest_offsets
from lanindex.errors import BodyError
from lanindex.formats.file import Content, File, Wanted, several
from lanindex.formats.rates import rate_doubt
from lanindex.model import Markers, Motion, Reading, Skeleton, Source

Floats = NDArray[np.float64]
Frames = slice | NDArray[np.int64]

BLOCK = 2048
"""Frames that are turned and scaled at a time."""

END = " End"
"""Ends the name of the joint where a bone without a child ends."""

REACH = 1600.0
"""Millimetres that the markers of a body reach over, about: it tells the unit where nobody does."""


SAMPLED = 512
"""Frames that tell how long bones are."""

_FIRST = 2 * BEGINNING
"""Frames among which a calibration pose and the fall from it are."""


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Places that are worked out where they are asked for, not held: those of a long animation."""

    known: NDArray[np.bool_]  # (T, M) bool: where they are
    # gives (t, K, 3) places, units and axes of the file, and (t, K, 4) rotations or None, by frames
    # (a slice, or numbers) and by the numbers of points
    at: Callable[[Frames, NDArray[np.int64]], tuple[NDArray[Any], NDArray[Any] | None]]

    def __len__(self) -> int:
        return len(self.known)


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """What a file tells of points."""

    names: tuple[str, ...]  # (M) as the file has them
    # (T, M, 3) float, units and axes of the file; NaN where unknown. Of markers in float32 it
    # becomes the motion's: what it holds is turned and scaled in place. Or what tells them of a
    # file with a hierarchy, rotations included.
    places: NDArray[Any] | Places
    rate: Fraction  # frames a second
    declared: Declared = field(default_factory=Declared)  # what the file says of itself
    # (M) where the file has a hierarchy: parents before children, -1 for a root
    parents: tuple[int, ...] | None = None
    # (M, 3) from each joint's parent, at rest; None: the median
    offsets: NDArray[Any] | None = None
    # (T, M, 4) from each joint's rest to the world, (w, x, y, z), axes of the file
    rotations: NDArray[Any] | None = None
    doubts: tuple[str, ...] = ()  # what the reader found doubtful
    palms_down: bool = False  # whether the format says that at rest palms face down


def spread(wanted: Wanted, count: int) -> NDArray[np.int64]:
    """Return the frames to read, (T,): which are wanted, and others that tell what points are of.

    These are the first ones, and some of all.
    """
    every = np.arange(count)
    if wanted.frames is None:
        return every
    some = np.linspace(0, count - 1, min(count, SAMPLED)).astype(np.int64)
    return np.unique(np.concatenate([every[:_FIRST], some, every[slice(*wanted.frames)]]))


def gathered(content: Content, pieces: NDArray[np.int64]) -> tuple[bytes, NDArray[np.int64]]:
    """Return stretches of a file, (T, 2) and rising, laid end to end, and where they are then."""
    apart = np.flatnonzero(pieces[1:, 0] != pieces[:-1, 1]) + 1
    runs = zip(pieces[[0, *apart], 0].tolist(), pieces[[*(apart - 1), -1], 1].tolist(), strict=True)
    stops = np.cumsum(pieces[:, 1] - pieces[:, 0])
    data = b"".join(several(content, list(runs)))
    return data, np.stack((stops - (pieces[:, 1] - pieces[:, 0]), stops), axis=1)


def motion_of(points: Points, file: File, form: str, options: Reading, wanted: Wanted) -> Motion:
    """Return a motion of points."""
    marker_set = _marker_set(points.names, options) if points.parents is None else None
    names = points.names
    if marker_set is not None:
        names = marker_set.joints
        points = replace(points, declared=replace(points.declared, body=_body_by_name(names)))
    places = _places(points, marker_set, options)
    mapping = _mapping(names, places, points, options, file.name)
    skeleton, order = _skeleton(names, places, points, mapping)
    full_skeleton = skeleton
    if wanted.body_only:
        kept, skeleton = body_of(skeleton)
        order = order[kept]
    gaps = _gaps(places.known[:, mapping.body[mapping.body >= 0]], points.rate)
    positions, rotations = _oriented(mapping, places, order)
    turns = None
    if rotations is not None:
        turns = partial(_turns, order=order, rotations=rotations, places=places, mapping=mapping)
    del places  # of a long capture of markers a part of the memory
    palm_axes = _axes(points, marker_set, turns, mapping, full_skeleton, skeleton.body, positions)
    axes, made_up = measured_palms(
        axes_of(skeleton, rotations) | palm_axes, positions, skeleton.body
    )
    markers = None
    if marker_set is not None and not wanted.body_only and isinstance(points.places, np.ndarray):
        # joints are made of them
        markers = Markers(points.names, _overwrite_oriented(mapping, points.places))
    source = Source(
        *(file.name, form, mapping.unit, mapping.scale, mapping.up),
        joints=points.names,
        set=marker_set.set if marker_set else "",
        made=marker_set.sources(points.names) if marker_set else {},
    )
    doubts = (
        *points.doubts,
        *(marker_set.doubts if marker_set else ()),
        *rate_doubt(points.rate),
        *made_up,
    )
    doubts = (*doubts, *mapping.doubts, *gaps)
    about = (source, mapping.first, doubts, rotations, markers, axes)
    return Motion(skeleton, points.rate, positions, *about)


def _axes(
    points: Points,
    marker_set: MarkerSet | Clusters | None,
    turns: Callable[[int], NDArray[np.float32]] | None,
    mapping: BodyMapping,
    full_skeleton: Skeleton,
    body: NDArray[np.int16],
    positions: NDArray[np.float32],
) -> dict[str, NDArray[np.float32]]:
    """Return where palms face: as hands are turned, else of markers or knuckles in each frame."""
    if turns is not None:
        full = full_skeleton
        at_rest = full.names, full.parents.tolist(), full.offsets, full.body
        return turned(rest_palms(*at_rest, points.palms_down), turns)
    if not isinstance(points.places, np.ndarray):
        return {}
    those = marker_set.palms if isinstance(marker_set, MarkerSet) else planes(points.names)
    played = {hand: int(body[JOINT_CODES[f"{hand[0]}Wrist"]]) for hand in those}
    wrists = {hand: positions[:, joint] for hand, joint in played.items() if joint >= 0}
    return seen_palms(points.places, those, wrists, mapping.oriented)


def _turns(
    joint: int,
    order: NDArray[np.int64],
    rotations: NDArray[np.float32],
    places: Places,
    mapping: BodyMapping,
) -> NDArray[np.float32]:
    """Return how one joint of a file is turned, (T, 4), whether it was kept or not."""
    if joint not in order:
        _, alone = _oriented(mapping, places, np.array([joint]))
        rotations, order = rotations if alone is None else alone, np.array([joint])
    return rotations[:, order.tolist().index(joint)]


def _marker_set(names: tuple[str, ...], options: Reading) -> MarkerSet | Clusters | None:
    """Return how joints are made of points, if they are markers."""
    if not options.body:
        return marker_set_of(names)
    try:
        return marker_set_of(names, read_body_file(options.body))
    except BodyError as error:
        raise BodyError(error.found, place=options.body, wanted=error.wanted) from error


def _places(points: Points, marker_set: MarkerSet | Clusters | None, options: Reading) -> Places:
    """Return what tells where the joints are: the points, or what is made of them."""
    if isinstance(points.places, Places):
        return points.places
    if marker_set is None:
        return _stored_places(points.places, points.rotations)
    scale = _millimetres(points.places, points.declared, options)
    known, at = marker_set.over(points.places, scale, BLOCK)
    if len(points.places) <= BLOCK:
        return _stored_places(at(slice(None)))
    return Places(known, lambda frames, joints: (at(frames)[:, joints], None))


def _stored_places(places: NDArray[Any], rotations: NDArray[Any] | None = None) -> Places:
    def at(frames: Frames, joints: NDArray[np.int64]) -> tuple[NDArray[Any], NDArray[Any] | None]:
        turns = None if rotations is None else rotations[frames][:, joints]
        return places[frames][:, joints], turns

    return Places(np.isfinite(places).all(axis=2), at)


def _millimetres(places: NDArray[Any], declared: Declared, options: Reading) -> float:
    """Return the millimetres in a unit of markers: as is said, else by how far they reach."""
    _, size, doubts = unit_of({}, options.unit, declared.unit)
    some = places[:: max(len(places) // POSES, 1)]
    known = np.isfinite(some).all(axis=2)
    if not doubts or not known.any():
        return size
    reach = max(float((one[seen].max(axis=0) - one[seen].min(axis=0)).max())
                for one, seen in zip(some, known, strict=True) if seen.any())  # fmt: skip
    return min(UNITS.values(), key=lambda unit: abs(np.log(max(unit * reach, 1e-9) / REACH)))


def _gaps(known: NDArray[np.bool_], rate: Fraction) -> tuple[str, ...]:
    """Say how many gaps joints have: short ones are filled as they are written down."""
    if known.all():
        return ()
    edges = np.diff(~known.T, axis=1, prepend=False, append=False)
    starts, stops = (np.flatnonzero(edges) % edges.shape[1]).reshape(-1, 2).T
    filled = (stops - starts <= LONGEST_GAP * rate) & (starts > 0) & (stops < len(known))
    short, many, longest = int(filled.sum()), len(filled), f"{float(LONGEST_GAP):g} s"
    counts = (short, f"of at most {longest} filled"), (many - short, "left open")
    return tuple(f"{count} {'gap' if count == 1 else 'gaps'} {what}"
                 for count, what in counts if count)  # fmt: skip


def _body_by_name(names: Sequence[str]) -> NDArray[np.int16]:
    """Return which of some joints play the body, where they are called as its own are."""
    body = np.full(len(JOINTS), -1, np.int16)
    body[[JOINT_CODES[name] for name in names]] = np.arange(len(names))
    return body


def _mapping(
    names: Sequence[str], places: Places, points: Points, options: Reading, path: str
) -> BodyMapping:
    """Find the body among those points that are known somewhere."""
    known = places.known
    counts = known.sum(axis=1)
    fullest = np.flatnonzero(counts == counts.max(initial=0))
    if not len(fullest) or not counts.max():
        raise BodyError("no point is known in any frame", place=path, wanted="a body that moves")
    chosen = fullest[np.linspace(0, len(fullest) - 1, min(len(fullest), POSES)).astype(np.int64)]
    there = np.arange(len(names))
    if points.declared.body is None:
        there = np.flatnonzero(known[chosen].all(axis=0))
        if not len(there):
            unsteady = "in no two frames the same points are known"
            raise BodyError(unsteady, place=path, wanted="a body that moves")
    declared = points.declared
    if declared.body is not None:  # of markers: joints that were never seen play nothing
        ever = np.append(known.any(axis=0), False)
        declared = replace(declared, body=np.where(ever[declared.body], declared.body, -1))
    found = map_body(
        tuple(names[index] for index in there.tolist()),
        _parents_among(points.parents, there),
        places.at(chosen, there)[0].astype(np.float64),
        places.at(slice(BEGINNING), there)[0].astype(np.float64),
        points.rate,
        options,
        path,
        declared,
    )
    body = np.where(found.body >= 0, there[found.body], -1).astype(np.int16)
    return replace(found, body=body)


def _parents_among(
    parents: tuple[int, ...] | None, there: NDArray[np.int64]
) -> tuple[int, ...] | None:
    """Return the parents of some joints, by their places among these: the nearest that is there."""
    if parents is None:
        return None
    place = {joint: number for number, joint in enumerate(there.tolist())}
    found = []
    for joint in there.tolist():
        above = parents[joint]
        while above >= 0 and above not in place:
            above = parents[above]
        found.append(place.get(above, -1))
    return tuple(found)


def _skeleton(
    names: Sequence[str], places: Places, points: Points, mapping: BodyMapping
) -> tuple[Skeleton, NDArray[np.int64]]:
    """Return a skeleton, and which of the points each of its joints is."""
    if points.parents is not None:
        order = np.arange(len(names))
        parents, played = np.array(points.parents, np.int16), mapping.body
    else:  # the joints of the body come first, and hang together as a body does
        body = {joint: int(index) for joint, index in zip(JOINTS, mapping.body, strict=True)
                if index >= 0}  # fmt: skip
        rest = [index for index in range(len(names)) if index not in body.values()]
        order = np.array([*body.values(), *rest], np.int64)
        parents = np.array([*parents_of(list(body)), *[-1] * len(rest)], np.int16)
        played = _body_by_name(list(body))
    if points.offsets is not None:
        offsets = mapping.oriented(np.asarray(points.offsets, np.float64))
    else:
        some = np.unique(np.linspace(0, len(places) - 1, min(len(places), SAMPLED)).astype(int))
        there, _ = places.at(some, np.arange(len(names)))
        seen = mapping.oriented(there.astype(np.float64)).astype(np.float64)
        offsets = np.zeros((len(order), 3), np.float32)
        if points.parents is None:
            offsets[: len(body)] = rest_offsets({it: seen[:, index] for it, index in body.items()})
        else:
            for joint, parent in enumerate(parents.tolist()):
                if parent >= 0:
                    offsets[joint] = usual(seen[:, joint] - seen[:, parent])
    ordered = tuple(names[index] for index in order.tolist())
    return Skeleton(ordered, parents, offsets, played), order


def usual(vectors: NDArray[Any]) -> Floats:
    """Return the median of (T, 3) vectors; 0 where none is known."""
    known = vectors[np.isfinite(vectors).all(axis=1)]
    return np.median(known, axis=0) if len(known) else np.zeros(3)


def _oriented(
    mapping: BodyMapping, places: Places, order: NDArray[np.int64]
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
    """Return places in mm, y up, and how they are turned."""
    result = np.empty((len(places), len(order), 3), np.float32)
    turned = None
    for start in range(0, len(places), BLOCK):
        part = slice(start, start + BLOCK)
        block, turns = places.at(part, order)
        mapping.oriented(block.astype(np.float64), result[part])
        if turns is not None:
            turned = np.empty((*result.shape[:2], 4), np.float32) if turned is None else turned
            turned[part, :, 0] = turns[..., 0]
            turned[part, :, 1:] = mapping.turned(turns[..., 1:])
    return result, turned


def _overwrite_oriented(mapping: BodyMapping, places: NDArray[Any]) -> NDArray[np.float32]:
    """Return places in mm, y up; written over what they were, where they fit."""
    fits = places.dtype == np.float32 and places.flags.writeable
    result = places if fits else np.empty(places.shape, np.float32)
    for start in range(0, len(places), BLOCK):
        part = slice(start, start + BLOCK)
        mapping.oriented(places[part].astype(np.float64), result[part])
    return result
