"""Programs to hits in a batch: the best match from each beginning, those that end soon first.

A match that ends soon is better than any that goes on for longer. Else a line that may wander
through a capture would be followed from each beginning to each of its ends: the square of its
symbols.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import numpy as np

from lanindex.search.automaton import NEGATIONS, Program
from lanindex.search.language.times import Length, Time
from lanindex.search.match.arrays import FAR, BoolArray, IntArray, best_of_each
from lanindex.search.match.backward import Backwards
from lanindex.search.match.batch import Batch
from lanindex.search.match.budget import TooMuch
from lanindex.search.match.conditions import Told
from lanindex.search.match.context import Alive, Context, alive_in
from lanindex.search.match.hit_table import HitTable, joined, own_rows, roots, table
from lanindex.search.match.join import Joiner
from lanindex.search.match.mirror_runs import MirrorRuns, repeats
from lanindex.search.match.rewrites import enough
from lanindex.search.match.walk import Ends, Walk

SOON = 4
"""Seconds that are soon; the next are so many times as many."""


def widening(batch: Batch, left: list[BoolArray], soon: int | None) -> Iterator[IntArray | None]:
    """Yield in how many frames ways are looked for, by capture; at last, or at once, in all.

    It ends where none is `left`, as `settled` has it, to be looked for.
    """
    if soon:
        within = batch.bounds(Length("<=", Time(Fraction(soon), "s")))[1]
        most = int(batch.frames.max(initial=0))
        while int(within.min(initial=most)) < most:
            yield within
            if not any(map(np.any, left)):
                return
            within = soon * within
    yield None


def settled(
    batch: Batch,
    program: Program,
    left: list[BoolArray],
    within: IntArray | None,
    ways: tuple[IntArray, IntArray, IntArray],
) -> IntArray:
    """Return the places of the ways that are the best ones; `left` loses what is settled by now.

    Parameters
    ----------
    batch : Batch
        Where.
    program : Program
        The line.
    left : list of ndarray
        By entry, from which events of its state ways were looked for, (N,) bool.
    within : ndarray or None
        (captures,) int64: in how many frames; in no more than a capture has nothing else is found.
    ways : tuple of ndarray
        Entry, event and end of the best of each beginning, of those that were found.
    """
    entry, root, high = ways
    best = np.ones(len(entry), bool)
    for place, (way_in, fits) in enumerate(zip(program.entries, left, strict=True)):
        own = np.flatnonzero(entry == place)
        if within is not None:
            events = batch.events(program.states[way_in.state])
            frames = within[events.capture]
            best[own] = high[own] - events.start[root[own]] <= frames[root[own]]
            fits &= frames < batch.frames[events.capture]
        fits[root[own[best[own]]]] = False
    return np.flatnonzero(best)


FEW = 4
"""What is less than one in so many captures is gone through on its own."""


def answers_of(
    context: Context, number: int, program: Program, parts: list[tuple[str, ...]]
) -> list[HitTable]:
    """Return the answers of a program in a batch.

    Raises
    ------
    TooMuch
        Where there are too many ways.
    """
    if context.clauses:
        lines = repeats(context.clauses, program)
        if lines:
            return MirrorRuns(context.batch, lines).answers(number, parts, context.tick)
        return remembering(context, number, program, parts)
    return in_some(context, number, program, parts)


def may_match(batch: Batch, program: Program, alive: Alive | None = None) -> BoolArray:
    """Tell in which captures a program can match at all: with all that it remembers left out.

    Parameters
    ----------
    batch : Batch
        Where.
    program : Program
        With those beside it.
    alive : callable, optional
        Gives what `alive_in` does of a line.
    """
    standing = (
        alive(program) if alive else alive_in(batch, program, Backwards(batch, program).values)
    )
    found = np.zeros(len(batch), bool)
    for entry in program.entries:
        fits = roots(batch, program, entry) & standing[entry.state]
        found[batch.events(program.states[entry.state]).capture[fits]] = True
    for companion in program.whole.companions:
        if companion.relation not in NEGATIONS:
            others = [may_match(batch, inner, alive) for inner in companion.programs]
            found &= np.any(others, axis=0)
    return found


def in_some(
    context: Context, number: int, program: Program, parts: list[tuple[str, ...]]
) -> list[HitTable]:
    """Return the same as `remembering`, looked for where the program can match at all.

    Raises
    ------
    TooMuch
        Where there are too many ways.
    """
    batch = context.batch
    places = np.flatnonzero(may_match(batch, program, context.alive))
    if FEW * len(places) > len(batch):
        return remembering(context, number, program, parts)
    some = batch.taken(places)
    inside = context.inside(some)
    found = joined(remembering(inside, number, program, parts))
    context.refused[places] |= inside.refused
    found = own_rows(
        found, parts, lambda part: some.rows(part).bounds[:-1] - batch.rows(part).bounds[places]
    )
    return [replace(found, capture=places[found.capture])]


def remembering(
    context: Context,
    number: int,
    program: Program,
    parts: list[tuple[str, ...]],
) -> list[HitTable]:
    """Return the answers of a program; their fits are not known.

    Parameters
    ----------
    context : Context
        Where, and what is asked.
    number : int
        Of the program.
    program : Program
        A leading line.
    parts : list of tuple of str
        Of `Finder`.

    Raises
    ------
    TooMuch
        Where there are too many ways.
    """
    joiner = context.joiner = Joiner(context)
    timed, tracked = bool(context.clauses.rhythm), program.open_ended
    walk = Walk(context, program, timed=timed, tracked=tracked, enough=enough(program))
    tables = _best_of_all(context, program, walk, joiner, walk.roots())
    return [
        answers for found in tables for answers in _answers(context, number, program, parts, found)
    ]


def _best_of_all(
    context: Context, program: Program, walk: Walk, joiner: Joiner, begun: list[BoolArray]
) -> list[Ends]:
    """Return the best ways from some beginnings; from fewer at once where one capture has many."""
    tables, left = [], [fits.copy() for fits in begun]
    soon = SOON if walk.wanders else None
    try:
        for within in widening(context.batch, left, soon):
            found = walk.found(left, within)
            found = found.at(_best(context, program, walk, found, joiner))
            if within is not None and program.open_ended:
                found = found.at(~walk.is_cut_off(found.node))
            ways = found.entry, found.root, found.high
            tables.append(found.at(settled(context.batch, program, left, within, ways)))
        return tables
    except TooMuch:
        if len(context.batch) > 1 or sum(map(np.count_nonzero, left)) < 2:
            raise
    bounds = np.cumsum([len(fits) for fits in left])
    for some in np.array_split(np.flatnonzero(np.concatenate(left)), 2):
        half = np.zeros(bounds[-1], bool)
        half[some] = True
        few = np.split(half, bounds[:-1])
        tables += _best_of_all(context, program, walk, joiner, few)
    return tables


def _best(context: Context, program: Program, walk: Walk, found: Ends, joiner: Joiner) -> IntArray:
    """Return the places of the best ways from each beginning."""
    chosen = asked_for(context, program, walk, found, joiner)
    keys = (found.entry[chosen], found.root[chosen])
    return chosen[best_of_each(keys, (found.high[chosen], -found.low[chosen]))]


def asked_for(
    context: Context, program: Program, walk: Walk, found: Ends, joiner: Joiner
) -> IntArray:
    """Return the places of the ways that are all that is asked for, the longest if they run on."""
    chosen = _whole(context, program, found, joiner)
    if program.open_ended:
        node = found.node[chosen]
        chosen = chosen[~walk.nodes.behind(np.zeros(len(node), np.int64), node)]
    return chosen


def _answers(
    context: Context, number: int, program: Program, parts: list[tuple[str, ...]], found: Ends
) -> list[HitTable]:
    answers = []
    for place, entry in enumerate(program.entries):
        own = np.flatnonzero(found.entry == place)
        state = program.states[entry.state]
        events = context.batch.events(state).at(found.root[own])
        cost = np.where(found.cost[own] >= 0, found.cost[own], ~events.cost)
        frames = found.low[own], found.high[own], cost
        answers.append(table(number, state, parts, events, frames))
    return answers


def _whole(context: Context, program: Program, found: Ends, joiner: Joiner) -> IntArray:
    """Return the places of the ways that are all that is asked for.

    A starting position alone is no movement; nothing happens that must not.
    """
    clauses, memory = context.clauses, found.memory
    fits = ~found.alone
    if memory.unmet.size:
        still_unmet = joiner.still_unmet(memory.unmet, memory.claims)
        fits &= (still_unmet >= FAR).all(axis=0)
    width = len(memory.columns) - len(clauses.columns)
    if clauses.rhythm:
        fits &= clauses.in_rhythm(memory.columns[width - len(clauses.rhythm) : width])
    chosen = np.flatnonzero(fits)
    own = set(context.due(program).own)
    for condition in clauses.conditions:
        if condition not in own:
            told = Told(
                found.capture, memory.columns[width:], found.low, found.high, found.part, found.row
            )
            chosen = chosen[context.evaluator.holds(condition, told.at(chosen))]
    return chosen
