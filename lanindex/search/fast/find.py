"""Query + columns → hits: where they are in all captures at once, objects of those asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial

import numpy as np

from lanindex.errors import LanindexError
from lanindex.model import Capture, Hit, Span, Symbol, Track
from lanindex.model.columns import THOUSANDTHS, Columns, Roster, columns_of
from lanindex.model.symbol import listed
from lanindex.search import plain
from lanindex.search.automaton import counts, plan
from lanindex.search.conditions import holds
from lanindex.search.fast import overlaps as staying
from lanindex.search.fast.answers import (
    Answers,
    best,
    firsts,
    joined,
    own_rows,
)
from lanindex.search.fast.asked import Asked
from lanindex.search.fast.asking import answers_of, possible
from lanindex.search.fast.block import Block, slabs
from lanindex.search.fast.chains import chains_of
from lanindex.search.fast.chains import table as table_of
from lanindex.search.fast.found import Found
from lanindex.search.fast.lines import value_of
from lanindex.search.fast.linked import Linked, covered
from lanindex.search.fast.narrow import Narrowing
from lanindex.search.fast.placed import TOGETHER
from lanindex.search.fast.ragged import Mask, NotCovered, TooMuch, Whole
from lanindex.search.fast.setting import Setting
from lanindex.search.fast.source import Recordings, Source
from lanindex.search.fast.trace import labelled, trace
from lanindex.search.language.query import Query

MANY = 1000
"""Captures of which it is asked first which of them can have a hit."""

MOST_ROWS = 1 << 16
"""How many rows of a part, or captures, are gone through at once."""

Watch = Callable[[int, int], None]
"""Is told, now and then, how many captures are done, of how many; it may raise."""


class Finder:
    """Searches for one query.

    Parameters
    ----------
    query : Query
        What to find.
    roster : Roster
        All captures.
    columns : Mapping of str to Columns
        The symbols of the query's parts; a part that is not there never moves.
    recordings : callable
        Gives captures and tracks, by places in the roster: of hits that are made objects, and of
        captures that only the plain matcher can tell about.
    tolerance : Fraction
        Seconds within which edges agree.
    """

    def __init__(
        self,
        query: Query,
        roster: Roster,
        columns: Mapping[str, Columns],
        recordings: Recordings,
        tolerance: Fraction = plain.TOLERANCE,
    ) -> None:
        self._query, self._roster, self._columns = query, roster, columns
        self._tolerance = tolerance
        self._programs = plan(query)
        self._parts: list[tuple[str, ...]] = []
        self._recordings = recordings
        self._fetched: dict[int, tuple[Capture, Mapping[str, Track]]] = {}
        self._told: dict[int, list[Hit]] = {}
        self._tellers: dict[int, plain.Teller] = {}
        self._asked = Asked(query)
        self._meet: dict[int, bool] = {}
        self._labelled = any(it.labels for program in self._programs for it in program.states)

    def find(self, overlaps: str = "none", watch: Watch | None = None) -> Found:
        """Return all hits.

        Parameters
        ----------
        overlaps : str
            ``none`` or ``all``, as in `lanindex.search.plain.find`.
        watch : callable, optional
            Is told how far the search is.
        """
        pieces = self._chained(watch)
        if pieces is None:
            pieces = self._linked(watch)
        blocks: list[Whole] = []
        if pieces is None:
            pieces, blocks = [], slabs(self._columns.values(), self._possible(), MOST_ROWS)
        for places in blocks:
            answers, doubtful = self._among(places, watch)
            pieces.append(answers)
            told = self._told_plainly(doubtful, watch)
            self._told.update(told)
            pieces += [_columns_of(place, hits) for place, hits in told.items()]
        answers = joined(pieces)
        if (answers.capture[1:] < answers.capture[:-1]).any():
            answers = answers.at(np.argsort(answers.capture, kind="stable"))
        answers = self._in_those_asked_for(answers)
        return Found(self, answers, self._kept(answers, overlaps), len(self._told))

    def _chained(self, watch: Watch | None) -> list[Answers] | None:
        """Return all answers where no program is more than chains, else None."""
        if self._asked:
            return None
        chained = [chains_of(program) for program in self._programs]
        found: list[Answers] = []
        for number, chains in enumerate(chained):
            if chains is None:
                return None
            if watch:
                watch(0, len(self._roster))
            state = self._programs[number].states[0]
            place, _ = firsts(state, self._parts)
            if None not in chained and state.members[0] in self._columns:
                columns = self._columns[state.members[0]]
                found.append(table_of(columns, chains, number, place))
        every = best(joined(found))
        return [own_rows(every, self._parts, lambda part: self._columns[part].bounds)]

    def _linked(self, watch: Watch | None) -> list[Answers] | None:
        """Return all answers where all lines are linked movements of one part, else None."""
        chains = None if self._asked else covered(self._programs)
        if chains is None:
            return None
        linked = Linked(self._roster, self._columns, self._programs, self._tolerance)
        found = []
        for done, answers in linked.answers(chains, self._parts):
            if watch:
                watch(done, len(self._roster))
            found.append(answers)
        return found

    def fetch(self, places: Sequence[int]) -> None:
        """Fetch captures of which hits will be made objects; forget the others."""
        self._fetched = dict(zip(places, self._recordings(places, self._query.parts), strict=True))
        for place, (capture, tracks) in self._fetched.items():
            self._check(place, capture, tracks)

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the roster."""
        return [capture for capture, _ in self._recordings(places, ())]

    def numbers(self, places: Whole) -> Whole:
        """Return the numbers of captures by their places in the roster."""
        return self._roster.number[places]

    def hit(self, answer: Answers) -> Hit:
        """Return the one answer of a table as an object."""
        place = int(answer.capture[0])
        if place in self._told:
            return self._told[place][int(answer.rows[0, 0])]
        if place not in self._fetched:
            self.fetch([place])
        if answer.cost[0] < 0 or self._labelled:
            return self._teller(place, answer)
        taken = trace(
            self._block(np.array([place])),
            self._programs[int(answer.program[0])],
            self._parts[int(answer.parts[0])],
            tuple(answer.rows[0].tolist()),
            int(answer.low[0]),
            int(value_of(answer.high, answer.cost)[0]),
        )
        capture, tracks = self._fetched[place]
        span = Span(int(answer.low[0]), int(answer.high[0]))
        rows = dict.fromkeys(row for it in taken for row in it.rows)
        symbols = {(part, row): _symbol(tracks[part], row) for part, row in rows}
        return Hit(
            capture,
            span,
            (THOUSANDTHS - int(answer.cost[0])) / THOUSANDTHS,
            (tuple(symbols.values()),),
            labelled(taken, symbols),
        )

    def _teller(self, place: int, answer: Answers) -> Hit:
        """Return a hit of which the engine knows the frames alone."""
        if place not in self._tellers:
            self._tellers = {
                place: plain.Teller(self._query, *self._fetched[place], self._tolerance)
            }
        parts = self._parts[int(answer.parts[0])]
        first = frozenset(zip(parts, answer.rows[0].tolist(), strict=False))
        hit = self._tellers[place].hit(first)
        if hit is None or hit.span != Span(int(answer.low[0]), int(answer.high[0])):
            raise LanindexError(
                f"the two ways to search differ about frame {int(answer.low[0])}",
                place=self._fetched[place][0].path,
                remedy="Please report this pattern.",
            )
        return hit

    def _check(self, place: int, capture: Capture, tracks: Mapping[str, Track]) -> None:
        """Refuse to tell a hit from other symbols than it was found in."""
        for part, columns in self._columns.items():
            rows = slice(*columns.bounds[place : place + 2].tolist())
            now = columns_of(part, [capture], [tracks.get(part)])
            if not all(
                np.array_equal(getattr(now, name), getattr(columns, name)[rows])
                for name in ("cell", "margin", "start", "stop")
            ):
                raise LanindexError(
                    f"the symbols of {part} are others than when it was searched",
                    place=capture.path,
                    remedy="Search again.",
                )

    def _possible(self) -> Whole:
        """Return the captures that can have a hit, as far as it is asked."""
        every = np.arange(len(self._roster))
        if len(every) < MANY:
            return every
        narrowing = Narrowing(self._columns, self._block(every))
        return np.flatnonzero(narrowing.possible(self._programs))

    def _block(self, places: Whole) -> Block:
        """Return some captures as a block."""
        return Block(self._roster, self._columns, places, self._tolerance)

    def _among(self, places: Whole, watch: Watch | None) -> tuple[Answers, Whole]:
        """Return all answers in some captures, and those captures of which nothing is known."""
        if watch:
            watch(int(places[0]), len(self._roster))
        try:
            answers, doubtful = self._in_block(self._block(places), places, watch)
        except TooMuch:  # at once: fewer captures are tried, and one alone plainly
            if len(places) == 1:
                return joined([]), places
            halves = [self._among(half, watch) for half in np.array_split(places, 2)]
            return joined([it for it, _ in halves]), np.concatenate([it for _, it in halves])
        answers.capture = places[answers.capture]
        return answers, places[doubtful]

    def _in_block(self, block: Block, here: Whole, watch: Watch | None) -> tuple[Answers, Mask]:
        """Return all answers in a block, and the captures of which nothing is known yet."""
        found: list[Answers] = []
        doubtful = np.zeros(len(block), bool)
        source = Source(self._recordings, here, block, self._programs)
        tick = self._tick(int(here[0]), watch)
        for number, program in enumerate(self._programs):
            setting = Setting(block, self._asked, source, tick)
            try:
                found += answers_of(setting, number, program, self._parts)
            except NotCovered:
                doubtful |= possible(block, program)
        every = joined(found)
        if doubtful.any():
            every = every.at(~doubtful[every.capture])
        return own_rows(best(every), self._parts, lambda part: block.rows(part).bounds), doubtful

    def _in_those_asked_for(self, answers: Answers) -> Answers:
        """Return the answers in captures that are as conditions on the capture alone ask."""
        if not self._asked.of_capture or not len(answers):
            return answers
        places = np.unique(answers.capture).tolist()
        for first in range(0, len(places), MANY):
            some = [it for it in places[first : first + MANY] if it not in self._meet]
            for place, capture in zip(some, self.captures(some), strict=True):
                hit = Hit(capture, Span(0, 0), 1.0, ())
                self._meet[place] = all(holds(it, hit) for it in self._asked.of_capture)
        meet = np.array([self._meet[place] for place in places])
        return answers.at(np.isin(answers.capture, np.array(places)[meet]))

    def _kept(self, answers: Answers, overlaps: str) -> Whole:
        """Return which answers are hits."""
        kept, where = np.arange(len(answers)), (answers.capture, answers.low, answers.high)
        if overlaps == "all":
            return kept
        if not counts(self._query.pattern):
            kept = np.flatnonzero(staying.nearest(*where))
        return kept[staying.from_left(*(column[kept] for column in where))]

    def _told_plainly(self, places: Whole, watch: Watch | None) -> dict[int, list[Hit]]:
        """Return what the plain matcher finds in some captures, overlapping or not."""
        told = {}
        for first in range(0, len(places), TOGETHER):
            some = places[first : first + TOGETHER].tolist()
            recordings = self._recordings(some, self._query.parts)
            for place, recording in zip(some, recordings, strict=True):
                tick = self._tick(place, watch)
                tick()
                found = plain.find(
                    *(self._query, [recording]),
                    tolerance=self._tolerance,
                    overlaps="all",
                    tick=tick,
                )
                told[place] = list(found)
        return told

    def _tick(self, place: int, watch: Watch | None) -> Callable[[], None]:
        """Return what tells that the search is still at a capture."""
        many = len(self._roster)
        return partial(watch, place, many) if watch else lambda: None


def _columns_of(place: int, hits: list[Hit]) -> Answers:
    """Return the hits of a capture as columns."""
    nothing = np.full(len(hits), -1)
    own = np.stack((np.arange(len(hits)), nothing), axis=1)  # which hit of the capture it is
    return Answers(
        np.full(len(hits), place),
        np.array([hit.span.start for hit in hits], np.int64),
        np.array([hit.span.stop for hit in hits], np.int64),
        np.array([round((1 - hit.fit) * THOUSANDTHS) for hit in hits], np.int64),
        *(nothing, nothing, own),
    )


def _symbol(track: Track, row: int) -> Symbol:
    (symbol,) = listed(track.part, track.symbols[row : row + 1])
    return replace(symbol, ordinal=row)
