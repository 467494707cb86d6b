"""``lanindex demo``: see everything at work on the bundled choreographies."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output, counted, duration
from lanindex.errors import LanindexError

if TYPE_CHECKING:
    from lanindex.pipeline import Library

SEARCHES = (
    ("arms side mid -> place high", "both arms open to their sides, then go up"),
    ("r_arm place high -> hold 1s+", "the right arm arrives overhead and stays"),
    ("r_arm high with l_arm low", "the right arm up while the left goes down"),
)
"""Patterns, and what each means."""


def run(
    folder: Annotated[
        Path | None,
        typer.Option(
            "--folder", metavar="FOLDER", help="Where to work; by default a temporary folder."
        ),
    ] = None,
    color: options.Color = "auto",
) -> None:
    """See everything at work on the bundled choreographies.

    Ingests them into a library of its own, searches three times and exports clips.
    """
    out = Output(color=color)
    from lanindex.pipeline import open_library
    from lanindex.search.hits import hits_in

    start = time.monotonic()
    place = folder or Path(tempfile.mkdtemp(prefix="lanindex-demo-"))
    place.mkdir(parents=True, exist_ok=True)
    db, source = place / "demo.db", corpus()
    with open_library(db, create=True) as library:
        done = library.ingest(*sorted(source.glob("*.bvh")), labels=source / "labels.csv")
        stats = library.stats()
        out.line(
            f"Read {len(done)} choreographies ({duration(stats.seconds)} of movement) "
            f"and wrote them down: {stats.symbols:,} symbols."
        )
        for pattern, meaning in SEARCHES:
            _search(out, library, pattern, meaning)
        pattern = SEARCHES[0][0]
        clips = library.export(
            hits_in(library.search(pattern)), place / "clips", pad="0.5s", force=True
        )
    out.line()
    out.line(f'Exported {counted(len(clips), "clip")} of "{pattern}" to {place / "clips"}:')
    for clip in clips[:3]:
        out.line(f"  {clip['clip']}  (frames {clip['clip_start_frame']}-{clip['clip_end_frame']})")
    out.line(f"All in {time.monotonic() - start:.1f} s. Now type:")
    out.line(f'  lanindex search "r_arm rising x2" --db {db}')
    out.line(f"  lanindex show 1 --db {db}")
    out.line("  lanindex ingest YOUR_FOLDER    # then search without --db")


def _search(out: Output, library: Library, pattern: str, meaning: str) -> None:
    from lanindex.app import formatting
    from lanindex.search.hits import hits_in

    found = hits_in(library.search(pattern))
    captures = len({hit.capture.id for hit in found})
    out.line()
    out.line(out.paint(f'$ lanindex search "{pattern}"', "match"))
    out.line(out.paint(f"# {meaning}", "dim"))
    formatting.hits(out, found[:3], pattern)
    out.line(f"{counted(len(found), 'hit')} in {counted(captures, 'capture')}")


def corpus() -> Path:
    """Return the folder of choreographies: in the package, or beside it in a checkout."""
    package = Path(__file__).parents[2]
    for folder in (package / "_corpus", package.parent / "corpus"):
        if (folder / "labels.csv").is_file():
            return folder
    raise LanindexError("the choreographies are missing", wanted="the folder corpus/")
