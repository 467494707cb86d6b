"""``lanindex evaluate``: measure patterns against labelled captures."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output, end_progress, say_error
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lanindex.evaluate import Clip, Miss, Result
    from lanindex.pipeline.labels import Labels


def run(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", readable=False, help="Where they are.")
    ],
    labels: Annotated[str, typer.Option(metavar="CSV", help="Columns file and label.")],
    patterns: Annotated[str, typer.Option(metavar="TOML", help="Patterns and their positives.")],
    profile: options.Profile = "default",
    jobs: Annotated[int | None, typer.Option("--jobs", "-j", min=1, help="Processes.")] = None,
    misses: Annotated[
        bool, typer.Option("--misses", help="Say which clips were judged wrongly, and why.")
    ] = False,
    near: options.Near = False,
    fuzzy: options.Fuzzy = None,
    timeout: options.Timeout = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Measure patterns against labelled captures.

    A clip is found if a pattern has at least one hit in it. Files both in FOLDER and in the CSV
    count. PATTERNS: name = {pattern = "r_arm high", positives = ["label", "walk*", ...]}.
    """
    out = Output(json, quiet, verbose, color)
    from lanindex.app.formatting import counted
    from lanindex.encode.profile import load
    from lanindex.evaluate import evaluate, read_clips, read_patterns, summary
    from lanindex.pipeline.search import named as too_rich

    chosen, named = read_patterns(patterns), _labels(labels)
    reader = read_clips(folder, named, load(profile), jobs=jobs or os.cpu_count() or 1)
    clips = list(out.progress(reader, len(named), "clips"))
    _compare(out, folder, labels, named, clips)
    failed = [clip for clip in clips if clip.error]
    for clip in failed:
        say_error(f"{clip.error}; it counts as not found")
    for expectation in chosen:
        if unused := expectation.unused(clip.capture.label for clip in clips):
            out.note(f"{expectation.name}: no clip has the label {', '.join(unused)}")
    results = evaluate(clips, chosen, near=near, fuzzy=fuzzy, timeout=timeout, tell=out.watch)
    end_progress()
    for result in results:
        for line in too_rich(result.refused):
            say_error(f"{result.expectation.name}: {line}; it counts as not found")
    _print(out, results, misses)
    total = summary(results)
    mean, error = total["mean_f1"], total["standard_error"]
    if json:
        out.record({"pattern": "(mean)", **total})
    elif mean is not None:
        counts = (counted(total[f"{noun}s"], noun) for noun in ("pattern", "clip"))
        out.line(", ".join((f"mean F1 {mean:.3f} ± {error:.3f}", *counts)))
    if mean is None:
        out.note("nothing was measured: no clip has a label that a pattern should find")
    refused = any(result.refused for result in results)
    if failed or refused or mean is None:
        raise typer.Exit(2 if failed or refused else 1)


def _compare(out: Output, folder: Path, table: str, named: Labels, clips: Sequence[Clip]) -> None:
    """Say which rows of the table name no clip; refuse to go on without any."""
    from lanindex.pipeline.discover import discover
    from lanindex.pipeline.labels import unfitting

    files = [clip.capture.path for clip in clips]
    said = unfitting(named, files or discover([folder]))
    if not clips:
        raise UsageError(said, place=table, wanted=f"files in {folder}")
    if said:
        out.note(f"{table}: {said}")


def _labels(table: str) -> Labels:
    from lanindex.pipeline.labels import read_labels

    named = read_labels(table)
    if not any(label for label, _ in named.values()):
        raise UsageError("no labels", place=table, wanted='a column "label"')
    return named


def _print(out: Output, results: list[Result], misses: bool) -> None:
    records = [result.record(misses=misses and out.json) for result in results]
    if out.json:
        for record in records:
            out.record(record)
        return
    figures = ("precision", "recall", "f1")
    counts = ("found_rightly", "found_wrongly", "missed")
    head = ("pattern", *figures, "right", "wrong", "missed")
    rows = [
        (
            record["name"],
            *("-" if record[key] is None else f"{record[key]:.3f}" for key in figures),
            *(record[key] for key in counts),
        )
        for record in records
    ]
    out.table(head, rows)
    for result in results if misses else ():
        for miss in result.misses:
            _miss(out, result, miss)


def _miss(out: Output, result: Result, miss: Miss) -> None:
    from lanindex.app.formatting import words

    name, capture = result.expectation.name, miss.capture
    if miss.hit:
        span = miss.hit.span
        out.line(f"{name}: wrongly {capture.path} ({capture.label})")
        out.line(f"    frames {span.start}-{span.stop}: {words(miss.hit.symbols)}")
    else:
        out.line(f"{name}: missed {capture.path} ({capture.label})")
        out.line(f"    {result.obstacle(miss)}")
