"""``lanindex export``: write hits as clips."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import meaning, options
from lanindex.app.output import Output, end_progress
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.app.dataset import Range
    from lanindex.pipeline import Library
    from lanindex.pipeline.requests import Request


def run(
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="PATTERN|-",
            help="A pattern, or - for hits from search --json.",
            autocompletion=options.offered("patterns"),
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FOLDER", help="Where to: clips.")
    ] = None,
    capture: Annotated[
        str | None,
        typer.Option(
            "--capture",
            metavar="PATH|ID",
            help="Cut from this capture.",
            autocompletion=options.offered("captures"),
        ),
    ] = None,
    begin: Annotated[
        int | None, typer.Option("--from", metavar="FRAME", min=0, help="First frame.")
    ] = None,
    end: Annotated[
        int | None, typer.Option("--to", metavar="FRAME", min=1, help="Frame after the last.")
    ] = None,
    format: Annotated[
        str, typer.Option(metavar="native|bvh|c3d|...|lnd", help="What to write: --format ? tells.")
    ] = "native",
    origin: Annotated[
        bool, typer.Option("--origin", help="Begin at the floor's origin, facing forward.")
    ] = False,
    preview: Annotated[
        str | None,
        typer.Option("--preview", metavar="webp|gif|mp4", help="Write a film beside each clip."),
    ] = None,
    pad: Annotated[
        str, typer.Option(metavar="TIME", help="Time around each hit: 0.5s, 200ms, 10f.")
    ] = "0",
    dataset: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Write a data set to train on, instead of clips."),
    ] = None,
    patterns: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Its labels, each a pattern, as evaluate has them."),
    ] = None,
    layout: Annotated[
        str | None, typer.Option(metavar="npz|humanml3d", help="How a data set lies in its folder.")
    ] = None,
    fps: Annotated[
        str | None, typer.Option(metavar="RATE", help="Frames a second of a data set.")
    ] = None,
    split: Annotated[
        str | None, typer.Option(metavar="80/10/10", help="Per cent to train, validate and test.")
    ] = None,
    split_by: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="What is in one split: performer.")
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="Another choice of splits.")] = None,
    within: options.In = None,
    where: options.Where = None,
    overlaps: options.Overlaps = "none",
    strict: options.Strict = False,
    tolerance: options.Tolerance = 0.1,
    near: options.Near = False,
    fuzzy: options.Fuzzy = None,
    words: options.Words = None,
    force: Annotated[bool, typer.Option("--force", help="Replace files that are there.")] = False,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Write hits as clips, in the format they came in or another.

    A clip in its source's format is cut out of it, byte for byte where the format allows that; in
    another (--format), or at the origin (--origin), it is written anew. Beside each stands its
    score (.lnd), with --preview a film, and a manifest lists them all. With --dataset they become
    arrays of joints, symbols and words, in splits, with a card; without a pattern, whole captures
    do.
    """
    out = Output(json, quiet, verbose, color)
    how: dict[str, Any] = {"tolerance": tolerance, "overlaps": overlaps, "strict": strict}
    how |= {"near": near, "fuzzy": fuzzy, "within": within, "where": options.where(where)}
    wished = {"layout": layout, "rate": fps, "shares": split, "split_by": split_by, "seed": seed}
    span = (capture, begin, end)
    if dataset is not None:
        others = {"--output": output is not None, "--format": format != "native"}
        others |= {"--origin": origin, "--preview": preview is not None}
        _refused(others, "nothing of the kind beside --dataset")
        from lanindex.app import dataset as job

        wished |= {"pad": pad, "force": force}
        job.run(out, db, dataset, wished, what, patterns, span, how, words)
        return
    named: dict[str, Any] = {
        "--patterns": patterns,
        "--layout": layout,
        "--fps": fps,
        "--split": split,
    }
    named |= {"--split-by": split_by, "--seed": seed}
    _refused({name: it is not None for name, it in named.items()}, "--dataset beside it")
    output = output or Path("clips")
    _one_thing(what, capture)
    _refused({"--from and --to": capture is None and span != _NOWHERE}, "--capture beside them")
    apart = (where or within is not None) and (capture is not None or what == "-")
    _refused({"--in and --where": apart}, "a pattern beside them")
    from lanindex.pipeline import open_library
    from lanindex.pipeline.export import export

    with open_library(db, readonly=True) as library:
        library.tell, library.watch, library.words = out.note, out.watch, words
        wanted = _wanted(out, library, what, span, how)
        forms: dict[str, Any] = {"format": format, "origin": origin, "preview": preview}
        manifest = export(library, wanted, output, pad=pad, force=force, **forms)
    _tell(out, manifest, output)
    if library.refused or not manifest:
        raise typer.Exit(2 if library.refused else 1)


_NOWHERE = (None, None, None)


def _wanted(
    out: Output, library: Library, what: str | None, span: Range, how: dict[str, Any]
) -> Iterable[Request]:
    """Return what is to be cut."""
    from lanindex.pipeline.requests import from_hits, from_lines, from_range
    from lanindex.search.hits import hits_in
    from lanindex.search.language.score import pattern_in

    capture, begin, end = span
    if capture is not None:
        return [from_range(library, options.which(capture), begin, end)]
    if what == "-":
        return from_lines(library, sys.stdin.buffer if sys.stdin else ())
    pattern = meaning.of(out, library, pattern_in(str(what)), library.words)
    found = library.search(pattern, **how)
    end_progress()
    return from_hits(hits_in(found), found.pattern)


def _tell(out: Output, manifest: list[dict[str, Any]], folder: Path) -> None:
    """Say what was written."""
    from lanindex.app.formatting import counted

    for row in manifest:
        if out.json:
            out.record(row)
        else:
            out.line(str(folder / row["clip"]))
    out.note(f"{counted(len(manifest), 'clip')} in {folder}")


def _refused(given: dict[str, Any], wanted: str) -> None:
    """Refuse options that do not apply."""
    for name, is_given in given.items():
        if is_given:
            raise UsageError(name, wanted=wanted)


def _one_thing(what: str | None, capture: str | None) -> None:
    if (what is None) == (capture is None):
        raise UsageError(
            "nothing to export" if what is None else "two things to export",
            wanted="a pattern, - or --capture",
        )
