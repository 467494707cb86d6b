"""A query in plain English."""

from __future__ import annotations

import re

from lanindex.alphabet import KINDS, kind_of
from lanindex.model.measures import GRADES
from lanindex.search.explain.clauses import endings, time
from lanindex.search.language.query import (
    ONCE,
    Arrow,
    Beside,
    Bracket,
    Choice,
    Item,
    Line,
    Lines,
    Query,
    Repeat,
    Skips,
    Step,
    Word,
)
from lanindex.search.language.times import Length, degrees, sixths
from lanindex.search.language.words import Mover

_VALUES = {
    "right": "to the right",
    "r_forward": "to the front right",
    "forward": "forward",
    "l_forward": "to the front left",
    "left": "to the left",
    "l_back": "to the back left",
    "back": "back",
    "r_back": "to the back right",
    "place": "in place",
    "any": "anywhere",
    "side": "to its own side",
    "side_forward": "forward on its own side",
    "side_back": "back on its own side",
    "across": "across the body",
    "across_forward": "forward across the body",
    "across_back": "back across the body",
    "low": "low",
    "mid": "at middle height",
    "high": "high",
    "rising": "to a higher level than before",
    "sinking": "to a lower level than before",
    "spring": "from both feet to both",
    "hop": "from one foot to the same",
    "leap": "from one foot to the other",
    "assemble": "from one foot to both",
    "sissonne": "from both feet to one",
    "unseen": "from or to feet that were not seen",
    "slow": "slowly",
    "fast": "fast",
    "small": "a little way",
    "large": "a long way",
}
_OWN = {
    "touched": {
        **{"hand": "each other", "head": "the head", "trunk": "the trunk"},
        **{"arm": "the other arm", "thigh": "a thigh", "knee": "a knee"},
        **{"shank": "a shank", "foot": "a foot"},
    },
    "carrier": {
        **{"knee": "on a knee", "seat": "on the seat", "trunk": "on the trunk"},
        **{"hand": "on a hand", "other": "on something that is not told"},
    },
}
"""By kind, words that mean something else elsewhere."""
_PLACES = {"low": "straight down", "mid": "drawn in to its joint", "high": "straight up"}
_MANNERS = {
    "move": (("moves", "anywhere"), ("move", "anywhere")),
    "via": (("goes, if only in passing,", "anywhere"), ("go, if only in passing,", "anywhere")),
    "at": (("is", "anywhere"), ("are", "anywhere")),
    "hold": (("stays", "where it is"), ("stay", "where they are")),
}
_FACES = {"moves": "turns", "move": "turn", "goes": "turns", "go": "turn", "is": "faces",
          "are": "face"}  # fmt: skip
"""What palms do, by what limbs do."""
"""By manner, for one and for two: the verb, and where if no words tell."""
_DOINGS = {
    "step": ("a foot", "steps"),
    "jump": ("the body", "jumps"),
    "travel": ("the body", "travels"),
    "turn": ("the body", "turns"),
    "carrier": ("the body", "rests"),
    "torso_twist": ("the torso", "twists"),
    "head_turn": ("the head", "turns"),
    "torso_incline": ("the torso", "inclines"),
    "head_incline": ("the head", "inclines"),
}
"""By kind of track, or by part, who does it, and what."""
_LENGTHS = {
    "<": "less than {}",
    "<=": "at most {}",
    ">": "more than {}",
    ">=": "at least {}",
    "+": "at least {}",
    "~": "about {} (a fifth more or less)",
}
_SKIPS = {"": "{}", "<": "fewer than {}", "<=": "at most {}", ">": "more than {}"}
_RELATIONS = {
    "with": "and in the meantime, sharing a frame at least, {}",
    "during": "and all of it while {}",
    "starting with": "and beginning at the same time, {}",
    "ending with": "and ending at the same time, {}",
    "exactly with": "and at exactly the same time, {}",
    "without": "and in the meantime never: {}",
    "after": "and before it begins, {}",
    "before": "and when it is over, {}",
    "never": "and nowhere in the clip: {}",
}
_WITHIN = {
    "with": "and not {} or more away, {}",
    "without": "and not even {} away: {}",
    "after": "and before it begins ({} between), {}",
    "before": "and when it is over ({} between), {}",
}
"""By relation, what it says with a limit."""


def sentence(query: Query) -> str:
    """Return what a query asks for, as one English sentence or more."""
    said = _pattern(query.pattern)
    first = len(said) - len(said.lstrip("("))
    whole = f"{said[:first]}{said[first].upper()}{said[first + 1 :]}."
    return " ".join([whole, *endings(query)])


def _pattern(pattern: Choice, begins: bool = True) -> str:
    """Return a pattern in words; one that does not begin its line cannot begin there either."""
    return " — or — ".join(_lines(lines, begins) for lines in pattern.alternatives)


def _lines(lines: Lines, begins: bool) -> str:
    return "; ".join([_line(lines.first, begins), *map(_beside, lines.others)])


def _beside(beside: Beside) -> str:
    line, within = _line(beside.line), beside.within
    if within is None:
        return _RELATIONS[beside.relation].format(line)
    limit = _length(within) if beside.relation in ("after", "before") else time(within.time)
    return _WITHIN[beside.relation].format(limit, line)


def _line(line: Line, begins: bool = True) -> str:
    said = ""
    if line.start:
        limit = _limit(line.start)
        said = f"from the clip's start{', later on' if line.start.later else ''}{limit}: "
    said += _item(line.items[0], begins)
    first = line.items[0].unit
    if begins and len(line.items) > 1 and not line.start and _may_be_there(line.items[0]):
        many = isinstance(first, Step) and first.mover.form == "both"
        said += " (or begin there)" if many else " (or begins there)"
    for arrow, item in zip(line.arrows, line.items[1:], strict=True):
        said += f", {'later' if arrow.later else 'then'}{_limit(arrow)} {_item(item, False)}"
    if line.end:
        last = "some time before" if line.end.later else "as the last movement before"
        said += f", {last} the clip's end{_limit(line.end)}"
    return said


def _may_be_there(item: Item) -> bool:
    """Tell whether a line's first step may be the starting position."""
    step = item.unit
    return (
        isinstance(step, Step)
        and KINDS[kind_of(step.mover.members[0])].lasts
        and (step.manner, item.length, item.repeat) == ("move", None, ONCE)
        and not any(word.kind == "change" and not word.negated for word in step.words)
        and not any(word.kind in GRADES for word in step.words)
    )


def _limit(arrow: Arrow) -> str:
    if arrow.length:
        return f" (after {_length(arrow.length)})"
    return f" ({_skipped(arrow.skips)} between)" if arrow.skips else ""


def _skipped(skips: Skips) -> str:
    number = _SKIPS.get(skips.form, "at least {}").format(skips.count)
    return f"{number} movement{'' if skips.count == 1 else 's'}"


def _item(item: Item, begins: bool) -> str:
    unit = item.unit
    said = f"({_pattern(unit.pattern, begins)})" if isinstance(unit, Bracket) else _step(unit)
    if item.length:
        said += f", for {_length(item.length)}"
    return said + _repeat(item.repeat) + (f" (call it {item.label})" if item.label else "")


def _repeat(repeat: Repeat) -> str:
    if (repeat.least, repeat.most) == (1, 1):
        return ""
    if (repeat.least, repeat.most) == (0, 1):
        return " (or leaves this out)"
    if repeat.most is None:
        return f", {repeat.least} or more times in a row"
    exact = repeat.least == repeat.most
    return f", {repeat.least if exact else f'{repeat.least} to {repeat.most}'} times in a row"


def _length(length: Length) -> str:
    if length.last:
        return f"{time(length.time)} to {time(length.last)}"
    return _LENGTHS[length.form].format(time(length.time))


def _doing(mover: Mover) -> tuple[str, str] | None:
    part = mover.members[0]
    return _DOINGS.get(part) or _DOINGS.get(kind_of(part))


def who(mover: Mover) -> str:
    """Return a part or pair as a person would name it."""
    if doing := _doing(mover):
        return doing[0]
    name = mover.name.replace("_bend", "", 1).replace("_touches", "s").replace("_touch", "")
    name = name.replace("stances", "feet").replace("stance", "foot").replace("_", " ")
    if name == "hands":
        return "the hands" if mover.form == "one" else "both hands"
    if mover.form == "one":
        side = {"r": "right ", "l": "left "}.get(mover.name[:1], "") if mover.sided else ""
        return f"the {side}{name[2:] if side else name}"
    return f"either {name}" if mover.form == "either" else f"both {name} together"


def _step(step: Step) -> str:
    many = step.mover.form == "both"
    verb, place = _MANNERS[step.manner][many]
    if step.manner in ("move", "via") and (doing := _doing(step.mover)):
        verb, place = verb.replace("goes", "moves").replace("moves", doing[1]), ""
    if kind_of(step.mover.members[0]) == "bend" and step.manner in ("move", "via"):
        bends = _bends(step) if many else re.sub("(bend|stretch)", _third, _bends(step))
        verb, place = re.sub("goes|go|moves?", bends, verb), ""
    elif kind_of(step.mover.members[0]) == "stance" and step.manner in ("move", "via"):
        verb, place = f"hold{'' if many else 's'} weight", ""
    elif kind_of(step.mover.members[0]) == "touch":
        verb, place = _touches(step)
    elif step.mover.members[0].endswith("_palm"):
        verb = re.sub(r"^\w+", lambda found: _FACES.get(found[0], found[0]), verb)
    where = _where(step)
    if place and step.manner in ("move", "via") and {it.kind for it in step.words} == {"bend"}:
        where = f"{place}, {where}"
    said = f"{verb} {where or place}"
    if many or not step.mover.sided:
        said = said.replace("its own side", "their own sides" if many else "either side")
    return f"{who(step.mover)} {said}".rstrip(" ,") if step.named else said.rstrip(" ,")


def _bends(step: Step) -> str:
    """Return what an elbow or a knee does, of many."""
    told = {it.split()[0] for word in step.words if not word.negated for it in word.values}
    return told.pop() if len(told) == 1 and told <= {"bend", "stretch"} else "bend or stretch"


def _third(verb: re.Match[str]) -> str:
    return {"bend": "bends", "stretch": "stretches"}[verb[1]]


def _touches(step: Step) -> tuple[str, str]:
    """Return the verb of hands that touch, and what if no words tell."""
    several = step.mover.form == "both" or step.mover.name == "hands_touch"
    if step.manner == "hold":
        return f"touch{'' if several else 'es'} nothing{' after' * bool(step.words)}", ""
    passing = ", if only in passing," if step.manner == "via" else ""
    thing = "each other" if step.mover.name == "hands_touch" else "something"
    return f"touch{'' if several else 'es'}{passing}", thing


def _where(step: Step) -> str:
    words, kind = step.words, kind_of(step.mover.members[0])
    told = {word.kind: word for word in words if not word.negated and len(word.values) == 1}
    direction, level = told.get("direction"), told.get("level")
    if (
        kind == "gesture"
        and direction
        and level
        and direction.values == ("place",)
        and len(words) == 2
    ):
        return _PLACES[level.values[0]]
    curves = "on a way that curves " if kind == "travel" else ""
    return ", ".join(_word(word, curves) for word in words)


def _word(word: Word, curves: str = "") -> str:
    own = _VALUES | _OWN.get(word.kind, {})
    hows = {"degrees": lambda it: curves + _angle(it), "bend": _degree}
    how = hows.get(word.kind, lambda it: own.get(it, it))
    joined = " or ".join(filter(None, map(how, word.values)))
    if word.negated and word.values[0].split()[0] in ("bend", "stretch"):
        joined = " or ".join(f"{it.split()[0]}ing {_degree(it)}".rstrip() for it in word.values)
    return f"not {joined}" if word.negated else joined


def _degree(value: str) -> str:
    """Return how far a limb bends, stretches or is bent as a person says it."""
    how, _, said = value.partition(" ")
    if not said:
        return "" if how in ("bend", "stretch") else how
    least, most = sixths(said)
    some = f"{least} to {most}" if most is not None and most > least else str(least)
    degree = f"degree {some}" if most is not None else f"degree {least} or more"
    return f"bent by {degree}" if how == "bent" else f"to {degree}"


def _angle(value: str) -> str:
    """Return an angle as it is written as a person says it."""
    least, most = degrees(value)
    if most is None:
        return f"by {least} degrees or more"
    return f"by {least} to {most} degrees" if least else f"by {most} degrees or less"
