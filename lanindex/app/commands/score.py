"""``lanindex score``: a capture as a picture, in Labanotation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lanindex.app import named, options
from lanindex.app.output import Output
from lanindex.errors import UsageError


def run(
    capture: Annotated[
        str,
        typer.Argument(
            metavar="CAPTURE|FILE|-",
            help="Of the library or a file; with :FROM-TO a stretch; -: a hit of search --json.",
            autocompletion=options.offered("captures"),
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE.svg|png|pdf",
            help="Where to (-: SVG on standard output); else an .svg file here.",
        ),
    ] = None,
    parts: Annotated[
        str | None, typer.Option("--parts", metavar="PART,...", help="Only these tracks.")
    ] = None,
    start: Annotated[
        float | None, typer.Option("--from", metavar="SECONDS", min=0.0, help="Begin there.")
    ] = None,
    stop: Annotated[
        float | None, typer.Option("--to", metavar="SECONDS", min=0.0, help="End there.")
    ] = None,
    bars: Annotated[
        int | None,
        typer.Option("--bars", metavar="N", min=1, help="Bars, or five seconds, a staff: 4."),
    ] = None,
    strip: Annotated[bool, typer.Option("--strip", help="One long staff.")] = False,
    scale: Annotated[
        float, typer.Option("--scale", metavar="N", min=0.1, max=20.0, help="How large.")
    ] = 1.0,
    highlight: Annotated[
        str | None,
        typer.Option("--highlight", metavar="PATTERN", help="Lay a band over its hits' symbols."),
    ] = None,
    legend: Annotated[bool, typer.Option("--legend", help="Say what the signs mean.")] = False,
    words: options.Words = None,
    profile: options.OwnProfile = None,
    unit: options.Unit = None,
    up: options.Up = None,
    fps: options.Fps = None,
    compose: options.Compose = None,
    skeleton: options.Skeleton = None,
    body: options.Body = None,
    columns: options.Columns = None,
    take: options.Take = None,
    tempo: options.Tempo = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    db: options.Db = options.DB,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Draw a capture or a score as a staff of Labanotation, time upwards.

    Beats are counted where a tempo was told, seconds elsewhere. Without --parts, limbs are drawn
    as a whole where a score has them so. What the library holds is drawn as it was ingested; with
    an option of reading (--unit, --profile and so on) a file is meant, and read.
    """
    out = Output(False, quiet, verbose, color)
    if strip and bars is not None:
        raise UsageError("--strip and --bars", wanted="one of them")
    from lanindex.draw.score import BARS, draw
    from lanindex.draw.svg import FORMS, rendered
    from lanindex.pipeline.files import safe_stem, write_all

    target = output or Path(f"{safe_stem('hit' if capture == '-' else capture)}.svg")
    form = "svg" if target == options.STDOUT else target.suffix.lower().removeprefix(".")
    if form not in FORMS:
        raise UsageError(f'"{target}"', place="--output", wanted="an ending of svg, png or pdf")
    told = options.reading(
        unit, up, fps, compose, skeleton=skeleton, body=body, columns=columns, take=take
    )
    found = named.found(out, capture, db, told, profile, tempo)
    hits = [list(found.matched)]
    if highlight is not None:
        from lanindex.pipeline.apart import matched

        hits = matched(found.score, highlight, words)
        out.note(f"{len(hits)} hit{'s' * (len(hits) != 1)}")
    picture = draw(
        found.score,
        title=found.title,
        parts=None if parts is None else [part.strip() for part in parts.split(",")],
        start=found.seconds[0] if start is None else start,
        stop=found.seconds[1] if stop is None else stop,
        bars=None if strip else bars or BARS,
        seconds=not found.counted,
        marked=[symbol for hit in hits for symbol in hit],
        legend=legend,
    )
    for warning in picture.warnings:
        out.note(f"{found.title}: {warning}")
    content = rendered(picture, form, scale)
    if target == options.STDOUT:
        out.content(content.decode())
        return
    write_all([(target, content)], force=force, sources=[found.path])
    out.note(f"{target}: {len(picture.groups())} symbols")
