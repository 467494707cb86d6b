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
from lanindex.search.match.backward import end_of
from lanindex.search.match.conditions import Facts
from lanindex.search.match.context import Context
from lanindex.search.match.hits import HitTable, table
from lanindex.search.match.join import Joiner
from lanindex.search.match.matches import NEVER, hull_rank
from lanindex.search.match.mirror_runs import hits_of_mirror_runs, repeats
from lanindex.search.match.relations import EndBounds
from lanindex.search.match.rewrites import enough
from lanindex.search.match.walk import Ends, Walk, companions

SHORT = 1000
"""Events of a capture up to which a line is walked from all beginnings at once."""

SOON = Fraction(1, 2)
"""Seconds from the first frame in which a match may end to the first horizon."""

WIDER = 8  # times as far lies each next horizon


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
        bounds = _bounds(context, walk.joiner, left)
        for horizon in widening(context, left, bounds, SOON if walk.wanders else None):
            found = walk.run(left, horizon, bounds)
            chosen = complete(context, walk, found)
            keys = (found.entry[chosen], found.root[chosen])
            ranks = (hull_rank(found.spans.low[chosen], found.spans.high[chosen]),)
            found = found.at(chosen[best_of_each(keys, ranks)])
            if horizon and context.program.open_ended:
                found = found.at(~walk.is_cut_off(found.node))
            tables.append(found.at(final(context, left, horizon, found, bounds)))
        return tables
    except OverBudget:
        if len(context.batch) > 1 or sum(map(np.count_nonzero, left)) < 2:
            raise
    ends = np.cumsum([len(fits) for fits in left])
    for some in np.array_split(np.flatnonzero(np.concatenate(left)), 2):
        half = np.zeros(ends[-1], bool)
        half[some] = True
        tables += _best_ends(context, walk, np.split(half, ends[:-1]))
    return tables


def _bounds(context: Context, joiner: Joiner, left: list[BoolArray]) -> list[EndBounds]:
    """Return by entry where lines from each event may end, judged by what must stand beside them.

    `left` loses the beginnings beside which no other line can stand.
    """
    batch, program, found = context.batch, context.program, []
    for entry, fits in zip(program.entries, left, strict=True):
        events = batch.events(program.states[entry.state])
        end = events.end
        if not program.open_ended:  # values tell where a line ends that runs on
            end = np.maximum(end, end_of(context.backwards(program).values[entry.state]))
        bounds = joiner.end_bounds(program.outermost, events.capture, events.start, end)
        fits &= bounds.rank < NEVER
        found.append(bounds)
    return found


def widening(
    context: Context, left: list[BoolArray], bounds: list[EndBounds], soon: Fraction | None
) -> Iterator[list[IntArray] | None]:
    """Yield by entry the frames by which lines from each event have to end, (N,) int64.

    The last one, or the only one, is None. It ends once no beginning is `left`: `final` takes those
    away that are done.
    """
    batch, program = context.batch, context.program
    if soon:
        beyond = batch.bounds(Length("<=", Time(soon, "s")))[1]
        owners = [batch.events(program.states[it.state]).capture for it in program.entries]
        most = int(batch.frames.max(initial=0))
        while int(beyond.min(initial=most)) < most:
            pairs = zip(bounds, owners, strict=True)
            yield [own.first + beyond[capture] for own, capture in pairs]
            if not any(map(np.any, left)):
                return
            beyond = WIDER * np.maximum(beyond, 1)
    yield None


def final(
    context: Context,
    left: list[BoolArray],
    horizon: list[IntArray] | None,
    found: Ends,
    bounds: list[EndBounds],
) -> IntArray:
    """Return the places of the best matches that no wider horizon betters.

    `left` loses their beginnings, and those that cannot end behind their horizon.
    """
    batch, program = context.batch, context.program
    best = np.ones(len(found.root), bool)
    for place, (way_in, fits) in enumerate(zip(program.entries, left, strict=True)):
        own = np.flatnonzero(found.entry == place)
        root, high = found.root[own], found.spans.high[own]
        if horizon:
            rank = hull_rank(found.spans.low[own], high)
            best[own] = (high <= horizon[place][root]) | (rank <= bounds[place].rank[root])
            capture = batch.events(program.states[way_in.state]).capture
            fits &= horizon[place] < np.minimum(bounds[place].last, batch.frames[capture])
        fits[root[best[own]]] = False
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
