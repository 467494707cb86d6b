"""Why a pattern matches in a capture or not: its steps, or where the furthest beginning ends."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from math import inf
from typing import Any

import numpy as np

from lanindex.alphabet import PLACE
from lanindex.errors import LanindexError
from lanindex.model import Capture, Hit, Symbol, Track
from lanindex.model.columns import GRADES, graded, stored
from lanindex.records import of_matched, of_name
from lanindex.search.explain.advice import nearest_limit
from lanindex.search.language import query as tree
from lanindex.search.language.times import TOLERANCE, Clock, Length
from lanindex.search.language.words import AMOUNTS, BESIDE_CELLS, RESTS, WORD_KINDS
from lanindex.search.match import find_in
from lanindex.search.plan import fits

Symbols = tuple[Symbol, ...]
_Near = tuple[Symbols, Symbol | None, str]
"""What was reached, what came nearest to what should have followed, and all that in a sentence."""


@dataclass(frozen=True, slots=True)
class Matched:
    """A step of a pattern, and the symbols that matched it."""

    step: str  # as written, with what goes before: ``-> high``, ``with l_arm``
    symbols: Symbols  # several of a pair, a stay or a repetition; none where it was left out


@dataclass(frozen=True, slots=True)
class Stop:
    """How far one alternative of a query came in a capture."""

    reached: str  # the longest beginning of it that is found; empty: none
    symbols: Symbols  # what matched that
    wanted: str  # what should have come then, as written
    instead: Symbol | None  # what came nearest to it
    reason: str  # all that in a sentence


@dataclass(frozen=True, slots=True)
class Trace:
    """What a query finds in one capture, step by step, or how far it comes.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     seen = library.why("torso forward high", "greetings.bvh")
    >>> for hit, steps in seen.hits:
    ...     print(hit.span, *steps[0].symbols)
    Span(start=482, stop=524) torso forward high [482, 524)
    >>> seen.dicts()[0]["start_frame"], seen.dicts()[0]["end_frame"]
    (482, 524)
    """

    query: tree.Query
    capture: Capture
    hits: tuple[tuple[Hit, tuple[Matched, ...]], ...] = ()  # each with its steps
    stops: tuple[Stop, ...] = ()  # where nothing was found: how far each alternative came
    refused: LanindexError | None = None  # set if the capture is too rich for the query

    @property
    def obstacle(self) -> str:
        """Why nothing is found, one reason for each alternative."""
        if self.refused:
            return self.refused.found
        return "; or ".join(stop.reason for stop in self.stops) or "nothing: it is found"

    def dicts(self) -> list[dict[str, Any]]:
        """Return the hits, or the end of each alternative, as ``search --why --json`` prints them.

        Of a capture that is too rich for the query there is one, with the reason.
        """
        return list(records_of(self))


def trace(
    query: tree.Query,
    capture: Capture,
    tracks: Mapping[str, Track],
    *,
    tolerance: Fraction = TOLERANCE,
    overlaps: str = "none",
) -> Trace:
    """Return the hits of a query in a capture, or how far each of its alternatives came.

    `tolerance` and `overlaps` are those of `lanindex.search.match.finder.Finder`.
    """
    plain = replace(query, stages=())
    labelled, steps = _labelled(plain)
    alternatives = [it for pattern in plain.patterns for it in pattern.alternatives]
    try:
        found = find_in([(capture, tracks)], labelled, tolerance=tolerance, overlaps=overlaps)
        hits = tuple(
            (hit, tuple(Matched(steps[it], hit.labels[it]) for it in steps if it in hit.labels))
            for hit in found
        )
        stop_of = _StopFinder(plain, capture, tracks, tolerance).stop_of
        return Trace(query, capture, hits, () if hits else tuple(map(stop_of, alternatives)))
    except LanindexError as error:
        return Trace(query, capture, refused=error)


def records_of(trace: Trace) -> Iterator[dict[str, Any]]:
    """Yield a line of ``search --why --json`` for each hit, or for each alternative's end."""

    def step(text: str, symbols: Symbols) -> dict[str, Any]:
        return {"step": text, "symbols": list(map(of_matched, symbols))}

    common: dict[str, Any] = {
        **of_name(trace.capture),
        "pattern": str(trace.query),
        "found": bool(trace.hits),
        **dict.fromkeys(("start_frame", "end_frame", "fit")),
        "steps": [],
        **dict.fromkeys(("wanted", "instead", "reason")),
    }
    for hit, steps in trace.hits:
        span = {"start_frame": hit.start, "end_frame": hit.stop, "fit": round(hit.fit, 3)}
        yield {**common, **span, "steps": [step(it.step, it.symbols) for it in steps]}
    for stop in trace.stops:
        yield {
            **common,
            "steps": [step(stop.reached, stop.symbols)] if stop.reached else [],
            "wanted": stop.wanted,
            "instead": of_matched(stop.instead) if stop.instead else None,
            "reason": stop.reason,
        }
    if trace.refused:
        yield {**common, "reason": trace.refused.found}


def _labelled(query: tree.Query) -> tuple[tree.Query, dict[str, str]]:
    """Return a query with a label on every step, and by label what the step says."""
    labels: list[str] = []

    def labelled(node: Any) -> Any:
        if not isinstance(node, tree.Item) or isinstance(node.unit, tree.Bracket):
            return node
        labels.append(node.label or f"step {len(labels) + 1}")
        return replace(node, label=labels[-1])

    labelled_query: tree.Query = tree.changed_nodes(query, labelled)
    return labelled_query, dict(zip(labels, _step_texts(query.pattern, ""), strict=True))


def _step_texts(pattern: tree.Choice, before: str) -> Iterator[str]:
    """Yield the steps of a pattern, each with what goes before it."""
    for lines in pattern.alternatives:
        others = ((it.relation, it.line) for it in lines.others)
        for first, line in [(before, lines.first), *others]:
            for arrow, item in zip((first, *map(str, line.arrows)), line.items, strict=True):
                if isinstance(item.unit, tree.Bracket):
                    yield from _step_texts(item.unit.pattern, arrow)
                else:
                    yield f"{arrow} {item}".strip()


class _StopFinder:
    """Finds where a query stops in one capture, by ever longer beginnings of it."""

    def __init__(
        self, query: tree.Query, capture: Capture, tracks: Mapping[str, Track], tolerance: Fraction
    ) -> None:
        self.query, self.capture, self.tolerance = query, capture, tolerance
        self.recordings = [(capture, tracks)]
        self.clock = Clock(capture.rate, capture.meter.speed / 60)
        self.rows = {
            part: [symbol for symbol in track.listed() if not symbol.passing]
            for part, track in tracks.items()
        }

    def hits(self, query: tree.Query) -> list[Hit]:
        return list(find_in(self.recordings, query, tolerance=self.tolerance, overlaps="all"))

    def stop_of(self, lines: tree.Lines) -> Stop:
        """Return how far one alternative comes that is not found."""
        flat = tree.Lines(_flat(lines.first), lines.others)
        begun: tree.Lines | None = None
        hits: list[Hit] = []
        reached: list[Symbols] = []
        for tried in _beginnings(flat):
            before, hits = hits, self.hits(tree.query_of(tried))
            resting = [] if begun else self.starting_positions(flat.first)
            if not hits and not resting:
                return self.between(begun, tried, before, reached)
            begun, reached = tried, [*resting, *(hit.lines[0] for hit in hits)]
        # all is there but what is said of the whole pattern
        whole = replace(self.query, either_side=False)
        wanted = str(whole).removeprefix(str(whole.pattern)).strip()
        reason = f"{_listed(hits[0].lines[0])}, but not {wanted}"
        return Stop(str(lines), hits[0].symbols, wanted, None, reason)

    def between(
        self, begun: tree.Lines | None, tried: tree.Lines, hits: list[Hit], reached: list[Symbols]
    ) -> Stop:
        """Return the stop between a beginning, with its hits, and what has one condition more."""
        first = tried.first.items[0]
        wanted = str(tried).removeprefix(str(begun)).strip() if begun else str(first)
        near: Symbol | None = None
        if tried.others:
            symbols, near, reason = self.not_beside(tried.others[-1], hits)
        elif tried.first.end:
            symbols = reached[-1]
            near = next(iter(self.after(symbols[-1].part, symbols)), None)
            reason = f"after {_ends_text(symbols)} the clip does not end"
            reason += f": the next movement is {_movement_text(near)}" if near else ""
        elif reason := self.wrong_count(tried.first):
            symbols = reached[0] if reached else ()
        elif begun:
            symbols, near, reason = self.no_next_step(tried.first, reached)
        elif isinstance(first.unit, tree.Bracket):
            return self.stop_of(first.unit.pattern.alternatives[0])
        else:
            symbols, near, reason = self.no_first_step(tried.first)
        return Stop(str(begun or ""), symbols, wanted, near, reason)

    def starting_positions(self, line: tree.Line) -> list[Symbols]:
        """Return the starting positions with which a line can begin; alone they are no hit."""
        first = line.items[0]
        step = _first(first)
        if len(line.items) == 1 or line.start or not tree.may_begin(first):
            return []
        rows = [rows[0] for part in step.mover.members if (rows := self.rows.get(part))]
        fitting = tuple(it for it in rows if it.start == it.stop and not away(it, step))
        if step.mover.form == "both":
            return [fitting] if len(fitting) == 2 else []
        return [(it,) for it in fitting]

    def no_next_step(self, line: tree.Line, reached: list[Symbols]) -> _Near:
        """Return what came nearest to the last step of a line."""
        arrow, item = line.arrows[-1], line.items[-1]
        step = _first(item)
        worst = max if step.mover.form == "both" else min  # of two together both must fit
        tries = []
        for symbols in reached:
            nears = []
            for part in _going_on(step, symbols):
                later = self.after(part, symbols)
                nears.append((symbols, part, nearest(later if arrow.later else later[:1], step)))
            tries.append(worst(nears, key=lambda it: away(it[-1], step)))
        symbols, part, near = min(tries, key=lambda it: away(it[-1], step))
        end, last = max(it.stop for it in symbols), symbols[-1]
        subject = str(near) if near is None or part != last.part else _movement_text(near)
        if step.manner in RESTS:
            rest = (near.start if near else self.capture.frames) - last.stop
            rests = f"rests for {self.seconds(rest)}" if rest > 0 else "goes on at once"
            reason = f'{part} {rests}, wanted "{item}"'
        elif near is None:
            reason = f"{part} does not move again"
        elif away(near, step):
            which = "the nearest movement" if arrow.later else "the next movement"
            reason = f"{which} is {subject}, {_unwanted_text(step)} ({doubts(near)})"
        elif self.frames_off(near.start - end, arrow.length):
            gap = self.seconds(near.start - end)
            reason = f"{subject} comes after {gap}, wanted [{arrow.length}]"
        else:
            unlike = f'{subject} comes, but not "{arrow} {item}"'
            reason = self.wrong_length(item, subject, near) or unlike
        return symbols, near, f"after {_ends_text(symbols)} {reason}"

    def wrong_count(self, line: tree.Line) -> str:
        """Return by how much the last step misses its count or its whole length, if it does."""
        *before, item = line.items

        def hits(**limit: Any) -> list[Hit]:
            last = replace(item, **limit)
            return self.hits(tree.query_of(replace(line, items=(*before, last))))

        counted, whole = item.repeat.least > 1, isinstance(item.unit, tree.Bracket) and not before
        if counted and (near := nearest_limit(item.repeat, lambda it: bool(hits(repeat=it)))):
            return f'"{replace(item, repeat=tree.ONCE)}" is there {near[1]} in a row at most'
        if whole and item.length and (others := hits(length=None)):
            lengths = [len(hit.span) for hit in others]
            best = min(lengths, key=lambda it: self.frames_off(it, item.length))
            without = replace(item, length=None)
            return f'"{without}" takes {self.seconds(best)}, wanted {item.length}'
        return ""

    def no_first_step(self, line: tree.Line) -> _Near:
        """Return what came nearest to the very first step."""
        (item,) = line.items
        step = _first(item)
        moving = self.movements(step.mover.members)
        near = nearest(moving, step)
        if not any(part in self.rows for part in step.mover.members):
            reason = f"this capture does not tell where the {step.mover} is"
        elif near is None:
            reason = f"{step.mover} does not move"
        elif away(near, step):
            reason = f"no movement of {step.mover} is {_words(step)}; "
            reason += f"the nearest is {near} ({doubts(near)})"
        elif line.start and moving[0] is not near:
            reason = f"the first movement is {moving[0]}, {_unwanted_text(step)}"
        else:
            fitting = [it for it in moving if not away(it, step)]
            near = min(fitting, key=lambda it: self.frames_off(it.stop - it.start, item.length))
            reason = self.wrong_length(item, str(near), near) or f'there is no "{item}"'
        return (), near, reason

    def wrong_length(self, item: tree.Item, subject: str, symbol: Symbol) -> str:
        """Return how long a movement takes, if that is not as wanted."""
        frames = symbol.stop - symbol.start
        moves = isinstance(item.unit, tree.Step) and item.unit.manner in ("move", "via")
        if moves and self.frames_off(frames, item.length):
            return f"{subject} takes {self.seconds(frames)}, wanted {item.length}"
        return ""

    def not_beside(self, beside: tree.Beside, hits: list[Hit]) -> _Near:
        """Return what came nearest to a line that should lie beside the others."""
        hit, near, step = hits[0], None, _first(beside.line.items[0])
        there = f"{step.mover} does not move"
        others = self.hits(tree.query_of(beside.line))
        if others:
            hit, other = min(product(hits, others), key=lambda both: _frames_between(*both))
            near, gap = other.lines[0][0], _frames_between(hit, other)
            there = f'"{beside.line}" is at [{other.start}, {other.stop})'
            there += f", {self.seconds(gap)} away" if gap > 0 else ""
        else:
            span, moving = hit.span, self.movements(step.mover.members, step.manner != "move")
            meanwhile = [it for it in moving if it.start < span.stop and span.start < it.stop]
            near = nearest(meanwhile or moving, step)
            when = "meanwhile" if meanwhile else "at another time"
            if near and away(near, step):
                there = f"{when} {near}, {_unwanted_text(step)} ({doubts(near)})"
            elif near:  # the first step of the line is there
                there = self.stop_of(tree.Lines(beside.line)).reason
        return hit.symbols, near, f"{_listed(hit.lines[0])}, but {there}"

    def movements(self, parts: tuple[str, ...], also_resting: bool = False) -> list[Symbol]:
        """Return the movements of some parts, of each in turn."""
        rows = [it for part in parts for it in self.rows.get(part, ())]
        return [it for it in rows if it.start < it.stop or also_resting]

    def after(self, part: str, symbols: Symbols) -> list[Symbol]:
        """Return the movements of a part behind some symbols."""
        own = [it.ordinal for it in symbols if it.part == part]
        end = max(it.stop for it in symbols)
        rows = self.movements((part,))
        return [it for it in rows if (it.ordinal > own[-1] if own else it.start >= end)]

    def frames_off(self, frames: int, length: Length | None) -> int:
        """Return by how many frames a length is missed."""
        if length is None:
            return 0
        least, most = length.bounds(self.clock)
        return max(least - frames, frames - most if most is not None else 0, 0)

    def seconds(self, frames: int) -> str:
        return f"{float(frames / self.capture.rate):.2f} s"


def _beginnings(lines: tree.Lines) -> Iterator[tree.Lines]:
    """Yield the first step, then one step more each time, then the end, then one line more."""
    line = lines.first
    for count in range(1, len(line.items) + 1):
        yield tree.Lines(tree.Line(line.items[:count], line.arrows[: count - 1], line.start))
    if line.end:
        yield tree.Lines(line)
    for count in range(len(lines.others)):
        yield tree.Lines(line, lines.others[: count + 1])


def _first(item: tree.Item) -> tree.Step:
    return next(tree.nodes_in(item, tree.Step))


def _frames_between(hit: Hit, other: Hit) -> int:
    """Return how many frames lie between two hits; below 0 where they share some."""
    return max(hit.start - other.stop, other.start - hit.stop)


def _going_on(step: tree.Step, symbols: Symbols) -> tuple[str, ...]:
    """Return the parts that may go on with a step: of either one the side that has begun."""
    side = symbols[-1].part[:2]
    same = tuple(part for part in step.mover.members if part[:2] == side)
    return same if same and step.mover.form == "either" else step.mover.members


def _flat(line: tree.Line) -> tree.Line:
    """Return a line without brackets that only hold a line, which says the same."""
    items: list[tree.Item] = []
    arrows: list[tree.Arrow] = []
    for arrow, item in zip((tree.NEXT, *line.arrows), line.items, strict=True):
        inner = tree.Line((item,))
        match item.unit:
            case tree.Bracket(
                tree.Choice((tree.Lines(tree.Line(start=None, end=None) as only, ()),))
            ):
                inner = _flat(only) if item == tree.Item(item.unit) else inner
        items += inner.items
        arrows += (arrow, *inner.arrows)
    return replace(line, items=tuple(items), arrows=tuple(arrows[1:]))


def _listed(symbols: Symbols) -> str:
    return ", ".join(map(str, symbols))


def _ends_text(symbols: Symbols) -> str:
    """Return where each part came to, in words."""
    return _listed(tuple({it.part: it for it in symbols}.values()))


def _movement_text(symbol: Symbol) -> str:
    return f"{symbol.words} [{symbol.start}, {symbol.stop})"


def _words(step: tree.Step) -> str:
    return " ".join(map(str, step.words)) or "anywhere"


def _unwanted_text(step: tree.Step) -> str:
    denies = any(word.negated for word in step.words)
    return f'wanted "{_words(step)}"' if denies else f"not {_words(step)}"


# The nearest symbol.

_RUNNER_UP = 0.5  # how far a symbol at its border is from the next cell, in cells
_FAR = 9.0  # how far what has no direction or no level is from what has one


def away(symbol: Symbol | None, step: tree.Step) -> float:
    """Return how far a symbol is from what a step says: 0 where it fits, infinity of none.

    Less than 1 where its runner-up fits, the less the nearer it is to that border; else how many
    levels and directions lie between, and how many of its other words do not fit. Changes of level
    are not looked at.
    """
    if symbol is None:
        return inf
    wanted = fits(step, symbol.part)
    wrong = sum(_code(symbol, it) not in wanted[it] for it in wanted if it in BESIDE_CELLS)
    cell = _cells_apart((symbol.direction, symbol.level), wanted)
    if cell and symbol.runner_up and not _cells_apart(symbol.runner_up, wanted):
        cell = _RUNNER_UP * (0.01 + symbol.margin)
    return cell + wrong


def nearest(symbols: Iterable[Symbol], step: tree.Step) -> Symbol | None:
    """Return the symbol that comes nearest to a step, of equals the first; None of none."""
    return min(symbols, key=lambda symbol: away(symbol, step), default=None)


def doubts(symbol: Symbol) -> str:
    """Return how clearly a symbol is what it is: ``margin 0.12, else forward high``."""
    other = f", else {' '.join(symbol.runner_up)}" if symbol.runner_up else ""
    return f"margin {symbol.margin:.2f}{other}"


def _cells_apart(cell: tuple[str | None, ...], wanted: Mapping[str, frozenset[int]]) -> float:
    """Return how many directions and levels lie between a cell and those that are wanted."""
    total = 0.0
    for kind, value in zip(("direction", "level"), cell, strict=True):
        if kind in wanted:
            code = WORD_KINDS[kind].codes.get(value or "")
            total += _FAR if code is None else min(_apart(kind, code, it) for it in wanted[kind])
    return total


def _apart(kind: str, one: int, other: int) -> int:
    """Return how many directions or levels lie between two; upright is next to all directions."""
    if kind == "level" or one == other:
        return abs(one - other)
    return 1 if PLACE in (one, other) else min((one - other) % 8, (other - one) % 8)


def _code(symbol: Symbol, kind: str) -> int:
    """Return the code of a symbol's amount, speed or size; -1: it has none."""
    if kind in AMOUNTS:
        return -1 if symbol.amount is None else symbol.amount
    measure = getattr(symbol, GRADES[kind])
    if measure is None:
        return -1
    return int(graded(symbol.part, kind, stored(GRADES[kind], np.array([measure])))[0])
