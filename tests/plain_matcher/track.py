"""One part's track as a matcher sees it: movements, stays, rests, and what follows what.

Rows of a track are *shown* if the score shows them, else *passing*: on the way to the row after.
A movement spans its row and is achieved in its last frame; a stay (``at``) lasts from there until
the part goes on; a rest (``hold``) from the row's end to the next one's start. Nothing
crosses a gap of the capture: rows on both sides of one are of different *stretches*.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import NamedTuple

from lanindex.alphabet import is_limb
from lanindex.model import Track
from lanindex.model.columns import GRADES, THOUSANDTHS, graded, stored
from lanindex.search.language.words import STILL, WORD_KINDS
from lanindex.search.plan import State

Symbol = tuple[str, int]
"""A symbol that is used: a part and a row."""

Claim = tuple[str, str, int]
"""What cannot serve two lines: a manner, a part and a row."""


def symbols_of(claims: Iterable[Claim]) -> frozenset[Symbol]:
    """Return the symbols of what is used, whatever as."""
    return frozenset((part, row) for _, part, row in claims)


def forgiving(claims: frozenset[Claim]) -> frozenset[Claim]:
    """Return what must not happen and does not count: what is used, and how it came there."""
    return claims | {("move", part, row) for part, row in symbols_of(claims)}


@dataclass(eq=False)
class Event:
    """A movement, stay or rest of one part.

    Attributes
    ----------
    timeline : Timeline
        Whose.
    first, last : int
        Its rows; only a stay has several.
    start, end : int
        Its frames, half-open; a starting position has none.
    until : int
        Its end for sharing frames: a starting position lasts until the first movement.
    fit : float
        How clearly it is what was asked for: by the smallest margin of its symbols.
    passing, starting : bool
        Whether it is on the way only, or a starting position.
    """

    timeline: Timeline
    manner: str
    first: int
    last: int
    start: int
    end: int
    until: int
    fit: float
    passing: bool = False
    starting: bool = False

    @cached_property
    def rows(self) -> tuple[int, ...]:
        """Its rows; the passing ones within a stay are not named."""
        rows = range(self.first, self.last + 1)
        return tuple(row for row in rows if self.passing or not self.timeline.passing[row])

    @cached_property
    def claims(self) -> frozenset[Claim]:
        """What it uses up: no other line may use it too."""
        return frozenset((self.manner, self.timeline.part, row) for row in self.rows)


class Origin(NamedTuple):
    """From where an arrow looks: what comes next has count 0, what comes after that 1, and so on.

    Attributes
    ----------
    row : int
        The first row that may follow.
    shown : int
        How many shown rows are behind.
    stretch : int
        Which no arrow leaves.
    """

    row: int
    shown: int
    stretch: int


_COLUMNS = {"direction": "direction", "level": "level", "change": "", STILL: "swings"}
_COLUMNS |= dict.fromkeys(GRADES, "")
"""By kind of words, the field of a symbol that has it, if not the amount; empty: none has."""


class Timeline:
    """A track, with what follows what worked out.

    Parameters
    ----------
    track : Track
        Of one part.
    frames : int
        Of the capture.
    """

    def __init__(self, track: Track, frames: int) -> None:
        self._track, rows = track, track.symbols
        self.part, self.frames = track.part, frames
        self.start: list[int] = rows["start"].tolist()
        self.stop: list[int] = rows["stop"].tolist()
        self.passing: list[bool] = rows["passing"].tolist()
        self.margin: list[float] = rows["margin"].tolist()
        self._columns: dict[str, list[int]] = {}
        self.starting = [a == b for a, b in zip(self.start, self.stop, strict=True)]
        self.shown = [row for row, passing in enumerate(self.passing) if not passing]
        self.rank = [0, *accumulate(int(not passing) for passing in self.passing)]
        begins = [int(starting and row > 0) for row, starting in enumerate(self.starting)]
        if not is_limb(self.part):  # what just happens has no starting position
            own = [sum(span.start <= start for span in track.known) for start in self.start]
            parted = [one != two for one, two in zip(own, own[:1] + own, strict=False)]
            begins = [int(begin or apart) for begin, apart in zip(begins, parted, strict=True)]
        self.stretch = list(accumulate(begins))
        self._known(track)
        self._follow()

    def _known(self, track: Track) -> None:
        """Work out the frames of each stretch."""
        self.spans = []
        for number in range(self.stretch[-1] + 1 if self.stretch else 0):
            begin = self.start[self.stretch.index(number)]
            inside = [it for it in track.known if it.start <= begin <= it.stop]
            span = inside[-1] if inside else None
            self.spans.append((span.start, span.stop) if span else (begin, self.frames))

    def _follow(self) -> None:
        """Work out until when each shown row is the last, and how its level has changed."""
        self.until = [0] * len(self.start)
        codes, level = WORD_KINDS["change"].codes, self._track.symbols["level"].tolist()
        change = [codes["neither"] if it >= 0 else -1 for it in level]
        for row, after in zip(self.shown, [*self.shown[1:], -1], strict=True):
            same = after >= 0 and self.stretch[after] == self.stretch[row]
            self.until[row] = self.start[after] if same else self.spans[self.stretch[row]][1]
            if same and min(level[row], level[after]) >= 0 and level[row] != level[after]:
                change[after] = codes["rising" if level[row] < level[after] else "sinking"]
        self._columns["change"] = change
        for kind, name in GRADES.items():
            grades = graded(self.part, kind, stored(name, self._track.symbols[name]))
            self._columns[kind] = grades.tolist()

    def _fitting(self, state: State, member: int) -> list[float]:
        """Return, for each row, how clearly it is what a state says; -1 where it is not.

        It may also be so by the cell across its nearest border, if that is near enough.
        """
        own, across = self._saying(state, member, ""), [False] * len(self.start)
        if state.near:
            across = self._saying(state, member, "runner_")
        fitting = []
        for here, there, margin in zip(own, across, self.margin, strict=True):
            thousandths = round(margin * THOUSANDTHS)
            inside = state.near + (thousandths if here else -thousandths)
            clear = inside * THOUSANDTHS // (state.near + THOUSANDTHS) / THOUSANDTHS
            fitting.append(clear if here or (there and inside > 0) else -1)
        return fitting

    def _saying(self, state: State, member: int, whose: str) -> list[bool]:
        """Return, for each row, whether its cell, or its ``runner_``-up, is what a state says."""
        saying = [True] * len(self.start)
        for kind, codes in state.fits[member].items():
            column = _COLUMNS.get(kind, "amount")
            beside = whose if column in ("direction", "level") else ""
            name = beside + column if column else kind
            if name not in self._columns:
                self._columns[name] = self._track.symbols[name].tolist()
            held = self._columns[name]
            saying = [so and code in codes for so, code in zip(saying, held, strict=True)]
        return saying

    # Events.

    def events(self, state: State, member: int) -> list[Event]:
        """Return all movements, stays or rests that a state asks for, in order of their rows."""
        fitting = self._fitting(state, member)
        if state.manner == "at":
            return list(self._stays(fitting))
        if state.manner == "hold":
            return list(self._rests(fitting))
        return list(self._movements(fitting, state.names_passing))

    def _movements(self, fitting: list[float], names_passing: bool) -> Iterator[Event]:
        for row, passing in enumerate(self.passing):
            fit = fitting[row]
            if fit < 0 or (passing and not names_passing):
                continue
            start, stop = self.start[row], self.stop[row]
            starting = self.starting[row]
            until = max(self.until[row], start + 1) if starting else stop
            yield Event(self, "move", row, row, start, stop, until, fit, passing, starting)

    def _stays(self, fitting: list[float]) -> Iterator[Event]:
        stay: list[int] = []
        for row in [*self.shown, -1]:
            fits = row >= 0 and fitting[row] >= 0
            if stay and not (fits and self.stretch[row] == self.stretch[stay[0]]):
                start, end = self.arrival(stay[0]), self.until[stay[-1]]
                if start < end:
                    fit = min(fitting[held] for held in stay)
                    yield Event(self, "at", stay[0], stay[-1], start, end, end, fit)
                stay = []
            if fits:
                stay.append(row)

    def _rests(self, fitting: list[float]) -> Iterator[Event]:
        for row in self.shown:
            if fitting[row] >= 0 and self.stop[row] < self.until[row]:
                start, end = self.stop[row], self.until[row]
                yield Event(self, "hold", row, row, start, end, end, fitting[row])

    def arrival(self, row: int) -> int:
        """Return the frame in which a row is achieved."""
        return self.start[row] if self.starting[row] else self.stop[row] - 1

    # What follows what.

    def after(self, event: Event, manner: str) -> Origin:
        """Return the origin of an arrow from an event of this part."""
        row = event.last
        behind = self.rank[row + 1]
        same_row = manner == "hold" and event.manner == "move" and not event.passing
        return Origin(row if same_row else row + 1, behind, self.stretch[row])

    def since(self, frame: int, manner: str) -> Origin | None:
        """Return the origin of an arrow from another part's event that ends before `frame`."""
        for stretch, (begin, end) in enumerate(self.spans):
            if begin <= frame < end:
                return self._since(frame, manner, stretch)
        return None

    def _since(self, frame: int, manner: str, stretch: int) -> Origin | None:
        before = -1
        for row in self.shown:
            if self.stretch[row] == stretch and self._begins(row, manner) >= frame:
                if manner == "hold":
                    return Origin(row, self.rank[row] + 1, stretch)
                no_stay = manner == "at" and self._left_at_once(row)
                return Origin(before + 1, self.rank[row] + no_stay, stretch)
            before = row
        return None

    def _begins(self, row: int, manner: str) -> int:
        """Return when a row's movement, stay or rest begins; -1 if it has none."""
        if manner == "at":
            return self.arrival(row)
        if manner == "hold":
            return self.stop[row] if self.stop[row] < self.until[row] else -1
        return -1 if self.starting[row] else self.start[row]

    def from_start(self, manner: str) -> Origin | None:
        """Return the origin of an arrow from the clip's start."""
        if not self.spans or self.spans[0][0] > 0:
            return None
        row = self.shown[0]
        moves_on = self._left_at_once(row) if manner == "at" else self.starting[row]
        return Origin(0, int(manner == "hold" or moves_on), 0)

    def _left_at_once(self, row: int) -> bool:
        """Return whether a row is a starting position that alone is no stay."""
        return self.starting[row] and self.until[row] <= self.start[row]

    def count(self, origin: Origin, event: Event) -> int | None:
        """Return how many movements lie between; None where no arrow leads."""
        if event.first < origin.row or self.stretch[event.first] != origin.stretch:
            return None
        count = self.rank[event.first] + int(event.manner == "hold") - origin.shown
        # a stay may begin in a starting position that alone is none
        return max(0, count) if event.manner == "at" else count

    def remaining(self, event: Event) -> int | None:
        """Return how many movements follow until the clip's end; None where it is not known."""
        if self.spans[self.stretch[event.last]][1] < self.frames:
            return None
        return len(self.shown) - self.rank[event.last + 1]
