"""Query + recordings → hits: the plain matcher, which follows the language's page word for word.

It is correct first and serves as the oracle of any faster one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction

from lanindex.errors import UsageError
from lanindex.model import Capture, Hit, Span, Track
from lanindex.search.automaton import Program, counts, plan
from lanindex.search.language.query import Query
from lanindex.search.plain.candidates import First, Recording
from lanindex.search.plain.clauses import Clauses, labels_of
from lanindex.search.plain.paths import Path
from lanindex.search.plain.walk import Walker

TOLERANCE = Fraction(1, 10)
"""Seconds by which edges may differ that should agree."""

OVERLAPS = ("none", "all")
"""Whether a capture's hits may overlap."""


def find(
    query: Query,
    recordings: Iterable[tuple[Capture, Mapping[str, Track]]],
    *,
    tolerance: Fraction = TOLERANCE,
    overlaps: str = "none",
    tick: Callable[[], None] = lambda: None,
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
    tick : callable, optional
        Is called now and then, also while one capture is searched, and may raise.

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
    >>> from lanindex.search.plain import find
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
    return _find(query, recordings, tolerance, overlaps, tick)


def _find(
    query: Query,
    recordings: Iterable[tuple[Capture, Mapping[str, Track]]],
    tolerance: Fraction,
    overlaps: str,
    tick: Callable[[], None],
) -> Iterator[Hit]:
    programs = plan(query)
    counted = counts(query.pattern)
    for capture, tracks in recordings:
        recording = Recording(capture, tracks, tick)
        clauses = Clauses(query, recording)
        if not clauses.may_hold(()):
            continue
        paths = _starts(Walker(recording, programs, tolerance, clauses), programs)
        if overlaps == "none":
            paths = list(_apart(paths if counted else _nearest(paths)))
        yield from (_hit(recording, path) for path in paths)


class Teller:
    """Tells single hits of a capture, from the symbols with which they begin.

    Parameters
    ----------
    query : Query
        What was found.
    capture : Capture
        Where.
    tracks : Mapping of str to Track
        Its tracks by part.
    tolerance : Fraction
        As for `find`.
    """

    def __init__(
        self, query: Query, capture: Capture, tracks: Mapping[str, Track], tolerance: Fraction
    ) -> None:
        self._recording, self._programs = Recording(capture, tracks), plan(query)
        clauses = Clauses(query, self._recording)
        self._walker = Walker(self._recording, self._programs, tolerance, clauses)

    def hit(self, first: First) -> Hit | None:
        """Return the best hit that begins with some symbols, None if there is none."""
        paths = _starts(self._walker, self._programs, first)
        return _hit(self._recording, paths[0]) if paths else None


def _starts(
    walker: Walker, programs: tuple[Program, ...], first: First | None = None
) -> list[Path]:
    """Return the best path from each place where the pattern can start, in order of time."""
    best: dict[First, Path] = {}
    for program in programs:
        for path in walker.leading(program, first):
            here = path.first.first
            if here not in best or path.rank < best[here].rank:
                best[here] = path
    return sorted(best.values(), key=lambda path: (path.low, path.high, -path.fit))


def _nearest(paths: list[Path]) -> list[Path]:
    """Return, of paths that end together, those that start last."""
    latest: dict[int, int] = {}
    for path in paths:
        latest[path.high] = max(path.low, latest.get(path.high, path.low))
    return [path for path in paths if path.low == latest[path.high]]


def _apart(paths: list[Path]) -> Iterator[Path]:
    """Yield, from left to right, those that begin at or after the end of the one before."""
    end = 0
    for path in paths:
        if path.low >= end:
            end = path.high
            yield path


def _hit(recording: Recording, path: Path) -> Hit:
    lines = tuple(
        tuple(recording.symbols(part)[row] for part, row in line) for line in path.lines()
    )
    labels = labels_of(recording, path.labelled())
    return Hit(recording.capture, Span(path.low, path.high), path.fit, lines, labels)
