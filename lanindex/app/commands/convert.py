"""``lanindex convert``: a capture written down, without a library."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lanindex.app import options
from lanindex.app.screen import Screen


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
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Write a capture down as LND, without a library."""
    screen = Screen(False, quiet, verbose, color)
    from lanindex.capture import read
    from lanindex.encode import encode
    from lanindex.notation import lnd
    from lanindex.write.files import write_all

    told = options.reading(unit, up, fps, compose)
    motion = read(file, unit=told.unit, up=told.up, rate=told.rate, compose=told.compose)
    text = lnd.write(encode(motion, profile))
    for warning in motion.warnings:
        screen.note(f"{file}: {warning}")
    if output == options.STDOUT:
        screen.out(text.removesuffix("\n"))
    else:
        write_all([(output, text.encode())], force=force, sources=[file])
        screen.note(str(output))
