"""The alphabet as one table: directions, levels, joints and parts of the body.

Names, codes, angles and mirror images come from here and from nowhere else; encoding, notation,
storage, search and drawing read it. A direction's code is its azimuth in steps of 45 degrees
(right 0, forward 2, left 4, back 6), with ``place`` behind them.
"""

import re
from dataclasses import dataclass
from typing import Any

from lanindex.data import shipped

_WORDS = shipped("words.toml")

DIRECTIONS = (
    *("right", "r_forward", "forward", "l_forward", "left", "l_back", "back", "r_back"),
    "place",
)
"""Names by code; code k < 8 points to azimuth 45 k degrees, 0 right and 90 forward."""

LEVELS = ("low", "mid", "high")
"""Names by code; level k points to elevation 45, 90, 135 degrees from straight down."""

PLACE = DIRECTIONS.index("place")
LOW, MID, HIGH = range(3)

DIRECTION_CODES = {name: code for code, name in enumerate(DIRECTIONS)}
LEVEL_CODES = {name: code for code, name in enumerate(LEVELS)}

MIRRORED = tuple((4 - code) % 8 if code < PLACE else PLACE for code in range(len(DIRECTIONS)))
"""The code of each direction's mirror image (left for right)."""

JOINTS = (
    *("Pelvis", "Chest", "Neck", "Head"),
    *("RShoulder", "RElbow", "RWrist", "RHand", "RHip", "RKnee", "RAnkle", "RToe"),
    *("LShoulder", "LElbow", "LWrist", "LHand", "LHip", "LKnee", "LAnkle", "LToe"),
)
"""The 20 joints of the body model.

Source: ``encoding/METHOD.md``, stage 0; Matsumoto and Hachimura (2001), figure 2.
"""

JOINT_CODES = {name: code for code, name in enumerate(JOINTS)}

PALMS = {"RPalm": "RHand", "LPalm": "LHand"}
"""The point in front of each palm (no joint), and the hand that says where the palm faces.

Source: ``encoding/BODY.md``, "Palms".
"""

FEET: tuple[str, ...] = tuple(_WORDS["jumps"])
"""Which feet a jump leaves and lands on, by the symbol's amount."""

TOUCHED: tuple[str, ...] = tuple(_WORDS["touched"])
"""What a hand touches, by the symbol's amount."""

CARRIERS: tuple[str, ...] = tuple(_WORDS["carriers"])
"""What carries the body beside the feet or instead of them, by the symbol's amount."""

MOST_AMOUNT = (1 << 15) - 2
"""The largest amount of a symbol: that many degrees are 91 turns, and more are stored as this."""

FASTEST = 40.94
"""The highest speed that a symbol can store."""

SIXTHS = 6
"""The number of degrees of bending; at the last one the ends of a limb meet."""

DEGREES_BENT = tuple(f"{way}{it}" for way in ("bend", "stretch") for it in range(SIXTHS + 1))
"""To which degree a limb is bent or stretched, by the symbol's amount."""

BENT = 2
"""The least degree that counts as bent: hanging arms and standing legs are bent by less."""

HOW_BENT = ("",) * BENT + tuple(f"bent {degree}" for degree in range(BENT, SIXTHS + 1))
"""How far an arm or a leg with a direction is bent, in words, by the symbol's amount."""


@dataclass(frozen=True, slots=True)
class Kind:
    """What the symbols of a track say: a row of ``words.toml``."""

    name: str
    # Kinds of words of the pattern language that fit it: first those of its fields
    words: tuple[str, ...]
    fields: tuple[str, ...]  # Which of a symbol's direction, level and amount it has
    # What its lines in LND begin with; empty: its symbols come from those of other tracks
    keyword: str = ""
    directions: tuple[str, ...] = DIRECTIONS  # Those that it can have
    amounts: tuple[str, ...] = ()  # What its amounts are called, by number; empty: they are degrees
    measures: tuple[str, ...] = ()  # Which of `MEASURES` can be known of it
    # Whether its symbols say where something is from then on, so that each known stretch begins
    # with a starting position
    lasts: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """What its fields are called where they are read or written: an amount by what it is."""
        return self.words[: len(self.fields)]

    def amount(self, number: int) -> str:
        """Return an amount in words: ``hop``, ``90deg``."""
        return self.amounts[number] if number < len(self.amounts) else f"{number}deg"


MEASURES = ("speed", "size", "straightness")
"""What is measured of a movement but written in no notation: how fast, how far, how straight."""

_AMOUNTS = {
    **{"gesture": HOW_BENT, "bend": DEGREES_BENT},
    **{"jump": FEET, "touch": TOUCHED, "carrier": CARRIERS},
}


def _kind(name: str, row: dict[str, Any]) -> Kind:
    fields: dict[str, Any] = {
        it: tuple(row[it]) if type(row[it]) is list else row[it] for it in row
    }
    return Kind(name=name, amounts=_AMOUNTS.get(name, ()), **fields)


KINDS = {name: _kind(name, row) for name, row in _WORDS["kind"].items()}
"""Every kind of track, by name; a library stores its place in this table."""

LINES = {kind.keyword: kind for kind in KINDS.values() if kind.keyword}
"""Every kind whose symbols have lines of their own in LND, by the word those begin with."""


@dataclass(frozen=True, slots=True)
class Part:
    """One part of the body that moves: a child joint seen from a parent joint."""

    name: str  # As written in LND: ``r_arm``
    group: str  # The part without its side: ``arm``; profiles keep one set of files a group
    side: str  # ``r``, ``l`` or the empty string
    # Joints from the parent to the child; the part's length is the sum of the bones between. A
    # palm's is one of `PALMS`
    chain: tuple[str, ...]

    @property
    def parent(self) -> str:
        """The joint that the movement is seen from."""
        return self.chain[0]

    @property
    def child(self) -> str:
        """The joint that moves."""
        return self.chain[-1]


_PAIRED: dict[str, list[str]] = _WORDS["paired"]
_SINGLE: dict[str, list[str]] = _WORDS["single"]

PARTS: dict[str, Part] = {
    **{
        f"{side}_{group}": Part(
            f"{side}_{group}", group, side, tuple(side.upper() + joint for joint in chain)
        )
        for group, chain in _PAIRED.items()
        for side in "rl"
    },
    **{name: Part(name, name, "", tuple(chain)) for name, chain in _SINGLE.items()},
}
"""Every part that is encoded as a limb, by name."""

FACING = tuple(name for name, part in PARTS.items() if part.child in PALMS)
"""The tracks of palms, which not every capture has."""

ALWAYS = tuple(name for name in PARTS if name not in FACING)
"""The parts that any capture may have."""

BODY: tuple[str, ...] = tuple(_WORDS["body"])
"""The tracks of the whole body, in order."""

BENDS = {part: f"{part}_bend" for part in PARTS if part[2:] in ("arm", "leg")}
"""The tracks of elbows and knees, by the limb they belong to."""

CONTACTS: tuple[str, ...] = tuple(_WORDS["contacts"])
"""The tracks of contacts: of the body with the ground, of hands with each other and the body."""

TRACKS = (*PARTS, *BODY, *BENDS.values(), *CONTACTS)
"""Every track, in the order in which they are shown."""

GROUPS = (*_PAIRED, *_SINGLE)
"""The groups of parts that share a profile's files."""


def mirrored_part(name: str) -> str:
    """Return the part on the other side: ``l_arm`` for ``r_arm``, ``head`` for ``head``."""
    return {"r_": "l_", "l_": "r_"}.get(name[:2], name[:2]) + name[2:]


def group_of(part: str) -> str:
    """Return a part's name without its side."""
    return part[2:] if part[:2] in ("r_", "l_") else part


_SPOKEN = {"r_": "right ", "l_": "left ", "body_": ""}


def plain(words: str) -> str:
    """Return names of parts and directions in some words as a person says them.

    >>> from lanindex.alphabet import plain
    >>> plain("r_arm_bend"), plain("body_travel"), plain("r_arm l_forward high")
    ('right arm bend', 'travel', 'right arm left forward high')
    """
    return re.sub(r"\b(r|l|body)_", lambda it: _SPOKEN[it[0]], words).replace("_", " ")


def is_limb(part: str) -> bool:
    """Return whether a part has a starting position: what the body does as a whole has none."""
    return kind_of(part) in ("gesture", "support", "bend")


def amounts_of(part: str) -> tuple[str, ...]:
    """Return the words for the amounts of a part's track; empty where they are numbers."""
    if part == "hands_touch":
        return TOUCHED[:1]
    kind = KINDS[kind_of(part)]
    return kind.amounts[1:] if kind.name == "touch" else kind.amounts


_KIND_OF_GROUP: dict[str, str] = _WORDS["kinds"]


def kind_of(part: str) -> str:
    """Return the kind of a part's track; of an unknown part, ``gesture``."""
    return _KIND_OF_GROUP.get(group_of(part), "gesture")
