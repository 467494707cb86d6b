"""Hits as a tier of an ELAN file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex.app.output import Output
from lanindex.errors import UsageError, shown

if TYPE_CHECKING:
    from lanindex.search.hits import Counts, Hits

NAME = "hits"
"""What a tier is called that nobody names."""


@dataclass(frozen=True, slots=True)
class Tier:
    """Where hits are to be written."""

    into: Path | None
    name: str | None
    force: bool

    def check(self, others: dict[str, Any]) -> None:
        """Refuse what cannot stand beside each other."""
        if self.into is None:
            if self.name:
                raise UsageError("--tier", wanted="--into beside it")
            if self.force:
                raise UsageError("--force", wanted="--into or --preview beside it")
            return
        for option, there in others.items():
            if there:
                raise UsageError(f"--into and {option}", wanted="one of them")

    def write(
        self,
        out: Output,
        found: Hits | Counts,
        pattern: str,
        limit: int | None,
        *,
        by_fit: bool = False,
    ) -> None:
        """Write hits of one capture into the file: the pattern and the fit of each."""
        from lanindex.app.formatting import counted
        from lanindex.notation import content_of, eaf
        from lanindex.notation.timed import Said, milliseconds
        from lanindex.pipeline.files import write_all
        from lanindex.search.hits import Counts

        if isinstance(found, Counts):
            raise UsageError("--into and | count", wanted="one of them")
        if found.captures > 1:
            remedy = "Choose one with --in."
            raise UsageError(
                f"hits in {found.captures} captures", place="--into", wanted="one", remedy=remedy
            )
        assert self.into is not None
        words, entries = " ".join(pattern.split()), []
        for hit in (found.by_fit(limit) if by_fit else found)[:limit]:
            start, stop = (
                milliseconds(it, hit.capture.rate) for it in (hit.span.start, hit.span.stop)
            )
            entries.append(Said(f"{words} {hit.fit:.2f}", start, max(stop, start + 1)))
        place, name = str(self.into), self.name or NAME
        content = eaf.mark(content_of(place), name, entries, place=place, force=self.force)
        write_all([(self.into, content)], force=True)
        out.note(f"{place}: {counted(len(entries), 'hit')} in the tier {shown(name)}")
