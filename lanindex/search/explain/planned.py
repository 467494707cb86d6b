"""The plan of a query as text: its states and edges, and what the search leaves out."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from lanindex.search.language.query import Query
from lanindex.search.language.words import WORD_KINDS
from lanindex.search.match.batch import unavoidable
from lanindex.search.match.conditions import Clauses
from lanindex.search.match.leading import SHORT, SOON
from lanindex.search.match.mirror_runs import repeats
from lanindex.search.match.relations import FIRST, LAST, RELATIONS
from lanindex.search.match.rewrites import ONLY, Rewrites, enough, enough_beside, free_states
from lanindex.search.plan import NEGATIONS, Companion, Program, State, plan

_ENDS = {
    FIRST: "the first end from each beginning is enough",
    LAST: "the last end from each beginning is enough",
    ONLY: "runs on: the longest match from each beginning is enough",
    None: "all ends from each beginning are tried",
}


def planned(query: Query) -> str:
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
        rows = dict.fromkeys(_line(line, lines[line], clauses, numbers))
        found += [f"  {row.ljust(9)}  {text}" for row, text in rows]
    return "\n".join(found)


def _add(line: Program, rewrites: Rewrites, lines: dict[Program, Rewrites]) -> None:
    """Add a line and those that can stand beside it, with what may be left out."""
    lines.setdefault(line, rewrites)
    for companion in line.companions:
        for inner in rewrites.programs(companion):
            _add(inner, rewrites, lines)


def _line(
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
        yield from _leading(line, clauses)
    for companion in line.companions:
        standing = [numbers[it] for it in rewrites.programs(companion)]
        yield companion.relation, _join(companion, standing)
    early = [
        numbers[inner]
        for it in line.whole.companions
        if it.relation == "without"
        for inner in rewrites.programs(it)
        if inner not in rewrites.contested
    ]
    if early:
        yield "drop", f"matches as soon as they share a frame with {_numbered('line', early)}"
    if contested := sorted(rewrites.contested.get(line, ())):
        yield "claims", f"another line could want the symbols of {_numbered('state', contested)}"


def _state(state: State) -> str:
    words = []
    for kind, codes in state.fits[0].items():
        names = [name for name, code in WORD_KINDS[kind].codes.items() if code in codes]
        words.append("/".join(names))
    manner = "" if state.manner == "move" else state.manner
    length = str(state.length or "")
    return " ".join(filter(None, ("+".join(state.members), manner, *words, length)))


def _leading(program: Program, clauses: Clauses) -> Iterator[tuple[str, str]]:
    wanted = [_state(state) for state in unavoidable(program)]
    for companion in program.whole.companions:
        if companion.relation not in NEGATIONS and len(companion.programs) == 1:
            wanted += [_state(state) for state in unavoidable(companion.programs[0])]
    if wanted:
        yield "prefilter", f"captures with {', '.join(dict.fromkeys(wanted))}"
    end = enough(program)
    yield "ends", _ENDS[end]
    free = [place for place, is_free in enumerate(free_states(program)) if is_free]
    if end and free and not clauses:
        yield "best end", f"looked up from {_numbered('state', free)}"
    one_by_one = bool(clauses) or not (end and free[:1] == [0])
    goes_far = any(
        it.arrow.later or it.entry.state <= it.exit.state for it in chain(*program.edges)
    )
    if one_by_one and not clauses and not program.whole.companions:
        yield "walk", f"from all beginnings at once in captures of at most {SHORT} events"
    if one_by_one and goes_far:
        yield "horizon", f"{SOON} s, then {SOON} times as far, until all of the capture"


def _join(companion: Companion, standing: list[int]) -> str:
    if not standing:
        return "cannot be there: a part makes one movement at a time"
    if companion.relation in NEGATIONS:
        kind = "anti-join"
    else:
        kind = "join" if RELATIONS[companion.relation].adds_frames else "semi-join"
    end = _ENDS[enough_beside(companion.programs[0], companion)]
    return f"{kind} with {_numbered('line', standing)}; {end}"


def _numbered(what: str, numbers: list[int]) -> str:
    return f"{what}{'s'[: len(numbers) != 1]} {', '.join(map(str, numbers))}"
