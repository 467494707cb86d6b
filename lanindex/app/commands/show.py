"""``lanindex show``: the symbols of a capture."""

from __future__ import annotations

from pathlib import Path
from typing import IO, TYPE_CHECKING, Annotated

import typer

from lanindex.alphabet import MEASURES
from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lanindex.model import Capture, Track

    Found = Iterable[tuple[Capture, dict[str, Track]]]


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
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="FILE", help="As a table: .csv, .jsonl or .parquet."
        ),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Show the symbols of a capture.

    A star marks what is only passed on the way; it stands in no score. Speed is the highest, in
    lengths of the part a second; size the degrees between where it pointed and where it points.
    In a file they stand row by row, with what --json has.
    """
    out = Output(json, quiet, verbose, color)
    if (capture is None) != everything:
        raise UsageError("no capture" if capture is None else "a capture and --all", wanted="one")
    if where and not everything:
        raise UsageError("--where", wanted="--all beside it")
    if staff and json:
        raise UsageError("--staff and --json", wanted="one of them")
    form = _form(output, json or staff, force)
    from lanindex.app.formatting import counted
    from lanindex.pipeline import open_library

    with open_library(db, readonly=True) as library:
        numbers = None
        if capture is not None:
            numbers = [library.capture(options.which(capture)).id]
        elif where:
            numbers = library.numbers(where=options.where(where))
        if part:
            library.check_parts(part)
        symbols = 0
        # what stands beside some parts may belong to them: feet that hold the weight
        every = library.tracks(numbers, None if staff else part)
        if output is not None:
            symbols = _saved(output, form, every, force)
        for found, tracks in every:  # none are left where they were saved
            tracks = _drawn(out, found, tracks, part) if staff else _show(out, found, tracks)
            symbols += sum(len(track) for track in tracks.values())
    out.note(counted(symbols, "symbol"))
    if not symbols:
        raise typer.Exit(1)


def _form(output: Path | None, otherwise: bool, force: bool) -> str:
    """Return which table is written, if one is."""
    from lanindex.notation import TABLES

    if output is None:
        if force:
            raise UsageError("--force", wanted="--output beside it")
        return ""
    if otherwise:
        raise UsageError("--output beside --json or --staff", wanted="one of them")
    form = output.suffix.lower().removeprefix(".")
    if form not in TABLES:
        wanted = f"an ending of {', '.join(TABLES)}"
        raise UsageError(f'"{output}"', place="--output", wanted=wanted)
    return form


def _saved(output: Path, form: str, found: Found, force: bool) -> int:
    """Write symbols into a file as they come; none is written without one."""
    from lanindex.notation import TABLES, table
    from lanindex.pipeline.files import write_all

    rows = (row for capture, tracks in found for row in table.rows_in(capture, tracks))
    count = 0

    def into(file: IO[bytes]) -> None:
        nonlocal count
        count = TABLES[form].does.save(rows, file)
        if not count:
            raise typer.Exit(1)

    write_all([(output, into)], force=force)
    return count


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
