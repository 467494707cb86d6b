"""The body by the names of its joints (`names.toml`), whatever a program calls them.

Nothing is invented: a joint that is not there stays absent.
"""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib import resources
from typing import Any

from lanindex.body.rig import Rig, near_hips

_NAMESPACE = re.compile(r"^.*[:|]")
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^\W\d_a-zA-Z]+")
_SHARED = 0.8
_GROUPS = ("middle", "limbs", "tips", "fingers")

Key = tuple[str, str]
"""Side (``L``, ``R`` or empty) and the name without it."""


@lru_cache(maxsize=1)
def tables() -> Mapping[str, Any]:
    """Return `names.toml`."""
    text = resources.files("lanindex.body").joinpath("names.toml").read_text("utf-8")
    return tomllib.loads(text)


@lru_cache(maxsize=1)
def _sides() -> Mapping[str, str]:
    letters = {"left": "L", "right": "R", "middle": ""}
    return {word: letters[side] for side, words in tables()["sides"].items() for word in words}


@lru_cache(maxsize=1)
def _known() -> frozenset[str]:
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
            if count < max(4, _SHARED * len(names)) or word in _sides() or word in _known():
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
    if name in _known():
        return "", name
    for mark, side in _sides().items():
        if not side:
            continue
        for rest in (name.removeprefix(mark), name.removesuffix(mark)):
            if rest != name and rest in _known():
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
_Limb = tuple[str, str, str]

LIMBS: tuple[_Limb, ...] = (("Shoulder", "Elbow", "Wrist"), ("Hip", "Knee", "Ankle"))
_TIPS = {"Wrist": "Hand", "Ankle": "Toe"}


def by_name(rig: Rig) -> dict[str, int]:
    """Find the body by the names of joints."""
    found = candidates(rig.names)
    body: dict[str, int] = {}
    for side in "RL":
        for limb in LIMBS:
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
    inner, outer = (body.get(side + joint) for joint in limb[1:])
    if outer is not None:
        named = found["tips", side, _TIPS[limb[-1]]]
        tip = rig.tip(outer, named, inner if limb[-1] == "Ankle" else None)
        if tip is not None:
            body[side + _TIPS[limb[-1]]] = tip


def _pelvis(rig: Rig, found: Candidates, body: dict[str, int]) -> None:
    named = found["middle", "", "Pelvis"]
    if not {"RHip", "LHip", "RKnee"} <= body.keys():
        if named:
            body["Pelvis"] = named[0]
        return
    meeting = rig.meeting(body["RHip"], body["LHip"])
    chest = next(iter(found["middle", "", "Chest"]), None)  # what names call so lies low in some
    for index in (*named, *([meeting] if meeting not in (None, chest) else [])):
        if near_hips(rig, index, body):
            body["Pelvis"] = index
            return


def _neck_head(rig: Rig, found: Candidates, body: dict[str, int]) -> None:
    """Find neck and head; a head that stands for both (no neck, or in one place) gives its tip."""
    neck, head = (next(iter(found["middle", "", joint]), None) for joint in ("Neck", "Head"))
    tips = found["tips", "", "Head"]
    if head is None:
        head = rig.tip(neck, tips) if neck is not None else None
    elif neck is None or rig.distance(neck, head) <= rig.nothing:
        tip = rig.tip(head, tips)
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
