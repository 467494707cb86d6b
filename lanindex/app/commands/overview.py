"""The verbs that look at many captures at once: stats, motifs, similar."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output, counted, duration, end_progress
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.library.stats import Stats
    from lanindex.pipeline.motifs import Motifs, Recurring
    from lanindex.pipeline.movement import Movement
    from lanindex.pipeline.similar import Groups, Similar

MOTIFS_ON_TERMINAL = 20
"""Motifs that a terminal shows without --limit."""


def stats(
    by: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="How movement is spread, by label or another column."),
    ] = None,
    compare: Annotated[
        tuple[str, str] | None, typer.Option(metavar="A B", help="Only two of its values.")
    ] = None,
    part: options.Part = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE.svg|png|pdf", help="Draw it.", readable=False)
    ] = None,
    within: options.In = None,
    where: options.Where = None,
    force: options.Force = False,
    db: options.Db = options.DB,
    *,
    out: options.Out,
) -> None:
    """Summarize the library; with --by or --plot, how movement is spread in it.

    For each group: where each part goes, from where, how often. For two groups: how they differ.
    A capture is one observation; the intervals hold for all comparisons together.
    """
    if compare and not by:
        raise UsageError("--compare", wanted="--by beside it")
    if force and not plot:
        raise UsageError("--force", wanted="--plot beside it")
    from lanindex.pipeline import open_library

    with open_library(db, readonly=True) as library:
        if not any((by, part, plot, within is not None, where)):
            return _summarize(out, library.stats())
        movement = library.movement(
            by=by or "",
            compared=compare,
            parts=part or (),
            selection=options.selection(within, where),
        )
    if plot:
        from lanindex.pipeline.charts import charted
        from lanindex.pipeline.files import write_all

        content = charted(movement, plot.suffix.lower().removeprefix("."))
        write_all([(plot, content)], force=force)
        out.note(str(plot))
    groups = list(movement.groups)
    if out.json:
        for difference in movement.differences if compare else ():
            out.record(difference.record(movement.by, (groups[0], groups[1])))
        for moves in () if compare else movement.moves:
            out.record(moves.record(movement.by))
    else:
        _moves(out, movement)
        if len(groups) == 2:
            out.line()
            _differences(out, movement)
    if not any(movement.groups.values()):
        raise typer.Exit(1)


def _summarize(out: Output, stats: Stats) -> None:
    """Print what the library holds."""
    if out.json:
        return out.record(asdict(stats))
    from lanindex.alphabet import TRACKS

    rows = [
        ("captures", f"{stats.captures}"),
        ("movement", f"{duration(stats.seconds)}, {stats.frames} frames"),
        ("symbols", f"{stats.symbols}"),
        ("size", f"{stats.size / 1e6:.1f} MB"),
    ]
    for name, counts in (
        ("format", stats.formats),
        ("profile", stats.profiles),
        ("label", stats.labels),
        ("part", stats.parts),
    ):
        rows += [(f"{name} {key or '(none)'}", f"{number}") for key, number in counts.items()]
    rows += [
        (f"coverage {part}", f"{share:.1%}") for part, share in stats.coverage.items() if share < 1
    ]
    never = [part for part in TRACKS if part not in stats.parts]
    rows += [("in no capture", " ".join(never))] if stats.captures and never else []
    out.table(("what", "how much"), rows)


def _moves(out: Output, movement: Movement) -> None:
    """Print how movement is spread: a line for each part of a group."""
    from lanindex.pipeline.movement import CELLS

    rows = []
    for moves in movement.moves:
        order = (-moves.cells).argsort(kind="stable")[:3].tolist()
        rows.append(
            (
                moves.group or "(none)",
                moves.part,
                moves.captures,
                int(moves.cells.sum()),
                f"{moves.rate:.2f}",
                f"{moves.coverage:.0%}",
                ", ".join(f"{CELLS[it]} {moves.cells[it]}" for it in order if moves.cells[it]),
            )
        )
    group = movement.by or "group"
    out.table((group, "part", "captures", "moves", "a second", "known", "most often"), rows)


def _differences(out: Output, movement: Movement) -> None:
    """Print the differences between two groups that matter."""
    rows = []
    for one in movement.differences:
        if not one.matters:
            continue
        unit, factor, digits = ("/s", 1, 2) if one.what == "rate" else ("%", 100, 1)
        first, second = one.values
        numbers = (first, second, second - first, one.least, one.most)
        a, b, change, least, most = (f"{number * factor:.{digits}f}" for number in numbers)
        values = f"{a} {unit} ({one.movements[0]})", f"{b} {unit} ({one.movements[1]})"
        interval = f"{least} to {most}"
        rows.append((one.part, one.what, *values, f"{change} {unit}", interval, f"{one.p:.3f}"))
    if rows:
        groups = (group or "(none)" for group in movement.groups)
        out.table(("part", "where", *groups, "difference", "95% interval", "p"), rows)
    out.note(
        f"{len(rows)} of {len(movement.differences)} differences matter: means over captures, the "
        "number of movements in brackets; intervals and p hold for all of them together"
    )


def motifs(
    min_count: Annotated[
        int, typer.Option("--min-count", metavar="N", help="How often one must occur.")
    ] = 5,
    length: Annotated[
        int, typer.Option("--length", metavar="N", help="How many symbols it must have.")
    ] = 3,
    part: options.Part = None,
    limit: options.Limit = None,
    everything: Annotated[
        bool, typer.Option("--all", help="Look through all captures, not a sample of 5,000.")
    ] = False,
    within: options.In = None,
    where: options.Where = None,
    timeout: options.Timeout = None,
    db: options.Db = options.DB,
    *,
    out: options.Out,
) -> None:
    """List sequences of symbols that recur.

    Each is a pattern that can be pasted into a search and has as many hits there. The motif that
    accounts for most symbols comes first, then the one that accounts for most of the rest. A
    sequence that occurs only within a longer motif is left out. Exits with 1 if nothing recurs.
    """
    from lanindex.pipeline import open_library
    from lanindex.pipeline.motifs import SAMPLE

    with open_library(db, readonly=True, note=out.note, progress=out.watch) as library:
        found = library.motifs(
            min_count=min_count,
            length=length,
            parts=part,
            sample=None if everything else SAMPLE,
            selection=options.selection(within, where),
            timeout=timeout,
        )
    end_progress()
    motifs = found.found
    shown = motifs[: limit or (MOTIFS_ON_TERMINAL if out.terminal else None)]
    for motif in shown:
        _motif(out, motif, found)
    for line in found.notes:
        out.note(line)
    if found.captures < found.of:
        sample = f"{found.captures:,} of {counted(found.of, 'capture')}"
        out.note(f"{sample}, taken at random, were looked through: --all looks through all")
    cut = f"; {len(shown)} are shown, --limit shows more" if len(shown) < len(motifs) else ""
    captures = counted(found.captures, "capture")
    out.note(f"{counted(len(motifs), 'motif')} in {captures}{cut}")
    if not motifs:
        raise typer.Exit(1)


def _motif(out: Output, motif: Recurring, found: Motifs) -> None:
    first = motif.places[0]
    span = f"[{first.span.start}, {first.span.stop})"
    if out.json:
        from lanindex import records

        places = [(place.capture, place.span) for place in motif.places]
        counts = motif.captures, places, found.captures, found.of
        out.record(records.of_motif(motif.pattern, motif.part, *counts))
    elif out.terminal:
        times = f"{counted(motif.hits, 'hit')} in {counted(motif.captures, 'capture')}"
        out.line(out.paint(motif.pattern, "match"))
        out.line(out.paint(f"    {times}, first {first.capture.path} {span}", "dim"))
    else:
        out.row([motif.hits, motif.captures, motif.pattern, first.capture.path, span])


def similar(
    groups: Annotated[
        int | None, typer.Option("--groups", min=1, help="How many groups to make.")
    ] = None,
    alike: Annotated[
        float | None,
        typer.Option("--alike", metavar="0..1", help="Least mean likeness in a group: 0.4."),
    ] = None,
    everything: Annotated[
        bool, typer.Option("--all", help="Compare all captures, not a sample of 2,000.")
    ] = False,
    within: options.In = None,
    where: options.Where = None,
    timeout: options.Timeout = None,
    db: options.Db = options.DB,
    *,
    out: options.Out,
) -> None:
    """Group captures that are alike.

    Groups are joined while their captures are alike on average. Each starts with the capture that
    is most like all its others. Exits with 1 if there are no groups.
    """
    if groups is not None and alike is not None:
        raise UsageError("--groups and --alike", wanted="one of them")
    from lanindex import records
    from lanindex.pipeline import open_library
    from lanindex.pipeline.similar import ALIKE, SAMPLE

    with open_library(db, readonly=True, note=out.note, progress=out.watch) as library:
        found = library.similar(
            groups=groups,
            alike=ALIKE if alike is None else alike,
            sample=None if everything else SAMPLE,
            selection=options.selection(within, where),
            timeout=timeout,
        )
    end_progress()
    rows = []
    for number, group in enumerate(found.groups, 1):
        if out.json:
            counts = found.captures, found.of
            out.record(records.of_group(number, group.captures, group.likeness, *counts))
        elif out.terminal and len(group.captures) == 1:
            break  # so are all that follow; the summary counts them
        else:
            rows.append(_group(out, group))
    if rows:
        out.table(("captures", "alike", "labels", "most like all", "others"), rows)
    _similar_summary(out, found, groups)
    if not found.groups:
        raise typer.Exit(1)


def _group(out: Output, group: Similar) -> tuple[str, ...]:
    """Return a group's row; on a terminal, its first labels and captures only."""
    labels = Counter(capture.label or "-" for capture in group.captures).most_common()
    counts = [f"{count} {label}" for label, count in labels]
    first, *others = [capture.path for capture in group.captures]
    if out.terminal:
        counts[3:] = [] if len(counts) <= 3 else ["…"]
        others[2:] = [] if len(others) <= 2 else ["…"]
    named = ", ".join(counts).replace(", …", " …")
    return (str(len(group.captures)), f"{group.likeness:.2f}", named, first, " ".join(others))


def _similar_summary(out: Output, found: Groups, requested: int | None) -> None:
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
    if requested is not None:
        single = f", {alone:,} of them of one capture" if alone else ""
        out.note(f"{counted(len(found.groups), 'group')} of {captures}{single}")
    else:
        single = f"; {counted(alone, 'capture')} like no other" if alone else ""
        out.note(f"{counted(len(several), 'group')} of {captures}{single}")
