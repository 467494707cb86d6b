"""What a query means that is a word of the dictionary: said beside the results."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lanindex.app.output import Output
    from lanindex.pipeline import Library


def of(out: Output, library: Library, asked: str, words: str | PathLike[str] | None) -> str:
    """Return the pattern that a query stands for, and say so; itself where it is one."""
    from lanindex.pipeline.words import absent, hints, meant, unknown

    entry = meant(asked, words)
    if entry is not None:
        told = f": {entry.sentence}" if entry.sentence else ""
        out.note(f"{entry.name}{told} (lanindex words {entry.name})")
        _labelled(out, library, entry.name)
        return entry.pattern
    if name := unknown(asked):
        why = absent(name) or "lanindex words"
        out.note(f'no word "{name}" in the dictionary of movement: {why}')
        _labelled(out, library, name)
    for hint in hints(asked, words):
        out.note(hint)
    return asked


def _labelled(out: Output, library: Library, name: str) -> None:
    """Say which captures are labelled with a word."""
    from lanindex.app.formatting import counted
    from lanindex.pipeline.words import glob_of, said_by

    labelled = library.numbers(where=[("label", glob_of(name))])
    if labelled:
        label = said_by(library.called("label", labelled).values(), glob_of(name))
        verb = "is" if len(labelled) == 1 else "are"
        out.note(
            f'{counted(len(labelled), "capture")} {verb} labelled "{label}": '
            f'lanindex list --where "label={label}"'
        )
