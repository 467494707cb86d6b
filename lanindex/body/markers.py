"""Markers on the skin → joints within: which set they are, and what each joint is made of.

The sets are data (`markers.toml`). A joint lies in the middle of its markers; hip centres follow
from the hip bone's four, shoulders lie below the marker on top of them.

Where markers hold together in clusters, one a segment, and none lies at a joint, the joint is the
point that keeps its place in both of the segments that meet there: least squares over all frames
tell it. A hinge has no such single point but an axis; then, of all points that fit, the one nearest
to both clusters is taken.

Source: Harrington et al. (2007), *J. Biomech.* 40, 595-602 (hips, from pelvic width and depth);
Bell et al. (1990), *J. Biomech.* 23, 617-621 (hips, from the two in front); Rab et al. (2002),
*Gait & Posture* 15, 23-33 (shoulders, 17 % of the way between them below the top); Ehrig et al.
(2006), *J. Biomech.* 39, 2798-2809 (SCoRE, clusters); Söderkvist and Wedin (1993), *J. Biomech.*
26, 1473-1477 (how a cluster has turned).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import takewhile
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.body.recognition import tables
from lanindex.errors import BodyError

Floats = NDArray[np.float64]
Indices = tuple[int, ...]
"""The markers, by index, in whose middle a joint lies."""

SHOULDER_BELOW = 0.17
"""Of the way between the shoulders: how far a joint lies below the marker on top of it."""

HARRINGTON = ((-0.24, -9.9), (-0.30, -10.9), (0.33, 7.3))
"""Forward by pelvic depth, up and outwards by pelvic width: a share, and mm besides."""

BELL = (-0.22, -0.30, 0.36)
"""Forward, up and outwards from the middle of the front, in shares of pelvic width."""

_OTHER = re.compile(r"[\W_]+")
_HIPS = frozenset(("RHip", "LHip"))
_HIP_CODES = [JOINT_CODES[name] for name in sorted(_HIPS)]
_CAPPED = frozenset(("RShoulder", "LShoulder"))
_SHOULDERS = [JOINT_CODES["RShoulder"], JOINT_CODES["LShoulder"]]
_BELOW = ("Pelvis", "Chest")
"""What tells which way is down from the shoulders: the second, where the first is never known."""

_PLAIN = {joint.removeprefix("R").upper() for joint in JOINTS if not joint.startswith("L")}
_LIMB = {"arm": {"Shoulder", "Elbow", "Wrist"}, "leg": {"Hip", "Knee", "Ankle"}}


@dataclass(frozen=True, slots=True)
class MarkerSet:
    """How the joints of a body are made of a file's markers."""

    doubts: ClassVar[tuple[str, ...]] = ()  # What a person should know of such joints
    set: str  # What the set of markers is called; several names where one gives what another lacks
    # By joint of ``alphabet.JOINTS``: the markers in whose middle it lies
    joint_markers: Mapping[str, Indices]
    caps: frozenset[str] = frozenset()  # Shoulders whose markers lie on top of them
    # Right and left in front, and behind: where the hips are told by them; else empty
    pelvis: tuple[Indices, ...] = ()
    # By hand (``RHand``): the markers that tell its plane, as in `lanindex.body.axes.Plane`
    palms: Mapping[str, Indices] = field(default_factory=dict)

    @property
    def used(self) -> frozenset[int]:
        """The markers that it looks at."""
        return frozenset(
            index for indices in (*self.joint_markers.values(), *self.pelvis) for index in indices
        )

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it makes, in their order."""
        joints = self.joint_markers.keys() | (_HIPS if self.pelvis else set())
        return tuple(
            name for name in JOINTS if name in joints or (name == "Pelvis" and joints >= _HIPS)
        )

    def sources(self, names: Sequence[str]) -> dict[str, str]:
        """Return of each joint the markers that it is made of, by their names."""
        texts = {
            joint: " ".join(names[index] for index in indices)
            for joint, indices in self.joint_markers.items()
        }
        texts |= {joint: f"{texts[joint]}, below" for joint in self.caps}
        if self.pelvis:
            pelvis = " ".join(names[index] for indices in self.pelvis for index in indices)
            texts |= dict.fromkeys(_HIPS, f"{pelvis}, by regression")
        texts.setdefault("Pelvis", "the middle of the hips")
        return {joint: texts[joint] for joint in self.joints}

    def over(
        self, markers: NDArray[Any], scale: float, block: int
    ) -> tuple[NDArray[np.bool_], Callable[[slice | NDArray[np.int64]], Floats]]:
        """Return where `joints` are known, (T, J), and what gives (t, J, 3) in some frames.

        `markers` (T, M, 3) are worked on `block` frames at a time; `scale` mm in a unit of theirs.
        """
        # how wide and deep the pelvis is, which all frames tell
        sizes = [_median_length(side) for side in self._pelvis_sides(markers)[1:]]
        parts = [slice(start, start + block) for start in range(0, len(markers), block)]
        columns = [JOINT_CODES[joint] for joint in self.joints]
        known = np.empty((len(markers), len(columns)), np.bool_)
        wide, down = np.empty(len(markers)), np.empty((len(markers), 3))
        lower = False
        for joint in _BELOW:
            for part in parts:
                found = self._joint_places(markers[part], scale, sizes)
                known[part] = np.isfinite(found[:, columns]).all(axis=2)
                right, left = (found[:, code] for code in _SHOULDERS)
                wide[part] = _length(right - left)
                down[part] = _unit(found[:, JOINT_CODES[joint]] - (right + left) / 2)
            lower = self.caps == _CAPPED and bool(_known(down).any())
            if lower or self.caps != _CAPPED:
                break
        if lower:  # a shoulder lies below its marker
            down = _filled_in(down)
            down *= SHOULDER_BELOW * float(np.nanmedian(wide))

        def at(frames: slice | NDArray[np.int64]) -> Floats:
            found = self._joint_places(markers[frames], scale, sizes)
            if lower:
                found[:, _SHOULDERS] += down[frames][:, None]
            return found[:, columns]

        return known, at

    def _joint_places(self, markers: NDArray[Any], scale: float, sizes: Sequence[float]) -> Floats:
        """Return where the joints are, shoulders on their tops."""
        found = np.full((len(markers), len(JOINTS), 3), np.nan)
        for joint, indices in self.joint_markers.items():
            found[:, JOINT_CODES[joint]] = _middle(markers, indices)
        if self.pelvis:
            self._place_hips(markers, scale, found, sizes)
        if "Pelvis" not in self.joint_markers:
            found[:, JOINT_CODES["Pelvis"]] = found[:, _HIP_CODES].mean(axis=1)
        return found

    def _pelvis_sides(self, markers: NDArray[Any]) -> list[Floats]:
        """Return the middle of the pelvis in front, its width, and its depth if that is known."""
        if not self.pelvis:
            return []
        right, left, *back = (_middle(markers, indices) for indices in self.pelvis)
        front = (right + left) / 2
        return [front, right - left, *(front - it for it in back)]

    def _place_hips(
        self, markers: NDArray[Any], scale: float, places: Floats, sizes: Sequence[float]
    ) -> None:
        """Find the hip centres in the frame of the pelvis: forward, up and to the right."""
        front, across, *deep = self._pelvis_sides(markers)
        width, *depth = sizes
        if deep:
            up = _unit(np.cross(across, deep[0]))
            wide = (*depth, width, width)
            away = [share * size + mm / scale
                    for (share, mm), size in zip(HARRINGTON, wide, strict=True)]  # fmt: skip
        else:
            trunk = next((places[:, JOINT_CODES[name]] for name in ("Neck", "Chest", "RShoulder")
                          if name in self.joint_markers), np.full_like(front, np.nan))  # fmt: skip
            up = _unit(np.cross(across, np.cross(trunk - front, across)))
            away = [share * width for share in BELL]
        sideways = _unit(across)
        forward = np.cross(up, sideways)
        middle = front + away[0] * forward + away[1] * up
        for side, sign in (("R", 1), ("L", -1)):
            places[:, JOINT_CODES[f"{side}Hip"]] = middle + sign * away[2] * sideways


def marker_set_of(
    names: Sequence[str], body: Mapping[str, tuple[str, ...]] | None = None
) -> MarkerSet | Clusters | None:
    """Return how the joints of a body are made of markers called `names`, if their set is known."""
    return _marker_set(tuple(names), tuple((body or {}).items()))


@lru_cache(maxsize=64)
def _marker_set(
    names: tuple[str, ...], user_markers: tuple[tuple[str, tuple[str, ...]], ...]
) -> MarkerSet | Clusters | None:
    subject = _subject(names)
    index = {
        _key(name.removeprefix(subject)): number
        for number, name in reversed(list(enumerate(names)))
    }
    sets = sorted(
        (_in_set(one, index) for one in tables("markers.toml")["sets"]),
        key=lambda it: -len(it.joints),
    )
    merged, used = MarkerSet("", {}), []
    for one in sets:
        pelvis = merged.pelvis or (
            () if _HIPS & (merged.joint_markers.keys() | one.joint_markers.keys()) else one.pelvis
        )
        taken = set(merged.joint_markers.values())  # what is a joint already is no second one
        left = {joint for joint, indices in one.joint_markers.items() if indices not in taken}
        left -= merged.joint_markers.keys() | (_HIPS if pelvis else set())
        if left or pelvis != merged.pelvis:
            used.append(one.set)
        joint_markers = {
            **merged.joint_markers,
            **{joint: one.joint_markers[joint] for joint in left},
        }
        caps, palms = merged.caps | (one.caps & left), {**one.palms, **merged.palms}
        merged = MarkerSet(", ".join(used), joint_markers, caps, pelvis, palms)
    used_names = {name for name, number in index.items() if number in merged.used}
    if all(name.lstrip("RL") in _PLAIN for name in used_names):
        merged = MarkerSet("", {})  # those are joints, and called so
    if user_markers:
        body = {
            joint: _user_markers(joint, [name.removeprefix(subject) for name in markers], index)
            for joint, markers in user_markers
        }
        pelvis = () if body.keys() >= _HIPS else merged.pelvis
        name = ", ".join(("as told", *used))
        merged = MarkerSet(
            name, {**merged.joint_markers, **body}, merged.caps - body.keys(), pelvis, merged.palms
        )
    whole = any(_LIMB[limb].issubset(it[1:] for it in merged.joints if it[0] == side)
                for side in "RL" for limb in _LIMB)  # fmt: skip
    faces = any({f"R{joint}", f"L{joint}"}.issubset(merged.joints) for joint in ("Hip", "Shoulder"))
    if (whole and faces) or user_markers:
        return merged if whole and faces else None
    return clusters_of([_key(name) for name in names], tables("markers.toml")["clusters"])


def _user_markers(joint: str, names: Sequence[str], index: Mapping[str, int]) -> Indices:
    missing = [name for name in names if _key(name) not in index]
    if missing:
        raise BodyError(f'no "{missing[0]}" for {joint}', wanted="the name of a marker")
    return tuple(index[_key(name)] for name in names)


def _subject(names: Sequence[str]) -> str:
    """Return what stands before all names, where an underscore parts it from them: ``Ada_``."""
    first, last = min(names, default=""), max(names, default="")
    alike = takewhile(lambda letters: letters[0] == letters[1], zip(first, last, strict=False))
    shared, mark, _ = "".join(letter for letter, _ in alike).rpartition("_")
    return shared + mark if len(shared) > 1 else ""  # one letter is a side


def _key(name: str) -> str:
    return _OTHER.sub("", name.rpartition(":")[2]).upper()


def _in_set(one: Mapping[str, Any], index: Mapping[str, int]) -> MarkerSet:
    """Return what a set makes of some markers."""
    found: dict[str, dict[str, Indices]] = {"joints": {}, "shoulder_cap": {}, "palm": {}}
    for group, by_joint in found.items():
        for joint, choices in one.get(group, {}).items():
            for side in "RL" if "{s}" in joint else ("",):
                indices = _first(choices, side, index)
                if indices:
                    by_joint[joint.format(s=side)] = indices
    joints, capped, palms = found.values()
    pelvis = _pelvis(one.get("pelvis"), index)
    return MarkerSet(one["name"], {**joints, **capped}, frozenset(capped), pelvis, palms)


def _pelvis(pelvis: Mapping[str, Any] | None, index: Mapping[str, int]) -> tuple[Indices, ...]:
    if pelvis is None:
        return ()
    front = tuple(_first([pelvis["front"]], side, index) for side in "RL")
    behind = tuple(dict.fromkeys(
        marker for side in "RL" for marker in _first(pelvis["back"], side, index)
    ))  # fmt: skip
    return () if () in front else (*front, *((behind,) if behind else ()))


def _first(choices: Sequence[str], side: str, index: Mapping[str, int]) -> Indices:
    """Return the first choice all of whose markers are there, else none."""
    for choice in choices:
        indices = tuple(index.get(_key(name.format(s=side)), -1) for name in choice.split())
        if -1 not in indices:
            return indices
    return ()


def _middle(markers: NDArray[Any], indices: Indices) -> Floats:
    place = markers[:, indices[0]].astype(np.float64)
    for marker in indices[1:]:
        place += markers[:, marker]
    place /= len(indices)
    return place


def _median_length(vectors: Floats) -> float:
    """Return how long vectors (T, 3) are, the median; NaN where none is known."""
    lengths = _length(vectors)
    return float(np.nanmedian(lengths)) if np.isfinite(lengths).any() else np.nan


def _length(vectors: Floats) -> Floats:
    length: Floats = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
    return length


def _unit(vectors: Floats) -> Floats:
    length = _length(vectors)[..., None]
    unit: Floats = np.divide(vectors, length, out=np.full_like(vectors, np.nan), where=length > 0)
    return unit


def _known(vectors: Floats) -> NDArray[np.bool_]:
    known: NDArray[np.bool_] = np.asarray(
        np.isfinite(vectors.reshape(len(vectors), -1)).all(axis=1)
    )
    return known


def _filled_in(directions: Floats) -> Floats:
    """Fill in, where directions are unknown, the last known one, or the first."""
    there = _known(directions)
    known, unknown = np.flatnonzero(there), np.flatnonzero(~there)
    last = np.searchsorted(known, unknown) - 1
    directions[unknown] = directions[known[np.maximum(last, 0)]]
    return directions


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

    doubts: ClassVar[tuple[str, ...]] = (DOUBT,)  # What a person should know of such joints
    set: str  # What such markers are called
    segments: Mapping[str, Indices]  # By segment: its markers
    # By joint of ``alphabet.JOINTS``: the two segments that it joins
    between: Mapping[str, tuple[str, str]]

    @property
    def used(self) -> frozenset[int]:
        """The markers that it looks at."""
        return frozenset(index for indices in self.segments.values() for index in indices)

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it makes, in their order."""
        return tuple(name for name in JOINTS if name in self.between or name == "Pelvis")

    def sources(self, names: Sequence[str]) -> dict[str, str]:
        """Return of each joint the markers between which it lies, by their names."""
        texts = {
            segment: " ".join(names[it] for it in indices)
            for segment, indices in self.segments.items()
        }
        joints = {
            joint: f"between {texts[a]} and {texts[b]}" for joint, (a, b) in self.between.items()
        }
        joints["Pelvis"] = "the middle of the hips"
        return {joint: joints[joint] for joint in self.joints}

    def over(
        self, markers: NDArray[Any], scale: float, _block: int
    ) -> tuple[NDArray[np.bool_], Callable[[slice | NDArray[np.int64]], Floats]]:
        """Return what `MarkerSet.over` does; unknown where clusters share no point."""
        turns = {name: self._turns(markers, indices) for name, indices in self.segments.items()}
        places: dict[str, Floats] = {}
        for joint, pair in self.between.items():
            sides = [turns[name] for name in pair]
            points = np.split(_shared_point(*sides[0], *sides[1], LOOSE / scale), 2)
            places[joint] = _midpoint(*(
                turn @ point + middle for (turn, middle), point in zip(sides, points, strict=True)
            ))  # fmt: skip
        hips = np.stack([places[name] for name in sorted(_HIPS)], axis=1)
        places["Pelvis"] = hips.mean(axis=1)
        found = np.stack([places[joint] for joint in self.joints], axis=1)
        known: NDArray[np.bool_] = np.asarray(np.isfinite(found).all(axis=2))
        return known, lambda frames: found[frames]

    def _turns(self, markers: NDArray[Any], indices: Indices) -> tuple[Floats, Floats]:
        """Return how a segment has turned, (T, 3, 3), and moved, (T, 3)."""
        shape = shape_of(markers, indices)
        blocks = (
            turns_of(markers[part][:, list(indices)].astype(np.float64), shape)
            for part in _blocks(len(markers))
        )
        turns, shifts = zip(*blocks, strict=True)
        return np.concatenate(turns), np.concatenate(shifts)


def _blocks(count: int) -> Iterator[slice]:
    return (slice(start, start + BLOCK) for start in range(0, max(count, 1), BLOCK))


def _shared_point(turn: Floats, middle: Floats, back: Floats, end: Floats, loose: float) -> Floats:
    """Return the point that two segments hold in common, as both hold it, (6,); NaN if none.

    In all frames ``turn @ one + middle`` is ``back @ other + end``.
    """
    total, wanted, square, count = np.zeros((6, 6)), np.zeros(6), 0.0, 0
    there = np.isfinite(turn[:, 0, 0]) & np.isfinite(back[:, 0, 0])
    for part in _blocks(len(turn)):
        known = there[part]
        table = np.concatenate([turn[part][known], -back[part][known]], axis=2).reshape(-1, 6)
        apart = (end[part] - middle[part])[known].ravel()
        total += table.T @ table
        wanted += table.T @ apart
        square += float(apart @ apart)
        count += int(known.sum())
    values, axes = np.linalg.eigh(total)
    told = values > STILL**2 * count
    inverse = np.divide(1.0, values, out=np.zeros(6), where=told)
    point: Floats = axes @ (inverse * (axes.T @ wanted))
    rest = square - 2 * point @ wanted + point @ total @ point
    return point if told.any() and rest <= count * loose**2 else np.full(6, np.nan)


def clusters_of(keys: Sequence[str], tables: Sequence[Mapping[str, Any]]) -> Clusters | None:
    """Return the clusters of two legs, by `keys` (M): letters and digits of names, in capitals."""
    groups: dict[str, list[int]] = {}
    for index, key in enumerate(keys):
        numbered = _NUMBERED.fullmatch(key)
        if numbered:
            groups.setdefault(numbered[1], []).append(index)
    for table in tables:
        segments: dict[str, Indices] = {}
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


def shape_of(markers: NDArray[Any], indices: Indices) -> Floats:
    """Return a cluster's mean shape about its middle, (m, 3); NaN where it is unknown or a line."""
    shape = np.full((len(indices), 3), np.nan)
    known = np.flatnonzero(np.isfinite(markers[:, list(indices), 0]).all(axis=1))
    if not len(known):
        return shape
    chosen = known[np.linspace(0, len(known) - 1, min(len(known), _SAMPLE)).astype(np.int64)]
    poses = markers[chosen][:, list(indices)].astype(np.float64)
    away = poses - poses.mean(axis=1, keepdims=True)
    mean: Floats = away[len(away) // 2]
    for _ in range(_ROUNDS):
        turns, _ = turns_of(poses, mean)
        mean = np.einsum("tji,tmj->mi", turns, away) / len(poses)
    sizes = np.linalg.svd(mean, compute_uv=False)
    return mean if sizes[1] > FLAT * sizes[0] else shape


def turns_of(places: Floats, shape: Floats) -> tuple[Floats, Floats]:
    """Return rotations (T, 3, 3) and shifts (T, 3) from `shape` (m, 3) to `places` (T, m, 3)."""
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


def _midpoint(one: Floats, other: Floats) -> Floats:
    """Return the middle of two points; where one is unknown, the other."""
    known, also = np.isfinite(one), np.isfinite(other)
    middle: Floats = (np.where(known, one, other) + np.where(also, other, one)) / 2
    return middle
