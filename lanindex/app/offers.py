"""What a shell offers to complete an argument with: words of a pattern, captures."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from lanindex.errors import LanindexError
from lanindex.notation import notation_of

if TYPE_CHECKING:
    from typer import Context

    from lanindex.pipeline import Library

_FRAGMENT = re.compile(r"[\w@]*\Z")
_MOST = 200
"""Captures that are offered at once; a longer list helps nobody."""


def patterns(ctx: Context, incomplete: str) -> list[str]:
    """Return the continuations of a pattern: parts and words, each behind what was typed before."""
    if incomplete.startswith("@"):
        return sorted(f"@{path}" for path in _files(incomplete[1:]))
    begin = len(incomplete) - len(_FRAGMENT.search(incomplete)[0])  # type: ignore[index]
    before, fragment = incomplete[:begin], incomplete[begin:].lower()
    return [before + word for word in _words(ctx, not before.strip()) if word.startswith(fragment)]


def captures(ctx: Context, incomplete: str) -> list[str]:
    """Return the paths of captures that begin with what was typed, or whose file's name does."""
    return _held(ctx, lambda library: library.begun(incomplete, _MOST))


def _files(begun: str) -> list[str]:
    folder, name = begun.rpartition("/")[::2]
    found = Path(folder or ".").glob("*")
    prefix = f"{folder}/" if folder or begun.startswith("/") else ""
    return [
        prefix + path.name
        for path in found
        if path.name.startswith(name) and (path.suffix.lower() == ".lq" or notation_of(path.name))
    ]


def _words(ctx: Context, only_parts: bool) -> list[str]:
    from lanindex.search.language.words import LANGUAGE, VALUES, Vocabulary

    parts = _held(ctx, lambda library: library.parts(checked=False))
    movers = {
        mover.name
        for mover in Vocabulary(parts).movers.values()
        if not parts or not {*parts}.isdisjoint(mover.members)
    }
    own = {name for _, name in VALUES.values() if " " not in name}
    return sorted(movers if only_parts else {*movers, *own, *LANGUAGE})


def _held(ctx: Context, asked: Callable[[Library], list[str]]) -> list[str]:
    """Return what the library tells; nothing where it cannot be asked."""
    from lanindex.pipeline import open_library

    try:
        with open_library(ctx.params["db"], readonly=True) as library:
            return asked(library)
    except (LanindexError, OSError):
        return []
