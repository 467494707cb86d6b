"""Plain English → a pattern, by the words and phrases of ``natural.toml``, without a grammar."""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise

from lanindex.data import shipped
from lanindex.errors import PatternError
from lanindex.model.columns import GRADES
from lanindex.search.dictionary import absent
from lanindex.search.language.query import Query
from lanindex.search.language.words import VALUES, Vocabulary

_LONGEST = 200
_SPELLING = re.compile(
    r'^Did you mean "[^"]*"\? '
    r'| (Did you mean "[^"]*"\?|(Did you mean|The parts are): .*|A movement has a direction .*)$'
)
"""Sentences of an error that suggest another word."""

_SINGLE = ("head", "torso")  # parts that have no side
_LEGS = ("leg", "thigh", "shank")
_UP = {"arm": "high", "forearm": "high", "upper_arm": "mid/high", "leg": "mid/high"}
_UP |= {"thigh": _UP["leg"], "palm": "high"}
"""By limb that can be up, the levels that this means."""

_BENDING = {"upper_arm": "arm", "thigh": "leg", "arm": "arm", "leg": "leg"}
"""The limb that bends, by the word for it; ``thigh`` also stands for the knee."""

_MANNERS = {"stay": "at", "rest": "still"}
_ORDER = ("bend", "change", "direction", "level", *GRADES)
"""The kinds of words that are said of limbs, in the order in which they are written."""


class _UnclearError(Exception):
    """It could mean more than one thing, or nothing that the language can say."""


def _want(clear: bool) -> None:
    if not clear:
        raise _UnclearError


def reading(text: str) -> str | None:
    """Return the pattern that plain words mean; None where a word is not clear."""
    if len(text) > _LONGEST:
        return None
    if whole := absent(text):
        return whole.instead
    try:
        return _pattern(_joined(list(_clauses(text))))
    except _UnclearError:
        return None


def offer_reading(error: PatternError, read: Callable[[str], Query]) -> None:
    """Add the pattern that was probably meant to an error, if it parses."""
    meant = reading(error.text)
    if meant is None:
        return
    try:
        read(meant)
    except PatternError:
        return
    error.instead = meant
    if error.found.endswith(f": {meant}"):  # it is said already
        return
    found = _SPELLING.sub("", error.found)
    stop = "" if found.endswith((".", "?")) else "."
    error.found = f"{found}{stop} Did you mean:  {meant}"
    error.args = (error.found,)


_TOKEN = re.compile(r"->|→|\.\.\.|…|[^\W\d]\w*|\S")
_HALF = re.compile(r"\b(right|left|both|the|an?|his|her|their|your|my) (lower|upper) (arm|leg)")
"""Where 'lower arm' is surely a limb, and 'lower' no verb."""

_FROM = re.compile(r"(.*)\bfrom (.+?) to (.+)")


@cache
def _phrases() -> Mapping[tuple[str, ...], tuple[str, str]]:
    """Return the table and the meaning of each phrase, words of the language included."""
    known: dict[tuple[str, ...], tuple[str, str]] = {
        **{(word,): ("phrases", word) for word in VALUES},
        **{(name,): ("movers", name) for name in Vocabulary().movers},
    }
    for table, meanings in shipped("search/language/natural.toml").items():
        for meaning, phrases in meanings.items():
            for phrase in phrases:
                known[tuple(phrase.replace(",", " , ").split())] = (table, meaning)
                if table == "limbs" and meaning not in _SINGLE:
                    known[tuple(f"{phrase}s".split())] = (table, f"{meaning}s")
    return known


def _plain(text: str) -> list[str]:
    """Return the words without articles, hyphens and the stop at the end."""
    text = re.sub(r"(?<=\w)-(?=\w)", " ", text.lower()).strip()
    text = _HALF.sub(r"\1 \2_\3", text)
    tables = shipped("search/language/natural.toml")
    verbs, fillers = tables["verbs"], tables["fillers"]
    ends = {*verbs["raise"], *verbs["lower"]}  # they say where it ends by themselves
    if (match := _FROM.fullmatch(text)) and ends.isdisjoint(text.split()):
        text = f"{match[1]} {match[2]} ... {match[3]}"
    text = text.rstrip("!? ")
    words = _TOKEN.findall(text.removesuffix(".") if not text.endswith("..") else text)
    return [word for word in words if word not in fillers["articles"]]


def _meanings(text: str) -> Iterator[tuple[str, str]]:
    """Yield what the words of a text mean, as `_phrases` says it, the longest phrases first."""
    words, known = tuple(_plain(text)), _phrases()
    longest = max(map(len, known))
    while words:
        for count in range(min(longest, len(words)), 0, -1):
            phrase, rest = words[:count], words[count:]
            tables = {known[rest[:some]][0] for some in (1, 2) if rest[:some] in known}
            side = phrase[-1] in ("right", "left") and not tables.isdisjoint(("limbs", "movers"))
            if phrase in known and not (side and phrase[-2:-1] == ("to",)):
                break
        else:
            raise _UnclearError
        table, meaning = known[phrase]
        _want(table != "unclear")
        if phrase in (("right",), ("left",)):
            table, meaning = ("sides", meaning) if side else ("phrases", phrase[0])
        yield table, meaning
        words = rest


@dataclass(slots=True)
class _Clause:
    """What stands between two links."""

    link: str = ""  # before it; the first has none
    limb: str = ""  # a part, in singular or plural, or its name in the language
    side: str = ""  # r, l, both, either or nothing
    values: list[str] = field(default_factory=list)
    verbs: list[str] = field(default_factory=list)

    @property
    def says(self) -> bool:
        """Whether it says more than who moves."""
        return bool(self.values or self.verbs)

    @property
    def group(self) -> str:
        """The limb without side and number."""
        group = self.limb.removeprefix("r_").removeprefix("l_")
        return "foot" if group == "feet" else group.removesuffix("s")

    @property
    def is_pair(self) -> bool:
        """Whether it speaks of both at once."""
        return self.side == "both" or self.limb.endswith("s") or self.limb == "feet"

    @property
    def mover(self) -> str:
        """Who moves, in the language."""
        if self.group in _SINGLE:
            name = self.limb if not self.side else ""
        elif self.side in ("r", "l"):
            name = f"{self.side}_{self.group}" if not self.is_pair else ""
        else:
            name = f"{self.group}s" if self.is_pair and self.group != "foot" else self.limb
        _want(name in Vocabulary().movers)
        return name


def _clauses(text: str) -> Iterator[_Clause]:
    clause = _Clause()
    for table, meaning in _meanings(text):
        if table == "links":
            yield clause
            clause = _Clause(meaning)
        elif table == "phrases":
            clause.values += [meaning] if meaning not in clause.values else []
        elif table == "verbs":
            clause.verbs.append(meaning)
        elif table in ("limbs", "movers"):
            _want(not clause.limb and not (clause.side and meaning[:2] in ("r_", "l_")))
            clause.limb = meaning
        elif table == "sides":
            _want(not clause.side and not clause.limb)
            clause.side = meaning
    yield clause


def _joined(clauses: list[_Clause]) -> list[_Clause]:
    """Join clauses that 'and' and 'with' do not separate: 'forward and up'."""
    joined = clauses[:1]
    for clause in clauses[1:]:
        before = joined[-1]
        if clause.link == "with" and not before.limb and not clause.says:
            before.limb, before.side = clause.limb, clause.side
        elif clause.link in ("with", "and") and not clause.limb:
            _want(bool(clause.values) and not clause.verbs)
            before.values += [it for it in clause.values if it not in before.values]
        else:
            clause.link = "with" if clause.link == "and" else clause.link
            joined.append(clause)
    for before, clause in pairwise(joined):
        if not before.says and before.limb and clause.link == "with":
            before.values, before.verbs = list(clause.values), list(clause.verbs)
    return joined


def _pattern(clauses: list[_Clause]) -> str:
    first = clauses[0]
    if not first.limb and first.verbs in (["lean"], ["bend"]):
        first.limb = "torso"
    for clause in clauses:
        if clause.verbs == ["bend"] and not clause.values and clause.group in _BENDING:
            clause.limb = clause.limb.replace(clause.group, _BENDING[clause.group])
    links = {clause.link for clause in clauses[1:]}
    _want(bool(first.limb) and (len(links) <= 1 or links == {"->", "..."}))
    _want(any(clause.says for clause in clauses))
    pattern = _step(first, first.mover)
    for before, clause in pairwise(clauses):
        name = clause.mover if clause.limb else ""
        if not clause.limb and clause.link in ("->", "..."):
            clause.limb, clause.side = before.limb, before.side
        pattern += f" {clause.link} {_step(clause, name)}"
    return pattern


def _step(clause: _Clause, name: str) -> str:
    """Return the step of a clause; `name` is empty where the part carries over."""
    words = _words(clause)
    verbs = ["rest"] if clause.verbs == ["stay", "rest"] else clause.verbs  # to keep still
    manner = _MANNERS.get(verbs[0], "") if verbs else ""
    _want(len(verbs) <= 1 and bool(words) == (manner != "still"))
    name = "head_turn" if "turn" in verbs else name
    return " ".join(filter(None, (name, manner, *words)))


def _words(clause: _Clause) -> list[str]:
    """Return the words of a clause, in the order of `_ORDER`."""
    kinds: dict[str, str] = {}
    for value in clause.values:
        for word in value.split():
            value = _UP.get(clause.group, "") if word == "up" else word
            _want(bool(value))
            kind = VALUES[value.split("/")[0]][0]
            _want(kinds.setdefault(kind, value) == value)
    for verb in clause.verbs:
        _add_verb(verb, clause.group, kinds)
    if clause.group in _SINGLE:
        _want("level" not in kinds)
        if kinds.get("direction") == "side":
            kinds["direction"] = "right/left"
    _want(clause.is_pair or kinds.get("direction") != "across/across_forward")
    _want(kinds.keys() <= {*_ORDER})
    return [kinds[kind] for kind in _ORDER if kind in kinds]


def _add_verb(verb: str, group: str, kinds: dict[str, str]) -> None:
    """Check that a limb can do what a verb says, and add that to its words by kind."""
    direction = kinds.get("direction")
    match verb:
        case "raise":
            _want(group in _UP and group != "palm")
            _want(kinds.get("level") != "low" and "change" not in kinds)
            if not direction:
                kinds.setdefault("level", _UP[group])
            elif group not in _LEGS:
                kinds.setdefault("level", "mid/high")
        case "lower":
            _want(group not in (*_SINGLE, "palm") and kinds.setdefault("level", "low") == "low")
            _want(len(kinds) == 1)
        case "bend" if group in _BENDING.values() and not kinds:
            kinds["bend"] = "bend"
        case "lean" | "bend":
            _want(group in _SINGLE and list(kinds) == ["direction"])
        case "turn":
            _want(group == "head" and direction in ("right", "left"))
        case "kick":
            _want(group == "leg" and direction is not None)
        case "put":
            _want(direction != "back")  # to the back, or to where it was?
