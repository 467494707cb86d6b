"""What may stand at a position of a pattern, as the parser itself expects it there."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass
from os import PathLike
from typing import Any

from lanindex.data import shipped
from lanindex.search.dictionary import Entry, inside, load
from lanindex.search.language.parser import wanted
from lanindex.search.language.words import (
    RELATIONS,
    THINGS,
    UNITS,
    VALUES,
    WORD_KINDS,
    Vocabulary,
)

_FRAGMENT = re.compile(r"@?(?:[^\W\d]\w*)?\Z")
_REST = re.compile(r"\w*")
_MARKS = "-.<>=!()[]/?:;|+#"
_ALIKE = 60  # of 100: from which likeness on a misspelt word is corrected
_MOST_ALIKE = 5

_RANKS = (
    *("unit", "field", "direction", "level", "manner", "change", "bend", "degrees", "feet"),
    *("touched", "carrier", "pace", "extent", "part", "arrow", "relation", "compare", "number"),
    *("text", "clause", "stage", "word", "movement", "name", "count", "mark", "range", "notation"),
)
"""Every kind of completion, the likeliest first."""


@dataclass(frozen=True, slots=True)
class Completion:
    """A text that may stand at a position of a pattern.

    Examples
    --------
    >>> import lanindex
    >>> for it in lanindex.complete("r_arm ri"):
    ...     print(it.text, it.kind, it.start, it.stop, it.meaning)
    right direction 6 8 to the right
    rising change 6 8 to a higher level than before
    """

    text: str  # to insert
    kind: str  # part, direction, level, relation …: one of `_RANKS`
    start: int  # the characters that it replaces: a word that has been begun, or none
    stop: int
    meaning: str = ""  # in a few words, where there are any

    def record(self) -> dict[str, Any]:
        """Return it as JSON has it: these five keys."""
        return asdict(self)


def complete(
    text: str,
    position: int | None = None,
    *,
    parts: Collection[str] | None = None,
    words: str | PathLike[str] | None = None,
) -> list[Completion]:
    """Return what may stand at a position of a pattern, the likeliest first.

    Parameters
    ----------
    text : str
        A pattern, complete or not. What stands behind the position is not read.
    position : int, optional
        A number of characters; by default all of them.
    parts : collection of str, optional
        The parts that are offered; by default all. `Library.complete` offers its own.
    words : path-like, optional
        A file with words of your own for the dictionary of movement.

    Returns
    -------
    list of Completion
        Nothing where the parser stops before the position.

    Examples
    --------
    >>> import lanindex
    >>> [it.text for it in lanindex.complete("r_arm right mid ->", 8)]
    ['right', 'rising']
    """
    position = len(text) if position is None else max(0, min(position, len(text)))
    before = text[:position]
    begun = _FRAGMENT.search(before)
    fragment = begun.group().lower() if begun else ""
    start, stop = position - len(fragment), position + len(_REST.match(text, position)[0])  # type: ignore[index]
    names, vocabulary = load(words), Vocabulary(parts)
    patterns = {name: inside(entry.pattern) for name, entry in names.items()}

    def offered(text: str) -> dict[str, str]:
        return _offered(wanted(text, vocabulary, patterns))

    here, behind = offered(before[:start]), dict[str, str]()
    own = {it: kind for it, kind in here.items() if not _is_alias(it, kind, vocabulary, names)}
    if fragment:
        here = _beginning(own, fragment) or _beginning(here, fragment) or _alike(here, fragment)
        # a mark may follow a word without a space
        behind = {it: kind for it, kind in offered(before).items() if it[0] in _MARKS}
    else:
        here = own
    places = [(here, start, stop), (behind, position, position)]
    return [
        Completion(it, kind, begin, end, _meaning(it, kind, vocabulary, names))
        for chosen, begin, end in places
        for it, kind in chosen.items()
    ]


def _offered(found: Mapping[str, str]) -> dict[str, str]:
    """Return the texts that a parser wants with their kinds, ranked."""
    kinds = {RELATIONS.get(text, text): _kind(text, kind) for text, kind in found.items()}
    return dict(sorted(kinds.items(), key=lambda it: _RANKS.index(it[1])))


def _kind(text: str, kind: str) -> str:
    if kind == "word" and text in RELATIONS:
        return "relation"
    return "arrow" if kind == "dots" else kind


def _word(text: str, fragment: str) -> str:
    """Return a text as it is compared with what was typed: perhaps without its ``@``."""
    return text if fragment[0] == "@" else text.removeprefix("@")


def _beginning(offered: Mapping[str, str], fragment: str) -> dict[str, str]:
    return {it: kind for it, kind in offered.items() if _word(it, fragment).startswith(fragment)}


def _alike(offered: Mapping[str, str], fragment: str) -> dict[str, str]:
    """Return the texts that a word may be a misspelling of."""
    from rapidfuzz import process

    words = {it: _word(it, fragment) for it in offered}
    near = process.extract(fragment, words, limit=_MOST_ALIKE, score_cutoff=_ALIKE)
    return {it: offered[it] for _, _, it in near}


def _is_alias(text: str, kind: str, vocabulary: Vocabulary, names: Mapping[str, Entry]) -> bool:
    """Return whether a text is another spelling of one that is offered."""
    if kind == "part":
        return text in vocabulary.movers and vocabulary.movers[text].name != text
    if kind == "movement":
        return text[1:] in names and names[text[1:]].name != text[1:]
    known = {**VALUES, **THINGS.get(kind, {})}
    return (
        kind != "notation" and text in known and known[text][1].split()[0] not in (text, ">=45deg")
    )


def _meaning(text: str, kind: str, vocabulary: Vocabulary, names: Mapping[str, Entry]) -> str:
    english = shipped("search/language/english.toml")
    if kind == "movement":
        return names[text[1:]].sentence if text[1:] in names else ""
    if kind == "part" and (mover := vocabulary.movers.get(text)):
        members = " and ".join(mover.members)
        forms = {"either": f"either of {members}", "both": f"{members} together"}
        return forms.get(mover.form, "" if mover.name == text else mover.name)
    if kind == "relation":
        return str(english["relations"][text][0].format("…"))
    if kind == "unit":
        return UNITS.get(text, "degrees")
    table = {"field": "fields"}.get(kind, kind)
    return str(
        english.get(table, {}).get(text)
        or english["values" if kind in WORD_KINDS else "language"].get(text, "")
    )
