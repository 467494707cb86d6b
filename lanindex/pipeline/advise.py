"""Ask a library what would be found where a pattern finds nothing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction

from lanindex.alphabet import PARTS
from lanindex.errors import LanindexError, PatternError
from lanindex.library.store import Store
from lanindex.model import Capture, Track
from lanindex.search.explain.advice import SECONDS, Advice, Count, Found, LeftOut, advise
from lanindex.search.explain.budget import Budget
from lanindex.search.language import Query, parse
from lanindex.search.plain import find

_FOR_READING = 0.5
"""The share of the time in which as much of the library is read as will go."""

_FOR_ADVICE = 0.7
"""The share until which changes are tried, where other captures are to be looked at as well."""

Recordings = list[tuple[Capture, Mapping[str, Track]]]


def suggest(
    library: Store,
    query: Query,
    chosen: Collection[int] | None,
    *,
    tolerance: Fraction,
    overlaps: str,
    budget: Budget | None = None,
) -> Advice:
    """Return what to do about a query that finds nothing.

    Parameters
    ----------
    library : Store
        Where it was looked for.
    query : Query
        Which finds nothing.
    chosen : collection of int, optional
        The captures that were looked at; by default all.
    tolerance, overlaps
        As in `lanindex.search.plain.find.find`.
    budget : Budget, optional
        How long it may take, about.

    Returns
    -------
    Advice
        Of a library that cannot be read in that time, what a part of it tells.
    """
    budget = budget or Budget(SECONDS)

    def read(captures: Collection[int] | None, share: float) -> tuple[Recordings, bool]:
        recordings: Recordings = []
        for recording in library.tracks(captures):
            recordings.append(recording)
            if budget.late(share):
                return recordings, False
        return recordings, True

    recordings, complete = read(chosen, _FOR_READING)
    count = counting(recordings, tolerance, overlaps, budget)
    remark = "" if complete else f"Tried on the first {len(recordings):,} captures only."
    if not recordings:
        fitting = "" if chosen is None else " that fits --in and --where"
        remark = f"There is no capture{fitting}."
    advice = Advice(str(query))
    if recordings:
        share = _FOR_ADVICE if chosen is not None else 1
        advice = advise(query, count, reader(library), budget=budget, share=share)
    if chosen is not None:
        others, _ = read(None, 1)
        found = counting(others, tolerance, overlaps, Budget(1))(query)
        if found and found[0]:
            everywhere = LeftOut("", found[0], len(found[1]))
            advice = replace(advice, left_out=(everywhere, *advice.left_out))
    return replace(advice, remark=remark)


def reader(library: Store) -> Callable[[str], Query | None]:
    """Return what reads a pattern for a library: None where it is not understood."""
    parts = library.parts(checked=False)

    def read(text: str) -> Query | None:
        try:
            return parse(text, parts, known=PARTS)
        except PatternError:
            return None

    return read


def counting(recordings: Recordings, tolerance: Fraction, overlaps: str, budget: Budget) -> Count:
    """Return what counts the hits of a query in some recordings, until its time is up."""

    def chosen(among: frozenset[int] | None) -> Iterator[tuple[Capture, Mapping[str, Track]]]:
        for recording in recordings:
            if budget.late():
                raise TimeoutError
            if among is None or recording[0].id in among:
                yield recording

    def count(query: Query, among: frozenset[int] | None = None) -> Found | None:
        hits = Counter[int]()
        try:
            for hit in find(query, chosen(among), tolerance=tolerance, overlaps=overlaps):
                hits[hit.capture.id] += 1
        except (TimeoutError, LanindexError):  # or it fits in too many ways
            return None
        return hits.total(), frozenset(hits)

    return count
