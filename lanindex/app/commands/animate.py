"""``lanindex animate``: a standard body carries out a score."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lanindex.app import options
from lanindex.app.screen import Screen


def run(
    score: Annotated[Path, typer.Argument(metavar="SCORE", readable=False, help="An .lnd file.")],
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
    screen = Screen(False, quiet, verbose, color)
    from lanindex.notation import lnd
    from lanindex.perform import perform
    from lanindex.write import bvh
    from lanindex.write.files import write_all

    rate = options.rate(fps)
    motion = perform(lnd.read(score), rate=rate, noise=noise, seed=seed)
    target = output or score.with_suffix(".bvh")
    text = bvh.write(motion)
    if target == options.STDOUT:
        screen.out(text.removesuffix("\n"))
    else:
        write_all([(target, text.encode())], force=force, sources=[score])
    for warning in motion.warnings:
        screen.note(f"{score}: {warning}")
    screen.note(f"{target}: {len(motion)} frames at {float(rate):g} Hz, {motion.seconds:.2f} s")
