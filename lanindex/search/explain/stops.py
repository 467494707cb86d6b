"""Where a walk through a capture ends: the furthest beginning, and what came there instead."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf

from lanindex.model import Capture, Hit, Symbol, Track
from lanindex.search.explain.nearness import away, doubts, nearest
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
    Step,
)
from lanindex.search.language.times import Clock, Length
from lanindex.search.match import find_in


@dataclass(frozen=True, slots=True)
class Stop:
    """How far one alternative of a query came in a capture.

    Attributes
    ----------
    reached : str
        The longest beginning of it that is found; empty: none.
    symbols : tuple of Symbol
        What matched that.
    wanted : str
        What should have come then, as written.
    instead : Symbol or None
        What came nearest to it.
    reason : str
        All that in a sentence.
    """

    reached: str
    symbols: tuple[Symbol, ...]
    wanted: str
    instead: Symbol | None
    reason: str


def stops(
    query: Query, capture: Capture, tracks: Mapping[str, Track], tolerance: Fraction
) -> Iterator[Stop]:
    """Yield for each alternative of a query that finds nothing how far it comes."""
    walk = _Walk(query, capture, tracks, tolerance)
    for pattern in query.patterns:
        for lines in pattern.alternatives:
            yield walk.stop(lines)


_MOST_REPEATED = 30
"""Up to how many repetitions are counted."""

Reached = tuple[Symbol, ...]
"""What matched a beginning of a line."""


class _Walk:
    """Looks for ever longer beginnings in one capture."""

    def __init__(
        self, query: Query, capture: Capture, tracks: Mapping[str, Track], tolerance: Fraction
    ) -> None:
        self.query, self.capture, self.tracks = query, capture, tracks
        self.tolerance = tolerance
        self.clock = Clock(capture.rate, capture.meter.speed / 60)
        self.rows = {
            part: [symbol for symbol in track.listed() if not symbol.passing]
            for part, track in tracks.items()
        }

    def hits(self, lines: Lines) -> list[Hit]:
        here = [(self.capture, self.tracks)]
        query = Query(Choice((lines,)))
        return list(find_in(here, query, tolerance=self.tolerance, overlaps="all"))

    def stop(self, lines: Lines) -> Stop:
        line = _flat(lines.first)
        reached: list[Reached] = []
        hits: list[Hit] = []
        for count in range(1, len(line.items) + 1):
            hits = self.hits(Lines(_beginning(line, count)))
            resting = self.resting(line) if count == 1 and len(line.items) > 1 else []
            if not hits and not resting:
                return self.missing(line, count - 1, reached)
            reached = [*resting, *(hit.lines[0] for hit in hits)]
        if line.end and not (hits := self.hits(Lines(line))):
            return self.going_on(line, reached)
        for count, beside in enumerate(lines.others, 1):
            before, hits = hits, self.hits(Lines(line, lines.others[:count]))
            if not hits:
                return self.unaccompanied(Lines(line, lines.others[: count - 1]), beside, before)
        return self.unlike(lines, hits)

    def resting(self, line: Line) -> list[Reached]:
        """Return the starting positions with which a line can begin; alone they are no hit."""
        step = _first(line.items[0])
        firsts = [rows[0] for part in step.mover.members if (rows := self.rows.get(part))]
        fitting = [it for it in firsts if it.start == it.stop and not away(it, step)]
        if step.manner != "move" or line.start or line.items[0].length:
            return []
        if step.mover.form == "both":
            return [tuple(fitting)] if len(fitting) == 2 else []
        return [(it,) for it in fitting]

    # What came instead of the next step.

    def missing(self, line: Line, count: int, reached: list[Reached]) -> Stop:
        """Return the stop at a step that does not follow, or does not begin."""
        item = line.items[count]
        if reason := self.measured(line, count):
            begun = str(_beginning(line, count)) if count else ""
            wanted = f"{line.arrows[count - 1]} {item}" if count else str(item)
            return Stop(begun, reached[0] if reached else (), wanted, None, reason)
        if not count and isinstance(item.unit, Bracket):
            return self.stop(item.unit.pattern.alternatives[0])
        if not count:
            return self.nowhere(line, item)
        arrow, step = line.arrows[count - 1], _first(item)
        worst = max if step.mover.form == "both" else min  # of two together both must fit
        ways = []
        for symbols in reached:
            nearest_of = [
                (away(near, step) if near else inf, part, near)
                for part in _partners(step, symbols)
                for later in [self.after(part, symbols)]
                for near in [nearest(later if arrow.later else later[:1], step)]
            ]
            ways.append((symbols, *worst(nearest_of, key=lambda it: it[0])))
        symbols, _, part, near = min(ways, key=lambda it: it[1])
        reason = f"after {_last(symbols)} {self.instead(arrow, item, symbols, part, near)}"
        return Stop(str(_beginning(line, count)), symbols, f"{arrow} {item}", near, reason)

    def instead(
        self, arrow: Arrow, item: Item, symbols: Reached, part: str, near: Symbol | None
    ) -> str:
        """Return what follows, and why it is not what was wanted."""
        step, last = _first(item), symbols[-1]
        if step.manner == "hold":
            until = near.start if near else self.capture.frames
            rests = f"rests for {self.seconds(until - last.stop)}"
            return f'{part} {rests if until > last.stop else "goes on at once"}, wanted "{item}"'
        if near is None:
            return f"{part} does not move again"
        said = f"{near.words} [{near.start}, {near.stop})" if part == last.part else str(near)
        if away(near, step):
            which = "the nearest movement" if arrow.later else "the next movement"
            return f"{which} is {said}, {_not(step)} ({doubts(near)})"
        gap = near.start - max(symbol.stop for symbol in symbols)
        if arrow.length and not self.meets(gap, arrow.length):
            return f"{said} comes after {self.seconds(gap)}, wanted [{arrow.length}]"
        return self.unlasting(item, said, near) or f'{said} comes, but not "{arrow} {item}"'

    def measured(self, line: Line, count: int) -> str:
        """Return by how much the count or the whole length of a step is missed, if it is that."""
        item = line.items[count]

        def hits(other: Item) -> list[Hit]:
            items = (*line.items[:count], other)
            return self.hits(Lines(Line(items, line.arrows[:count], line.start)))

        for most in reversed(range(1, min(item.repeat.least, _MOST_REPEATED))):
            if hits(replace(item, repeat=Repeat(most, None))):
                return f'"{replace(item, repeat=ONCE)}" is there {most} in a row at most'
        if isinstance(item.unit, Bracket) and item.length and not count:
            found = hits(replace(item, length=None))
            frames = [hit.span.stop - hit.span.start for hit in found]
            if frames:
                best = self.seconds(min(frames, key=lambda it: self.off(it, item.length)))
                return f'"{replace(item, length=None)}" takes {best}, wanted {item.length}'
        return ""

    def nowhere(self, line: Line, item: Item) -> Stop:
        """Return the stop at the very first step."""
        step = _first(item)
        tracked = [self.rows[part] for part in step.mover.members if part in self.rows]
        moving = [it for rows in tracked for it in rows if it.start < it.stop]
        near = nearest(moving, step)
        if not tracked:
            reason = f"this capture does not tell where the {step.mover} is"
        elif near is None:
            reason = f"{step.mover} does not move"
        elif away(near, step):
            reason = f"no movement of {step.mover} is {_said(step)}; "
            reason += f"the nearest is {near} ({doubts(near)})"
        elif line.start and moving[0] is not near:
            reason = f"the first movement is {moving[0]}, {_not(step)}"
        else:
            fitting = [it for it in moving if not away(it, step)]
            near = min(fitting, key=lambda it: self.off(it.stop - it.start, item.length))
            reason = self.unlasting(item, str(near), near) or f'there is no "{item}"'
        return Stop("", (), str(item), near, reason)

    def unlasting(self, item: Item, said: str, symbol: Symbol) -> str:
        """Return how long a movement takes, if that is not as wanted."""
        frames = symbol.stop - symbol.start
        if isinstance(item.unit, Bracket) or item.unit.manner not in ("move", "via"):
            return ""
        if item.length is None or self.meets(frames, item.length):
            return ""
        return f"{said} takes {self.seconds(frames)}, wanted {item.length}"

    def going_on(self, line: Line, reached: list[Reached]) -> Stop:
        """Return the stop before the end of the clip."""
        symbols = reached[-1]
        later = self.after(symbols[-1].part, symbols)
        reason = f"after {_last(symbols)} the clip does not end"
        if later:
            reason += f": the next movement is {later[0].words} [{later[0].start}, {later[0].stop})"
        begun = str(replace(line, end=None))
        return Stop(begun, symbols, f"{line.end} end", later[0] if later else None, reason)

    # What is not beside.

    def unaccompanied(self, lines: Lines, beside: Beside, hits: list[Hit]) -> Stop:
        """Return the stop at a line that does not lie beside the others as it should."""
        others = self.hits(Lines(beside.line))
        pairs = [(_between(hit, other), hit, other) for hit in hits for other in others]
        if pairs:
            gap, hit, other = min(pairs, key=lambda it: it[0])
            there = f'"{beside.line}" is at [{other.span.start}, {other.span.stop})'
            far = f", {self.seconds(gap)} away" if gap > 0 else ""
            reason = f"{_at(hit)}, but {there}{far}"
            return self._beside(lines, beside, hit, other.lines[0][0], reason)
        step, hit = _first(beside.line.items[0]), hits[0]
        rows = [it for part in step.mover.members for it in self.rows.get(part, [])]
        moving = [it for it in rows if it.start < it.stop or step.manner != "move"]
        meanwhile = [it for it in moving if it.start < hit.span.stop and hit.span.start < it.stop]
        near = nearest(meanwhile or moving, step)
        if near is None:
            reason = f"{_at(hit)}, but {step.mover} does not move"
            return self._beside(lines, beside, hit, None, reason)
        when = "meanwhile" if meanwhile else "at another time"
        reason = f"{_at(hit)}, but {when} {near}, {_not(step)} ({doubts(near)})"
        return self._beside(lines, beside, hit, near, reason)

    def _beside(
        self, lines: Lines, beside: Beside, hit: Hit, near: Symbol | None, reason: str
    ) -> Stop:
        return Stop(str(lines), hit.symbols, str(beside), near, reason)

    def unlike(self, lines: Lines, hits: list[Hit]) -> Stop:
        """Return the stop at what is said of the whole pattern."""
        alone = replace(self.query, either_side=False, stages=())
        wanted = str(alone).removeprefix(str(self.query.pattern)).strip()
        return Stop(str(lines), hits[0].symbols, wanted, None, f"{_at(hits[0])}, but not {wanted}")

    # Symbols and times.

    def after(self, part: str, symbols: Reached) -> list[Symbol]:
        """Return the movements of a part behind some symbols."""
        rows = [it for it in self.rows.get(part, []) if it.start < it.stop]
        own = [it.ordinal for it in symbols if it.part == part]
        if own:
            return [it for it in rows if it.ordinal > own[-1]]
        end = max(it.stop for it in symbols)
        return [it for it in rows if it.start >= end]

    def meets(self, frames: int, length: Length) -> bool:
        return not self.off(frames, length)

    def off(self, frames: int, length: Length | None) -> int:
        """Return by how many frames a length is missed."""
        if length is None:
            return 0
        least, most = length.bounds(self.clock)
        return max(least - frames, frames - most if most is not None else 0, 0)

    def seconds(self, frames: int) -> str:
        return f"{float(frames / self.capture.rate):.2f} s"


def _beginning(line: Line, count: int) -> Line:
    return Line(line.items[:count], line.arrows[: count - 1], line.start)


def _first(item: Item) -> Step:
    """Return the first step of an item."""
    unit = item.unit
    while isinstance(unit, Bracket):
        unit = unit.pattern.alternatives[0].first.items[0].unit
    return unit


def _partners(step: Step, symbols: Reached) -> tuple[str, ...]:
    """Return the parts that may go on: of either one the side that has begun."""
    side = symbols[-1].part[:2]
    same = tuple(part for part in step.mover.members if part[:2] == side)
    return same if same and step.mover.form == "either" else step.mover.members


def _between(hit: Hit, other: Hit) -> int:
    """Return how many frames lie between two hits; below 0 where they share some."""
    return max(hit.span.start - other.span.stop, other.span.start - hit.span.stop)


def _at(hit: Hit) -> str:
    return ", ".join(map(str, hit.lines[0]))


def _last(symbols: Reached) -> str:
    """Return where each part came to, in words."""
    return ", ".join(str(it) for it in {it.part: it for it in symbols}.values())


def _flat(line: Line) -> Line:
    """Return a line without brackets that only hold a line, which says the same."""
    items: list[Item] = []
    arrows: list[Arrow] = []
    for before, item in zip((None, *line.arrows), line.items, strict=True):
        inner = Line((item,))
        if isinstance(item.unit, Bracket) and item == Item(item.unit):
            alternatives = item.unit.pattern.alternatives
            plain = len(alternatives) == 1 and not alternatives[0].others
            within = _flat(alternatives[0].first) if plain else inner
            inner = within if not (within.start or within.end) else inner
        items += inner.items
        arrows += [*([before] if before else []), *inner.arrows]
    return Line(tuple(items), tuple(arrows), line.start, line.end)


def _said(step: Step) -> str:
    return " ".join(map(str, step.words)) or "anywhere"


def _not(step: Step) -> str:
    denies = any(word.negated for word in step.words)
    return f'wanted "{_said(step)}"' if denies else f"not {_said(step)}"
