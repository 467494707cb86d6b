"""``lanindex evaluate``: measure patterns against labelled captures."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.evaluate import Miss, Result
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
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Measure patterns against labelled captures.

    A clip is found if a pattern has at least one hit in it. Files both in FOLDER and in the CSV
    count. PATTERNS: name = {pattern = "r_arm high", positives = ["label", ...]}.
    """
    out = Output(json, quiet, verbose, color)
    from lanindex.app.formatting import counted
    from lanindex.encode.profile import load
    from lanindex.evaluate import evaluate, read_clips, read_patterns, summary

    chosen, named = read_patterns(patterns), _labels(labels)
    reader = read_clips(folder, named, load(profile), jobs=jobs or os.cpu_count() or 1)
    clips = list(out.progress(reader, len(named), "clips"))
    if not clips:
        raise UsageError(
            "no file of the CSV is in the folder",
            place=str(folder),
            wanted="files that both name",
            remedy="A relative path in the CSV counts from the CSV's folder.",
        )
    failed = [clip for clip in clips if clip.error]
    for clip in failed:
        out.note(f"{clip.error}; it counts as not found")
    seen = {clip.capture.label for clip in clips}
    for pattern in chosen:
        if unseen := sorted(pattern.positives - seen):
            out.note(f"{pattern.name}: no clip has the label {', '.join(unseen)}")
    results = evaluate(clips, chosen)
    _print(out, results)
    if misses:
        for result in results:
            for miss in result.misses:
                _miss(out, result, miss)
    total = summary(results)
    if json:
        out.record({"summary": total})
    else:
        mean, error = total["mean_f1"], total["standard_error"]
        figure = "no pattern has positives" if mean is None else f"mean F1 {mean:.3f} ± {error:.3f}"
        counts = (counted(total[f"{noun}s"], noun) for noun in ("pattern", "clip"))
        out.line(", ".join((figure, *counts)))
    if failed:
        raise typer.Exit(2)


def _labels(table: str) -> Labels:
    from lanindex.pipeline.labels import read_labels

    named = read_labels(table)
    if not any(label for label, _ in named.values()):
        raise UsageError("no labels", place=table, wanted='a column "label"')
    return named


def _print(out: Output, results: list[Result]) -> None:
    records = [result.record() for result in results]
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


def _miss(out: Output, result: Result, miss: Miss) -> None:
    from lanindex import records
    from lanindex.app.formatting import words
    from lanindex.search.explain import obstacle

    name, query = result.pattern.name, result.pattern.query
    why = "" if miss.hit else obstacle(query, miss.capture, miss.tracks)
    if out.json:
        record = {"miss": name, "capture": miss.capture.path, "label": miss.capture.label}
        if miss.hit:
            out.record({**record, "kind": "wrong", "hit": records.of_hit(miss.hit)})
        else:
            out.record({**record, "kind": "missed", "obstacle": why})
    elif miss.hit:
        span = miss.hit.span
        out.line(f"{name}: wrongly {miss.capture.path} ({miss.capture.label})")
        out.line(f"    frames {span.start}-{span.stop}: {words(miss.hit.symbols)}")
    else:
        out.line(f"{name}: missed {miss.capture.path} ({miss.capture.label})")
        out.line(f"    {why}")
