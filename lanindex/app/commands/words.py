"""The verbs about patterns: words (the dictionary of movement) and language."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import options
from lanindex.app.output import Output, counted
from lanindex.errors import UsageError, guess

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lanindex.pipeline import Library
    from lanindex.search.dictionary import Entry


_MEASURED = {
    "precision": "precision",
    "recall": "recall",
    "found_rightly": "right",
    "found_wrongly": "wrong",
    "missed": "missed",
    "clips": "clips",
    "collections": "collections",
}
"""Keys of a record, and the measured counts they hold."""


def language(color: options.Color = "auto") -> None:
    """Show the pattern language on one page: parts, directions, heights, times and all else."""
    from importlib.resources import files

    page = files("lanindex.search").joinpath("LANGUAGE.md").read_text(encoding="utf-8")
    Output(color=color).content(page)


def words(
    word: Annotated[
        str | None, typer.Argument(metavar="WORD", help="Show this one: walk, hands_up.")
    ] = None,
    words: options.Words = None,
    *,
    out: options.Out,
) -> None:
    """Show the dictionary of movement.

    Each word stands for a pattern, and can be searched: lanindex search walk. Precision and recall
    were measured on labelled captures. What patterns are made of: lanindex language.
    """
    from lanindex.search.dictionary import entries, load

    known = load(words)
    chosen = entries(known) if word is None else [_named(known, word)]
    if out.json:
        for entry in chosen:
            out.record(_record(entry, known))
    elif word is None:
        _table(out, chosen)
        out.note("one in full: lanindex words walk; the language of patterns: lanindex language")
    else:
        _in_full(out, chosen[0], known)


def pattern_of(out: Output, library: Library, query: str, words: str | PathLike[str] | None) -> str:
    """Return the pattern that a query stands for, and say which word of the dictionary it is."""
    from lanindex.pipeline.words import absent, hints, meant, unknown

    entry = meant(query, words)
    if entry is not None:
        sentence = f": {entry.sentence}" if entry.sentence else ""
        out.note(f"{entry.name}{sentence} (lanindex words {entry.name})")
        _labelled(out, library, entry.name)
        return entry.pattern
    if name := unknown(query):
        why = absent(name) or "lanindex words"
        out.note(f'no word "{name}" in the dictionary of movement: {why}')
        _labelled(out, library, name)
    for hint in hints(query, words):
        out.note(hint)
    return query


def _labelled(out: Output, library: Library, name: str) -> None:
    """Say which captures are labelled with a word."""
    from lanindex.library.selection import Selection
    from lanindex.pipeline.words import glob_of, said_by

    labelled = library.store.numbers(Selection(where={"label": glob_of(name)}))
    if labelled:
        label = said_by(library.store.texts("label", labelled).values(), glob_of(name))
        verb = "is" if len(labelled) == 1 else "are"
        out.note(
            f'{counted(len(labelled), "capture")} {verb} labelled "{label}": '
            f'lanindex list --where "label={label}"'
        )


def _named(known: Mapping[str, Entry], word: str) -> Entry:
    from lanindex.search.dictionary import absent, spelled

    entry = known.get(spelled(word))
    if entry is None:
        if why := absent(spelled(word)):
            raise UsageError(f'no word "{word}" in the dictionary of movement: {why}')
        near = guess(spelled(word), known)
        remedy = f"Did you mean {near}?" if near else "All are shown by: lanindex words"
        raise UsageError(f'no word "{word}" in the dictionary of movement', remedy=remedy)
    return entry


def _record(entry: Entry, known: Mapping[str, Entry]) -> dict[str, Any]:
    from lanindex.search.dictionary import mirror_image

    return {
        "name": entry.name,
        "names": list(entry.names),
        "sentence": entry.sentence,
        "pattern": entry.pattern,
        "mirror_image": mirror_image(entry, known) or None,
        "labels": list(entry.labels),
        **{key: getattr(entry.measured, name, None) for key, name in _MEASURED.items()},
    }


def _table(out: Output, chosen: list[Entry]) -> None:
    from textwrap import wrap

    from lanindex.app.columns import cut, room

    head = ("word", "precision", "recall", "found", "sentence")
    if not out.terminal:
        rows = [[*_figures(entry), entry.sentence, entry.pattern] for entry in chosen]
        out.table((*head, "pattern"), rows)
        return
    wide = max(len("word"), *(len(entry.name) for entry in chosen))
    out.line(out.paint(f"{'word':{wide}}  precision  recall     found", "dim"))
    for entry in chosen:
        name, precision, recall, found = _figures(entry)
        out.line(out.paint(f"{name:{wide}}", "match"), f"  {precision:>9}  {recall:>6}  {found:>8}")
        for line in wrap(entry.sentence, max(24, room() - 2)):
            out.line("  ", line)
        out.line("  ", out.paint(cut(entry.pattern, room() - 2), "dim"))


def _figures(entry: Entry) -> list[str]:
    counts = entry.measured
    if counts is None:
        return [entry.name, "", "", ""]
    found = f"{counts.right} of {counts.right + counts.missed}"
    return [entry.name, f"{counts.precision:.2f}", f"{counts.recall:.2f}", found]


def _in_full(out: Output, entry: Entry, known: Mapping[str, Entry]) -> None:
    """Show one word in full, a field per line."""
    from lanindex.search.dictionary import mirror_image

    counts = entry.measured
    fields = {
        "word": entry.name,
        "also": ", ".join(entry.names),
        "means": entry.sentence,
        "pattern": entry.pattern,
        "mirrored": mirror_image(entry, known),
        "labels": ", ".join(entry.labels),
    }
    if counts:
        wanted = counts.right + counts.missed
        fields["found"] = (
            f"{counts.right} of {counted(wanted, 'capture')}, in "
            f"{counted(counts.collections, 'collection')}; {counts.wrong} of "
            f"{counts.clips - wanted} others wrongly"
        )
        fields["precision"], fields["recall"] = f"{counts.precision:.2f}", f"{counts.recall:.2f}"
    for name, value in fields.items():
        if value:
            out.line(out.paint(f"{name:9}", "dim"), "  ", value)
