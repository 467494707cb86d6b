"""Programs → answers in a block of captures: by the quickest way that covers what they ask."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lanindex.search.automaton import Program
from lanindex.search.fast.answers import (
    Answers,
    joined,
    own_rows,
    roots,
    table,
)
from lanindex.search.fast.beside import FORBIDDEN
from lanindex.search.fast.block import Block
from lanindex.search.fast.budget import TooMuch
from lanindex.search.fast.conditions import Told
from lanindex.search.fast.ends import Found
from lanindex.search.fast.lines import Backwards
from lanindex.search.fast.mirrored import Mirroring, repeats
from lanindex.search.fast.partners import Partners
from lanindex.search.fast.ragged import FAR, Mask, Whole, best_of_each
from lanindex.search.fast.recall import Recall
from lanindex.search.fast.setting import Alive, Setting, alive_in
from lanindex.search.fast.soon import SOON, settled, widening
from lanindex.search.fast.tails import enough

FEW = 4
"""What is less than one in so many captures is gone through on its own."""


def answers_of(
    setting: Setting, number: int, program: Program, parts: list[tuple[str, ...]]
) -> list[Answers]:
    """Return the answers of a program in a block.

    Raises
    ------
    TooMuch
        Where there are too many ways.
    """
    if setting.asked:
        lines = repeats(setting.asked, program)
        if lines:
            return Mirroring(setting.block, lines).answers(number, parts, setting.tick)
        return remembering(setting, number, program, parts)
    return in_some(setting, number, program, parts)


def possible(block: Block, program: Program, alive: Alive | None = None) -> Mask:
    """Tell in which captures a program can match at all: with all that it remembers left out.

    Parameters
    ----------
    block : Block
        Where.
    program : Program
        With those beside it.
    alive : callable, optional
        Gives what `alive_in` does of a line.
    """
    standing = (
        alive(program) if alive else alive_in(block, program, Backwards(block, program).values)
    )
    found = np.zeros(len(block), bool)
    for entry in program.entries:
        fits = roots(block, program, entry) & standing[entry.state]
        found[block.events(program.states[entry.state]).capture[fits]] = True
    for companion in program.whole.companions:
        if companion.relation not in FORBIDDEN:
            others = [possible(block, inner, alive) for inner in companion.programs]
            found &= np.any(others, axis=0)
    return found


def in_some(
    setting: Setting, number: int, program: Program, parts: list[tuple[str, ...]]
) -> list[Answers]:
    """Return the same as `remembering`, looked for where the program can match at all.

    Raises
    ------
    TooMuch
        Where there are too many ways.
    """
    block = setting.block
    places = np.flatnonzero(possible(block, program, setting.alive))
    if setting.asked or FEW * len(places) > len(block):
        return remembering(setting, number, program, parts)
    some = block.taken(places)
    inside = setting.inside(some)
    found = joined(remembering(inside, number, program, parts))
    setting.refused[places] |= inside.refused
    found = own_rows(
        found, parts, lambda part: some.rows(part).bounds[:-1] - block.rows(part).bounds[places]
    )
    return [replace(found, capture=places[found.capture])]


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
    TooMuch
        Where there are too many ways.
    """
    setting.enter(program)
    partners = setting.company = Partners(setting, program)
    timed, tracked = bool(setting.asked.rhythm), program.open_ended
    recall = Recall(setting, program, timed=timed, tracked=tracked, enough=enough(program))
    begun = recall.roots()
    if passing_only:
        passing = (setting.block.events(program.states[it.state]) for it in program.entries)
        begun = [fits & events.passing for fits, events in zip(begun, passing, strict=True)]
    tables = _best_of_all(setting, program, recall, partners, begun)
    return [
        answers for found in tables for answers in _answers(setting, number, program, parts, found)
    ]


def _best_of_all(
    setting: Setting, program: Program, recall: Recall, partners: Partners, begun: list[Mask]
) -> list[Found]:
    """Return the best ways from some beginnings; from fewer at once where one capture has many."""
    tables, left = [], [fits.copy() for fits in begun]
    soon = SOON if recall.wanders else None
    try:
        for within in widening(setting.block, left, soon):
            found = recall.found(left, within)
            found = found.at(_best(setting, program, recall, found, partners))
            if within is not None and program.open_ended:
                found = found.at(~recall.is_cut_off(found.node))
            ways = found.entry, found.root, found.high
            tables.append(found.at(settled(setting.block, program, left, within, ways)))
        return tables
    except TooMuch:
        if len(setting.block) > 1 or sum(map(np.count_nonzero, left)) < 2:
            raise
    bounds = np.cumsum([len(fits) for fits in left])
    for some in np.array_split(np.flatnonzero(np.concatenate(left)), 2):
        half = np.zeros(bounds[-1], bool)
        half[some] = True
        few = np.split(half, bounds[:-1])
        tables += _best_of_all(setting, program, recall, partners, few)
    return tables


def _best(
    setting: Setting, program: Program, recall: Recall, found: Found, partners: Partners
) -> Whole:
    """Return the places of the best ways from each beginning."""
    chosen = asked_for(setting, program, recall, found, partners)
    keys = (found.entry[chosen], found.root[chosen])
    return chosen[best_of_each(keys, (found.high[chosen], -found.low[chosen]))]


def asked_for(
    setting: Setting, program: Program, recall: Recall, found: Found, partners: Partners
) -> Whole:
    """Return the places of the ways that are all that is asked for, the longest if they run on."""
    chosen = _whole(setting, program, found, partners)
    if program.open_ended:
        node = found.node[chosen]
        chosen = chosen[~recall.nodes.behind(np.zeros(len(node), np.int64), node)]
    return chosen


def _answers(
    setting: Setting, number: int, program: Program, parts: list[tuple[str, ...]], found: Found
) -> list[Answers]:
    answers = []
    for place, entry in enumerate(program.entries):
        own = np.flatnonzero(found.entry == place)
        state = program.states[entry.state]
        events = setting.block.events(state).at(found.root[own])
        cost = np.where(found.cost[own] >= 0, found.cost[own], ~events.cost)
        frames = found.low[own], found.high[own], cost
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
