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
from lanindex.search.conditions import holds, names_in
from lanindex.search.language.clauses import CLIP, MATCH
from lanindex.search.language.query import Query
from lanindex.search.plain.candidates import Recording
from lanindex.search.plain.paths import Path, Seen

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
        self._names = {condition: names_in([condition]) - {CLIP} for condition in query.where}
        self.timed = bool(query.rhythm)
        names = names_in(query.where)
        self.labels = names - {CLIP, MATCH}
        self.of_match = MATCH in names

    def may_go_on(self, beats: tuple[int, ...]) -> bool:
        """Tell whether there are not yet more steps than the rhythm has."""
        return not self.timed or len(beats) <= len(self._rhythm)

    def may_hold(self, seen: tuple[Seen, ...]) -> bool:
        """Tell whether the conditions hold that speak of these labels and of the clip alone."""
        told = {it.label for it in seen}
        settled = [it for it in self._where if self._names[it] <= told]
        if not settled:
            return True
        hit = Hit(self._recording.capture, Span(0, 0), 1.0, (), labels_of(self._recording, seen))
        return all(holds(condition, hit) for condition in settled)

    def met_by(self, path: Path) -> bool:
        """Tell whether a way through the whole pattern is as the clauses ask."""
        return self._in_rhythm(path.memory.beats) and self._true_of(path)

    def _in_rhythm(self, beats: tuple[int, ...]) -> bool:
        if not self.timed:
            return True
        if len(beats) != len(self._rhythm):
            return False
        unit = Fraction(sum(beats)) / sum(self._rhythm)
        return all(
            abs(beat - share * unit) <= _OFF * share * unit
            for beat, share in zip(beats, self._rhythm, strict=True)
        )

    def _true_of(self, path: Path) -> bool:
        if not self._where:
            return True
        event = path.node.match.events[-1]
        last = self._recording.symbols(event.timeline.part)[event.rows[-1]]
        hit = Hit(
            self._recording.capture,
            Span(path.low, path.high),
            path.fit,
            ((last,),),
            labels_of(self._recording, path.memory.seen),
        )
        return all(holds(condition, hit) for condition in self._where)
