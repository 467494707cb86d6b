"""The verbs to learn from: demo, words (the dictionary of movement), language, guide."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

import lanindex
from lanindex.app import options
from lanindex.app.options import argument, option
from lanindex.app.output import Output, cut, duration, print_hits, room
from lanindex.data import shipped
from lanindex.errors import UsageError, counted, did_you_mean
from lanindex.pipeline.files import choreographies

if TYPE_CHECKING:
    from lanindex.search.dictionary import Entry

SEARCHES = (
    ("arms side mid -> place high", "both arms open to their sides, then go up"),
    ("r_arm place high -> hold 1s+", "the right arm arrives overhead and stays"),
    ("r_arm high with l_arm low", "the right arm up while the left goes down"),
)
"""Patterns, and what each means."""

TOPICS: dict[str, list[str]] = shipped("guide/topics.toml")
"""Topics of the guide: the page in the package, and what it is about."""


def demo(
    folder: Path | None = option(None, "FOLDER", "Where to work; by default a temporary folder."),
    *,
    out: options.ColorOut,
) -> None:
    """See everything at work on the bundled choreographies.

    Ingests them into a library of its own, searches three times and exports clips.
    """
    start = time.monotonic()
    if folder is None:
        with tempfile.TemporaryDirectory(prefix="lanindex-demo-") as place:
            _demo(out, Path(place))
        follow = ["demo --folder demo    # to keep the library and the clips"]
    else:
        folder.mkdir(parents=True, exist_ok=True)
        _demo(out, folder)
        db = folder / "demo.db"
        follow = [f'search "r_arm rising x2" --db {db}', f"show 1 --db {db}"]
    kept = f", in {folder}" if folder else ""
    out.line(f"All in {time.monotonic() - start:.1f} s{kept}. Now type:")
    for line in (*follow, "ingest YOUR_FOLDER    # then search without --db"):
        out.line(f"  lanindex {line}")


def _demo(out: Output, folder: Path) -> None:
    """Write a library and clips of the choreographies to a folder, and say how."""
    from lanindex.search.hits import hits_in

    source = choreographies()
    with lanindex.open_library(folder / "demo.db", create=True) as library:
        done = library.ingest(*sorted(source.glob("*.bvh")), labels=source / "labels.csv")
        stats = library.stats()
        out.line(
            f"Read {len(done)} choreographies ({duration(stats.seconds)} of movement) "
            f"and wrote them down: {stats.symbols:,} symbols."
        )
        for pattern, meaning in SEARCHES:
            hits = hits_in(library.search(pattern))
            out.line()
            out.line(out.paint(f'$ lanindex search "{pattern}"', "match"))
            out.line(out.paint(f"# {meaning}", "dim"))
            print_hits(out, hits[:3], pattern)
            out.line(f"{counted(len(hits), 'hit')} in {counted(hits.captures, 'capture')}")
        pattern = SEARCHES[0][0]
        clips = library.export(
            hits_in(library.search(pattern)), folder / "clips", pad="0.5s", force=True
        )
    out.line()
    out.line(f'Exported {counted(len(clips), "clip")} of "{pattern}":')
    for clip in clips[:3]:
        out.line(f"  {clip['clip']}  (frames {clip['clip_start_frame']}-{clip['clip_end_frame']})")


def language(*, out: options.ColorOut) -> None:
    """Show the pattern language on one page: parts, directions, heights, times and all else."""
    out.content(_page("language"))


def guide(
    topic: str | None = argument(None, None, "A topic; without one they are listed."),
    *,
    out: options.ColorOut,
) -> None:
    """Print a page of the guide, or list its topics."""
    if topic is None:
        out.table(["topic", "about"], [[name, about] for name, (_, about) in TOPICS.items()])
        return
    if topic not in TOPICS:
        remedy = did_you_mean(topic, TOPICS) or "All are shown by: lanindex guide"
        raise UsageError(f'the guide has no topic "{topic}"', remedy=remedy)
    out.content(_page(topic))


def _page(topic: str) -> str:
    return files("lanindex").joinpath(TOPICS[topic][0]).read_text(encoding="utf-8")


def words(
    word: str | None = argument(None, "WORD", "Show this one: walk, hands_up."),
    words: options.Words = None,
    *,
    out: options.Out,
) -> None:
    """Show the dictionary of movement.

    Each word stands for a pattern, and can be searched: lanindex search walk. Precision and recall
    were measured on people and collections that were left out while a pattern was made; "few" are
    fewer than ten captures of two collections. What patterns are made of: lanindex language.
    """
    from lanindex.search.dictionary import entries, entry_of, load, record

    known = load(words)
    chosen = entries(known) if word is None else [entry_of(known, word)]
    if out.json:
        out.records(record(entry, known) for entry in chosen)
    elif word is None:
        _table(out, chosen)
        out.note("one in full: lanindex words walk; the language of patterns: lanindex language")
    else:
        _print_entry(out, chosen[0], known)


def _table(out: Output, chosen: list[Entry]) -> None:
    from textwrap import wrap

    head = ("word", "precision", "recall", "clips", "sentence")
    if not out.terminal:
        rows = [[*_figures(entry), entry.sentence, entry.pattern] for entry in chosen]
        out.table((*head, "pattern"), rows)
        return
    wide = max(len("word"), *(len(entry.name) for entry in chosen))
    out.line(out.paint(f"{'word':{wide}}  precision  recall     clips", "dim"))
    for entry in chosen:
        name, precision, recall, clips = _figures(entry)
        out.line(out.paint(f"{name:{wide}}", "match"), f"  {precision:>9}  {recall:>6}  {clips:>8}")
        for line in wrap(entry.sentence, max(24, room() - 2)):
            out.line("  ", line)
        out.line("  ", out.paint(cut(entry.pattern, room() - 2), "dim"))


def _figures(entry: Entry) -> list[str]:
    counts = entry.measured
    if counts is None:
        return [entry.name, "", "", ""]
    figures = ("few" if it is None else f"{it:.2f}" for it in (counts.precision, counts.recall))
    return [entry.name, *figures, f"{counts.wanted} in {counts.collections}"]


def _print_entry(out: Output, entry: Entry, entries: Mapping[str, Entry]) -> None:
    """Show one word in full, a field per line."""
    from lanindex.search.dictionary import mirror_image

    counts = entry.measured
    fields = {
        "word": entry.name,
        "also": ", ".join(entry.names),
        "means": entry.sentence,
        "pattern": entry.pattern,
        "mirrored": mirror_image(entry, entries),
        "labels": ", ".join(entry.labels),
    }
    if counts:
        fields["found"] = (
            f"{counts.right} of {counted(counts.wanted, 'capture')}, in "
            f"{counted(counts.collections, 'collection')}; {counts.wrong} of "
            f"{counts.clips - counts.wanted} others wrongly; all left out while it was made"
        )
        if counts.tells:
            _, fields["precision"], fields["recall"], _ = _figures(entry)
        else:
            fields["figures"] = "none: seen on fewer than ten captures of two collections"
    for name, value in fields.items():
        if value:
            out.line(out.paint(f"{name:9}", "dim"), "  ", value)
