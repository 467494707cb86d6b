"""``lanindex show``: the symbols of a capture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.alphabet import MEASURES
from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.model import Capture, Track


_WIDE = 94
"""Cells of a terminal that shows measures, too."""


def run(
    capture: Annotated[
        str | None,
        typer.Argument(
            metavar="CAPTURE",
            help="Its number, path or end of path.",
            autocompletion=options.offered("captures"),
        ),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="All captures.")] = False,
    part: Annotated[
        list[str] | None, typer.Option("--part", metavar="PART", help="Only this part.")
    ] = None,
    staff: Annotated[
        bool, typer.Option("--staff", help="Draw them as a staff, time downwards.")
    ] = False,
    where: options.Where = None,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Show the symbols of a capture.

    A star marks what is only passed on the way; it stands in no score. Speed is the highest, in
    lengths of the part a second; size the degrees between where it pointed and where it points.
    """
    out = Output(json, quiet, verbose, color)
    if (capture is None) != everything:
        raise UsageError("no capture" if capture is None else "a capture and --all", wanted="one")
    if where and not everything:
        raise UsageError("--where", wanted="--all beside it")
    if staff and json:
        raise UsageError("--staff and --json", wanted="one of them")
    from lanindex.app.formatting import counted
    from lanindex.pipeline import open_library

    with open_library(db, readonly=True) as library:
        numbers = None
        if capture is not None:
            numbers = [library.capture(options.which(capture)).id]
        elif where:
            numbers = library.numbers(where=options.where(where))
        _check_parts(part, library.parts())
        symbols = 0
        # what stands beside some parts may belong to them: feet that hold the weight
        for found, tracks in library.tracks(numbers, None if staff else part):
            tracks = _drawn(out, found, tracks, part) if staff else _show(out, found, tracks)
            symbols += sum(len(track) for track in tracks.values())
    out.note(counted(symbols, "symbol"))
    if not symbols:
        raise typer.Exit(1)


def _check_parts(wanted: list[str] | None, parts: list[str]) -> None:
    for part in wanted or []:
        if part not in parts:
            raise UsageError(f'"{part}"', place="--part", wanted="one of " + " ".join(parts))


def _drawn(
    out: Output, capture: Capture, tracks: dict[str, Track], parts: list[str] | None
) -> dict[str, Track]:
    """Draw a capture's tracks, and return those that were asked for."""
    from lanindex.app import staves

    asked = {name: it for name, it in tracks.items() if len(it) and name in (parts or tracks)}
    if asked:
        staves.whole(out, capture, tracks, parts and list(asked))
    return asked


def _show(out: Output, capture: Capture, tracks: dict[str, Track]) -> dict[str, Track]:
    """List a capture's tracks, and return them."""
    from lanindex import records
    from lanindex.app.columns import room

    more = MEASURES if not out.terminal or room() >= _WIDE else ()
    if not out.json:
        out.line(out.paint(capture.path, "path"))
        head = ("part", "symbol", "frames", "seconds", "margin", "swings", "else", *more)
    rows = []
    for track in tracks.values():
        for symbol in track.listed():
            line = records.of_row(capture, symbol)
            if out.json:
                out.record(line)
                continue
            star = "*" if symbol.passing else ""
            rows.append(
                (
                    symbol.part,
                    f"{symbol.words}{star}",
                    f"{symbol.span.start}-{symbol.span.stop}",
                    f"{line['start']:.2f}-{line['end']:.2f}",
                    f"{symbol.margin:.2f}",
                    symbol.swings or "",
                    line["runner_up"] or "",
                    *(_number(getattr(symbol, name)) for name in more),
                )
            )
    if not out.json:
        out.table(head, rows)
    return tracks


def _number(measure: float | None) -> str:
    if measure is None:
        return ""
    return f"{measure:.2f}" if isinstance(measure, float) else str(measure)
