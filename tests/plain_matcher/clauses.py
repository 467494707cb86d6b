"""What the clauses behind a pattern ask of each way in which it matches: rhythm and conditions.

Conditions choose among the ways before the best one is taken: "any way to satisfy the whole pattern
counts". "The first line's steps last in that proportion, each ± 25 %; every repetition is a step;
rests between do not count."
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

from lanindex.model import Hit, Span, Symbol
from lanindex.search.hits import names_in
from lanindex.search.language.clauses import CLIP
from lanindex.search.language.query import Query
from plain_matcher.candidates import Match, Recording
from plain_matcher.conditions import holds
from plain_matcher.ways import Seen, Way

_OFF = Fraction(1, 4)
"""How far a step of a rhythm may be off, in proportion to its share."""


def labels_of(recording: Recording, seen: Iterable[Seen]) -> dict[str, tuple[Symbol, ...]]:
    """Return, by label, the symbols under it, with the frames of the steps that they matched."""
    labels: dict[str, tuple[Symbol, ...]] = {}
    for it in seen:
        symbol = replace(recording.symbols(it.part)[it.row], start=it.start, stop=it.end)
        labels[it.label] = (*labels.get(it.label, ()), symbol)
    return labels


class Clauses:
    """The clauses of a query, asked of one capture.

    Parameters
    ----------
    query : Query
        With its rhythm and conditions.
    recording : Recording
        The capture.
    """

    def __init__(self, query: Query, recording: Recording) -> None:
        self._recording = recording
        self._rhythm, self._where = query.rhythm, query.where

    def may_hold(self, seen: Iterable[Seen]) -> bool:
        """Return whether the conditions hold that speak of these labels and of the clip alone."""
        labels = labels_of(self._recording, seen)
        hit = Hit(self._recording.capture, Span(0, 0), 1.0, (), labels)
        told = {CLIP, *labels}
        return all(holds(it, hit) for it in self._where if names_in([it]) <= told)

    def met_by(self, way: Way) -> bool:
        """Return whether a way through the whole pattern is as the clauses ask."""
        return self._in_rhythm([it.match for it in way.nodes]) and self._true_of(way)

    def _in_rhythm(self, matches: list[Match]) -> bool:
        beats = [it.end - it.start for it in matches]
        if not self._rhythm or len(beats) != len(self._rhythm):
            return not self._rhythm
        unit = Fraction(sum(beats)) / sum(self._rhythm)
        return all(
            abs(beat - share * unit) <= _OFF * share * unit
            for beat, share in zip(beats, self._rhythm, strict=True)
        )

    def _true_of(self, way: Way) -> bool:
        event = way.node.match.events[-1]
        last = self._recording.symbols(event.timeline.part)[event.rows[-1]]
        labels = labels_of(self._recording, way.labelled())
        span = Span(way.low, way.high)
        hit = Hit(self._recording.capture, span, way.fit, ((last,),), labels)
        return all(holds(condition, hit) for condition in self._where)
