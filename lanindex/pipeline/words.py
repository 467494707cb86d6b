"""A whole query that is a word of the dictionary: what it stands for, and who is labelled so."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING

from lanindex.search.dictionary import load, spelled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lanindex.model import Capture
    from lanindex.search.dictionary import Entry


def meant(text: str, words: str | PathLike[str] | None = None) -> Entry | None:
    """Return the entry that a whole query names: ``walk``, ``@walk``, ``jumping jack``.

    Parameters
    ----------
    text : str
        The query.
    words : path-like, optional
        A file of one's own words.

    Returns
    -------
    Entry or None
        None where the query is something else.

    Raises
    ------
    UsageError
        Where that file is no dictionary.
    """
    name = spelled(text)
    return load(words).get(name) if name.isidentifier() else None


def said(text: str, words: str | PathLike[str] | None = None) -> str:
    """Return a query, or the pattern that it names.

    Parameters
    ----------
    text, words
        As for `meant`.
    """
    entry = meant(text, words)
    return entry.pattern if entry else text


def named(text: str, words: str | PathLike[str] | None = None) -> dict[str, str]:
    """Return the patterns that a query may name with ``@``; nothing where it names none.

    Parameters
    ----------
    text, words
        As for `meant`.
    """
    if "@" not in text:
        return {}
    return {name: entry.pattern for name, entry in load(words).items()}


def glob_of(entry: Entry) -> str:
    """Return the glob of labels that say the same: ``jumping?jack*``."""
    return entry.name.replace("_", "?") + "*"


def said_by(captures: Sequence[Capture], glob: str) -> str:
    """Return the glob of labels, or the one label where that is all that fits it.

    Parameters
    ----------
    captures : sequence of Capture
        Those whose label fits.
    glob : str
        As from `glob_of`.
    """
    labels = {capture.label for capture in captures}
    return labels.pop() if len(labels) == 1 else glob
