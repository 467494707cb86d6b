"""``lanindex list``: the captures of the library."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output

if TYPE_CHECKING:
    from lanindex.model import Capture


def run(
    within: options.In = None,
    where: options.Where = None,
    doubts: Annotated[
        bool, typer.Option("--doubts", help="Only those that were doubtful to read, and why.")
    ] = False,
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
        found = library.captures(within, options.where(where), doubts=doubts)
    length = sum(float(capture.frames / capture.rate) for capture in found)
    if json:
        for capture in found:
            out.record(records.of_capture(capture))
    elif doubts:
        _doubts(out, found)
    elif found:
        _table(out, found)
    out.note(f"{counted(len(found), 'capture')}, {duration(length)}")
    if not found:
        raise typer.Exit(1)


def _table(out: Output, found: list[Capture]) -> None:
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


def _doubts(out: Output, found: list[Capture]) -> None:
    for capture in found:
        if out.terminal:
            out.line(out.paint(capture.path, "path"))
        for warning in capture.warnings:
            if out.terminal:
                out.line("  ", warning)
            else:
                out.row([capture.id, capture.path, warning])
