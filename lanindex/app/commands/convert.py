"""``lanindex convert``: a capture written down, without a library."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output


def run(
    file: Annotated[Path, typer.Argument(metavar="FILE", readable=False, help="A capture.")],
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="FILE", help="Where to; - is standard output."),
    ] = options.STDOUT,
    profile: options.Profile = "default",
    unit: options.Unit = None,
    up: options.Up = None,
    fps: options.Fps = None,
    compose: options.Compose = None,
    skeleton: options.Skeleton = None,
    body: options.Body = None,
    columns: options.Columns = None,
    take: options.Take = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Write a capture down as LND, without a library."""
    out = Output(False, quiet, verbose, color)
    from lanindex.encode import encode
    from lanindex.formats import Wanted, opened, read_file
    from lanindex.notation import lnd
    from lanindex.pipeline.files import write_all

    told = options.reading(
        unit, up, fps, compose, skeleton=skeleton, body=body, columns=columns, take=take
    )
    motion = read_file(opened(file), told, Wanted(body_only=True))
    text = lnd.write(encode(motion, profile))
    for warning in motion.warnings:
        out.note(f"{file}: {warning}")
    if output == options.STDOUT:
        out.content(text)
    else:
        write_all([(output, text.encode())], force=force, sources=[file])
        out.note(str(output))
