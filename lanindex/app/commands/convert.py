"""``lanindex convert``: a capture written down, or in another format, without a library."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import UsageError


def run(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", readable=False, help="A capture or score.")
    ],
    to: Annotated[
        Path | None,
        typer.Argument(metavar="[OUT]", help="Where to: its ending tells the format."),
    ] = None,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="FILE", help="The same; - is standard output."),
    ] = options.STDOUT,
    form: Annotated[
        str | None,
        typer.Option("--to", metavar="lnd|bvh|c3d|...", help="The format, whatever the ending."),
    ] = None,
    into: Annotated[
        Path | None,
        typer.Option("--into", metavar="FILE", help="Add tiers to an .eaf file that is there."),
    ] = None,
    media: Annotated[
        Path | None, typer.Option("--media", metavar="FILE", help="A recording an .eaf opens with.")
    ] = None,
    origin: Annotated[
        bool, typer.Option("--origin", help="Begin at the floor's origin, facing forward.")
    ] = False,
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
    force: Annotated[bool, typer.Option("--force", help="Replace what is there.")] = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Write a capture down as LND or in another notation or format, without a library.

    Joints come out where they were; where only places are known, bones are turned by the rule of
    lanindex.rotation, from a body that stands with its arms to the sides.
    """
    out = Output(False, quiet, verbose, color)
    from lanindex.notation import NOTATIONS, WRITTEN, left_out
    from lanindex.pipeline import convert
    from lanindex.pipeline.files import write_all

    target = to or (into if into and output == options.STDOUT else output)
    if form is None and target == options.STDOUT:
        form = "lnd"
    form = convert.target_of(str(target), form)
    if target == options.STDOUT and (form not in WRITTEN or not NOTATIONS[form].text):
        raise UsageError(f"{form} on standard output", wanted="a file to write it to")
    if form != "lnd" and tempo is not None:
        raise UsageError(f"beats in {form}", place="--tempo", wanted="--to lnd, which counts them")
    told = options.reading(
        unit, up, fps, compose, skeleton=skeleton, body=body, columns=columns, take=take
    )
    if form in WRITTEN:
        score = convert.score_of(file, told, profile, tempo=tempo, origin=origin)
        for line in score.warnings:
            out.note(f"{file}: {line}")
        if lost := left_out(score, form):
            out.note(f"{NOTATIONS[form].title} has no room for {' '.join(lost)}")
        content = convert.notated(score, form, into, force=force, media=media)
        files = [(target, content)]
    else:
        motion = convert.motion_of(file, told, origin=origin)
        files, said = convert.files_of(motion, form, target)
        for line in (*motion.warnings, *said):
            out.note(f"{file}: {line}")
    if target != options.STDOUT:
        write_all(files, force=force or target == into, sources=[file])
        for path, _ in files:
            out.note(str(path))
    else:
        out.content(content.decode())
