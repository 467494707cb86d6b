"""Plain words → the pattern that says it: what people type before they know the language.

No grammar: words and phrases of `natural.toml` are looked up, one limb and what is said of it make
a step. Whatever is not understood to the last word is not guessed at.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise

from lanindex.errors import PatternError
from lanindex.model.measures import GRADES
from lanindex.search.language.phrases import SINGLE, Meaning, UnclearError, meanings
from lanindex.search.language.query import Query
from lanindex.search.language.words import VALUES, Vocabulary

_LONGEST = 200
_GUESS = re.compile(
    r'^Did you mean "[^"]*"\? '
    r'| (Did you mean "[^"]*"\?|(The parts are|It has): .*|A movement has a direction .*)$'
)
"""What an error says to mend a word alone."""

_LEGS = ("leg", "thigh", "shank")
_HIGH = {"arm": "high", "forearm": "high", "upper_arm": "mid/high", "leg": "mid/high"}
_HIGH |= {"thigh": _HIGH["leg"], "palm": "high"}
"""By limb, where it is when it is up; of the others nobody can tell."""

_BENT = {"upper_arm": "arm", "thigh": "leg", "arm": "arm", "leg": "leg"}
"""What bends, by what is said to: ``thigh`` stands for the knee, too."""


def reading(text: str) -> str | None:
    """Return the pattern that plain words say, None where that is not clear to the last word.

    Examples
    --------
    >>> from lanindex.search.language.natural import reading
    >>> reading("raise the right hand"), reading("walk")
    ('r_arm high', None)
    """
    if len(text) > _LONGEST:
        return None
    try:
        return _said(list(_clauses(meanings(text))))
    except UnclearError:
        return None


def offer_reading(
    error: PatternError, understood: Callable[[str], Query], held: Collection[str]
) -> None:
    """Let the error of a pattern offer the one that was probably meant, if that is plain.

    Parameters
    ----------
    error : PatternError
        Of the whole text.
    understood : callable
        Reads a pattern, or raises a PatternError.
    held : collection of str
        The parts that the library has: what names none of them is not offered.
    """
    read = reading(error.text)
    if read is None:
        return
    try:
        parts = understood(read).parts
    except PatternError:
        return
    if parts.isdisjoint(held):
        return
    found = _GUESS.sub("", error.found)
    stop = "" if found.endswith((".", "?")) else "."
    error.found = f"{found}{stop} Did you mean:  {read}"
    error.args = (error.found,)


# Clauses.


@dataclass(slots=True)
class _Clause:
    """What is said between two links.

    Attributes
    ----------
    link : str
        What goes before it; the first has none.
    limb : str
        A part, in singular or plural, or how it is called in the language.
    side : str
        ``r``, ``l``, ``both``, ``either`` or nothing.
    values, verbs : list of str
        What is said of it.
    """

    link: str = ""
    limb: str = ""
    side: str = ""
    values: list[str] = field(default_factory=list)
    verbs: list[str] = field(default_factory=list)

    @property
    def says(self) -> bool:
        """Whether it says more than who moves."""
        return bool(self.values or self.verbs)

    def take(self, table: str, meaning: str) -> None:
        """Add a word."""
        if table == "phrases":
            self.values += [meaning] if meaning not in self.values else []
        elif table == "verbs":
            self.verbs.append(meaning)
        elif table in ("limbs", "movers"):
            self.name(meaning)
        elif table == "sides":
            if self.side or self.limb:
                raise UnclearError
            self.side = meaning

    def name(self, limb: str) -> None:
        if self.limb or (self.side and limb[:2] in ("r_", "l_")):
            raise UnclearError
        self.limb = limb

    @property
    def group(self) -> str:
        """The limb without side and number."""
        group = self.limb.removeprefix("r_").removeprefix("l_")
        return "foot" if group == "feet" else group.removesuffix("s")

    @property
    def both(self) -> bool:
        """Whether it speaks of both at once."""
        return self.side == "both" or self.limb.endswith("s") or self.limb == "feet"

    @property
    def mover(self) -> str:
        """Who moves, in the language."""
        if self.group in SINGLE:
            name = self.limb if not self.side else ""
        elif self.side in ("r", "l"):
            name = f"{self.side}_{self.group}" if not self.both else ""
        else:
            name = f"{self.group}s" if self.both and self.group != "foot" else self.limb
        if name not in _movers():
            raise UnclearError
        return name


@lru_cache(maxsize=1)
def _movers() -> frozenset[str]:
    return frozenset(Vocabulary().movers)


def _clauses(meanings: Iterator[Meaning]) -> Iterator[_Clause]:
    clause = _Clause()
    for table, meaning in meanings:
        if table == "links":
            yield clause
            clause = _Clause(meaning)
        else:
            clause.take(table, meaning)
    yield clause


def _said(clauses: list[_Clause]) -> str:
    """Return what the clauses say together."""
    clauses = _joined(clauses)
    if not clauses[0].limb and clauses[0].verbs in (["lean"], ["bend"]):
        clauses[0].limb = "torso"
    for clause in clauses:
        if clause.verbs == ["bend"] and not clause.values and clause.group in _BENT:
            clause.limb = clause.limb.replace(clause.group, _BENT[clause.group])
    links = {clause.link for clause in clauses[1:]}
    if not clauses[0].limb or (len(links) > 1 and links != {"->", "..."}):
        raise UnclearError
    if all(clause.values + clause.verbs == [] for clause in clauses):
        raise UnclearError
    pattern = _step(clauses[0], clauses[0].mover)
    for before, clause in pairwise(clauses):
        name = clause.mover if clause.limb else ""
        if not clause.limb and clause.link in ("->", "..."):
            clause.limb, clause.side = before.limb, before.side
        pattern += f" {clause.link} {_step(clause, name)}"
    return pattern


def _joined(clauses: list[_Clause]) -> list[_Clause]:
    """Join what 'and' and 'with' do not separate: 'forward and up', 'with the right leg'."""
    joined = clauses[:1]
    for clause in clauses[1:]:
        before = joined[-1]
        if clause.link == "with" and not before.limb and not clause.says:
            before.limb, before.side = clause.limb, clause.side
        elif clause.link in ("with", "and") and not clause.limb:
            if clause.verbs or not clause.values:
                raise UnclearError
            before.values += [it for it in clause.values if it not in before.values]
        else:
            clause.link = "with" if clause.link == "and" else clause.link
            joined.append(clause)
    for before, clause in pairwise(joined):
        if not before.says and before.limb and clause.link == "with":
            before.values, before.verbs = list(clause.values), list(clause.verbs)
    return joined


# Steps.


def _step(clause: _Clause, name: str) -> str:
    """Return a clause as a step; `name` is empty where the part carries over."""
    words = _words(clause)
    if clause.verbs == ["stay", "rest"]:  # to keep still
        clause.verbs = ["rest"]
    manner = _MANNERS.get(clause.verbs[0], "") if clause.verbs else ""
    if len(clause.verbs) > 1 or (not words and manner != "hold") or (words and manner == "hold"):
        raise UnclearError
    name = "head_turn" if "turn" in clause.verbs else name
    return " ".join(filter(None, (name, manner, *words)))


def _words(clause: _Clause) -> list[str]:
    """Return what a clause says, in the order of `_ORDER`."""
    kinds: dict[str, str] = {}
    for value in clause.values:
        for word in value.split():
            said = _HIGH.get(clause.group, "") if word == "up" else word
            kind = VALUES[said.split("/")[0]][0] if said else ""
            if not kind or kinds.setdefault(kind, said) != said:
                raise UnclearError
    for verb in clause.verbs:
        _VERBS.get(verb, _anybody)(clause, kinds)
    if clause.group in SINGLE:
        if "level" in kinds:
            raise UnclearError
        if kinds.get("direction") == "side":
            kinds["direction"] = "right/left"
    if kinds.get("direction") == "across/across_forward" and not clause.both:
        raise UnclearError
    if not kinds.keys() <= {*_ORDER}:
        raise UnclearError
    return [kinds[kind] for kind in _ORDER if kind in kinds]


_ORDER = ("bend", "change", "direction", "level", *GRADES)
"""In which words are written, by kind; others are said of no limb."""


def _anybody(clause: _Clause, kinds: dict[str, str]) -> None:
    """Check nothing: whoever can do it."""


def _raise(clause: _Clause, kinds: dict[str, str]) -> None:
    high = _HIGH.get(clause.group)
    if high is None or clause.group == "palm" or kinds.get("level") == "low" or "change" in kinds:
        raise UnclearError
    if "direction" not in kinds:
        kinds.setdefault("level", high)
    elif clause.group not in _LEGS:
        kinds.setdefault("level", "mid/high")


def _lower(clause: _Clause, kinds: dict[str, str]) -> None:
    if (
        clause.group in (*SINGLE, "palm")
        or kinds.setdefault("level", "low") != "low"
        or len(kinds) > 1
    ):
        raise UnclearError


def _lean(clause: _Clause, kinds: dict[str, str]) -> None:
    if clause.group not in SINGLE or list(kinds) != ["direction"]:
        raise UnclearError


def _bend(clause: _Clause, kinds: dict[str, str]) -> None:
    if clause.group in _BENT.values() and not kinds:
        kinds["bend"] = "bend"
    else:
        _lean(clause, kinds)


def _turn(clause: _Clause, kinds: dict[str, str]) -> None:
    if clause.group != "head" or kinds.get("direction") not in ("right", "left"):
        raise UnclearError


def _kick(clause: _Clause, kinds: dict[str, str]) -> None:
    if clause.group != "leg" or "direction" not in kinds:
        raise UnclearError


def _put(clause: _Clause, kinds: dict[str, str]) -> None:
    if kinds.get("direction") == "back":  # to the back, or to where it was?
        raise UnclearError


_MANNERS = {"stay": "at", "rest": "hold"}
_VERBS = {
    "raise": _raise,
    "lower": _lower,
    "lean": _lean,
    "bend": _bend,
    "turn": _turn,
    "kick": _kick,
    "put": _put,
}
"""By verb, what checks whether its limb can do that, and adds what it says."""
