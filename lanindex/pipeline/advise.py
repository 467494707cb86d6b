"""Ask a library what would be found where a pattern finds nothing."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from lanindex.errors import LanindexError, PatternError
from lanindex.library.store import Store
from lanindex.model import Capture, Track
from lanindex.pipeline.search import SearchOptions, named
from lanindex.search.explain.advice import SECONDS, Advice, Budget, HitCounts, LeftOut, advise
from lanindex.search.fields import extras_in
from lanindex.search.language import Query, parse


def suggest(
    store: Store,
    query: Query,
    numbers: Sequence[int] | None,
    options: SearchOptions,
    budget: Budget | None = None,
) -> tuple[Advice, list[LanindexError]]:
    """Return what to do about a query that finds nothing."""
    budget = budget or Budget(SECONDS)
    query = replace(query, stages=())  # a pipe finds nothing by itself
    refused: dict[str, LanindexError] = {}

    def count(query: Query, among: Sequence[int] | None = numbers) -> HitCounts | None:
        if budget.late():
            return None
        rich: list[LanindexError] = []
        try:
            found = _counted(store, query, among, options, budget, rich)
        except (TimeoutError, LanindexError):  # or no edits are allowed in it
            return None
        refused.update({error.place: error for error in rich})
        return found

    elsewhere = None if numbers is None else count(query, None)
    roster, _ = store.columns(query.parts, numbers)
    if not len(roster):
        fitting = "" if numbers is None else " that fits --in and --where"
        advice = Advice(str(query), remark=f"There is no capture{fitting}.")
    else:
        advice = advise(query, count, reader(store), budget=budget)
    if elsewhere and elsewhere[0]:
        advice = replace(advice, left_out=(LeftOut("", *elsewhere), *advice.left_out))
    errors = list(refused.values())
    for line in named(errors):
        store.session.note(line)
    return advice, errors


def _counted(
    store: Store,
    query: Query,
    numbers: Sequence[int] | None,
    options: SearchOptions,
    budget: Budget,
    refused: list[LanindexError],
) -> HitCounts:
    """Return how many hits there are, and in how many captures; give up what takes too long."""
    roster, columns = store.columns(query.parts, numbers, more=extras_in(query))

    def watch(done: int, captures: int) -> None:
        if budget.late():
            raise TimeoutError

    def recordings(
        captures: Sequence[int], parts: Collection[str]
    ) -> Iterator[tuple[Capture, Mapping[str, Track]]]:
        """Yield captures with tracks as long as there is time."""
        for recording in store.tracks(roster.number[np.array(captures, int)].tolist(), parts):
            watch(0, 0)
            yield recording

    found = options.find(query, roster, columns, recordings, watch, refused=refused)
    return len(found), found.captures


def reader(store: Store) -> Callable[[str], Query | None]:
    """Return what reads a pattern for a library: None where it is not understood."""
    parts = store.parts(checked=False)

    def read(text: str) -> Query | None:
        try:
            return parse(text, parts)
        except PatternError:
            return None

    return read
