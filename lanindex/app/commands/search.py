"""``lanindex search``: find movement by pattern, or by a clip that is like it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import completion, options
from lanindex.app.commands.words import pattern_of
from lanindex.app.output import Output, choice, counted, end_progress
from lanindex.errors import UsageError, shown

if TYPE_CHECKING:
    from lanindex.pipeline import Library
    from lanindex.pipeline.example import Alike
    from lanindex.search.explain import Trace
    from lanindex.search.hits import Counts, Hits

ON_TERMINAL = 20
"""Hits that a terminal shows without --limit."""

LIKE_LIMIT = 100
"""Captures that --like shows in a pipe without --limit."""

TROUBLES = 10
"""Hits that cannot be drawn, as many as are named."""

TIER = "hits"
"""The default name of a tier."""


def run(
    patterns: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[PATTERN]",
            help="r_arm right mid -> high",
            autocompletion=completion.patterns,
        ),
    ] = None,
    like: Annotated[
        str | None,
        typer.Option("--like", metavar="CLIP[:FROM-TO]", help="Find what is like a capture."),
    ] = None,
    rerank: Annotated[
        bool, typer.Option("--rerank", help="With --like: compare joint positions, too.")
    ] = False,
    limit: options.Limit = None,
    within: options.In = None,
    where: options.Where = None,
    sort: Annotated[
        str, typer.Option(metavar="fit|time", help="Best fit or earliest first.")
    ] = "time",
    overlaps: options.Overlaps = "none",
    tolerance: options.Tolerance = 0.1,
    near: options.Near = False,
    fuzzy: options.Fuzzy = None,
    timeout: options.Timeout = None,
    memory: options.Memory = None,
    words: options.Words = None,
    count: Annotated[bool, typer.Option("--count", help="Count the hits in each capture.")] = False,
    strict: options.Strict = False,
    explain: Annotated[
        bool,
        typer.Option(
            "--explain",
            help="Say how the pattern is understood; --explain plan: how it is searched.",
        ),
    ] = False,
    why: Annotated[
        str | None,
        typer.Option(
            "--why",
            metavar="CAPTURE",
            autocompletion=completion.captures,
            help="Say what matched in one capture, or where matching failed.",
        ),
    ] = None,
    context: Annotated[
        str | None,
        typer.Option(
            "--context",
            metavar="TIME",
            help="Draw the staff of each hit and this much around it: 0, 0.5s, 10f.",
        ),
    ] = None,
    into: Annotated[
        Path | None,
        typer.Option("--into", metavar="FILE", help="Add the hits to an existing .eaf file."),
    ] = None,
    tier: Annotated[
        str | None, typer.Option("--tier", metavar="NAME", help="The tier to add there: hits.")
    ] = None,
    preview: Annotated[
        Path | None,
        typer.Option(
            "--preview",
            metavar="FILE.png|svg|html",
            help="Draw the hits: poses and staves on a sheet, or a page on which they play.",
        ),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Replace an existing tier or file.")
    ] = False,
    db: options.Db = options.DB,
    *,
    out: options.Out,
) -> None:
    """Find movement by pattern.

    Parts, directions and levels as in Labanotation: "r_arm right mid -> high",
    "arms place high 1s+", "r_arm high with l_arm low". The whole language: lanindex language.
    Or a word of the dictionary of movement, such as walk: lanindex words.
    Exits with 1 if nothing is found.
    """
    choice("--sort", sort, ("fit", "time"))
    choice("--overlaps", overlaps, ("none", "all"))
    arguments = list(patterns or ())
    plan = explain and len(arguments) == 2 and "plan" in arguments
    if plan:
        arguments.remove("plan")
    if len(arguments) > 1:
        raise UsageError(f'"{arguments[1]}" behind the pattern', remedy="Quote the pattern.")
    pattern = arguments[0] if arguments else None
    others = {"--like": like, "--explain": explain, "--why": why, "--json": out.json}
    others |= {"--count": count}
    _refuse("--context", context, {**others, "--into": into})
    _refuse("--preview", preview, {**others, "--into": into, "--context": context})
    _refuse("--into", into, {**others, "--rerank": rerank})
    if into is None and tier:
        raise UsageError("--tier", wanted="--into beside it")
    if into is None and preview is None and force:
        raise UsageError("--force", wanted="--into or --preview beside it")
    _check_files(context, preview, force)
    among: dict[str, Any] = {"selection": options.selection(within, where)}
    if pattern is None or like is not None or rerank:
        if like is None:
            given = "nothing to search for" if pattern is None else "--rerank"
            raise UsageError(given, wanted="--like" if rerank else "a pattern or --like")
        beside = {"a pattern": pattern, "--explain": explain, "--why": why, "--count": count}
        _refuse("--like", like, beside)
        return _like(out, db, options.one_line(like), rerank, limit, timeout, among)
    _refuse("--why", why, {"--fuzzy": fuzzy is not None})
    from lanindex.pipeline import open_library
    from lanindex.search.hits import Counts
    from lanindex.search.language.score import pattern_in

    typed, pattern = pattern, pattern_in(pattern)
    how: dict[str, Any] = {"tolerance": tolerance, "overlaps": overlaps, "strict": strict}
    how["near"] = near
    with open_library(db, readonly=True, words=words, note=out.note, progress=out.watch) as library:
        pattern = pattern_of(out, library, pattern, words)
        if why is not None:
            return _why(out, library.why(pattern, options.capture_id(why), **how))
        if explain:
            text = library.explain(pattern, strict=strict, plan=plan, **among)
            return out.record({"explain": text}) if out.json else out.text(text)
        by_fit = sort == "fit"
        best = limit if by_fit and fuzzy is not None and not count else None
        bounds: dict[str, Any] = {"timeout": timeout, "memory": memory}
        found = library.search(pattern, fuzzy=fuzzy, best=best, **bounds, **how, **among)
        end_progress()
        if isinstance(found, Counts):
            for name, value in (("--into", into), ("--context", context), ("--preview", preview)):
                _refuse(name, value, {"| count": True})
            _counts(out, found, limit)
        elif into is not None and found:
            if found.captures > 1:
                several = f"hits in {found.captures} captures"
                remedy = "Choose one with --in."
                raise UsageError(several, place="--into", wanted="one", remedy=remedy)
            hits = (found.by_fit(limit) if by_fit else found)[:limit]
            _write_tier(out, hits, into, tier or TIER, typed, force=force)
        elif count:
            tally = dict(found.tally())
            for number, path in library.store.texts("path", tally).items():
                if out.json:
                    out.record({"capture": path, "capture_id": number, "count": tally[number]})
                else:
                    out.row([path, tally[number]])
            _summary(out, found, len(found))
        else:
            _hits(out, library, found, limit, by_fit, best, context, preview, force)
        if not found and not out.quiet:
            advice = library.suggest(pattern, fuzzy=fuzzy, **how, **among)
            for line in [advice.brief] if out.json else str(advice).split("\n"):
                out.note(line)
        if library.refused or not found:
            raise typer.Exit(2 if library.refused else 1)


def _refuse(name: str, value: object, others: Mapping[str, object]) -> None:
    """Refuse options that cannot stand beside another."""
    for other, given in others.items():
        if value and given:
            raise UsageError(f"{name} and {other}", wanted="one of them")


def _check_files(context: str | None, preview: Path | None, force: bool) -> None:
    """Refuse a bad --context or --preview before the search."""
    if context is not None:
        from fractions import Fraction

        from lanindex.pipeline.export import pad_frames

        pad_frames(context, Fraction(1), "--context")
    if preview is not None:
        from lanindex.pipeline.files import refuse
        from lanindex.pipeline.preview import form_of

        form_of(preview)
        refuse(preview, force=force)


def _hits(
    out: Output,
    library: Library,
    found: Hits,
    limit: int | None,
    by_fit: bool,
    best: int | None,
    context: str | None,
    preview: Path | None,
    force: bool,
) -> None:
    """Print or draw hits; `best` is how many were searched for, if not all."""
    from lanindex.app import formatting

    most = limit or (ON_TERMINAL if out.terminal else None)
    if limit is None and preview is not None:
        from lanindex.pipeline.preview import FORMS, form_of

        most = FORMS[form_of(preview)]
    hits = (found.by_fit(most) if by_fit else found)[:most]
    if preview is None and context is None:
        formatting.hits(out, hits, hits.pattern)
    elif preview is None and context is not None:
        formatting.hits_with_staves(out, library, hits, context)
    elif preview is not None and hits:
        _draw(out, library, hits, preview, force)
    _summary(out, found, len(hits), all_searched=len(found) != best)


def _summary(out: Output, found: Hits, shown: int, *, all_searched: bool = True) -> None:
    cut = f"; {shown} are shown, --limit shows more" if shown < len(found) else ""
    cut = cut if all_searched else "; no others fit better, --limit shows more"
    out.note(f"{counted(len(found), 'hit')} in {counted(found.captures, 'capture')}{cut}")


def _counts(out: Output, found: Counts, limit: int | None) -> None:
    """Print what a pattern that ends in ``| count`` counted."""
    rows = found.dicts()[:limit]
    if out.json:
        for row in rows:
            out.record(row)
    elif found.by is None:
        out.row([found.total])
    else:
        values = (("-" if row["value"] is None else row["value"], row["count"]) for row in rows)
        out.table((str(found.by), "hits"), list(values))
    cut = f"; {len(rows)} are shown, --limit shows more" if len(rows) < len(found) else ""
    by = f" by {counted(len(found), 'value')}" if found.by else ""
    out.note(f"{counted(found.total, 'hit')}{by}{cut}")


def _draw(out: Output, library: Library, hits: Hits, path: Path, force: bool) -> None:
    """Write the files that show hits, and say which hits they cannot show."""
    from functools import partial

    from lanindex.pipeline.export import suspects
    from lanindex.pipeline.files import write_all
    from lanindex.pipeline.preview import preview

    sizes: list[tuple[Path, int]] = []
    troubles: list[str] = []

    def files() -> Iterator[tuple[Path, bytes]]:
        for file, content, untold in preview(library.store, hits, path, out.watch):
            sizes.append((file, len(content)))
            troubles.extend(untold)
            yield file, content

    write_all(files(), force=force, suspects=partial(suspects, library.store))
    end_progress()
    for line in troubles[:TROUBLES]:
        out.note(f"not drawn: {line}")
    if len(troubles) > TROUBLES:
        out.note(f"and {len(troubles) - TROUBLES} more, each with its reason in the picture")
    for file, size in sizes:
        out.line(str(file))
        out.note(f"{file}: {size / 1000:,.0f} kB")


def _write_tier(
    out: Output, hits: Hits, into: Path, tier: str, pattern: str, *, force: bool
) -> None:
    """Write the hits of one capture into an ELAN file: the pattern and the fit of each."""
    from lanindex.notation import content_of, eaf
    from lanindex.notation.tiers import TierEntry, milliseconds
    from lanindex.pipeline.files import write_all

    text, entries = " ".join(pattern.split()), []
    for hit in hits:
        start = milliseconds(hit.span.start, hit.capture.rate)
        stop = milliseconds(hit.span.stop, hit.capture.rate)
        entries.append(TierEntry(f"{text} {hit.fit:.2f}", start, max(stop, start + 1)))
    place = str(into)
    content = eaf.mark(content_of(place), tier, entries, place=place, force=force)
    write_all([(into, content)], force=True)
    out.note(f"{place}: {counted(len(entries), 'hit')} in the tier {shown(tier)}")


def _why(out: Output, trace: Trace) -> None:
    """Print how a pattern met one capture; exit with 1 if it has no hits there."""
    from lanindex.app import formatting
    from lanindex.search.explain.why import records_of

    if trace.refused:
        raise trace.refused
    if out.json:
        for record in records_of(trace):
            out.record(record)
    else:
        formatting.trace(out, trace)
    raise typer.Exit(not trace.hits)


def _like(
    out: Output,
    db: str,
    clip: str,
    rerank: bool,
    limit: int | None,
    timeout: float | None,
    among: Mapping[str, Any],
) -> None:
    """Print what is like a clip; exit with 1 if nothing is."""
    from lanindex import records
    from lanindex.app import formatting
    from lanindex.pipeline import open_library

    most = limit or (ON_TERMINAL if out.terminal else LIKE_LIMIT)
    reach = max(most, LIKE_LIMIT) if rerank else most
    with open_library(db, readonly=True, note=out.note, progress=out.watch) as library:
        found = library.like(clip, limit=reach, rerank=rerank, timeout=timeout, **among)
    end_progress()
    hits = found.hits[:most]
    if out.terminal:
        rows = []
        for hit in hits:  # of the symbols, only where most of them correspond
            begin, end = (records.seconds(hit.capture, frame) for frame in (hit.start, hit.stop))
            common = f"{counted(len(hit.symbols), 'symbol')} of {hit.symbols[0].part}"
            times = f"{hit.start}-{hit.stop}", f"{begin:.2f}-{end:.2f}"
            rows.append((f"{hit.fit:.2f}", hit.path, hit.capture.label, *times, common))
        out.table(("like", "capture", "label", "frames", "seconds", "most in common"), rows)
    else:
        formatting.hits(out, hits, found.hits.pattern)
    _like_summary(out, found, len(hits))
    if not found.hits:
        raise typer.Exit(1)


def _like_summary(out: Output, found: Alike, shown: int) -> None:
    for line in found.notes[:3]:
        out.note(f"not ranked by its joints: {line}")
    if len(found.notes) > 3:
        out.note(f"and {len(found.notes) - 3} more")
    if not found.sure:
        out.note(f"{found.aligned:,} captures were looked at closely; others might be as like")
    out.note(f"the {shown} most like of {counted(found.captures, 'capture')}, the likest first")
