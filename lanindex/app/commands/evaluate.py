"""``lanindex evaluate``: measure patterns against labelled captures."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output, counted, end_progress, say_error
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.evaluate import Result


def run(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", readable=False, help="The captures.")],
    labels: Annotated[str, typer.Option(metavar="CSV", help="Columns file and label.")],
    patterns: Annotated[str, typer.Option(metavar="TOML", help="Patterns and their positives.")],
    profile: options.Profile = "default",
    jobs: options.Jobs = None,
    misses: Annotated[
        bool, typer.Option("--misses", help="Say which clips were judged wrongly, and why.")
    ] = False,
    near: options.Near = False,
    fuzzy: options.Fuzzy = None,
    timeout: options.Timeout = None,
    *,
    out: options.Out,
) -> None:
    """Measure patterns against labelled captures.

    A clip is found if a pattern has at least one hit in it. Files that are both in FOLDER and in
    the CSV count. PATTERNS: name = {pattern = "r_arm high", positives = ["label", "walk*", ...]}.
    """
    from lanindex.encoding.profile import load
    from lanindex.evaluate import evaluate, read_clips, read_patterns, summary
    from lanindex.pipeline.discover import discover
    from lanindex.pipeline.labels import read_labels, unfitting
    from lanindex.pipeline.search import named as too_rich

    expectations, table = read_patterns(patterns), read_labels(labels)
    if not any(label for label, _ in table.values()):
        raise UsageError("no labels", place=labels, wanted='a column "label"')
    reader = read_clips(folder, table, load(profile), jobs=jobs or os.cpu_count() or 1)
    clips = list(out.progress(reader, len(table), "clips"))
    unused_rows = unfitting(table, [it.capture.path for it in clips] or discover([folder]))
    if not clips:
        raise UsageError(unused_rows, place=labels, wanted=f"files in {folder}")
    if unused_rows:
        out.note(f"{labels}: {unused_rows}")
    failed = [clip for clip in clips if clip.error]
    for clip in failed:
        say_error(f"{clip.error}; it counts as not found")
    for expectation in expectations:
        if unused := expectation.unused(clip.capture.label for clip in clips):
            out.note(f"{expectation.name}: no clip has the label {', '.join(unused)}")
    results = evaluate(
        clips, expectations, near=near, fuzzy=fuzzy, timeout=timeout, progress=out.watch
    )
    end_progress()
    for result in results:
        for line in too_rich(result.refused):
            say_error(f"{result.expectation.name}: {line}; it counts as not found")
    _print(out, results, misses)
    total = summary(results)
    mean, error = total["mean_f1"], total["standard_error"]
    if out.json:
        out.record({"pattern": "(mean)", **total})
    elif mean is not None:
        counts = (counted(total[f"{noun}s"], noun) for noun in ("pattern", "clip"))
        out.line(", ".join((f"mean F1 {mean:.3f} ± {error:.3f}", *counts)))
    if mean is None:
        out.note("nothing was measured: no clip has a label that a pattern should find")
    if failed or any(result.refused for result in results):
        raise typer.Exit(2)
    if mean is None:
        raise typer.Exit(1)


def _print(out: Output, results: list[Result], misses: bool) -> None:
    records = [result.record(misses=misses and out.json) for result in results]
    if out.json:
        for record in records:
            out.record(record)
        return
    figures = ("precision", "recall", "f1")
    rows = [
        (
            record["name"],
            *("-" if record[key] is None else f"{record[key]:.3f}" for key in figures),
            *(record[key] for key in ("found_rightly", "found_wrongly", "missed")),
        )
        for record in records
    ]
    out.table(("pattern", *figures, "right", "wrong", "missed"), rows)
    for result in results if misses else ():
        _misses(out, result)


def _misses(out: Output, result: Result) -> None:
    from lanindex.model.capture import in_words

    for miss in result.misses:
        kind = "wrongly" if miss.hit else "missed"
        out.line(f"{result.expectation.name}: {kind} {miss.capture.path} ({miss.capture.label})")
        if miss.hit:
            span, symbols = miss.hit.span, ", ".join(in_words(miss.hit.symbols))
            out.line(f"    frames {span.start}-{span.stop}: {symbols}")
        else:
            out.line(f"    {result.obstacle(miss)}")
