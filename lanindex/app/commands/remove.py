"""``lanindex remove``: take captures out of the library."""

from __future__ import annotations

from typing import Annotated

import typer

from lanindex.app import options
from lanindex.app.screen import Screen
from lanindex.errors import UsageError


def run(
    captures: Annotated[
        list[str] | None,
        typer.Argument(metavar="CAPTURE", help="Their numbers, paths or ends of paths."),
    ] = None,
    missing: Annotated[
        bool, typer.Option("--missing", help="All whose file is no longer there.")
    ] = False,
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
    screen = Screen(json, quiet, verbose, color)
    if bool(captures) == missing:
        raise UsageError(
            "captures and --missing" if missing else "nothing to remove",
            wanted="captures, or --missing",
        )
    from lanindex.app.present import capture_line, counted
    from lanindex.pipeline import open_library

    with open_library(db, readonly=dry_run) as library:
        named = [library.capture(options.which(name)) for name in captures or []]
        found = list({one.id: one for one in named or library.missing()}.values())
        if not dry_run:
            library.remove(*(capture.id for capture in found))
    if json:
        for capture in found:
            screen.record(capture_line(capture))
        screen.record({"summary": {"removed": len(found)}})
    elif found:
        screen.table(("id", "path"), [(capture.id, capture.path) for capture in found])
    screen.note(f"{counted(len(found), 'capture')} {'would be ' if dry_run else ''}removed")
    if not found:
        raise typer.Exit(1)
