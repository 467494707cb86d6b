"""Words that say something of a few tracks alone and elsewhere name a part: what a hand touches."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from lanindex.alphabet import CARRIERS, TOUCHED
from lanindex.search.language.words import VALUES

_PLURALS = {"foot": "feet"}
_OTHER = {"torso": "trunk"}


def _spellings(kind: str, names: Collection[str]) -> dict[str, tuple[str, str]]:
    """Return the words of a kind, by spelling: in the plural, too."""
    plural = {_PLURALS.get(name, f"{name}s"): name for name in names}
    known = {**dict(zip(names, names, strict=True)), **plural, **_OTHER}
    return {spelling: (kind, name) for spelling, name in known.items()}


OWN = {kind: _spellings(kind, it) for kind, it in (("touched", TOUCHED), ("carrier", CARRIERS))}
"""By kind, its words, as in ``words.VALUES``."""


def values(kinds: Collection[str]) -> Mapping[str, tuple[str, str]]:
    """Return the words that may be understood of tracks of which some kinds of words are said.

    Examples
    --------
    >>> from lanindex.search.language.things import values
    >>> values(["touched"])["knees"]
    ('touched', 'knee')
    >>> "knee" in values(["direction"])
    False
    """
    own = [OWN[kind] for kind in kinds if kind in OWN]
    return {word: it for known in (VALUES, *own) for word, it in known.items()} if own else VALUES
