"""``lanindex score``: a capture as a picture, in Labanotation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.model import Reading, Score


def run(
    capture: Annotated[
        str,
        typer.Argument(
            metavar="CAPTURE|FILE",
            help="Its number, path or end of path in the library; else a capture or score.",
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
        float, typer.Option("--from", metavar="SECONDS", min=0.0, help="Begin there.")
    ] = 0.0,
    stop: Annotated[
        float | None, typer.Option("--to", metavar="SECONDS", min=0.0, help="End there.")
    ] = None,
    bars: Annotated[
        int, typer.Option("--bars", metavar="N", min=1, help="Bars, or five seconds, a staff.")
    ] = 4,
    strip: Annotated[bool, typer.Option("--strip", help="One long staff.")] = False,
    scale: Annotated[
        float, typer.Option("--scale", metavar="N", min=0.1, max=20.0, help="How large.")
    ] = 1.0,
    highlight: Annotated[
        str | None,
        typer.Option("--highlight", metavar="PATTERN", help="Lay a band over its hits' symbols."),
    ] = None,
    words: options.Words = None,
    profile: options.Profile = "default",
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
    as a whole where a score has them so.
    """
    out = Output(False, quiet, verbose, color)
    from lanindex.draw import draw
    from lanindex.draw.render import FORMS, rendered
    from lanindex.pipeline.files import safe_stem, write_all

    target = output or Path(f"{safe_stem(capture)}.svg")
    form = "svg" if target == options.STDOUT else target.suffix.lower().removeprefix(".")
    if form not in FORMS:
        raise UsageError(f'"{target}"', place="--output", wanted="an ending of svg, png or pdf")
    told = options.reading(
        unit, up, fps, compose, skeleton=skeleton, body=body, columns=columns, take=take
    )
    name, score, counted = _found(out, capture, db, told, profile, tempo)
    hits = []
    if highlight is not None:
        from lanindex.pipeline.apart import matched

        hits = matched(score, highlight, words)
        out.note(f"{len(hits)} hit{'s' * (len(hits) != 1)}")
    picture = draw(
        score,
        title=name,
        parts=None if parts is None else [part.strip() for part in parts.split(",")],
        start=start,
        stop=stop,
        bars=None if strip else bars,
        seconds=not counted,
        marked=[symbol for hit in hits for symbol in hit],
    )
    for warning in picture.warnings:
        out.note(f"{name}: {warning}")
    content = rendered(picture, form, scale)
    if target == options.STDOUT:
        out.content(content.decode())
        return
    sources = [capture] if Path(capture).is_file() else []
    write_all([(target, content)], force=force, sources=sources)
    out.note(f"{target}: {len(picture.groups())} symbols")


def _found(
    out: Output, named: str, db: str, told: Reading, profile: str, tempo: str | None
) -> tuple[str, Score, bool]:
    """Return what a score is called, the score, and whether its beats were told."""
    from lanindex.errors import LibraryError
    from lanindex.model import Score
    from lanindex.notation import notation_of
    from lanindex.pipeline import open_library

    file = Path(named)
    try:
        with open_library(db, readonly=True) as library:
            number = library.capture(options.which(named)).id
            ((capture, tracks),) = library.tracks([number])
    except (LibraryError, UsageError):
        if not file.is_file():
            raise
    else:
        score = Score(capture.rate, capture.frames, capture.meter, tracks)
        return capture.path, score, capture.format == _COUNTS or _has_tempo(score)
    from lanindex.pipeline.convert import score_of

    score = score_of(file, told, profile, tempo=tempo)
    for warning in score.warnings:
        out.note(f"{file}: {warning}")
    form = notation_of(named)
    return named, score, (form is not None and form.name == _COUNTS) or _has_tempo(score)


_COUNTS = "lnd"
"""The notation that counts beats, whatever their tempo."""


def _has_tempo(score: Score) -> bool:
    """Return whether somebody told how fast beats come: else they are seconds."""
    return score.meter.speed != 60
