"""``lanindex motifs``: sequences of symbols that recur."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output, end_progress

if TYPE_CHECKING:
    from lanindex.pipeline.motifs import Motifs, Recurring

ON_A_TERMINAL = 20
"""Motifs that a terminal shows where no limit is set."""


def run(
    least: Annotated[
        int, typer.Option("--min-count", metavar="N", help="How often one occurs at least.")
    ] = 5,
    length: Annotated[
        int, typer.Option("--length", metavar="N", help="How many symbols it has at least.")
    ] = 3,
    part: Annotated[
        list[str] | None, typer.Option("--part", metavar="PART", help="Only of this part.")
    ] = None,
    limit: Annotated[
        int | None,
        typer.Option("--limit", "-n", min=1, help="Motifs to show: 20 on a terminal, else all."),
    ] = None,
    every: Annotated[
        bool, typer.Option("--all", help="Look through all captures, where else 5,000 are taken.")
    ] = False,
    within: options.In = None,
    where: options.Where = None,
    timeout: options.Timeout = None,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """List the sequences of symbols that recur.

    Each is a pattern to be pasted into a search, which has just as many hits. First comes what
    accounts for most symbols, then what accounts for most of the others. Of sequences that occur
    as often as a longer one around them only that is told. Exits with 1 if nothing recurs.
    """
    out = Output(json, quiet, verbose, color)
    from lanindex.app.formatting import counted
    from lanindex.pipeline import open_library
    from lanindex.pipeline.motifs import SAMPLE

    with open_library(db, readonly=True) as library:
        library.tell, library.watch = out.note, out.watch
        found = library.motifs(
            min_count=least,
            length=length,
            parts=part,
            sample=None if every else SAMPLE,
            within=within,
            where=options.where(where),
            timeout=timeout,
        )
    end_progress()
    motifs = found.found
    shown = motifs[: limit or (ON_A_TERMINAL if out.terminal else None)]
    _show(out, shown, found)
    for line in found.told:
        out.note(line)
    if found.captures < found.of:
        sample = f"{found.captures:,} of {counted(found.of, 'capture')}"
        out.note(f"{sample}, taken at random, were looked through: --all looks through all")
    cut = f"; {len(shown)} are shown, --limit shows more" if len(shown) < len(motifs) else ""
    captures = counted(found.captures, "capture")
    out.note(f"{counted(len(motifs), 'motif')} in {captures}{cut}")
    if not motifs:
        raise typer.Exit(1)


def _show(out: Output, shown: list[Recurring], found: Motifs) -> None:
    from lanindex import records
    from lanindex.app.formatting import counted

    for motif in shown:
        if out.json:
            places = [(place.capture, place.span) for place in motif.places]
            counts = motif.captures, places, found.captures, found.of
            out.record(records.of_motif(motif.pattern, motif.part, *counts))
            continue
        first = motif.places[0]
        span = f"[{first.span.start}, {first.span.stop})"
        if not out.terminal:
            out.row([motif.hits, motif.captures, motif.pattern, first.capture.path, span])
            continue
        told = f"{counted(motif.hits, 'hit')} in {counted(motif.captures, 'capture')}"
        out.line(out.paint(motif.pattern, "match"))
        out.line(out.paint(f"    {told}, first {first.capture.path} {span}", "dim"))
