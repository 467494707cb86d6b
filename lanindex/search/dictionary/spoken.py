"""Words as people speak them: ``waves``, ``a person walks``, ``wave with the right hand``."""

from __future__ import annotations

import re
from collections.abc import Mapping

from lanindex.search.dictionary import Entry

_LEFT_OUT = {
    *("a", "an", "the", "his", "her", "their", "he", "she", "they", "someone", "somebody"),
    *("person", "dancer", "man", "woman", "is", "are", "with"),
}
"""What may stand in between and says nothing."""

_ENDINGS = ("ing", "es", "ed", "s")
_SHORTEST = 3


def words_of(text: str) -> list[str]:
    """Return the words of a text; none where it is more than words.

    Parameters
    ----------
    text : str
        A query.
    """
    plain = text.lower().replace("-", " ").split()
    return plain if all(re.fullmatch(r"[a-z]+", word) for word in plain) else []


def called(text: str, words: Mapping[str, Entry]) -> Entry | None:
    """Return the entry that has the words of a text for a name, in any order and with any ending.

    Parameters
    ----------
    text : str
        A query.
    words : Mapping of str to Entry
        As from `load`.

    Examples
    --------
    >>> from lanindex.search.dictionary import load
    >>> from lanindex.search.dictionary.spoken import called
    >>> called("someone waves with the right hand", load()).name
    'wave_right'
    """
    said = _stems(words_of(text))
    if not said:
        return None
    found = (entry for name, entry in words.items() if _stems(name.split("_")) == said)
    return next(found, None)


def _stems(words: list[str]) -> list[str]:
    return sorted(_stem(word) for word in words if word not in _LEFT_OUT)


def _stem(word: str) -> str:
    """Return a word without its ending: ``clap`` of ``clapping``, ``wav`` of ``waves``."""
    for ending in _ENDINGS:
        if word.endswith(ending) and len(word) - len(ending) >= _SHORTEST:
            word = word.removesuffix(ending)
            break
    if len(word) > _SHORTEST and word[-1] == word[-2]:
        word = word[:-1]
    return word.removesuffix("e")
