"""``lanindex export``: write hits as clips."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import meaning, options
from lanindex.app.output import Output, end_progress
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.pipeline.requests import Request


def run(
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="PATTERN|-",
            help="A pattern, or - for hits from search --json.",
            autocompletion=options.offered("patterns"),
        ),
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FOLDER", help="Where to.")] = (
        Path("clips")
    ),
    capture: Annotated[
        str | None,
        typer.Option(
            "--capture",
            metavar="PATH|ID",
            help="Cut from this capture.",
            autocompletion=options.offered("captures"),
        ),
    ] = None,
    begin: Annotated[
        int | None, typer.Option("--from", metavar="FRAME", min=0, help="First frame.")
    ] = None,
    end: Annotated[
        int | None, typer.Option("--to", metavar="FRAME", min=1, help="Frame after the last.")
    ] = None,
    format: Annotated[
        str, typer.Option(metavar="native|bvh|c3d|...|lnd", help="What to write: --format ? tells.")
    ] = "native",
    origin: Annotated[
        bool, typer.Option("--origin", help="Begin at the floor's origin, facing forward.")
    ] = False,
    pad: Annotated[
        str, typer.Option(metavar="TIME", help="Time around each hit: 0.5s, 200ms, 10f.")
    ] = "0",
    within: options.In = None,
    where: options.Where = None,
    overlaps: options.Overlaps = "none",
    strict: options.Strict = False,
    tolerance: options.Tolerance = 0.1,
    near: options.Near = False,
    fuzzy: options.Fuzzy = None,
    words: options.Words = None,
    force: Annotated[bool, typer.Option("--force", help="Replace files that are there.")] = False,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Write hits as clips, in the format they came in or another.

    A clip in its source's format is cut out of it, byte for byte where the format allows that; in
    another (--format), or at the origin (--origin), it is written anew. Beside each stands its
    score (.lnd), and a manifest lists them all.
    """
    out = Output(json, quiet, verbose, color)
    how: dict[str, Any] = {"tolerance": tolerance, "overlaps": overlaps, "strict": strict}
    how |= {"near": near, "fuzzy": fuzzy, "within": within, "where": options.where(where)}
    _one_thing(what, capture)
    if capture is None and not (begin is None and end is None):
        raise UsageError("--from and --to", wanted="--capture beside them")
    if (where or within is not None) and (capture is not None or what == "-"):
        raise UsageError("--in and --where", wanted="a pattern beside them")
    from lanindex.app.formatting import counted
    from lanindex.pipeline import open_library
    from lanindex.pipeline.export import export
    from lanindex.pipeline.requests import from_hits, from_lines, from_range
    from lanindex.search.language.saved import pattern_in
    from lanindex.search.stages import hits_in

    with open_library(db, readonly=True) as library:
        library.tell, library.watch = out.note, out.watch
        if capture is not None:
            wanted: Iterable[Request] = [from_range(library, options.which(capture), begin, end)]
        elif what == "-":
            wanted = from_lines(library, sys.stdin.buffer if sys.stdin else ())
        else:
            library.words = words
            pattern = meaning.of(out, library, pattern_in(str(what)), words)
            found = library.search(pattern, **how)
            end_progress()
            wanted = from_hits(hits_in(found), found.pattern)
        manifest = export(
            library, wanted, output, pad=pad, format=format, origin=origin, force=force
        )
    for row in manifest:
        if json:
            out.record(row)
        else:
            out.line(str(output / row["clip"]))
    out.note(f"{counted(len(manifest), 'clip')} in {output}")
    if not manifest:
        raise typer.Exit(1)


def _one_thing(what: str | None, capture: str | None) -> None:
    if (what is None) == (capture is None):
        raise UsageError(
            "nothing to export" if what is None else "two things to export",
            wanted="a pattern, - or --capture",
        )
