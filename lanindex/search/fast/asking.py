"""The answers of programs that have to remember: with clauses, or lines beside their brackets."""

from __future__ import annotations

import numpy as np

from lanindex.search.automaton import Program
from lanindex.search.fast.answers import Answers, table
from lanindex.search.fast.asked import Told
from lanindex.search.fast.partners import MOST_MARKS, Partners
from lanindex.search.fast.ragged import FAR, Whole, best_of_each
from lanindex.search.fast.recall import Found, Recall
from lanindex.search.fast.setting import Setting


def remembering(
    setting: Setting,
    number: int,
    program: Program,
    parts: list[tuple[str, ...]],
    *,
    passing_only: bool = False,
) -> list[Answers]:
    """Return the answers of a program; their fits are not known.

    Parameters
    ----------
    setting : Setting
        Where, and what is asked.
    number : int
        Of the program.
    program : Program
        A leading line.
    parts : list of tuple of str
        Of `Finder`.
    passing_only : bool
        Whether only those are asked for that begin with a passing symbol.

    Raises
    ------
    NotCovered
        Where only the plain matcher can tell.
    TooMuch
        Where there are too many ways.
    """
    setting.enter(program)
    partners = setting.company = Partners(setting)
    rhythm = setting.asked.rhythm
    recall = Recall(setting, program, timed=bool(rhythm), tracked=program.open_ended)
    found = recall.found(passing_only=passing_only)
    chosen = _whole(setting, program, found, partners)
    if program.open_ended:
        node = found.node[chosen]
        chosen = chosen[~recall.nodes.behind(np.zeros(len(node), np.int64), node, MOST_MARKS)]
    keys = (found.entry[chosen], found.root[chosen])
    chosen = chosen[best_of_each(keys, (found.high[chosen], -found.low[chosen]))]
    answers = []
    for place, entry in enumerate(program.entries):
        own = chosen[found.entry[chosen] == place]
        state = program.states[entry.state]
        events = setting.block.events(state).at(found.root[own])
        unknown = np.full(len(own), -1)
        frames = found.low[own], found.high[own], unknown
        answers.append(table(number, state, parts, events, frames))
    return answers


def _whole(setting: Setting, program: Program, found: Found, partners: Partners) -> Whole:
    """Return the places of the ways that are all that is asked for.

    A starting position alone is no movement; nothing happens that must not.
    """
    asked, memory = setting.asked, found.memory
    fits = ~found.alone
    if memory.owed.size:
        unpaid = partners.unpaid(memory.owed, memory.taken)
        fits &= (unpaid >= FAR).all(axis=0)
    width = len(memory.columns) - len(asked.columns)
    if asked.rhythm:
        fits &= asked.in_rhythm(memory.columns[width - len(asked.rhythm) : width])
    chosen = np.flatnonzero(fits)
    own = set(setting.due(program).own)
    for condition in asked.conditions:
        if condition not in own:
            told = Told(
                found.capture, memory.columns[width:], found.low, found.high, found.part, found.row
            )
            chosen = chosen[setting.clauses.holds(condition, told.at(chosen))]
    return chosen
