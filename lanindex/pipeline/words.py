"""A whole query that is a word of the dictionary: what it stands for, and which words it uses."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import suppress
from os import PathLike

from lanindex.errors import PatternError
from lanindex.search.dictionary import (
    Entry,
    absent,
    entry_named,
    inside,
    load,
    spelled,
    words_of,
)
from lanindex.search.language import Query, parse
from lanindex.search.language.natural import reading
from lanindex.search.language.words import LANGUAGE, VALUES, Vocabulary


def query_of(
    text: str,
    parts: Collection[str],
    words: str | PathLike[str] | None = None,
    *,
    strict: bool = False,
) -> Query:
    """Read a query, or the pattern that it names, for captures with some parts."""
    entry = entry_of_query(text, words)
    pattern = entry.pattern if entry else text
    return parse(pattern, parts, names=named_patterns(pattern, words), strict=strict)


def entry_of_query(text: str, words: str | PathLike[str] | None = None) -> Entry | None:
    """Return the entry that a whole query names: ``walk``, ``@walk``, ``a person walks``.

    Where the words have a meaning in the language as well, they are left to it, but for words of
    one's own.
    """
    name, known = spelled(text), load(words)
    if Vocabulary().mover(text.strip().lower()) is not None and known.get(name) == load().get(name):
        return None
    if name in known:
        return known[name]
    return entry_named(text, known) if words_of(text) and reading(text) is None else None


def hints(text: str, words: str | PathLike[str] | None = None) -> Iterator[str]:
    """Yield what there is to say of single words of a query that has several and is no pattern."""
    several = words_of(text)
    if len(several) < 2:
        return
    with suppress(PatternError):
        parse(text)
        return
    known = load(words)
    for word in several:
        entry = entry_named(word, known)
        if entry is not None:
            yield f'"{word}" is in the dictionary of movement: @{entry.name}'
        elif why := absent(word):
            yield f'no word "{word}" in the dictionary of movement: {why}'


def named_patterns(text: str, words: str | PathLike[str] | None = None) -> dict[str, str]:
    """Return the patterns that a query may name with ``@``; nothing where it names none."""
    if "@" not in text:
        return {}
    return {name: inside(entry.pattern) for name, entry in load(words).items()}


def unknown(text: str) -> str:
    """Return the one word of a query that means nothing, neither alone nor in a pattern."""
    name = spelled(text)
    one = name.isidentifier() and len(text.split()) == 1
    means = name in LANGUAGE or name in VALUES or Vocabulary().mover(name) is not None
    return name if one and not means else ""
