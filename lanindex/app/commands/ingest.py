"""``lanindex ingest``: read captures and scores into the library."""

from __future__ import annotations

import os
import time
from collections import Counter
from itertools import groupby
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import options
from lanindex.app.output import Output, say_error

if TYPE_CHECKING:
    from lanindex.pipeline.labels import Labels
    from lanindex.pipeline.prepare import Outcome

MANY = 16
"""Files from which on several processes are worth their start."""


def run(
    paths: Annotated[
        list[str], typer.Argument(metavar="PATH...", help="Captures, scores, folders.")
    ],
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", "-j", min=1, help="Processes; as many as there are processors."),
    ] = None,
    profile: options.Profile = "default",
    labels: Annotated[
        str | None,
        typer.Option(metavar="CSV", help="A table with columns file, label and any others."),
    ] = None,
    unit: options.Unit = None,
    up: options.Up = None,
    fps: options.Fps = None,
    compose: options.Compose = None,
    skeleton: options.Skeleton = None,
    body: options.Body = None,
    columns: options.Columns = None,
    take: options.Take = None,
    tempo: options.Tempo = None,
    force: Annotated[bool, typer.Option("--force", help="Read unchanged files again.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Read and say what would be done; store nothing.")
    ] = False,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Read captures and scores into the library.

    Folders are searched through; what is unchanged is skipped. A file that cannot be read is
    reported, the others go in, and the exit code is 2.
    """
    out = Output(json, quiet, verbose, color)
    from contextlib import nullcontext

    from lanindex.encode.profile import load
    from lanindex.formats import check, parted
    from lanindex.pipeline import open_library
    from lanindex.pipeline.discover import discover
    from lanindex.pipeline.ingest import ingest
    from lanindex.pipeline.labels import unfitting

    named = {"skeleton": skeleton, "body": body, "columns": columns, "take": take, "tempo": tempo}
    chosen, told = load(profile), options.reading(unit, up, fps, compose, **named)
    check(told)
    others: list[str] = []
    files = list(discover(paths, others, apart=False))
    if not files:
        _nothing(out, paths, _left_out(others, labels, db))
    how: dict[str, Any] = {"force": force, "dry_run": dry_run}
    words = _labels(labels, files)
    how |= {"labels": words, "jobs": _processes(out, files, jobs)}
    tally, read, beside, begun = Counter[str](), list[str](), set[str](), time.monotonic()
    unmade = dry_run and not os.path.exists(db)
    with nullcontext() if unmade else open_library(db, create=True, readonly=dry_run) as library:
        if library:
            library.tell = out.note
            library.watch = out.watch if out.watched else library.watch
        done = ingest(library, files, chosen, reading=told, **how)
        by_file = groupby(done, key=lambda outcome: parted(outcome.path)[0])
        for _, outcomes in out.progress(by_file, len(files), "files"):
            for outcome in outcomes:
                _count(tally, outcome, chosen.meter.division)
                _report(out, outcome)
                read.append(outcome.path)
                beside.update(outcome.beside)
    if said := unfitting(words, read):
        out.note(f"{labels}: {said}")
    _summary(out, tally, len(read), time.monotonic() - begun, dry_run)
    _afterwards(out, tally, _left_out(others, labels, db, *beside), chosen.meter.division, dry_run)
    if tally["failed"]:
        raise typer.Exit(2)


def _processes(out: Output, files: list[str], told: int | None) -> int:
    """Return how many processes are worth their start and have room in memory."""
    from lanindex.pipeline.memory import affordable, size_of

    wanted = told or (os.cpu_count() or 1 if len(files) >= MANY else 1)
    found = affordable(map(size_of, files), wanted)
    if found < wanted:
        out.detail(f"{found} of {wanted} processes: the largest files leave no room for more")
    return found


def _labels(table: str | None, files: list[str]) -> Labels:
    """Read the table of labels; refuse one that speaks of none of the files."""
    from lanindex.pipeline.labels import check_fit, read_labels

    if table is None:
        return {}
    labels = read_labels(table)
    check_fit(labels, files, table)
    return labels


def _left_out(others: list[str], *own: str | None) -> str:
    """Say what was passed over; library, table of labels and what was read are none of it."""
    from lanindex.pipeline.discover import left_out

    known = {os.path.abspath(path) + end for path in own if path for end in ("", "-wal", "-shm")}
    return left_out(path for path in others if os.path.abspath(path) not in known)


def _nothing(out: Output, paths: list[str], rest: str) -> None:
    said = f", but {rest}" if rest else ""
    out.note(f"no capture or score in {' '.join(paths)}{said}")
    raise typer.Exit(1)


def _count(tally: Counter[str], outcome: Outcome, division: int) -> None:
    tally.update({outcome.status: 1, "frames": outcome.frames, "symbols": outcome.symbols})
    tally["milliseconds"] += round(1000 * outcome.seconds)
    tally["warnings"] += len(outcome.warnings)
    tally["anew"] += outcome.held and outcome.status == "added"
    tally["moved"] += bool(outcome.moved) and outcome.status == "unchanged"
    tally["labelled"] += outcome.labelled
    tally["finer"] += outcome.division > division


def _summary(out: Output, tally: Counter[str], files: int, elapsed: float, dry_run: bool) -> None:
    from lanindex.app.formatting import counted, duration

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
    said = ", ".join(f"{number} {word}" for word, number in counts.items() if number)
    out.note(
        f"{counted(files, 'file')}: {said or 'nothing to do'}; "
        f"{duration(tally['milliseconds'] / 1000)} of movement, "
        f"{counted(tally['symbols'], 'symbol')}, in {elapsed:.1f} s"
    )


def _afterwards(out: Output, tally: Counter[str], rest: str, division: int, dry_run: bool) -> None:
    from lanindex.app.formatting import counted

    if rest:
        out.note(f"left out: {rest}")
    if tally["warnings"] and not (out.verbose or out.json):
        shown = "-v shows" if dry_run else "lanindex list --doubts tells"
        out.note(f"{counted(tally['warnings'], 'warning')}: {shown} more")
    if tally["finer"]:
        finer = counted(tally["finer"], "score")
        out.detail(f"grid finer than 1/{division} of a unit: {finer}")


def _report(out: Output, outcome: Outcome) -> None:
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
