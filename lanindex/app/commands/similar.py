"""``lanindex similar``: captures that are like each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output, end_progress

if TYPE_CHECKING:
    from lanindex.pipeline.similar import Groups, Similar


def run(
    groups: Annotated[
        int | None, typer.Option("--groups", min=1, help="How many groups there shall be.")
    ] = None,
    alike: Annotated[
        float | None,
        typer.Option("--alike", metavar="0..1", help="Their mean likeness at least: 0.4."),
    ] = None,
    every: Annotated[
        bool, typer.Option("--all", help="Compare all captures, where else 2,000 are taken.")
    ] = False,
    within: options.In = None,
    where: options.Where = None,
    timeout: options.Timeout = None,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Group the captures that are like each other.

    Groups are joined while their captures are like each other on average; each is told with the
    capture that is most like all others first. Exits with 1 if there is none.
    """
    out = Output(json, quiet, verbose, color)
    from lanindex.errors import UsageError
    from lanindex.pipeline import open_library
    from lanindex.pipeline.similar import ALIKE, SAMPLE

    if groups is not None and alike is not None:
        raise UsageError("--groups and --alike", wanted="one of them")
    with open_library(db, readonly=True) as library:
        library.tell, library.watch = out.note, out.watch
        found = library.similar(
            groups=groups,
            alike=ALIKE if alike is None else alike,
            sample=None if every else SAMPLE,
            within=within,
            where=options.where(where),
            timeout=timeout,
        )
    end_progress()
    _show(out, found)
    _summary(out, found, groups)
    if not found.groups:
        raise typer.Exit(1)


def _show(out: Output, found: Groups) -> None:
    from lanindex import records

    rows = []
    for number, group in enumerate(found.groups, 1):
        if out.json:
            counts = found.captures, found.of
            out.record(records.of_group(number, group.captures, group.likeness, *counts))
        elif out.terminal and len(group.captures) == 1:
            break  # the rest are by themselves, too; they are counted below
        else:
            rows.append(_row(out, group))
    if rows:
        out.table(("captures", "alike", "labels", "most like all", "others"), rows)


def _row(out: Output, group: Similar) -> tuple[str, ...]:
    from collections import Counter

    medoid, *others = group.captures
    labels = Counter(capture.label or "-" for capture in group.captures).most_common()
    told = ", ".join(f"{count} {label}" for label, count in labels[: 3 if out.terminal else None])
    more = "" if len(labels) <= 3 or not out.terminal else " …"
    names = [capture.path for capture in others]
    shown = " ".join(names[:2]) + (" …" if len(names) > 2 else "")
    last = shown if out.terminal else " ".join(names)
    return (str(len(group.captures)), f"{group.likeness:.2f}", told + more, medoid.path, last)


def _summary(out: Output, found: Groups, wanted: int | None) -> None:
    from lanindex.app.formatting import counted

    several = [group for group in found.groups if len(group.captures) > 1]
    alone = len(found.groups) - len(several)
    pairs = "all" if found.every else "the nearest"
    out.detail(f"{found.pairs:,} pairs were compared: {pairs}")
    if found.captures < found.of:
        sample = f"{found.captures:,} of {counted(found.of, 'capture')}"
        out.note(f"{sample}, taken at random, were compared: --all compares all")
    if not found.every:
        out.note("each capture was compared with those of like movements only, not with all")
    captures = counted(found.captures, "capture")
    if wanted is not None:
        single = f", {alone:,} of them of one capture" if alone else ""
        return out.note(f"{counted(len(found.groups), 'group')} of {captures}{single}")
    single = f"; {counted(alone, 'capture')} like no other" if alone else ""
    out.note(f"{counted(len(several), 'group')} of {captures}{single}")
