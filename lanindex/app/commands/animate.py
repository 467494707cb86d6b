"""``lanindex animate``: a standard body carries out a score."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output


def run(
    score: Annotated[
        Path,
        typer.Argument(metavar="SCORE", readable=False, help="An .lnd file, or another score."),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Where to (-: standard output); else beside the score.",
        ),
    ] = None,
    fps: Annotated[str, typer.Option("--fps", metavar="RATE", help="Frames a second.")] = "30",
    noise: Annotated[
        float, typer.Option(metavar="MM", min=0.0, help="Shake every joint (standard deviation).")
    ] = 0.0,
    seed: Annotated[int, typer.Option(min=0, help="Which noise.")] = 0,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Let a standard body carry out a score, as a BVH file."""
    out = Output(False, quiet, verbose, color)
    from lanindex import notation
    from lanindex.formats import bvh
    from lanindex.perform import perform
    from lanindex.pipeline.files import write_all

    rate = options.rate(fps)
    motion = perform(notation.read(str(score)), rate=rate, noise=noise, seed=seed)
    target = output or score.with_suffix(".bvh")
    content = bvh.write(motion)
    if target == options.STDOUT:
        out.content(content.decode())
    else:
        write_all([(target, content)], force=force, sources=[score])
    for warning in motion.warnings:
        out.note(f"{score}: {warning}")
    out.note(f"{target}: {len(motion)} frames at {float(rate):g} Hz, {motion.seconds:.2f} s")
