"""How what a search found is told: hits, counts, staves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex.app.output import Output
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.pipeline import Library
    from lanindex.search.hits import Counts, Hits

FEW = 10
"""Troubles that are told one by one."""

ON_A_TERMINAL = 20
"""Hits that a terminal shows where no limit is set."""


@dataclass(frozen=True, slots=True)
class Telling:
    """What is wanted of a search's hits."""

    count: bool
    by_fit: bool
    limit: int | None
    context: str | None
    preview: Path | None
    force: bool

    def check(self, others: dict[str, Any]) -> None:
        """Refuse what cannot stand beside each other."""
        others = {**others, "--count": self.count, "--context": self.context}
        for name, given in (("--context", self.context), ("--preview", self.preview)):
            for other, there in others.items():
                if given and there and name != other:
                    raise UsageError(f"{name} and {other}", wanted="one of them")
        if self.context is not None:
            from lanindex.app import staves

            staves.check(self.context)
        if self.preview is not None:
            from lanindex.pipeline.files import refuse
            from lanindex.pipeline.preview import form_of

            form_of(self.preview)
            refuse(self.preview, force=self.force)

    def tell(self, out: Output, library: Library, found: Hits | Counts, best: int | None) -> None:
        """Print what was found; `best` is how many were looked for, where not all were."""
        from lanindex.search.hits import Counts

        if isinstance(found, Counts):
            self.check({"| count": True})
            _counted(out, found, self.limit)
        elif self.count:
            _count(out, library, found)
        else:
            most = self._most(out)
            hits = (found.by_fit(most) if self.by_fit else found)[:most]
            if hits or self.preview is None:
                self._show(out, library, hits)
            _summary(out, found, len(hits), len(found) == best)

    def _most(self, out: Output) -> int | None:
        """Return how many hits are shown; None: all."""
        if self.limit is None and self.preview is not None:
            from lanindex.pipeline.preview import FORMS, form_of

            return FORMS[form_of(self.preview)]
        return self.limit or (ON_A_TERMINAL if out.terminal else None)

    def _show(self, out: Output, library: Library, hits: Hits) -> None:
        if self.preview is not None:
            _draw(out, library, hits, self.preview, self.force)
        elif self.context is not None:
            from lanindex.app import staves

            staves.around(out, library, hits, self.context)
        else:
            from lanindex.app import formatting

            formatting.hits(out, hits, hits.pattern)


def _draw(out: Output, library: Library, hits: Hits, path: Path, force: bool) -> None:
    """Write the file that shows hits, or several, and say what they cannot show."""
    from functools import partial

    from lanindex.app.output import end_progress
    from lanindex.pipeline.export import suspects
    from lanindex.pipeline.files import write_all
    from lanindex.pipeline.preview import preview

    sizes: list[tuple[Path, int]] = []
    troubles: list[str] = []

    def files() -> Iterator[tuple[Path, bytes]]:
        for file, content, told in preview(library, hits, path, out.watch):
            sizes.append((file, len(content)))
            troubles.extend(told)
            yield file, content

    write_all(files(), force=force, suspects=partial(suspects, library))
    end_progress()
    for line in troubles[:FEW]:
        out.note(f"not drawn: {line}")
    if len(troubles) > FEW:
        out.note(f"and {len(troubles) - FEW} more, each with its reason in the picture")
    for file, size in sizes:
        out.line(str(file))
        out.note(f"{file}: {size / 1000:,.0f} kB")


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
