"""How a query is understood, and what stands in its way."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from fractions import Fraction

import numpy as np

from lanindex.model import Capture, Track
from lanindex.search.automaton import states_of
from lanindex.search.explain.english import sentence
from lanindex.search.language.query import (
    Bracket,
    Item,
    Line,
    Query,
    Step,
    items_of,
)
from lanindex.search.match import columns_in
from lanindex.search.match.batch import Batch


def explanation(query: Query, recordings: Iterable[tuple[Capture, Mapping[str, Track]]]) -> str:
    """Return how a query is understood: in English, step by step, and the order of work.

    Parameters
    ----------
    query : Query
        To be explained.
    recordings : iterable of tuple of Capture and Mapping of str to Track
        Where to count what each step alone would match.
    """
    counts = step_counts(query, recordings)
    width = max(len(step) for step in counts)
    lines = [sentence(query), "", "Each step alone:"]
    lines += [f"  {step.ljust(width)}  {count}" for step, count in counts.items()]
    lines += ["", "Order of work:"]
    lines += [f"  {number}. {work}" for number, work in enumerate(order(query), 1)]
    return "\n".join(lines)


def step_counts(
    query: Query, recordings: Iterable[tuple[Capture, Mapping[str, Track]]]
) -> dict[str, int]:
    """Return how many symbols each step alone would match, by the step's text.

    Movements, stays or rests, of pairs those together; no starting positions and, as a step
    alone is a first step, nothing that is only passed.
    """
    states = {_alone(item): states_of(item) for item in items_of(query.pattern)}
    counts = dict.fromkeys(states, 0)
    for capture, tracks in recordings:
        block = Batch(*columns_in([(capture, tracks)], query.parts), np.arange(1), Fraction(0))
        for step, alternatives in states.items():
            for state in alternatives:
                events = block.events(state)
                passing = events.passing & (state.manner != "via")
                counts[step] += int((~events.starting & ~passing).sum())
    return counts


def order(query: Query) -> list[str]:
    """Return what the matcher does, one sentence after the other."""
    works = [f"Take the tracks of {', '.join(sorted(query.parts))}."]
    for lines in query.pattern.alternatives:
        line, first = str(lines.first), _first(lines.first)
        works.append(f"Begin at each {first}" + ("." if line == first else f", and follow {line}"))
        works += [f"Keep what is {it}" for it in lines.others]
    if query.either_side:
        works.append("Do the same with the mirror image.")
    works.append("From each beginning keep what ends first.")
    if query.where:
        works.append(f"Keep what is so: {' and '.join(map(str, query.where))}")
    return [*works, *(f"Of these: {stage}" for stage in query.stages)]


def _alone(item: Item) -> str:
    assert isinstance(item.unit, Step)
    return str(Item(replace(item.unit, named=True), item.length))


def _first(line: Line) -> str:
    item = line.items[0]
    if isinstance(item.unit, Bracket):
        return _first(item.unit.pattern.alternatives[0].first)
    return _alone(item)
