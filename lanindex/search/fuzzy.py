"""Search that forgives: symbols and steps have costs, and the cheapest matches are the best hits.

Up to half a cell beside the middle of the wanted direction costs nothing; beyond that each width of
a cell costs an edit. The page of `lanindex.search` follows a line, key by key, under "With costs".
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LanindexError, UsageError
from lanindex.model import Capture, Hit, Span, Symbol
from lanindex.model.columns import CELL, THOUSANDTHS, Columns, Roster, ranges
from lanindex.search.hits import Found, Hits
from lanindex.search.language import query as tree
from lanindex.search.language.words import BESIDE_CELLS, WORD_KINDS
from lanindex.search.limits import OverBudget, tick
from lanindex.search.match import relations
from lanindex.search.match.arrays import (
    FAR,
    AnyArray,
    BoolArray,
    IntArray,
    best_of_each,
    in_pieces,
    once,
    smallest_in,
)
from lanindex.search.match.batch import Batch, cells_of, unavoidable
from lanindex.search.match.finder import Finder, Watch
from lanindex.search.match.hits import ExactHits, staying
from lanindex.search.match.relations import RELATIONS, Margins, SpanIndex, Spans, margins_of
from lanindex.search.plan import NEGATIONS, Companion, Program, State, plan
from lanindex.search.sphere import KNOWN, MIDDLES, points_of

Costs = NDArray[np.int16]

UNIT = 64  # parts of an edit in which costs are counted, so that equal ones are equal
WIDTH, ALLOWED = 45.0, 22.5  # degrees: from one cell to the next, and what costs nothing
DRAWN_IN = 60.0  # degrees between a direction and place mid
MOST = 2 * UNIT  # what a symbol costs at most: more than to leave out the step and pass over it
CHANGE = UNIT  # what a change of level costs that is not the one asked for
NEVER = 30000  # what a symbol costs that no edit makes a match
BUCKETS = 16  # steps of the margin
CARRYING = 2  # steps that a share of edits is not given for: without them nothing is left

MISSING = UNIT  # what a step costs that is missing
BETWEEN = UNIT // 4  # the same, where the step lies on the way from the one before to the next
OVER = np.array([0, BETWEEN]).reshape(2, 1, 1, 1)  # the same by whether an edge leads over a step
SKIPPED = UNIT // 2  # what a shown symbol costs between two steps joined by ->
MOST_STEPS = 40  # of a line that can be followed: the work grows with their number
IMPOSSIBLE = 1 << 14  # what it costs to begin or end where a line cannot: more than any match
FREE, NEXT, LATER = range(3)  # a line lies anywhere, right at a clip's start or end, or apart

COST, FIRST = 32, 10  # the lowest bits of a key's cost and of its beginning; below, the blur
BLUR, LATEST = (1 << FIRST) - 1, (1 << COST - FIRST) - 1  # the bits of the blur, the latest start
NOTHING = 1 << 62  # the key where no match stands


@dataclass(frozen=True, slots=True)
class Allowance:
    """How much a match may differ from its pattern.

    Examples
    --------
    >>> from lanindex.search.fuzzy import Allowance
    >>> Allowance.read("2").of(5), Allowance.read("20%").of(7)
    (128, 64)
    """

    edits: Fraction  # in all, or as a share for each step but the first `CARRYING`
    share: bool = False

    @classmethod
    def read(cls, text: str) -> Allowance:
        """Return what ``2``, ``0.5`` or ``20%`` means; a `UsageError` where it is none of these."""
        number = text.strip().removesuffix("%")
        share = number != text.strip()
        if not number.replace(".", "", 1).isdecimal() or len(number) > 9:
            raise UsageError(f'"{text}" edits', wanted="a number of edits, 2, or a share, 20%")
        return cls(Fraction(number) / (100 if share else 1), share)

    def of(self, steps: int) -> int:
        """Return how much a pattern of so many steps may cost, in parts of an edit."""
        edits = self.edits * max(steps - CARRYING, 0) if self.share else self.edits
        return int(edits * UNIT)


def angles(vectors: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angles between (N, 3) and (M, 3) vectors: (N, M) degrees.

    Between a vector of no length and another one it is `DRAWN_IN`.
    """
    one, other = np.linalg.norm(vectors, axis=1)[:, None], np.linalg.norm(others, axis=1)
    cosine = vectors @ others.T / np.maximum(one * other, 1e-12)
    found = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    found = np.where((one < 1e-6) ^ (other < 1e-6), DRAWN_IN, found)
    return np.where((one < 1e-6) & (other < 1e-6), 0.0, found)


class Kinds:
    """The symbols of a part by kind: those of a kind have cell, runner-up and margin in common."""

    code: AnyArray  # (S,) which kind each symbol is of
    counts: IntArray  # (K,) how many symbols are of each kind
    bucket: IntArray  # (K,) the step of their margin

    def __init__(self, columns: Columns) -> None:
        numbers = (columns.cell & CELL).astype(np.int32)
        numbers *= CELL + 1
        numbers += columns.runner & CELL
        numbers *= BUCKETS + 1
        numbers += np.minimum(columns.margin, THOUSANDTHS).astype(np.int32) * BUCKETS // THOUSANDTHS
        counts = np.bincount(numbers)
        known = np.flatnonzero(counts)
        places = np.zeros(len(counts), np.min_scalar_type(len(known)))
        places[known] = np.arange(len(known))
        self.code = places[numbers]
        self.counts, self.bucket = counts[known], known % (BUCKETS + 1)
        self._cell, self._runner = np.divmod(known // (BUCKETS + 1), CELL + 1)
        turned = angles(points_of(self._cell, self._runner, self.bucket / BUCKETS), MIDDLES)
        costs = np.rint(np.maximum(turned - ALLOWED, 0) / WIDTH * UNIT)
        directed = KNOWN[self._cell][:, None] & KNOWN
        # (K, cells) what each kind costs where a cell is asked for
        self._turns = np.where(directed, np.minimum(costs, MOST), MOST).astype(np.int16)
        self._bounds = columns.bounds

    def table(self, state: State) -> Costs:
        """Return what each kind costs as what a state asks for: (K,), changes left out."""
        wanted = cells_of(state, 0)[: CELL + 1]
        table = self._turns[:, wanted].min(axis=1, initial=MOST)
        near = wanted[self._runner] & (self.bucket * THOUSANDTHS < state.near * BUCKETS)
        return np.where(wanted[self._cell] | near, np.int16(0), table)

    def fit(self, state: State) -> NDArray[np.float64]:
        """Return more steps of a fit than each kind has where it costs nothing, (K,)."""
        near = state.near * BUCKETS / THOUSANDTHS
        own = cells_of(state, 0)[: CELL + 1][self._cell]
        inside = near + np.where(own, self.bucket, -self.bucket) + 1
        found: NDArray[np.float64] = inside * BUCKETS / (near + BUCKETS)
        return found

    def having(self, kinds: BoolArray) -> BoolArray:
        """Return which captures have a symbol of some kinds, (captures,)."""
        by_kind, ends = self._by_kind
        _, places = ranges((ends - self.counts)[kinds], ends[kinds])
        found = np.zeros(len(self._bounds) - 1, np.bool_)
        found[by_kind[places]] = True
        return found

    @cached_property
    def _by_kind(self) -> tuple[NDArray[np.int32], IntArray]:
        """The captures of all symbols, those of a kind together, and where each kind ends."""
        captures = np.arange(len(self._bounds) - 1, dtype=np.int32)
        order = np.argsort(self.code, kind="stable")
        return np.repeat(captures, np.diff(self._bounds))[order], np.cumsum(self.counts)


def costs_of(state: State, costs: Costs, batch: Batch, row: IntArray) -> Costs:
    """Return what rows (R,) cost at a state, of which `costs` (R,) are those of their kinds."""
    rows = batch.rows(state.members[0])
    if "change" in state.fits[0]:
        neither = WORD_KINDS["change"].codes["neither"]
        change = np.where(rows.change[row] < 0, neither, rows.change[row])
        wrong = ~np.isin(change, list(state.fits[0]["change"]))
        costs = np.minimum(costs + wrong * np.int16(CHANGE), np.maximum(costs, MOST))
    if state.length:
        start, stop = rows.start[row].astype(np.int64), rows.stop[row].astype(np.int64)
        lasts = batch.meets(rows.capture[row].astype(np.int64), stop - start, state.length)
        costs = np.where(lasts & (start < stop), costs, np.int16(NEVER))
    return np.where(rows.passing[row], np.int16(NEVER), costs) if state.manner == "at" else costs


def blur_of(state: State, cell: AnyArray, cost: AnyArray) -> IntArray:
    """Return what rows (R,) lack to a fit of 1 at a state, from what they lack in their cells."""
    margin = THOUSANDTHS - cost.astype(np.int64)
    inside = state.near + np.where(cells_of(state, 0)[cell], margin, -margin)  # of the border
    found: IntArray = np.maximum(inside, 0) * THOUSANDTHS // (state.near + THOUSANDTHS)
    return THOUSANDTHS - found


class Net:
    """A line, of one of the parts that move in it: its K states, and what joins them."""

    def __init__(self, program: Program, member: int) -> None:
        self.number = 0  # of the line in `FuzzyMatches`; a search counts its lines
        self.part = program.states[0].members[member]
        self.states = [
            replace(state, members=(self.part,), fits=(state.fits[member],))
            for state in program.states
        ]
        self.stays = self.states[0].manner == "at"  # asks where the part is, not where it goes
        # (2, 2, K, K) directly and over a step on the way, by -> and by ...: from which state one
        # comes to which
        self.edges = np.zeros((2, 2, len(self.states), len(self.states)), np.bool_)
        for it in (edge for leaving in program.edges for edge in leaving):
            self.edges[0, int(it.arrow.later), it.exit.state, it.entry.state] = True
        nearest, joined = self.edges[0, 0], self.edges[0].any(axis=0)
        between, both_nearest = on_the_way(self.states, joined), nearest[:, :, None] & nearest
        self.edges[1] = [(between & it).any(axis=1) for it in (both_nearest, ~both_nearest)]
        # by state: over a step or not, by ... or ->, and from which states one comes to it
        self.before = [
            [(*it, own) for it in np.ndindex(2, 2) if (own := self.edges[*it, :, state]).any()]
            for state in range(len(self.states))
        ]
        # (K,) what leaving out each state costs at least
        self.least = np.where(between.any(axis=(0, 2)), BETWEEN, MISSING)
        self.branches = bool(joined.any())  # one match may go on in several: passing symbols, too
        back = np.tril(self.edges.any(axis=(0, 1)))
        self.back = np.flatnonzero(back.any(axis=1))  # where an open count goes back
        # (3, K) by FREE, NEXT, LATER: what the missing steps before each state cost, and behind it
        entries = [(it.state, it.from_start) for it in program.entries]
        exits = [(it.state, it.to_end) for leaving in program.exits for it in leaving]
        self.entry, self.exit = _missing(entries, joined), _missing(exits, joined.T)
        # states that every match stands at, but for missing steps
        self.needed = [state.number for state in unavoidable(program)]


def on_the_way(states: Sequence[State], joined: BoolArray) -> BoolArray:
    """Return over which steps people pass: (K, K, K) by the step before, that one and the next.

    Each of the three names one cell, the one between another than the others; the way by that is
    longer by less than the width of a cell.
    """
    cells = np.array([cells_of(state, 0)[: CELL + 1] for state in states])
    one, middles = cells.sum(axis=1) == 1, MIDDLES[cells.argmax(axis=1)]
    turned = angles(middles, middles)
    turns: BoolArray = joined & one & one[:, None] & (turned > 0)
    by_that = turned[:, :, None] + turned
    return turns[:, :, None] & turns & (by_that < turned[:, None] + WIDTH)


def _missing(ends: Sequence[tuple[int, tuple[tree.Arrow, ...]]], joined: BoolArray) -> IntArray:
    """Return what it costs to leave out all steps between each state and an end: (3, K)."""
    costs = np.full((3, len(joined)), IMPOSSIBLE)
    for state, arrows in ends:
        near = LATER if all(arrow.later for arrow in arrows) else NEXT
        costs[near if arrows else FREE, state] = 0
    step = np.where(joined, MISSING, IMPOSSIBLE)
    for _ in joined:
        costs = np.minimum(costs, np.min(costs[:, :, None] + step, axis=1))
    return costs


def nets_of(program: Program) -> list[Net]:
    """Return a program as nets, one a part that moves; a `UsageError` where it has no edits."""
    states = program.states
    edges = [edge for leaving in program.edges for edge in leaving]
    ends = [arrow for entry in program.entries for arrow in entry.from_start]
    ends += [arrow for leaving in program.exits for it in leaving for arrow in it.to_end]
    arrows = [edge.arrow for edge in edges] + ends
    stays = len(states) == 1 and states[0].manner == "at" and states[0].length is None
    stays = stays and not ends and len(states[0].members) == 1
    cannot = {
        "brackets with a length or a line beside them": any(
            group.length or group.companions for group in program.brackets
        ),
        '"overlapping"': any(it.relation == "overlapping" for it in program.outermost.companions),
        '"hold", "still", and "at" beside other steps or with a length': not stays
        and any(state.manner in ("at", "hold") for state in states),
        "the feet of a jump, degrees of turns and bends, what is touched or carries, "
        "and how fast or large a movement is": not {*BESIDE_CELLS}.isdisjoint(
            kind for state in states for fits in state.fits for kind in fits
        ),
        "arrows to another part": any(not edge.same for edge in edges),
        "limits on an arrow": any(arrow.length or arrow.skips for arrow in arrows),
    }
    for what, found in cannot.items():
        if found:
            raise UsageError(
                f"a fuzzy search cannot count edits in {what}",
                remedy="Leave that out, or search without --fuzzy.",
            )
    if len(states) > MOST_STEPS:
        raise UsageError(
            f"a fuzzy search for {len(states)} steps in a row",
            wanted=f"{MOST_STEPS} at most",
            remedy="Look for a shorter piece of it, or search without --fuzzy.",
        )
    return [Net(program, member) for member in range(len(states[0].members))]


class Symbols(NamedTuple):
    """R symbols that a line of K states is followed over, in order."""

    stretch: AnyArray  # (R,) in which stretch of known frames each lies
    costs: AnyArray  # (K, R) what each costs at each state
    blur: AnyArray  # (K, R) what each lacks to a fit of 1 at each state, in thousandths
    # (2, R) over -> and ...: keys of what it costs to pass over all before each, and over that one;
    # from one stretch to the next it is more than a match may cost
    before: IntArray
    behind: IntArray
    entry: IntArray  # (K, R) keys of matches that begin with each, but for what that one costs
    exit: IntArray  # (K, R) keys of what it costs to end with each


class FuzzyMatches(NamedTuple):
    """N matches of a line, or of L lines beside each other."""

    capture: IntArray  # (N,) places in a batch, or in the roster
    low: IntArray  # (N,) frames, half-open
    high: IntArray
    cost: IntArray  # (N,) parts of an edit
    blur: IntArray  # (N,) what the symbols that fit lack to a margin of 1, in thousandths
    # (N, L, 5) by line, the leading one first: its number, the first and the last row, counted in
    # the capture, and its frames; -1: there is no such line
    line_rows: IntArray

    def at(self, rows: AnyArray | slice) -> FuzzyMatches:
        """Return some of them."""
        return FuzzyMatches._make(column[rows] for column in self)


_NONE = np.empty(0, np.int64)
NO_MATCHES = FuzzyMatches(_NONE, _NONE, _NONE, _NONE, _NONE, np.empty((0, 1, 5), np.int64))


def joined(matches: Sequence[FuzzyMatches]) -> FuzzyMatches:
    """Return several tables as one."""
    lines = max(it.line_rows.shape[1] for it in matches)
    more = [((0, 0), (0, lines - it.line_rows.shape[1]), (0, 0)) for it in matches]
    wide = map(partial(np.pad, constant_values=-1), (it.line_rows for it in matches), more)
    *columns, _ = zip(*matches, strict=True)
    return FuzzyMatches(*map(np.concatenate, (*columns, list(wide))))


class FuzzyLine:
    """A line to be searched for, where a match costs no more than `most` parts of an edit.

    Symbols that cost nothing have a margin of `clear` of `BUCKETS` steps at least.
    """

    def __init__(self, net: Net, columns: Columns, most: int, clear: int = 0) -> None:
        self.net, self._bounds = net, columns.bounds
        self._most = min(most, (MOST + MISSING) * len(net.states))
        if __name__ not in columns.kept:
            columns.kept[__name__] = Kinds(columns)
        kinds: Kinds = columns.kept[__name__]
        self._kinds = kinds
        self._tables = [kinds.table(state) for state in net.states]
        for state, table in zip(net.states, self._tables, strict=True):
            if "change" not in state.fits[0] or self._most < CHANGE:
                table[(table == 0) & (kinds.fit(state) <= clear) & (clear > 0)] = NEVER
        self._told: tuple[Batch, int, Symbols] | None = None  # the capture that was told last
        self._able = np.any([table <= self._most for table in self._tables], axis=0)

    def possible(self) -> BoolArray:
        """Return which captures have a symbol for enough of the steps it needs, (captures,)."""
        lacking = np.zeros(len(self._bounds) - 1, np.int64)
        for state in self.net.needed:
            fits = self._tables[state] <= self._most
            if 8 * self._kinds.counts[fits].sum() < len(self._kinds.code):  # else most have one
                lacking += ~self._kinds.having(fits) * self.net.least[state]
        found: BoolArray = lacking <= self._most
        return found

    def matches(self, batch: Batch) -> FuzzyMatches:
        """Return the cheapest match from each symbol."""
        rows = batch.rows(self.net.part)
        code = rows.of_rows(self._kinds.code)
        row = np.flatnonzero(self._able[code])
        symbols = self._symbols(batch, row, code[row])
        arrived, _ = followed(self.net, symbols, self._most)
        keys = np.min(arrived + symbols.exit, axis=0)
        ends = np.flatnonzero(keys >> COST <= self._most)
        keys = keys[ends]
        cost, first, last = keys >> COST, row[LATEST - (keys >> FIRST & LATEST)], row[ends]
        frames = rows.start[first], rows.stop[last]
        if self.net.stays:
            frames = rows.arrival[first], rows.until(last)
        capture, start, until = (it.astype(np.int64) for it in (rows.capture[first], *frames))
        number, base = np.full(len(keys), self.net.number), rows.bounds[capture]
        line_rows = np.stack((number, first - base, last - base, start, until), axis=1)[:, None]
        best = best_of_each((first,), (cost, until))
        best = best[start[best] < until[best]]  # a starting position alone is no match
        return FuzzyMatches(capture, start, until, cost, keys & BLUR, line_rows).at(best)

    def _symbols(self, batch: Batch, row: IntArray, code: AnyArray) -> Symbols:
        """Return some rows of a batch, each of a kind, as symbols."""
        rows, net = batch.rows(self.net.part), self.net
        stretch = rows.stretch[row]
        pairs = zip(net.states, self._tables, strict=True)
        costs = np.stack([costs_of(state, table[code], batch, row) for state, table in pairs])

        def passed(at: IntArray, end: IntArray) -> IntArray:
            """Return what it costs to get from the first row to some, and past others."""
            apart = (rows.stretch[at] - rows.stretch[row[:1]]).astype(np.int64) * (self._most + 1)
            shown = (rows.rank[end] - rows.rank[row[:1]]).astype(np.int64)
            return np.stack((apart + SKIPPED * shown, apart))

        before, behind = passed(row, row), passed(row, row + 1)
        if len(row) > LATEST + 1 or int(behind.max(initial=0)) << COST >= NOTHING:
            raise OverBudget  # keys have no room for so many symbols
        entry, leave = net.entry[FREE, :, None], net.exit[FREE, :, None]
        if min(net.entry[NEXT:].min(), net.exit[NEXT:].min()) < IMPOSSIBLE:
            capture = rows.capture[row]
            first, last = rows.bounds[capture], rows.bounds[capture + 1] - 1
            start = before - passed(first, first + rows.starting[first])
            start[:, rows.starting[row] | (rows.stretch_begin[stretch] > 0)] = IMPOSSIBLE
            end = passed(last, last + 1) - behind
            end[:, rows.stretch_end[stretch] < batch.frames[capture]] = IMPOSSIBLE
            entry = np.minimum(entry, np.min(net.entry[NEXT:, :, None] + start[:, None], axis=0))
            leave = np.minimum(leave, np.min(net.exit[NEXT:, :, None] + end[:, None], axis=0))
        entry = (entry << COST) + (LATEST - np.arange(len(row)) << FIRST)
        leave = np.broadcast_to(leave << COST, costs.shape)
        blur = np.stack([blur_of(state, rows.cell[row], rows.cost[row]) for state in net.states])
        return Symbols(stretch, costs, blur, before << COST, behind << COST, entry, leave)

    def rows(self, batch: Batch, capture: int, first: int, last: int) -> list[tuple[int, int]]:
        """Return the rows, counted in their capture, and the states of the best match of a span."""
        told = self._told  # another thread may tell another capture meanwhile
        if not told or told[:2] != (batch, capture):
            begin, end = batch.rows(self.net.part).bounds[capture : capture + 2].tolist()
            code = self._kinds.code[self._bounds[batch.places[capture]] :][: end - begin]
            told = self._told = batch, capture, self._symbols(batch, np.arange(begin, end), code)
        symbols = Symbols._make(it[..., first : last + 1] for it in told[2])
        entry = np.full_like(symbols.entry, NOTHING)
        entry[:, 0] = symbols.entry[:, 0]
        symbols = symbols._replace(entry=entry)
        arrived, gone = followed(self.net, symbols, self._most)
        state, at = int((arrived[:, -1] + symbols.exit[:, -1]).argmin()), last - first
        path = [(last, state)]
        while at:
            end, passed, over = at, symbols.before, OVER << COST
            while end:
                came = gone[:, :end] + (passed[:, at, None] - symbols.behind[:, :end])[:, None]
                edges = self.net.edges[: len(over), :, :, state, None]
                came = np.where(edges, came + over, NOTHING).min(axis=(0, 1)).T
                at, state = (int(it) for it in np.unravel_index(came.argmin(), came.shape))
                missing = arrived[state, at] > gone[state, at]
                end, passed, over = missing * (at + 1), symbols.behind, over[:1]
            path.append((first + at, state))
        return path[::-1]


def followed(net: Net, symbols: Symbols, most: int) -> tuple[IntArray, IntArray]:
    """Return keys of the best match at each state with each symbol, or `NOTHING`: (K, R), twice.

    The first are of matches that stand there, the second also of those that left out the state.
    """
    arrived, gone = _once(net, symbols, most, np.full(symbols.entry.shape, NOTHING))
    left, better = np.arange(len(symbols.stretch)), (gone[net.back] < NOTHING).any(axis=0)
    while better.any():  # once more where a step that may come again stands better than before
        tick()
        stretch = symbols.stretch[left]
        left = left[np.isin(stretch, stretch[better])]
        some, before = Symbols._make(it[..., left] for it in symbols), gone[:, left]
        arrived[:, left], gone[:, left] = _once(net, some, most, before)
        better = (gone[:, left] < before)[net.back].any(axis=0)
    return arrived, gone


def _once(net: Net, symbols: Symbols, most: int, gone: IntArray) -> tuple[IntArray, IntArray]:
    """Return the same as `followed`, going on from what is behind each state so far."""
    arrived, gone, limit = np.empty_like(gone), gone.copy(), most + 1 << COST
    for state in range(len(net.states)):
        keys, waiting = symbols.entry[state].copy(), np.full(gone.shape[1], NOTHING)
        for over, later, before in net.before[state]:
            came = np.min(gone[before], axis=0) - symbols.behind[later]
            np.minimum.accumulate(came, out=came)
            ahead = came[:-1] + symbols.before[later, 1:] + (over * BETWEEN << COST)
            np.minimum(keys[1:], ahead, out=keys[1:])
            if not over:
                np.minimum(waiting, came + symbols.behind[later], out=waiting)
        costs = symbols.costs[state]
        keys += costs.astype(np.int64) << COST
        keys = np.maximum(keys, keys & ~BLUR | np.where(costs == 0, symbols.blur[state], 0))
        arrived[state] = np.where(keys < limit, keys, NOTHING)
        waiting = np.where(waiting < limit, waiting + (MISSING << COST), NOTHING)
        gone[state] = np.minimum(arrived[state], waiting)
    return arrived, gone


# Hits.

FITS = (15, 12, 8, 4)  # in steps: fits down to which the best hits are looked for in turn
MORE = 4  # captures that are tried at first for each hit that is wanted

NOBODY = 1 << 62  # the place of a match where there is none

ExactSearch = Callable[[tree.Query, IntArray], ExactHits]
"""Searches exactly, in some captures of the roster."""


def find(
    finder: Finder,
    allowance: Allowance,
    overlaps: str = "none",
    watch: Watch | None = None,
    best: int | None = None,
    refused: list[LanindexError] | None = None,
    found: Found | None = None,
) -> FuzzyHits:
    """Find what is nearly the query of a finder; a `UsageError` where that has no edits.

    The other parameters are those of `Finder.find`, but that overlaps ``none`` means the match that
    differs least of those that share frames. Hits come by capture, start and end, where they are
    not the best. The fit of hits without an edit is half the smallest margin of their symbols above
    1/2; of others half that of the symbols without an edit, lowered in proportion to the edits.
    """
    search = FuzzySearch(finder, plans_of(finder.query, allowance), overlaps, found=found)
    with finder.searching(watch, refused):
        if any(one.branches for one in search.plans):
            search.exact_hits = search.find_exactly(finder.query)
            hits = search.all_hits()
            return hits if best is None else hits.by_fit(best)[:best]
        return search.all_hits() if best is None else search.best(best)


def plans_of(query: tree.Query, allowance: Allowance) -> list[FuzzyPlan]:
    """Return the plans of a query; a `UsageError` where it has no edits."""
    if query.rhythm or query.where:
        raise UsageError(
            'a fuzzy search cannot count edits in "where" and "rhythm"',
            remedy="Leave them out, or search without --fuzzy.",
        )
    opened = [lines for pattern in query.patterns for lines in _opened(pattern).alternatives]
    plans = [
        FuzzyPlan.of(program, lines, allowance)
        for lines in dict.fromkeys(opened)
        for program in plan(replace(tree.query_of(lines), near=query.near))
    ]
    for number, net in enumerate(net for one in plans for net in one.nets):
        net.number = number
    return plans


def _opened(pattern: tree.Choice) -> tree.Choice:
    """Return a pattern without brackets around all of it, such as a pasted score has."""
    opened: list[tree.Lines] = []
    for lines in pattern.alternatives:
        unit = lines.first.items[0].unit
        if isinstance(unit, tree.Bracket) and lines.first == tree.Line((tree.Item(unit),)):
            opened += [
                tree.Lines(inner.first, (*inner.others, *lines.others))
                for inner in _opened(unit.pattern).alternatives
            ]
        else:
            opened.append(lines)
    return tree.Choice(tuple(opened))


@dataclass
class FuzzySearch:
    """A search for some plans; `finder` holds the captures, `exact_hits` are exact hits to add."""

    finder: Finder
    plans: list[FuzzyPlan]
    overlaps: str
    exact_hits: ExactHits | None = None
    found: Found | None = None

    @property
    def roster(self) -> Roster:
        """The captures."""
        return self.finder.roster

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the roster."""
        return self.finder.captures(places)

    @cached_property
    def lines(self) -> list[FuzzyLine]:
        """All lines by their numbers."""
        plans = [one.within(self.finder.columns, one.most) for one in self.plans]
        return [line for one in plans for sides in one.lines for line in sides]

    def hits(self, matches: FuzzyMatches, fit: NDArray[np.float64]) -> list[Hit]:
        """Return matches as objects, of which each fits so well, (N,)."""
        places = once(matches.capture)
        fetched = self.finder.fetched(places.tolist())
        batch, hits = self.finder.batch(places), list[Hit]()
        listed: dict[tuple[int, str], list[Symbol]] = {}
        for index, line_rows in enumerate(matches.line_rows.tolist()):
            if self.exact_hits and line_rows[0][0] == len(self.lines):
                hits.append(replace(self.exact_hits[line_rows[0][1]], fit=float(fit[index])))
                continue
            place, matched = int(matches.capture[index]), []
            capture, tracks = fetched[place]
            for number, first, last, *_ in (it for it in line_rows if it[0] >= 0):
                line, part = self.lines[number], self.lines[number].net.part
                if (place, part) not in listed:
                    listed[place, part] = tracks[part].listed()
                rows = line.rows(batch, int(np.searchsorted(places, place)), first, last)
                matched.append(tuple(listed[place, part][row] for row, _ in rows))
            span = Span(int(matches.low[index]), int(matches.high[index]))
            hits.append(Hit(capture, span, float(fit[index]), tuple(matched)))
        return hits

    def find_exactly(self, query: tree.Query, among: IntArray | None = None) -> ExactHits:
        """Return all exact hits, in some captures; None: in all."""
        finder = self.finder.of(query)
        found = finder.find("all", lambda *_: self.finder.tell(), refused=[], among=among)
        self.finder.refused |= finder.refused
        return found

    def all_hits(self) -> FuzzyHits:
        """Return all hits."""
        plans, pieces, hits = self._plans_within(BUCKETS), [NO_MATCHES], list[FuzzyHits]()
        for matches in self._hits_in(plans, self._possible(plans)):
            pieces.append(matches)
            hits.append(FuzzyHits(self, matches))
            if self.found:
                self.found(hits)
        return FuzzyHits(self, self._without_refused(joined(pieces)))

    def best(self, number: int) -> FuzzyHits:
        """Return so many hits that fit best, the clearest first.

        The clearest are looked for first, in the captures that can have such: at first in a few for
        each hit wanted, then in those whose bound reaches the last of the best so far.
        """
        for fit in FITS:
            edits, clear = max(BUCKETS - 2 * fit, 0), max(2 * fit - BUCKETS, 0)
            plans = self._plans_within(edits, clear)
            bounds = np.zeros(len(self.finder.roster))
            likely = self._possible(plans)
            for places, most in self.finder.in_batches(partial(self._bounds, plans), likely):
                bounds[places] = most
            order = np.flatnonzero(bounds)
            order = order[np.argsort(-bounds[order], kind="stable")]
            plans, matches = self._plans_within(edits), NO_MATCHES
            least, searched, within = 0.0, 0, len(order)
            while within:  # captures that may hold one of the best
                some = order[searched : searched + min(within, searched or MORE * number)]
                matches = joined((matches, *self._hits_in(plans, np.sort(some))))
                matches = self._without_refused(matches)
                matches = matches.at(np.argsort(matches.capture, kind="stable"))
                best = FuzzyHits(self, matches).by_fit()[:number]
                if self.found:
                    self.found([best.at(np.argsort(best.place, kind="stable"))])
                searched += len(some)
                rest = order[searched:]
                within = len(rest)
                if len(best) == number:
                    least, last = float(best.fit[-1]), best.place[-1]
                    ahead = (bounds[rest] > least) | (bounds[rest] == least) & (rest < last)
                    within = int(ahead.sum())
            if least >= fit / BUCKETS:
                return best
        return self.all_hits().by_fit()[:number]

    def _plans_within(self, most: int, clear: int = 0) -> list[FuzzyPlan]:
        """Return the plans for matches that fit well enough, in steps of a margin less than 1."""
        limit = UNIT * most // BUCKETS
        return [it.within(self.finder.columns, it.steps * limit, clear) for it in self.plans]

    def _possible(self, plans: list[FuzzyPlan]) -> IntArray:
        """Return the captures in which any of some plans may match."""
        return np.flatnonzero(np.any([one.possible() for one in plans], axis=0))

    def _bounds(self, plans: list[FuzzyPlan], places: IntArray) -> AnyArray:
        """Return how well a match of any plan fits at most in some captures, (captures,)."""
        batch = self.finder.batch(places)
        bounds: AnyArray = np.max([one.bounds(batch) for one in plans], axis=0)
        return bounds

    def _hits_in(self, plans: list[FuzzyPlan], places: IntArray) -> Iterator[FuzzyMatches]:
        """Yield the hits in some captures."""
        for _, matches in self.finder.in_batches(partial(self._hits, plans), places):
            yield self._without_refused(matches)

    def _without_refused(self, matches: FuzzyMatches) -> FuzzyMatches:
        return matches.at(~np.isin(matches.capture, list(self.finder.refused)))

    def _hits(self, plans: list[FuzzyPlan], places: IntArray) -> FuzzyMatches:
        """Return the hits of plans in a batch of captures, by capture, start and end."""
        batch = self.finder.batch(places)
        sets = [one.matches(batch, self.find_exactly) for one in plans]
        sets = [it._replace(capture=places[it.capture]) for it in sets]
        if self.exact_hits is not None:
            sets.append(self._exact_matches(self.exact_hits, joined(sets), places))
        matches = joined(sets)
        if len(sets) > 1:
            parts = [one.sides[0][0].part for one in plans]
            of_each = [*map(parts.index, parts), len(parts)][: len(sets)]
            part = np.repeat(of_each, [len(it.cost) for it in sets])
            keys = part, matches.capture, matches.line_rows[:, 0, 1]
            matches = matches.at(best_of_each(keys, (matches.cost, matches.high, -matches.low)))
        if self.overlaps == "none":
            rank = np.empty(len(matches.cost), np.int64)
            rank[np.lexsort((-matches.low, matches.high, matches.cost))] = np.arange(len(rank))
            matches = matches.at(staying(matches.capture, matches.low, matches.high, rank))
        return matches.at(np.lexsort((matches.high, matches.low, matches.capture)))

    def _exact_matches(
        self, exact: ExactHits, matches: FuzzyMatches, places: IntArray
    ) -> FuzzyMatches:
        """Return the exact hits of some captures where no match that costs nothing begins."""
        begun = (matches.capture * FAR + matches.low)[matches.cost == 0]
        own = np.isin(exact.place, places) & ~np.isin(exact.place * FAR + exact.low, begun)
        indices = np.flatnonzero(own)
        line_rows = np.full((len(indices), 1, 5), len(steps_of(self.plans)))
        line_rows[:, 0, 1] = indices  # the number behind all lines, and for a first row the place
        frames = exact.place[indices], exact.low[indices], exact.high[indices]
        return FuzzyMatches(*frames, 0 * indices, 0 * indices, line_rows)


class Maker(Protocol):
    """Makes objects of what a search for some plans found in the captures of a roster."""

    plans: list[FuzzyPlan]
    exact_hits: ExactHits | None

    @property
    def roster(self) -> Roster:
        """The captures."""

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the roster."""

    def hits(self, matches: FuzzyMatches, fit: NDArray[np.float64]) -> list[Hit]:
        """Return matches as objects, of which each fits so well, (N,)."""


class FuzzyHits(Hits):
    """The hits of a search as columns; each is made an object when it is asked for."""

    def __init__(self, maker: Maker, matches: FuzzyMatches) -> None:
        columns = matches.capture, matches.low, matches.high
        super().__init__(maker.captures, maker.roster.number, *columns)
        self._maker, self._matches = maker, matches

    @cached_property
    def fit(self) -> NDArray[np.float64]:
        """As `fits` says."""
        steps, found = np.array([*steps_of(self._maker.plans), 1]), self._matches
        fit: NDArray[np.float64] = fits(found.cost, found.blur, steps[found.line_rows[:, 0, 0]])
        own, exact = self._exact_hits()
        fit[own] = (1 + exact.clear()) / 2 if exact else 0
        return fit

    def clear(self) -> NDArray[np.float64]:
        """Return how clear each hit is, (H,) from 0 to 1."""
        return self.fit

    def by_fit(self, most: int | None = None) -> FuzzyHits:
        """Return the same hits, the clearest first; as `Hits.by_fit`."""
        own, exact = self._exact_hits()
        if not exact or most is None or most >= len(own):
            return super().by_fit()
        rest = np.delete(own, exact.clearest(most))  # of these nothing is made
        likely = np.delete(np.arange(len(self)), rest)
        likely = likely[np.argsort(-self._subset(likely).fit, kind="stable")]
        return self.at(np.append(likely, rest))

    def _exact_hits(self) -> tuple[IntArray, ExactHits | None]:
        """Return which hits were found exactly, by place, and as such."""
        number, place = self._matches.line_rows[:, 0, :2].T
        own = np.flatnonzero(number == len(steps_of(self._maker.plans)))
        exact = self._maker.exact_hits
        return own, exact.arranged(place[own].tolist()) if exact else None

    def _subset(self, rows: AnyArray | slice) -> FuzzyHits:
        return FuzzyHits(self._maker, self._matches.at(rows))

    def told(self) -> tuple[FuzzyMatches, ExactHits | None]:
        """Return the matches, and of the exact hits those that are among them."""
        own, exact = self._exact_hits()
        line_rows = self._matches.line_rows.copy()
        line_rows[own, 0, 1] = np.arange(len(own))
        return self._matches._replace(line_rows=line_rows), exact

    def _hits(self, indices: Sequence[int]) -> list[Hit]:
        some = np.array(indices, np.int64)
        return self._maker.hits(self._matches.at(some), self.fit[some])


class FuzzyPlan(NamedTuple):
    """What a leading line asks for."""

    sides: list[list[Net]]  # the leading line, and those that must lie beside it, one net a side
    beside: list[Companion]  # how these lie
    forbidden: list[tree.Beside]  # lines that must not happen
    steps: int  # how many the lines have
    most: int  # what a match may cost, in parts of an edit
    lines: Sequence[list[FuzzyLine]] = ()  # as `sides`, where they are searched for

    @property
    def nets(self) -> list[Net]:
        """The nets of all lines."""
        return [net for nets in self.sides for net in nets]

    @property
    def branches(self) -> bool:
        """Whether another end than the nearest may go with what is asked for beside it."""
        return bool(self.beside or self.forbidden) and any(net.branches for net in self.nets)

    @classmethod
    def of(cls, program: Program, lines: tree.Lines, allowance: Allowance) -> FuzzyPlan:
        """Return the plan of a program of some lines; a `UsageError` where that has no edits."""
        lead, *halves = nets_of(program)
        sides, beside = [[half] for half in halves], [Companion("with", ())] * len(halves)
        for it in program.outermost.companions:
            if it.relation not in NEGATIONS:
                nets = [list(nets) for nets in zip(*map(nets_of, it.programs), strict=True)]
                sides, beside = sides + nets, beside + [it] * len(nets)
        forbidden = [it for it in lines.others if it.relation in NEGATIONS]
        sides = [[lead], *sides]
        steps = sum(max(len(net.states) for net in nets) for nets in sides)
        return cls(sides, beside, forbidden, steps, allowance.of(steps))

    def within(self, columns: Mapping[str, Columns], most: int, clear: int = 0) -> FuzzyPlan:
        """Return the plan for matches that cost no more than `most`; `clear` as of `FuzzyLine`."""
        most = min(self.most, most)
        lines = [
            [FuzzyLine(it, columns[it.part], most, clear) for it in nets] for nets in self.sides
        ]
        return self._replace(most=most, lines=lines)

    def possible(self) -> BoolArray:
        """Return in which captures all lines may match, (captures,)."""
        sides = [np.any([line.possible() for line in sides], axis=0) for sides in self.lines]
        found: BoolArray = np.all(sides, axis=0)
        return found

    def bounds(self, batch: Batch) -> AnyArray:
        """Return how well a match in each capture fits at most, (captures,); 0: there is none."""
        least = np.ones(len(batch))
        for it in self._line_matches(batch):
            best = np.zeros(len(batch))
            np.maximum.at(best, it.capture, fits(it.cost, it.blur, self.steps))
            least = np.minimum(least, best)
        return least

    def matches(self, batch: Batch, find_exactly: ExactSearch) -> FuzzyMatches:
        """Return what matches all lines, one for each row where the leading one begins."""
        lead, *others = self._line_matches(batch)
        for companion, nets, other in zip(self.beside, self.sides[1:], others, strict=True):
            tick()
            margins = margins_of(batch, companion)
            if companion.relation == "with":  # no two movements of one part share a frame
                same = [net.number for net in nets if net.part == self.sides[0][0].part]
                near = margins.most[other.capture] > 0
                other = other.at(near | ~np.isin(other.line_rows[:, 0, 0], same))
            lead = self._beside(companion.relation, lead, other, margins)
        for forbidden in self.forbidden:
            lead = lead.at(~self._disturbed(forbidden, lead, batch, find_exactly))
        return lead

    def _line_matches(self, batch: Batch) -> list[FuzzyMatches]:
        """Return the matches of all lines, of both sides together."""
        return [joined([line.matches(batch) for line in sides]) for sides in self.lines]

    def _beside(
        self, relation: str, lead: FuzzyMatches, other: FuzzyMatches, margins: Margins
    ) -> FuzzyMatches:
        """Return the leading matches with the cheapest other one that stands beside each."""
        # of equally cheap ones the first side, and there the one that ends first
        other = other.at(np.lexsort((other.high, other.line_rows[:, 0, 0], other.cost)))
        lines = _spans(lead.capture, *lead.line_rows[:, 0, 3:].T)
        best = _first(relation, lines, _spans(*other[:3]), margins)
        kept = np.flatnonzero(best < NOBODY)
        kept = kept[lead.cost[kept] + other.cost[best[kept]] <= self.most]
        lead, other = lead.at(kept), other.at(best[kept])
        low, high = lead.low, lead.high
        if RELATIONS[relation].adds_frames:
            low, high = np.minimum(low, other.low), np.maximum(high, other.high)
        cost, blur = lead.cost + other.cost, np.maximum(lead.blur, other.blur)
        line_rows = np.concatenate((lead.line_rows, other.line_rows), axis=1)
        return FuzzyMatches(lead.capture, low, high, cost, blur, line_rows)

    def _disturbed(
        self, forbidden: tree.Beside, matches: FuzzyMatches, batch: Batch, find_exactly: ExactSearch
    ) -> BoolArray:
        """Return which matches have a match of a `without` line beside them, (N,) bool.

        Matches of that line that share a symbol with them do not count.
        """
        query = tree.query_of(forbidden.line)
        exact = find_exactly(query, batch.places[once(matches.capture)])
        parts = {net.number: net.part for net in self.nets}
        shares = not query.parts.isdisjoint(parts.values())
        others = _spans(np.searchsorted(batch.places, exact.place), exact.low, exact.high)
        begin, end = matches.line_rows[:, :, 3].min(axis=1), matches.line_rows[:, :, 4].max(axis=1)
        disturbed, pairs = np.zeros(len(begin), np.bool_), [np.empty((2, 0), np.int64)]
        margins = margins_of(batch, Companion(forbidden.relation, (), forbidden.within))
        for match, hit in _pairs(
            forbidden.relation, _spans(*matches[:3]), SpanIndex(others), margins
        ):
            tick()
            # what a match is made of lies in its frames: any hit outside of them disturbs it
            near = shares & (exact.low[hit] <= end[match]) & (exact.high[hit] >= begin[match])
            disturbed[match[~near]] = True
            pairs.append(np.stack((match, hit))[:, near & ~disturbed[match]])
        match, hit = np.concatenate(pairs, axis=1)
        wanted = once(hit[~disturbed[match]]).tolist()
        symbols = {}
        for index, one in zip(wanted, exact.arranged(wanted), strict=True):
            tick()
            symbols[index] = [(it.part, it.ordinal) for it in one.symbols]
        for one, index in zip(match.tolist(), hit.tolist(), strict=True):
            disturbed[one] = disturbed[one] or not any(
                parts[net] == part and first <= row <= last
                for net, first, last, *_ in matches.line_rows[one].tolist()
                for part, row in symbols[index]
            )
        return disturbed


def steps_of(plans: Sequence[FuzzyPlan]) -> list[int]:
    """Return of each line, by its number, how many steps its plan has."""
    return [one.steps for one in plans for _ in one.nets]


def fits(cost: IntArray, blur: IntArray, steps: AnyArray | int) -> AnyArray:
    """Return how well matches fit, of plans with so many steps: without an edit 1/2 to 1."""
    clear = (THOUSANDTHS - blur) / THOUSANDTHS
    found: AnyArray = (clear * np.maximum(1 - cost / UNIT / steps, 0) + (cost == 0)) / 2
    return found


def _spans(capture: IntArray, start: IntArray, until: IntArray) -> Spans:
    return Spans(capture, start, until, start, until, np.zeros(len(capture), np.bool_))


def _pairs(
    relation: str, lines: Spans, others: SpanIndex, margins: Margins
) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield all pairs of a line and another one beside it, by their places, some at a time."""
    first, last, _ = relations.candidates(relation, lines, others, margins)
    for some in in_pieces(np.maximum(last - first, 0)):
        line, other = relations.pairs(relation, lines.at(some), others, margins)
        yield some[line], other


def _first(relation: str, lines: Spans, spans: Spans, margins: Margins) -> IntArray:
    """Return the first of some spans that stands beside each line, by place; or `NOBODY`."""
    others = SpanIndex(spans)
    if relation not in relations.BY_END + relations.BY_START or relation == "exactly with":
        found = np.full(len(lines), NOBODY)
        for line, other in _pairs(relation, lines, others, margins):
            np.minimum.at(found, line, other)
        return found
    order = others.order[others.by_end] if relation in relations.BY_END else others.order
    low, high, _ = relations.candidates(relation, lines, others, margins)
    return smallest_in(order, low, high, NOBODY)
