"""The words of the pattern language, as tables.

Directions and levels come from the alphabet; here are their aliases, the directions that are
relative to a limb's own side, the words of the language itself, and the names of the parts.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

from lanindex.alphabet import (
    BENDS,
    BENT,
    CARRIERS,
    DEGREES_BENT,
    DIRECTION_CODES,
    DIRECTIONS,
    FEET,
    LEVEL_CODES,
    LEVELS,
    MIRRORED,
    MOST_AMOUNT,
    SIXTHS,
    TOUCHED,
    TRACKS,
    is_limb,
    mirrored_part,
)
from lanindex.model.bends import bending, stretching
from lanindex.model.measures import ABOVE, BELOW, GRADES, USUAL
from lanindex.search.language.times import degrees

ANY = "any"
ABSENT = ""  # what a symbol is that has no direction, no level or no amount

RELATIVE = {
    **{"side": "right", "side_forward": "r_forward", "side_back": "r_back"},
    **{"across": "left", "across_forward": "l_forward", "across_back": "l_back"},
}
"""Directions relative to the limb's own side, with what they are for a right limb."""

ACROSS = tuple(name for name in RELATIVE if name.startswith("across"))
"""Those that only what has a side can take."""

CHANGES = ("rising", "sinking")  # how a level compares with the one before
PACES = ("slow", "fast")  # how a movement's speed compares with others of its group of parts
EXTENTS = ("small", "large")  # and its size

BEND_MOVES = ("bend", "stretch")  # what is said of an elbow or a knee, though its limb is named
BEND_WORDS = {
    **{name: name for name in (*BEND_MOVES, "bent", "straight")},
    **{"bends": "bend", "bending": "bend", "stretches": "stretch", "stretching": "stretch"},
    **{name: f"{name[:-1]} {name[-1]}" for name in DEGREES_BENT},
}
"""Every word of elbows and knees, with its own spelling; a degree may follow but ``straight``."""

_DIRECTION_ALIASES = {
    "backward": "back",
    "side_backward": "side_back",
    "across_backward": "across_back",
    **{
        alias: f"{side[0]}_{name}"
        for side in ("right", "left")
        for end, name in (("forward", "forward"), ("back", "back"), ("backward", "back"))
        for alias in (f"{side}_{end}", f"{side[0]}_{end}", f"{end}_{side}")
    },
}

VALUES: dict[str, tuple[str, str]] = {
    **{name: ("direction", name) for name in (*DIRECTIONS, *RELATIVE, ANY)},
    **{name: ("level", name) for name in LEVELS},
    **{name: ("change", name) for name in CHANGES},
    **{name: ("feet", name) for name in FEET},
    "circling": ("degrees", ">=45deg"),
    **{name: ("pace", name) for name in PACES},
    **{name: ("extent", name) for name in EXTENTS},
    **{alias: ("bend", name) for alias, name in BEND_WORDS.items()},
    **{alias: ("direction", name) for alias, name in _DIRECTION_ALIASES.items()},
    **{"middle": ("level", "mid"), "normal": ("level", "mid")},
}
"""Every word that says how a part moves: its kind and its own spelling."""


def _things(kind: str, names: Collection[str]) -> dict[str, tuple[str, str]]:
    """Return the words of a kind, also in the plural."""
    plurals = {"feet" if name == "foot" else f"{name}s": name for name in names}
    known = {**{name: name for name in names}, **plurals, "torso": "trunk"}
    return {alias: (kind, name) for alias, name in known.items()}


THINGS = {kind: _things(kind, it) for kind, it in (("touched", TOUCHED), ("carrier", CARRIERS))}
"""Words as in `VALUES` that say something of a few tracks and elsewhere name a part, by kind."""


def values_for(kinds: Collection[str]) -> Mapping[str, tuple[str, str]]:
    """Return the words, as in `VALUES`, that tracks understand of which some kinds can be said.

    Examples
    --------
    >>> from lanindex.search.language.words import values_for
    >>> values_for(["touched"])["knees"], "knee" in values_for(["direction"])
    (('touched', 'knee'), False)
    """
    things = [THINGS[kind] for kind in kinds if kind in THINGS]
    known = (VALUES, *things)
    return {word: it for one in known for word, it in one.items()} if things else VALUES


class Numbers(Mapping[str, int]):
    """Whole numbers by their names, ``90``: from 0 to the most, none of them kept."""

    def __init__(self, most: int) -> None:
        self._most = most

    def __getitem__(self, name: str) -> int:
        return int(name)

    def __iter__(self) -> Iterator[str]:
        return map(str, range(self._most + 1))

    def __len__(self) -> int:
        return self._most + 1


def _codes(names: Collection[str]) -> dict[str, int]:
    return {name: code for code, name in enumerate(names)}


@dataclass(frozen=True, slots=True)
class WordKind:
    """What words of one kind speak of."""

    noun: str  # what a movement has one of
    column: str  # the field of a symbol that tells; empty: worked out from the symbols before
    codes: Mapping[str, int]  # what a movement can be, with its code; `ABSENT` is -1 everywhere
    mirrored: Mapping[str, str] = field(default_factory=dict)  # of what is not its own image


WORD_KINDS = {
    "direction": WordKind(
        "direction",
        "direction",
        DIRECTION_CODES,
        {name: DIRECTIONS[MIRRORED[code]] for code, name in enumerate(DIRECTIONS)},
    ),
    "level": WordKind("level", "level", LEVEL_CODES),
    "change": WordKind("change of level", "", {"sinking": 0, "neither": 1, "rising": 2}),
    "feet": WordKind("kind of jump", "amount", _codes(FEET)),
    "degrees": WordKind("angle", "amount", Numbers(MOST_AMOUNT)),
    "bend": WordKind("degree of bending", "amount", Numbers(stretching(SIXTHS))),
    **{
        kind: WordKind(noun, "", {below: BELOW, "usual": USUAL, above: ABOVE})
        for kind, noun, (below, above) in (("pace", "speed", PACES), ("extent", "size", EXTENTS))
    },
    "touched": WordKind("thing touched", "amount", _codes(TOUCHED)),
    "carrier": WordKind("carrier", "amount", _codes(CARRIERS)),
}
"""Every kind of words; ``alphabet.KINDS`` tells which can be said of whose track."""

# Kinds of words that speak of ...
AMOUNTS = ("feet", "degrees", "bend", "touched", "carrier")  # an amount: a track has one of them
MOVING = ("change", *GRADES)  # a movement, and of no stay or rest
BESIDE_CELLS = (*AMOUNTS, *GRADES)  # what no cell tells
_NAMES_TOO = ("feet", "bend", *GRADES)  # what a colon or an @ can make a name

DEGREES = "deg"
UNITS = {"s": "s", "ms": "ms", "f": "frames", "b": "beats"}  # of time, with what they are called

ONE_WORD_RELATIONS = ("with", "overlapping", "during", "without", "after", "before", "never")
TWO_WORD_RELATIONS = ("starting", "ending", "exactly")
"""How a line may stand beside the first one; ``with`` follows those of two words."""

MANNERS = ("at", "via", "hold")  # words that say how a part is or moves there

LANGUAGE = (
    *("then", *ONE_WORD_RELATIONS, *TWO_WORD_RELATIONS, "or"),
    *("not", *MANNERS, "start", "end", "mirror", "mirrors", "either", "rhythm"),
    *("where", "and", "clip", "match", "let", "count", "sort", "by", "first", "direction"),
)
"""The words that hold a pattern together; none of them can be a name."""

_APART = (
    *("right", "left", "either", "both", "body", "other", "torso", "head"),
    *("hand", "hands", "r_hand", "l_hand"),
)
"""Words that may stand before a part and tell which: ``right arm``, ``body turn``."""

_SHORT = {
    **{"travel": "body_travel", "turn": "body_turn"},
    **{"twist": "torso_twist", "incline": "torso_incline"},
}
_PLURALS = {"foot": "feet", "hand_touch": "hand_touches"}


def with_article(noun: str) -> str:
    """Return ``an angle``, ``a level``."""
    return f"{'an' if noun[0] in 'aeio' else 'a'} {noun}"


def mirrored_value(kind: str, value: str) -> str:
    """Return the mirror image of a word; relative directions and ``any`` are their own."""
    return WORD_KINDS[kind].mirrored.get(value, value)


def values_of(kind: str, value: str, part: str) -> frozenset[str]:
    """Return what a word stands for, said of one part (``l_arm``).

    Only ``any`` says nothing, so that what has no direction will do as well. What has no side of
    its own goes to either.
    """
    if value == ANY:
        return frozenset((*WORD_KINDS[kind].codes, ABSENT))
    if kind == "degrees":
        return _angles(value)
    if kind == "bend":
        return bend_amounts(value)
    if value not in RELATIVE:
        return frozenset({value})
    right = RELATIVE[value]
    left = mirrored_value(kind, right)
    return frozenset({"r_": {right}, "l_": {left}}.get(part[:2], {right, left}))


@lru_cache(64)
def _angles(value: str) -> frozenset[str]:
    """Return the whole degrees of an angle as written: ``90deg``, ``>180deg``."""
    least, most = degrees(value)
    return frozenset(map(str, range(least, (MOST_AMOUNT if most is None else most) + 1)))


_BEND_RANGES = {
    **{"bend": (1, SIXTHS), "stretch": (0, SIXTHS)},
    **{"bent": (BENT, SIXTHS), "straight": (0, BENT - 1)},
}
"""To which degrees a limb bends or stretches, or is bent, if that is not said."""


@lru_cache(64)
def bend_amounts(value: str) -> frozenset[str]:
    """Return which amounts of a symbol are meant: of bending, of stretching, or of either.

    Examples
    --------
    >>> from lanindex.search.language.words import bend_amounts
    >>> sorted(map(int, bend_amounts("bend 5+"))), sorted(map(int, bend_amounts("bent 5+")))
    ([5, 6], [5, 6, 12, 13])
    """
    word, _, degree = value.partition(" ")
    least, most = degrees(degree) if degree else _BEND_RANGES[word]
    some = range(least, (SIXTHS if most is None else min(most, SIXTHS)) + 1)
    ways = {"bend": (bending,), "stretch": (stretching,)}.get(word, (bending, stretching))
    return frozenset(str(way(degree)) for way in ways for degree in some)


@dataclass(frozen=True, slots=True)
class Mover:
    """Who moves: one part, either of a pair, or both at once."""

    name: str  # as written: r_arm, arm, arms
    form: str  # one, either, both
    members: tuple[str, ...]  # the parts it may mean; of a pair the right one first

    def __str__(self) -> str:
        return self.name

    @property
    def sided(self) -> bool:
        """Whether it has a side of its own."""
        return all(member[:2] in ("r_", "l_") for member in self.members)

    def mirrored(self) -> Mover:
        """Return who moves in the mirror."""
        if self.form != "one":
            return self
        name = mirrored_part(self.name)
        return Mover(name, "one", (name,))


def written(name: str, manner: str, bend: str) -> str:
    """Return how a mover is written: of an elbow or a knee the limb, where its words tell.

    Examples
    --------
    >>> from lanindex.search.language.words import written
    >>> written("leg_bends", "move", "bend 3+"), written("r_arm_bend", "move", "bent")
    ('legs', 'r_arm_bend')
    """
    tells = bend and (manner in ("at", "hold") or bend.split()[0] in BEND_MOVES)
    return name.replace("_bend", "", 1) if tells else name


def _place(part: str) -> tuple[bool, bool, str]:
    """Return what to sort parts by: those without a side, those with one, the whole body."""
    limb = is_limb(part)
    return not limb, part[:2] in ("r_", "l_"), part[2:] if limb else ""


def _movers(parts: Collection[str]) -> dict[str, Mover]:
    movers = {name: Mover(name, "one", (name,)) for name in parts}
    aliases = dict(_SHORT)
    for group in [name[2:] for name in parts if name[:2] in ("r_", "l_")]:
        pair = (f"r_{group}", f"l_{group}")
        plural = _PLURALS.get(group, f"{group}s")
        movers.setdefault(group, Mover(group, "either", pair))
        movers.setdefault(plural, Mover(plural, "both", pair))
        aliases |= {f"right_{group}": pair[0], f"left_{group}": pair[1]}
        aliases |= {f"either_{group}": group, f"both_{plural}": plural}
    known = {alias: movers[name] for alias, name in aliases.items() if name in movers}
    return movers | {alias: mover for alias, mover in known.items() if alias not in movers}


class Vocabulary:
    """The words that a pattern may use, those of the parts included.

    The parts are those that the library has, by default those of the alphabet. A pattern may name
    these in any case: one that no capture has never moves.
    """

    def __init__(self, parts: Collection[str] | None = None) -> None:
        self.of_library = parts is not None
        self.parts = tuple(sorted(TRACKS if parts is None else parts, key=_place))
        self.movers = _movers(dict.fromkeys((*TRACKS, *self.parts)))

    def mover(self, word: str) -> Mover | None:
        """Return who a word names."""
        return self.movers.get(word)

    def bending(self, mover: Mover) -> Mover | None:
        """Return whose elbow or knee bends when a limb does; None where that is not known."""
        return self.of(mover.form, tuple(BENDS.get(part, "") for part in mover.members))

    def of(self, form: str, members: tuple[str, ...]) -> Mover | None:
        """Return who moves in a form, one, either or both, and may mean certain parts."""
        those = (form, members)
        return next((it for it in self.movers.values() if (it.form, it.members) == those), None)

    def spelt_apart(self, *words: str) -> Mover | None:
        """Return whom words name together: ``right arm``, ``right hand touch``; or None."""
        return self.movers.get("_".join(words)) if words[0] in _APART else None

    def taken(self, word: str) -> str:
        """Return what a word means, so that it can be no name; nothing of the whole body's."""
        kind, _ = VALUES.get(word, ("feet", ""))
        if word in LANGUAGE or kind not in _NAMES_TOO:
            return "a word of the language"
        mover = self.mover(word)
        return "a part" if mover and is_limb(mover.members[0]) else ""
