"""Clusters of markers that hold together, one a segment → the joints between segments.

Where no marker lies at a joint, it is the point that keeps its place in both of the segments that
meet there: least squares over all frames tell it. A hinge has no such single point but an axis;
then, of all points that fit, the one nearest to both clusters is taken.

Source: Ehrig et al. (2006), *J. Biomech.* 39, 2798-2809 (SCoRE); Söderkvist and Wedin (1993),
*J. Biomech.* 26, 1473-1477 (how a cluster has turned).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, JOINTS

Floats = NDArray[np.float64]
Way = tuple[int, ...]

LEAST = 3
"""Markers by which a cluster's turn is known."""

FLAT = 0.1
"""Of its length: how wide a cluster is at least, for markers in a line leave a turn open."""

STILL = 0.05
"""Radians (root mean square): about what axis a joint turns less, there its place stays open."""

LOOSE = 40.0
"""Millimetres (root mean square) by which what two segments say of a joint differs at most."""

DOUBT = (
    "joints were found between clusters of markers, as the points that keep their places in both: "
    "sideways they may be some centimetres off"
)

BLOCK = 4096
"""Frames that are looked at at a time."""

_SAMPLE = 64
_ROUNDS = 4
_NUMBERED = re.compile(r"(.*?)([0-9]|[A-Z])$")


@dataclass(frozen=True, slots=True)
class Clusters:
    """How the joints of a body are found between clusters of a file's markers."""

    set: str  # What such markers are called
    segments: Mapping[str, Way]  # By segment: its markers
    # By joint of ``alphabet.JOINTS``: the two segments that it joins
    between: Mapping[str, tuple[str, str]]

    @property
    def doubts(self) -> tuple[str, ...]:
        """What a person should know of such joints."""
        return (DOUBT,)

    @property
    def used(self) -> frozenset[int]:
        """The markers that it looks at."""
        return frozenset(index for way in self.segments.values() for index in way)

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it makes, in their order."""
        return tuple(name for name in JOINTS if name in self.between or name == "Pelvis")

    def sources(self, names: Sequence[str]) -> dict[str, str]:
        """Return of each joint the markers between which it lies, by their names."""
        said = {
            segment: " ".join(names[it] for it in way) for segment, way in self.segments.items()
        }
        joints = {
            joint: f"between {said[a]} and {said[b]}" for joint, (a, b) in self.between.items()
        }
        joints["Pelvis"] = "the middle of the hips"
        return {joint: joints[joint] for joint in self.joints}

    def places(self, markers: NDArray[Any], scale: float) -> Floats:
        """Return where the joints are: see `lanindex.body.markers.MarkerSet.places`.

        NaN where neither of the two clusters is known, and everywhere where they hold no point in
        common.
        """
        found = np.full((len(markers), len(JOINTS), 3), np.nan)
        shapes = {name: shape_of(markers, way) for name, way in self.segments.items()}
        meetings = {joint: _Meeting() for joint in self.between}
        few = list(self._turned(markers, shapes)) if len(markers) <= BLOCK else None
        for _, turns in few or self._turned(markers, shapes):
            for joint, (one, other) in self.between.items():
                meetings[joint].add(*turns[one], *turns[other])
        held = {joint: meeting.point(LOOSE / scale) for joint, meeting in meetings.items()}
        for start, turns in few or self._turned(markers, shapes):
            for joint, pair in self.between.items():
                out = found[start : start + BLOCK, JOINT_CODES[joint]]
                sides = zip(pair, np.split(held[joint], 2), strict=True)
                out[:] = _middle(*(_moved(*turns[name], point) for name, point in sides))
        hips = found[:, [JOINT_CODES["RHip"], JOINT_CODES["LHip"]]]
        found[:, JOINT_CODES["Pelvis"]] = hips.mean(axis=1)
        return found

    def over(
        self, markers: NDArray[Any], scale: float, block: int
    ) -> tuple[NDArray[np.bool_], Callable[[slice | NDArray[np.int64]], Floats]]:
        """Return in which frames `joints` are known, and what gives their places in some frames."""
        found = self.places(markers, scale)[:, [JOINT_CODES[joint] for joint in self.joints]]
        known: NDArray[np.bool_] = np.asarray(np.isfinite(found).all(axis=2))
        return known, lambda frames: found[frames]

    def _turned(
        self, markers: NDArray[Any], shapes: Mapping[str, Floats]
    ) -> Iterator[tuple[int, dict[str, tuple[Floats, Floats]]]]:
        """Yield how all segments have turned and moved, and the first frame, of each block."""
        for start in range(0, len(markers), BLOCK):
            block = markers[start : start + BLOCK]
            yield (
                start,
                {
                    name: turns_of(block[:, list(way)].astype(np.float64), shapes[name])
                    for name, way in self.segments.items()
                },
            )


class _Meeting:
    """What all frames say of the points that two segments hold in common."""

    def __init__(self) -> None:
        self._total, self._wanted = np.zeros((6, 6)), np.zeros(6)
        self._square, self._count = 0.0, 0

    def add(self, turn: Floats, middle: Floats, back: Floats, end: Floats) -> None:
        """Take in some frames: where ``turn @ one + middle`` is ``back @ other + end``."""
        known = np.isfinite(turn[:, 0, 0]) & np.isfinite(back[:, 0, 0])
        table = np.concatenate([turn[known], -back[known]], axis=2).reshape(-1, 6)
        apart = (end - middle)[known].ravel()
        self._total += table.T @ table
        self._wanted += table.T @ apart
        self._square += float(apart @ apart)
        self._count += int(known.sum())

    def point(self, loose: float) -> Floats:
        """Return the point as both hold it, (6,); NaN where they hold none."""
        values, axes = np.linalg.eigh(self._total)
        told = values > STILL**2 * self._count
        inverse = np.divide(1.0, values, out=np.zeros(6), where=told)
        point: Floats = axes @ (inverse * (axes.T @ self._wanted))
        rest = self._square - 2 * point @ self._wanted + point @ self._total @ point
        return point if told.any() and rest <= self._count * loose**2 else np.full(6, np.nan)


def clusters_of(keys: Sequence[str], tables: Sequence[Mapping[str, Any]]) -> Clusters | None:
    """Return the clusters of two legs.

    `keys` (M) names of markers, letters and digits alone, in capitals.
    """
    groups: dict[str, list[int]] = {}
    for index, key in enumerate(keys):
        numbered = _NUMBERED.fullmatch(key)
        if numbered:
            groups.setdefault(numbered[1], []).append(index)
    for table in tables:
        segments: dict[str, Way] = {}
        for segment, choices in table["segments"].items():
            for side in "RL" if "{s}" in segment else ("",):
                named = (groups.get(choice.format(s=side), []) for choice in choices)
                segments[segment.format(s=side)] = max(map(tuple, named), key=len)
        if min(map(len, segments.values())) >= LEAST:
            between = {
                joint.format(s=side): (one.format(s=side), other.format(s=side))
                for joint, (one, other) in table["joints"].items()
                for side in "RL"
            }
            return Clusters(table["name"], segments, between)
    return None


def shape_of(markers: NDArray[Any], way: Way) -> Floats:
    """Return a cluster's shape: the mean of some frames, turned onto each other.

    returned (m, 3) about its middle; NaN where its markers are never all known, or lie in a line.
    """
    shape = np.full((len(way), 3), np.nan)
    known = np.flatnonzero(np.isfinite(markers[:, list(way), 0]).all(axis=1))
    if not len(known):
        return shape
    chosen = known[np.linspace(0, len(known) - 1, min(len(known), _SAMPLE)).astype(np.int64)]
    poses = markers[chosen][:, list(way)].astype(np.float64)
    away = poses - poses.mean(axis=1, keepdims=True)
    mean: Floats = away[len(away) // 2]
    for _ in range(_ROUNDS):
        turns, _ = turns_of(poses, mean)
        mean = np.einsum("tji,tmj->mi", turns, away) / len(poses)
    sizes = np.linalg.svd(mean, compute_uv=False)
    return mean if sizes[1] > FLAT * sizes[0] else shape


def turns_of(places: Floats, shape: Floats) -> tuple[Floats, Floats]:
    """Return how a cluster has turned and moved.

    `places` (T, m, 3) of its markers, NaN where unknown; `shape` (m, 3) of the cluster; returned
    (T, 3, 3) and (T, 3): ``turn @ point + middle`` is where a point of the shape is.
    """
    known = np.asarray(np.isfinite(places).all(axis=2) & np.isfinite(shape).all())
    shape = np.nan_to_num(shape)
    count = known.sum(axis=1)
    enough = count >= LEAST
    weight = known / np.maximum(count, 1)[:, None]
    at = np.where(known[..., None], places, 0.0)
    middle, centre = np.einsum("tm,tmi->ti", weight, at), weight @ shape
    away = (at - middle[:, None]) * known[..., None]
    left, _, right = np.linalg.svd(np.einsum("tmi,tmj->tij", away, shape - centre[:, None]))
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]  # a turn, no mirror
    turn = left @ right
    turn[~enough] = np.nan
    return turn, middle - np.einsum("tij,tj->ti", turn, centre)


def _moved(turn: Floats, middle: Floats, point: Floats) -> Floats:
    moved: Floats = turn @ point + middle
    return moved


def _middle(one: Floats, other: Floats) -> Floats:
    """Return the middle of two points; where one is unknown, the other."""
    known, also = np.isfinite(one), np.isfinite(other)
    middle: Floats = (np.where(known, one, other) + np.where(also, other, one)) / 2
    return middle
