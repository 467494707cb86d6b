"""How a query is understood, in plain English, and how it is searched: its plan as text."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from itertools import chain, islice
from typing import Any

from lanindex.alphabet import kind_of, plain
from lanindex.data import shipped
from lanindex.search.language import query as tree
from lanindex.search.language.clauses import CLIP, MATCH, Comparison, Mirrors, Reference, Stage, Sum
from lanindex.search.language.times import Length, Time, decimal, degrees
from lanindex.search.language.words import AMOUNTS, RESTS, STILL, UNITS, WORD_KINDS, Mover
from lanindex.search.match.batch import unavoidable
from lanindex.search.match.conditions import Clauses
from lanindex.search.match.finder import Recording, find_in
from lanindex.search.match.leading import SHORT, SOON, WIDER
from lanindex.search.match.mirror_runs import repeats
from lanindex.search.match.relations import RELATIONS
from lanindex.search.match.rewrites import ONLY, Rewrites, enough, enough_beside
from lanindex.search.plan import NEGATIONS, Companion, Program, State, plan

_ENGLISH = shipped("search/language/english.toml")
_COMPARED: dict[str, str] = _ENGLISH["compared"]
_AT_ONCE = 200  # captures in which steps are counted together


def sentence(query: tree.Query) -> str:
    """Return what a query asks for, as one English sentence or more."""
    text = _text(query.pattern)
    first = len(text) - len(text.lstrip("("))
    sentences = [f"{text[:first]}{text[first].upper()}{text[first + 1 :]}."]
    if query.either_side:
        sentences.append("Or the mirror image of all this.")
    if query.rhythm:
        proportion = " : ".join(map(decimal, query.rhythm))
        sentences.append(f"Its steps last in proportion {proportion}, give or take a quarter.")
    if query.where:
        sentences.append(f"And so that {' and '.join(map(_text, query.where))}.")
    return " ".join([*sentences, *(f"Then {_text(stage)}." for stage in query.stages)])


def _text(node: object, begins: bool = True) -> str:
    """Return a node of a query in words; `begins`: whether it may be a starting position."""
    match node:
        case tree.Choice(alternatives):
            return " — or — ".join(_text(lines, begins) for lines in alternatives)
        case tree.Lines(first, others):
            return "; ".join([_text(first, begins), *map(_text, others)])
        case tree.Beside(relation, line, None):
            return str(_ENGLISH["relations"][relation][0].format(_text(line)))
        case tree.Beside(relation, line, Length(time=time) as within):
            limit = within if relation in ("after", "before") else time
            return str(_ENGLISH["relations"][relation][1].format(_text(limit), _text(line)))
        case tree.Line():
            return _line(node, begins)
        case tree.Item(unit, length, repeat, label):
            text = _text(unit, begins) + (f", for {_text(length)}" if length else "")
            return text + _text(repeat) + (f" (call it {label})" if label else "")
        case tree.Bracket(pattern):
            return f"({_text(pattern, begins)})"
        case tree.Step():
            return _step(node)
        case tree.Arrow(length=Length() as length):
            return f" (after {_text(length)})"
        case tree.Arrow(skips=Length(form, Time(count))):
            how = "fewer than " if form == "<" else f"{_COMPARED[form]} " if form else ""
            return f" ({how}{count} movement{'' if count == 1 else 's'} between)"
        case tree.Arrow() | tree.Repeat(1, 1):
            return ""
        case tree.Repeat(0, 1):
            return " (or leaves this out)"
        case tree.Repeat(least, most):
            several = f"{least} or more" if most is None else f"{least} to {most}"
            return f", {least if least == most else several} times in a row"
        case Length(_, time, Time() as last):
            return f"{_text(time)} to {_text(last)}"
        case Length("~", time):
            return f"about {_text(time)} (a fifth more or less)"
        case Length(form, time):
            return f"{_COMPARED[form]} {_text(time)}"
        case Time(count, unit):
            number, name = decimal(count), UNITS[unit]
            return f"{number} {name[:-1] if number == '1' and len(name) > 2 else name}"
        case Mirrors(first_label, second_label):
            return f"{first_label} is the mirror image of {second_label}"
        case Comparison(left, compare, right):
            return " ".join(filter(None, (_text(left), "is", _COMPARED[compare], _text(right))))
        case Sum(terms):
            texts = [f"{'plus' if sign > 0 else 'less'} {_text(term)}" for sign, term in terms]
            return " ".join(texts).removeprefix("plus ")
        case Reference(name, field):
            owner = {CLIP: "the clip's", MATCH: "the hit's"}.get(name, f"{name}'s")
            noun = WORD_KINDS[field].noun if field in AMOUNTS else field
            return f"{owner} {_ENGLISH['fields'].get(field, noun)}"
        case Stage("count", by):
            return "count the hits" + (f" by {_text(by)}" if by else "")
        case Stage("sort", by):
            return f"sort them by {_text(by)}, the smallest first"
        case Stage("first", _, most):
            return f"keep the first{f' {most}' if most > 1 else ''}"
    return str(node)


def _line(line: tree.Line, begins: bool) -> str:
    first, *others = line.items
    text = _text(first, begins)
    if line.start:
        later = ", later on" if line.start.later else ""
        text = f"from the clip's start{later}{_text(line.start)}: {text}"
    elif begins and others and tree.may_begin(first):
        both = isinstance(first.unit, tree.Step) and first.unit.mover.form == "both"
        text += " (or begin there)" if both else " (or begins there)"
    for arrow, item in zip(line.arrows, others, strict=True):
        text += f", {'later' if arrow.later else 'then'}{_text(arrow)} {_text(item, False)}"
    if line.end:
        last = "some time before" if line.end.later else "as the last movement before"
        text += f", {last} the clip's end{_text(line.end)}"
    return text


def _doing(mover: Mover) -> list[str] | None:
    part = mover.members[0]
    doings: dict[str, list[str]] = _ENGLISH["doings"]
    return doings.get(part) or doings.get(kind_of(part))


def _who(mover: Mover) -> str:
    """Return a part or pair as a person would name it."""
    if doing := _doing(mover):
        return doing[0]
    name = mover.name.replace("_bend", "", 1).replace("_touches", "s").replace("_touch", "")
    name = plain(name.replace("stances", "feet").replace("stance", "foot"))
    if name == "hands":
        return "the hands" if mover.form == "one" else "both hands"
    if mover.form == "one":
        return f"the {name}"
    return f"either {name}" if mover.form == "either" else f"both {name} together"


def _step(step: tree.Step) -> str:
    verb, place = _verb(step)
    text = f"{verb} {_where(step) or place}".rstrip(" ,")
    many = step.mover.form == "both"
    if many or not step.mover.sided:
        text = text.replace("its own side", "their own sides" if many else "either side")
    return f"{_who(step.mover)} {text}" if step.named else text


def _verb(step: tree.Step) -> tuple[str, str]:
    """Return what a part or pair does, and where if no words tell."""
    part, many = step.mover.members[0], step.mover.form == "both"
    kind, palm, s = kind_of(part), part.endswith("_palm"), "" if many else "s"
    passing = ", if only in passing," if step.manner == "via" else ""
    if kind == "touch":
        each_other = part == "hands_touch"
        touch = "touch" if each_other or many else "touches"
        if step.manner == "hold":
            return f"{touch} nothing{' after' * bool(step.words)}", ""
        return f"{touch}{passing}", "each other" if each_other else "something"
    if step.manner in RESTS:
        still = " still" * (step.manner == STILL)
        return f"stay{s}{still}", "where they are" if many else "where it is"
    if step.manner == "at":
        return f"face{s}" if palm else "are" if many else "is", "anywhere"
    if doing := _doing(step.mover):
        return f"{doing[1]}{passing}", ""
    if kind == "stance":
        return f"hold{s} weight", ""
    if kind == "bend":
        verbs = {"bend": f"bend{s}", "stretch": "stretch" if many else "stretches"}
        words = {it.split()[0] for word in step.words if not word.negated for it in word.values}
        meant = [verb for word, verb in verbs.items() if words == {word}]
        return f"{' or '.join(meant or verbs.values())}{passing}", ""
    goes = f"go{'' if many else 'es'}" if passing else f"move{s}"
    bent = " anywhere," if {it.kind for it in step.words} == {"bend"} else ""
    return f"{f'turn{s}' if palm else goes}{passing}{bent}", "anywhere"


def _where(step: tree.Step) -> str:
    kind, places = kind_of(step.mover.members[0]), _ENGLISH["places"]
    for level in places if kind == "gesture" else ():
        if {*map(str, step.words)} == {"place", level}:
            return str(places[level])
    curves = "on a way that curves " if kind == "travel" else ""
    return ", ".join(_word(word, curves) for word in step.words)


def _word(word: tree.Word, curves: str) -> str:
    own = _ENGLISH["values"] | _ENGLISH.get(word.kind, {})
    hows = {"degrees": lambda it: curves + _angle(it), "bend": _degree}
    how = hows.get(word.kind, lambda it: own.get(it, it))
    joined = " or ".join(filter(None, map(how, word.values)))
    if word.negated and word.values[0].split()[0] in ("bend", "stretch"):
        joined = " or ".join(f"{it.split()[0]}ing {_degree(it)}".rstrip() for it in word.values)
    return f"not {joined}" if word.negated else joined


def _degree(value: str) -> str:
    """Return how far a limb bends, stretches or is bent as a person says it."""
    word, _, amount = value.partition(" ")
    if not amount:
        return "" if word in ("bend", "stretch") else word
    least, most = degrees(amount)
    more = " or more" if most is None else f" to {most}" if most > least else ""
    return f"{'bent by' if word == 'bent' else 'to'} degree {least}{more}"


def _angle(value: str) -> str:
    """Return an angle as it is written as a person says it."""
    least, most = degrees(value)
    if most is None:
        return f"by {least} degrees or more"
    return f"by {least} to {most} degrees" if least else f"by {most} degrees or less"


# How it is answered.


@dataclass(frozen=True, slots=True)
class Explanation:
    """How a query is understood; as text, or as a dict.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     explained = library.explain("torso forward high -> hold 1s+")
    >>> explained.steps
    {'torso forward high': 1, 'torso hold 1s+': 15}
    """

    pattern: str
    english: str  # one sentence or more
    steps: Mapping[str, int]  # how many symbols each step alone would match, by the step's text
    order: tuple[str, ...]  # what the matcher does, one sentence after the other
    plan: str = ""  # how it is searched, if that is asked for, instead of steps and order

    def __str__(self) -> str:
        if self.plan:
            return self.plan
        width = max(len(step) for step in self.steps)
        lines = [self.english, "", "Each step alone:"]
        lines += [f"  {step.ljust(width)}  {count}" for step, count in self.steps.items()]
        lines += ["", "Order of work:"]
        lines += [f"  {number}. {work}" for number, work in enumerate(self.order, 1)]
        return "\n".join(lines)

    def record(self) -> dict[str, Any]:
        """Return it as ``search --explain --json`` prints it."""
        steps = [{"step": step, "count": count} for step, count in self.steps.items()]
        return {**asdict(self), "steps": steps, "order": list(self.order)}


def explanation(query: tree.Query, recordings: Iterable[Recording]) -> Explanation:
    """Return how a query is understood: in English, step by step, and the order of work.

    `recordings` are those in which is counted what each step alone would match.
    """
    counts = step_counts(query, recordings)
    return Explanation(str(query), sentence(query), counts, tuple(order(query)))


def step_counts(query: tree.Query, recordings: Iterable[Recording]) -> dict[str, int]:
    """Return how many symbols each step alone would match, by the step's text.

    Movements, stays or rests, of pairs those together; no starting positions and, as a step
    alone is a first step, nothing that is only passed.
    """
    steps = {str(it): tree.query_of(tree.Line((it,))) for it in _alone(query)}
    counts, rest = dict.fromkeys(steps, 0), iter(recordings)
    while some := list(islice(rest, _AT_ONCE)):
        for text, step in steps.items():
            counts[text] += len(find_in(some, step, tolerance=Fraction(0), overlaps="all"))
    return counts


def order(query: tree.Query) -> list[str]:
    """Return what the matcher does, one sentence after the other."""
    works = [f"Take the tracks of {', '.join(sorted(query.parts))}."]
    for lines in query.pattern.alternatives:
        line, first = str(lines.first), str(next(_alone(tree.query_of(lines))))
        works.append(f"Begin at each {first}" + ("." if line == first else f", and follow {line}"))
        works += [f"Keep what is {it}" for it in lines.others]
    if query.either_side:
        works.append("Do the same with the mirror image.")
    works.append("From each beginning keep what ends first.")
    if query.where:
        works.append(f"Keep what is so: {' and '.join(map(str, query.where))}")
    return [*works, *(f"Of these: {stage}" for stage in query.stages)]


def _alone(query: tree.Query) -> Iterator[tree.Item]:
    """Yield each step by itself, as a search for it is written."""
    for item in tree.nodes_in(query.pattern, tree.Item):
        if isinstance(item.unit, tree.Step):
            yield tree.Item(replace(item.unit, named=True), item.length)


# The plan.


def planned(query: tree.Query) -> str:
    """Return the lines of a query, each side and alternative on its own, and how they are searched.

    The page of `lanindex.search` explains a plan line by line.
    """
    clauses, lines = Clauses(query), dict[Program, Rewrites]()
    for program in plan(query):
        _add(program, Rewrites(program), lines)
    numbers = {line: number for number, line in enumerate(lines, 1)}
    found = []
    for line, number in numbers.items():
        found.append(f"line {number}")
        rows = dict.fromkeys(_rows_of(line, lines[line], clauses, numbers))
        found += [f"  {row.ljust(9)}  {text}" for row, text in rows]
    return "\n".join(found)


def _add(line: Program, rewrites: Rewrites, lines: dict[Program, Rewrites]) -> None:
    """Add a line and those that can stand beside it, with what may be left out."""
    lines.setdefault(line, rewrites)
    for companion in line.companions:
        for inner in rewrites.programs(companion):
            _add(inner, rewrites, lines)


def _rows_of(
    line: Program, rewrites: Rewrites, clauses: Clauses, numbers: dict[Program, int]
) -> Iterator[tuple[str, str]]:
    """Yield what is said of a line: a word and a text each."""
    begins = {entry.state for entry in line.entries}
    texts = [_state(state) for state in line.states]
    width = max(map(len, texts))
    for number, text in enumerate(texts):
        roles = ["begins"] * (number in begins) + ["ends"] * bool(line.exits[number])
        yield f"state {number}", f"{text.ljust(width)}    {', '.join(roles)}".rstrip()
    for edge in chain(*line.edges):
        other = "" if edge.same else " (of another part)"
        yield "edge", f"{edge.exit.state} {edge.arrow}{other} {edge.entry.state}"
    if line is rewrites.program and repeats(clauses, line):
        yield "runs", "of symbols that mirror each other are counted"
    elif line is rewrites.program:
        yield from _searched(line, rewrites, clauses)
    for companion in line.companions:
        standing = [numbers[it] for it in rewrites.programs(companion)]
        yield companion.relation, _join(companion, standing)
    forbidden = [it for it in line.outermost.companions if it.relation == "without"]
    inner = chain.from_iterable(map(rewrites.programs, forbidden))
    if early := [numbers[it] for it in inner if it not in rewrites.contested]:
        yield "drop", f"matches as soon as they share a frame with {_numbered('line', early)}"
    if contested := sorted(rewrites.contested.get(line, ())):
        yield "claims", f"another line could want the symbols of {_numbered('state', contested)}"


def _state(state: State) -> str:
    words = []
    for kind, codes in state.fits[0].items():
        names = {code: name for name, code in WORD_KINDS[kind].codes.items()}
        words.append("/".join(names.get(it, str(it)) for it in sorted(codes)))
    manner = "" if state.manner == "move" else state.manner
    length = str(state.length or "")
    return " ".join(filter(None, ("+".join(state.members), manner, *words, length)))


def _searched(program: Program, rewrites: Rewrites, clauses: Clauses) -> Iterator[tuple[str, str]]:
    beside = [it for it in program.outermost.companions if it.relation not in NEGATIONS]
    lines = [program, *(it.programs[0] for it in beside if len(it.programs) == 1)]
    if wanted := dict.fromkeys(_state(state) for line in lines for state in unavoidable(line)):
        yield "prefilter", f"captures with {', '.join(wanted)}"
    end = enough(program)
    yield "ends", _ENGLISH["ends"][ONLY if end and program.open_ended else end or "all"]
    one_by_one = bool(clauses or program.brackets or rewrites.contested.get(program) or not end)
    if not one_by_one:
        yield "best end", f"looked up from {_numbered('state', range(len(program.states)))}"
        return
    if not clauses and not program.outermost.companions:
        yield "walk", f"from all beginnings at once in captures of at most {SHORT} events"
    if any(it.arrow.later or it.entry.state <= it.exit.state for it in chain(*program.edges)):
        yield "horizon", f"{SOON} s, then {WIDER} times as far, until all of the capture"


def _join(companion: Companion, standing: list[int]) -> str:
    if not standing:
        return "cannot be there: a part makes one movement at a time"
    if companion.relation in NEGATIONS:
        kind = "anti-join"
    else:
        kind = "join" if RELATIONS[companion.relation].adds_frames else "semi-join"
    end = enough_beside(companion.programs[0], companion) or "all"
    return f"{kind} with {_numbered('line', standing)}; {_ENGLISH['ends'][end]}"


def _numbered(what: str, numbers: Sequence[int]) -> str:
    return f"{what}{'s'[: len(numbers) != 1]} {', '.join(map(str, numbers))}"
