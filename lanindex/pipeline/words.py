"""A whole query that is a word of the dictionary: what it stands for, and who is labelled so."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING

from lanindex.search.dictionary import absent, entry_named, inside, load, spelled, words_of

__all__ = ["absent", "glob_of", "hints", "meant", "named", "said", "said_by", "unknown"]

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from lanindex.search.dictionary import Entry


def meant(text: str, words: str | PathLike[str] | None = None) -> Entry | None:
    """Return the entry that a whole query names: ``walk``, ``@walk``, ``a person walks``.

    Where the words have a meaning in the language as well, they are left to it, but for words of
    one's own.
    """
    name, known = spelled(text), load(words)
    if _is_part(text) and known.get(name) == load().get(name):
        return None
    if name in known:
        return known[name]
    from lanindex.search.language.natural import reading

    return entry_named(text, known) if words_of(text) and reading(text) is None else None


def hints(text: str, words: str | PathLike[str] | None = None) -> Iterator[str]:
    """Yield what there is to say of single words of a query that has several and is no pattern."""
    several = words_of(text)
    if len(several) < 2 or _is_pattern(text):
        return
    known = load(words)
    for word in several:
        entry = entry_named(word, known)
        if entry is not None:
            yield f'"{word}" is in the dictionary of movement: @{entry.name}'
        elif why := absent(word):
            yield f'no word "{word}" in the dictionary of movement: {why}'


def _is_part(text: str) -> bool:
    from lanindex.search.language.words import Vocabulary

    return Vocabulary().mover(text.strip().lower()) is not None


def _is_pattern(text: str) -> bool:
    from lanindex.errors import PatternError
    from lanindex.search.language import parse

    try:
        parse(text)
    except PatternError:
        return False
    return True


def said(text: str, words: str | PathLike[str] | None = None) -> str:
    """Return a query, or the pattern that it names."""
    entry = meant(text, words)
    return entry.pattern if entry else text


def named(text: str, words: str | PathLike[str] | None = None) -> dict[str, str]:
    """Return the patterns that a query may name with ``@``; nothing where it names none."""
    if "@" not in text:
        return {}
    return {name: inside(entry.pattern) for name, entry in load(words).items()}


def unknown(text: str) -> str:
    """Return the one word of a query that means nothing, neither alone nor in a pattern."""
    from lanindex.search.language.words import LANGUAGE, VALUES, Vocabulary

    name = spelled(text)
    one = name.isidentifier() and len(text.split()) == 1
    means = name in LANGUAGE or name in VALUES or Vocabulary().mover(name) is not None
    return name if one and not means else ""


def glob_of(name: str) -> str:
    """Return the glob of labels that say the same as a word: ``jumping?jack*``."""
    return name.replace("_", "?") + "*"


def said_by(labels: Iterable[str], glob: str) -> str:
    """Return the glob of labels, or the one label where that is all that fits it."""
    different = set(labels)
    return different.pop() if len(different) == 1 else glob
