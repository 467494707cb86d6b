"""A dictionary of movement: everyday names for patterns, and how well each pattern finds them.

``dictionary.toml`` holds them; users may write a file of the same form with words of their own.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from itertools import product
from os import PathLike
from pathlib import Path
from typing import Any

from lanindex.data import shipped
from lanindex.errors import (
    NotationError,
    PatternError,
    UsageError,
    did_you_mean,
    quoted,
    shown,
)
from lanindex.notation.text import read_toml

FORM = 'name = {pattern = "...", sentence = "...", names = ["other name", ...]}'

_FIELDS = {"pattern": str, "sentence": str, "names": list, "labels": list, "measured": dict}
_COMMENT = re.compile(r"//[^\n]*")
_EITHER = "either side"
_SIDED = re.compile(r"(?<![a-z])(?:right|left|[rl](?=_))(?![a-z])")
_SWAPPED = {"right": "left", "left": "right", "r": "l", "l": "r"}

_ABSENT = "search/dictionary/absent.toml"
_SLOT = re.compile(r"{(\w+)}")  # in a name of absent.toml
_ENDING = re.compile(r"(?<=...)(?:ing|es|ed|s)\Z")


@dataclass(frozen=True, slots=True)
class Measured:
    """What a pattern found among labelled captures that were left out while it was made."""

    right: int  # captures found that should be
    wrong: int  # found that should not
    missed: int  # not found that should be
    clips: int  # all that were judged
    collections: int  # by other people and machines each, that have something to find

    @property
    def wanted(self) -> int:
        """How many captures it should find."""
        return self.right + self.missed

    @property
    def tells(self) -> bool:
        """Whether it was seen often enough for a figure: on ten captures of two collections."""
        return self.wanted >= 10 and self.collections >= 2

    @property
    def precision(self) -> float | None:
        """The share of what it found that was right; None where it was seen too seldom."""
        return self.right / max(1, self.right + self.wrong) if self.tells else None

    @property
    def recall(self) -> float | None:
        """The share of what it should have found that it did find; None as above."""
        return self.right / self.wanted if self.tells else None


@dataclass(frozen=True, slots=True)
class Entry:
    """A word for a movement."""

    name: str  # in small letters: jumping_jack
    pattern: str  # on one line
    sentence: str = ""  # the same in English
    names: tuple[str, ...] = ()  # others that it has
    labels: tuple[str, ...] = ()  # of the captures, or globs, that it was measured against
    measured: Measured | None = None  # None: nobody has measured it


def spelled(text: str) -> str:
    """Return a name as the dictionary spells it: ``@Hands up`` is ``hands_up``."""
    return "_".join(text.strip().removeprefix("@").replace("-", " ").lower().split())


def load(extra: str | PathLike[str] | None = None) -> dict[str, Entry]:
    """Return all words by each of their names; those of the file `extra` come before ours."""
    entries = [*_ours(), *(_read(Path(extra)) if extra is not None else ())]
    words = {entry.name: entry for entry in entries}
    also = {other: entry for entry in entries for other in entry.names}
    return words | {other: entry for other, entry in also.items() if other not in words}


@dataclass(frozen=True, slots=True)
class Absent:
    """What people ask for and no word of the dictionary means."""

    why: str
    instead: str  # the pattern that means it, or nearly

    def __str__(self) -> str:
        return f"{self.why}; try: {self.instead}"


def absent(text: str) -> Absent | None:
    """Return what is said of words that the dictionary lacks, in any order and with any ending."""
    return _absent().get(tuple(_stems(words_of(text.replace("_", " ")))))


@cache
def _absent() -> Mapping[tuple[str, ...], Absent]:
    """Return what ``absent.toml`` has, each slot filled with each of its words."""
    table = dict(shipped(_ABSENT))
    del table["left_out"]
    slots = {
        slot: [(value, word) for value, also in values.items() for word in (value, *also)]
        for slot, values in table.pop("slots").items()
    }
    found: dict[tuple[str, ...], Absent] = {}
    for entry in table.values():
        for name in entry["names"]:
            open_slots = _SLOT.findall(name)
            for filled in product(*(slots[slot] for slot in open_slots)):
                values = {slot: it[0] for slot, it in zip(open_slots, filled, strict=True)}
                words = {slot: it[1] for slot, it in zip(open_slots, filled, strict=True)}
                said = _stems(name.format(**words).split("_"))
                meant = Absent(entry["why"], entry["instead"].format(**values))
                found.setdefault(tuple(said), meant)
    return found


def entries(words: Mapping[str, Entry]) -> list[Entry]:
    """Return each entry once."""
    return [entry for name, entry in words.items() if name == entry.name]


def entry_of(words: Mapping[str, Entry], word: str) -> Entry:
    """Return the entry that has this name; say what is meant where none has it."""
    name = spelled(word)
    if name in words:
        return words[name]
    found = f'no word "{shown(word)}" in the dictionary of movement'
    if why := absent(name):
        raise UsageError(f"{found}: {why}")
    remedy = did_you_mean(name, words) or "All are shown by: lanindex words"
    raise UsageError(found, remedy=remedy)


def record(entry: Entry, words: Mapping[str, Entry]) -> dict[str, Any]:
    """Return an entry as JSON has it."""
    names = ("precision", "recall", "right", "wrong", "missed", "clips", "collections")
    keys = {"right": "found_rightly", "wrong": "found_wrongly"}
    return {
        "name": entry.name,
        "names": list(entry.names),
        "sentence": entry.sentence,
        "pattern": entry.pattern,
        "mirror_image": mirror_image(entry, words) or None,
        "labels": list(entry.labels),
        **{keys.get(name, name): getattr(entry.measured, name, None) for name in names},
    }


def named_patterns(text: str, words: str | PathLike[str] | None = None) -> dict[str, str]:
    """Return the patterns that a query may name with ``@``; nothing where it names none."""
    if "@" not in text:
        return {}
    return {name: inside(entry.pattern) for name, entry in load(words).items()}


def inside(pattern: str) -> str:
    """Return a pattern as it may stand inside another: ``either side`` is written out."""
    one = pattern.removesuffix(_EITHER)
    return pattern if one == pattern else f"{one}or mirror ({one.rstrip()})"


def mirrored(pattern: str) -> str:
    """Return a pattern with right and left exchanged, of parts and directions."""
    swapped = _SIDED.sub(lambda word: _SWAPPED[word[0]], pattern)
    return pattern if pattern.endswith(_EITHER) else swapped


def mirror_image(entry: Entry, words: Mapping[str, Entry]) -> str:
    """Return the name of an entry's mirror image: ``itself``, or empty where it has no name."""
    image = _ordered(mirrored(entry.pattern))
    if image == _ordered(entry.pattern):
        return "itself"
    return next((it.name for it in entries(words) if _ordered(it.pattern) == image), "")


def _ordered(pattern: str) -> str:
    """Return a pattern with all alternatives in one order: ``left/right`` is ``right/left``."""
    return " ".join("/".join(sorted(word.split("/"))) for word in pattern.split())


def words_of(text: str) -> list[str]:
    """Return the words of a text; none where it is more than words."""
    plain = text.lower().replace("-", " ").split()
    return plain if all(re.fullmatch(r"[a-z]+", word) for word in plain) else []


def entry_named(text: str, words: Mapping[str, Entry]) -> Entry | None:
    """Return the entry that these words name, in any order and with any ending."""
    spoken = _stems(words_of(text))
    found = (entry for name, entry in words.items() if _stems(name.split("_")) == spoken)
    return next(found, None) if spoken else None


def _stems(words: list[str]) -> list[str]:
    """Return words without endings, in order: ``clap`` of ``clapping``, ``wav`` of ``waves``."""
    return sorted(_stem(word) for word in words if word not in shipped(_ABSENT)["left_out"])


def _stem(word: str) -> str:
    word = _ENDING.sub("", word)
    if len(word) > 3 and word[-1] == word[-2]:
        word = word[:-1]
    return word.removesuffix("e")


def _read(path: Path) -> list[Entry]:
    """Return the entries of a user's file."""
    try:
        found = _entries(read_toml(path), str(path))
    except NotationError as error:
        raise UsageError(
            error.found, place=error.place, wanted=f"TOML: {FORM}", remedy=error.remedy
        ) from error
    for entry in found:
        _check(entry, f"{path}: {shown(entry.name)}")
    return found


@cache
def _ours() -> list[Entry]:
    return _entries(shipped("search/dictionary/dictionary.toml"), "dictionary.toml")


def _entries(table: dict[str, Any], place: str) -> list[Entry]:
    return [_entry(name, values, place) for name, values in table.items()]


def _entry(name: str, values: Any, place: str) -> Entry:
    fits = isinstance(values, dict) and {"pattern"} <= values.keys() <= _FIELDS.keys()
    if not fits or not all(isinstance(value, _FIELDS[key]) for key, value in values.items()):
        raise UsageError(f"{shown(name)} = {quoted(values)}", place=place, wanted=FORM)
    for listed in ("names", "labels"):
        if not all(isinstance(text, str) for text in values.get(listed, ())):
            raise UsageError(f"{listed} = {quoted(values[listed])}", place=place, wanted="texts")
    counts, numbers = values.get("measured"), list(Measured.__dataclass_fields__)
    if counts is not None and (
        list(counts) != numbers or not all(type(count) is int for count in counts.values())
    ):
        place, wanted = f"{place}: {shown(name)}", f"whole numbers: {numbers}"
        raise UsageError(f"measured = {quoted(counts)}", place=place, wanted=wanted)
    return Entry(
        spelled(name),
        " ".join(_COMMENT.sub(" ", values["pattern"]).split()),
        " ".join(values.get("sentence", "").split()),
        tuple(spelled(other) for other in values.get("names", ())),
        tuple(values.get("labels", ())),
        None if counts is None else Measured(**counts),
    )


def _check(entry: Entry, place: str) -> None:
    """Refuse an entry with an impossible name, or with a pattern that does not parse."""
    from lanindex.search.language import parse
    from lanindex.search.language.words import Vocabulary

    for name in (entry.name, *entry.names):
        if not name.isidentifier():
            wanted = "a name of letters: salute, left_turn"
            raise UsageError(f'"{shown(name)}"', place=place, wanted=wanted)
        if Vocabulary().meaning_of(name):
            found, remedy = "is a word of the language already", "Call the movement something else."
            raise UsageError(f'"{name}" {found}', place=place, remedy=remedy)
    try:
        parse(entry.pattern)
    except PatternError as error:
        raise UsageError(f"the pattern is not understood\n{error}", place=place) from error
