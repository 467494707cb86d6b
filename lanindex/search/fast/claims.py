"""Which movements, stays and rests several lines side by side could want.

One movement, stay or rest serves one line only, and what must not happen is forgiven where the hit
uses it, or came there by it. Where lines can want none in common, because they speak of other
parts or cells, nothing has to be remembered.
"""

from __future__ import annotations

from itertools import combinations, product

from lanindex.search.automaton import Program, State
from lanindex.search.fast.abreast import standing
from lanindex.search.fast.beside import FORBIDDEN

MANNERS = ("move", "at", "hold")
"""As what a symbol may be taken."""


def contested(program: Program) -> bool:
    """Tell whether a line, or one beside it, could want what another one takes."""
    lines = [(program, False)]
    for companion in program.whole.companions:
        forbidden = companion.relation in FORBIDDEN
        lines += [(inner, forbidden) for inner in standing(program, companion)]
    return any(
        not (unwanted and forbidden) and _clash(one, other)
        for (one, unwanted), (other, forbidden) in combinations(lines, 2)
    )


def _clash(one: Program, other: Program) -> bool:
    return any(touching(*states) for states in product(one.states, other.states))


def manner_of(state: State) -> str:
    """Return as what a state takes what it takes: what is gone through is a movement."""
    return state.manner if state.manner in MANNERS else MANNERS[0]


def touching(one: State, other: State) -> bool:
    """Tell whether two states can take the same symbol, whatever as."""
    if one.near or other.near:  # a symbol near a border may be on either side of it
        return not set(one.members).isdisjoint(other.members)
    return any(
        part == another and all(said[kind] & told[kind] for kind in said.keys() & told.keys())
        for (part, said), (another, told) in product(
            zip(one.members, one.fits, strict=True), zip(other.members, other.fits, strict=True)
        )
    )
