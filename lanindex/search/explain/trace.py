"""One capture under the glass: what matched there step by step, or where the walk ended."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from lanindex import records
from lanindex.model import Capture, Hit, Span, Symbol, Track
from lanindex.search.explain.changes import FORBIDDING
from lanindex.search.explain.stops import Stop, stops
from lanindex.search.language.query import Bracket, Choice, Item, Line, Query
from lanindex.search.language.times import TOLERANCE
from lanindex.search.match import find_in


@dataclass(frozen=True, slots=True)
class Matched:
    """A step of a pattern, and the symbols that matched it.

    Attributes
    ----------
    step : str
        As written, with what goes before: ``-> high``, ``with l_arm``.
    symbols : tuple of Symbol
        Several of a pair, a stay or a repetition; none where it was left out.
    """

    step: str
    symbols: tuple[Symbol, ...]


@dataclass(frozen=True, slots=True)
class Trace:
    """What a query meets with in one capture.

    Attributes
    ----------
    query : Query
        What was looked for.
    capture : Capture
        Where.
    hits : tuple of tuple of Hit and tuple of Matched
        What was found, each with its steps.
    stops : tuple of Stop
        Where nothing was found: how far each alternative came.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     seen = library.why("torso forward high", "greetings.bvh")
    >>> for hit, steps in seen.hits:
    ...     print(hit.span, *steps[0].symbols)
    Span(start=482, stop=524) torso forward high [482, 524)
    """

    query: Query
    capture: Capture
    hits: tuple[tuple[Hit, tuple[Matched, ...]], ...]
    stops: tuple[Stop, ...]


def trace(
    query: Query,
    capture: Capture,
    tracks: Mapping[str, Track],
    *,
    tolerance: Fraction = TOLERANCE,
    overlaps: str = "none",
) -> Trace:
    """Follow a query through a capture.

    Parameters
    ----------
    query : Query
        What to find.
    capture, tracks
        Where.
    tolerance, overlaps
        As in `lanindex.search.match.finder.Finder`.

    Returns
    -------
    Trace
        The hits step by step; where there are none, how far each alternative of the query came.
    """
    plain = replace(query, stages=())
    labelled, steps = _labelled(plain)
    found = find_in([(capture, tracks)], labelled, tolerance=tolerance, overlaps=overlaps)
    hits = tuple((hit, tuple(_steps(hit, steps))) for hit in found)
    ends = () if hits else tuple(stops(plain, capture, tracks, tolerance))
    return Trace(query, capture, hits, ends)


def obstacle(
    query: Query,
    capture: Capture,
    tracks: Mapping[str, Track],
    *,
    tolerance: Fraction = TOLERANCE,
) -> str:
    """Return why a query finds nothing in a capture, one reason for each alternative."""
    seen = trace(query, capture, tracks, tolerance=tolerance)
    return "; or ".join(stop.reason for stop in seen.stops) or "nothing: it is found"


def _steps(hit: Hit, steps: Mapping[str, str]) -> Iterator[Matched]:
    """Yield what matched each step; where a matcher does not tell that, line by line."""
    if not hit.labels:
        yield from (Matched("", line) for line in hit.lines)
        return
    for label, said in steps.items():
        if label in hit.labels:
            yield Matched(said, hit.labels[label])


def _labelled(query: Query) -> tuple[Query, dict[str, str]]:
    """Return a query with a label on every step, and each step as it is written, by its label."""
    steps: dict[str, str] = {}
    return replace(query, pattern=_labelled_pattern(query.pattern, "", steps)), steps


def _labelled_pattern(pattern: Choice, before: str, steps: dict[str, str]) -> Choice:
    alternatives = []
    for lines in pattern.alternatives:
        first = _labelled_line(lines.first, before, steps)
        others = tuple(
            it
            if it.relation in FORBIDDING
            else replace(it, line=_labelled_line(it.line, it.relation, steps))
            for it in lines.others
        )
        alternatives.append(replace(lines, first=first, others=others))
    return Choice(tuple(alternatives))


def _labelled_line(line: Line, before: str, steps: dict[str, str]) -> Line:
    items = []
    for arrow, item in zip((before, *map(str, line.arrows)), line.items, strict=True):
        items.append(_labelled_item(item, arrow, steps))
    return replace(line, items=tuple(items))


def _labelled_item(item: Item, before: str, steps: dict[str, str]) -> Item:
    if isinstance(item.unit, Bracket):
        return replace(item, unit=Bracket(_labelled_pattern(item.unit.pattern, before, steps)))
    label = item.label or f"step {len(steps) + 1}"
    steps[label] = f"{before} {item}".strip()
    return replace(item, label=label)


def records_of(found: Trace) -> Iterator[dict[str, Any]]:
    """Yield a line of ``search --why --json`` for each hit, or for each alternative's end."""
    for hit, steps in found.hits:
        said = [
            {"step": it.step, "symbols": [records.of_matched(symbol) for symbol in it.symbols]}
            for it in steps
        ]
        yield _record(found, hit.span, round(hit.fit, 3), said)
    for stop in found.stops:
        symbols = [records.of_matched(symbol) for symbol in stop.symbols]
        said = [{"step": stop.reached, "symbols": symbols}] if stop.reached else []
        yield _record(found, None, None, said, stop)


def _record(
    found: Trace,
    span: Span | None,
    fit: float | None,
    steps: list[dict[str, Any]],
    stop: Stop | None = None,
) -> dict[str, Any]:
    instead = records.of_matched(stop.instead) if stop and stop.instead else None
    return {
        "capture": found.capture.path,
        "capture_id": found.capture.id,
        "pattern": str(found.query),
        "found": span is not None,
        "start_frame": span.start if span else None,
        "end_frame": span.stop if span else None,
        "fit": fit,
        "steps": steps,
        "wanted": stop.wanted if stop else None,
        "instead": instead,
        "reason": stop.reason if stop else None,
    }
