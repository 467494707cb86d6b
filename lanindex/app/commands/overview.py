"""The verbs that look at many captures at once: stats, motifs, similar, evaluate."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex import records
from lanindex.app import options
from lanindex.app.options import argument, dependent, exclusive, flag, option
from lanindex.app.output import Output, cut_note, duration, say_error
from lanindex.errors import UsageError, counted

if TYPE_CHECKING:
    from lanindex.evaluate import Result
    from lanindex.library.stats import Stats
    from lanindex.pipeline.example import Groups, Similar
    from lanindex.pipeline.motifs import Motifs, Recurring
    from lanindex.pipeline.movement import Movement

LABELS_ON_TERMINAL = 20  # labels that a terminal shows of a library
MOTIFS_ON_TERMINAL = 20  # motifs that a terminal shows without --limit


def stats(
    by: str | None = option(None, "COLUMN", "How movement is spread, by label or another column."),
    compare: tuple[str, str] | None = option(None, "A B", "Only two of its values."),
    part: options.Part = None,
    plot: Path | None = option(None, "FILE.svg|png|pdf", "Draw it.", readable=False),
    *,
    selection: options.Selected,
    cluster: options.Cluster = None,
    force: options.Force = False,
    db: options.Db = options.DB,
    out: options.Out,
) -> int:
    """Summarize the library; with --by or --plot, how movement is spread in it.

    For each group: where each part goes, from where, how often. For two groups: how they differ.
    A capture is one observation; the intervals hold for all comparisons together.
    """
    dependent("--compare", compare, on="--by", given=by)
    dependent("--force", force, on="--plot", given=plot)
    detailed = any((by, part, plot, selection.globs))
    dependent("--cluster", cluster, on="--by, --part, --plot or --in", given=detailed)
    with options.opened(db, out, cluster=cluster) as library:
        if not detailed:
            _summarize(out, library.stats())
            return 0
        movement = library.movement(
            by=by or "", compared=compare, parts=part or (), selection=selection
        )
    if plot:
        from lanindex.pipeline.charts import charted
        from lanindex.pipeline.files import refuse, write_all

        refuse(plot, force=force)
        content = charted(movement, plot.suffix.lower().removeprefix("."))
        write_all([(plot, content)], force=force)
        out.note(str(plot))
    groups = list(movement.groups)
    if out.json:
        if compare:
            pair = groups[0], groups[1]
            out.records(one.record(movement.by, pair) for one in movement.differences)
        else:
            out.records(moves.record(movement.by) for moves in movement.moves)
    else:
        _moves(out, movement)
        if len(groups) == 2:
            out.line()
            _differences(out, movement)
    return not any(movement.groups.values())


def _summarize(out: Output, stats: Stats) -> None:
    """Print what the library holds."""
    if out.json:
        return out.record(asdict(stats))
    from lanindex.alphabet import TRACKS

    labels, cut = len(stats.labels), out.terminal and len(stats.labels) > LABELS_ON_TERMINAL
    if cut:
        most = Counter(stats.labels).most_common(LABELS_ON_TERMINAL)
        stats = replace(stats, labels=dict(most))
    rows = [
        ("captures", f"{stats.captures}"),
        ("movement", f"{duration(stats.seconds)}, {stats.frames} frames"),
        ("symbols", f"{stats.symbols}"),
        ("size", f"{stats.size / 1e6:.1f} MB"),
    ]
    for noun in ("format", "profile", "label", "part"):
        counts = getattr(stats, f"{noun}s")
        rows += [(f"{noun} {name or '(none)'}", f"{number}") for name, number in counts.items()]
    rows += [
        (f"coverage {part}", f"{share:.1%}") for part, share in stats.coverage.items() if share < 1
    ]
    never = [part for part in TRACKS if part not in stats.parts]
    rows += [("in no capture", " ".join(never))] if stats.captures and never else []
    out.table(("what", "how much"), rows)
    if cut:
        out.note(f"the {LABELS_ON_TERMINAL} most frequent of {labels:,} labels; --json has all")


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
    min_count: int = option(5, "N", "How often one must occur."),
    length: int = option(3, "N", "How many symbols it must have."),
    part: options.Part = None,
    limit: options.Limit = None,
    everything: bool = flag("--all", "Look through all captures, not a sample of 5,000."),
    *,
    selection: options.Selected,
    timeout: options.Timeout = None,
    cluster: options.Cluster = None,
    db: options.Db = options.DB,
    out: options.Out,
) -> int:
    """List sequences of symbols that recur.

    Each is a pattern that can be pasted into a search and has as many hits there. The motif that
    accounts for most symbols comes first, then the one that accounts for most of the rest. A
    sequence that occurs only within a longer motif is left out. Exits with 1 if nothing recurs.
    """
    from lanindex.pipeline.motifs import SAMPLE

    sample = None if everything else SAMPLE
    with options.opened(db, out, cluster=cluster) as library:
        result = library.motifs(
            selection,
            min_count=min_count,
            length=length,
            parts=part,
            sample=sample,
            timeout=timeout,
        )
    motifs = result.found
    shown = motifs[: limit or (MOTIFS_ON_TERMINAL if out.terminal else None)]
    folder = out.folder(motif.first.capture.path for motif in shown)
    for motif in shown:
        _motif(out, motif, result, folder)
    out.notes(result.notes)
    _note_sample(out, result, "were looked through: --all looks through all")
    cut, captures = cut_note(len(shown), len(motifs)), counted(result.captures, "capture")
    out.note(f"{counted(len(motifs), 'motif')} in {captures}{cut}")
    return not motifs


def _note_sample(out: Output, result: Motifs | Groups, remedy: str) -> None:
    """Say of how many captures a sample was taken, if it was."""
    if result.captures < result.of:
        sample = f"{result.captures:,} of {counted(result.of, 'capture')}"
        out.note(f"{sample}, taken at random, {remedy}")


def _motif(out: Output, motif: Recurring, result: Motifs, folder: str) -> None:
    path, span = motif.first.capture.path.removeprefix(folder), motif.first.span
    frames = f"[{span.start}, {span.stop})"
    if out.terminal:
        times = f"{counted(motif.hits, 'hit')} in {counted(motif.captures, 'capture')}"
        out.line(out.paint(motif.pattern, "match"))
        out.line(out.paint(f"    {times}, first {path} {frames}", "dim"))
        return
    if not out.json:
        out.row([motif.hits, motif.captures, motif.pattern, path, frames])
        return
    places = [
        {
            **records.of_name(place.capture),
            "start_frame": place.span.start,
            "end_frame": place.span.stop,
        }
        for place in motif.places
    ]
    counts = {"hits": len(places), "captures": motif.captures, "places": places}
    sample = {"sampled": result.captures, "of": result.of}
    out.record({"pattern": motif.pattern, "part": motif.part, **counts, **sample})


def similar(
    groups: int | None = option(None, None, "How many groups to make.", min=1),
    alike: float | None = option(None, "0..1", "Least mean likeness in a group: 0.4."),
    everything: bool = flag("--all", "Compare all captures, not a sample of 2,000."),
    *,
    selection: options.Selected,
    timeout: options.Timeout = None,
    cluster: options.Cluster = None,
    db: options.Db = options.DB,
    out: options.Out,
) -> int:
    """Group captures that are alike.

    Groups are joined while their captures are alike on average. Each starts with the capture that
    is most like all its others. Exits with 1 if there are no groups.
    """
    exclusive("--groups", groups is not None, {"--alike": alike is not None})
    from lanindex.pipeline.example import ALIKE, SAMPLE

    sample, least = None if everything else SAMPLE, ALIKE if alike is None else alike
    with options.opened(db, out, cluster=cluster) as library:
        result = library.similar(
            selection, groups=groups, alike=least, sample=sample, timeout=timeout
        )
    alone = sum(len(group.captures) == 1 for group in result.groups)
    # on a terminal the summary counts those of one capture, which come last
    shown = result.groups[: len(result.groups) - alone] if out.terminal else result.groups
    if shown:
        group_records = (
            {
                "group": number,
                "count": len(group.captures),
                "likeness": round(group.likeness, 3),
                **records.of_name(group.captures[0]),
                "label": group.captures[0].label,
                "captures": [capture.path for capture in group.captures],
                "sampled": result.captures,
                "of": result.of,
            }
            for number, group in enumerate(shown, 1)
        )
        head = ("captures", "alike", "labels", "most like all", "others")
        folder = out.folder(capture.path for group in shown for capture in group.captures)
        out.table(head, (_group(out, group, folder) for group in shown), group_records)
    out.detail(f"{result.pairs:,} pairs were compared: {'all' if result.every else 'the nearest'}")
    _note_sample(out, result, "were compared: --all compares all")
    if not result.every:
        out.note("each capture was compared with those of like movements only, not with all")
    count, single = len(result.groups), f", {alone:,} of them of one capture"
    if groups is None:
        count, single = count - alone, f"; {counted(alone, 'capture')} like no other"
    captures = counted(result.captures, "capture")
    out.note(f"{counted(count, 'group')} of {captures}{single if alone else ''}")
    return not result.groups


def _group(out: Output, group: Similar, folder: str) -> tuple[str, ...]:
    """Return a group's row; on a terminal, its first labels and captures only."""
    labels = Counter(capture.label or "-" for capture in group.captures).most_common()
    counts = [f"{count} {label}" for label, count in labels]
    first, *others = [capture.path.removeprefix(folder) for capture in group.captures]
    if out.terminal:
        counts[3:] = [] if len(counts) <= 3 else ["…"]
        others[2:] = [] if len(others) <= 2 else ["…"]
    named = ", ".join(counts).replace(", …", " …")
    return (str(len(group.captures)), f"{group.likeness:.2f}", named, first, " ".join(others))


def evaluate(
    folder: str = argument(..., "FOLDER", "The captures."),
    labels: str = option(..., "CSV", "Columns file and label."),
    patterns: str = option(..., "TOML", "Patterns and their positives."),
    profile: options.Profile = "default",
    jobs: options.Jobs = None,
    cluster: options.Cluster = None,
    words: options.Words = None,
    misses: bool = flag("--misses", "Say which clips were judged wrongly, and why."),
    near: options.Near = False,
    fuzzy: options.Fuzzy = None,
    timeout: options.Timeout = None,
    *,
    out: options.Out,
) -> int:
    """Measure patterns against labelled captures.

    A clip is found if a pattern has at least one hit in it. Files that are both in FOLDER and in
    the CSV count. PATTERNS: name = {pattern = "r_arm high", positives = ["label", "walk*", ...]}.
    """
    from lanindex.encoding.profile import load
    from lanindex.evaluate import evaluate, read_clips, read_patterns, summary
    from lanindex.pipeline.ingest import discover, key_of, read_labels, unfitting
    from lanindex.pipeline.prepare import processes
    from lanindex.pipeline.search import too_rich

    exclusive("--jobs", jobs, {"--cluster": cluster})
    expectations, table = read_patterns(patterns, words), read_labels(labels)
    if not any(label for label, _ in table.values()):
        raise UsageError("no labels", place=labels, wanted='a column "label"')
    count = sum(key_of(path) in table for path in discover([folder]))
    with options.spread(cluster, out) as spread:
        how: dict[str, Any] = {"jobs": processes(count, jobs), "spread": spread}
        reader = read_clips(folder, table, load(profile), **how)
        clips = list(out.progress(reader, count, "clips"))
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
        chosen: dict[str, Any] = {"near": near, "fuzzy": fuzzy, "timeout": timeout}
        results = evaluate(clips, expectations, **chosen, progress=out.watch, spread=spread)
    for result in results:
        for line in too_rich(result.refused):
            say_error(f"{result.expectation.name}: {line}; it counts as not found")
    _results(out, results, misses)
    total = summary(results)
    mean, error = total["mean_f1"], total["standard_error"]
    if out.json:
        out.record({"pattern": "(mean)", **total})
    elif mean is not None:
        counts = (counted(total[f"{noun}s"], noun) for noun in ("pattern", "clip"))
        out.line(", ".join((f"mean F1 {mean:.3f} ± {error:.3f}", *counts)))
    if mean is None:
        out.note("nothing was measured: no clip has a label that a pattern should find")
    return 2 if failed or any(result.refused for result in results) else mean is None


def _results(out: Output, results: list[Result], misses: bool) -> None:
    """Print the figures of each pattern, and the clips that were judged wrongly if `misses`."""
    from lanindex.model.capture import in_words

    lines = [result.record(misses=misses and out.json) for result in results]
    figures, counts = ("precision", "recall", "f1"), ("found_rightly", "found_wrongly", "missed")
    rows = []
    for record in lines:
        values = ("-" if record[key] is None else f"{record[key]:.3f}" for key in figures)
        rows.append((record["name"], *values, *(record[key] for key in counts)))
    out.table(("pattern", *figures, "right", "wrong", "missed"), rows, lines)
    for result in results:
        for miss in result.misses if misses and not out.json else ():
            kind, capture = "wrongly" if miss.hit else "missed", miss.capture
            out.line(f"{result.expectation.name}: {kind} {capture.path} ({capture.label})")
            if miss.hit:
                span, symbols = miss.hit.span, ", ".join(in_words(miss.hit.symbols))
                out.line(f"    frames {span.start}-{span.stop}: {symbols}")
            else:
                out.line(f"    {result.obstacle(miss)}")
