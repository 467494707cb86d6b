"""``lanindex ingest``: read captures and scores into the library."""

from __future__ import annotations

import os
import time
from collections import Counter
from contextlib import nullcontext
from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import options
from lanindex.app.output import Output, counted, duration, say_error

if TYPE_CHECKING:
    from lanindex.pipeline.prepare import Outcome

MANY = 16
"""Files from which on several processes are worth their start."""


def run(
    paths: Annotated[
        list[str], typer.Argument(metavar="PATH...", help="Captures, scores, folders.")
    ],
    jobs: options.Jobs = None,
    profile: options.Profile = "default",
    labels: Annotated[
        str | None,
        typer.Option(metavar="CSV", help="A table with columns file, label and any others."),
    ] = None,
    *,
    reading: options.Reading,
    tempo: options.Tempo = None,
    force: Annotated[bool, typer.Option("--force", help="Read unchanged files again.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Read and say what would be done; store nothing.")
    ] = False,
    db: options.Db = options.DB,
    out: options.Out,
) -> None:
    """Read captures and scores into the library.

    Folders are searched through; unchanged files are skipped. A file that cannot be read is
    reported, the others go in, and the exit code is 2.
    """
    from lanindex.encoding.profile import load
    from lanindex.formats import check, parted
    from lanindex.library.store import Store
    from lanindex.pipeline.discover import discover
    from lanindex.pipeline.ingest import ingest
    from lanindex.pipeline.labels import check_fit, read_labels, unfitting

    chosen, reading = load(profile), replace(reading, tempo=tempo)
    check(reading)
    others: list[str] = []
    files = list(discover(paths, others, apart=False))
    if not files:
        left_out = _left_out(others, labels, db)
        but = f", but {left_out}" if left_out else ""
        out.note(f"no capture or score in {' '.join(paths)}{but}")
        raise typer.Exit(1)
    table = {} if labels is None else read_labels(labels)
    if labels is not None:
        check_fit(table, files, labels)
    jobs = _processes(out, files, jobs)
    tally, read, beside = Counter[str](), list[str](), set[str]()
    start, division = time.monotonic(), chosen.meter.division
    no_library = dry_run and not os.path.exists(db)
    progress = out.watch if out.watched else None
    with (
        nullcontext()
        if no_library
        else Store.open(db, create=True, readonly=dry_run, note=out.note, progress=progress)
    ) as store:
        how: dict[str, Any] = {"force": force, "dry_run": dry_run, "labels": table, "jobs": jobs}
        outcomes = ingest(store, files, chosen, reading=reading, **how)
        by_file = groupby(outcomes, key=lambda outcome: parted(outcome.path)[0])
        for _, of_file in out.progress(by_file, len(files), "files"):
            for outcome in of_file:
                _count(tally, outcome, division)
                _report(out, outcome)
                read.append(outcome.path)
                beside.update(outcome.beside)
    if unused := unfitting(table, read):
        out.note(f"{labels}: {unused}")
    _summary(out, tally, len(read), time.monotonic() - start, dry_run)
    if rest := _left_out(others, labels, db, *beside):
        out.note(f"left out: {rest}")
    if tally["warnings"] and not (out.verbose or out.json):
        more = "-v shows" if dry_run else "lanindex list --doubts tells"
        out.note(f"{counted(tally['warnings'], 'warning')}: {more} more")
    if tally["finer"]:
        out.detail(f"grid finer than 1/{division} of a unit: {counted(tally['finer'], 'score')}")
    if tally["failed"]:
        raise typer.Exit(2)


def _processes(out: Output, files: list[str], requested: int | None) -> int:
    """Return how many processes are worth their start and have room in memory."""
    from lanindex.pipeline.pool import affordable, size_of

    wanted = requested or (os.cpu_count() or 1 if len(files) >= MANY else 1)
    possible = affordable(map(size_of, files), wanted)
    if possible < wanted:
        out.detail(f"{possible} of {wanted} processes: the largest files leave no room for more")
    return possible


def _left_out(others: list[str], *own: str | None) -> str:
    """Say which files were passed over, but for the library, the labels and what was read."""
    from lanindex.pipeline.discover import left_out

    known = {os.path.abspath(path) + end for path in own if path for end in ("", "-wal", "-shm")}
    return left_out(path for path in others if os.path.abspath(path) not in known)


def _count(tally: Counter[str], outcome: Outcome, division: int) -> None:
    tally.update({outcome.status: 1, "frames": outcome.frames, "symbols": outcome.symbols})
    tally["milliseconds"] += round(1000 * outcome.seconds)
    tally["warnings"] += len(outcome.warnings)
    tally["anew"] += outcome.held and outcome.status == "added"
    tally["moved"] += bool(outcome.moved) and outcome.status == "unchanged"
    tally["labelled"] += outcome.labelled
    tally["finer"] += outcome.division > division


def _report(out: Output, outcome: Outcome) -> None:
    """Print what became of a file."""
    if out.json:
        record: dict[str, Any] = {
            "capture": outcome.path,
            "status": outcome.status,
            "frames": outcome.frames,
            "symbols": outcome.symbols,
            **({"tempo": outcome.tempo} if outcome.tempo else {}),
            "warnings": list(outcome.warnings),
            "error": outcome.error,
        }
        out.record(record)
    if outcome.error:
        say_error(outcome.error)
    if outcome.tempo:
        out.detail(f"{outcome.path}: {outcome.tempo}")
    if outcome.moved:
        out.detail(f"{outcome.path}: was {outcome.moved} before")
    for warning in outcome.warnings:
        out.detail(f"{outcome.path}: {warning}")


def _summary(out: Output, tally: Counter[str], files: int, elapsed: float, dry_run: bool) -> None:
    if tally["unchanged"] == files and not (tally["labelled"] or tally["moved"]):
        out.note(f"nothing new: {counted(files, 'file')} unchanged")
        return
    would = "would be " if dry_run else ""
    counts = {
        f"{would}added": tally["added"] - tally["anew"],
        f"{would}written anew": tally["anew"],
        "unchanged": tally["unchanged"] - tally["moved"],
        "moved": tally["moved"],
        "labelled anew": tally["labelled"],
        "failed": tally["failed"],
    }
    changes = ", ".join(f"{number} {word}" for word, number in counts.items() if number)
    out.note(
        f"{counted(files, 'file')}: {changes or 'nothing to do'}; "
        f"{duration(tally['milliseconds'] / 1000)} of movement, "
        f"{counted(tally['symbols'], 'symbol')}, in {elapsed:.1f} s"
    )
