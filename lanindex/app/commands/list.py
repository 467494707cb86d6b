"""``lanindex list``: the captures of the library."""

from __future__ import annotations

import typer

from lanindex.app import options
from lanindex.app.output import Output


def run(
    within: options.In = None,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """List the captures of the library."""
    out = Output(json, quiet, verbose, color)
    from lanindex import records
    from lanindex.app.formatting import counted, duration
    from lanindex.pipeline import open_library

    with open_library(db, readonly=True) as library:
        found = library.captures(within)
    length = sum(float(capture.frames / capture.rate) for capture in found)
    if json:
        for capture in found:
            out.record(records.of_capture(capture))
    elif found:
        out.table(
            ("id", "path", "label", "fps", "frames", "seconds"),
            [
                (
                    capture.id,
                    capture.path,
                    capture.label,
                    f"{float(capture.rate):g}",
                    capture.frames,
                    f"{float(capture.frames / capture.rate):.2f}",
                )
                for capture in found
            ],
        )
    out.note(f"{counted(len(found), 'capture')}, {duration(length)}")
    if not found:
        raise typer.Exit(1)
