"""Shell completion: its installation, and the words it offers for patterns and captures."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from typer import Context

from lanindex.app.output import Output
from lanindex.errors import LanindexError, UsageError

if TYPE_CHECKING:
    from lanindex.pipeline import Library

VARIABLE = "_LANINDEX_COMPLETE"  # the environment variable in which a shell asks for completions

SHELLS = ("bash", "zsh", "fish", "powershell", "pwsh")

_FRAGMENT = re.compile(r"[\w@]*\Z")
_MOST = 200  # captures offered at once; a longer list helps nobody


def install() -> None:
    """Install completion for the shell that runs this."""
    from typer._completion_shared import install

    try:
        shell, path = install(shell=_shell(), prog_name="lanindex", complete_var=VARIABLE)
    except OSError as error:
        raise LanindexError(
            f"cannot be written ({error.strerror})", place=str(error.filename)
        ) from error
    Output().note(f"{path}: completes lanindex in {shell} from its next start on")


def show() -> None:
    """Print what `install` would install."""
    from typer._completion_shared import get_completion_script

    script = get_completion_script(prog_name="lanindex", complete_var=VARIABLE, shell=_shell())
    Output().text(script)


def _shell() -> str:
    from shellingham import ShellDetectionFailure, detect_shell

    try:
        shell = str(detect_shell()[0])
    except ShellDetectionFailure:
        shell = os.path.basename(os.environ.get("SHELL", ""))
    if shell not in SHELLS:
        raise UsageError(f'no shell that is known ("{shell}")', wanted=" or ".join(SHELLS))
    return shell


def patterns(ctx: Context, incomplete: str) -> list[str]:
    """Return the continuations of a pattern: parts and words, each behind what was typed before."""
    if incomplete.startswith("@"):
        return sorted(f"@{path}" for path in _pattern_files(incomplete[1:]))
    begin = len(incomplete) - len(_FRAGMENT.search(incomplete)[0])  # type: ignore[index]
    before, fragment = incomplete[:begin], incomplete[begin:].lower()
    words = _pattern_words(ctx, only_parts=not before.strip())
    return [before + word for word in words if word.startswith(fragment)]


def captures(ctx: Context, incomplete: str) -> list[str]:
    """Return captures whose path, or whose file's name, begins with what was typed."""
    return _from_library(ctx, lambda library: library.store.paths_starting(incomplete, _MOST))


def _pattern_files(begun: str) -> list[str]:
    from lanindex.notation import notation_of

    folder, name = begun.rpartition("/")[::2]
    prefix = f"{folder}/" if folder or begun.startswith("/") else ""
    return [
        prefix + path.name
        for path in Path(folder or ".").glob("*")
        if path.name.startswith(name) and (path.suffix.lower() == ".lq" or notation_of(path.name))
    ]


def _pattern_words(ctx: Context, *, only_parts: bool) -> list[str]:
    from lanindex.search.language.words import LANGUAGE, VALUES, Vocabulary

    parts = _from_library(ctx, lambda library: library.store.parts(checked=False))
    movers = {
        mover.name
        for mover in Vocabulary(parts).movers.values()
        if not parts or not {*parts}.isdisjoint(mover.members)
    }
    values = {name for _, name in VALUES.values() if " " not in name}
    return sorted(movers if only_parts else {*movers, *values, *LANGUAGE})


def _from_library(ctx: Context, query: Callable[[Library], list[str]]) -> list[str]:
    """Return what the library answers; nothing where it cannot be read."""
    from lanindex.pipeline import open_library

    try:
        with open_library(ctx.params["db"], readonly=True) as library:
            return query(library)
    except (LanindexError, OSError):
        return []
