"""``lanindex remove``: take captures out of the library."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import LibraryError, UsageError

if TYPE_CHECKING:
    from lanindex.model import Capture
    from lanindex.pipeline import Library


def run(
    captures: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="CAPTURE...",
            help="Their numbers, paths or ends of paths.",
            autocompletion=options.offered("captures"),
        ),
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
        chosen, damaged = _named(
            library, captures or [], dry_run or within is not None or bool(where)
        )
        if not damaged:  # else nothing but numbers can be trusted
            found = library.captures(within, options.where(where))
            wanted = {one.id for one in (chosen if captures else library.missing())}
            chosen = [one for one in found if one.id in wanted or not (captures or missing)]
        if not dry_run:
            library.remove(*damaged, *(capture.id for capture in chosen))
    if json:
        for capture in chosen:
            out.record(records.of_capture(capture))
    elif chosen:
        out.table(("id", "path"), [(capture.id, capture.path) for capture in chosen])
    gone = len(chosen) + len(damaged)
    out.note(f"{counted(gone, 'capture')} {'would be ' if dry_run else ''}removed")
    if not gone:
        raise typer.Exit(1)


def _named(library: Library, names: list[str], whole: bool) -> tuple[list[Capture], list[int]]:
    """Return the captures that are named, and the numbers of those too damaged to be read.

    Where all must be `whole`, to be shown or chosen from, a damaged one is an error.
    """
    found: dict[int, Capture] = {}
    damaged: list[int] = []
    for which in map(options.which, names):
        try:
            one = library.capture(which)
            found[one.id] = one
        except LibraryError:
            if whole or not isinstance(which, int):
                raise
            damaged.append(which)  # where there is none, the removal says so
    return list(found.values()), damaged
