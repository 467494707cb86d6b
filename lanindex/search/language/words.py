"""The words of the pattern language, as tables.

Those that scores have too come from ``alphabet.py`` (directions, levels, parts) and ``words.toml``
(kinds of jumps such as ``hop``).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from lanindex.alphabet import (
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
from lanindex.data import shipped
from lanindex.model.columns import ABOVE, BELOW, GRADES, USUAL
from lanindex.model.derived import bending, stretching
from lanindex.search.language.times import degrees

_WORDS = shipped("words.toml")

ANY = "any"
STILL = "still"  # a rest without swings; so is the kind of words that asks for that
ABSENT = -1  # the code of a symbol that has no direction, no level or no amount

RELATIVE: dict[str, str] = _WORDS["relative"]
"""Directions relative to the limb's own side, and what they are for a right limb."""

BEND_MOVES = ("bend", "stretch")  # movements of an elbow or a knee, named by the limb

VALUES: dict[str, tuple[str, str]] = {
    **{name: ("direction", name) for name in (*DIRECTIONS, *RELATIVE, ANY)},
    **{name: ("level", name) for name in LEVELS},
    **{name: ("change", name) for name in ("rising", "sinking")},
    **{name: ("feet", name) for name in FEET},
    "circling": ("degrees", ">=45deg"),
    **{name: ("pace", name) for name in ("slow", "fast")},
    **{name: ("extent", name) for name in ("small", "large")},
    **{name: ("bend", name) for name in (*BEND_MOVES, "bent", "straight")},
    **{"bends": ("bend", "bend"), "bending": ("bend", "bend")},
    **{"stretches": ("bend", "stretch"), "stretching": ("bend", "stretch")},
    **{name: ("bend", f"{name[:-1]} {name[-1]}") for name in DEGREES_BENT},
    **{alias: ("direction", name) for alias, name in _WORDS["directions"].items()},
    **{"middle": ("level", "mid"), "normal": ("level", "mid")},
}
"""The kind and the own spelling of every word that says how a part moves."""


def _things(kind: str, names: Collection[str]) -> dict[str, tuple[str, str]]:
    plurals = {"feet" if name == "foot" else f"{name}s": name for name in names}
    known = {**{name: name for name in names}, **plurals, "torso": "trunk"}
    return {alias: (kind, name) for alias, name in known.items()}


THINGS = {"touched": _things("touched", TOUCHED), "carrier": _things("carrier", CARRIERS)}
"""Words as in `VALUES` that say something of a few tracks and elsewhere name a part, by kind."""


def values_for(kinds: Collection[str]) -> Mapping[str, tuple[str, str]]:
    """Return the words, as in `VALUES`, that are understood of tracks with some kinds of words."""
    known = VALUES
    for kind in THINGS.keys() & kinds:
        known = known | THINGS[kind]
    return known


@dataclass(frozen=True, slots=True)
class WordKind:
    """What the words of one kind describe."""

    noun: str
    codes: Mapping[str, int]  # by value
    numbers: range = range(0)  # codes that are numbers, and have no names

    @property
    def all(self) -> frozenset[int]:
        """Every code, and `ABSENT`."""
        return frozenset((*self.codes.values(), *self.numbers, ABSENT))


WORD_KINDS = {
    "direction": WordKind("direction", DIRECTION_CODES),
    "level": WordKind("level", LEVEL_CODES),
    "change": WordKind("change of level", {"sinking": 0, "neither": 1, "rising": 2}),
    "feet": WordKind("kind of jump", {it: FEET.index(it) for it in FEET}),
    "degrees": WordKind("angle", {}, range(MOST_AMOUNT + 1)),
    "bend": WordKind("degree of bending", {}, range(stretching(SIXTHS) + 1)),
    "pace": WordKind("speed", {"slow": BELOW, "usual": USUAL, "fast": ABOVE}),
    "extent": WordKind("size", {"small": BELOW, "usual": USUAL, "large": ABOVE}),
    "touched": WordKind("thing touched", {it: TOUCHED.index(it) for it in TOUCHED}),
    "carrier": WordKind("carrier", {it: CARRIERS.index(it) for it in CARRIERS}),
    STILL: WordKind("number of swings", {STILL: 0}),
}
"""Every kind of words; ``alphabet.KINDS`` has those of each kind of track."""

AMOUNTS = ("feet", "degrees", "bend", "touched", "carrier")  # a track has one of them
MOVING = ("change", *GRADES)  # said of a movement, and of no stay or rest
BESIDE_CELLS = (*AMOUNTS, *GRADES)  # not in a cell
_ALSO_NAMES = ("feet", "bend", *GRADES)  # words that may also be the name of a label or a pattern

DEGREES = "deg"
COUNT = re.compile(r"x(\d+)")  # a word that counts: x3
UNITS = {"s": "s", "ms": "ms", "f": "frames", "b": "beats"}  # of time, and what they are called

RELATIONS: dict[str, str] = _WORDS["relations"]
"""How a line may stand beside the first one, by the first word."""

RESTS = ("hold", STILL)
MANNERS = ("at", "via", *RESTS)  # how a part is or moves there

LANGUAGE = (
    *("then", *RELATIONS, "or"),
    *("not", *MANNERS, "start", "end", "mirror", "mirrors", "either", "rhythm"),
    *("where", "and", "clip", "match", "let", "count", "sort", "by", "first", "direction"),
)
"""The words that hold a pattern together; none of them can be a name."""


def with_article(noun: str) -> str:
    """Return ``an angle``, ``a level``."""
    return f"{'an' if noun[0] in 'aeio' else 'a'} {noun}"


def codes_of(kind: str, value: str, part: str) -> frozenset[int]:
    """Return the codes that a word means, said of one part; of ``any`` one is `ABSENT`."""
    if value == ANY:
        return WORD_KINDS[kind].all
    if kind == "degrees":
        least, most = degrees(value)
        return frozenset(range(least, (MOST_AMOUNT if most is None else most) + 1))
    if kind == "bend":
        return _bend_amounts(value)
    if value not in RELATIVE:
        return frozenset({WORD_KINDS[kind].codes[value]})
    right = DIRECTION_CODES[RELATIVE[value]]
    left = MIRRORED[right]
    # the side of a part that has none is either of the two
    return frozenset({"r_": {right}, "l_": {left}}.get(part[:2], {right, left}))


_BEND_RANGES = {
    **{"bend": (1, SIXTHS), "stretch": (0, SIXTHS)},
    **{"bent": (BENT, SIXTHS), "straight": (0, BENT - 1)},
}
"""The degrees that a word of elbows and knees means without a number."""


def _bend_amounts(value: str) -> frozenset[int]:
    """Return the amounts of bending, of stretching, or of both: ``bend 5+``, ``bent``."""
    word, _, degree = value.partition(" ")
    least, most = degrees(degree) if degree else _BEND_RANGES[word]
    some = range(least, (SIXTHS if most is None else min(most, SIXTHS)) + 1)
    moves = {"bend": (bending,), "stretch": (stretching,)}.get(word, (bending, stretching))
    return frozenset(move(degree) for move in moves for degree in some)


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
        return Mover(mirrored_part(self.name), "one", tuple(map(mirrored_part, self.members)))


def _place(part: str) -> tuple[bool, bool, str]:
    """Return a key that sorts limbs without a side first, then those with one, then the rest."""
    limb = is_limb(part)
    return not limb, part[:2] in ("r_", "l_"), part[2:] if limb else ""


def _movers(parts: Collection[str]) -> dict[str, Mover]:
    movers = {name: Mover(name, "one", (name,)) for name in parts}
    aliases = dict(_WORDS["parts"]["short"])
    for group in [name[2:] for name in parts if name[:2] in ("r_", "l_")]:
        pair = (f"r_{group}", f"l_{group}")
        plural = _WORDS["parts"]["plurals"].get(group, f"{group}s")
        movers.setdefault(group, Mover(group, "either", pair))
        movers.setdefault(plural, Mover(plural, "both", pair))
        aliases |= {f"right_{group}": pair[0], f"left_{group}": pair[1]}
        aliases |= {f"either_{group}": group, f"both_{plural}": plural}
    for alias, name in aliases.items():
        if name in movers:
            movers.setdefault(alias, movers[name])
    return movers


class Vocabulary:
    """The names of parts: those of a library, and in any case those of the alphabet."""

    def __init__(self, parts: Collection[str] | None = None) -> None:
        self.parts = tuple(sorted(TRACKS if parts is None else parts, key=_place))
        self.held = frozenset(self.parts)
        self.movers = _movers(dict.fromkeys((*TRACKS, *self.parts)))

    def mover(self, *words: str) -> Mover | None:
        """Return who is named by a word, or by several: ``right arm``, ``right hand touch``."""
        known = len(words) == 1 or words[0] in _WORDS["parts"]["first"]
        return self.movers.get("_".join(words)) if known else None

    def names(self, begun: str = "", form: str = "") -> Iterator[str]:
        """Yield how names of a library's movers go on that begin so, ``right_``, by limb."""
        if not begun or begun.partition("_")[0] in _WORDS["parts"]["first"]:
            order = {name: number for number, name in enumerate(self.movers)}
            near = sorted(self.movers.items(), key=lambda it: order.get(it[1].members[0], 0))
            for name, mover in near:
                held = not self.held.isdisjoint(mover.members) and form in ("", mover.form)
                if held and name.startswith(begun):
                    yield name.removeprefix(begun)

    def of(self, form: str, members: tuple[str, ...]) -> Mover | None:
        """Return the mover with this form and these members, as `Mover` has them."""
        those = (form, members)
        return next((it for it in self.movers.values() if (it.form, it.members) == those), None)

    def meaning_of(self, word: str) -> str:
        """Return the meaning of a word that cannot be a name; empty where it can."""
        kind, _ = VALUES.get(word, ("feet", ""))
        if word in LANGUAGE or kind not in _ALSO_NAMES:
            return "a word of the language"
        mover = self.mover(word)
        return "a part" if mover and is_limb(mover.members[0]) else ""
