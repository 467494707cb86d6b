"""The words of the pattern language, as tables.

Directions and levels come from the alphabet; here are their other spellings, the directions that
are relative to a limb's own side, the words of the language itself, and the names of the parts.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

from lanindex.alphabet import (
    BENDS,
    CARRIERS,
    DIRECTION_CODES,
    DIRECTIONS,
    FEET,
    LEVEL_CODES,
    LEVELS,
    MIRRORED,
    MOST_AMOUNT,
    TOUCHED,
    TRACKS,
    is_limb,
    mirrored_part,
)
from lanindex.model.measures import ABOVE, BELOW, GRADES, USUAL
from lanindex.search.language import bending
from lanindex.search.language.meant import LIMBS, MEANT
from lanindex.search.language.times import degrees

ANY = "any"

RELATIVE = {
    "side": "right",
    "side_forward": "r_forward",
    "side_back": "r_back",
    "across": "left",
    "across_forward": "l_forward",
    "across_back": "l_back",
}
"""Directions relative to the limb's own side, with what they are for a right limb."""

ACROSS = tuple(name for name in RELATIVE if name.startswith("across"))
"""Those that only what has a side can take."""

CHANGES = ("rising", "sinking")
"""How a level compares with the one before."""

PACES = ("slow", "fast")
EXTENTS = ("small", "large")
"""How a movement's speed and size compare with those of its group of parts."""

_OTHER_DIRECTIONS = {
    "backward": "back",
    "side_backward": "side_back",
    "across_backward": "across_back",
    **{
        spelling: f"{side[0]}_{name}"
        for side in ("right", "left")
        for name, spellings in {"forward": ("forward",), "back": ("back", "backward")}.items()
        for end in spellings
        for spelling in (f"{side}_{end}", f"{side[0]}_{end}", f"{end}_{side}")
    },
}
_OTHER_LEVELS = {"middle": "mid", "normal": "mid"}

VALUES: dict[str, tuple[str, str]] = {
    **{name: ("direction", name) for name in (*DIRECTIONS, *RELATIVE, ANY)},
    **{name: ("level", name) for name in LEVELS},
    **{name: ("change", name) for name in CHANGES},
    **{name: ("feet", name) for name in FEET},
    "circling": ("degrees", ">=45deg"),
    **{name: ("pace", name) for name in PACES},
    **{name: ("extent", name) for name in EXTENTS},
    **{word: ("bend", name) for word, name in bending.WORDS.items()},
    **{spelling: ("direction", name) for spelling, name in _OTHER_DIRECTIONS.items()},
    **{spelling: ("level", name) for spelling, name in _OTHER_LEVELS.items()},
}
"""Every word that says how a part moves: its kind and its own spelling."""

ABSENT = ""
"""What a symbol is that has no direction, no level or no amount."""


class Numbers(Mapping[str, int]):
    """Whole numbers by their names, ``90``: from 0 to the most, none of them kept."""

    def __init__(self, most: int) -> None:
        self._most = most

    def __getitem__(self, name: str) -> int:
        """Return a number by its name."""
        return int(name)

    def __iter__(self) -> Iterator[str]:
        """Yield all names."""
        return map(str, range(self._most + 1))

    def __len__(self) -> int:
        """Return how many numbers there are."""
        return self._most + 1


@dataclass(frozen=True, slots=True)
class WordKind:
    """What words of one kind speak of.

    Attributes
    ----------
    noun : str
        What a movement has one of.
    column : str
        The field of a symbol that tells; empty: worked out from the symbols before.
    codes : Mapping of str to int
        What a movement can be, with its code there; `ABSENT` is -1 everywhere.
    mirrored : Mapping of str to str
        The mirror image of what is not its own.
    """

    noun: str
    column: str
    codes: Mapping[str, int]
    mirrored: Mapping[str, str] = field(default_factory=dict)


WORD_KINDS = {
    "direction": WordKind(
        "direction",
        "direction",
        DIRECTION_CODES,
        {name: DIRECTIONS[MIRRORED[code]] for code, name in enumerate(DIRECTIONS)},
    ),
    "level": WordKind("level", "level", LEVEL_CODES),
    "change": WordKind("change of level", "", {"sinking": 0, "neither": 1, "rising": 2}),
    "feet": WordKind("kind of jump", "amount", {name: code for code, name in enumerate(FEET)}),
    "degrees": WordKind("angle", "amount", Numbers(MOST_AMOUNT)),
    "bend": WordKind("degree of bending", "amount", Numbers(bending.MOST)),
    **{
        kind: WordKind(noun, "", {below: BELOW, "usual": USUAL, above: ABOVE})
        for kind, noun, (below, above) in (("pace", "speed", PACES), ("extent", "size", EXTENTS))
    },
    "touched": WordKind(
        "thing touched", "amount", {name: code for code, name in enumerate(TOUCHED)}
    ),
    "carrier": WordKind("carrier", "amount", {name: code for code, name in enumerate(CARRIERS)}),
}
"""Every kind of words; ``alphabet.KINDS`` tells which can be said of whose track."""

AMOUNTS = ("feet", "degrees", "bend", "touched", "carrier")
"""The kinds of words that speak of a symbol's amount: no two can be said of one track."""

MOVING = ("change", *GRADES)
"""The kinds of words that speak of a movement, and of no stay or rest."""

BESIDE_CELLS = (*AMOUNTS, *GRADES)
"""The kinds of words that speak of what no cell tells."""

NAMES_TOO = ("feet", "bend", *GRADES)
"""The kinds of words that may also be names: a colon or an @ tells which is meant."""

DEGREES = "deg"
"""The unit of a turn."""

UNITS = ("s", "ms", "f", "b")
"""Units of time: seconds, milliseconds, frames of the source, beats."""

ONE_WORD_RELATIONS = ("with", "during", "without", "after", "before", "never")
"""How a line may stand beside the first one, in one word."""

TWO_WORD_RELATIONS = ("starting", "ending", "exactly")
"""Words that ``with`` follows: of relations of two words."""

LANGUAGE = (
    *("then", *ONE_WORD_RELATIONS, *TWO_WORD_RELATIONS, "or"),
    *("not", "at", "via", "hold", "start", "end", "mirror", "mirrors", "either", "rhythm"),
    *("where", "and", "clip", "match", "let", "count", "sort", "by", "first", "direction"),
)
"""The words that hold a pattern together; none of them can be a name."""

APART = (
    *("right", "left", "either", "both", "body", "other", "torso", "head"),
    *("hand", "hands", "r_hand", "l_hand"),
)
"""Words that may stand before a part and tell which: ``right arm``, ``body turn``."""

_SHORT = {
    **{"travel": "body_travel", "turn": "body_turn"},
    **{"twist": "torso_twist", "incline": "torso_incline"},
}
"""What parts are called for short."""

_PLURALS = {"foot": "feet", "hand_touch": "hand_touches"}


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
        return bending.amounts(value)
    absolute = RELATIVE.get(value, value)
    there = {"r_": {absolute}, "l_": {mirrored_value(kind, absolute)}}
    either = {absolute, mirrored_value(kind, absolute)}
    return frozenset(there.get(part[:2], either) if value in RELATIVE else {absolute})


@lru_cache(64)
def _angles(value: str) -> frozenset[str]:
    """Return the whole degrees of an angle as written: ``90deg``, ``>180deg``."""
    least, most = degrees(value)
    known = WORD_KINDS["degrees"].codes
    return frozenset(map(str, range(least, len(known) if most is None else most + 1)))


@dataclass(frozen=True, slots=True)
class Mover:
    """Who moves: one part, either of a pair, or both at once.

    Attributes
    ----------
    name : str
        As written: ``r_arm``, ``arm``, ``arms``.
    form : str
        ``one``, ``either`` or ``both``.
    members : tuple of str
        The parts it may mean; of a pair the right one first.
    """

    name: str
    form: str
    members: tuple[str, ...]

    def __str__(self) -> str:
        """Return the name as it is written in a pattern."""
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


def _place(part: str) -> tuple[bool, bool, str]:
    """Return what to sort parts by: those without a side, those with one, the whole body."""
    limb = is_limb(part)
    return not limb, part[:2] in ("r_", "l_"), part[2:] if limb else ""


def _movers(parts: Collection[str]) -> dict[str, Mover]:
    movers = {name: Mover(name, "one", (name,)) for name in parts}
    for name in parts:
        if name[:2] in ("r_", "l_"):
            group = name[2:]
            pair = (f"r_{group}", f"l_{group}")
            plural = _PLURALS.get(group, f"{group}s")
            movers.setdefault(group, Mover(group, "either", pair))
            movers.setdefault(plural, Mover(plural, "both", pair))
            meant = {"right": f"r_{group}", "left": f"l_{group}", "either": group, "both": plural}
            for word, mover in meant.items():
                if mover in movers:
                    said = f"{word}_{plural if word == 'both' else group}"
                    movers.setdefault(said, movers[mover])
    for short, name in _SHORT.items():
        if name in movers:
            movers.setdefault(short, movers[name])
    return movers


class Vocabulary:
    """The words that a pattern may use, those of the parts included.

    Parameters
    ----------
    parts : collection of str, optional
        The parts that the library has; by default those of the alphabet. A pattern may name
        these in any case: one that no capture has never moves.
    """

    def __init__(self, parts: Collection[str] | None = None) -> None:
        self._owner = "There is" if parts is None else "This library has"
        self.parts = tuple(sorted(TRACKS if parts is None else parts, key=_place))
        self.movers = _movers({*TRACKS, *self.parts})

    def mover(self, word: str) -> Mover | None:
        """Return who a word names, or None."""
        return self.movers.get(word)

    def bending(self, mover: Mover) -> Mover | None:
        """Return whose elbow or knee bends when a limb does; None where that is not known."""
        members = tuple(BENDS.get(part, "") for part in mover.members)
        those = (mover.form, members)
        return next((it for it in self.movers.values() if (it.form, it.members) == those), None)

    def spelt_apart(self, *words: str) -> Mover | None:
        """Return whom words name together: ``right arm``, ``right hand touch``; or None."""
        return self.movers.get("_".join(words)) if words[0] in APART else None

    def taken(self, word: str) -> str:
        """Return what a word means, so that it can be no name; or nothing.

        Words of `NAMES_TOO`, and the tracks of the whole body, may be names: a colon or an @ tells
        which is meant.
        """
        kind, _ = VALUES.get(word, ("feet", ""))
        if word in LANGUAGE or word == "then" or kind not in NAMES_TOO:
            return "a word of the language"
        mover = self.mover(word)
        return "a part" if mover and is_limb(mover.members[0]) else ""

    def stranger(self, word: str, part_expected: bool) -> str:
        """Return the sentence about a word that is not in the vocabulary."""
        if guess := self._guess(word.lower(), part_expected):
            return f'I don\'t know "{word}". Did you mean "{guess}"?'
        if part_expected:
            has = "The parts are" if self._owner == "There is" else "It has"
            return f'{self._owner} no part "{word}". {has}: {" ".join(self.parts) or "none"}'
        return (
            f'I don\'t know "{word}". A movement has a direction ({", ".join(DIRECTIONS[:4])} …) '
            f"and a level (high, mid, low)."
        )

    def _guess(self, word: str, part_expected: bool) -> str | None:
        from rapidfuzz import process
        from rapidfuzz.distance import OSA

        from lanindex.search.dictionary import load

        named = {name: f"@{name}" for name in load()} if part_expected else {}
        if word in named:
            return named[word]
        if word in MEANT:
            return MEANT[word]
        side = next((it for it in ("right_", "left_", "r_", "l_") if word.startswith(it)), "")
        limb = (side[:1] and f"{side[0]}_") + LIMBS.get(word.removeprefix(side), "")
        if limb in self.movers:
            return limb
        known = [*VALUES, *self.movers, *LANGUAGE, *named]
        jumbled = [it for it in known if sorted(it) == sorted(word)]
        found = process.extractOne(word, known, scorer=OSA.normalized_similarity, score_cutoff=0.7)
        guess = jumbled[0] if jumbled else found[0] if found else ""
        return named.get(guess, guess) or None
