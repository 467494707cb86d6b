"""``lanindex remove``: take captures out of the library."""

from __future__ import annotations

from typing import Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import UsageError


def run(
    captures: Annotated[
        list[str] | None,
        typer.Argument(metavar="CAPTURE...", help="Their numbers, paths or ends of paths."),
    ] = None,
    missing: Annotated[
        bool, typer.Option("--missing", help="All whose file is no longer there.")
    ] = False,
    within: options.In = None,
    where: options.Where = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what would be removed; change nothing.")
    ] = False,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Take captures out of the library, all or none; their files stay.

    Exits with 1 if there is nothing to remove.
    """
    out = Output(json, quiet, verbose, color)
    if captures and missing:
        raise UsageError("captures and --missing", wanted="one of them")
    if not (captures or missing or where) and within is None:
        raise UsageError("nothing to remove", wanted="captures, --in, --where or --missing")
    from lanindex import records
    from lanindex.app.formatting import counted
    from lanindex.pipeline import open_library

    with open_library(db, readonly=dry_run) as library:
        named = [library.capture(options.which(name)) for name in captures or []]
        chosen = library.captures(within, options.where(where))
        if captures or missing:
            wanted = {one.id for one in (named if captures else library.missing())}
            chosen = [one for one in chosen if one.id in wanted]
        if not dry_run:
            library.remove(*(capture.id for capture in chosen))
    if json:
        for capture in chosen:
            out.record(records.of_capture(capture))
    elif chosen:
        out.table(("id", "path"), [(capture.id, capture.path) for capture in chosen])
    out.note(f"{counted(len(chosen), 'capture')} {'would be ' if dry_run else ''}removed")
    if not chosen:
        raise typer.Exit(1)
