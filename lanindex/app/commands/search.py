"""``lanindex search``: find movement by pattern."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import meaning, options
from lanindex.app.found import Telling
from lanindex.app.output import Output, end_progress, one_of
from lanindex.app.tiers import Tier
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.search.explain import Advice, Trace


def run(
    pattern: Annotated[
        str | None,
        typer.Argument(
            metavar="PATTERN",
            help="r_arm right mid -> high",
            autocompletion=options.offered("patterns"),
        ),
    ] = None,
    shown: Annotated[str | None, typer.Argument(hidden=True)] = None,
    like: Annotated[
        str | None,
        typer.Option("--like", metavar="CLIP[:FROM-TO]", help="What is like a capture or file."),
    ] = None,
    rerank: Annotated[
        bool, typer.Option("--rerank", help="Order what is like it by its joints, too.")
    ] = False,
    limit: Annotated[
        int | None,
        typer.Option("--limit", "-n", min=1, help="Hits to show: 20 on a terminal, else all."),
    ] = None,
    within: options.In = None,
    where: options.Where = None,
    sort: Annotated[str, typer.Option(metavar="fit|time", help="Clearest or earliest first.")] = (
        "time"
    ),
    overlaps: options.Overlaps = "none",
    tolerance: options.Tolerance = 0.1,
    near: options.Near = False,
    fuzzy: options.Fuzzy = None,
    timeout: options.Timeout = None,
    memory: options.Memory = None,
    words: options.Words = None,
    count: Annotated[bool, typer.Option("--count", help="Count the hits, capture by capture.")] = (
        False
    ),
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
            autocompletion=options.offered("captures"),
            help="Say what matched in one capture, or where the walk through it ended.",
        ),
    ] = None,
    context: Annotated[
        str | None,
        typer.Option(
            "--context",
            metavar="TIME",
            help="Draw the staff of each hit, with so much around it: 0, 0.5s, 10f.",
        ),
    ] = None,
    into: Annotated[
        Path | None,
        typer.Option("--into", metavar="FILE", help="Add the hits to an .eaf that is there."),
    ] = None,
    tier: Annotated[
        str | None, typer.Option("--tier", metavar="NAME", help="As a tier of this name: hits.")
    ] = None,
    preview: Annotated[
        Path | None,
        typer.Option(
            "--preview",
            metavar="FILE.png|svg|html",
            help="Show the hits: poses and staves on a sheet, or a page on which they play.",
        ),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Replace a tier or file that is there.")
    ] = False,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Find movement by pattern.

    Parts, directions and heights as in Labanotation: "r_arm right mid -> high",
    "arms place high 1s+", "r_arm high with l_arm low". The whole language: lanindex language.
    Or a word of the dictionary of movement, such as walk: lanindex words.
    Exits with 1 if nothing is found.
    """
    out = Output(json, quiet, verbose, color)
    one_of("--sort", sort, ("fit", "time"))
    one_of("--overlaps", overlaps, ("none", "all"))
    if explain and pattern == "plan" and shown is not None:
        pattern, shown = shown, pattern
    if shown is not None and not (explain and shown == "plan"):
        raise UsageError(f'"{shown}" behind the pattern', remedy="Quote the pattern.")
    telling = Telling(count, sort == "fit", limit, context, preview, force)
    others = {"--like": like, "--explain": explain, "--why": why, "--json": json}
    telling.check({**others, "--into": into})
    written = Tier(into, tier, force and preview is None)
    written.check({**others, "--count": count, "--context": context, "--rerank": rerank})
    among: dict[str, Any] = {"within": within, "where": options.where(where)}
    if pattern is None or like is not None or rerank:
        from lanindex.app import alike

        asked = alike.Asked(pattern, like, rerank, explain, count, limit)
        return alike.run(out, asked, db, timeout=timeout, **among)
    from lanindex.pipeline import open_library
    from lanindex.search.language.score import pattern_in

    asked_for, pattern = pattern, pattern_in(pattern)
    _refuse_fuzzy(fuzzy, why)
    how: dict[str, Any] = {"tolerance": tolerance, "overlaps": overlaps, "strict": strict}
    how["near"] = near
    with open_library(db, readonly=True) as library:
        library.tell, library.watch, library.words = out.note, out.watch, words
        pattern = meaning.of(out, library, pattern, words)
        if why is not None:
            raise typer.Exit(not _trace(out, library.why(pattern, options.which(why), **how)))
        if explain:
            return _explain(
                out, library.explain(pattern, strict=strict, plan=shown is not None, **among)
            )
        best = limit if sort == "fit" and fuzzy is not None and not count else None
        patience: dict[str, Any] = {"timeout": timeout, "memory": memory}
        found = library.search(pattern, fuzzy=fuzzy, best=best, **patience, **how, **among)
        end_progress()
        if into is not None and found:
            return written.write(out, found, asked_for, limit, by_fit=sort == "fit")
        telling.tell(out, library, found, best)
        if not found and not quiet:
            _advise(out, library.suggest(pattern, fuzzy=fuzzy, **how, **among))
        if library.refused or not found:
            raise typer.Exit(2 if library.refused else 1)


def _refuse_fuzzy(fuzzy: str | None, why: str | None) -> None:
    if fuzzy is not None and why is not None:
        raise UsageError("--why and --fuzzy", wanted="one of them")


def _explain(out: Output, text: str) -> None:
    if out.json:
        out.record({"explain": text})
    else:
        out.text(text)


def _advise(out: Output, advice: Advice) -> None:
    """Say why nothing is found, and what is near: in lines, or in one beside JSON."""
    for line in [advice.brief] if out.json else str(advice).split("\n"):
        out.note(line)


def _trace(out: Output, seen: Trace) -> bool:
    """Say what a pattern met with in a capture, and return whether it has hits there."""
    from lanindex.app import formatting
    from lanindex.search.explain.why import records_of

    if seen.refused:
        raise seen.refused
    if out.json:
        for record in records_of(seen):
            out.record(record)
    else:
        formatting.trace(out, seen)
    return bool(seen.hits)
