"""What may match a state of a program, anywhere in a capture or over an arrow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product

from lanindex.model import Capture, Symbol, Track
from lanindex.search.language.query import Arrow
from lanindex.search.language.times import Clock, Length
from lanindex.search.plan import State
from plain_matcher.track import Claim, Event, Origin, Timeline

First = frozenset[tuple[str, int]]
"""The first symbols of a match: parts and rows. They tell the places where a pattern can start."""


@dataclass(eq=False)
class Match:
    """What matches a state: one event, or two that share a frame.

    Attributes
    ----------
    manner : str
        Of the state: a movement, a passage, a stay or a rest.
    events : tuple of Event
        One a member of the state.
    start, end, until : int
        Frames, half-open, and the end for sharing frames.
    passing, starting : bool
        Whether one of them is on the way only, or a starting position.
    """

    manner: str
    events: tuple[Event, ...]
    start: int
    end: int
    until: int
    passing: bool
    starting: bool

    @cached_property
    def claims(self) -> frozenset[Claim]:
        """What it uses up."""
        return frozenset().union(*(event.claims for event in self.events))

    @property
    def first(self) -> First:
        """Its first symbols."""
        return frozenset((event.timeline.part, event.first) for event in self.events)

    @cached_property
    def fit(self) -> float:
        """The smallest margin of its symbols."""
        return min(event.fit for event in self.events)

    @property
    def may_border(self) -> bool:
        """Whether a line may begin or end with it: only ``via`` knows what the score leaves out."""
        return not self.passing or self.manner == "via"


def _matched(manner: str, events: tuple[Event, ...]) -> Match | None:
    """Return one event as a match, or two if they share a frame.

    Two movements span both; two stays or rests last while both do.
    """
    begin, end = max(it.start for it in events), min(it.until for it in events)
    if len(events) > 1 and begin >= end:
        return None
    moving = manner in ("move", "via")
    if moving:
        begin, end = min(it.start for it in events), max(it.end for it in events)
    return Match(
        manner,
        events,
        begin,
        end,
        max(it.until for it in events) if moving else end,
        any(it.passing for it in events),
        any(it.starting for it in events),
    )


class Recording:
    """One capture, laid out for matching.

    Parameters
    ----------
    capture : Capture
        Its rate, frames and tempo.
    tracks : Mapping of str to Track
        By part; a part that is not there never moves.
    """

    def __init__(
        self,
        capture: Capture,
        tracks: Mapping[str, Track],
    ) -> None:
        self.capture, self._tracks = capture, tracks
        self._clock = Clock(capture.rate, capture.meter.speed / 60)
        self._timelines: dict[str, Timeline | None] = {}
        self._symbols: dict[str, list[Symbol]] = {}
        self._events: dict[State, tuple[list[Event], ...]] = {}

    def timeline(self, part: str) -> Timeline | None:
        """Return a part's timeline, None if the capture lacks the part."""
        if part not in self._timelines:
            track = self._tracks.get(part)
            frames = self.capture.frames
            self._timelines[part] = Timeline(track, frames) if track and len(track) else None
        return self._timelines[part]

    def symbols(self, part: str) -> list[Symbol]:
        """Return a part's symbols as objects."""
        if part not in self._symbols:
            self._symbols[part] = self._tracks[part].listed()
        return self._symbols[part]

    def events(self, state: State) -> tuple[list[Event], ...]:
        """Return, for each member of a state, the events that fit, in order of their rows."""
        if state not in self._events:
            timelines = [self.timeline(part) for part in state.members]
            self._events[state] = tuple(
                it.events(state, member) if it else [] for member, it in enumerate(timelines)
            )
        return self._events[state]

    def meets(self, frames: int, length: Length | None) -> bool:
        """Return whether a number of frames meets a condition on length."""
        if length is None:
            return True
        least, most = length.bounds(self._clock)
        return least <= frames and (most is None or frames <= most)

    def anywhere(self, state: State) -> Iterator[Match]:
        """Yield what matches a state that begins a line."""
        for events in product(*self.events(state)):
            match = self._match(state, events)
            if match and match.may_border:
                yield match

    def _origins(self, state: State, before: Match, same: bool) -> tuple[Origin, ...] | None:
        """Return from where an arrow looks for each member of a state, None if it cannot.

        Parameters
        ----------
        state : State
            Where the arrow leads.
        before : Match
            Where it comes from.
        same : bool
            Whether both are of the same parts.
        """
        origins = []
        for member, part in enumerate(state.members):
            timeline = self.timeline(part)
            if timeline is None:
                return None
            if same:
                origin: Origin | None = timeline.after(before.events[member], state.manner)
            else:
                origin = timeline.since(before.end, state.manner)
            if origin is None:
                return None
            origins.append(origin)
        return tuple(origins)

    def following(self, state: State, before: Match, arrow: Arrow, same: bool) -> Iterator[Match]:
        """Yield what matches a state over an arrow from the match before.

        Between a passing symbol and the one that it leads to no time passes.
        """
        origins = self._origins(state, before, same)
        if origins is None:
            return
        moving = before.passing and same and not arrow.later
        choices = (
            _within(events, origin, arrow)
            for events, origin in zip(self.events(state), origins, strict=True)
        )
        for chosen in product(*choices):
            match = self._match(state, chosen)
            if match is None:
                continue
            if self.meets(0 if moving else max(0, match.start - before.end), arrow.length):
                yield match

    def begins(self, match: Match, arrow: Arrow) -> bool:
        """Return whether an arrow leads from the clip's start to a match."""
        for event in match.events:
            origin = event.timeline.from_start(event.manner)
            if origin is None or not _allows(arrow, event.timeline.count(origin, event)):
                return False
            if event.manner in ("at", "hold") and not arrow.later and event.start > 0:
                return False
        return match.may_border and self.meets(match.start, arrow.length)

    def ends(self, match: Match, arrow: Arrow) -> bool:
        """Return whether an arrow leads from a match to the clip's end."""
        for event in match.events:
            if not _allows(arrow, event.timeline.remaining(event)):
                return False
        remaining = self.capture.frames - match.end
        return not match.passing and self.meets(remaining, arrow.length)

    def _match(self, state: State, events: tuple[Event, ...]) -> Match | None:
        match = _matched(state.manner, events)
        if match is None or state.length is None:
            return match
        fits = not match.starting and self.meets(match.end - match.start, state.length)
        return match if fits else None


def _allows(arrow: Arrow, count: int | None) -> bool:
    least, most = arrow.bounds
    return count is not None and least <= count and (most is None or count <= most)


def _within(events: list[Event], origin: Origin, arrow: Arrow) -> Iterator[Event]:
    """Yield the events to which an arrow leads; a starting position never follows one."""
    for event in events:
        if _allows(arrow, event.timeline.count(origin, event)) and not event.starting:
            yield event
