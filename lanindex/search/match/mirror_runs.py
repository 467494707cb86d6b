"""Two repeats without end that mirror each other: how far they go on from each pair of symbols.

For each symbol of the one line and each of the other, the pairs of symbols that follow and mirror
each other are counted. The longest run of those that share a frame is the match of both lines, so
that nothing shorter need be tried and no partial match of either be kept.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lanindex.alphabet import KINDS, kind_of, mirrored_part
from lanindex.model.columns import CELL
from lanindex.search.language.clauses import Mirrors
from lanindex.search.language.query import NEXT
from lanindex.search.limits import tick
from lanindex.search.match.arrays import BoolArray, IntArray, Table, best_of_each, together
from lanindex.search.match.batch import Batch, Events
from lanindex.search.match.conditions import MIRRORED_CELLS, Clauses
from lanindex.search.match.hits import BestTrace, HitTable, parts_number, table
from lanindex.search.plan import Program, State


class Repeats(NamedTuple):
    """The steps of two lines that mirror each other, and how often each comes at least."""

    leading: State
    other: State
    least: int


def repeats(clauses: Clauses, program: Program) -> Repeats | None:
    """Return what a program repeats, if it is a repeat with one beside it that mirrors it."""
    lines = [program, *(it for one in program.outermost.companions for it in one.programs)]
    if clauses.rhythm or len(clauses.conditions) != 1 or len(lines) != 2:
        return None
    (condition,), (companion,) = clauses.conditions, program.outermost.companions
    first, second = (line.states[0] for line in lines)
    if (
        not isinstance(condition, Mirrors)
        or not all(map(_is_repeat, lines))
        or (companion.relation, companion.within) != ("with", None)
        or first.members == second.members
        or any("amount" in KINDS[kind_of(it)].fields for it in (*first.members, *second.members))
        or {condition.first, condition.second}
        not in ({one, other} for one in first.labels for other in second.labels)
    ):
        return None
    return Repeats(first, second, max(len(line.states) for line in lines))


def _is_repeat(line: Program) -> bool:
    """Return whether a line is one part's movements in a row, all alike, without end."""
    first, last = line.states[0], len(line.states) - 1
    edges = [edge for edges in line.edges for edge in edges]
    exits = [leaving for exits in line.exits for leaving in exits]
    return (
        (first.manner, len(first.members), first.names_passing) == ("move", 1, False)
        and not line.brackets
        and all(
            (it.members, it.manner, it.fits, it.length, it.labels)
            == (first.members, first.manner, first.fits, first.length, first.labels)
            for it in line.states
        )
        and [(it.exit.state, it.entry.state) for it in edges]
        == [*((number, number + 1) for number in range(last)), (last, last)]
        and all(it.arrow == NEXT and it.same for it in edges)
        and [(it.state, it.from_start) for it in line.entries] == [(0, ())]
        and [(it.state, it.to_end) for it in exits] == [(last, ())]
    )


@dataclass(slots=True, eq=False)
class MirrorRuns(Table):
    """The best run from each event of a line that begins one, in order; (N,) int64 each."""

    event: IntArray  # the first of the line
    beside: IntArray  # the first of the line beside it
    length: IntArray  # how many pairs of symbols
    low: IntArray  # frames
    high: IntArray
    cost: IntArray  # what is missing to a fit of 1, in thousandths


def mirror_runs(batch: Batch, lines: Repeats) -> MirrorRuns:
    """Return the runs in a batch: the longest, of those the first to end, the last to begin."""
    leading, other = batch.events(lines.leading), batch.events(lines.other)
    ((part,), (beside,)) = lines.leading.members, lines.other.members
    image, shown = MIRRORED_CELLS[_cells(batch, part, leading)], _cells(batch, beside, other)
    if mirrored_part(part) != beside:
        shown = np.full(len(other), CELL + 1)  # the mirror image of none
    on, on_beside = _is_followed(batch, part, leading), _is_followed(batch, beside, other)
    behind = np.searchsorted(leading.capture, np.arange(len(batch)), "right")
    many = np.bincount(leading.capture, minlength=len(batch))
    here, none = np.arange(len(other)), np.empty(0, np.int64)
    lengths, costs = np.zeros((2, len(other) + 1), np.int64)
    found = [MirrorRuns(none, none, none, none, none, none)]
    for back in range(1, int(many.max(initial=0)) + 1):  # each capture's last symbol first
        tick()
        here = here[many[other.capture[here]] >= back]
        event = behind[other.capture[here]] - back
        follows = on[event] & on_beside[here]
        cost = np.maximum(leading.cost[event], other.cost[here])
        cost = np.maximum(cost, follows * costs[here + 1])
        length = (1 + follows * lengths[here + 1]) * (image[event] == shown[here])
        lengths[here], costs[here] = length, cost * (length > 0)
        last = event + length - 1, here + length - 1
        low = np.minimum(leading.start[event], other.start[here])
        high = np.maximum(leading.end[last[0]], other.end[last[1]])
        fits = (length >= lines.least) & (leading.start[event] < other.end[last[1]])
        fits &= other.start[here] < leading.end[last[0]]
        # a starting position alone is no movement
        fits &= (length > 1) | ~(leading.starting[event] | other.starting[here])
        runs = MirrorRuns(event, here, length, low, high, cost).at(fits)
        found.append(
            runs.at(best_of_each((runs.event,), (-runs.length, runs.high, -runs.low, runs.cost)))
        )
    runs = together(found)
    return runs.at(np.argsort(runs.event))


def hits_of_mirror_runs(batch: Batch, lines: Repeats) -> HitTable:
    """Return the best match from each event of the leading line."""
    runs = mirror_runs(batch, lines)
    events = batch.events(lines.leading).at(runs.event)
    return table(batch, lines.leading, events, (runs.low, runs.high, runs.cost))


def traced_mirror_runs(
    batch: Batch, lines: Repeats, hits: HitTable
) -> Iterator[tuple[int, BestTrace]]:
    """Yield the places of the hits that are runs, each with its cost and its lines."""
    runs = mirror_runs(batch, lines)
    (part,), first = lines.leading.members, batch.events(lines.leading).first[0]
    rows = hits.rows[0] + batch.rows(part).bounds[hits.capture]
    keys = np.append(first[runs.event], -1)
    places = np.searchsorted(keys[:-1], rows)
    fits = (keys[places] == rows) & (hits.parts == parts_number([part]))
    for number in np.flatnonzero(fits).tolist():
        run = runs.at(places[number : number + 1])
        if run.low == hits.low[number] and run.high == hits.high[number]:
            event, beside, length, *_, cost = (getattr(run, it).item() for it in run.__slots__)
            begins = (lines.leading, event), (lines.other, beside)
            steps = [[(state, it + step) for step in range(length)] for state, it in begins]
            yield number, ((cost, -length), steps)


def _cells(batch: Batch, part: str, events: Events) -> IntArray:
    """Return direction and level of some events of a part, as one number."""
    return batch.rows(part).cell[events.first[0]].astype(np.int64) & CELL


def _is_followed(batch: Batch, part: str, events: Events) -> BoolArray:
    """Tell after which events the next one is what follows."""
    rows, row = batch.rows(part), events.first[0]
    found = np.zeros(len(row), bool)
    found[:-1] = (np.diff(rows.rank[row]) == 1) & (np.diff(rows.stretch[row]) == 0)
    return found
