"""Joint names, whatever a program calls them: which side, and which word of `names.toml`."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib import resources
from typing import Any

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
