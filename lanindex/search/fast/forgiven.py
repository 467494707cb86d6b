"""Matches of what must not happen, and which of them the hit itself forgives by what it takes."""

from __future__ import annotations

import numpy as np

from lanindex.search.fast import beside, budget
from lanindex.search.fast.beside import Margins, Stretches
from lanindex.search.fast.ragged import FAR, Mask, Whole, spread
from lanindex.search.fast.taken import Taken


def paired(
    relation: str, lines: Stretches, others: Stretches, margins: Margins
) -> tuple[Whole, Whole]:
    """Return all pairs of a line and another one that stands beside it, by place."""
    ordered = beside.Others(others)
    line, place = beside.pairs(relation, lines, ordered, margins)
    return line, ordered.order[place]


def unforgiven(
    relation: str,
    lines: Stretches,
    forgiving: Taken,
    matches: Stretches,
    taken: Taken,
    margins: Margins,
) -> Mask:
    """Tell beside which lines there is a match that takes nothing of what the line forgives.

    There is if more stand beside it than those that do take something of that, which are few.

    Parameters
    ----------
    relation : str
        ``without`` or ``never``.
    lines : Stretches
        (N,) the frames of hits.
    forgiving : Taken
        (N,) by line, in no order.
    matches : Stretches
        (M,) of what must not happen.
    taken : Taken
        (M,) what each of those takes.
    margins : Margins
        How near matches must lie.
    """
    line, match = _touching(forgiving, taken)
    limit = beside.limits(relation, lines, margins)
    start, until = matches.start[match], matches.until[match]
    fits = lines.capture[line] == matches.capture[match]
    fits &= (start <= limit.begin_last[line]) & (until >= limit.end_first[line])
    forgiven = np.bincount(line[fits], minlength=len(lines))
    base, behind = lines.capture * FAR, matches.capture * FAR
    starts, ends = np.sort(behind + matches.start), np.sort(behind + matches.until)
    many = np.searchsorted(starts, base + limit.begin_last, "right")
    many -= np.searchsorted(ends, base + limit.end_first)
    found: Mask = many > forgiven
    return found


def _touching(one: Taken, other: Taken) -> tuple[Whole, Whole]:
    """Return all pairs of a line and another that take something in common, each once."""
    first, last, line = _ranges(one)
    begin, end, match = _ranges(other)
    order = np.argsort(begin, kind="stable")
    begin, end, match = begin[order], end[order], match[order]
    latest = np.maximum.accumulate(end)
    which, place = spread(np.searchsorted(latest, first), np.searchsorted(begin, last, "right"))
    common = end[place] >= first[which]
    pairs = line[which[common]] * (len(other) + 1) + match[place[common]]
    return np.divmod(np.unique(pairs), len(other) + 1)


def _ranges(taken: Taken) -> tuple[Whole, Whole, Whole]:
    """Return all ranges that lines have taken, and whose they are."""
    column, line = np.nonzero(taken.first < FAR)
    return taken.first[column, line], taken.last[column, line], line


def by_line(pairs: Whole, lines: int) -> Whole:
    """Return what each line is paired with as columns, filled up with `FAR`."""
    pairs = pairs[:, np.lexsort(pairs[::-1])]
    counts = np.bincount(pairs[0], minlength=lines)
    most = int(counts.max(initial=0))
    if most * lines > budget.rows(64):
        raise budget.TooMuch
    found = np.full((most, lines), FAR)
    begin = np.cumsum(counts) - counts
    found[np.arange(pairs.shape[1]) - begin[pairs[0]], pairs[0]] = pairs[1]
    return found
