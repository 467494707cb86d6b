"""``lanindex demo``: see it all happen on the choreographies that come with it."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.screen import Screen
from lanindex.errors import LanindexError

if TYPE_CHECKING:
    from lanindex.pipeline import Library

SEARCHES = (
    ("arms side mid -> place high", "both arms open to their sides, then go up"),
    ("r_arm place high -> hold 1s+", "the right arm arrives overhead and stays"),
    ("r_arm high with l_arm low", "the right arm up while the left goes down"),
)
"""Patterns, and what each says."""


def run(
    folder: Annotated[
        Path | None,
        typer.Option("--folder", metavar="FOLDER", help="Where to work; else a temporary one."),
    ] = None,
    color: options.Color = "auto",
) -> None:
    """See it all happen on the choreographies that come with LanIndex.

    Ingests them into a library of its own, searches three times and exports clips.
    """
    screen = Screen(color=color)
    from lanindex.app import present
    from lanindex.pipeline import open_library

    begun = time.monotonic()
    place = folder or Path(tempfile.mkdtemp(prefix="lanindex-demo-"))
    place.mkdir(parents=True, exist_ok=True)
    db, source = place / "demo.db", corpus()
    with open_library(db, create=True) as library:
        done = library.ingest(*sorted(source.glob("*.bvh")), labels=source / "labels.csv")
        stats = library.stats()
        screen.out(
            f"Read {len(done)} choreographies ({present.duration(stats.seconds)} of movement) and "
            f"wrote them down: {stats.symbols:,} symbols."
        )
        for pattern, meaning in SEARCHES:
            _search(screen, library, pattern, meaning)
        pattern = SEARCHES[0][0]
        clips = library.export(library.search(pattern), place / "clips", pad="0.5s", force=True)
    screen.out()
    screen.out(
        f'Exported {present.counted(len(clips), "clip")} of "{pattern}" to {place / "clips"}:'
    )
    for clip in clips[:3]:
        screen.out(
            f"  {clip['clip']}  (frames {clip['clip_start_frame']}-{clip['clip_end_frame']})"
        )
    screen.out(f"All in {time.monotonic() - begun:.1f} s. Now type:")
    screen.out(f'  lanindex search "r_arm rising x2" --db {db}')
    screen.out(f"  lanindex show 1 --db {db}")
    screen.out("  lanindex ingest YOUR_FOLDER    # then search without --db")


def _search(screen: Screen, library: Library, pattern: str, meaning: str) -> None:
    from lanindex.app import present

    found = library.search(pattern)
    captures = len({hit.capture.id for hit in found})
    screen.out()
    screen.out(screen.paint(f'$ lanindex search "{pattern}"', "match"))
    screen.out(screen.paint(f"# {meaning}", "dim"))
    present.hits(screen, found[:3])
    screen.out(f"{present.counted(len(found), 'hit')} in {present.counted(captures, 'capture')}")


def corpus() -> Path:
    """Return the folder of choreographies: in the package, or beside it in a checkout."""
    package = Path(__file__).parents[2]
    for folder in (package / "_corpus", package.parent / "corpus"):
        if (folder / "labels.csv").is_file():
            return folder
    raise LanindexError("the choreographies are missing", wanted="the folder corpus/")
