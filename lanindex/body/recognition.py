"""Which joints of a skeleton play the body: by their names (`names.toml`), else by its shape.

Nothing is invented: a joint that is not there stays absent. Names are compared whatever a program
calls its joints.

For skeletons whose joints are called J1, J2, J3 the shape tells. Two limbs are a pair if they leave
the trunk at one joint and have equal bones. The pair with the longest two bones in a row is the
legs, the next one the arms; the trunk between goes on to neck and head. Feet point forward (else
knees do), and that tells left from right, unless the names of the limbs do.

A body is human enough to be encoded if both hips are there (the heading needs them) and both legs
down to the ankles or both arms from shoulder to wrist. Where names leave no doubt, one whole limb
is enough, with two hips or two shoulders that tell where it faces: captures of the upper body.
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from heapq import nlargest
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.data import shipped
from lanindex.errors import BodyError, shown

_NEAR_PELVIS = 0.35  # of a thigh, from the middle of the hips
_STRAIGHT = 0.95  # mean cosine: a foot of real captures makes at most .91 with its shank
_NOTHING = 0.003  # of the body's extent: two joints in one place


class Rig:
    """A skeleton, `names` (J), in a few of its poses (S, J, 3).

    `parents` (J) parents before children, -1 for a root; None without a hierarchy: joints then lie
    beyond each other by their distance alone.
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
        return next(
            (one for one in found if inner is None or self._leaves_line(one, outer, inner)), None
        )

    def _leaves_line(self, joint: int, outer: int, inner: int) -> bool:
        """Return whether a joint leaves the line from `inner` through `outer`."""
        bone, before = (
            self.poses[:, b] - self.poses[:, a] for a, b in ((outer, joint), (inner, outer))
        )
        sizes = np.linalg.norm(bone, axis=1) * np.linalg.norm(before, axis=1)
        along = np.einsum("si,si->s", bone, before)[sizes > 0] / sizes[sizes > 0]
        return not along.size or float(along.mean()) < _STRAIGHT


def above(parents: Sequence[int], joint: int) -> list[int]:
    """Return a joint, its parent, and so on up to the root."""
    chain = []
    while joint >= 0:
        chain.append(joint)
        joint = parents[joint]
    return chain


def meeting(parents: Sequence[int], one: int, other: int) -> int | None:
    """Return the lowest joint that two joints hang on, where their branches part."""
    chain = above(parents, one)
    return next((joint for joint in above(parents, other) if joint in chain), None)


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


_NAMESPACE = re.compile(r"^.*[:|]")
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^\W\d_a-zA-Z]+")
_SHARED = 0.8
_GROUPS = ("middle", "limbs", "tips", "fingers")

Key = tuple[str, str]
"""Side (``L``, ``R`` or empty) and the name without it."""


def tables(file: str = "names.toml") -> Mapping[str, Any]:
    """Return `names.toml`, or `markers.toml`."""
    return shipped(f"body/{file}")


@lru_cache(maxsize=1)
def _sides() -> Mapping[str, str]:
    letters = {"left": "L", "right": "R", "middle": ""}
    return {word: letters[side] for side, words in tables()["sides"].items() for word in words}


@lru_cache(maxsize=1)
def _known_words() -> frozenset[str]:
    groups = (tables()[group] for group in _GROUPS)
    return frozenset(word for group in groups for words in group.values() for word in words)


def _words(name: str) -> list[str]:
    """Cut a name into small words: ``Bip01 L UpperArm`` → bip 1 l upper arm."""
    found = _WORDS.findall(_NAMESPACE.sub("", name) or name)
    return [str(int(word)) if word.isdecimal() else word.lower() for word in found]


def _without_shared(names: list[list[str]]) -> list[list[str]]:
    """Drop first and last words that nearly all names have: ``bip 1``, ``joint``."""
    for end in (0, -1):
        while True:
            counts = Counter(words[end] for words in names if len(words) > 1)
            word, count = counts.most_common(1)[0] if counts else ("", 0)
            if count < max(4, _SHARED * len(names)) or word in _sides() or word in _known_words():
                break
            names = [
                (words[1:] if end == 0 else words[:-1])
                if len(words) > 1 and words[end] == word
                else words
                for words in names
            ]
    return names


def _key(words: Sequence[str]) -> Key:
    words = [word for word in words if word not in tables()["ignored"]] or words
    for place, word in enumerate(words):
        if word in _sides() and len(words) > 1:
            return _sides()[word], "".join((*words[:place], *words[place + 1 :]))
    name = "".join(words)
    if name in _known_words():
        return "", name
    for mark, side in _sides().items():
        if not side:
            continue
        for rest in (name.removeprefix(mark), name.removesuffix(mark)):
            if rest != name and rest in _known_words():
                return side, rest
    return "", name


@lru_cache(maxsize=64)
def keys(names: tuple[str, ...]) -> tuple[Key, ...]:
    """Return side and plain name of each joint."""
    return tuple(map(_key, _without_shared([_words(name) for name in names])))


@lru_cache(maxsize=64)
def candidates(names: tuple[str, ...]) -> Mapping[tuple[str, str, str], tuple[int, ...]]:
    """Return the joints that may be meant, best first."""
    found: dict[Key, int] = {}
    passed_over = exporter_of(names).get("passed_over", ())
    for index, key in enumerate(keys(names)):
        if names[index] not in passed_over:
            found.setdefault(key, index)
    return {
        (group, side, joint): tuple(
            found[side, alias] for alias in aliases if (side, alias) in found
        )
        for group in _GROUPS
        for joint, aliases in tables()[group].items()
        for side in ("", "L", "R")
    }


@lru_cache(maxsize=64)
def exporter_of(names: tuple[str, ...]) -> Mapping[str, Any]:
    """Return what `names.toml` knows about the program that wrote these joints, or nothing."""
    present = set(names)
    for exporter in tables()["exporters"]:
        if present.issuperset(exporter["joints"]):
            known: Mapping[str, Any] = exporter
            return known
    return {}


Candidates = Mapping[tuple[str, str, str], tuple[int, ...]]

_ARM, _LEG = ("Shoulder", "Elbow", "Wrist", "Hand"), ("Hip", "Knee", "Ankle", "Toe")
LIMBS = (_ARM[:3], _LEG[:3])


def by_name(rig: Rig) -> dict[str, int]:
    """Find the body by the names of joints."""
    choices = candidates(rig.names)
    body: dict[str, int] = {}
    for side in "RL":
        for limb in (_ARM, _LEG):
            _named_limb(rig, choices, side, limb, body)
    _pelvis(rig, choices, body)
    _neck_head(rig, choices, body)
    _chest(rig, choices, body)
    return body


def _named_limb(
    rig: Rig, choices: Candidates, side: str, limb: tuple[str, str, str, str], body: dict[str, int]
) -> None:
    """Walk from the trunk outwards; each joint lies below the one before."""
    last: int | None = None
    *joints, end = limb
    for joint in joints:
        for index in choices["limbs", side, joint]:
            if last is None or rig.beyond(index, last) > 0.0:
                body[side + joint] = last = index
                break
    inner, outer = (body.get(side + joint) for joint in joints[1:])
    if outer is not None:
        tip = rig.tip(outer, choices["tips", side, end], inner if end == "Toe" else None)
        if tip is not None:
            body[side + end] = tip


def _pelvis(rig: Rig, choices: Candidates, body: dict[str, int]) -> None:
    named = choices["middle", "", "Pelvis"]
    if not {"RHip", "LHip", "RKnee"} <= body.keys():
        if named:
            body["Pelvis"] = named[0]
        return
    parting = meeting(rig.parents, body["RHip"], body["LHip"])
    chest = next(iter(choices["middle", "", "Chest"]), None)  # what names call so lies low in some
    for index in (*named, *([parting] if parting not in (None, chest) else [])):
        if near_hips(rig, index, body):
            body["Pelvis"] = index
            return


def _neck_head(rig: Rig, choices: Candidates, body: dict[str, int]) -> None:
    """Find neck and head; a head that stands for both (no neck, or in one place) gives its tip."""
    neck, head = (next(iter(choices["middle", "", joint]), None) for joint in ("Neck", "Head"))
    tips = choices["tips", "", "Head"]
    if head is None:
        head = rig.tip(neck, tips) if neck is not None else None
    elif neck is None or rig.distance(neck, head) <= rig.nothing:
        tip = rig.tip(head, tips)
        neck, head = (head, tip) if tip is not None else (neck, head if neck is None else None)
    body |= {joint: index for joint, index in (("Neck", neck), ("Head", head)) if index is not None}


def _chest(rig: Rig, choices: Candidates, body: dict[str, int]) -> None:
    """Take the joint where the arms part from the trunk; where all part at the pelvis, a name."""
    taken = set(body.values())
    if {"RShoulder", "LShoulder"} <= body.keys():
        parting = meeting(rig.parents, body["RShoulder"], body["LShoulder"])
        taken_or_low = taken.union(above(rig.parents, body.get("Pelvis", -1)))
        if parting is not None and parting not in taken_or_low:
            body["Chest"] = parting
            return
    for index in choices["middle", "", "Chest"]:
        if index not in taken:
            body["Chest"] = index
            return


_ALIKE = 0.3  # how much the bones of two sides may differ
_THINNEST = 0.1  # of a limb's longest bone: shorter ones are no thigh or forearm
_BRANCHES = 12  # looked at where more leave one joint
_LONGEST = 60  # joints of a branch looked at
_EQUAL = 0.86  # of the longest two bones in a row
_CLEAR = 0.2  # mean cosine: how far forward feet or knees must show


@dataclass(frozen=True, slots=True)
class _Limb:
    """The two longest bones in a row of a branch."""

    top: int  # The first joint of the branch
    joints: tuple[int, int, int]  # Where the two bones begin, meet and end: hip, knee, ankle
    bones: tuple[float, float]  # Their lengths


Poses = NDArray[np.float64]
_Pair = tuple[_Limb, _Limb]


def by_shape(rig: Rig) -> tuple[dict[str, int], tuple[str, ...]]:
    """Find the body by bones and poses."""
    pairs = sorted(_pairs(rig), key=lambda pair: -sum(pair[0].bones + pair[1].bones))
    if not pairs:
        return {}, ()
    legs = pairs[0]
    inside = _inside(rig, legs)
    arms = next((pair for pair in pairs[1:] if not inside & {pair[0].top, pair[1].top}), None)
    body: dict[str, int] = {}
    _limbs(rig, legs, _LEG, body)
    if arms is not None:
        _limbs(rig, arms, _ARM, body)
    _trunk(rig, legs, arms, body)
    return _with_sides(rig, body)


def _pairs(rig: Rig) -> list[_Pair]:
    """Return all pairs of branches with equal bones."""
    found = []
    for children in rig.below:
        if len(children) < 2:
            continue
        longest = nlargest(_BRANCHES, children, key=rig.extent.__getitem__)
        limbs = [limb for child in longest if (limb := _limb(rig, child)) is not None]
        for one, other in combinations(limbs, 2):
            if all(
                abs(a - b) <= _ALIKE * max(a, b)
                for a, b in zip(one.bones, other.bones, strict=True)
            ):
                found.append((one, other))
    return found


def _limb(rig: Rig, top: int) -> _Limb | None:
    """Return the two longest bones in a row, where a branch has two; of equals the outer ones."""
    chain = _chain(rig, top)
    lengths = [rig.bones[joint] for joint in chain]
    sums = [one + two for one, two in pairwise(lengths[1:])]
    if not sums:
        return None
    best = max(k for k, length in enumerate(sums, 1) if length >= _EQUAL * max(sums))
    if min(lengths[best : best + 2]) < _THINNEST * max(lengths):
        return None
    first, middle, last = chain[best - 1 : best + 2]
    return _Limb(top, (first, middle, last), (lengths[best], lengths[best + 1]))


def _chain(rig: Rig, top: int) -> list[int]:
    """Return the joints of the longest branch, those in one place with the one before left out."""
    chain = [top]
    while rig.below[chain[-1]] and len(chain) < _LONGEST:
        joint = chain[-1]
        while rig.below[joint]:
            joint = max(rig.below[joint], key=rig.extent.__getitem__)
            if rig.bones[joint] > rig.nothing:
                break
        if rig.bones[joint] <= rig.nothing:
            break
        chain.append(joint)
    return chain


def _inside(rig: Rig, pair: _Pair) -> set[int]:
    """Return all joints of two branches."""
    inside = {pair[0].top, pair[1].top}
    for joint, parent in enumerate(rig.parents):
        if parent in inside:
            inside.add(joint)
    return inside


def _limbs(rig: Rig, pair: _Pair, names: tuple[str, str, str, str], body: dict[str, int]) -> None:
    for side, limb in zip("RL", pair, strict=True):
        body |= {side + name: joint for name, joint in zip(names, limb.joints, strict=False)}
        inner = limb.joints[-2] if names[-1] == "Toe" else None
        tip = rig.tip(limb.joints[-1], inner=inner)
        if tip is not None:
            body[side + names[-1]] = tip


def _trunk(rig: Rig, legs: _Pair, arms: _Pair | None, body: dict[str, int]) -> None:
    """Find pelvis, chest, neck and head."""
    pelvis = rig.parents[legs[0].top]
    if near_hips(rig, pelvis, body):
        body["Pelvis"] = pelvis
    if arms is None:
        return
    chest = rig.parents[arms[0].top]
    if chest not in above(rig.parents, body.get("Pelvis", -1)):
        body["Chest"] = chest
    limbs = {limb.top for limb in (*legs, *arms)}
    towards = set(above(rig.parents, pelvis))
    free = [child for child in rig.below[chest] if child not in limbs and child not in towards]
    if not free:
        return
    neck = _chain(rig, max(free, key=rig.extent.__getitem__))
    if rig.bones[neck[0]] <= rig.nothing and len(neck) > 1:
        neck = neck[1:]
    head = next((k for k, joint in enumerate(neck) if len(rig.below[joint]) > 1), None)
    if head is None:  # the last but one: behind it comes the tip of the head
        head = max(len(neck) - 2, 0)
    body["Neck"] = neck[0]
    body["Head"] = neck[head] if head > 0 else neck[-1]
    if len(neck) == 1:
        del body["Neck"]


def _with_sides(rig: Rig, body: dict[str, int]) -> tuple[dict[str, int], tuple[str, ...]]:
    """Exchange right and left where the body faces the other way."""
    poses = rig.poses
    ankles = (poses[:, body["RAnkle"]] + poses[:, body["LAnkle"]]) / 2
    top = body.get("Neck", body.get("Chest", body.get("Pelvis", body["RHip"])))
    up = (poses[:, top] - ankles).mean(axis=0)
    if {"RShoulder", "LShoulder"} <= body.keys():
        hips, arms = _across(poses, body, "Hip"), _across(poses, body, "Shoulder")
        if (hips * arms).sum() < 0:
            body = {_other(j) if j[1:] in _ARM else j: index for j, index in body.items()}
    forward = _side_by_name(rig, body) or _forward(poses, body, up)
    if forward < 0:
        body = {_other(joint): index for joint, index in body.items()}
    doubt = "which side is left could not be told for certain"
    return body, () if abs(forward) > _CLEAR else (doubt,)


def _side_by_name(rig: Rig, body: dict[str, int]) -> int:
    """Return 1 where names tell the same sides, -1: the other ones, 0: they do not tell them."""
    sides = [side for side, _ in keys(rig.names)]
    told = [sides[index] == joint[0] for joint, index in body.items()
            if _other(joint) != joint and sides[index]]  # fmt: skip
    return 0 if len(told) < 4 else 1 if all(told) else 0 if any(told) else -1


def _other(joint: str) -> str:
    paired = joint[0] in "RL" and joint[1:2].isupper()
    return {"R": "L", "L": "R"}[joint[0]] + joint[1:] if paired else joint


def _across(poses: Poses, body: dict[str, int], joint: str) -> Poses:
    return poses[:, body["R" + joint]] - poses[:, body["L" + joint]]


def _forward(poses: Poses, body: dict[str, int], up: Poses) -> float:
    """Return how far forward (1) or backward (-1) feet point; without feet, knees and hands."""
    forward = np.cross(up, _across(poses, body, "Hip"))
    at = {joint: poses[:, index] for joint, index in body.items()}
    if {"RToe", "LToe"} <= body.keys():
        points = [at[s + "Toe"] - at[s + "Ankle"] for s in "RL"]
    else:
        points = [2 * at[s + "Knee"] - at[s + "Hip"] - at[s + "Ankle"] for s in "RL"]
        points += [at[s + "Wrist"] - at[s + "Shoulder"] for s in "RL" if s + "Wrist" in body]
    total = np.sum(points, axis=0)
    total -= np.outer(total @ up, up) / (up @ up)
    sizes = np.linalg.norm(forward, axis=1) * np.linalg.norm(total, axis=1)
    return float((forward * total).sum() / max(sizes.sum(), 1e-12))


NEEDED = tuple(side + joint for side in "RL" for limb in LIMBS for joint in limb)

_SHOWN = 200  # letters of their names that a message shows
_LIKE = 75  # of 100: how much a misspelt name has to be like the right one


def find_body(
    rig: Rig, path: str = "", user_joints: Mapping[str, int] | None = None
) -> tuple[NDArray[np.int16], tuple[str, ...]]:
    """Return the joint for each of ``alphabet.JOINTS``, (20,), -1 where absent; and warnings."""
    body = by_name(rig) | dict(user_joints or {})
    warnings: tuple[str, ...] = ()
    named = dict(body)
    if not all(joint in body for joint in NEEDED):
        shaped, doubts = by_shape(rig)
        if all(shaped.get(joint, index) == index for joint, index in body.items()):
            taken = set(body.values())
            found = [j for j in JOINTS if j in shaped and j not in body and shaped[j] not in taken]
            body |= {joint: shaped[joint] for joint in found}
            if found:
                warnings = (f"recognised by shape, not by name: {', '.join(found)}", *doubts)
    if not (_has(body, ("Hip",)) and any(_has(body, limb) for limb in LIMBS)):
        missing = [joint for joint in NEEDED if joint not in named]
        whole = any(_has(named, limb, side) for limb in LIMBS for side in "RL")
        faces = any(_has(named, limb[:1]) for limb in LIMBS)  # two hips or shoulders
        if not (whole and faces) or _guess(rig, named, missing):
            missing = [joint for joint in NEEDED if joint not in body]
            raise BodyError(
                f"no human skeleton: among {len(rig.names)} joints "
                f"({shown(', '.join(rig.names), _SHOWN)}) there is no "
                f"{', '.join(missing)}{_guess(rig, body, missing)}",
                place=path,
                wanted="both hips, and both legs down to the ankles or "
                "both arms down to the wrists",
                remedy="If a body is there, say what plays its joints with --body FILE.",
            )
        body, warnings = named, (f"a part of a body: it has no {', '.join(missing)}",)
    under = _under_ankles(rig, body)
    if len(under) == 1 and ("RToe" in body or "LToe" in body):
        body |= under  # a rig's feet are alike: one alone is a foot that is pointed throughout
        under = {}
    result = np.full(len(JOINTS), -1, np.int16)
    for joint, index in body.items():
        result[JOINT_CODES[joint]] = index
    feet = (
        f'no {joint}: "{rig.names[index]}" lies straight under the ankle'
        for joint, index in under.items()
    )
    return result, (*warnings, *feet)


def _under_ankles(rig: Rig, body: Mapping[str, int]) -> dict[str, int]:
    """Return for each foot without a toe the joint that might have been one."""
    found: dict[str, int] = {}
    for side in "RL":
        if side + "Ankle" in body and side + "Toe" not in body:
            tip = rig.tip(body[side + "Ankle"], candidates(rig.names)["tips", side, "Toe"])
            if tip is not None:
                found[side + "Toe"] = tip
    return found


def _has(body: Mapping[str, int], joints: Sequence[str], sides: str = "RL") -> bool:
    return all(side + joint in body for side in sides for joint in joints)


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
