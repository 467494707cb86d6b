"""``lanindex words``: the dictionary of movement, and one word of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import UsageError, guess

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lanindex.search.dictionary import Entry, Measured


def run(
    word: Annotated[
        str | None, typer.Argument(metavar="WORD", help="Show this one: walk, hands_up.")
    ] = None,
    words: options.Words = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Show the dictionary of movement.

    Each word stands for a pattern, and can be searched: lanindex search walk. Precision and recall
    were measured on labelled captures. What patterns are made of: lanindex language.
    """
    out = Output(json, quiet, verbose, color)
    from lanindex.search.dictionary import entries, load

    known = load(words)
    chosen = entries(known) if word is None else [_named(known, word)]
    if json:
        for entry in chosen:
            out.record(_record(entry, known))
    elif word is None:
        _table(out, chosen)
        out.note("one in full: lanindex words walk; the language of patterns: lanindex language")
    else:
        _whole(out, chosen[0], known)


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

    counts = entry.measured
    return {
        "name": entry.name,
        "names": list(entry.names),
        "sentence": entry.sentence,
        "pattern": entry.pattern,
        "mirror_image": mirror_image(entry, known) or None,
        "labels": list(entry.labels),
        "precision": counts.precision if counts else None,
        "recall": counts.recall if counts else None,
        "found_rightly": counts.right if counts else None,
        "found_wrongly": counts.wrong if counts else None,
        "missed": counts.missed if counts else None,
        "clips": counts.clips if counts else None,
        "collections": counts.collections if counts else None,
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


def _whole(out: Output, entry: Entry, known: Mapping[str, Entry]) -> None:
    """Show one word in full: a line a field."""
    from lanindex.search.dictionary import mirror_image

    counts = entry.measured
    fields = {
        "word": entry.name,
        "also": ", ".join(entry.names),
        "means": entry.sentence,
        "pattern": entry.pattern,
        "mirrored": mirror_image(entry, known),
        "labels": ", ".join(entry.labels),
        "found": counts and _found(counts),
        "precision": counts and f"{counts.precision:.2f}",
        "recall": counts and f"{counts.recall:.2f}",
    }
    for name, value in fields.items():
        if value:
            out.line(out.paint(f"{name:9}", "dim"), "  ", value)


def _found(counts: Measured) -> str:
    from lanindex.app.formatting import counted

    wanted = counts.right + counts.missed
    return (
        f"{counts.right} of {counted(wanted, 'capture')}, in "
        f"{counted(counts.collections, 'collection')}; {counts.wrong} of "
        f"{counts.clips - wanted} others wrongly"
    )
