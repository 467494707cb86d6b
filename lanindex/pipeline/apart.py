"""A search without a library: patterns on some scores that are at hand."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from fractions import Fraction
from os import PathLike

from lanindex.errors import LanindexError, UsageError
from lanindex.model import Capture, Score, Symbol, Track
from lanindex.model.columns import Columns, columns_of, roster_of
from lanindex.pipeline.how import How
from lanindex.search.hits import Hits
from lanindex.search.language import Query, parse
from lanindex.search.match import Watch


def searcher(
    captures: Sequence[Capture], tracks: Sequence[Mapping[str, Track]], how: How
) -> Callable[[Query, Watch | None, list[LanindexError] | None], Hits]:
    """Return what searches some captures for a query, with `watch` and `refused` of `How.find`."""
    roster = roster_of(captures)
    columns: dict[str, Columns] = {}

    def recordings(
        places: Sequence[int], parts: Collection[str]
    ) -> list[tuple[Capture, Mapping[str, Track]]]:
        return [(captures[place], tracks[place]) for place in places]

    def search(query: Query, watch: Watch | None, refused: list[LanindexError] | None) -> Hits:
        for part in set(query.parts) - columns.keys():
            columns[part] = columns_of(part, captures, [own.get(part) for own in tracks])
        own = {part: columns[part] for part in query.parts}
        return Hits(how.find(query, roster, own, recordings, watch, refused=refused), str(query))

    return search


def matched(
    score: Score, pattern: str, words: str | PathLike[str] | None = None
) -> list[list[Symbol]]:
    """Return the symbols of each hit of a pattern in a score."""
    from lanindex.pipeline.words import named, said

    text = said(pattern, words)
    query = parse(text, list(score.tracks), names=named(text, words))
    if query.stages:
        raise UsageError(f'"| {query.stages[0]}"', wanted="a pattern without a pipe")
    capture = Capture(1, "score", "lnd", "", "", Fraction(score.rate), score.frames, score.meter)
    hits = searcher([capture], [score.tracks], How.read())(query, None, None)
    return [list(hit.symbols) for hit in hits]
