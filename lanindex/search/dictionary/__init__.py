"""A dictionary of movement: everyday names for patterns, and how well each of them tells.

``dictionary.toml`` holds them; who has words of their own writes a file of the same form. Nothing
here knows a capture: an entry is text, and what was measured stands beside it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from os import PathLike
from pathlib import Path
from typing import Any

from lanindex.errors import NotationError, PatternError, UsageError, quoted, shown
from lanindex.notation.text import read_toml

FORM = 'name = {pattern = "...", sentence = "...", names = ["other name", ...]}'
"""What an entry looks like."""

_NEEDED = {"pattern": str}
_FREE = {"sentence": str, "names": list, "labels": list, "measured": dict}
_COMMENT = re.compile(r"//[^\n]*")
_EITHER = "either side"
_SIDED = re.compile(r"(?<![a-z])(?:right|left|[rl](?=_))(?![a-z])")
_SWAPPED = {"right": "left", "left": "right", "r": "l", "l": "r"}


@dataclass(frozen=True, slots=True)
class Measured:
    """What a pattern found among labelled captures.

    Attributes
    ----------
    right, wrong, missed : int
        Captures found that should be, found that should not, and not found that should be.
    clips : int
        Captures that were judged.
    collections : int
        Collections, each by other people and machines, in which it found something rightly.
    """

    right: int
    wrong: int
    missed: int
    clips: int
    collections: int

    @property
    def precision(self) -> float:
        """Which part of what it found was right."""
        return self.right / max(1, self.right + self.wrong)

    @property
    def recall(self) -> float:
        """Which part of what it should have found it did find."""
        return self.right / max(1, self.right + self.missed)


@dataclass(frozen=True, slots=True)
class Entry:
    """A word for a movement.

    Attributes
    ----------
    name : str
        What it is called, in small letters: ``jumping_jack``.
    pattern : str
        What that means, on one line.
    sentence : str
        The same in English.
    names : tuple of str
        What else it is called.
    labels : tuple of str
        Labels of the captures, or globs that fit them, that it was measured against.
    measured : Measured or None
        What it found; None: nobody has measured it.
    """

    name: str
    pattern: str
    sentence: str = ""
    names: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()
    measured: Measured | None = None


@cache
def _own() -> tuple[Entry, ...]:
    """Return the entries that come along."""
    with resources.as_file(resources.files(__name__).joinpath("dictionary.toml")) as path:
        return tuple(_entry(name, values, str(path)) for name, values in read_toml(path).items())


def spelled(text: str) -> str:
    """Return a name as the dictionary spells it: ``@Hands up`` is ``hands_up``.

    Parameters
    ----------
    text : str
        As typed.
    """
    return "_".join(text.strip().removeprefix("@").replace("-", " ").lower().split())


def load(extra: str | PathLike[str] | None = None) -> dict[str, Entry]:
    """Return all words, by each of their names.

    Parameters
    ----------
    extra : path-like, optional
        A file of one's own words; where a name is in both, its entry counts.

    Returns
    -------
    dict of str to Entry
        In order; an entry stands under its name and under every other name that is not the name
        of another.

    Raises
    ------
    UsageError
        Where the file cannot be read, an entry is none, a name is a word of the language, or a
        pattern is not understood.

    Examples
    --------
    >>> from lanindex.search.dictionary import load
    >>> words = load()
    >>> words["running"] is words["run"], words["bow"].sentence[:23]
    (True, 'The trunk leans forward')
    """
    entries = list(_own())
    if extra is not None:
        entries = [*entries, *_read(Path(extra))]
    also = {other: entry for entry in entries for other in entry.names}
    return {entry.name: entry for entry in entries} | {
        other: entry
        for other, entry in also.items()
        if other not in {entry.name for entry in entries}
    }


def absent(name: str) -> str:
    """Return why there is no such word, and what may be asked instead; empty where none is known.

    Parameters
    ----------
    name : str
        As `spelled`.

    Examples
    --------
    >>> from lanindex.search.dictionary import absent
    >>> absent("sitting")
    'there was no labelled capture to measure it on; try: other support seat/other 1s+'
    """
    with resources.as_file(resources.files(__name__).joinpath("absent.toml")) as path:
        words = read_toml(path)
    for word, entry in words.items():
        if name == word or name in entry["names"]:
            return "; try: ".join(filter(None, (entry["why"], entry["instead"])))
    return ""


def entries(words: Mapping[str, Entry]) -> list[Entry]:
    """Return each entry once.

    Parameters
    ----------
    words : Mapping of str to Entry
        As from `load`.
    """
    return [entry for name, entry in words.items() if name == entry.name]


def inside(pattern: str) -> str:
    """Return a pattern as it may stand inside another: ``either side`` is written out.

    Parameters
    ----------
    pattern : str
        One that is understood.

    Examples
    --------
    >>> from lanindex.search.dictionary import inside
    >>> inside("r_leg forward either side")
    'r_leg forward or mirror (r_leg forward)'
    """
    one = pattern.removesuffix(_EITHER)
    return pattern if one == pattern else f"{one}or mirror ({one.rstrip()})"


def mirrored(pattern: str) -> str:
    """Return a pattern's mirror image: right and left are exchanged, of parts and directions.

    Parameters
    ----------
    pattern : str
        One that is understood.
    """
    if pattern.endswith(_EITHER):
        return pattern
    return _SIDED.sub(lambda word: _SWAPPED[word[0]], pattern)


def mirror_image(entry: Entry, words: Mapping[str, Entry]) -> str:
    """Return the name of an entry's mirror image: ``itself``, or empty where it has no name.

    Parameters
    ----------
    entry : Entry
        One of `words`.
    words : Mapping of str to Entry
        As from `load`.
    """
    image = _ordered(mirrored(entry.pattern))
    if image == _ordered(entry.pattern):
        return "itself"
    return next((it.name for it in entries(words) if _ordered(it.pattern) == image), "")


def _ordered(pattern: str) -> str:
    """Return a pattern with all alternatives in one order: ``left/right`` is ``right/left``."""
    return " ".join("/".join(sorted(word.split("/"))) for word in pattern.split())


def _read(path: Path) -> list[Entry]:
    try:
        table = read_toml(path)
    except NotationError as error:
        raise UsageError(
            error.found, place=error.place, wanted=f"TOML: {FORM}", remedy=error.remedy
        ) from error
    found = [_entry(name, values, str(path)) for name, values in table.items()]
    for entry in found:
        _check(entry, f"{path}: {shown(entry.name)}")
    return found


def _entry(name: str, values: Any, place: str) -> Entry:
    wanted = {**_NEEDED, **_FREE}
    fits = isinstance(values, dict) and _NEEDED.keys() <= values.keys() <= wanted.keys()
    if not fits or not all(isinstance(value, wanted[key]) for key, value in values.items()):
        raise UsageError(f"{shown(name)} = {quoted(values)}", place=place, wanted=FORM)
    for listed in ("names", "labels"):
        if not all(isinstance(text, str) for text in values.get(listed, ())):
            raise UsageError(f"{listed} = {quoted(values[listed])}", place=place, wanted="texts")
    return Entry(
        spelled(name),
        " ".join(_COMMENT.sub(" ", values["pattern"]).split()),
        " ".join(values.get("sentence", "").split()),
        tuple(spelled(other) for other in values.get("names", ())),
        tuple(values.get("labels", ())),
        _measured(values["measured"], f"{place}: {shown(name)}") if "measured" in values else None,
    )


def _measured(values: dict[str, Any], place: str) -> Measured:
    wanted = list(Measured.__dataclass_fields__)
    if list(values) != wanted or not all(type(value) is int for value in values.values()):
        raise UsageError(
            f"measured = {quoted(values)}", place=place, wanted=f"whole numbers: {wanted}"
        )
    return Measured(**values)


def _check(entry: Entry, place: str) -> None:
    """Refuse an entry that no pattern could name, or that nobody could understand."""
    from lanindex.search.language import parse
    from lanindex.search.language.words import Vocabulary

    for name in (entry.name, *entry.names):
        if not name.isidentifier():
            raise UsageError(
                f'"{shown(name)}"', place=place, wanted="a name of letters: salute, left_turn"
            )
        if Vocabulary().taken(name):
            raise UsageError(
                f'"{name}" is a word of the language already',
                place=place,
                remedy="Call the movement something else.",
            )
    try:
        parse(entry.pattern)
    except PatternError as error:
        raise UsageError(f"the pattern is not understood\n{error}", place=place) from error
