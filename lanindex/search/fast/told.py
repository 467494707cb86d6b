"""Hits as they are told: which symbols each line of one took."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import NamedTuple

from lanindex.model import Symbol
from lanindex.search.automaton import State
from lanindex.search.fast.block import Block


class Taken(NamedTuple):
    """What matched a state: parts and rows, and the frames of it."""

    state: State
    rows: tuple[tuple[str, int], ...]
    start: int
    end: int


class Told(NamedTuple):
    """A hit: what is missing to a fit of 1, and what each line took, the leading one first."""

    cost: int
    lines: list[list[Taken]]


def took(block: Block, state: State, event: int) -> Taken:
    """Return what a state took at one of its events."""
    events, rows = block.events(state), []
    for part, first, last in zip(state.members, events.first, events.last, strict=True):
        begin, end, passing = int(first[event]), int(last[event]), block.rows(part).passing
        rows += [(part, it) for it in range(begin, end + 1) if begin == end or not passing[it]]
    return Taken(state, tuple(rows), int(events.start[event]), int(events.end[event]))


def labelled(
    taken: Iterable[Taken], symbols: Mapping[tuple[str, int], Symbol]
) -> dict[str, tuple[Symbol, ...]]:
    """Return, by label, what matched under it; one stayed at or rested in lasts as long as that."""
    labels: dict[str, tuple[Symbol, ...]] = {}
    for it in taken:
        if not it.state.labels:
            continue
        found = [symbols[row] for row in it.rows]
        if it.state.manner in ("at", "hold"):
            found = [replace(symbol, start=it.start, stop=it.end) for symbol in found]
        for label in it.state.labels:
            labels[label] = (*labels.get(label, ()), *found)
    return labels
