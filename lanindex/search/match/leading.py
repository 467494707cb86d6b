"""The best match from each beginning of a leading line: the first to end, then the last to begin.

A match that ends soon is better than any that goes on for longer, so matches are looked for within
a horizon that widens. Otherwise a line that may wander through a capture would be followed from
each beginning to each of its ends: the square of its symbols. Where nothing is compared with all of
a line, and the capture is short, it is walked from all beginnings at once instead.
"""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from lanindex.search.language.times import Length, Time
from lanindex.search.limits import OverBudget
from lanindex.search.match.arrays import FAR, BoolArray, IntArray, best_of_each
from lanindex.search.match.batch import Batch
from lanindex.search.match.conditions import Facts
from lanindex.search.match.context import Context
from lanindex.search.match.hits import HitTable, table
from lanindex.search.match.join import Joiner
from lanindex.search.match.mirror_runs import hits_of_mirror_runs, repeats
from lanindex.search.match.rewrites import enough
from lanindex.search.match.walk import Ends, Walk, companions
from lanindex.search.plan import Program

SHORT = 1000
"""Events of a capture up to which a line is walked from all beginnings at once."""

SOON = 4
"""Seconds of the first horizon; each next one is so many times as far."""


def hits_of(context: Context) -> list[HitTable]:
    """Return the best match from each beginning of a program.

    Raises `OverBudget` if one capture needs more than the budget.
    """
    lines = repeats(context.clauses, context.program)
    if lines:
        return [hits_of_mirror_runs(context.batch, lines)]
    program = context.program
    timed, tracked = bool(context.clauses.rhythm), program.open_ended
    joiner = Joiner(context, companions)
    walk = Walk(joiner, program, timed=timed, tracked=tracked, enough=enough(program))
    begun, hits = context.roots(program), list[HitTable]()
    if walk.best_ends is None and not (program.outermost.companions or context.clauses):
        short = _short(context)
        hits += _from_all(joiner, _in_captures(context, begun, short))
        begun = _in_captures(context, begun, ~short)
    ends = _best_ends(context, walk, begun)
    return hits + [hits for found in ends for hits in _as_hits(context, found)]


def _short(context: Context) -> BoolArray:
    """Tell in which captures the line may stand at few events, (captures,) bool."""
    many = np.zeros(len(context.batch), np.int64)
    for state, alive in zip(context.program.states, context.alive(context.program), strict=True):
        many += np.bincount(context.batch.events(state).capture[alive], minlength=len(many))
    return many <= SHORT


def _in_captures(context: Context, roots: list[BoolArray], captures: BoolArray) -> list[BoolArray]:
    """Return the beginnings, by entry, that lie in some captures."""
    states = (context.program.states[entry.state] for entry in context.program.entries)
    own = (context.batch.events(state).capture for state in states)
    return [fits & captures[capture] for fits, capture in zip(roots, own, strict=True)]


def _from_all(joiner: Joiner, roots: list[BoolArray]) -> Iterator[HitTable]:
    """Yield the best match from each of some beginnings, walked from all of them at once.

    What follows a partial match does not depend on where it began: the best end of each beginning
    is found backwards, over the links between partial matches.
    """
    context, program = joiner.context, joiner.context.program
    walk = Walk(joiner, program, rooted=False)
    found = walk.run(roots)
    found = found.at(complete(context, walk, found))
    lows, highs = walk.nodes.best_hulls(found.node, found.spans.low, found.spans.high)
    bounds = np.cumsum([0, *map(len, walk.firsts)])
    for place, (entry, first) in enumerate(zip(program.entries, walk.firsts, strict=True)):
        own = bounds[place] + np.flatnonzero(highs[bounds[place] : bounds[place + 1]] >= 0)
        state = program.states[entry.state]
        events = context.batch.events(state).at(first[own - bounds[place]])
        yield table(context.batch, state, events, (lows[own], highs[own], ~events.cost))


def _best_ends(context: Context, walk: Walk, roots: list[BoolArray]) -> list[Ends]:
    """Return the best matches from some beginnings; from half of them at a time if too many."""
    tables, left = [], [fits.copy() for fits in roots]
    try:
        for within in widening(context.batch, left, SOON if walk.wanders else None):
            found = walk.run(left, within)
            chosen = complete(context, walk, found)
            keys = (found.entry[chosen], found.root[chosen])
            ranks = (found.spans.high[chosen], -found.spans.low[chosen])
            found = found.at(chosen[best_of_each(keys, ranks)])
            if within is not None and context.program.open_ended:
                found = found.at(~walk.is_cut_off(found.node))
            matches = found.entry, found.root, found.spans.high
            best = final(context.batch, context.program, left, within, matches)
            tables.append(found.at(best))
        return tables
    except OverBudget:
        if len(context.batch) > 1 or sum(map(np.count_nonzero, left)) < 2:
            raise
    bounds = np.cumsum([len(fits) for fits in left])
    for some in np.array_split(np.flatnonzero(np.concatenate(left)), 2):
        half = np.zeros(bounds[-1], bool)
        half[some] = True
        tables += _best_ends(context, walk, np.split(half, bounds[:-1]))
    return tables


def widening(batch: Batch, left: list[BoolArray], soon: int | None) -> Iterator[IntArray | None]:
    """Yield horizons by capture, (captures,) frames; the last one, or the only one, is None.

    It ends once no beginning is `left`: `final` takes those away that are done.
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


def final(
    batch: Batch,
    program: Program,
    left: list[BoolArray],
    within: IntArray | None,
    matches: tuple[IntArray, IntArray, IntArray],
) -> IntArray:
    """Return the places of the matches that no wider horizon betters; `left` loses their roots.

    These are the entry, event and end of the best match from each beginning that has one. Beyond a
    horizon that holds all of a capture, (captures,) frames, there is nothing else to find.
    """
    entry, root, high = matches
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


def complete(context: Context, walk: Walk, ends: Ends) -> IntArray:
    """Return the places of the ends that fulfil the whole pattern; the longest if they run on.

    A starting position alone is no movement, and nothing that must not happen is left.
    """
    clauses, memory = context.clauses, ends.memory
    fits = ~ends.spans.alone
    if memory.unmet.size:
        still_unmet = walk.joiner.still_unmet(memory.unmet, memory.claims)
        fits &= (still_unmet >= FAR).all(axis=0)
    width = len(memory.columns) - clauses.width
    if clauses.rhythm:
        fits &= clauses.in_rhythm(memory.columns[width - len(clauses.rhythm) : width])
    chosen = np.flatnonzero(fits)
    spans, notes = ends.spans, memory.columns[width:]
    facts = Facts(spans.capture, notes, spans.low, spans.high, ends.part, ends.row)
    for condition in clauses.conditions:
        chosen = chosen[context.evaluator.holds(condition, facts.at(chosen))]
    if context.program.open_ended:
        node = ends.node[chosen]
        chosen = chosen[~walk.nodes.behind(np.zeros(len(node), np.int64), node)]
    return chosen


def _as_hits(context: Context, ends: Ends) -> Iterator[HitTable]:
    """Yield ends as hits, a table for each entry."""
    for place, entry in enumerate(context.program.entries):
        rows = np.flatnonzero(ends.entry == place)
        state = context.program.states[entry.state]
        events = context.batch.events(state).at(ends.root[rows])
        cost = np.where(ends.cost[rows] >= 0, ends.cost[rows], ~events.cost)
        yield table(
            context.batch, state, events, (ends.spans.low[rows], ends.spans.high[rows], cost)
        )
