"""The words of elbows and knees that bend: ``bend 3+``, ``stretch``, ``bent``, ``straight``."""

from __future__ import annotations

from functools import lru_cache

from lanindex.alphabet import BENT, DEGREES_BENT, SIXTHS
from lanindex.model.bends import bending, stretching
from lanindex.search.language.times import sixths

MOVES = ("bend", "stretch")
"""What is said of an elbow or a knee, though its limb is named."""

WORDS = {
    **{name: name for name in (*MOVES, "bent", "straight")},
    **{"bends": "bend", "bending": "bend", "stretches": "stretch", "stretching": "stretch"},
    **{name: f"{name[:-1]} {name[-1]}" for name in DEGREES_BENT},
}
"""Every word, with its own spelling; a degree may follow all but ``straight``."""

MOST = stretching(SIXTHS)
"""The largest amount."""

_DEGREES = {
    **{"bend": (1, SIXTHS), "stretch": (0, SIXTHS)},
    **{"bent": (BENT, SIXTHS), "straight": (0, BENT - 1)},
}
"""To which degrees a limb bends or stretches, or is bent, if that is not said."""


@lru_cache(64)
def amounts(value: str) -> frozenset[str]:
    """Return which amounts of a symbol are meant: of bending, of stretching, or of either.

    Examples
    --------
    >>> from lanindex.search.language.bending import amounts
    >>> sorted(map(int, amounts("bend 5+"))), sorted(map(int, amounts("bent 5+")))
    ([5, 6], [5, 6, 12, 13])
    """
    how, _, said = value.partition(" ")
    least, most = sixths(said) if said else _DEGREES[how]
    some = range(least, (SIXTHS if most is None else min(most, SIXTHS)) + 1)
    ways = {"bend": (bending,), "stretch": (stretching,)}.get(how, (bending, stretching))
    return frozenset(str(way(degree)) for way in ways for degree in some)


def written(name: str, manner: str, told: str) -> str:
    """Return how a mover is written: of an elbow or a knee the limb, where its words tell.

    Examples
    --------
    >>> from lanindex.search.language.bending import written
    >>> written("leg_bends", "move", "bend 3+"), written("r_arm_bend", "move", "bent")
    ('legs', 'r_arm_bend')
    """
    tells = told and (manner in ("at", "hold") or told.split()[0] in MOVES)
    return name.replace("_bend", "", 1) if tells else name
