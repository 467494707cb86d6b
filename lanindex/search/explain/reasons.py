"""How a query is understood, and what stands in its way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction

from lanindex.model import Capture, Track
from lanindex.search.automaton import states_of
from lanindex.search.explain.english import sentence
from lanindex.search.language.query import (
    Bracket,
    Choice,
    Item,
    Line,
    Lines,
    Query,
    Step,
    items_of,
)
from lanindex.search.plain import TOLERANCE, find
from lanindex.search.plain.candidates import Recording


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
        recording = Recording(capture, tracks)
        for step, alternatives in states.items():
            for state in alternatives:
                counts[step] += sum(not match.starting for match in recording.anywhere(state))
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


def obstacle(
    query: Query,
    capture: Capture,
    tracks: Mapping[str, Track],
    *,
    tolerance: Fraction = TOLERANCE,
) -> str:
    """Return why a query finds nothing in a capture, one reason for each alternative.

    Parameters
    ----------
    query : Query
        Which has no hit there.
    capture, tracks
        Where.
    tolerance : Fraction, optional
        As in `lanindex.search.plain.find.find`.
    """
    recording = [(capture, tracks)]

    def found(lines: Lines) -> bool:
        reduced = replace(query, pattern=Choice((lines,)))
        return any(True for _ in find(reduced, recording, tolerance=tolerance))

    reasons = []
    for lines in query.pattern.alternatives:
        shortened = list(_shortened(lines))
        reached = [number for number, (shorter, _) in enumerate(shortened, 1) if found(shorter)]
        if len(shortened) in reached:
            return "nothing: it is found"
        reason = shortened[max(reached, default=0)][1]
        counts = step_counts(replace(query, pattern=Choice((lines,))), recording)
        never = " or ".join(f'"{step}"' for step, count in counts.items() if not count)
        alone = f"; no movement at all is {never}" if never and never not in reason else ""
        reasons.append(reason + alone)
    return "; or ".join(reasons)


def _shortened(lines: Lines) -> Iterator[tuple[Lines, str]]:
    """Yield ever longer beginnings of some lines, and what to say of the first not found."""
    first = lines.first
    for count in range(min(2, len(first.items)), len(first.items) + 1):
        line = Line(first.items[:count], first.arrows[: count - 1], first.start)
        before = Line(first.items[: count - 1], first.arrows[: max(count - 2, 0)], first.start)
        if count == 1:
            yield Lines(line), f'there is no "{line}"'
        else:
            step = f"{first.arrows[count - 2]} {first.items[count - 1]}"
            yield Lines(line), f'"{before}" never goes on "{step}"'
    if first.end:
        yield Lines(first), f'"{replace(first, end=None)}" is never the clip\'s end'
    for count, beside in enumerate(lines.others, 1):
        before_it = Lines(first, lines.others[: count - 1])
        yield Lines(first, lines.others[:count]), f'"{before_it}" is never "{beside}"'


def _alone(item: Item) -> str:
    assert isinstance(item.unit, Step)
    return str(Item(replace(item.unit, named=True), item.length))


def _first(line: Line) -> str:
    item = line.items[0]
    if isinstance(item.unit, Bracket):
        return _first(item.unit.pattern.alternatives[0].first)
    return _alone(item)
