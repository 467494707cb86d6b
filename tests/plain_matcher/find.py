"""Query + recordings → hits: from each beginning the best way, and which of them are hits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction

from lanindex.errors import UsageError
from lanindex.model import Capture, Hit, Span, Track
from lanindex.search.language.query import Query
from lanindex.search.language.times import TOLERANCE
from lanindex.search.plan import Program, counts, plan
from plain_matcher.candidates import First, Recording
from plain_matcher.clauses import Clauses, labels_of
from plain_matcher.walk import Walker
from plain_matcher.ways import Way

OVERLAPS = ("none", "all")
"""Whether a capture's hits may overlap."""

Recorded = tuple[Capture, Mapping[str, Track]]
"""A capture, and its tracks by part."""


def find(
    query: Query,
    recordings: Iterable[Recorded],
    *,
    tolerance: Fraction = TOLERANCE,
    overlaps: str = "none",
) -> Iterator[Hit]:
    """Find a pattern.

    Parameters
    ----------
    query : Query
        What to find.
    recordings : iterable of tuple of Capture and Mapping of str to Track
        Where: captures, each with its tracks by part. ``query.parts`` are needed; a part that is
        not there never moves.
    tolerance : Fraction, optional
        Seconds within which ``starting``, ``ending`` and ``exactly with`` count as together.
    overlaps : str, optional
        ``none``: from left to right, those that begin when the one before is over; ``all``: one
        for every place where the pattern can start.

    Yields
    ------
    Hit
        Capture by capture as they come, in each by start and end.

    Raises
    ------
    UsageError
        `overlaps` or `tolerance` make no sense.
    LanindexError
        The pattern fits a capture in too many ways to try them all.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.search.language import parse
    >>> from plain_matcher import find
    >>> with lanindex.open_library("dance.db") as library:
    ...     for hit in find(parse("r_arm place high -> place mid"), library.tracks()):
    ...         print(hit.capture.path, hit.span)
    corpus/compass.bvh Span(start=721, stop=773)
    corpus/radio_gymnastics.bvh Span(start=383, stop=428)
    corpus/radio_gymnastics.bvh Span(start=473, stop=518)
    """
    if overlaps not in OVERLAPS:
        raise UsageError(f'overlaps "{overlaps}"', wanted=" or ".join(OVERLAPS))
    if tolerance < 0:
        raise UsageError(f"a tolerance of {tolerance} s", wanted="0 or more")
    return (hits[0] for hits in _find(query, recordings, tolerance, overlaps))


def ties(
    query: Query,
    recordings: Iterable[Recorded],
    *,
    tolerance: Fraction = TOLERANCE,
    overlaps: str = "none",
) -> Iterator[list[Hit]]:
    """Find a pattern, and tell each hit in all ways that are as good: any of them may be shown.

    Those of most steps come first.
    """
    return _find(query, recordings, tolerance, overlaps)


def _find(
    query: Query,
    recordings: Iterable[Recorded],
    tolerance: Fraction,
    overlaps: str,
) -> Iterator[list[Hit]]:
    programs = plan(query)
    counted = counts(query.pattern)
    for capture, tracks in recordings:
        recording = Recording(capture, tracks)
        clauses = Clauses(query, recording)
        if not clauses.may_hold(()):
            continue
        best = _best(Walker(recording, tolerance, clauses), programs)
        if overlaps == "none":
            best = list(_apart(best if counted else _nearest(best)))
        yield from ([_hit(recording, way) for way in ways] for ways in best)


def _best(walker: Walker, programs: tuple[Program, ...]) -> list[list[Way]]:
    """Return the best ways from each place where the pattern can start, in order of time."""
    every: dict[First, list[Way]] = {}
    for program in programs:
        for ways in walker.leading(program):
            for way in ways:
                every.setdefault(way.nodes[0].match.first, []).append(way)
    best = []
    for ways in every.values():
        rank = min(way.rank for way in ways)
        tied = [way for way in ways if way.rank == rank]
        best.append(sorted(tied, key=lambda way: -len(way.nodes)))
    return sorted(best, key=lambda ways: (ways[0].low, ways[0].high, -ways[0].fit))


def _nearest(best: list[list[Way]]) -> list[list[Way]]:
    """Return, of ways that end together, those that start last."""
    latest: dict[int, int] = {}
    for way, *_ in best:
        latest[way.high] = max(way.low, latest.get(way.high, way.low))
    return [ways for ways in best if ways[0].low == latest[ways[0].high]]


def _apart(best: list[list[Way]]) -> Iterator[list[Way]]:
    """Yield, from left to right, those that begin at or after the end of the one before.

    Those of other beginnings that are as good may be shown instead.
    """
    end = 0
    for ways in best:
        if ways[0].low >= end:
            end = ways[0].high
            yield [way for tied in best if tied[0].rank == ways[0].rank for way in tied]


def _hit(recording: Recording, way: Way) -> Hit:
    lines = tuple(tuple(recording.symbols(part)[row] for part, row in line) for line in way.lines())
    labels = labels_of(recording, way.labelled())
    return Hit(recording.capture, Span(way.low, way.high), way.fit, lines, labels)
