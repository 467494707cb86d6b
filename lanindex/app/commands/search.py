"""``lanindex search``: find movement by pattern, or by a clip that is like it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from lanindex import records
from lanindex.app import options
from lanindex.app.options import argument, exclusive, flag, option
from lanindex.app.output import Output, choice, cut_note, print_hits, print_hits_with_staves
from lanindex.errors import UsageError, counted, shown

if TYPE_CHECKING:
    from lanindex.library.selection import Selection
    from lanindex.pipeline.library import Library
    from lanindex.search.explain.why import Trace
    from lanindex.search.hits import Counts, Hits

ON_TERMINAL = 20  # hits that a terminal shows without --limit
LIKE_LIMIT = 100  # captures that --like shows in a pipe without --limit
TROUBLES = 10  # how many of the hits that cannot be drawn are named
TIER = "hits"  # the default name of a tier


@dataclass(frozen=True)
class View:
    """Options: which hits are shown, and how."""

    limit: options.Limit = None
    sort: str | None = option(
        None, "fit|time", "Best fit or earliest first; by default fit for words, time for patterns."
    )
    count: bool = flag("--count", "Count the hits in each capture.")
    context: str | None = option(
        None, "TIME", "Draw the staff of each hit and this much around it: 0, 0.5s, 10f."
    )
    into: Path | None = option(None, "FILE", "Add the hits to an existing .eaf file.")
    tier: str | None = option(None, "NAME", "The tier to add there: hits.")
    preview: Path | None = option(
        None,
        "FILE.png|svg|html",
        "Draw the hits: poses and staves on a sheet, or a page on which they play.",
    )
    force: bool = flag("--force", "Replace an existing tier or file.")

    def check(self, others: Mapping[str, object], rerank: bool) -> None:
        """Refuse options that cannot stand beside each other, and bad ones before the search."""
        choice("--sort", self.sort or "time", ("fit", "time"))
        others = {**others, "--count": self.count}
        exclusive("--context", self.context, {**others, "--into": self.into})
        drawn = {"--into": self.into, "--context": self.context}
        exclusive("--preview", self.preview, {**others, **drawn, "--like": None})
        exclusive("--into", self.into, {**others, "--rerank": rerank})
        options.dependent("--tier", self.tier, on="--into", given=self.into)
        beside = self.into or self.preview
        options.dependent("--force", self.force, on="--into or --preview", given=beside)
        if self.context is not None:
            from fractions import Fraction

            from lanindex.pipeline.export import pad_frames

            pad_frames(self.context, Fraction(1), "--context")
        if self.preview is not None:
            from lanindex.pipeline.files import refuse
            from lanindex.pipeline.preview import FORMS

            options.ending(self.preview, FORMS, "--preview")
            refuse(self.preview, force=self.force)

    def first(self, hits: Hits, most: int | None) -> Hits:
        """Return the first hits, by fit or time."""
        return (hits.by_fit(most) if self.sort == "fit" else hits)[:most]


def run(
    patterns: list[str] | None = argument(
        None, "[PATTERN]", "r_arm right mid -> high", autocompletion=options.complete_pattern
    ),
    like: str | None = option(None, "CLIP[:FROM-TO]", "Find what is like a capture."),
    rerank: bool = flag("--rerank", "With --like: compare joint positions, too."),
    *,
    selection: options.Selected,
    matching: options.Matching,
    timeout: options.Timeout = None,
    memory: float | None = option(
        None, "MB", "Megabytes a search may use; by default a quarter of free memory.", min=64
    ),
    words: options.Words = None,
    cluster: options.Cluster = None,
    explain: bool = flag(
        "--explain", "Say how the pattern is understood; --explain plan: how it is searched."
    ),
    why: str | None = option(
        None,
        "CAPTURE|GLOB",
        "Say what matched in a capture, or where matching failed.",
        autocompletion=options.complete_capture,
    ),
    view: Annotated[View, options.Group(View)],
    db: options.Db = options.DB,
    out: options.Out,
) -> int:
    """Find movement by pattern.

    Parts, directions and levels as in Labanotation: "r_arm right mid -> high",
    "arms place high 1s+", "r_arm high with l_arm low". The whole language: lanindex language.
    Or a word of the dictionary of movement, such as walk: lanindex words.
    Exits with 1 if nothing is found.
    """
    arguments = list(patterns or ())
    plan = explain and len(arguments) == 2 and "plan" in arguments
    if plan:
        arguments.remove("plan")
    if len(arguments) > 1:
        raise UsageError(f'"{arguments[1]}" behind the pattern', remedy="Quote the pattern.")
    typed = arguments[0] if arguments else None
    explained = {"--explain": explain, "--why": why}
    view.check({"--like": like, **explained, "--json": out.json}, rerank)
    if typed is None or like is not None or rerank:
        if like is None:
            found = "nothing to search for" if typed is None else "--rerank"
            raise UsageError(found, wanted="--like" if rerank else "a pattern or --like")
        of_patterns = {f"--{name}": matching[name] for name in ("near", "fuzzy", "strict")}
        others = {"a pattern": typed, **explained, "--count": view.count, **of_patterns}
        exclusive("--like", like, others)
        clip = options.one_line(like)
        with options.opened(db, out) as library:
            return _print_alike(out, library, clip, rerank, view, selection, timeout)
    exclusive("--why", why, {"--fuzzy": matching["fuzzy"] is not None})
    from lanindex.library.selection import Selection
    from lanindex.search.hits import Counts
    from lanindex.search.language.score import pattern_in

    asked = pattern_in(typed)
    with options.opened(db, out, words, cluster) as library:
        pattern = pattern_of(out, library, asked, words)
        if view.sort is None:
            view = replace(view, sort="time" if pattern == asked else "fit")
        if why is not None:
            del matching["fuzzy"]
            fitting = library.store.numbers(Selection(why))
            chosen = fitting or (options.capture_id(why),)
            traces = [library.why(pattern, it, **matching) for it in chosen[: view.limit]]
            return all([_print_trace(out, trace) for trace in traces])
        if explain:
            said = library.explain(pattern, selection, strict=matching["strict"], plan=plan)
            out.record(said.record()) if out.json else out.text(str(said))
            return 0
        only_best = view.sort == "fit" and matching["fuzzy"] is not None and not view.count
        best = view.limit if only_best else None
        one_more = best and best + 1  # which tells whether there are others
        hits = library.search(
            pattern, selection, best=one_more, timeout=timeout, memory=memory, **matching
        )
        if isinstance(hits, Counts):
            _counts(out, hits, view)
        elif view.into is not None and hits:
            _write_tier(out, hits[:best], view, typed)
        elif view.count:
            _count(out, library, hits)
        else:
            more = best is not None and len(hits) > best
            _hits(out, library, hits[:best], view, more, " ".join(typed.split()))
        if not hits and not out.quiet:
            advice = library.suggest(pattern, selection, **matching)
            out.notes([advice.brief] if out.json else str(advice).split("\n"))
        return 2 if library.refused else not hits


def pattern_of(out: Output, library: Library, query: str, words: str | PathLike[str] | None) -> str:
    """Return the pattern that a query stands for, and say which word of the dictionary it is."""
    from lanindex.pipeline.search import entry_of_query, unknown
    from lanindex.search.dictionary import absent

    entry = entry_of_query(query, words)
    if entry is not None:
        sentence = f": {entry.sentence}" if entry.sentence else ""
        out.note(f"{entry.name}{sentence} (lanindex words {entry.name})")
        _note_labelled(out, library, entry.name)
        return entry.pattern
    if name := unknown(query):
        lacking = absent(name)
        why = lacking.why if lacking else "lanindex words"
        out.note(f'no word "{name}" in the dictionary of movement: {why}')
        _note_labelled(out, library, name)
    return query


def _note_labelled(out: Output, library: Library, name: str) -> None:
    """Say which captures are labelled with a word."""
    from lanindex.library.selection import Selection

    glob = name.replace("_", "?") + "*"
    labelled = library.store.numbers(Selection(where={"label": glob}))
    if labelled:
        labels = set(library.store.texts("label", labelled).values())
        label = labels.pop() if len(labels) == 1 else glob
        verb = "is" if len(labelled) == 1 else "are"
        out.note(
            f'{counted(len(labelled), "capture")} {verb} labelled "{label}": '
            f'lanindex list --where "label={label}"'
        )


def _hits(out: Output, library: Library, hits: Hits, view: View, others: bool, title: str) -> None:
    """Print or draw hits; there may be `others` that nobody has counted, which fit no better."""
    most = view.limit or (ON_TERMINAL if out.terminal else None)
    if view.limit is None and view.preview is not None:
        from lanindex.pipeline.preview import FORMS

        most = FORMS[options.ending(view.preview, FORMS)]
    first = view.first(hits, most)
    if view.context is not None:
        print_hits_with_staves(out, library, first, view.context)
    elif view.preview is None:
        print_hits(out, first, first.pattern)
    elif first:
        some = f" \u00b7 the first {len(first):,} of {len(hits):,} hits" * (len(first) < len(hits))
        _draw(out, library, first.of(title + some), view.preview, view.force)
    if others:
        out.note(f"{_numbers(hits)}, the best; there are others, --limit shows more")
        return
    order = ", the best first" if view.sort == "fit" and len(first) > 1 else ""
    out.note(f"{_numbers(hits)}{order}{cut_note(len(first), len(hits))}")


def _numbers(hits: Hits) -> str:
    return f"{counted(len(hits), 'hit')} in {counted(hits.captures, 'capture')}"


def _count(out: Output, library: Library, hits: Hits) -> None:
    """Print the number of hits in each capture."""
    tally = dict(hits.tally())
    for number, path in library.store.texts("path", tally).items():
        count = tally[number]
        out.row([path, count], {"capture": path, "capture_id": number, "count": count})
    out.note(_numbers(hits))


def _counts(out: Output, counts: Counts, view: View) -> None:
    """Print what a pattern that ends in ``| count`` counted."""
    for name in ("into", "context", "preview"):
        exclusive(f"--{name}", getattr(view, name), {"| count": True})
    dicts = counts.dicts()[: view.limit]
    if counts.by is None:
        out.row([counts.total], dicts[0])
    else:
        rows = (("-" if it["value"] is None else it["value"], it["count"]) for it in dicts)
        out.table((str(counts.by), "hits"), rows, dicts)
    by = f" by {counted(len(counts), 'value')}" if counts.by else ""
    out.note(f"{counted(counts.total, 'hit')}{by}{cut_note(len(dicts), len(counts))}")


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
    out.notes(troubles[:TROUBLES], "not drawn")
    if len(troubles) > TROUBLES:
        out.note(f"and {len(troubles) - TROUBLES} more, each with its reason in the picture")
    for file, size in sizes:
        out.line(str(file))
        out.note(f"{file}: {size / 1000:,.0f} kB")


def _write_tier(out: Output, hits: Hits, view: View, pattern: str) -> None:
    """Write the hits of one capture into an ELAN file: the pattern and the fit of each."""
    from lanindex.notation import content_of, eaf
    from lanindex.notation.tiers import TierEntry, milliseconds
    from lanindex.pipeline.files import write_all

    if hits.captures > 1:
        found = f"hits in {hits.captures} captures"
        raise UsageError(found, place="--into", wanted="one", remedy="Choose one with --in.")
    text, entries = " ".join(pattern.split()), []
    for hit in view.first(hits, view.limit):
        start = milliseconds(hit.span.start, hit.capture.rate)
        stop = milliseconds(hit.span.stop, hit.capture.rate)
        entries.append(TierEntry(f"{text} {hit.fit:.2f}", start, max(stop, start + 1)))
    place, tier = str(view.into), view.tier or TIER
    content = eaf.mark(content_of(place), tier, entries, place=place, force=view.force)
    write_all([(Path(place), content)], force=True)
    out.note(f"{place}: {counted(len(entries), 'hit')} in the tier {shown(tier)}")


def _print_trace(out: Output, trace: Trace) -> bool:
    """Print the steps of a pattern's hits in one capture, or where matching failed."""
    from lanindex.search.explain.why import doubts

    if trace.refused:
        raise trace.refused
    if out.json:
        out.records(trace.dicts())
        return not trace.hits
    out.line(out.paint(trace.capture.path, "path"))
    for hit, steps in trace.hits:
        out.line(out.paint(hit.when, "place"), f"  fit {hit.fit:.2f}")
        width = max(len(it.step) for it in steps)
        for matched in steps:
            symbols = "; ".join(f"{it}, {doubts(it)}" for it in matched.symbols)
            step = matched.step.ljust(width)
            out.line("  ", step, "  " if width else "", symbols or "left out")
    for stop in trace.stops:
        if stop.reached:
            out.line("found:      ", stop.reached)
        out.line("not found:  ", stop.wanted)
        out.line("  ", stop.reason)
    return not trace.hits


def _print_alike(
    out: Output,
    library: Library,
    clip: str,
    rerank: bool,
    view: View,
    selection: Selection,
    timeout: float | None,
) -> bool:
    """Print or draw what is like a clip, and return whether nothing is."""
    most = view.limit or (ON_TERMINAL if out.terminal else LIKE_LIMIT)
    reach = max(most, LIKE_LIMIT) if rerank else most
    alike = library.like(clip, selection, limit=reach, rerank=rerank, timeout=timeout)
    hits = alike.hits[:most]
    if view.preview is not None and hits:
        _draw(out, library, hits, view.preview, view.force)
    elif out.terminal:
        rows, folder = [], out.folder(hit.path for hit in hits)
        for hit in hits:  # of the symbols, only where most of them correspond
            begin, end = (records.seconds(hit.capture, frame) for frame in (hit.start, hit.stop))
            common = f"{counted(len(hit.symbols), 'symbol')} of {hit.symbols[0].part}"
            times = f"{hit.start}-{hit.stop}", f"{begin:.2f}-{end:.2f}"
            path = hit.path.removeprefix(folder)
            rows.append((f"{hit.fit:.2f}", path, hit.capture.label, *times, common))
        out.table(("like", "capture", "label", "frames", "seconds", "most in common"), rows)
    else:
        print_hits(out, hits, alike.hits.pattern)
    out.notes(alike.notes[:3], "joints not compared")
    if len(alike.notes) > 3:
        out.note(f"and {len(alike.notes) - 3} more")
    if not alike.sure:
        out.note(f"{alike.aligned:,} captures were looked at closely; others might be as like")
    captures = counted(alike.captures, "capture")
    out.note(f"the {len(hits)} most like of {captures}, the likest first")
    return not alike.hits
