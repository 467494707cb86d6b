"""``lanindex search --like``: what is like a clip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import typer

from lanindex.app import options
from lanindex.app.output import Output, end_progress
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.library.find import Where
    from lanindex.pipeline.example import Alike
    from lanindex.search.hits import Hits

ON_A_TERMINAL = 20
"""Captures that a terminal shows where no limit is set."""

ELSEWHERE = 100
"""Captures that are told elsewhere where no limit is set."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What of a search's arguments concerns its kind."""

    pattern: str | None
    like: str | None
    rerank: bool
    explain: bool
    count: bool
    limit: int | None

    def clip(self) -> str:
        """Return the clip that is named, or stands on standard input."""
        if self.like is None:
            found = "nothing to search for" if self.pattern is None else "--rerank"
            raise UsageError(found, wanted="a pattern or --like" if not self.rerank else "--like")
        beside = {"a pattern": self.pattern, "--explain": self.explain, "--count": self.count}
        for name, there in beside.items():
            if there:
                raise UsageError(f"--like and {name}", wanted="one of them")
        return options.one_line(self.like)


def run(
    out: Output,
    asked: Asked,
    db: str,
    *,
    within: str | None,
    where: Where | None,
    timeout: float | None,
) -> None:
    """Print what is like a clip; exit with 1 if nothing is."""
    clip = asked.clip()
    from lanindex.app import formatting
    from lanindex.pipeline import open_library

    limit = asked.limit or (ON_A_TERMINAL if out.terminal else ELSEWHERE)
    reach = max(limit, ELSEWHERE) if asked.rerank else limit
    with open_library(db, readonly=True) as library:
        library.tell, library.watch = out.note, out.watch
        how: dict[str, Any] = {"limit": reach, "rerank": asked.rerank, "timeout": timeout}
        found = library.like(clip, within=within, where=where, **how)
    end_progress()
    if out.terminal:
        _table(out, found.hits[:limit])
    else:
        formatting.hits(out, found.hits[:limit], found.hits.pattern)
    _summary(out, found, min(limit, len(found.hits)))
    if not found.hits:
        raise typer.Exit(1)


def _table(out: Output, hits: Hits) -> None:
    """Print a capture a line; of its symbols only where most of them correspond."""
    from lanindex import records
    from lanindex.app.formatting import counted

    rows = []
    for hit in hits:
        begin, end = (records.seconds(hit.capture, frame) for frame in (hit.start, hit.stop))
        most = f"{counted(len(hit.symbols), 'symbol')} of {hit.symbols[0].part}"
        place = (hit.path, hit.capture.label, f"{hit.start}-{hit.stop}", f"{begin:.2f}-{end:.2f}")
        rows.append((f"{hit.fit:.2f}", *place, most))
    out.table(("like", "capture", "label", "frames", "seconds", "most in common"), rows)


def _summary(out: Output, found: Alike, shown: int) -> None:
    from lanindex.app.formatting import counted

    for line in found.told[:3]:
        out.note(f"not ranked by its joints: {line}")
    if len(found.told) > 3:
        out.note(f"and {len(found.told) - 3} more")
    if not found.sure:
        out.note(f"{found.aligned:,} captures were looked at closely; others might be as like")
    out.note(f"the {shown} most like of {counted(found.captures, 'capture')}, the likest first")
