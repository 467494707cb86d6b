"""glTF: nodes, skins and animations → Motion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body.mapping import Declared, sampled
from lanindex.errors import CaptureError, UsageError, quoted
from lanindex.formats.file import File, Wanted
from lanindex.formats.gltf.document import Document, Value, opened_document
from lanindex.formats.gltf.scene import Nodes, Person, nodes_of, people
from lanindex.formats.gltf.tracks import Clock, Track, clock, moved, takes, timed, tracks
from lanindex.formats.people import distinct, is_human, named, others, person, take_doubt
from lanindex.formats.points import BLOCK, Frames, Places, Points, motion_of
from lanindex.formats.rates import given_rate
from lanindex.formats.turning import ancestry, from_parents, inverse, product, worlds
from lanindex.model import Motion, Reading

MOST = 20_000_000
"""Places of joints in a file that is smaller than four bytes for each."""

FARTHEST = 1e30
"""Metres: farther away a place is no number of 32 bits any more, in millimetres."""


@dataclass(frozen=True, slots=True, eq=False)
class Performance:
    """Somebody in a take."""

    document: Document  # the file
    nodes: Nodes  # its nodes
    person: Person  # whose joints
    take: Value  # the animation
    tracks: list[Track]  # what moves the joints
    clock: Clock  # when frames are

    def placed(self, frames: NDArray[np.int64]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return where joints are in some frames, (T, J, 3), and how they are turned."""
        return placed(self.nodes, self.person.joints, self.tracks, frames)

    def human(self) -> bool:
        """Tell whether the joints make a body."""
        poses, _ = self.placed(sampled(self.clock.count))
        return is_human(self.person.names, self.person.parents, poses)


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read a glTF or GLB file: see `lanindex.formats.read_file`.

    Of several people the one is read that the file's name tells behind ``#``, else the first; of
    several animations the one that is named, else the first that moves them. At rest joints are as
    the nodes stand while nothing is animated. A GLB that LanIndex wrote tells where joints were
    unknown.

    The joints of a skin, or the nodes that move.

    References
    ----------
    Khronos Group, glTF 2.0 Specification, 2021: 3.6 (accessors), 3.7 (skins), 3.11 (animations).
    """
    found, doubts = chosen(file, options.take)
    whose, ticks = found.person, found.clock
    rate = rate_of(found) if options.rate is None else given_rate(options.rate)
    rest, upright = placed(found.nodes, whose.joints)
    offsets = from_parents(rest[0], whose.parents)
    gaps = unknown(found)
    known = _known((ticks.count, len(whose.joints)), gaps)
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
    points_of = Points(
        whose.names,
        places,
        rate,
        Declared("m", "y"),
        whose.parents,
        offsets,
        turns,
        doubts=(*doubts, *(ticks.doubts if options.rate is None else ())),
    )
    return motion_of(points_of, file, "gltf", options, wanted)


def _known(shape: tuple[int, int], gaps: Mapping[int, list[tuple[int, int]]]) -> NDArray[np.bool_]:
    """Return whether places are known, (T, J)."""
    known = np.ones(shape, np.bool_)
    for joint, spans in gaps.items():
        for start, stop in spans:
            known[start:stop, joint] = False
    return known


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


def rate_of(found: Performance) -> Fraction:
    """Return the rate; a single key tells none, LanIndex's own files do."""
    beside = extras(found)
    if found.clock.count == 1 and isinstance(beside.get("rate"), str):
        with suppress(UsageError):
            return given_rate(beside["rate"])
    return found.clock.rate


def extras(found: Performance) -> dict[str, Any]:
    """Return what LanIndex wrote beside an animation, if all its frames are there."""
    beside = found.take.get("extras").value
    fits = isinstance(beside, dict) and beside.get("frames") == found.clock.count
    return beside if fits else {}


def unknown(found: Performance) -> dict[int, list[tuple[int, int]]]:
    """Return by joint in which frames LanIndex wrote that its place was unknown."""
    spans_by_name = extras(found).get("unknown")
    place = {name: joint for joint, name in enumerate(found.person.names)}
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
    meant, known = found[name], takes(document)
    read = next(called for called, value in known if value.where == meant.take.where)
    return meant, (*doubts, *take_doubt([called for called, _ in known], read, take))


def performers(document: Document, take: str | None) -> dict[str, Performance]:
    """Return the people of a file by their names; somebody who is not human only where none is."""
    path, nodes, known = document.file.name, nodes_of(document), takes(document)
    meant = known if take is None else [one for one in known if one[0] == take]
    if not meant:
        raise CaptureError(
            "has no animation" if take is None else f"has no take {quoted(take)}",
            place=path,
            wanted=others(name for name, _ in known) or "an animation of a skeleton",
        )
    moving = [(value, moved(document, value)) for _, value in meant]
    skeletons = people(document, nodes, set().union(*(which for _, which in moving)))
    found = list[Performance]()
    for skeleton in skeletons:
        needed = set(above(nodes, skeleton.joints))
        for value, which in moving:
            if which & needed:
                found.append(_performance(document, nodes, skeleton, value, needed))
                break
    if not found:
        raise CaptureError(
            "no animation moves a skeleton", place=path, wanted="one that moves its joints"
        )
    if len(found) > 1:
        found = [one for one in found if one.human()] or found[:1]
    numbers = range(1, len(found) + 1)
    names = [one.person.name or str(number) for number, one in zip(numbers, found, strict=True)]
    return named(dict(zip(distinct(names, numbers), found, strict=True)))


def _performance(
    document: Document, nodes: Nodes, person: Person, take: Value, needed: set[int]
) -> Performance:
    found = tracks(document, take, needed)
    ticks = clock([track.times for track in found], document.file.name)
    count = ticks.count * len(person.joints)
    if count > max(MOST, len(document.file.content) // 4):
        raise CaptureError(
            f"{ticks.count} frames of {len(person.joints)} joints",
            place=document.file.name,
            wanted="as many as such a file can hold",
        )
    return Performance(document, nodes, person, take, timed(found, ticks), ticks)


Floats = NDArray[np.float64]


def above(nodes: Nodes, joints: Iterable[int]) -> list[int]:
    """Return joints and all nodes above them, parents before children."""
    needed = ancestry(joints, nodes.parents)
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
