"""How what a search found is told: hits, counts, staves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lanindex.app.output import Output
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.pipeline import Library
    from lanindex.search.hits import Hits
    from lanindex.search.stages import Counts

ON_A_TERMINAL = 20
"""Hits that a terminal shows where no limit is set."""


@dataclass(frozen=True, slots=True)
class Telling:
    """What is wanted of a search's hits.

    Attributes
    ----------
    count, by_fit : bool
        Only how many there are; the clearest first.
    limit : int or None
        Hits to show.
    context : str or None
        The time around each of which a staff is drawn.
    """

    count: bool
    by_fit: bool
    limit: int | None
    context: str | None

    def check(self, others: dict[str, Any]) -> None:
        """Refuse what cannot stand beside each other.

        Raises
        ------
        UsageError
            With both names, or where the context is no time.
        """
        if self.context is None:
            return
        for name, there in {"--count": self.count, **others}.items():
            if there:
                raise UsageError(f"--context and {name}", wanted="one of them")
        from lanindex.app import staves

        staves.check(self.context)

    def tell(self, out: Output, library: Library, found: Hits | Counts, best: int | None) -> None:
        """Print what was found; `best` is how many were looked for, where not all were."""
        from lanindex.search.stages import Counts

        if isinstance(found, Counts):
            self.check({"| count": True})
            _counted(out, found, self.limit)
        elif self.count:
            _count(out, library, found)
        else:
            most = self.limit or (ON_A_TERMINAL if out.terminal else None)
            hits = (found.by_fit(most) if self.by_fit else found)[:most]
            self._show(out, library, hits)
            _summary(out, found, len(hits), len(found) == best)

    def _show(self, out: Output, library: Library, found: Hits) -> None:
        from lanindex.app import formatting, staves

        if self.context is None:
            formatting.hits(out, found, found.pattern)
        else:
            staves.around(out, library, found, self.context)


def _count(out: Output, library: Library, found: Hits) -> None:
    tally = dict(found.tally())
    for number, path in library.called("path", tally).items():
        if out.json:
            out.record({"capture": path, "capture_id": number, "count": tally[number]})
        else:
            out.row([path, tally[number]])
    _summary(out, found, len(found))


def _counted(out: Output, found: Counts, limit: int | None) -> None:
    from lanindex.app.formatting import counted

    rows = found.dicts()[:limit]
    for row in rows if out.json else ():
        out.record(row)
    if not out.json and found.by is None:
        out.row([found.total])
    elif not out.json:
        head = (str(found.by), "hits")
        out.table(head, [(_said(row["value"]), row["count"]) for row in rows])
    cut = f"; {len(rows)} are shown, --limit shows more" if len(rows) < len(found) else ""
    values = f" by {counted(len(found), 'value')}" if found.by else ""
    out.note(f"{counted(found.total, 'hit')}{values}{cut}")


def _said(value: str | float | None) -> str:
    return "-" if value is None else str(value)


def _summary(out: Output, found: Hits, shown: int, best: bool = False) -> None:
    from lanindex.app.formatting import counted

    cut = f"; {shown} are shown, --limit shows more" if shown < len(found) else ""
    cut = "; no others fit better, --limit shows more" if best else cut
    out.note(f"{counted(len(found), 'hit')} in {counted(found.captures, 'capture')}{cut}")
